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

"""
A heading between the readings of a sensor, by up to eight of them, from their stamps alone.

The weights are those of the best estimate for motion with a flat spectrum up to a band limit that
keep cubics exact. A straight line lacks the motion of a few steps; eight readings do not.
"""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import NamedTuple

import numpy as np

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.records import Integers, Reals

SHORTER = (3, 2, 1)
"""Readings on either side whose values are compared with that by four on either side."""

_LONGEST = 4
#: Up to the first step four readings suffice. Above the second one they do not, nanoseconds.
_FAST_NS, _MIDDLE_NS = 250_000_000, 500_000_000
#: Band limit in radians per step, by the readings on either side.
_BAND = {3: 1.6, 4: 1.8}
_RIDGE = 1e-5
_POWERS = (0, 1, 2, 3)
LARGEST_FACTOR = 1.2
"""On uneven stamps a kernel may amplify white noise, but by no more than this factor."""
_AT_ONCE = 1 << 14


def reach(step_ns: int) -> int:
    """Return how many readings on either side are used, for a sensor with this usual step."""
    return 2 if step_ns <= _FAST_NS else _LONGEST


def longest_step_ns(step_ns: int) -> int:
    """
    Return the longest step that a kernel bridges, for a sensor with this usual step.

    It is half as much again as usual. A fast sensor may miss a few readings: in a quarter of a
    second no ship moves so that they matter.
    """
    return max(3 * step_ns // 2, _FAST_NS if 0 < step_ns <= _FAST_NS else 0)


def interpolated_response(factor: float, step_ns: int, frequency: Reals) -> Reals:
    """
    Return what interpolation leaves of the power of the noise of a sensor.

    Parameters
    ----------
    factor
        What it leaves of white noise, the mean over the frequencies.
    step_ns
        Usual step of the sensor, nanoseconds.
    frequency : ndarray, shape (n,)
        Frequencies over half the rate of the sensor, from 0 to 1.

    Notes
    -----
    1 - (1 - f) (1 - cos(pi u))^k / mean((1 - cos)^k), k = 2 for four readings and 8 for eight:
    within 0.045 of the response of both kernels at any place between two readings.

    """
    k = 2 if step_ns <= _FAST_NS else 8
    lost = (1.0 - np.cos(np.pi * frequency)) ** k * 2.0 ** k / math.comb(2 * k, k)
    return np.asarray(np.maximum(1.0 - (1.0 - factor) * lost, 0.0))


def find_left(stamp_ns: Integers, t_ns: Integers) -> Integers:
    """Return the index of the last reading at or before each stamp; -1 if there is none."""
    first = int(np.searchsorted(stamp_ns, t_ns[0], side='right')) - 1
    after = stamp_ns[first + 1:first + 1 + t_ns.size]
    if first >= 0 and after.size == t_ns.size and (t_ns < after).all() and (
            stamp_ns[first:first + t_ns.size] <= t_ns).all():
        # The streams alternate.
        return np.arange(first, first + t_ns.size)
    return np.searchsorted(stamp_ns, t_ns, side='right') - 1


@dataclass(frozen=True, slots=True, eq=False)
class Bridged:
    """
    Headings between the readings of one sensor.

    Attributes
    ----------
    side : ndarray of int8, shape (n,)
        Readings used on either side of each stamp; 0 if no kernel bridges it.
    heading_deg : ndarray, shape (n,)
        The headings, not reduced to a turn; nan if not bridged.
    factor : ndarray, shape (n,)
        Sum of the squared weights: what remains of the variance of white noise.
    compared : ndarray of int64, shape (k,)
        Where the value by the most readings is compared with those by fewer.
    apart_deg2 : ndarray, shape (k, 3)
        The squared distances from it of the values by `SHORTER`.

    """

    side: np.ndarray
    heading_deg: Reals
    factor: Reals
    compared: Integers
    apart_deg2: Reals


class _Values(NamedTuple):
    """Headings relative to the reading before, degrees, and the sums of squared weights."""

    rise_deg: Reals
    factor: Reals


class _Readings:
    """The readings around stamps between them."""

    def __init__(self, stamp_ns: Integers, turn_deg: Reals, left: Integers, t_ns: Integers,
                 step_ns: int) -> None:
        self._stamp_ns, self._turn_deg, self._step_ns = stamp_ns, turn_deg, step_ns
        self._left, self._t_ns = left, t_ns
        n = left.size
        self._first = int(left[0]) if n and int(left[-1]) - int(left[0]) == n - 1 and (
            np.diff(left) == 1).all() else None

    def among(self, at: np.ndarray) -> _Readings:
        """Return the same for some of the stamps."""
        return _Readings(self._stamp_ns, self._turn_deg, self._left[at], self._t_ns[at],
                         self._step_ns)

    def _pick(self, column: np.ndarray, offset: int) -> np.ndarray:
        """Return the entries at a distance from the reading before each stamp."""
        if self._first is None:
            return column[self._left + offset]
        return column[self._first + offset:self._first + offset + self._left.size]

    def by(self, side: int) -> _Values:
        """Return the values by this number of readings on either side."""
        if side == 1:
            return self._line()
        return self._cubic() if side == 2 else self._best(side)

    def _line(self) -> _Values:
        before = self._pick(self._stamp_ns, 0)
        w = (self._t_ns - before) / (self._pick(self._stamp_ns, 1) - before)
        return _Values(w * self._pick(self._turn_deg, 0), (1.0 - w) ** 2 + w ** 2)

    def _cubic(self) -> _Values:
        """Return the values by Lagrange's cubic."""
        stamps = [self._pick(self._stamp_ns, k) for k in (-1, 0, 1, 2)]
        before, step, after = (b - a for a, b in zip(stamps, stamps[1:]))
        s = (self._t_ns - stamps[1]).astype(np.float64)
        p, q, r = s + before, s - step, s - (step + after)
        left, right = before + step, step + after
        # As floats, for products of three steps exceed 64 bits.
        pq, sr, whole = p * q, s * r, (left + after).astype(np.float64)
        c = (-sr * q / (before * whole * left), pq * r / (before * right.astype(float) * step),
             -p * sr / (step * after.astype(float) * left), pq * s / (after * whole * right))
        turn = self._pick(self._turn_deg, 0)
        rise = -c[0] * self._pick(self._turn_deg, -1) + c[2] * turn + c[3] * (
            turn + self._pick(self._turn_deg, 1))
        return _Values(rise, c[0] * c[0] + c[1] * c[1] + c[2] * c[2] + c[3] * c[3])

    def _best(self, side: int) -> _Values:
        """Return the values by the best estimate in the band."""
        rise, factor = np.empty(self._left.size), np.empty(self._left.size)
        for lo in range(0, self._left.size, _AT_ONCE):
            part = slice(lo, lo + _AT_ONCE)
            rise[part], factor[part] = self._best_of(side, self._left[part], self._t_ns[part])
        return _Values(rise, factor)

    def _best_of(self, side: int, left: Integers, t_ns: Integers) -> tuple[Reals, Reals]:
        begins = np.diff(left, prepend=-1) != 0
        at, which = left[begins], np.cumsum(begins) - 1
        around = at[:, None] + np.arange(1 - side, side + 1)
        # From the reading before the stamp: the system is that of all stamps of the bracket.
        x = (self._stamp_ns[around] - self._stamp_ns[at][:, None]) / self._step_ns
        alike = bool((x == x[0]).all())
        weights = _invert(x[:1] if alike else x, side)
        system = np.zeros_like(which) if alike else which
        s = (t_ns - self._stamp_ns[left]) / self._step_ns
        band = _BAND[side]
        targets = [_sinc(band * (x[which, k] - s)) for k in range(2 * side)]
        targets += [(s / side) ** p for p in _POWERS]
        c = np.zeros((s.size, 2 * side))
        for j, column in enumerate(targets):
            c += weights[system, :, j] * column[:, None]
        turns = self._turn_deg[around[:, :-1]]
        rise = np.zeros((at.size, 2 * side))
        for k in range(side, 2 * side):
            rise[:, k] = rise[:, k - 1] + turns[:, k - 1]
        for k in range(side - 2, -1, -1):
            rise[:, k] = rise[:, k + 1] - turns[:, k]
        value, factor = np.zeros(s.size), np.zeros(s.size)
        for k in range(2 * side):
            value += c[:, k] * rise[which, k]
            factor += c[:, k] * c[:, k]
        return value, factor


def _sinc(x: Reals) -> Reals:
    """Return sin(x) / x."""
    safe = np.where(x == 0.0, 1.0, x)
    return np.where(x == 0.0, 1.0, np.sin(safe) / safe)


def _invert(x: Reals, side: int) -> Reals:
    """Return what the weights are as linear functions of the right-hand side, by bracket."""
    n, m = x.shape
    system = np.zeros((n, m + len(_POWERS), m + len(_POWERS)))
    system[:, :m, :m] = _sinc(_BAND[side] * (x[:, :, None] - x[:, None, :]))
    system[:, range(m), range(m)] += _RIDGE
    for p in _POWERS:
        system[:, :m, m + p] = system[:, m + p, :m] = (x / side) ** p
    return np.linalg.inv(system)[:, :m]


def _find_reaches(is_good: np.ndarray) -> np.ndarray:
    """Return how many readings on either side of each step lie among good steps, at most 4."""
    reaches = is_good.astype(np.int8)
    wide = is_good
    for side in range(1, _LONGEST):
        outer = np.zeros_like(is_good)
        if is_good.size > 2 * side:
            outer[side:-side] = is_good[2 * side:] & is_good[:-2 * side]
        wide = wide & outer
        reaches += wide
    return reaches


def interpolate(stamp_ns: Integers, heading_deg: Reals, is_good: np.ndarray, left: Integers,
                t_ns: Integers, step_ns: int, *, is_line: bool = False) -> Bridged:
    """
    Interpolate the headings of a sensor to stamps between its readings.

    Parameters
    ----------
    stamp_ns : ndarray of int64, shape (r,)
        Increasing stamps of the readings, nanoseconds.
    heading_deg : ndarray, shape (r,)
        Their headings, degrees.
    is_good : ndarray of bool, shape (r - 1,)
        Whether the step from each reading to the next may be bridged.
    left : ndarray of int64, shape (n,)
        Index of the last reading before each stamp, ascending, from 0 to r - 2.
    t_ns : ndarray of int64, shape (n,)
        The stamps, none equal to that of a reading.
    step_ns
        Usual step of the sensor, nanoseconds.
    is_line
        Whether the values are those of the line between two readings; the longest kernel is then
        only compared with it.

    Returns
    -------
    Bridged
        Each value depends on the readings around its stamp alone.

    Notes
    -----
    With x_k = (t_k - t) / h the weights c solve
    sum_j [sinc(b (x_k - x_j)) + 1e-5 delta_kj] c_j + sum_p l_p x_k^p = sinc(b x_k) and
    sum_k c_k x_k^p = [p = 0] for p = 0 to 3, where sinc(x) = sin(x) / x. The band b is 1.8 for
    four readings on either side and 1.6 for three. Two leave only Lagrange's cubic.

    The most readings are used that amplify white noise by no more than a fifth: four on either
    side, three, or two if the usual step is at most 0.5 s. If it is at most 0.25 s, two, or the
    line.

    References
    ----------
    E.21 of ``docs/diagnostics.md``.

    """
    n, is_fast = len(t_ns), step_ns <= _FAST_NS
    side = np.zeros(n, np.int8)
    rise, factor = np.full(n, np.nan), np.ones(n)
    turns = wrap180(np.diff(heading_deg))
    reaches = _find_reaches(is_good)[left]
    readings = _Readings(stamp_ns, turns, left, t_ns, step_ns)
    sides = (2, 1) if is_fast else (4, 3, 2) if step_ns <= _MIDDLE_NS else (4, 3)
    for per_side in (1,) if is_line else sides:
        open_ = (side == 0) & (reaches >= per_side)
        if not open_.any():
            continue
        whole = bool(open_.all())
        at = np.flatnonzero(open_)
        values = (readings if whole else readings.among(at)).by(per_side)
        good = values.factor <= LARGEST_FACTOR
        if whole and good.all():
            side[:], rise, factor = per_side, values.rise_deg, values.factor
        else:
            side[at[good]] = per_side
            rise[at[good]], factor[at[good]] = values.rise_deg[good], values.factor[good]
    compared = np.empty(0, np.int64)
    if is_line or not is_fast:
        compared = np.flatnonzero(reaches >= sides[0] if is_line else side == sides[0])
    apart = np.zeros((compared.size, len(SHORTER)))
    if compared.size:
        compared_readings = readings.among(compared)
        best = compared_readings.by(sides[0]).rise_deg if is_line else rise[compared]
        for column, shorter in enumerate(SHORTER):
            if shorter < sides[0]:
                apart[:, column] = (compared_readings.by(shorter).rise_deg - best) ** 2
    return Bridged(side, heading_deg[left] + rise, factor, compared, apart)
