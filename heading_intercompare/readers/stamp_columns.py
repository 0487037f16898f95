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

"""The stamps of the rows of a table: their columns, the form of their cells, and their unit."""

from __future__ import annotations

from collections import Counter
from decimal import Decimal
from functools import partial
from itertools import islice
import re
from typing import Callable, ContextManager, Iterable, Iterator, NamedTuple, Protocol, Sequence

import numpy as np

from heading_intercompare.bags.csv.csv_rows import CsvRows
from heading_intercompare.bags.csv.plain_rows import Decimals, Flags, PlainRows
from heading_intercompare.bags.csv.stamp_cells import (
    DAY_ZERO_NS,
    looks_like_days,
    nanoseconds,
    scale,
)
from heading_intercompare.core.records import Integers
from heading_intercompare.core.units.given_stamps import find_unit, is_of_satellite_time
from heading_intercompare.core.utc_text import DAY_NS
from heading_intercompare.drivers.log_lines.line_formats import compile_form, FORMATS
from heading_intercompare.drivers.log_lines.log_clocks import start_stamps_of_file
from heading_intercompare.drivers.log_lines.rollovers import Rollovers
from heading_intercompare.drivers.log_lines.times import SECOND_NS
from heading_intercompare.drivers.refused_lines import advise, name_options
from heading_intercompare.drivers.sentences import Rejected
from heading_intercompare.drivers.settings import DEFAULT_DRIVER, DriverSettings

from .json_lines import is_heading_name
from .stream_recording import ReaderError

TIMES = ('t_ns', 'stamp_ns', 'stamp_s', 'stamp_utc', 'timestamp', 'utc', 'datetime', 'date_time',
         'time', 't', 'epoch', 'unixtime', 'u_dday', 'dday')
"""Names of columns of times, in the order in which one is chosen."""

_TIME_WORDS = {'time', 'timestamp', 'utc', 'datetime', 'epoch', 'unixtime', 'stamp'}
_UNITS = {'ns': 1, 'nsec': 1, 'nanoseconds': 1, 'us': 10 ** 3, 'usec': 10 ** 3,
          'microseconds': 10 ** 3, 'ms': 10 ** 6, 'msec': 10 ** 6, 'milliseconds': 10 ** 6,
          's': SECOND_NS, 'sec': SECOND_NS, 'seconds': SECOND_NS}
_WORD = re.compile(r'[A-Z]?[a-z]+|[A-Z]+')
_NUMBER = re.compile(r'\d+(?:[.,]\d*)?(?:[eE]\+?\d+)?', re.ASCII)
_SIX_DIGITS = re.compile(r'(\d\d)(\d\d)(\d\d)((?:[.,]\d*)?)', re.ASCII)
_EIGHT_DIGITS = re.compile(r'((?:19|20)\d\d)(\d\d)(\d\d)', re.ASCII)
#: The seconds of a time of day, and their decimals.
_SECONDS = re.compile(r'(?<![\d:])\d{1,2}:\d\d:(\d\d)((?:[.,]\d+)?)(?![\d:.,])', re.ASCII)
_NO_TIME: Integers = np.zeros(1, np.int64)
_CLOCK = compile_form(next(form.pattern for form in FORMATS if form.name == 'clock'), 'alone')
_HINTS = (
    (_NUMBER, 'write every digit of a number, and its unit at the end of the name of the column '
     '(time_s, time_ms, time_us, time_ns)'),
    (re.compile(r'.*\d[T ]\d{1,2}:\d\d'), 'it has no seconds; write them'),
    (re.compile(r'\d\d?[/.-]\d\d?[/.-]\d\d\D.*'), 'write the year with four digits, or describe '
     'the stamp with --stamp-pattern'))
#: What may stand around a stamp in its cell: brackets, quotes, the day of the week.
_AROUND = re.compile(rb'[\s"\'\[\]()]*(?:(?:Mon|Tue|Wed|Thu|Fri|Sat|Sun)[a-z]*,?)?[\s"\'\[\]()]*')
_MIDNIGHT = re.compile(r'(?<=\d)[T ]00?:00:00(?:[.,]0*)?Z?')
#: Numbers that decide on the unit of all.
_FIRST_ROWS = 1000
#: A number that a program rounded to less than this is no stamp.
_COARSEST_NS = 10 ** 7
#: Of a number of days; seven are 9 ms.
_DECIMALS_OF_DAY = 7
_SHOWN = 80


class _Unit(NamedTuple):
    """The unit of a column of numbers."""

    ns: int
    zero_ns: int = 0
    named: bool = False


def find_time_column(names: Sequence[str]) -> str | None:
    """Return the column of times among the names of a header; None if there is none."""
    by_name = {name.lower(): name for name in reversed(names)}
    column = next((by_name[name] for name in TIMES if name in by_name), None)
    if column is not None:
        return column
    times = [name for name in names if _words(name) & _TIME_WORDS and not is_heading_name(name)
             and not _is_date(name)]
    return times[0] if len(times) == 1 else None


def find_time_columns(names: Sequence[str], stated: str | None = None) -> list[str]:
    """
    Return the columns whose cells together are the stamp of a row.

    Parameters
    ----------
    names
        The names of a header.
    stated
        The setting `time_column`.

    Returns
    -------
    list of str
        A column of times; or one of dates, and one of times of day. Empty if there is none, or
        none of the stated ones.

    """
    if stated is not None:
        columns = [stated] if stated in names else [name.strip() for name in stated.split(',')]
        return columns if set(columns) <= {*names} else []
    time, dates = find_time_column(names), [*filter(_is_date, names)]
    if len(dates) != 1 or time == dates[0]:
        return [] if time is None else [time]
    return dates if time is None else [dates[0], time]


def _words(name: str) -> set[str]:
    return {word.lower() for word in _WORD.findall(name)}


def _is_date(name: str) -> bool:
    words = _words(name)
    return 'date' in words and 'time' not in words


def _unit_in_name(name: str) -> int | None:
    """Return the nanoseconds of the unit that ends the name of a column."""
    words = [word.lower() for word in _WORD.findall(name)]
    return _UNITS.get(words[-1]) if len(words) > 1 else None


class RowPlace(Protocol):
    """Where a row is in its table, and how the numbers of the table are written."""

    @property
    def line(self) -> int:
        """Return the number of the row, from 1."""

    def plain(self, cell: str) -> str:
        """Return the number in a cell with a decimal point; ValueError if it is none."""


class StampColumns:
    """
    Reads the stamps of the rows of one table.

    Parameters
    ----------
    path
        The table.
    names
        The names of its header.
    settings
        The columns of the times; form, zone and pattern of the stamps, and the date of those
        without one.
    open_rows
        Opens the rows of the whole table; by default those of a csv.
    counted
        What the number of a row counts, in one word.

    Attributes
    ----------
    names : list of str
        The columns that are read.
    refusal : str
        The first cell without a stamp: where it is, what it holds, what to set; '' if none.
    origin : str
        Where the date of times of day came from, or what was undone by it.

    Raises
    ------
    ReaderError
        If there is no column of times, or only one of decimal days.

    Notes
    -----
    The cells have the forms of the stamps of logs, see `LineStamps`, and nothing else in them.
    Numbers are all in one unit: that in the name of the column, the one in which most of the
    first rows are times from 1990 to 2100, or days of a spreadsheet.

    """

    def __init__(self, path: str, names: Sequence[str],
                 settings: DriverSettings = DEFAULT_DRIVER,
                 open_rows: Callable[[], ContextManager[Iterable[Sequence[str]]]] | None = None,
                 counted: str = 'line') -> None:
        self._path, self.refusal, self._counted = path, '', counted
        self._open_rows = open_rows or partial(CsvRows, path, '')
        stated = settings.time_column
        self.names = find_time_columns(names, stated)
        if not self.names:
            columns = ', '.join(filter(None, names))[:200]
            raise ReaderError(path, f'has no column of times ({stated or ", ".join(TIMES)}); it '
                              f'has {columns}; name that of the times with --time-column')
        if stated is None and self.names[-1].lower().endswith('dday'):
            raise ReaderError(path, f'column {self.names[-1]}: a decimal day has no year; add a '
                              'column stamp_utc or t_ns')
        self._places = [names.index(name) for name in self.names]
        self._joins = stated is not None and len(self.names) > 1
        self._numeric = (settings.stamp_format in ('auto', 'epoch')
                         and settings.stamp_pattern is None)
        self._auto = settings.stamp_format == 'auto'
        self._has_known_form = settings.stamp_pattern is None
        self._days, self._stamps = start_stamps_of_file(
            settings, path, lambda: (cell.encode() + b'\n' for cell in self._cells()))
        self._rollovers = Rollovers(self._days) if self._days.noon_ns is not None else None
        self._unit: _Unit | None = None
        self._has_looked = False

    @property
    def origin(self) -> str:
        """Return where the date of times came from, in words; '' if they have it themselves."""
        return self._days.origin or (self._rollovers.words if self._rollovers else '')

    def read(self, rows: RowPlace, row: Sequence[str]) -> int:
        """
        Return the stamp of a row, nanoseconds UTC.

        Raises
        ------
        Rejected
            If it has none that is beyond doubt; the reason is one of `STAMP_REASONS`.

        """
        cell = self._text(row)
        try:
            ns = self._read(rows, cell)
            return ns if self._rollovers is None else self._rollovers.undo(ns, None)
        except ReaderError:
            raise
        except (ValueError, ArithmeticError):
            reason = 'bad_stamp'
        except Rejected as rejected:
            reason = rejected.reason
        if not self.refusal and cell:
            self.refusal = (f'{self._counted} {rows.line}: column {" and ".join(self.names)}: '
                            f'{cell[:_SHOWN]!r} is no stamp that can be read: '
                            f'{_advise(reason, cell)}; or name another column with --time-column')
        raise Rejected(reason)

    def read_many(self, rows: CsvRows, plain: PlainRows, not_taken: Counter[str],
                  ) -> tuple[Integers, Flags]:
        """
        Return the stamps of many rows, as `read` returns them one by one.

        Parameters
        ----------
        rows
            The table.
        plain
            Its next rows, n of them.
        not_taken
            Takes the reasons of the rows that have no stamp.

        Returns
        -------
        stamp_ns : ndarray of int64, shape (n,)
            Nanoseconds UTC.
        stamped : ndarray of bool, shape (n,)
            Which rows have one.

        Raises
        ------
        ReaderError
            If the unit of the times is in doubt.

        """
        stamp_ns, stamped = np.zeros(len(plain), np.int64), np.zeros(len(plain), bool)

        def read(at: int) -> None:
            rows.line = plain.line + at
            try:
                stamp_ns[at], stamped[at] = self.read(rows, plain.row(at)), True
            except Rejected as rejected:
                not_taken[rejected.reason] += 1

        place = self._places[-1]
        if self._numeric and len(self._places) == 1:
            numbers = plain.decimals(place, rows.mark)
            unit = self._find_unit() if (numbers.plain & (numbers.sign == 0)).any() else None
            if unit is not None:
                stamp_ns, stamped = _read_numbers(numbers, unit)
                stamped &= self._leaves(stamp_ns[stamped])
                for at in np.flatnonzero(~stamped).tolist():
                    read(at)
                return stamp_ns, stamped
        for lo, hi in self._find_alike(plain):
            for first, last, elapsed_ns in self._find_minutes(plain, lo, hi):
                read(first)
                if stamped[first] and last - first > 1 and self._leaves(stamp_ns[first:first + 1]):
                    stamp_ns[first + 1:last] = stamp_ns[first] + elapsed_ns[1:]
                    stamped[first + 1:last] = True
                    # The day of the next time of day follows the last one.
                    read(last - 1)
                else:
                    for at in range(first + 1, last):
                        read(at)
        return stamp_ns, stamped

    def _leaves(self, stamp_ns: Integers) -> bool:
        """Tell whether no rollover of GPS is undone in some stamps."""
        return self._rollovers is None or not len(stamp_ns) or self._rollovers.is_idle(
            int(stamp_ns.min()), int(stamp_ns.max()))

    def _find_alike(self, plain: PlainRows) -> Iterator[tuple[int, int]]:
        """Yield the runs of rows whose stamps have the same length."""
        changes = np.zeros(len(plain) - 1, bool)
        for place in self._places:
            changes |= np.diff(plain.lengths(place)) != 0
        edges = [0, *(np.flatnonzero(changes) + 1).tolist(), len(plain)]
        return zip(edges, edges[1:])

    def _find_minutes(self, plain: PlainRows, lo: int, hi: int,
                      ) -> Iterator[tuple[int, int, Integers]]:
        """
        Yield the runs of rows whose stamps differ in seconds alone.

        Yields
        ------
        first, last : int
            The first row of a run, and the one after it.
        elapsed_ns : ndarray of int64, shape (last - first,)
            From the stamp of the first row to that of each row.

        """
        digits = self._find_seconds(plain.row(lo)) if hi - lo > 1 else None
        if digits is None:
            yield from ((at, at + 1, _NO_TIME) for at in range(lo, hi))
            return
        seconds_at, fraction_at = digits
        *others, last = [plain.texts(place, lo, hi) for place in self._places]
        seconds, good = last.whole(seconds_at)
        fraction, good_fraction = last.whole(fraction_at)
        good &= good_fraction & (seconds < 60)
        elapsed_ns = seconds * SECOND_NS + fraction * 10 ** (9 - len(fraction_at))
        alike = good[1:] & good[:-1] & last.equal_before([*seconds_at, *fraction_at])
        for texts in others:
            alike &= texts.equal_before([])
        edges = [0, *(np.flatnonzero(~alike) + 1).tolist(), hi - lo]
        for first, after in zip(edges, edges[1:]):
            yield lo + first, lo + after, elapsed_ns[first:after] - elapsed_ns[first]

    def _find_seconds(self, row: Sequence[str]) -> tuple[list[int], list[int]] | None:
        """Return where the last cell of a stamp has seconds and decimals; None if unsure."""
        cell = row[self._places[-1]].strip(' ')
        times = [*_SECONDS.finditer(cell)] if self._has_known_form and cell.isascii() else []
        match = (times[0] if len(times) == 1
                 else _SIX_DIGITS.fullmatch(cell) if len(self._places) == 2 else None)
        if match is None:
            return None
        *_, seconds, decimals = range(1, match.re.groups + 1)
        lo, hi = match.span(decimals)
        while lo < hi and not cell[lo].isdigit():
            lo += 1
        return ([*range(*match.span(seconds))], [*range(lo, hi)]) if hi - lo <= 9 else None

    def _text(self, row: Sequence[str]) -> str:
        """Return the cells of a stamp as one text; '' if one of them is empty."""
        cells = [row[place].strip() if place < len(row) else '' for place in self._places]
        last = cells[-1]
        if len(cells) == 1 or not self._joins and not (
                _CLOCK.match(last.encode()) or _SIX_DIGITS.fullmatch(last)):
            return last
        if not all(cells):
            return ''
        if len(cells) == 2:
            cells = [_write_date(cells[0]), _write_clock(last)]
        return ' '.join(cells)

    def _cells(self) -> Iterator[str]:
        """Yield the stamps of the whole table as texts."""
        with self._open_rows() as rows:
            for row in rows:
                yield self._text(row)

    def _read(self, rows: RowPlace, cell: str) -> int:
        if not cell:
            raise Rejected('no_stamp')
        if self._numeric and _NUMBER.fullmatch(cell):
            number = rows.plain(cell)
            unit = self._find_unit()
            if unit is not None:
                return _read_number(number, unit)
            if not self._auto:
                raise Rejected('bad_stamp')
        text = cell.encode()
        try:
            ns = self._stamps.own_ns(text, b'')
        except Rejected as rejected:
            # A time of day within another text is no stamp without a date.
            raise (rejected if rejected.reason != 'no_date' or _CLOCK.match(text)
                   else Rejected('bad_stamp')) from None
        if ns is None or self._stamps.form == 'epoch' or not _AROUND.fullmatch(self._stamps.words):
            raise Rejected('bad_stamp')
        return ns

    def _find_unit(self) -> _Unit | None:
        """Return the unit of the numbers, by the first of them."""
        if not self._has_looked:
            self._has_looked = True
            self._unit = self._choose_unit(
                [cell.replace(',', '.') for cell in islice(self._cells(), _FIRST_ROWS)
                 if _NUMBER.fullmatch(cell)])
        return self._unit

    def _choose_unit(self, cells: list[str]) -> _Unit | None:
        numbers = [*map(float, cells)]
        units = Counter(filter(None, (find_unit(number, number) for number in numbers)))
        likely = units.most_common(1)[0][0] if units else None
        name = self.names[-1]
        named_ns = _unit_in_name(name) if len(self.names) == 1 else None
        if named_ns is not None:
            times = [*filter(None, numbers)] or [0.0]
            whole = find_unit(min(times), max(times))
            if whole is not None and whole[1] != named_ns:
                raise ReaderError(self._path, f'column {name}: {cells[0]} looks like {whole[0]} '
                                  'since 1970, which its name contradicts; rename it')
            return _Unit(named_ns, named=True)
        if likely is not None:
            return _Unit(likely[1])
        if not looks_like_days([round(number * SECOND_NS) for number in numbers]):
            return None
        if max(len(cell.partition('.')[2]) for cell in cells) < _DECIMALS_OF_DAY:
            raise ReaderError(self._path, f'column {name}: {cells[0]} is the day of a spreadsheet '
                              'that rounded it to less than its seconds; format the column as '
                              'yyyy-mm-dd hh:mm:ss.000')
        return _Unit(DAY_NS, DAY_ZERO_NS)


def _write_date(cell: str) -> str:
    """Return a date with marks between its numbers, and without the midnight of a spreadsheet."""
    if match := _EIGHT_DIGITS.fullmatch(cell):
        return '-'.join(match.groups())
    match = _MIDNIGHT.search(cell)
    return cell[:match.start()] if match and match.end() == len(cell) else cell


def _write_clock(cell: str) -> str:
    """Return a time of day with marks between its numbers."""
    match = _SIX_DIGITS.fullmatch(cell)
    return f'{match[1]}:{match[2]}:{match[3]}{match[4]}' if match else cell


def _advise(reason: str, cell: str) -> str:
    """Return what to do about a cell without a stamp, with the options of the command line."""
    hint = next((words for form, words in _HINTS if form.fullmatch(cell)), None)
    return hint if hint and reason == 'bad_stamp' else name_options(advise(reason), None)


def _read_number(number: str, unit: _Unit) -> int:
    """Return a number of a unit as nanoseconds; ValueError if it is no time or a rounded one."""
    if unit.ns == SECOND_NS:
        ns = nanoseconds(number)
    elif number.isdecimal():
        ns = unit.zero_ns + int(number) * unit.ns
    else:
        ns = unit.zero_ns + scale(number, unit.ns)
    if 'e' in number.lower():
        exponent = Decimal(number).as_tuple().exponent
        if not isinstance(exponent, int) or Decimal(10) ** exponent * unit.ns > _COARSEST_NS:
            raise ValueError(number)
    if not (0 <= ns < 2 ** 63 if unit.named else is_of_satellite_time(ns)):
        raise ValueError(number)
    return ns


def _read_numbers(numbers: Decimals, unit: _Unit) -> tuple[Integers, Flags]:
    """Return numbers of a unit as nanoseconds, and which of them `_read_number` reads so."""
    places = len(str(unit.ns)) - 1
    stamp_ns, good = numbers.scaled(places)
    good &= (numbers.sign == 0) & (unit.ns == 10 ** places and not unit.zero_ns)
    if not unit.named:
        good &= is_of_satellite_time(stamp_ns)
    return stamp_ns, good
