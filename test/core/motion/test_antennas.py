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

"""Headings of two antennas, by hand and on a ship that moves."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.motion.antennas import find_baseline_headings
from heading_intercompare.core.motion.tangent_plane import radii_m
from heading_intercompare.core.records import Motion
from heading_intercompare.core.settings import Antennas, Settings

S = 10 ** 9
N = 600
STAMPS = 10 ** 18 + np.arange(N) * S


def placed(east_m, north_m, stamps=STAMPS, latitude=54.0, longitude=179.9999):
    """Return positions at metres east and north of a point by the date line."""
    meridian, normal = radii_m(latitude)
    return Motion.of_positions(
        stamps, latitude + np.degrees(north_m / meridian),
        (longitude + np.degrees(east_m / normal / math.cos(math.radians(latitude))) + 180.0)
        % 360.0 - 180.0)


def antennas(heading_deg, length_m=12.0, angle_deg=0.0, sigma_m=0.0, rng=None, stamps=STAMPS,
             late_s=0.0):
    """Return the positions of a fore and an aft antenna on a ship that sails north-east."""
    t = (stamps - stamps[0]) / S
    east, north = 3.0 * t, 4.0 * t
    baseline = np.radians(heading_deg - angle_deg)
    noise = np.zeros((4, t.size)) if rng is None else sigma_m * rng.standard_normal((4, t.size))
    fore = placed(east + length_m * np.sin(baseline) + noise[0],
                  north + length_m * np.cos(baseline) + noise[1], stamps)
    aft = placed(east + noise[2] + 3.0 * late_s, north + noise[3] + 4.0 * late_s,
                 stamps + round(late_s * S))
    return fore, aft


@pytest.mark.parametrize('angle', [0.0, 90.0, -90.0, 180.0, 3.5])
def test_the_heading_is_the_azimuth_plus_the_mounting_angle(angle):
    heading = np.linspace(0.0, 350.0, N)
    fore, aft = antennas(heading, angle_deg=angle)
    found = find_baseline_headings(fore, aft, Antennas(baseline_angle_deg=angle))
    assert np.abs(wrap180(found.headings.heading_deg - heading)).max() < 0.02
    assert found.length_m == pytest.approx(12.0, abs=0.003)
    assert found.rejected == {'no_partner': 0, 'wrong_baseline': 0}


def test_a_baseline_to_the_east_by_hand():
    """1 m east of each other at the equator: longitudes 1 / 6378137 rad apart."""
    step = math.degrees(1.0 / 6378137.0)
    fore = Motion.of_positions([S * 10 ** 9], [0.0], [5.0 + step])
    aft = Motion.of_positions([S * 10 ** 9], [0.0], [5.0])
    found = find_baseline_headings(fore, aft, Antennas())
    assert found.headings.heading_deg == pytest.approx([90.0])
    assert found.length_m == pytest.approx(1.0, rel=1e-6) and found.scatter_m is None


@pytest.mark.parametrize('late_s', [0.0, 0.3, -0.4])
def test_the_aft_antenna_is_interpolated(late_s):
    """Without it the way of 0.3 s at 5 m/s would turn a baseline of 12 m by up to 7 deg."""
    fore, aft = antennas(np.full(N, 100.0), late_s=late_s)
    found = find_baseline_headings(fore, aft, Antennas())
    assert np.abs(wrap180(found.headings.heading_deg - 100.0)).max() < 0.02
    assert len(found.headings) == N - (late_s != 0.0)


@pytest.mark.parametrize('length, sigma', [(2.0, 0.01), (10.0, 0.02), (40.0, 0.5)])
def test_the_uncertainty_is_that_of_the_headings(rng, length, sigma):
    """The scatter of the headings is sqrt(2) s / L, to six standard errors of 600 values."""
    fore, aft = antennas(np.full(N, 200.0), length, sigma_m=sigma, rng=rng)
    found = find_baseline_headings(fore, aft, Antennas(baseline_m=length, tolerance_m=100.0))
    expected = math.degrees(math.sqrt(2.0) * sigma / length)
    assert np.std(found.headings.heading_deg - 200.0) == pytest.approx(expected, rel=0.18)
    assert found.sigma_deg == pytest.approx(expected, rel=0.3)
    stated = find_baseline_headings(fore, aft, Antennas(baseline_m=length, position_sigma_m=sigma))
    assert stated.sigma_deg == pytest.approx(expected, rel=1e-9)


def test_a_wrong_baseline_is_rejected_and_counted(rng):
    """One antenna is multipathed by 3 m for 20 s."""
    fore, aft = antennas(np.full(N, 30.0), sigma_m=0.02, rng=rng)
    bad = placed(*_metres(fore, 200, 220), fore.stamp_ns)
    found = find_baseline_headings(bad, aft, Antennas())
    assert found.rejected == {'no_partner': 0, 'wrong_baseline': 20}
    assert np.abs(wrap180(found.headings.heading_deg - 30.0)).max() < 1.0
    all_wrong = find_baseline_headings(fore, aft, Antennas(baseline_m=20.0))
    assert all_wrong.rejected['wrong_baseline'] == N and len(all_wrong.headings) == 0


def _metres(rows, lo, hi):
    """Return positions as metres from their point, some 3 m further north."""
    meridian, normal = radii_m(54.0)
    east = np.radians(wrap180(rows.longitude_deg - 179.9999)) * normal * math.cos(
        math.radians(54.0))
    north = np.radians(rows.latitude_deg - 54.0) * meridian
    north[lo:hi] += 3.0
    return east, north


def test_positions_without_a_partner_are_counted():
    fore, aft = antennas(np.full(N, 30.0))
    gap = np.r_[aft.stamp_ns < STAMPS[100]] | (aft.stamp_ns > STAMPS[110])
    found = find_baseline_headings(fore, aft[gap], Antennas())
    assert found.rejected['no_partner'] == 11 and len(found.headings) == N - 11


@pytest.mark.parametrize('n', [0, 1])
def test_few_positions_give_few_headings(n):
    fore, aft = antennas(np.full(N, 30.0))
    found = find_baseline_headings(fore[:n], aft[:n], Antennas())
    assert len(found.headings) == n and found.scatter_m is None
    assert find_baseline_headings(fore, aft[:0], Antennas()).rejected == {'no_partner': N}


def test_order_and_repeated_stamps_do_not_matter(rng):
    fore, aft = antennas(np.linspace(0.0, 90.0, N))
    mixed = (fore + fore)[rng.permutation(2 * N)], aft[rng.permutation(N)]
    assert find_baseline_headings(*mixed, Antennas()).headings == find_baseline_headings(
        fore, aft, Antennas()).headings


def test_one_topic_without_the_other_is_a_mistake():
    with pytest.raises(SettingsError, match='antennas.aft_topic: must be given with '
                       'antennas.fore_topic'):
        Settings.from_mapping({'antennas.fore_topic': 'gps/fore'})
