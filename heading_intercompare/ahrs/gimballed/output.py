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

from .gimballed_ahrs import GimballedAhrs, Track, TRACK_STEPS
from .modes import AhrsStatus, Validity

__all__ = ['AhrsOutput', 'Indication']

RESOLUTION_DEG = 360.0 / 2**20
BLOCK_S = TRACK_STEPS * GRID_S


class Indication(NamedTuple):
    """Headings as a continuous angle and claimed standard deviations, degrees; nan if invalid."""

    heading_deg: np.ndarray
    sigma_deg: np.ndarray


class AhrsOutput:
    """
    Heading output of one AHRS.

    Parameters
    ----------
    sensor : Sensor
        Settings of the sensor, whose model is an AHRS.
    ship : ShipTruth
        The ship that carries it.
    seed : int
        Seed of the simulation.
    role : str
        'ts' or 'rs'.
    fast : bool
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
        self._track: Track | None = None
        self._statuses: list[AhrsStatus] = []

    def statuses(self) -> tuple[AhrsStatus, ...]:
        """Return the statuses since the last call, up to the end of the newest block."""
        said, self._statuses = tuple(self._statuses), []
        return said

    def command(self, kind: str, t_s: float) -> float:
        """Make an event happen; return when, or raise ValueError: see `GimballedAhrs.command`."""
        return self._ahrs.command(kind, t_s)

    def read(self, t_s: np.ndarray) -> Indication:
        """
        Return the output at some instants.

        Parameters
        ----------
        t_s : ndarray, shape (n,)
            Seconds since the start, no earlier than the block in which the last call ended.

        """
        heading_deg, sigma_deg = np.empty(t_s.shape), np.empty(t_s.shape)
        done = 0
        while done < t_s.size:
            if self._track is None or t_s[done] >= self._track.start_s + BLOCK_S:
                self._track = self._ahrs.block()
                self._statuses += self._track.statuses
                continue
            end_s = self._track.start_s + BLOCK_S
            part = slice(done, int(np.searchsorted(t_s, end_s, side='left')))
            heading_deg[part], sigma_deg[part] = self._indicate(self._track, t_s[part])
            done = part.stop
        return Indication(heading_deg, sigma_deg)

    def _indicate(self, track: Track, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """
        Return headings and claimed standard deviations within one block.

        The heading is that of the ship plus the azimuth error of the platform (assumed minus true
        azimuth), with follow-up lag, pick-off harmonics, gimbal coupling, flexure and noise.
        """
        e, ship = self._errors, self._ship
        position = np.minimum((t_s - track.start_s) / GRID_S, TRACK_STEPS - 1e-9)
        step = np.maximum(position, 0.0).astype(np.int64)
        left, right = track.error_rad[step], track.error_rad[step + 1]
        error = left + (position - step) * (right - left)
        heading = ship.heading_rad(t_s)
        psi = heading - (track.azimuth_rad[step] + (position - step) * (
            track.azimuth_rad[step + 1] - track.azimuth_rad[step]))
        roll, pitch = ship.roll_pitch_rad(t_s)
        arcsec = (e.harmonic_arcsec * np.sin(psi + self._phases[0])
                  + e.harmonic2_arcsec * np.sin(2.0 * psi + self._phases[1]))
        indicated = np.degrees(
            heading + error - e.follow_up_s * ship.heading_rate_rad_s(t_s)
            + e.coupling * (roll + pitch) + track.flexure_rad[step]) + arcsec / 3600.0
        indicated += self._noise_deg * self._white.standard_normal(t_s.size)
        indicated = RESOLUTION_DEG * np.rint(indicated / RESOLUTION_DEG)
        given = track.validity[step] >= self._least
        return (np.where(given, indicated, np.nan),
                np.where(given, np.degrees(track.sigma_rad[step]), np.nan))
