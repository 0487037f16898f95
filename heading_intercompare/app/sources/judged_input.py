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

"""What the judging of one input gives: the runs of each pair of its sensors."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Mapping, Sequence

from heading_intercompare.bags.csv.pairs_account import PairsAccount
from heading_intercompare.core.sensors.pair_names import Names
from heading_intercompare.core.verdict.judge import RunResult
from heading_intercompare.core.verdict.verdict_document import Input, RunVerdict
from heading_intercompare.report import SegmentSketches


@dataclass(frozen=True, slots=True)
class JudgedInput:
    """
    The runs of one input: a recording, a table of pairs, a journal, or the logs of a trial.

    Attributes
    ----------
    path
        The path as the user gave it.
    results : mapping of (str, str) to list of RunResult
        The runs of each pair, by the names of its sensors.
    entries
        Its entries in the verdict on several sensors.
    entries_of_tested
        Its entries in the verdict on each tested sensor, by its name.
    notes : list of str
        What the user should know about it: unfinished bag, no run, not judged again.
    earlier
        Runs of each tested sensor that are too old for the verdict (`runs.keep`).
    sketches
        Data for the figures of each tested sensor; empty unless requested.
    accounts
        What belongs beside a csv of the pairs of each tested sensor.
    apart
        Why no sensors in it have a pair, if their stamps do not meet; otherwise empty.

    """

    path: str
    results: Mapping[Names, list[RunResult]]
    entries: Sequence[Input]
    entries_of_tested: Mapping[str, Sequence[Input]]
    notes: list[str] = field(default_factory=list)
    earlier: Mapping[str, list[RunVerdict]] = field(default_factory=dict)
    sketches: Mapping[str, SegmentSketches] = field(default_factory=dict)
    accounts: Mapping[str, PairsAccount] = field(default_factory=dict)
    apart: str = ''

    @property
    def error(self) -> str | None:
        """Why it could not be judged; None if it could."""
        return self.entries[0].error if self.entries else None

    @property
    def sha256(self) -> str | None:
        """Hash of its data; None if it has none of its own."""
        return self.entries[0].sha256 if len(self.entries) == 1 else None

    def lacks_run(self, names: Names) -> bool:
        """Tell whether a pair has no run in it, though it is judged for itself."""
        elsewhere = any(entry.same_as or entry.continues for entry in self.entries)
        return not elsewhere and not self.results.get(names)

    def without_runs(self, note: str, **changes: Any) -> 'JudgedInput':
        """Return the input without its runs, with a note that says why, and changed entries."""
        return JudgedInput(
            path=self.path, results={},
            entries=[replace(entry, **changes) for entry in self.entries],
            entries_of_tested={
                name: [replace(entry, **changes) for entry in entries]
                for name, entries in self.entries_of_tested.items()},
            notes=[f'{self.path}: {note}'])
