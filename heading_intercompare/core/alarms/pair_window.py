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

"""The newest pairs as columns, for the detectors that watch a run in progress."""

from __future__ import annotations

import numpy as np

from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.records import Differences, Integers, Pairs, Reals

_MOST = 1 << 16


class PairWindow:
    """
    Columns of the newest pairs whose difference is finite.

    Parameters
    ----------
    window_s
        Length of the window, seconds of stamp time.
    most
        Most pairs kept.

    Notes
    -----
    The columns are views of buffers of twice the size, so an update copies on average each pair
    twice, whatever the length of the window.

    """

    def __init__(self, window_s: float, most: int = _MOST) -> None:
        self._window_ns, self._most = round(window_s * 1e9), most
        self._stamps = np.empty(2 * most, np.int64)
        self._columns = np.empty((4, 2 * most))
        self._lo = self._hi = 0
        self.interpolates_ts = False

    def __len__(self) -> int:
        return self._hi - self._lo

    def resize(self, window_s: float) -> None:
        """Change the length, seconds; pairs that are too old go with the next update."""
        self._window_ns = round(window_s * 1e9)

    def clear(self) -> None:
        """Forget all pairs."""
        self._lo = self._hi = 0

    def update(self, pairs: Pairs, differences: Differences) -> None:
        """Take pairs in stamp order, with their differences."""
        keep = np.isfinite(differences.x_deg)
        if not keep.all():
            pairs, differences = pairs[keep], differences[keep]
        pairs, differences = pairs[-self._most:], differences[-self._most:]
        n = len(pairs)
        if not n:
            return
        if self._hi + n > len(self._stamps):
            self._shift(min(len(self), self._most))
        at = slice(self._hi, self._hi + n)
        self._stamps[at] = pairs.stamp_ns
        factors = pairs.rs_variance_factor, pairs.ts_variance_factor
        self._columns[:, at] = differences.x_deg, pairs.rs_deg, *factors
        self.interpolates_ts = bool((factors[1] != 1.0).sum() > (factors[0] != 1.0).sum())
        self._hi += n
        first_ns = int(self._stamps[self._hi - 1]) - self._window_ns
        self._lo = max(self._lo, self._hi - self._most)
        self._lo += int(np.searchsorted(self._stamps[self._lo:self._hi], first_ns))

    def _shift(self, n: int) -> None:
        lo = self._hi - n
        self._stamps[:n] = self._stamps[lo:self._hi].copy()
        self._columns[:, :n] = self._columns[:, lo:self._hi].copy()
        self._lo, self._hi = 0, n

    @property
    def stamp_ns(self) -> Integers:
        """Stamps, nanoseconds."""
        stamps: Integers = self._stamps[self._lo:self._hi]
        return stamps

    @property
    def x_deg(self) -> Reals:
        """Differences, degrees."""
        return self._column(0)

    @property
    def rs_deg(self) -> Reals:
        """Headings of the RS, degrees."""
        return self._column(1)

    @property
    def factor(self) -> Reals:
        """Factor by which interpolation reduces the variance of white noise."""
        return self._column(2) * self._column(3)

    def to_pairs(self, offset_deg: float) -> tuple[Pairs, Differences]:
        """Return the pairs and their differences, from which an offset was removed, degrees."""
        stamps, x_deg, rs_deg = self.stamp_ns.copy(), self.x_deg.copy(), self.rs_deg.copy()
        pairs = Pairs.of(stamps, wrap360(rs_deg + x_deg + offset_deg), rs_deg, None,
                         self._column(2).copy(), self._column(3).copy())
        return pairs, Differences.of(stamps, x_deg)

    def _column(self, at: int) -> Reals:
        column: Reals = self._columns[at, self._lo:self._hi]
        return column

    def find(self, ago_s: float) -> int:
        """Return the index of the first pair that is at most this time older than the newest."""
        stamps = self.stamp_ns
        return int(np.searchsorted(stamps, int(stamps[-1]) - round(ago_s * 1e9)))
