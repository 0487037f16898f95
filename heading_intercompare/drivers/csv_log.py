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
Csv of headings, as decoders of NMEA 2000 (PGN 127250) write them: one file, or many of a log.

A header, then one row per reading. Columns `t_ns` (integer nanoseconds UTC) and `heading_deg` are
required; a heading may count from -180 as long as none exceeds 180. `deviation_deg`,
`variation_deg` (east positive), `reference_0true_1mag` and `src` are used if present. Reference 0
is a true heading; 1 is a magnetic one, to which deviation (0 if empty) and variation are added.
The setting `talker` selects one of several sources; without it, the first one is used.
"""

from __future__ import annotations

from collections import Counter

from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.records import ColumnBuffer, Headings

from .log_lines.log_files import head_of, is_several, LogFiles
from .log_lines.log_order import holds_sentences
from .sentences import Rejected
from .settings import DriverError, DriverSettings

_NEEDED = ('t_ns', 'heading_deg')
COLUMNS_OF_LOG = frozenset(('t_ns', 'src', 'reference_0true_1mag', 'deviation_deg',
                            'variation_deg'))
"""A csv with `heading_deg` and none of these columns is a table of another program."""


def _cells(line: bytes) -> list[str]:
    return [cell.strip() for cell in line.decode('utf-8', 'replace').lstrip('\ufeff').split(',')]


def is_csv_file(path: str) -> bool:
    """Tell whether a file begins with the header of a csv of headings."""
    first = head_of(path).partition(b'\n')[0]
    return b'heading_deg' in first and 'heading_deg' in _cells(first)


def open_csv(path: str, settings: DriverSettings) -> LogFiles | None:
    """
    Return the csv files of a folder or a pattern of names, in order of their first stamps.

    Returns
    -------
    LogFiles or None
        None for a single file, and where a file has sentences or none is a csv of headings.

    Raises
    ------
    OSError
        If a folder or a file in it cannot be read.
    DriverError
        If a csv lacks a required column.

    """
    if not is_several(path):
        return None
    files = LogFiles(path)
    if any(map(holds_sentences, files.paths)) or not any(map(is_csv_file, files.paths)):
        return None

    def first_ns(name: str) -> int | None:
        stamp_ns = CsvDecoder(name, settings).feed(head_of(name)).stamp_ns
        return int(stamp_ns[0]) if len(stamp_ns) else None
    files.keep(is_csv_file, first_ns)
    return files


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        raise Rejected('bad_field') from None


def _count_decimals(line: bytes) -> int:
    """Return how many decimals the number in the last cell of a line has."""
    decimals = line.rpartition(b',')[2].strip().partition(b'.')[2]
    return len(decimals) if decimals.isdigit() else 0


class CsvDecoder:
    """
    Turns the bytes of a csv log into headings; used like `NmeaDecoder`.

    Parameters
    ----------
    path
        The file, or the first of several.
    settings
        Only `talker` is used.

    Raises
    ------
    DriverError
        If a required column is missing.

    """

    def __init__(self, path: str, settings: DriverSettings) -> None:
        self._src = settings.talker
        self._counts_from_zero = False
        self._counts: Counter[str] = Counter()
        self._open = self._before = b''
        self.begin_file(path)

    def begin_file(self, path: str) -> None:
        """Go on with another file of the same log; its columns may have another order."""
        header = head_of(path).partition(b'\n')[0]
        self._columns = {name: i for i, name in enumerate(_cells(header))}
        missing = [name for name in _NEEDED if name not in self._columns]
        if missing:
            raise DriverError(f'{path}: column {missing[0]} is missing; a csv of headings must '
                              f'have the columns {" and ".join(_NEEDED)}')
        self._in_header = True

    @property
    def counts(self) -> dict[str, int]:
        """Rows so far that gave no heading, by reason."""
        return dict(sorted(self._counts.items()))

    def feed(self, data: bytes, received_ns: int | None = None) -> Headings:
        """Take bytes and return the headings of the rows that they complete."""
        lines = (self._open + data).split(b'\n')
        self._open = lines.pop()
        if self._in_header and lines:
            self._in_header = False
            del lines[0]
        self._before = lines[-1] if lines else self._before
        rows = ColumnBuffer()
        for line in lines:
            if not line.strip():
                continue
            try:
                rows.add(*self._read(_cells(line)))
            except Rejected as rejected:
                self._counts[rejected.reason] += 1
        stamps, headings = rows.drain()
        return Headings(stamps, wrap360(headings))

    def flush(self) -> Headings:
        """Return the last heading at the end of a file, unless its number is cut."""
        if self._open.strip() and _count_decimals(self._open) < _count_decimals(self._before):
            self._counts['cut_line'] += 1
            self._open = b''
        return self.feed(b'\n')

    def _read(self, row: list[str]) -> tuple[int, float]:
        columns = self._columns
        if len(row) != len(columns):
            raise Rejected('too_few_fields' if len(row) < len(columns) else 'bad_field')

        def cell(name: str) -> str:
            return row[columns[name]] if name in columns else ''

        src = cell('src')
        if self._src is None and src:
            self._src = src
        if src and src != self._src:
            raise Rejected(f'other_talker.{src}')
        if not cell('heading_deg'):
            raise Rejected('empty_heading')
        heading_deg = _number(cell('heading_deg'))
        if not (0.0 if self._counts_from_zero else -180.0) <= heading_deg <= 360.0:
            raise Rejected('out_of_range')
        self._counts_from_zero |= heading_deg > 180.0
        if cell('reference_0true_1mag') not in ('', '0'):
            if cell('reference_0true_1mag') != '1':
                raise Rejected('bad_field')
            if not cell('variation_deg'):
                raise Rejected('no_variation')
            turn_deg = _number(cell('deviation_deg') or '0') + _number(cell('variation_deg'))
            if not -360.0 <= turn_deg <= 360.0:
                raise Rejected('bad_field')
            heading_deg += turn_deg
        stamp = cell('t_ns')
        if not stamp:
            raise Rejected('no_stamp')
        if not (stamp.isascii() and stamp.isdigit() and int(stamp) < 2 ** 63):
            raise Rejected('bad_stamp')
        return int(stamp), heading_deg
