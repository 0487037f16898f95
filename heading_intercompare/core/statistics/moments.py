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

"""Moments of differences that can be added, exact sums, and counts outside a limit."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike

UNIT = 2.0 ** -53
"""All floats from 1/2 to 1 are integer multiples of this."""

_HALF = 26
#: Few enough that a linear algebra library stays in one thread, and that they stay in the cache.
_PIECE = 1 << 13


def exact_sum(values: ArrayLike) -> int:
    """
    Return the exact sum of numbers from 1/2 to 1, in units of `UNIT`.

    An exact sum does not depend on how the numbers are cut into chunks.

    Examples
    --------
    >>> exact_sum([0.5, 1.0, 0.75]) * UNIT
    2.25

    """
    numbers = np.asarray(values, dtype=np.float64)
    if numbers.size and (numbers == numbers[0]).all():
        return int(numbers[0] / UNIT) * numbers.size
    units = (numbers / UNIT).astype(np.int64)
    return (int((units >> _HALF).sum()) << _HALF) + int((units & ((1 << _HALF) - 1)).sum())


def sum_products(a: np.ndarray, b: np.ndarray) -> float:
    """Return the sum of products of two columns, shape (n,), the same with any BLAS threads."""
    return math.fsum(float(a[lo:lo + _PIECE] @ b[lo:lo + _PIECE])
                     for lo in range(0, len(a), _PIECE))


@dataclass(frozen=True, slots=True)
class Moments:
    """
    Count, mean, sum of squared deviations and extremes of differences.

    Attributes
    ----------
    n
        Number of values.
    mean_deg
        Mean, degrees; 0 for n = 0.
    m2_deg2
        Sum of squared deviations from the mean, square degrees.
    min_deg, max_deg
        Extremes, degrees; +inf and -inf for n = 0.

    References
    ----------
    Merging: Chan, Golub and LeVeque 1983, E.1 of ``docs/equations.md``. The estimates are
    GK (4).

    """

    n: int = 0
    mean_deg: float = 0.0
    m2_deg2: float = 0.0
    min_deg: float = math.inf
    max_deg: float = -math.inf

    @classmethod
    def of(cls, x_deg: ArrayLike) -> 'Moments':
        """
        Return the moments of values.

        Examples
        --------
        >>> m = Moments.of([1.0, 2.0]) + Moments.of([6.0])
        >>> m.n, m.mean_deg, m.variance_deg2
        (3, 3.0, 7.0)

        """
        x = np.asarray(x_deg, dtype=np.float64)
        if x.size == 0:
            return cls()
        mean = float(x.mean())
        m2 = off = 0.0
        for lo in range(0, x.size, _PIECE):
            e = x[lo:lo + _PIECE] - mean
            m2 += float(e @ e)
            off += float(e.sum())
        # The second term corrects for the rounding of the mean.
        m2 -= off ** 2 / x.size
        return cls(int(x.size), mean, max(0.0, m2), float(x.min()), float(x.max()))

    def __add__(self, other: 'Moments') -> 'Moments':
        """Return the joint moments of both sets of values."""
        if not isinstance(other, Moments):
            return NotImplemented
        if self.n == 0 or other.n == 0:
            return other if self.n == 0 else self
        n = self.n + other.n
        d = other.mean_deg - self.mean_deg
        return Moments(n, self.mean_deg + d * (other.n / n),
                       self.m2_deg2 + other.m2_deg2 + d * d * (self.n * (other.n / n)),
                       min(self.min_deg, other.min_deg), max(self.max_deg, other.max_deg))

    @property
    def variance_deg2(self) -> float | None:
        """Estimate of the variance, GK (4); None for n < 2."""
        return self.m2_deg2 / (self.n - 1) if self.n > 1 else None

    @property
    def std_deg(self) -> float | None:
        """Square root of the variance; None for n < 2."""
        variance = self.variance_deg2
        return None if variance is None else math.sqrt(variance)

    @property
    def mean_square_deg2(self) -> float | None:
        """Mean of the squares, about zero; None for n = 0."""
        return self.m2_deg2 / self.n + self.mean_deg ** 2 if self.n else None


def count_outside(x_deg: np.ndarray, center_deg: float, limit_deg: float) -> int:
    """Count the values farther than the limit from the centre, strictly; GK (*), (**)."""
    return sum(int(np.count_nonzero(np.abs(x_deg[lo:lo + _PIECE] - center_deg) > limit_deg))
               for lo in range(0, len(x_deg), _PIECE))
