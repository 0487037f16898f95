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

import numpy as np

from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.records import Differences, Pairs
from heading_intercompare.core.settings import Norms, RunCutting
from heading_intercompare.core.statistics.cells import Cells
from heading_intercompare.core.statistics.moments import exact_sum, UNIT

from .run_cutter import RunCutter

__all__ = ['RecordPiece', 'RecordPieces']


@dataclass(slots=True)
class RecordPiece:
    """
    The differences of a record from one silence or cut of the clock to the next.

    Attributes
    ----------
    start_ns, end_ns : int
        Stamps of its first and last pair.
    cells : Cells
        Its finite differences.

    """

    start_ns: int
    end_ns: int
    cells: Cells = field(default_factory=Cells)
    _n: int = 0
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
            self._n += len(pairs)
            self._rs_units += exact_sum(pairs.rs_variance_factor)
            self._ts_units += exact_sum(pairs.ts_variance_factor)

    def limits(self, norms: Norms, model: str) -> Limits:
        """Return the limits of a decision on the piece."""
        if not self._n:
            return Limits.of(norms, model)
        return Limits.of(norms, model, self._rs_units / self._n * UNIT,
                         self._ts_units / self._n * UNIT)


class RecordPieces:
    """
    Keep the sums of all differences of a record, in runs or not.

    Parameters
    ----------
    rule : RunCutting
        Only silences and the clock cut the record.

    Attributes
    ----------
    n : int
        Pairs so far, in runs or not.

    Notes
    -----
    A piece keeps sums over cells of time, so it takes some kilobytes however long it is.

    """

    def __init__(self, rule: RunCutting) -> None:
        self._cutter = RunCutter(rule)
        self._key: int | None = None
        self._pieces: list[RecordPiece] = []
        self.n = 0

    def update(self, pairs: Pairs, differences: Differences) -> None:
        """Take pairs in stamp order and their differences."""
        for piece in self._cutter.update(pairs.stamp_ns):
            part = slice(piece.lo, piece.hi)
            if piece.key != self._key:
                self._key = piece.key
                start_ns = int(pairs.stamp_ns[piece.lo])
                self._pieces.append(RecordPiece(start_ns, start_ns))
            self._pieces[-1].update(pairs[part], differences[part])
        self.n += len(pairs)

    def forget_before(self, stamp_ns: int) -> None:
        """Forget the pieces that end before a stamp."""
        self._pieces = [piece for piece in self._pieces if piece.end_ns >= stamp_ns]

    @property
    def start_ns(self) -> int | None:
        """Stamp of the first pair of the first piece; None without any."""
        return self._pieces[0].start_ns if self._pieces else None

    @property
    def pieces(self) -> tuple[RecordPiece, ...]:
        """The pieces so far, in the order of time."""
        return tuple(self._pieces)
