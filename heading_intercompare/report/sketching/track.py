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

"""The track of a ship in bounded memory: the first position of each span of time."""

from __future__ import annotations

import numpy as np

from heading_intercompare.core.records import Motion

__all__ = ['MOST_POSITIONS', 'Track']

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
