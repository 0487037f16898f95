# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Detectors: each fault made and found, and real logs that only look faulty."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.angles import heading_from_quaternion, wrap180
from heading_intercompare.core.detectors import (
    convention,
    frozen,
    same_source,
    stamp_steps,
)
from heading_intercompare.core.resolution import resolution
from heading_intercompare.core.settings import Detectors, from_mapping, SettingsError
from heading_intercompare.drivers.logs import read_log


def turning(n, rng, noise=0.1):
    rs = np.cumsum(rng.standard_normal(n)) % 360.0
    return rs, (rs + noise * rng.standard_normal(n)) % 360.0


# --- convention ---

@pytest.mark.parametrize('offset', [90.0, -90.0, 180.0, -178.0, 84.0])
def test_a_right_angle_between_the_sensors_is_suspicious(offset, rng):
    rs, ts = turning(1000, rng)
    found = convention(wrap180(ts + offset - rs), rs)
    assert found.kind == 'offset'
    assert float(wrap180(found.angle_deg - offset)) == pytest.approx(0.0, abs=0.1)
    assert found.spread_deg == pytest.approx(0.1, rel=0.2)


@pytest.mark.parametrize('offset', [0.0, 5.0, -45.0, 79.0, 135.0])
def test_other_angles_may_be_installation_offsets(offset, rng):
    rs, ts = turning(1000, rng)
    assert convention(wrap180(ts + offset - rs), rs).kind == 'consistent'


def test_a_yaw_taken_for_a_heading_is_mirrored(rng):
    """An ENU yaw read as NED is 90 degrees less the heading."""
    rs, ts = turning(3000, rng)
    half = np.radians(90.0 - ts) / 2.0
    zero = np.zeros(ts.size)
    wrong = heading_from_quaternion(zero, zero, np.sin(half), np.cos(half), 'ned')
    found = convention(wrap180(wrong - rs), rs)
    assert found.kind == 'mirrored'
    assert found.angle_deg == pytest.approx(90.0, abs=0.1)


def test_a_mirrored_sensor_on_a_straight_course_cannot_be_told(rng):
    rs = 30.0 + 0.5 * rng.standard_normal(500)
    assert convention(wrap180(-rs - rs), rs).kind == 'consistent'


def test_an_erratic_sensor_is_not_called_mirrored(rng):
    rs, _ = turning(2000, rng)
    assert convention(rng.uniform(-180.0, 180.0, 2000), rs).kind == 'consistent'


def test_turning_the_ship_changes_nothing(rng):
    rs, ts = turning(500, rng)
    x = wrap180(ts + 90.0 - rs)
    a, b = convention(x, rs), convention(x, (rs + 123.0) % 360.0)
    assert (a.kind, a.angle_deg) == (b.kind, b.angle_deg)


def test_no_pairs_have_no_convention():
    found = convention([], [])
    assert (found.kind, found.angle_deg) == ('not_testable', None)


# --- same source ---

def test_a_copy_is_suspected_and_so_is_a_rounded_copy(rng):
    rs, _ = turning(3000, rng)
    rs = np.round(rs, 2) % 360.0
    ts = np.round(rs, 1) % 360.0
    for copy in (rs, ts):
        found = same_source(wrap180(copy - rs), rs, resolution(copy), resolution(rs))
        assert found.suspected is True
    assert found.rounding_deg == pytest.approx(0.1 / np.sqrt(12.0), rel=0.01)
    assert found.std_deg == pytest.approx(found.rounding_deg, rel=0.05)


def test_two_good_sensors_are_not_suspected(rng):
    rs, ts = turning(3000, rng, noise=0.05)
    ts = np.round(ts, 1) % 360.0
    found = same_source(wrap180(ts - rs), rs, resolution(ts), resolution(rs))
    assert found.suspected is False


@pytest.mark.parametrize('name', ['gyr1-s330', 'seap-s330', 'lgyr-lsep'])
def test_sensors_of_real_ships_are_not_suspected(name, real):
    pairs, x = real(name)
    assert same_source(x, pairs.rs_deg, resolution(pairs.ts_deg),
                       resolution(pairs.rs_deg)).suspected is False


def test_sensors_of_a_moored_ship_cannot_be_told():
    steady = np.full(100, 30.0)
    found = same_source(np.zeros(100), steady, resolution(steady), resolution(steady))
    assert found.suspected is None
    assert same_source([], [], resolution([]), resolution([])).std_deg is None


# --- frozen ---

def test_a_frozen_stretch_by_hand():
    """TS stands from the third to the ninth second while RS turns from 3 to 9 degrees."""
    stamps = np.arange(12) * 10 ** 9
    rs = np.arange(12.0)
    ts = np.where((rs >= 3) & (rs <= 9), 3.0, rs)
    found = frozen(stamps, ts, rs)
    assert (found.longest_s, found.stretches, found.start_ns) == (6.0, 1, 3 * 10 ** 9)
    assert (found.duration_s, found.other_moved_deg) == (6.0, 6.0)
    assert frozen(stamps, rs, ts).stretches == 0


def test_the_worst_of_several_stretches_is_shown(rng):
    stamps = np.arange(3000) * 10 ** 8
    rs = 350.0 + 20.0 * np.sin(np.arange(3000) / 200.0)
    ts = rs + 0.01 * rng.standard_normal(3000)
    ts[100:200] = ts[100]
    ts[1200:1300] = ts[1200]
    found = frozen(stamps, ts % 360.0, rs % 360.0)
    moved = [np.ptp(rs[lo:lo + 100]) for lo in (100, 1200)]
    assert found.stretches == 2
    assert found.other_moved_deg == pytest.approx(max(moved))
    assert found.start_ns == stamps[(100, 1200)[int(np.argmax(moved))]]


def test_a_coarse_sensor_on_a_steady_course_is_not_frozen(real):
    """The gyro of the Gould, in steps of 0.1 deg, repeats values for six seconds."""
    pairs, _ = real('lgyr-lsep')
    found = frozen(pairs.stamp_ns, pairs.ts_deg, pairs.rs_deg)
    assert found.longest_s > 5.0
    assert (found.stretches, found.start_ns) == (0, None)


def test_a_sensor_frozen_at_north_is_found():
    stamps = np.arange(20) * 10 ** 9
    north = np.where(np.arange(20) % 2, 360.0, 0.0)
    assert frozen(stamps, north, np.arange(20.0)).stretches == 1


@pytest.mark.parametrize('n', [0, 1, 2, 3])
def test_too_few_readings_are_not_frozen(n):
    assert frozen(np.arange(n), np.zeros(n), np.zeros(n)).stretches == 0


# --- stamps ---

def test_steps_of_stamps_by_hand():
    found = stamp_steps(np.array([0, 1, 2, 2, 3, 1, 2, 3, 60]) * 10 ** 9)
    assert (found.n, found.typical_s) == (9, 1.0)
    assert (found.backward, found.equal, found.silences) == (1, 1, 1)
    assert (found.longest_back_s, found.longest_s) == (2.0, 57.0)


def test_clock_steps_of_a_replayed_log_are_seen(shared_data):
    """The lines of nbp1700_replay: one step of -0.93 s and one jump of an hour, at least."""
    path = next((shared_data / 'nbp1700_replay').glob('*gyr1*'))
    found = stamp_steps(read_log(path)[0].stamp_ns)
    assert found.backward >= 1
    assert found.longest_back_s == pytest.approx(0.93, abs=0.3)
    assert found.longest_s == pytest.approx(3600.0, abs=2.0)


@pytest.mark.parametrize('n', [0, 1])
def test_too_few_stamps_have_no_steps(n):
    found = stamp_steps(np.arange(n))
    assert (found.n, found.typical_s, found.silences) == (n, None, 0)


def test_equal_stamps_are_no_silence():
    found = stamp_steps([5, 5, 5, 100])
    assert (found.equal, found.silences) == (2, 0)


def test_settings_of_the_detectors_are_checked():
    assert from_mapping(Detectors, {'frozen_s': 3}).frozen_s == 3.0
    with pytest.raises(SettingsError, match='same_source_ratio = 0.5'):
        Detectors(same_source_ratio=0.5)
