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

"""The motion of the ship in a log of NMEA sentences, read on its own, beside the headings."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
import os
from typing import Iterator, Mapping

from heading_intercompare.core.records import Motion
from heading_intercompare.drivers.csv_log import is_csv_file, open_csv
from heading_intercompare.drivers.log_lines.log_files import LogFiles
from heading_intercompare.drivers.log_lines.log_order import open_log
from heading_intercompare.drivers.settings import DriverSettings

from .motion_lines import find_best, MotionColumns, MotionLine, MotionLines
from .motion_sentences import COURSE, MOTION_KINDS, POSITION, RATE

__all__ = ['LoggedMotion', 'read_log_motion']

_BLOCK = 1 << 20
_TOKENS = tuple(f'{kind},'.encode() for kind in MOTION_KINDS)


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
    last line with a stamp. With times of validity it takes its own time, or the time told last.

    """
    rule = settings or DriverSettings()
    name = os.fspath(path)
    files = open_csv(name, rule) or open_log(name, rule)
    if not _has_motion(files):
        return LoggedMotion()
    columns: dict[tuple[str, str], MotionColumns] = {}
    counts: Counter[str] = Counter()
    for name, stamp_ns, reading in _read_lines(MotionLines(rule, counts, files), files):
        columns.setdefault((reading.what, name), MotionColumns()).add(stamp_ns, reading)
    rows, sentences = {}, {}
    for what in (POSITION, COURSE, RATE):
        names = [name for quantity, name in columns if quantity == what]
        if names:
            best = find_best(names)
            rows[what], sentences[what] = columns[what, best].to_motion(what), best
    return LoggedMotion(rows, sentences, dict(sorted(counts.items())))


def _read_lines(lines: MotionLines, files: LogFiles) -> Iterator[MotionLine]:
    for begins, block in files.blocks(_BLOCK):
        if begins is not None:
            lines.begin_file(begins)
        yield from lines.feed(block)
    yield from lines.flush()


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
