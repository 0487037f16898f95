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

"""What the lines of a stream or a log tell of the motion of the ship, with their stamps."""

from __future__ import annotations

from collections import Counter
from typing import Iterable, Iterator, NamedTuple

from heading_intercompare.core.motion.moved_rows import MovedRow
from heading_intercompare.drivers.framing import Frame, Framer
from heading_intercompare.drivers.log_lines.log_clocks import choose_time_sentences, start_stamps
from heading_intercompare.drivers.log_lines.log_files import LogFiles
from heading_intercompare.drivers.log_lines.stream_times import StreamTimes, TIME_SENTENCES
from heading_intercompare.drivers.log_lines.times import day_time_ns, nearest_day_ns
from heading_intercompare.drivers.sentences import Name, Rejected
from heading_intercompare.drivers.settings import DriverSettings

from .motion_sentences import Family

_TIMES = frozenset(kind.encode() for kind in TIME_SENTENCES)
#: Field with the time of day, by kind.
_TIME_FIELD = {b'GGA': 1, b'GNS': 1, b'RMC': 1, b'GLL': 5}


class MotionLine(NamedTuple):
    """The name of a sentence, its stamp, and a row that it tells."""

    name: Name
    stamp_ns: int
    row: MovedRow


class MotionLines:
    """
    Yields what the lines of a source tell of the motion of the ship.

    Parameters
    ----------
    rule
        How lines are stamped. The scheme of `source` matters as for `NmeaDecoder`.
    counts
        Counts the sentences of the motion that told nothing, by reason.
    family
        The sentences to read.
    files
        The log that is read or played; none for a live stream.

    Notes
    -----
    In a log a sentence takes the stamp of its line or of the last line with one. On a live line it
    takes the time of receipt, unless `stamp_format` names the form of its stamp. With times of
    validity it takes its own time, or the time told last.

    """

    def __init__(self, rule: DriverSettings, counts: Counter[str], family: Family,
                 files: LogFiles | None = None) -> None:
        self._counts, self._family, self._is_log = counts, family, files is not None
        self._lenient = rule.checksum == 'if_present'
        self._validity = rule.time == 'validity'
        days, self._stamps = start_stamps(rule, files)
        self._no_stamps = rule.stamp_format == 'none' or (
            not self._is_log and rule.stamp_format == 'auto')
        self._times = StreamTimes(days, choose_time_sentences(files, self._validity))
        is_udp = rule.source is not None and rule.address.scheme == 'udp'
        self._framer = Framer(datagrams=is_udp, with_lines=self._is_log)
        self._last_ns: int | None = None

    def begin_file(self, name: str) -> None:
        """Begin with another file of a log."""
        self._stamps.begin_file(name)
        self._last_ns = None

    def feed(self, data: bytes, received_ns: int | None = None) -> Iterator[MotionLine]:
        """Yield what the sentences tell that some bytes complete."""
        yield from self._take(self._framer.feed(data, received_ns))

    def flush(self) -> Iterator[MotionLine]:
        """Yield what the last sentences tell."""
        yield from self._take(self._framer.flush())

    def _take(self, frames: Iterable[Frame]) -> Iterator[MotionLine]:
        for received_ns, prefix, text, checked, suffix in frames:
            stamp_ns = self._stamp(prefix, text, suffix, received_ns)
            name = self._family.identify(text)
            if name is None or name.kind not in self._family.parsers:
                continue
            if not (checked or self._lenient):
                self._counts['no_checksum'] += 1
            elif stamp_ns is None:
                self._counts['no_stamp'] += 1
            else:
                try:
                    for row in self._family.parse(name, text):
                        yield MotionLine(name, stamp_ns, row)
                except Rejected as rejected:
                    self._counts[f'{name}.{rejected.reason}'] += 1

    def _stamp(self, prefix: bytes, text: bytes, suffix: bytes,
               received_ns: int | None) -> int | None:
        """Return the stamp of a line, or of the last one that had one."""
        if self._no_stamps:
            own_ns = None if self._is_log else received_ns
        else:
            own_ns = self._line_ns(prefix, suffix)
        if not self._validity:
            self._last_ns = self._last_ns if own_ns is None else own_ns
            return self._last_ns
        if text[2:5] in _TIMES and text[5:6] == b',' and self._times.tells(text):
            try:
                self._last_ns = self._times.read(text, own_ns)
            except ValueError:
                self._last_ns = None
        return self._own_time_ns(text, own_ns)

    def _line_ns(self, prefix: bytes, suffix: bytes) -> int | None:
        try:
            return self._stamps.own_ns(prefix, suffix) if prefix or suffix else None
        except Rejected:
            return None

    def _own_time_ns(self, text: bytes, line_ns: int | None) -> int | None:
        """Return the time of day in a sentence on its day, or the time told last."""
        at = _TIME_FIELD.get(text[2:5]) if text[5:6] == b',' else None
        if at is None:
            return self._last_ns
        near_ns = self._last_ns if self._last_ns is not None else line_ns
        try:
            time_of_day_ns = day_time_ns(text.split(b',', at + 1)[at])
            return (self._times.place(time_of_day_ns, line_ns) if near_ns is None
                    else nearest_day_ns(time_of_day_ns, near_ns))
        except (ValueError, IndexError):
            return None
