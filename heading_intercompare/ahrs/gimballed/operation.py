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

"""The two modes of operation, meridian-seeking and free in azimuth, and the fault mode."""

from __future__ import annotations

from collections import deque
import math

from heading_intercompare.ahrs.inertial.control_laws import settled_rate
from heading_intercompare.ahrs.inertial.loop import FINE, GYROCOMPASS, SCHULER
from heading_intercompare.ahrs.ship.earth import RAD_PER_DEG_H, RAD_PER_DEG_SQRT_H

from .alignment import hold_azimuth, PROCEDURES as ALIGNMENT
from .claims import alignment_sigma, FreeAzimuth, gyrocompass_sigma, output_sigma
from .fixes import Fixes
from .machine import Machine, Procedure, SECOND, Steady
from .modes import Mode, Validity

POLE_RAD = math.radians(85.0)
FORGOTTEN = 0.7
"""An error of the azimuth is forgotten at least as fast as by exp(-0.7 sigma t): A6."""
TOO_NEAR_THE_POLE = 'too near the pole for a gyrocompass'


def gyrocompass(ahrs: Machine) -> Procedure:
    """Seek the meridian and report when it is found: S (20)-(22)."""
    computer, errors = ahrs.computer, ahrs.errors
    ahrs.fixes = None
    if abs(computer.latitude_rad) > POLE_RAD:
        ahrs.say(TOO_NEAR_THE_POLE)
        return Mode.GYRO_AZIMUTH
    computer.enter_gyrocompass()
    sigma_1_s = ahrs.settings.sigma_1_s
    recent: deque[float] = deque(maxlen=max(1, round(1.0 / sigma_1_s)))
    wait_s = 0.0 if ahrs.validity is Validity.VALID else 3.0 / sigma_1_s
    if ahrs.validity is not Validity.VALID:
        ahrs.validity = Validity.SETTLING
        # What was claimed before may be more, such as after hours of a free azimuth.
        ahrs.sigma_rad = max(alignment_sigma(ahrs.residual_deg_h, computer.latitude_rad),
                             ahrs.sigma_rad)
    speed_rad, output_rad = 0.0, output_sigma(errors)
    second = 0
    while True:
        yield Steady(GYROCOMPASS, SECOND)
        second += 1
        latitude_rad = computer.latitude_rad
        speed_rad = max(speed_rad * math.exp(-FORGOTTEN * sigma_1_s), math.atan2(
            ahrs.unknown_m_s, computer.meridian_m * computer.earth_north))
        if abs(latitude_rad) > POLE_RAD:
            ahrs.say(TOO_NEAR_THE_POLE)
            return Mode.GYRO_AZIMUTH
        recent.append(computer.correction_rad_s**2)
        if second % 10 == 0 and second >= wait_s:
            limit = settled_rate(errors.random_walk_deg_sqrt_h * RAD_PER_DEG_SQRT_H,
                                 ahrs.course_deg_h * RAD_PER_DEG_H, sigma_1_s, latitude_rad)
            rate = math.sqrt(math.fsum(recent) / len(recent))
            if ahrs.validity is not Validity.VALID and rate < limit:
                ahrs.validity = Validity.VALID
                ahrs.say('meridian found')
            elif ahrs.validity is Validity.VALID and rate > 3.0 * limit:
                ahrs.validity = Validity.SETTLING
                ahrs.say('meridian lost')
        if ahrs.validity is Validity.VALID:
            ahrs.sigma_rad = math.hypot(output_rad, speed_rad, gyrocompass_sigma(
                errors, ahrs.residual_deg_h, sigma_1_s, ahrs.soak, latitude_rad))


def gyro_azimuth(ahrs: Machine) -> Procedure:
    """Hold the azimuth, levelled by the log or the AHRS's own velocity, with fixes: S (14)."""
    computer = ahrs.computer
    computer.enter_hold()
    schuler = ahrs.settings.vertical == 'schuler'
    law = SCHULER if schuler else FINE
    if schuler:
        computer.enter_schuler()
    if ahrs.validity is Validity.SETTLING:
        ahrs.say('the meridian was not found: the heading stays settling')
    else:
        ahrs.validity = Validity.VALID
    free = FreeAzimuth(ahrs.errors, ahrs.sigma_rad)
    # The fixes of fine levelling count: the azimuth has been free since.
    fixes = ahrs.fixes or Fixes(computer, ahrs.platform, ahrs.say)
    while True:
        yield from hold_azimuth(ahrs, law, SECOND, fixes)
        ahrs.claim(free, 1.0, own_velocity=schuler)


def fault(ahrs: Machine) -> Procedure:
    """Stand still until a reset."""
    ahrs.validity = Validity.NONE
    while True:
        yield None


PROCEDURES = {
    **ALIGNMENT,
    Mode.GYROCOMPASS: gyrocompass,
    Mode.GYRO_AZIMUTH: gyro_azimuth,
    Mode.FAULT: fault,
}
"""The procedure of each mode."""
