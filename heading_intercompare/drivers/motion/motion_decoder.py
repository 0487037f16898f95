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

"""The motion or the attitude of the ship in sentences: live, played, or a whole log at once."""

from __future__ import annotations

from collections import Counter
import math
from typing import Callable, Iterable, Iterator, NamedTuple

import numpy as np

from heading_intercompare.core.motion.moved_rows import MovedRow
from heading_intercompare.core.records import Motion
from heading_intercompare.drivers.framing import Frame, Framer
from heading_intercompare.drivers.line_numbers import LineNumbers
from heading_intercompare.drivers.log_lines.log_clocks import choose_time_sentences, start_stamps
from heading_intercompare.drivers.log_lines.log_files import LogFiles
from heading_intercompare.drivers.log_lines.log_order import open_log
from heading_intercompare.drivers.log_lines.stream_times import StreamTimes, TIME_SENTENCES
from heading_intercompare.drivers.log_lines.times import day_time_ns, nearest_day_ns
from heading_intercompare.drivers.sentence_choice import Listening
from heading_intercompare.drivers.sentences import Name, Rejected
from heading_intercompare.drivers.settings import DriverSettings

from .motion_sentences import Family, MOTION

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
        self._times = StreamTimes(days, choose_time_sentences(files, rule))
        is_udp = rule.source is not None and rule.address.scheme == 'udp'
        self._framer = Framer(datagrams=is_udp, with_lines=self._is_log)
        self._numbers = LineNumbers()
        self._last_ns: int | None = None

    def begin_file(self, name: str) -> None:
        """Begin with another file of a log."""
        self._stamps.begin_file(name)
        self._numbers.begin_file()
        self._last_ns = None

    def feed(self, data: bytes, received_ns: int | None = None) -> Iterator[MotionLine]:
        """Yield what the sentences tell that some bytes complete."""
        yield from self._take(self._framer.feed(data, received_ns))

    def flush(self) -> Iterator[MotionLine]:
        """Yield what the last sentences tell."""
        yield from self._take(self._framer.flush())

    def _take(self, frames: Iterable[Frame]) -> Iterator[MotionLine]:
        for received_ns, prefix, text, checked, suffix in frames:
            if refused := self._numbers.refuse(prefix, text, received_ns):
                self._counts[refused] += 1
                continue
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


def may_tell(log: LogFiles, family: Family) -> bool:
    """Tell whether a log may have a sentence of a family: much faster than to read it."""
    tokens = [f'{kind},'.encode() for kind in family.parsers]
    tail = b''
    for block in log.bare_blocks():
        text = tail + block
        if any(token in text for token in tokens):
            return True
        tail = block[-7:]
    return False


_BLOCK = 1 << 20
#: Rows held until a sentence is chosen; a flood does not wait for the end of `learn_s`.
_MOST_HELD = 20_000


class MotionDecoder:
    r"""
    Turns the bytes of a source into the motion of the ship.

    Parameters
    ----------
    settings
        As for `NmeaDecoder`; `sentence`, `talker` and `instrument` choose headings only.
    family
        The sentences to read; of those of the attitude only `read_log` gives rows.
    log
        A log for `read_log`; without one, `source` says whether a log is played.

    Attributes
    ----------
    chosen
        The sentence used for each thing, by what it tells, such as INVTG for 'velocity'.

    Notes
    -----
    Of each thing one kind of sentence is taken, from the talker heard first: that which
    `read_log_motion` takes of a log. A log that is played is searched beforehand. On a live line
    the decoder listens for `learn_s` of receipt time after the first sentence that tells the
    thing, holds all rows until then, and returns those of the best kind.

    Examples
    --------
    >>> decoder = MotionDecoder(DriverSettings(learn_s=0.0))
    >>> decoder.feed(b'$HEROT,-30.0,A*35\r\n', 10 ** 18).rate_deg_s.tolist()
    [-0.5]

    """

    def __init__(self, settings: DriverSettings, family: Family = MOTION,
                 log: LogFiles | None = None) -> None:
        self._kinds, self._learn_s = [*family.parsers], settings.learn_s
        self._most = _MOST_HELD if log is None else math.inf
        self.chosen: dict[str, Name] = {}
        if log is None and settings.source is not None and settings.address.scheme == 'file':
            log = open_log(settings.address.path, settings)
            if may_tell(log, family):
                search = MotionDecoder(settings, family, log)
                search.read_log(log)
                self.chosen = search.chosen
        self._counts: Counter[str] = Counter()
        self._lines = MotionLines(settings, self._counts, family, log)
        self._by_thing: dict[str, Listening] = {}

    @property
    def counts(self) -> dict[str, int]:
        """Sentences of the motion that gave none, by reason; `other` are those not chosen."""
        return dict(sorted(self._counts.items()))

    def feed(self, data: bytes, received_ns: int | None, late_s: float = 0.0,
             file: str | None = None, sender: str = '') -> Motion:
        """Take bytes and return the motion that they complete; see `NmeaDecoder.feed`."""
        if file is not None:
            self._lines.begin_file(file)
        self._take(self._lines.feed(data, received_ns))
        for what, listening in self._by_thing.items():
            self._choose(what, listening, received_ns)
        return self._drain()

    def flush(self) -> Motion:
        """Return the last rows at the end of the stream."""
        self._finish()
        return self._drain()

    def read_log(self, log: LogFiles, progress: Callable[[str], None] = lambda text: None,
                 ) -> dict[str, list[np.ndarray]]:
        """Read a whole log; return stamps and values by what they tell."""
        for begins, block in log.blocks(_BLOCK):
            if begins is not None:
                self._lines.begin_file(begins)
            self._take(self._lines.feed(block))
            progress(f'{log.share_read} of the motion of the ship in {log.path} read')
        self._finish()
        return {what: listening.rows.drain() for what, listening in self._by_thing.items()}

    def _take(self, lines: Iterable[MotionLine]) -> None:
        for name, stamp_ns, (what, values) in lines:
            listening = self._by_thing.get(what)
            if listening is None:
                listening = self._by_thing[what] = Listening(
                    self._kinds, self._learn_s, self._most, self.chosen.get(what), len(values))
            if listening.chosen is None:
                listening.hear(name).rows.add(stamp_ns, *values)
            elif listening.chosen == name:
                listening.rows.add(stamp_ns, *values)
            else:
                self._counts['other'] += 1

    def _finish(self) -> None:
        self._take(self._lines.flush())
        for what, listening in self._by_thing.items():
            self._choose(what, listening, None, at_end=True)

    def _choose(self, what: str, listening: Listening, now_ns: int | None,
                at_end: bool = False) -> None:
        """Choose the best sentence if it is time, and count what was heard of the others."""
        held = listening.choose() if at_end else listening.learn(now_ns)
        if listening.chosen is not None:
            self.chosen[what] = listening.chosen
        if n_others := sum(heard.n for name, heard in held.items() if name != listening.chosen):
            self._counts['other'] += n_others

    def _drain(self) -> Motion:
        return Motion.concatenate([Motion.of(what, *listening.rows.drain())
                                   for what, listening in self._by_thing.items()
                                   if len(listening.rows)])
