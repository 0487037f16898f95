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
from heading_intercompare.core.declared_figures import Figure, find_figure, list_figures
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
    worth_of,
)

_COLUMNS = 4

Thing = TypeVar('Thing')


@dataclass(frozen=True, slots=True)
class Row(Generic[Thing]):
    """
    One row of a table.

    Attributes
    ----------
    unit
        '1' for a number without dimension, '' for anything but a number.
    figure
        Takes the subject of the table; returns a figure, or words.
    holds
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


#: The figures of a run that need not hold beside its outcome; all others do.
_HOLDS: dict[str, Callable[[RunVerdict], bool]] = {
    **dict.fromkeys(('paper_outcome', 'variance_criterion.outcome', 'count_criterion.outcome',
                     'total_error.outcome', 'guarded.outcome', 'guarded.count_outcome',
                     'guarded.lower_bound_deg2'), is_sound),
    **dict.fromkeys(('guarded.upper_bound_deg2', 'guarded.sigma_ts_lower_deg',
                     'guarded.slow_allowance_deg2', 'guarded.rate_plus_plus_upper'),
                    upper_bound_holds),
    'guarded.nu': lambda run: worth_of(run) is not None,
    'guarded.confidence_compliant': confidence_holds,
    'guarded.confidence_non_compliant': confidence_holds,
    'guarded.conformance_probability': probability_holds,
    'guarded.duration_factor': length_holds, 'guarded.hours_needed': length_holds}


def _declare(kind: Any, keys: str, block: str = '') -> tuple[Row[Any], ...]:
    """Return the rows of figures of a dataclass by their keys, which may be within a block."""
    figures = list_figures(kind)
    return tuple(_make_row(f'{block}{key}', figures[f'{block}{key}']) for key in keys.split())


def _make_row(key: str, figure: Figure) -> Row[Any]:
    def show(thing: Any) -> Any:
        shown = find_figure(thing, key)
        if figure.unit == 'UTC':
            return utc(shown)
        if key.endswith('interval_deg'):
            return interval(*(shown or (None, None)))
        if isinstance(shown, Mapping):
            return ', '.join(f'{n} {figure.choices.get(reason, reason)}'
                             for reason, n in shown.items()) or '0'
        return interval(shown, find_figure(thing, figure.up_key)) if figure.up_key else shown

    return Row(figure.words, figure.unit, show, _HOLDS.get(key, lambda thing: True))


LEDGER: tuple[Row[RunVerdict], ...] = (
    *_declare(RunVerdict, """
        paired ts_received ts_paired ts_used ts_unpaired ts_unbridged ts_held rejected.ts lost.ts
        rs_received rs_used rs_unused rs_unbridged rs_held rejected.rs lost.rs mean_lag_s max_lag_s
        rs_variance_factor ts_variance_factor""", 'pairing.'),
    *_declare(RunVerdict, 'n_input n_invalid n_stabilization'),
    Row('left out: taken out by hand', '1',
        lambda run: 0 if run.taken_out is None else run.taken_out.n),
    *_declare(RunVerdict, 'n'),
    Row('clocks set back before it', '1', lambda run: run.clock_segment or 0),
)

RESULTS = _declare(RunVerdict, """
    outcome source start_ns end_ns duration_s coverage.span_s coverage.longest_s
    coverage.stated_s coverage.least_duration_s n mean_deg min_deg max_deg max_abs_deg
    limit_95.limit_deg limit_95.lower_deg mean_square_deg2 resultant_length drift_coefficients_deg
    variance_deg2 std_deg total_error.k total_error.sigma_ts_low_deg total_error.low_deg
    total_error.low_narrow_deg total_error.outcome""")

GK_RESULTS = _declare(RunVerdict, """
    paper_outcome variance_criterion.limit_deg2 variance_criterion.tightened_limit_deg2
    variance_criterion.ratio variance_criterion.dead_zone_width variance_criterion.outcome
    count_criterion.k count_criterion.k_tightened count_criterion.limit_deg
    count_criterion.tightened_limit_deg count_criterion.n_plus count_criterion.n_plus_plus
    count_criterion.allowed count_criterion.dead_zone_width count_criterion.outcome""")

SUMMARY: tuple[Row[RunVerdict], ...] = (
    Row('outcome', '', lambda run: run.outcome),
    Row('first pair', 'UTC', lambda run: utc(run.start_ns)),
    Row('length analysed', 'h', lambda run: number(run.coverage.span_s / 3600.0, 4)),
    Row('differences, n', '1', lambda run: run.n),
    Row('independent differences they are worth for the variance', '1',
        lambda run: rounded(worth_of(run), worth_of(run))),
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
)

GK_SUMMARY: tuple[Row[RunVerdict], ...] = (
    Row('differences beyond the limit, and allowed', '1',
        lambda run: f'{run.count_criterion.n_plus} of {number(run.count_criterion.allowed, 4)}'),
)

GUARDED: tuple[Row[RunVerdict], ...] = (
    *_declare(RunVerdict, """
        outcome count_outcome d_hat_deg2 upper_bound_deg2 acceptance_limit_deg2 lower_bound_deg2
        rejection_limit_deg2 sigma_ts_lower_deg nu f corner_j r_slow slow_variance_deg2
        slow_allowance_deg2 stated_times confidence_compliant confidence_non_compliant
        conformance_probability duration_factor hours_needed bias_u_deg bias_interval_deg
        bias_significant rate_plus rate_plus_lower rate_plus_plus rate_plus_plus_upper""",
              'guarded.'),
)

WORST = _declare(Campaign, """
    m worst_variance_deg2 worst_variance_run worst_plus_rate worst_plus_plus_rate a_low_deg
    a_up_deg low_worst_deg up_worst_deg""")

SENSOR = _declare(Together, """
    runs n span_s apart_s d_hat_deg2 nu f slow_allowance_deg2 pooled_upper_bound_deg2
    between_upper_bound_deg2 scatter_upper_bound_deg2 stated_times upper_bound_deg2
    acceptance_limit_deg2 lower_bound_deg2 rejection_limit_deg2 rate_plus_lower""")


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
