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

"""One sensor that repeats another is found; coarse and quiet ones are not."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.conditions.one_source import find_same_source
from heading_intercompare.core.statistics.resolution import find_resolution


def turning(n, rng, noise=0.1):
    rs = np.cumsum(rng.standard_normal(n)) % 360.0
    return rs, (rs + noise * rng.standard_normal(n)) % 360.0


# --- same source ---

def suspected(ts, rs, offset=0.0):
    return find_same_source(wrap180(ts - rs - offset), rs, find_resolution(ts),
                            find_resolution(rs)).suspected


@pytest.mark.parametrize('step', [None, 0.01, 0.1, 1.0])
def test_a_copy_is_suspected_whatever_its_step_and_mounting(step, rng):
    """One of 3000 readings may differ, from a thousand changes on; ten may not."""
    rs, _ = turning(3000, rng)
    rs = rs if step is None else np.round(rs / step) * step % 360.0
    assert suspected(rs, rs) is True
    assert suspected((rs + 90.0) % 360.0, rs) is True
    assert suspected((rs + 30.0) % 360.0, rs, 30.0) is True
    ts = rs.copy()
    ts[1500] += 1.0
    assert suspected(ts, rs) is True
    ts[1500:1510] += 2.0
    assert suspected(ts, rs) is False


def test_a_copy_alongside_shows_by_its_noise(rng):
    rs = np.round(30.0 + 0.05 * rng.standard_normal(3000), 1)
    assert suspected(rs.copy(), rs) is True
    assert suspected(np.round(30.0 + 0.05 * rng.standard_normal(3000), 1), rs) is False


@pytest.mark.parametrize('ts_step, rs_step, ts_noise, rs_noise', [
    (1.0, None, 0.1, 0.05), (1.0, 0.01, 0.1, 0.05), (1.0, 0.1, 0.1, 0.05), (1.0, 1.0, 0.03, 0.03),
    (0.5, 0.1, 0.05, 0.05), (0.1, 0.1, 0.02, 0.02), (0.1, 0.1, 0.01, 0.01), (1.0, 0.1, 0.0, 0.0)])
def test_coarse_quiet_sensors_are_two(ts_step, rs_step, ts_noise, rs_noise, rng):
    """Rounding alone makes the difference of two good sensors, and less where they round alike."""
    t = np.arange(12_000) / 10.0
    ship = 90.0 + 40.0 * np.sin(t / 100.0) + np.sin(2.0 * np.pi * t / 8.0)
    ts, rs = (h if step is None else np.round(h / step) * step for h, step in (
        (ship + ts_noise * rng.standard_normal(t.size), ts_step),
        (ship + rs_noise * rng.standard_normal(t.size), rs_step)))
    assert suspected(ts, rs) is False


def test_a_copy_rounded_again_is_no_smaller_than_two_good_sensors(rng):
    rs, _ = turning(3000, rng)
    rs = np.round(rs, 2) % 360.0
    ts = np.round(rs, 1) % 360.0
    found = find_same_source(wrap180(ts - rs), rs, find_resolution(ts), find_resolution(rs))
    assert found.suspected is False
    assert found.rounding_deg == pytest.approx(0.1 / np.sqrt(12.0), rel=0.01)
    assert found.std_deg == pytest.approx(found.rounding_deg, rel=0.05)


def test_two_good_sensors_are_not_suspected(rng):
    rs, ts = turning(3000, rng, noise=0.05)
    ts = np.round(ts, 1) % 360.0
    found = find_same_source(wrap180(ts - rs), rs, find_resolution(ts), find_resolution(rs))
    assert found.suspected is False


def test_too_few_changes_do_not_tell(rng):
    """A ship that keeps within a degree for long, and turns: both read the same whole degrees."""
    rs = np.round(np.repeat(np.arange(0.0, 200.0), 20))
    assert suspected(rs.copy(), rs) is None


@pytest.mark.parametrize('name', ['gyr1-s330', 'seap-s330', 'lgyr-lsep'])
def test_sensors_of_real_ships_are_not_suspected(name, real):
    pairs, x = real(name)
    assert find_same_source(x, pairs.rs_deg, find_resolution(pairs.ts_deg),
                            find_resolution(pairs.rs_deg)).suspected is False


def test_sensors_of_a_moored_ship_cannot_be_told():
    steady = np.full(100, 30.0)
    found = find_same_source(np.zeros(100), steady, find_resolution(steady),
                             find_resolution(steady))
    assert found.suspected is None
    assert find_same_source([], [], find_resolution([]), find_resolution([])).std_deg is None


# --- stamps ---
