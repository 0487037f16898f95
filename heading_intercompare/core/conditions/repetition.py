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

"""Ranges of both sensors in windows of time, which bound what a repeating sensor may miss."""

from __future__ import annotations

import math

import numpy as np

from heading_intercompare.core.angles import unwrap_deg
from heading_intercompare.core.records import Reals

_PART_S = 1.0
_MOST_PARTS = 1024
_PER_PART = 16
_GOLDEN = 0.6180339887498949
_LOOKED_AT = 1 << 14
_WINDOWS = 64
_PER_LENGTH, _MOST_BEGINS = 32, 1 << 16
_LEAST_WINDOWS = 8
_LEAST_READINGS = 4
_SHORTEST_S = 8.0
_FOLLOWS = 0.3
_FOLLOWS_S = 16.0
_SPAN_SHARE = 0.9
_SWING_S = 32.0
_NORMS, _RANGE_NORMS = 1.5, 8.0


def _part_means(stamps: np.ndarray, values: np.ndarray) -> np.ndarray:
    """
    Return means of a heading over about a second each, or the readings if they are fewer.

    Parameters
    ----------
    stamps : ndarray of int64, shape (n,)
        Stamps in increasing order, nanoseconds; n >= 1.
    values : ndarray, shape (n,)
        Headings or differences, degrees.

    Returns
    -------
    ndarray, shape (m,)
        Unwrapped means of at most 1024 parts, spread over the time.

    """
    span = (int(stamps[-1]) - int(stamps[0])) / 1e9
    parts = min(values.size, max(1, math.floor(span / _PART_S)))
    if parts < 2:
        return unwrap_deg(values)
    if parts <= _MOST_PARTS and values.size <= _LOOKED_AT:
        edges = np.linspace(0, values.size, parts + 1).astype(np.int64)
        return np.add.reduceat(unwrap_deg(values), edges[:-1]) / np.diff(edges)
    # Longer parts would average a swell away, and evenly spaced ones could keep step with it.
    count = min(parts, _MOST_PARTS)
    k = np.arange(count)
    width = values.size // parts
    begins = ((k + (_GOLDEN * k) % 1.0) * (parts / count)).astype(np.int64) * values.size // parts
    inside = np.arange(0, width, max(1, width // _PER_PART))
    index = np.minimum(begins[:, None] + inside, values.size - 1)
    means: Reals = unwrap_deg(values[index].ravel()).reshape(index.shape).mean(axis=1)
    return means


def _range_deg(stamps: np.ndarray, values: np.ndarray) -> float:
    """Return the range of headings, of their means over about a second; 0 for n = 0."""
    return float(np.ptp(_part_means(stamps, values))) if values.size else 0.0


class Windows:
    """
    The motion of both sensors in windows without a long repetition.

    Parameters
    ----------
    stamps : ndarray of int64, shape (n,)
        Stamps in increasing order, nanoseconds; n >= 2.
    heading, other_deg : ndarray, shape (n,)
        Headings of the sensor examined, and of the other sensor, degrees.
    busy : ndarray of bool, shape (n,)
        Whether a reading belongs to a long repetition of the sensor.
    other_step_deg
        Step in which the other sensor reports, degrees; 0 if unknown.
    sigma_deg
        Norm of the errors of the other sensor, degrees.

    """

    def __init__(self, stamps: np.ndarray, heading: np.ndarray, other_deg: np.ndarray,
                 busy: np.ndarray, other_step_deg: float, sigma_deg: float | None) -> None:
        self._stamps, self._heading, self._other_deg = stamps, heading, other_deg
        self._before = np.append(0, np.cumsum(busy))
        self._other_step_deg, self._sigma_deg = other_step_deg, sigma_deg
        self._least_s = _LEAST_READINGS * float(np.median(np.diff(stamps[:_LOOKED_AT]))) / 1e9
        self._measured: dict[float, tuple[np.ndarray, int]] = {}

    def excess(self, lo: int, hi: int, grain_deg: float) -> tuple[float, float] | None:
        """
        Tell whether the other sensor moves too far for a repetition of a working sensor.

        Parameters
        ----------
        lo, hi
            Readings lo <= i < hi are the repetition.
        grain_deg
            Range allowed for the other sensor if neither has errors, degrees.

        Returns
        -------
        moved_deg, allowed_deg : float
            Range of the other sensor, and the range allowed, degrees. None if it stays within.

        """
        moved = _range_deg(self._stamps[lo:hi], self._other_deg[lo:hi])
        if moved <= grain_deg:
            return None
        span = max((int(self._stamps[hi - 1]) - int(self._stamps[lo])) / 1e9, self._least_s,
                   _PART_S)
        length = _PART_S * 2.0 ** math.ceil(math.log2(span))
        rows, _ = self._ranges(length)
        rounded = grain_deg + self._other_step_deg
        if rows.shape[1] >= _LEAST_WINDOWS:
            allowed = _allowed_deg(rows, length, moved, rounded)
            return (moved, allowed) if moved > allowed else None
        longest = None
        while length >= max(2.0 * _SHORTEST_S, 2.0 * self._least_s):
            length *= 0.5
            rows, apart = self._ranges(length)
            if apart < _LEAST_WINDOWS or length > span:
                continue
            most = max((_range_deg(self._stamps[a:b], self._other_deg[a:b])
                        for a, b in self._make_windows(lo, hi, length, 2)), default=0.0)
            allowed = _allowed_deg(rows, length, most, rounded)
            if most > allowed:
                return most, allowed
            longest = allowed if longest is None else longest
        if longest is None:
            return self._exceed_norm(lo, hi, moved, grain_deg)
        # A slow turn shows only over the whole repetition.
        allowed = longest + _RANGE_NORMS * (self._sigma_deg or 0.0)
        return (moved, allowed) if moved > allowed else None

    def _exceed_norm(self, lo: int, hi: int, moved: float,
                     grain_deg: float) -> tuple[float, float] | None:
        """Judge by the norm of the other sensor if the rest of the run shows nothing."""
        if 2 * int(self._before[-1]) <= self._before.size - 1:
            return None
        sigma = self._sigma_deg or 0.0
        allowed = grain_deg + _RANGE_NORMS * sigma
        if moved > allowed:
            return moved, allowed
        swings = [float(np.var(_part_means(self._stamps[a:b], self._other_deg[a:b]), ddof=1))
                  for a, b in self._make_windows(lo, hi, _SWING_S, 1)]
        if len(swings) < _LEAST_WINDOWS:
            return None
        # The range of a sine is 2 sqrt(2) times its standard deviation.
        moved = math.sqrt(8.0 * float(np.mean(swings)))
        allowed = math.sqrt(8.0) * math.hypot(0.5 * grain_deg, _NORMS * sigma)
        return (moved, allowed) if moved > allowed else None

    def _make_windows(self, lo: int, hi: int, length_s: float,
                      per_length: int) -> list[tuple[int, int]]:
        """Return at most 64 even windows of a length within a repetition."""
        stamps, length = self._stamps, round(length_s * 1e9)
        begins = np.arange(int(stamps[lo]), int(stamps[hi - 1]) - length + 1,
                           length // per_length)
        if begins.size > _WINDOWS:
            begins = begins[np.linspace(0, begins.size - 1, _WINDOWS).astype(np.int64)]
        a, b = np.searchsorted(stamps, begins), np.searchsorted(stamps, begins + length)
        enough = b - a >= _LEAST_READINGS
        return list(zip(a[enough].tolist(), b[enough].tolist()))

    def _ranges(self, length_s: float) -> tuple[np.ndarray, int]:
        """Return ranges of sensor, other and difference; and the number of disjoint windows."""
        if length_s not in self._measured:
            self._measured[length_s] = self._measure(round(length_s * 1e9))
        return self._measured[length_s]

    def _measure(self, length: int) -> tuple[np.ndarray, int]:
        stamps, whole = self._stamps, int(self._stamps[-1]) - int(self._stamps[0])
        if 2 * length >= whole:
            return np.empty((3, 0)), 0
        begins = np.arange(int(stamps[0]), int(stamps[-1]) - length + 1,
                           max(length // _PER_LENGTH, whole // _MOST_BEGINS))
        lo, hi = np.searchsorted(stamps, begins), np.searchsorted(stamps, begins + length)
        usable = (hi - lo >= 2) & (self._before[hi] == self._before[lo])
        usable &= stamps[np.maximum(hi - 1, 0)] - stamps[np.minimum(lo, hi - 1)] >= 0.5 * length
        lo, hi, begins = lo[usable], hi[usable], begins[usable]
        if lo.size > _WINDOWS:
            picked = np.linspace(0, lo.size - 1, _WINDOWS).astype(np.int64)
            lo, hi, begins = lo[picked], hi[picked], begins[picked]
        rows, apart, end = [], 0, int(stamps[0])
        for a, b, begin in zip(lo.tolist(), hi.tolist(), begins.tolist()):
            sensor_deg, other_deg = self._heading[a:b], self._other_deg[a:b]
            rows.append([_range_deg(stamps[a:b], h)
                         for h in (sensor_deg, other_deg, sensor_deg - other_deg)])
            if begin >= end:
                apart, end = apart + 1, begin + length
        return np.array(rows).reshape(-1, 3).T, apart


def _allowed_deg(rows: np.ndarray, length_s: float, moved_deg: float, grain_deg: float) -> float:
    """Return the range allowed for the other sensor while a working sensor repeats its value."""
    sensor, others, errors = rows
    alike = (others >= 0.5 * moved_deg) & (others <= 2.0 * moved_deg)
    if length_s >= _FOLLOWS_S and np.count_nonzero(alike) >= _LEAST_WINDOWS:
        # Even at rest, a window without a long repetition holds changes by a step or two.
        follows = (sensor >= _FOLLOWS * others) & (sensor > grain_deg)
        if np.mean(follows[alike]) >= _SPAN_SHARE:
            return grain_deg
    return grain_deg + 2.0 * float(np.quantile(errors, _SPAN_SHARE))
