# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The motion of the ship in a log of NMEA sentences, read on its own, beside the headings."""

from __future__ import annotations

from array import array
from collections import Counter
from dataclasses import dataclass, field
import os
from typing import Iterable, Iterator, Mapping

import numpy as np

from heading_intercompare.core.records import Motion
from heading_intercompare.drivers.csv_log import is_csv_file, open_csv
from heading_intercompare.drivers.framing import Framer
from heading_intercompare.drivers.log_lines.log_clocks import choose_time_sentences, start_stamps
from heading_intercompare.drivers.log_lines.log_files import LogFiles
from heading_intercompare.drivers.log_lines.log_order import open_log
from heading_intercompare.drivers.log_lines.stream_times import StreamTimes, TIME_SENTENCES
from heading_intercompare.drivers.log_lines.times import day_time_ns, nearest_day_ns
from heading_intercompare.drivers.sentences import Rejected
from heading_intercompare.drivers.settings import DriverSettings

from .motion_sentences import COURSE, MOTION_KINDS, parse_motion, POSITION, RATE, Told

__all__ = ['LoggedMotion', 'read_log_motion']

_BLOCK = 1 << 20
_TOKENS = tuple(f'{kind},'.encode() for kind in MOTION_KINDS)
_KINDS = frozenset(kind.encode() for kind in MOTION_KINDS)
_TIMES = frozenset(kind.encode() for kind in TIME_SENTENCES)
#: Field with the time of day, by kind.
_TIME_FIELD = {b'GGA': 1, b'GNS': 1, b'RMC': 1, b'GLL': 5}


@dataclass(frozen=True, slots=True)
class LoggedMotion:
    """
    The motion of the ship in a log.

    Attributes
    ----------
    rows : mapping of str to Motion
        By what they tell: 'position', 'course', 'rate'. Only what the log has.
    sentences : mapping of str to str
        The sentence that each came from, such as 'INVTG'.
    not_taken : mapping of str to int
        Sentences of the motion that gave none, by reason.

    """

    rows: Mapping[str, Motion] = field(default_factory=dict)
    sentences: Mapping[str, str] = field(default_factory=dict)
    not_taken: Mapping[str, int] = field(default_factory=dict)


class _Columns:
    """What the sentences of one name tell of one thing."""

    def __init__(self) -> None:
        self.stamp_ns, self.first, self.second = array('q'), array('d'), array('d')

    def add(self, stamp_ns: int, told: Told) -> None:
        self.stamp_ns.append(stamp_ns)
        self.first.append(told.first)
        self.second.append(told.second)

    def to_motion(self, what: str) -> Motion:
        stamps = np.array(self.stamp_ns, np.int64)
        first, second = np.array(self.first), np.array(self.second)
        if what == POSITION:
            return Motion.of_positions(stamps, first, second)
        return (Motion.of_velocities(stamps, first, second) if what == COURSE
                else Motion.of_rates(stamps, first))


def read_log_motion(path: str | os.PathLike[str],
                    settings: DriverSettings | None = None) -> LoggedMotion:
    """
    Read the motion of the ship from a log.

    Parameters
    ----------
    path : path
        A log of NMEA sentences: a file, a folder of files, or a pattern of names.
    settings : DriverSettings, optional
        How its lines are stamped; `sentence`, `talker` and `instrument` choose headings only.

    Returns
    -------
    LoggedMotion
        Empty for a csv, and for a log without such sentences.

    Raises
    ------
    OSError
        If the log cannot be read.
    DriverError
        If compressed data are damaged, or no file matches.

    Notes
    -----
    Of each thing one kind of sentence is taken, from the talker heard first: for courses VTG
    before RMC; for positions GNS, GGA, RMC, GLL. A sentence takes the stamp of its line or of the
    last line with one. With times of validity it takes its own time, or the time told last.

    """
    rule = settings or DriverSettings()
    name = os.fspath(path)
    files = open_csv(name, rule) or open_log(name, rule)
    if not _has_motion(files):
        return LoggedMotion()
    columns: dict[tuple[str, str], _Columns] = {}
    counts: Counter[str] = Counter()
    for name, stamp_ns, told in _Reader(files, rule, counts).read():
        columns.setdefault((told.what, name), _Columns()).add(stamp_ns, told)
    rows, sentences = {}, {}
    for what in (POSITION, COURSE, RATE):
        names = [name for each, name in columns if each == what]
        if names:
            best = min(names, key=lambda name: list(MOTION_KINDS).index(name[2:]))
            rows[what], sentences[what] = columns[what, best].to_motion(what), best
    return LoggedMotion(rows, sentences, dict(sorted(counts.items())))


def _has_motion(files: LogFiles) -> bool:
    """Tell whether a log may have such a sentence; a csv has none."""
    if is_csv_file(files.paths[0]):
        return False
    tail = b''
    for block in files.bare_blocks():
        text = tail + block
        if any(token in text for token in _TOKENS):
            return True
        tail = block[-4:]
    return False


class _Reader:
    """Yields what the sentences of a log tell, with their stamps."""

    def __init__(self, files: LogFiles, rule: DriverSettings, counts: Counter[str]) -> None:
        self._files, self._counts = files, counts
        self._lenient = rule.checksum == 'if_present'
        self._validity = rule.time == 'validity'
        days, self._stamps = start_stamps(rule, files)
        self._no_stamps = rule.stamp_format == 'none'
        self._times = StreamTimes(days, choose_time_sentences(files, self._validity))
        self._last_ns: int | None = None

    def read(self) -> Iterator[tuple[str, int, Told]]:
        """Yield name of the sentence, stamp, and what it tells."""
        framer = Framer(with_lines=True)
        for begins, block in self._files.blocks(_BLOCK):
            if begins is not None:
                self._stamps.begin_file(begins)
                self._last_ns = None
            yield from self._take(framer.feed(block, None))
        yield from self._take(framer.flush())

    def _take(self, frames: Iterable[tuple[int | None, bytes, bytes, bool, bytes]]
              ) -> Iterator[tuple[str, int, Told]]:
        for _, prefix, text, checked, suffix in frames:
            stamp_ns = self._stamp(prefix, text, suffix)
            kind = text[2:5]
            if kind not in _KINDS or text[5:6] != b',' or text[:1] == b'P':
                continue
            if not (checked or self._lenient):
                self._counts['no_checksum'] += 1
                continue
            if stamp_ns is None:
                self._counts['no_stamp'] += 1
                continue
            try:
                found = parse_motion(text)
            except Rejected as rejected:
                self._counts[f'{text[:5].decode("latin-1")}.{rejected.reason}'] += 1
                continue
            for told in found:
                yield text[:5].decode('latin-1'), stamp_ns, told

    def _stamp(self, prefix: bytes, text: bytes, suffix: bytes) -> int | None:
        """Return the stamp of a line, or of the last one that had one."""
        try:
            own_ns = (None if self._no_stamps or not (prefix or suffix)
                      else self._stamps.own_ns(prefix, suffix))
        except Rejected:
            own_ns = None
        if not self._validity:
            self._last_ns = self._last_ns if own_ns is None else own_ns
            return self._last_ns
        if text[2:5] in _TIMES and text[5:6] == b',' and self._times.tells(text):
            try:
                self._last_ns = self._times.read(text, own_ns)
            except ValueError:
                self._last_ns = None
        return self._own_time_ns(text, own_ns)

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
