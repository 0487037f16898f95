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

"""The analysed columns of a run, and the figures that several of its detectors share."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
import math
from typing import Sequence

import numpy as np

from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.conditions.one_source import find_one_source, OneSource
from heading_intercompare.core.conditions.partings import find_partings, Parting
from heading_intercompare.core.conditions.shared_readings import Fingerprint
from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.records import Integers, Reals
from heading_intercompare.core.runs.run_series import RunSeries
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.statistics.autocorrelation import SeriesCorrelation
from heading_intercompare.core.statistics.drift import remove_polynomial, select_order
from heading_intercompare.core.statistics.moments import count_outside, Moments
from heading_intercompare.core.statistics.resolution import find_resolution, Resolution
from heading_intercompare.core.statistics.warm_up import fit_warm_up
from heading_intercompare.core.time_rules.exclusions import Exclusion, find_excluded
from heading_intercompare.core.timing.realignment import move_pairs
from heading_intercompare.core.timing.skew_instrument import common_tracks, LEAST_PAIRS, Tracks
from heading_intercompare.core.timing.stamp_steps import measure_stamp_steps, StampSteps
from heading_intercompare.core.timing.time_skew import estimate_skew, Skew

from .averaged_pairs import AveragedPairs
from .run_findings import Correlation, describe_correlation

SETTLED_SHARE = 0.1
"""A warm-up has settled when it has fallen to this share of sigma_max."""

HIGHEST_ORDER_REMOVED = 3
"""Highest order of the polynomials that `drift_order` may remove."""


@dataclass(frozen=True, slots=True)
class PreparedRun:
    """
    The analysed part of a run.

    Attributes
    ----------
    stamp_ns, x_deg, rs_deg : ndarray, shape (n,)
        Stamps, differences and RS headings after the stabilisation period.
    residual_deg : ndarray, shape (n,), or None
        Differences minus the polynomial removed, degrees; None if only the mean is removed.
    order
        Order of that polynomial; 0 for the mean.
    coefficients_deg
        Its Legendre coefficients from order 0, degrees; empty if only the mean is removed.
    n_left_out
        Differences at the start that an automatic stabilisation period leaves out.
    moments
        Moments of `x_deg`.
    variance_deg2
        GK (4): sum of squared residuals / (n - 1 - order); None for n < 2 + order.
    taken_out_s
        Time within the run that a person took out, seconds.

    """

    stamp_ns: Integers
    x_deg: Reals
    rs_deg: Reals
    residual_deg: Reals | None
    order: int
    coefficients_deg: tuple[float, ...]
    n_left_out: int
    moments: Moments
    variance_deg2: float | None
    taken_out_s: float = 0.0

    def count_outside(self, variant: str, limit_deg: float) -> int:
        """Count what exceeds a limit: ``|x|`` in variant A, otherwise the absolute residuals."""
        if variant != 'A' and self.residual_deg is not None:
            return count_outside(self.residual_deg, 0.0, limit_deg)
        return count_outside(self.x_deg, 0.0 if variant == 'A' else self.moments.mean_deg,
                             limit_deg)

    @classmethod
    def of(cls, stamp_ns: Integers, x_deg: Reals, rs_deg: Reals,
           settings: Settings, n_left_out: int = 0) -> 'PreparedRun':
        """Build from settled differences; the settings decide which drift to remove."""
        order = settings.drift_order
        if isinstance(order, str):
            chosen = select_order(stamp_ns, x_deg)
            order = 0 if chosen is None else min(chosen.order, HIGHEST_ORDER_REMOVED)
        moments = Moments.of(x_deg)
        if order == 0 or moments.n < 2 + order:
            variance = moments.variance_deg2 if moments.n >= 2 + order else None
            return cls(stamp_ns=stamp_ns, x_deg=x_deg, rs_deg=rs_deg, residual_deg=None, order=0,
                       coefficients_deg=(), n_left_out=n_left_out, moments=moments,
                       variance_deg2=variance)
        fit = remove_polynomial(stamp_ns, x_deg, order)
        squares = float(np.dot(fit.residual_deg, fit.residual_deg))
        return cls(stamp_ns=stamp_ns, x_deg=x_deg, rs_deg=rs_deg, residual_deg=fit.residual_deg,
                   order=fit.order, coefficients_deg=fit.coefficients_deg, n_left_out=n_left_out,
                   moments=moments, variance_deg2=squares / (moments.n - 1 - fit.order))

    @property
    def series_deg(self) -> Reals:
        """Return what gives the variance: the residuals, or the differences; degrees."""
        return self.x_deg if self.residual_deg is None else self.residual_deg

    @property
    def span_s(self) -> float:
        """Time from the first to the last analysed difference that is not taken out, seconds."""
        stamps = self.stamp_ns
        if not stamps.size:
            return 0.0
        return max(0.0, (int(stamps[-1]) - int(stamps[0])) / 1e9 - self.taken_out_s)


def prepare_run(run: RunSeries, limits: Limits, settings: Settings,
                exclusions: Sequence[Exclusion] = ()) -> PreparedRun:
    """
    Remove the stabilisation period and the drift of a run, as the settings say.

    Parameters
    ----------
    run
        A run at its end.
    limits
        `sigma_max_deg` determines when a run has settled.
    settings
        Uses `runs.stabilization_s` and `drift_order`; both may be 'auto'. A run that goes on
        after a cut by the clock has no automatic stabilisation period.
    exclusions
        Stretches to leave out after the stabilisation period, which they do not move.

    References
    ----------
    GK (4) and its conditions on the data.

    """
    stamps, x, rs = run.stamp_ns.values, run.x_deg.values, run.rs_deg.values
    lo = 0
    if run.stabilization_s == 'auto':
        warm_up = fit_warm_up(stamps, x, SETTLED_SHARE * limits.sigma_max_deg)
        if warm_up is not None and warm_up.stabilization_s > 0.0:
            until = int(stamps[0]) + round(warm_up.stabilization_s * 1e9)
            lo = int(np.searchsorted(stamps, until))
            stamps, x, rs = stamps[lo:], x[lo:], rs[lo:]
    if not exclusions:
        return PreparedRun.of(stamps, x, rs, settings, lo)
    stays = find_excluded(stamps, exclusions) < 0
    stamps, x, rs = stamps[stays], x[stays], rs[stays]
    taken_out_ns = sum(
        min(exclusion.end_ns, int(stamps[-1])) - max(exclusion.start_ns, int(stamps[0]))
        for exclusion in exclusions if stamps.size
        and exclusion.start_ns < int(stamps[-1]) and exclusion.end_ns > int(stamps[0]))
    return replace(PreparedRun.of(stamps, x, rs, settings, lo), taken_out_s=taken_out_ns / 1e9)


#: Few enough that intermediate results stay in the cache.
_PIECE = 1 << 14


@dataclass(frozen=True)
class RunColumns:
    """
    The analysed pairs of a run in stamp order, n >= 0. A shared figure is computed once.

    Attributes
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        Stamps in increasing order, nanoseconds.
    x_deg, rs_deg : ndarray, shape (n,)
        Differences, installation offset removed, and headings of the RS; finite, degrees.
    settings
        Uses installation offset, alignment and pairing gap.
    limits
        The limits of the decision on the run.
    residual_deg : ndarray, shape (n,), or None
        Differences minus the polynomial that `drift_order` removed; None if none was.
    factor : ndarray, shape (n,), or None
        Factor by which interpolation reduces the variance of white noise; None is 1.
    interpolates_ts
        Whether the TS is interpolated, not the RS.

    """

    stamp_ns: Integers
    x_deg: Reals
    rs_deg: Reals
    settings: Settings
    limits: Limits
    residual_deg: Reals | None = None
    factor: np.ndarray | None = None
    interpolates_ts: bool = False

    @property
    def n(self) -> int:
        """Return the number of pairs."""
        return self.x_deg.size

    @property
    def series_deg(self) -> Reals:
        """Return what gives the variance: the residuals, or the differences; degrees."""
        return self.x_deg if self.residual_deg is None else self.residual_deg

    @cached_property
    def fingerprint(self) -> Fingerprint | None:
        """By which the readings are known in another run, or elsewhere in this one."""
        return Fingerprint.of(self.stamp_ns, self.x_deg, self.rs_deg)

    @cached_property
    def ts_deg(self) -> Reals:
        """Headings of the TS, which follow from the differences, degrees."""
        ts_deg = np.empty_like(self.x_deg)
        offset_deg = self.settings.installation_offset_deg
        for lo in range(0, self.n, _PIECE):
            part = slice(lo, lo + _PIECE)
            ts_deg[part] = wrap360(self.x_deg[part] + self.rs_deg[part] + offset_deg)
        return ts_deg

    @cached_property
    def tracks(self) -> Tracks | None:
        """Headings of both as continuous tracks; None for too few pairs."""
        if self.n < LEAST_PAIRS or self.stamp_ns[-1] <= self.stamp_ns[0]:
            return None
        return common_tracks(self.stamp_ns, self.x_deg, self.rs_deg)

    @cached_property
    def averaged(self) -> AveragedPairs | None:
        """Return averages over a fraction of a second; None for too few pairs."""
        if self.tracks is None:
            return None
        return AveragedPairs.of(self.tracks, self.n, Moments.of(self.x_deg).m2_deg2,
                                self.settings.wrap_center_deg)

    @cached_property
    def skew(self) -> Skew:
        """Estimate of the time skew between the sensors."""
        alignment = self.settings.alignment
        if alignment.skew == 'off':
            return Skew(0)
        return estimate_skew(self.stamp_ns, self.x_deg, self.rs_deg,
                             range_s=alignment.skew_range_s,
                             max_gap_s=self.settings.pairing.longest_gap_s,
                             clock_range_s=alignment.clock_range_s, tracks=self.tracks)

    @cached_property
    def stamps(self) -> StampSteps:
        """Return steps of the stamps."""
        return measure_stamp_steps(self.stamp_ns)

    @cached_property
    def series(self) -> SeriesCorrelation:
        """Correlation of what gives the variance."""
        return SeriesCorrelation.of(self.series_deg)

    @cached_property
    def correlation(self) -> Correlation:
        """Correlation times and effective numbers of the same."""
        return describe_correlation(self.stamps, self.series)

    @cached_property
    def steps(self) -> tuple[Resolution, Resolution]:
        """Return steps in which TS and RS report."""
        return find_resolution(self.ts_deg), find_resolution(self.rs_deg)

    @cached_property
    def source(self) -> OneSource:
        """Signs that both headings come from one sensor."""
        return find_one_source(self.stamp_ns, self.x_deg, self.rs_deg, factor=self.factor,
                               interpolates_ts=self.interpolates_ts)

    @cached_property
    def partings(self) -> list[Parting]:
        """Stretches in which the sensors point far apart."""
        return find_partings(self.stamp_ns, self.x_deg,
                             math.sqrt(self.limits.rejection_limit_deg2))

    @property
    def at_one_time(self) -> 'RunColumns':
        """
        Return the pairs with clocks that lie apart set right; otherwise these columns.

        Read minutes apart, sound sensors seem to turn against each other, or to be frozen.
        """
        return self._moved or self

    @cached_property
    def _moved(self) -> 'RunColumns | None':
        # Columns that held themselves would stay until the collector of garbage comes.
        apart_s = self.skew.apart_s
        if apart_s is None:
            return None
        return RunColumns(*move_pairs(self.stamp_ns, self.x_deg, self.rs_deg, apart_s),
                          self.settings, self.limits, interpolates_ts=self.interpolates_ts)
