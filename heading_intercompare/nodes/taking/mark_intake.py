# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Marks as they come from a topic: each once, of the two kinds, and not without end."""

from __future__ import annotations

from typing import Iterable

from heading_intercompare.messages.marks import MARKS
from heading_intercompare.messages.status_messages import WARN
from heading_intercompare.nodes.runtime.health import Health

__all__ = ['MarkIntake']

#: Marks that a node takes; a year of watches has 2200.
_MOST = 10_000


class MarkIntake:
    """
    Says which marks are new.

    Parameters
    ----------
    health : Health
        Shows marks that are refused.
    taken : iterable of (str, int)
        Marks that have taken effect already, by kind and stamp.

    """

    def __init__(self, health: Health, taken: Iterable[tuple[str, int]] = ()) -> None:
        self._health = health
        self._taken = set(taken)
        self._refused = 0

    def take(self, kind: str, stamp_ns: int) -> bool:
        """Tell whether a mark is to take effect: a late subscriber gets all marks again."""
        if kind not in MARKS:
            self._health.note('marker', WARN, f'mark {kind[:40]!r} is neither start nor stop')
            return False
        if (kind, stamp_ns) in self._taken:
            return False
        if len(self._taken) >= _MOST:
            self._refused += 1
            self._health.note('marker', WARN, f'{self._refused} marks refused: a node takes '
                              f'{_MOST}', latch=True)
            return False
        self._taken.add((kind, stamp_ns))
        return True
