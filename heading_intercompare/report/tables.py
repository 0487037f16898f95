# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The tables of a report: which figure stands in which row, with its unit."""

from __future__ import annotations

from typing import Any, Callable, Iterable, Mapping, Sequence

from .formatting import ABSENT, interval, number, outcome, utc, value
from .markup import element, join, Markup

__all__ = ['facts', 'GUARDED', 'LEDGER', 'RESULTS', 'Row', 'rows_by_run', 'SENSOR', 'table',
           'WORST']

_COLUMNS = 5

Mapped = Mapping[str, Any]
Row = tuple[str, str, Callable[[Mapped], str]]
"""Name, unit and what prints the cell from a run."""


def _figure(path: str) -> Callable[[Mapped], str]:
    """Return what prints the figure under a dotted name."""
    def text(run: Mapped) -> str:
        thing: Any = run
        for key in path.split('.'):
            thing = thing[key]
        return value(thing)
    return text


def _interval(block: str, low: str, up: str) -> Callable[[Mapped], str]:
    return lambda run: interval(run[block][low], run[block][up])


def _rejected(stream: str) -> Callable[[Mapped], str]:
    def text(run: Mapped) -> str:
        reasons = run['pairing']['rejected'][stream]
        return ', '.join(f'{n} {reason}' for reason, n in reasons.items()) or '0'
    return text


def _drift(run: Mapped) -> str:
    return ', '.join(number(c) for c in run['drift_coefficients_deg']) or ABSENT


LEDGER: tuple[Row, ...] = (
    ('pairs', '1', _figure('pairing.paired')),
    ('TS readings received', '1', _figure('pairing.ts_received')),
    ('of these paired as they are', '1', _figure('pairing.ts_paired')),
    ('of these only interpolated between', '1', _figure('pairing.ts_used')),
    ('of these without partner', '1', _figure('pairing.ts_unpaired')),
    ('of these rejected, by reason', '1', _rejected('ts')),
    ('RS readings received', '1', _figure('pairing.rs_received')),
    ('of these paired or interpolated between', '1', _figure('pairing.rs_used')),
    ('of these not used', '1', _figure('pairing.rs_unused')),
    ('of these rejected, by reason', '1', _rejected('rs')),
    ('mean lag RS - TS', 's', _figure('pairing.mean_lag_s')),
    ('largest |lag|', 's', _figure('pairing.max_lag_s')),
    ('factor of the RS noise variance by interpolation', '1',
     _figure('pairing.rs_variance_factor')),
    ('factor of the TS noise variance by interpolation', '1',
     _figure('pairing.ts_variance_factor')),
    ('pairs given', '1', _figure('n_input')),
    ('left out: not finite', '1', _figure('n_invalid')),
    ('left out: stabilisation period', '1', _figure('n_stabilization')),
    ('differences analysed, n', '1', _figure('n')),
)

RESULTS: tuple[Row, ...] = (
    ('verdict on the run', '', _figure('outcome')),
    ('verdict as printed in GK', '', _figure('paper_outcome')),
    ('source', '', _figure('source')),
    ('first pair', 'UTC', lambda run: utc(run['start_ns'])),
    ('last pair', 'UTC', lambda run: utc(run['end_ns'])),
    ('duration', 's', _figure('duration_s')),
    ('differences analysed, n', '1', _figure('n')),
    ('mean difference', 'deg', _figure('mean_deg')),
    ('least difference', 'deg', _figure('min_deg')),
    ('largest difference', 'deg', _figure('max_deg')),
    ('largest |difference|', 'deg', _figure('max_abs_deg')),
    ('mean square', 'deg²', _figure('mean_square_deg2')),
    ('circular mean', 'deg', _figure('circular_mean_deg')),
    ('resultant length', '1', _figure('resultant_length')),
    ('coefficients of the drift removed', 'deg', _drift),
    ('variance, GK (4)', 'deg²', _figure('variance_deg2')),
    ('standard deviation', 'deg', _figure('std_deg')),
    ('GK (5): variance limit', 'deg²', _figure('variance_criterion.limit_deg2')),
    ("GK (5'): tightened variance limit", 'deg²',
     _figure('variance_criterion.tightened_limit_deg2')),
    ("GK (5''): ratio", '1', _figure('variance_criterion.ratio')),
    ('GK (5): width of the dead zone', '1', _figure('variance_criterion.dead_zone_width')),
    ('GK (5): outcome', '', _figure('variance_criterion.outcome')),
    ('GK (*): coverage factor', '1', _figure('count_criterion.k')),
    ('GK (**): coverage factor', '1', _figure('count_criterion.k_tightened')),
    ('GK (*): limit of a deviation', 'deg', _figure('count_criterion.limit_deg')),
    ('GK (**): tightened limit', 'deg', _figure('count_criterion.tightened_limit_deg')),
    ('GK (6): n+ beyond the limit', '1', _figure('count_criterion.n_plus')),
    ('GK (6): n++ beyond the tightened limit', '1', _figure('count_criterion.n_plus_plus')),
    ('GK (6): allowed, n (1 - P)', '1', _figure('count_criterion.allowed')),
    ('GK (6): width of the dead zone', '1', _figure('count_criterion.dead_zone_width')),
    ('GK (6): outcome', '', _figure('count_criterion.outcome')),
    ('GK (7): coverage factor', '1', _figure('total_error.k')),
    ('GK (7): TS standard deviation, RS at its upper .. lower bound', 'deg',
     _interval('total_error', 'sigma_ts_low_deg', 'sigma_ts_up_deg')),
    ('GK (7): total TS error, wide', 'deg', _interval('total_error', 'low_deg', 'up_deg')),
    ('GK (7): total TS error, narrow', 'deg',
     _interval('total_error', 'low_narrow_deg', 'up_narrow_deg')),
    ('GK (7): outcome', '', lambda run: outcome(run['total_error']['outcome'])),
)

GUARDED: tuple[Row, ...] = (
    ('outcome on the variance', '', _figure('guarded.outcome')),
    ('outcome on the counts', '', _figure('guarded.count_outcome')),
    ('variance with what the removed mean has swallowed', 'deg²', _figure('guarded.d_hat_deg2')),
    ("its upper bound U, at the consumer's risk", 'deg²', _figure('guarded.upper_bound_deg2')),
    ('acceptance limit A', 'deg²', _figure('guarded.acceptance_limit_deg2')),
    ("its lower bound L, at the producer's risk", 'deg²', _figure('guarded.lower_bound_deg2')),
    ('rejection limit R', 'deg²', _figure('guarded.rejection_limit_deg2')),
    ('TS standard deviation, bounds', 'deg',
     _interval('guarded', 'sigma_ts_lower_deg', 'sigma_ts_upper_deg')),
    ('effective degrees of freedom', '1', _figure('guarded.nu')),
    ('degrees of freedom of the slow part, f', '1', _figure('guarded.f')),
    ('corner of the spectrum of the squares, half-periods', '1', _figure('guarded.corner_j')),
    ('lowest half-periods over the middle ones', '1', _figure('guarded.r_slow')),
    ('variance of the slow part that shows', 'deg²', _figure('guarded.slow_variance_deg2')),
    ('allowance for it in U', 'deg²', _figure('guarded.slow_allowance_deg2')),
    ('confidence that the variance is at most A', '1', _figure('guarded.confidence_compliant')),
    ('confidence that the variance is above R', '1',
     _figure('guarded.confidence_non_compliant')),
    ('conformance probability', '1', _figure('guarded.conformance_probability')),
    ('times the duration that would decide', '1', _figure('guarded.duration_factor')),
    ('duration that would decide', 'h', _figure('guarded.hours_needed')),
    ('mean difference: standard uncertainty', 'deg', _figure('guarded.bias_u_deg')),
    ('mean difference: 95 % interval', 'deg',
     lambda run: interval(*(run['guarded']['bias_interval_deg'] or (None, None)))),
    ('mean difference significant', '', _figure('guarded.bias_significant')),
    ('rate beyond the limit, n+ / n', '1', _figure('guarded.rate_plus')),
    ('its lower bound', '1', _figure('guarded.rate_plus_lower')),
    ('rate beyond the tightened limit, n++ / n', '1', _figure('guarded.rate_plus_plus')),
    ('its upper bound', '1', _figure('guarded.rate_plus_plus_upper')),
)

WORST: tuple[Row, ...] = (
    ('runs, m', '1', _figure('m')),
    ('largest variance', 'deg²', _figure('worst_variance_deg2')),
    ('in run', '', _figure('worst_variance_run')),
    ('largest rate beyond the limit', '1', _figure('worst_plus_rate')),
    ('largest rate beyond the tightened limit', '1', _figure('worst_plus_plus_rate')),
    ('mean difference, least', 'deg', _figure('a_low_deg')),
    ('mean difference, largest', 'deg', _figure('a_up_deg')),
    ('total TS error, least', 'deg', _figure('low_worst_deg')),
    ('total TS error, largest', 'deg', _figure('up_worst_deg')),
)

SENSOR: tuple[Row, ...] = (
    ('runs with 128 differences or more', '1', _figure('runs')),
    ('their differences', '1', _figure('n')),
    ('their lengths added up', 's', _figure('span_s')),
    ('mean variance, weighted', 'deg²', _figure('d_hat_deg2')),
    ('effective degrees of freedom', '1', _figure('nu')),
    ('degrees of freedom of the slow part', '1', _figure('f')),
    ('allowance for a slow part that shows', 'deg²', _figure('slow_allowance_deg2')),
    ('upper bound from within the runs', 'deg²', _figure('pooled_upper_bound_deg2')),
    ('upper bound from the means of the runs', 'deg²', _figure('between_upper_bound_deg2')),
    ('upper bound U in force', 'deg²', _figure('upper_bound_deg2')),
    ('acceptance limit A', 'deg²', _figure('acceptance_limit_deg2')),
    ('lower bound L', 'deg²', _figure('lower_bound_deg2')),
    ('rejection limit R', 'deg²', _figure('rejection_limit_deg2')),
    ('lower bound of the rate beyond the limit', '1', _figure('rate_plus_lower')),
)


def table(head: Sequence[object], rows: Iterable[Sequence[object]], **attributes: str) -> Markup:
    """Return a table; the first cell of each row names it."""
    body = [element('tr', element('th', row[0], scope='row'),
                    *(element('td', cell) for cell in row[1:])) for row in rows]
    top = element('thead', element('tr', *(element('th', cell, scope='col') for cell in head))) \
        if head else ''
    return element('table', top, element('tbody', *body), **attributes)


def rows_by_run(rows: Sequence[Row], runs: Sequence[Mapped], *, units: bool = True) -> Markup:
    """Return tables of a row a figure and a column a run, a few runs in each."""
    parts = []
    for first in range(0, len(runs), _COLUMNS):
        some = runs[first:first + _COLUMNS]
        parts.append(table(['', *(['unit'] if units else []),
                            *(f'run {run["run"]}' for run in some)],
                           [[name, *([unit] if units else []), *(text(run) for run in some)]
                            for name, unit, text in rows]))
    return join(parts)


def facts(rows: Iterable[tuple[str, object]]) -> Markup:
    """Return a table of names and values; a value that is '' is left to be filled by hand."""
    return table([], [(name, thing if thing != '' else element('span', '', class_='blank'))
                      for name, thing in rows], class_='facts')
