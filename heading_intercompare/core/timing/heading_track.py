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

"""The heading of one sensor as a continuous function of time."""

from __future__ import annotations

from functools import cached_property
import math

import numpy as np

from heading_intercompare.core.angles import unwrap_deg
from heading_intercompare.core.records import Headings, Reals
from heading_intercompare.core.statistics.blocking import pick_stretches

_ROUNDING_S = 5e-10
_PIECE = 1 << 14


def select_usable(headings: Headings) -> Headings:
    """Return the readings that are finite and whose stamps increase."""
    finite = np.isfinite(headings.heading_deg)
    if not finite.all():
        headings = headings[finite]
    stamps = headings.stamp_ns
    if stamps.size > 1 and not (stamps[1:] > stamps[:-1]).all():
        newest = np.maximum.accumulate(stamps)
        headings = headings[np.concatenate(([True], stamps[1:] > newest[:-1]))]
    return headings


class Track:
    """
    The heading of one sensor as a continuous function of time.

    Parameters
    ----------
    headings
        Readings that are not finite, or whose stamp does not increase, are skipped.
    origin_ns
        Stamp of time zero, nanoseconds.

    Attributes
    ----------
    t_s, heading_deg : ndarray, shape (n,)
        Times of the readings, seconds after the origin; unwrapped headings, degrees.

    """

    def __init__(self, headings: Headings, origin_ns: int = 0) -> None:
        headings = select_usable(headings)
        self.t_s: Reals = np.empty(len(headings))
        # Pieces need no memory for a whole column between.
        for lo in range(0, len(headings), _PIECE):
            part = slice(lo, lo + _PIECE)
            np.divide(headings.stamp_ns[part] - origin_ns, 1e9, out=self.t_s[part])
        self.heading_deg: Reals = unwrap_deg(headings.heading_deg)
        self._gaps: dict[float, np.ndarray] = {}

    @classmethod
    def of(cls, t_s: Reals, heading_deg: Reals) -> 'Track':
        """Return a track of unwrapped headings at increasing times, without a copy."""
        track = cls(Headings.empty())
        track.t_s, track.heading_deg = t_s, heading_deg
        return track

    @cached_property
    def step_s(self) -> float:
        """Median step from reading to reading, seconds; at least two readings."""
        return float(np.median(np.concatenate([np.diff(self.t_s[part])
                                               for part in pick_stretches(len(self))])))

    def _find_gaps(self, max_gap_s: float) -> np.ndarray:
        """Return the readings before a longer silence."""
        if max_gap_s not in self._gaps:
            self._gaps[max_gap_s] = np.flatnonzero(np.diff(self.t_s) > max_gap_s) \
                if max_gap_s < math.inf else np.empty(0, np.int64)
        return self._gaps[max_gap_s]

    def __len__(self) -> int:
        return len(self.t_s)

    def at(self, t_s: Reals) -> Reals:
        """Return unwrapped headings, interpolated to times within those of the readings."""
        return np.interp(t_s, self.t_s, self.heading_deg)

    def rate(self, t_s: Reals, half_span_s: float) -> Reals:
        """Return the mean rate from `half_span_s` before to `half_span_s` after, deg/s."""
        return (self.at(t_s + half_span_s) - self.at(t_s - half_span_s)) / (2.0 * half_span_s)

    def covers(self, from_s: Reals, to_s: Reals, max_gap_s: float = math.inf) -> np.ndarray:
        """Tell which spans of time lie wholly between readings at most `max_gap_s` apart."""
        if not len(self):
            return np.zeros(from_s.shape, bool)
        # Half a nanosecond, the unit of stamps, absorbs the rounding of seconds.
        from_s, to_s = from_s + _ROUNDING_S, to_s - _ROUNDING_S
        good: np.ndarray = (from_s >= self.t_s[0]) & (to_s <= self.t_s[-1])
        gaps = self._find_gaps(max_gap_s)
        if gaps.size:
            # Equal counts of gaps ended before the span and begun by its end: none within.
            ended = np.searchsorted(self.t_s[gaps + 1], from_s, side='right')
            begun = np.searchsorted(self.t_s[gaps], to_s, side='left')
            good &= ended == begun
        return good


class RisingTimes:
    """
    A track at a set of times that rise together from call to call.

    To search for each time in a long track costs more than the rest, and most times move by a
    reading or two.

    Parameters
    ----------
    track
        Of at least two readings.
    t_s : array_like, shape (n,)
        The first times, within those of the readings.

    """

    def __init__(self, track: Track, t_s: Reals) -> None:
        self._t_s, self._heading_deg = track.t_s, track.heading_deg
        # The last reading begins no step.
        self._last = self._t_s.size - 2
        self._at = np.clip(np.searchsorted(self._t_s, t_s, side='right') - 1, 0, self._last)
        self._step()

    def _step(self) -> None:
        """Read the step of the track in which each time lies."""
        self._from_s, self._from_deg = self._t_s[self._at], self._heading_deg[self._at]
        self._to_s = self._t_s[self._at + 1]
        self._slope = ((self._heading_deg[self._at + 1] - self._from_deg)
                       / (self._to_s - self._from_s))

    def at(self, t_s: Reals) -> Reals:
        """Return unwrapped headings as `Track.at` does; no time is before its last one."""
        late = np.flatnonzero((t_s >= self._to_s) & (self._at < self._last))
        while late.size:
            self._at[late] += 1
            self._step()
            late = late[(t_s[late] >= self._to_s[late]) & (self._at[late] < self._last)]
        return self._slope * (t_s - self._from_s) + self._from_deg
