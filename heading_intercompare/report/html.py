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

"""The protocol of an intercomparison: one HTML file that needs no network and no script."""

from __future__ import annotations

from functools import cache, partial
from pathlib import Path
import re
from typing import Any, Callable, Mapping, Sequence

import jinja2

from heading_intercompare.core.decision.sequential import LookVerdict
from heading_intercompare.core.declared_figures import list_figures
from heading_intercompare.core.statistics.stationarity import Homogeneity
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.validity.condition import VOID
from heading_intercompare.core.verdict.validity import CONDITION_WORDS
from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.core.verdict.verdict_table import asks_for_gk
from heading_intercompare.core.verdict.vocabulary import EFFECT_WORDS, NO_RUN, STATE_WORDS

from .contents.decision_rule import describe_norms, describe_uncertainty, state_conformity
from .contents.defaults import is_default
from .contents.file_names import hide_paths, name_files
from .contents.findings import describe_findings, rows_of_block
from .contents.first_page import compose_first_page
from .contents.heading_sectors import tabulate_sectors
from .contents.holding import find_worst
from .contents.identification import identify, name_trial, span_of, verdict_id
from .contents.tables import (
    GK_RESULTS,
    GK_SUMMARY,
    GUARDED,
    LEDGER,
    RESULTS,
    rows_by_run,
    rows_of,
    SENSOR,
    SUMMARY,
    Table,
    WORST,
)
from .contents.uncertainty_budget import budget_of
from .figures.drawing import Subject
from .figures.gallery import draw_figures, Drawn, NAMES
from .formatting import exact, flatten, value
from .series_sketch import SeriesSketch

#: Characters that HTML or UTF-8 cannot hold: control characters, undecodable bytes of a file name.
#: Also what turns the direction of the text around it, and what has no width.
_UNPRINTABLE = re.compile('[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u061c\u200b-\u200f\u2028-\u202e'
                          '\u2060-\u206f\ufeff\ud800-\udfff\ufffe\uffff]')
_LONGEST_HEAD = 80


def write(verdict: Verdict, path: str | Path, sketches: Sequence[SeriesSketch] = (),
          progress: Callable[[str], None] = lambda text: None, verbose: bool = False) -> None:
    """
    Write the protocol; see `render`.

    Raises
    ------
    OSError
        If the file cannot be written.

    """
    Path(path).write_text(render(verdict, sketches, progress, verbose), encoding='utf-8')


def render(verdict: Verdict, sketches: Sequence[SeriesSketch] = (),
           progress: Callable[[str], None] = lambda text: None, verbose: bool = False) -> str:
    """
    Return the protocol as an HTML page.

    Parameters
    ----------
    verdict
        The verdict to show.
    sketches
        One sketch per input, for the figures; without sketches there are no figures.
    progress
        Called with the progress in words.
    verbose
        Show the criteria of GK even if no setting asks for them.

    """
    names = name_files(verdict.inputs, [
        *(run.source for run in verdict.runs), *(sketch.source for sketch in sketches)])
    drawn = [(names[sketch.source], sketch.n_invalid, draw_figures(
        sketch, verdict, f'input{k}', partial(_tell, progress, k, len(sketches))))
        for k, sketch in enumerate(sketches, 1)]
    shown = hide_paths(verdict, names)
    runs = [(run.run, run) for run in shown.runs]
    campaign, settings = shown.campaign, shown.settings
    by_sensor = campaign.rule == 'sensor' and shown.validity_effect != VOID
    running = name_trial(settings)
    gk = verbose or asks_for_gk(settings)
    return load_template('protocol.html').render(
        verdict=shown, gk=gk, no_run=NO_RUN, id=verdict_id(verdict), span=span_of(shown),
        running=running if len(running) <= _LONGEST_HEAD else f'{running[:_LONGEST_HEAD]}...',
        first=compose_first_page(shown, gk), shows=_pick_figure(verdict, sketches, drawn),
        identification=identify(verdict), norms=describe_norms(settings),
        statement=state_conformity(shown, gk), ledger=rows_by_run(LEDGER, runs),
        summary=rows_by_run((*SUMMARY, *GK_SUMMARY) if gk else SUMMARY, runs),
        results=rows_by_run((*RESULTS, *GK_RESULTS) if gk else RESULTS, runs),
        sectors=[(about.title('differences by heading'), tabulate_sectors(about)) for about in (
            Subject.of(sketch, verdict) for sketch in sketches) if about is not None],
        worst=rows_of(WORST, campaign), homogeneity=_compare_runs(shown),
        shared=rows_of(SENSOR, campaign.sensor) if campaign.sensor and by_sensor else [],
        guarded=rows_by_run(GUARDED, runs), uncertainty=describe_uncertainty(settings),
        budgets=[(number, budget_of(run, settings)) for number, run in runs], drawn=drawn,
        findings=describe_findings(shown.runs),
        deviations=settings.trial.deviations,
        notes=[(f'{utc(note.stamp_ns)} UTC', note.text, recording.path)
               for recording in shown.inputs for note in recording.notes or ()],
        settings=[(name, exact(thing), 'default' if is_default(settings, name) else '')
                  for name, thing in settings.to_mapping().items()
                  if not name.startswith('trial.')],
        taken_out=[(f'{utc(stretch.start_ns)} UTC', f'{utc(stretch.end_ns)} UTC', str(stretch.n),
                    stretch.reason)
                   for stretch in (shown.taken_out.stretches if shown.taken_out else ())])


def _tell(progress: Callable[[str], None], sketch: int, sketches: int, done: int) -> None:
    """Say how many figures are drawn, `done` of them of the sketch of this number."""
    n_figures = len(NAMES)
    progress(f'{(sketch - 1) * n_figures + done} of {sketches * n_figures} figures drawn')


def _compare_runs(verdict: Verdict) -> list[Table]:
    """Return the table that compares the runs with each other; none for a single run."""
    if len(verdict.runs) < 2:
        return []
    figures = dict(flatten(verdict.campaign.homogeneity))
    return rows_of_block(list_figures(Homogeneity), [(0, figures)])


def _pick_figure(verdict: Verdict, sketches: Sequence[SeriesSketch],
                 drawn: Sequence[tuple[str, int, list[Drawn]]]) -> Drawn | None:
    """Return the differences in time of the run with the largest variance."""
    candidates = [(sketch, figure) for sketch, (_, _, figures) in zip(sketches, drawn)
                  for figure in figures if figure.id.endswith('-differences') and figure.svg]
    worst = find_worst(verdict)
    if worst is not None:
        begun = [(sketch.time.start_ns, figure) for sketch, figure in candidates
                 if sketch.source == worst.source and sketch.time.start_ns is not None
                 and sketch.time.start_ns <= worst.end_ns]
        if begun:
            return max(begun, key=lambda candidate: candidate[0])[1]
    return candidates[0][1] if candidates else None


def _rows_of_looks(looks: Sequence[LookVerdict]) -> list[tuple[str, str, str]]:
    """Return number, time and headline of each look."""
    return [(f'{look.look} of {look.looks}', value(look.span_s), look.headline) for look in looks]


def _quote_css(text: str) -> str:
    """Return a text for a string of CSS; everything but letters and digits is escaped."""
    return ''.join(c if c.isascii() and c.isalnum() else f'\\{ord(c):x} '
                   for c in _UNPRINTABLE.sub('\ufffd', text))


@cache
def load_template(name: str) -> jinja2.Template:
    """Return the template of a page; it shows every value literally."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader('heading_intercompare.report'), autoescape=True,
        undefined=jinja2.StrictUndefined, finalize=_show, trim_blocks=True, lstrip_blocks=True,
        keep_trailing_newline=True, auto_reload=False)
    environment.filters |= {
        'value': value, 'css': _quote_css, 'looks': _rows_of_looks,
        'state_words': partial(_say, STATE_WORDS),
        'effect_words': partial(_say, EFFECT_WORDS),
        'condition_words': partial(_say, CONDITION_WORDS)}
    return environment.get_template(name)


def _show(thing: Any) -> Any:
    """Return a value with its unprintable characters replaced by U+FFFD; markup unchanged."""
    return thing if hasattr(thing, '__html__') else _UNPRINTABLE.sub('\ufffd', str(thing))


def _say(words: Mapping[Any, str], key: Any) -> str:
    """Return the words for a key; the key itself if unknown, perhaps from a later version."""
    return words.get(key, key)
