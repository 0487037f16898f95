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

"""A judgement goes on from its journal as if nothing had happened."""

from __future__ import annotations

import json
import os
import time

from journals import ledger_of
import numpy as np
import pytest

from heading_intercompare.core.motion.motion_record import leave_out_known
from heading_intercompare.core.pairing.incarnations import StreamNumbers
from heading_intercompare.core.pairing.ledger import Ledger, LedgerSegment
from heading_intercompare.core.pipeline import Compliance
from heading_intercompare.core.raw_streams.stamp_jumps import SetBack
from heading_intercompare.core.records import Motion, Pairs, Quality
from heading_intercompare.core.sensors.pair_names import TWO
from heading_intercompare.core.settings import Settings
from heading_intercompare.journal import journal_file
from heading_intercompare.journal.journal_file import read_journal
from heading_intercompare.journal.run_journal import find_bag, RunJournal
from heading_intercompare.messages.ledger_messages import LedgerMessage

S = 1_000_000_000
T0 = 20_000 * 86400 * S
NORMS = {'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1, 'risk.min_duration_s': 0.0}
NOW = T0


def settings(**more):
    return Settings.from_mapping({**NORMS, **{k.replace('__', '.'): v for k, v in more.items()}})


def some_pairs(rng, n, gap_at=None):
    """Return a pair a second; after `gap_at` pairs, ten minutes of silence."""
    stamp = T0 + np.arange(n) * S
    if gap_at is not None:
        stamp[gap_at:] += 600 * S
    return Pairs.of(stamp, 90.0 + rng.normal(0.0, 0.1, n), np.full(n, 90.0),
                    np.arange(n) % 7, rng.uniform(0.5, 1.0, n))


def verdict(compliance, ledger=None):
    return json.loads(json.dumps(compliance.verdict(ledger).to_dict()))


class Node:
    """A node that judges and keeps a journal, and may be killed at any time."""

    def __init__(self, path, rule, within_s=3600.0, now_ns=None):
        self.compliance = Compliance(rule, source='live')
        self.journal = RunJournal(path, rule, {TWO: self.compliance}, within_s=within_s,
                                  now_ns=time.time_ns() if now_ns is None else now_ns)
        self.now_s = 0.0

    def take(self, pairs, marks=(), n=0):
        self.journal.add(pairs, {'1000': (1, n, 0, 0)})
        self.compliance.update(pairs)
        for kind, stamp_ns in marks:
            self.journal.mark(kind, stamp_ns)
            self.compliance.mark(kind, stamp_ns)
        self.now_s += 0.3
        self.journal.tick(self.now_s)

    def kill(self):
        """Let go of the file without a word, as the system does for a process that is killed."""
        self.journal._journal._syncing.close()
        if self.journal._journal._file >= 0:
            os.close(self.journal._journal._file)


@pytest.mark.parametrize('rule', [{}, {'runs__every_h': 0.25}, {'runs__stabilization_s': 100.0},
                                  {'sequential__plan_s': 3600.0},
                                  {'runs__every_h': 0.25, 'runs__keep': 3}])
@pytest.mark.parametrize('marks', [False, True])
def test_after_any_kills_the_verdict_is_that_of_a_trial_without(tmp_path, rng, rule, marks):
    rule, n = settings(**rule), 4000
    pairs = some_pairs(rng, n, gap_at=1500)
    whole = Compliance(rule, source='live')
    node = Node(tmp_path / 'j', rule)
    for lo in range(0, n, 100):
        chunk = pairs[lo:lo + 100]
        set_now = [('start', int(chunk.stamp_ns[-1]))] if marks and lo == 500 else (
            [('stop', int(chunk.stamp_ns[-1]))] if marks and lo == 3000 else [])
        whole.update(chunk)
        for mark in set_now:
            whole.mark(*mark)
        node.take(chunk, set_now, lo + 100)
        whole.results(), node.compliance.results()
        if lo % 700 == 0:
            node.kill()
            node = Node(tmp_path / 'j', rule)
            assert node.journal.resumed and not node.journal.set_aside
            assert node.journal.kept.numbers == {'1000': (1, lo + 100, 0, 0)}
            assert ('start' in {kind for kind, _ in node.journal.kept.marks}) is (
                marks and lo >= 500)
    whole.finish()
    node.compliance.finish()
    assert verdict(node.compliance) == verdict(whole)
    assert [r.verdict for r in node.compliance.take_earlier()] == [
        r.verdict for r in whole.take_earlier()]
    node.journal.close(over=True)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize('rule', [{}, {'runs__every_h': 0.25}, {'sequential__plan_s': 3600.0}])
def test_after_any_kills_the_motion_of_the_run_is_known(tmp_path, rng, rule):
    """The motion comes in other chunks than the pairs, and a part of it a second time."""
    rule, n = settings(**rule), 4000
    pairs = some_pairs(rng, n)
    moved = Motion.of_courses(pairs.stamp_ns, rng.normal(90.0, 1.0, n), np.full(n, 10.0))
    whole = Compliance(rule, source='live')
    node, given = Node(tmp_path / 'j', rule), 0
    for lo in range(0, n, 100):
        new = moved[given:lo + 100 + lo % 70]
        given = lo + 100 + lo % 70
        whole.take_motion(new)
        node.journal.add_motion(new)
        node.compliance.take_motion(new)
        whole.update(pairs[lo:lo + 100])
        node.take(pairs[lo:lo + 100], n=lo + 100)
        if lo % 700 == 0:
            node.kill()
            node = Node(tmp_path / 'j', rule)
            assert node.journal.kept.motion_ns == {'velocity': int(moved.stamp_ns[:given][-1])}
            again = leave_out_known(moved[:given], node.journal.kept.motion_ns)
            assert not len(again)
    whole.finish()
    node.compliance.finish()
    found = verdict(node.compliance)
    assert found == verdict(whole)
    assert sum(run['motion']['n_velocities'] for run in found['runs']) == n
    assert node.compliance.motion.late == whole.motion.late == 0


@pytest.mark.parametrize('rule', [{}, {'runs__every_h': 0.25}, {'sequential__plan_s': 3600.0}])
def test_after_any_kills_it_is_known_what_the_sensors_say(tmp_path, rng, rule):
    """The rows come in other chunks than the pairs, and their publisher sends some again."""
    rule, n = settings(**rule), 4000
    pairs = some_pairs(rng, n)
    said = Quality.of(pairs.stamp_ns, rng.uniform(0.1, 0.2, n), 1 + np.arange(n) // 300 % 3)
    whole = Compliance(rule, source='live')
    node, taken = Node(tmp_path / 'j', rule), 0
    for lo in range(0, n, 100):
        new = said[taken:lo + 100 + lo % 70]
        taken = lo + 100 + lo % 70
        for name, rows in {'rs': new, 'ts': new[::10]}.items():
            whole.take_quality(name, rows)
            node.journal.add_quality(name, rows)
            node.compliance.take_quality(name, rows)
        whole.update(pairs[lo:lo + 100])
        node.take(pairs[lo:lo + 100], n=lo + 100)
        if lo % 700 == 0:
            node.kill()
            node = Node(tmp_path / 'j', rule)
            node.compliance.take_quality('rs', said[max(0, taken - 50):taken])
    whole.finish()
    node.compliance.finish()
    document = verdict(node.compliance)
    assert document == verdict(whole)
    assert sum(run['quality']['rs']['n'] for run in document['runs']) == n
    assert sum(run['quality']['rs']['n_reduced'] for run in document['runs']) == np.count_nonzero(
        said.flag > 1)


def test_ledgers_of_all_synchronizers_come_back(tmp_path):
    node = Node(tmp_path / 'j', settings())
    node.take(some_pairs(np.random.default_rng(1), 10))
    ledgers = {}
    for started_ns in (5, 9):
        segments = [LedgerSegment(None, {'paired': 3})]
        for k in range(5):
            segments.append(LedgerSegment(T0 + k * S, {'ts_unpaired': k, 'rs_used': started_ns}))
            ledgers[started_ns] = LedgerMessage(Ledger.from_segments(
                segments, T0 + k, [SetBack('ts', T0, 7 * S)]), k == 4, started_ns,
                {'ts': StreamNumbers('ab', 1, 'cd', k)})
            node.journal.book(ledgers[started_ns])
            node.take(Pairs.empty())
    node.kill()
    kept = Node(tmp_path / 'j', settings()).journal.kept
    for started_ns, (ledger, final, _, numbers) in ledgers.items():
        back = kept.ledgers[started_ns]
        assert back.ledger.segments == ledger.segments and back.final == final
        assert back.numbers == numbers
        assert (back.ledger.newest_ns, back.ledger.set_backs) == (
            ledger.newest_ns, [SetBack('ts', T0, 7 * S)])


@pytest.mark.parametrize('cut', [1, 7, 300])
def test_a_torn_tail_is_left_out_and_named_and_the_trial_goes_on(tmp_path, rng, cut):
    pairs, path = some_pairs(rng, 200), tmp_path / 'j'
    node = Node(path, settings())
    for lo in range(0, 200, 50):
        node.take(pairs[lo:lo + 50])
    node.kill()
    os.truncate(path, path.stat().st_size - cut)
    node = Node(path, settings())
    assert node.compliance.newest_ns == pairs.stamp_ns[149]
    assert 'bytes of' in node.journal.resumed and 'were cut' in node.journal.resumed
    node.take(pairs[150:])
    node.kill()
    assert Node(path, settings()).compliance.newest_ns == pairs.stamp_ns[199]


def test_damage_within_ends_what_can_be_used(tmp_path, rng):
    path = tmp_path / 'j'
    node = Node(path, settings())
    for _ in range(3):
        node.take(some_pairs(rng, 50))
        node.compliance = node.journal._compliance = Compliance(settings())
    node.kill()
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    assert 0 < len(read_journal(path).records) < 5


@pytest.mark.parametrize('change, why', [
    (lambda p: p.write_bytes(b'heading_intercompare journal 7\n'), 'version 7, must be 3'),
    (lambda p: p.write_bytes(b'something else entirely'), 'is not a journal'),
    (lambda p: p.write_bytes(b''), 'is not a journal'),
    (lambda p: os.utime(p, (0, 0)), 'h ago, more than 3600 s')])
def test_another_journal_is_named_and_set_aside_and_nothing_of_it_is_lost(
        tmp_path, rng, change, why):
    path = tmp_path / 'j'
    node = Node(path, settings())
    node.take(some_pairs(rng, 50))
    node.kill()
    change(path)
    was = path.read_bytes()
    for number in (1, 2):
        node = Node(path, settings())
        if number == 1:
            assert why in node.journal.set_aside
            assert ('heading-intercompare analyze' in node.journal.set_aside) == ('ago' in why)
            assert str(tmp_path / 'j.1') in node.journal.set_aside
        assert not node.journal.resumed and node.compliance.newest_ns is None
        node.kill()
    assert (tmp_path / 'j.1').read_bytes() == was


def test_a_journal_of_other_settings_is_set_aside_and_they_are_named(tmp_path, rng):
    path = tmp_path / 'j'
    node = Node(path, settings())
    node.take(some_pairs(rng, 50))
    node.kill()
    node = Node(path, settings(norms__sigma_max_deg=0.4))
    aside = tmp_path / 'j.1'
    assert node.journal.set_aside.endswith(
        f'other settings: norms.sigma_max_deg; it is kept as {aside}; to judge what it holds: '
        f'heading-intercompare analyze {aside}')


def test_a_state_that_this_version_cannot_read_is_set_aside(tmp_path, rng, monkeypatch):
    path, rule = tmp_path / 'j', settings(runs__every_h=0.25)
    node = Node(path, rule)
    node.take(some_pairs(rng, 2000))
    node.kill()
    data = path.read_bytes()
    assert b'n_short' in data
    monkeypatch.setattr(journal_file.zlib, 'crc32', lambda data: 0)
    contents = [record._replace(data=record.data.replace(b'n_short', b'n_other'))
                for record in _records_of(data)]
    path.write_bytes(journal_file._MAGIC + b''.join(map(journal_file._pack, contents)))
    node = Node(path, rule)
    assert ('this version cannot read it: state.segments[0].n_short is missing'
            in node.journal.set_aside)
    assert node.compliance.finished_runs == 0


def _records_of(data):
    at, found = len(journal_file._MAGIC), []
    while at < len(data):
        size, _, kind = journal_file._HEAD.unpack_from(data, at)
        at += journal_file._HEAD.size
        found.append(journal_file.Record(kind, data[at:at + size]))
        at += size
    return found


def test_the_newest_bag_of_a_trial_is_found(tmp_path, rng):
    path, rule = tmp_path / 'j', settings()

    def found(rule=rule, within_s=3600.0):
        return find_bag(path, rule, within_s=within_s, now_ns=time.time_ns() + 10 * S)
    assert found() is None
    for bag in ('trial', 'trial_2', 'trial_3'):
        compliance = Compliance(rule)
        journal = RunJournal(path, rule, {TWO: compliance}, within_s=3600.0,
                             now_ns=time.time_ns(), bag=bag)
        journal.add(some_pairs(rng, 5), {})
        journal.tick(1.0)
        assert found() is None, 'a live process keeps its run there'
        journal.close(over=False)
        assert found() == bag
    assert found(settings(norms__sigma_max_deg=0.5)) is found(within_s=5.0) is None
    path.write_bytes(b'nothing')
    assert found() is None


def test_two_processes_do_not_share_a_journal(tmp_path, rng):
    first = Node(tmp_path / 'j', settings())
    first.take(some_pairs(rng, 50))
    with pytest.raises(BlockingIOError):
        Node(tmp_path / 'j', settings())
    first.take(some_pairs(rng, 50)[:0])
    assert not first.journal.fault


def test_a_full_disk_costs_nothing_once_there_is_room_again(tmp_path, rng, monkeypatch):
    pairs, path, full = some_pairs(rng, 3000), tmp_path / 'j', []
    node = Node(path, settings(runs__every_h=0.25))
    real = os.pwrite

    def pwrite(descriptor, data, at):
        if full and len(data) > 10:
            real(descriptor, data[:10], at)
            raise OSError(28, 'No space left on device')
        return real(descriptor, data, at)
    monkeypatch.setattr(journal_file.os, 'pwrite', pwrite)
    for lo in range(0, 3000, 100):
        full[:] = [True] * (500 <= lo < 2000)
        node.take(pairs[lo:lo + 100])
        assert node.journal.fault == ('No space left on device' if 500 <= lo < 2000 else
                                      node.journal.fault)
        node.now_s += 1.0
    assert node.journal.fault == ''
    node.kill()
    again = Node(path, settings(runs__every_h=0.25))
    assert again.journal.kept.dropped == 0
    for one in (again, node):
        one.compliance.finish()
    assert verdict(again.compliance) == verdict(node.compliance)


def test_a_disk_that_stays_full_costs_bounded_memory_and_the_hole_is_counted(
        tmp_path, rng, monkeypatch):
    monkeypatch.setattr(journal_file, '_MOST_WAITING', 20_000)
    pairs, path, full = some_pairs(rng, 3000), tmp_path / 'j', [True]
    node = Node(path, settings())
    real = os.pwrite

    def pwrite(descriptor, data, at):
        if full:
            raise OSError(28, 'No space left on device')
        return real(descriptor, data, at)
    monkeypatch.setattr(journal_file.os, 'pwrite', pwrite)
    for lo in range(0, 3000, 100):
        node.take(pairs[lo:lo + 100])
        node.now_s += 1.0
        assert node.journal._journal._n_waiting < 30_000
    full.clear()
    node.take(pairs[:0])
    node.kill()
    again = Node(path, settings())
    assert again.journal.kept.dropped > 0
    assert again.compliance.newest_ns == pairs.stamp_ns[-1]


@pytest.mark.slow
@pytest.mark.parametrize('booked', [False, True])
def test_the_journal_holds_one_run_only(tmp_path, rng, booked):
    """50 runs of 15 minutes: the file does not grow from run to run; `booked` with ledgers."""
    rule, sizes = settings(runs__every_h=0.25, runs__keep=3), []
    node = Node(tmp_path / 'j', rule)
    pairs = some_pairs(rng, 45_000)
    for lo in range(0, 45_000, 300):
        if booked:
            moved = Motion.of_rates(
                pairs.stamp_ns[lo] + np.arange(1500) * S // 5, rng.random(1500))
            node.journal.add_motion(moved)
            node.compliance.take_motion(moved)
            node.journal.book(ledger_of(pairs, lo + 300, [], False))
        node.take(pairs[lo:lo + 300])
        node.compliance.motion.forget(node.compliance.run_start_ns)
        node.compliance.results()
        node.compliance.take_earlier()
        sizes.append((tmp_path / 'j').stat().st_size)
    assert max(sizes[-30:]) < 1.3 * max(sizes[15:45]) and max(sizes) < 800_000
