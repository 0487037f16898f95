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

"""Parquet tables of headings or of pairs."""

from __future__ import annotations

from collections import Counter
from contextlib import contextmanager
from functools import partial
from typing import Any, Iterator, NamedTuple, Sequence

import numpy as np
import pyarrow
import pyarrow.parquet

from heading_intercompare.bags.csv.stamp_cells import looks_like_unit
from heading_intercompare.core.angles import headings_from_signed
from heading_intercompare.core.pairing.interpolation_kernel import LARGEST_FACTOR
from heading_intercompare.core.records import Headings, Integers, Pairs, Reals
from heading_intercompare.core.units.angle_units import find_named_unit
from heading_intercompare.core.units.given_stamps import find_unit
from heading_intercompare.drivers.sentences import Rejected
from heading_intercompare.drivers.settings import DEFAULT_DRIVER, DriverSettings

from .json_lines import is_heading_name
from .motion_columns import find_motion_columns, make_motion
from .stamp_columns import find_time_columns, StampColumns, TIMES
from .stream_recording import Collected, ReaderError, StreamOptions, UNSTATED

_ROWS = 65536
#: Rows by which the unit of nanoseconds is doubted.
_FIRST_ROWS = 100
_SECOND_NS = 1_000_000_000
_REALS = {'rs_variance_factor': 1.0, 'ts_variance_factor': 1.0}
_KNOWN = ('ts_deg', 'rs_deg', 'lag_ns', 'lag_s', 'difference_deg', *_REALS)


@contextmanager
def _open(path: str) -> Iterator[Any]:
    try:
        with pyarrow.parquet.ParquetFile(path) as file:
            yield file
    except (pyarrow.ArrowException, OSError) as error:
        if isinstance(error, OSError) and error.errno is not None:
            raise
        raise ReaderError(path, f'is damaged, or no Parquet: {error}') from error


def has_pairs(path: str) -> bool:
    """Tell whether a Parquet table has the headings of both sensors in each row."""
    with _open(path) as file:
        return {'ts_deg', 'rs_deg'} <= {*file.schema_arrow.names}


def _time_column(path: str, file: Any, stated: str | None = None) -> str:
    names = list(file.schema_arrow.names)
    columns = find_time_columns(names, stated)
    if not columns or columns[-1].lower().endswith('dday'):
        raise ReaderError(path, f'has the columns {", ".join(names)[:200]}: one must be the time, '
                          f'{stated or ", ".join(TIMES[:4])} or a column of type timestamp so '
                          'named; name it with --time-column')
    if stated is not None and len(columns) > 1:
        raise ReaderError(path, f'--time-column {stated}: the times of Parquet are one column')
    return columns[-1]


class _Row(NamedTuple):
    """A row of a table: its number, from 1. Its texts hold numbers with decimal points."""

    line: int

    @staticmethod
    def plain(cell: str) -> str:
        return cell


@contextmanager
def _open_texts(path: str, names: Sequence[str]) -> Iterator[Iterator[list[str]]]:
    """Open the rows of some columns as texts, '' where a cell is null."""
    with _open(path) as file:
        yield (row for batch in file.iter_batches(_ROWS, columns=[*names])
               for row in _list_texts(batch, names))


def _list_texts(batch: Any, names: Sequence[str]) -> Iterator[list[str]]:
    columns = [batch.column(name).cast(pyarrow.string()).fill_null('').to_pylist()
               for name in names]
    return map(list, zip(*columns))


def _is_text(kind: Any) -> bool:
    """Tell whether a column has texts, or times of the day, whose date is in another column."""
    if pyarrow.types.is_dictionary(kind):
        kind = kind.value_type
    return any(is_kind(kind) for is_kind in (
        pyarrow.types.is_string, pyarrow.types.is_large_string, pyarrow.types.is_time))


class _Times:
    """
    The stamps of the rows of a table.

    Attributes
    ----------
    names
        The columns of times.
    texts
        What reads texts as the stamps of a csv; None for a column of another type.
    n_rows, n_stamps
        Rows read so far, and those of them whose text is a stamp.

    """

    def __init__(self, path: str, file: Any, settings: DriverSettings = DEFAULT_DRIVER) -> None:
        self._path, schema = path, file.schema_arrow
        self.texts: StampColumns | None = None
        columns = find_time_columns(list(schema.names), settings.time_column)
        if columns and _is_text(schema.field(columns[-1]).type):
            self.texts = StampColumns(path, columns, settings, partial(_open_texts, path, columns),
                                      'row')
            self.names = columns
        else:
            self.names = [_time_column(path, file, settings.time_column)]
        self.n_rows = self.n_stamps = 0

    def read(self, batch: Any, not_taken: Counter[str]) -> tuple[Integers, np.ndarray]:
        """Return the stamps of the next rows, ns, and which have one; count why not."""
        begin, self.n_rows = self.n_rows, self.n_rows + len(batch)
        stamped = np.ones(len(batch), bool)
        if self.texts is None:
            return _stamps(self._path, self.names[0], batch.column(self.names[0])), stamped
        stamp_ns = np.zeros(len(batch), np.int64)
        for at, row in enumerate(_list_texts(batch, self.names)):
            try:
                stamp_ns[at] = self.texts.read(_Row(begin + at + 1), row)
            except Rejected as rejected:
                stamped[at] = False
                not_taken[rejected.reason] += 1
        self.n_stamps += int(np.count_nonzero(stamped))
        return stamp_ns, stamped

    def tell(self) -> list[str]:
        """Return what is odd about the texts; ReaderError if none of them is a stamp."""
        if self.texts is None:
            return []
        if self.texts.refusal and not self.n_stamps:
            raise ReaderError(self._path, self.texts.refusal)
        return [*filter(None, (self.texts.origin, self.texts.refusal and
                               f'first row without a stamp: {self.texts.refusal}'))]


def _stamps(path: str, name: str, column: Any) -> Integers:
    """Return a column of times as nanoseconds; 0 where it is null."""
    kind = column.type
    if pyarrow.types.is_timestamp(kind):
        column = column.cast(pyarrow.timestamp('ns', kind.tz)).cast(pyarrow.int64())
    elif not (pyarrow.types.is_floating(kind) or pyarrow.types.is_integer(kind)):
        raise ReaderError(path, f'column {name} is {kind}: must be integers, floats, timestamps '
                          'or texts')
    if not pyarrow.types.is_floating(column.type):
        filled: Integers = column.fill_null(0).to_numpy(zero_copy_only=False).astype(np.int64)
        unit_ns = 1 if pyarrow.types.is_timestamp(kind) else _find_unit(path, name, filled)
        return np.multiply(filled, unit_ns)
    if name.lower().endswith('_ns'):
        raise ReaderError(path, f'column {name} is {kind}: nanoseconds must be integers')
    numbers: Reals = np.nan_to_num(column.to_numpy(zero_copy_only=False))
    unit_ns = _find_unit(path, name, numbers)
    whole = np.floor(numbers)
    rest = np.round((numbers - whole) * unit_ns)
    stamps: Integers = whole.astype(np.int64) * unit_ns + rest.astype(np.int64)
    return stamps


def _find_unit(path: str, name: str, numbers: Integers | Reals) -> int:
    """Return the nanoseconds of the unit of some times; null is 0."""
    times = numbers[numbers != 0]
    low, high = (float(times.min()), float(times.max())) if len(times) else (0.0, 0.0)
    _, likely_ns = find_unit(low, high) or ('', None)
    named = {'_ns': 1, '_s': _SECOND_NS}.get('_' + name.lower().rpartition('_')[2])
    # Numbers of a clock that began at zero are seconds, as their name does not say.
    unit_ns = named or likely_ns or _SECOND_NS
    if named == 1 and (why := looks_like_unit(numbers[:_FIRST_ROWS].astype(np.int64).tolist())):
        raise ReaderError(path, f'column {name}: {why}')
    if (named == _SECOND_NS and likely_ns not in (None, named)
            or max(abs(low), high) * unit_ns >= 2 ** 63):
        raise ReaderError(path, f'column {name}: {low:.0f} to {high:.0f} are no '
                          f'{"seconds" if named else "times"} since 1970; give '
                          'the times as timestamps, or as nanoseconds in a column stamp_ns')
    return unit_ns


def _reals(path: str, name: str, column: Any) -> Reals:
    try:
        reals: Reals = column.cast(pyarrow.float64()).to_numpy(zero_copy_only=False)
        return reals
    except pyarrow.ArrowException:
        raise ReaderError(path, f'column {name} is {column.type}: must be numbers') from None


def read_parquet(path: str, options: StreamOptions = UNSTATED) -> Collected:
    """
    Read the headings of a Parquet table.

    A stream is a column whose name says that it is a heading, and may tell its unit; or one that
    the options name. If there is
    one such column and a column `src`, each source is a stream. The motion of the ship is in the
    columns of `find_motion_columns`.

    Raises
    ------
    OSError
        If the file cannot be read.
    ReaderError
        If it is damaged, or a column is missing or of a wrong type.

    """
    collected = Collected()
    with _open(path) as file:
        names = file.schema_arrow.names
        times = _Times(path, file, options.stamps)
        headings = [name for name in names if name == 'heading_deg' or is_heading_name(name)
                    or options.is_wanted(name)]
        if not headings:
            raise ReaderError(path, f'has the columns {", ".join(names)[:200]}: one must be '
                              'heading_deg')
        by_source = 'src' in names and len(headings) == 1
        motion = find_motion_columns(names)
        columns = [*times.names, *headings, *(['src'] if by_source else []),
                   *(name for column in motion for name in column.names)]
        for batch in file.iter_batches(_ROWS, columns=columns):
            stamps, stamped = times.read(batch, collected.not_taken)
            if not stamped.all():
                batch, stamps = batch.filter(pyarrow.array(stamped)), stamps[stamped]
            for column in motion:
                collected.add_motion_chunk(column.what, ' '.join(column.names), *make_motion(
                    column, stamps,
                    [_reals(path, name, batch.column(name)) for name in column.names]))
            for name in headings:
                angles = Headings(stamps, _reals(path, name, batch.column(name)))
                labels = (batch.column('src').cast(pyarrow.string()).to_numpy(
                    zero_copy_only=False).astype(str) if by_source else None)
                for label in [name] if labels is None else np.unique(labels).tolist():
                    collected.add_angles(label, 'Parquet', angles if labels is None
                                         else angles[labels == label], find_named_unit(name))
        collected.oddities += times.tell()
    return collected


class PairsParquet:
    """
    A Parquet table of pairs, with the columns of `PairsCsv`; used like it.

    Attributes
    ----------
    names : tuple of str
        The columns.
    cut : str
        Empty: a table that is cut cannot be read.
    ignored : tuple of str
        Those that are not read.

    Raises
    ------
    OSError
        If the file cannot be read.
    ReaderError
        If it is damaged, or a column is missing or of a wrong type.

    """

    def __init__(self, path: str) -> None:
        self._path, self.cut = path, ''
        with _open(path) as file:
            self.names = tuple(file.schema_arrow.names)
            times = _Times(path, file)
        self.ignored = tuple(name for name in self.names if name not in (*times.names, *_KNOWN))

    def __iter__(self) -> Iterator[Pairs]:
        """Yield the pairs in file order, at most 65536 rows each."""
        with _open(self._path) as file:
            times = _Times(self._path, file)
            for batch in file.iter_batches(_ROWS):
                stamps, stamped = times.read(batch, Counter())
                if times.texts is not None and not stamped.all():
                    first = times.n_rows - len(batch) + int(np.argmin(stamped)) + 1
                    raise ReaderError(self._path, times.texts.refusal or
                                      f'row {first}: column {" and ".join(times.names)} is empty')
                yield self._pairs(batch, stamps)

    def _pairs(self, batch: Any, stamps: Integers) -> Pairs:
        path = self._path
        ts_deg, rs_deg = (_reals(path, name, batch.column(name)) for name in ('ts_deg', 'rs_deg'))
        factors = []
        for name, absent in _REALS.items():
            column = (_reals(path, name, batch.column(name)) if name in self.names
                      else np.full(len(stamps), absent))
            column = np.where(np.isnan(column), absent, column)
            if not ((column > 0.0) & (column <= LARGEST_FACTOR)).all():
                raise ReaderError(path, f'column {name}: must be above 0 and at most '
                                  f'{LARGEST_FACTOR:g}, or null')
            factors.append(column)
        lag_ns = None
        for name, unit_ns in (('lag_ns', 1), ('lag_s', _SECOND_NS)):
            if name in self.names:
                lag = _reals(path, name, batch.column(name))
                lag_ns = np.round(np.nan_to_num(lag) * unit_ns).astype(np.int64)
                break
        return Pairs.of(stamps, headings_from_signed(ts_deg), headings_from_signed(rs_deg),
                        lag_ns, *factors)
