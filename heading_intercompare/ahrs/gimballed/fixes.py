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

"""Satellite fixes of the heading, which correct the drift of the course gyro."""

from __future__ import annotations

import math
from typing import Callable

from heading_intercompare.ahrs.inertial.computer import Computer
from heading_intercompare.ahrs.inertial.platform import Platform
from heading_intercompare.ahrs.ship.seaway import GRID_S

from .calibration import drift_correction

FIX_EVERY_S, FIX_S = 1800.0, 600.0


class Fixes:
    """
    Satellite fixes of the heading: the mean of the last ten minutes of each half hour.

    They go on as long as nothing else corrects the azimuth: through fine levelling and gyro
    azimuth.

    Parameters
    ----------
    computer
        Its estimate of the drift is corrected.
    platform
        Gives the pick-off angle and the satellite heading.
    say
        Reports a correction.

    References
    ----------
    S (14).

    """

    def __init__(self, computer: Computer, platform: Platform,
                 say: Callable[[str], None]) -> None:
        self._computer, self._platform, self._say = computer, platform, say
        self._method = computer.settings.gps_correction
        self._fixes: list[tuple[float, float, float]] = []
        self._step = 0
        self._done_rad = 0.0
        self._sums = [0, 0.0, 0.0]

    def miss(self, n: int) -> None:
        """Add control steps without a satellite heading."""
        self._step += n
        for _ in range(n):
            self._done_rad += GRID_S * self._computer.drift_z_rad_s
        self._sums = [0, 0.0, 0.0]

    def step(self) -> None:
        """Add one control step."""
        computer, platform = self._computer, self._platform
        self._step += 1
        self._done_rad += GRID_S * computer.drift_z_rad_s
        if not computer.gps_ok:
            self._sums = [0, 0.0, 0.0]
            return
        place = self._step % round(FIX_EVERY_S / GRID_S)
        if place == 0 or place > round((FIX_EVERY_S - FIX_S) / GRID_S):
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
        if n < round(FIX_S / GRID_S):
            return
        turns = 2.0 * math.pi * math.floor(difference / n / (2.0 * math.pi) + 0.5)
        self._fixes.append((self._step * GRID_S, difference / n - turns, done / n))
        if len(self._fixes) >= 2:
            t_s, differences, corrected = zip(*self._fixes)
            self._computer.drift_z_rad_s = drift_correction(
                t_s, differences, corrected, self._method)
            self._say('drift of the course gyro corrected by satellite heading')
