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

import codecs
import math
import re

import numpy as np

from heading_intercompare.bags.csv.csv_rows import CsvRows
from heading_intercompare.bags.csv.plain_rows import Flags, PlainRows
from heading_intercompare.bags.errors import BagError
from heading_intercompare.core.records import ColumnBuffer, Headings, Integers
from heading_intercompare.core.units.angle_units import find_named_unit
from heading_intercompare.drivers.csv_log import COLUMNS_OF_LOG
from heading_intercompare.drivers.sentences import Rejected

from .json_lines import is_heading_name
from .motion_columns import find_motion_columns, make_motion
from .stamp_columns import find_time_columns, StampColumns, TIMES
from .stream_recording import Collected, ReaderError, StreamOptions, UNSTATED

_WANTED = f'of times ({", ".join(TIMES)}) and of headings'
_SPLIT = re.compile(r'[,;\t]')
_SEPARATOR_LINE = re.compile(r'sep=.\s*\Z', re.IGNORECASE)
_UTF16 = codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE
_SHOWN = 80


def is_table(head: bytes, options: StreamOptions = UNSTATED) -> bool:
    """
    Tell whether a file that begins so is a csv with a column of times and one of headings.

    A column that the options name is one of headings; then the column of times may have any name.
    """
    names = _names_in(head)
    # A csv with these columns is a log of the drivers.
    if 'heading_deg' in names and not COLUMNS_OF_LOG.isdisjoint(names):
        return False
    if len(names) > 1 and any(map(options.is_wanted, names)):
        return True
    return bool(find_time_columns(names, options.stamps.time_column)
                and any(map(is_heading_name, names)))


def list_columns(head: bytes) -> list[str]:
    """Return the columns of a csv that begins so and has one of times; [] if it is none."""
    names = _names_in(head)
    return names if len(names) > 1 and find_time_columns(names) else []


def _names_in(head: bytes) -> list[str]:
    """Return the names in the header of a csv that begins so."""
    lines = (line for line in _decode(head).splitlines()
             if line.strip() and not line.startswith('#') and not _SEPARATOR_LINE.match(line))
    return [name.strip(' "') for name in _SPLIT.split(next(lines, ''))]


def _decode(head: bytes) -> str:
    """Return the text that a file begins with."""
    return (head[:len(head) // 2 * 2].decode('utf-16', 'replace') if head[:2] in _UTF16
            else head.decode('utf-8-sig', 'replace'))


def read_table(path: str, options: StreamOptions = UNSTATED) -> Collected:
    """
    Read a csv with columns of times and columns of headings.

    A stream is a column whose name says that it is a heading, see `is_heading_name`, or that the
    options name. The name may also tell the unit (``hdg_rad``). The times have the forms of the
    stamps of logs, or are numbers of one unit; see `StampColumns`. Columns such as `lat` and
    `lon`, `cog` and `sog_kn`, and `rot_deg_min` tell the motion of the ship; see
    `find_motion_columns`.

    Raises
    ------
    OSError
        If the file cannot be read.
    ReaderError
        If the form of the csv is wrong, its times have no year, no row has a stamp that can be
        read, or a column that the options name has no number.

    """
    collected = Collected()
    try:
        with CsvRows(path, _WANTED) as rows:
            stamps = StampColumns(path, rows.names, options.stamps)
            headings = _HeadingCells(collected, rows, options)
            motion = _MotionRows(rows)
            n_stamps = 0
            for part in rows.parts():
                if isinstance(part, PlainRows):
                    options.progress(f'{part.line:,} lines')
                    stamp_ns, stamped = stamps.read_many(rows, part, collected.not_taken)
                    n_stamps += int(np.count_nonzero(stamped))
                    headings.take_many(stamp_ns, stamped, part)
                    motion.take_many(stamp_ns, stamped, part)
                    continue
                try:
                    row_ns = stamps.read(rows, part)
                except Rejected as rejected:
                    collected.not_taken[rejected.reason] += 1
                    continue
                n_stamps += 1
                headings.take(row_ns, part)
                motion.take(row_ns, part)
            motion.give(collected)
            collected.other_columns = [name for name in rows.names if name and name not in (
                *stamps.names, *headings.names, *motion.names)]
            if rows.cut:
                collected.not_taken['cut_line'] += 1
    except BagError as error:
        raise ReaderError(path, error.problem) from error
    if refusal := (not n_stamps and stamps.refusal) or headings.refusal:
        raise ReaderError(path, refusal)
    collected.oddities += filter(None, (
        stamps.origin, stamps.refusal and f'first row without a stamp: {stamps.refusal}'))
    return collected


class _HeadingCells:
    """The cells of the columns of headings."""

    def __init__(self, collected: Collected, rows: CsvRows, options: StreamOptions) -> None:
        self._collected, self._rows = collected, rows
        self._columns = [
            (place, name, find_named_unit(name)) for place, name in enumerate(rows.names)
            if is_heading_name(name) or options.is_wanted(name)]
        self._wanted = {*filter(options.is_wanted, rows.names)}
        self._wrong: dict[str, str] = {}

    @property
    def names(self) -> list[str]:
        """Return the columns of headings."""
        return [name for _, name, _ in self._columns]

    @property
    def refusal(self) -> str:
        """Return the first wrong cell of a column that is wanted and has no number; '' if none."""
        return next((words for name, words in self._wrong.items()
                     if name in self._wanted and name not in self._collected.kinds), '')

    def take(self, stamp_ns: int, row: list[str]) -> None:
        for place, name, unit in self._columns:
            angle = self._read(name, row[place] if place < len(row) else '')
            if angle is not None:
                self._collected.add_angle(name, 'csv', stamp_ns, angle, unit)

    def take_many(self, stamp_ns: Integers, stamped: Flags, plain: PlainRows) -> None:
        for place, name, unit in self._columns:
            angles, good = plain.reals(place, self._rows.mark)
            empty = plain.empty(place)
            if n_empty := int(np.count_nonzero(stamped & empty)):
                self._collected.not_taken['empty_heading'] += n_empty
            good &= stamped
            for at in np.flatnonzero(stamped & ~good & ~empty).tolist():
                self._rows.line = plain.line + at
                angle = self._read(name, plain.row(at)[place])
                if angle is not None:
                    angles[at], good[at] = angle, True
            if good.any():
                self._collected.add_angles(name, 'csv', Headings(stamp_ns[good], angles[good]),
                                           unit)

    def _read(self, name: str, cell: str) -> float | None:
        """Return the angle in a cell of a column; None, and count why, without one."""
        try:
            angle = float(self._rows.plain(cell)) if cell.strip() else math.nan
        except ValueError:
            self._collected.not_taken['bad_field'] += 1
            if name not in self._wrong:
                self._wrong[name] = (
                    f'line {self._rows.line}: column {name}: {cell.strip()[:_SHOWN]!r} is no '
                    f'number of a heading{self._rows.why_no_number(cell)}; choose another column '
                    'with --ts and --rs')
            return None
        if math.isnan(angle):
            self._collected.not_taken['empty_heading'] += 1
            return None
        return angle


class _MotionRows:
    """The cells of the columns of motion as numbers; nan where a row has none."""

    def __init__(self, rows: CsvRows) -> None:
        self._rows, self._columns = rows, find_motion_columns(rows.names)
        self.names = [name for column in self._columns for name in column.names]
        self._places = [*map(rows.names.index, self.names)]
        self._buffer = ColumnBuffer(len(self._places))
        self._chunks: list[list[np.ndarray]] = []

    def take(self, stamp_ns: int, row: list[str]) -> None:
        if self._places:
            self._buffer.add(stamp_ns, *(_number(self._rows, row, place)
                                         for place in self._places))

    def take_many(self, stamp_ns: Integers, stamped: Flags, plain: PlainRows) -> None:
        if not self._places:
            return
        columns: list[np.ndarray] = [stamp_ns[stamped]]
        for place in self._places:
            values, good = plain.reals(place, self._rows.mark)
            values[~good] = math.nan
            for at in np.flatnonzero(stamped & ~good & ~plain.empty(place)).tolist():
                values[at] = _number(self._rows, plain.row(at), place)
            columns.append(values[stamped])
        self._chunks += [self._buffer.drain(), columns]

    def give(self, collected: Collected) -> None:
        stamps, *columns = map(np.concatenate, zip(*self._chunks, self._buffer.columns()))
        for motion_column in self._columns:
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
