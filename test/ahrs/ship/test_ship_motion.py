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

"""The ship on her course."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from heading_intercompare.ahrs.ship.course import Current
from heading_intercompare.ahrs.ship.earth import EARTH_RATE_RAD_S, KNOT_M_S, radii
from heading_intercompare.ahrs.ship.ship_motion import ShipBlock, ShipTruth
from heading_intercompare.ahrs.ship.steering import Leg

TURN = (Leg(0.0, 350.0, 12.0), Leg(60.0, 80.0, 12.0))


def test_steady_course_is_kept():
    ship = ShipTruth([Leg(0.0, 123.0, 12.0)], 45.0)
    assert ship.heading_deg(np.array([0.0, 1.7, 5000.0])) == pytest.approx(123.0, abs=1e-9)


def test_turn_takes_the_short_way_and_ends_on_course():
    """From 350 to 80 degrees through north, at no more than 2 deg/s."""
    ship = ShipTruth(TURN, 45.0)
    t_s = np.arange(0.0, 900.0, 0.5)
    turned_deg = np.degrees(ship.heading_rad(t_s))
    assert turned_deg[-1] == pytest.approx(350.0 + 90.0, abs=0.05)
    assert turned_deg.max() < 350.0 + 100.0
    assert np.degrees(ship.heading_rate_rad_s(t_s)).max() <= 2.0


@pytest.mark.parametrize('turn_deg_s', [0.2, 1.0, 2.0, 10.0, 20.0])
def test_a_change_of_course_is_made_at_the_rate_set(turn_deg_s):
    """From 60 to 220 degrees: the rate is nearly reached, and the course is met."""
    ship = ShipTruth([Leg(0.0, 60.0, 12.0), Leg(60.0, 220.0, 12.0)], 45.0, turn_deg_s=turn_deg_s)
    t_s = np.arange(0.0, 2000.0, 0.5)
    rate_deg_s = np.degrees(ship.heading_rate_rad_s(t_s))
    assert 0.9 * turn_deg_s < rate_deg_s.max() < 1.01 * turn_deg_s
    assert rate_deg_s.min() > -0.05 * turn_deg_s
    assert ship.heading_deg(t_s[-1:])[0] == pytest.approx(220.0, abs=0.05)


def test_steering_follows_its_differential_equation():
    """Nomoto's equation and the autopilot, integrated by scipy with the rudder held for 0.5 s."""
    heading, r = math.radians(350.0), 0.0
    t = 60.0
    for _ in range(120):
        away = math.remainder(math.radians(80.0) - heading, 2.0 * math.pi)
        wanted = np.clip(0.02 * away, -math.radians(2.0), math.radians(2.0))
        rudder = np.clip((wanted + 1.5 * (wanted - r)) / 0.08, -math.radians(25.0),
                         math.radians(25.0))
        step = solve_ivp(lambda _, y, d=rudder: (y[1], (0.08 * d - y[1]) / 20.0), (0.0, 0.5),
                         (heading, r), rtol=1e-10, atol=1e-13)
        heading, r = step.y[:, -1]
        t += 0.5
    ship = ShipTruth(TURN, 45.0)
    assert ship.heading_rad(np.array([t]))[0] == pytest.approx(heading, abs=1e-8)
    assert ship.heading_rate_rad_s(np.array([t]))[0] == pytest.approx(r, abs=1e-9)


def test_rate_is_the_derivative_of_the_heading():
    ship, t_s = ShipTruth(TURN, 45.0, seaway='ss5', seed=2), np.arange(55.0, 200.0, 0.01)
    steps = np.diff(ship.heading_rad(t_s)) / 0.01
    rate = ship.heading_rate_rad_s(t_s[:-1] + 0.005)
    assert np.degrees(np.abs(steps - rate).max()) < 1e-5


def test_dead_reckoning_by_hand():
    """Twelve knots north for an hour are 22224 m of the meridian."""
    ship = ShipTruth([Leg(0.0, 0.0, 12.0)], 45.0, 10.0)
    latitude, longitude = ship.position_deg(np.array([0.0, 3600.0]))
    assert np.radians(np.diff(latitude))[0] * radii(math.radians(45.1))[0] == pytest.approx(
        22224.0, rel=1e-5)
    assert longitude == pytest.approx(10.0)


def test_block_agrees_with_the_readings():
    ship, t_s = ShipTruth(TURN, 45.0, seaway='ss3', seed=2), 60.0 + 0.1 * np.arange(601)
    block = ship.block(1)
    assert block.heading_rad == pytest.approx(ship.heading_rad(t_s), abs=1e-12)
    assert block.speed_m_s == pytest.approx(ship.speed_m_s(t_s), abs=1e-12)


def test_specific_force_of_a_calm_straight_run_is_gravity_and_coriolis():
    """2 W sin(phi) v to port, 6.4e-4 m/s^2 for 12 kn at 45 degrees north: west on course 0."""
    block = ShipTruth([Leg(0.0, 0.0, 12.0)], 45.0).block(0)
    assert block.force_east_m_s2[0] == pytest.approx(
        -2.0 * 7.292115e-5 * math.sin(math.radians(45.0)) * 12.0 * KNOT_M_S, rel=1e-3)
    assert block.force_north_m_s2[0] == pytest.approx(0.0, abs=1e-12)
    assert block.force_down_m_s2[0] == pytest.approx(-9.8062, abs=2e-4)


def test_level_frame_of_a_northward_ship_tips_westward():
    """Going north turns it by -v / R about east, on top of the rotation of the Earth."""
    block = ShipTruth([Leg(0.0, 0.0, 12.0)], 30.0).block(0)
    latitude = math.radians(30.0)
    assert block.turn_north_rad_s[0] == pytest.approx(7.292115e-5 * math.cos(latitude))
    assert block.turn_east_rad_s[0] == pytest.approx(-12.0 * KNOT_M_S / radii(latitude)[0],
                                                     rel=1e-6)
    assert block.turn_down_rad_s[0] == pytest.approx(-7.292115e-5 * math.sin(latitude))


def test_the_same_ship_whatever_is_asked_first():
    one, other = (ShipTruth(TURN, 45.0, seaway='ss5', seed=4) for _ in range(2))
    late, early = np.array([5000.25]), np.array([77.77])
    first = one.heading_rad(late)[0], one.heading_rad(early)[0]
    second = other.heading_rad(early)[0], other.heading_rad(late)[0]
    assert first == second[::-1]


def test_before_the_start_there_is_no_ship():
    with pytest.raises(ValueError, match='t_s = -1.0'):
        ShipTruth(TURN, 45.0).heading_rad(np.array([-1.0, 2.0]))


def test_a_current_carries_the_ship_and_not_its_log():
    """Ten knots north in two knots to the east: 10 kn by the log, 10 and 2 over ground."""
    ship = ShipTruth([Leg(0.0, 0.0, 10.0)], 45.0, current=Current(90.0, 2.0))
    still, t_s = ShipTruth([Leg(0.0, 0.0, 10.0)], 45.0), np.array([0.0, 3600.0])
    assert ship.speed_m_s(t_s).tolist() == still.speed_m_s(t_s).tolist()
    east, north = ship.velocity_m_s(t_s)
    assert east / KNOT_M_S == pytest.approx([2.0, 2.0])
    assert north / KNOT_M_S == pytest.approx([10.0, 10.0])
    latitude, longitude = ship.position_deg(t_s)
    normal = radii(math.radians(45.08))[1] * math.cos(math.radians(45.08))
    assert longitude[1] == pytest.approx(math.degrees(2.0 * 1852.0 / normal), rel=1e-4)
    assert latitude.tolist() == still.position_deg(t_s)[0].tolist()
    block, other = ship.block(3), still.block(3)
    drift = 2.0 * KNOT_M_S
    turn = drift * (2.0 * EARTH_RATE_RAD_S * math.sin(math.radians(45.01)) + drift / 6.389e6)
    assert block.force_north_m_s2 - other.force_north_m_s2 == pytest.approx(
        np.full(601, turn), rel=1e-3)


def test_without_a_current_nothing_changes():
    """A drift of zero gives the bits of a ship without one, wherever it sets."""
    one, other = (ShipTruth(TURN, 45.0, seaway='ss3', seed=2, current=current)
                  for current in (Current(), Current(123.0, 0.0)))
    for name in ShipBlock.__slots__:
        assert getattr(one.block(1), name).tolist() == getattr(other.block(1), name).tolist()
