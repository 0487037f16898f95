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

"""Where a ship points and goes, apart from the sea: what a course tells, and the current."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import NamedTuple, Protocol

import numpy as np

from heading_intercompare.core.records import Integers, Reals

from .earth import KNOT_M_S


@dataclass(frozen=True, slots=True)
class Current:
    """
    A steady current.

    Attributes
    ----------
    set_deg
        Where the water goes, degrees from true north.
    drift_kn
        How fast, knots.

    """

    set_deg: float = 0.0
    drift_kn: float = 0.0

    @property
    def velocity_m_s(self) -> tuple[float, float]:
        """Velocity of the water over ground to the east and the north, m/s."""
        drift = self.drift_kn * KNOT_M_S
        set_rad = math.radians(self.set_deg)
        return drift * math.sin(set_rad), drift * math.cos(set_rad)


NO_CURRENT = Current()


class Push(NamedTuple):
    """Acceleration of the ship over ground along its axis and to starboard, m/s^2."""

    ahead_m_s2: Reals
    aside_m_s2: Reals


class Course(Protocol):
    """
    The motion of a ship as it is steered; every method takes instants t_s, shape (n,).

    An instant gives the same bits whatever other instants are read with it.
    """

    def read_heading(self, t_s: Reals) -> tuple[Reals, Reals]:
        """Return the heading as a continuous angle, rad, and the rate of turn, rad/s."""

    def read_speed(self, t_s: Reals) -> Reals:
        """Return the speed through the water along the ship axis, m/s."""

    def read_velocity(self, t_s: Reals) -> tuple[Reals, Reals]:
        """Return the velocity over ground to the east and the north, m/s."""

    def read_push(self, t_s: Reals) -> Push:
        """Return the acceleration over ground in the axes of the ship."""

    def read_position(self, t_s: Reals) -> tuple[Reals, Reals]:
        """Return latitude and longitude, degrees."""

    def read_way(self, t_s: Reals) -> tuple[Reals, Reals]:
        """Return the way through the water since the start to the east and the north, metres."""


def interpolate_way(ways_m: Reals, speeds_m_s: Reals, step_s: float, t_s: Reals) -> Reals:
    """
    Return a way at any instants, by cubics through ways and speeds on an even grid from 0.

    Parameters
    ----------
    ways_m, speeds_m_s : ndarray, shape (m,)
        Of each step of the grid.
    step_s
        Step of the grid, seconds.
    t_s : ndarray, shape (n,)
        Seconds, none beyond the grid.

    """
    step: Integers = np.minimum((t_s / step_s).astype(np.int64), ways_m.size - 2)
    u = t_s / step_s - step
    left, right = ways_m[step], ways_m[step + 1]
    return (left + u * u * (3.0 - 2.0 * u) * (right - left)
            + step_s * u * (1.0 - u) * ((1.0 - u) * speeds_m_s[step] - u * speeds_m_s[step + 1]))
