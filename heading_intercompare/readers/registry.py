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

"""
The registry of readers: what a file is, by its content first and its name second.

A recording has the headings of one or several sensors, by stream. A library of an extra is loaded
only when a file needs it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
import os
from pathlib import Path
import re
import sqlite3
from typing import Callable, TYPE_CHECKING

from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.drivers.csv_log import is_csv_file
from heading_intercompare.drivers.log_lines.log_files import is_several, list_files
from heading_intercompare.drivers.logs import is_log, LogReader
from heading_intercompare.drivers.refused_lines import explain_no_heading, name_options
from heading_intercompare.natural_order import natural_key

from . import json_lines, nmea2000, tables
from .stream_recording import Collected, ReaderError, StreamOptions, StreamRecording, UNSTATED
from .topic_bag import TopicBag
from .written_files import find_written_file, WrittenFile

if TYPE_CHECKING:
    from .rosbag_recording import RosbagRecording

    Recording = BagReader | StreamRecording | RosbagRecording


_HEAD_BYTES = 1 << 16
_ROS1, _SQLITE, _PARQUET = b'#ROSBAG V2.0\n', b'SQLite format 3\0', b'PAR1'
_TABLES = {'messages', 'topics'}


@dataclass(frozen=True, slots=True)
class Format:
    """
    A kind of file that can be read.

    Attributes
    ----------
    name
        What it is, in words.
    recognise
        Tells from the path, the first 64 KiB of the file and what is stated whether it is one; a
        directory has no bytes.
    read
        Reads the headings of the file at a path, by stream, as stated; None for a bag.
    extra
        The extra that it needs.

    """

    name: str
    recognise: Callable[[Path, bytes, StreamOptions], bool]
    read: Callable[[str, StreamOptions], Collected] | None
    extra: str | None = None


def _is_sqlite_bag(path: Path, head: bytes, options: StreamOptions = UNSTATED) -> bool:
    """Tell whether a path is a rosbag2 in SQLite, or one that is compressed by file."""
    if path.is_dir():
        return not any(path.glob('*.mcap*')) and any(
            file for form in ('*.db3', '*.db3.zstd') for file in path.glob(form))
    return head.startswith(_SQLITE) and _TABLES <= _tables_of(path)


def _tables_of(path: Path) -> set[str]:
    try:
        connection = sqlite3.connect(f'{path.absolute().as_uri()}?immutable=1', uri=True)
    except sqlite3.Error:
        return set()
    try:
        return {name for name, in connection.execute('SELECT name FROM sqlite_master')}
    except sqlite3.Error:
        # Damaged: what it was can only be told by its name.
        return _TABLES if path.suffix == '.db3' else set()
    finally:
        connection.close()


def _read_parquet(path: str, options: StreamOptions) -> Collected:
    from .parquet import read_parquet
    return read_parquet(path, options)


def _read_log(path: str, options: StreamOptions) -> Collected:
    """Read a log of the drivers; its stream is the sentence that it gives by default."""
    collected, reader = Collected(), LogReader(path, options.stamps)
    chunks = list(reader)
    for chunk in chunks:
        if len(chunk):
            collected.add_chunk(reader.sentence or 'csv', 'log', chunk)
    collected.not_taken.update(reader.counts)
    if not collected.kinds and collected.not_taken:
        collected.oddities.append(name_options(
            explain_no_heading(path, options.stamps, reader.counts), 'ts'))
    return collected


def _of_head(tell: Callable[[bytes], bool]) -> Callable[[Path, bytes, StreamOptions], bool]:
    return lambda path, head, options: tell(head)


def _of_frames(form: nmea2000.FrameForm) -> Callable[[Path, bytes, StreamOptions], bool]:
    """Tell whether a log has frames; where a sentence is stated, it has none in sentences."""
    return lambda path, head, options: (
        form.is_in(head) and not (form.sentence and options.stamps.kind != 'auto'))


def _as_is(read: Callable[[str], Collected]) -> Callable[[str, StreamOptions], Collected]:
    """Return the reader of files of which nothing can be stated."""
    return lambda path, options: read(path)


def _is_log(path: Path, head: bytes, options: StreamOptions) -> bool:
    """Tell whether a path is a log of the drivers; a csv of another program is none."""
    return is_log(path) and not (
        path.is_file() and is_csv_file(os.fspath(path)) and tables.is_table(head, options))


_LOG = Format('log of one sensor', _is_log, _read_log)

FORMATS = (
    Format('rosbag2, SQLite', _is_sqlite_bag, None, 'bags'),
    Format('ROS 1 bag', _of_head(lambda head: head.startswith(_ROS1)), None, 'bags'),
    Format('Parquet', _of_head(lambda head: head.startswith(_PARQUET)), _read_parquet,
           'parquet'),
    Format('NMEA 2000, canboat JSON', _of_head(nmea2000.is_canboat_json),
           _as_is(nmea2000.read_canboat_json)),
    *(Format(f'NMEA 2000, {form.program}', _of_frames(form),
             partial(nmea2000.read_frames, form)) for form in nmea2000.FRAME_FORMS),
    Format('Signal K deltas', _of_head(json_lines.is_signalk), _as_is(json_lines.read_signalk)),
    Format('gpsd reports', _of_head(json_lines.is_gpsd), _as_is(json_lines.read_gpsd)),
    Format('OpenRVDAS records', _of_head(json_lines.is_openrvdas),
           _as_is(json_lines.read_openrvdas)),
    # A line of a log may look like the header of a table.
    _LOG,
    Format('csv of headings', lambda path, head, options: tables.is_table(head, options),
           tables.read_table),
)
"""The formats beside MCAP bags; the first that recognises a file reads it."""

#: Shown of a file whose form is not known.
_SHOWN_LETTERS, _SHOWN_BYTES = 80, 16
_MCAP = b'\x89MCAP'
_UNPACK = 'is compressed: unpack it and give the file that was in it'
#: First bytes, end of the name, and what to do; either may be given.
_UNREADABLE = (
    (b'', '.rbin', 'is a binary file of UHDAS: write it as csv with the columns t_ns and '
     'heading_deg'),
    (b'#ROSBAG V1', '', 'is a ROS 1 bag of version 1: convert it with `rosbag migrate`'),
    (b'', '.db3.zstd', 'is one file of a compressed bag: give the folder with its metadata.yaml, '
     'or unpack it with `zstd -d`'),
    (b'', '.xlsx', 'is a spreadsheet: save it as csv'),
    (b'', '.xls', 'is a spreadsheet: save it as csv'),
    (b'', '.ods', 'is a spreadsheet: save it as csv'),
    (b'\x1f\x8b', '', _UNPACK), (b'BZh', '', _UNPACK), (b'\xfd7zXZ', '', _UNPACK),
    (b'PK\x03\x04', '', _UNPACK), (b'\x28\xb5\x2f\xfd', '', _UNPACK),
    (b'7z\xbc\xaf', '', _UNPACK),
    (b'\x89HDF', '', 'is HDF5 or netCDF: write it as csv with the columns t_ns and heading_deg'),
    (b'CDF', '', 'is netCDF: write it as csv with the columns t_ns and heading_deg'),
    (b'MATLAB', '', 'is a file of MATLAB: write it as csv with the columns t_ns and heading_deg'),
    *((magic, '', 'is a capture of network packets: write their payloads as a log, with a stamp '
       'before each sentence') for magic in (
        b'\xd4\xc3\xb2\xa1', b'\xa1\xb2\xc3\xd4', b'\x4d\x3c\xb2\xa1', b'\xa1\xb2\x3c\x4d',
        b'\x0a\x0d\x0d\x0a')),
    (b'LOGG', '', 'is a CAN log of Vector: convert it to the form of `candump -l`'),
    *((magic, '', f'is a binary log of {maker}: write its headings as sentences or csv with the '
       "maker's converter") for magic, maker in (
        (b'\xb5b', 'u-blox (UBX)'), (b'$@', 'Septentrio (SBF)'), (b'\xaa\x44\x12', 'NovAtel'),
        (b'\xaa\x44\x13', 'NovAtel'), (b'\xaa\x44\xb5', 'Unicore'))),
    (b'<', '', 'is XML or HTML, such as GPX: write it as csv with the columns t_ns and '
     'heading_deg'),
    (b'%PDF', '', 'is a PDF: give the data that it was made of'),
    (b'', '.asc', 'is a CAN log of Vector: convert it to the form of `candump -l`'),
    *((b'', end, 'is a log of Kongsberg SIS: write its headings as csv with the columns t_ns and '
       'heading_deg') for end in ('.all', '.kmall')),
    (b'', '.ebl', 'is a log of Actisense: convert it with canboat (`analyzer -json`)'),
    (_SQLITE, '', 'is an SQLite file without the tables of a rosbag2 (messages, topics)'),
)


def _head(path: Path) -> bytes:
    if not path.is_file():
        return b''
    with path.open('rb') as file:
        return file.read(_HEAD_BYTES)


def find_format(path: str | os.PathLike[str],
                options: StreamOptions = UNSTATED) -> Format | None:
    """
    Return the format that a path has; None for a bag of MCAP and for any other.

    A folder, or a pattern of names, has the format of its files if they are those of one program.

    Raises
    ------
    OSError
        If the file cannot be read.

    """
    return _recognise(Path(path), options) or next(
        (replace(form, read=partial(_read_files, form))
         for form in _forms_of_files(os.fspath(path), options).values()), None)


def _recognise(place: Path, options: StreamOptions) -> Format | None:
    head = _head(place)
    written = find_written_file(place.name, head)
    if written is not None and written.contents != 'pairs':
        return None
    return next((form for form in FORMATS if form.recognise(place, head, options)), None)


def _files_of(path: str) -> list[str]:
    return list_files(path) if is_several(path) else []


def _forms_of_files(path: str, options: StreamOptions) -> dict[str, Format]:
    """Return the files of a folder or a pattern that have streams, with the format of each."""
    forms = {file: _recognise(Path(file), options) for file in _files_of(path)}
    return {file: form for file, form in forms.items()
            if form is not None and form.read is not None and form is not _LOG
            and not _has_pairs(file, form)}


def _read_files(form: Format, path: str, options: StreamOptions) -> Collected:
    """Read the files of a folder or a pattern, in the order of their first stamps."""
    assert form.read is not None
    forms = _forms_of_files(path, options)
    for file, file_form in forms.items():
        if file_form is not form:
            first = next(iter(forms))
            raise ReaderError(path, f'holds {form.name} ({first}) and {file_form.name} ({file}): '
                              'give the files of one form, as a pattern in quotes')
    collected = Collected()
    if len(forms) > 1:
        # The date of the first line is not that of each file; the name of a file may tell it.
        options = replace(options, stamps=replace(options.stamps, date=None))
    parts = {}
    for number, file in enumerate(forms):
        options.progress(f'{number} of {len(forms)} files')
        parts[file] = form.read(file, options)
    for file, part in sorted(parts.items(), key=lambda entry: entry[1].start_ns):
        part.oddities = [f'{file}: {words}' for words in part.oddities]
        collected.add_all(part)
    if left_out := len(_files_of(path)) - len(forms):
        collected.not_taken['file_of_another_form'] += left_out
    return collected


def find_written(path: str | os.PathLike[str]) -> WrittenFile | None:
    """Return what a file that this program writes is; None for any other file."""
    place = Path(path)
    return find_written_file(place.name, _head(place))


def is_verdict(path: str | os.PathLike[str]) -> bool:
    """Tell whether a file can only be a verdict in JSON: no log, table or other file is."""
    written = find_written(path)
    if written is not None:
        return written.contents == 'verdict'
    return Path(path).suffix.lower() == '.json' and find_format(path) is None


def refuse_unreadable(path: str | os.PathLike[str]) -> None:
    """
    Raise ReaderError for a file that cannot be read: what it is, or how it begins; what to do.

    An MCAP file, a file that is named like one, and one without anything but zeros, are left to
    the reader of bags.
    """
    place = Path(path)
    head, name = _head(place), place.name.lower()
    if (written := find_written_file(name, head)) is not None:
        raise ReaderError(path, f'is {written.name}: {written.use.format(os.fspath(path))}')
    for begin, end, problem in _UNREADABLE if head and not name.endswith('.mcap.zstd') else ():
        if head.startswith(begin) and name.endswith(end):
            raise ReaderError(path, problem)
    if names := tables.list_columns(head):
        raise ReaderError(path, 'is a table, and no column has the name of a heading: choose two '
                          f'with --ts and --rs from {", ".join(names)}')
    if any(head) and not head.startswith(_MCAP) and '.mcap' not in name:
        raise ReaderError(path, f'has no form that can be read: it begins with {_show(head)}. '
                          'A log has sentences such as $HEHDT, a table a header with the names of '
                          'its columns (analyze takes any two as --ts and --rs); docs/bags.md '
                          'lists all forms')


def _show(head: bytes) -> str:
    """Return how a file begins: its first line, or its first bytes if they are no text."""
    line = next((line for line in head.splitlines() if line.strip()), b'')
    try:
        text = line.decode().strip()
    except UnicodeDecodeError:
        text = ''
    if text.isprintable() and text:
        return repr(text if len(text) <= _SHOWN_LETTERS else f'{text[:_SHOWN_LETTERS]}...')
    return f'the bytes {head[:_SHOWN_BYTES].hex(" ")}'


def _library(error: ImportError) -> str:
    """Return the library that is not installed, or that does not fit the others."""
    if isinstance(error, ModuleNotFoundError) and error.name:
        return error.name.partition('.')[0]
    return f'another version of a library ({error})'


def _need(path: str | os.PathLike[str], form: Format, error: ImportError) -> ReaderError:
    return ReaderError(path, f'is {form.name}, and reading it needs {_library(error)}: install '
                       f'heading_intercompare[{form.extra}]')


def has_pairs(path: str | os.PathLike[str]) -> bool:
    """Tell whether a file is a Parquet table of pairs."""
    form = find_format(path)
    return form is not None and _has_pairs(path, form)


def _has_pairs(path: str | os.PathLike[str], form: Format) -> bool:
    if form.extra != 'parquet':
        return False
    try:
        from .parquet import has_pairs as of_parquet
    except ImportError as error:
        raise _need(path, form, error) from None
    return of_parquet(os.fspath(path))


def open_recording(path: str | os.PathLike[str], namespace: str | None = None,
                   options: StreamOptions = UNSTATED) -> Recording:
    """
    Open a recording of any kind.

    Parameters
    ----------
    path
        A bag of MCAP, or a file of one of `FORMATS`; a folder or a pattern of such files.
    namespace
        Where the topics of a bag without a leading slash are; see `BagReader`.
    options
        What is stated of a file of streams; of a bag the units count.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        If it is damaged, of an unknown form, or needs a library that is not installed.

    """
    form = find_format(path, options)
    if form is None:
        refuse_unreadable(path)
        return TopicBag(path, namespace, options.unit_of)
    try:
        if (read := form.read) is not None:
            return StreamRecording(path, form.name, lambda name: read(name, options),
                                   options.unit_of)
        from .rosbag_recording import RosbagRecording
    except ImportError as error:
        raise _need(path, form, error) from None
    return RosbagRecording(path, namespace, options.unit_of)


def open_log_of_streams(path: str | os.PathLike[str],
                        options: StreamOptions = UNSTATED) -> StreamRecording | None:
    """
    Open a file of streams of another program; None for a log of one sensor.

    Raises
    ------
    OSError
        If it cannot be read.
    ReaderError
        If it is damaged, a bag, or in a known form that cannot be read.

    """
    form = find_format(path, options)
    if form is None:
        refuse_unreadable(path)
    elif form.read is None:
        raise ReaderError(path, f'is a bag ({form.name}), no log: give it to analyze, with --ts '
                          'and --rs')
    if form is None or form is _LOG:
        return None
    recording = open_recording(path, options=options)
    return recording if isinstance(recording, StreamRecording) else None


def has_streams(path: str | os.PathLike[str],
                options: StreamOptions = UNSTATED) -> bool:
    """Tell whether a path is a file of streams of another program."""
    form = find_format(path, options)
    return form is not None and form.read is not None and form is not _LOG


def has_one_sensor(path: str | os.PathLike[str]) -> bool:
    """Tell whether a path is a log of one sensor."""
    return find_format(path) is _LOG


def sources_of(path: str | os.PathLike[str],
               options: StreamOptions = UNSTATED) -> list[Path]:
    """Return the files of a recording that is no MCAP bag, in natural order; otherwise []."""
    place = Path(path)
    if not place.is_dir() or not _is_sqlite_bag(place, b''):
        return [*map(Path, _forms_of_files(os.fspath(path), options))]
    return sorted((file for file in place.iterdir()
                   if re.search(r'\.db3(\.zstd)?$', file.name)),
                  key=natural_key)
