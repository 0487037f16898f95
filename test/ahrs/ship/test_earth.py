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

"""The Earth as the simulated instruments sense it."""

from __future__ import annotations

import math

import pytest

from heading_intercompare.ahrs.ship.earth import (
    EARTH_RATE_RAD_S,
    gravity,
    RAD_PER_DEG_H,
    RAD_PER_DEG_SQRT_H,
    radii,
)


def test_earth_turns_once_in_a_sidereal_day():
    """2 pi / 86164.0905 s."""
    assert EARTH_RATE_RAD_S == pytest.approx(2.0 * math.pi / 86164.0905, rel=2e-7)
    assert EARTH_RATE_RAD_S / RAD_PER_DEG_H == pytest.approx(15.0411, abs=1e-4)


def test_units_by_hand():
    """1 deg/h is an arc second per second; 1 deg/sqrt(h) is 1 deg / 60 in rad/sqrt(s)."""
    assert RAD_PER_DEG_H == pytest.approx(4.848e-6, rel=1e-4)
    assert RAD_PER_DEG_SQRT_H == pytest.approx(2.909e-4, rel=1e-4)


@pytest.mark.parametrize('latitude_deg, g', [(0.0, 9.7803253359), (90.0, 9.8321849379)])
def test_gravity_at_equator_and_pole(latitude_deg, g):
    """The two defining constants of the formula (NIMA TR8350.2)."""
    assert gravity(math.radians(latitude_deg)) == pytest.approx(g, abs=1e-8)


def test_radii_meet_at_the_pole():
    """Both are a / sqrt(1 - e^2) = 6399593.6 m there."""
    meridian, normal = radii(math.pi / 2.0)
    assert meridian == pytest.approx(normal, rel=1e-12)
    assert normal == pytest.approx(6399593.6258, abs=1e-3)
