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

"""
Where runs start and end.

Cuts come from a table of runs if there is one, otherwise from start and stop marks; without these
a run opens at the first pair. Within these bounds, a silence longer than `runs.gap_s` cuts, and
without a table so does the clock (`runs.every_h`, `runs.cut_at_utc`).
"""

from __future__ import annotations

from bisect import insort
from dataclasses import dataclass
from typing import Sequence

import numpy as np

from heading_intercompare.core.settings import RunCutting
from heading_intercompare.core.time_rules.clock_cuts import ClockCuts


@dataclass(frozen=True, slots=True)
class Piece:
    """
    Consecutive pairs of one run.

    Attributes
    ----------
    key
        The same for all pieces of a run, larger for a later run.
    cut_ns
        Stamp of the cut that opened the run: of its mark, of the clock, or of its first pair.
    since_ns
        Stamp of the first pair after the newest mark or silence. A cut by the clock leaves it as
        it is: the sensors go on.
    lo, hi
        The pairs i of the chunk with lo <= i < hi belong to the piece.

    """

    key: int
    cut_ns: int
    since_ns: int
    lo: int
    hi: int


@dataclass(frozen=True, slots=True)
class CutterState:
    """
    What a cutter remembers, to go on later.

    Attributes
    ----------
    since_ns, cut_ns, newest_ns, key, in_run
        As in `Piece`; stamp of the newest pair; whether a run is in progress.
    events : sequence of (stamp_ns, starts)
        Marks that wait.
    marked, open
        A mark was set; pairs belong to runs.

    """

    since_ns: int
    cut_ns: int | None
    newest_ns: int | None
    key: int
    in_run: bool
    events: tuple[tuple[int, bool], ...]
    marked: bool
    open: bool


class RunCutter:
    """
    Cut a stream of pairs into runs.

    Parameters
    ----------
    rule
        Uses `gap_s`, `every_h` and `cut_at_utc`.
    table : sequence of (start_ns, stop_ns), optional
        Runs as half-open intervals, ascending, without overlap. Marks are then ignored.

    Notes
    -----
    A mark carries the stamp of the newest pair at the time it was set: a start takes effect
    after that pair, a stop includes it. A mark that comes early waits; one that comes late takes
    effect after the newest pair. The first start mark withdraws the runs that were opened
    without one.

    """

    def __init__(self, rule: RunCutting, table: Sequence[tuple[int, int]] | None = None) -> None:
        self._gap_ns = round(rule.gap_s * 1e9)
        # The table says where its runs begin and end, whatever the clock says.
        self._clock = rule.clock_cuts() if table is None else ClockCuts(None, None)
        self._since_ns = 0
        self._events: list[tuple[int, bool]] = []
        self._rows = [*(table or ())]
        self._table = table is not None
        self._marked = self._table
        self._open = not self._table
        self._key = 0
        self._in_run = False
        self._cut_ns: int | None = None
        self._newest_ns: int | None = None
        last = None
        for start_ns, stop_ns in table or ():
            if stop_ns <= start_ns:
                raise ValueError(f'run table: stop {stop_ns} is not after start {start_ns}')
            if last is not None and start_ns < last:
                raise ValueError(f'run table: start {start_ns} is before the end {last} of '
                                 'the run above it')
            last = stop_ns
        self._arm_table()

    def _arm_table(self) -> None:
        self._events += [event for start_ns, stop_ns in self._rows
                         for event in ((start_ns, True), (stop_ns, False))]

    def begin_segment(self) -> None:
        """End the run where a clock was set back; the rows of a table count again."""
        self._in_run, self._cut_ns, self._newest_ns = False, None, None
        if self._table:
            self._open, self._events = False, []
            self._arm_table()

    @property
    def state(self) -> CutterState:
        """Return what the cutter remembers; another one with the same rule can go on from it."""
        return CutterState(since_ns=self._since_ns, cut_ns=self._cut_ns, newest_ns=self._newest_ns,
                           key=self._key, in_run=self._in_run, events=tuple(self._events),
                           marked=self._marked, open=self._open)

    def go_on(self, state: CutterState) -> None:
        """Go on from the state of another cutter."""
        self._since_ns, self._cut_ns, self._newest_ns = (
            state.since_ns, state.cut_ns, state.newest_ns)
        self._key, self._in_run, self._events = state.key, state.in_run, [*state.events]
        self._marked, self._open = state.marked, state.open

    @property
    def current(self) -> int | None:
        """Key of the run in progress, None outside runs."""
        return self._key if self._in_run else None

    @property
    def next_cut_ns(self) -> int | None:
        """When the clock cuts next after the newest pair; None if it does not or there is none."""
        if self._newest_ns is None or not self._clock:
            return None
        return self._clock.next(self._newest_ns)

    def mark(self, kind: str, stamp_ns: int) -> bool:
        """
        Set a mark.

        Parameters
        ----------
        kind : {'start', 'stop'}
            Whether a run starts or stops.
        stamp_ns
            Stamp of the newest pair when the mark was set.

        Returns
        -------
        bool
            True if this mark withdraws the runs that were opened without one.

        """
        if kind not in ('start', 'stop'):
            raise ValueError(f"mark = {kind!r}: use 'start' or 'stop'")
        if self._table:
            return False
        withdraws = kind == 'start' and not self._marked
        if withdraws:
            self._open = self._in_run = False
        self._marked = True
        event = (stamp_ns + 1, kind == 'start')
        if event not in self._events:
            insort(self._events, event)
        if self._newest_ns is not None:
            self._apply(self._newest_ns + 1)
        return withdraws

    def update(self, stamp_ns: np.ndarray) -> list[Piece]:
        """Return the pieces of runs in a chunk; pairs outside runs belong to no piece."""
        pieces = []
        n = len(stamp_ns)
        lo = 0
        while lo < n:
            self._apply(int(stamp_ns[lo]))
            hi = int(np.searchsorted(stamp_ns, self._events[0][0])) if self._events else n
            if self._open:
                pieces += self._cut_pieces(stamp_ns, lo, hi)
            self._newest_ns = int(stamp_ns[hi - 1])
            lo = hi
        return pieces

    def _apply(self, stamp_ns: int) -> None:
        """Apply the marks up to a stamp."""
        while self._events and self._events[0][0] <= stamp_ns:
            at_ns, starts = self._events.pop(0)
            self._in_run = False
            self._open = starts
            self._cut_ns = at_ns if starts else None

    def _cut_pieces(self, stamp_ns: np.ndarray, lo: int, hi: int) -> list[Piece]:
        chunk = stamp_ns[lo:hi]
        newest_ns = self._newest_ns
        first = newest_ns if newest_ns is not None and self._in_run else int(chunk[0])
        silent = set((lo + np.flatnonzero(
            np.diff(chunk, prepend=first) > self._gap_ns)).tolist())
        crossed = set((lo + self._clock.find_crossed(chunk, first)).tolist())
        bounds = sorted({lo, hi} | silent | crossed)
        pieces = []
        for begin, end in zip(bounds[:-1], bounds[1:]):
            begin_ns = int(stamp_ns[begin])
            if begin in silent or not self._in_run:
                if begin in silent or self._cut_ns is None:
                    self._cut_ns = begin_ns
                self._since_ns = begin_ns
                self._key += 1
                self._in_run = True
            elif begin in crossed:
                self._cut_ns = self._clock.last(begin_ns)
                self._key += 1
            if self._cut_ns is not None:
                pieces.append(Piece(self._key, self._cut_ns, self._since_ns, begin, end))
        return pieces
