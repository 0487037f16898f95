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
Moments of differences over 512 to 1023 cells of equal time, updated chunk by chunk.

A cell holds the count, the mean and the second to fourth central moments of its differences. As
the record grows, neighbouring cells are joined in twos. The order of summation depends only on
the place of each difference in the record, so the chunks do not change a single bit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.records import Reals

LEAST_CELLS = 128
"""Fewest differences, and fewest cells, that give a result."""

_MOST_CELLS = 1023
_HALF = 512
_PIECE = 1 << 16
_ROWS = 5
_N, _MEAN, _M2, _M3, _M4 = range(_ROWS)


@dataclass(frozen=True, slots=True)
class CellValues:
    """
    The figures of a record, computed from its cells.

    Attributes
    ----------
    n
        Number of differences, including those of the incomplete last cell.
    mean_deg
        Their mean, degrees.
    mean_square_deg2
        Mean square of the deviations from the mean, q of S.2; square degrees.
    kurtosis
        Mean fourth power of the deviations over q squared, k4 of S.6; 3 where q is 0.
    rounding_deg
        Deviations smaller than this are rounding errors, degrees.
    b_deg, y_deg2 : ndarray, shape (K,)
        Sums of the deviations, and of their squares, in each of the K complete cells, times K
        over the number of differences in all of them. If the cells are equally full, these are
        the means. An empty cell has 0 and q.
    occupied
        Share of the complete cells that hold a difference.

    """

    n: int
    mean_deg: float
    mean_square_deg2: float
    kurtosis: float
    rounding_deg: float
    b_deg: np.ndarray
    y_deg2: np.ndarray
    occupied: float = 1.0


def _join(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the joint moments of neighbouring cells; Pebay 2008."""
    na, nb = a[_N], b[_N]
    n = na + nb
    d = b[_MEAN] - a[_MEAN]
    naa, nab, nbb = na * na, na * nb, nb * nb
    nn, dd = n ** 2, d ** 2
    result: Reals = a + b
    result[_MEAN] = a[_MEAN] + d * (nb / n)
    result[_M2] += dd * (nab / n)
    result[_M3] += (d ** 3 * (nab * (na - nb) / nn)
                    + 3.0 * d * (na * b[_M2] - nb * a[_M2]) / n)
    result[_M4] += (d ** 4 * (nab * (naa - nab + nbb) / n ** 3)
                    + 6.0 * dd * (naa * b[_M2] + nbb * a[_M2]) / nn
                    + 4.0 * d * (na * b[_M3] - nb * a[_M3]) / n)
    return result


def _coarsen(index: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Join the cells in twos; a cell whose partner is empty stays as it is."""
    if index.size > 1 and index[0] % 2 == 0 and index[-1] - index[0] == index.size - 1:
        # No cell is empty: as below, without a search for partners.
        paired = index.size - index.size % 2
        joined = _join(rows[:, :paired:2], rows[:, 1:paired:2])
        return index[::2] >> 1, (joined if paired == index.size else
                                 np.concatenate((joined, rows[:, paired:]), axis=1))
    index = index >> 1
    pairs = np.flatnonzero(index[1:] == index[:-1])
    if pairs.size:
        rows = rows.copy()
        rows[:, pairs] = _join(rows[:, pairs], rows[:, pairs + 1])
        keep = np.ones(index.size, bool)
        keep[pairs + 1] = False
        index, rows = index[keep], rows[:, keep]
    return index, rows


def _append(index: np.ndarray, rows: np.ndarray, next_index: np.ndarray,
            next_rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Append cells; the last old one and the first new one may be parts of one cell."""
    shared = index.size and next_index.size and index[-1] == next_index[0]
    index = np.concatenate((index, next_index))
    rows = np.concatenate((rows, next_rows), axis=1)
    return _coarsen(2 * index, rows) if shared else (index, rows)


def _sum_groups(x: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Return the moments of consecutive groups of values, one column per group."""
    rows = np.empty((_ROWS, starts.size))
    counts = np.concatenate((starts[1:], [x.size])) - starts
    rows[_N] = counts
    rows[_MEAN] = np.add.reduceat(x, starts) / counts
    e = x - np.repeat(rows[_MEAN], counts)
    power = e * e
    rows[_M2] = np.add.reduceat(power, starts)
    e *= power
    rows[_M3] = np.add.reduceat(e, starts)
    power *= power
    rows[_M4] = np.add.reduceat(power, starts)
    return rows


@dataclass(frozen=True, slots=True)
class CellsState:
    """What `Cells` remember, in numbers and tuples, to go on later to the bit."""

    n: int
    shift: float
    largest: float
    level: int
    index: tuple[int, ...]
    rows: tuple[tuple[float, ...], ...]
    open_places: tuple[int, ...]
    open_deg: tuple[float, ...]
    last_place: int
    held_ns: tuple[int, ...]
    held_deg: tuple[float, ...]
    step_ns: int | None
    first_ns: int
    newest_ns: int
    anchor_ns: int
    since_anchor: int


class Cells:
    """
    Moments of a growing series over cells of equal time.

    Attributes
    ----------
    n : int
        Number of differences so far.

    Notes
    -----
    Each difference has a place in the record. If the step of the stamps is within half a usual
    step of the usual one, the place is the previous one plus 1: in a regular record, places count
    differences. After any other step the place follows from the time since the last regular
    difference, so a gap leaves places empty and a burst shares one. The usual step is the median
    of the first 127 steps; differences are held back until it is known. A cell is 2^l consecutive
    places, with the smallest l that gives at most 1023 cells.

    References
    ----------
    S.1 to S.6 and the section on cells of ``docs/risk.md``; moments joined by Pebay 2008.

    Examples
    --------
    >>> whole, parts = Cells.of(range(2000)), Cells()
    >>> parts.update(range(30))
    >>> parts.update(range(30, 2000))
    >>> bool((whole.values().y_deg2 == parts.values().y_deg2).all())
    True

    """

    def __init__(self) -> None:
        self.n = 0
        self._shift = 0.0
        self._largest = 0.0
        self._level = 0
        self._index = np.empty(0, np.int64)
        self._rows = np.empty((_ROWS, 0))
        # Places and values of the differences in the cell in progress, in order of arrival.
        self._open: list[tuple[np.ndarray, np.ndarray]] = []
        self._last_place = -1
        # For stamped differences: those held back until the usual step is known; then that step,
        # the first and newest stamps, the stamp of the last regular difference, and the number
        # of places since.
        self._held: list[tuple[np.ndarray, np.ndarray]] = []
        self._step_ns: int | None = None
        self._first_ns = self._newest_ns = self._anchor_ns = 0
        self._since_anchor = 0

    @classmethod
    def of(cls, x_deg: ArrayLike, stamp_ns: ArrayLike | None = None) -> 'Cells':
        """Return the moments of a whole series; see `update`."""
        result = cls()
        x = np.asarray(x_deg, dtype=np.float64).reshape(-1)
        stamps = None if stamp_ns is None else np.asarray(stamp_ns, dtype=np.int64).reshape(-1)
        # Pieces give the same result to the bit and need little memory.
        for lo in range(0, x.size, _PIECE):
            hi = lo + _PIECE
            result.update(x[lo:hi], None if stamps is None else stamps[lo:hi])
        return result

    def update(self, x_deg: ArrayLike, stamp_ns: ArrayLike | None = None) -> None:
        """
        Add the next differences.

        Parameters
        ----------
        x_deg : array_like, shape (n,)
            In stamp order, degrees, finite; n = 0 changes nothing.
        stamp_ns : array_like of int, shape (n,), optional
            Their stamps, nanoseconds, increasing. Without stamps all steps count as equal.
            Give stamps on every call or on none.

        Raises
        ------
        ValueError
            If a value is not finite; then nothing is added.

        """
        x = np.array(x_deg, dtype=np.float64).reshape(-1)
        if not np.isfinite(x).all():
            raise ValueError('x_deg holds values that are not finite: leave them out and count '
                             'them')
        if not x.size:
            return
        if self.n == 0:
            self._shift = float(x[0])
        self.n += x.size
        self._largest = max(self._largest, float(x.max()), -float(x.min()))
        x -= self._shift
        if stamp_ns is None:
            self._take(np.arange(self._last_place + 1, self._last_place + 1 + x.size), x)
            return
        stamps = np.asarray(stamp_ns, dtype=np.int64).reshape(-1)
        if self._step_ns is None:
            self._held.append((stamps.copy(), x))
            if self.n < LEAST_CELLS:
                return
            stamps, x = (np.concatenate(c) for c in zip(*self._held))
            self._held = []
            self._step_ns = int(np.median(np.diff(stamps[:LEAST_CELLS])))
            self._first_ns = self._newest_ns = self._anchor_ns = int(stamps[0])
            self._take(np.zeros(1, np.int64), x[:1])
            stamps, x = stamps[1:], x[1:]
        self._take(self._places(stamps, self._step_ns), x)

    def _places(self, stamps: np.ndarray, usual: int) -> np.ndarray:
        """Return the places of stamped differences; `usual` is the usual step, nanoseconds."""
        steps = np.diff(stamps, prepend=self._newest_ns)
        regular = (2 * steps >= usual) & (2 * steps <= 3 * usual)
        if regular.all():
            places = np.arange(self._last_place + 1, self._last_place + 1 + stamps.size)
            self._anchor_ns, self._since_anchor = int(stamps[-1]), 0
        else:
            anchor = np.maximum.accumulate(np.where(regular, np.arange(stamps.size), -1))
            since = stamps - np.where(anchor >= 0, stamps[anchor], self._anchor_ns)
            since = (2 * since + usual) // (2 * usual)
            before = np.concatenate(([self._since_anchor], since[:-1]))
            places = self._last_place + np.cumsum(np.where(regular, 1, since - before))
            if anchor[-1] >= 0:
                self._anchor_ns = int(stamps[anchor[-1]])
            self._since_anchor = int(since[-1])
        self._newest_ns = int(stamps[-1])
        return places

    def _take(self, places: np.ndarray, x: np.ndarray) -> None:
        """Put differences into cells of the level that their place requires."""
        lo = 0
        while lo < x.size:
            level = _level_at(int(places[lo]))
            hi = int(np.searchsorted(places, _HALF << (level + 1)))
            if level > self._level:
                self._close()
                self._raise_to(level)
            self._add(places[lo:hi], x[lo:hi])
            lo = hi
        self._last_place = int(places[-1])

    def _add(self, places: np.ndarray, x: np.ndarray) -> None:
        """Add differences of one level; the last cell stays open."""
        last = int(places[-1]) >> self._level
        if self._open and int(self._open[0][0][0]) >> self._level == last:
            self._open.append((places, x))
            return
        first = int(np.searchsorted(places, last << self._level))
        self._open.append((places[:first], x[:first]))
        self._close()
        self._open = [(places[first:], x[first:])]

    def _sum_open(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the differences not yet closed, as cells."""
        if not self._open:
            return np.empty(0, np.int64), np.empty((_ROWS, 0))
        places, x = (np.concatenate(c) for c in zip(*self._open))
        if not x.size:
            return np.empty(0, np.int64), np.empty((_ROWS, 0))
        index = places >> self._level
        starts = np.concatenate(([0], 1 + np.flatnonzero(index[1:] != index[:-1])))
        return index[starts], _sum_groups(x, starts)

    def _close(self) -> None:
        self._index, self._rows = _append(self._index, self._rows, *self._sum_open())
        self._open = []

    def _raise_to(self, level: int) -> None:
        while self._level < level:
            self._index, self._rows = _coarsen(self._index, self._rows)
            self._level += 1

    def __add__(self, other: 'Cells') -> 'Cells':
        """
        Return the moments of this series followed by another one.

        Raises
        ------
        ValueError
            If the cells of the other series would straddle those of this one, if only one of them
            has stamps, or if their usual steps differ: then pass its differences to `update`.

        """
        if not isinstance(other, Cells):
            return NotImplemented
        if not self.n or not other.n:
            return self._copy() if self.n else other._copy()
        if self._held or other._held or self._step_ns != other._step_ns:
            raise ValueError('the usual steps of the two series differ or are not known yet: '
                             'update with the differences instead')
        offset = self._last_place + 1
        if self._step_ns is not None:
            gap = other._first_ns - self._newest_ns
            offset = self._last_place + max(1, round(gap / self._step_ns))
        size = 1 << other._level
        if offset % size:
            raise ValueError(f'{offset} places cannot be followed by cells of {size}: must be a '
                             f'multiple of {size}; update with the differences instead')
        result = self._copy()
        result._close()
        index, rows = _append(other._index, other._rows, *other._sum_open())
        index = index + offset // size
        rows[_MEAN] += other._shift - self._shift
        last = other._last_place + offset
        result._raise_to(max(other._level, _level_at(last)))
        for _ in range(result._level - other._level):
            index, rows = _coarsen(index, rows)
        result._index, result._rows = _append(result._index, result._rows, index, rows)
        result.n += other.n
        result._largest = max(self._largest, other._largest)
        result._last_place, result._newest_ns = last, other._newest_ns
        result._anchor_ns, result._since_anchor = other._anchor_ns, other._since_anchor
        return result

    def _copy(self) -> 'Cells':
        """Return an independent copy; arrays are replaced, never changed, so they are shared."""
        result = Cells()
        result.__dict__.update(self.__dict__, _open=list(self._open), _held=list(self._held))
        return result

    @property
    def state(self) -> CellsState:
        """Return what the cells remember."""
        places, x = _join_parts(self._open)
        stamps, held = _join_parts(self._held)
        return CellsState(
            n=self.n, shift=self._shift, largest=self._largest, level=self._level,
            index=tuple(self._index.tolist()),
            rows=tuple(tuple(row) for row in self._rows.tolist()),
            open_places=tuple(places.tolist()), open_deg=tuple(x.tolist()),
            last_place=self._last_place, held_ns=tuple(stamps.tolist()),
            held_deg=tuple(held.tolist()), step_ns=self._step_ns, first_ns=self._first_ns,
            newest_ns=self._newest_ns, anchor_ns=self._anchor_ns, since_anchor=self._since_anchor)

    @classmethod
    def from_state(cls, state: CellsState) -> 'Cells':
        """Return cells that go on from the state of others."""
        result = cls()
        result.n, result._shift, result._largest = state.n, state.shift, state.largest
        result._level, result._last_place = state.level, state.last_place
        result._index = np.array(state.index, np.int64)
        result._rows = np.array(state.rows, np.float64).reshape(_ROWS, len(state.index))
        if state.open_places:
            result._open = [(np.array(state.open_places, np.int64), np.array(state.open_deg))]
        if state.held_ns:
            result._held = [(np.array(state.held_ns, np.int64), np.array(state.held_deg))]
        result._step_ns, result._first_ns = state.step_ns, state.first_ns
        result._newest_ns, result._anchor_ns = state.newest_ns, state.anchor_ns
        result._since_anchor = state.since_anchor
        return result

    def profile(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the stamps of the complete cells, nanoseconds, and their means, degrees."""
        step_ns = 1 if self._step_ns is None else self._step_ns
        return (self._first_ns + (self._index << self._level) * step_ns,
                self._shift + self._rows[_MEAN])

    def after(self, stamp_ns: int) -> 'Cells':
        """Return the series from the first complete cell on that starts at or after a stamp."""
        stamps, _ = self.profile()
        at = int(np.searchsorted(stamps, stamp_ns))
        first = int(self._index[at]) if at < stamps.size else self._last_place >> self._level
        result, places = self._copy(), first << self._level
        result.n = int(self._rows[_N, at:].sum()) + sum(len(x) for _, x in self._open)
        result._index, result._rows = self._index[at:] - first, self._rows[:, at:]
        result._open = [(place - places, x) for place, x in self._open]
        result._last_place -= places
        result._first_ns += places * (1 if self._step_ns is None else self._step_ns)
        return result

    def values(self) -> CellValues | None:
        """
        Return the figures of the record so far.

        Returns
        -------
        CellValues or None
            None for fewer than 128 differences or cells.

        """
        if self.n < LEAST_CELLS or self._last_place + 1 < LEAST_CELLS:
            return None
        index, rows = _append(self._index, self._rows, *self._sum_open())
        level, k = self._level, (self._last_place + 1) >> self._level
        if k > _MOST_CELLS:
            index, rows = _coarsen(index, rows)
            level, k = level + 1, k >> 1
        whole = _sum_all(index, rows)
        mean, q = float(whole[_MEAN]), float(whole[_M2]) / self.n
        kurtosis = self.n * float(whole[_M4]) / float(whole[_M2]) ** 2 \
            if float(whole[_M2]) ** 2 > 0.0 else 3.0
        full = index < k
        index, rows = index[full], rows[:, full]
        counts = rows[_N]
        scale = k / float(counts.sum())
        off = rows[_MEAN] - mean
        b, y = np.zeros(k), np.full(k, q)
        b[index] = scale * counts * off
        y[index] = scale * (rows[_M2] + counts * (off * off - q)) + q
        return CellValues(n=self.n, mean_deg=self._shift + mean, mean_square_deg2=q,
                          kurtosis=kurtosis, rounding_deg=1e-13 * self._largest, b_deg=b, y_deg2=y,
                          occupied=index.size / k)


def _join_parts(parts: list[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """Return the integers and the values of all parts."""
    if not parts:
        return np.empty(0, np.int64), np.empty(0)
    integers, values = zip(*parts)
    return np.concatenate(integers), np.concatenate(values)


def _level_at(place: int) -> int:
    """Return the cell level that is needed when a place is the newest."""
    return max(0, place.bit_length() - _HALF.bit_length())


def _sum_all(index: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return the joint moments of all cells."""
    index = index.copy()
    while rows.shape[1] > 1:
        index, rows = _coarsen(index, rows)
    return rows[:, 0]
