# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Missing messages, found by the sequence numbers that their publishers gave them."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

__all__ = ['Numbering']

#: Publishers and gaps remembered per topic; no topic has more at once.
_PUBLISHERS, _GAPS = 8, 16


def _beyond(number: int, other: int) -> int:
    """Return how far a 32-bit number is beyond another, counted through the wrap to 0."""
    return (number - other + 2**31) % 2**32 - 2**31


@dataclass(slots=True)
class Numbering:
    """
    The sequence numbers of the messages of one topic, in order of arrival.

    Each publisher counts on its own, and a subscriber is not told which message is whose. So a
    number is credited to the publisher whose last number it follows most closely. A number that
    follows none starts a new count, or fills a gap that was no gap.

    Attributes
    ----------
    numbered : bool
        Some number is not 0; rosbag2 writes only 0.
    missing : int
        Numbers skipped between one message and the next.
    restarts : int
        How often a number followed no other: a publisher restarted, or another one joined.
    first : int or None
        The first number; messages that a publisher sent earlier do not count as missing.

    """

    numbered: bool = False
    missing: int = 0
    restarts: int = 0
    first: int | None = None
    _newest: list[int] = field(default_factory=list)
    _gaps: deque[tuple[int, int]] = field(default_factory=lambda: deque(maxlen=_GAPS))

    def take(self, numbers: ArrayLike) -> None:
        """Take the numbers of the next messages, n >= 1; only their lowest 32 bits count."""
        numbers = np.asarray(numbers).astype(np.uint32)
        self.numbered = self.numbered or bool(numbers.any())
        if not self.numbered:
            return
        if self.first is None:
            self.first = int(numbers[0])
            self._newest.append(self.first)
            numbers = numbers[1:]
        steps = np.diff(np.append(np.uint32(self._newest[-1]), numbers)).view(np.int32)
        if len(self._newest) > 1 or (steps < 1).any():
            for number in numbers.tolist():
                self._take(number)
            return
        for at in np.flatnonzero(steps > 1).tolist():
            self._miss(int(numbers[at]) - int(steps[at]), int(numbers[at]))
        self._newest[-1:] = numbers[-1:].tolist() or self._newest[-1:]

    def _take(self, number: int) -> None:
        steps = [(step, at) for at, newest in enumerate(self._newest)
                 if (step := _beyond(number, newest)) > 0]
        if steps:
            _, at = min(steps)
            self._miss(self._newest.pop(at), number)
        else:
            self._begin(number)
        self._newest = [*self._newest[1 - _PUBLISHERS:], number]

    def _miss(self, before: int, number: int) -> None:
        """Count the numbers missing between two."""
        before %= 2**32
        step = _beyond(number, before)
        self.missing += step - 1
        if step > 1:
            self._gaps.append((before, number))

    def _begin(self, number: int) -> None:
        """Take a number that follows none."""
        for before, behind in self._gaps:
            if 0 < _beyond(number, before) < _beyond(behind, before):
                # Nothing was missing there: the number after the gap was another publisher's.
                self._gaps.remove((before, behind))
                self.missing -= _beyond(behind, before) - 1
                self._miss(before, number)
                break
        self.restarts += 1
