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

"""How much the differences scatter if the RS is read earlier or later: the scan for a skew."""

from __future__ import annotations

import numpy as np

from heading_intercompare.core.records import Integers, Reals

_SHIFTS = 41
_APART_NS = 100_000_000
_AT_ONCE = 4096


class ShiftScan:
    """
    Sums of the differences at 41 shifts of the RS.

    Parameters
    ----------
    range_s
        Largest shift in either direction, seconds.
    max_gap_s
        Longest bracket in which the RS is interpolated, seconds.

    Attributes
    ----------
    n : int
        Differences compared, the same at every shift: at most ten a second.

    """

    def __init__(self, range_s: float, max_gap_s: float) -> None:
        self.n = 0
        self._range_ns = round(range_s * 1e9)
        self._max_gap_ns = round(max_gap_s * 1e9)
        self._shifts_ns = np.rint(np.linspace(-range_s, range_s, _SHIFTS) * 1e9).astype(np.int64)
        self._sums, self._squares = np.zeros(_SHIFTS), np.zeros(_SHIFTS)
        self._reference_deg: float | None = None
        self._stamp_ns = np.zeros(0, np.int64)
        self._x_deg, self._rs_deg = np.zeros(0), np.zeros(0)
        # The stamp from which on a difference is to be compared.
        self._from_ns = 0

    def update(self, stamp_ns: Integers, x_deg: Reals, rs_deg: Reals) -> None:
        """Take finite differences in stamp order, with unwrapped RS headings."""
        for lo in range(0, len(stamp_ns), _AT_ONCE):
            part = slice(lo, lo + _AT_ONCE)
            self._take(stamp_ns[part], x_deg[part], rs_deg[part])

    def _take(self, stamp_ns: Integers, x_deg: Reals, rs_deg: Reals) -> None:
        if self._reference_deg is None:
            self._reference_deg = float(x_deg[0])
            self._from_ns = int(stamp_ns[0])
        stamps = np.concatenate((self._stamp_ns, stamp_ns))
        x = np.concatenate((self._x_deg, x_deg))
        rs = np.concatenate((self._rs_deg, rs_deg))
        until_ns = int(stamps[-1]) - self._range_ns
        slot = stamps // _APART_NS
        due = (stamps >= self._from_ns) & (stamps < until_ns)
        due &= np.diff(slot, prepend=slot[0] - 1) > 0
        self._compare(np.flatnonzero(due), stamps, x, rs)
        self._from_ns = max(self._from_ns, until_ns)
        # Keep one that is not due before those that are: it says whether their slot is new.
        lo = max(0, int(np.searchsorted(stamps, self._from_ns - self._range_ns)) - 2)
        self._stamp_ns, self._x_deg, self._rs_deg = stamps[lo:], x[lo:], rs[lo:]

    def _compare(self, at: Integers, stamps: Integers, x: Reals, rs: Reals) -> None:
        """Add the differences `at`, each at all shifts, unless a gap is within their range."""
        shifted_ns = stamps[at][:, None] + self._shifts_ns
        right = np.searchsorted(stamps, shifted_ns)
        covered = (shifted_ns[:, 0] >= stamps[0]) & (right[:, -1] < len(stamps))
        at, shifted_ns, right = at[covered], shifted_ns[covered], np.maximum(right[covered], 1)
        left_ns, right_ns = stamps[right - 1], stamps[right]
        whole = np.all(right_ns - left_ns <= self._max_gap_ns, axis=1)
        at, shifted_ns, right = at[whole], shifted_ns[whole], right[whole]
        left_ns, right_ns = left_ns[whole], right_ns[whole]
        share = (shifted_ns - left_ns) / np.maximum(right_ns - left_ns, 1)
        moved = rs[right - 1] + share * (rs[right] - rs[right - 1])
        d = (x[at] - (self._reference_deg or 0.0) + rs[at])[:, None] - moved
        self.n += len(at)
        self._sums += d.sum(axis=0)
        self._squares += np.square(d).sum(axis=0)

    @property
    def latency_s(self) -> Reals:
        """Age of the TS data that each shift assumes, ascending, seconds."""
        age: Reals = self._shifts_ns / 1e9
        return age

    @property
    def std_deg(self) -> Reals:
        """Return the standard deviation at each `latency_s`, degrees; nan for n < 2."""
        if self.n < 2:
            return np.full(_SHIFTS, np.nan)
        spread = self._squares - self._sums ** 2 / self.n
        # A TS that is late shows the heading of an earlier RS.
        return np.sqrt(np.maximum(spread, 0.0) / (self.n - 1))[::-1]
