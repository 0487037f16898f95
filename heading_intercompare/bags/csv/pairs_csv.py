# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Pairs as csv, one pair per row; reading gives back the same bits."""

from __future__ import annotations

import csv
from decimal import Decimal, localcontext
import math
import os
from typing import Callable, Iterable, Iterator

from heading_intercompare.bags.errors import BagError
from heading_intercompare.core.pairing.difference import subtract
from heading_intercompare.core.records import Pairs

__all__ = ['COLUMNS', 'PairsCsvWriter', 'read_pairs_csv', 'write_pairs_csv']

#: Columns written; the reader ignores the difference and the lag.
COLUMNS = ('stamp_ns', 'ts_deg', 'rs_deg', 'difference_deg', 'lag_s', 'rs_variance_factor',
           'ts_variance_factor')
_FACTORS = COLUMNS[-2:]

_ROWS = 65536
_SECOND_NS = 1_000_000_000
_DIGITS = 60
_FIRST_BEYOND = 2**63


def _stamp_of_seconds(text: str) -> int:
    """Return decimal seconds as nanoseconds, rounded from the tenth decimal on, without floats."""
    whole, point, decimals = text.partition('.')
    if whole.isdecimal() and len(decimals) <= 9 and (decimals.isdecimal() or not decimals):
        return int(whole) * _SECOND_NS + int(decimals.ljust(9, '0'))
    with localcontext() as context:
        context.prec = _DIGITS
        stamp_ns = Decimal(text) * _SECOND_NS
        if not abs(stamp_ns) < _FIRST_BEYOND:
            raise OverflowError
        return int(stamp_ns.to_integral_value())


def _heading(text: str) -> float:
    heading_deg = float(text) if text.strip() else math.nan
    return heading_deg if math.isfinite(heading_deg) else math.nan


_STAMPS: dict[str, tuple[Callable[[str], int], str]] = {
    'stamp_ns': (int, 'a whole number of nanoseconds'),
    'stamp_s': (_stamp_of_seconds, 'a decimal number of seconds'),
}


def _factor(text: str) -> float:
    """Return a variance factor; 1 if the text is empty."""
    factor = float(text) if text.strip() else 1.0
    if not 0.0 < factor <= 1.0:
        raise ValueError
    return factor


def _columns(path: str, header: list[str]) -> tuple[str, list[int], list[int | None]]:
    """Return the name of the stamp column, and the places of stamp, TS, RS, and of the factors."""
    names = [name.strip() for name in header]
    stamp = next((name for name in _STAMPS if name in names), None)
    absent = [name for name in ('ts_deg', 'rs_deg') if name not in names]
    if stamp is None:
        absent.insert(0, 'stamp_s or stamp_ns')
    if absent:
        raise BagError(f'line 1 is {",".join(header)[:80]!r}: must be a header with the columns '
                       f'stamp_s or stamp_ns, ts_deg, rs_deg; missing: {", ".join(absent)}', path)
    return (stamp, [names.index(name) for name in (stamp, 'ts_deg', 'rs_deg')],
            [names.index(name) if name in names else None for name in _FACTORS])


def read_pairs_csv(path: str | os.PathLike[str]) -> Iterator[Pairs]:
    """
    Yield the pairs of a csv file.

    Parameters
    ----------
    path : str or path
        A header, then one row per pair. Columns in any order: `stamp_ns` or `stamp_s` (decimal,
        read exactly to the nanosecond), `ts_deg`, `rs_deg`; optionally `rs_variance_factor` and
        `ts_variance_factor`. Others are ignored.

    Yields
    ------
    Pairs
        At most 65536 rows each, in file order. A heading that is empty or not finite is nan. Lags
        are 0; variance factors are 1 where they are empty or absent.

    Raises
    ------
    OSError
        If the file cannot be read.
    BagError
        If the header or a row is wrong, with the number of its line.

    """
    path = os.fspath(path)
    with open(path, newline='', encoding='utf-8-sig', errors='replace') as file:
        rows = csv.reader(file)
        header = next(rows, None)
        if header is None:
            raise BagError('is empty; must begin with a header with the columns stamp_s or '
                           'stamp_ns, ts_deg, rs_deg', path)
        name, places, factors = _columns(path, header)
        stamp_of, allowed = _STAMPS[name]
        last = max(*places, *(place for place in factors if place is not None))
        chunk: tuple[list, ...] = ([], [], [], [], [])
        try:
            for row in rows:
                if not row:
                    continue
                if len(row) <= last:
                    raise BagError(f'line {rows.line_num} has {len(row)} columns, fewer than the '
                                   'header', path)
                stamp, ts_text, rs_text = (row[place] for place in places)
                try:
                    stamp_ns = stamp_of(stamp.strip())
                except (ValueError, ArithmeticError):
                    stamp_ns = _FIRST_BEYOND
                if abs(stamp_ns) >= _FIRST_BEYOND:
                    raise BagError(f'line {rows.line_num}: {name} = {stamp[:40]!r} must be '
                                   f'{allowed} since 1970', path)
                try:
                    heading = _heading(ts_text), _heading(rs_text)
                except ValueError:
                    raise BagError(f'line {rows.line_num}: ts_deg = {ts_text[:40]!r}, rs_deg = '
                                   f'{rs_text[:40]!r} must be numbers', path) from None
                texts = ['' if place is None else row[place] for place in factors]
                try:
                    shrunk = [_factor(text) for text in texts]
                except ValueError:
                    given = ', '.join(f'{name} = {text[:40]!r}'
                                      for name, text in zip(_FACTORS, texts))
                    raise BagError(f'line {rows.line_num}: {given} must be above 0 and at most '
                                   '1, or empty', path) from None
                for column, value in zip(chunk, (stamp_ns, *heading, *shrunk)):
                    column.append(value)
                if len(chunk[0]) == _ROWS:
                    yield _pairs(chunk)
                    chunk = ([], [], [], [], [])
        except csv.Error as error:
            raise BagError(f'line {rows.line_num}: {error}', path) from None
        if chunk[0]:
            yield _pairs(chunk)


def _pairs(columns: tuple[list, ...]) -> Pairs:
    stamps, ts_deg, rs_deg, rs_factor, ts_factor = columns
    return Pairs.of(stamps, ts_deg, rs_deg, None, rs_factor, ts_factor)


class PairsCsvWriter:
    """
    Writes a csv of pairs; an existing file is replaced.

    Parameters
    ----------
    path : str or path
        The file.
    wrap_center_deg : float
        Centre of the range to which the differences are wrapped, degrees.

    Raises
    ------
    OSError
        If the file cannot be written, here and in each method.

    """

    def __init__(self, path: str | os.PathLike[str], *, wrap_center_deg: float = 0.0) -> None:
        self._center_deg = wrap_center_deg
        self._file = open(path, 'w', encoding='ascii', newline='')
        self._file.write(','.join(COLUMNS) + '\n')

    def __enter__(self) -> 'PairsCsvWriter':
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def write(self, pairs: Pairs) -> None:
        """Append one row per pair; the installation offset stays in the difference."""
        columns = (pairs.stamp_ns, pairs.ts_deg, pairs.rs_deg,
                   subtract(pairs, wrap_center_deg=self._center_deg).x_deg,
                   pairs.lag_ns / _SECOND_NS, pairs.rs_variance_factor, pairs.ts_variance_factor)
        for row in zip(*(column.tolist() for column in columns)):
            self._file.write(','.join(map(repr, row)) + '\n')

    def close(self) -> None:
        """Close the file; a second call does nothing."""
        self._file.close()


def write_pairs_csv(path: str | os.PathLike[str], chunks: Iterable[Pairs], *,
                    wrap_center_deg: float = 0.0) -> None:
    """Write chunks of pairs to a csv file; see `PairsCsvWriter`."""
    with PairsCsvWriter(path, wrap_center_deg=wrap_center_deg) as file:
        for pairs in chunks:
            file.write(pairs)
