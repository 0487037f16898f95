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
from typing import Any, Iterable, Iterator

import numpy as np

from heading_intercompare.bags.errors import BagError
from heading_intercompare.special_files import open_once

from .plain_rows import Bytes, find_plain_rows, PlainRows

_SEPARATORS = ',;\t'
_UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
_BLOCK_BYTES = 1 << 20
#: Fewer plain rows are read one by one.
_FEWEST_PLAIN = 32
_SHOWN = 80
_NUMBER = re.compile(r'[+-]?\d*(?:[.,](\d*))?')
#: Marks that stand between groups of three digits.
_GROUPING = re.compile(r"\d[\s'\u2019]\d|,.*[.,]|\..*,")


class _Lines:
    """
    The lines of a text in UTF-8, or in UTF-16 if its byte order mark says so; iterate once.

    Parameters
    ----------
    path
        The file. It is opened once: a pipe has no beginning to come back to.

    """

    def __init__(self, path: str) -> None:
        self._file = open_once(path)
        head = self._file.peek(2)
        self._text = None
        if head[:2] in _UTF16 or b'\r' in head and b'\n' not in head:
            self._text = io.TextIOWrapper(
                self._file, newline='', errors='replace',
                encoding='utf-16' if head[:2] in _UTF16 else 'utf-8-sig')
        elif head.startswith(codecs.BOM_UTF8):
            self._file.read(len(codecs.BOM_UTF8))
        self._separator = self._n_cells = self._at = self._n = 0
        self._rest = b''
        self._take_block(b'')

    def close(self) -> None:
        (self._text or self._file).close()

    def __iter__(self) -> Iterator[str]:
        return self

    def __next__(self) -> str:
        """Return the next line with its end; the last one may have none."""
        if self._text is not None:
            return next(self._text)
        if self._at == self._n and not self._read_block():
            last, self._rest = self._rest, b''
            if last:
                return last.decode('utf-8', 'replace')
            raise StopIteration
        lo, hi = self._starts[self._at:self._at + 2]
        self._at += 1
        return self._block[lo:hi].tobytes().decode('utf-8', 'replace')

    def expect(self, separator: str, width: int) -> None:
        """Take note of the form of plain rows, once the header has been read."""
        if len(separator) == 1 and separator in f'{_SEPARATORS}|':
            self._separator, self._n_cells = ord(separator), width
            self._find_plain()

    def take_plain(self, line: int) -> PlainRows | None:
        """Return the plain rows that follow, the first of them at a line; None if few do."""
        if self._at == self._n and (self._text is not None or not self._read_block()):
            return None
        while self._runs and self._runs[-1][1] - self._at < _FEWEST_PLAIN:
            self._runs.pop()
        if not self._runs or self._at < self._runs[-1][0]:
            return None
        hi, lo = self._runs.pop()[1], self._at
        self._at = hi
        return PlainRows(self._block[self._starts[lo]:self._starts[hi]], self._separator,
                         self._n_cells, line)

    def _read_block(self) -> bool:
        """Read the next whole lines; return False if none are left."""
        data = self._rest
        while more := self._file.read(_BLOCK_BYTES):
            data += more
            end = data.rfind(b'\n') + 1
            if end:
                self._rest = data[end:]
                self._take_block(data[:end])
                return True
        self._rest = data
        return False

    def _take_block(self, data: bytes) -> None:
        self._block: Bytes = np.frombuffer(data, np.uint8)
        self._starts = np.concatenate(([0], np.flatnonzero(self._block == ord('\n')) + 1))
        self._at, self._n = 0, len(self._starts) - 1
        self._find_plain()

    def _find_plain(self) -> None:
        """Find the runs of plain rows in the block, the first one last."""
        self._runs: list[tuple[int, int]] = []
        if self._separator and self._n:
            plain = find_plain_rows(self._block, self._starts, self._separator, self._n_cells)
            edges = np.flatnonzero(np.diff(np.concatenate(([False], plain, [False]))))
            self._runs = [(lo, hi) for lo, hi in edges.reshape(-1, 2)[::-1].tolist()
                          if hi - lo >= _FEWEST_PLAIN]


class StrayQuote(csv.Error):
    """A quotation mark that hides the rows after it; with how many lines it spans."""

    def __init__(self, n_lines: int) -> None:
        super().__init__('a quotation mark hides the rows after it; remove it, or close it in the '
                         'same cell')
        self.n_lines = n_lines


def split_rows(lines: Iterable[str], width: int, **form: Any) -> Iterator[list[str]]:
    """
    Yield the cells of each row of a csv; a cell in quotes may hold ends of lines.

    Parameters
    ----------
    lines
        The lines with their ends.
    width
        How many cells a row has.
    **form
        As for `csv.reader`.

    Raises
    ------
    StrayQuote
        If a quotation stands open at the end, closes within a cell, or holds lines that look
        like rows.

    """
    spanned: list[str] = []

    def note_lines() -> Iterator[str]:
        for line in lines:
            spanned.append(line)
            yield line
    rows = csv.reader(note_lines(), **form)
    while True:
        try:
            row = next(rows, None)
            if len(spanned) > 1:
                [*csv.reader(spanned, strict=True, **form)]
        except csv.Error as error:
            raise StrayQuote(len(spanned)) if len(spanned) > 1 else error from None
        if row is None:
            return
        if any(_looks_like_row(line, width, form.get('delimiter', ',')) for line in spanned[1:]):
            raise StrayQuote(len(spanned))
        spanned.clear()
        yield row


def _looks_like_row(line: str, width: int, separator: str) -> bool:
    return line.count(separator) == width - 1 and line.lstrip(' "')[:1].isdigit()


class CsvRows:
    """
    The rows of a csv file with a header; iterate once, over rows or over `parts`.

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
        the header, or a quotation mark hides rows.

    """

    def __init__(self, path: str | os.PathLike[str], columns: str) -> None:
        self.path = os.fspath(path)
        self._lines = _Lines(self.path)
        self._mark = self.cut = ''
        self._ended = True
        self._row_before = ['']
        try:
            self.line, header, separator = self._read_header(columns)
            self.names = [name.strip() for name in
                          next(csv.reader([header], delimiter=separator), [])]
            while len(self.names) > 1 and not self.names[-1]:
                self.names.pop()
            self._check_doubled()
            self._rows = split_rows(self._whole_lines(), len(self.names), delimiter=separator)
        except csv.Error as error:
            self._lines.close()
            raise BagError(f'line {self.line}: {error}', self.path) from None
        except BagError:
            self._lines.close()
            raise
        self._lines.expect(separator, 1 + header.count(separator))

    def __enter__(self) -> 'CsvRows':
        return self

    def __exit__(self, *exception: object) -> None:
        self._lines.close()

    @property
    def mark(self) -> str:
        """Return the decimal mark of the numbers so far; '' if none had one."""
        return self._mark

    def _read_header(self, columns: str) -> tuple[int, str, str]:
        """Return the number of the line of the header, the line, and the separator."""
        separator = ''
        for number, line in enumerate(self._lines, 1):
            text = line.strip()
            if text[:4].lower() == 'sep=' and len(text) == 5:
                separator = text[4]
            elif text.strip(_SEPARATORS + '" ') and not text.startswith('#'):
                # A name of a column has no separator: the sign that stands most often is it.
                return number, text, separator or max(_SEPARATORS, key=text.count)
        raise BagError(f'is empty; must begin with a header with the columns {columns}', self.path)

    def _whole_lines(self) -> Iterator[str]:
        """Yield the lines, count them, and note whether the newest one has an end."""
        for line in self._lines:
            self._ended = line.endswith(('\n', '\r'))
            self.line += 1
            yield line

    def _check_doubled(self) -> None:
        for at, name in enumerate(self.names):
            if name and name in self.names[:at]:
                raise BagError(f'line {self.line}: column {name[:_SHOWN]!r} stands twice, as '
                               f'column {self.names.index(name) + 1} and {at + 1}; leave out one',
                               self.path)

    def __iter__(self) -> Iterator[list[str]]:
        """Yield the cells of each row."""
        width = len(self.names)
        try:
            for row in self._rows:
                if not row or row[0].startswith('#') or not any(map(str.strip, row)):
                    continue
                if len(row) > width and any(map(str.strip, row[width:])):
                    raise self._too_wide(len(row))
                if len(row) < width and not self._ended:
                    self.cut = (f'line {self.line} was left out: the file ends within it, after '
                                f'{len(row)} of {width} columns')
                    return
                if not self._ended and _has_fewer_decimals(row[-1], self._row_before[-1]):
                    self.cut = (f'line {self.line} was left out: the file ends within it, and its '
                                'last number has fewer decimals than the one before')
                    return
                self._row_before = row
                yield row
        except StrayQuote as error:
            raise BagError(f'line {self.line - error.n_lines + 1}: {error}', self.path) from None
        except csv.Error as error:
            raise BagError(f'line {self.line}: {error}', self.path) from None

    def parts(self) -> Iterator[list[str] | PlainRows]:
        """
        Yield all rows in the order of the file: many plain ones at once, others one by one.

        The first row is yielded by itself. Set `line` to the row of plain ones that is read.
        """
        rows = iter(self)
        while (row := next(rows, None)) is not None:
            yield row
            while (plain := self._lines.take_plain(self.line + 1)) is not None:
                self._check_width(plain)
                yield plain
                self.line, self._row_before = plain.line + len(plain) - 1, plain.row(-1)

    def _check_width(self, plain: PlainRows) -> None:
        """Raise BagError if a row has cells beyond the header that are not empty."""
        for place in range(len(self.names), plain.n_cells):
            if len(filled := np.flatnonzero(~plain.empty(place))):
                self.line = plain.line + int(filled[0])
                raise self._too_wide(plain.n_cells)

    def _too_wide(self, n_cells: int) -> BagError:
        return BagError(f'line {self.line} has {n_cells} columns, more than the header '
                        f'({len(self.names)}); if its numbers have decimal commas, separate the '
                        'columns by semicolons', self.path)

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
