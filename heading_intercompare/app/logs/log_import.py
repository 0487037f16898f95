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

"""The import of one log: its headings, and where they come from."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
import os
import time
from typing import Any, Callable, Mapping, Sequence

from heading_intercompare.app.sources.file_hash import hash_files
from heading_intercompare.core.records import Headings, Quality
from heading_intercompare.core.runs.growing_columns import GrowingHeadings
from heading_intercompare.drivers.log_lines.rollovers import describe_far
from heading_intercompare.drivers.logs import LogReader
from heading_intercompare.drivers.refused_lines import explain_no_heading, name_options
from heading_intercompare.drivers.settings import DriverError, DriverSettings
from heading_intercompare.readers.registry import open_log_of_streams, sources_of
from heading_intercompare.readers.stream_recording import StreamOptions

_READING = ('own_sentence', 'talker', 'instrument', 'variation_deg', 'deviation_table',
            'stamp_pattern', 'stamp_zone', 'time_column', 'date', 'checksum', 'bursts')


@dataclass(frozen=True, slots=True)
class ImportedLog:
    """
    The headings of a log, with its provenance.

    Attributes
    ----------
    path
        Path as given.
    headings
        In the order of the log.
    sha256
        Hash of the log; of several files, of their bytes in order.
    size
        Its length, bytes.
    sentence
        Talker and kind of the sentence taken ('HEHDT'); None for a csv.
    not_taken
        Lines that gave no heading, by reason.
    driver
        How it was read.
    files
        The number of its files.
    remarks
        What a reader of the verdict should know of how it was read.
    quality
        What the sensor says of its headings; None if that is not read.

    """

    path: str
    headings: Headings
    sha256: str
    size: int
    sentence: str | None
    not_taken: Mapping[str, int]
    driver: DriverSettings
    files: int = 1
    remarks: Sequence[str] = ()
    quality: Quality | None = None

    @property
    def origin(self) -> dict[str, Any]:
        """Return the provenance as a bag keeps it."""
        driver_options = describe_reading_options(self.driver)
        if self.files > 1:
            driver_options['files'] = self.files
        return {'path': self.path, 'sha256': self.sha256, 'bytes': self.size,
                'sentence': self.sentence, 'time': self.driver.time,
                'stamp_format': self.driver.stamp_format, 'headings': len(self.headings),
                **driver_options,
                **{f'not_taken.{reason}': n for reason, n in self.not_taken.items()}}

    @property
    def words_not_taken(self) -> str:
        """Return the lines that gave no heading, in words."""
        return ', '.join(f'{n} {reason}' for reason, n in sorted(self.not_taken.items())
                         if n) or 'nothing'


def describe_reading_options(driver: DriverSettings) -> dict[str, Any]:
    """Return what is stated of how a file is read, as a bag keeps it."""
    default = DriverSettings()
    return {name: getattr(driver, name) for name in _READING
            if getattr(driver, name) != getattr(default, name)}


def options_for(driver: DriverSettings, unit: str = 'auto') -> StreamOptions:
    """Return what is stated of a file of streams that is the log of one sensor."""
    return StreamOptions(driver, (driver.talker,) if driver.talker else (), lambda stream: unit)


def import_log(path: str, driver: DriverSettings,
               progress: Callable[[str], None] = lambda text: None, *,
               role: str | None = None, unit: str = 'auto') -> ImportedLog:
    """
    Read the headings of a log.

    Parameters
    ----------
    path
        A log of NMEA sentences: a file, a folder of files, or a pattern of names; or a csv of
        headings.
    driver
        Sentence, talker, time, form of the stamps; `source` and `speed` are ignored.
    progress
        Called with the progress in words.
    role : {'ts', 'rs'}, optional
        The sensor that must have headings in it.
    unit : {'auto', 'deg', 'rad', 'rev'}
        Unit that is stated for the headings of a file of streams.

    Raises
    ------
    OSError
        If the log cannot be read.
    DriverError
        If it is empty, a csv without the required columns, or of several instruments; or if it
        has no heading of the sensor that must have some. What to set is named by the options of
        the command line.

    """
    options = options_for(driver, unit)
    streams = open_log_of_streams(path, options)
    if streams is not None:
        name = streams.only(driver.talker)
        return ImportedLog(path=path, headings=streams.streams[name],
                           sha256=hash_files(sources_of(path, options) or [path]),
                           size=os.path.getsize(path), sentence=name, not_taken=streams.not_taken,
                           driver=driver, remarks=[
                               *streams.oddities, *_describe_span(streams.streams[name])])
    try:
        reader = LogReader(path, driver)
        readings, quality = GrowingHeadings(), []
        for chunk in reader:
            readings.append(chunk)
            quality.append(reader.drain_quality())
            progress(f'{reader.share_read} of {path} read')
    except DriverError as error:
        raise DriverError(name_options(str(error), role)) from None
    log = ImportedLog(path=path, headings=readings.headings,
                      sha256=hash_files(reader.paths), size=reader.size, sentence=reader.sentence,
                      not_taken=reader.counts, driver=driver, files=len(reader.paths),
                      remarks=[name_options(remark, role) for remark in reader.remarks],
                      quality=Quality.concatenate([*quality, reader.drain_quality(end=True)]))
    log = dataclasses.replace(log, remarks=[*log.remarks, *_describe_span(log.headings)])
    if role is not None and not len(log.headings):
        raise DriverError(_no_heading(log, role))
    return log


def describe_far_stamps(first_ns: int | None, last_ns: int | None) -> list[str]:
    """Return what to know of a span with stamps before 2000 or in the future, in lines."""
    words = '' if first_ns is None or last_ns is None else describe_far(
        first_ns, last_ns, time.time_ns())
    return [name_options(words, None)] if words else []


def _describe_span(headings: Headings) -> list[str]:
    stamp_ns = headings.stamp_ns
    return (describe_far_stamps(int(stamp_ns.min()), int(stamp_ns.max())) if len(headings)
            else [])


def _no_heading(log: ImportedLog, role: str) -> str:
    """Return why a log has no heading, in one line."""
    why = '' if log.sentence is None and not log.not_taken else (
        name_options(explain_no_heading(log.path, log.driver, log.not_taken), role))
    return (f'{log.path}: no heading in it, read as the {role.upper()} (not taken: '
            f'{log.words_not_taken}); {why}')
