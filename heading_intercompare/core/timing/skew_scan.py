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

"""The time skew at which the differences of two streams scatter least."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
import math
from typing import Callable

import numpy as np

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.records import Headings, Reals
from heading_intercompare.core.statistics.blocking import sum_covariance

from .heading_track import RisingTimes, select_usable, Track
from .skew_instrument import LEAST_STRENGTH

_COMPARED, _SEARCHED = 1 << 18, 1 << 13
_CURVE = 50


@dataclass(frozen=True, slots=True)
class Scan:
    """A scan of the skew between two streams; keys of the JSON."""

    n: int = figure('TS readings compared', 'the same at every offset; 262 144 at most')
    range_s: float = figure('range', 'largest offset tried, in either direction')
    step_s: float = figure('step')
    skew_s: float = figure('offset of the least scatter', 'L*; minimum of the parabola through '
                           'the least variance and its neighbours', u='u_s')
    u_s: float | None = figure('standard uncertainty of the offset', 'allows for correlation; '
                               'null for fewer than 64 readings, or if the RS does not turn')
    bias_s: float | None = figure('shift that a noisy RS may cause, at most')
    at_edge: bool = figure('the least scatter is at an end of the range', 'then there is none')
    well_determined: bool = figure('the offset is well determined', 'not at an edge, and `u_s` + '
                                   '`bias_s` at most a tenth of the range')
    std_deg: float = figure('standard deviation at that offset')
    mean_deg: float = figure('mean difference at that offset')
    std_zero_deg: float = figure('standard deviation without an offset')
    mean_zero_deg: float = figure('mean difference without an offset')
    curve_s: tuple[float, ...] = figure('offsets of the scan, for a plot', 'at most 101')
    curve_std_deg: tuple[float, ...] = figure('standard deviations at these offsets')


class _Differences:
    """TS minus shifted RS over a fixed set of TS readings, evenly spread over a long record."""

    def __init__(self, ts: Headings, rs: Track, origin_ns: int, range_s: float,
                 max_gap_s: float) -> None:
        ts = select_usable(ts)
        every = max(1, -(-len(ts) // _COMPARED))
        at = np.arange(0, len(ts), every)
        if every > 3:
            # Of the others only those beside them are needed, for the rates.
            at = np.arange(1, len(ts) - 1, every)
            ts, at = ts[np.add.outer(at, (-1, 0, 1)).reshape(-1)], 1 + 3 * np.arange(at.size)
        self._ts, self.rs = Track(ts, origin_ns), rs
        t_s = self._ts.t_s[at]
        self._at = at[rs.covers(t_s - range_s, t_s + range_s, max_gap_s)]
        self.t_s, self.ts_deg = self._ts.t_s[self._at], self._ts.heading_deg[self._at]

    def at(self, skew_s: float) -> Reals:
        """Return the wrapped differences at a skew."""
        return _wrap(self.ts_deg - self.rs.at(self.t_s - skew_s))

    def variance(self, skew_s: float) -> float:
        """Return the sample variance at a skew; needs at least two readings."""
        return _find_variance(self.at(skew_s))

    def search(self, skews_s: Reals, every: int) -> Reals:
        """Return the sample variances at rising skews, of one reading in `every`."""
        t_s, ts_deg = self.t_s[::every], self.ts_deg[::every]
        rs = RisingTimes(self.rs, t_s - skews_s[-1])
        variances = [_find_variance(_wrap(ts_deg - rs.at(t_s - skew_s)))
                     for skew_s in skews_s[::-1].tolist()]
        return np.array(variances[::-1])

    def ts_rate(self) -> Reals:
        """Return the rates of the TS from the reading before to the one after, deg/s."""
        at = np.clip(self._at, 1, len(self._ts) - 2)
        t_s, heading_deg = self._ts.t_s, self._ts.heading_deg
        rate: Reals = heading_deg[at + 1] - heading_deg[at - 1]
        rate /= t_s[at + 1] - t_s[at - 1]
        return rate


def _wrap(x: Reals) -> Reals:
    x -= 360.0 * round(float(x.mean()) / 360.0)
    return wrap180(x) if float(x.max()) >= 180.0 or float(x.min()) < -180.0 else x


def _find_variance(x: Reals) -> float:
    x -= x.mean()
    return float(x @ x) / (x.size - 1)


def scan_skew(ts: Headings, rs: Headings, range_s: float = 2.0, step_s: float = 0.01, *,
              max_gap_s: float = math.inf) -> Scan | None:
    """
    Find the skew at which the differences of two streams scatter least.

    Parameters
    ----------
    ts, rs
        All readings of the TS and of the RS. Those that are not finite, or whose stamp does not
        increase, are skipped.
    range_s
        Largest skew tried, in either direction, seconds; rounded to steps.
    step_s
        Step of the grid, seconds.
    max_gap_s
        TS readings with a longer silence of the RS within the range are skipped, seconds.

    Returns
    -------
    Scan or None
        None for fewer than 3 TS readings that stay within the RS at every skew.

    Raises
    ------
    ValueError
        If range or step are not positive, or the range is shorter than a step.

    Notes
    -----
    x_i(L) = TS(t_i) - RS(t_i - L), wrapped, with the unwrapped RS interpolated linearly. Only
    readings i inside the RS record at both ends of the range are used. L_0 is the grid point of
    least variance v, and ``L* = L_0 - step (v_+ - v_-) / (2 (v_+ - 2 v_0 + v_-))``. Of more than
    262144 TS readings, an even subset of at most that number is used. With more than 8192, L_0 is
    first searched on at most that many of them, then moved to the nearest minimum over all.

    Interpolating halfway between two RS readings averages their noise. If TS and RS report in
    step, this draws the minimum away from the readings. `bias_s` bounds that: half the RS
    interval times the share of noise in the variance of the RS rate.

    References
    ----------
    E.16 of ``docs/diagnostics.md``.

    """
    if not 0.0 < step_s <= range_s < math.inf:
        raise ValueError(f'range_s = {range_s!r}, step_s = {step_s!r}: must be greater than 0, '
                         'the range at least a step')
    if not len(ts) or not len(rs):
        return None
    last = round(range_s / step_s)
    origin = int(rs.stamp_ns[0])
    difference = _Differences(ts, Track(rs, origin), origin, last * step_s, max_gap_s)
    n = difference.t_s.size
    if n < 3:
        return None
    every = max(1, -(-n // _SEARCHED))
    grid = np.arange(-last, last + 1)
    skews_s: Reals = grid.astype(np.float64) * step_s
    searched = difference.search(skews_s, every)
    variance = cache(lambda k: difference.variance(k * step_s))
    best = _descend(variance, last, int(grid[np.argmin(searched)]))
    skew_s = _find_lowest(variance, best, last, step_s)
    std_zero_deg, mean_zero_deg = _spread(difference.at(0.0))
    x = difference.at(skew_s)
    std_deg, mean_deg = _spread(x)
    u_s, bias_s = _uncertainty(difference, skew_s, step_s, x)
    at_edge = abs(best) == last
    thin = max(1, -(-last // _CURVE))
    shown = slice(last % thin, None, thin)
    return Scan(n=n, range_s=last * step_s, step_s=step_s, skew_s=skew_s, u_s=u_s, bias_s=bias_s,
                at_edge=at_edge,
                well_determined=not at_edge and u_s is not None and bias_s is not None
                and u_s + bias_s <= 0.1 * last * step_s,
                std_deg=std_deg, mean_deg=mean_deg, std_zero_deg=std_zero_deg,
                mean_zero_deg=mean_zero_deg, curve_s=tuple(skews_s[shown].tolist()),
                curve_std_deg=tuple(np.sqrt(searched[shown]).tolist()))


def _spread(x: Reals) -> tuple[float, float]:
    """Return the standard deviation and the mean."""
    return float(x.std(ddof=1)), float(x.mean())


def _descend(variance: Callable[[int], float], last: int, start: int) -> int:
    """Return the nearest grid point with a local minimum of the variance of all readings."""
    best = start
    for direction in (1, -1):
        while (abs(best + direction) <= last
               and variance(best + direction) < variance(best)):
            best += direction
    return best


def _find_lowest(variance: Callable[[int], float], best: int, last: int, step_s: float) -> float:
    """Return the minimum of the parabola through a grid point and its neighbours."""
    if abs(best) == last:
        return best * step_s
    minus, middle, plus = (variance(k) for k in (best - 1, best, best + 1))
    bend = plus - 2.0 * middle + minus
    return best * step_s - (step_s * (plus - minus) / (2.0 * bend) if bend > 0.0 else 0.0)


def _uncertainty(difference: _Differences, skew_s: float, step_s: float,
                 x: np.ndarray) -> tuple[float | None, float | None]:
    """Return the standard uncertainty, and the largest shift by interpolation; changes `x`."""
    if x.size < 64:
        return None, None
    t = difference.t_s
    h = min(step_s, 0.5 * difference.rs.step_s)
    t = np.clip(t - skew_s, difference.rs.t_s[0] + h, difference.rs.t_s[-1] - h)
    rate = difference.rs.rate(t, h)
    rate -= rate.mean()
    power = float(rate @ rate)
    if power <= 0.0:
        return None, None
    # The neighbours of a TS reading give its rate without the noise of the reading itself.
    common = difference.ts_rate()
    common -= common.mean()
    common *= rate
    covariance, _ = sum_covariance(common)
    total = float(common.sum())
    del common
    if total <= 0.0 or total * total < LEAST_STRENGTH * float(covariance):
        return None, None
    noise = max(0.0, 1.0 - total / power)
    x -= x.mean()
    x *= rate
    covariance, _ = sum_covariance(x)
    return math.sqrt(float(covariance)) / power, 0.5 * difference.rs.step_s * noise
