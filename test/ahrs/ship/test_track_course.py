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

"""A ship that repeats a recorded voyage."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.ahrs.ship.course import Current
from heading_intercompare.ahrs.ship.earth import EARTH_RATE_RAD_S, KNOT_M_S, radii
from heading_intercompare.ahrs.ship.ship_motion import ShipTruth
from heading_intercompare.ahrs.ship.track_course import Track
from heading_intercompare.core.motion.smoothing import fit_smooth

T_S = np.arange(0.0, 301.0)


def make_track(heading_deg=None, **given):
    """Return a track of 5 min: northeast at 6 m/s, unless given otherwise."""
    heading = np.full(T_S.size, 45.0) if heading_deg is None else heading_deg
    parts = {'east_m_s': np.full(T_S.size, 6.0 * math.sin(math.pi / 4.0)),
             'north_m_s': np.full(T_S.size, 6.0 * math.cos(math.pi / 4.0)), **given}
    return Track(10**18, 300.0, fit_smooth(T_S, np.radians(heading), 4.0),
                 position_deg=(50.0, 3.0),
                 **{name: fit_smooth(T_S, values, 4.0) for name, values in parts.items()})


def test_the_heading_is_that_of_the_record_at_any_instant():
    """Unwrapped through north, with the rate that belongs to it; same bits alone."""
    wanted = 355.0 + 15.0 * np.sin(2.0 * math.pi * T_S / 60.0)
    ship = ShipTruth([], 0.0, track=make_track(wanted))
    t_s = np.linspace(5.0, 295.0, 997)
    exact = 355.0 + 15.0 * np.sin(2.0 * math.pi * t_s / 60.0)
    assert np.abs((ship.heading_deg(t_s) - exact + 180.0) % 360.0 - 180.0).max() < 0.01
    rate = 15.0 * 2.0 * math.pi / 60.0 * np.cos(2.0 * math.pi * t_s / 60.0)
    assert np.degrees(ship.heading_rate_rad_s(t_s)) == pytest.approx(rate, abs=0.005)
    assert [ship.heading_deg(t_s[k:k + 1])[0] for k in range(0, 997, 50)] == (
        ship.heading_deg(t_s)[::50].tolist())


def test_position_is_the_integral_of_the_velocity():
    """Six m/s to the northeast for 5 min are 1273 m each way."""
    latitude, longitude = ShipTruth([], 0.0, track=make_track()).position_deg(np.array([300.0]))
    meridian, normal = radii(math.radians(50.0))
    way = 1800.0 * math.sqrt(0.5)
    assert latitude[0] - 50.0 == pytest.approx(math.degrees(way / meridian), rel=1e-4)
    assert longitude[0] - 3.0 == pytest.approx(
        math.degrees(way / (normal * math.cos(math.radians(50.006)))), rel=1e-4)


def test_the_specific_force_is_the_acceleration_and_that_of_coriolis():
    """A circle of 100 s at 5 m/s: v r towards the centre, and 2 W sin(lat) v to the side."""
    angle = 2.0 * math.pi * T_S / 100.0
    track = make_track(np.degrees(angle), east_m_s=5.0 * np.sin(angle),
                       north_m_s=5.0 * np.cos(angle))
    block, at = ShipTruth([], 0.0, track=track).block(1), 60.0 + 0.1 * np.arange(601)
    turn, psi = 2.0 * math.pi / 100.0, 2.0 * math.pi * at / 100.0
    c = 2.0 * EARTH_RATE_RAD_S * math.sin(math.radians(50.0))
    assert block.force_north_m_s2 == pytest.approx(
        (-5.0 * turn + 5.0 * c) * np.sin(psi), abs=2e-5)
    assert block.force_east_m_s2 == pytest.approx(
        (5.0 * turn - 5.0 * c) * np.cos(psi), abs=2e-5)
    assert block.speed_m_s == pytest.approx(np.full(601, 5.0), abs=1e-3)


def test_the_log_reads_the_recorded_velocity_less_the_current():
    """Along the axis: two knots of current from astern make the log read two knots less."""
    ship = ShipTruth([], 0.0, track=make_track(), current=Current(45.0, 2.0))
    assert ship.speed_m_s(np.array([100.0]))[0] == pytest.approx(6.0 - 2.0 * KNOT_M_S, abs=1e-9)
    east, north = ship.velocity_m_s(np.array([100.0]))
    assert math.hypot(east[0], north[0]) == pytest.approx(6.0, abs=1e-9)


def test_a_recorded_roll_replaces_the_simulated_one_and_yaw_is_not_added():
    roll = np.radians(5.0) * np.sin(2.0 * math.pi * T_S / 12.0)
    ship = ShipTruth([], 0.0, seaway='ss5', seed=3, track=make_track(roll_rad=roll))
    still = ShipTruth([], 0.0, track=make_track())
    t_s = np.linspace(10.0, 290.0, 301)
    assert ship.heading_rad(t_s).tolist() == still.heading_rad(t_s).tolist()
    _, _, read, pitch = ship.read_attitude(t_s)
    assert read == pytest.approx(np.radians(5.0) * np.sin(2.0 * math.pi * t_s / 12.0), abs=1e-3)
    assert np.degrees(np.std(pitch)) > 0.5
    block = ship.block(2)
    assert np.diff(block.roll_rad) / 0.1 == pytest.approx(
        0.5 * (block.roll_rate_rad_s[1:] + block.roll_rate_rad_s[:-1]), abs=1e-4)
    assert np.std(block.force_down_m_s2) > 0.1


def test_the_last_block_goes_on_beyond_the_record():
    block = ShipTruth([], 0.0, track=make_track()).block(5)
    assert np.all(np.isfinite(block.force_north_m_s2))
    assert block.heading_rad == pytest.approx(np.full(601, math.pi / 4.0), abs=1e-9)
