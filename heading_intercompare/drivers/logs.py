# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Whole logs to headings: NMEA with or without stamps before the sentences, and csv."""

from __future__ import annotations

import dataclasses
import os
from os import PathLike
import re
from typing import Iterator

from heading_intercompare.core.records import Headings

from .csv_log import CsvDecoder, is_csv
from .nmea import NmeaDecoder
from .settings import DriverError, DriverSettings

__all__ = ['is_log', 'LogReader', 'read_log']

_HEAD_BYTES = 1 << 16
_MCAP = b'\x89MCAP'
_SENTENCE = re.compile(rb'[$!][A-Z]{2,}[A-Z0-9]*,')


def is_log(path: str | PathLike) -> bool:
    """
    Tell whether a path is a file whose beginning has an NMEA sentence or is a csv of headings.

    An MCAP file, also under another name, and a file that does not exist are none.
    """
    if not os.path.isfile(path) or os.fspath(path).endswith('.mcap'):
        return False
    with open(path, 'rb') as file:
        head = file.read(_HEAD_BYTES)
    if head.startswith(_MCAP):
        return False
    return is_csv(head.partition(b'\n')[0]) or _SENTENCE.search(head) is not None


class LogReader:
    """
    Reads the headings of a log, in chunks; iterate once.

    Parameters
    ----------
    path : path-like
        A log of NMEA sentences, or a csv of headings (`csv_log`).
    settings : DriverSettings, optional
        `source` and `speed` are ignored.
    block_bytes : int
        Bytes read at once; each block gives one chunk.

    Attributes
    ----------
    size, position : int
        Bytes of the log, and bytes read so far, to show progress.

    Raises
    ------
    OSError
        If the log cannot be read.
    DriverError
        If the log is empty, or a csv without the required columns.

    """

    def __init__(self, path: str | PathLike, settings: DriverSettings | None = None,
                 block_bytes: int = 1 << 20) -> None:
        self._path, self._block_bytes = os.fspath(path), block_bytes
        self.position = 0
        settings = settings or DriverSettings()
        with open(self._path, 'rb') as file:
            first = file.readline(4096)
            self.size = os.fstat(file.fileno()).st_size
        if not first:
            raise DriverError(f'{self._path}: no lines')
        if is_csv(first):
            self._decoder = CsvDecoder(self._path, first, settings)
        else:
            self._decoder = NmeaDecoder(
                dataclasses.replace(settings, source=f'file:{self._path}'))

    @property
    def counts(self) -> dict[str, int]:
        """Everything so far that gave no heading, by reason; see `NmeaDecoder.counts`."""
        return self._decoder.counts

    @property
    def sentence(self) -> str | None:
        """Talker and kind of the chosen sentence ('HEHDT'); None if unknown yet, and for a csv."""
        name = getattr(self._decoder, 'chosen', None)
        return None if name is None else str(name)

    def __iter__(self) -> Iterator[Headings]:
        """Yield the chunks, in the order of the log."""
        with open(self._path, 'rb') as file:
            while block := file.read(self._block_bytes):
                self.position += len(block)
                yield self._decoder.feed(block, None)
        yield self._decoder.flush()


def read_log(path: str | PathLike, settings: DriverSettings | None = None
             ) -> tuple[Headings, dict[str, int]]:
    """
    Return all headings of a log, and counts of everything that gave none, by reason.

    Parameters
    ----------
    path : path-like
        A log of NMEA sentences, or a csv of headings.
    settings : DriverSettings, optional
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
        If the log is empty, or a csv without the required columns.

    """
    reader = LogReader(path, settings)
    headings = Headings.concatenate(list(reader))
    return headings, reader.counts
