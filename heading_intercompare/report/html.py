# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The protocol of an intercomparison: one HTML file that needs no network and no script."""

from __future__ import annotations

from functools import cache, partial
from operator import methodcaller
from pathlib import Path
import re
from typing import Any, Mapping, Sequence

import jinja2

from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.verdict.verdict_document import SCHEMA, SCHEMA_VERSION, Verdict
from heading_intercompare.core.verdict.vocabulary import (
    CAMPAIGN_WORDS,
    CONDITION_WORDS,
    EFFECT_WORDS,
    NO_RUN,
    REASON_WORDS,
    STATE_WORDS,
)

from .decision_rule import describe_norms, describe_uncertainty, state_conformity
from .figures.gallery import draw_figures
from .formatting import exact, flatten, outcome, value
from .series_sketch import SeriesSketch
from .tables import (
    GUARDED,
    LEDGER,
    RESULTS,
    Row,
    rows_by_run,
    rows_of,
    SENSOR,
    Table,
    WORST,
)

__all__ = ['render', 'write']

_FINDINGS = ('skew', 'drift', 'heading_dependence', 'normality', 'stationarity', 'correlation',
             'allan')

#: Characters that HTML or UTF-8 cannot hold: control characters, undecodable bytes of a file name.
_UNPRINTABLE = re.compile('[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]')


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
        One per input, for the figures; without any there are no figures.

    """
    runs = [(run.run, run) for run in verdict.runs]
    campaign = verdict.campaign
    homogeneity = [(f'homogeneity: {name}', '', value(thing))
                   for name, thing in flatten(campaign.homogeneity)]
    return _load_template().render(
        verdict=verdict, no_run=NO_RUN, schema=f'{SCHEMA}, version {SCHEMA_VERSION}',
        span=f'{utc(min((run.start_ns for _, run in runs), default=None))} .. '
             f'{utc(max((run.end_ns for _, run in runs), default=None))}',
        norms=describe_norms(verdict.settings), statement=state_conformity(verdict),
        ledger=rows_by_run(LEDGER, runs), results=rows_by_run(RESULTS, runs),
        worst=[*rows_of(WORST, campaign), *homogeneity],
        shared=rows_of(SENSOR, campaign.sensor) if campaign.sensor is not None else [],
        guarded=rows_by_run(GUARDED, runs), uncertainty=describe_uncertainty(verdict),
        drawn=[(sketch.source, sketch.n_invalid, draw_figures(sketch, verdict, f'input{k}'))
               for k, sketch in enumerate(sketches, 1)],
        findings=_find(verdict),
        notes=[(f'{utc(note.stamp_ns)} UTC', note.text, given.path)
               for given in verdict.inputs for note in given.notes or ()],
        taken_out=[(f'{utc(one.start_ns)} UTC', f'{utc(one.end_ns)} UTC', str(one.n), one.reason)
                   for one in (verdict.taken_out.stretches if verdict.taken_out else ())],
        settings=[(name, exact(thing)) for name, thing in verdict.settings.to_mapping().items()])


def _find(verdict: Verdict) -> list[Table]:
    """Return the further findings of each run, under their names in the JSON."""
    found = [{f'{block}.{name}': thing for block in _FINDINGS
              for name, thing in flatten(getattr(run, block))} for run in verdict.runs]
    rows = [Row(name, '', methodcaller('get', name))
            for name in dict.fromkeys(name for names in found for name in names)]
    runs = [(run.run, names) for names, run in zip(found, verdict.runs)]
    return rows_by_run(rows, runs, units=False) if rows else []


@cache
def _load_template() -> jinja2.Template:
    """Return the template of the page; it shows every value literally."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader('heading_intercompare.report'), autoescape=True,
        undefined=jinja2.StrictUndefined, finalize=_show, trim_blocks=True, lstrip_blocks=True,
        keep_trailing_newline=True, auto_reload=False)
    environment.filters |= {
        'value': value, 'outcome': outcome, 'campaign_words': partial(_say, CAMPAIGN_WORDS),
        'reason_words': partial(_say, REASON_WORDS), 'state_words': partial(_say, STATE_WORDS),
        'effect_words': partial(_say, EFFECT_WORDS),
        'condition_words': partial(_say, CONDITION_WORDS)}
    return environment.get_template('protocol.html')


def _show(thing: Any) -> Any:
    """Return a value with its unprintable characters replaced by U+FFFD; markup unchanged."""
    return thing if hasattr(thing, '__html__') else _UNPRINTABLE.sub('\ufffd', str(thing))


def _say(words: Mapping[Any, str], key: Any) -> str:
    """Return the words for a key; the key itself if unknown, perhaps from a later version."""
    return words.get(key, key)
