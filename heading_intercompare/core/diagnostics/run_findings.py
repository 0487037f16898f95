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

"""Blocks of the JSON of a run that combine several findings: skew, drift, correlation, Allan."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np

from heading_intercompare.core.decision.criteria import apply_variance_criterion, Limits
from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.statistics.autocorrelation import (
    compute_allan_deviation,
    SeriesCorrelation,
)
from heading_intercompare.core.statistics.blocking import Averages
from heading_intercompare.core.statistics.drift import (
    Detrended,
    drift_left_deg2,
    fit_slope,
    Order,
    select_order,
    Slope,
)
from heading_intercompare.core.statistics.warm_up import fit_warm_up, mser5, WarmUp
from heading_intercompare.core.timing.skew_scan import Scan
from heading_intercompare.core.timing.stamp_steps import StampSteps
from heading_intercompare.core.timing.time_skew import Skew

from .reference_noise import ReferenceNoise


@dataclass(frozen=True, slots=True)
class RunSkew:
    """The time skew of a run, and the variance criterion with and without it."""

    estimate: Skew = figure('latency or clock offset from the pairs')
    variance_aligned_deg2: float | None = figure('variance of the differences without the offset',
                                                 'null unless the offset is well determined')
    outcome_as_paired: Outcome | None = figure('GK (5) as paired')
    outcome_aligned: Outcome | None = figure('GK (5) without the offset')
    scan: Scan | None = figure('offset from a scan of the two streams', 'null if only pairs were '
                               'available', prefix='scan: ')


@dataclass(frozen=True, slots=True)
class Drift:
    """The drift of a run. A figure is None if there is too little data for it."""

    order: Order | None = figure('order of the polynomial that the differences call for',
                                 'whatever order was removed; null for fewer than 64 differences')
    coefficients_deg: tuple[float, ...] | None = figure('Legendre coefficients of that polynomial')
    left_deg2: float | None = figure('variance of the drift if it is left in, upper 95 % bound',
                                     'of a drift of that order, at least a slope')
    residual_std_deg: float | None = figure('standard deviation about the polynomial')
    span_h: float = figure('length of the run')
    line: Slope | None = figure('straight line through the differences', 'null for fewer than two')
    warm_up: WarmUp | None = figure('exponential after switching on', 'null below 64 differences')
    mser_s: float | None = figure('time until the start no longer disturbs the mean',
                                  'MSER-5, after the first difference; null for fewer than 20')


@dataclass(frozen=True, slots=True, kw_only=True)
class Correlation:
    """The correlation of the differences in time."""

    n: int = figure('differences')
    stamps: StampSteps = figure('how their stamps follow each other', 'the other keys count '
                                'readings, so they do not see silences')
    r1: float | None = figure('correlation of neighbours', default=None)
    window_s: float | None = figure('largest lag summed', default=None)
    tau_1_s: float | None = figure('correlation time for the mean', default=None)
    tau_2_s: float | None = figure('correlation time for the variance', default=None)
    n_effective_mean: float = figure(
        'effective number for the mean, by this correlation time', 'of independent differences '
        'that would give as good a mean')
    n_effective_variance: float = figure(
        'effective number for the variance, by this correlation time')
    closed: bool = figure('the run is long enough for these times', 'the sum ended before a '
                          'quarter of it; if not, they are too short')


@dataclass(frozen=True, slots=True)
class Allan:
    """Scatter of the differences against averaging time."""

    m: tuple[int, ...] = figure('readings averaged', '1, 2, 4, …')
    tau_s: tuple[float, ...] = figure('averaging time')
    deviation_deg: tuple[float, ...] = figure('Allan deviation', 'overlapping')
    terms: tuple[int, ...] = figure('differences of averages')
    reference_noise: ReferenceNoise = figure('noise of the reference sensor', 'the variance split '
                                             'between the sensors, where the ship is quiet')


def describe_skew(estimate: Skew, variance_deg2: float | None, limits: Limits,
                  scan: Scan | None = None) -> RunSkew:
    """
    Return the block of the skew.

    Parameters
    ----------
    estimate
        Estimate from the pairs of the run.
    variance_deg2
        Variance of the differences as paired, square degrees.
    limits
        Limits of the variance criterion.
    scan
        Scan of the two streams.

    """
    if variance_deg2 is None:
        return RunSkew(estimate, None, None, None, scan)
    paired = apply_variance_criterion(variance_deg2, limits).outcome
    std_deg, aligned_deg = estimate.std_deg, estimate.std_aligned_deg
    if not estimate.well_determined or std_deg is None or aligned_deg is None:
        return RunSkew(estimate, None, paired, None, scan)
    # The estimate may use short averages, to which the skew adds the same variance.
    added = std_deg ** 2 - aligned_deg ** 2
    aligned = max(0.0, variance_deg2 - added)
    return RunSkew(estimate, aligned, paired, apply_variance_criterion(aligned, limits).outcome,
                   scan)


def describe_drift(stamp_ns: np.ndarray, x_deg: np.ndarray,
                   tolerance_deg: float) -> tuple[Drift, Detrended]:
    """
    Return the block of the drift, and the differences without it.

    Parameters
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        Stamps in increasing order, nanoseconds.
    x_deg : ndarray, shape (n,)
        Differences, finite, degrees.
    tolerance_deg
        Value to which a warm-up must fall, degrees.

    """
    n = x_deg.size
    span_h = (int(stamp_ns[-1]) - int(stamp_ns[0])) / 3.6e12 if n else 0.0
    averages = Averages.of(stamp_ns, x_deg)
    order = select_order(averages.stamp_ns, averages.x_deg)
    rest = Detrended.of(averages, order.order if order else 0)
    fit = rest.polynomial
    line = rest if fit.order == 1 else Detrended.of(averages, 1)
    std = None if order is None else math.sqrt(rest.rss_deg2 / (n - 1 - order.order))
    return Drift(
        order=order, coefficients_deg=fit.coefficients_deg if order else None,
        left_deg2=drift_left_deg2(rest if fit.order > 1 else line), residual_std_deg=std,
        span_h=span_h, line=fit_slope(stamp_ns, x_deg, line),
        warm_up=fit_warm_up(averages.stamp_ns, averages.x_deg, tolerance_deg),
        mser_s=mser5(averages.stamp_ns, averages.x_deg)), rest


def left_in_deg2(stamp_ns: np.ndarray, x_deg: np.ndarray) -> float:
    """
    Return the upper bound of the variance that a drift adds if it is not removed.

    Parameters
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        Stamps in increasing order, nanoseconds.
    x_deg : ndarray, shape (n,)
        Differences, finite, degrees.

    Returns
    -------
    float
        Square degrees: `Drift.left_deg2` of `describe_drift`, or 0 if that is None.

    """
    averages = Averages.of(stamp_ns, x_deg)
    order = select_order(averages.stamp_ns, averages.x_deg)
    rest = Detrended.of(averages, max(1, order.order if order else 0))
    return drift_left_deg2(rest) or 0.0


def describe_correlation(stamps: StampSteps, series: SeriesCorrelation) -> Correlation:
    """
    Return the block of the correlation.

    Parameters
    ----------
    stamps
        Steps of the stamps of the differences.
    series
        The correlation of the differences or residuals.

    """
    times = series.wide
    n, step = times.n, stamps.typical_s
    mean, variance = n / max(times.tau_1, 1.0), n / max(times.tau_2, 1.0)
    if series.r1 is None or step is None:
        return Correlation(n=n, stamps=stamps, n_effective_mean=mean,
                           n_effective_variance=variance, closed=False)
    return Correlation(
        n=n, stamps=stamps, r1=series.r1, window_s=times.window * step,
        tau_1_s=times.tau_1 * step, tau_2_s=times.tau_2 * step, n_effective_mean=mean,
        n_effective_variance=variance, closed=times.window < max(2, n // 4) - 1)


def describe_allan(x_deg: np.ndarray, step_s: float | None, noise: ReferenceNoise) -> Allan:
    """
    Return the block of the Allan deviation.

    Parameters
    ----------
    x_deg : ndarray, shape (n,)
        Differences in sample order, finite, degrees.
    step_s
        Time from sample to sample, seconds.
    noise
        Noise found in the headings of both sensors.

    """
    if not step_s:
        return Allan((), (), (), (), noise)
    allan = compute_allan_deviation(x_deg, 1.0 / step_s)
    return Allan(m=tuple(allan.m.tolist()), tau_s=tuple(allan.tau_s.tolist()),
                 deviation_deg=tuple(allan.deviation.tolist()),
                 terms=tuple(allan.terms.tolist()), reference_noise=noise)
