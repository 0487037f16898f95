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

"""The readings of one sensor that wait for a partner, and how each one was used."""

from __future__ import annotations

from collections import deque

import numpy as np

from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.raw_streams.decimal_steps import StepCount
from heading_intercompare.core.raw_streams.held_values import HoldFilter, Unfolded
from heading_intercompare.core.raw_streams.stamp_jumps import Decided, JumpFilter, NEVER, SetBack
from heading_intercompare.core.records import Headings, Losses

from .direction import UsualSteps
from .ledger import Ledger, LedgerKey

UNBRIDGED, BRACKET, PAIRED = 1, 2, 3
"""How a reading was used: 0 is not at all; use in a pair outranks use in a bracket."""

#: Readings without a pair are remembered for this long, for the next segment; it begins with those
#: up to this time before the step.
_REMEMBERED_NS, _BEFORE_STEP_NS = 30 * 10 ** 9, 5 * 10 ** 9
_KEYS = {'ts': (LedgerKey.TS_UNPAIRED, LedgerKey.TS_UNBRIDGED, LedgerKey.TS_USED,
                LedgerKey.TS_PAIRED),
         'rs': (LedgerKey.RS_UNUSED, LedgerKey.RS_UNBRIDGED, LedgerKey.RS_USED,
                LedgerKey.RS_USED)}


class Stream:
    """
    The accepted readings of one sensor that may still be needed, with arrival times.

    Readings whose stamps jump wait until later stamps decide, see `JumpFilter`. Those that repeat
    a value wait until it is decided whether a logger holds it, see `HoldFilter`.

    Attributes
    ----------
    turned_ns : ndarray of int64
        Stamps of the first readings, of those accepted last, after a hold has begun or ended.
    accepted : Headings
        The readings that were accepted last.
    set_back : SetBack or None
        The clock of the sensor was set back.
    after : Headings
        The readings since then, which wait for the next segment.

    """

    def __init__(self, name: str, shift_ns: int, jump_s: float, ledger: Ledger,
                 steps: UsualSteps) -> None:
        self.name = name
        self.shift_ns = shift_ns
        self.ledger = ledger
        self.steps = steps
        self.last_ns = NEVER
        self.stamp_ns = np.empty(0, np.int64)
        self.heading_deg = np.empty(0)
        self.came_s = np.empty(0)
        self.role = np.empty(0, np.uint8)
        self.broken = np.empty(0, bool)
        self._lost = False
        self._jumps = JumpFilter(name, jump_s, Headings.empty())
        self._holds = HoldFilter()
        self._changes = StepCount()
        self.turned_ns = np.empty(0, np.int64)
        self.accepted = Headings.empty()
        self._heard_s = -np.inf
        self.heard_ns: int | None = None
        self.set_back: SetBack | None = None
        self.after = Headings.empty()
        self._unused: deque[tuple[LedgerKey, Headings]] = deque()

    def __len__(self) -> int:
        return len(self.stamp_ns)

    def take(self, headings: Headings, now_s: float) -> np.ndarray:
        """Reject unusable readings, keep the rest and return their stamps."""
        stamp: np.ndarray = headings.stamp_ns
        heading = headings.heading_deg
        self.ledger.receive(self.name, stamp)
        self.heard_ns = int(stamp[-1]) - self.shift_ns
        good = self._reject('no_stamp', stamp > 0, self._place_unstamped(stamp, heading))
        good = self._reject('invalid', np.isfinite(heading), stamp, good)
        good = self._reject('out_of_range', (heading >= 0.0) & (heading <= 360.0), stamp, good)
        self._heard_s = now_s
        if not good.all():
            stamp, heading = stamp[good], heading[good]
        return self.take_usable(Headings(stamp - self.shift_ns, heading), now_s)

    def take_usable(self, headings: Headings, now_s: float) -> np.ndarray:
        """Take readings that have a stamp and a value; return the stamps of those kept."""
        if self.set_back is not None:
            self.after += headings
            return np.empty(0, np.int64)
        accepted = self._decide(self._jumps.take(headings))
        return self._keep_first(self._holds.take(accepted), now_s)

    def end(self) -> np.ndarray:
        """Decide what waits at the end of the stream; return the stamps of those kept."""
        decided = self._holds.take(self._decide(self._jumps.end()))
        stamps = self._keep_first(decided + self._holds.end(), np.nan)
        self.ledger.lose(LedgerKey.of_gaps(self.name), *self.steps.end())
        return stamps

    def _decide(self, decided: Decided[Headings]) -> Headings:
        """Count the readings whose stamps are rejected, and return the others."""
        for reason, stamps in (('stamp_not_increasing', decided.late_ns),
                               ('jump', decided.jumped_ns)):
            self.ledger.add(LedgerKey.of_rejected(self.name, reason), stamps)
        if decided.set_back is not None and decided.after is not None:
            self.set_back, self.after = decided.set_back, decided.after
            self.ledger.note_set_back(decided.set_back)
        return decided.accepted

    def _keep_first(self, unfolded: Unfolded, now_s: float) -> np.ndarray:
        """Keep the readings that do not only repeat a held value, and return their stamps."""
        self.ledger.add(LedgerKey.of_held(self.name), unfolded.held_ns)
        self.ledger.add(LedgerKey.of_standing(self.name), unfolded.standing_ns)
        self.accepted, self.turned_ns = unfolded.kept, unfolded.turned_ns
        for step, stamp_ns in self._changes.take(unfolded.kept).items():
            self.ledger.add(LedgerKey.of_step(self.name, step), stamp_ns)
        stamp, heading = unfolded.kept.stamp_ns, unfolded.kept.heading_deg
        if stamp.size:
            self.last_ns = int(stamp[-1])
            self.ledger.lose(LedgerKey.of_gaps(self.name), *self.steps.note(stamp, self.turned_ns))
            self.stamp_ns = np.concatenate((self.stamp_ns, stamp))
            self.heading_deg = np.concatenate((self.heading_deg, wrap360(heading)))
            self.came_s = np.concatenate((self.came_s, np.full(stamp.shape, now_s)))
            self.role = np.concatenate((self.role, np.zeros(stamp.shape, np.uint8)))
            broken = np.zeros(stamp.shape, bool)
            broken[0], self._lost = self._lost, False
            self.broken = np.concatenate((self.broken, broken))
        return stamp

    @property
    def pending(self) -> int:
        """Return how many readings wait for a partner, or for later readings to decide."""
        return len(self) + len(self._jumps) + len(self._holds) + len(self.after)

    def reach_ns(self, since_s: float) -> int:
        """Return the newest stamp, also of readings that wait, if the sensor was heard since."""
        if not self.is_heard(since_s):
            return self.last_ns
        return max(self.last_ns, self._jumps.held_ns, self._holds.waiting_ns)

    def is_heard(self, since_s: float) -> bool:
        """Tell whether the sensor was heard since a time of the steady clock."""
        return self._heard_s >= since_s

    def _place_unstamped(self, stamp: np.ndarray, heading: np.ndarray) -> np.ndarray:
        """Return where to count readings: those without a stamp at the last accepted one."""
        if (stamp > 0).all():
            return stamp
        usable = (stamp > 0) & (heading >= 0.0) & (heading <= 360.0)
        last_ns = self.last_ns if self.last_ns != NEVER else self._jumps.held_ns
        before = np.concatenate(([last_ns], np.where(usable, stamp - self.shift_ns, NEVER)))
        newest = np.maximum.accumulate(before)[:-1]
        return np.where((stamp > 0) | (newest == NEVER), stamp, newest + self.shift_ns)

    def _reject(self, reason: str, passes: np.ndarray, stamp: np.ndarray,
                among: np.ndarray | None = None) -> np.ndarray:
        fails = ~passes if among is None else among & ~passes
        if fails.any():
            self.ledger.add(LedgerKey.of_rejected(self.name, reason), stamp[fails] - self.shift_ns)
        return passes if among is None else among & passes

    def lose(self, key: LedgerKey, losses: Losses, run_gap_ns: int) -> None:
        """Count readings that were lost, each gap where the run is in which it happened."""
        stamp_ns: np.ndarray = losses.stamp_ns
        gap_ns = np.where(losses.since_ns > 0, stamp_ns - losses.since_ns, 0)
        # A gap that ends a run belongs to neither that run nor the next.
        at_ns = np.where(gap_ns > run_gap_ns, stamp_ns - gap_ns // 2, stamp_ns)
        self.ledger.lose(key, at_ns - self.shift_ns, losses.count)

    def release(self, n: int) -> np.ndarray:
        """Record and drop the n oldest readings; return their stamps."""
        stamps = self._book(slice(0, n))
        self._keep(slice(n, None))
        return stamps

    def give_up(self, late: np.ndarray) -> np.ndarray:
        """Record and drop consecutive readings that waited too long; no bracket spans them."""
        lo, hi = int(late[0]), int(late[-1]) + 1
        stamps = self._book(slice(lo, hi))
        if hi < len(self):
            self.broken[hi] = True
        else:
            self._lost = True
        self._keep(np.r_[:lo, hi:len(self)])
        return stamps

    def _book(self, which: slice) -> np.ndarray:
        stamps, role = self.stamp_ns[which], self.role[which]
        for number, key in enumerate(_KEYS[self.name]):
            booked = role == number
            self.ledger.add(key, stamps[booked])
            if number < BRACKET and booked.any():
                self._remember(key, Headings(stamps[booked], self.heading_deg[which][booked]))
        return stamps

    def _remember(self, key: LedgerKey, unused: Headings) -> None:
        """Remember readings without a pair: the next segment may begin with them."""
        oldest_ns = self.last_ns - _REMEMBERED_NS
        while self._unused and self._unused[0][1].stamp_ns[-1] < oldest_ns:
            self._unused.popleft()
        unused = unused[int(np.searchsorted(unused.stamp_ns, oldest_ns)):]
        if len(unused):
            self._unused.append((key, unused))

    def take_back(self, partner: Stream) -> Headings:
        """
        Return what the next segment begins with, after the clock of the `partner` was set back.

        These are the readings without a pair that lie where the partner goes on, or after its last
        reading before the step. The ledger no longer counts them in this segment.
        """
        assert partner.set_back is not None
        end_ns, begin_ns = partner.set_back.stamp_ns, int(partner.after.stamp_ns[0])
        rows = []
        for key, unused in self._unused:
            stamps = unused.stamp_ns
            goes_over = (stamps > end_ns) | (stamps >= begin_ns - _BEFORE_STEP_NS) & (
                np.abs(stamps - begin_ns) < np.abs(stamps - end_ns))
            self.ledger.take_back(key, stamps[goes_over])
            rows.append(unused[goes_over])
        self._unused.clear()
        headings = Headings.concatenate(rows)
        return headings[np.argsort(headings.stamp_ns, kind='stable')]

    def release_back(self) -> Headings:
        """Give up the readings held far before the newest accepted one, and return them."""
        return self._jumps.release_back()

    @property
    def may_step(self) -> bool:
        """Whether the clock was set back, or may have been."""
        return self.set_back is not None or self._jumps.holds_back

    def has_passed(self, partner: Stream) -> bool:
        """Tell whether all has come that belongs before a step of the partner's clock."""
        assert partner.set_back is not None
        end_ns, begin_ns = partner.set_back.stamp_ns, int(partner.after.stamp_ns[0])
        newest_ns = self.reach_ns(-np.inf)
        if newest_ns == NEVER or self._jumps.holds_back:
            return False
        nearest_ns = min((begin_ns, end_ns), key=lambda stamp_ns: abs(newest_ns - stamp_ns))
        return newest_ns >= nearest_ns + _BEFORE_STEP_NS

    def go_on_from(self, before: Stream) -> None:
        """Go on in the next segment, where the sensor was heard as before."""
        self.heard_ns, self._heard_s = before.heard_ns, before._heard_s

    def _keep(self, which: slice | np.ndarray) -> None:
        self.stamp_ns = self.stamp_ns[which]
        self.heading_deg = self.heading_deg[which]
        self.came_s = self.came_s[which]
        self.role = self.role[which]
        self.broken = self.broken[which]
