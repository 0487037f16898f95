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

"""Synchronizers that were restarted: which one is followed, and their ledgers added up."""

from __future__ import annotations

from collections import Counter, deque
from dataclasses import dataclass, replace
from typing import Iterator, Mapping, NamedTuple, Sequence

from heading_intercompare.core.raw_streams.stamp_jumps import SetBack
from heading_intercompare.core.utc_text import utc

from .ledger import Ledger, LedgerKey, LedgerSegment
from .names import Span

#: A live synchronizer publishes its ledger every second.
_PATIENCE_S = 2.5
#: A node that looks less often than this was held up; what it has not heard may still wait.
_ASLEEP_S = 1.0
#: Incarnations remembered; more than two at once are rare.
_MOST_STARTS = 16


class IncarnationChoice:
    """
    The incarnation of the synchronizer whose pairs and ledger count.

    Attributes
    ----------
    current
        When the synchronizer that is followed was started, UTC ns; None before the first.

    Notes
    -----
    A synchronizer that was killed stays in the graph of ROS for some 20 s. So only what a
    synchronizer says shows that it lives. The clock is the caller's.

    Examples
    --------
    >>> choice = IncarnationChoice()
    >>> choice.hear(1, 0.0)
    >>> choice.hear(2, 1.0)
    >>> choice.look(1.5), choice.look(2.4), choice.look(3.1)
    (1, 1, 2)

    """

    def __init__(self) -> None:
        self.current: int | None = None
        self._heard_s: dict[int, float] = {}
        self._ended: set[int] = set()
        self._past: set[int] = set()
        self._looked_s: float | None = None

    def hear(self, started_ns: int, now_s: float, final: bool = False) -> None:
        """Take note that a synchronizer said something, and whether it was its last word."""
        if self.current is None:
            self.current = started_ns
        if started_ns in self._past or started_ns in self._ended:
            return
        self._heard_s[started_ns] = now_s
        if final:
            self._ended.add(started_ns)
        while len(self._heard_s) > _MOST_STARTS:
            oldest = min((candidate for candidate in self._heard_s if candidate != self.current),
                         key=self._heard_s.__getitem__)
            del self._heard_s[oldest]
            self._ended.discard(oldest)

    def follow(self, started_ns: int, now_s: float) -> None:
        """Follow a synchronizer, as an earlier process did."""
        if self.current is not None:
            self._past.add(self.current)
            self._heard_s.pop(self.current, None)
        self.current, self._heard_s[started_ns] = started_ns, now_s

    def look(self, now_s: float) -> int | None:
        """Return which synchronizer is followed now; it changes only if another one lives."""
        asleep_s = 0.0 if self._looked_s is None else now_s - self._looked_s
        self._looked_s = now_s
        if asleep_s > _ASLEEP_S:
            self._heard_s = {started_ns: heard_s + asleep_s
                             for started_ns, heard_s in self._heard_s.items()}
        others = self.list_others(now_s)
        if self.current is not None and others and (
                self.current in self._ended
                or now_s - self._heard_s[self.current] > _PATIENCE_S):
            self._past.add(self.current)
            del self._heard_s[self.current]
            self.current = others[0]
        return self.current

    def list_others(self, now_s: float) -> list[int]:
        """Return the other synchronizers that live, or that ended before they were followed."""
        return sorted(started_ns for started_ns, heard_s in self._heard_s.items()
                      if started_ns != self.current
                      and (started_ns in self._ended or now_s - heard_s <= _PATIENCE_S))


#: What becomes of readings that waited for a partner when their synchronizer went.
_LEFT = {LedgerKey.TS_PENDING: LedgerKey.TS_UNPAIRED, LedgerKey.RS_PENDING: LedgerKey.RS_UNUSED}

#: Starts of the synchronizer whose ledgers are kept.
_MOST = 1000
#: Earlier ledgers of the newest start that are kept, one a second.
_EARLIER = 30


class StreamNumbers(NamedTuple):
    """
    The numbers of the readings of one sensor that an incarnation took.

    Attributes
    ----------
    first_publisher, last_publisher
        The publishers of the first and of the newest one; '' if unknown.
    first, last
        The numbers that they gave.
    spans
        From which number to which one each publisher was heard.

    """

    first_publisher: str
    first: int
    last_publisher: str
    last: int
    spans: tuple[Span, ...] = ()


@dataclass(frozen=True, slots=True)
class _Last:
    """The last ledger of an incarnation, whether it was the final one, and the numbers."""

    ledger: Ledger
    final: bool
    numbers: Mapping[str, StreamNumbers]

    def count_until(self, after: '_Last') -> dict[str, int]:
        """
        Return how many readings of each sensor came until the next incarnation took its first.

        A negative count says how many of the newest readings the next incarnation took again.
        """
        between = {}
        for stream in ('ts', 'rs'):
            numbers, next_numbers = self.numbers.get(stream), after.numbers.get(stream)
            if (numbers and next_numbers and numbers.last_publisher
                    and numbers.last_publisher == next_numbers.first_publisher
                    and numbers.last > 0 and next_numbers.first > 0):
                between[stream] = next_numbers.first - numbers.last - 1
        return between

    @property
    def has_begun(self) -> bool:
        """Whether it is known where this incarnation began with both streams."""
        return len(self.numbers) == 2 and all(numbers.first for numbers in self.numbers.values())

    def joins(self, after: '_Last') -> bool:
        """Tell whether the next incarnation took again no more than what waited for a partner."""
        counts = self.ledger.total.counts
        return all(-n <= counts.get(LedgerKey.of_pending(stream), 0)
                   for stream, n in self.count_until(after).items())


class _LedgerSum:
    """The ledgers of incarnations added up, from the first one on."""

    def __init__(self) -> None:
        self._counts: dict[int, dict[int | None, Counter[LedgerKey]]] = {}
        # Clock segments before those of the newest ledger, and how many that ledger has.
        self._n_before = self._n_segments = 0
        self.newest_ns: int | None = None
        self.set_backs: list[SetBack] = []

    def add(self, ledger: Ledger, before: Mapping[str, int],
            after: Mapping[str, int] | None) -> None:
        """Add a ledger with the counts until it began, and until the next; None for the newest."""
        newest_segment = self._n_before + max(0, self._n_segments - 1)
        if self.newest_ns is not None:
            for stream, n in before.items():
                self._count(newest_segment, self.newest_ns + 1)[
                    LedgerKey.of_lost(stream, 'on_the_way')] += max(0, n)
        if self._n_segments > 1:
            # Each synchronizer counts its segments from 0; its first one goes on with the first
            # of the one before.
            self._n_before, self.newest_ns = newest_segment + 1, None
        self._n_segments = len(ledger.clock_segments)
        unpaired = {} if after is None else _LEFT
        for segment in _without_pending(ledger.segments, after or {}):
            start_ns, number = segment.start_ns, segment.clock_segment or 0
            if start_ns is None and not number and self.newest_ns is not None:
                # What came before the first cut came after all of the incarnation before.
                start_ns = self.newest_ns + 1
            counts = self._count(self._n_before + number, start_ns)
            for key, n in segment.counts.items():
                # The incarnation before took such readings, or the numbers between count them.
                if not (key.lost == 'before_start' and key.stream in before):
                    counts[unpaired.get(key, key)] += n
        stamps = ([] if ledger.closed else [self.newest_ns]) + [ledger.newest_ns]
        self.newest_ns = max((ns for ns in stamps if ns is not None), default=None)
        self.set_backs += [replace(step, clock_segment=self._n_before + step.clock_segment)
                           for step in ledger.all_set_backs]

    def _count(self, number: int, start_ns: int | None) -> Counter[LedgerKey]:
        return self._counts.setdefault(number, {None: Counter()}).setdefault(start_ns, Counter())

    @property
    def segments(self) -> list[LedgerSegment]:
        """Return the sums by the start of their segments."""
        return [LedgerSegment(start_ns, dict(counts[start_ns]), clock_segment=number or None)
                for number, counts in sorted(self._counts.items())
                for start_ns in sorted(counts, key=lambda start: -1 if start is None else start)]


class Incarnations:
    """
    The last ledger of each start of the synchronizer.

    Each start is an incarnation, with its time as its name. It counts from 0.

    Notes
    -----
    A synchronizer that follows a killed one goes on after the ledger that was known at its start.
    That ledger may not be the last: pairs that the last ledger counts may have been lost with the
    process. So the ledger that counts is the newest after which the successor went on.

    """

    def __init__(self) -> None:
        self._last: dict[int, _Last] = {}
        self._earlier: deque[tuple[int, _Last]] = deque(maxlen=_EARLIER)
        self._joined: int | None = None
        self._refused = 0

    def take(self, ledger: Ledger, final: bool, started_ns: int,
             numbers: Mapping[str, StreamNumbers] | None = None) -> None:
        """Take the newest ledger of the incarnation that was started at a time, UTC ns."""
        before = self._last.get(started_ns)
        if before is None and len(self._last) >= _MOST:
            self._refused += 1
            return
        if before is not None and before.final:
            return
        if before is not None:
            self._earlier.append((started_ns, before))
        self._last[started_ns] = newest = _Last(ledger, final, numbers or {})
        self._join(started_ns, newest)

    def _join(self, started_ns: int, newest: _Last) -> None:
        """Count of the incarnation before only what its successor did not take again."""
        past = max((before_ns for before_ns in self._last if before_ns < started_ns), default=None)
        if past is None or self._joined == started_ns or not newest.has_begun:
            return
        self._joined = started_ns
        if not self._last[past].joins(newest):
            self._last[past] = next((last for name, last in reversed(self._earlier) if name == past
                                     and last.joins(newest)), self._last[past])

    def __len__(self) -> int:
        return len(self._last)

    def copy(self) -> 'Incarnations':
        """Return the same ledgers, to add another one."""
        ledgers = Incarnations()
        ledgers._last = dict(self._last)
        return ledgers

    @property
    def _in_order(self) -> list[tuple[int, _Last]]:
        return sorted(self._last.items(), key=lambda numbered: numbered[0])

    @property
    def paired(self) -> int:
        """Return the number of pairs of the newest incarnation."""
        return self._in_order[-1][1].ledger.paired if self._last else 0

    @property
    def final(self) -> bool:
        """Whether the newest incarnation has ended, and this is its last word."""
        return bool(self._last) and self._in_order[-1][1].final

    @property
    def total(self) -> Ledger | None:
        """Return the ledgers of all incarnations added up; None before the first ledger."""
        if len(self._last) < 2:
            return next((last.ledger for last in self._last.values()), None)
        ordered = [last for _, last in self._in_order]
        ledgers = [last.ledger for last in ordered]
        steps = [before.count_until(after) for before, after in zip(ordered, ordered[1:])]
        sums = _LedgerSum()
        for ledger, before, after in zip(ledgers, ({}, *steps), (*steps, None)):
            sums.add(ledger, before, after)
        return Ledger.from_segments(sums.segments, sums.newest_ns, sums.set_backs)

    def problems(self, who: str = 'the synchronizer',
                 sensors: tuple[str, str] = ('TS', 'RS')) -> Iterator[str]:
        """
        Yield, in plain sentences, what restarts have left uncounted.

        Parameters
        ----------
        who
            The node that pairs.
        sensors
            What to call the TS and the RS.

        """
        if self._refused:
            yield (f'{self._refused} ledgers of further starts of {who} were refused: {_MOST} are '
                   'kept')
        ordered = self._in_order
        for (_, before), (started_ns, after) in zip(ordered, ordered[1:]):
            counted = before.count_until(after)
            if len(counted) == 2:
                if any(n > 0 for n in counted.values()):
                    yield (f'{who} was restarted at {utc(started_ns)} UTC; {counted["ts"]} '
                           f'{sensors[0]} and {counted["rs"]} {sensors[1]} readings came after '
                           'its last ledger, and count as lost')
            elif before.final:
                yield (f'{who} was stopped, and started again at {utc(started_ns)} UTC: readings '
                       'that came in between are not counted')
            else:
                yield (f'{who} was restarted at {utc(started_ns)} UTC; its last ledger was not '
                       'final: up to 1 s of readings is missing, and those that came while it was '
                       'down')


def _without_pending(segments: Sequence[LedgerSegment],
                     again: Mapping[str, int]) -> list[LedgerSegment]:
    """Return segments without the pending readings that the next incarnation took again."""
    left = {LedgerKey.of_pending(stream): max(0, -n) for stream, n in again.items()}
    settled = []
    for segment in reversed(segments):
        counts = dict(segment.counts)
        for key in left:
            retaken = min(left[key], counts.get(key, 0))
            counts[key] = counts.get(key, 0) - retaken
            left[key] -= retaken
        settled.append(replace(segment, counts=counts))
    return settled[::-1]
