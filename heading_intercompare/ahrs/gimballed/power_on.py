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

"""The power-on self-test: excites gyros and accelerometers, turns the unit, watches the heater."""

from __future__ import annotations

import math
from typing import Generator, NamedTuple

from heading_intercompare.ahrs.inertial.instruments import Thermostat
from heading_intercompare.ahrs.inertial.platform import Platform
from heading_intercompare.ahrs.ship.seaway import GRID_S

TEST_S = 10.0
"""Length of the self-test, seconds."""

RATE_RAD_S = math.radians(5.0)
PUSH_M_S2 = 5.0
HALF_PERIOD_STEPS = 5
TURN_RAD_S, TURN_STEPS = math.radians(2.0), 30
ANSWER = 0.5


class Excitation(NamedTuple):
    """What the caged instruments are made to feel over one control step."""

    rate_rad_s: float
    push_m_s2: float


def run_self_test(platform: Platform,
                  thermostat: Thermostat) -> Generator[Excitation, None, list[str]]:
    """
    Test the hardware while the platform is caged.

    Parameters
    ----------
    platform
        The platform with its instruments. Each yield excites them over one control step.
    thermostat
        Gives the temperature.

    Returns
    -------
    list of str
        The parts that failed: 'gyro', 'accelerometer', 'servo', 'thermostat'.

    Notes
    -----
    * A square wave of 1 Hz excites the torquers of the gyros and the coils of the accelerometers.
      Every channel must answer with half of it to one and a half. The motion of the ship, which is
      slower, drops out of the mean.
    * The rotation unit turns by 6 degrees and back. It must arrive within half a degree.
    * The temperature must approach its set point by half of what the heater can do, or be there.

    """
    n = round(TEST_S / GRID_S)
    answers = [0.0] * 8
    far_rad, start_k = 0.0, thermostat.away_k
    for step in range(n):
        sign = -1.0 if step // HALF_PERIOD_STEPS % 2 else 1.0
        way = 1.0 if step < TURN_STEPS else -1.0 if step < 2 * TURN_STEPS else 0.0
        steps_out = min(step + 1, max(2 * TURN_STEPS - step - 1, 0))
        platform.turn_meter(steps_out * TURN_RAD_S * GRID_S, way * TURN_RAD_S)
        yield Excitation(sign * RATE_RAD_S, sign * PUSH_M_S2)
        gyros = [rate / RATE_RAD_S for rate in platform.caged_rad_s]
        forces = [force / PUSH_M_S2 for force in (
            platform.force_x_m_s2, platform.force_y_m_s2, platform.force_z_m_s2)]
        for i, answer in enumerate(gyros + forces):
            answers[i] += sign * answer / n
        if step == TURN_STEPS - 1:
            far_rad = platform.angle_rad
    wrong = [abs(answer - 1.0) > ANSWER for answer in answers]
    turn_rad = TURN_STEPS * TURN_RAD_S * GRID_S
    miss_rad = max(abs(far_rad - turn_rad), abs(platform.angle_rad))
    possible_k = abs(start_k) * -math.expm1(-TEST_S / thermostat.LAG_S)
    approach_k = abs(start_k) - abs(thermostat.away_k)
    return [part for part, failed in {
        'gyro': any(wrong[:5]), 'accelerometer': any(wrong[5:]),
        'servo': miss_rad > math.radians(0.5),
        'thermostat': not thermostat.ready and approach_k < 0.5 * possible_k}.items() if failed]
