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

"""Many runs in one protocol: a list of all, the worst first, and which are shown in full."""

from __future__ import annotations

from typing import NamedTuple, Sequence

from heading_intercompare.core.decision.coverage import span_words
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.verdict.headline import say_outcome
from heading_intercompare.core.verdict.run_gravity import gravity_of, list_doubts
from heading_intercompare.core.verdict.verdict_document import RunVerdict, Verdict
from heading_intercompare.report.formatting import fixed

MANY = 10
"""Of more runs than this a protocol shows only the worst in full."""
N_IN_FULL = 5
"""The number of runs that it then shows in full."""
RUN_COLUMNS = ('run', 'recording', 'from', 'outcome', 'sd [deg]', 'mean [deg]', 'n', 'duration',
               'in doubt')


class RunLine(NamedTuple):
    """The line of a run: its number, the cells after it, and the file of its own page."""

    run: int
    cells: tuple[str, ...]
    page: str


def pick_in_full(verdict: Verdict) -> Sequence[RunVerdict]:
    """Return the runs that a protocol shows in full: all, or the worst of many."""
    if len(verdict.runs) <= MANY:
        return verdict.runs
    return sorted(verdict.runs, key=gravity_of)[:N_IN_FULL]


def list_run_lines(verdict: Verdict, folder: str) -> list[RunLine]:
    """
    Return a line for each of many runs, the worst first; none for few runs.

    Parameters
    ----------
    verdict
        The verdict as it is shown.
    folder
        Folder with a page for each run; '' if there is none.

    """
    if len(verdict.runs) <= MANY:
        return []
    return [RunLine(run.run, _describe(run), f'{folder}/{page_name(run)}' if folder else '')
            for run in sorted(verdict.runs, key=gravity_of)]


def tell_elsewhere(verdict: Verdict, folder: str) -> str:
    """Return where the figures of the runs are that the protocol does not show in full."""
    if len(verdict.runs) <= MANY:
        return 'The annexes have those of all runs.'
    if folder:
        return 'Each run has a page of its own: see the list of the runs.'
    return 'The protocol in HTML has a page for each run, the verdict in JSON has all figures.'


def page_name(run: RunVerdict) -> str:
    """Return the name of the page of a run."""
    return f'run-{run.run}.html'


def _describe(run: RunVerdict) -> tuple[str, ...]:
    return (run.source, utc(run.start_ns).partition('.')[0],
            say_outcome(run.outcome, run.validity_effect), fixed(run.std_deg, '.3f'),
            fixed(run.mean_deg, '+.3f'), str(run.n), span_words(run.duration_s),
            ', '.join(list_doubts(run)))
