# Copyright 2026 The heading_intercompare authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""Journals for tests, written as a compliance node writes them."""

from __future__ import annotations

from contextlib import suppress
import json

import numpy as np

from heading_intercompare.core.pairing.incarnations import Incarnations
from heading_intercompare.core.pairing.ledger import Ledger, LedgerKey
from heading_intercompare.core.pipeline import Compliance
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.sensors.pair_names import TWO
from heading_intercompare.core.settings import Settings
from heading_intercompare.journal import journal_file
from heading_intercompare.journal.journal_file import Record
from heading_intercompare.journal.run_journal import RunJournal
from heading_intercompare.messages.ledger_messages import LedgerMessage

S = 1_000_000_000
T0 = 20_000 * 86400 * S
NORMS = {'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1, 'risk.min_duration_s': 0.0}


def some_pairs(n, sigma_deg=0.1, gap_at=None, seed=5):
    """Return a pair a second; ten minutes of silence after `gap_at` pairs."""
    rng = np.random.default_rng(seed)
    stamp = T0 + np.arange(n) * S
    if gap_at is not None:
        stamp[gap_at:] += 600 * S
    return Pairs.of(stamp, 90.0 + rng.normal(0.0, sigma_deg, n), np.full(n, 90.0))


def ledger_of(pairs, n, cut_ns, final=False):
    """Return the ledger of a synchronizer that made the first `n` pairs and was told to cut."""
    ledger = Ledger()
    ledger.receive('ts', pairs.stamp_ns[:n])
    ledger.receive('rs', pairs.stamp_ns[:n])
    for key in (LedgerKey.PAIRED, LedgerKey.TS_PAIRED, LedgerKey.RS_USED):
        ledger.add(key, pairs.stamp_ns[:n])
    for stamp_ns in cut_ns:
        ledger.cut_run(stamp_ns)
    return LedgerMessage(Ledger.from_segments(ledger.segments, ledger.newest_ns), final, 1000, {})


def plain(verdict):
    """Return a verdict as its JSON, without what names its input."""
    found = json.loads(json.dumps(verdict.to_dict()))
    for key in ('inputs', 'ledger_problems', 'ledger_complete'):
        del found[key]
    for run in found['runs']:
        del run['source']
    return found


def write_journal(path, pairs, marks=(), bag='trial_1', booked=True, **settings):
    """
    Write the journal of a node that took pairs, and return what it would have judged at its end.

    `marks` are kinds by the number of pairs before them.
    """
    rule = Settings.from_mapping({**NORMS, **settings})
    node = Compliance(rule, source='live')
    with suppress(FileNotFoundError):
        path.unlink()
    journal = RunJournal(path, rule, {TWO: node}, within_s=3600.0, now_ns=T0, bag=bag)
    now_s, cuts = 0.0, []
    for lo in range(0, len(pairs), 100):
        chunk = pairs[lo:lo + 100]
        journal.add(chunk, {'1000': (1, lo + len(chunk), 0, 0)})
        node.update(chunk)
        for kind in [kind for at, kind in marks if at == lo + len(chunk)]:
            journal.mark(kind, int(chunk.stamp_ns[-1]))
            node.mark(kind, int(chunk.stamp_ns[-1]))
            cuts.append(int(chunk.stamp_ns[-1]) + 1)
        if booked:
            journal.book(ledger_of(pairs, lo + len(chunk), cuts, lo + 100 >= len(pairs)))
        now_s += 0.3
        journal.tick(now_s)
        node.results()
    ledgers = Incarnations()
    for message in journal.kept.ledgers.values():
        ledgers.take(*message)
    journal.close(over=False)
    node.finish()
    return node.verdict(ledgers.total)


def last_record_at(path):
    """Return at which byte the last record of a journal begins."""
    data, at, last = path.read_bytes(), len(journal_file._MAGIC), 0
    while at < len(data):
        last, size = at, journal_file._HEAD.unpack_from(data, at)[0]
        at += journal_file._HEAD.size + size
    return last


def write_records(path, *records):
    """Write a journal of any records, (kind, bytes)."""
    path.write_bytes(journal_file._MAGIC + b''.join(
        journal_file._pack(Record(*one)) for one in records))
