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

"""All diagnostics of a run, and the assumptions of its verdict that they confirm."""

from __future__ import annotations

from dataclasses import dataclass, replace
import math
from typing import Callable, Iterator, Sequence

import numpy as np

from heading_intercompare.core.angles import unwrap_deg, wrap180, wrap360
from heading_intercompare.core.conditions.conventions import (
    Convention,
    estimate_mean_difference,
    find_convention,
    MeanDifference,
)
from heading_intercompare.core.conditions.one_source import find_one_source, OneSource
from heading_intercompare.core.conditions.outliers import find_outliers, Outliers
from heading_intercompare.core.conditions.standstill import (
    find_frozen,
    find_standstill,
    Frozen,
    Standstill,
)
from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.decision.guarded import Guarded
from heading_intercompare.core.settings import Detectors, Settings
from heading_intercompare.core.statistics.autocorrelation import SeriesCorrelation
from heading_intercompare.core.statistics.blocking import pick_stretches, samples_per_average
from heading_intercompare.core.statistics.drift import Detrended
from heading_intercompare.core.statistics.ergodicity import Homogeneity
from heading_intercompare.core.statistics.moments import Moments
from heading_intercompare.core.statistics.normality import examine_normality, Normality
from heading_intercompare.core.statistics.resolution import find_resolution
from heading_intercompare.core.statistics.stationarity import examine_stationarity, Stationarity
from heading_intercompare.core.timing.clock_drift import ClockDrift, estimate_clock_drift
from heading_intercompare.core.timing.interpolation_error import (
    estimate_interpolation_error,
    InterpolationError,
)
from heading_intercompare.core.timing.realignment import move_pairs
from heading_intercompare.core.timing.skew_instrument import common_tracks, LEAST_PAIRS, Tracks
from heading_intercompare.core.timing.skew_scan import Scan
from heading_intercompare.core.timing.stamp_steps import measure_stamp_steps
from heading_intercompare.core.timing.time_skew import estimate_skew, Skew

from . import assumptions
from .assumptions import Assumption
from .deviation import fit_deviation, HeadingDependence
from .reference_noise import estimate_reference_noise, ReferenceNoise
from .run_findings import (
    Allan,
    Correlation,
    describe_allan,
    describe_correlation,
    describe_skew,
    Drift,
    RunSkew,
)

__all__ = ['diagnose', 'Diagnostics', 'Signs', 'with_runs']

#: Few enough that intermediate results stay in the cache.
_PIECE = 1 << 14

MOVING_AVERAGE_S = 1.0
"""Span of the moving average that is subtracted from headings, seconds."""

LONGEST_BURST_S = 60.0
"""Longest excursion of the difference that counts as an outlier, not a slow error; seconds."""

SETTLED_SHARE = 0.1
"""A warm-up has settled when it has fallen to this share of sigma_max."""


@dataclass(frozen=True, slots=True)
class Signs:
    """The findings of the detectors in the pairs of a run."""

    convention: Convention
    mean: MeanDifference
    source: OneSource
    ts_frozen: Frozen
    rs_frozen: Frozen
    standstill: Standstill
    outliers: Outliers
    clock: ClockDrift
    interpolation: InterpolationError


@dataclass(frozen=True, slots=True)
class Diagnostics:
    """
    The diagnostic blocks of a run in the JSON, its assumptions and warnings.

    All fields except `signs` are keys of the JSON; ``docs/verdict_json.md`` lists their contents.
    """

    skew: RunSkew
    drift: Drift
    heading_dependence: HeadingDependence
    normality: Normality
    stationarity: Stationarity
    correlation: Correlation
    allan: Allan
    assumptions: tuple[Assumption, ...]
    warnings: tuple[str, ...]
    signs: Signs


def diagnose(stamp_ns: np.ndarray, x_deg: np.ndarray, rs_deg: np.ndarray, settings: Settings,
             guarded: Guarded, limits: Limits, *, drift: Drift, rest: Detrended,
             residual_deg: np.ndarray | None = None, series: SeriesCorrelation | None = None,
             scan: Scan | None = None, factor: np.ndarray | None = None,
             interpolates_ts: bool = False,
             told: Callable[[float], None] = lambda share: None) -> Diagnostics:
    """
    Examine a run.

    Parameters
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        Stamps of the analysed pairs in increasing order, nanoseconds; n >= 0.
    x_deg, rs_deg : ndarray, shape (n,)
        Differences, installation offset removed, and headings of the RS; finite, degrees.
    settings : Settings
        Uses installation offset, model, variant, alignment, risk, pairing gap and detectors.
    guarded : Guarded
        The decision on the same differences.
    limits : Limits
        The limits of that decision.
    drift : Drift
        Drift of the differences, from `describe_drift`.
    rest : Detrended
        The differences without that drift.
    residual_deg : ndarray, shape (n,), optional
        Differences minus the polynomial that `drift_order` removed; default the differences.
    series : SeriesCorrelation, optional
        The correlation of the residuals, if already known.
    scan : Scan, optional
        Skew scan of the two streams, if available.
    factor : ndarray, shape (n,), optional
        Factor by which interpolation reduces the variance of white noise, (1-w)^2 + w^2;
        default 1.
    interpolates_ts : bool
        Whether the TS is interpolated, not the RS.
    told : callable
        Called with the share of the work that is done, from 0 to 1.

    Returns
    -------
    Diagnostics
        Holds None and 'not_testable' where n is too small.

    Notes
    -----
    Long records are not thinned, but averaged or examined in parts. Of more than 262144 pairs,
    what is slow is found on averages: skew and dependence on the heading over up to a quarter of
    a second, drift over the blocks of `Averages`. The noise of each sensor is found in 16
    stretches of 16384 readings spread over the run, the resolution in the first 100000. Whatever
    may happen at any time, an outlier or a glitch, is looked for everywhere.

    References
    ----------
    GK, conditions on the data; ``docs/diagnostics.md``.

    """
    detectors = settings.detectors
    n = x_deg.size
    is_whole = residual_deg is None
    residual = x_deg if residual_deg is None else residual_deg
    range_s = settings.alignment.skew_range_s
    tracks = (common_tracks(stamp_ns, x_deg, rs_deg)
              if n >= LEAST_PAIRS and stamp_ns[-1] > stamp_ns[0] else None)
    estimate = Skew(0) if settings.alignment.skew == 'off' else estimate_skew(
        stamp_ns, x_deg, rs_deg, range_s=range_s, max_gap_s=settings.pairing.max_gap_s,
        clock_range_s=settings.alignment.clock_range_s, tracks=tracks)
    told(0.3)
    stamps = measure_stamp_steps(stamp_ns, detectors.silence_steps)
    series = series or SeriesCorrelation.of(residual)
    correlation = describe_correlation(stamps, series)
    signs, normal = _examine_headings(stamp_ns, x_deg, rs_deg, residual, settings, detectors,
                                      limits, factor, interpolates_ts, correlation, estimate,
                                      tracks, series)
    told(0.9)
    allan = describe_allan(x_deg, stamps.typical_s,
                           _noise_of_rs(x_deg, rs_deg, estimate, range_s, tracks))
    moments = Moments.of(x_deg)
    block = describe_skew(estimate, moments.variance_deg2, limits, scan)
    deviation = _fit_deviation(x_deg, rs_deg, tracks, moments.m2_deg2,
                               settings.wrap_center_deg)
    result = Diagnostics(block, drift, deviation, normal,
                         examine_stationarity(residual, stamps.typical_s or 0.0), correlation,
                         allan, (),
                         (), signs)
    resolved = assumptions.is_resolved(rest.found)
    rest_found = examine_stationarity(rest.polynomial.residual_deg,
                                      rest.averages.size * (stamps.typical_s or 0.0))
    return replace(result, warnings=tuple(_warnings(result, range_s)),
                   assumptions=_assumptions(result, n, settings, guarded, limits, rest_found,
                                            resolved, is_whole))


def _examine_headings(stamp_ns: np.ndarray, x_deg: np.ndarray, rs_deg: np.ndarray,
                      residual_deg: np.ndarray, settings: Settings, detectors: Detectors,
                      limits: Limits, factor: np.ndarray | None, interpolates_ts: bool,
                      correlation: Correlation, estimate: Skew, tracks: Tracks | None,
                      series: SeriesCorrelation) -> tuple[Signs, Normality]:
    """Examine the headings of both sensors; those of the TS follow from the differences."""
    source = find_one_source(stamp_ns, x_deg, rs_deg, factor=factor,
                             interpolates_ts=interpolates_ts, share=detectors.same_source_share)
    ts_deg = np.empty_like(x_deg)
    for lo in range(0, x_deg.size, _PIECE):
        part = slice(lo, lo + _PIECE)
        ts_deg[part] = wrap360(x_deg[part] + rs_deg[part] + settings.installation_offset_deg)
    both = (ts_deg, rs_deg) if interpolates_ts else (rs_deg, ts_deg)
    steps = find_resolution(ts_deg), find_resolution(rs_deg)
    # Read minutes apart, sound sensors seem to turn against each other.
    at_ns, x_there, rs_there, there = stamp_ns, x_deg, rs_deg, tracks
    if estimate.apart_s is not None:
        at_ns, x_there, rs_there = move_pairs(stamp_ns, x_deg, rs_deg, estimate.apart_s)
        there = None
    signs = Signs(
        find_convention(x_there, rs_there, detectors.convention_tolerance_deg, stamp_ns=at_ns,
                        range_s=settings.alignment.skew_range_s, tracks=there),
        estimate_mean_difference(x_deg), source,
        find_frozen(stamp_ns, ts_deg, rs_deg, least_s=detectors.frozen_s,
                    moved_deg=detectors.frozen_moved_deg, sigma_deg=limits.sigma_ref_max_deg),
        find_frozen(stamp_ns, rs_deg, ts_deg, least_s=detectors.frozen_s,
                    moved_deg=detectors.frozen_moved_deg, sigma_deg=limits.sigma_max_deg),
        find_standstill(ts_deg, rs_deg), find_outliers(
            stamp_ns, residual_deg, longest_s=LONGEST_BURST_S,
            step_deg=max((s.step_deg or 0.0) for s in steps)),
        ClockDrift('not_testable') if settings.alignment.skew == 'off' else estimate_clock_drift(
            stamp_ns, x_deg, rs_deg, range_s=settings.alignment.skew_range_s,
            max_gap_s=settings.pairing.max_gap_s, near_s=estimate.about_s, tracks=tracks),
        estimate_interpolation_error(stamp_ns, *both, np.ones(x_deg.size) if factor is None
                                     else factor))
    step = correlation.stamps.typical_s
    width = 2 * max(1, round(0.5 * MOVING_AVERAGE_S / step)) + 1 if step else 3
    return signs, examine_normality(residual_deg, ts_deg, rs_deg, width=width,
                                    n_effective=correlation.n_effective_variance,
                                    tau=series.narrow.tau_1)


def _noise_of_rs(x_deg: np.ndarray, rs_deg: np.ndarray, estimate: Skew, range_s: float,
                 tracks: Tracks | None) -> ReferenceNoise:
    added = estimate.largest_variance_deg2(range_s)
    parts = pick_stretches(x_deg.size)
    averages = None
    if len(parts) > 1 and tracks is not None:
        averages = x_deg.size // len(tracks.rs), tracks.ts.heading_deg, tracks.rs.heading_deg
    else:
        parts = [slice(None)]
    # Octaves never straddle two stretches, so the steps between these do not matter.
    rs_line = unwrap_deg(np.concatenate([rs_deg[part] for part in parts]))
    ts_line = unwrap_deg(np.concatenate([x_deg[part] for part in parts]))
    ts_line += rs_line
    return estimate_reference_noise(ts_line, rs_line, averages=averages,
                                    skew_variance_deg2=math.inf if added is None else added)


def _fit_deviation(x_deg: np.ndarray, rs_deg: np.ndarray, tracks: Tracks | None, m2_deg2: float,
                   center_deg: float) -> HeadingDependence:
    """Fit the deviation to the pairs, or to the averages of a long run."""
    if tracks is None or samples_per_average(x_deg.size) == 1:
        return fit_deviation(x_deg, rs_deg)
    size = x_deg.size // len(tracks.rs)
    # The tracks of a TS that turns against the RS move apart without end.
    x = wrap180(tracks.ts.heading_deg - tracks.rs.heading_deg - center_deg) + center_deg
    within_deg2 = max(0.0, m2_deg2 / x_deg.size - float(np.var(x)))
    return fit_deviation(x, wrap360(tracks.rs.heading_deg), averaged=size,
                         within_deg2=within_deg2)


def _assumptions(found: Diagnostics, n: int, settings: Settings, guarded: Guarded,
                 limits: Limits, rest: Stationarity, resolved: bool,
                 is_whole: bool) -> tuple[Assumption, ...]:
    upper = guarded.upper_bound_deg2
    least, most = (m * limits.sigma_ref_max_deg for m in (limits.m_low, limits.m_up))
    drift = found.drift
    return (
        assumptions.judge_large_n(n, guarded.nu, resolved),
        assumptions.judge_synchronous(found.skew.estimate, settings.alignment.skew_range_s),
        assumptions.judge_stabilized(drift.warm_up),
        assumptions.judge_reference_norm(found.allan.reference_noise.sigma_ref_lower_deg,
                                         limits.sigma_ref_max_deg, upper, limits.m_low),
        assumptions.judge_installation(guarded.bias_interval_deg, limits.sigma_max_deg,
                                       settings.variant),
        assumptions.judge_drift_and_stationary(drift.order, rest, resolved),
        assumptions.judge_ergodic(None),
        assumptions.judge_constant_moments(found.stationarity, drift.line if is_whole else None,
                                           drift.span_h, found.heading_dependence, resolved),
        assumptions.judge_correlated_errors(upper, least, found.signs.source),
        assumptions.judge_laws(found.normality.difference, settings.model, (least, most)))


def with_runs(checked: Sequence[Assumption], runs: Homogeneity) -> tuple[Assumption, ...]:
    """Return the assumptions of a run, with (g) judged from all runs."""
    return tuple(assumptions.judge_ergodic(runs) if a.id == 'g' else a for a in checked)


def _warnings(found: Diagnostics, range_s: float) -> Iterator[str]:
    estimate = found.skew.estimate
    skew_s, std_deg, aligned_deg = estimate.skew_s, estimate.std_deg, estimate.std_aligned_deg
    if estimate.kind == 'beyond':
        yield f'skew: {estimate.why_not(range_s)}'
    if (estimate.significant and estimate.well_determined and skew_s is not None
            and std_deg is not None and aligned_deg is not None):
        share = 1.0 - (aligned_deg / std_deg) ** 2
        if share > assumptions.SKEW_SHARE:
            age = 'older' if skew_s > 0.0 else 'newer'
            yield (f'skew: the TS data are {abs(skew_s):.3f} s {age} than their stamps '
                   'say, compared with the RS; that makes up '
                   f'{100.0 * share:.0f} % of the variance')
    warm_up = found.drift.warm_up
    if warm_up is not None and warm_up.stabilization_s > 0.0:
        yield (f'warm_up: the difference is still settling; it is within '
               f'{warm_up.tolerance_deg:.3g} deg {warm_up.settle_s:.4g} s after its first value')
    steps = [s for s in (found.normality.ts_step_deg, found.normality.rs_step_deg) if s]
    std = found.normality.difference.std_deg
    if steps and std is not None and std < 0.5 * max(steps):
        yield (f'resolution: the differences scatter by {std:.2g} deg, less than half of the '
               f'{max(steps):.2g} deg step in which a sensor reports')
    stamps = found.correlation.stamps
    if stamps.silences:
        yield (f'silence: the pairs fall silent {stamps.silences} times, for up to '
               f'{stamps.longest_s:.1f} s; correlation times and block lengths ignore this')
