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

__all__ = ['Allan', 'Correlation', 'describe_allan', 'describe_correlation', 'describe_drift',
           'describe_skew', 'Drift', 'left_in_deg2', 'RunSkew']


@dataclass(frozen=True, slots=True)
class RunSkew:
    """
    The time skew of a run, and the variance criterion with and without it.

    Attributes
    ----------
    estimate : Skew
        Estimate from the pairs.
    variance_aligned_deg2 : float or None
        Variance of the differences with the part of the skew removed; None unless the skew is
        well determined.
    outcome_as_paired, outcome_aligned : Outcome or None
        GK (5) on the variance as paired, and on the aligned one; None without a variance.
    scan : Scan or None
        Scan of the two streams, if they were available.

    """

    estimate: Skew
    variance_aligned_deg2: float | None
    outcome_as_paired: Outcome | None
    outcome_aligned: Outcome | None
    scan: Scan | None


@dataclass(frozen=True, slots=True)
class Drift:
    """
    The drift of a run. A figure is None if there is too little data for it.

    Attributes
    ----------
    order : Order or None
        The order that the differences need, whatever order was removed.
    coefficients_deg : tuple of float or None
        Legendre coefficients up to that order.
    left_deg2 : float or None
        Upper 95 % bound of the variance that a drift of that order, at least a slope, adds if it
        is not removed; square degrees.
    residual_std_deg : float or None
        Standard deviation about that polynomial, the root of RSS/(n - 1 - order).
    span_h : float
        Length of the run, hours.
    line : Slope or None
    warm_up : WarmUp or None
    mser_s : float or None
        Time after which the start no longer disturbs the mean, by MSER-5: seconds after the
        first stamp.

    """

    order: Order | None
    coefficients_deg: tuple[float, ...] | None
    left_deg2: float | None
    residual_std_deg: float | None
    span_h: float
    line: Slope | None
    warm_up: WarmUp | None
    mser_s: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Correlation:
    """
    The correlation of the differences in time.

    Attributes
    ----------
    n : int
        Number of differences.
    stamps : StampSteps
        Steps of their stamps; the figures below ignore silences.
    r1 : float or None
        Autocorrelation at a lag of one sample.
    window_s, tau_1_s, tau_2_s : float or None
        Largest lag summed, and the correlation times for mean and variance, seconds.
    n_effective_mean, n_effective_variance : float
        Number of independent differences that give an equally good mean, and an equally good
        variance.
    closed : bool
        Whether the sum ended before a quarter of the run; if not, the times are too short.

    """

    n: int
    stamps: StampSteps
    r1: float | None = None
    window_s: float | None = None
    tau_1_s: float | None = None
    tau_2_s: float | None = None
    n_effective_mean: float
    n_effective_variance: float
    closed: bool


@dataclass(frozen=True, slots=True)
class Allan:
    """
    Scatter of the differences against averaging time.

    Attributes
    ----------
    m : tuple of int
        Samples per average: 1, 2, 4, ...; empty for n < 2.
    tau_s, deviation_deg : tuple of float
        Averaging times, seconds, and overlapping Allan deviations, degrees.
    terms : tuple of int
        Number of squared differences in each.
    reference_noise : ReferenceNoise
        The same variance split between TS and RS where the ship is quiet.

    """

    m: tuple[int, ...]
    tau_s: tuple[float, ...]
    deviation_deg: tuple[float, ...]
    terms: tuple[int, ...]
    reference_noise: ReferenceNoise


def describe_skew(estimate: Skew, variance_deg2: float | None, limits: Limits,
                  scan: Scan | None = None) -> RunSkew:
    """
    Return the block of the skew.

    Parameters
    ----------
    estimate : Skew
        Estimate from the pairs of the run.
    variance_deg2 : float or None
        Variance of the differences as paired, square degrees.
    limits : Limits
        Limits of the variance criterion.
    scan : Scan, optional
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
    tolerance_deg : float
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
    return Drift(order, fit.coefficients_deg if order else None,
                 drift_left_deg2(rest if fit.order > 1 else line), std, span_h,
                 fit_slope(stamp_ns, x_deg, line),
                 fit_warm_up(averages.stamp_ns, averages.x_deg, tolerance_deg),
                 mser5(averages.stamp_ns, averages.x_deg)), rest


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
    stamps : StampSteps
        Steps of the stamps of the differences.
    series : SeriesCorrelation
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
    step_s : float or None
        Time from sample to sample, seconds.
    noise : ReferenceNoise
        Noise found in the headings of both sensors.

    """
    if not step_s:
        return Allan((), (), (), (), noise)
    allan = compute_allan_deviation(x_deg, 1.0 / step_s)
    return Allan(m=tuple(allan.m.tolist()), tau_s=tuple(allan.tau_s.tolist()),
                 deviation_deg=tuple(allan.deviation.tolist()),
                 terms=tuple(allan.terms.tolist()), reference_noise=noise)
