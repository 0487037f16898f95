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

"""Ledgers of several starts of the synchronizer add up."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare import Headings, Settings
from heading_intercompare.core.pairing.incarnations import Incarnations, StreamNumbers
from heading_intercompare.core.pairing.ledger import Ledger, LedgerKey, LedgerSegment
from heading_intercompare.core.pairing.pairer import Pairer
from heading_intercompare.core.raw_streams.stamp_jumps import SetBack

STEP_NS = 10 ** 8
STAMPS = 1_700_000_000 * 10 ** 9 + np.arange(1, 301) * STEP_NS
RULE = Settings.from_mapping({'pairing': {'method': 'interpolate'}})


def pairer_of(lo, hi, *, ends=True):
    """Return a pairer that took some of the readings; an RS reading is there for every other."""
    pairer = Pairer(RULE)
    pairer.update(Headings.of(STAMPS[lo:hi], np.full(hi - lo, 90.0)),
                  Headings.of(STAMPS[lo:hi:2], np.full(len(STAMPS[lo:hi:2]), 90.0)))
    if ends:
        pairer.flush()
    return pairer


def received(counts, stream):
    """Return how many readings of a sensor a mapping of counts has."""
    return sum(n for key, n in counts.items() if key.stream == stream and not key.lost)


def test_before_the_first_ledger_there_is_none():
    found = Incarnations()
    assert (found.total, found.paired, found.final, [*found.problems()]) == (None, 0, False, [])


def test_one_incarnation_is_its_last_ledger():
    found, pairer = Incarnations(), pairer_of(0, 100)
    found.take(pairer_of(0, 50).ledger, False, 7)
    found.take(pairer.ledger, True, 7)
    assert found.total is pairer.ledger and found.final and [*found.problems()] == []


@pytest.mark.parametrize('final', [False, True])
def test_incarnations_add_up_and_the_restart_is_told(final):
    first, second = pairer_of(0, 100, ends=final), pairer_of(120, 300)
    found = Incarnations()
    found.take(second.ledger, True, 1_700_000_030 * 10 ** 9)
    found.take(first.ledger, final, 1_700_000_001 * 10 ** 9)
    total = found.total.total.counts
    assert found.paired == second.ledger.paired and found.final
    assert found.total.paired == first.ledger.paired + second.ledger.paired
    for stream, n in (('ts', 280), ('rs', 140)):
        assert received(total, stream) == n
    # What waited when the first one was killed will never be decided.
    assert 'ts_pending' not in total and 'rs_pending' not in total
    problem, = found.problems()
    assert '2023-11-14 22:13:50.000 UTC' in problem
    assert ('up to 1 s of readings is missing' in problem) == (not final)


def test_what_the_second_one_received_first_does_not_fall_before_the_first():
    first, second = pairer_of(0, 100), Pairer(RULE)
    second.update(ts=Headings.of(STAMPS[120:140], np.full(20, 90.0)))
    second.flush()
    found = Incarnations()
    found.take(first.ledger, True, 1)
    found.take(second.ledger, True, 2)
    late = [s for s in found.total.segments if s.counts.get('ts_unpaired') == 20]
    assert [s.start_ns for s in late] == [int(STAMPS[99]) + 1]


def test_a_late_copy_does_not_replace_the_final_ledger():
    found = Incarnations()
    found.take(pairer_of(0, 100).ledger, True, 1)
    found.take(pairer_of(0, 50).ledger, False, 1)
    assert found.final and found.total.total.received('ts') == 100


@pytest.mark.parametrize('publishers, counted', [
    (('a', 'a'), True), (('a', 'b'), False), (('', ''), False)])
def test_readings_between_two_starts_count_as_lost_if_one_publisher_numbered_them(
        publishers, counted):
    """The first took up to 100, the second from 121 on: 20 lie between."""
    found, (last, first) = Incarnations(), publishers
    for name, lo, hi, started_ns in ((last, 0, 100, 1), (first, 120, 300, 2)):
        numbers = dict.fromkeys(('ts', 'rs'), StreamNumbers(name, lo + 1, name, hi))
        found.take(pairer_of(lo, hi).ledger, started_ns == 2, started_ns, numbers)
    counts = found.total.total.counts
    assert (counts.get('ts_lost.on_the_way'), counts.get('rs_lost.on_the_way')) == (
        (20, 20) if counted else (None, None))
    problem, = found.problems()
    assert ('20 TS and 20 RS readings came after' in problem) == counted
    inside = found.total.count_between(int(STAMPS[0]), int(STAMPS[-1]))
    assert inside.lost('ts') == ({'on_the_way': 20} if counted else {})


@pytest.mark.parametrize('publisher, before', [('a', 40), ('b', 160)])
def test_what_came_before_a_successor_is_not_counted_twice(publisher, before):
    """The first heard from number 41 to 100, the second from 121: of `a` the numbers say it."""
    found = Incarnations()
    for name, number, started_ns in (('a', 41, 1), (publisher, 121, 2)):
        pairer = pairer_of(number - 1, number + 59)
        pairer.ledger.lose(LedgerKey.TS_LOST_BEFORE_START, STAMPS[[number - 1]] - 1,
                           np.array([number - 1]))
        found.take(pairer.ledger, True, started_ns, dict.fromkeys(
            ('ts', 'rs'), StreamNumbers(name, number, name, number + 59)))
    lost = found.total.total.lost('ts')
    assert lost['before_start'] == before
    assert lost.get('on_the_way') == (20 if publisher == 'a' else None)
    assert 'before_start' not in found.total.count_between(
        int(STAMPS[40]), int(STAMPS[99])).lost('ts')


def test_what_waits_in_the_newest_incarnation_still_waits():
    """The first left 3 TS and 2 RS readings without a partner; 4 and 6 wait in the second."""
    ledgers = Incarnations()
    for started_ns, (n_ts, n_rs) in enumerate(((3, 2), (4, 6)), 1):
        counts = {'paired': 60, 'ts_paired': 60, 'rs_used': 60, 'ts_pending': n_ts,
                  'rs_pending': n_rs}
        ledgers.take(Ledger.from_segments([LedgerSegment(None, counts)], 1000 * started_ns),
                     False, started_ns)
    counts = ledgers.total.total.counts
    assert (counts['ts_unpaired'], counts['rs_unused']) == (3, 2)
    assert (counts['ts_pending'], counts['rs_pending']) == (4, 6)


def test_clock_segments_go_on_counting_after_a_restart():
    """The first synchronizer ended in its second segment, so that of the next is a third one."""
    first = Ledger.from_segments([
        LedgerSegment(None, {'paired': 10}), LedgerSegment(500, {'paired': 20}),
        LedgerSegment(None, {'paired': 30}, clock_segment=1)], 200, [SetBack('ts', 900, 800)])
    second = Ledger.from_segments([
        LedgerSegment(None, {'paired': 40}),
        LedgerSegment(None, {'paired': 50}, clock_segment=1)], 300, [SetBack('rs', 700, 600)])
    ledgers = Incarnations()
    ledgers.take(first, False, 1)
    ledgers.take(second, True, 2, first_segment=2)
    total = ledgers.total
    assert [part.clock_segment_total.counts['paired'] for part in total.clock_segments] == [
        30, 30, 40, 50]
    assert [(step.stream, step.clock_segment) for step in total.all_set_backs] == [
        ('ts', 0), ('rs', 2)]
    assert total.paired == 150 and total.newest_ns == 300


def test_a_restart_before_any_step_goes_on_in_the_same_clock_segment():
    first = Ledger.from_segments([LedgerSegment(None, {'paired': 10})], 200)
    second = Ledger.from_segments([
        LedgerSegment(None, {'paired': 40}),
        LedgerSegment(None, {'paired': 50}, clock_segment=1)], 50, [SetBack('ts', 400, 380)])
    ledgers = Incarnations()
    ledgers.take(first, False, 1)
    ledgers.take(second, True, 2)
    assert [part.clock_segment_total.counts['paired']
            for part in ledgers.total.clock_segments] == [50, 50]
