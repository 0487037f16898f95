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

"""The playback of a log at its own pace, as if its sentences arrived live."""

from __future__ import annotations

import time
from typing import Any, Callable

from .csv_log import is_csv_file, open_csv
from .framing import Received, split
from .log_lines.log_clocks import choose_time_sentences, start_stamps
from .log_lines.log_order import open_log
from .log_lines.stream_times import StreamTimes
from .nmea import NmeaDecoder
from .sentences import Rejected
from .settings import DriverError, DriverSettings

_MAX_READ = 1000


class FileSource:
    """
    Plays a log line by line, at `speed` relative to log time.

    Each line keeps its log stamp as its time of receipt. A line without a stamp follows the line
    before at once, with None. A log without stamps is paced by the sentences that tell the time if
    `time` is 'validity'. The clock starts with the first `read`.

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
        If the log is empty, a csv, or holds headings of several instruments of one talker.

    """

    def __init__(self, settings: DriverSettings, now_ns: Callable[[], int] = time.time_ns, *,
                 clock: Callable[[], float] = time.monotonic,
                 wait: Callable[[float], Any] = time.sleep) -> None:
        self._path = settings.address.path
        self._clock, self._wait = clock, wait
        self._speed, self._settings = settings.speed, settings
        self._files = open_csv(self._path, settings) or open_log(self._path, settings)
        head = next(self._files.bare_blocks(), b'')
        if not head or is_csv_file(self._files.paths[0]):
            raise DriverError(f'{self._path}: no lines' if not head else
                              f'{self._path}: a csv cannot be played, only imported; must be a '
                              'log of NMEA sentences')
        decoder = NmeaDecoder(settings, self._files)
        decoder.feed(head, None)
        decoder.flush()
        # Its beginning shows them; the whole log may be long.
        decoder.refuse_several_instruments(self._path)
        self._rewind()
        self.first_ns = next((line.stamp_ns for line in iter(self._line, None)
                              if line.stamp_ns is not None), None)
        self.origin_ns = self.first_ns
        self._rewind()
        self._next = self._line()
        self._started: float | None = None
        self.counts: dict[str, int] = {}
        self.status = f'playing {self._path}'

    @property
    def exhausted(self) -> bool:
        """Whether all lines have been returned."""
        return self._next is None

    def read(self, timeout_s: float) -> list[Received]:
        """Return the lines that are due, at most 1000."""
        if self._started is None:
            self._started = self._clock()
        end = self._clock() + timeout_s
        lines: list[Received] = []
        while self._next is not None and len(lines) < _MAX_READ:
            due = self._due(self._next.stamp_ns)
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
        self._lines.close()

    def _due(self, stamp_ns: int | None) -> float:
        if stamp_ns is None or self._speed == 0.0:
            return 0.0
        assert self._started is not None and self.origin_ns is not None
        return self._started + (stamp_ns - self.origin_ns) / 1e9 / self._speed

    def _rewind(self) -> None:
        """Begin with the first line."""
        settings, files = self._settings, self._files
        days, self._stamps = start_stamps(settings, files, of_log=False)
        self._times = StreamTimes(days, choose_time_sentences(files, settings))
        self._lines = files.lines()

    def _line(self) -> Received | None:
        begins, line = next(self._lines, (None, b''))
        if not line:
            return None
        if begins is not None:
            self._stamps.begin_file(begins)
        return Received(line, self._stamp_ns(line), 0.0, begins)

    def _stamp_ns(self, line: bytes) -> int | None:
        """Return the stamp of a line, or the time that its sentence tells."""
        parts = split(line)
        prefix, text, suffix = parts if parts else (line, b'', b'')
        try:
            if self._settings.stamp_format != 'none':
                stamp_ns = self._stamps.own_ns(prefix, suffix)
                if stamp_ns is not None:
                    return stamp_ns
            if self._settings.time == 'validity' and self._times.tells(text):
                return self._times.read(text, None)
        except (Rejected, ValueError):
            pass
        return None
