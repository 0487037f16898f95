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

"""Stamps that jump: bad ones cost only themselves, true ones cost nothing."""

from __future__ import annotations

from hypothesis import given, settings as tries, strategies as st
import numpy as np
import pytest

from heading_intercompare.core.pairing.pairer import pair, Pairer
from heading_intercompare.core.raw_streams.stamp_jumps import JumpFilter, SetBack
from heading_intercompare.core.records import Headings, Pairs
from heading_intercompare.core.settings import Settings

S = 10 ** 9
HOUR = 3600 * S
T0 = 1_700_000_000 * S
STEP = S // 10
METHODS = ['auto', 'interpolate', 'interpolate_ts', 'nearest']


def regular(n=400, step=STEP):
    """Return n regular stamps."""
    return T0 + np.arange(n, dtype=np.int64) * step


def numbered(stamps):
    """Return readings whose heading is their number, modulo 360."""
    return Headings.of(stamps, np.arange(len(stamps)) % 360.0)


def sift(stamps, jump_s=10.0, size=None):
    """Return the stamps late, jumped and accepted, and the clocks set back, chunk by chunk."""
    jumps, set_backs, decided = JumpFilter('ts', jump_s, Headings.empty()), [], []
    size = size or max(1, len(stamps))
    for lo in range(0, len(stamps), size):
        rows = numbered(stamps)[lo:lo + size]
        while rows is not None:
            decided.append(jumps.take(rows))
            rows = decided[-1].after
            if rows is not None:
                assert len(jumps) == 0
                set_backs.append(decided[-1].set_back)
                jumps = JumpFilter('ts', jump_s, Headings.empty())
    decided.append(jumps.end())
    assert len(jumps) == 0
    return (*(np.concatenate([getattr(d, name) for d in decided]).tolist()
              for name in ('late_ns', 'jumped_ns')),
            np.concatenate([d.accepted.stamp_ns for d in decided]).tolist(), set_backs)


@pytest.mark.parametrize('off', [HOUR, -HOUR, 11 * S, -11 * S, 365 * 24 * HOUR])
@pytest.mark.parametrize('rows', [[0], [1], [2], [200], [398], [399], [0, 1], [5, 6], [200, 201],
                                  [398, 399], [3, 5, 7], list(range(100, 109))])
def test_bad_stamps_cost_only_themselves(rows, off):
    stamps = regular()
    stamps[rows] += off
    late, jumped, accepted, set_backs = sift(stamps)
    assert late == []
    assert sorted(jumped) == sorted(stamps[rows].tolist())
    assert accepted == np.delete(stamps, rows).tolist()
    assert set_backs == []


@pytest.mark.parametrize('off', [HOUR, -HOUR])
def test_five_seconds_of_bad_stamps_cost_only_themselves(off):
    stamps = regular()
    stamps[100:150] += off
    late, jumped, accepted, set_backs = sift(stamps)
    assert (late, len(jumped), len(accepted), set_backs) == ([], 50, 350, [])


def test_bad_stamps_of_many_sizes_in_a_row_are_rejected():
    stamps = regular()
    stamps[200:212] += np.array([9, 3, 7, 1, 8, 2, 6, 4, 5, 12, 11, 10]) * HOUR
    _, jumped, accepted, _ = sift(stamps)
    assert (len(jumped), len(accepted)) == (12, 388)


@pytest.mark.parametrize('step', [S // 100, STEP, S, 5 * S, 20 * S, 300 * S])
@pytest.mark.parametrize('silence', [12 * S, 60 * S, 2 * HOUR, 1000 * HOUR])
def test_a_true_silence_costs_nothing(step, silence):
    stamps = regular(300, step)
    stamps[150:] += silence
    late, jumped, accepted, set_backs = sift(stamps)
    assert (late, jumped, set_backs) == ([], [], [])
    assert accepted == stamps.tolist()


@pytest.mark.parametrize('step', [15 * S, 40 * S, 600 * S])
def test_a_sensor_slower_than_the_bound_is_held_only_at_first(step):
    stamps = regular(20, step)
    jumps = JumpFilter('ts', 10.0, Headings.empty())
    held = []
    for row in range(20):
        jumps.take(numbered(stamps)[row:row + 1])
        held.append(len(jumps))
    assert held[:3] == [1, 2, 0]
    assert set(held[6:]) == {0}


def test_a_sensor_that_becomes_slow_is_still_heard():
    stamps = np.concatenate((regular(), regular()[-1] + np.arange(1, 101) * 20 * S))
    late, jumped, accepted, _ = sift(stamps)
    assert (late, jumped) == ([], [])
    assert accepted == stamps.tolist()


@pytest.mark.parametrize('size', [4000, 2001, 1000, 7, 1])
def test_a_clock_set_back_by_an_hour_is_named_and_its_stamps_go_on(size):
    stamps = regular(4000)
    stamps[2000:] -= HOUR
    late, jumped, accepted, set_backs = sift(stamps, size=size)
    assert (late, jumped, accepted) == ([], [], stamps.tolist())
    assert set_backs == [SetBack('ts', int(stamps[1999]), HOUR)]


def test_a_reading_ahead_among_those_set_back_is_rejected():
    stamps = regular()
    stamps[200:] -= HOUR
    stamps[[210, 230]] += 3 * HOUR
    late, jumped, accepted, set_backs = sift(stamps)
    assert (late, sorted(jumped)) == ([], sorted(stamps[[210, 230]].tolist()))
    assert accepted == np.delete(stamps, [210, 230]).tolist()
    assert [step.size_ns for step in set_backs] == [HOUR]


def test_a_clock_set_back_by_half_a_second_repeats_stamps_as_ever():
    stamps = regular()
    stamps[200:] -= S // 2
    late, jumped, accepted, set_backs = sift(stamps)
    assert (len(late), jumped, len(accepted), set_backs) == (5, [], 395, [])


def test_two_clocks_in_turn_cost_one_of_them():
    """Every other reading an hour ahead: the first clock stays, and nothing is set back."""
    stamps = regular()
    stamps[1::2] += HOUR
    late, jumped, accepted, set_backs = sift(stamps)
    assert accepted == stamps[::2].tolist()
    assert (late, len(jumped), set_backs) == ([], 200, [])


def test_duplicates_and_reordering_within_the_bound_are_late():
    stamps = regular()
    stamps[[100, 101]] = stamps[[101, 100]]
    stamps[300] = stamps[299]
    late, jumped, _, _ = sift(stamps)
    assert (late, jumped) == ([stamps[101], stamps[300]], [])


def test_a_duplicate_of_a_held_stamp_does_not_confirm_it():
    stamps = np.insert(regular(), 200, [T0 + HOUR] * 50)
    late, jumped, accepted, _ = sift(stamps)
    assert (len(late), len(jumped), len(accepted)) == (49, 1, 400)


@pytest.mark.parametrize('n', [0, 1, 2])
@pytest.mark.parametrize('step', [STEP, 2 * HOUR])
def test_a_stream_too_short_to_tell_is_accepted(n, step):
    late, jumped, accepted, _ = sift(regular(n, step))
    assert (late, jumped, accepted) == ([], [], regular(n, step).tolist())


def test_a_start_waits_for_a_second_of_stamps_and_a_jump_for_five():
    """At 10 Hz the first is held with 10 or 50 more; then all are accepted at once."""
    jumps = JumpFilter('ts', 10.0, Headings.empty())
    rows = numbered(regular(60))
    assert [len(jumps.take(rows[k:k + 1]).accepted) for k in range(12)] == [0] * 10 + [11, 1]
    late = Headings.of(rows.stamp_ns + 2 * HOUR, rows.heading_deg)
    assert [len(jumps.take(late[k:k + 1]).accepted) for k in range(52)] == [0] * 50 + [51, 1]


def test_the_memory_of_a_filter_is_bounded():
    jumps = JumpFilter('ts', 10.0, Headings.empty())
    jumps.take(numbered(regular()))
    for k in range(1000):
        jumps.take(Headings.of([T0 + (2000 - k) * HOUR], [0.0]))
        assert len(jumps) <= 16


# Stretches of readings, each with a step, an offset of the clock and a size.
stretches = st.lists(st.tuples(
    st.integers(1, 40), st.sampled_from([STEP, S // 2, S, 15 * S]),
    st.sampled_from([0, 0, 0, S // 2, -S // 2, 9 * S, 12 * S, -12 * S, HOUR, -HOUR, 2 * HOUR])),
    min_size=1, max_size=12)


def stamps_of(rows):
    """Return the stamps of stretches; each offset holds for its stretch."""
    found, now = [], T0
    for n, step, off in rows:
        found.append(now + off + step * np.arange(1, n + 1, dtype=np.int64))
        now += n * step
    return np.concatenate(found)


@pytest.mark.slow
@given(stretches)
def test_chunks_do_not_matter_and_every_reading_has_a_place(rows):
    stamps = stamps_of(rows)
    late, jumped, accepted, whole = sift(stamps)
    assert sorted([*late, *jumped, *accepted]) == sorted(stamps.tolist())
    assert int((np.diff(accepted) <= 0).sum()) <= len(whole)
    for size in (1, 7):
        *other, set_backs = sift(stamps, size=size)
        assert [*map(sorted, other[:2]), other[2]] == [sorted(late), sorted(jumped), accepted]
        assert set_backs == whole


@pytest.mark.slow
@pytest.mark.parametrize('method', METHODS)
@tries(max_examples=max(10, tries.default.max_examples // 4))  # Each takes a second.
@given(ts=stretches, rs=stretches, data=st.data())
def test_pairs_and_ledger_are_the_same_for_every_chunking(method, ts, rs, data):
    settings = Settings.from_mapping({
        'pairing.method': method, 'pairing.tolerance_s': 0.3, 'runs.gap_s': 5.0,
        'pairing.auto_s': 4.0})
    streams = {'ts': numbered(stamps_of(ts)), 'rs': numbered(stamps_of(rs))}
    whole, ledger = pair(streams['ts'], streams['rs'], settings)
    assert all((np.diff(part.stamp_ns) > 0).all() for part in whole.in_segments())
    assert ledger.balance() == {'ts': 0, 'rs': 0}
    # Where a clock was set back, what came before it counts, too: both come in their order.
    came_ns = {name: stamps_of([(n, step, 0) for n, step, _ in rows])
               for name, rows in (('ts', ts), ('rs', rs))}
    pairer, at, chunks = Pairer(settings), {'ts': 0, 'rs': 0}, []
    while any(at[name] < len(streams[name]) for name in at):
        left = [name for name in at if at[name] < len(streams[name])]
        name = (min(left, key=lambda stream: came_ns[stream][at[stream]]) if ledger.closed
                else data.draw(st.sampled_from(left)))
        n = data.draw(st.integers(1, 5 if ledger.closed else 200))
        chunks.append(pairer.update(**{name: streams[name][at[name]:at[name] + n]}))
        at[name] += n
        assert pairer.ledger.balance() == {'ts': 0, 'rs': 0}
    chunks.append(pairer.flush())
    pairs = Pairs.concatenate(chunks)
    assert all((np.diff(part.stamp_ns) > 0).all() for part in pairs.in_segments())
    if not ledger.closed:
        assert pairs == whole
        assert pairer.ledger.segments == ledger.segments
        assert pairer.ledger.set_backs == ledger.set_backs


@pytest.mark.parametrize('who', ['ts', 'rs'])
@pytest.mark.parametrize('rows', [[122], [0], [399], [122, 123]])
def test_of_400_readings_with_a_stamp_an_hour_ahead_the_others_are_paired(who, rows):
    stamps = regular()
    bad = stamps.copy()
    bad[rows] += HOUR
    streams = {s: numbered(bad if s == who else stamps) for s in ('ts', 'rs')}
    pairs, ledger = pair(streams['ts'], streams['rs'], Settings())
    counts = ledger.total.counts
    assert counts[f'{who}_rejected.jump'] == len(rows)
    if who == 'ts':
        assert len(pairs) == 400 - len(rows)
    else:
        # A fast RS is interpolated over a bad reading, but not over two, nor beyond its ends.
        assert len(pairs) == (400 if rows == [122] else 400 - len(rows))
    assert 'ts_pending' not in counts and f'{who}_rejected.stamp_not_increasing' not in counts


@pytest.mark.parametrize('bad', [{'ts': 122}, {'rs': 122}, {'ts': 0}, {'rs': 0},
                                 {'ts': 50, 'rs': 50}])
@pytest.mark.parametrize('silence', [0, 2 * HOUR])
def test_live_with_a_waiting_limit_the_pairs_are_those_of_the_recording(bad, silence):
    """Readings do not expire while a stamp of the other sensor is held."""
    settings = Settings.from_mapping({'pairing.method': 'interpolate', 'pairing.max_wait_s': 0.5})
    stamps = regular()
    stamps[200:] += silence
    streams = {}
    for name in ('ts', 'rs'):
        own = stamps.copy()
        if name in bad:
            own[bad[name]] += HOUR
        streams[name] = numbered(own)
    whole, ledger = pair(streams['ts'], streams['rs'], settings)
    pairer, found = Pairer(settings), []
    for k in range(400):
        found.append(pairer.update(streams['ts'][k:k + 1], streams['rs'][k:k + 1],
                                   now_s=k * 0.1))
    found.append(pairer.flush())
    assert Pairs.concatenate(found) == whole
    assert pairer.ledger.total.counts == ledger.total.counts
    assert len(whole) >= 398


def test_live_held_readings_are_pending():
    pairer = Pairer(Settings.from_mapping({'pairing.method': 'interpolate'}))
    both = numbered(regular(100))
    pairer.update(both, both, now_s=0.0)
    ahead = Headings.of([T0 + HOUR, T0 + HOUR + STEP], [0.0, 0.0])
    pairer.update(ahead, ahead, now_s=0.1)
    counts = pairer.ledger.total.counts
    assert counts['ts_pending'] == 2 and counts['rs_pending'] >= 2
    assert pairer.ledger.balance() == {'ts': 0, 'rs': 0}
