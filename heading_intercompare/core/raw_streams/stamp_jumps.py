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
Stamps that jump: each is held until later stamps show whether the jump is true.

One bad stamp in the future would otherwise make every later reading look old. The decisions
depend on the stamps and their order alone, not on how the stream is cut into chunks.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Generic, Sequence, TypeVar

import numpy as np

from heading_intercompare.core.records import Headings, Integers, Pairs
from heading_intercompare.core.utc_text import utc

NEVER = np.iinfo(np.int64).min
"""A stamp before all others."""

# The least number of readings that go on from each other, and the least time that they span: at
# the start of a stream, and after a step of the clock. Accepting a wrong step costs most.
_CONFIRMED_N, _SETTLED_NS, _CONFIRMED_NS = 3, 10 ** 9, 5 * 10 ** 9
# A sensor slower than the bound: its steps are alike within this factor. If it was faster before,
# more of them must confirm that, because stamps at random rise three times in a row, too.
_ALIKE, _SLOWED_N = 10, 8
# A gap of this many usual steps is no jump, however slow the sensor.
_USUAL_STEPS = 3
_RECENT, _MOST_LINES, _BLOCK = 4, 16, 64
_MOST_HELD, _MOST_SLOWED = 20_000, 1000

_HELD, _ACCEPTED, _LATE, _JUMPED, _GONE = range(5)
_NONE = np.empty(0, np.int64)

_Rows = TypeVar('_Rows', Headings, Pairs)


def is_rising(stamp_ns: np.ndarray, newest_ns: int | None = None) -> np.ndarray:
    """
    Tell which stamps are greater than all earlier ones.

    Parameters
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        Stamps in order of arrival, nanoseconds.
    newest_ns
        Largest stamp accepted so far.

    Returns
    -------
    ndarray of bool, shape (n,)

    Examples
    --------
    >>> is_rising(np.array([3, 3, 2, 4]), 1).tolist()
    [True, False, False, True]

    """
    before = np.concatenate(([NEVER if newest_ns is None else newest_ns], stamp_ns[:-1]))
    return stamp_ns > np.maximum.accumulate(before)[:len(stamp_ns)]


@dataclass(frozen=True, slots=True)
class SetBack:
    """
    A clock that was set back: the stamps of a stream went on from an earlier time.

    Attributes
    ----------
    stream : {'ts', 'rs'}
        The sensor.
    stamp_ns
        Newest stamp before the step, nanoseconds.
    size_ns
        How far the clock was set back, nanoseconds, > 0.
    clock_segment
        How many clocks of the comparison were set back before, each at another time.

    """

    stream: str
    stamp_ns: int
    size_ns: int
    clock_segment: int = 0

    def __str__(self) -> str:
        return (f'the clock of the {self.stream.upper()} was set back by '
                f'{self.size_ns / 1e9:.1f} s at {utc(self.stamp_ns)} UTC')


@dataclass(frozen=True, slots=True)
class Decided(Generic[_Rows]):
    """
    Readings whose stamps are decided.

    Attributes
    ----------
    accepted : Headings or Pairs
        With increasing stamps, also across calls.
    late_ns : ndarray of int64
        Stamps rejected because they do not increase: duplicates and reordered readings.
    jumped_ns : ndarray of int64
        Stamps rejected because the readings around them contradict them.
    set_back : SetBack, optional
        The clock was set back: this line of stamps has ended.
    after : Headings or Pairs, optional
        The readings after the step, whose stamps are decided by another filter.

    """

    accepted: _Rows
    late_ns: Integers
    jumped_ns: Integers
    set_back: SetBack | None = None
    after: _Rows | None = None


class _Line:
    """Held readings whose stamps go on from each other."""

    def __init__(self, row: int, stamp_ns: int) -> None:
        self.rows = [row]
        self.first_ns = self.last_ns = stamp_ns

    def add(self, row: int, stamp_ns: int) -> None:
        self.rows.append(row)
        self.last_ns = stamp_ns

    def lasts(self, span_ns: int) -> bool:
        return len(self.rows) >= _CONFIRMED_N and self.last_ns - self.first_ns >= span_ns


class JumpFilter(Generic[_Rows]):
    """
    Accept readings whose stamps go on from each other, and hold those that jump.

    Parameters
    ----------
    stream
        Name of the stream, stated in a `SetBack`.
    jump_s
        A longer step of the stamps is a jump, seconds: `pairing.jump_s`.
    empty : Headings or Pairs
        The empty chunk of the kind to take.

    Attributes
    ----------
    newest_ns
        Newest accepted stamp.

    Notes
    -----
    The *bound* is `jump_s`, or three usual steps of a sensor slower than that. A stamp up to the
    bound after the newest accepted one is accepted. One up to the bound before it does not
    increase and is rejected as late.

    A stamp further ahead is held. If a later one goes on from the newest accepted stamp, the held
    ones are rejected as jumps. If at least three held stamps go on from each other for at least
    five seconds, they are accepted: the sensor was silent, or its clock was set forward. The first
    stamps of a stream are held in the same way for a second, because nothing before them says
    whether they are right. Stamps that rise by similar steps longer than the bound are accepted,
    too: three at the start of a stream, eight later.

    A stamp further back is held, too. If a later one goes on from the newest accepted stamp, the
    held ones are rejected as jumps. If at least three go on from each other for at least five
    seconds, the clock was set back. Then the filter has done its work: `Decided.after` has the
    readings from the first of them on.

    """

    def __init__(self, stream: str, jump_s: float, empty: _Rows) -> None:
        self.newest_ns: int | None = None
        self._stream = stream
        self._jump_ns = round(jump_s * 1e9)
        self._held: _Rows = empty
        self._lines: list[_Line] = []
        self._recent: list[int] = []
        self._back: _Line | None = None

    def __len__(self) -> int:
        """Return the number of readings held."""
        return len(self._held)

    @property
    def held_ns(self) -> int:
        """Largest stamp held; `NEVER` if none is held."""
        return max((line.last_ns for line in self._lines), default=NEVER)

    def take(self, rows: _Rows) -> Decided[_Rows]:
        """Take readings in order of arrival; return those that are now decided."""
        at = len(self._held)
        if not at and self._goes_on(rows.stamp_ns):
            self._note_accepted(rows.stamp_ns[-_RECENT:].tolist())
            return Decided(rows, _NONE, _NONE)
        if at:
            rows = self._held + rows
        stamps, n = rows.stamp_ns, len(rows)
        fate = np.full(n, _HELD, np.uint8)
        # One by one only near a jump: blocks that grow keep a long stream fast.
        block, singly = n, at
        while at < n:
            if (at >= singly and not self._lines and self._back is None
                    and self.newest_ns is not None):
                end = min(at + block, n)
                at += self._go_on(stamps[at:end], fate[at:end])
                block *= 2
                if at < end:
                    block, singly = _BLOCK, at + _BLOCK
            else:
                self._decide(at, int(stamps[at]), stamps, fate)
                at += 1
                if self._back is not None and self._back.lasts(_CONFIRMED_NS):
                    return self._break_off(rows, fate, at)
        return self._release(rows, fate)

    def _break_off(self, rows: _Rows, fate: np.ndarray, at: int) -> Decided[_Rows]:
        """End this line of stamps at a clock that was set back; `at` is the first row not read."""
        assert self._back is not None and self.newest_ns is not None
        set_back = SetBack(self._stream, self.newest_ns,
                           self.newest_ns + self._usual_ns() - self._back.first_ns)
        after = rows[np.r_[self._back.rows, at:len(rows)]]
        fate[self._back.rows], fate[at:] = _GONE, _GONE
        self._drop_lines(fate)
        self._back = None
        return replace(self._release(rows, fate), set_back=set_back, after=after)

    @property
    def holds_back(self) -> bool:
        """Whether stamps far before the newest accepted one are held."""
        return self._back is not None

    def release_back(self) -> _Rows:
        """Give up the readings held far before the newest accepted one, and return them."""
        if self._back is None:
            return self._held[:0]
        rows = self._held[np.array(self._back.rows)]
        fate = np.full(len(self._held), _HELD, np.uint8)
        fate[self._back.rows], self._back = _GONE, None
        self._release(self._held, fate)
        return rows

    def end(self) -> Decided[_Rows]:
        """Decide the readings held at the end of the stream."""
        rows = self._held
        fate = np.full(len(rows), _JUMPED, np.uint8)
        if self._lines:
            if self.newest_ns is None and is_rising(rows.stamp_ns).all():
                fate[:] = _ACCEPTED
            else:
                longest = max(self._lines, key=lambda line: len(line.rows))
                if self.newest_ns is None or len(longest.rows) >= _CONFIRMED_N:
                    fate[longest.rows] = _ACCEPTED
            self._lines = []
            self._note_accepted(rows.stamp_ns[fate == _ACCEPTED].tolist(), fate)
        self._back = None
        return self._release(rows, fate)

    def _goes_on(self, stamp_ns: Integers) -> bool:
        """Tell whether all stamps of a chunk go on from each other, as nearly always."""
        if self.newest_ns is None or not len(stamp_ns):
            return False
        if not 0 < int(stamp_ns[0]) - self.newest_ns <= self._jump_ns:
            return False
        steps = stamp_ns[1:] - stamp_ns[:-1]
        return not len(steps) or bool(steps.min() > 0 and steps.max() <= self._jump_ns)

    def _release(self, rows: _Rows, fate: np.ndarray) -> Decided[_Rows]:
        """Keep the held readings and return the others."""
        held = fate == _HELD
        if held.any():
            place = np.cumsum(held) - 1
            for line in self._held_lines:
                line.rows = place[line.rows].tolist()
        self._held = rows[held]
        accepted = fate == _ACCEPTED
        return Decided(rows if accepted.all() else rows[accepted],
                       rows.stamp_ns[fate == _LATE], rows.stamp_ns[fate == _JUMPED])

    @property
    def _held_lines(self) -> list[_Line]:
        return self._lines if self._back is None else [*self._lines, self._back]

    def _go_on(self, stamp_ns: Integers, fate: np.ndarray) -> int:
        """Decide the stamps before the first jump; return how many they are."""
        assert self.newest_ns is not None
        before = np.concatenate(([self.newest_ns], stamp_ns[:-1]))
        step = stamp_ns - np.maximum.accumulate(before)
        odd = np.abs(step) > self._jump_ns
        n = int(np.argmax(odd)) if odd.any() else len(step)
        rises = step[:n] > 0
        fate[:n] = np.where(rises, _ACCEPTED, _LATE)
        self._note_accepted(stamp_ns[:n][rises][-_RECENT:].tolist())
        return n

    def _note_accepted(self, stamp_ns: Sequence[int], fate: np.ndarray | None = None) -> None:
        if len(stamp_ns):
            self.newest_ns = stamp_ns[-1]
            self._recent = [*self._recent, *stamp_ns[-_RECENT:]][-_RECENT:]
            if fate is not None and self._back is not None:
                fate[self._back.rows] = _JUMPED
            self._back = None

    def _usual_ns(self) -> int:
        """Return the median of the last three steps; 0 if there are fewer."""
        if len(self._recent) < _RECENT:
            return 0
        steps = sorted(b - a for a, b in zip(self._recent, self._recent[1:]))
        return steps[len(steps) // 2]

    def _decide(self, row: int, stamp_ns: int, stamps: Integers, fate: np.ndarray) -> None:
        """Decide a stamp, or hold it."""
        bound_ns = max(self._jump_ns, _USUAL_STEPS * self._usual_ns())
        if self.newest_ns is not None:
            step = stamp_ns - self.newest_ns
            if 0 < step <= bound_ns:
                self._drop_lines(fate)
                fate[row] = _ACCEPTED
                self._note_accepted([stamp_ns], fate)
                return
            if step < -bound_ns:
                self._hold_back(row, stamp_ns, bound_ns, fate)
                return
            if step <= 0:
                fate[row] = _LATE
                return
        self._hold(row, stamp_ns, bound_ns, fate)
        confirmed = self._find_confirmed(stamps, fate, bound_ns)
        if confirmed:
            self._drop_lines(fate)
            fate[confirmed] = _ACCEPTED
            self._note_accepted(stamps[confirmed].tolist(), fate)

    def _drop_lines(self, fate: np.ndarray) -> None:
        for line in self._lines:
            fate[line.rows] = _JUMPED
        self._lines = []

    def _hold(self, row: int, stamp_ns: int, bound_ns: int, fate: np.ndarray) -> None:
        """Put a stamp in the line from which it goes on, or in a new one."""
        line = min(self._lines, key=lambda held: abs(stamp_ns - held.last_ns), default=None)
        if line is not None and abs(stamp_ns - line.last_ns) <= bound_ns:
            if stamp_ns > line.last_ns:
                line.add(row, stamp_ns)
                if len(line.rows) > _MOST_HELD:
                    # No sensor sends this number of readings within five seconds.
                    fate[line.rows] = _JUMPED
                    self._lines.remove(line)
            else:
                fate[row] = _LATE
            return
        self._lines.append(_Line(row, stamp_ns))
        if len(self._lines) > _MOST_LINES:
            fate[self._lines.pop(0).rows] = _JUMPED

    def _find_confirmed(self, stamps: Integers, fate: np.ndarray, bound_ns: int) -> list[int]:
        """Return the rows of the held stamps that confirm each other, if any."""
        span_ns = _SETTLED_NS if self.newest_ns is None else _CONFIRMED_NS
        for line in self._lines:
            if line.lasts(span_ns):
                return line.rows
        needed = _CONFIRMED_N if len(self._recent) < _RECENT else _SLOWED_N
        # Only a sensor slower than the bound has several lines and does not fall back.
        # It has few readings in a line; to look at many at each reading would take for ever.
        if len(self._lines) < 2 or not (
                needed <= sum(len(line.rows) for line in self._lines) <= _MOST_SLOWED):
            return []
        held = sorted(row for line in self._lines for row in line.rows)
        times = [int(stamps[row]) for row in held]
        steps = [b - a for a, b in zip(times, times[1:])]
        last = steps[1 - needed:]
        if min(last) <= 0 or max(last) <= bound_ns or max(last) > _ALIKE * min(last):
            return []
        begin = next((at + 1 for at in reversed(range(len(steps))) if steps[at] <= 0), 0)
        return held[begin:]

    def _hold_back(self, row: int, stamp_ns: int, bound_ns: int, fate: np.ndarray) -> None:
        """Put a stamp far before the newest accepted one in the line there, or in a new one."""
        line = self._back
        if line is not None and 0 < stamp_ns - line.last_ns <= bound_ns:
            line.add(row, stamp_ns)
            if len(line.rows) <= _MOST_HELD:
                return
            # No sensor sends this number of readings within five seconds.
            fate[line.rows], self._back = _JUMPED, None
            return
        if line is not None and -bound_ns <= stamp_ns - line.last_ns <= 0:
            fate[row] = _LATE
            return
        if line is not None:
            fate[line.rows] = _JUMPED
        self._back = _Line(row, stamp_ns)
