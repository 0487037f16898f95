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
from typing import NamedTuple, TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.records import Losses

#: Publishers and gaps remembered per topic; no topic has more at once.
_PUBLISHERS, _GAPS = 8, 16

_NOTHING = Losses.empty()


class _Message(NamedTuple):
    """Number and stamp of a message."""

    number: int
    stamp_ns: int


def _beyond(number: int, reference: int) -> int:
    """Return how far a 32-bit number is beyond another, counted through the wrap to 0."""
    return (number - reference + 2**31) % 2**32 - 2**31


@dataclass(slots=True)
class Numbering:
    """
    The sequence numbers of the messages of one topic, in order of arrival.

    Each publisher counts on its own, and a subscriber is not told which message is whose. So a
    number is credited to the publisher whose last number it follows most closely. A number that
    follows none starts a new count, or fills a gap that was no gap.

    Attributes
    ----------
    numbered
        Some number is not 0; rosbag2 writes only 0.
    missing
        Numbers skipped between one message and the next.
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
    _newest: list[_Message] = field(default_factory=list)
    _begun_ns: int | None = None
    _gaps: deque[tuple[_Message, _Message]] = field(default_factory=lambda: deque(maxlen=_GAPS))
    _losses: list[tuple[int, int, int]] = field(default_factory=list)

    @classmethod
    def go_on(cls, first: int, newest: int, missing: int) -> 'Numbering':
        """Return a numbering of one publisher that goes on from an earlier `summary`."""
        return cls(numbered=True, missing=missing, restarts=0, first=first,
                   _newest=[_Message(newest, 0)])

    @property
    def summary(self) -> tuple[int, int, int]:
        """Return the first number, the newest one, and how many are missing."""
        newest = self._newest[-1].number if self._newest else 0
        return self.first or 0, newest, self.missing

    def take(self, numbers: ArrayLike, stamp_ns: ArrayLike | None = None) -> Losses:
        """
        Take the numbers of the next messages; only their lowest 32 bits count.

        Parameters
        ----------
        numbers : array_like of int, shape (n,)
            Sequence numbers, n >= 0, in order of arrival.
        stamp_ns : array_like of int, shape (n,), optional
            Stamps of the messages, nanoseconds.

        Returns
        -------
        Losses
            The gaps found, at the stamps of the messages around them; 0 without stamps. The gaps
            are the same however the messages are cut into chunks.

        """
        if self._goes_on(numbers):
            stamp = 0 if stamp_ns is None else int(np.asarray(stamp_ns)[-1])
            self._newest[0] = _Message(numbers[-1], stamp)
            return _NOTHING
        numbers = np.asarray(numbers).astype(np.uint32)
        stamps = (np.zeros(len(numbers), np.int64) if stamp_ns is None
                  else np.asarray(stamp_ns, np.int64))
        if not self.numbered:
            begin = int(np.argmax(numbers > 0)) if numbers.any() else len(numbers)
            numbers, stamps = numbers[begin:], stamps[begin:]
        if not len(numbers):
            return _NOTHING
        if self.first is None:
            self.numbered, self.first = True, int(numbers[0])
            self._begun_ns = int(stamps[0])
            self._newest.append(_Message(self.first, int(stamps[0])))
            numbers, stamps = numbers[1:], stamps[1:]
        before = self._newest[-1]
        steps = np.diff(np.append(np.uint32(before.number), numbers)).view(np.int32)
        if len(self._newest) == 1 and len(steps) and (steps == 1).all():
            self._newest[-1] = _Message(int(numbers[-1]), int(stamps[-1]))
            return _NOTHING
        if len(self._newest) > 1 or (steps < 1).any():
            for number, stamp in zip(numbers.tolist(), stamps.tolist()):
                self._take(_Message(number, stamp))
        elif len(numbers):
            since = np.append(before.stamp_ns, stamps)
            for at in np.flatnonzero(steps > 1).tolist():
                self._miss(_Message(int(numbers[at]) - int(steps[at]), int(since[at])),
                           _Message(int(numbers[at]), int(stamps[at])))
            self._newest[-1] = _Message(int(numbers[-1]), int(stamps[-1]))
        losses, self._losses = self._losses, []
        return Losses.of(*zip(*losses)) if losses else _NOTHING

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
        if not (isinstance(numbers, list) and numbers and len(self._newest) == 1):
            return False
        after = self._newest[0].number + 1
        return after + len(numbers) < 2**32 and numbers == [*range(after, after + len(numbers))]

    def _take(self, message: _Message) -> None:
        steps = [(step, at) for at, newest in enumerate(self._newest)
                 if (step := _beyond(message.number, newest.number)) > 0]
        if steps:
            _, at = min(steps)
            self._miss(self._newest.pop(at), message)
        else:
            self._begin(message)
        self._newest = [*self._newest[1 - _PUBLISHERS:], message]

    def _miss(self, before: _Message, message: _Message) -> None:
        """Count the numbers missing between two."""
        before = before._replace(number=before.number % 2**32)
        step = _beyond(message.number, before.number)
        if step > 1:
            self._count(before, message, step - 1)
            self._gaps.append((before, message))

    def _count(self, before: _Message, behind: _Message, count: int) -> None:
        self.missing += count
        self._losses.append((behind.stamp_ns, before.stamp_ns, count))

    def _begin(self, message: _Message) -> None:
        """Take a number that follows none."""
        for before, behind in self._gaps:
            gap = _beyond(behind.number, before.number)
            if 0 < _beyond(message.number, before.number) < gap:
                # Nothing was missing there: the number after the gap was another publisher's.
                self._gaps.remove((before, behind))
                self._count(before, behind, 1 - gap)
                self._miss(before, message)
                break
        self.restarts += 1
