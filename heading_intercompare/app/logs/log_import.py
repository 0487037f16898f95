# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The import of one log: its headings, and where they come from."""

from __future__ import annotations

from dataclasses import dataclass
import os
from typing import Any, Callable, Mapping

from heading_intercompare.app.inputs import sha256
from heading_intercompare.core.records import Headings
from heading_intercompare.drivers.logs import LogReader
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.readers.registry import open_log_of_streams

__all__ = ['import_log', 'ImportedLog']


@dataclass(frozen=True, slots=True)
class ImportedLog:
    """
    The headings of a log, with its provenance.

    Attributes
    ----------
    path : str
        Path as given.
    headings : Headings
        In the order of the log.
    sha256 : str
        Hash of the log.
    size : int
        Its length, bytes.
    sentence : str or None
        Talker and kind of the sentence taken ('HEHDT'); None for a csv.
    not_taken : mapping of str to int
        Lines that gave no heading, by reason.
    driver : DriverSettings
        How it was read.

    """

    path: str
    headings: Headings
    sha256: str
    size: int
    sentence: str | None
    not_taken: Mapping[str, int]
    driver: DriverSettings

    @property
    def origin(self) -> dict[str, Any]:
        """The provenance as a bag keeps it."""
        return {'path': self.path, 'sha256': self.sha256, 'bytes': self.size,
                'sentence': self.sentence, 'time': self.driver.time,
                'stamp_format': self.driver.stamp_format, 'headings': len(self.headings),
                **{f'not_taken.{reason}': n for reason, n in self.not_taken.items()}}

    @property
    def words_not_taken(self) -> str:
        """The lines that gave no heading, in words."""
        return ', '.join(f'{n} {reason}' for reason, n in sorted(self.not_taken.items())
                         if n) or 'nothing'


def import_log(path: str, driver: DriverSettings,
               progress: Callable[[str], None] = lambda text: None) -> ImportedLog:
    """
    Read the headings of a log.

    Parameters
    ----------
    path : str
        A log of NMEA sentences, or a csv of headings.
    driver : DriverSettings
        Sentence, talker, time, form of the stamps; `source` and `speed` are ignored.
    progress : callable
        Called with the progress in words.

    Raises
    ------
    OSError
        If the log cannot be read.
    DriverError
        If it is empty, or a csv without the required columns.

    """
    streams = open_log_of_streams(path)
    if streams is not None:
        name = streams.only(driver.talker)
        return ImportedLog(path, streams.streams[name], sha256(path), os.path.getsize(path), name,
                           streams.not_taken, driver)
    reader = LogReader(path, driver)
    chunks = []
    for chunk in reader:
        chunks.append(chunk)
        progress(f'{reader.position / reader.size:.0%}')
    return ImportedLog(path, Headings.concatenate(chunks), sha256(path), reader.size,
                       reader.sentence, reader.counts, driver)
