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


class CubicSpline:
    """
    A cubic spline through values at uneven times.

    Parameters
    ----------
    t_s : ndarray, shape (n,)
        Increasing times, seconds; n >= 4.
    values : ndarray, shape (n,) or (n, k)
        What the spline passes through.

    Notes
    -----
    The third derivative does not change at the second and at the last but one time. Outside the
    times, the first and the last piece go on.

    References
    ----------
    de Boor 1978, *A Practical Guide to Splines*, chapter IV, "not-a-knot".

    """

    def __init__(self, t_s: Reals, values: Reals) -> None:
        step = np.diff(t_s)
        wide = step.reshape(-1, *[1] * (values.ndim - 1))
        slope = np.diff(values, axis=0) / wide
        first, last = t_s[2] - t_s[0], t_s[-1] - t_s[-3]
        # The equations of the derivatives at the times; those at both ends are put into the next.
        begin = ((step[0] + 2.0 * first) * step[1] * slope[0] + step[0] ** 2 * slope[1]) / first
        end = ((step[-1] + 2.0 * last) * step[-2] * slope[-1] + step[-1] ** 2 * slope[-2]) / last
        middle = 2.0 * (step[:-1] + step[1:])
        middle[0] -= first
        middle[-1] -= last
        right = 3.0 * (wide[1:] * slope[:-1] + wide[:-1] * slope[1:])
        right[0] -= begin
        right[-1] -= end
        before, after = step[1:].copy(), step[:-1].copy()
        before[0] = after[-1] = 0.0
        rate = np.empty_like(values)
        rate[1:-1] = _solve(before.reshape(wide[1:].shape), middle.reshape(wide[1:].shape),
                            after.reshape(wide[1:].shape), right)
        rate[0] = (begin - first * rate[1]) / step[1]
        rate[-1] = (end - last * rate[-2]) / step[-2]
        bend = (rate[:-1] + rate[1:] - 2.0 * slope) / wide
        self._t_s = t_s
        self._terms = values[:-1], rate[:-1], (slope - rate[:-1]) / wide - bend, bend / wide

    def __call__(self, t_s: Reals) -> Reals:
        """Return the values at times, shape (m,) or (m, k)."""
        at = np.clip(np.searchsorted(self._t_s, t_s, side='right') - 1, 0, self._t_s.size - 2)
        value, rate, square, cube = (term[at] for term in self._terms)
        since = (t_s - self._t_s[at]).reshape(-1, *[1] * (value.ndim - 1))
        result: Reals = ((cube * since + square) * since + rate) * since + value
        return result


def _solve(before: Reals, middle: Reals, after: Reals, right: Reals) -> Reals:
    """
    Solve tridiagonal equations in which the middle of each outweighs its neighbours.

    By cyclic reduction (Hockney 1965): each second unknown is put into its neighbours, again and
    again, and then found from them.
    """
    n = len(middle)
    if n == 1:
        return right / middle
    # The unknowns with odd numbers are kept, and those before and after them put into them.
    odd, first, second = slice(1, None, 2), slice(0, n - n % 2, 2), slice(2, None, 2)
    lower = before[odd] / middle[first]
    new_middle = middle[odd] - lower * after[first]
    new_right = right[odd] - lower * right[first]
    new_before, new_after = -lower * before[first], np.zeros_like(new_middle)
    # The last one kept may have none after it.
    inner = slice(0, (n - 1) // 2)
    upper = after[odd][inner] / middle[second]
    new_middle[inner] -= upper * before[second]
    new_right[inner] -= upper * right[second]
    new_after[inner] = -upper * after[second]
    odd_roots = _solve(new_before, new_middle, new_after, new_right)
    rest = right[::2].copy()
    rest[1:] -= before[second] * odd_roots[inner]
    rest[:n // 2] -= after[first] * odd_roots
    roots = np.empty_like(right)
    roots[odd], roots[::2] = odd_roots, rest / middle[::2]
    return roots


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
