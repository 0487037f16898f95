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
Rows of a csv file as programs and spreadsheets write it.

Commas, semicolons or tabs separate the cells. Numbers have a decimal point or a decimal comma.
"""

from __future__ import annotations

import codecs
import csv
import io
import os
import re
from typing import Iterator, TextIO

from heading_intercompare.bags.errors import BagError

_SEPARATORS = ',;\t'
_UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
_SHOWN = 80
_NUMBER = re.compile(r'[+-]?\d*(?:[.,](\d*))?')
#: Marks that stand between groups of three digits.
_GROUPING = re.compile(r"\d[\s'\u2019]\d|,.*[.,]|\..*,")


def _open(path: str) -> TextIO:
    """Open a text in UTF-8, or in UTF-16 if its byte order mark says so."""
    # Opened once: a pipe has no beginning to come back to.
    file = open(path, 'rb')
    head = file.peek(2)[:2]
    return io.TextIOWrapper(file, newline='', errors='replace',
                            encoding='utf-16' if head in _UTF16 else 'utf-8-sig')


class CsvRows:
    """
    The rows of a csv file with a header; iterate once.

    Empty rows are skipped, and so are comments, which begin with ``#``. A first line ``sep=;``,
    as Excel reads it, names the separator.

    Parameters
    ----------
    path
        The file: UTF-8 with or without byte order mark, or UTF-16 with one.
    columns
        The columns that the header must have, in words, for the error of an empty file.

    Attributes
    ----------
    names : list of str
        The names of the header.
    line
        Number of the last line read, from 1.
    cut : str
        Which line was left out because the file ends within it; empty if none.

    Raises
    ------
    OSError
        If the file cannot be read.
    BagError
        If it is empty, or a column stands twice; while iterating, if a row has more cells than
        the header.

    """

    def __init__(self, path: str | os.PathLike[str], columns: str) -> None:
        self.path = os.fspath(path)
        self._file = _open(self.path)
        self._mark = self.cut = ''
        self._ended = True
        try:
            self._before, header, separator = self._read_header(columns)
            self._rows = csv.reader(self._lines(), delimiter=separator)
            self.names = [name.strip() for name in
                          next(csv.reader([header], delimiter=separator), [])]
            while len(self.names) > 1 and not self.names[-1]:
                self.names.pop()
            self._check_doubled()
        except csv.Error as error:
            self._file.close()
            raise BagError(f'line {self._before}: {error}', self.path) from None
        except BagError:
            self._file.close()
            raise

    def __enter__(self) -> 'CsvRows':
        return self

    def __exit__(self, *exception: object) -> None:
        self._file.close()

    @property
    def line(self) -> int:
        """Return the number of the last line read."""
        return self._before + self._rows.line_num

    def _read_header(self, columns: str) -> tuple[int, str, str]:
        """Return the number of the line of the header, the line, and the separator."""
        separator = ''
        for number, line in enumerate(iter(self._file.readline, ''), 1):
            text = line.strip()
            if text[:4].lower() == 'sep=' and len(text) == 5:
                separator = text[4]
            elif text.strip(_SEPARATORS + '" ') and not text.startswith('#'):
                # A name of a column has no separator: the sign that stands most often is it.
                return number, text, separator or max(_SEPARATORS, key=text.count)
        raise BagError(f'is empty; must begin with a header with the columns {columns}', self.path)

    def _lines(self) -> Iterator[str]:
        """Yield the lines, and note whether the newest one has an end."""
        for line in self._file:
            self._ended = line.endswith(('\n', '\r'))
            yield line

    def _check_doubled(self) -> None:
        for at, name in enumerate(self.names):
            if name and name in self.names[:at]:
                raise BagError(f'line {self._before}: column {name[:_SHOWN]!r} stands twice, as '
                               f'column {self.names.index(name) + 1} and {at + 1}; leave out one',
                               self.path)

    def __iter__(self) -> Iterator[list[str]]:
        """Yield the cells of each row."""
        width, before = len(self.names), ['']
        try:
            for row in self._rows:
                if not row or row[0].startswith('#') or not any(map(str.strip, row)):
                    continue
                if len(row) > width and any(map(str.strip, row[width:])):
                    raise BagError(
                        f'line {self.line} has {len(row)} columns, more than the header '
                        f'({width}); if its numbers have decimal commas, separate the columns by '
                        'semicolons', self.path)
                if len(row) < width and not self._ended:
                    self.cut = (f'line {self.line} was left out: the file ends within it, after '
                                f'{len(row)} of {width} columns')
                    return
                if not self._ended and _has_fewer_decimals(row[-1], before[-1]):
                    self.cut = (f'line {self.line} was left out: the file ends within it, and its '
                                'last number has fewer decimals than the one before')
                    return
                before = row
                yield row
        except csv.Error as error:
            raise BagError(f'line {self.line}: {error}', self.path) from None

    def plain(self, cell: str) -> str:
        """
        Return the number in a cell with a decimal point.

        Raises
        ------
        ValueError
            If it has both marks, several of one, or another mark than the numbers before it.

        """
        text = cell.strip()
        if ',' in text or '.' in text:
            mark = ',' if ',' in text else '.'
            if text.count(',') + text.count('.') > 1 or self._mark not in ('', mark):
                raise ValueError(text)
            self._mark = mark
            return text.replace(',', '.')
        return text

    def why_no_number(self, cell: str) -> str:
        """Return a hint for a cell that `plain` or a conversion rejected; '' without one."""
        if _GROUPING.search(cell):
            return '; write numbers without thousands separators'
        mark = ',' if ',' in cell else '.' if '.' in cell else ''
        if mark and self._mark not in ('', mark):
            return (f'; its decimal mark is {mark!r}, and that of the numbers before it '
                    f'{self._mark!r}: use one of them throughout')
        return ''


def _has_fewer_decimals(cell: str, before: str) -> bool:
    """Tell whether a cell holds a number with fewer decimals than the cell before."""
    number, number_before = _NUMBER.fullmatch(cell.strip()), _NUMBER.fullmatch(before.strip())
    return bool(cell.strip() and number and number_before
                and len(number[1] or '') < len(number_before[1] or ''))
