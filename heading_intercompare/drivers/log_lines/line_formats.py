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
The forms in which logs write the stamp of a line: a table, with an example of each.

A pattern has three groups: date and clock to the second, decimals of the second, zone. A stamp
may stand anywhere before the sentence, or after it. Words may stand around it.
"""

from __future__ import annotations

from functools import lru_cache
import re
from typing import Callable, NamedTuple

from heading_intercompare.core.utc_text import DAY_NS

from .times import (
    clock_ns,
    date_ns,
    day_time_ns,
    fraction_ns,
    SECOND_NS,
    short_year,
    year_day_ns,
)

_MONTHS = {name: number for number, name in enumerate(
    (b'jan', b'feb', b'mar', b'apr', b'may', b'jun', b'jul', b'aug', b'sep', b'oct', b'nov',
     b'dec'), 1)}
_NAMED_ZONES = (b'A[CEKW]?[SD]T', b'BST', b'CES?T', b'C[SD]T', b'EES?T', b'E[SD]T', b'HK?[SD]?T',
                b'I[SD]T', b'JST', b'KST', b'MSK', b'M[SD]T', b'NZ[SD]T', b'P[SD]T', b'SGT',
                b'WES?T')
#: After a comma, one or two digits before another comma, or a decimal number, are a field.
#: After a colon, an underline or nothing, only whole groups of three digits are decimals.
_THREES = rb'(?=\d{3}(?:\d{3}){0,2}(?![\d:]))'
_FRACTION = rb'(?:(?:\.|,(?!\d\d?,|\d+\.\d)|[:_]' + _THREES + rb')(\d+))?'
_COMPACT_FRACTION = rb'(?:(?:\.|,(?!\d\d?,|\d+\.\d)|[:_]?' + _THREES + rb')(\d+))?'
_ZONE = (rb'(?:[ ]?(Z|UTC|GMT|[AaPp]\.?[Mm]\.?|[+-]\d\d(?::?\d\d)?(?![\d.:])|'
         + b'|'.join(_NAMED_ZONES) + rb')(?![0-9A-Za-z]))?')
_CLOCK = rb'\d{1,2}:\d\d:\d\d'
_APART = rb'[ \t,;:_|"\'-]+'
_MONTH = rb'(?:Jan|Feb|Mar|Apr|May|Jun|Jul|Aug|Sep|Oct|Nov|Dec)[a-z]*'
_MARK = rb'[-/.,;_ \t]{1,3}'


class LineFormat(NamedTuple):
    """
    One form of stamp.

    Attributes
    ----------
    name
        The value of the setting `stamp_format`.
    words
        What it looks like.
    pattern
        Regular expression with three groups: date and clock, decimals, zone.
    read
        From the first group to nanoseconds; ValueError if there is no such instant.
    kind : {'instant', 'date', 'clock'}
        Unix time; date and clock of a zone; the clock alone, nanoseconds since midnight.
    example
        A line.
    stamp
        The stamp of the example, UTC.
    automatic
        Whether 'auto' looks for it.

    """

    name: str
    words: str
    pattern: bytes
    read: Callable[[bytes], int]
    kind: str
    example: bytes
    stamp: str
    automatic: bool = True


_DIGITS = re.compile(rb'\d+').findall
_CLOCK_PARTS = re.compile(rb'(\d+):(\d\d):(\d\d)(?:[.,](\d+))?').search


def _numbers(text: bytes) -> list[int]:
    return [int(digits) for digits in _DIGITS(text)]


@lru_cache(maxsize=64)
def _day_ns(day: bytes) -> int:
    return date_ns(*_numbers(day))


def _read_iso(text: bytes) -> int:
    if len(text) == 19 and text[11:13].isdigit():
        return _day_ns(text[:10]) + clock_ns(int(text[11:13]), int(text[14:16]), int(text[17:]))
    year, month, day, *clock = _numbers(text)
    return date_ns(year, month, day) + clock_ns(*clock)


def _read_compact(text: bytes) -> int:
    return (date_ns(int(text[:4]), int(text[4:6]), int(text[6:8]))
            + clock_ns(int(text[-6:-4]), int(text[-4:-2]), int(text[-2:])))


def _read_doy(text: bytes) -> int:
    year, day, *clock = _numbers(text)
    if not text[:4].isdigit():
        year = short_year(year)
    return year_day_ns(year, day) + clock_ns(*clock)


def _read_named(text: bytes) -> int:
    day, year, *clock = _numbers(text)
    month = _MONTHS[re.findall(rb'[A-Za-z]{3}', text)[0].lower()]
    return date_ns(year, month, day) + clock_ns(*clock)


def _read_asctime(text: bytes) -> int:
    month, clock = _MONTHS[text[:3].lower()], _CLOCK_PARTS(text)
    assert clock is not None
    day, year = _numbers(text[:clock.start()])[0], int(text[-4:])
    return (date_ns(year, month, day) + clock_ns(*map(int, clock.group(1, 2, 3)))
            + fraction_ns(clock[4]))


def _read_mdy(text: bytes) -> int:
    month, day, year, *clock = _numbers(text)
    return date_ns(year, month, day) + clock_ns(*clock)


def _read_dmy(text: bytes) -> int:
    day, month, year, *clock = _numbers(text)
    return date_ns(year, month, day) + clock_ns(*clock)


def _read_epoch(text: bytes) -> int:
    unit_ns: int = 10 ** (19 - len(text))
    return int(text) * unit_ns


def _read_clock(text: bytes) -> int:
    return clock_ns(*_numbers(text))


_NUMERIC = (rb'(\d{1,2}[/.-]\d{1,2}[/.-]\d{4}' + rb'(?:T|' + _APART + rb')' + _CLOCK + rb')'
            + _FRACTION + _ZONE)
_HDT = b'$HEHDT,218.53,T*12'

#: The forms, in the order in which 'auto' looks for them.
FORMATS = (
    LineFormat(
        name='iso', words=(
            'year, month, day and clock, with - or / or . in the date, T, blank, comma '
            'or semicolon before the clock; UTC or with an offset'),
        pattern=rb'(\d{4}[-/.]\d{1,2}[-/.]\d{1,2}(?:T|' + _APART + rb')' + _CLOCK + rb')'
            + _FRACTION + _ZONE, read=_read_iso, kind='date',
        example=b'NAV 2025/06/18 14:00:00.828 GYRO ' + _HDT, stamp='2025-06-18T14:00:00.828'),
    LineFormat(
        name='doy', words='year of two or four digits, day of the year, clock',
        pattern=rb'((?:\d{4}[+:/ .,_-]|\d\d[+:/-])\d{3}[T: ,./_]' + _CLOCK + rb')'
            + _FRACTION + _ZONE, read=_read_doy, kind='date',
        example=b'19+085:10:05:54.447 ' + _HDT, stamp='2019-03-26T10:05:54.447'),
    LineFormat(
        name='compact',
        words='year, month and day, hours, minutes and seconds without marks between',
        pattern=rb'((?:19|20)\d\d(?:0\d|1[0-2])[0-3]\d[T _-]?[0-2]\d[0-5]\d[0-6]\d)'
            + _COMPACT_FRACTION
            + _ZONE, read=_read_compact, kind='date', example=b'20240528T200000.063Z ' + _HDT,
        stamp='2024-05-28T20:00:00.063'),
    LineFormat(
        name='named', words='day, name of the month in English, year, clock',
        pattern=rb'(\d{1,2}[ /-]?' + _MONTH + rb'[ /-]?\d{4}' + _APART + _CLOCK + rb')'
            + _FRACTION + _ZONE, read=_read_named, kind='date',
        example=b'28-May-2024 20:00:00.063 ' + _HDT, stamp='2024-05-28T20:00:00.063'),
    LineFormat(
        name='month', words='name of the month in English, day, year, clock',
        pattern=rb'(' + _MONTH + rb'[ /.-]{1,2}\d{1,2}[ ,/-]{1,2}\d{4}' + _APART + _CLOCK + rb')'
            + _FRACTION + _ZONE, read=_read_named, kind='date',
        example=b'May 28, 2024 20:00:00.063 ' + _HDT, stamp='2024-05-28T20:00:00.063'),
    LineFormat(
        name='asctime', words=(
            'name of the month in English, day, clock, year, as the C library '
            'writes it'), pattern=rb'(' + _MONTH + rb'[ ]{1,2}\d{1,2}[ ]' + _CLOCK
            + rb'(?:[.,]\d+)?(?:[ ](?:UTC|GMT))?[ ](?:19|20)\d\d(?!\d))()()', read=_read_asctime,
        kind='date', example=b'Tue May 28 20:00:00 2024 ' + _HDT, stamp='2024-05-28T20:00:00'),
    LineFormat(name='mdy', words='month first, as SCS writes it; see below', pattern=_NUMERIC,
               read=_read_mdy, kind='date', example=b'05/28/2024,20:00:00.063,' + _HDT,
               stamp='2024-05-28T20:00:00.063'),
    LineFormat(name='dmy', words='day first; see below', pattern=_NUMERIC, read=_read_dmy,
               kind='date', example=b'28.05.2024 20:00:00,063; ' + _HDT,
               stamp='2024-05-28T20:00:00.063'),
    LineFormat(
        name='fields', words=(
            'six numbers, from the year to the second, as fields or with the same '
            'marks throughout'),
        pattern=rb'((?:19|20)\d\d(?:' + _MARK + rb'\d{1,2}){2}(?:T|' + _MARK + rb')\d{1,2}(?:'
            + _MARK + rb'\d{1,2}){2})' + _FRACTION + _ZONE, read=_read_iso, kind='date',
        example=b'2024,05,28,20,00,00.063,' + _HDT, stamp='2024-05-28T20:00:00.063'),
    LineFormat(
        name='epoch', words=(
            'Unix time in seconds with decimals, or in milli-, micro- or nanoseconds '
            'by the number of digits'), pattern=rb'(\d{10}|\d{13}|\d{16}|\d{19})(?:\.(\d+))?()',
        read=_read_epoch, kind='instant', example=_HDT + b',1716926400.063',
        stamp='2024-05-28T20:00:00.063'),
    LineFormat(
        name='clock', words=(
            'the time of day alone; the date comes from the setting `date`, from ZDA '
            'or RMC of the same log, or from the name of the file'),
        pattern=rb'((?<!\d:)' + _CLOCK + rb'(?!:\d\d?(?!\d)))' + _FRACTION + _ZONE,
        read=_read_clock, kind='clock', example=b'[20:00:00.063] ' + _HDT,
        stamp='2024-05-28T20:00:00.063'),
    LineFormat(
        name='hhmmss',
        words='the time of day alone, without marks between; the date as for `clock`',
        pattern=rb'([0-2]\d[0-5]\d[0-6]\d)' + _FRACTION + _ZONE, read=day_time_ns, kind='clock',
        example=b'200000.063 ' + _HDT, stamp='2024-05-28T20:00:00.063', automatic=False),
)

#: Forms with the same pattern; 'auto' takes one of them only if the log says which.
NUMERIC_DATES = ('mdy', 'dmy')

_BEFORE = rb'(?<![0-9A-Za-z.+-])'
_REST = {'alone': rb'[\s,;:|>\])"\'-]*\Z', 'last': rb'[\s,;:|>\])"\'-]*\Z',
         'anywhere': rb'(?![0-9A-Za-z])'}


@lru_cache(maxsize=64)
def compile_form(pattern: bytes, place: str) -> re.Pattern[bytes]:
    """
    Return a pattern whose `match` finds the last stamp of one form in a text.

    Parameters
    ----------
    pattern
        Of a `LineFormat`.
    place : {'alone', 'last', 'anywhere'}
        'alone': the stamp begins the text, and only separators and brackets follow it; the
        fastest. 'last': words may stand before it. 'anywhere': words may follow it too.

    """
    before = b'' if place == 'alone' else rb'.*' + _BEFORE
    return re.compile(before + rb'(?:' + pattern + rb')' + _REST[place], re.DOTALL)


def read_zone(ns: int, zone: bytes) -> int:
    """
    Return UTC for a clock with a zone as it was written.

    Parameters
    ----------
    ns
        Nanoseconds of the clock as written.
    zone
        'Z', 'UTC', 'GMT' or an offset such as '+02:00'.

    Raises
    ------
    ValueError
        If the zone is another name, whose offset is not known.

    """
    if zone in (b'Z', b'UTC', b'GMT'):
        return ns
    if zone[:1] in (b'+', b'-'):
        digits = zone[1:].replace(b':', b'')
        offset_ns = (int(digits[:2]) * 3600 + int(digits[2:] or 0) * 60) * SECOND_NS
        return ns - offset_ns if zone[:1] == b'+' else ns + offset_ns
    raise ValueError('name of a zone')


def half_day_ns(ns: int, zone: bytes) -> int:
    """Return the 24-hour clock for a clock with AM or PM; ValueError if the hour is not 1-12."""
    hour = ns % DAY_NS // (3600 * SECOND_NS)
    if not 1 <= hour <= 12:
        raise ValueError('hour with AM or PM')
    shift = (12 if zone[:1] in b'Pp' else 0) - (12 if hour == 12 else 0)
    return ns + shift * 3600 * SECOND_NS


def read_own(match: re.Match[bytes]) -> tuple[str, int, bytes | None]:
    """
    Return kind, nanoseconds and zone of a stamp that a pattern of one's own found.

    Its groups are named: `epoch`; or `hour`, `minute`, `second`, with `year`, `month` (number or
    English name) and `day`, or `year` and `yday`, or without a date. `fraction` and `zone` may be
    missing.

    Raises
    ------
    ValueError
        If there is no such instant.

    """
    parts = {name: text for name, text in match.groupdict().items() if text is not None}
    if 'epoch' not in parts and not {'hour', 'minute', 'second'} <= set(parts):
        raise ValueError('time of day')
    decimals_ns = fraction_ns(parts.get('fraction'))
    if 'epoch' in parts:
        digits = parts['epoch']
        if len(digits) > 19:
            raise ValueError('year')
        unit_digits = len(digits) if len(digits) in (13, 16, 19) else 10
        return 'instant', (int(digits) * 10 ** (19 - unit_digits)
                           + decimals_ns // 10 ** (unit_digits - 10)), None
    ns = clock_ns(int(parts['hour']), int(parts['minute']), int(parts['second'])) + decimals_ns
    zone = parts.get('zone')
    if 'year' not in parts:
        return 'clock', ns, zone
    year = int(parts['year']) if len(parts['year']) == 4 else short_year(int(parts['year']))
    if 'yday' not in parts and not {'month', 'day'} <= set(parts):
        raise ValueError('date')
    if 'yday' in parts:
        return 'date', ns + year_day_ns(year, int(parts['yday'])), zone
    month = parts['month']
    number = int(month) if month.isdigit() else _MONTHS.get(month[:3].lower(), 0)
    return 'date', ns + date_ns(year, number, int(parts['day'])), zone
