# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Detectors: each fault made and found, and real logs that only look faulty."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.detectors import same_source, stamp_steps
from heading_intercompare.core.resolution import resolution
from heading_intercompare.core.settings import Detectors, from_mapping, SettingsError
from heading_intercompare.drivers.logs import read_log


def turning(n, rng, noise=0.1):
    rs = np.cumsum(rng.standard_normal(n)) % 360.0
    return rs, (rs + noise * rng.standard_normal(n)) % 360.0


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


def test_the_step_of_a_sensor_shows_although_most_readings_are_missing(rng):
    """Two of five kept: the median step is 0.2 s, that of the sensor 0.1 s."""
    stamps = np.flatnonzero(rng.random(10_000) < 0.4) * 10 ** 8
    found = stamp_steps(stamps)
    assert (found.typical_s, found.nominal_s) == (0.2, 0.1)


def test_steps_without_a_common_measure_have_none(rng):
    assert stamp_steps(np.cumsum(1 + rng.integers(0, 10 ** 9, 10_000))).nominal_s is None


def test_the_step_of_a_sensor_survives_jitter(rng):
    stamps = np.arange(5000) * 10 ** 8 + rng.integers(-10 ** 6, 10 ** 6, 5000)
    assert stamp_steps(stamps).nominal_s == pytest.approx(0.1, rel=0.02)
