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

"""Tracks and traces in bounded memory: where a ship was, and what its sensors showed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from heading_intercompare.core.records import Motion, Reals


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """
    What one sensor of a trial showed, in columns of equal time.

    Attributes
    ----------
    name
        The sensor.
    n
        Its readings.
    t_h : ndarray, shape (m,)
        Middle of each column, hours since the start.
    true_deg, heading_deg : ndarray, shape (m,)
        True heading and reading at the last valid reading of each column; nan without one.
    low_deg, high_deg : ndarray, shape (m,)
        Least and greatest error of the readings in each column.
    sigma_deg : ndarray, shape (m,)
        Greatest standard deviation that the sensor claims.
    modes
        Hour at which each mode begins, and its name; empty for sensors without.

    """

    name: str
    n: int
    t_h: Reals
    true_deg: Reals
    heading_deg: Reals
    low_deg: Reals
    high_deg: Reals
    sigma_deg: Reals
    modes: tuple[tuple[float, str], ...] = ()


MOST_POSITIONS = 4096


class Track:
    """
    At most 4096 positions of a record, in stamp order.

    Attributes
    ----------
    step_s : float
        Length of the spans of time, a power of two; each gives its first position.
    positions : Motion
    n : int
        Positions taken so far.

    Notes
    -----
    The spans lie at multiples of their length since 1970, so the track does not depend on the
    chunks. A position earlier than the one before it is skipped.

    """

    def __init__(self) -> None:
        self.n = 0
        self.step_s = 1.0
        self.positions = Motion.empty()

    def update(self, motion: Motion) -> None:
        """Take motion in any order within the chunk; rows without a position do not count."""
        rows = motion.positions().in_order()
        self.n += len(rows)
        if len(self.positions):
            rows = rows[rows.stamp_ns > self.positions.stamp_ns[-1]]
        self.positions = self._thin(self.positions + rows)
        while len(self.positions) > MOST_POSITIONS:
            self.step_s *= 2.0
            self.positions = self._thin(self.positions)

    def _thin(self, rows: Motion) -> Motion:
        """Return the first position of each span."""
        if not len(rows):
            return rows
        span = rows.stamp_ns // round(self.step_s * 1e9)
        return rows[np.flatnonzero(np.diff(span, prepend=span[0] - 1))]
