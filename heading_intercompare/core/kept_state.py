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

"""What a judgement in progress remembers apart from the pairs of its run, as text and back."""

from __future__ import annotations

from dataclasses import dataclass, fields
import json

from heading_intercompare.core.decision.criteria import Limits, Printed
from heading_intercompare.core.decision.guarded import Evidence
from heading_intercompare.core.decision.taken_out import Stretch
from heading_intercompare.core.runs.record_pieces import PieceState
from heading_intercompare.core.runs.run_cutter import CutterState
from heading_intercompare.core.validity.condition import Finding
from heading_intercompare.core.verdict.judge import RunResult
from heading_intercompare.core.verdict.recorded import JudgedPiece
from heading_intercompare.core.verdict.verdict_document import RunVerdict

from .outcome import Outcome
from .settings import Settings
from .typed_reader import make_plain, read_plain


@dataclass(frozen=True, slots=True)
class KeptRun:
    """A judged run without its settings, and the stamp of the cut that opened it."""

    verdict: RunVerdict
    evidence: Evidence
    limits: Limits
    printed: Printed
    alone: tuple[Outcome, str]
    stabilization_s: float | str
    cut_ns: int
    judged: tuple[Finding, ...]
    fingerprint: str | None
    first_pair: int

    @classmethod
    def of(cls, result: RunResult, cut_ns: int = 0) -> 'KeptRun':
        """Return a judged run to keep."""
        return cls(**{f.name: getattr(result, f.name) for f in fields(cls) if f.name != 'cut_ns'},
                   cut_ns=cut_ns)

    def result(self, settings: Settings) -> RunResult:
        """Return the judged run, given the settings it was judged by."""
        return RunResult(**{f.name: getattr(self, f.name) for f in fields(self)
                            if f.name != 'cut_ns'}, settings=settings)


@dataclass(frozen=True, slots=True)
class KeptState:
    """
    The state of a `Compliance`, without the pairs of the run in progress.

    Attributes
    ----------
    cutter
        Where runs start and end.
    newest_ns
        Stamp of the newest pair.
    in_run
        A run is in progress; its cut is that of the cutter.
    finished
        Runs judged, but for those that were too old for the verdict and handed out.
    n_earlier, n_short
        Number of runs handed out, and of those that were too short before the newest of them.
    earlier_ns
        Cut of the newest run that is too old.
    n_pairs, first_pair
        Pairs so far, and those before the run in progress.
    record_ns
        Stamp of the first pair.
    record : tuple
        State of `RecordPieces`.
    outside
        What pairs outside the runs are called.
    before
        Pairs up to the end of the newest run that is too old, and that end, nanoseconds.
    short
        Runs that were too short.

    """

    cutter: CutterState
    newest_ns: int | None
    in_run: bool
    finished: tuple[KeptRun, ...]
    n_earlier: int
    n_short: int
    earlier_ns: int | None
    n_pairs: int
    record_ns: int | None
    record: tuple[CutterState, tuple[JudgedPiece, ...], PieceState | None]
    outside: str
    first_pair: int
    before: tuple[int, int]
    short: tuple[Stretch, ...]

    @property
    def n_judged(self) -> int:
        """Return the number of runs judged so far."""
        return self.n_earlier + len(self.finished)

    def to_text(self) -> str:
        """Return the state as text; `from_text` gives the same state to the bit."""
        return json.dumps(make_plain(self, exact=True))

    @classmethod
    def from_text(cls, text: str) -> 'KeptState':
        """
        Return the state in a text of `to_text`.

        Raises
        ------
        ValueError
            If the text is not a state.

        """
        state = read_plain(cls, json.loads(text), 'state')
        assert isinstance(state, cls)
        return state
