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
Many rows of a csv at once: where their cells are, and the numbers in them.

Plain rows have no quotation marks, are no comments and have all the same number of cells. Decimal
numbers are those of `float`, to the bit: of up to 15 digits, they are a whole number below 2**53
divided by an exact power of ten, which is rounded once.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from heading_intercompare.core.records import Integers, Reals

Bytes = NDArray[np.uint8]
Flags = NDArray[np.bool_]

_NEWLINE, _RETURN, _SPACE, _QUOTE, _COMMENT = b'\n\r "#'
_ZERO, _PLUS, _MINUS = b'0+-'
#: Longer numbers are read one by one.
_MOST_CHARACTERS = 24
#: A whole number of 19 digits that does not fit into 64 bits turns negative.
_MOST_DIGITS = 19
#: No product from here on is sure to fit into 64 bits.
_BELOW_LAST = 9.2e18
#: A whole number of 15 digits is below 2**53.
_EXACT_DIGITS = 15
_POWERS = np.array([10.0 ** n for n in range(_EXACT_DIGITS + 1)])


class Decimals(NamedTuple):
    """
    Decimal numbers in the cells of a column, n rows.

    Attributes
    ----------
    digits : ndarray of int64
        The digits as a whole number, where that fits into 64 bits.
    n_decimals, n_digits : ndarray of int64
        The number of digits after the decimal mark, and of all digits.
    sign : ndarray of int8
        -1 or 1 where the number begins with a sign, otherwise 0.
    plain : ndarray of bool
        The cell is such a number. The other fields hold only where it is.

    """

    digits: Integers
    n_decimals: Integers
    n_digits: Integers
    sign: NDArray[np.int8]
    plain: Flags

    def scaled(self, places: int) -> tuple[Integers, Flags]:
        """
        Return the numbers times a power of ten, as whole numbers.

        Parameters
        ----------
        places
            The power.

        Returns
        -------
        ndarray of int64, ndarray of bool
            The whole numbers, and which of them are exact.

        """
        behind = places - self.n_decimals
        good = (self.plain & (behind >= 0) & (self.n_digits <= _MOST_DIGITS)
                & (self.digits >= 0))
        factor = 10 ** np.where(good, behind, 0)
        good &= self.digits * factor.astype(np.float64) < _BELOW_LAST
        product = self.digits * factor
        return np.where(self.sign < 0, -product, product), good


class Texts(NamedTuple):
    """
    The cells of a column that all have the same length, n rows.

    Attributes
    ----------
    cells : ndarray of uint8, shape (n, length)
        Their characters.

    """

    cells: Bytes

    def equal_before(self, varying: list[int]) -> Flags:
        """Tell of each row but the first whether it equals the row before, but for characters."""
        same = self.cells[1:] == self.cells[:-1]
        same[:, varying] = True
        flags: Flags = same.all(axis=1)
        return flags

    def whole(self, places: list[int]) -> tuple[Integers, Flags]:
        """Return the whole number that the characters at some places make, and which are one."""
        number, good = np.zeros(len(self.cells), np.int64), np.ones(len(self.cells), bool)
        for place in places:
            digit = self.cells[:, place] - np.uint8(_ZERO)
            good &= digit < 10
            number = number * 10 + digit
        return number, good


class PlainRows:
    """
    Rows of a csv without quotation marks, as they are in a file.

    Parameters
    ----------
    block : ndarray of uint8
        Whole lines, each with its end.
    separator
        The byte between cells.
    n_cells
        Cells of each row.
    line
        Number of the first line in the file.

    Attributes
    ----------
    n_cells, line

    """

    def __init__(self, block: Bytes, separator: int, n_cells: int, line: int) -> None:
        self._block, self._separator = block, separator
        self.n_cells, self.line = n_cells, line
        self._bounds: dict[int, tuple[Integers, Integers]] = {}
        ends = np.flatnonzero((block == separator) | (block == _NEWLINE)).reshape(-1, n_cells)
        self._starts = np.empty_like(ends)
        self._starts[0, 0] = 0
        self._starts.reshape(-1)[1:] = ends.reshape(-1)[:-1] + 1
        self._ends = ends

    def __len__(self) -> int:
        return len(self._ends)

    def row(self, at: int) -> list[str]:
        """Return the cells of one row."""
        text = self._block[self._starts[at, 0]:self._ends[at, -1]].tobytes()
        return text.decode('utf-8', 'replace').rstrip('\r').split(chr(self._separator))

    def empty(self, place: int) -> Flags:
        """Tell of each row whether its cell in a column is empty."""
        starts, ends = self._trimmed(place)
        flags: Flags = starts >= ends
        return flags

    def lengths(self, place: int) -> Integers:
        """Return the number of bytes of each cell of a column, without the spaces around it."""
        starts, ends = self._trimmed(place)
        return ends - starts

    def texts(self, place: int, lo: int, hi: int) -> Texts:
        """Return the cells of a column from row `lo` to before `hi`, all of one length."""
        starts, ends = self._trimmed(place)
        return Texts(self._block[starts[lo:hi, None] + np.arange(ends[lo] - starts[lo])])

    def reals(self, place: int, mark: str) -> tuple[Reals, Flags]:
        """
        Return the numbers in a column, and which cells hold one.

        Parameters
        ----------
        place
            The column, from 0.
        mark
            The decimal mark; '' if none may occur.

        """
        decimals = self.decimals(place, mark)
        exact = decimals.n_digits <= _EXACT_DIGITS
        reals = decimals.digits / _POWERS[np.where(exact, decimals.n_decimals, 0)]
        np.negative(reals, out=reals, where=decimals.sign < 0)
        if len(long := np.flatnonzero(decimals.plain & ~exact)):
            reals[long] = self._convert(place, long)
        return reals, decimals.plain

    def decimals(self, place: int, mark: str) -> Decimals:
        """Return the numbers in a column digit by digit; parameters as of `reals`."""
        starts, ends = self._trimmed(place)
        lengths, last = ends - starts, len(self._block) - 1
        digits, n_decimals, n_digits = (np.zeros(len(starts), np.int64) for _ in range(3))
        plain = (lengths > 0) & (lengths <= _MOST_CHARACTERS)
        first = self._block[starts]
        sign = (first == _PLUS).astype(np.int8) - (first == _MINUS)
        marked = np.zeros(len(starts), bool)
        for at in range(int(lengths[plain].max(initial=0))):
            byte = self._block[np.minimum(starts + at, last)]
            digit = byte - np.uint8(_ZERO)
            is_digit = (at < lengths) & (digit < 10)
            is_other = (at < lengths) & ~is_digit
            if at == 0:
                is_other &= sign == 0
            if mark and is_other.any():
                is_mark = is_other & (byte == ord(mark)) & ~marked
                marked |= is_mark
                is_other &= ~is_mark
            plain &= ~is_other
            digits = np.where(is_digit, digits * 10 + digit, digits)
            n_digits += is_digit
            n_decimals += is_digit & marked
        return Decimals(digits, n_decimals, n_digits, sign, plain & (n_digits > 0))

    def _convert(self, place: int, rows: Integers) -> Reals:
        """Return the numbers in some cells, which are decimal numbers of any length."""
        starts, ends = self._trimmed(place)
        at = starts[rows, None] + np.arange(_MOST_CHARACTERS)
        cells = self._block[np.minimum(at, len(self._block) - 1)]
        cells = np.where(at < ends[rows, None], cells, np.uint8(0))
        cells[cells == ord(',')] = ord('.')
        return cells.view(f'S{_MOST_CHARACTERS}').reshape(-1).astype(np.float64)

    def _trimmed(self, place: int) -> tuple[Integers, Integers]:
        """Return where the cells of a column begin and end, without spaces around them."""
        if place in self._bounds:
            return self._bounds[place]
        starts, ends = self._starts[:, place], self._ends[:, place]
        block = self._block
        if place == self.n_cells - 1:
            ends = ends - ((ends > starts) & (block[ends - 1] == _RETURN))
        while (spaces := (starts < ends) & (block[starts] == _SPACE)).any():
            starts = starts + spaces
        while (spaces := (starts < ends) & (block[ends - 1] == _SPACE)).any():
            ends = ends - spaces
        self._bounds[place] = starts, ends
        return starts, ends


def find_plain_rows(block: Bytes, starts: Integers, separator: int, n_cells: int) -> Flags:
    """
    Tell which lines of a block are plain rows.

    Parameters
    ----------
    block : ndarray of uint8
        Whole lines, each with its end.
    starts : ndarray of int64, shape (n + 1,)
        Where each line begins, and where the last one ends.
    separator
        The byte between cells.
    n_cells
        Cells of a row.

    Returns
    -------
    ndarray of bool, shape (n,)

    """
    separators = np.flatnonzero(block == separator)
    plain: Flags = np.diff(np.searchsorted(separators, starts)) == n_cells - 1
    plain &= block[starts[:-1]] != _COMMENT
    # A row of empty cells counts for nothing.
    blank = (block == separator) | (block == _SPACE) | (block == _RETURN) | (block == _NEWLINE)
    plain &= np.add.reduceat(~blank, starts[:-1], dtype=np.int64) > 0
    odd = (block == _QUOTE) | (block == _RETURN) & (np.append(block[1:], _RETURN) != _NEWLINE)
    plain[np.searchsorted(starts, np.flatnonzero(odd), 'right') - 1] = False
    return plain
