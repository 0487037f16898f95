# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The verdict as a table on the terminal: a row a figure, a column a run."""

from __future__ import annotations

from typing import Any, Callable, Mapping, Sequence

from heading_intercompare.report.formatting import explain_no_run, NO_RUN, utc
from heading_intercompare.report.vocabulary import (
    CAMPAIGN_WORDS,
    EFFECT_WORDS,
    OUTCOME_WORDS,
    REASON_WORDS,
)

__all__ = ['verdict_text']

_COLUMNS = 5


def _number(value: float | int | None, digits: int = 4) -> str:
    if value is None:
        return '-'
    if isinstance(value, int):
        return str(value)
    return f'{value:.{digits}f}' if abs(value) < 1e5 else f'{value:.4g}'


def _rejected(run: Mapping[str, Any]) -> str:
    parts = [f'{n} {s.upper()} {reason}' for s, reasons in run['pairing']['rejected'].items()
             for reason, n in reasons.items()]
    return ', '.join(parts) or '0'


def _range(low: float | None, high: float | None, digits: int = 4) -> str:
    return f'{_number(low, digits)} .. {_number(high, digits)}'


_Text = Callable[[Mapping[str, Any]], str]


def _figure(path: str, digits: int = 4) -> _Text:
    """Return what prints the figure under a dotted name."""
    def text(run: Mapping[str, Any]) -> str:
        value: Any = run
        for key in path.split('.'):
            value = value[key]
        return OUTCOME_WORDS[value] if isinstance(value, str) else _number(value, digits)
    return text


def _guarded(low: str, high: str, digits: int = 4) -> _Text:
    return lambda r: _range(r['guarded'][low], r['guarded'][high], digits)


_ROWS: tuple[tuple[str, _Text], ...] = (
    ('outcome', _figure('outcome')),
    ('GK as printed', _figure('paper_outcome')),
    ('first pair, UTC', lambda r: utc(r['start_ns'])),
    ('duration [s]', _figure('duration_s', 1)),
    ('pairs', _figure('pairing.paired')),
    ('TS received', _figure('pairing.ts_received')),
    ('  paired as they are', _figure('pairing.ts_paired')),
    ('  only interpolated between', _figure('pairing.ts_used')),
    ('  without partner', _figure('pairing.ts_unpaired')),
    ('RS received', _figure('pairing.rs_received')),
    ('  paired or interpolated between', _figure('pairing.rs_used')),
    ('  not used', _figure('pairing.rs_unused')),
    ('rejected', _rejected),
    ('analysed n', _figure('n')),
    ('effective size nu', _figure('guarded.nu', 1)),
    ('mean difference [deg]', _figure('mean_deg')),
    ('largest |difference| [deg]', _figure('max_abs_deg')),
    ('standard deviation [deg]', _figure('std_deg')),
    ('variance [deg2]', _figure('variance_deg2', 6)),
    ('  with its bounds [deg2]', _guarded('lower_bound_deg2', 'upper_bound_deg2', 6)),
    ('  acceptance limit [deg2]', _figure('guarded.acceptance_limit_deg2', 6)),
    ('  rejection limit [deg2]', _figure('guarded.rejection_limit_deg2', 6)),
    ('GK (5) variance', _figure('variance_criterion.outcome')),
    ('n+ / n++ / allowed', lambda r: '{n_plus} / {n_plus_plus} / {allowed:.2f}'.format(
        **r['count_criterion'])),
    ('GK (6) counts', _figure('count_criterion.outcome')),
    ('sigma of the TS [deg]', _guarded('sigma_ts_lower_deg', 'sigma_ts_upper_deg')),
    ('total TS error [deg]', lambda r: _range(r['total_error']['low_deg'],
                                              r['total_error']['up_deg'])),
)


def verdict_text(verdict: Mapping[str, Any]) -> str:
    """
    Return a verdict as text for a terminal, without a final newline.

    Parameters
    ----------
    verdict : mapping
        `Verdict.to_dict()`, or the JSON of a report.

    """
    settings, runs = verdict['settings'], verdict['runs']
    campaign = verdict['campaign']
    lines = [f'VERDICT: {verdict["headline"]}',
             f'GK as printed: {OUTCOME_WORDS[verdict["paper_outcome"]]}']
    norm = (f'by {settings["norms.preset"]}' if settings['norms.preset'] is not None
            else f'{settings["norms.sigma_max_deg"]:g} deg')
    lines.append(f'norms: sigma_max {norm}, sigma_ref_max '
                 f'{settings["norms.sigma_ref_max_deg"]:g} deg, '
                 f'P {settings["norms.probability"]:g}; '
                 f'model {settings["model"]}, variant {settings["variant"]}; '
                 f'risks: consumer {settings["risk.alpha_consumer"]:g}, '
                 f'producer {settings["risk.alpha_producer"]:g}')
    for first in range(0, len(runs), _COLUMNS):
        lines += ['', *_table(runs[first:first + _COLUMNS])]
    lines.append('')
    several = len(verdict['inputs']) > 1
    if len(runs) > 1:
        lines.append(f'together ({campaign["rule"]}): {CAMPAIGN_WORDS[campaign["reason"]]}')
    for run in runs:
        of = f' of {run["source"]}' if several else ''
        lines.append(f'run {run["run"]}{of}: {REASON_WORDS.get(run["reason"], run["reason"])}')
        lines += [f'  {EFFECT_WORDS[found["effect"]]}: {found["evidence"]}'
                  for found in run['validity'] if found['effect'] in ('doubtful', 'void')]
        lines += [f'  look {look["look"]} of {look["looks"]} at {look["span_s"]:.0f} s: '
                  f'{look["headline"]}' for look in run['looks']]
        lines += [f'  warning: {warning}' for warning in run['warnings']]
    reasons = [f'not judged: {given["path"]}: {why}' for given in verdict['inputs']
               if (why := explain_no_run(given))]
    lines += reasons if reasons or runs else [NO_RUN]
    return '\n'.join(lines)


def _table(runs: Sequence[Mapping[str, Any]]) -> list[str]:
    rows = [('', *(f'run {r["run"]}' for r in runs))]
    rows += [(name, *(text(r) for r in runs)) for name, text in _ROWS]
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    return ['  '.join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip()
            for row in rows]
