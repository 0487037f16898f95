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

"""The difference of a tested sensor from the reference: the newest, its trends, their centre."""

from __future__ import annotations

import numpy as np

from heading_intercompare.core.pairing.difference import subtract
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.settings import Settings

from .trend import Trend, TrendColumn

SPANS_S = (1800.0, 6 * 3600.0, 24 * 3600.0)
"""Lengths of the trends, seconds."""

#: The long trends and the centre change slowly.
_SLOW_S = 10.0


class DifferenceWatch:
    """
    Watches the pairs of one tested sensor with the reference; memory is bounded.

    Parameters
    ----------
    settings
        Of the pair. In variant A the mean is known, so the limits stand about zero.

    Attributes
    ----------
    x_deg, stamp_ns, came_s
        The newest difference, degrees, its stamp, and when it came; None before the first.

    """

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._centred = settings.variant == 'A'
        self._trends = tuple(Trend(span_s) for span_s in SPANS_S)
        self._slow: tuple[tuple[float, tuple[TrendColumn, ...]], ...] = ()
        self._slow_s = self._center_s = -np.inf
        self.center_deg = 0.0
        self.x_deg: float | None = None
        self.stamp_ns: int | None = None
        self.came_s: float | None = None

    def take(self, pairs: Pairs, now_s: float) -> None:
        """Take pairs in the order of their stamps, at a time of a steady clock, seconds."""
        differences = subtract(pairs, self._settings.installation_offset_deg,
                               self._settings.wrap_center_deg)
        self.came_s = now_s
        self.x_deg = float(differences.x_deg[-1])
        self.stamp_ns = int(differences.stamp_ns[-1])
        for trend in self._trends:
            trend.take(differences.stamp_ns, differences.x_deg)

    def age_s(self, now_s: float) -> float | None:
        """Return the time since the last pair came, seconds; None before the first."""
        return None if self.came_s is None else now_s - self.came_s

    def columns(self) -> tuple[TrendColumn, ...]:
        """Return the columns of the shortest trend, oldest first."""
        return self._trends[0].columns()

    def longer_columns(self, now_s: float) -> tuple[tuple[float, tuple[TrendColumn, ...]], ...]:
        """Return length and columns of the long trends; they change every ten seconds."""
        if now_s >= self._slow_s + _SLOW_S:
            self._slow_s = now_s
            self._slow = tuple((trend.span_s, trend.columns()) for trend in self._trends[1:])
        return self._slow

    def follow_center(self, columns: tuple[TrendColumn, ...], sound: bool, now_s: float) -> float:
        """
        Return the centre of the limits, degrees.

        Where the mean is not known it is the median of the trend, which a fault of less than half
        of it does not move. While the comparison is not sound the centre stays where it was.
        """
        due = now_s >= self._center_s + _SLOW_S
        if columns and due and not self._centred and (sound or np.isinf(self._center_s)):
            self._center_s = now_s
            self.center_deg = float(np.median(
                [0.5 * (column.low_deg + column.high_deg) for column in columns]))
        return self.center_deg
