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

"""The runs of a logbook that a verdict judges together, and those that it leaves out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterator, Mapping, Sequence

from heading_intercompare.core.count_words import count_words
from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.utc_text import utc

#: Times of runs that a line names.
_MOST_TIMES = 3


@dataclass(frozen=True, slots=True)
class LeftOutRun:
    """A run of a logbook that is left out; keys of the JSON."""

    start_ns: int = figure('first pair')
    end_ns: int = figure('last pair')
    why: str = figure('why it is left out')


@dataclass(frozen=True, slots=True)
class ChosenRuns:
    """The last runs of one sensor in a logbook; keys of the JSON."""

    asked: int = figure('number of the last runs that were to be judged', unit='1')
    ship: str = figure('ship or sensor, as the logbook names it')
    logbooks: Mapping[str, str | None] = figure(
        'newest hash in the chain of each logbook, by the name of its file',
        'null if the logbook has no chain')
    left_out: tuple[LeftOutRun, ...] = figure('runs since the first of them that are left out')

    @property
    def words(self) -> str:
        """Return which runs these are, in a line."""
        runs = f'the last {count_words(self.asked, "usable run")}'
        left_out = (f'; {len(self.left_out)} since the first of them left out'
                    if self.left_out else '; none since the first of them left out')
        return f'{runs} of {self.ship or "(no ship)"} in {", ".join(self.logbooks)}{left_out}'

    def list_left_out(self) -> Iterator[str]:
        """Yield a line for each reason, with the times of the runs."""
        return describe_left_out(self.left_out)


def describe_left_out(runs: Sequence[LeftOutRun]) -> Iterator[str]:
    """Yield a line for each reason why runs are left out, with their times."""
    for why in dict.fromkeys(run.why for run in runs):
        starts = [f'{utc(run.start_ns)[:16]}' for run in runs if run.why == why]
        more = ', ...' if len(starts) > _MOST_TIMES else ''
        yield (f'{count_words(len(starts), "run")} left out, {why}: '
               f'{", ".join(starts[:_MOST_TIMES])} UTC{more}')
