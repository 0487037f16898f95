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

"""The slew of the platform in azimuth by its motor, checked by the pick-off."""

from __future__ import annotations

import math
from typing import Generator

from heading_intercompare.ahrs.inertial.computer import Computer
from heading_intercompare.ahrs.inertial.loop import Rates
from heading_intercompare.ahrs.inertial.platform import MOTOR_1_S, Platform
from heading_intercompare.ahrs.ship.seaway import GRID_S

Slew = Generator[Rates, None, bool]

SLEW_RAD_S = math.radians(10.0)
TRIM_RAD_S = math.radians(2.0)
COAST_S = 1.0 / MOTOR_1_S - GRID_S
COAST_STEPS = 20
LIMIT_S = 10.0
CHECK_RAD = math.radians(1.0)
SHIP_RAD_S = math.radians(3.0)


def slew(computer: Computer, platform: Platform, angle_rad: float) -> Slew:
    """
    Turn the platform in azimuth by an angle.

    Parameters
    ----------
    computer
        Knows the azimuth; follows the turn by what the course gyro reads.
    platform
        Carries motor, gyro and pick-off.
    angle_rad
        Angle to turn, clockwise.

    Returns
    -------
    bool
        Whether the platform arrived, and the pick-off confirms the angle: to one degree, at sea
        plus 3 deg/s for the ship's own turn.

    Notes
    -----
    The motor is switched off early enough for the platform to coast to its goal. The course gyro,
    which then holds the azimuth again, takes out the rest by its torquer. The course gyro measures
    the turn, because a ship that yaws would mislead the pick-off. So the scale error of its
    torquer stays in the azimuth.

    References
    ----------
    S (10): 10 deg/s relative to the ship. S (11): the stop when the angle turned is reached.

    """
    start_rad, goal_rad = computer.azimuth_rad, computer.azimuth_rad + angle_rad
    sense = math.copysign(1.0, angle_rad)
    limit_s = abs(angle_rad) / SLEW_RAD_S + LIMIT_S
    platform.brake()
    before_rad, steps = platform.pick_off_rad, 0
    while sense * (goal_rad - computer.azimuth_rad) > COAST_S * sense * platform.drive_rad_s:
        yield _turn(computer, platform, platform.drive(sense * SLEW_RAD_S))
        steps += 1
        if steps * GRID_S > limit_s:
            platform.brake()
            return False
    for _ in range(COAST_STEPS):
        yield _turn(computer, platform, platform.drive(0.0))
    platform.brake()
    left_rad = math.inf
    while abs(left_rad) > TRIM_RAD_S * GRID_S:
        left_rad = goal_rad - computer.azimuth_rad
        yield _turn(computer, platform, max(-TRIM_RAD_S, min(TRIM_RAD_S, left_rad / GRID_S)))
        steps += 1
    computer.azimuth_rad = goal_rad
    span_s = (steps + COAST_STEPS) * GRID_S
    seen_rad = before_rad - platform.pick_off_rad
    allowed_rad = CHECK_RAD + (0.0 if computer.moored else SHIP_RAD_S * span_s)
    return abs(seen_rad - (goal_rad - start_rad)) <= allowed_rad


def _turn(computer: Computer, platform: Platform, rate_rad_s: float) -> Rates:
    """Return the rates to command over a step in which the platform turns, and follow it."""
    platform.turn_meter(0.0, 0.0)
    part_rad = rate_rad_s * GRID_S
    computer.azimuth_rad += 0.5 * part_rad
    ux, uy, uz = computer.free()
    computer.azimuth_rad += 0.5 * part_rad
    computer.turn_axes(part_rad)
    return ux, uy, uz + rate_rad_s
