# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
The variance of differences by octaves of averaging time, for chunks as they come.

Blocks of 2^l samples are joined two by two. A block is its mean and the octave variances inside
it, whose sum is the variance inside it; so nothing is ever subtracted, and since every sum
follows the same binary tree the result does not depend on the chunks, to the bit.
"""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike

__all__ = ['Components', 'Dyadic', 'LEAST_SAMPLES']

LEAST_SAMPLES = 64
"""Fewest samples of which components are computed: 32 blocks of two."""

_MOST_BLOCKS = 64
_PIECE = 1 << 16


@dataclass(frozen=True, slots=True)
class Components:
    """
    What the dyadic blocks of one run say about the variance of its differences.

    Attributes
    ----------
    n, order : int
        Number of samples; order of the polynomial removed before (0: the mean).
    octave_deg2 : ndarray, shape (j,)
        E_1, E_2, ...: variance between neighbouring blocks of 1, 2, 4, ... samples, half the
        Allan variance; square degrees. G.1.
    octave_dof : ndarray, shape (j,)
        Number of pairs k_j behind each.
    slow_deg2, slow_dof : float, int
        Variance S of the means of 16 to 31 blocks, square degrees, and its degrees of freedom
        f_S. G.2.
    slow_samples : int
        Samples in each of those blocks.
    square_scatter : tuple of float
        Variance of the mean square as the scatter of 8 to 15, 16 to 31 and 32 to 63 block
        values gives it, relative to the square of the variance (0 if that is 0). G.4.
    r1_blocks : float
        Autocorrelation of the means of 32 to 63 blocks at lag 1; 0 if they are all equal. G.5.
    block_variance_deg2 : float
        Variance of those means, square degrees.

    """

    n: int
    order: int
    octave_deg2: np.ndarray
    octave_dof: np.ndarray
    slow_deg2: float
    slow_dof: int
    slow_samples: int
    square_scatter: tuple[float, float, float]
    r1_blocks: float
    block_variance_deg2: float

    @property
    def d_hat_deg2(self) -> float:
        """Variance of the differences, with what the removed mean has swallowed; G.3."""
        return float(self.octave_deg2.sum()) + self.slow_deg2

    @property
    def mean_variance_deg2(self) -> float:
        """Variance of the mean of the run, square degrees; G.3."""
        return self.slow_deg2 * self.slow_samples / self.n

    @property
    def variances_deg2(self) -> np.ndarray:
        """All components: the octaves, then the slow variance; square degrees."""
        return np.append(self.octave_deg2, self.slow_deg2)

    @property
    def dof(self) -> np.ndarray:
        """Degrees of freedom of `variances_deg2`."""
        return np.append(self.octave_dof, self.slow_dof)

    @property
    def nu_batch(self) -> float:
        """Effective degrees of freedom by the scatter of block values; may be inf. G.4."""
        scatter = max(self.square_scatter)
        return 2.0 / scatter if scatter > 0.0 else math.inf

    @property
    def nu_components(self) -> float:
        """Degrees of freedom of the sum of components, Welch-Satterthwaite; G.7."""
        d_hat = self.d_hat_deg2
        if d_hat == 0.0:
            return float(self.n - 1 - self.order)
        return 1.0 / float(np.sum((self.variances_deg2 / d_hat) ** 2 / self.dof))

    @property
    def slow_share(self) -> float:
        """Variance of 32 to 63 block means as a share of the whole; G.5."""
        d_hat = self.d_hat_deg2
        return self.block_variance_deg2 / d_hat if d_hat > 0.0 else 0.0


def _joined(left: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Join blocks two by two; return the blocks of the next level and the one left over."""
    if left.shape[1]:
        rows = np.concatenate((left, rows), axis=1)
    m = rows.shape[1] // 2 * 2
    even, odd = rows[:, 0:m:2], rows[:, 1:m:2]
    result = np.empty((rows.shape[0] + 1, m // 2))
    np.add(even, odd, out=result[:-1])
    result[:-1] *= 0.5
    half = 0.5 * (odd[0] - even[0])
    np.multiply(half, half, out=result[-1])
    return result, rows[:, m:].copy()


def _no_blocks(level: int) -> np.ndarray:
    return np.empty((level + 1, 0))


def _variance(values: np.ndarray, lost: int = 1) -> float:
    """Return the sum of squares about the mean over (count - lost)."""
    centred = values - values.mean()
    return float(np.sum(centred * centred)) / (values.size - lost)


class Dyadic:
    """
    Dyadic block summaries of a series that grows.

    Attributes
    ----------
    n : int
        Number of samples taken.

    Notes
    -----
    Holds 32 to 63 blocks of 2^l samples, l as large as that allows, and at most one block of
    each smaller level: some thousand numbers at most, however long the series. A block is a
    column: its mean about the first sample, then the octave variances inside it.

    References
    ----------
    Haar decomposition of the variance: Percival & Howe 1997; G.1 to G.5 of ``docs/risk.md``.

    Examples
    --------
    >>> whole = Dyadic.of(range(100))
    >>> parts = Dyadic()
    >>> parts.update(range(30))
    >>> parts.update(range(30, 100))
    >>> parts.components().d_hat_deg2 == whole.components().d_hat_deg2
    True

    """

    __slots__ = ('_first', '_level', '_pending', '_top', 'n')

    def __init__(self) -> None:
        self.n = 0
        self._first = 0.0
        self._level = 0
        self._top = _no_blocks(0)
        self._pending: list[np.ndarray] = []

    @classmethod
    def of(cls, x: ArrayLike) -> 'Dyadic':
        """Return the summaries of a whole series; see `update`."""
        result = cls()
        result.update(x)
        return result

    def update(self, x: ArrayLike) -> None:
        """
        Take the next samples.

        Parameters
        ----------
        x : array_like, shape (n,)
            Differences in sample order, degrees, finite; n = 0 changes nothing.

        Raises
        ------
        ValueError
            If a value is not finite; nothing is taken then.

        """
        x = np.asarray(x, dtype=np.float64).reshape(-1)
        if not np.isfinite(x).all():
            raise ValueError('x holds values that are not finite: leave them out and count them')
        if not x.size:
            return
        if self.n == 0:
            self._first = float(x[0])
        for lo in range(0, x.size, _PIECE):
            piece = x[lo:lo + _PIECE]
            self.n += piece.size
            self._take((piece - self._first)[np.newaxis], 0)

    def _take(self, rows: np.ndarray, level: int) -> None:
        """Append blocks of a level; no smaller block is pending."""
        while self._level < level:
            self._coarsen()
        for at in range(level, self._level):
            rows, self._pending[at] = _joined(self._pending[at], rows)
            if not rows.shape[1]:
                return
        self._top = np.concatenate((self._top, rows), axis=1)
        while self._top.shape[1] >= _MOST_BLOCKS:
            self._coarsen()

    def _coarsen(self) -> None:
        self._top, left = _joined(_no_blocks(self._level), self._top)
        self._pending.append(left)
        self._level += 1

    def __add__(self, other: 'Dyadic') -> 'Dyadic':
        """
        Return the summaries of this series followed by another one.

        Raises
        ------
        ValueError
            If the blocks of the other one would straddle those of this one: then feed its
            samples to `update` instead.

        """
        if not isinstance(other, Dyadic):
            return NotImplemented
        if not self.n or not other.n:
            return (self if self.n else other)._copy()
        size = 1 << other._level
        if self.n % size:
            raise ValueError(f'{self.n} samples cannot be followed by blocks of {size}: '
                             'the number must be a multiple; update with the samples instead')
        result = self._copy()
        shift = other._first - self._first
        for level, blocks in ((other._level, other._top),
                              *reversed(list(enumerate(other._pending)))):
            if blocks.shape[1]:
                moved = blocks.copy()
                moved[0] += shift
                result._take(moved, level)
        result.n += other.n
        return result

    def _copy(self) -> 'Dyadic':
        """Return an independent copy; block arrays are replaced, never changed, so shared."""
        result = Dyadic()
        result.n, result._first, result._level = self.n, self._first, self._level
        result._top, result._pending = self._top, list(self._pending)
        return result

    @property
    def _shifted_mean(self) -> float:
        sums = [math.fsum(self._top[0]) * (1 << self._level)]
        sums += [float(b[0, 0]) * (1 << at) for at, b in enumerate(self._pending) if b.shape[1]]
        return math.fsum(sums) / self.n

    @property
    def mean(self) -> float | None:
        """Mean of all samples, degrees; None for n = 0."""
        return self._first + self._shifted_mean if self.n else None

    def _levels(self) -> list[np.ndarray]:
        """Return the blocks of the level held and of all coarser ones."""
        levels = [self._top]
        while levels[-1].shape[1] >= 2:
            blocks = levels[-1]
            levels.append(_joined(_no_blocks(blocks.shape[0] - 1), blocks)[0])
        return levels

    def octaves(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """
        Return the variance by octaves, as far as there is one pair of blocks.

        Returns
        -------
        m : ndarray of int, shape (j,)
            Samples averaged: 1, 2, 4, ...
        variance_deg2 : ndarray, shape (j,)
            E_j, half the Allan variance (not overlapping) at m samples; square degrees.
        pairs : ndarray of int, shape (j,)
            Number of pairs of blocks. Empty arrays for n < 2.

        References
        ----------
        G.1; GK has no counterpart.

        """
        levels = self._levels()
        count = self._level + len(levels) - 1 if self.n > 1 else 0
        sums = np.zeros(count)
        for at, blocks in ((self._level, self._top), *reversed(list(enumerate(self._pending)))):
            if blocks.shape[1]:
                j = np.arange(1, at + 1)
                sums[:at] += blocks[1:].sum(axis=1) * 2.0 ** (at - j)
        for up, blocks in enumerate(levels[1:], start=1):
            sums[self._level + up - 1] = blocks[-1].sum()
        pairs = self.n >> np.arange(1, count + 1)
        return 1 << np.arange(count), sums / pairs, pairs

    def components(self, order: int = 0) -> Components | None:
        """
        Return the components of the variance.

        Parameters
        ----------
        order : int
            Order of the polynomial that was removed from the samples before; 0 for none, for
            the mean is removed here.

        Returns
        -------
        Components or None
            None for fewer than 64 samples.

        Notes
        -----
        The coarsest levels of at least 32, 16 and 8 blocks follow each other, so the three
        sets of block values come from the 32 to 63 blocks held.

        References
        ----------
        G.1 to G.5.

        """
        if self.n < LEAST_SAMPLES:
            return None
        blocks32, blocks16, blocks8 = self._levels()[:3]
        j = self._level + 1
        _, octaves, pairs = self.octaves()
        slow_dof = blocks16.shape[1] - 1 - order
        slow = _variance(blocks16[0], lost=1 + order)
        d_hat = float(octaves[:j].sum()) + slow

        def scatter(blocks: np.ndarray) -> float:
            squares = blocks[1:].sum(axis=0) + (blocks[0] - self._shifted_mean) ** 2
            size = 1 << (blocks.shape[0] - 1)
            return _variance(squares / d_hat) * size / self.n if d_hat > 0.0 else 0.0

        c = blocks32[0] - blocks32[0].mean()
        power = float(np.sum(c * c))
        r1 = float(np.sum(c[:-1] * c[1:])) / power if power > 0.0 else 0.0
        return Components(self.n, order, octaves[:j], pairs[:j], slow, slow_dof, 1 << j,
                          (scatter(blocks8), scatter(blocks16), scatter(blocks32)), r1,
                          power / (c.size - 1))
