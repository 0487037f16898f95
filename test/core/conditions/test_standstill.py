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

"""Frozen, dead and moored sensors, and sensors that only look so."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.conditions.standstill import (
    find_coarse_resolution,
    find_frozen,
    find_standstill,
)

HOUR = 36_000


def ship(t, rng, course_deg=100.0):
    """Return a heading with swell and a slow wander, degrees."""
    heading = course_deg + 0.5 * np.sin(2.0 * np.pi * t / rng.uniform(100.0, 600.0))
    for _ in range(4):
        heading += 0.3 * np.sin(2.0 * np.pi * t / rng.uniform(6.0, 12.0) + rng.uniform(0.0, 6.0))
    return heading


def stamps_of(t):
    return np.rint(t * 1e9).astype(np.int64)


def test_a_frozen_stretch_by_hand():
    """
    TS stands from the 30th to the 60th second while RS turns on, a degree a second.

    Two seconds and a hold of one at either end leave 33 to 57 s, where RS turns by 24 degrees
    in readings, and by 23 in the means of 24 parts of one or two readings (33, ..., 56.5). TS
    reports whole degrees: two of them are allowed, and the differences elsewhere are zero.
    """
    stamps = np.arange(120) * 10 ** 9
    rs = np.arange(120.0)
    ts = np.where((rs >= 30) & (rs <= 60), 30.0, rs)
    found = find_frozen(stamps, ts, rs)
    assert (found.kind, found.longest_s, found.stretches) == ('frozen', 30.0, 1)
    assert (found.start_ns, found.duration_s, found.frozen_s) == (30 * 10 ** 9, 30.0, 30.0)
    assert found.other_moved_deg == pytest.approx(23.5)
    assert (found.resolution_deg, found.hold_s) == (pytest.approx(1.0), 1.0)
    assert found.allowed_deg == pytest.approx(3.0)
    assert find_frozen(stamps, rs, ts).kind == 'alive'


def test_the_worst_of_several_stretches_is_shown(rng):
    stamps = np.arange(3000) * 10 ** 8
    rs = 350.0 + 20.0 * np.sin(np.arange(3000) / 200.0)
    ts = rs + 0.01 * rng.standard_normal(3000)
    ts[100:200] = ts[100]
    ts[1200:1300] = ts[1200]
    found = find_frozen(stamps, ts % 360.0, rs % 360.0)
    moved = [np.ptp(rs[lo:lo + 100]) for lo in (100, 1200)]
    assert found.stretches == 2
    assert 0.4 * max(moved) < found.other_moved_deg < max(moved)
    assert found.start_ns == stamps[(100, 1200)[int(np.argmax(moved))]]
    assert found.frozen_s == pytest.approx(2 * 9.9)


def test_a_coarse_sensor_on_a_steady_course_is_not_frozen(real):
    """The gyro of the Gould, in steps of 0.1 deg, repeats values for six seconds."""
    pairs, _ = real('lgyr-lsep')
    found = find_frozen(pairs.stamp_ns, pairs.ts_deg, pairs.rs_deg)
    assert found.longest_s > 5.0
    assert (found.stretches, found.start_ns) == (0, None)


def test_a_sensor_frozen_at_north_is_found():
    stamps = np.arange(20) * 10 ** 9
    north = np.where(np.arange(20) % 2, 360.0, 0.0)
    assert find_frozen(stamps, north, np.arange(20.0)).stretches == 1
    assert find_standstill(north, north).kind == 'still'


@pytest.mark.parametrize('n', [0, 1, 2, 3])
def test_too_few_readings_are_not_frozen(n):
    assert find_frozen(np.arange(n), np.zeros(n), np.zeros(n)).stretches == 0


@pytest.mark.parametrize('name', ['gyr1-s330', 's330-gyr1', 'seap-s330', 'gyr1-seap',
                                  'lgyr-lsep', 'lsep-lgyr', 'adcp-gyr1', 'gyr1-adcp'])
def test_no_real_sensor_is_frozen_dead_or_still(name, real):
    """Even if no motion of the other is allowed: the steps of both still count."""
    pairs, _ = real(name)
    for one, other in ((pairs.ts_deg, pairs.rs_deg), (pairs.rs_deg, pairs.ts_deg)):
        found = find_frozen(pairs.stamp_ns, one, other, moved_deg=0.0)
        assert (found.kind, found.stretches) == ('alive', 0)
    assert find_standstill(pairs.ts_deg, pairs.rs_deg).kind == 'moving'


@pytest.mark.parametrize('name, lasted', [('gyr1-s330', 60), ('lgyr-lsep', 120)])
def test_a_real_sensor_that_stops_is_found(name, lasted, real):
    pairs, _ = real(name)
    ts = pairs.ts_deg.copy()
    first = np.searchsorted(pairs.stamp_ns, pairs.stamp_ns[0] + 200 * 10 ** 9)
    last = np.searchsorted(pairs.stamp_ns, pairs.stamp_ns[first] + lasted * 10 ** 9)
    ts[first:last] = ts[first]
    assert find_frozen(pairs.stamp_ns, ts, pairs.rs_deg).kind == 'frozen'


@pytest.mark.parametrize('rate, step, held, skew', [
    (10, 0.1, 1, 0.0), (10, 0.1, 10, 0.0), (10, 0.01, 10, 1.2), (5, 0.5, 1, -1.5),
    (1, 1.0, 1, 2.0), (10, 1.0, 1, 0.5), (1, 0.1, 5, 0.0)])
def test_coarse_slow_and_late_sensors_are_alive(rate, step, held, skew, rng):
    """Ten runs each with turns: values held for a second or five, steps up to a degree."""
    t = np.arange(0, 1800, 1.0 / rate)
    fine = np.arange(-10.0, 1810.0, 0.05)
    for _ in range(10):
        heading = ship(fine, rng)
        for _ in range(4):
            heading += 60.0 * np.clip((fine - rng.uniform(0.0, 1800.0)) * rng.choice([0.1, 3.0])
                                      / 60.0, 0.0, 1.0)
        seen = t[np.arange(t.size) // held * held] - skew
        ts = np.interp(seen, fine, heading) + 0.03 * rng.standard_normal(t.size // held + 1)[
            np.arange(t.size) // held]
        rs = np.interp(t, fine, heading) + 0.05 * rng.standard_normal(t.size)
        ts = np.round(ts / step) * step
        for one, other in ((ts, rs), (rs, ts)):
            found = find_frozen(stamps_of(t), one % 360.0, other % 360.0, moved_deg=0.0)
            assert found.kind == 'alive', found


def test_a_skew_does_not_hide_a_sensor_that_stops_in_a_seaway(rng):
    """The differences range as much as the headings do; a minute without a change stands out."""
    t = np.arange(18_000) / 10.0
    phase = 2.0 * np.pi * t / 8.0
    rs = 50.0 + np.sin(phase) + 0.02 * rng.standard_normal(t.size)
    ts = np.round(50.0 + np.sin(phase - 1.6), 1)
    assert find_frozen(stamps_of(t), ts, rs).kind == 'alive'
    ts[9000:9600] = ts[9000]
    found = find_frozen(stamps_of(t), ts, rs)
    assert (found.kind, found.stretches) == ('frozen', 1)
    assert found.start_ns == pytest.approx(900 * 10 ** 9, abs=10 ** 9)


def test_an_hour_of_one_value_is_dead_though_the_ship_lies_alongside(rng):
    t = np.arange(HOUR + 1) / 10.0
    rs = np.round(123.44 + 0.02 * rng.standard_normal(t.size), 2)
    dead = np.full(t.size, 123.4)
    found = find_frozen(stamps_of(t), dead, rs)
    assert (found.kind, found.longest_s, found.resolution_deg) == ('dead', 3600.0, 0.1)
    assert (found.stretches, found.hold_s) == (0, None)
    # 36 000 readings of a tenth of a second are an hour, 35 999 are none.
    assert find_frozen(stamps_of(t)[:-1], dead[:-1], rs[:-1]).kind == 'dead'
    assert find_frozen(stamps_of(t)[:-2], dead[:-2], rs[:-2]).kind == 'constant'


def test_whole_degrees_may_stand_for_an_hour(rng):
    t = np.arange(HOUR + 1) / 10.0
    rs = np.round(123.04 + 0.02 * rng.standard_normal(t.size), 2)
    assert find_frozen(stamps_of(t), np.full(t.size, 123.0), rs).kind == 'alive'


def test_a_constant_sensor_is_frozen_in_a_run_of_minutes_under_way(rng):
    """Nothing else in the run shows the errors: the norm of the other sensor bounds them."""
    t = np.arange(6000) / 10.0
    rs = ship(t, rng) + 0.02 * rng.standard_normal(t.size)
    constant = np.full(t.size, 123.4)
    assert find_frozen(stamps_of(t), constant, rs).kind == 'frozen'
    assert find_frozen(stamps_of(t), constant, rs, sigma_deg=0.1).kind == 'frozen'
    assert find_frozen(stamps_of(t), constant, rs, sigma_deg=1.0).kind == 'constant'


@pytest.mark.parametrize('run_s, yaw_deg', [(3590, 0.3), (1200, 0.5), (3600, 0.3)])
def test_a_constant_sensor_of_a_ship_that_yaws_is_frozen(run_s, yaw_deg, rng):
    """Means of more than a second would average the yaw away; the norm of the RS is 0.1 deg."""
    t = np.arange(1, run_s * 10 + 1) / 10.0
    rs = 45.3 + yaw_deg * np.sin(2.0 * np.pi * t / 8.0) + 0.05 * rng.standard_normal(t.size)
    found = find_frozen(stamps_of(t), np.full(t.size, 45.3), rs, moved_deg=0.0, sigma_deg=0.1)
    assert (found.kind, found.stretches) == ('dead' if run_s == 3600 else 'frozen', 1)


@pytest.mark.parametrize('run_s', [1200, 3500])
def test_a_constant_sensor_alongside_is_told_from_one_that_works(run_s, rng):
    """The noise of the RS is no motion: a range within two steps of the TS shows nothing."""
    t = np.arange(1, run_s * 10 + 1) / 10.0
    rs = 90.1 + 0.02 * np.sin(t / 50.0) + 0.05 * rng.standard_normal(t.size)
    stamps = stamps_of(t)
    works = np.round(rs + 0.05 * rng.standard_normal(t.size), 1)
    for ts, kind in ((np.full(t.size, 90.1), 'constant'), (np.full(t.size, 90.0), 'alive'),
                     (np.full(t.size, 90.0 + 1.0 / 3.0), 'constant'), (works, 'alive')):
        assert find_frozen(stamps, ts, rs, moved_deg=0.0, sigma_deg=0.1).kind == kind


@pytest.mark.parametrize('share', [0.1, 0.33, 0.45, 0.6, 0.85])
def test_a_sensor_that_stops_for_a_large_part_of_a_run_is_frozen(share, rng):
    """No window of that length is left: shorter ones decide."""
    t = np.arange(1, 36_001) / 10.0
    yaw = 45.3 + 0.3 * np.sin(2.0 * np.pi * t / 8.0)
    ts = np.round(yaw + 0.1 * rng.standard_normal(t.size), 3)
    rs = yaw + 0.05 * rng.standard_normal(t.size)
    assert find_frozen(stamps_of(t), ts, rs, moved_deg=0.0, sigma_deg=0.1).kind == 'alive'
    first = t.size - round(share * t.size)
    ts[first:] = ts[first]
    found = find_frozen(stamps_of(t), ts, rs, moved_deg=0.0, sigma_deg=0.1)
    assert (found.kind, found.start_ns) == ('frozen', stamps_of(t)[first])


def test_a_slow_turn_shows_a_long_stop(rng):
    """Thirty degrees in 10 min: hardly a step in the short windows that remain."""
    t = np.arange(1, 12_001) / 10.0
    rs = 45.3 + 30.0 * np.clip((t - 300.0) / 600.0, 0.0, 1.0) + 0.05 * rng.standard_normal(t.size)
    ts = np.round(rs + 0.05 * rng.standard_normal(t.size))
    ts[2000:] = ts[2000]
    assert find_frozen(stamps_of(t), ts, rs, moved_deg=0.0, sigma_deg=0.1).kind == 'frozen'


def test_two_sensors_alongside_show_nothing(rng):
    t = np.arange(HOUR + 1) / 10.0
    rs = np.full(t.size, 10.01)
    rs[rng.integers(0, t.size, 100)] = 10.02
    ts = np.full(t.size, 10.2)
    found = find_standstill(ts, rs)
    assert (found.kind, found.ts_range_deg) == ('still', 0.0)
    assert (found.ts_step_deg, found.rs_step_deg) == (0.1, pytest.approx(0.01))
    assert find_frozen(stamps_of(t), ts, rs).kind == 'alive'
    assert find_standstill(ts, rs + 0.02 * rng.standard_normal(t.size)).kind == 'moving'
    assert find_standstill(ts, ship(t, rng)).kind == 'moving'


def test_an_interpolated_standstill_is_one():
    """Between 10.0 and 10.1 the interpolated RS takes values that it never reported."""
    rs = np.interp(np.arange(4000) / 10.0, [0.0, 100.03, 101.0, 200.0, 201.0, 400.0],
                   [10.0, 10.0, 10.1, 10.1, 10.0, 10.0])
    assert find_coarse_resolution(rs) == 0.1
    assert find_standstill(np.full(4000, 10.3), rs).kind == 'still'


@pytest.mark.parametrize('values, step', [
    ([123.4] * 5, 0.1), ([123.0] * 5, 1.0), ([0.24, 0.24], 0.01), ([1.0 / 3.0] * 9, None),
    ([], None), ([90.5] * 5, 0.5), ([90.5] * 5 + [91.0] * 5 + [90.5] * 5 + [91.5] * 5, 0.5),
    ([90.5] * 5 + [90.6] * 5 + [90.5] * 5 + [90.4] * 5, 0.1)])
def test_decimals_tell_the_step_of_a_constant(values, step):
    assert find_coarse_resolution(values) == step


def test_turning_both_headings_and_shifting_the_time_change_nothing(rng):
    t = np.arange(9000) / 10.0
    rs = ship(t, rng, 0.0)
    ts = np.round(rs, 1)
    ts[3000:3600] = ts[3000]
    here = find_frozen(stamps_of(t), ts % 360.0, rs % 360.0)
    there = find_frozen(stamps_of(t) + 10 ** 18, (ts + 170.0) % 360.0, (rs + 170.0) % 360.0)
    assert (here.kind, here.stretches) == (there.kind, there.stretches) == ('frozen', 1)
    assert here.other_moved_deg == pytest.approx(there.other_moved_deg)
    assert there.start_ns == here.start_ns + 10 ** 18
