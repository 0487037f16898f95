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

"""Means over blocks of 2^l samples, which keep uncertainties valid for correlated samples."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike
import scipy

from heading_intercompare.core.records import Reals

__all__ = ['block_means', 'block_size', 'sum_covariance', 'student_95']


#: Longest block whose samples are added in twos.
_SHORT = 32
_PIECE = 1 << 11


def block_size(n: int, least: int) -> int:
    """
    Return the largest block size, a power of two, that gives at least `least` blocks.

    Parameters
    ----------
    n : int
        Number of samples.
    least : int
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
    size : int
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
