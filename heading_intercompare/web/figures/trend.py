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

"""The trend of the difference: its least and greatest value per column of a picture."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from heading_intercompare.core.records import Integers, Reals


class TrendColumn(NamedTuple):
    """
    The differences of one column.

    Attributes
    ----------
    age_s
        Time from the middle of the column to the end of the newest one, seconds.
    low_deg, high_deg
        Least and greatest difference in it, degrees.

    """

    age_s: float
    low_deg: float
    high_deg: float


class Trend:
    """
    Keeps the extremes of the last stretch of time, by stamps; memory does not grow.

    Parameters
    ----------
    span_s
        Length of the stretch, seconds.
    columns
        Number of columns, at least 2.

    Examples
    --------
    >>> trend = Trend(10.0, 10)
    >>> trend.take(np.array([10 ** 9, 10 ** 9 + 1, 3 * 10 ** 9]), np.array([0.1, 0.3, 0.2]))
    >>> [tuple(column) for column in trend.columns()]
    [(2.5, 0.1, 0.3), (0.5, 0.2, 0.2)]

    """

    def __init__(self, span_s: float = 1800.0, columns: int = 600) -> None:
        self.span_s = span_s
        self._n = columns
        self._width_ns = round(span_s * 1e9 / columns)
        self._newest: int | None = None
        self._clear()

    def _clear(self) -> None:
        self._place = np.full(self._n, -1, np.int64)
        self._low = np.full(self._n, np.inf)
        self._high = np.full(self._n, -np.inf)

    def take(self, stamp_ns: Integers, x_deg: Reals) -> None:
        """
        Take differences, degrees, with their stamps, nanoseconds; nan is left out.

        If the clock is set back by more than the stretch, the trend begins again.
        """
        finite = np.isfinite(x_deg)
        place, x_deg = stamp_ns[finite] // self._width_ns, x_deg[finite]
        if not len(place):
            return
        greatest = int(place.max())
        if self._newest is not None and greatest <= self._newest - self._n:
            self._clear()
            self._newest = None
        self._newest = greatest if self._newest is None else max(greatest, self._newest)
        inside = place > self._newest - self._n
        place, x_deg = place[inside], x_deg[inside]
        slot = place % self._n
        old = self._place[slot] != place
        self._low[slot[old]], self._high[slot[old]] = np.inf, -np.inf
        self._place[slot] = place
        np.minimum.at(self._low, slot, x_deg)
        np.maximum.at(self._high, slot, x_deg)

    def columns(self) -> tuple[TrendColumn, ...]:
        """Return the columns that hold differences, oldest first."""
        if self._newest is None:
            return ()
        back = self._newest - self._place
        slots = np.flatnonzero((back < self._n) & (self._place >= 0))
        slots = slots[np.argsort(-back[slots])]
        ages_s = (back[slots] + 0.5) * (self._width_ns / 1e9)
        return tuple(map(TrendColumn._make, zip(
            ages_s.tolist(), self._low[slots].tolist(), self._high[slots].tolist())))
