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

"""The tables of a report: the figure and the unit of each row."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, Generic, Mapping, Sequence, TypeVar

from heading_intercompare.core.decision.campaign import Together
from heading_intercompare.core.runs.pairing_figures import LostReadings
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.verdict.verdict_document import Campaign, RunVerdict
from heading_intercompare.report.formatting import (
    ABSENT,
    bounds,
    interval,
    number,
    rounded,
    value,
    with_uncertainty,
)

from .holding import (
    confidence_holds,
    is_sound,
    length_holds,
    probability_holds,
    upper_bound_holds,
)

__all__ = ['GUARDED', 'LEDGER', 'RESULTS', 'Row', 'rows_by_run', 'rows_of', 'SENSOR', 'SUMMARY',
           'Table', 'WORST']

_COLUMNS = 4

Thing = TypeVar('Thing')


@dataclass(frozen=True, slots=True)
class Row(Generic[Thing]):
    """
    One row of a table.

    Attributes
    ----------
    name : str
    unit : str
        '1' for a number without dimension, '' for anything but a number.
    figure : callable
        Takes the subject of the table; returns a figure, or words.
    holds : callable
        Tells whether the figure may stand beside the outcome of the subject; otherwise the cell
        is a dash.

    """

    name: str
    unit: str
    figure: Callable[[Thing], Any]
    holds: Callable[[Thing], bool] = lambda thing: True

    def cell(self, thing: Thing) -> str:
        """Return the figure of a subject as text."""
        return value(self.figure(thing)) if self.holds(thing) else ABSENT


@dataclass(frozen=True, slots=True)
class Table:
    """A table: a head and rows of equal length; the first cell of a row is its name."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]


def _list_reasons(reasons: Mapping[str, int]) -> str:
    return ', '.join(f'{n} {reason}' for reason, n in reasons.items()) or '0'


def _lost(lost: LostReadings | None, sensor: str) -> str:
    if lost is None:
        return ABSENT
    wheres = {'ts': lost.ts, 'rs': lost.rs}[sensor]
    return ', '.join(f'{n} {where.replace("_", " ")}' for where, n in wheres.items()) or '0'


LEDGER: tuple[Row[RunVerdict], ...] = (
    Row('pairs', '1', lambda run: run.pairing.paired),
    Row('TS readings received', '1', lambda run: run.pairing.ts_received),
    Row('of these paired as they are', '1', lambda run: run.pairing.ts_paired),
    Row('of these only interpolated between', '1', lambda run: run.pairing.ts_used),
    Row('of these without a partner', '1', lambda run: run.pairing.ts_unpaired),
    Row('of these beside a gap of the RS', '1', lambda run: run.pairing.ts_unbridged),
    Row('of these repeating a held value', '1', lambda run: run.pairing.ts_held),
    Row('of these rejected, by reason', '1', lambda run: _list_reasons(run.pairing.rejected.ts)),
    Row('TS readings lost besides', '1', lambda run: _lost(run.pairing.lost, 'ts')),
    Row('RS readings received', '1', lambda run: run.pairing.rs_received),
    Row('of these paired or interpolated between', '1', lambda run: run.pairing.rs_used),
    Row('of these not used', '1', lambda run: run.pairing.rs_unused),
    Row('of these beside a gap of the TS', '1', lambda run: run.pairing.rs_unbridged),
    Row('of these repeating a held value', '1', lambda run: run.pairing.rs_held),
    Row('of these rejected, by reason', '1', lambda run: _list_reasons(run.pairing.rejected.rs)),
    Row('RS readings lost besides', '1', lambda run: _lost(run.pairing.lost, 'rs')),
    Row('mean lag RS - TS', 's', lambda run: run.pairing.mean_lag_s),
    Row('largest |lag|', 's', lambda run: run.pairing.max_lag_s),
    Row('factor of the RS noise variance by interpolation', '1',
        lambda run: run.pairing.rs_variance_factor),
    Row('factor of the TS noise variance by interpolation', '1',
        lambda run: run.pairing.ts_variance_factor),
    Row('pairs given', '1', lambda run: run.n_input),
    Row('left out: not finite', '1', lambda run: run.n_invalid),
    Row('left out: stabilisation period', '1', lambda run: run.n_stabilization),
    Row('left out: taken out by hand', '1',
        lambda run: 0 if run.taken_out is None else run.taken_out.n),
    Row('differences analysed, n', '1', lambda run: run.n),
)

RESULTS: tuple[Row[RunVerdict], ...] = (
    Row('verdict on the run', '', lambda run: run.outcome),
    Row('verdict as printed in GK', '', lambda run: run.paper_outcome, is_sound),
    Row('source', '', lambda run: run.source),
    Row('first pair', 'UTC', lambda run: utc(run.start_ns)),
    Row('last pair', 'UTC', lambda run: utc(run.end_ns)),
    Row('duration', 's', lambda run: run.duration_s),
    Row('length analysed', 's', lambda run: run.coverage.span_s),
    Row('slowest errors covered, if the run decides', 's', lambda run: run.coverage.longest_s),
    Row('slowest error stated', 's', lambda run: run.coverage.stated_s),
    Row('least length of a run that may comply', 's',
        lambda run: run.coverage.least_duration_s),
    Row('differences analysed, n', '1', lambda run: run.n),
    Row('mean difference', 'deg', lambda run: run.mean_deg),
    Row('minimum difference', 'deg', lambda run: run.min_deg),
    Row('maximum difference', 'deg', lambda run: run.max_deg),
    Row('largest |difference|', 'deg', lambda run: run.max_abs_deg),
    Row('limit that 95 % of the differences keep, about their mean', 'deg',
        lambda run: None if run.limit_95 is None else run.limit_95.limit_deg),
    Row('its lower .. upper bound at 95 % confidence', 'deg', lambda run: ABSENT if (
        run.limit_95 is None) else interval(run.limit_95.lower_deg, run.limit_95.upper_deg)),
    Row('mean square', 'deg²', lambda run: run.mean_square_deg2),
    Row('resultant length', '1', lambda run: run.resultant_length),
    Row('coefficients of the drift removed', 'deg',
        lambda run: ', '.join(number(c) for c in run.drift_coefficients_deg) or ABSENT),
    Row('variance, GK (4)', 'deg²', lambda run: run.variance_deg2),
    Row('standard deviation', 'deg', lambda run: run.std_deg),
    Row('GK (5): variance limit', 'deg²', lambda run: run.variance_criterion.limit_deg2),
    Row("GK (5'): tightened variance limit", 'deg²',
        lambda run: run.variance_criterion.tightened_limit_deg2),
    Row("GK (5''): ratio", '1', lambda run: run.variance_criterion.ratio),
    Row('GK (5): width of the dead zone', '1', lambda run: run.variance_criterion.dead_zone_width),
    Row('GK (5): outcome', '', lambda run: run.variance_criterion.outcome, is_sound),
    Row('GK (*): coverage factor', '1', lambda run: run.count_criterion.k),
    Row('GK (**): coverage factor', '1', lambda run: run.count_criterion.k_tightened),
    Row('GK (*): limit of a deviation', 'deg', lambda run: run.count_criterion.limit_deg),
    Row('GK (**): tightened limit', 'deg', lambda run: run.count_criterion.tightened_limit_deg),
    Row('GK (6): n+ beyond the limit', '1', lambda run: run.count_criterion.n_plus),
    Row('GK (6): n++ beyond the tightened limit', '1',
        lambda run: run.count_criterion.n_plus_plus),
    Row('GK (6): allowed, n (1 - P)', '1', lambda run: run.count_criterion.allowed),
    Row('GK (6): width of the dead zone', '1', lambda run: run.count_criterion.dead_zone_width),
    Row('GK (6): outcome', '', lambda run: run.count_criterion.outcome, is_sound),
    Row('GK (7): coverage factor', '1', lambda run: run.total_error.k),
    Row('GK (7): TS standard deviation, RS at its upper .. lower bound', 'deg',
        lambda run: interval(run.total_error.sigma_ts_low_deg, run.total_error.sigma_ts_up_deg)),
    Row('GK (7): total TS error, wide', 'deg',
        lambda run: interval(run.total_error.low_deg, run.total_error.up_deg)),
    Row('GK (7): total TS error, narrow', 'deg',
        lambda run: interval(run.total_error.low_narrow_deg, run.total_error.up_narrow_deg)),
    Row('GK (7): outcome', '', lambda run: run.total_error.outcome, is_sound),
)

SUMMARY: tuple[Row[RunVerdict], ...] = (
    Row('outcome', '', lambda run: run.outcome),
    Row('first pair', 'UTC', lambda run: utc(run.start_ns)),
    Row('length analysed', 'h', lambda run: number(run.coverage.span_s / 3600.0, 4)),
    Row('differences, n', '1', lambda run: run.n),
    Row('independent differences they are worth for the variance', '1',
        lambda run: rounded(run.guarded.nu, run.guarded.nu)),
    Row('mean difference and its standard uncertainty', 'deg',
        lambda run: with_uncertainty(run.mean_deg, run.guarded.bias_u_deg)),
    Row('its 95 % interval', 'deg',
        lambda run: bounds(*(run.guarded.bias_interval_deg or (None, None)))),
    Row('standard deviation of the difference', 'deg', lambda run: number(run.std_deg, 3)),
    Row('variance of the difference', 'deg²', lambda run: number(run.variance_deg2, 3)),
    Row('its bounds at the stated risks', 'deg²',
        lambda run: bounds(run.guarded.lower_bound_deg2, run.guarded.upper_bound_deg2),
        upper_bound_holds),
    Row('at most, to comply: A', 'deg²',
        lambda run: number(run.guarded.acceptance_limit_deg2, 3)),
    Row('above, not to comply: R', 'deg²',
        lambda run: number(run.guarded.rejection_limit_deg2, 3)),
    Row('standard deviation of the TS, bounds', 'deg',
        lambda run: bounds(run.guarded.sigma_ts_lower_deg, run.guarded.sigma_ts_upper_deg),
        upper_bound_holds),
    Row('total TS error by GK (7)', 'deg',
        lambda run: bounds(run.total_error.low_deg, run.total_error.up_deg), is_sound),
    Row('differences beyond the limit, and allowed', '1',
        lambda run: f'{run.count_criterion.n_plus} of {number(run.count_criterion.allowed, 4)}'),
)

GUARDED: tuple[Row[RunVerdict], ...] = (
    Row('outcome on the variance', '', lambda run: run.guarded.outcome, is_sound),
    Row('outcome on the counts', '', lambda run: run.guarded.count_outcome, is_sound),
    Row('variance, including the part that the removed mean absorbed', 'deg²',
        lambda run: run.guarded.d_hat_deg2),
    Row("its upper bound U, at the consumer's risk", 'deg²',
        lambda run: run.guarded.upper_bound_deg2,
        upper_bound_holds),
    Row('acceptance limit A', 'deg²', lambda run: run.guarded.acceptance_limit_deg2),
    Row("its lower bound L, at the producer's risk", 'deg²',
        lambda run: run.guarded.lower_bound_deg2,
        is_sound),
    Row('rejection limit R', 'deg²', lambda run: run.guarded.rejection_limit_deg2),
    Row('TS standard deviation, bounds', 'deg',
        lambda run: interval(run.guarded.sigma_ts_lower_deg, run.guarded.sigma_ts_upper_deg),
        upper_bound_holds),
    Row('effective degrees of freedom of the variance', '1', lambda run: run.guarded.nu),
    Row('degrees of freedom of the slow part, f', '1', lambda run: run.guarded.f),
    Row('corner of the spectrum of the squares, half-periods', '1',
        lambda run: run.guarded.corner_j),
    Row('ratio of the lowest half-periods to the middle ones', '1',
        lambda run: run.guarded.r_slow),
    Row('variance of the visible slow part', 'deg²',
        lambda run: run.guarded.slow_variance_deg2),
    Row('allowance for the slow part in U', 'deg²', lambda run: run.guarded.slow_allowance_deg2,
        upper_bound_holds),
    Row('length in slowest errors stated, if U rests on them', '1',
        lambda run: run.guarded.stated_times),
    Row('confidence that the variance is at most A', '1',
        lambda run: run.guarded.confidence_compliant,
        confidence_holds),
    Row('confidence that the variance is above R', '1',
        lambda run: run.guarded.confidence_non_compliant,
        confidence_holds),
    Row('conformance probability', '1', lambda run: run.guarded.conformance_probability,
        probability_holds),
    Row('length with which the run alone decides, times this one', '1',
        lambda run: run.guarded.duration_factor,
        length_holds),
    Row('length with which the run alone decides', 'h', lambda run: run.guarded.hours_needed,
        length_holds),
    Row('mean difference: standard uncertainty', 'deg', lambda run: run.guarded.bias_u_deg),
    Row('mean difference: 95 % interval', 'deg',
        lambda run: interval(*(run.guarded.bias_interval_deg or (None, None)))),
    Row('mean difference significant', '', lambda run: run.guarded.bias_significant),
    Row('rate beyond the limit, n+ / n', '1', lambda run: run.guarded.rate_plus),
    Row('its lower bound', '1', lambda run: run.guarded.rate_plus_lower),
    Row('rate beyond the tightened limit, n++ / n', '1', lambda run: run.guarded.rate_plus_plus),
    Row('its upper bound', '1', lambda run: run.guarded.rate_plus_plus_upper,
        upper_bound_holds),
)

WORST: tuple[Row[Campaign], ...] = (
    Row('runs, m', '1', lambda campaign: campaign.m),
    Row('largest variance', 'deg²', lambda campaign: campaign.worst_variance_deg2),
    Row('in run', '', lambda campaign: campaign.worst_variance_run),
    Row('largest rate beyond the limit', '1', lambda campaign: campaign.worst_plus_rate),
    Row('largest rate beyond the tightened limit', '1',
        lambda campaign: campaign.worst_plus_plus_rate),
    Row('mean difference, minimum', 'deg', lambda campaign: campaign.a_low_deg),
    Row('mean difference, maximum', 'deg', lambda campaign: campaign.a_up_deg),
    Row('total TS error, minimum', 'deg', lambda campaign: campaign.low_worst_deg),
    Row('total TS error, maximum', 'deg', lambda campaign: campaign.up_worst_deg),
)

SENSOR: tuple[Row[Together], ...] = (
    Row('runs with 128 differences or more', '1', lambda shared: shared.runs),
    Row('their differences', '1', lambda shared: shared.n),
    Row('their total duration', 's', lambda shared: shared.span_s),
    Row('shortest time between two of them', 's', lambda shared: shared.apart_s),
    Row('mean variance, weighted', 'deg²', lambda shared: shared.d_hat_deg2),
    Row('effective degrees of freedom of the variance', '1', lambda shared: shared.nu),
    Row('degrees of freedom of the slow part', '1', lambda shared: shared.f),
    Row('allowance for a visible slow part', 'deg²', lambda shared: shared.slow_allowance_deg2),
    Row('upper bound from within the runs', 'deg²', lambda shared: shared.pooled_upper_bound_deg2),
    Row('upper bound from the means of the runs', 'deg²',
        lambda shared: shared.between_upper_bound_deg2),
    Row('upper bound from the scatter of the runs', 'deg²',
        lambda shared: shared.scatter_upper_bound_deg2),
    Row('shortest run in slowest errors stated, if U rests on them', '1',
        lambda shared: shared.stated_times),
    Row('upper bound U in force', 'deg²', lambda shared: shared.upper_bound_deg2),
    Row('acceptance limit A', 'deg²', lambda shared: shared.acceptance_limit_deg2),
    Row('lower bound L', 'deg²', lambda shared: shared.lower_bound_deg2),
    Row('rejection limit R', 'deg²', lambda shared: shared.rejection_limit_deg2),
    Row('lower bound of the rate beyond the limit', '1', lambda shared: shared.rate_plus_lower),
)


def rows_of(rows: Sequence[Row[Thing]], thing: Thing) -> list[tuple[str, str, str]]:
    """Return name, unit and cell of each row."""
    return [(row.name, row.unit, row.cell(thing)) for row in rows]


def rows_by_run(rows: Sequence[Row[Thing]], runs: Sequence[tuple[int, Thing]]) -> list[Table]:
    """Return tables with one row per figure and one column per run, a few runs in each."""
    return [Table(['', 'unit', *(f'run {number}' for number, _ in columns)],
                  [[row.name, row.unit, *(row.cell(thing) for _, thing in columns)]
                   for row in rows])
            for columns in (runs[first:first + _COLUMNS]
                            for first in range(0, len(runs), _COLUMNS))]
