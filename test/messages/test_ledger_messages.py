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

"""Ledgers and losses as messages."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare import analyze, Headings, Settings
from heading_intercompare.core.pairing.incarnations import StreamNumbers
from heading_intercompare.core.pairing.ledger import Ledger, LedgerSegment, LOSSES, REASONS
from heading_intercompare.core.pairing.names import Span
from heading_intercompare.core.pairing.pairer import Pairer
from heading_intercompare.core.pipeline import Compliance
from heading_intercompare.core.raw_streams.stamp_jumps import SetBack
from heading_intercompare.core.records import Losses
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.ledger_messages import (
    decode_ledger,
    decode_losses,
    encode_ledger,
    encode_losses,
    LOST_AS,
    lost_topic,
)
from heading_intercompare.messages.status_messages import (
    decode_statuses,
    encode_statuses,
    OK,
    Status,
)

hypothesis = pytest.importorskip('hypothesis')
st = hypothesis.strategies

KEYS = ['paired', 'ts_paired', 'ts_used', 'ts_unpaired', 'ts_pending', 'rs_used', 'rs_unused',
        'rs_pending',
        *(f'{s}_rejected.{r}' for s in ('ts', 'rs') for r in REASONS),
        *(f'{s}_lost.{where}' for s in ('ts', 'rs') for where in LOSSES)]
T_NS = 1_700_000_000_123_456_789
COUNTS = st.dictionaries(st.sampled_from(KEYS), st.integers(1, 2 ** 40), max_size=6)


@hypothesis.given(COUNTS, st.lists(st.tuples(st.integers(1, 2 ** 62), COUNTS), max_size=3,
                                   unique_by=lambda s: s[0]),
                  st.integers(1, 2 ** 31 * 10 ** 9 - 1), st.booleans())
def test_a_ledger_arrives_as_it_was(first, others, newest_ns, final):
    segments = (LedgerSegment(None, dict(sorted(first.items()))),
                *(LedgerSegment(ns, dict(sorted(counts.items())))
                  for ns, counts in sorted(others, key=lambda s: s[0])))
    ledger = Ledger.from_segments(segments, newest_ns)
    back, said_final, started_ns, _ = decode_ledger(encode_ledger(ledger, final, newest_ns + 7))
    assert started_ns == newest_ns + 7
    assert back.segments == segments
    assert (back.newest_ns, said_final) == (newest_ns, final)
    assert back.paired == ledger.paired


def test_the_numbers_of_each_publisher_arrive():
    numbers = {'ts': StreamNumbers('aa', 3, 'bb', 9, (Span('aa', 3, 70), Span('', 2, 9))),
               'rs': StreamNumbers('', 0, '', 0)}
    assert decode_ledger(encode_ledger(Ledger(), numbers=numbers)).numbers == numbers


def test_clocks_that_were_set_back_arrive_with_their_ledger():
    steps = [SetBack('ts', 5, 3600), SetBack('ts', 9, 1), SetBack('rs', 7, 2)]
    ledger = Ledger.from_segments([LedgerSegment(None), LedgerSegment(6), LedgerSegment(8)], 9,
                                  steps)
    back = decode_ledger(encode_ledger(ledger)).ledger
    assert back.set_backs == ledger.set_backs
    assert back.segments == ledger.segments
    assert [share.set_backs for share in back.shares([1, 6, 8])] == [
        (steps[0],), (steps[2],), (steps[1],)]
    assert [share.set_backs for share in back.shares([6, 100])] == [tuple(steps), ()]


@pytest.mark.slow
def test_a_live_verdict_names_a_clock_set_back_as_the_recording_does():
    """Pairs and ledger as they go from node to node; the clock of both goes back by an hour."""
    stamps = 1_700_000_000 * 10 ** 9 + np.arange(12_000) * 10 ** 8
    stamps[11_000:] -= 3600 * 10 ** 9
    rng = np.random.default_rng(1)
    ts, rs = (Headings.of(stamps, 90.0 + s * rng.standard_normal(12_000)) for s in (0.1, 0.05))
    settings = Settings.from_mapping({'norms.sigma_max_deg': 0.3,
                                      'norms.sigma_ref_max_deg': 0.1})
    pairer, compliance = Pairer(settings), Compliance(settings)
    for lo in range(0, 12_000, 7):
        compliance.update(pairer.update(ts[lo:lo + 7], rs[lo:lo + 7], now_s=lo / 10.0))
    compliance.update(pairer.flush())
    compliance.finish()
    ledger = decode_ledger(encode_ledger(pairer.ledger, final=True)).ledger
    live, offline = compliance.verdict(ledger), analyze(ts, rs, settings)
    assert 'was set back by 3600.0 s' in live.headline
    assert (live.outcome, live.headline) == (offline.outcome, offline.headline)
    assert live.runs[0].validity == offline.runs[0].validity
    assert live.runs[0].pairing == offline.runs[0].pairing


@pytest.mark.parametrize('values, why', [
    ({'stream': 'x', 'stamp_ns': 1, 'size_ns': 1}, "stream = 'x' must be 'ts' or 'rs'"),
    ({'stream': 'ts', 'size_ns': 1}, "stamp_ns = '' must be an integer")])
def test_a_set_back_that_cannot_be_read_is_refused(values, why):
    with pytest.raises(MessageError, match=f'ledger: {why}'):
        decode_ledger(encode_statuses(1, [Status('clock set back 0', OK, '', values)]))


def test_a_ledger_of_nothing_arrives_as_it_was():
    back, final, *_ = decode_ledger(encode_ledger(Ledger()))
    assert (back.segments, back.newest_ns, final) == (Ledger().segments, None, False)


def test_a_ledger_shows_its_total_first():
    segments = [LedgerSegment(None, {'paired': 3, 'rs_used': 3}), LedgerSegment(5, {'paired': 4})]
    _, (total, *others) = decode_statuses(encode_ledger(Ledger.from_segments(segments, 9)))
    assert total == Status('ledger', OK, 'so far', {'final': 'false', 'paired': '7',
                                                    'rs_used': '3'})
    assert [(one.name, one.values.get('start_ns')) for one in others] == [
        ('segment 0', None), ('segment 1', '5')]


def test_a_count_that_is_no_number_is_refused():
    data = encode_statuses(1, [Status('segment 0', OK, '', {'paired': 'many'})])
    with pytest.raises(MessageError, match="ledger: paired = 'many' must be an integer"):
        decode_ledger(data)


@pytest.mark.parametrize('key', ['start_ns', 'paired', 'incarnation_ns'])
@pytest.mark.parametrize('number', [2**63, -2**63, 10**400])
def test_a_number_beyond_64_bits_is_refused(key, number):
    name = 'ledger' if key == 'incarnation_ns' else 'segment 0'
    data = encode_statuses(1, [Status(name, OK, '', {key: number})])
    with pytest.raises(MessageError, match=f'ledger: {key} = .* must be an integer of 64 bits'):
        decode_ledger(data)


def test_a_key_that_no_ledger_has_is_refused():
    data = encode_statuses(1, [Status('segment 0', OK, '', {'paired': 3, 'ts_lost': 2})])
    with pytest.raises(MessageError, match="ledger: 'ts_lost' is not a key of a ledger"):
        decode_ledger(data)


def test_a_ledger_that_is_cut_is_refused():
    with pytest.raises(MessageError, match='ends early'):
        decode_ledger(encode_ledger(Ledger())[:-5])


def test_a_segment_that_does_not_say_where_it_starts_is_refused():
    data = encode_statuses(1, [Status(f'segment {i}', OK, '', {'paired': 1}) for i in range(2)])
    with pytest.raises(MessageError, match='has no start_ns'):
        decode_ledger(data)


def test_losses_come_back_to_the_bit():
    found = {lost_as: Losses.of([T_NS + at, T_NS + at + 7], [0, T_NS], [1 + at, -5])
             for at, lost_as in enumerate(LOST_AS)}
    assert decode_losses(encode_losses(found)) == found
    assert decode_losses(encode_losses({})) == {}


def test_the_topic_stands_beside_that_of_the_headings():
    assert lost_topic('/ts/heading') == '/ts/heading/lost'


@pytest.mark.parametrize('status, words', [
    (Status('lost.in_thought', OK, '', {}), "'lost.in_thought' must be one of lost.on_the_way"),
    (Status('lost.at_source', OK, '', {'stamp_ns': 1, 'since_ns': 0}), "count = ''"),
    (Status('lost.at_source', OK, '', {'stamp_ns': 'x', 'since_ns': 0, 'count': 1}),
     "stamp_ns = 'x': must be|stamp_ns = 'x' must be an integer"),
    (Status('lost.at_source', OK, '', {'stamp_ns': 1, 'since_ns': 0, 'count': 2**63}),
     'count = .* must be an integer of 64 bits')])
def test_what_is_no_loss_is_refused(status, words):
    with pytest.raises(MessageError, match=words):
        decode_losses(encode_statuses(1, [status]))
