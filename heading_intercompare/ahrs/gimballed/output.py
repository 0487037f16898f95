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

"""The output of the AHRS: its heading at any instant, with the errors of the read-out."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from heading_intercompare.ahrs.random_noise import open_stream
from heading_intercompare.ahrs.sensor_presets import errors_of
from heading_intercompare.ahrs.settings import Sensor
from heading_intercompare.ahrs.ship.seaway import GRID_S
from heading_intercompare.ahrs.ship.ship_motion import ShipTruth
from heading_intercompare.core.records import Reals

from .gimballed_ahrs import GimballedAhrs, Track, TRACK_STEPS
from .modes import AhrsStatus, Validity

RESOLUTION_DEG = 360.0 / 2**20
BLOCK_S = TRACK_STEPS * GRID_S


class Indication(NamedTuple):
    """
    The output of an AHRS at some instants, each of shape (n,).

    Headings as a continuous angle and claimed standard deviations, degrees; nan if invalid. The
    true rate of turn, rad/s.
    """

    heading_deg: Reals
    sigma_deg: Reals
    rate_rad_s: Reals


class AhrsOutput:
    """
    Heading output of one AHRS.

    Parameters
    ----------
    sensor
        Settings of the sensor, whose model is an AHRS.
    ship
        The ship that carries it.
    seed
        Seed of the simulation.
    role
        'ts' or 'rs'.
    fast
        Compile the control loop if numba is installed; it gives the same bits.

    """

    def __init__(self, sensor: Sensor, ship: ShipTruth, seed: int, role: str,
                 fast: bool = False) -> None:
        self._errors = errors_of(sensor.model, sensor.ahrs.errors)
        self._ship = ship
        self._least = Validity[sensor.ahrs.publish.upper()]
        self._ahrs = GimballedAhrs(sensor.ahrs, self._errors, ship, seed, role, fast)
        self._white = open_stream(seed, f'{role}.ahrs.output')
        self._noise_deg = self._errors.output_deg if sensor.ahrs.noise else 0.0
        self._phases = (2.0 * math.pi * self._white.random(2)).tolist()
        self._tracks: list[Track] = []
        self._statuses: list[AhrsStatus] = []

    def statuses(self) -> tuple[AhrsStatus, ...]:
        """Return the statuses since the last call, up to the end of the newest block."""
        statuses, self._statuses = tuple(self._statuses), []
        return statuses

    def command(self, kind: str, t_s: float) -> float:
        """Make an event happen; return when, or raise ValueError: see `GimballedAhrs.command`."""
        return self._ahrs.command(kind, t_s)

    def read(self, t_s: Reals) -> Indication:
        """
        Return the output at some instants.

        Parameters
        ----------
        t_s : ndarray, shape (n,)
            Seconds since the start, no earlier than the block in which the last call ended.

        """
        while t_s.size and (not self._tracks
                            or t_s[-1] >= self._tracks[-1].start_s + BLOCK_S):
            self._tracks.append(self._ahrs.block())
            self._statuses += self._tracks[-1].statuses
        if not t_s.size:
            return Indication(t_s, t_s, t_s)
        indication = self._indicate(t_s)
        del self._tracks[:-1]
        return indication

    def _indicate(self, t_s: Reals) -> Indication:
        """
        Return the output within the blocks at hand.

        The heading is that of the ship plus the azimuth error of the platform (assumed minus true
        azimuth), with follow-up lag, pick-off harmonics, gimbal coupling, flexure and noise.
        """
        e, ship = self._errors, self._ship
        start_s = np.array([track.start_s for track in self._tracks])
        block = np.searchsorted(start_s[:-1] + BLOCK_S, t_s, side='right')
        position = np.minimum((t_s - start_s[block]) / GRID_S, TRACK_STEPS - 1e-9)
        step = np.maximum(position, 0.0).astype(np.int64)
        part, step = position - step, step + block * TRACK_STEPS
        # The end of a block is the start of the next one, but for rounding.
        left = step + block
        error, azimuth = (
            values[left] + part * (values[left + 1] - values[left])
            for values in (self._join('error_rad'), self._join('azimuth_rad')))
        heading, rate, roll, pitch = ship.read_attitude(t_s)
        psi = heading - azimuth
        arcsec = (e.harmonic_arcsec * np.sin(psi + self._phases[0])
                  + e.harmonic2_arcsec * np.sin(2.0 * psi + self._phases[1]))
        indicated = np.degrees(
            heading + error - e.follow_up_s * rate
            + e.coupling * (roll + pitch) + self._join('flexure_rad')[step]) + arcsec / 3600.0
        indicated += self._noise_deg * self._white.standard_normal(t_s.size)
        indicated = RESOLUTION_DEG * np.rint(indicated / RESOLUTION_DEG)
        valid = self._join('validity')[step] >= self._least
        return Indication(
            np.where(valid, indicated, np.nan),
            np.where(valid, np.degrees(self._join('sigma_rad')[step]), np.nan), rate)

    def _join(self, name: str) -> np.ndarray:
        """Return an attribute of all blocks at hand, one after the other."""
        return np.concatenate([getattr(track, name) for track in self._tracks])
