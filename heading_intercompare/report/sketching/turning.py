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

"""The differences against the rate of turn, from means over seconds."""

from __future__ import annotations

import numpy as np

from heading_intercompare.core.records import Integers, Motion, Reals

from .bins import Bins

_BLOCK_NS = 10 ** 9
_LONGEST_S = 10.0
_LONGEST_GAP_S = 2.5
_FASTEST_DEG_S = 30.0
_BINS = 128
_FIRST_WIDTH_DEG_S = 2.0 ** -16


class Turning:
    """
    Bins of the rate of turn of the RS, with the differences in them.

    Attributes
    ----------
    width_deg_s : float
        Width of a bin, a power of two; bin k begins at (k - 64) times the width.
    bins : Bins
        128 bins of mean differences over a second.
    measured : bool
        Whether the rates are those of a rate-of-turn sensor.

    Notes
    -----
    Rates of a sensor are interpolated between readings at most 2.5 s apart. Without them the rate
    at a second is the slope from the mean RS heading of the second before to that of the second
    after. So the noise of the RS in a difference does not stand in its rate. Seconds more than
    10 s apart give no rate, nor does a turn faster than 30 deg/s.

    """

    def __init__(self) -> None:
        self.width_deg_s = _FIRST_WIDTH_DEG_S
        self.bins = Bins.of(_BINS, np.zeros(0, np.int64), np.zeros(0))
        # Columns: second, number, sums of time, difference and heading; the last is unfinished.
        self._blocks = np.zeros((5, 0))
        self._origin_ns: int | None = None
        self.measured = False
        self._rates = Motion.empty()

    def take_rates(self, rates: Motion) -> None:
        """Take rates of turn of a sensor, before the differences of the same time."""
        if len(rates):
            self._rates = (self._rates + rates).in_order()
            self.measured = True

    def update(self, stamp_ns: Integers, x_deg: Reals, rs_deg: Reals) -> None:
        """Take finite differences in stamp order, with unwrapped RS headings."""
        if not len(stamp_ns):
            return
        if self._origin_ns is None:
            self._origin_ns = int(stamp_ns[0])
        since = stamp_ns - self._origin_ns
        second = since // _BLOCK_NS
        first = np.flatnonzero(np.diff(second, prepend=second[0] - 1))
        columns = (np.ones(len(second)), since / 1e9, x_deg, rs_deg)
        new = np.stack([second[first].astype(np.float64),
                        *(np.add.reduceat(column, first) for column in columns)])
        if self._blocks.shape[1] and self._blocks[0, -1] == new[0, 0]:
            new[1:, 0] += self._blocks[1:, -1]
            self._blocks = self._blocks[:, :-1]
        blocks = np.concatenate((self._blocks, new), axis=1)
        self._take(blocks[:, :-1])
        self._blocks = blocks[:, -3:]

    def _take(self, blocks: Reals) -> None:
        """Take finished seconds; the first and the last only give the rate between them."""
        if blocks.shape[1] < 3:
            return
        t, x, rs = blocks[2:] / blocks[1]
        step_s = t[2:] - t[:-2]
        rate, x = (rs[2:] - rs[:-2]) / step_s, x[1:-1]
        if self.measured:
            rate = self._measured_at(t[1:-1])
        good = (step_s <= _LONGEST_S) & (np.abs(rate) < _FASTEST_DEG_S)
        rate, x = rate[good], x[good]
        if not len(rate):
            return
        while float(np.abs(rate).max()) >= 0.5 * _BINS * self.width_deg_s:
            self._double()
        at = (rate // self.width_deg_s).astype(np.int64) + _BINS // 2
        self.bins = self.bins + Bins.of(_BINS, at, x)

    def _measured_at(self, t_s: Reals) -> Reals:
        """Return the measured rate at some times since the first difference; nan in gaps."""
        if len(self._rates) < 2 or self._origin_ns is None:
            return np.full(len(t_s), np.nan)
        rate_t_s = (self._rates.stamp_ns - self._origin_ns) / 1e9
        after = np.searchsorted(rate_t_s, t_s).clip(1, len(rate_t_s) - 1)
        inside = (t_s >= rate_t_s[0]) & (t_s <= rate_t_s[-1]) & (
            rate_t_s[after] - rate_t_s[after - 1] <= _LONGEST_GAP_S)
        rate_deg_s: Reals = np.where(
            inside, np.interp(t_s, rate_t_s, self._rates.rate_deg_s), np.nan)
        # Later differences need no earlier rates.
        self._rates = self._rates[rate_t_s >= t_s[-1] - 2.0 * _LONGEST_S]
        return rate_deg_s

    def _double(self) -> None:
        """Double the width of the bins about zero."""
        half, shift = self.bins.halve(), _BINS // 4
        self.bins = Bins(np.roll(half.n, shift), np.roll(half.mean_deg, shift),
                         np.roll(half.m2_deg2, shift), np.roll(half.low_deg, shift),
                         np.roll(half.up_deg, shift))
        self.width_deg_s *= 2.0

    @property
    def rate_deg_s(self) -> Reals:
        """Middle of each bin, degrees per second."""
        return np.asarray((np.arange(_BINS) - _BINS // 2 + 0.5) * self.width_deg_s, np.float64)
