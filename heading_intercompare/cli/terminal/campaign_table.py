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

"""A verdict on several recordings as lines: one per recording by name, the worst first."""

from __future__ import annotations

from dataclasses import dataclass
import os
from typing import Iterable, Sequence

from heading_intercompare.core.decision.coverage import span_words
from heading_intercompare.core.verdict.headline import say_outcome
from heading_intercompare.core.verdict.run_gravity import (
    gravity_of,
    list_doubts,
    OUTCOMES,
    share_of_norm,
)
from heading_intercompare.core.verdict.verdict_document import Input, RunVerdict, Verdict
from heading_intercompare.core.verdict.verdict_table import describe_together, head_lines
from heading_intercompare.report.formatting import fixed

_HEAD = ('recording', 'outcome', 'sd/deg', 'of norm', 'mean/deg', 'run', 'n', 'duration',
         'in doubt')
_TO_THE_RIGHT = {'sd/deg', 'of norm', 'mean/deg', 'n', 'duration'}
#: A longer name loses its middle.
_LONGEST_NAME = 32

#: An input that could not be judged stands before the indeterminate ones; one that was judged
#: under another name stands last.
_NOT_JUDGED, _ELSEWHERE = 0.5, float(len(OUTCOMES))


@dataclass(frozen=True, slots=True)
class _Line:
    """One line: what it is sorted by, and its cells."""

    gravity: tuple[float, float, float]
    cells: tuple[str, ...]


def is_campaign(verdict: Verdict) -> bool:
    """Tell whether a verdict is on several recordings; the logs of two sensors are one."""
    return len(verdict.inputs) > 1 and all(
        recording.not_taken is None for recording in verdict.inputs)


def campaign_lines(verdict: Verdict, columns: int | None = None,
                   verbose: bool = False) -> list[str]:
    """
    Return the verdict on a campaign as lines, one per recording, the worst first.

    Parameters
    ----------
    verdict
        The verdict on several recordings.
    columns
        Width of the terminal; a longer line of the table ends with an ellipsis.
    verbose
        See `head_lines`.

    Notes
    -----
    A recording with several runs shows the figures of its worst run. First come the outcomes that
    are not compliant, then recordings that could not be judged, then those without a decision.
    Among equals the one whose scatter is largest in terms of the norm comes first.

    """
    runs: dict[str, list[RunVerdict]] = {}
    for run in verdict.runs:
        runs.setdefault(run.source, []).append(run)
    names = _shorten_names([recording.path for recording in verdict.inputs])
    lines = [_describe(name, recording, runs.get(recording.path, []))
             for name, recording in zip(names, verdict.inputs)]
    rows = [_HEAD, *(line.cells for line in sorted(lines, key=lambda line: line.gravity))]
    table = [*_align(rows)]
    if columns is not None:
        table = [line if len(line) <= columns else f'{line[:columns - 1]}…' for line in table]
    together = describe_together(verdict)
    if verdict.chosen is not None:
        together += [verdict.chosen.words,
                     *(f'  {line}' for line in verdict.chosen.list_left_out())]
    return [*head_lines(verdict, verbose), '', *table, *([''] * bool(together)), *together]


def _describe(name: str, recording: Input, runs: Sequence[RunVerdict]) -> _Line:
    if not runs:
        elsewhere = recording.same_as is not None or recording.continues is not None
        rank = _ELSEWHERE if elsewhere else _NOT_JUDGED
        word = '-' if elsewhere else 'NOT JUDGED' if recording.error else 'NO RUN'
        return _Line((rank, 0.0, 0.0), (name, word, *'------', recording.why_no_run or 'no run'))
    worst = min(runs, key=gravity_of)
    share = share_of_norm(worst)
    word = say_outcome(worst.outcome, worst.validity_effect)
    which = str(worst.run) if len(runs) == 1 else f'{worst.run}, worst of {len(runs)}'
    return _Line(gravity_of(worst), (
        name, word, fixed(worst.std_deg, '.3f'), fixed(share, '.0%'),
        fixed(worst.mean_deg, '+.3f'), which, str(worst.n), span_words(worst.duration_s),
        '; '.join(_list_doubts(runs))))


def _list_doubts(runs: Iterable[RunVerdict]) -> Iterable[str]:
    """Yield what speaks against each run, the gravest first."""
    for run in sorted(runs, key=gravity_of):
        if doubts := list_doubts(run):
            yield f'run {run.run}: {", ".join(doubts)}'


def _shorten_names(paths: Sequence[str]) -> list[str]:
    """Return the last part of each path, or the paths if these parts are not unique."""
    names = [os.path.basename(path.rstrip(os.sep)) or path for path in paths]
    labels = names if len({*names}) == len({*paths}) else [*paths]
    half = _LONGEST_NAME // 2
    return [name if len(name) <= _LONGEST_NAME else f'{name[:half - 1]}…{name[-half:]}'
            for name in labels]


def _align(rows: Sequence[tuple[str, ...]]) -> Iterable[str]:
    widths = [max(len(row[at]) for row in rows) for at in range(len(_HEAD))]
    for row in rows:
        cells = [cell.rjust(width) if name in _TO_THE_RIGHT else cell.ljust(width)
                 for name, cell, width in zip(_HEAD, row, widths)]
        yield '  '.join(cells).rstrip()
