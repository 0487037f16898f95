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

from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
import re
from typing import Any, Callable, Mapping, Sequence

import jinja2

from heading_intercompare.core.decision.sequential import LookVerdict
from heading_intercompare.core.declared_figures import list_figures
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.statistics.stationarity import Homogeneity
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.validity.condition import VOID
from heading_intercompare.core.verdict.run_gravity import count_compliant
from heading_intercompare.core.verdict.validity import CONDITION_WORDS
from heading_intercompare.core.verdict.verdict_document import RunVerdict, Verdict
from heading_intercompare.core.verdict.verdict_table import asks_for_gk
from heading_intercompare.core.verdict.vocabulary import EFFECT_WORDS, NO_RUN, STATE_WORDS
from heading_intercompare.replaced_file import replace_file

from .contents.decision_rule import describe_norms, describe_uncertainty, state_conformity
from .contents.defaults import is_default
from .contents.file_names import hide_paths, name_files
from .contents.findings import describe_findings, rows_of_block
from .contents.first_page import compose_first_page
from .contents.heading_sectors import tabulate_sectors
from .contents.holding import find_worst
from .contents.identification import identify, name_trial, span_of, verdict_id
from .contents.run_list import (
    list_run_lines,
    page_name,
    pick_in_full,
    RUN_COLUMNS,
    tell_elsewhere,
)
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
from .contents.verdict_code import draw_code
from .figures.drawing import Subject
from .figures.gallery import draw_figures, Drawn, NAMES
from .formatting import exact, flatten, value
from .series_sketch import SeriesSketch

#: Characters that HTML or UTF-8 cannot hold: control characters, undecodable bytes of a file name.
#: Also what turns the direction of the text around it, and what has no width.
_UNPRINTABLE = re.compile('[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u061c\u200b-\u200f\u2028-\u202e'
                          '\u2060-\u206f\ufeff\ud800-\udfff\ufffe\uffff]')
_LONGEST_HEAD = 80
#: Rows of a list that the protocol shows if its annexes lie apart.
_MOST_ROWS = 8


@dataclass(frozen=True, slots=True)
class _RunTables:
    """The tables of some runs, and of the records in which they are."""

    runs: Sequence[RunVerdict]
    ledger: Sequence[Table]
    summary: Sequence[Table]
    sectors: Sequence[tuple[str, Table]]
    budgets: Sequence[tuple[int, Table]]


def write(verdict: Verdict, path: str | Path, sketches: Sequence[SeriesSketch] = (),
          progress: Callable[[str], None] = lambda text: None, verbose: bool = False,
          annexes: Path | None = None) -> None:
    """
    Write the protocol; see `compose_files`.

    Raises
    ------
    OSError
        If a file cannot be written.

    """
    for place, text in compose_files(verdict, path, sketches, progress, verbose, annexes,
                                     run_pages=True):
        place.parent.mkdir(exist_ok=True)
        replace_file(place, text)


def compose_files(verdict: Verdict, path: str | Path, sketches: Sequence[SeriesSketch],
                  progress: Callable[[str], None], verbose: bool, annexes: Path | None,
                  run_pages: bool = False) -> list[tuple[Path, str]]:
    """
    Return the files of a protocol with their pages.

    Parameters
    ----------
    verdict, sketches, progress, verbose
        As for `render`.
    path
        The protocol.
    annexes
        A second file for the annexes. The protocol then shows the tables of one run and the first
        rows of long lists, so it has at most 8 pages of A4; all the rest is in the annexes. None
        if the protocol has its annexes.
    run_pages
        Whether each of many runs has a page of its own, in a folder beside the protocol. The
        protocol lists all of them, the worst first, and shows the worst in full.

    """
    place = Path(path)
    folder = place.with_name(f'{place.stem}-runs')
    values = _gather(verdict, sketches, progress, verbose, apart=annexes is not None,
                     folder=folder.name if run_pages else '')
    if annexes is None:
        files = [(place, _fill(values, 'whole'))]
    else:
        files = [(place, _fill(values, 'protocol', beside=annexes.name)),
                 (annexes, _fill(values, 'annexes', beside=place.name))]
    if not run_pages or not values['lines']:
        return files
    return files + [(folder / page_name(run), _fill(
        values | _gather_run(run, values), 'run', beside=f'../{place.name}'))
        for run in values['verdict'].runs]


def render(verdict: Verdict, sketches: Sequence[SeriesSketch] = (),
           progress: Callable[[str], None] = lambda text: None, verbose: bool = False) -> str:
    """
    Return the protocol with its annexes as an HTML page.

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
    return _fill(_gather(verdict, sketches, progress, verbose), 'whole')


def _fill(values: Mapping[str, Any], part: str, *, beside: str = '') -> str:
    """Return the page of a part, which may name the other part beside it."""
    titles = {'annexes': 'annexes to the protocol', 'run': 'page of a run'}
    return load_template('protocol.html').render(
        values, part=part, title=titles.get(part, 'protocol'), beside=beside)


def _gather(verdict: Verdict, sketches: Sequence[SeriesSketch],
            progress: Callable[[str], None], verbose: bool, apart: bool = False,
            folder: str = '') -> dict[str, Any]:
    """Return the values of the template by their names in it; `folder` has a page per run."""
    names = name_files(verdict.inputs, [
        *(run.source for run in verdict.runs), *(sketch.source for sketch in sketches)])
    shown = hide_paths(verdict, names)
    campaign, settings = shown.campaign, shown.settings
    by_sensor = campaign.rule == 'sensor' and shown.validity_effect != VOID
    running = name_trial(settings)
    gk = verbose or asks_for_gk(settings)
    in_full = pick_in_full(shown)
    records = _draw_records(verdict, sketches, names, progress,
                            shown.runs if folder else in_full)
    details = _detail(in_full, records, settings, gk)
    decides = find_worst(shown) or next(iter(shown.runs), None)
    tables = details['in_full'] if not apart or decides is None else _tabulate(
        [decides], [record for record in records if decides.run in record.numbers][:1], settings,
        gk)
    return {
        **details, 'verdict': shown, 'gk': gk, 'no_run': NO_RUN, 'id': verdict_id(verdict),
        'code': draw_code(verdict_id(verdict)),
        'span': span_of(shown), 'records': records,
        'running': running if len(running) <= _LONGEST_HEAD else f'{running[:_LONGEST_HEAD]}...',
        'first': compose_first_page(shown, gk, verdict.signed),
        'shows': _pick_figure(verdict, records),
        'identification': identify(verdict), 'norms': describe_norms(settings),
        'statement': state_conformity(shown, gk), 'most': _MOST_ROWS if apart else None,
        'tables': tables, 'lines': list_run_lines(shown, folder), 'run_columns': RUN_COLUMNS,
        'n_compliant': count_compliant(shown.runs), 'of_run': None,
        'elsewhere': tell_elsewhere(shown, folder),
        'worst': rows_of(WORST, campaign), 'homogeneity': _compare_runs(shown),
        'shared': rows_of(SENSOR, campaign.sensor) if campaign.sensor and by_sensor else [],
        'uncertainty': describe_uncertainty(settings), 'deviations': settings.trial.deviations,
        'notes': [(f'{utc(note.stamp_ns)} UTC', note.text, recording.path)
                  for recording in shown.inputs for note in recording.notes or ()],
        'settings': [(name, exact(thing), 'default' if is_default(settings, name) else '')
                     for name, thing in settings.to_mapping().items()
                     if not name.startswith('trial.')],
        'taken_out': [(f'{utc(stretch.start_ns)} UTC', f'{utc(stretch.end_ns)} UTC',
                       str(stretch.n), stretch.reason)
                      for stretch in (shown.taken_out.stretches if shown.taken_out else ())]}


def _gather_run(run: RunVerdict, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of the template that differ on the page of a run."""
    details = _detail([run], values['records'], values['verdict'].settings, values['gk'])
    return {**details, 'tables': details['in_full'], 'most': None, 'shows': None, 'of_run': run}


@dataclass(frozen=True, slots=True)
class _DrawnRecord:
    """The figures of a record, and the numbers of its runs; empty without a difference."""

    name: str
    sketch: SeriesSketch
    subject: Subject | None
    figures: list[Drawn]

    @property
    def numbers(self) -> set[int]:
        """Return the numbers of its runs."""
        return set() if self.subject is None else {run.run for run in self.subject.runs}


def _draw_records(verdict: Verdict, sketches: Sequence[SeriesSketch], names: Mapping[str, str],
                  progress: Callable[[str], None],
                  runs: Sequence[RunVerdict]) -> list[_DrawnRecord]:
    """Draw the records in which these runs are; all of them if these are all runs."""
    numbers = {run.run for run in runs}
    is_whole = len(numbers) == len(verdict.runs)
    records = [_DrawnRecord(names[sketch.source], sketch, Subject.of(sketch, verdict), [])
               for sketch in sketches]
    chosen = [record for record in records if is_whole or record.numbers & numbers]
    return [replace(record, figures=draw_figures(
        record.sketch, verdict, f'input{k}', partial(_tell, progress, k, len(chosen))))
        for k, record in enumerate(chosen, 1)]


def _detail(runs: Sequence[RunVerdict], records: Sequence[_DrawnRecord], settings: Settings,
            gk: bool) -> dict[str, Any]:
    """Return the values of the template that show some runs in full, with their records."""
    numbered = _number(runs)
    numbers = {run.run for run in runs}
    of_runs = [record for record in records if not record.numbers or record.numbers & numbers]
    return {
        'in_full': _tabulate(runs, of_runs, settings, gk),
        'results': rows_by_run((*RESULTS, *GK_RESULTS) if gk else RESULTS, numbered),
        'guarded': rows_by_run(GUARDED, numbered), 'findings': describe_findings(runs),
        'drawn': [(record.name, record.sketch.n_invalid, record.figures) for record in of_runs],
        'warnings': [f'run {run.run}: {warning}' for run in runs for warning in run.warnings]}


def _tabulate(runs: Sequence[RunVerdict], records: Sequence[_DrawnRecord], settings: Settings,
              gk: bool) -> _RunTables:
    """Return the tables of these runs and of these records."""
    return _RunTables(
        runs=runs, ledger=rows_by_run(LEDGER, _number(runs)),
        summary=rows_by_run((*SUMMARY, *GK_SUMMARY) if gk else SUMMARY, _number(runs)),
        sectors=[(f'Run {run.run}: differences by heading',
                  tabulate_sectors(run.by_motion.sectors))
                 for run in runs if run.by_motion is not None],
        budgets=[(run.run, budget_of(run, settings)) for run in runs])


def _number(runs: Sequence[RunVerdict]) -> list[tuple[int, RunVerdict]]:
    return [(run.run, run) for run in runs]


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


def _pick_figure(verdict: Verdict, records: Sequence[_DrawnRecord]) -> Drawn | None:
    """Return the differences in time of the run with the largest variance."""
    candidates = [(record.sketch, figure) for record in records for figure in record.figures
                  if figure.id.endswith('-differences') and figure.svg]
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
