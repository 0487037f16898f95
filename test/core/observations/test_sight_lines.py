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

"""True bearings of marks, lines and quays."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.observations.sight_lines import (
    bearing_between,
    bearing_uncertainty,
    line_bearing,
    quay_angle,
)


def geodesic_azimuth(lat1, lon1, lat2, lon2):
    """Return the azimuth of the geodesic by Vincenty's inverse formula, a plain loop."""
    f = 1 / 298.257223563
    u1, u2 = (math.atan((1 - f) * math.tan(math.radians(lat))) for lat in (lat1, lat2))
    total = lam = math.radians(lon2 - lon1)
    for _ in range(100):
        east = math.cos(u2) * math.sin(lam)
        north = math.cos(u1) * math.sin(u2) - math.sin(u1) * math.cos(u2) * math.cos(lam)
        sin_s = math.hypot(east, north)
        cos_s = math.sin(u1) * math.sin(u2) + math.cos(u1) * math.cos(u2) * math.cos(lam)
        s = math.atan2(sin_s, cos_s)
        sin_a = math.cos(u1) * math.cos(u2) * math.sin(lam) / sin_s
        cos2_a = 1 - sin_a ** 2
        middle = cos_s - 2 * math.sin(u1) * math.sin(u2) / cos2_a if cos2_a else 0.0
        c = f / 16 * cos2_a * (4 + f * (4 - 3 * cos2_a))
        lam = total + (1 - c) * f * sin_a * (
            s + c * sin_s * (middle + c * cos_s * (2 * middle ** 2 - 1)))
    return math.degrees(math.atan2(east, north)) % 360.0


def test_the_bearing_is_that_of_the_geodesic_to_a_thousandth_of_a_degree(rng):
    """Up to 130 km; the plane through the vertical differs by less."""
    for lat in (-65.0, -20.0, 0.5, 35.0, 54.0, 70.0):
        for _ in range(20):
            north, east = rng.uniform(-1.0, 1.0, 2)
            there = lat + north, 10.0 + east
            bearing, _ = bearing_between(lat, 10.0, *there)
            assert abs(wrap180(float(bearing) - geodesic_azimuth(lat, 10.0, *there))) < 1e-3


def test_cardinal_bearings_and_distances():
    """A minute of latitude is a nautical mile to half a percent."""
    bearing, distance = bearing_between(54.0, 10.0, [54.0 + 1 / 60, 54.0 - 1 / 60], 10.0)
    assert wrap180(bearing - [0.0, 180.0]) == pytest.approx([0.0, 0.0], abs=1e-9)
    assert distance == pytest.approx([1852.0, 1852.0], rel=0.005)
    bearing, _ = bearing_between(0.0, 10.0, 0.0, [10.1, 9.9])
    assert bearing == pytest.approx([90.0, 270.0], abs=1e-9)


def test_one_point_has_no_bearing():
    bearing, distance = bearing_between(54.0, 10.0, 54.0, 10.0)
    assert np.isnan(bearing) and distance == 0.0
    with pytest.raises(ValueError, match='one point'):
        line_bearing((54.0, 10.0), (54.0, 10.0))


def test_a_ship_on_the_line_sees_the_front_mark_at_the_bearing_of_the_line():
    """The line 70 deg at the front mark, seen 15 km further west: the meridians converge."""
    front = (60.0, 10.0)
    _, length = bearing_between(*front, 60.01, 10.05)
    line, given_length = line_bearing(front, (60.01, 10.05))
    assert given_length == pytest.approx(float(length))
    back = math.radians(float(line) + 180.0)
    low, high = 0.0, 1.0
    ship = (front[0] + 0.135 * math.cos(back), front[1] + 0.27 * math.sin(back))
    # Move the place across the line until the ship lies on it: the rear mark covers the front.
    for _ in range(60):
        shift = 0.5 * (low + high) - 0.5
        place = ship[0] + 0.02 * shift, ship[1]
        one = float(bearing_between(*place, *front)[0])
        other = float(bearing_between(*place, 60.01, 10.05)[0])
        low, high = ((0.5 * (low + high), high) if wrap180(one - other) < 0.0
                     else (low, 0.5 * (low + high)))
    assert abs(wrap180(one - other)) < 1e-9
    seen, _ = line_bearing(front, (60.01, 10.05), [place[1]])
    assert abs(wrap180(float(seen[0]) - one)) < 1e-3
    assert abs(wrap180(float(line) - one)) > 0.1


def test_the_uncertainty_of_two_points_by_hand():
    """sqrt(2) · 0.02 m / 150 m = 1.8856e-4 rad = 0.010804 deg."""
    assert float(bearing_uncertainty(0.02, 150.0)) == pytest.approx(0.010804, abs=1e-6)


def test_the_bow_off_the_quay_turns_the_ship_away_from_the_side_that_lies_at_it():
    """Port side to, bow 0.4 m further off over 80 m: atan(0.005) = 0.2865 deg to starboard."""
    assert quay_angle(1.9, 1.5, 80.0, 'port') == pytest.approx(0.28648, abs=1e-5)
    assert quay_angle(1.9, 1.5, 80.0, 'starboard') == pytest.approx(-0.28648, abs=1e-5)
    with pytest.raises(ValueError, match="side = 'left'"):
        quay_angle(1.9, 1.5, 80.0, 'left')
    with pytest.raises(ValueError, match='base_m = 0.0'):
        quay_angle(1.9, 1.5, 0.0, 'port')
