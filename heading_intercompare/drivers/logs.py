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

"""Whole logs to headings: NMEA with or without stamps on the lines, and csv."""

from __future__ import annotations

import dataclasses
import os
from os import PathLike
from typing import Iterator

from heading_intercompare.core.count_words import count_words
from heading_intercompare.core.records import Headings, Quality
from heading_intercompare.core.units.angle_units import AngleWatch

from .csv_log import CsvDecoder, is_csv_file, open_csv
from .log_lines.log_files import is_several, list_files
from .log_lines.log_order import holds_sentences, open_log
from .nmea import NmeaDecoder
from .settings import DriverError, DriverSettings


def is_log(path: str | PathLike[str]) -> bool:
    """
    Tell whether a path names a log: its beginning has an NMEA sentence or is a csv of headings.

    A folder or a pattern of names is a log if one of its files is one and none is part of a bag.
    An MCAP file, also under another name, and a file that does not exist are none.
    """
    name = os.fspath(path)
    if is_several(name):
        return any(holds_sentences(file) or is_csv_file(file) for file in list_files(name))
    if not os.path.isfile(name) or name.endswith('.mcap'):
        return False
    return is_csv_file(name) or holds_sentences(name)


class LogReader:
    """
    Reads the headings of a log, in chunks; iterate once.

    Parameters
    ----------
    path : path-like
        A log of NMEA sentences, or a csv of headings (`csv_log`): a file, a folder of files, or a
        pattern of names (`LogFiles`).
    settings
        `source` and `speed` are ignored.
    block_bytes
        Bytes read at once; each block gives one chunk.

    Attributes
    ----------
    size : int
        Bytes of the log on the disk.

    Raises
    ------
    OSError
        If the log cannot be read.
    DriverError
        If the log is empty, a csv without the required columns, holds headings of several
        instruments of the same talker, or headings that look like radians.

    """

    def __init__(self, path: str | PathLike[str], settings: DriverSettings | None = None,
                 block_bytes: int = 1 << 20) -> None:
        self._path, self._block_bytes = os.fspath(path), block_bytes
        settings = settings or DriverSettings()
        self._files = open_csv(self._path, settings) or open_log(self._path, settings)
        self.size = self._files.size
        if not next(self._files.bare_blocks(), b''):
            raise DriverError(f'{self._path}: no lines')
        self._nmea: NmeaDecoder | None = None
        if is_csv_file(self.paths[0]):
            self._csv = CsvDecoder(self.paths[0], settings)
        else:
            self._nmea = NmeaDecoder(
                dataclasses.replace(settings, source=f'file:{self._path}'), self._files)

    @property
    def paths(self) -> list[str]:
        """Return the files of the log, in the order in which they are read."""
        return self._files.paths

    @property
    def position(self) -> int:
        """Bytes read so far."""
        return self._files.position

    @property
    def share_read(self) -> str:
        """Return how much of the log is read, as 12%, to show progress."""
        return self._files.share_read

    @property
    def remarks(self) -> list[str]:
        """Return what a reader of the verdict should know of how the log was read, in words."""
        words = []
        if len(self.paths) > 1:
            words.append(f'{len(self.paths)} files')
        if self._nmea is not None:
            if self._nmea.stamps.borrowed:
                words.append(f'{self._nmea.stamps.borrowed} headings with the stamp of a line '
                             'before theirs')
            if self._nmea.chosen is not None and self._nmea.turns:
                talkers = (self._nmea.chosen.talker, *self._nmea.turns)
                words.append(f'{" and ".join(talkers)} send in turns: if they are one receiver, '
                             f'take all its headings with `talker` {",".join(talkers)}')
            if n_missing := self._nmea.numbers.n_missing:
                words.append(f'{count_words(n_missing, "line")} missing by the numbers n:')
            words += filter(None, (self._nmea.days.origin, self._nmea.undone))
        return words + [f'{path} ends too early' for path in self._files.cut] + [
            f'{path} is a link that leads nowhere' for path in self._files.dangling]

    @property
    def counts(self) -> dict[str, int]:
        """Everything so far that gave no heading, by reason; see `NmeaDecoder.counts`."""
        return self._csv.counts if self._nmea is None else self._nmea.counts

    @property
    def sentence(self) -> str | None:
        """Return talker and kind in one word, HEHDT; None if unknown, and for a csv."""
        name = None if self._nmea is None else self._nmea.chosen
        return None if name is None else str(name)

    def drain_quality(self, *, end: bool = False) -> Quality:
        """Return what the sensor said of its headings; see `NmeaDecoder.drain_quality`."""
        return (Quality.empty() if self._nmea is None else
                self._nmea.drain_quality(end=end))

    def __iter__(self) -> Iterator[Headings]:
        """Yield the chunks, in the order of the log."""
        watch = AngleWatch()
        for chunk in self._chunks():
            watch.update(chunk.stamp_ns, chunk.heading_deg)
            yield chunk
        if watch.words:
            raise DriverError(f'{self._path}: {watch.words}, as '
                              + ('a column heading_deg must be; name it heading_rad or heading_rev'
                                 if self._nmea is None else 'in these sentences'))

    def _chunks(self) -> Iterator[Headings]:
        if self._nmea is None:
            for begins, block in self._files.blocks(self._block_bytes):
                if begins not in (None, self.paths[0]):
                    yield self._csv.flush()
                    self._csv.begin_file(begins)
                yield self._csv.feed(block)
            yield self._csv.flush()
            return
        for begins, block in self._files.blocks(self._block_bytes):
            yield self._nmea.feed(block, None, file=begins)
        yield self._nmea.flush()
        self._nmea.refuse_several_instruments(self._path)


def read_log(path: str | PathLike[str], settings: DriverSettings | None = None
             ) -> tuple[Headings, dict[str, int]]:
    """
    Return all headings of a log, and counts of everything that gave none, by reason.

    Parameters
    ----------
    path : path-like
        A log of NMEA sentences, or a csv of headings.
    settings
        Sentence, talker, time, form of the stamps; `source` and `speed` are ignored.

    Returns
    -------
    headings : Headings
        In the order of the log; the stamps need not increase. Empty if no line gives a heading.
    counts : dict of str to int
        Lines by reason, see `NmeaDecoder.counts`; with the headings they add up to all lines.

    Raises
    ------
    OSError
        If the log cannot be read.
    DriverError
        As `LogReader`.

    """
    reader = LogReader(path, settings)
    headings = Headings.concatenate(list(reader))
    return headings, reader.counts
