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

from heading_intercompare.core.angles import unwrap_deg, wrap360
from heading_intercompare.core.decision.guarded import Guarded
from heading_intercompare.core.statistics.blocking import pick_stretches, samples_per_average
from heading_intercompare.core.statistics.drift import Detrended
from heading_intercompare.core.statistics.moments import Moments
from heading_intercompare.core.statistics.normality import examine_normality, Normality
from heading_intercompare.core.statistics.stationarity import (
    examine_stationarity,
    Homogeneity,
    Stationarity,
)
from heading_intercompare.core.timing.skew_instrument import Tracks
from heading_intercompare.core.timing.skew_scan import Scan
from heading_intercompare.core.timing.time_skew import Skew

from . import assumptions
from .assumptions import Assumption
from .by_motion import ByMotion, divide_by_motion
from .deviation import fit_deviation, HeadingDependence
from .reference_noise import estimate_reference_noise, ReferenceNoise
from .run_columns import RunColumns
from .run_findings import Allan, Correlation, describe_allan, describe_skew, Drift, RunSkew

MOVING_AVERAGE_S = 1.0
"""Span of the moving average that is subtracted from headings, seconds."""


@dataclass(frozen=True, slots=True)
class Diagnostics:
    """
    The diagnostic blocks of a run in the JSON, its assumptions and warnings.

    The fields are keys of the JSON; ``docs/verdict_json.md`` lists their contents.
    """

    skew: RunSkew
    drift: Drift
    heading_dependence: HeadingDependence
    by_motion: ByMotion | None
    normality: Normality
    stationarity: Stationarity
    correlation: Correlation
    allan: Allan
    assumptions: tuple[Assumption, ...]
    warnings: tuple[str, ...]


def diagnose(columns: RunColumns, guarded: Guarded, *, drift: Drift, rest: Detrended,
             scan: Scan | None = None,
             progress: Callable[[float], None] = lambda share: None) -> Diagnostics:
    """
    Examine a run.

    Parameters
    ----------
    columns
        The analysed pairs; n >= 0.
    guarded
        The decision on the same differences.
    drift
        Drift of the differences, from `describe_drift`.
    rest
        The differences without that drift.
    scan
        Skew scan of the two streams, if available.
    progress
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
    c, settings = columns, columns.settings
    range_s = settings.alignment.skew_range_s
    estimate = c.skew
    progress(0.3)
    correlation, step = c.correlation, c.stamps.typical_s
    width = 2 * max(1, round(0.5 * MOVING_AVERAGE_S / step)) + 1 if step else 3
    normal = examine_normality(c.series_deg, c.ts_deg, c.rs_deg, width=width,
                               n_effective=correlation.n_effective_variance,
                               tau=c.series.narrow.tau_1)
    allan = describe_allan(c.x_deg, step,
                           _noise_of_rs(c.x_deg, c.rs_deg, estimate, range_s, c.tracks))
    progress(0.5)
    moments = Moments.of(c.x_deg)
    block = describe_skew(estimate, moments.variance_deg2, c.limits, scan)
    deviation = _fit_deviation(c)
    result = Diagnostics(skew=block, drift=drift, heading_dependence=deviation,
                         by_motion=divide_by_motion(c.averaged, deviation), normality=normal,
                         stationarity=examine_stationarity(c.series_deg, step or 0.0),
                         correlation=correlation, allan=allan, assumptions=(), warnings=())
    resolved = assumptions.is_resolved(rest.found)
    rest_found = examine_stationarity(rest.polynomial.residual_deg,
                                      rest.averages.size * (step or 0.0))
    return replace(result, warnings=tuple(_warnings(result, range_s)),
                   assumptions=_assumptions(result, c, guarded, rest_found, resolved))


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


def _fit_deviation(columns: RunColumns) -> HeadingDependence:
    """Fit the deviation to the pairs, or to the averages of a long run."""
    averaged = columns.averaged
    if averaged is None or samples_per_average(columns.n) == 1:
        return fit_deviation(columns.x_deg, columns.rs_deg)
    return fit_deviation(averaged.x_deg, wrap360(averaged.rs_deg), averaged=averaged.size,
                         within_deg2=averaged.within_deg2)


def _assumptions(diagnostics: Diagnostics, columns: RunColumns, guarded: Guarded,
                 rest: Stationarity, resolved: bool) -> tuple[Assumption, ...]:
    settings, limits = columns.settings, columns.limits
    upper = guarded.upper_bound_deg2
    least, most = (m * limits.sigma_ref_max_deg for m in (limits.m_low, limits.m_up))
    drift = diagnostics.drift
    is_whole = columns.residual_deg is None
    return (
        assumptions.judge_large_n(columns.n, guarded.nu, resolved),
        assumptions.judge_synchronous(diagnostics.skew.estimate, settings.alignment.skew_range_s),
        assumptions.judge_stabilized(drift.warm_up),
        assumptions.judge_reference_norm(diagnostics.allan.reference_noise.sigma_ref_lower_deg,
                                         limits.sigma_ref_max_deg, upper, limits.m_low),
        assumptions.judge_installation(guarded.bias_interval_deg, limits.sigma_max_deg,
                                       settings.variant),
        assumptions.judge_drift_and_stationary(drift.order, rest, resolved),
        assumptions.judge_ergodic(None),
        assumptions.judge_constant_moments(
            diagnostics.stationarity, drift.line if is_whole else None, drift.span_h,
            diagnostics.heading_dependence, resolved),
        assumptions.judge_correlated_errors(upper, least, columns.source),
        assumptions.judge_laws(diagnostics.normality.difference, settings.model, (least, most)))


def with_runs(checked: Sequence[Assumption], runs: Homogeneity) -> tuple[Assumption, ...]:
    """Return the assumptions of a run, with (g) judged from all runs."""
    return tuple(assumptions.judge_ergodic(runs) if a.id == 'g' else a for a in checked)


def _warnings(diagnostics: Diagnostics, range_s: float) -> Iterator[str]:
    estimate = diagnostics.skew.estimate
    skew_s, std_deg, aligned_deg = estimate.skew_s, estimate.std_deg, estimate.std_aligned_deg
    if estimate.kind == 'beyond':
        yield f'timing: {estimate.why_not(range_s)}'
    if (estimate.significant and estimate.well_determined and skew_s is not None
            and std_deg is not None and aligned_deg is not None):
        share = 1.0 - (aligned_deg / std_deg) ** 2
        if share > assumptions.SKEW_SHARE:
            age = 'older' if skew_s > 0.0 else 'newer'
            yield (f'timing: the TS data are {abs(skew_s):.3f} s {age} than their stamps '
                   'say, compared with the RS; that makes up '
                   f'{100.0 * share:.0f} % of the variance')
    warm_up = diagnostics.drift.warm_up
    if warm_up is not None and warm_up.stabilization_s > 0.0:
        yield (f'warm_up: the difference is still settling; it is within '
               f'{warm_up.tolerance_deg:.3g} deg {warm_up.settle_s:.4g} s after its first value')
    normality = diagnostics.normality
    steps = [s for s in (normality.ts_step_deg, normality.rs_step_deg) if s]
    std = normality.difference.std_deg
    if steps and std is not None and std < 0.5 * max(steps):
        yield (f'resolution: the differences scatter by {std:.2g} deg, less than half of the '
               f'{max(steps):.2g} deg step in which a sensor reports')
    stamps = diagnostics.correlation.stamps
    if stamps.silences:
        yield (f'silence: the pairs fall silent '
               f'{"once" if stamps.silences == 1 else f"{stamps.silences} times"}, for up to '
               f'{stamps.longest_s:.1f} s; correlation times and block lengths ignore this')
