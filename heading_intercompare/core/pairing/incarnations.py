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

"""Starts of a synchronizer: what the ledger of each one counts, added up."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from typing import Iterator, Mapping, NamedTuple

from heading_intercompare.core.raw_streams.stamp_jumps import SetBack
from heading_intercompare.core.utc_text import utc

from .ledger import Ledger, LedgerKey, LedgerSegment
from .names import Span

#: What becomes of readings that waited for a partner when their synchronizer went.
_LEFT = {LedgerKey.TS_PENDING: LedgerKey.TS_UNPAIRED, LedgerKey.RS_PENDING: LedgerKey.RS_UNUSED}

#: Starts of the synchronizer whose ledgers are kept.
_MOST = 1000


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
    """
    The last ledger of a start, whether it was the final one, and the numbers of the readings.

    Its first clock segment has the number `first_segment`; without one it is that in which the
    start before ended.
    """

    ledger: Ledger
    final: bool
    numbers: Mapping[str, StreamNumbers]
    first_segment: int | None

    def count_until(self, after: '_Last') -> dict[str, int]:
        """Return how many readings of each sensor came until the next start took its first."""
        between = {}
        for stream in ('ts', 'rs'):
            numbers, next_numbers = self.numbers.get(stream), after.numbers.get(stream)
            if (numbers and next_numbers and numbers.last_publisher
                    and numbers.last_publisher == next_numbers.first_publisher
                    and numbers.last > 0 and next_numbers.first > 0):
                between[stream] = next_numbers.first - numbers.last - 1
        return between


class _LedgerSum:
    """The ledgers of all starts added up, from the first one on."""

    def __init__(self) -> None:
        self._counts: dict[int, dict[int | None, Counter[LedgerKey]]] = {}
        self._newest_segment = 0
        self.newest_ns: int | None = None
        self.set_backs: list[SetBack] = []

    def add(self, last: _Last, before: Mapping[str, int], is_newest: bool) -> None:
        """Add a ledger, given the counts until its first reading."""
        ledger = last.ledger
        if self.newest_ns is not None:
            for stream, n in before.items():
                self._count(self._newest_segment, self.newest_ns + 1)[
                    LedgerKey.of_lost(stream, 'on_the_way')] += max(0, n)
        first = self._newest_segment if last.first_segment is None else last.first_segment
        if first != self._newest_segment:
            self.newest_ns = None
        unpaired = {} if is_newest else _LEFT
        for segment in ledger.segments:
            start_ns, number = segment.start_ns, segment.clock_segment or 0
            if start_ns is None and not number and self.newest_ns is not None:
                # What came before the first cut came after all of the start before.
                start_ns = self.newest_ns + 1
            counts = self._count(first + number, start_ns)
            for key, n in segment.counts.items():
                # The start before took such readings, or the numbers between count them.
                if not (key.lost == 'before_start' and key.stream in before):
                    counts[unpaired.get(key, key)] += n
        stamps = ([] if ledger.closed else [self.newest_ns]) + [ledger.newest_ns]
        self.newest_ns = max((ns for ns in stamps if ns is not None), default=None)
        self._newest_segment = first + max(0, len(ledger.clock_segments) - 1)
        self.set_backs += [replace(step, clock_segment=first + step.clock_segment)
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
    """

    def __init__(self) -> None:
        self._last: dict[int, _Last] = {}
        self._refused = 0

    def take(self, ledger: Ledger, final: bool, started_ns: int,
             numbers: Mapping[str, StreamNumbers] | None = None,
             first_segment: int | None = None) -> None:
        """
        Take the newest ledger of the synchronizer that was started at a time.

        Parameters
        ----------
        ledger
            Its ledger.
        final
            It is the last one.
        started_ns
            When it was started, UTC ns.
        numbers
            The numbers of the readings that it took, by sensor.
        first_segment
            Number of its first clock segment. Without it this start goes on in the clock segment
            of the start before.

        """
        before = self._last.get(started_ns)
        if before is None and len(self._last) >= _MOST:
            self._refused += 1
        elif before is None or not before.final:
            self._last[started_ns] = _Last(ledger, final, numbers or {}, first_segment)

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
        """Return the number of pairs of the newest start."""
        return self._in_order[-1][1].ledger.paired if self._last else 0

    @property
    def final(self) -> bool:
        """Whether the newest start has ended, and this is its last word."""
        return bool(self._last) and self._in_order[-1][1].final

    @property
    def total(self) -> Ledger | None:
        """Return the ledgers of all starts added up; None before the first ledger."""
        if len(self._last) < 2:
            return next((last.ledger for last in self._last.values()), None)
        ordered = [last for _, last in self._in_order]
        sums = _LedgerSum()
        steps = [before.count_until(after) for before, after in zip(ordered, ordered[1:])]
        for last, before in zip(ordered, ({}, *steps)):
            sums.add(last, before, last is ordered[-1])
        return Ledger.from_segments(sums.segments, sums.newest_ns, sums.set_backs)

    def problems(self) -> Iterator[str]:
        """Yield, in plain sentences, what restarts of the synchronizer have left uncounted."""
        if self._refused:
            yield (f'{self._refused} ledgers of further starts of the synchronizer were refused: '
                   f'{_MOST} are kept')
        ordered = self._in_order
        for (_, before), (started_ns, after) in zip(ordered, ordered[1:]):
            counted = before.count_until(after)
            ends = ', and the run ended there' if after.first_segment is not None else ''
            if len(counted) == 2:
                if ends or any(n > 0 for n in counted.values()):
                    yield (f'the synchronizer was restarted at {utc(started_ns)} UTC{ends}; '
                           f'{counted["ts"]} TS and {counted["rs"]} RS readings came after its '
                           'last ledger, and count as lost')
            elif before.final:
                yield (f'the synchronizer was stopped, and started again at {utc(started_ns)} '
                       f'UTC{ends}: readings that came in between are not counted')
            else:
                yield (f'the synchronizer was restarted at {utc(started_ns)} UTC{ends}; its last '
                       'ledger was not final: up to 1 s of readings is missing, and those that '
                       'came while it was down')
