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

"""Clocks that lie minutes apart are found, and none are made up from independent motion."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from heading_intercompare.core.records import Headings
from heading_intercompare.core.timing.clock_search import ClockSearch, find_apart
from heading_intercompare.core.timing.heading_track import Track


def track(t_s, heading_deg):
    """Return a track of headings that need no unwrapping."""
    made = Track(Headings.empty())
    made.t_s, made.heading_deg = np.asarray(t_s, float), np.asarray(heading_deg, float)
    return made


def times(span_s, hz=2.0, begin_s=0.0):
    return begin_s + np.arange(0.0, span_s, 1.0 / hz)


def quiet(rng, span_s):
    return np.zeros_like


def swell(rng, span_s):
    hz, phase = rng.normal(0.1, 0.015, 60), rng.uniform(0.0, 2.0 * np.pi, 60)
    return lambda t_s: 0.13 * np.sin(2.0 * np.pi * hz * t_s[:, np.newaxis] + phase).sum(axis=1)


def tones(rng, span_s):
    period, phase = rng.uniform(5.0, 14.0, 12), rng.uniform(0.0, 2.0 * np.pi, 12)
    return lambda t_s: 0.4 * np.sin(2.0 * np.pi * t_s[:, np.newaxis] / period + phase).sum(axis=1)


def one_tone(rng, span_s):
    phase = rng.uniform(0.0, 2.0 * np.pi)
    return lambda t_s: np.sin(2.0 * np.pi * t_s / 8.0 + phase)


def turns(rng, span_s, n=4):
    begin, rate = rng.uniform(0.0, span_s, n), rng.choice([-1.0, 1.0], n) * rng.uniform(0.3, 2, n)
    lasts = rng.uniform(10.0, 120.0, n) / np.abs(rate)
    return lambda t_s: (rate * np.clip(t_s[:, np.newaxis] - begin, 0.0, lasts)).sum(axis=1)


def wander(rng, span_s):
    grid = np.arange(-700.0, span_s + 700.0)
    steps = lfilter([1.0], [1.0, -0.8], rng.standard_normal(grid.size))
    heading = lfilter([1.0], [1.0, -np.exp(-1.0 / 40.0)], steps)
    return lambda t_s: np.interp(t_s, grid, heading / heading.std())


def pair_of(rng, ship, other, late_s, span_s=1200.0, ts_hz=2.0, rs_hz=1.0):
    """Return TS and RS with noise; the TS shows the other ship, late."""
    t, u = times(span_s, ts_hz, 0.05), times(span_s, rs_hz)
    return (track(t, other(t - late_s) + 0.1 * rng.standard_normal(t.size)),
            track(u, ship(u) + 0.05 * rng.standard_normal(u.size)))


@pytest.mark.parametrize('late_s', [61.0, -79.5, 89.1, -300.0, 590.0])
@pytest.mark.parametrize('motion', [swell, tones, wander])
@pytest.mark.parametrize('rs_hz', [1.0, 5.0])
def test_an_offset_of_the_clocks_is_found(late_s, motion, rs_hz, rng):
    ship = motion(rng, 1200.0)
    search, found = find_apart(*pair_of(rng, ship, ship, late_s, rs_hz=rs_hz), 600.0)
    assert search.searched_s == 600.0
    assert found.skew_s == pytest.approx(late_s, abs=0.5)
    assert found.also_s is None and 0.5 < found.agreement <= 1.0


@pytest.mark.slow
@pytest.mark.parametrize('motion', [
    turns, wander, *(pytest.param(motion, marks=pytest.mark.endurance)
                     for motion in (quiet, swell, tones, one_tone))])
def test_independent_motion_gives_no_offset(motion, rng):
    """Of 300 pairs each, half of one ship with true clocks, none has a skew."""
    for k in range(300):
        span_s = (700.0, 1200.0, 2700.0)[k % 3]
        ship = motion(rng, span_s)
        other = ship if k % 2 else motion(rng, span_s)
        assert find_apart(*pair_of(rng, ship, other, 0.0, span_s), 600.0)[1] is None


def test_two_turns_that_look_alike_are_no_evidence(rng):
    """Each sensor turns once, by the same angle, at times 200 s apart."""
    def turn(t_s):
        return np.clip(t_s - 500.0, 0.0, 60.0)
    assert find_apart(*pair_of(rng, turn, turn, 200.0), 600.0)[1] is None


def test_bags_of_two_loggers_may_overlap_in_part_or_not_at_all(rng):
    """The RS begins 500 s after the TS ends by its stamps, and 400 s before that in truth."""
    ship = swell(rng, 4000.0)
    t, u = times(900.0), times(900.0, 1.0, 1400.0)
    ts = track(t, ship(t + 900.0) + 0.1 * rng.standard_normal(t.size))
    rs = track(u, ship(u) + 0.05 * rng.standard_normal(u.size))
    assert find_apart(ts, rs, 500.0)[1] is None
    search, found = find_apart(ts, rs, 1200.0)
    assert search.searched_s == 1200.0
    assert found.skew_s == pytest.approx(-900.0, abs=0.2)


def test_gaps_and_a_step_of_a_heading_do_no_harm(rng):
    ship = swell(rng, 1800.0)
    ts, rs = pair_of(rng, ship, ship, 123.4, 1800.0)
    left = (ts.t_s < 300.0) | (ts.t_s > 420.0)
    ts = track(ts.t_s[left], ts.heading_deg[left] + 30.0 * (ts.t_s[left] > 1000.0))
    found = find_apart(ts, rs, 600.0)[1]
    assert found.skew_s == pytest.approx(123.4, abs=0.2)


def test_clocks_that_also_drift_agree_in_a_part(rng):
    """At 8 s an hour three hours smear two periods of the swell."""
    ship = swell(rng, 10_800.0)
    t = times(10_800.0)
    ts = track(t, ship(t - 120.0 - 8.0 * t / 3600.0) + 0.1 * rng.standard_normal(t.size))
    found = find_apart(ts, track(t, ship(t)), 600.0)[1]
    assert 120.0 < found.skew_s < 144.0


def test_the_agreement_is_that_of_a_plain_loop(rng):
    """Without slow motion, gaps or clipping: concordance at each lag over the common times."""
    t = times(400.0)
    a, b = (lfilter([1.0], [1.0, -0.5], rng.standard_normal(t.size)) for _ in range(2))
    search = ClockSearch(track(t, a), track(t, b), 100.0)
    mine, other = search._ts, search._rs
    for lag_s in (-80.0, 0.0, 65.5):
        at = round((lag_s + 100.0) / 0.5)
        there = round((100.0 - lag_s) / 0.5)
        x, y = mine.deg, other.deg[there:there + mine.deg.size]
        both = (mine.covered > 0.0) & (other.covered[there:there + mine.deg.size] > 0.0)
        x, y = x[both], y[both]
        plain = 2.0 * np.mean((x - x.mean()) * (y - y.mean())) / (x.var() + y.var())
        assert search._agreement[at] == pytest.approx(plain, abs=1e-9)


def test_sensors_without_motion_or_with_little_of_it_have_no_offset():
    t = times(1200.0)
    still = track(t, np.full(t.size, 7.0))
    assert find_apart(still, still, 600.0)[1] is None
    short = track(t[:100], np.sin(t[:100]))
    search, found = find_apart(short, short, 600.0)
    assert (search.searched_s, found) == (0.0, None)
