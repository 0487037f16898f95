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

"""Values summarised in bins of time or size, whose width doubles so that memory stays bounded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from heading_intercompare.core.records import Integers, Reals

_TIME_BINS = 1000
_FIRST_WIDTH_NS = 1_000_000
_HISTOGRAM_BINS = 4096
_FIRST_WIDTH_DEG = 2.0 ** -20


@dataclass
class Bins:
    """
    Count, mean, sum of squared deviations and extremes of the values in each bin.

    Attributes
    ----------
    n : ndarray of int64, shape (k,)
    mean_deg : ndarray, shape (k,)
        0 where n is 0.
    m2_deg2 : ndarray, shape (k,)
        Sum of squared deviations from the mean.
    low_deg, up_deg : ndarray, shape (k,)
        Extremes; infinite where n is 0.

    """

    n: Integers
    mean_deg: Reals
    m2_deg2: Reals
    low_deg: Reals
    up_deg: Reals

    @classmethod
    def of(cls, size: int, at: Integers, x_deg: Reals) -> 'Bins':
        """Return the bins of values `x_deg`, each in the bin `at`."""
        n = np.bincount(at, minlength=size)
        mean = np.bincount(at, x_deg, size) / np.maximum(n, 1)
        # A sum of weights is real, although numpy does not declare it so.
        m2 = np.asarray(np.bincount(at, (x_deg - mean[at]) ** 2, size), np.float64)
        low, up = np.full(size, np.inf), np.full(size, -np.inf)
        np.minimum.at(low, at, x_deg)
        np.maximum.at(up, at, x_deg)
        return cls(n, mean, m2, low, up)

    def __add__(self, other: 'Bins') -> 'Bins':
        """Return the bins of both samples together, by Chan's formula."""
        n = self.n + other.n
        share = other.n / np.maximum(n, 1)
        step = other.mean_deg - self.mean_deg
        return Bins(n, np.where(self.n > 0, self.mean_deg + step * share, other.mean_deg),
                    self.m2_deg2 + other.m2_deg2 + step ** 2 * self.n * share,
                    np.minimum(self.low_deg, other.low_deg), np.maximum(self.up_deg, other.up_deg))

    def halve(self) -> 'Bins':
        """Return as many bins of twice the width; the upper half is empty."""
        pairs = self.join(2)
        rest = Bins.of(len(self.n) // 2, np.zeros(0, np.int64), np.zeros(0))
        return Bins(n=np.concatenate((pairs.n, rest.n)),
                    mean_deg=np.concatenate((pairs.mean_deg, rest.mean_deg)),
                    m2_deg2=np.concatenate((pairs.m2_deg2, rest.m2_deg2)),
                    low_deg=np.concatenate((pairs.low_deg, rest.low_deg)),
                    up_deg=np.concatenate((pairs.up_deg, rest.up_deg)))

    def join(self, size: int, first: int = 0) -> 'Bins':
        """Return bins of `size` neighbours each, round the circle from the bin `first` on."""
        starts = np.arange(first, first + len(self.n), size)
        joined = self._pick(starts)
        for at in range(1, size):
            joined = joined + self._pick(starts + at)
        return joined

    def _pick(self, places: Integers) -> 'Bins':
        at = places % len(self.n)
        return Bins(self.n[at], self.mean_deg[at], self.m2_deg2[at], self.low_deg[at],
                    self.up_deg[at])

    @property
    def std_deg(self) -> Reals:
        """Return the standard deviation in each bin, degrees; nan for fewer than two values."""
        return np.sqrt(np.where(self.n > 1, self.m2_deg2 / np.maximum(self.n - 1, 1), np.nan))


class Envelope:
    """Time bins that start at the first difference; their width doubles as the span grows."""

    def __init__(self) -> None:
        self.start_ns: int | None = None
        self.width_ns = _FIRST_WIDTH_NS
        self.bins = Bins.of(_TIME_BINS, np.zeros(0, np.int64), np.zeros(0))

    def update(self, stamp_ns: Integers, x_deg: Reals) -> None:
        """Take finite differences in stamp order."""
        if not len(x_deg):
            return
        if self.start_ns is None:
            self.start_ns = int(stamp_ns[0])
        since = stamp_ns - self.start_ns
        while int(since[-1]) >= self.width_ns * _TIME_BINS:
            self.bins = self.bins.halve()
            self.width_ns *= 2
        self.bins = self.bins + Bins.of(_TIME_BINS, since // self.width_ns, x_deg)


class Histogram:
    """
    Counts in bins of equal width, aligned to zero; the width doubles as the range grows.

    Attributes
    ----------
    width_deg : float
        A power of two, degrees.
    first : int
        Number of the first bin; bin k is [k, k + 1) times the width.
    counts : ndarray of int64, shape (k,)

    """

    def __init__(self) -> None:
        self.width_deg = _FIRST_WIDTH_DEG
        self.first = 0
        self.counts = np.zeros(0, np.int64)

    def update(self, x_deg: Reals) -> None:
        """Take finite differences."""
        if not len(x_deg):
            return
        low, up = float(x_deg.min()), float(x_deg.max())
        if len(self.counts):
            low = min(low, self.first * self.width_deg)
            up = max(up, (self.first + len(self.counts) - 1) * self.width_deg)
        while up // self.width_deg - low // self.width_deg >= _HISTOGRAM_BINS:
            self._double()
        first = int(low // self.width_deg)
        counts = np.zeros(int(up // self.width_deg) - first + 1, np.int64)
        shift = self.first - first
        counts[shift:shift + len(self.counts)] += self.counts
        at = np.floor_divide(x_deg, self.width_deg).astype(np.int64) - first
        self.first, self.counts = first, counts + np.bincount(at, minlength=len(counts))

    def _double(self) -> None:
        if len(self.counts):
            at = (np.arange(len(self.counts)) + self.first) // 2
            self.first = int(at[0])
            self.counts = np.bincount(at - self.first, self.counts).astype(np.int64)
        self.width_deg *= 2.0

    def quantiles_deg(self, *shares: float) -> list[float]:
        """Return the upper edges of the bins that hold these shares of the values, n >= 1."""
        edges = self.edges_deg()
        whole = np.cumsum(self.counts) / self.counts.sum()
        return [float(edges[min(int(np.searchsorted(whole, share)) + 1, len(edges) - 1)])
                for share in shares]

    def edges_deg(self) -> Reals:
        """Return the edges of the bins in degrees, one more than there are bins."""
        at = self.first + np.arange(len(self.counts) + 1)
        return at.astype(np.float64) * self.width_deg
