# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The protocol of an intercomparison: one HTML file that needs no network and no script."""

from __future__ import annotations

from operator import methodcaller
from pathlib import Path
from typing import Sequence

from heading_intercompare.core.settings import Settings
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.verdict.verdict_document import (
    RunVerdict,
    SCHEMA,
    SCHEMA_VERSION,
    Verdict,
)
from heading_intercompare.core.verdict.vocabulary import (
    CAMPAIGN_WORDS,
    CONDITION_WORDS,
    EFFECT_WORDS,
    NO_RUN,
    REASON_WORDS,
    STATE_WORDS,
)

from .decision_rule import describe_rule, describe_uncertainty
from .formatting import exact, flat, outcome, value
from .graphs import draw_graphs
from .markup import element, join, Markup
from .series_sketch import SeriesSketch
from .tables import (
    facts,
    GUARDED,
    LEDGER,
    RESULTS,
    Row,
    rows_by_run,
    rows_of,
    SENSOR,
    table,
    WORST,
)

__all__ = ['render', 'write']

_FINDINGS = ('skew', 'drift', 'heading_dependence', 'normality', 'stationarity', 'correlation',
             'allan')

_STYLE = """
body { font: 14px/1.45 Helvetica, Arial, sans-serif; color: #000; background: #fff;
  max-width: 980px; margin: 2em auto; padding: 0 1em; }
h1 { font-size: 1.5em; border-bottom: 2px solid #000; padding-bottom: .2em; }
h2 { font-size: 1.15em; margin: 1.8em 0 .5em; border-bottom: 1px solid #888; }
table { border-collapse: collapse; margin: .5em 0 1em; width: 100%; }
th, td { border: 1px solid #999; padding: .2em .5em; text-align: left; vertical-align: top;
  overflow-wrap: anywhere; }
th { font-weight: normal; } thead th { font-weight: bold; background: #eee; }
td { font-variant-numeric: tabular-nums; }
table.facts th { width: 34%; }
tbody th { min-width: 16em; } table.plain tbody th { min-width: 0; }
.state { white-space: nowrap; }
table.settings td { font-family: monospace; }
.verdict { border: 3px solid #000; padding: .6em 1em; }
.verdict strong { font-size: 1.5em; letter-spacing: .03em; }
.blank { display: block; min-height: 1.3em; border-bottom: 1px dotted #000; }
.signature { display: flex; gap: 2em; margin-top: 3.5em; }
.signature div { flex: 1; border-top: 1px solid #000; padding-top: .2em; }
figure { margin: 1em 0; } figure svg { max-width: 100%; height: auto; }
@media print { body { margin: 0; max-width: none; font-size: 11px; } a { color: #000; }
  h2 { break-after: avoid; } tr, figure, .verdict, .signature { break-inside: avoid; } }
"""


def write(verdict: Verdict, path: str | Path, sketches: Sequence[SeriesSketch] = ()) -> None:
    """
    Write the protocol; see `render`.

    Raises
    ------
    OSError
        If the file cannot be written.

    """
    Path(path).write_text(render(verdict, sketches), encoding='utf-8')


def render(verdict: Verdict, sketches: Sequence[SeriesSketch] = ()) -> str:
    """
    Return the protocol as an HTML page.

    Parameters
    ----------
    verdict : Verdict
    sketches : sequence of SeriesSketch
        One an input, for the figures; none leaves them out.

    """
    sections = (('Identification', _identification), ('Norms and decision rule', describe_rule),
                ('Pairing ledger', _ledger), ('Results', _results),
                ('The runs together', _campaign), ('Guarded decision', _guarded),
                ('Validity of the comparison', _validity), ('Assumptions', _assumptions),
                ('Warnings', _warnings),
                ('Uncertainty', describe_uncertainty))
    parts = [(title, make(verdict)) for title, make in sections]
    parts = [(title, body) for title, body in parts if body]
    findings = _findings(verdict)
    parts += [('Figures', _figures(verdict, sketches)),
              *([('Further findings', findings)] if findings else []),
              ('Events, exclusions and reasons', _events(verdict)),
              ('Settings', _settings(verdict.settings)), ('Signatures', _signatures())]
    numbered = join(element('section', element('h2', f'{k}. {title}'), body)
                    for k, (title, body) in enumerate(parts, 1))
    title = 'Intercomparison of heading sensors: protocol'
    return '<!DOCTYPE html>\n' + element(
        'html', element('head', element('meta', charset='utf-8'), element('title', title),
                        element('style', Markup(_STYLE))),
        element('body', element('h1', title), _headline(verdict), numbered), lang='en') + '\n'


def _paragraph(*words: object) -> Markup:
    return element('p', *words)


def _make_list(items: Sequence[object]) -> Markup:
    return element('ul', *(element('li', item) for item in items))


def _reason(run: RunVerdict) -> str:
    return REASON_WORDS.get(run.reason, run.reason)


def _headline(verdict: Verdict) -> Markup:
    """Return the verdict with its reason in words."""
    runs = verdict.runs
    reasons = [element('li', f'run {run.run}: {run.headline} - {_reason(run)}')
               for run in runs]
    if len(runs) > 1:
        reason = verdict.campaign.reason
        words = CAMPAIGN_WORDS.get(reason, reason)
        reasons.insert(0, element('li', f'together: {words}'))
    return element(
        'div', element('strong', verdict.headline),
        _paragraph(f'GK as printed: {outcome(verdict.paper_outcome)}'),
        element('ul', *reasons) if reasons else _paragraph(NO_RUN),
        class_='verdict')


def _identification(verdict: Verdict) -> Markup:
    runs, software = verdict.runs, verdict.software
    settings = verdict.settings
    parts = [facts([
        ('software', f'{software.name} {software.version}'),
        ('version of the decision rule', value(verdict.rule_version)),
        ('schema of the verdict', f'{SCHEMA}, version {SCHEMA_VERSION}'),
        ('SHA-256 of the settings', verdict.settings_sha256),
        ('first and last pair [UTC]', f'{utc(min((r.start_ns for r in runs), default=None))} '
                                      f'.. {utc(max((r.end_ns for r in runs), default=None))}'),
        ('installation angle TS - RS [deg], as set',
         value(settings.installation_offset_deg)),
        ('ship', ''), ('place or area, latitudes', ''),
        ('tested sensor (TS): maker, type', ''), ('TS: serial number', ''),
        ('reference sensor (RS): maker, type', ''), ('RS: serial number', ''),
        ('RS: proof of its norm (service log)', ''), ('protocol number, client', '')])]
    if verdict.inputs:
        parts.append(table(
            ['input', 'SHA-256', 'TS topic', 'RS topic'],
            [[value(thing) for thing in (given.path, given.sha256, given.ts_topic,
                                         given.rs_topic)] for given in verdict.inputs]))
        parts += [_paragraph(f'{given.path} was not judged: {given.why_no_run}')
                  for given in verdict.inputs if given.why_no_run]
    else:
        parts.append(_paragraph('Inputs: none recorded; the readings were given live or by a '
                                'program.'))
    return join(parts)


def _numbered(verdict: Verdict) -> list[tuple[int, RunVerdict]]:
    return [(run.run, run) for run in verdict.runs]


def _ledger(verdict: Verdict) -> Markup:
    if not verdict.runs:
        return _paragraph(NO_RUN)
    return join((_paragraph('Every reading received stands in exactly one row of its sensor: '
                            'paired, interpolated between, without partner (not used) or '
                            'rejected.'),
                 rows_by_run(LEDGER, _numbered(verdict))))


def _results(verdict: Verdict) -> Markup:
    if not verdict.runs:
        return _paragraph(NO_RUN)
    return join((_paragraph('Differences are TS - RS. GK is Granovskii and Kudryavtsev, '
                            'ALLSENSORS 2016; the numbers are those of its formulas.'),
                 rows_by_run(RESULTS, _numbered(verdict))))


def _campaign(verdict: Verdict) -> Markup:
    campaign = verdict.campaign
    rows = rows_of(WORST, campaign)
    rows += [(f'homogeneity: {name}', '', value(thing))
             for name, thing in flat(campaign.homogeneity)]
    parts = [table(['', 'unit', 'worst of runs'], rows)]
    if campaign.sensor is not None:
        parts.append(table(['', 'unit', 'the variance that the runs share'],
                           rows_of(SENSOR, campaign.sensor)))
    return join(parts)


def _guarded(verdict: Verdict) -> Markup:
    if not verdict.runs:
        return _paragraph(NO_RUN)
    return join((_paragraph('The bounds hold for errors that change within a twentieth of the '
                            'run; of slower ones they allow for what shows in it.'),
                 rows_by_run(GUARDED, _numbered(verdict))))


def _validity(verdict: Verdict) -> Markup:
    """Return what binds the verdict: each condition of a comparison, by run."""
    parts = [_paragraph('A comparison means something only where these conditions hold. A void '
                        'one leaves the run undecided, whatever its variance.')]
    for run in verdict.runs:
        parts.append(element('h3', f'Run {run.run}'))
        parts.append(table(
            ['condition', 'effect', 'evidence'],
            [[CONDITION_WORDS.get(f.condition, f.condition),
              element('span', EFFECT_WORDS.get(f.effect, f.effect), class_='state'),
              value(f.evidence)] for f in run.validity], class_='plain'))
    return join(parts) if verdict.runs else _paragraph(NO_RUN)


def _assumptions(verdict: Verdict) -> Markup:
    parts = []
    for run in verdict.runs:
        if run.assumptions:
            parts.append(element('h3', f'Run {run.run}'))
            parts.append(table(
                ['', 'statement', 'state', 'evidence'],
                [[a.id, a.statement, _state(a.state), value(a.evidence)]
                 for a in run.assumptions], class_='plain'))
    return join(parts)


def _state(word: str) -> Markup:
    return element('span', STATE_WORDS.get(word, word), class_='state')


def _findings(verdict: Verdict) -> Markup:
    """Return what else was found in each run, by the names of the JSON."""
    found = [{f'{block}.{name}': thing for block in _FINDINGS
              for name, thing in flat(getattr(run, block))} for run in verdict.runs]
    rows = [Row(name, '', methodcaller('get', name))
            for name in dict.fromkeys(name for names in found for name in names)]
    if not rows:
        return join(())
    runs = [(run.run, names) for names, run in zip(found, verdict.runs)]
    return join((_paragraph('Names are those of the JSON and end in their unit.'),
                 rows_by_run(rows, runs, units=False)))


def _warnings(verdict: Verdict) -> Markup:
    items = [f'run {run.run}: {warning}' for run in verdict.runs
             for warning in run.warnings]
    return _make_list(items) if items else _paragraph('None.')


def _figures(verdict: Verdict, sketches: Sequence[SeriesSketch]) -> Markup:
    parts = []
    for sketch in sketches:
        source = f'Source: {sketch.source}. ' if sketch.source else ''
        said = (f'{source}All pairs of the input, those of a stabilisation period too; '
                f'{sketch.n_invalid} not finite left out.')
        drawn = [element('figure', graph) for graph in draw_graphs(sketch, verdict)]
        parts += [_paragraph(said), *drawn] if drawn else [
            _paragraph(f'{source}No difference to draw.')]
    return join(parts) or _paragraph('None: the protocol was made from the verdict alone.')


def _events(verdict: Verdict) -> Markup:
    """Return the operator's notes, and room for what they do not say."""
    notes = [[f'{utc(note.stamp_ns)} UTC', note.text, given.path]
             for given in verdict.inputs for note in given.notes or ()]
    room = facts([('events during the trial', ''), ('data left out, and why', '')])
    return join([table(['time', "operator's note", 'input'], notes), room] if notes else [room])


def _settings(settings: Settings) -> Markup:
    return table(['name', 'value'], [[name, exact(thing)] for name, thing in
                                     settings.to_mapping().items()], class_='settings')


def _signatures() -> Markup:
    return element('div', *(element('div', words) for words in (
        'measured by: name, date', 'evaluated by: name, date', 'approved by: name, date')),
        class_='signature')
