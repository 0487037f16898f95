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
Values that stand for several readings, because a logger polls a sensor faster than it reports.

The decisions depend on the stream alone, not on how it is cut into chunks.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from heading_intercompare.core.records import Headings, Integers

from .hold_search import Held, HoldSearch
from .stamp_jumps import NEVER

_LINE, _LEAST_LINE = 64, 8
_NONE = np.empty(0, np.int64)


def _no_stamps() -> Integers:
    return _NONE


@dataclass(frozen=True, slots=True)
class Unfolded:
    """
    Readings of which it is decided whether they only repeat a value.

    Attributes
    ----------
    kept
        The readings of the sensor, stamps increasing: all where it holds nothing, otherwise the
        first one of each value.
    held_ns : ndarray of int64
        Stamps of the readings that only repeat the one before.
    standing_ns : ndarray of int64
        Stamps of the kept readings whose values were held.
    turned_ns : ndarray of int64
        Stamps of the first kept readings after a hold has begun or ended.

    """

    kept: Headings
    held_ns: Integers = field(default_factory=_no_stamps)
    standing_ns: Integers = field(default_factory=_no_stamps)
    turned_ns: Integers = field(default_factory=_no_stamps)

    def __add__(self, other: Unfolded) -> Unfolded:
        """Return these readings and those decided after them."""
        return Unfolded(self.kept + other.kept, *(
            np.concatenate((getattr(self, name), getattr(other, name)))
            for name in ('held_ns', 'standing_ns', 'turned_ns')))


class HoldFilter:
    """
    Keep the first reading of each value that a logger repeats, and every other reading.

    Notes
    -----
    Where `HoldSearch` finds a hold, the first reading of each value is kept. If a value lasts
    longer than a hold, the sensor has reported it again, so one reading per hold is kept. No
    reading is dropped elsewhere: a sound sensor with coarse steps repeats values, too, and the
    first reading of each value lies at the edge of a step.

    With a constant number of repeats the delay of the poll is constant, and a skew shows it.
    Otherwise the delay wanders over one poll. Then the stamp of a kept reading is taken from a
    line through the stamps of the last 64. If more than one in eight of these lie more than one
    poll off the line, the sensor itself is uneven, and the stamp stays as it is.

    A reading that does not repeat the one before waits for no decision of its own. A repeated one
    waits until the search has decided, and those after it wait, too.

    References
    ----------
    E.26 of ``docs/diagnostics.md``.

    """

    def __init__(self) -> None:
        self._search = HoldSearch()
        self._waiting = Headings.empty()
        self._repeats = np.empty(0, bool)
        # Number of the oldest reading that waits, and of the first one with its value.
        self._row = self._value_row = 0
        # Whether a hold covers the newest decided reading, and the newest kept one.
        self._held = self._kept_held = False
        # It was decided by a later one.
        self._early = False
        self._line: _PollLine | None = None
        self._kept_ns = NEVER

    def __len__(self) -> int:
        """Return the number of readings that wait."""
        return len(self._waiting)

    @property
    def waiting_ns(self) -> int:
        """Newest stamp that waits; `NEVER` if none does."""
        return int(self._waiting.stamp_ns[-1]) if len(self._waiting) else NEVER

    def take(self, headings: Headings) -> Unfolded:
        """Take readings with increasing stamps; return those that are now decided."""
        if not len(headings):
            return Unfolded(headings)
        repeats = self._search.take(headings)
        if len(self._waiting):
            headings = self._waiting + headings
            repeats = np.concatenate((self._repeats, repeats))
        return self._decide(headings, repeats, end=False)

    def end(self) -> Unfolded:
        """Decide the readings that wait at the end of the stream."""
        if not len(self._waiting):
            return Unfolded(self._waiting)
        return self._decide(self._waiting, self._repeats, end=True)

    def _decide(self, headings: Headings, repeats: np.ndarray, end: bool) -> Unfolded:
        if not (self._held or repeats.any() or self._search.shows_hold):
            return self._keep_all(headings)
        row = self._row + np.arange(len(headings))
        state = self._search.judge(row, headings.stamp_ns)
        waits = state.is_open & repeats & ~state.is_held
        n = len(row) if end or not waits.any() else int(np.argmax(waits))
        self._waiting, self._repeats = headings[n:], repeats[n:]
        if not n:
            return Unfolded(headings[:0])
        self._row += n
        self._search.forget(self._row)
        headings, repeats, row, state = headings[:n], repeats[:n], row[:n], state[:n]
        value_row = np.maximum.accumulate(np.where(repeats, self._value_row, row))
        self._value_row = int(value_row[-1])
        is_held = self._begin_at_repeats(state.is_held, state.until_row > 0, repeats)
        if not self._held and not is_held.any():
            return self._leave_hold(headings)
        over = row - value_row - state.longest
        again = (over >= 0) & (np.floor(over / state.usual) > np.floor((over - 1) / state.usual))
        stays = ~is_held | ~repeats | again
        stamp_ns = self._rise(self._smooth(headings.stamp_ns, stays & is_held, stays & ~repeats,
                                           is_held, row, state)[stays])
        self._held = bool(is_held[-1])
        held = is_held[stays]
        turned = stamp_ns[np.diff(held, prepend=self._kept_held)]
        if len(held):
            self._kept_held = bool(held[-1])
        return Unfolded(Headings(stamp_ns, headings.heading_deg[stays]),
                        headings.stamp_ns[~stays], stamp_ns[held], turned)

    def _keep_all(self, headings: Headings) -> Unfolded:
        """Decide readings of which none repeats a value, while no hold is known."""
        self._waiting, self._repeats = headings[:0], np.empty(0, bool)
        self._row += len(headings)
        self._search.forget(self._row)
        self._value_row = self._row - 1
        self._early = False
        return self._leave_hold(headings)

    def _leave_hold(self, headings: Headings) -> Unfolded:
        self._kept_ns = int(headings.stamp_ns[-1])
        turned = headings.stamp_ns[:1] if self._kept_held else _NONE
        self._kept_held = False
        return Unfolded(headings, turned_ns=turned)

    def _begin_at_repeats(self, is_held: np.ndarray, is_early: np.ndarray,
                          repeats: np.ndarray) -> np.ndarray:
        """
        Return the held readings without those that came before the first one that waited.

        They were kept before the hold was known, if the stream came reading by reading.
        """
        begins = np.flatnonzero(np.diff(is_early, prepend=self._early) & is_early)
        if len(begins):
            is_held = is_held.copy()
        for begin in begins.tolist():
            waited = repeats[begin:] | ~is_early[begin:]
            end = begin + int(np.argmax(waited)) if waited.any() else len(is_held)
            is_held[begin:end] = False
        self._early = bool(is_early[-1] and is_held[-1])
        return is_held

    def _smooth(self, stamp_ns: Integers, chosen: np.ndarray, first: np.ndarray,
                is_held: np.ndarray, row: Integers, state: Held) -> Integers:
        """Return the stamps; those that are chosen lie on a line where the delay is uneven."""
        stamp_ns = stamp_ns.copy()
        uneven = is_held & (state.period == 0)
        edges = np.flatnonzero(np.diff(uneven, prepend=False, append=False)).tolist()
        for begin, end in zip(edges[::2], edges[1::2]):
            until_row = 0
            if begin > 0 or self._line is None:
                self._line, until_row = _PollLine(), int(state.until_row[begin])
            at = begin + np.flatnonzero(chosen[begin:end])
            stamp_ns[at] = self._line.take(stamp_ns[at], first[at], row[at] < until_row,
                                           state.poll_ns[at], state.usual[at])
        if not uneven[-1]:
            self._line = None
        return stamp_ns

    def _rise(self, stamp_ns: Integers) -> Integers:
        """Return stamps that increase, the few that do not moved by a nanosecond."""
        if len(stamp_ns):
            nth = np.arange(len(stamp_ns))
            stamp_ns = np.maximum(np.maximum.accumulate(stamp_ns - nth), self._kept_ns + 1) + nth
            self._kept_ns = int(stamp_ns[-1])
        return stamp_ns


class _PollLine:
    """The line through the stamps of the newest held values, in holds since the first."""

    def __init__(self) -> None:
        self._origin_ns: int | None = None
        self._count = np.empty(0)
        self._late_ns = np.empty(0)
        self._step = -1.0

    def take(self, stamp_ns: Integers, is_first: np.ndarray, is_early: np.ndarray,
             poll_ns: np.ndarray, usual: np.ndarray) -> Integers:
        """
        Return stamps on the line.

        Those that are early came before the hold was known, so they share one line.
        """
        if not len(stamp_ns):
            return stamp_ns
        if self._origin_ns is None:
            self._origin_ns = int(stamp_ns[0])
        late_ns = (stamp_ns - self._origin_ns).astype(np.float64)
        hold_ns = poll_ns * usual
        placed_ns = stamp_ns.copy()
        together: list[tuple[int, float]] = []
        for at in range(len(stamp_ns)):
            # A value that lasts is reported again a hold later.
            step = self._step + 1.0
            if is_first[at] and len(self._count):
                step = self._count[-1] + np.rint((late_ns[at] - self._late_ns[-1]) / hold_ns[at])
            self._step = step
            if is_first[at]:
                self._count = np.append(self._count, step)
                self._late_ns = np.append(self._late_ns, late_ns[at])
            if is_early[at]:
                together.append((at, step))
            else:
                self._count, self._late_ns = self._count[-_LINE:], self._late_ns[-_LINE:]
                self._place(placed_ns, [(at, step)], poll_ns[at])
            if together and (at + 1 == len(stamp_ns) or not is_early[at + 1]):
                self._place(placed_ns, together, poll_ns[at])
                together = []
        return placed_ns

    def _place(self, placed_ns: Integers, places: list[tuple[int, float]], poll_ns: float) -> None:
        """Put stamps on the line through the newest stamps, unless these are too uneven."""
        assert self._origin_ns is not None
        count, late_ns = self._count, self._late_ns
        for _ in range(2):
            if len(count) < _LEAST_LINE:
                return
            middle, mean_ns = count.mean(), late_ns.mean()
            off = count - middle
            slope = float(off @ (late_ns - mean_ns)) / float(off @ off)
            is_near = np.abs(late_ns - mean_ns - slope * off) <= poll_ns
            if is_near.all():
                for at, step in places:
                    placed_ns[at] = self._origin_ns + round(mean_ns + slope * (step - middle))
                return
            if 8 * np.count_nonzero(~is_near) > len(count):
                return
            count, late_ns = count[is_near], late_ns[is_near]
