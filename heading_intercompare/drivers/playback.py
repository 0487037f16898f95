# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The playback of a log at its own pace, as if its sentences arrived live."""

from __future__ import annotations

import time
from typing import Any, Callable

from .csv_log import is_csv
from .framing import KEPT_PREFIX, split
from .log_stamps import log_stamp_ns
from .settings import DriverError, DriverSettings

__all__ = ['FileSource']

_MAX_READ = 1000


class FileSource:
    """
    Plays a log line by line, at `speed` relative to log time.

    Each line keeps its log stamp as its time of receipt. A line without a stamp follows the line
    before at once, with None. The clock starts with the first `read`.

    Attributes
    ----------
    first_ns : int or None
        First stamp of the log; None if no line has one. Then the log is played without pacing.
    origin_ns : int or None
        Log time at the first `read`; `first_ns` unless set. To play the logs of two sensors in
        step, set it to the smaller `first_ns` for both.

    Raises
    ------
    OSError
        If the log cannot be read.
    DriverError
        If the log is empty, or a csv.

    """

    def __init__(self, settings: DriverSettings, now_ns: Callable[[], int] = time.time_ns, *,
                 clock: Callable[[], float] = time.monotonic,
                 wait: Callable[[float], Any] = time.sleep) -> None:
        self._path = settings.address.path
        self._clock, self._wait = clock, wait
        self._speed, self._stamp_format = settings.speed, settings.stamp_format
        self._file = open(self._path, 'rb')
        first = self._file.readline(4096)
        if not first or is_csv(first):
            self._file.close()
            raise DriverError(f'{self._path}: no lines' if not first else
                              f'{self._path}: a csv cannot be played, only imported; must be a '
                              'log of NMEA sentences')
        self._file.seek(0)
        self.first_ns = next((ns for ns, _ in iter(self._line, None) if ns is not None), None)
        self.origin_ns = self.first_ns
        self._file.seek(0)
        self._next = self._line()
        self._started: float | None = None
        self.status = f'playing {self._path}'

    @property
    def exhausted(self) -> bool:
        """Whether all lines have been returned."""
        return self._next is None

    def read(self, timeout_s: float) -> list[tuple[int | None, bytes]]:
        """Return the lines that are due, at most 1000."""
        if self._started is None:
            self._started = self._clock()
        end = self._clock() + timeout_s
        lines: list[tuple[int | None, bytes]] = []
        while self._next is not None and len(lines) < _MAX_READ:
            due = self._due(self._next[0])
            if due > self._clock():
                if lines or due > end:
                    break
                self._wait(max(0.0, due - self._clock()))
            lines.append(self._next)
            self._next = self._line()
        if self._next is None:
            self.status = f'{self._path}: end'
        elif not lines:
            self._wait(max(0.0, end - self._clock()))
        return lines

    def close(self) -> None:
        """Close the log; `read` returns nothing more."""
        self._next = None
        self._file.close()

    def _due(self, stamp_ns: int | None) -> float:
        if stamp_ns is None or self._speed == 0.0:
            return 0.0
        return self._started + (stamp_ns - self.origin_ns) / 1e9 / self._speed

    def _line(self) -> tuple[int | None, bytes] | None:
        line = self._file.readline(1 << 16)
        if not line:
            return None
        parts = split(line)
        if parts is None or self._stamp_format == 'none':
            return None, line
        try:
            return log_stamp_ns(parts[0][-KEPT_PREFIX:], self._stamp_format), line
        except ValueError:
            return None, line
