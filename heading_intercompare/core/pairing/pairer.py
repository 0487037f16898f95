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
Pairing of TS with RS readings by stamp, with every reading accounted for.

The pairs depend only on the two streams, not on how they are cut into chunks or which stream runs
ahead. Only the waiting limit of a live clock can change that, and its effects are counted.
"""

from __future__ import annotations

from typing import Callable, Sequence

import numpy as np

from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.raw_streams.sequence_match import Matched, SequenceMatch
from heading_intercompare.core.raw_streams.stamp_jumps import NEVER
from heading_intercompare.core.records import Headings, Losses, Pairs
from heading_intercompare.core.settings import Settings, SILENCE_STEPS

from .arrival_order import divide_by_arrival
from .direction import Direction, UsualSteps
from .interpolation_kernel import Bridged, find_left, interpolate, longest_step_ns, reach
from .ledger import APART_DEG2, Ledger, LedgerKey
from .pending_readings import BRACKET, PAIRED, Stream, UNBRIDGED

_Rows = np.ndarray | slice
_BRIDGED = {4: LedgerKey.BRIDGED_8, 3: LedgerKey.BRIDGED_6, 2: LedgerKey.BRIDGED_4,
            1: LedgerKey.BRIDGED_2}
_APART = (LedgerKey.APART_6, LedgerKey.APART_4, LedgerKey.APART_2)
#: A larger distance of two values counts as this one, so that sums stay within 64 bits.
_FARTHEST_DEG2 = 100.0
#: A kernel begins with up to four readings before the stamp.
_BEFORE = 4
_NO_LIMIT = 1 << 62
#: What a chunk of no more readings leaves without a pair is remembered anyway.
_FEW = 64
#: Beside `pairing.max_wait_s`, how long a step of one clock waits to show in the other.
_STEP_WAIT_S = 5.0
#: A sensor that falls silent after one odd stamp says no more about a step.
_LONGEST_STEP_S = 30.0
#: The judging node may lag behind the ledger, so this keeps more than a verdict covers.
_SPANS_KEPT = 2


class Pairer:
    """
    Pair two streams of headings as they arrive.

    Parameters
    ----------
    settings
        Uses `pairing`, `alignment.skew_s` (subtracted from the TS stamps) and `runs.gap_s` (after
        such a silence the ledger opens a segment and 'auto' chooses again). The ledger also opens
        a segment where the clock cuts runs.

    Attributes
    ----------
    ledger : Ledger
        The fate of every reading.
    segment : int
        Number of the clock segment, from 0.

    Notes
    -----
    ``interpolate``: interpolates the RS heading on the circle between the RS readings around the
    TS stamp, by up to four on either side, see `interpolation_kernel`. Neighbours of these are at
    most 1.5 usual steps and `pairing.max_gap_s` apart; nothing is extrapolated. A TS stamp equal
    to an RS stamp takes that reading, whatever the gap. A TS reading between two RS readings that
    are too far apart is unbridged; in a silence of the RS it is unpaired. With the `kernel`
    ``line`` two readings are enough.
    ``interpolate_ts``: the same with TS and RS exchanged, so the pairs have the RS stamps.
    ``auto``: chooses one of these for each stretch of the streams, see `direction.Direction`;
    until then the readings wait and count as pending.
    ``nearest``: pairs a TS and an RS reading if each is the nearest to the other (ties go to the
    earlier one) and they are at most `pairing.tolerance_s` apart.

    A reading whose stamp does not increase within its stream is rejected; the first is kept. One
    whose stamp jumps waits until later stamps decide (`stamp_jumps.JumpFilter`), and counts as
    pending. So does one that repeats a value, while the stream looks as if a logger held it; of a
    held value only the first reading is paired (`raw_streams.held_values.HoldFilter`).

    Where a clock was set back, both streams end, and a clock segment begins. It begins with the
    readings after the step, and with those of the other sensor that no pair has used and that lie
    there. No pair spans the step.

    """

    def __init__(self, settings: Settings) -> None:
        rule = settings.pairing
        self.ledger, self.segment = Ledger(), 0
        self._settings = settings
        self._method = rule.method
        self._max_gap_ns = _NO_LIMIT if rule.max_gap_s == 'auto' else round(
            rule.longest_gap_s * 1e9)
        self._is_line = rule.kernel == 'line'
        self._jump_ns = round(rule.jump_s * 1e9)
        self._tolerance_ns = round(rule.tolerance_s * 1e9)
        self._max_wait_s = rule.max_wait_s
        self._longest_wait_s = rule.longest_wait_s
        self._max_wait_ns = round(rule.max_wait_s * 1e9)
        self._run_gap_ns = round(settings.runs.gap_s * 1e9)
        self._clock = settings.runs.clock_cuts()
        self._begin()

    def _begin(self) -> None:
        """Begin a clock segment."""
        rule, alignment = self._settings.pairing, self._settings.alignment
        silence_ns = max(self._run_gap_ns, round(rule.longest_gap_s * 1e9))
        self._ts, self._rs = (
            Stream(name, round(skew_s * 1e9), rule.jump_s, self.ledger,
                   UsualSteps(silence_ns, round(rule.auto_s * 1e9)))
            for name, skew_s in (('ts', alignment.skew_s), ('rs', 0.0)))
        self._direction = Direction(rule, self._run_gap_ns) if rule.method == 'auto' else None
        self._sequences = SequenceMatch(alignment.skew_range_s)
        self._at, self._of = self._ts, self._rs
        if rule.method == 'interpolate_ts':
            self._at, self._of = self._rs, self._ts
        self._last_settled_ns = NEVER
        self._last_pair_ns: int | None = None
        self._set_back_s: float | None = None
        self._may_step_since_s = -np.inf

    def update(self, ts: Headings | None = None, rs: Headings | None = None,
               now_s: float | None = None) -> Pairs:
        """
        Take readings and return the pairs that are now decided.

        Parameters
        ----------
        ts, rs
            New readings, in order of arrival; n >= 0 of each.
        now_s
            A steady clock, seconds. With it a reading waits for its partner until the longer of
            `pairing.silent_wait_s` and `pairing.max_wait_s` has passed by this clock, and the
            latter by the stamps of newer readings; then it counts as unpaired or unused. So it
            waits for a sensor that is silent, and for one that lags, equally long. While nothing
            arrives, as in a paused replay, it keeps waiting. Without a clock, no reading expires.

        Returns
        -------
        Pairs
            In stamp order within a segment, also across calls.

        """
        headings = [Headings.empty() if chunk is None else chunk for chunk in (ts, rs)]
        streams = self._ts, self._rs
        if not any(map(self._may_step_back, streams, headings)):
            return self._update(headings, now_s)
        parts = divide_by_arrival(
            headings[0], headings[1], self._jump_ns,
            together=all(stream.last_ns != NEVER for stream in streams))
        return Pairs.concatenate([self._update(part, now_s) for part in parts])

    def _update(self, headings: Sequence[Headings], now_s: float | None) -> Pairs:
        came_s = np.nan if now_s is None else now_s
        for stream, chunk in zip((self._ts, self._rs), headings):
            if len(chunk):
                self._note(stream, stream.take(chunk, came_s))
        pairs = self._decide(now_s)
        while self._may_open_segment(now_s):
            pairs += self._open_segment(came_s) + self._decide(now_s)
        return pairs

    def _decide(self, now_s: float | None) -> Pairs:
        """Return the pairs that are decided; drop the readings that waited too long."""
        self._compare(self._sequences.take)
        pairs = self._pair(end=False)
        if now_s is not None:
            self._expire(now_s)
        self._forget()
        return pairs

    def _may_step_back(self, stream: Stream, headings: Headings) -> bool:
        """Tell whether the stamps of a long chunk go back by more than the bound of a jump."""
        stamps, jump_ns = headings.stamp_ns, self._jump_ns
        return len(stamps) > _FEW and bool(
            (stamps[1:] - stamps[:-1]).min() < -jump_ns
            or stamps[0] - stream.shift_ns < stream.last_ns - jump_ns)

    def _may_open_segment(self, now_s: float | None) -> bool:
        """Tell whether a clock was set back, and the other sensor has come as far."""
        if self._ts.set_back is None and self._rs.set_back is None:
            return False
        if (self._ts.set_back is not None and self._rs.set_back is not None
                or self._list_passed()):
            return True
        if now_s is None:
            return False
        self._set_back_s = now_s if self._set_back_s is None else self._set_back_s
        # A sensor that is heard lags, and has not come as far.
        lags = any(stream.set_back is None and stream.is_heard(now_s - self._max_wait_s)
                   for stream in (self._ts, self._rs))
        wait_s = self._longest_wait_s if lags else self._max_wait_s
        return now_s > self._set_back_s + wait_s + _STEP_WAIT_S

    def _list_passed(self) -> list[Stream]:
        """Return the streams whose clock was set back while the other one went on."""
        return [stream for stream, partner in ((self._ts, self._rs), (self._rs, self._ts))
                if stream.set_back is not None and partner.has_passed(stream)]

    def _open_segment(self, came_s: float) -> Pairs:
        """End both streams where a clock was set back, and begin again; return the last pairs."""
        before = self._ts, self._rs
        back = [stream.release_back() for stream in before]
        pairs = self._end_streams()
        first = []
        for stream, partner, held in zip(before, reversed(before), back):
            goes_over = Headings.empty() if partner.set_back is None or (
                stream.set_back is not None) else stream.take_back(partner)
            first.append(goes_over + held + stream.after)
        for stream in before:
            self.ledger.set_pending(stream.name, 0)
        self.ledger.open_clock_segment()
        self.segment += 1
        self._begin()
        for stream, headings, earlier in zip((self._ts, self._rs), first, before):
            stream.go_on_from(earlier)
            if len(headings):
                self._note(stream, stream.take_usable(headings, came_s))
        return pairs

    @property
    def heard_ns(self) -> tuple[int | None, int | None]:
        """Stamps of the last readings of the TS and of the RS; None before the first."""
        return self._ts.heard_ns, self._rs.heard_ns

    @property
    def choosing(self) -> bool:
        """Whether readings of both wait until it is chosen which sensor is interpolated."""
        return (self._direction is not None and self._direction.interpolates_ts is None
                and min(len(self._ts), len(self._rs)) > 0)

    def lose(self, key: LedgerKey, losses: Losses) -> None:
        """
        Count readings that never came; they may be told before or after the readings around them.

        Parameters
        ----------
        key
            Whose readings, and where they were lost; or a rejection by the driver.
        losses
            How many are missing in each gap. They count at the stamp of the first reading after
            the gap, unless the gap is so long that it ends a run: then they count in its middle,
            between the runs.

        """
        if not len(losses):
            return
        stream = self._ts if key.stream == 'ts' else self._rs
        stream.lose(key, losses, self._run_gap_ns)

    def flush(self) -> Pairs:
        """End both streams: decide all waiting readings and return the last pairs."""
        pairs = Pairs.empty()
        while self._ts.set_back is not None or self._rs.set_back is not None:
            pairs += self._open_segment(np.nan) + self._decide(None)
        return pairs + self._end_streams()

    def _end_streams(self) -> Pairs:
        """Decide all waiting readings of this segment and return its last pairs."""
        for stream in (self._ts, self._rs):
            self._note(stream, stream.end())
        self._compare(self._sequences.take)
        self._compare(lambda ts, rs: self._sequences.end())
        pairs = self._pair(end=True)
        for stream in (self._ts, self._rs):
            stream.release(len(stream))
        if self._last_pair_ns is not None:
            self.ledger.cut(self._last_pair_ns + 1)
        self._forget()
        return pairs

    def _compare(self, compare: Callable[[Headings, Headings], Matched]) -> None:
        """Count the changes of value that are compared by now, and those that differ."""
        matched = compare(self._ts.accepted, self._rs.accepted)
        for stream in (self._ts, self._rs):
            stream.accepted = Headings.empty()
        self.ledger.add(LedgerKey.CHANGES_COMPARED, matched.compared_ns)
        self.ledger.add(LedgerKey.CHANGES_DIFFERING, matched.differing_ns)

    def _note(self, stream: Stream, stamp_ns: np.ndarray) -> None:
        if self._direction and len(stamp_ns):
            self._direction.note(stream.name, stamp_ns, stream.turned_ns)

    def _pair(self, end: bool) -> Pairs:
        """Return the pairs that are decided, stretch by stretch."""
        if self._method == 'nearest':
            return self._settle(*self._nearest(end))
        settled = []
        while self._choose(end):
            settled.append(self._settle(*self._interpolate(end)))
            direction = self._direction
            limit_ns = direction.limit_ns if direction else None
            if direction is None or limit_ns is None or not (end or direction.has_heard(limit_ns)):
                break
            if len(self._at) and self._at.stamp_ns[0] < limit_ns:
                # Readings of the next stretch may still change the last pairs of this stretch.
                break
            direction.leave()
        return Pairs.concatenate(settled)

    def _choose(self, end: bool) -> bool:
        """Choose the sensor to interpolate if possible; tell whether it is chosen."""
        choice = self._direction
        if choice is None or choice.interpolates_ts is not None:
            return True
        if not choice.choose(end):
            return False
        at, of = (self._rs, self._ts) if choice.interpolates_ts else (self._ts, self._rs)
        if at is not self._at:
            self._at, self._of = at, of
            if self._last_settled_ns != NEVER and choice.start_ns is not None:
                # Both sensors drop their earlier readings: no bracket spans the change.
                for stream in (at, of):
                    stream.release(int(np.searchsorted(stream.stamp_ns, choice.start_ns)))
        return True

    def _interpolate(self, end: bool) -> tuple[int, _Rows, Pairs]:
        """Return the number of decided readings, the indices of those in pairs, and the pairs."""
        at, of = self._at, self._of
        ready, n = len(at), len(of)
        if self._direction and self._direction.limit_ns is not None:
            ready = int(np.searchsorted(at.stamp_ns, self._direction.limit_ns))
        if not end:
            ready = min(ready, int(np.searchsorted(at.stamp_ns, of.last_ns, side='right')))
        if ready == 0 or n == 0:
            return ready, np.empty(0, np.int64), Pairs.empty()
        t = at.stamp_ns[:ready]
        left = find_left(of.stamp_ns, t)
        is_node = of.stamp_ns[left] == t
        stretches = self._find_stretches(of)
        if not end:
            is_open = ~is_node & (left > self._last_decided(of, *stretches[-1]))
            if is_open.any():
                ready = int(np.argmax(is_open))
                t, left, is_node = t[:ready], left[:ready], is_node[:ready]
        of_deg, factor = of.heading_deg[left], np.ones(ready)
        has_pair = is_node & (left >= 0)
        of.role[left[has_pair]] = PAIRED
        for first, stop, step_ns in stretches:
            between = ~is_node & (left >= first) & (left < stop - 1)
            if step_ns and between.any():
                which: _Rows = slice(None) if between.all() else np.flatnonzero(between)
                bridged = self._bridge(of, slice(first, stop), step_ns, left[which], t[which],
                                       at.role[:ready], which)
                of_deg[which], factor[which] = bridged.heading_deg, bridged.factor
                has_pair[which] = bridged.side > 0
        paired: _Rows = slice(ready) if has_pair.all() else np.flatnonzero(has_pair)
        t, of_deg, factor = t[paired], wrap360(of_deg[paired]), factor[paired]
        at_deg, lag_ns = at.heading_deg[:ready][paired], np.zeros(t.shape, np.int64)
        ones, segment = np.ones(t.shape), np.full(t.shape, self.segment)
        if at is self._ts:
            return ready, paired, Pairs(t, at_deg, of_deg, lag_ns, factor, ones, segment)
        return ready, paired, Pairs(t, of_deg, at_deg, lag_ns, ones, factor, segment)

    def _find_stretches(self, of: Stream) -> list[tuple[int, int, int | None]]:
        """Return the first reading, the end and the usual step of the stretches of a stream."""
        starts_ns, steps_ns = zip(*of.steps.stretches(int(of.stamp_ns[0])))
        firsts = [0, *np.searchsorted(of.stamp_ns, starts_ns[1:]).tolist()]
        return [*zip(firsts, [*firsts[1:], len(of)], steps_ns)]

    def _find_good(self, of: Stream, part: slice, step_ns: int) -> np.ndarray:
        """Tell of each step of a stretch whether a kernel may bridge it."""
        longest_ns = min(longest_step_ns(step_ns), self._max_gap_ns)
        steps_ns = np.diff(of.stamp_ns[part])
        return np.asarray((steps_ns <= longest_ns) & ~of.broken[part][1:])

    def _last_decided(self, of: Stream, first: int, stop: int, step_ns: int | None) -> int:
        """Return the last reading after which no later reading changes a kernel."""
        if step_ns is None:
            return first - 1
        bad = np.flatnonzero(~self._find_good(of, slice(first, stop), step_ns))
        return max(first - 1, stop - 1 - reach(step_ns), first + int(bad[-1]) if bad.size else -1)

    def _bridge(self, of: Stream, part: slice, step_ns: int, left: np.ndarray, t: np.ndarray,
                role: np.ndarray, which: _Rows) -> Bridged:
        """Interpolate within a stretch; note the use of the readings, and how far kernels part."""
        inside = left - part.start
        interpolated = interpolate(of.stamp_ns[part], of.heading_deg[part],
                                   self._find_good(of, part, step_ns), inside, t, step_ns,
                                   is_line=self._is_line)
        side = interpolated.side.astype(np.int64)
        n = part.stop - part.start
        used = np.cumsum(np.bincount(inside + 1 - side, minlength=n + 1)
                         - np.bincount(inside + 1 + side, minlength=n + 1))[:n] > 0
        np.maximum(of.role[part], np.where(used, BRACKET, 0).astype(np.uint8), out=of.role[part])
        gap_ns = of.stamp_ns[left + 1] - of.stamp_ns[left]
        missed = (side == 0) & (gap_ns <= SILENCE_STEPS * step_ns)
        if missed.any():
            role[which] = np.where(missed, UNBRIDGED, role[which])
        for number, key in _BRIDGED.items():
            self.ledger.add(key, t[side == number])
        bridged = t if side.all() else t[side > 0]
        self.ledger.lose(LedgerKey.STEP, bridged, np.full(bridged.shape, step_ns // 1000))
        compared = t[interpolated.compared]
        self.ledger.add(LedgerKey.COMPARED, compared)
        squares = np.minimum(interpolated.apart_deg2, _FARTHEST_DEG2) / APART_DEG2
        for key, column in zip(_APART, np.rint(squares).astype(np.int64).T):
            self.ledger.lose(key, compared, column)
        return interpolated

    def _nearest(self, end: bool) -> tuple[int, np.ndarray, Pairs]:
        """Return the number of decided TS readings, the indices of those paired, and the pairs."""
        ts, rs = self._ts, self._rs
        t, r = ts.stamp_ns, rs.stamp_ns
        if len(t) == 0 or len(r) == 0:
            return (len(t) if end else 0), np.empty(0, np.int64), Pairs.empty()
        partner, closed = _nearest_index(r, t)
        rivals = np.concatenate(([self._last_settled_ns], t)) \
            if self._last_settled_ns != NEVER else t
        offset = len(rivals) - len(t)
        nearest_rival, heard = _nearest_index(rivals, r[partner])
        decided = closed & heard
        ready = len(t) if end or decided.all() else int(np.argmin(decided))
        lag = r[partner] - t
        good = (nearest_rival == np.arange(len(t)) + offset) & (np.abs(lag) <= self._tolerance_ns)
        which = np.flatnonzero(good[:ready])
        rs.role[partner[which]] = PAIRED
        pairs = Pairs.of(t[which], ts.heading_deg[which], rs.heading_deg[partner[which]],
                         lag[which], segment=self.segment)
        return ready, which, pairs

    def _settle(self, ready: int, which: _Rows, pairs: Pairs) -> Pairs:
        """Record the decided readings; cut the ledger where pairs begin and where they pause."""
        if ready == 0:
            return pairs
        self._at.role[which] = PAIRED
        self._last_settled_ns = int(self._at.release(ready)[-1])
        if len(pairs):
            self.ledger.add(LedgerKey.PAIRED, pairs.stamp_ns)
            first = int(pairs.stamp_ns[0])
            if self._last_pair_ns is None:
                self.ledger.cut(first)
                self._last_pair_ns = first
            before = np.concatenate(([self._last_pair_ns], pairs.stamp_ns[:-1]))
            for at in np.flatnonzero(pairs.stamp_ns - before > self._run_gap_ns):
                self.ledger.cut(int(before[at]) + 1)
                self.ledger.cut(int(pairs.stamp_ns[at]))
            for at in self._clock.find_crossed(pairs.stamp_ns, self._last_pair_ns):
                # The run before ends at the first such cut, and the run after begins at the last.
                self.ledger.cut(self._clock.next(int(before[at])))
                self.ledger.cut(self._clock.last(int(pairs.stamp_ns[at])))
            self._last_pair_ns = int(pairs.stamp_ns[-1])
        return pairs

    def _expire(self, now_s: float) -> None:
        """Drop readings that waited too long by the steady clock and are old by stamp."""
        if not (self._ts.may_step or self._rs.may_step):
            self._may_step_since_s = now_s
        elif now_s < self._may_step_since_s + _LONGEST_STEP_S:
            # What waits now may belong on either side of the step.
            return
        # A slow sensor is not late before its next reading is due.
        max_wait_ns = max(self._max_wait_ns, 2 * self._ts.steps.newest_ns,
                          2 * self._rs.steps.newest_ns)
        max_wait_s = max_wait_ns / 1e9
        before_ns = max(self._ts.last_ns, self._rs.last_ns) - max_wait_ns
        before_s = now_s - max(self._longest_wait_s, max_wait_s)
        is_open = self._direction is not None and self._direction.interpolates_ts is None
        for stream, partner in ((self._ts, self._rs), (self._rs, self._ts)):
            late = (stream.came_s < before_s) & (stream.stamp_ns <= before_ns)
            if self._method != 'nearest' or stream is self._rs:
                # Readings up to the newest one of the other sensor wait only for a choice or for
                # a held stamp, and so does the reading that closes the last bracket.
                reach_ns = partner.reach_ns(now_s - max_wait_s)
                come = int(np.searchsorted(stream.stamp_ns, reach_ns, side='right'))
                late[:come + 1 if is_open and come else come] = False
            given_up = np.flatnonzero(late)
            if given_up.size:
                if self._direction:
                    self._direction.forget()
                first = int(given_up[0]) == 0
                stamps = stream.give_up(given_up)
                if stream is self._at and first:
                    self._last_settled_ns = int(stamps[-1])

    def _forget(self) -> None:
        """Release readings that can only be brackets, but no longer of any future reading."""
        at, of = self._at, self._of
        if self._direction is None or self._direction.interpolates_ts is not None:
            oldest = int(at.stamp_ns[0]) if len(at) else at.last_ns
            limit_ns = self._direction.limit_ns if self._direction else None
            if limit_ns is not None:
                oldest = min(oldest, limit_ns)
            before = 1 if self._method == 'nearest' else _BEFORE
            of.release(max(0, int(np.searchsorted(of.stamp_ns, oldest, side='right')) - before))
        for stream in (self._ts, self._rs):
            self.ledger.set_pending(stream.name, stream.pending)
            if len(stream):
                stream.steps.forget(int(stream.stamp_ns[0]))
        if self._last_settled_ns != NEVER:
            # Readings dropped after the last pair belong to no run: cut before folding them.
            if (self._last_pair_ns is not None
                    and self._last_settled_ns - self._last_pair_ns > self._run_gap_ns):
                self.ledger.cut(self._last_pair_ns + 1)
            if self._clock and self._last_pair_ns is not None:
                for cut_ns in (self._clock.next(self._last_pair_ns),
                               self._clock.last(self._last_settled_ns)):
                    if self._last_pair_ns < cut_ns <= self._last_settled_ns:
                        self.ledger.cut(cut_ns)
            self.ledger.settle(self._last_settled_ns)

    def forget_earlier(self) -> None:
        """Join the segments of the ledger that are too old for a verdict with the first one."""
        if (horizon_ns := self._settings.runs.horizon_ns(
                self._last_pair_ns, spans=_SPANS_KEPT)) is not None:
            self.ledger.forget_before(horizon_ns)


def _nearest_index(among_ns: np.ndarray, of_ns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the index of the nearest stamp (ties to the earlier), and whether that is final."""
    right = np.searchsorted(among_ns, of_ns, side='left')
    closed = right < len(among_ns)
    right = np.minimum(right, len(among_ns) - 1)
    left = np.maximum(right - 1, 0)
    nearer_right = np.abs(among_ns[right] - of_ns) < np.abs(of_ns - among_ns[left])
    return np.where(nearer_right, right, left), closed


def pair(ts: Headings, rs: Headings, settings: Settings | None = None) -> tuple[Pairs, Ledger]:
    """
    Pair two whole streams.

    Parameters
    ----------
    ts, rs
        All readings of the TS and of the RS, in order of arrival.
    settings
        As for `Pairer`.

    Returns
    -------
    pairs : Pairs
        In stamp order.
    ledger : Ledger
        The fate of every reading.

    Examples
    --------
    >>> ts = Headings.as_sent([10, 20, 40], [359.0, 1.0, 3.0])
    >>> rs = Headings.as_sent([5, 25], [358.0, 2.0])
    >>> pairs, ledger = pair(ts, rs)
    >>> pairs.rs_deg.tolist(), ledger.total.counts['ts_unpaired']
    ([359.0, 1.0], 1)

    """
    pairer = Pairer(settings or Settings())
    pairs = pairer.update(ts, rs)
    return Pairs.concatenate((pairs, pairer.flush())), pairer.ledger
