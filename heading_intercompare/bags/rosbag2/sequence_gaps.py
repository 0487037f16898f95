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

"""Missing messages, found by the sequence numbers that their publishers gave them."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Callable, Iterable, NamedTuple, Sequence, TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.pairing.names import Span
from heading_intercompare.core.records import Losses

#: Publishers and gaps remembered per topic; no topic has more at once.
_PUBLISHERS, _GAPS = 8, 16
#: Publishers whose numbers are listed; more than restarts in any trial.
_MOST_LISTED = 1000

_NOTHING = Losses.empty()


class _Message(NamedTuple):
    """Number and stamp of a message."""

    number: int
    stamp_ns: int


@dataclass(slots=True)
class _Publisher:
    """A publisher: its name, '' if it is unknown, and what was heard of it."""

    name: str
    first: int
    newest: _Message


class _Gap(NamedTuple):
    """Numbers missing between two messages; where they were counted."""

    before: _Message
    behind: _Message
    since_ns: int

    @property
    def n(self) -> int:
        """Return how many are missing."""
        return _beyond(self.behind.number, self.before.number) - 1


def _beyond(number: int, reference: int) -> int:
    """Return how far a 32-bit number is beyond another, counted through the wrap to 0."""
    return (number - reference + 2**31) % 2**32 - 2**31


def _nobody(number: int, stamp_ns: int) -> None:
    """Say that no publisher is known to begin with this message."""


@dataclass(slots=True)
class Numbering:
    """
    The sequence numbers of the messages of one topic, in order of arrival.

    Each publisher counts on its own, and a subscriber is not told which message is whose. So a
    number that does not follow the last one is the first of a publisher that others know to begin
    there. Otherwise it is credited to the publisher whose last number it follows most closely. A
    number that follows none fills a gap, if its stamp lies within that, or starts a new count.

    Attributes
    ----------
    numbered
        Some number is not 0; rosbag2 writes only 0.
    missing
        Numbers skipped between one message and the next, and those that a later publisher gave
        before its first message.
    restarts
        How often a number followed no other: a publisher restarted, or another one joined.
    first
        The first number that is not 0; messages that a publisher sent earlier do not count as
        missing.

    """

    numbered: bool = False
    missing: int = 0
    restarts: int = 0
    first: int | None = None
    _newest: list[_Publisher] = field(default_factory=list)
    _listed: deque[_Publisher] = field(default_factory=lambda: deque(maxlen=_MOST_LISTED))
    _begun_ns: int | None = None
    _gaps: deque[_Gap] = field(default_factory=lambda: deque(maxlen=_GAPS))
    _losses: list[tuple[int, int, int]] = field(default_factory=list)

    @classmethod
    def go_on(cls, spans: Iterable[Span], missing: int = 0) -> 'Numbering':
        """Return a numbering that goes on after these numbers, of which some are missing."""
        numbering = cls(missing=missing)
        for span in spans:
            numbering.numbered = True
            numbering.first = span.first if numbering.first is None else numbering.first
            numbering._add(_Publisher(span.publisher, span.first, _Message(span.last, 0)))
        return numbering

    @property
    def summary(self) -> tuple[int, int, int]:
        """Return the first number, the newest one, and how many are missing."""
        newest = self._newest[-1].newest.number if self._newest else 0
        return self.first or 0, newest, self.missing

    @property
    def spans(self) -> tuple[Span, ...]:
        """Return from which number to which one each publisher was heard, in their order."""
        return tuple(Span(publisher.name, publisher.first, publisher.newest.number)
                     for publisher in self._listed)

    @property
    def publisher(self) -> str:
        """Return the publisher of the newest message; '' if it is unknown."""
        return self._newest[-1].name if self._newest else ''

    def name_newest(self, publisher: str) -> None:
        """Name the publisher of the newest message, if it is unknown."""
        if self._newest and not self._newest[-1].name:
            self._newest[-1].name = publisher

    def take(self, numbers: ArrayLike, stamp_ns: ArrayLike | None = None,
             find_new: Callable[[int, int], str | None] = _nobody,
             begins: Sequence[int] = ()) -> Losses:
        """
        Take the numbers of the next messages; only their lowest 32 bits count.

        Parameters
        ----------
        numbers : array_like of int, shape (n,)
            Sequence numbers, n >= 0, in order of arrival.
        stamp_ns : array_like of int, shape (n,), optional
            Stamps of the messages, nanoseconds.
        find_new
            Called with number and stamp of a message that does not follow the last one. Returns
            the publisher that it is the first message of, '' if that is unknown; None if it is not
            known to be the first of any.
        begins
            Which of the messages, counted from 0 and rising, may be the first of a publisher even
            where their numbers follow the last one: `find_new` is asked about them, too.

        Returns
        -------
        Losses
            The gaps found, at the stamps of the messages around them; 0 without stamps. The gaps
            are the same however the messages are cut into chunks.

        """
        if not begins and self._goes_on(numbers):
            stamp = 0 if stamp_ns is None else int(np.asarray(stamp_ns)[-1])
            self._newest[-1].newest = _Message(numbers[-1], stamp)
            return _NOTHING
        numbers = np.asarray(numbers).astype(np.uint32)
        stamps = (np.zeros(len(numbers), np.int64) if stamp_ns is None
                  else np.asarray(stamp_ns, np.int64))
        if not self.numbered:
            zeros = int(np.argmax(numbers > 0)) if numbers.any() else len(numbers)
            numbers, stamps = numbers[zeros:], stamps[zeros:]
            begins = [at - zeros for at in begins]
        if not len(numbers):
            return _NOTHING
        if self.first is None:
            first = _Message(int(numbers[0]), int(stamps[0]))
            self.numbered, self.first = True, first.number
            self._begun_ns = first.stamp_ns
            self._add(_Publisher(find_new(*first) or '', first.number, first))
            numbers, stamps = numbers[1:], stamps[1:]
            begins = [at - 1 for at in begins]
        # Numbers that follow each other are those of one publisher; only its first one decides.
        breaks = np.flatnonzero(np.diff(numbers).view(np.int32) != 1) + 1
        cuts = sorted({0, *breaks.tolist(), *(at for at in begins if at > 0)})
        for lo, hi in zip(cuts, [*cuts[1:], len(numbers)]):
            if lo < hi:
                self._take(_Message(int(numbers[lo]), int(stamps[lo])), find_new, lo in begins)
                if hi - lo > 1:
                    self._extend(numbers[lo:hi], stamps[lo:hi], find_new)
        losses, self._losses = self._losses, []
        return Losses.of(*zip(*losses)) if losses else _NOTHING

    def _extend(self, numbers: np.ndarray, stamps: np.ndarray,
                find_new: Callable[[int, int], str | None]) -> None:
        """Take numbers that follow each other, of which the first one was taken."""
        newest = self._newest[-1].newest
        if newest.number % 2**32 != numbers[0]:
            # The first one filled a gap, and so may the next.
            for number, stamp in zip(numbers[1:].tolist(), stamps[1:].tolist()):
                self._take(_Message(number, stamp), find_new)
            return
        self._newest[-1].newest = _Message(newest.number + len(numbers) - 1, int(stamps[-1]))

    def take_before(self) -> Losses:
        """
        Return, once, what the publisher sent before the first message.

        Returns
        -------
        Losses
            At the stamp just before that of the first message, so in no run; empty if that message
            was the first of its publisher, or none has come.

        """
        begun_ns, self._begun_ns = self._begun_ns, None
        if begun_ns is None or self.first in (None, 1):
            return _NOTHING
        return Losses.of([begun_ns - 1], [0], [self.first - 1])

    def _goes_on(self, numbers: ArrayLike) -> TypeGuard[list[int]]:
        """Tell whether the numbers of a live batch follow the last one without a gap."""
        if not (isinstance(numbers, list) and numbers and self._newest):
            return False
        after = self._newest[-1].newest.number + 1
        return numbers == [*range(after, after + len(numbers))]

    def _take(self, message: _Message, find_new: Callable[[int, int], str | None],
              begins: bool = False) -> None:
        # Of several that it follows as closely, the one heard last.
        steps = [(step, -at) for at, publisher in enumerate(self._newest)
                 if (step := _beyond(message.number, publisher.newest.number)) > 0]
        at = -min(steps)[1] if steps else -1
        if steps and min(steps)[0] == 1 and at == len(self._newest) - 1 and not begins:
            self._hear(at, message)
            return
        name = find_new(*message)
        names = [publisher.name for publisher in self._newest]
        if name and name in names:
            at = names.index(name)
        elif name is not None:
            self._begin(message, name)
            return
        if _beyond(message.number, self._newest[at].newest.number) > 0:
            self._hear(at, message)
        elif not self._fill(message):
            self._begin_unknown(message)

    def _hear(self, at: int, message: _Message) -> None:
        """Take the next message of a publisher."""
        publisher = self._newest.pop(at)
        before = publisher.newest
        self._miss(before._replace(number=before.number % 2**32), message)
        step = _beyond(message.number, before.number)
        publisher.newest = message._replace(number=before.number + step)
        self._newest.append(publisher)

    def _add(self, publisher: _Publisher) -> None:
        self._newest = [*self._newest[1 - _PUBLISHERS:], publisher]
        self._listed.append(publisher)

    def _begin(self, message: _Message, name: str) -> None:
        """Take the first message heard of another publisher: what it sent before is missing."""
        self.restarts += 1
        self._miss(_Message(0, self._newest[-1].newest.stamp_ns), message)
        self._add(_Publisher(name, message.number, message))

    def _miss(self, before: _Message, message: _Message) -> None:
        """Count the numbers missing between two."""
        gap = _Gap(before, message, before.stamp_ns)
        if gap.n > 0:
            self._count(gap, gap.n)
            self._gaps.append(gap)

    def _count(self, gap: _Gap, count: int) -> None:
        self.missing += count
        self._losses.append((gap.behind.stamp_ns, gap.since_ns, count))

    def _find_gap(self, number: int) -> list[_Gap]:
        """Return the gaps that a number lies in."""
        return [gap for gap in self._gaps
                if 0 < _beyond(number, gap.before.number) <= gap.n]

    def _fill(self, message: _Message) -> bool:
        """Take a number that comes late, into the gap that its stamp lies in too."""
        for gap in self._find_gap(message.number):
            if gap.before.stamp_ns < message.stamp_ns < gap.behind.stamp_ns:
                self._gaps.remove(gap)
                self._count(gap, -1)
                for part in (gap._replace(behind=message._replace(stamp_ns=gap.behind.stamp_ns)),
                             gap._replace(before=message)):
                    if part.n > 0:
                        self._gaps.append(part)
                return True
        return False

    def _begin_unknown(self, message: _Message) -> None:
        """Take a number that follows none, and is not late."""
        # What a publisher sent before it was heard is explained by no other one.
        for gap in (gap for gap in self._find_gap(message.number) if gap.before.number):
            # Nothing was missing there: the number after the gap was another publisher's.
            self._gaps.remove(gap)
            self._count(gap, -gap.n)
            self.restarts += 1
            self._miss(gap.before, message)
            self._add(_Publisher('', message.number, message))
            return
        if message.stamp_ns > self._newest[-1].newest.stamp_ns:
            self._begin(message, '')
            return
        # Without a later stamp it may also be a message that comes late.
        self.restarts += 1
        self._add(_Publisher('', message.number, message))
