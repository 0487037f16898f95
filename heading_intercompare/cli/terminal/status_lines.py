# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Lines of plain text on standard error: now and then, and when something changes."""

from __future__ import annotations

import sys
import time

__all__ = ['StatusLines']

#: A line at least this often, and not more often than that.
_EVERY_S, _AT_MOST_S = 10.0, 1.0


class StatusLines:
    """Writes a line every 10 s, and at once when the state changes, at most one a second."""

    def __init__(self) -> None:
        self._state: object = None
        self._next_s = self._soonest_s = 0.0

    def is_due(self, state: object) -> bool:
        """Tell whether to write a line about a state, and assume that it is written."""
        now_s = time.monotonic()
        if now_s < self._soonest_s or state == self._state and now_s < self._next_s:
            return False
        self._state = state
        self._next_s, self._soonest_s = now_s + _EVERY_S, now_s + _AT_MOST_S
        return True

    @staticmethod
    def write(text: str) -> None:
        """Write a line."""
        sys.stderr.write(f'{text}\n')
        sys.stderr.flush()
