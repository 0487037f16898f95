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

"""Csv tables of other programs, such as OpenRVDAS and UHDAS: a column of times, and headings."""

from __future__ import annotations

import math
import re

from heading_intercompare.bags.csv.csv_rows import CsvRows
from heading_intercompare.bags.csv.stamp_cells import nanoseconds, utc_nanoseconds
from heading_intercompare.bags.errors import BagError
from heading_intercompare.core.records import ColumnBuffer
from heading_intercompare.core.units.angle_units import find_named_unit
from heading_intercompare.core.units.given_stamps import find_unit

from .json_lines import is_heading_name
from .motion_columns import find_motion_columns, make_motion, MotionColumn
from .stream_recording import Collected, ReaderError

TIMES = ('t_ns', 'stamp_ns', 'stamp_s', 'stamp_utc', 'timestamp', 'utc', 'datetime', 'date_time',
         'time', 't', 'epoch', 'unixtime', 'u_dday', 'dday')
"""Names of columns of times, in the order in which one is chosen."""

_WANTED = f'of times ({", ".join(TIMES)}) and of headings'
_SPLIT = re.compile(r'[,;\t]')


def find_time_column(names: list[str]) -> str | None:
    """Return the column of times among the names of a header; None if there is none."""
    by_name = {name.lower(): name for name in reversed(names)}
    return next((by_name[name] for name in TIMES if name in by_name), None)


def is_table(head: bytes) -> bool:
    """Tell whether a file that begins so is a csv with a column of times and one of headings."""
    lines = (line for line in head.decode('utf-8-sig', 'replace').splitlines()
             if line.strip() and not line.startswith('#'))
    names = [name.strip(' "') for name in _SPLIT.split(next(lines, ''))]
    # A csv with this column is a log of the drivers.
    return ('heading_deg' not in names and find_time_column(names) is not None
            and any(map(is_heading_name, names)))


def parse_time(text: str) -> int:
    """
    Return a time as a stamp: ISO, or a number of seconds to nanoseconds since 1970.

    Raises
    ------
    ValueError, ArithmeticError
        If it is none.

    """
    if not text.replace('.', '', 1).isdecimal():
        return utc_nanoseconds(text)
    whole = int(text.partition('.')[0])
    unit = find_unit(whole, whole)
    if unit is None:
        raise ValueError(text)
    _, unit_ns = unit
    return nanoseconds(text) if unit_ns == 1_000_000_000 else whole * unit_ns


def read_stamp(rows: CsvRows, row: list[str], at: int) -> int:
    """
    Return the time in a cell of a row as a stamp; see `parse_time`.

    Raises
    ------
    ValueError, ArithmeticError, IndexError
        If there is none.

    """
    return parse_time(row[at].strip() if ':' in row[at] else rows.plain(row[at]))


def read_table(path: str) -> Collected:
    """
    Read a csv with a column of times and columns of headings.

    A stream is a column whose name says that it is a heading; see `is_heading_name`. It may also
    tell the unit (``hdg_rad``). Times are
    ISO, or seconds, milli-, micro- or nanoseconds since 1970. Columns such as `lat` and `lon`,
    `cog` and `sog_kn`, and `rot_deg_min` tell the motion of the ship; see `find_motion_columns`.

    Raises
    ------
    OSError
        If the file cannot be read.
    ReaderError
        If the form of the csv is wrong, or its times have no year.

    """
    collected = Collected()
    try:
        with CsvRows(path, _WANTED) as rows:
            time = find_time_column(rows.names)
            if time is None:
                raise ReaderError(path, f'has no column {_WANTED}')
            if time.lower().endswith('dday'):
                raise ReaderError(path, f'column {time}: a decimal day has no year; add a column '
                                  'stamp_utc or t_ns')
            at, headings = rows.names.index(time), [
                (place, name) for place, name in enumerate(rows.names) if is_heading_name(name)]
            motion = find_motion_columns(rows.names)
            motion_rows = _MotionRows([
                rows.names.index(name) for column in motion for name in column.names])
            for row in rows:
                stamp_ns = _take_row(collected, rows, row, at, headings)
                if motion and stamp_ns is not None:
                    motion_rows.take(stamp_ns, row, rows)
            motion_rows.give(collected, motion)
            if rows.cut:
                collected.not_taken['cut_line'] += 1
    except BagError as error:
        raise ReaderError(path, error.problem) from error
    return collected


class _MotionRows:
    """The cells of some columns as numbers; nan where a row has none."""

    def __init__(self, places: list[int]) -> None:
        self._places = places
        self._buffer = ColumnBuffer(len(places))

    def take(self, stamp_ns: int, row: list[str], rows: CsvRows) -> None:
        self._buffer.add(stamp_ns, *(_number(rows, row, place) for place in self._places))

    def give(self, collected: Collected, motion: list[MotionColumn]) -> None:
        stamps, *columns = self._buffer.columns()
        for motion_column in motion:
            n = len(motion_column.names)
            values, columns = columns[:n], columns[n:]
            collected.add_motion_chunk(motion_column.what, ' '.join(motion_column.names),
                                       *make_motion(motion_column, stamps, values))


def _number(rows: CsvRows, row: list[str], place: int) -> float:
    """Return the number in a cell; nan without one."""
    try:
        return float(rows.plain(row[place]))
    except (ValueError, IndexError):
        return math.nan


def _take_row(collected: Collected, rows: CsvRows, row: list[str], at: int,
              headings: list[tuple[int, str]]) -> int | None:
    """Take the headings of a row; return its stamp, None if it has none."""
    try:
        stamp_ns = read_stamp(rows, row, at)
    except (ValueError, ArithmeticError, IndexError):
        collected.not_taken['bad_stamp'] += 1
        return None
    for place, name in headings:
        cell = row[place] if place < len(row) else ''
        try:
            heading = float(rows.plain(cell)) if cell.strip() else None
        except ValueError:
            collected.not_taken['bad_field'] += 1
            continue
        if heading is None or heading != heading:
            collected.not_taken['empty_heading'] += 1
        else:
            collected.add_angle(name, 'csv', stamp_ns, heading, find_named_unit(name))
    return stamp_ns
