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

"""A verdict as a table for people, with a row per figure and a column per run; text or HTML."""

from __future__ import annotations

from functools import cache, partial
import math
from typing import Callable, Iterator, Mapping, Sequence
from xml.etree.ElementTree import Element, SubElement, tostring

from heading_intercompare.core.decision.campaign import CAMPAIGN_REASONS
from heading_intercompare.core.declared_figures import Figure, find_figure, list_figures
from heading_intercompare.core.diagnostics.by_motion import ByRate, BySector
from heading_intercompare.core.norm_tests.judged_test import MET
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.validity.condition import DOUBTFUL, VOID

from .conclusion import explain
from .headline import OUTCOME_WORDS
from .run_gravity import count_compliant
from .verdict_document import RunVerdict, Verdict
from .vocabulary import EFFECT_WORDS, law_words, NO_RUN

Row = tuple[str, Callable[[RunVerdict], str]]

_COLUMNS = 5
#: Decimals of figures that are no differences, in the tables by heading and by rate of turn.
_DIGITS = {'heading_deg': 0, 'duration_s': 0, 'from_deg_s': 1, 'to_deg_s': 1, 'rate_deg_s': 2}

#: Settings in the terms of GK; who states one has a norm, or a contract, of GK.
_GK_TERMS = ('model', 'variant', 'norms.probability', 'norms.k_rule', 'norms.k_total_rule',
             'norms.total_error_max_deg')

#: What is known of the mean of the TS, GK Table I.
_VARIANTS = {'A': 'the mean of the TS is known to be 0',
             'B': 'the mean of the TS is not known, and the same in all runs',
             'C': 'the mean of the TS is not known, and may differ between runs'}


def _number(value: float | int | None, digits: int = 4) -> str:
    if isinstance(value, int):
        return str(value)
    if value is None or not math.isfinite(value):
        return '-'
    return f'{value:.{digits}f}' if abs(value) < 1e5 else f'{value:.4g}'


def _range(low: float | None, high: float | None, digits: int = 4) -> str:
    return f'{_number(low, digits)} .. {_number(high, digits)}'


def _limit(run: RunVerdict) -> str:
    limit = run.limit_95
    if limit is None:
        return _number(None)
    return f'{_number(limit.limit_deg)} ({_range(limit.lower_deg, limit.upper_deg)})'


def _list_reasons(key: str, run: RunVerdict) -> str:
    """Return the readings of both sensors by reason."""
    words = list_figures(RunVerdict)[f'{key}.ts'].choices
    return ', '.join(f'{n} {sensor.upper()} {words.get(reason, reason)}'
                     for sensor in ('ts', 'rs')
                     for reason, n in find_figure(run, f'{key}.{sensor}').items()) or '0'


def _counts(run: RunVerdict) -> str:
    counts = run.count_criterion
    return f'{counts.n_plus} / {counts.n_plus_plus} / {counts.allowed:.2f}'


def _declare(keys: str) -> Iterator[Row]:
    """Yield the rows of declared figures by their keys, units in ASCII."""
    for key in keys.split():
        figure = list_figures(RunVerdict)[key]
        unit = '' if figure.unit in ('', '1', 'UTC') else f' [{figure.unit.replace("²", "2")}]'
        words = figure.row or figure.words.replace('of these ', '  ')
        yield words + unit, partial(_cell, key, figure)


def _cell(key: str, figure: Figure, run: RunVerdict) -> str:
    value, digits = find_figure(run, key), {'deg': 4, 'deg²': 6}.get(figure.unit, 1)
    if figure.up_key:
        return _range(value, find_figure(run, figure.up_key), digits)
    if isinstance(value, Outcome):
        return OUTCOME_WORDS[value]
    return utc(value) if figure.unit == 'UTC' else _number(value, digits)


@cache
def _list_rows(gk: bool) -> tuple[Row, ...]:
    """Return the rows of the table; a program that prints none does not wait for them."""
    counts = [('n+ / n++ / allowed', _counts)]
    return (
        *_declare('outcome paper_outcome' if gk else 'outcome'),
        *_declare("""
            start_ns duration_s pairing.paired pairing.ts_received
            pairing.ts_paired pairing.ts_used pairing.ts_unpaired pairing.ts_unbridged
            pairing.ts_held pairing.rs_received pairing.rs_used pairing.rs_unused
            pairing.rs_unbridged pairing.rs_held"""),
        ('rejected', partial(_list_reasons, 'pairing.rejected')),
        ('lost', partial(_list_reasons, 'pairing.lost')),
        *_declare('n guarded.nu mean_deg max_abs_deg'),
        ('limit of 95 % of them [deg]', _limit),
        *_declare('std_deg variance_deg2'),
        ('  with its bounds [deg2]',
         lambda r: _range(r.guarded.lower_bound_deg2, r.guarded.upper_bound_deg2, 6)),
        *_declare('guarded.acceptance_limit_deg2 guarded.rejection_limit_deg2'),
        *([*_declare('variance_criterion.outcome'), *counts,
           *_declare('count_criterion.outcome')] if gk else []),
        *_declare('guarded.sigma_ts_lower_deg total_error.low_deg'),
    )


def asks_for_gk(settings: Settings) -> bool:
    """Tell whether a setting states a term of GK, so that a contract may ask for its criteria."""
    stated, usual = settings.to_mapping(), Settings().to_mapping()
    return any(stated[name] != usual[name] for name in _GK_TERMS)


def _describe_norms(verdict: Verdict, gk: bool) -> str:
    """Describe norms and risks in one line, and what only GK needs."""
    settings, norms = verdict.settings, verdict.settings.norms
    sigma = f'by {norms.preset}' if norms.preset is not None else f'{norms.sigma_max_deg:g} deg'
    terms = (f', P {norms.probability:g}; model {settings.model}, variant {settings.variant}'
             if gk else '')
    return (f'norms: sigma_max {sigma}, sigma_ref_max {norms.sigma_ref_max_deg:g} deg{terms}; '
            f'risks: consumer {settings.risk.alpha_consumer:g}, '
            f'producer {settings.risk.alpha_producer:g}')


def _explain_letters(verdict: Verdict) -> str:
    """Say in one line what the abbreviations on the screen stand for."""
    ts_law, rs_law = law_words(verdict.settings.model)
    laws = f'errors of TS and RS {ts_law}' if ts_law == rs_law else (
        f'errors of the TS {ts_law}, of the RS {rs_law}')
    return (f'TS: tested sensor; RS: reference sensor; GK: Granovskii and Kudryavtsev 2016; '
            f'{verdict.settings.model}: {laws}; {verdict.settings.variant}: '
            f'{_VARIANTS[verdict.settings.variant]}')


def _tables(verdict: Verdict, gk: bool) -> Iterator[list[tuple[str, ...]]]:
    """Yield one table per group of runs, as rows; the first row is the head."""
    for first in range(0, len(verdict.runs), _COLUMNS):
        runs = verdict.runs[first:first + _COLUMNS]
        yield [('', *(f'run {r.run}' for r in runs)),
               *((name, *(text(r) for r in runs)) for name, text in _list_rows(gk))]


def _reasons(verdict: Verdict) -> Iterator[tuple[str, list[str]]]:
    """Yield the reasons of the outcome, together and per run, each with further findings."""
    several = len(verdict.inputs) > 1
    for line in describe_together(verdict):
        yield line, []
    if verdict.chosen is not None:
        yield verdict.chosen.words, [*verdict.chosen.list_left_out()]
    for run in verdict.runs:
        of = f' of {run.source}' if several else ''
        findings = [f'{EFFECT_WORDS[f.effect]}: {f.evidence}' for f in run.validity
                    if f.effect in (DOUBTFUL, VOID)]
        findings += [f'look {look.look} of {look.looks} at {look.span_s:.0f} s: {look.headline}'
                     for look in run.looks]
        findings += [f'warning: {warning}' for warning in run.warnings]
        yield f'run {run.run}{of}: {explain(run)}', findings
    if verdict.ledger_problems:
        yield 'the ledger is not complete:', list(verdict.ledger_problems)
    if verdict.operator_actions:
        yield 'operators did while the nodes ran:', [
            f'{utc(note.stamp_ns)} UTC: {note.text}' for note in verdict.operator_actions]
    missing = [f'not judged: {recording.path}: {recording.why_no_run}'
               for recording in verdict.inputs if recording.why_no_run]
    for line in missing if missing or verdict.runs else [NO_RUN]:
        yield line, []


def _in_one_line(text: str) -> str:
    """Return foreign text without line ends, which could forge a line."""
    return ' '.join(text.split()) if '\n' in text or not text.isprintable() else text


def describe_together(verdict: Verdict) -> list[str]:
    """Return how many runs comply, the rule and its reason in one line; none for one run."""
    if len(verdict.runs) < 2:
        return []
    reason = verdict.campaign.reason
    return [f'{count_compliant(verdict.runs)}; together ({verdict.campaign.rule}): '
            f'{CAMPAIGN_REASONS.get(reason, reason)}']


def head_lines(verdict: Verdict, verbose: bool = False) -> list[str]:
    """
    Return the first lines: the headline and the norms.

    A verdict that was read says next where it comes from. The outcome of GK as printed and the
    abbreviations stand with them if a setting asks for GK, or if the lines are to be verbose.
    """
    gk = verbose or asks_for_gk(verdict.settings)
    outcome = [f'GK as printed: {OUTCOME_WORDS[verdict.paper_outcome]}'] if gk else []
    origin = [verdict.provenance] if verdict.provenance is not None else []
    return [f'VERDICT: {verdict.headline}', *origin, *outcome, _describe_norms(verdict, gk),
            *([_explain_letters(verdict)] if gk else [])]


def verdict_text(verdict: Verdict, verbose: bool = False) -> str:
    """Return a verdict as text in columns, without a final newline; see `head_lines`."""
    lines = head_lines(verdict, verbose)
    for rows in _tables(verdict, verbose or asks_for_gk(verdict.settings)):
        lines += ['', *_align(rows)]
    if rows := _list_tests(verdict):
        lines += ['', *_align(rows), *_note_tests(verdict)]
    for run in verdict.runs if verbose else ():
        lines += _list_by_motion(run)
    lines.append('')
    for line, findings in _reasons(verdict):
        lines += [line, *(f'  {more}' for more in findings)]
    return '\n'.join(map(_in_one_line, lines))


def _list_tests(verdict: Verdict) -> list[tuple[str, ...]]:
    """Return the table of the tests of the norm; no rows if it requires none."""
    tests = verdict.campaign.norm_tests or ()
    head = [('tests of the norm', '', 'figure', 'limit', 'clause')] if tests else []
    return [*head, *((test.words, *test.cells) for test in tests)]


def _note_tests(verdict: Verdict) -> list[str]:
    """Return what the record holds of the tests that are not met, and what decides others."""
    return [f'  {test.words}: {test.notes}' for test in verdict.campaign.norm_tests or ()
            if test.state != MET and test.notes]


def _list_by_motion(run: RunVerdict) -> Iterator[str]:
    """Yield the lines of the differences by heading and by the rate of turn."""
    if run.by_motion is None:
        return
    yield from ('', f'run {run.run}, differences by heading, on steady headings:')
    yield from _align([*_list_columns(run.by_motion.sectors, list_figures(BySector))])
    yield from ('', f'run {run.run}, differences by rate of turn, starboard positive:')
    yield from _align([*_list_columns(run.by_motion.turns, list_figures(ByRate))])


def _list_columns(block: BySector | ByRate,
                  figures: Mapping[str, Figure]) -> Iterator[tuple[str, ...]]:
    """Yield the head and the rows of figures that are lists of equal length."""
    words = ((figure.row or figure.words, figure.unit) for figure in figures.values())
    yield tuple(name if unit == '1' else f'{name} [{unit}]' for name, unit in words)
    for row in zip(*(getattr(block, key) for key in figures)):
        yield tuple(_number(value, _DIGITS.get(key, 4)) for key, value in zip(figures, row))


def _align(rows: Sequence[tuple[str, ...]]) -> list[str]:
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    return ['  '.join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip()
            for row in rows]


def summary_text(verdict: Verdict) -> str:
    """Return a verdict as one line, plus one per run, without a final newline."""
    lines = [verdict.headline]
    for run in verdict.runs:
        lines.append(
            f'run {run.run}: {OUTCOME_WORDS[run.outcome]}, n = {run.n}, mean '
            f'{_number(run.mean_deg)} deg, standard deviation {_number(run.std_deg)} deg, '
            f'variance {_range(run.guarded.lower_bound_deg2, run.guarded.upper_bound_deg2, 6)} '
            f'deg2, limits '
            f'{_range(run.guarded.acceptance_limit_deg2, run.guarded.rejection_limit_deg2, 6)}')
    return '\n'.join(lines)


def verdict_html(verdict: Verdict) -> str:
    """Return the table as a piece of HTML for notebooks; the protocol is in `report`."""
    whole = Element('div')
    SubElement(SubElement(whole, 'p'), 'strong').text = verdict.headline
    for text in head_lines(verdict)[1:]:
        SubElement(whole, 'p').text = text
    for rows in (*_tables(verdict, asks_for_gk(verdict.settings)),
                 *filter(None, [_list_tests(verdict)])):
        table = SubElement(whole, 'table')
        for row in rows:
            line = SubElement(table, 'tr')
            for at, cell in enumerate(row):
                SubElement(line, 'td' if at and row is not rows[0] else 'th').text = cell
    reasons = SubElement(whole, 'ul')
    for reason, findings in _reasons(verdict):
        item = SubElement(reasons, 'li')
        item.text = reason
        if findings:
            more = SubElement(item, 'ul')
            for text in findings:
                SubElement(more, 'li').text = text
    # File names may hold bytes that are not text.
    return tostring(whole, 'unicode', method='html').encode('utf-8', 'replace').decode()
