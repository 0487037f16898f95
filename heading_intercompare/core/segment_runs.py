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

"""The judged runs of one clock segment, and what it holds beside them."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

from heading_intercompare.core.decision.criteria import Limits, Printed
from heading_intercompare.core.decision.guarded import Evidence
from heading_intercompare.core.decision.taken_out import Stretch
from heading_intercompare.core.pairing.ledger import Ledger, LedgerKey, LedgerSegment
from heading_intercompare.core.runs.record_pieces import PieceState, RecordPieces
from heading_intercompare.core.runs.run_cutter import CutterState
from heading_intercompare.core.runs.run_series import RunSeries
from heading_intercompare.core.validity.condition import Finding
from heading_intercompare.core.verdict.judge import RunResult
from heading_intercompare.core.verdict.recorded import judge_piece, JudgedPiece
from heading_intercompare.core.verdict.verdict_document import RunVerdict

from .outcome import Outcome
from .settings import Risk, Settings

_PAIR_KEYS = LedgerKey.PAIRED, LedgerKey.TS_PAIRED, LedgerKey.RS_USED


@dataclass(frozen=True, slots=True)
class KeptRun:
    """A judged run without its settings, and the stamp of the cut that opened it."""

    verdict: RunVerdict
    evidence: Evidence
    limits: Limits
    printed: Printed
    alone: tuple[Outcome, str]
    risk: Risk
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
class SegmentState:
    """
    The state of a `SegmentRuns`.

    Attributes
    ----------
    number
        How often a clock was set back before.
    finished
        Runs judged, but for those that were too old for the verdict and handed out.
    n_short
        Number of the runs that were too short before the newest run that is too old.
    earlier_ns
        Cut of the newest run that is too old.
    n_pairs
        Pairs so far.
    record_ns
        Stamp of the first pair.
    record : tuple
        State of `RecordPieces`.
    before
        Pairs up to the end of the newest run that is too old, and that end, nanoseconds.
    short
        Runs that were too short.

    """

    number: int
    finished: tuple[KeptRun, ...]
    n_short: int
    earlier_ns: int | None
    n_pairs: int
    record_ns: int | None
    record: tuple[CutterState, tuple[JudgedPiece, ...], PieceState | None]
    before: tuple[int, int]
    short: tuple[Stretch, ...]


class SegmentRuns:
    """
    The judged runs of a clock segment, in which stamps increase, and its record.

    Parameters
    ----------
    settings
        Must hold the norms.
    number
        How often a clock was set back before.

    Attributes
    ----------
    record : RecordPieces
        The pairs in runs or not.
    finished : list of (RunResult, int)
        Runs judged, each with the stamp of the cut that opened it, but for those handed out.
    short : list of Stretch
        Runs that were too short.

    """

    def __init__(self, settings: Settings, number: int) -> None:
        self._settings, self.number = settings, number
        self.record: RecordPieces[JudgedPiece] = RecordPieces(
            settings.runs, lambda piece: judge_piece(piece, settings))
        self.finished: list[tuple[RunResult, int]] = []
        self.short: list[Stretch] = []
        # Pairs up to the end of the newest run that is too old for the verdict, and that end.
        self._before = 0, 0
        # How many runs were too short before the newest of the old runs, and the cut of that run.
        self._n_short_before = 0
        self._earlier_ns: int | None = None

    def copy(self) -> 'SegmentRuns':
        """Return the same runs, to judge another one."""
        copied = SegmentRuns(self._settings, self.number)
        copied.record, copied._before = self.record, self._before
        copied.finished, copied.short = [*self.finished], [*self.short]
        copied._n_short_before, copied._earlier_ns = self._n_short_before, self._earlier_ns
        return copied

    def withdraw(self) -> None:
        """Forget the runs, but not the record."""
        self.finished.clear()
        self.short.clear()
        self._n_short_before, self._earlier_ns = 0, None

    @property
    def state(self) -> SegmentState:
        """Return what is needed to go on later."""
        return SegmentState(
            number=self.number, finished=tuple(KeptRun.of(*run) for run in self.finished),
            n_short=self._n_short_before, earlier_ns=self._earlier_ns, n_pairs=self.record.n,
            record_ns=self.record.start_ns, record=self.record.state, before=self._before,
            short=tuple(self.short))

    @classmethod
    def from_state(cls, state: SegmentState, settings: Settings) -> 'SegmentRuns':
        """Return the runs of another process, which was given the same settings."""
        runs = cls(settings, state.number)
        runs.finished = [(run.result(settings), run.cut_ns) for run in state.finished]
        runs._n_short_before, runs._earlier_ns = state.n_short, state.earlier_ns
        runs._before, runs.short = state.before, [*state.short]
        runs.record.go_on(state.n_pairs, state.record_ns, *state.record)
        return runs

    @property
    def n_short(self) -> int:
        """Return how many runs were too short."""
        return self._n_short_before + len(self.short)

    @property
    def pieces(self) -> tuple[JudgedPiece, ...]:
        """Return the pieces of the record that the runs of the verdict can lie in."""
        return tuple(piece for piece in self.record.pieces if piece.end_ns >= self._before[1])

    def count_old(self, horizon_ns: int | None) -> int:
        """Return how many of the runs are too old for the verdict."""
        return 0 if horizon_ns is None else sum(
            result.verdict.end_ns < horizon_ns for result, _ in self.finished)

    def share(self, ledger: Ledger | None, run: RunSeries | None) -> list[RunResult]:
        """
        Return the runs with their shares of a ledger.

        Parameters
        ----------
        ledger
            Of this clock segment; without it, the pairs count as all readings received.
        run
            The run in progress, which has a share, too, though it is not among the runs yet.

        """
        if ledger is None:
            shares = [LedgerSegment(cut_ns, dict.fromkeys(_PAIR_KEYS, result.verdict.n_input))
                      for result, cut_ns in self.finished]
            return [replace(result, share=share, inside=share)
                    for (result, _), share in zip(self.finished, shares)]
        before = [] if self._earlier_ns is None else [self._earlier_ns]
        in_progress = [] if run is None else [run.cut_ns]
        starts = [*before, *(cut_ns for _, cut_ns in self.finished), *in_progress]
        return [replace(result, share=share, inside=ledger.count_between(
            result.verdict.start_ns, result.verdict.end_ns))
            for (result, _), share in zip(self.finished, ledger.shares(starts)[len(before):])]

    def list_outside(self, n_old: int, first_pair: int, why: str) -> tuple[Stretch, ...]:
        """
        Return the pairs that lie in no run of the verdict.

        Parameters
        ----------
        n_old
            How many of the runs are too old for the verdict.
        first_pair
            Pairs before the run in progress, or all pairs where there is none.
        why
            What pairs outside the runs are called.

        """
        results = [result for result, _ in self.finished]
        before = _end_of(results[n_old - 1]) if n_old else self._before
        ended = [before, *map(_end_of, results[n_old:])]
        begun = [*((result.first_pair, result.verdict.start_ns) for result in results[n_old:]),
                 (first_pair, self.record.newest_ns or 0)]
        short = [s for s in self.short if s.start_ns >= before[1]]
        outside = [*short]
        for (last, end_ns), (first, start_ns) in zip(ended, begun):
            n = first - last - sum(s.n for s in short if end_ns <= s.start_ns < start_ns)
            if n > 0:
                outside.append(Stretch(end_ns or self.record.start_ns or start_ns, start_ns,
                                       why, n))
        return tuple(outside)

    def forget(self, n_old: int) -> None:
        """Forget the oldest runs, and what lies before the end of the newest of them."""
        if not n_old:
            return
        last, self._earlier_ns = self.finished[n_old - 1]
        self._before = _end_of(last)
        end_ns = self._before[1]
        self.record.forget_before(end_ns, lambda piece: piece.end_ns)
        self._n_short_before += sum(s.start_ns < end_ns for s in self.short)
        self.short = [s for s in self.short if s.start_ns >= end_ns]
        del self.finished[:n_old]


def _end_of(result: RunResult) -> tuple[int, int]:
    """Return the pairs of the segment up to the end of a run, and that end, nanoseconds."""
    return result.first_pair + result.verdict.n_input, result.verdict.end_ns
