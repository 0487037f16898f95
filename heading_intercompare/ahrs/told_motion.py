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

"""What a simulated ship tells of its motion: a GNSS receiver and an indicator of rate of turn."""

from __future__ import annotations

import math

import numpy as np

from heading_intercompare.ahrs.ship.ship_motion import ShipTruth
from heading_intercompare.core.records import Motion, Reals

from .random_noise import open_stream

__all__ = ['ToldMotion']

POSITION_SIGMA_M = 1.0
"""Standard deviation of a position to the north and to the east, metres; white."""

VELOCITY_SIGMA_M_S = 0.05
"""Standard deviation of a velocity to the north and to the east, m/s; white."""

RATE_SIGMA_DEG_S = 0.05
"""Standard deviation of a rate of turn, degrees per second; white."""

_BLOCK = 64
_METRES_A_DEGREE = 111_200.0


class ToldMotion:
    """
    The motion of a ship as its receivers tell it, at a fixed rate and without latency.

    Parameters
    ----------
    ship : ShipTruth
    start_ns : int
        UTC stamp of the start, nanoseconds.
    seed : int
        Seed of the simulation.
    rate_hz : float
        Rows a second of each kind; 0: none.
    duration_s : float
        Length of the trial, seconds.

    Notes
    -----
    Position and velocity are those over ground, with the current; the sea moves neither. The rate
    of turn is that of the ship in the sea.

    """

    def __init__(self, ship: ShipTruth, start_ns: int, seed: int, rate_hz: float,
                 duration_s: float) -> None:
        self._ship, self._start_ns, self._rate_hz = ship, start_ns, rate_hz
        self._rng = open_stream(seed, 'motion')
        self._n = math.ceil(duration_s * rate_hz)
        self._next = 0
        self._noise = np.empty((5, 0))

    def take(self, end_s: float) -> Motion:
        """Return the rows since the last call and before `end_s`."""
        stop = max(self._next, min(self._n, math.ceil(end_s * self._rate_hz)))
        if stop == self._next:
            return Motion.empty()
        t_s = np.arange(self._next, stop) / self._rate_hz
        noise = self._draw(stop - self._next)
        self._next = stop
        stamps = self._start_ns + np.rint(t_s * 1e9).astype(np.int64)
        latitude, longitude = self._ship.position_deg(t_s)
        east, north = self._ship.velocity_m_s(t_s)
        metres = POSITION_SIGMA_M * noise[:2] / _METRES_A_DEGREE
        return Motion.concatenate([
            Motion.of_positions(stamps, latitude + metres[0],
                                longitude + metres[1] / np.cos(np.radians(latitude))),
            Motion.of_velocities(stamps, east + VELOCITY_SIGMA_M_S * noise[2],
                                 north + VELOCITY_SIGMA_M_S * noise[3]),
            Motion.of_rates(stamps, np.degrees(self._ship.heading_rate_rad_s(t_s))
                            + RATE_SIGMA_DEG_S * noise[4])])

    def _draw(self, n: int) -> Reals:
        """Return the next numbers, shape (5, n); drawn in blocks, whatever the chunks."""
        while self._noise.shape[1] < n:
            more = self._rng.standard_normal((5, _BLOCK))
            self._noise = np.concatenate((self._noise, more), axis=1)
        drawn, self._noise = self._noise[:, :n], self._noise[:, n:]
        return drawn
