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

"""Clocks that drift apart are found, and a constant skew is not mistaken for a drift."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.pairing.difference import subtract
from heading_intercompare.core.pairing.pairer import pair
from heading_intercompare.core.records import Headings
from heading_intercompare.core.timing.clock_drift import estimate_clock_drift


def stamps_of(t):
    return np.rint((t + 1000.0) * 1e9).astype(np.int64)


def judged(rng, slope_s_per_h, skew_s=0.0, *, span=7200.0, ts_hz=5.0, rs_hz=5.0, size=1.0,
           turn=0.0, near_s=0.0):
    """Return what is found for a ship that yaws by some degrees, and the pairs."""
    period, phase = rng.uniform(6.0, 12.0, 6), rng.uniform(0.0, 6.0, 6)

    def heading(t):
        return 20.0 * np.sin(t / 300.0) + turn + sum(
            0.4 * size * np.sin(2.0 * np.pi * t / p + q) for p, q in zip(period, phase))
    t, t_rs = np.arange(0.0, span, 1.0 / ts_hz), np.arange(0.0, span, 1.0 / rs_hz) + 0.03
    ts = heading(t - skew_s - slope_s_per_h * t / 3600.0) + 0.1 * rng.standard_normal(t.size)
    rs = heading(t_rs) + 0.05 * rng.standard_normal(t_rs.size)
    pairs, _ = pair(Headings.as_sent(stamps_of(t), ts % 360.0),
                    Headings.as_sent(stamps_of(t_rs), rs % 360.0))
    return estimate_clock_drift(pairs.stamp_ns, subtract(pairs).x_deg, pairs.rs_deg,
                                near_s=near_s), pairs


@pytest.mark.parametrize('slope, skew, rs_hz', [
    (1.0, 0.0, 5.0), (1.0, 0.0, 1.0), (-1.0, 1.2, 5.0), (5.0, 0.0, 1.0), (5.0, -1.0, 5.0),
    (-5.0, 0.5, 5.0)])
def test_a_drift_is_found_with_its_slope(slope, skew, rs_hz, rng):
    """At 5 s per hour the skew passes a whole period of the swell in two hours."""
    found, _ = judged(rng, slope, skew, rs_hz=rs_hz)
    assert found.kind == 'drifting'
    assert found.slope_s_per_h == pytest.approx(slope, abs=0.02 + 6.0 * found.u_s_per_h)
    assert found.u_s_per_h < 0.1
    assert found.skew_s == pytest.approx(skew + slope, abs=0.1)


@pytest.mark.parametrize('slope', [0.5, 0.36, -0.36])
@pytest.mark.parametrize('skew_s', [120.0, -400.0])
def test_a_drift_is_found_between_clocks_that_lie_apart(slope, skew_s, rng):
    """0.36 s/h are 100 ppm; the skew is that of the middle of all pairs, after 1.5 h."""
    found, pairs = judged(rng, slope, skew_s, span=10_800.0, near_s=skew_s + 0.3)
    assert found.kind == 'drifting'
    assert found.slope_s_per_h == pytest.approx(slope, abs=0.02)
    assert found.skew_s == pytest.approx(skew_s + 1.5 * slope, abs=0.05)
    for part in found.parts:
        assert part.skew_s == pytest.approx(skew_s + slope * part.time_s / 3600.0, abs=0.1)
    t_s = (pairs.stamp_ns - pairs.stamp_ns[0]) / 1e9
    assert found.late_s(t_s)[[0, -1]] == pytest.approx([skew_s, skew_s + 3.0 * slope], abs=0.05)


def test_what_a_drift_adds_by_hand(rng):
    """1 s/h over 2 h: d from 0 to 2 s, Var(d) = 1/3 s2 times Var(rate)."""
    found, pairs = judged(rng, 1.0)
    rate = float(np.mean([p.rate_std_deg_s ** 2 for p in found.parts]))
    assert found.variance_deg2 == pytest.approx(rate / 3.0, rel=0.05)


@pytest.mark.slow
def test_a_constant_skew_does_not_drift(rng):
    """None of 60; the nominal risk is 0.05 %."""
    for k in range(60):
        found, _ = judged(rng, 0.0, rng.uniform(-1.5, 1.5), span=1800.0,
                          rs_hz=(1.0, 5.0)[k % 2], size=rng.choice([0.5, 2.0]))
        assert found.kind == 'steady'
        assert found.interval_s_per_h[0] < found.slope_s_per_h < found.interval_s_per_h[1]


@pytest.mark.slow
@pytest.mark.endurance
def test_the_interval_holds_the_slope(rng):
    """95 % of 200; six standard errors of that are 9 %."""
    inside = 0
    for _ in range(200):
        found, _ = judged(rng, 0.3, 0.2, span=1800.0)
        inside += found.interval_s_per_h[0] <= 0.3 <= found.interval_s_per_h[1]
    assert inside / 200 > 0.95 - 6.0 * np.sqrt(0.95 * 0.05 / 200)


def test_a_ship_that_does_not_turn_shows_no_clock(rng):
    t = np.arange(36_000) / 10.0
    rs = 30.0 + 0.05 * rng.standard_normal(t.size)
    ts = 30.0 + 0.05 * rng.standard_normal(t.size)
    assert estimate_clock_drift(stamps_of(t), wrap180(ts - rs), rs).kind == 'not_testable'


@pytest.mark.parametrize('name', ['gyr1-s330', 'seap-s330', 'lgyr-lsep'])
def test_real_clocks_keep_step(name, real):
    pairs, x = real(name)
    assert estimate_clock_drift(pairs.stamp_ns, x, pairs.rs_deg).kind != 'drifting'


@pytest.mark.parametrize('n', [0, 1, 2, 127, 300])
def test_short_runs_are_not_testable(n):
    found = estimate_clock_drift(np.arange(n) * 10 ** 8, np.zeros(n), np.arange(n) * 0.1)
    assert (found.kind, found.slope_s_per_h) == ('not_testable', None)


def test_turning_and_shifting_change_nothing(rng):
    _, pairs = judged(rng, 1.0, span=1800.0)
    x = subtract(pairs).x_deg
    here = estimate_clock_drift(pairs.stamp_ns, x, pairs.rs_deg)
    there = estimate_clock_drift(pairs.stamp_ns + 10 ** 15, x, (pairs.rs_deg + 200.0) % 360.0)
    assert there.slope_s_per_h == pytest.approx(here.slope_s_per_h, abs=1e-4)
    assert len(there.parts) == len(here.parts)


@pytest.mark.parametrize('steps', [[(900.0, 1.0)], [(1000.0, -5.0)], [(600.0, 5.0), (1300.0, 0.0)],
                                   [(800.0, 30.0)]])
def test_steps_of_a_clock_are_found_with_size_and_time(steps, rng):
    """Sizes to 20 ms, times to a few seconds: the yaw hides a step where both skews agree."""
    t = np.arange(0.0, 1800.0, 0.2)
    late = np.zeros(t.size)
    for at_s, level_s in steps:
        late[t >= at_s] = level_s

    def heading(at_s):
        return 40.0 * np.sin(at_s / 100.0) + np.sin(2.0 * np.pi * at_s / 8.0)
    rs = heading(t) + 0.05 * rng.standard_normal(t.size)
    found = estimate_clock_drift(stamps_of(t),
                                 heading(t - late) + 0.1 * rng.standard_normal(t.size) - rs,
                                 rs)
    assert found.kind == 'stepped' and len(found.steps) == len(steps)
    for step, (at_s, level_s) in zip(found.steps, steps):
        assert step.time_s == pytest.approx(at_s, abs=10.0)
        assert step.after_s == pytest.approx(level_s, abs=0.02)
    assert found.late_s(t)[0] == pytest.approx(0.0, abs=0.02)
    assert found.late_s(t)[-1] == pytest.approx(steps[-1][1], abs=0.02)
