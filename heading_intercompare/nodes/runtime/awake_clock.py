# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""A steady clock that stands still while this process does."""

from __future__ import annotations

import time

__all__ = ['AwakeClock']

#: A process that runs reads the clock more often than this.
_LONGEST_S = 1.0


class AwakeClock:
    """
    Counts the time in which this process runs, seconds.

    A process that was stopped, or starved, finds later what came in the meantime. Nothing that
    waits may be given up before it has been looked for.
    """

    def __init__(self) -> None:
        self._read_s, self._awake_s = time.monotonic(), 0.0

    def now_s(self) -> float:
        """Return the time so far; each step counts for at most a second."""
        now_s = time.monotonic()
        self._awake_s += min(now_s - self._read_s, _LONGEST_S)
        self._read_s = now_s
        return self._awake_s
