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

"""
The time skew between the sensors, from the pairs of a run.

A TS whose stamps are late by d reports the heading of d seconds ago. In a turn at rate w this
shifts the difference by -d w. A positive skew means that, compared with the RS, the TS data are
older than their stamps say.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.records import Reals
from heading_intercompare.core.statistics.blocking import student_95

from .clock_search import find_apart
from .realignment import move_pairs
from .skew_instrument import (
    common_tracks,
    Fit,
    HALF_SPAN_S,
    Instrument,
    LEAST_PAIRS,
    LEAST_STRENGTH,
    Tracks,
)
from .skew_search import coarsen, find_skew, has_turned, REACH_S

_MAX_GAP_S = 3.0
_STEPS = 20
_SEARCH_BLOCK_S = 0.25
_SEARCHED = 8192
_SAME_S = 0.2


def regress_on_rate(x_deg: Reals, rate_deg_s: Reals) -> tuple[float, float] | None:
    """
    Regress differences on the rate of the RS by ordinary least squares.

    Parameters
    ----------
    x_deg, rate_deg_s : ndarray, shape (n,)
        Differences, and the rates of the RS at them.

    Returns
    -------
    skew_s, u_s : (float, float) or None
        Minus the slope, which the noise of the rate biases towards zero, and its standard error
        as if the residuals were uncorrelated. None for fewer than 3 samples, or if rate or
        differences do not vary.

    """
    n = x_deg.size
    if n < 3:
        return None
    w, e = rate_deg_s - rate_deg_s.mean(), x_deg - x_deg.mean()
    ww, ee, we = float(w @ w), float(e @ e), float(w @ e)
    if min(ww, ee) <= 0.0:
        return None
    b = we / ww
    residual = e - b * w
    return -b, math.sqrt(float(residual @ residual) / (n - 2) / ww)


_KINDS = {'found': 'found', 'unclear': 'found, but poorly determined',
          'beyond': 'beyond the range of the search', 'no_fit': 'no skew fits',
          'not_turned': 'the ship did not turn enough', 'too_few': 'too few pairs'}


@dataclass(frozen=True, slots=True)
class Skew:
    """The time skew of a run; keys of the JSON."""

    n: int = figure('pairs or short averages used', 'averages over up to 0.25 s; 0: too few, or '
                    '`alignment.skew` is `off`')
    kind: str = figure('result of the estimate', choices=_KINDS, default='too_few')
    rs_rate_std_deg_s: float | None = figure('rate of turn of the RS, standard deviation',
                                             'with its noise', default=None)
    rate_std_deg_s: float | None = figure('rate of turn that both sensors show',
                                          'standard deviation, free of their noise', default=None)
    strength: float | None = figure('strength of that rate; below 10 the ship did not turn enough',
                                    'its F', default=None)
    ols_s: float | None = figure('offset by least squares, too small with noise', default=None,
                                 u='ols_u_s')
    ols_u_s: float | None = figure('its naive standard error', default=None)
    iv_s: float | None = figure('offset after one step of the estimate', 'E.8', default=None)
    skew_s: float | None = figure('latency or clock offset', 'E.8; null if none is '
                                  'within `alignment.skew_range_s`', default=None, u='u_s')
    u_s: float | None = figure('standard uncertainty of the offset', default=None)
    interval_s: tuple[float, float] | None = figure('95 % interval of the offset', default=None)
    well_determined: bool | None = figure('the offset is well determined', 'by enough turns, and '
                                          '`u_s` at most a tenth of the range', default=None)
    significant: bool | None = figure('the interval excludes zero', default=None)
    std_deg: float | None = figure('standard deviation of the differences used', default=None)
    std_aligned_deg: float | None = figure('the same without the offset', default=None)
    mean_aligned_deg: float | None = figure('mean of the differences without the offset',
                                            default=None)
    beyond_s: float | None = figure('offset beyond the range of the search, about',
                                    'null unless `kind` is `beyond`', default=None)
    also_s: float | None = figure('another that fits about as well', 'because the motion repeats '
                                  'itself', absent='without one')
    searched_s: float | None = figure('clocks that lie apart were sought up to',
                                      '`alignment.clock_range_s`, or less if the run is short',
                                      absent='if there was no search')

    @property
    def about_s(self) -> float:
        """Return the skew, within the range or beyond it; 0 if unknown, seconds."""
        return (self.skew_s if self.well_determined else self.beyond_s) or 0.0

    @property
    def apart_s(self) -> float | None:
        """Return the skew if it exceeds a minute: no sensor is that late, the clocks lie apart."""
        return None if abs(self.beyond_s or 0.0) <= REACH_S else self.beyond_s

    def why_not(self, range_s: float) -> str:
        """Say why the skew is not well determined within a range, seconds."""
        if self.kind == 'beyond':
            also = '' if self.also_s is None else f' (or about {self.also_s:.1f} s)'
            return (f'the differences scatter least with a clock offset of about '
                    f'{self.beyond_s:.1f} s{also}, beyond alignment.skew_range_s = {range_s:g} s')
        if self.kind == 'no_fit':
            return (f'the ship moved, but no latency or clock offset within {range_s:g} s '
                    f'(alignment.skew_range_s) fits{self._beyond_that()}')
        if self.kind == 'unclear':
            return (f'the latency or clock offset, {self.skew_s:.3f} s, is not well determined '
                    f'(standard uncertainty {self.u_s:.3f} s)')
        return 'the ship did not turn enough to show a latency or clock offset'

    def _beyond_that(self) -> str:
        """Say how far the search for clocks that lie apart could see."""
        if not self.searched_s:
            return ''
        return f', nor was one found up to {self.searched_s:g} s (alignment.clock_range_s)'

    def largest_variance_deg2(self, range_s: float) -> float | None:
        """
        Return the largest variance that a skew may add to the differences, d^2 Var(rate).

        Here d is the far end of the interval, or the range if the skew is not well determined, or
        the skew beyond it. The result is None if the rates are unknown.
        """
        interval_s, rate_deg_s = self.interval_s, self.rate_std_deg_s
        if self.well_determined and interval_s is not None and rate_deg_s is not None:
            return (max(abs(d) for d in interval_s) * rate_deg_s) ** 2
        if self.rs_rate_std_deg_s is None:
            return None
        return (max(range_s, abs(self.beyond_s or 0.0)) * self.rs_rate_std_deg_s) ** 2


def estimate_skew(stamp_ns: ArrayLike, x_deg: ArrayLike, rs_deg: ArrayLike, *,
                  range_s: float = 2.0, half_span_s: float = HALF_SPAN_S,
                  max_gap_s: float = _MAX_GAP_S, clock_range_s: float = 0.0,
                  tracks: Tracks | None = None) -> Skew:
    """
    Estimate the time skew of a run from its pairs.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps of the pairs in increasing order, nanoseconds.
    x_deg, rs_deg : array_like, shape (n,)
        Differences and RS headings, finite, degrees.
    range_s
        Largest skew to search for, in either direction, seconds.
    half_span_s
        Rates span this time before a pair and the same time after it, seconds.
    max_gap_s
        Spans with a longer silence are left out, seconds.
    clock_range_s
        Largest skew to search for beyond a minute, in either direction, seconds; default none.
    tracks : pair of Track, optional
        `common_tracks` of the pairs, if already known.

    Returns
    -------
    Skew

    Notes
    -----
    The noise of the RS rates biases ordinary least squares towards zero. The rate of the TS
    serves as an instrument: over a span symmetric about the pair, its noise is correlated neither
    with the noise of the pair nor with the RS. A search from several starts, on up to 8192
    averages over 0.25 s, first finds where the estimate converges. Interpolating a shifted RS
    changes its noise, but not this estimate. Pairs more frequent than 10 per second are first
    averaged over up to 0.1 s, both sensors alike, which shifts neither.

    Clocks may lie minutes apart. `find_apart` looks for that, and the estimate is made again
    on the pairs moved by what it finds.

    References
    ----------
    E.8 and E.24 of ``docs/diagnostics.md``; strength of an instrument: Staiger & Stock 1997
    (Econometrica 65, 557).

    """
    stamps, x = np.asarray(stamp_ns), np.asarray(x_deg, dtype=np.float64)
    if x.size < LEAST_PAIRS or stamps[-1] == stamps[0]:
        return Skew(0)
    ts, rs = tracks or common_tracks(stamps, x, np.asarray(rs_deg, dtype=np.float64))
    fit = Instrument(ts, rs, half_span_s, max_gap_s)
    regression = fit(0.0)
    if regression is None:
        return Skew(0)
    ols_s, ols_u_s = regress_on_rate(regression.x, regression.rate) or (None, None)
    result = Skew(n=regression.x.size, kind='not_turned',
                  rs_rate_std_deg_s=float(regression.rate.std(ddof=1)),
                  rate_std_deg_s=regression.rate_std_deg_s, strength=regression.strength,
                  ols_s=ols_s, ols_u_s=ols_u_s,
                  iv_s=regression.step_s if regression.strength > 0.0 else None,
                  well_determined=False, std_deg=float(regression.x.std(ddof=1)))
    coarse = coarsen(ts, _SEARCH_BLOCK_S), coarsen(rs, _SEARCH_BLOCK_S)
    clocks = None
    if clock_range_s > REACH_S:
        clocks, apart = find_apart(*coarse, clock_range_s, max_gap_s)
        result = replace(result, searched_s=clocks.searched_s)
        if apart is not None:
            moved = estimate_skew(*move_pairs(stamps, x, np.asarray(rs_deg), apart.skew_s),
                                  range_s=range_s, half_span_s=half_span_s, max_gap_s=max_gap_s)
            return replace(result, kind='beyond', also_s=apart.also_s,
                           beyond_s=apart.skew_s + (moved.skew_s or 0.0))
    place = find_skew(Instrument(*coarse, half_span_s, max_gap_s, _SEARCHED), 0.0, range_s)
    if place is not None and abs(place[0]) > range_s:
        if clocks is None or clocks.is_sure(place[0]):
            return replace(result, kind='beyond', beyond_s=place[0])
        place = None
    settled = _settle(fit, regression, 0.0, range_s)
    if place is not None and (settled is None or abs(settled[0] - place[0]) > _SAME_S):
        begun = fit(place[0])
        settled = None if begun is None else _settle(fit, begun, place[0], range_s)
    if settled is None:
        return replace(result, kind='no_fit' if has_turned(coarse[1], max_gap_s) else
                       'not_turned')
    d, regression = settled
    return _fill_in(result, regression, d, range_s, ts.at(regression.t_s) - rs.at(regression.t_s))


def _settle(fit: Instrument, regression: Fit, d: float,
            range_s: float) -> tuple[float, Fit] | None:
    """Iterate from a fit at skew `d` until no skew remains; None if that fails."""
    if not regression.strength >= LEAST_STRENGTH:
        return None
    for _ in range(_STEPS):
        step = regression.step_s
        d += step
        next_one = fit(d) if abs(d) <= range_s else None
        if next_one is None:
            return None
        regression = next_one
        if abs(step) < 1e-7:
            return d, regression
    return None


def _fill_in(result: Skew, regression: Fit, d: float, range_s: float,
             x_paired: np.ndarray) -> Skew:
    half = student_95(regression.dof) * regression.u_s
    interval = d - half, d + half
    clear = regression.strength >= LEAST_STRENGTH and regression.u_s <= 0.1 * range_s
    return replace(
        result, n=regression.x.size, kind='found' if clear else 'unclear',
        rate_std_deg_s=regression.rate_std_deg_s, strength=regression.strength, skew_s=d,
        u_s=regression.u_s, interval_s=interval, well_determined=clear,
        significant=not interval[0] <= 0.0 <= interval[1], std_deg=float(x_paired.std(ddof=1)),
        std_aligned_deg=float(regression.x.std(ddof=1)),
        mean_aligned_deg=float(regression.x.mean()))
