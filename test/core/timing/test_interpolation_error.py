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

"""Interpolation error: its variance is found under the noise of both sensors."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.pairing.pairer import pair
from heading_intercompare.core.records import Headings
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.timing.interpolation_error import estimate_interpolation_error

RS_INTERPOLATED = Settings.from_mapping({'pairing': {'method': 'interpolate'}})

OMEGA = 2.0 * np.pi / 8.0


def stamps_of(t):
    return np.rint((t + 1000.0) * 1e9).astype(np.int64)


def judged(rng, *, rs_s, ts_s, size=1.0, period=8.0, noise=(0.0, 0.0), span=1800.0, known=True):
    """Return what is found, and the mean square of the true error of interpolation."""
    phase = rng.uniform(0.0, 6.0)

    def true(t):
        return 359.0 + size * np.sin(2.0 * np.pi * t / period + phase) + 5.0 * np.sin(t / 100.0)
    t_rs = np.arange(rng.uniform(0.0, rs_s), span, rs_s)
    t = np.arange(2.0 * rs_s + ts_s, span - 3.0 * rs_s, ts_s)
    rs = true(t_rs) + noise[1] * rng.standard_normal(t_rs.size)
    ts = true(t) + noise[0] * rng.standard_normal(t.size)
    pairs, _ = pair(Headings.as_sent(stamps_of(t), ts % 360.0),
                    Headings.as_sent(stamps_of(t_rs), rs % 360.0), RS_INTERPOLATED)
    found = estimate_interpolation_error(pairs.stamp_ns, pairs.rs_deg, pairs.ts_deg,
                                         pairs.rs_variance_factor, interval_s=rs_s if known
                                         else None)
    return found, float(np.mean((np.interp(t, t_rs, true(t_rs)) - true(t)) ** 2))


def test_slow_motion_by_hand(rng):
    """
    h^4/120 mean(r''^2): 2 deg in 40 s sampled once in 2 s, r'' = 2 (2 pi/40)^2 sin.

    16/120 * (2 * 0.02467)^2 / 2 = 1.62e-4; the slow swing of 5 deg in 628 s adds
    16/120 * (5e-4)^2 / 2 = 2e-8.
    """
    found, true = judged(rng, rs_s=2.0, ts_s=0.1, size=2.0, period=40.0, span=7200.0)
    assert (found.kind, found.method, found.folded) == ('estimated', 'brackets', False)
    assert true == pytest.approx(1.62e-4, rel=0.02)
    assert found.variance_deg2 == pytest.approx(true, rel=0.02)
    assert found.interval_s == 2.0


@pytest.mark.parametrize('rs_s, ts_s, method', [
    (2.0, 0.2, 'brackets'), (1.0, 0.2, 'brackets'), (1.0, 0.5, 'differences'),
    (1.0, 1.0, 'differences'), (2.0, 2.0, 'differences'), (0.7, 1.0, 'differences'),
    (1.0, 0.9, 'differences')])
def test_the_variance_is_that_of_the_true_error_at_any_rates(rs_s, ts_s, method, rng):
    """A swell of 8 s; within 15 % by one sine, and below the upper bound."""
    found, true = judged(rng, rs_s=rs_s, ts_s=ts_s, size=2.0, noise=(0.02, 0.02), span=3600.0)
    assert found.method == method
    assert found.variance_deg2 == pytest.approx(true, rel=0.15)
    assert true <= found.upper_deg2
    assert found.angle_rad == pytest.approx(2.0 * np.pi / 8.0 * rs_s, rel=0.1)


def test_it_is_found_under_the_noise_of_both(rng):
    """One deg in 8 s, an RS of 0.5 Hz: 0.0234 deg2 under a TS noise of 0.09 deg2."""
    inside = 0
    for _ in range(40):
        found, true = judged(rng, rs_s=2.0, ts_s=0.2, noise=(0.3, 0.1), span=1800.0)
        assert found.variance_deg2 == pytest.approx(true, rel=0.5)
        inside += true <= found.upper_deg2
    assert inside >= 34


def test_without_motion_there_is_next_to_nothing(rng):
    found, _ = judged(rng, rs_s=1.0, ts_s=0.2, size=0.0, noise=(0.1, 0.05), span=3600.0)
    assert found.variance_deg2 < 5e-4
    assert found.upper_deg2 < 2e-3


def test_motion_faster_than_the_readings_is_said_to_be(rng):
    """Once a second, a motion of 2.1 s."""
    found, _ = judged(rng, rs_s=1.0, ts_s=0.1, period=2.1, noise=(0.05, 0.05))
    assert found.folded


def test_brackets_tell_the_interval_and_fewer_pairs_do_not(rng):
    found, true = judged(rng, rs_s=1.0, ts_s=0.1, noise=(0.01, 0.01), known=False)
    assert found.interval_s == pytest.approx(1.0, rel=0.01)
    assert found.variance_deg2 == pytest.approx(true, rel=0.1)
    found, _ = judged(rng, rs_s=1.0, ts_s=0.7, known=False)
    assert found.kind == 'not_testable'


def test_readings_taken_as_they_are_have_no_error():
    found = estimate_interpolation_error(np.arange(9), np.zeros(9), np.zeros(9), np.ones(9))
    assert (found.kind, found.variance_deg2, found.upper_deg2) == ('none', 0.0, 0.0)


@pytest.mark.parametrize('n', [0, 1, 2, 63, 66])
def test_too_few_pairs_are_not_testable(n):
    t = np.arange(n) * 10 ** 9
    found = estimate_interpolation_error(t, np.zeros(n), np.zeros(n), np.full(n, 0.5),
                                         interval_s=1.0)
    assert found.kind == 'not_testable'


def test_turning_both_headings_changes_nothing(rng):
    t = np.arange(0.0, 900.0, 0.2)
    node = np.arange(-2.0, 905.0, 1.0) + 0.05
    other = 10.0 + 2.0 * np.sin(OMEGA * t)
    own = np.interp(t, node, 10.0 + 2.0 * np.sin(OMEGA * node))
    factor = np.full(t.size, 0.7)
    here, there = (estimate_interpolation_error(stamps_of(t), (own + turn) % 360.0,
                                                (other + turn) % 360.0,
                                                factor, interval_s=1.0) for turn in (0.0, 349.0))
    assert there.variance_deg2 == pytest.approx(here.variance_deg2, rel=1e-6)


@pytest.mark.parametrize('name, interval_s', [('gyr1-s330', 1.0), ('lgyr-lsep', 1.0),
                                              ('seap-s330', 1.0)])
def test_real_references_are_fast_enough(name, interval_s, real):
    """Between two good sensors, once a second in a sea, a fifth of the variance comes from it."""
    pairs, x = real(name)
    found = estimate_interpolation_error(pairs.stamp_ns, pairs.rs_deg, pairs.ts_deg,
                                         pairs.rs_variance_factor, interval_s=interval_s)
    assert found.kind == 'estimated' and not found.folded
    assert found.upper_deg2 < 0.3 * np.var(x)
