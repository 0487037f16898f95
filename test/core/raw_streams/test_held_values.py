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

"""Tests of the filter of values that a logger holds, and of the search for them."""

import numpy as np
import pytest

from heading_intercompare import analyze
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.pairing.pairer import pair, Pairer
from heading_intercompare.core.raw_streams.held_values import HoldFilter, Unfolded
from heading_intercompare.core.raw_streams.hold_search import find_period
from heading_intercompare.core.records import Headings, Pairs
from heading_intercompare.core.settings import Settings

T0 = 1_700_000_000_000_000_000
SETTINGS = Settings.from_mapping({'norms': {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1}})


def yaw(t_s, rms_deg, period_s, rng):
    """Return a heading: 40 sines, their periods spread by 15 %."""
    rate = 2.0 * np.pi / (period_s * (1.0 + 0.15 * rng.standard_normal(40)))
    a, b = rng.standard_normal((2, 40))
    waves = np.sin(t_s[:, None] * rate) @ a + np.cos(t_s[:, None] * rate) @ b
    return 200.0 + rms_deg * waves / np.sqrt(0.5 * (a @ a + b @ b))


def readings(t_s, heading_deg, step_deg=0.01):
    return Headings.of(T0 + np.round(t_s * 1e9).astype(np.int64),
                       np.round(np.round(heading_deg / step_deg) * step_deg, 6) % 360.0)


def polled(rng, *, poll_s=0.2, times=5.0, span_s=600.0, motion=(2.0, 6.0), noise_deg=0.05,
           step_deg=0.01, held=(0.0, 1.0)):
    """Return a sensor as a logger polls it, and the times of the sensor's own reports."""
    own_s = np.concatenate(([0.0], np.arange(rng.uniform(0.0, poll_s), span_s, poll_s * times)))
    poll = np.arange(0.0, span_s, poll_s)
    both = yaw(np.concatenate((own_s, poll)), *motion, rng)
    both += noise_deg * rng.standard_normal(both.size)
    now, directly = both[:own_s.size], both[own_s.size:]
    stands = now[np.searchsorted(own_s, poll, side='right') - 1]
    inside = (poll >= held[0] * span_s) & (poll < held[1] * span_s)
    return readings(poll, np.where(inside, stands, directly), step_deg), own_s


def unfold(headings, sizes=None):
    keep = HoldFilter()
    bounds = [0, len(headings)] if sizes is None else [0, *np.cumsum(sizes).tolist()]
    found = Unfolded(Headings.empty())
    for lo, hi in zip(bounds, bounds[1:]):
        found = found + keep.take(headings[lo:hi])
    return found + keep.end()


@pytest.mark.parametrize('poll_s, times', [(0.2, 5.0), (0.1, 10.0), (0.5, 2.0), (0.1, 4.5),
                                           (0.2, 2.5), (0.1, 3.3)])
def test_one_reading_is_kept_of_each_value_that_a_logger_holds(rng, poll_s, times):
    headings, own_s = polled(rng, poll_s=poll_s, times=times)
    found = unfold(headings)
    assert len(found.kept) + len(found.held_ns) == len(headings)
    assert abs(len(found.kept) - own_s.size) <= 0.02 * own_s.size + 8


def test_the_first_reading_of_each_value_keeps_its_stamp_if_the_number_is_constant(rng):
    headings, _ = polled(rng)
    found = unfold(headings)
    changes = np.flatnonzero(np.diff(headings.heading_deg, prepend=np.nan) != 0.0)
    assert set(headings.stamp_ns[changes].tolist()) <= set(found.kept.stamp_ns.tolist())


def test_stamps_lie_on_a_line_if_the_number_wanders(rng):
    headings, own_s = polled(rng, poll_s=0.1, times=4.5)
    found = unfold(headings)
    kept_s = (found.kept.stamp_ns - T0) / 1e9
    late_s = kept_s[200:1200] - own_s[np.searchsorted(own_s, kept_s[200:1200] - 0.05)]
    first = headings.stamp_ns[np.flatnonzero(np.diff(headings.heading_deg))[200:1200] + 1]
    raw_s = (first - T0) / 1e9
    wanders_s = raw_s - own_s[np.searchsorted(own_s, raw_s, side='right') - 1]
    assert np.std(wanders_s) > 0.02
    assert np.std(late_s) < 0.005


@pytest.mark.parametrize('step_deg, motion', [(0.1, (1.0, 8.0)), (0.5, (2.0, 6.0))])
def test_a_coarse_sensor_that_is_held_is_found_by_a_constant_number(rng, step_deg, motion):
    headings, _ = polled(rng, step_deg=step_deg, motion=motion)
    assert len(unfold(headings).held_ns) > 0.75 * len(headings)


@pytest.mark.parametrize('rate_hz', [1.0, 5.0, 10.0, 50.0])
@pytest.mark.parametrize('step_deg', [0.01, 0.1, 1.0])
@pytest.mark.parametrize('motion', [(0.01, 30.0), (0.1, 20.0), (0.7, 10.0), (2.0, 6.0)])
def test_no_reading_of_a_sound_sensor_is_dropped(rng, rate_hz, step_deg, motion):
    t_s = np.arange(0.0, 600.0, 1.0 / rate_hz)
    noise = step_deg * rng.choice([0.0, 0.3, 1.0]) * rng.standard_normal(t_s.size)
    headings = readings(t_s, yaw(t_s, *motion, rng) + noise, step_deg)
    assert unfold(headings).kept == headings


def test_a_hold_in_a_part_of_a_run_is_found_there_alone(rng):
    headings, _ = polled(rng, poll_s=0.1, times=10.0, held=(0.4, 0.7))
    found = unfold(headings)
    inside = (found.held_ns - T0) / 1e9
    assert inside.size > 0.85 * 0.9 * 1800
    assert 239.0 < inside.min() and inside.max() < 421.0
    assert len(found.turned_ns) == 2


@pytest.mark.parametrize('arguments', [
    {}, {'poll_s': 0.1, 'times': 4.5}, {'poll_s': 0.1, 'times': 10.0, 'held': (0.3, 0.6)},
    {'step_deg': 0.5}, {'poll_s': 0.1, 'times': 1.7, 'noise_deg': 0.0}])
def test_the_result_does_not_depend_on_the_chunks(rng, arguments):
    headings, _ = polled(rng, span_s=200.0, **arguments)
    whole = unfold(headings)
    for sizes in (np.ones(len(headings), int), rng.integers(0, 90, len(headings))):
        part = unfold(headings, sizes)
        assert part.kept == whole.kept
        for name in ('held_ns', 'standing_ns', 'turned_ns'):
            assert np.array_equal(getattr(part, name), getattr(whole, name))


@pytest.mark.parametrize('noise_deg', [0.05, 1e-5])
def test_a_hold_after_many_new_values_is_found_whatever_the_chunks(rng, noise_deg):
    """Of a long chunk without a repeated value only its ends are searched."""
    n = 6000
    free = readings(0.2 * np.arange(n), 90.0 + noise_deg * rng.standard_normal(n), 1e-6)
    held, _ = polled(rng)
    later = Headings(held.stamp_ns - held.stamp_ns[0] + free.stamp_ns[-1] + 200_000_000,
                     held.heading_deg)
    after = Headings(free.stamp_ns - free.stamp_ns[0] + later.stamp_ns[-1] + 200_000_000,
                     free.heading_deg)
    together = free + later + after
    long, short = (unfold(together, [size] * (len(together) // size + 1)) for size in (2000, 300))
    assert long.held_ns.size > 0.7 * len(held)
    assert long.kept == short.kept
    for name in ('held_ns', 'standing_ns', 'turned_ns'):
        assert np.array_equal(getattr(long, name), getattr(short, name))


def test_nothing_waits_where_each_reading_has_a_new_value(rng):
    keep = HoldFilter()
    for lo in range(500):
        t_s = 0.1 * np.arange(lo, lo + 1)
        keep.take(readings(t_s, 100.0 + 0.03 * np.arange(lo, lo + 1)))
        assert len(keep) == 0


def test_a_sensor_that_never_changes_waits_for_three_seconds_at_its_start():
    keep = HoldFilter()
    for lo in range(500):
        keep.take(readings(np.array([0.1 * lo]), np.array([123.0])))
        assert len(keep) == (lo if lo <= 30 else 0)


def test_a_slow_sensor_that_repeats_a_value_never_waits():
    keep = HoldFilter()
    for lo in range(100):
        keep.take(readings(np.array([4.0 * lo]), np.array([123.0 + lo // 7])))
        assert len(keep) == 0


def test_inside_a_hold_nothing_waits(rng):
    headings, _ = polled(rng)
    keep = HoldFilter()
    keep.take(headings[:1500])
    for at in range(1500, 2000):
        keep.take(headings[at:at + 1])
        assert len(keep) == 0


def test_an_empty_chunk_is_a_chunk():
    assert unfold(Headings.empty()).kept == Headings.empty()


def test_a_period_is_the_largest_number_that_divides_nearly_all_distances():
    assert find_period(np.array([6] * 50 + [3] * 14)) == 3
    assert find_period(np.array([6] * 98 + [5] * 2)) == 6
    assert find_period(np.array([6] * 90 + [5] * 10)) == 1


@pytest.mark.parametrize('held', ['ts', 'rs', 'both'])
def test_a_sound_sensor_behind_a_logger_that_polls_too_often_is_compliant(held):
    rng = np.random.default_rng(371)
    t_s = np.arange(0.0, 1500.0, 0.2)
    motion = yaw(t_s, 1.0, 8.0, rng)
    sensors = {}
    for name, noise_deg in (('ts', 0.1), ('rs', 0.05)):
        heading = motion + noise_deg * rng.standard_normal(t_s.size)
        if held in (name, 'both'):
            heading = np.repeat(heading[::5], 5)
        sensors[name] = readings(t_s, heading)
    verdict = analyze(sensors['ts'], sensors['rs'], SETTINGS)
    run = verdict.runs[0]
    assert verdict.outcome is Outcome.COMPLIANT and run.validity_effect == 'holds'
    for name in ('ts', 'rs'):
        n = getattr(run.pairing, f'{name}_held')
        assert n == 0 if held not in (name, 'both') else n > 5900
        assert any(f'each value of the {name.upper()} stands 5 times' in words
                   for words in run.warnings) is (n > 0)


def test_pairs_and_ledger_of_held_values_do_not_depend_on_the_chunks(rng):
    rs, _ = polled(rng, poll_s=0.1, times=10.0, held=(0.3, 0.8), span_s=300.0)
    t_s = np.arange(0.05, 300.0, 0.2)
    ts = readings(t_s, yaw(t_s, 2.0, 6.0, rng))
    pairs, ledger = pair(ts, rs, SETTINGS)
    pairer, found, at = Pairer(SETTINGS), [], [0, 0]
    while at[0] < len(ts) or at[1] < len(rs):
        n = rng.integers(0, 40, 2).tolist()
        found.append(pairer.update(ts[at[0]:at[0] + n[0]], rs[at[1]:at[1] + n[1]]))
        at = [at[0] + n[0], at[1] + n[1]]
    found.append(pairer.flush())
    assert Pairs.concatenate(found) == pairs
    assert pairer.ledger.segments == ledger.segments
    assert set(ledger.balance().values()) == {0}
