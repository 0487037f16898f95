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

"""Means over blocks of 2^l samples: valid uncertainties, and long records made short."""

from __future__ import annotations

from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.records import Integers, Reals

from .cells import CellValues

#: Longest block whose samples are added in twos.
_SHORT = 32
_PIECE = 1 << 11
#: A longer record is averaged. At 100 Hz that is 44 min.
_MOST = 1 << 18
_LEAST = _MOST // 2
_STRETCH = 1 << 14
_AT_ONCE = 1 << 14


def block_size(n: int, least: int) -> int:
    """
    Return the largest block size, a power of two, that gives at least `least` blocks.

    Parameters
    ----------
    n
        Number of samples.
    least
        Fewest blocks; the result gives fewer than twice this number.

    Returns
    -------
    int
        Samples in a block; 0 if there are fewer samples than blocks required.

    Examples
    --------
    >>> block_size(100, 16), block_size(15, 16)
    (4, 0)

    """
    return 1 << ((n // least).bit_length() - 1) if n >= least else 0


def block_means(values: ArrayLike, size: int) -> np.ndarray:
    """
    Return the means of consecutive blocks, starting at the first sample.

    Parameters
    ----------
    values : array_like, shape (n,) or (n, k)
        In sample order.
    size
        Samples in a block, at least 1; an incomplete last block is dropped.

    Returns
    -------
    ndarray, shape (n // size,) or (n // size, k)

    Examples
    --------
    >>> block_means([1.0, 3.0, 5.0, 7.0, 9.0], 2).tolist()
    [2.0, 6.0]

    """
    values = np.asarray(values, dtype=np.float64)
    count = values.shape[0] // size
    if size == 1:
        return values.copy()
    if values.ndim == 1 and 1 < size <= _SHORT and not size & (size - 1):
        return _halve(values[:count * size], size)
    means: Reals = values[:count * size].reshape(count, size, *values.shape[1:]).mean(axis=1)
    return means


def _halve(values: np.ndarray, size: int) -> np.ndarray:
    """Return means of short blocks: a sum along an axis of a few values takes longer."""
    means: Reals = np.empty(values.size // size)
    for lo in range(0, means.size, _PIECE):
        part = values[lo * size:(lo + _PIECE) * size]
        while part.size > min(means.size - lo, _PIECE):
            part = part[::2] + part[1::2]
        means[lo:lo + _PIECE] = part
    means /= size
    return means


def sum_covariance(terms: ArrayLike) -> tuple[np.ndarray, int]:
    """
    Return the covariance of the sum of correlated terms.

    Parameters
    ----------
    terms : array_like, shape (n,) or (n, k)
        Summands in sample order; at least 16.

    Returns
    -------
    covariance : ndarray, shape () or (k, k)
        n times the block size times the covariance of the means of 16 to 31 blocks.
    dof : int
        One less than the number of blocks.

    Raises
    ------
    ValueError
        If there are fewer than 16 terms.

    Notes
    -----
    Valid if the correlation time is short compared with a block.

    References
    ----------
    Batch means, Schmeiser 1982.

    """
    terms = np.asarray(terms, dtype=np.float64)
    n = terms.shape[0]
    size = block_size(n, 16)
    if not size:
        raise ValueError(f'{n} terms: at least 16 are needed')
    means = block_means(terms, size)
    return n * size * np.cov(means, rowvar=False), means.shape[0] - 1


def student_95(dof: float) -> float:
    """Return the factor that turns a standard uncertainty into a 95 % interval."""
    return -float(scipy.special.stdtrit(dof, 0.025)) if dof > 0 else math.inf


def student_quantile(p: float, nu: float) -> float:
    """Return the quantile of Student's distribution; the normal one for infinite `nu`."""
    return float(scipy.special.ndtri(p) if math.isinf(nu) else scipy.special.stdtrit(nu, p))


def samples_per_average(n: int) -> int:
    """
    Return how many samples of a record to average: a power of two; 1 up to 262144 samples.

    Examples
    --------
    >>> samples_per_average(262_144), samples_per_average(262_145), samples_per_average(4_320_000)
    (1, 2, 32)

    """
    return 1 if n <= _MOST else block_size(n, _LEAST)


def pick_stretches(n: int) -> list[slice]:
    """
    Return stretches that show what changes from sample to sample.

    Returns
    -------
    list of slice
        The whole record up to 262144 samples; of a longer one 16 stretches of 16384 samples,
        evenly spread.

    Examples
    --------
    >>> pick_stretches(100)
    [slice(0, 100, None)]
    >>> pick_stretches(1_000_000)[-1]
    slice(983616, 1000000, None)

    """
    if n <= _MOST:
        return [slice(0, n)]
    starts = np.linspace(0, n - _STRETCH, _MOST // _STRETCH).astype(np.int64)
    return [slice(lo, lo + _STRETCH) for lo in starts.tolist()]


def average(values: np.ndarray, size: int) -> Reals:
    """
    Return the means of blocks of a column, without a copy of the whole of it.

    Parameters
    ----------
    values : ndarray, shape (n,)
        In sample order. Integers are averaged as differences from the first.
    size
        Samples in a block; an incomplete last block is dropped.

    Returns
    -------
    ndarray, shape (n // size,)

    """
    means: Reals = np.empty(values.size // size)
    first = values[0] if values.size and values.dtype.kind == 'i' else values.dtype.type(0)
    rows = max(1, _AT_ONCE // size)
    for lo in range(0, means.size, rows):
        part = values[lo * size:min(lo + rows, means.size) * size]
        means[lo:lo + rows] = block_means(part - first if first else part, size)
    return means


@dataclass(frozen=True, slots=True, eq=False)
class Averages:
    """
    A record averaged over blocks of consecutive samples.

    Attributes
    ----------
    n
        Samples of the record.
    size
        Samples in a block: 1 up to 262144 samples, otherwise the power of two that leaves 131072
        to 262143 blocks. An incomplete last block is left out.
    stamp_ns : ndarray of int64, shape (n // size,)
        Mean stamps, nanoseconds.
    x_deg : ndarray, shape (n // size,)
        Mean differences, degrees.
    within_deg2
        Mean square of the differences about the means of their blocks, square degrees.

    """

    n: int
    size: int
    stamp_ns: Integers
    x_deg: Reals
    within_deg2: float

    @classmethod
    def of(cls, stamp_ns: ArrayLike, x_deg: ArrayLike) -> 'Averages':
        """
        Average a record.

        Parameters
        ----------
        stamp_ns : array_like of int, shape (n,)
            Stamps in increasing order, nanoseconds.
        x_deg : array_like, shape (n,)
            Differences, finite, degrees.

        """
        stamps = np.asarray(stamp_ns)
        x = np.asarray(x_deg, dtype=np.float64)
        size = samples_per_average(x.size)
        if size == 1:
            return cls(x.size, 1, stamps, x, 0.0)
        means = average(x, size)
        middle = float(means.mean())
        total = 0.0
        for lo in range(0, means.size * size, _AT_ONCE):
            e = x[lo:min(lo + _AT_ONCE, means.size * size)] - middle
            total += float(np.sum(e * e))
        between = float(np.sum((means - middle) ** 2))
        times: Integers = np.rint(average(stamps, size)).astype(np.int64)
        return cls(x.size, size, stamps[0] + times, means,
                   max(0.0, total / (means.size * size) - between / means.size))

    def with_noise(self, values: CellValues | None) -> CellValues | None:
        """Return the figures of cells of the averages with what the averages have lost."""
        if values is None or self.size == 1:
            return values
        return replace(values, n=self.n, y_deg2=values.y_deg2 + self.within_deg2,
                       mean_square_deg2=values.mean_square_deg2 + self.within_deg2)
