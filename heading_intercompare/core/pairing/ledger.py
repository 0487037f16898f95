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
The account of every reading: paired, unpaired, used, unused, rejected or lost.

The ledger is kept in segments, so that each run can get its own share. A reading belongs to the
last segment that starts at or before its stamp, otherwise to the first. Where a clock is set back
and stamps are repeated, a *clock segment* begins, with segments of its own. Per sensor, the
readings sent are those received and those lost.
"""

from __future__ import annotations

from bisect import insort
from collections import Counter
from dataclasses import dataclass, field, replace
from enum import Enum
from itertools import groupby
from typing import Iterable, Mapping

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.declared_figures import figure, no_key
from heading_intercompare.core.raw_streams.decimal_steps import DECIMAL_STEPS
from heading_intercompare.core.raw_streams.stamp_jumps import SetBack

REASONS = ('invalid', 'out_of_range', 'no_stamp', 'stamp_not_increasing', 'jump', 'burst',
           'repeated', 'old_number')
"""Reasons to reject a reading before pairing; its driver rejects the last three."""

APART_DEG2 = 1e-9
"""Unit of the squared distances between values interpolated in two ways, square degrees."""

LOSSES = ('on_the_way', 'at_source', 'before_start')
"""
Where a reading was lost: from publisher to subscriber, before the driver read it, or because it
was published before the first one that was taken. The last kind lies in no run.
"""


class LedgerKey(str, Enum):
    """
    The possible fates of a reading; topics and bags use the same words.

    `PAIRED` counts pairs. Every other key counts readings of one sensor: in a pair without
    interpolation (`TS_PAIRED`), only used for interpolation (`TS_USED`), either (`RS_USED`),
    neither (`TS_UNPAIRED`, `RS_UNUSED`), repeating a value that a logger holds (`TS_HELD`,
    `RS_HELD`), undecided (`TS_PENDING`, `RS_PENDING`), rejected, or lost. Lost readings are not
    received. `TS_UNBRIDGED` and `RS_UNBRIDGED` also have no pair,
    because a few readings of the other sensor are missing there.

    Other keys: `STANDING` counts values that a logger held, `CHANGES` those of value compared by
    `raw_streams.sequence_match` and those that differ, `TS_STEP` and `RS_STEP` changes of value by
    the coarsest step of which they are multiples, hundredths of a degree. `GAPS` counts usual
    steps without a reading, `BRIDGED` pairs by the readings interpolated, `COMPARED` those
    compared with fewer readings. `STEP` sums up steps, microseconds, `APART` squared distances,
    units of `APART_DEG2`.
    """

    PAIRED = 'paired'
    TS_PAIRED = 'ts_paired'
    TS_USED = 'ts_used'
    TS_UNPAIRED = 'ts_unpaired'
    TS_UNBRIDGED = 'ts_unbridged'
    TS_HELD = 'ts_held'
    TS_PENDING = 'ts_pending'
    TS_INVALID = 'ts_rejected.invalid'
    TS_OUT_OF_RANGE = 'ts_rejected.out_of_range'
    TS_NO_STAMP = 'ts_rejected.no_stamp'
    TS_STAMP_NOT_INCREASING = 'ts_rejected.stamp_not_increasing'
    TS_JUMP = 'ts_rejected.jump'
    TS_BURST = 'ts_rejected.burst'
    TS_REPEATED = 'ts_rejected.repeated'
    TS_OLD_NUMBER = 'ts_rejected.old_number'
    TS_LOST_ON_THE_WAY = 'ts_lost.on_the_way'
    TS_LOST_AT_SOURCE = 'ts_lost.at_source'
    TS_LOST_BEFORE_START = 'ts_lost.before_start'
    RS_USED = 'rs_used'
    RS_UNUSED = 'rs_unused'
    RS_UNBRIDGED = 'rs_unbridged'
    RS_HELD = 'rs_held'
    RS_PENDING = 'rs_pending'
    RS_INVALID = 'rs_rejected.invalid'
    RS_OUT_OF_RANGE = 'rs_rejected.out_of_range'
    RS_NO_STAMP = 'rs_rejected.no_stamp'
    RS_STAMP_NOT_INCREASING = 'rs_rejected.stamp_not_increasing'
    RS_JUMP = 'rs_rejected.jump'
    RS_BURST = 'rs_rejected.burst'
    RS_REPEATED = 'rs_rejected.repeated'
    RS_OLD_NUMBER = 'rs_rejected.old_number'
    RS_LOST_ON_THE_WAY = 'rs_lost.on_the_way'
    RS_LOST_AT_SOURCE = 'rs_lost.at_source'
    RS_LOST_BEFORE_START = 'rs_lost.before_start'
    TS_STANDING = 'standing.ts'
    RS_STANDING = 'standing.rs'
    CHANGES_COMPARED = 'changes.compared'
    CHANGES_DIFFERING = 'changes.differing'
    TS_STEP_100 = 'step.ts.100'
    TS_STEP_50 = 'step.ts.50'
    TS_STEP_25 = 'step.ts.25'
    TS_STEP_20 = 'step.ts.20'
    TS_STEP_10 = 'step.ts.10'
    TS_STEP_5 = 'step.ts.5'
    TS_STEP_4 = 'step.ts.4'
    TS_STEP_2 = 'step.ts.2'
    TS_STEP_1 = 'step.ts.1'
    TS_STEP_0 = 'step.ts.0'
    RS_STEP_100 = 'step.rs.100'
    RS_STEP_50 = 'step.rs.50'
    RS_STEP_25 = 'step.rs.25'
    RS_STEP_20 = 'step.rs.20'
    RS_STEP_10 = 'step.rs.10'
    RS_STEP_5 = 'step.rs.5'
    RS_STEP_4 = 'step.rs.4'
    RS_STEP_2 = 'step.rs.2'
    RS_STEP_1 = 'step.rs.1'
    RS_STEP_0 = 'step.rs.0'
    TS_GAPS = 'gaps.ts'
    RS_GAPS = 'gaps.rs'
    BRIDGED_8 = 'bridged.8'
    BRIDGED_6 = 'bridged.6'
    BRIDGED_4 = 'bridged.4'
    BRIDGED_2 = 'bridged.2'
    STEP = 'bridged.step'
    COMPARED = 'compared'
    APART_6 = 'apart.6'
    APART_4 = 'apart.4'
    APART_2 = 'apart.2'

    def __str__(self) -> str:
        return self.value

    @classmethod
    def of_rejected(cls, stream: str, reason: str) -> 'LedgerKey':
        """
        Return the key of readings of ``'ts'`` or ``'rs'`` rejected for one of `REASONS`.

        Examples
        --------
        >>> print(LedgerKey.of_rejected('ts', 'no_stamp'))
        ts_rejected.no_stamp

        """
        return cls(f'{stream}_rejected.{reason}')

    @classmethod
    def of_pending(cls, stream: str) -> 'LedgerKey':
        """Return the key of readings of ``'ts'`` or ``'rs'`` that still wait for a partner."""
        return cls(f'{stream}_pending')

    @classmethod
    def of_held(cls, stream: str) -> 'LedgerKey':
        """Return the key of readings of ``'ts'`` or ``'rs'`` that only repeat a held value."""
        return cls(f'{stream}_held')

    @classmethod
    def of_standing(cls, stream: str) -> 'LedgerKey':
        """Return the key of the values of ``'ts'`` or ``'rs'`` that were held."""
        return cls(f'standing.{stream}')

    @classmethod
    def of_lost(cls, stream: str, where: str) -> 'LedgerKey':
        """Return the key of readings of ``'ts'`` or ``'rs'`` lost at one of `LOSSES`."""
        return cls(f'{stream}_lost.{where}')

    @classmethod
    def of_step(cls, stream: str, step: int) -> 'LedgerKey':
        """Return the key of changes of ``'ts'`` or ``'rs'`` by a step, hundredths of a degree."""
        return cls(f'step.{stream}.{step}')

    @classmethod
    def of_gaps(cls, stream: str) -> 'LedgerKey':
        """Return the key of the usual steps without a reading of ``'ts'`` or ``'rs'``."""
        return cls(f'gaps.{stream}')

    @classmethod
    def of_told(cls, stream: str, lost_as: str) -> 'LedgerKey':
        """Return the key of what the driver of a sensor tells, such as ``lost.at_source``."""
        return cls(f'{stream}_{lost_as}')

    def of_stream(self, stream: str) -> 'LedgerKey':
        """
        Return the key of the same fate of readings of ``'ts'`` or ``'rs'``.

        Examples
        --------
        >>> print(LedgerKey.TS_LOST_AT_SOURCE.of_stream('rs'))
        rs_lost.at_source

        """
        return LedgerKey(f'{stream}{self.value[2:]}')

    @property
    def stream(self) -> str:
        """Return the sensor of these readings, ``'ts'`` or ``'rs'``; '' for no readings."""
        return self.value[:2] if self.value[:3] in ('ts_', 'rs_') else ''

    @property
    def reason(self) -> str:
        """Reason of a rejection; '' for any other key."""
        return self.value.partition('_rejected.')[2]

    @property
    def lost(self) -> str:
        """Where these readings were lost; '' if they were received."""
        return self.value.partition('_lost.')[2]


@dataclass(frozen=True, slots=True)
class LedgerSegment:
    """
    Counts of the readings from one boundary to the next.

    Attributes
    ----------
    start_ns
        First stamp of the segment; None for the first segment, which has no beginning.
    counts
        Pairs, and readings by fate. An absent key is 0.
    set_backs
        Of the share of a run: the clocks that were set back within it; None otherwise.
    clock_segment
        How often a clock was set back before; None for never.

    """

    start_ns: int | None
    counts: Mapping[LedgerKey, int] = field(default_factory=dict)
    set_backs: tuple[SetBack, ...] | None = no_key()
    clock_segment: int | None = figure('clock segment', absent='before a clock is set back')

    def __post_init__(self) -> None:
        """Turn strings into keys."""
        object.__setattr__(self, 'counts', {LedgerKey(k): n for k, n in self.counts.items()})

    def with_counts_of(self, segment: LedgerSegment) -> LedgerSegment:
        """Return the counts of both, from the start of this one."""
        return replace(self, counts=Counter(self.counts) + Counter(segment.counts),
                       set_backs=(*(self.set_backs or ()), *(segment.set_backs or ())))

    def received(self, stream: str) -> int:
        """Return how many readings of ``'ts'`` or ``'rs'`` came, whatever became of them."""
        return sum(n for key, n in self.counts.items() if key.stream == stream and not key.lost)

    def reported(self, stream: str) -> int:
        """Return how many of the readings that came repeat neither a held value nor a line."""
        return (self.received(stream) - self.counts.get(LedgerKey.of_held(stream), 0)
                - self.rejected(stream).get('repeated', 0))

    def changes(self, stream: str) -> dict[int, int]:
        """Return the changes of value of ``'ts'`` or ``'rs'`` by step, see `StepCount`."""
        return {step: n for step in (*DECIMAL_STEPS, 0)
                if (n := self.counts.get(LedgerKey.of_step(stream, step)))}

    def times_held(self, stream: str) -> float | None:
        """Return for how many readings each held value stands; None if none was held."""
        n = self.counts.get(LedgerKey.of_held(stream), 0)
        values = self.counts.get(LedgerKey.of_standing(stream), 0)
        return 1.0 + n / max(1, values) if n else None

    def rejected(self, stream: str) -> dict[str, int]:
        """Return how many readings of ``'ts'`` or ``'rs'`` were rejected, by reason."""
        return {reason: n for reason in REASONS
                if (n := self.counts.get(LedgerKey.of_rejected(stream, reason)))}

    def refused(self, stream: str) -> dict[str, int]:
        """Return what was rejected, by reason, without lines whose first copy was taken."""
        return {reason: n for reason, n in self.rejected(stream).items() if reason != 'repeated'}

    def lost(self, stream: str) -> dict[str, int]:
        """Return what of ``'ts'`` or ``'rs'`` was lost, by where: at the source datagrams."""
        return {where: n for where in LOSSES
                if (n := self.counts.get(LedgerKey.of_lost(stream, where)))}

    def lost_at_source(self, stream: str) -> int:
        """
        Return how many readings of ``'ts'`` or ``'rs'`` were lost at the source, at most.

        A driver tells datagrams, whatever they held. No more readings can be lost than the gaps of
        the stream have room for, beside those lost on the way.
        """
        lost = self.lost(stream)
        room = self.counts.get(LedgerKey.of_gaps(stream), 0) - lost.get('on_the_way', 0)
        return max(0, min(lost.get('at_source', 0), room))

    @property
    def unbridged(self) -> int:
        """Return how many readings have no pair for a gap of the other sensor around them."""
        return sum(self.counts.get(key, 0)
                   for key in (LedgerKey.TS_UNBRIDGED, LedgerKey.RS_UNBRIDGED))


_END_OF_TIME_NS = np.iinfo(np.int64).max
_PENDING = (LedgerKey.TS_PENDING, LedgerKey.RS_PENDING)

# A cut this far before the newest settled reading still divides exactly.
_SLACK_NS = 60_000_000_000
_MOST_SET_BACKS = 100
#: Batches of losses remembered one by one; at 1 kHz, ten seconds of nothing but losses.
_MOST_GAPS = 10_000
#: Stamps of losses remembered of a key, 16 bytes each; at 1 kHz, eight times the slack.
_MOST_STAMPS = 1_000_000


class Ledger:
    """
    Counts of readings by fate.

    `add` and `lose` count, `cut` opens a segment, and `settle` gives the stamp up to which no
    more readings will come. Up to there the ledger can forget single stamps, so its memory does
    not grow.

    Attributes
    ----------
    newest_ns
        Newest stamp received in this clock segment.
    set_backs : list of SetBack
        The clocks that were set back in this clock segment, at most the first hundred.
    closed : list of Ledger
        The earlier clock segments.

    """

    def __init__(self) -> None:
        self.closed: list[Ledger] = []
        self._received: Counter[str] = Counter()
        self._run_cuts: list[int] = []
        self._begin()

    def _begin(self) -> None:
        self._starts = np.empty(0, np.int64)
        self._bounds: list[int] = []
        self._counts: list[Counter[LedgerKey]] = [Counter()]
        self._total: Counter[LedgerKey] = Counter()
        self._recent: dict[LedgerKey, list[np.ndarray]] = {}
        self._gaps: dict[LedgerKey, list[tuple[np.ndarray, np.ndarray]]] = {}
        self._pending: Counter[LedgerKey] = Counter()
        self.set_backs: list[SetBack] = []
        self.newest_ns: int | None = None

    def open_clock_segment(self) -> None:
        """Close this clock segment, and begin the next."""
        earlier = Ledger.from_segments(self._own_segments, self.newest_ns, self.set_backs)
        self.closed.append(earlier)
        self._begin()
        for stamp_ns in self._run_cuts:
            self.cut(stamp_ns)
            insort(self._bounds, stamp_ns)

    def note_set_back(self, set_back: SetBack) -> None:
        """Note that a clock was set back."""
        if len(self.set_backs) < _MOST_SET_BACKS:
            self.set_backs.append(replace(set_back, clock_segment=len(self.closed)))
            # One step of the clock of both is confirmed for the one or the other first.
            self.set_backs.sort(key=lambda step: step.stream, reverse=True)

    @property
    def clock_segments(self) -> list[Ledger]:
        """Return the ledgers of all clock segments, in order."""
        return [*self.closed, self]

    def receive(self, stream: str, stamp_ns: np.ndarray) -> None:
        """Count readings on arrival, before anything is decided about them."""
        if len(stamp_ns):
            self._received[stream] += len(stamp_ns)
            newest = int(stamp_ns.max())
            if self.newest_ns is None or newest > self.newest_ns:
                self.newest_ns = newest

    def add(self, key: LedgerKey, stamp_ns: np.ndarray) -> None:
        """Count readings under a key; every reading is added exactly once."""
        if len(stamp_ns):
            self._recent.setdefault(key, []).append(stamp_ns)
            self._total[key] += len(stamp_ns)
            if key is LedgerKey.PAIRED:
                self._cut_at_pairs()

    def lose(self, key: LedgerKey, stamp_ns: np.ndarray, n: np.ndarray) -> None:
        """
        Count `n` at each stamp: readings lost, or rejected before they were sent.

        Also what is no count of readings.
        """
        if len(stamp_ns):
            gaps = self._gaps.setdefault(key, [])
            gaps.append((stamp_ns, n))
            n_all = int(n.sum())
            self._total[key] += n_all
            if len(gaps) > _MOST_GAPS:
                self._join_gaps(key)
            if key.stream and not key.lost:
                self._received[key.stream] += n_all

    def _join_gaps(self, key: LedgerKey) -> tuple[np.ndarray, np.ndarray]:
        """Return stamps and counts of a key that later cuts may divide, now in one piece."""
        gaps = self._gaps[key]
        stamp_ns, n = (np.concatenate(column) for column in zip(*gaps))
        if len(stamp_ns) > _MOST_STAMPS:
            # Told for times that never come: later cuts no longer divide them.
            self._fold(self._counts, key, stamp_ns, n)
            stamp_ns, n = stamp_ns[:0], n[:0]
        gaps[:] = [(stamp_ns, n)] if len(n) else []
        return stamp_ns, n

    def take_back(self, key: LedgerKey, stamp_ns: np.ndarray) -> None:
        """Count readings no longer, which were added under a key; they are to be added again."""
        if len(stamp_ns):
            self._gaps.setdefault(key, []).append((stamp_ns, np.full(len(stamp_ns), -1)))
            self._total[key] -= len(stamp_ns)

    def set_pending(self, stream: str, n: int) -> None:
        """Set the number of readings that still wait for a partner."""
        self._pending[LedgerKey.of_pending(stream)] = n

    def cut(self, stamp_ns: int) -> None:
        """Open a segment at a stamp, which may lie in the future or up to 60 s in the past."""
        at = int(np.searchsorted(self._starts, stamp_ns))
        if at < len(self._starts) and self._starts[at] == stamp_ns:
            return
        self._starts = np.insert(self._starts, at, stamp_ns)
        self._counts.insert(at + 1, Counter())

    def forget_before(self, stamp_ns: int) -> None:
        """Join the segments that end at or before a stamp with the first one."""
        for earlier in self.closed:
            if earlier.newest_ns is None or earlier.newest_ns < stamp_ns:
                earlier.forget_before(_END_OF_TIME_NS)
        n = int(np.searchsorted(self._starts, stamp_ns, side='right')) - 1
        if n > 0:
            self._counts[:n + 1] = [sum(self._counts[:n + 1], Counter())]
            self._starts = self._starts[n:]

    def cut_run(self, stamp_ns: int) -> None:
        """
        Open a segment where a run starts or stops, and at the pairs around that stamp.

        What comes between the last pair before the stamp and the first one from there on lies in
        no run: one sensor may have started earlier, or gone on later, than the other.
        """
        self._run_cuts.append(stamp_ns)
        self.cut(stamp_ns)
        insort(self._bounds, stamp_ns)
        self._cut_at_pairs()

    def _cut_at_pairs(self) -> None:
        """Cut at the pairs around the bounds that the newest pair has reached."""
        chunks = self._recent.get(LedgerKey.PAIRED)
        if not (self._bounds and chunks and chunks[-1][-1] >= self._bounds[0]):
            return
        stamps = np.concatenate(chunks)
        while self._bounds and self._bounds[0] <= stamps[-1]:
            at = int(np.searchsorted(stamps, self._bounds.pop(0)))
            self.cut(int(stamps[at]))
            if at:
                self.cut(int(stamps[at - 1]) + 1)

    def settle(self, stamp_ns: int) -> None:
        """Add the stamps that no later cut can divide to the counts of their segments."""
        limit = stamp_ns - _SLACK_NS
        for key, chunks in self._recent.items():
            # Chunks come nearly in order, so the first is the oldest. Fold many at once.
            if chunks and chunks[0][0] < limit - _SLACK_NS:
                stamps = np.concatenate(chunks)
                old = stamps < limit
                self._fold(self._counts, key, stamps[old])
                self._recent[key] = [stamps[~old]] if not old.all() else []
        for key, gaps in self._gaps.items():
            if gaps and gaps[0][0][0] < limit - _SLACK_NS:
                stamps, n = self._join_gaps(key)
                old = stamps < limit
                self._fold(self._counts, key, stamps[old], n[old])
                self._gaps[key] = [(stamps[~old], n[~old])] if not old.all() else []

    def _fold(self, counts: list[Counter[LedgerKey]], key: LedgerKey,
              stamp_ns: np.ndarray, n: np.ndarray | None = None) -> None:
        if len(stamp_ns):
            ends = stamp_ns.min(), stamp_ns.max()
            first, last = np.searchsorted(self._starts, ends, side='right').tolist()
            if first == last:
                counts[first][key] += len(stamp_ns) if n is None else int(n.sum())
                return
        where = np.searchsorted(self._starts, stamp_ns, side='right')
        sums = np.bincount(where, minlength=len(counts))
        if n is not None:
            # Whole numbers, unlike the weights of bincount.
            sums = np.zeros(len(counts), np.int64)
            np.add.at(sums, where, n)
        for at, count in enumerate(sums.tolist()):
            if count:
                counts[at][key] += count

    @property
    def segments(self) -> tuple[LedgerSegment, ...]:
        """Return the segments in order; the last one also holds the pending readings."""
        if not self.closed:
            return self._own_segments
        return tuple(replace(segment, clock_segment=number or None)
                     for number, ledger in enumerate(self.clock_segments)
                     for segment in ledger._own_segments)

    @property
    def _own_segments(self) -> tuple[LedgerSegment, ...]:
        gaps = {key: self._join_gaps(key) for key, parts in self._gaps.items() if parts}
        counts = [Counter(c) for c in self._counts]
        for key, chunks in self._recent.items():
            if chunks:
                chunks[:] = [np.concatenate(chunks)]
                self._fold(counts, key, chunks[0])
        for key, (stamp_ns, n) in gaps.items():
            self._fold(counts, key, stamp_ns, n)
        counts[-1].update({key: n for key, n in self._pending.items() if n})
        starts = [None, *self._starts.tolist()]
        # A loss that was taken back leaves a zero.
        return tuple(LedgerSegment(s, {key: n for key, n in sorted(c.items()) if n})
                     for s, c in zip(starts, counts))

    @classmethod
    def from_segments(cls, segments: Iterable[LedgerSegment],
                      newest_ns: int | None = None,
                      set_backs: Iterable[SetBack] = ()) -> 'Ledger':
        """Return a ledger that holds these segments, taken from the `segments` of another."""
        ledger, segments, set_backs = cls(), [*segments], [*set_backs]
        number = 0
        for number, of_clock in groupby(segments, key=lambda s: s.clock_segment or 0):
            while len(ledger.closed) < number:
                ledger.set_backs = [s for s in set_backs if s.clock_segment == len(ledger.closed)]
                ledger.open_clock_segment()
            rows = [*of_clock]
            ledger._starts = np.array([s.start_ns for s in rows[1:]], np.int64)
            ledger._counts = [Counter(s.counts) for s in rows]
            for counts in ledger._counts:
                ledger._total.update(counts)
        ledger.set_backs = [s for s in set_backs if s.clock_segment >= number]
        for stream in ('ts', 'rs'):
            ledger._received[stream] = sum(s.received(stream) for s in segments)
        ledger.newest_ns = newest_ns
        return ledger

    @property
    def total(self) -> LedgerSegment:
        """Return the counts of all segments together; no reading is divided among them."""
        total = self._count_own()
        for earlier in self.closed:
            total.update(earlier._count_own())
        return LedgerSegment(None, {key: n for key, n in sorted(total.items()) if n})

    @property
    def clock_segment_total(self) -> LedgerSegment:
        """Return the counts of this clock segment, and the clocks that were set back in it."""
        return LedgerSegment(None, {key: n for key, n in sorted(self._count_own().items()) if n},
                             tuple(self.set_backs))

    def _count_own(self) -> Counter[LedgerKey]:
        total = self._total.copy()
        total.update(self._pending)
        return total

    @property
    def troubles(self) -> list[str]:
        """In words: the last time that each clock was set back."""
        newest = {step.stream: step for ledger in self.clock_segments for step in ledger.set_backs}
        return [*map(str, newest.values())]

    @property
    def all_set_backs(self) -> list[SetBack]:
        """Return the clocks that were set back, in all clock segments."""
        return [step for ledger in self.clock_segments for step in ledger.set_backs]

    @property
    def rejected(self) -> int:
        """Return the number of readings rejected so far."""
        return sum(n for key, n in self.total.counts.items() if key.reason)

    @property
    def paired(self) -> int:
        """Return the number of pairs so far."""
        return self.total.counts.get(LedgerKey.PAIRED, 0)

    def balance(self) -> dict[str, int]:
        """Return readings received minus accounted for, per stream; not 0 is a defect."""
        total = self.total
        return {s: self._received[s] - total.received(s) for s in ('ts', 'rs')}

    def count_between(self, start_ns: int, end_ns: int) -> LedgerSegment:
        """
        Return the counts from the first pair of a run of this clock segment to its last one.

        Parameters
        ----------
        start_ns, end_ns
            Stamps of its first and of its last pair.

        Returns
        -------
        LedgerSegment
            The counts of the segments from the last one that starts at or before `start_ns` to
            the last one that starts at or before `end_ns`; without pending readings.

        """
        first_ns = max((s for s in self._starts.tolist() if s <= start_ns), default=start_ns)
        counts: Counter[LedgerKey] = Counter()
        for segment in self._own_segments:
            if segment.start_ns is not None and first_ns <= segment.start_ns <= end_ns:
                counts.update({key: n for key, n in segment.counts.items()
                               if key not in _PENDING})
        return LedgerSegment(first_ns, dict(counts))

    def shares(self, start_ns: ArrayLike) -> list[LedgerSegment]:
        """
        Divide this clock segment of the ledger among its runs.

        Parameters
        ----------
        start_ns : array_like of int, shape (m,)
            Starts of the runs, ascending, m >= 1; each but the first is the start of a segment.

        Returns
        -------
        list of LedgerSegment, length m
            A segment goes to the last run that starts at or before it, otherwise to the first, and
            so does a clock that was set back.

        """
        starts = np.asarray(start_ns, dtype=np.int64)

        def find(stamp_ns: int | None) -> int:
            """Return the run that a stamp belongs to."""
            return 0 if stamp_ns is None else max(
                0, int(np.searchsorted(starts, stamp_ns, side='right')) - 1)

        n = max(1, len(starts))
        shares: list[Counter[LedgerKey]] = [Counter() for _ in range(n)]
        for segment in self._own_segments:
            shares[find(segment.start_ns)].update(segment.counts)
        set_backs: list[list[SetBack]] = [[] for _ in range(n)]
        for set_back in self.set_backs:
            set_backs[find(set_back.stamp_ns)].append(set_back)
        return [LedgerSegment(int(start), dict(counts), tuple(within))
                for start, counts, within in zip(starts.tolist(), shares, set_backs)]
