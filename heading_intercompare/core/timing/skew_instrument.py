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

"""The instrumental-variable estimate of the time skew at one shift of the RS."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import NamedTuple

import numpy as np

from heading_intercompare.core.angles import unwrap_deg
from heading_intercompare.core.statistics.blocking import average, block_size, sum_covariance

from .heading_track import Track

_BLOCK_S = 0.1
"""Longest block that pairs are averaged over, seconds."""

_LONGER_BLOCK_S, _MANY = 0.25, 1 << 18
"""Longest block as long as there are more averages than the second number."""

HALF_SPAN_S = 0.5
"""Rates span this time before a pair and the same time after it, seconds."""

LEAST_STRENGTH = 10.0
"""Least F of the common turning of both sensors; below that the instrument is weak."""


LEAST_PAIRS = 64
"""Fewest pairs that show a skew."""


class Tracks(NamedTuple):
    """TS and RS on common times."""

    ts: Track
    rs: Track


def common_tracks(stamps: np.ndarray, x: np.ndarray, rs_deg: np.ndarray,
                  block_s: float = _BLOCK_S) -> Tracks:
    """
    Return TS and RS on common times, averaged over short blocks.

    Parameters
    ----------
    stamps : ndarray of int64, shape (n,)
        Stamps of the pairs in increasing order, nanoseconds; n >= 64.
    x, rs_deg : ndarray, shape (n,)
        Differences and RS headings, finite, degrees.
    block_s
        Longest block, seconds. More than 262144 averages make it longer, up to 0.25 s.

    Returns
    -------
    ts, rs : Track
        Time zero is the first stamp.

    """
    step = float(np.median(np.diff(stamps[:100_001]))) / 1e9
    size = block_size(math.floor(block_s / step), 1) if step < block_s else 1
    if size > block_size(x.size, 64):
        size = 1
    while x.size // size > _MANY and 2 * size * step <= _LONGER_BLOCK_S:
        size *= 2
    ts, rs = (average(unwrap_deg(angle), size) for angle in (x, rs_deg))
    ts += rs
    t_s = average(stamps, size) / 1e9
    return Tracks(Track.of(t_s, ts), Track.of(t_s, rs))


@dataclass(frozen=True, slots=True)
class Fit:
    """
    The instrumental estimate at one shift of the RS.

    Attributes
    ----------
    t_s, x, rate : ndarray, shape (n,)
        Times used, seconds; differences with the RS shifted, degrees; its rates, degrees per
        second.
    step_s, u_s
        Remaining skew, and its standard uncertainty, seconds.
    dof
        Degrees of freedom of the uncertainty.
    strength
        F of the common rate.
    rate_std_deg_s
        Standard deviation of the common rate, degrees per second.

    """

    t_s: np.ndarray
    x: np.ndarray
    rate: np.ndarray
    step_s: float
    u_s: float
    dof: int
    strength: float
    rate_std_deg_s: float


class Instrument:
    """
    Estimate the skew that remains after a shift of the RS.

    Parameters
    ----------
    ts, rs
        Both sensors on common times; the RS may reach further.
    half_span_s
        Rates span this time before a pair and the same time after it, seconds.
    max_gap_s
        Spans with a longer silence are left out, seconds.
    most
        Largest number of times used, spread evenly over those of the TS; default all.

    """

    def __init__(self, ts: Track, rs: Track, half_span_s: float, max_gap_s: float,
                 most: int | None = None) -> None:
        self.ts, self.rs = ts, rs
        self.half_span_s, self.max_gap_s = half_span_s, max_gap_s
        self._every = 1 if most is None else max(1, -(-len(ts) // most))

    def __call__(self, shift_s: float) -> Fit | None:
        h = self.half_span_s
        t = self.ts.t_s[::self._every]
        t = t[self.ts.covers(t - h - max(0.0, shift_s), t + h + max(0.0, -shift_s),
                             self.max_gap_s)]
        if t.size < 64:
            return None
        ts_rate = self.ts.rate(t, h)
        ts_rate -= ts_rate.mean()
        rate = self.rs.rate(t - shift_s, h)
        x = self.ts.at(t) - self.rs.at(t - shift_s)
        common = ts_rate * (rate - rate.mean())
        total = float(common.sum())
        u_total = math.sqrt(float(sum_covariance(common)[0]))
        strength = (total / u_total) ** 2 if u_total > 0.0 and total > 0.0 else 0.0
        if strength == 0.0:
            return Fit(t_s=t, x=x, rate=rate, step_s=0.0, u_s=math.inf, dof=0, strength=0.0,
                       rate_std_deg_s=0.0)
        e = x - x.mean()
        step = -float(ts_rate @ e) / total
        e += step * (rate - rate.mean())
        covariance, dof = sum_covariance(ts_rate * e)
        return Fit(t_s=t, x=x, rate=rate, step_s=step, u_s=math.sqrt(float(covariance)) / total,
                   dof=dof, strength=strength, rate_std_deg_s=math.sqrt(total / (t.size - 1)))
