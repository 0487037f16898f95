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

"""Conventions and the mean difference: every mistake is found, and the seam of the wrap."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.angles import circular_mean, heading_from_quaternion, wrap180
from heading_intercompare.core.conditions.conventions import (
    estimate_mean_difference,
    find_convention,
)


def turning(n, rng, noise=0.1):
    rs = np.cumsum(rng.standard_normal(n)) % 360.0
    return rs, (rs + noise * rng.standard_normal(n)) % 360.0


@pytest.mark.parametrize('offset', [90.0, -90.0, 180.0, -178.0, 84.0])
def test_a_right_angle_between_the_sensors_is_suspicious(offset, rng):
    rs, ts = turning(1000, rng)
    found = find_convention(wrap180(ts + offset - rs), rs)
    assert found.kind == 'offset'
    assert float(wrap180(found.angle_deg - offset)) == pytest.approx(0.0, abs=0.1)
    assert found.spread_deg == pytest.approx(0.1, rel=0.2)


@pytest.mark.parametrize('offset', [0.0, 5.0, -45.0, 79.0, 135.0])
def test_other_angles_may_be_installation_offsets(offset, rng):
    rs, ts = turning(1000, rng)
    assert find_convention(wrap180(ts + offset - rs), rs).kind == 'consistent'


def test_a_yaw_taken_for_a_heading_is_mirrored(rng):
    """An ENU yaw read as NED is 90 degrees minus the heading."""
    rs, ts = turning(3000, rng)
    half = np.radians(90.0 - ts) / 2.0
    zero = np.zeros(ts.size)
    wrong = heading_from_quaternion(zero, zero, np.sin(half), np.cos(half), 'ned')
    found = find_convention(wrap180(wrong - rs), rs)
    assert found.kind == 'mirrored'
    assert found.angle_deg == pytest.approx(90.0, abs=0.1)


def test_a_mirrored_sensor_on_a_straight_course_cannot_be_told(rng):
    """Each sensor shows its own noise, and no motion."""
    noise = 0.5 * rng.standard_normal((2, 500))
    assert find_convention(wrap180(-60.0 - noise[0] - noise[1]),
                           30.0 + noise[1]).kind == 'consistent'


def test_an_erratic_sensor_is_not_called_mirrored(rng):
    rs, _ = turning(2000, rng)
    assert find_convention(rng.uniform(-180.0, 180.0, 2000), rs).kind == 'consistent'


def test_turning_the_ship_changes_nothing(rng):
    rs, ts = turning(500, rng)
    x = wrap180(ts + 90.0 - rs)
    a, b = find_convention(x, rs), find_convention(x, (rs + 123.0) % 360.0)
    assert (a.kind, a.angle_deg) == (b.kind, b.angle_deg)


def test_no_pairs_have_no_convention():
    found = find_convention([], [])
    assert (found.kind, found.angle_deg) == ('not_testable', None)


def test_the_balance_by_hand():
    """RS 0, 2, ..., 14, TS = 90 - RS: x changes by -4 a step, x + 2 RS by 0: balance 0."""
    rs = 2.0 * np.arange(8)
    found = find_convention(90.0 - 2.0 * rs, rs)
    assert (found.kind, found.angle_deg, found.balance) == ('mirrored', 90.0, 0.0)
    assert (found.direction, found.turned_deg) == ('against', 14.0)


@pytest.mark.parametrize('offset', [180.0, -180.0, 179.95, -179.9])
def test_scatter_at_the_seam_of_the_wrap_is_a_half_turn(offset, rng):
    """Half of the differences are near 180, half near -180; their plain mean is near zero."""
    rs, ts = turning(4000, rng, noise=1.0)
    x = wrap180(ts + offset - rs)
    assert abs(x.mean()) < 20.0
    assert find_convention(x, rs).kind == 'offset'
    assert abs(wrap180(estimate_mean_difference(x).mean_deg - offset)) < 0.1


@pytest.mark.parametrize('turn_deg', [-90.0, 20.0, 10.0])
@pytest.mark.parametrize('back', [False, True])
def test_a_short_turn_tells_a_mirrored_sensor(turn_deg, back, rng):
    """Ten seconds of turning in two hours at 10 Hz, with errors of 0.2 deg and swell."""
    t = np.arange(72_000) / 10.0
    turn = turn_deg * (np.clip((t - 4000.0) / 10.0, 0.0, 1.0)
                       - back * np.clip((t - 4040.0) / 10.0, 0.0, 1.0))
    heading = 350.0 + turn + 0.5 * np.sin(2.0 * np.pi * t / 8.0)
    rs = (heading + 0.2 * rng.standard_normal(t.size)) % 360.0
    ts = heading + 0.2 * rng.standard_normal(t.size)
    stamps = np.rint(t * 1e9).astype(np.int64)
    found = find_convention(wrap180(-ts - rs), rs, stamp_ns=stamps)
    assert (found.kind, found.direction) == ('mirrored', 'against')
    assert abs(wrap180(found.angle_deg)) < 0.1
    found = find_convention(wrap180(ts - rs), rs, stamp_ns=stamps)
    assert (found.kind, found.direction) == ('consistent', 'with')


def test_without_a_turn_the_direction_is_not_testable(rng):
    rs = 30.0 + 0.3 * rng.standard_normal(500)
    found = find_convention(0.3 * rng.standard_normal(500), rs)
    assert (found.direction, found.turned_deg, found.balance) == ('not_testable', 0.0, None)


def test_noise_is_no_direction(rng):
    """An RS that scatters by many degrees on its own turns neither with TS nor against it."""
    rs = 180.0 + 3.0 * rng.standard_normal(4000)
    ts = 180.0 + 3.0 * rng.standard_normal(4000)
    found = find_convention(wrap180(ts - rs), rs)
    assert (found.kind, found.direction) == ('consistent', 'not_testable')
    assert 0.5 < found.balance < 2.0


@pytest.mark.parametrize('name', ['gyr1-s330', 's330-seap', 'lgyr-lsep', 'lsep-lgyr'])
def test_real_sensors_are_consistent_until_one_is_turned_or_mirrored(name, real):
    pairs, x = real(name)
    assert find_convention(x, pairs.rs_deg).kind == 'consistent'
    assert find_convention(wrap180(x + 90.0), pairs.rs_deg).kind == 'offset'
    mirrored = wrap180(90.0 - pairs.ts_deg - pairs.rs_deg)
    assert find_convention(mirrored, pairs.rs_deg).direction == 'against'


# --- mean difference ---

def test_the_mean_by_hand():
    """15, 16, 17, 18 four times: mean 16.5, blocks of one: u = sqrt(var/n) = sqrt(4/3/16)."""
    found = estimate_mean_difference([15.0, 16.0, 17.0, 18.0] * 4)
    assert (found.n, found.mean_deg) == (16, pytest.approx(16.5))
    assert found.u_deg == pytest.approx(np.sqrt(4.0 / 3.0 / 16.0))
    assert found.interval_deg == pytest.approx((16.5 - 2.1314 * found.u_deg,
                                                16.5 + 2.1314 * found.u_deg), abs=1e-3)
    assert found.surely_exceeds(15.0) and not found.surely_exceeds(16.4)


def test_the_interval_holds_the_mean_of_correlated_errors(ar1):
    """95 % of 400 runs; six standard errors of that share are 6.5 %."""
    inside = 0
    for _ in range(400):
        low, high = estimate_mean_difference(5.0 + ar1(4000, 10.0)).interval_deg
        inside += low <= 5.0 <= high
    assert abs(inside / 400 - 0.95) < 6.0 * np.sqrt(0.95 * 0.05 / 400)


def test_a_turned_sensor_has_a_turned_mean(rng):
    x = rng.standard_normal(5000)
    plain, turned = estimate_mean_difference(x), estimate_mean_difference(wrap180(x + 179.0))
    assert float(wrap180(turned.mean_deg - plain.mean_deg - 179.0)) == pytest.approx(0.0, abs=1e-9)
    assert turned.u_deg == pytest.approx(plain.u_deg)
    assert plain.mean_deg == pytest.approx(x.mean())
    assert plain.resultant == pytest.approx(circular_mean(x)[1])


def test_too_few_differences_have_a_mean_without_an_interval():
    assert estimate_mean_difference([]) == estimate_mean_difference(np.empty(0))
    assert estimate_mean_difference([]).mean_deg is None
    found = estimate_mean_difference([100.0] * 15)
    assert (found.mean_deg, found.u_deg) == (pytest.approx(100.0), None)
    assert not found.surely_exceeds(15.0)


def test_the_share_beyond_the_seam_by_hand():
    """179 three times and -179 once, about 180: one of four is a whole turn away."""
    found = estimate_mean_difference([179.0, 179.0, -179.0, 179.0])
    assert found.seam_share == 0.25
    assert found.is_torn(0.0) and not found.is_torn(180.0)
    assert estimate_mean_difference([1.0, 359.0]).is_torn(180.0)
    assert estimate_mean_difference([270.0, 271.0, 269.0]).seam_share == 0.0
    assert not estimate_mean_difference([]).is_torn(0.0)


def test_wild_readings_are_not_the_seam(rng):
    """A sensor near zero, with one random reading in fifty."""
    x = np.where(rng.random(5000) < 0.02, rng.uniform(-180.0, 180.0, 5000), 0.0)
    assert not estimate_mean_difference(x).is_torn(0.0)
