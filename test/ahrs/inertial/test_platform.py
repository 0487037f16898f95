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

"""Equations of motion of the platform against rotation matrices."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from heading_intercompare.ahrs.inertial.instruments import Instruments
from heading_intercompare.ahrs.inertial.platform import Platform, rows_of
from heading_intercompare.ahrs.sensor_presets import ERRORS
from heading_intercompare.ahrs.settings import Ahrs
from heading_intercompare.ahrs.ship.earth import KNOT_M_S, radii
from heading_intercompare.ahrs.ship.ship_motion import ShipTruth
from heading_intercompare.ahrs.ship.steering import Leg

LATITUDE = math.radians(40.0)


def quiet_platform():
    """Return a platform without errors and its rows for a ship on 060 at 15 kn."""
    settings = Ahrs(noise=False, initial_state='warm')
    parts = Instruments(ERRORS['imo'], settings, 1, 'ts')
    ship = ShipTruth([Leg(0.0, 60.0, 15.0)], 40.0)
    return Platform(parts, 0.0), rows_of(ship.block(0), parts.take(600))


@pytest.mark.parametrize('command', [(0.0, 0.0, 0.0), (1e-5, -2e-5, math.radians(10.0))])
def test_motion_agrees_with_rotation_matrices(command):
    """
    One minute with a tilt of 3'; the tilts are first order, so errors of 1e-3 of 3' are allowed.

    The second case turns the platform by 600 degrees at 10 deg/s, as a slew does.
    """
    platform, rows = quiet_platform()
    platform.alpha_rad, platform.beta_rad = 1e-3, -5e-4
    platform.azimuth_rad = 2.0
    velocity = 15.0 * KNOT_M_S * np.array([math.cos(math.radians(60.0)),
                                           math.sin(math.radians(60.0))])
    meridian, normal = radii(LATITUDE)
    level = np.array([
        7.292115e-5 * math.cos(LATITUDE) + velocity[1] / normal, -velocity[0] / meridian,
        -7.292115e-5 * math.sin(LATITUDE) - velocity[1] * math.tan(LATITUDE) / normal])
    # Platform axes in level axes: first the azimuth, then the tilts.
    attitude = (Rotation.from_euler('z', 2.0) * Rotation.from_rotvec([1e-3, -5e-4, 0.0]))
    for row in rows:
        platform.step(row, *command)
        # Both frames turn; the platform by the command in its own axes.
        attitude = (Rotation.from_rotvec(-0.1 * level) * attitude
                    * Rotation.from_rotvec(0.1 * np.array(command)))
    found = (Rotation.from_euler('z', platform.azimuth_rad)
             * Rotation.from_rotvec([platform.alpha_rad, platform.beta_rad, 0.0]))
    assert (found.inv() * attitude).magnitude() < 8e-6


def test_accelerometers_feel_the_tilt():
    """A platform tipped about its y by +1e-3 reads g 1e-3 along x, about x -g 1e-3 along y."""
    platform, rows = quiet_platform()
    platform.step(rows[0], 0.0, 0.0, 0.0)
    level_x, level_y = platform.force_x_m_s2, platform.force_y_m_s2
    platform, rows = quiet_platform()
    platform.alpha_rad, platform.beta_rad = 2e-3, 1e-3
    platform.step(rows[0], 0.0, 0.0, 0.0)
    assert platform.force_x_m_s2 - level_x == pytest.approx(9.8017e-3, rel=1e-3)
    assert platform.force_y_m_s2 - level_y == pytest.approx(-2.0 * 9.8017e-3, rel=1e-3)


def test_meter_turned_by_a_quarter_exchanges_its_axes():
    platform, rows = quiet_platform()
    platform.angle_rad = math.pi / 2.0
    platform.step(rows[0], 3e-5, -1e-5, 0.0)
    assert (platform.rate_x_rad_s, platform.rate_y_rad_s) == pytest.approx((-1e-5, -3e-5))


def test_servo_follows_the_revolution():
    """After the start the rotation unit is within 1e-6 rad of an angle that turns evenly."""
    platform, _ = quiet_platform()
    for step in range(1, 301):
        platform.turn_meter(math.radians(0.2 * step), math.radians(2.0))
    assert platform.angle_rad == pytest.approx(math.radians(60.0), abs=1e-6)


def test_velocity_quanta_keep_the_mean():
    settings = Ahrs(noise=False, initial_state='warm', fixed='bias_x 100')
    parts = Instruments(ERRORS['imo'], settings, 1, 'ts')
    ship = ShipTruth([Leg(0.0, 0.0, 0.0)], 0.0)
    platform = Platform(parts, 1e-3)
    read = []
    for row in rows_of(ship.block(0), parts.take(600)):
        platform.alpha_rad = platform.beta_rad = platform.azimuth_rad = 0.0
        platform.step(row, 7.292115e-5, 0.0, 0.0)
        read.append(platform.force_x_m_s2)
    assert set(np.round(np.array(read) / 0.01).tolist()) == {0.0, 1.0}
    assert np.mean(read) == pytest.approx(100.0 * 9.80665e-6, abs=1e-3 / 60.0)
