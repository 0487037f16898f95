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

"""Pairs as csv, one pair per row; reading gives back the same bits."""

from __future__ import annotations

import hashlib
import math
import os
from typing import Any, Callable, Iterable, Iterator, Sequence

import numpy as np

from heading_intercompare.bags.errors import BagError
from heading_intercompare.core.angles import headings_from_signed
from heading_intercompare.core.pairing.difference import subtract
from heading_intercompare.core.pairing.interpolation_kernel import LARGEST_FACTOR
from heading_intercompare.core.records import Pairs
from heading_intercompare.replaced_file import ReplacedFile

from .csv_rows import CsvRows
from .pairs_account import Fingerprint, PairsDigest
from .plain_rows import PlainRows
from .stamp_cells import (
    explain_stamp,
    looks_like_days,
    looks_like_unit,
    nanoseconds,
    STAMP_COLUMNS,
)

#: Columns written; the difference follows from the others.
COLUMNS = ('stamp_ns', 'ts_deg', 'rs_deg', 'difference_deg', 'lag_s', 'rs_variance_factor',
           'ts_variance_factor')
_HEADINGS = ('ts_deg', 'rs_deg')
_FACTORS = COLUMNS[-2:]
_WANTED = 'stamp_s or stamp_ns, ts_deg, rs_deg'
#: Rows looked at before the first pairs are given out.
_FIRST_ROWS = 100

_ROWS = 65536
_SECOND_NS = 1_000_000_000
_FIRST_BEYOND = 2**63
_SHOWN = 40
#: Of columns of decimal seconds.
_DECIMALS_OF_SECOND = {'stamp_s': 9, 'lag_s': 9}


def _heading(text: str) -> float:
    heading_deg = float(text) if text else math.nan
    return heading_deg if 0.0 <= heading_deg < 360.0 else float(headings_from_signed(heading_deg))


def _factor(text: str) -> float:
    """Return a variance factor; 1 if the text is empty."""
    factor = float(text) if text else 1.0
    if not 0.0 < factor <= LARGEST_FACTOR:
        raise ValueError
    return factor


def _lag_of_seconds(text: str) -> int:
    if text in ('', '0.0'):
        return 0
    return -nanoseconds(text[1:]) if text.startswith('-') else nanoseconds(text)


def _lag(text: str) -> int:
    return int(text) if text else 0


_LAGS: dict[str, tuple[Callable[[str], int], str]] = {
    'lag_s': (_lag_of_seconds, 'a decimal number of seconds, or empty'),
    'lag_ns': (_lag, 'a whole number of nanoseconds, or empty'),
}


_Columns = tuple[Sequence[Any] | np.ndarray, ...]


class PairsCsv:
    """
    A csv file of pairs; iterate once.

    Parameters
    ----------
    path
        A header, then one row per pair. Columns in any order: `stamp_ns`, `stamp_s` (decimal) or
        `stamp_utc` (ISO 8601, or the day numbers of a spreadsheet), all read exactly to the
        nanosecond; `ts_deg`, `rs_deg`; where present also `lag_s` or `lag_ns`,
        `rs_variance_factor` and `ts_variance_factor`. See `CsvRows` for the form.

    Attributes
    ----------
    names : tuple of str
        The columns of the header.
    ignored : tuple of str
        Those that are not read.

    Raises
    ------
    OSError
        If the file cannot be read.
    BagError
        If the header is wrong; while iterating, if a row is, with the number of its line.

    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._rows = CsvRows(path, _WANTED)
        names = self._rows.names
        try:
            stamp = self._find_columns(names)
        except BagError:
            self._rows.__exit__()
            raise
        self._stamp = stamp
        self.names = tuple(names)
        self._lag = next((name for name in _LAGS if name in names), None)
        self._places = [names.index(name) for name in (stamp, *_HEADINGS)]
        self._lag_place = None if self._lag is None else names.index(self._lag)
        self._factor_places = [names.index(name) if name in names else None for name in _FACTORS]
        self._last_place = max(place for place in (
            *self._places, self._lag_place, *self._factor_places) if place is not None)
        read = {stamp, *_HEADINGS, *_FACTORS, 'difference_deg', *STAMP_COLUMNS, *_LAGS}
        self.ignored = tuple(name for name in names if name and name not in read)

    @property
    def cut(self) -> str:
        """Which line was left out because the file ends within it; empty if none."""
        return self._rows.cut

    def _find_columns(self, names: list[str]) -> str:
        """Return the name of the column of stamps; BagError if one is missing."""
        stamp = next((name for name in STAMP_COLUMNS if name in names), None)
        absent = [name for name in _HEADINGS if name not in names]
        if stamp is None:
            absent.insert(0, 'stamp_s or stamp_ns')
        if stamp is None or absent:
            named = ('' if len(absent) < len(_HEADINGS) else
                     '; or name its columns of headings with --ts and --rs')
            raise BagError(f'line {self._rows.line} is {",".join(names)[:80]!r}: must be a header '
                           f'with the columns {_WANTED}; missing: {", ".join(absent)}{named}',
                           self._rows.path)
        return stamp

    def __iter__(self) -> Iterator[Pairs]:
        """Yield the pairs in file order, at most 65536 rows each."""
        with self._rows:
            first: list[_Columns] = []
            n_first = 0
            for columns in self._read():
                if n_first >= _FIRST_ROWS:
                    yield Pairs.of(*columns)
                    continue
                first.append(columns)
                n_first += len(columns[0])
                if n_first >= _FIRST_ROWS:
                    yield from self._begin(first)
            if n_first < _FIRST_ROWS:
                yield from self._begin(first)

    def _begin(self, first: list[_Columns]) -> Iterator[Pairs]:
        """Yield the first pairs, once they agree with the unit of their stamps."""
        self._check_unit([int(ns) for columns in first
                          for ns in columns[0][:_FIRST_ROWS]][:_FIRST_ROWS])
        yield from (Pairs.of(*columns) for columns in first)

    def _check_unit(self, stamp_ns: list[int]) -> None:
        looks = {'stamp_s': looks_like_days, 'stamp_ns': looks_like_unit}.get(self._stamp)
        if looks and (why := looks(stamp_ns)):
            raise BagError(why, self._rows.path)

    def _read(self) -> Iterator[_Columns]:
        """Yield the columns of `Pairs`, of at most 65536 rows."""
        single: tuple[list[Any], ...] = ([], [], [], [], [], [])
        # Times in words are read one by one.
        rows = self._rows if self._stamp == 'stamp_utc' else self._rows.parts()
        for part in rows:
            if isinstance(part, list):
                for column, value in zip(single, self._read_row(part)):
                    column.append(value)
            if single[0] and (len(single[0]) == _ROWS or isinstance(part, PlainRows)):
                yield single
                single = ([], [], [], [], [], [])
            if isinstance(part, PlainRows):
                columns = self._read_many(part)
                for lo in range(0, len(part), _ROWS):
                    yield tuple(column[lo:lo + _ROWS] for column in columns)
        if single[0]:
            yield single

    def _read_row(self, row: list[str]) -> tuple[int, float, float, int, float, float]:
        """Return the fields of `Pairs` in a row."""
        if len(row) <= self._last_place:
            raise BagError(f'line {self._rows.line} has {len(row)} columns, fewer than the header',
                           self._rows.path)
        at_stamp, at_ts, at_rs = self._places
        stamp_ns = self._read_stamp(row[at_stamp].strip())
        ts_deg, rs_deg = self._read_headings(row[at_ts], row[at_rs])
        lag_ns = 0 if self._lag_place is None else self._read_lag(row[self._lag_place])
        rs_factor, ts_factor = self._read_factors(
            ['' if place is None else row[place] for place in self._factor_places])
        return stamp_ns, ts_deg, rs_deg, lag_ns, rs_factor, ts_factor

    def _read_many(self, plain: PlainRows) -> tuple[np.ndarray, ...]:
        """Return the fields of `Pairs` in many rows."""
        good = np.ones(len(plain), bool)

        def reals_of(place: int | None, absent: float) -> np.ndarray:
            """Return the reals of a column; those that are empty are `absent`."""
            if place is None:
                return np.full(len(plain), absent)
            reals, numbers = plain.reals(place, self._rows.mark)
            empty = plain.empty(place)
            good[~(numbers | empty)] = False
            return np.where(empty, absent, reals)

        def times_of(place: int | None, name: str | None) -> np.ndarray:
            """Return the times of a column; those that are empty are 0."""
            if place is None:
                return np.zeros(len(plain), np.int64)
            behind = _DECIMALS_OF_SECOND.get(name or '', 0)
            ns, exact = plain.decimals(place, self._rows.mark if behind else '').scaled(behind)
            good[~(exact | plain.empty(place))] = False
            return ns
        stamp_ns = times_of(self._places[0], self._stamp)
        ts_deg, rs_deg = (headings_from_signed(reals_of(place, math.nan))
                          for place in self._places[1:])
        lag_ns = times_of(self._lag_place, self._lag)
        factors = [reals_of(place, 1.0) for place in self._factor_places]
        for factor in factors:
            good &= (factor > 0.0) & (factor <= LARGEST_FACTOR)
        good &= ~plain.empty(self._places[0])
        columns = stamp_ns, ts_deg, rs_deg, lag_ns, *factors
        for at in np.flatnonzero(~good).tolist():
            self._rows.line = plain.line + at
            for column, value in zip(columns, self._read_row(plain.row(at))):
                column[at] = value
        return columns

    def _read_stamp(self, text: str) -> int:
        kind = STAMP_COLUMNS[self._stamp]
        try:
            stamp_ns = kind.convert(self._rows.plain(text) if kind.decimal else text)
        except (ValueError, ArithmeticError):
            stamp_ns = _FIRST_BEYOND
        if not -_FIRST_BEYOND < stamp_ns < _FIRST_BEYOND:
            raise self._wrong(self._stamp, text, kind.allowed, explain_stamp(self._stamp, text))
        return stamp_ns

    def _read_headings(self, ts: str, rs: str) -> tuple[float, float]:
        rows = self._rows
        try:
            return _heading(rows.plain(ts)), _heading(rows.plain(rs))
        except ValueError:
            raise BagError(
                f'line {rows.line}: ts_deg = {ts[:_SHOWN]!r}, rs_deg = {rs[:_SHOWN]!r} must '
                f'be numbers{rows.why_no_number(ts) or rows.why_no_number(rs)}',
                rows.path) from None

    def _read_lag(self, text: str) -> int:
        if not text:
            return 0
        convert, allowed = _LAGS[self._lag or 'lag_s']
        try:
            lag_ns = convert(self._rows.plain(text))
        except (ValueError, ArithmeticError):
            lag_ns = _FIRST_BEYOND
        if not -_FIRST_BEYOND < lag_ns < _FIRST_BEYOND:
            raise self._wrong(self._lag or '', text, allowed)
        return lag_ns

    def _read_factors(self, texts: Sequence[str]) -> tuple[float, ...]:
        try:
            return tuple(_factor(self._rows.plain(text)) for text in texts)
        except ValueError:
            cells = ', '.join(f'{name} = {text[:_SHOWN]!r}'
                              for name, text in zip(_FACTORS, texts))
            raise BagError(f'line {self._rows.line}: {cells} must be above 0 and at most '
                           '1, or empty', self._rows.path) from None

    def _wrong(self, name: str, text: str, allowed: str, hint: str = '') -> BagError:
        hint = hint or self._rows.why_no_number(text)
        return BagError(f'line {self._rows.line}: {name} = {text[:_SHOWN]!r} must be '
                        f'{allowed}{hint}', self._rows.path)


def read_pairs_csv(path: str | os.PathLike[str]) -> Iterator[Pairs]:
    """
    Yield the pairs of a csv file; see `PairsCsv`.

    Yields
    ------
    Pairs
        At most 65536 rows each, in file order. A heading that is empty or not finite is nan. Lags
        are 0 and variance factors 1 where they are empty or absent.

    """
    yield from PairsCsv(path)


class PairsCsvWriter:
    """
    Writes a csv of pairs; an existing file is replaced.

    Parameters
    ----------
    path
        The file.
    wrap_center_deg
        Centre of the range to which the differences are wrapped, degrees.

    Raises
    ------
    OSError
        If the file cannot be written, here and in each method.

    """

    def __init__(self, path: str | os.PathLike[str], *, wrap_center_deg: float = 0.0) -> None:
        self._center_deg = wrap_center_deg
        self._pairs, self._bytes = PairsDigest(), hashlib.sha256()
        self._replaced = ReplacedFile(path)
        self._put(','.join(COLUMNS) + '\n')

    def __enter__(self) -> 'PairsCsvWriter':
        return self

    def __exit__(self, kind: type | None, *exception: object) -> None:
        self.close() if kind is None else self.discard()

    def write(self, pairs: Pairs) -> None:
        """Append one row per pair; the installation offset stays in the difference."""
        self._pairs.update(pairs)
        columns = (pairs.stamp_ns, pairs.ts_deg, pairs.rs_deg,
                   subtract(pairs, wrap_center_deg=self._center_deg).x_deg,
                   pairs.lag_ns / _SECOND_NS, pairs.rs_variance_factor, pairs.ts_variance_factor)
        rows = zip(*(column.tolist() for column in columns))
        self._put(''.join(','.join(map(repr, row)) + '\n' for row in rows))

    def _put(self, text: str) -> None:
        data = text.encode('ascii')
        self._bytes.update(data)
        self._replaced.write(data)

    @property
    def fingerprint(self) -> Fingerprint:
        """Return the hashes of what was written so far, for `write_account`."""
        return Fingerprint(self._bytes.hexdigest(), self._pairs.hexdigest())

    def close(self) -> None:
        """Put the file in its place; a second call does nothing."""
        self._replaced.commit()

    def discard(self) -> None:
        """Leave the file as it was before."""
        self._replaced.discard()


def write_pairs_csv(path: str | os.PathLike[str], chunks: Iterable[Pairs], *,
                    wrap_center_deg: float = 0.0) -> None:
    """Write chunks of pairs to a csv file; see `PairsCsvWriter`."""
    with PairsCsvWriter(path, wrap_center_deg=wrap_center_deg) as file:
        for pairs in chunks:
            file.write(pairs)
