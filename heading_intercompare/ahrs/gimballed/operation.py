# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The two modes of operation, meridian-seeking and free in azimuth, and the fault mode."""

from __future__ import annotations

from collections import deque
from itertools import count
import math

from heading_intercompare.ahrs.inertial.control_laws import settled_rate
from heading_intercompare.ahrs.inertial.loop import FINE, GYROCOMPASS, SCHULER
from heading_intercompare.ahrs.ship.earth import RAD_PER_DEG_H, RAD_PER_DEG_SQRT_H
from heading_intercompare.ahrs.ship.seaway import GRID_S

from .alignment import Machine, Procedure, PROCEDURES as ALIGNMENT, Steady, steps
from .calibration import drift_correction
from .claims import alignment_sigma, azimuth_sigma, gyrocompass_sigma, output_sigma
from .modes import Mode, Validity

__all__ = ['POLE_RAD', 'PROCEDURES', 'TOO_NEAR_THE_POLE']

POLE_RAD = math.radians(85.0)
TOO_NEAR_THE_POLE = 'too near the pole for a gyrocompass'
FIX_EVERY_S, FIX_S = 1800.0, 600.0
SECOND = steps(1.0)


def gyrocompass(ahrs: Machine) -> Procedure:
    """Seek the meridian and report when it is found: S (20)-(22)."""
    computer, errors = ahrs.computer, ahrs.errors
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
    for second in count(1):
        yield Steady(GYROCOMPASS, SECOND)
        latitude_rad = computer.latitude_rad
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
            ahrs.sigma_rad = math.hypot(output_sigma(errors), gyrocompass_sigma(
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
    start_rad = ahrs.sigma_rad
    fixes = _Fixes(ahrs)
    for second in count(1):
        if not computer.gps_ok:
            yield Steady(law, SECOND)
            fixes.miss(SECOND)
        else:
            for _ in range(SECOND):
                yield Steady(law, 1)
                fixes.step()
        ahrs.sigma_rad = azimuth_sigma(ahrs.errors, ahrs.course_deg_h, start_rad, float(second))


class _Fixes:
    """Satellite fixes of the heading: the mean of the last ten minutes of each half hour."""

    def __init__(self, ahrs: Machine) -> None:
        self._ahrs = ahrs
        self._method = ahrs.settings.gps_correction
        self._fixes: list[tuple[float, float, float]] = []
        self._step = 0
        self._done_rad = 0.0
        self._sums = [0, 0.0, 0.0]

    def miss(self, n: int) -> None:
        """Add control steps without a satellite heading."""
        self._step += n
        for _ in range(n):
            self._done_rad += GRID_S * self._ahrs.computer.drift_z_rad_s
        self._sums = [0, 0.0, 0.0]

    def step(self) -> None:
        """Add one control step."""
        computer, platform = self._ahrs.computer, self._ahrs.platform
        self._step += 1
        self._done_rad += GRID_S * computer.drift_z_rad_s
        if not computer.gps_ok:
            self._sums = [0, 0.0, 0.0]
            return
        place = self._step % steps(FIX_EVERY_S)
        if place == 0 or place > steps(FIX_EVERY_S - FIX_S):
            difference = platform.pick_off_rad + computer.azimuth_rad - platform.satellite_rad
            self._sums[0] += 1
            self._sums[1] += difference
            self._sums[2] += self._done_rad
        if place == 0:
            self._use()

    def _use(self) -> None:
        """Add a complete fix, and correct the drift by all fixes."""
        n, difference, done = self._sums
        self._sums = [0, 0.0, 0.0]
        if n < steps(FIX_S):
            return
        turns = 2.0 * math.pi * math.floor(difference / n / (2.0 * math.pi) + 0.5)
        self._fixes.append((self._step * GRID_S, difference / n - turns, done / n))
        if len(self._fixes) >= 2:
            computer = self._ahrs.computer
            computer.drift_z_rad_s = drift_correction(*zip(*self._fixes), method=self._method)
            self._ahrs.say('drift of the course gyro corrected by satellite heading')


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
