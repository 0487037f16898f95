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

"""The judging of one input of a campaign, in any process."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Callable, Iterable, Mapping, Sequence

from heading_intercompare.bags.csv.pairs_account import PairsAccount
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.judge import RunResult
from heading_intercompare.core.verdict.verdict_document import Input, RunVerdict
from heading_intercompare.report import SeriesSketch

from .inputs import analyze_input
from .run_table import RunTable

__all__ = ['explain_unreadable', 'Job', 'Judged', 'UNREADABLE']

UNREADABLE = (OSError, ValueError, MemoryError)
"""The errors of an input that cannot be judged."""


def explain_unreadable(error: Exception, path: str) -> str:
    """Return why the input at `path` raised one of `UNREADABLE`, in one line without the path."""
    if isinstance(error, MemoryError):
        return 'there is not enough memory for it'
    why = str(error)
    if isinstance(error, OSError) and error.strerror:
        why = error.strerror
    return ' '.join(why.removeprefix(f'{path}: ').split())


@dataclass(frozen=True, slots=True)
class Judged:
    """
    The results of one input.

    Attributes
    ----------
    path : str
        The path as the user gave it.
    results : list of RunResult
        Its runs.
    notes : list of str
        What the user should know about it.
    description : Input
        Its entry in the verdict.
    sketch : SeriesSketch or None
        Data for the graphs of a report, if requested.
    earlier : list of RunVerdict
        Its runs that are too old for the verdict (`runs.keep`).
    account : PairsAccount or None
        What belongs beside a csv of its pairs; None if it was not judged.

    """

    path: str
    results: list[RunResult]
    notes: list[str]
    description: Input
    sketch: SeriesSketch | None = None
    earlier: list[RunVerdict] = field(default_factory=list)
    account: PairsAccount | None = None

    @property
    def error(self) -> str | None:
        """Why it could not be judged; None if it could."""
        return self.description.error

    @property
    def no_run(self) -> str | None:
        """Why it gave no run; None if it did."""
        return self.description.no_run


@dataclass(frozen=True, slots=True)
class Job:
    """
    The part of the task that is the same for all inputs; it is sent to other processes.

    Attributes
    ----------
    settings : Settings
    table : sequence of (start_ns, stop_ns, source), optional
        Runs.
    sketched : bool
        Collect the data for the graphs of a report.
    parts : mapping of str to sequence of str
        Absolute paths of the bags that go on with the trial of an input, by its path.

    """

    settings: Settings
    table: RunTable | None
    sketched: bool
    parts: Mapping[str, Sequence[str]] = field(default_factory=dict)

    def judge(self, path: str, takers: Iterable[Callable[[Pairs], None]] = (),
              progress: Callable[[str], None] = lambda text: None, *,
              place: str | None = None, helpers: int = 0) -> Judged:
        """
        Judge one input; OSError and ValueError if it cannot be read.

        `place` is where to find it, if the path means something else here; `helpers` is the
        number of processes that decode in parallel with this one.
        """
        takers = list(takers)
        place = place or path
        sketch = SeriesSketch(path) if self.sketched else None
        if sketch is not None:
            takers.append(partial(sketch.update, settings=self.settings))
        found = analyze_input(
            place, self.settings, self.table, takers, progress, name=path, helpers=helpers,
            parts=self.parts.get(path, ()),
            take_motion=(lambda motion: None) if sketch is None else sketch.take_motion)
        return Judged(path, found.results, found.notes, found.described, sketch,
                      [r.verdict for r in found.earlier], found.account)

    def survive(self, path: str, place: str | None = None) -> Judged:
        """Judge one input among others; if that fails, return a result that says why."""
        try:
            return self.judge(path, place=place)
        except UNREADABLE as error:
            return self.unread(path, explain_unreadable(error, place or path))

    def unread(self, path: str, why: str) -> Judged:
        """Return the result for an input that could not be judged."""
        why = ' '.join(why.split())
        described = Input(path, error=why)
        if Path(path).suffix != '.csv':
            described = replace(described, ts_topic=self.settings.ts_topic,
                                rs_topic=self.settings.rs_topic)
        return Judged(path, [], [f'{path}: not judged: {why}'], described)
