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

"""A record as its sensors made it, whatever marks, tables and settings leave out of its runs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Callable, Generic, Sequence, TypeVar

import numpy as np

from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.records import Differences, Pairs
from heading_intercompare.core.settings import Norms, RunCutting
from heading_intercompare.core.statistics.cells import Cells, CellsState
from heading_intercompare.core.statistics.moments import exact_sum, UNIT

from .run_cutter import CutterState, RunCutter

Judged = TypeVar('Judged')


@dataclass(frozen=True, slots=True)
class PieceState:
    """What a piece remembers, to go on later."""

    start_ns: int
    end_ns: int
    cells: CellsState
    rs_units: int
    ts_units: int


@dataclass(slots=True)
class RecordPiece:
    """
    The differences of a record from one silence or cut of the clock to the next.

    Attributes
    ----------
    start_ns, end_ns
        Stamps of its first and last pair.
    cells
        Its finite differences.

    """

    start_ns: int
    end_ns: int
    cells: Cells = field(default_factory=Cells)
    _rs_units: int = 0
    _ts_units: int = 0

    @property
    def span_s(self) -> float:
        """Time from the first to the last pair, seconds."""
        return (self.end_ns - self.start_ns) / 1e9

    def update(self, pairs: Pairs, differences: Differences) -> None:
        """Take pairs in stamp order, n >= 1, and their differences."""
        self.end_ns = int(pairs.stamp_ns[-1])
        finite = np.isfinite(differences.x_deg)
        if not finite.all():
            pairs, differences = pairs[finite], differences[finite]
        if len(pairs):
            self.cells.update(differences.x_deg, differences.stamp_ns)
            self._rs_units += exact_sum(pairs.rs_variance_factor)
            self._ts_units += exact_sum(pairs.ts_variance_factor)

    def limits(self, norms: Norms, model: str) -> Limits:
        """Return the limits of a decision on the piece."""
        n = self.cells.n
        if not n:
            return Limits.of(norms, model)
        return Limits.of(norms, model, self._rs_units / n * UNIT, self._ts_units / n * UNIT)

    @property
    def state(self) -> PieceState:
        """Return what the piece remembers."""
        return PieceState(self.start_ns, self.end_ns, self.cells.state, self._rs_units,
                          self._ts_units)

    @classmethod
    def from_state(cls, state: PieceState) -> 'RecordPiece':
        """Return a piece that goes on from the state of another."""
        return cls(state.start_ns, state.end_ns, Cells.from_state(state.cells), state.rs_units,
                   state.ts_units)


class RecordPieces(Generic[Judged]):
    """
    Keep the sums of all differences of a record, in runs or not.

    Parameters
    ----------
    rule
        Only silences and the clock cut the record.
    judge
        Returns what is kept of a piece that has ended, or would end now.

    Attributes
    ----------
    n : int
        Pairs so far, in runs or not.
    start_ns
        Stamp of the first pair.

    Notes
    -----
    The piece in progress has sums over cells of time: some ten kilobytes, however long it is.

    """

    def __init__(self, rule: RunCutting, judge: Callable[[RecordPiece], Judged]) -> None:
        self._cutter, self._judge = RunCutter(rule), judge
        self._key: int | None = None
        self._ended: list[Judged] = []
        self._piece: RecordPiece | None = None
        self.n = 0
        self.start_ns: int | None = None

    def update(self, pairs: Pairs, differences: Differences) -> None:
        """Take pairs in stamp order and their differences."""
        if self.start_ns is None and len(pairs):
            self.start_ns = int(pairs.stamp_ns[0])
        for part in self._cutter.update(pairs.stamp_ns):
            which = slice(part.lo, part.hi)
            if self._piece is None or part.key != self._key:
                self._ended, self._key = [*self.pieces], part.key
                start_ns = int(pairs.stamp_ns[part.lo])
                self._piece = RecordPiece(start_ns, start_ns)
            self._piece.update(pairs[which], differences[which])
        self.n += len(pairs)

    def forget_before(self, stamp_ns: int, end_of: Callable[[Judged], int]) -> None:
        """Forget the pieces that end before a stamp, by a function that says when one ends."""
        self._ended = [judged for judged in self._ended if end_of(judged) >= stamp_ns]

    @property
    def newest_ns(self) -> int | None:
        """Stamp of the newest pair; None before the first."""
        return self._cutter.state.newest_ns

    @property
    def pieces(self) -> tuple[Judged, ...]:
        """Return what is kept of the pieces so far, in the order of time."""
        newest = () if self._piece is None else (self._judge(self._piece),)
        return (*self._ended, *newest)

    @property
    def state(self) -> tuple[CutterState, tuple[Judged, ...], PieceState | None]:
        """Return where the record is cut, the pieces that have ended, and that in progress."""
        return (self._cutter.state, tuple(self._ended),
                None if self._piece is None else self._piece.state)

    def go_on(self, n: int, start_ns: int | None, cutter: CutterState, ended: Sequence[Judged],
              piece: PieceState | None) -> None:
        """Go on from the state of another record."""
        self.n, self.start_ns, self._ended = n, start_ns, [*ended]
        self._cutter.go_on(cutter)
        self._key = cutter.key
        self._piece = None if piece is None else RecordPiece.from_state(piece)
