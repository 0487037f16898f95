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
Times in text: dates, times of day, ZDA and RMC, GPS weeks. All exact integers.

Text is always ASCII bytes. Decimals after the ninth are cut off.
"""

from __future__ import annotations

from datetime import date
from functools import lru_cache
import re
from typing import Callable

from heading_intercompare.core.utc_text import DAY_NS

SECOND_NS = 1_000_000_000

WEEK_NS = 7 * DAY_NS

_EPOCH = re.compile(rb'(\d{10}|\d{13}|\d{16}|\d{19})(?:\.(\d*))?\Z')
_CLOCK = re.compile(rb'(\d\d)(\d\d)(\d\d)(?:\.(\d*))?\Z')


def fraction_ns(digits: bytes | None) -> int:
    """Return the decimals of a second in nanoseconds."""
    return int(digits[:9].ljust(9, b'0')) if digits else 0


def clock_ns(hours: int, minutes: int, seconds: int) -> int:
    """Return nanoseconds since midnight; ValueError if there is no such time."""
    if hours > 23 or minutes > 59 or seconds > 60:
        raise ValueError('time of day')
    return (hours * 3600 + minutes * 60 + seconds) * SECOND_NS


@lru_cache(maxsize=64)
def date_ns(year: int, month: int, day: int) -> int:
    """Return the start of a day, nanoseconds UTC; ValueError if there is no such day."""
    if not 1970 <= year <= 2261:
        raise ValueError('year')
    return (date(year, month, day).toordinal() - date(1970, 1, 1).toordinal()) * DAY_NS


def short_year(year: int) -> int:
    """Return the year that two digits mean, as in POSIX: 69 is 1969, 68 is 2068."""
    return year + (2000 if year < 69 else 1900)


def year_day_ns(year: int, day: int) -> int:
    """Return the start of a day of the year, 1 to 366; ValueError if there is no such day."""
    first = date_ns(year, 1, 1)
    if not 1 <= day <= (date_ns(year + 1, 1, 1) - first) // DAY_NS:
        raise ValueError('day of the year')
    return first + (day - 1) * DAY_NS


def day_time_ns(field: bytes) -> int:
    """Return nanoseconds since midnight of `hhmmss.sss`; ValueError if it is not a time."""
    match = _CLOCK.match(field.strip())
    if match is None:
        raise ValueError('time of day')
    return clock_ns(int(match[1]), int(match[2]), int(match[3])) + fraction_ns(match[4])


def _date_and_time_ns(field: bytes) -> int:
    """Return the time of `yyyymmddhhmmss.sss`, nanoseconds; ValueError if it is none."""
    text = field.strip()
    if not text[:8].isdigit():
        raise ValueError('date')
    return date_ns(int(text[:4]), int(text[4:6]), int(text[6:8])) + day_time_ns(text[8:])


def _epoch_ns(field: bytes) -> int:
    """Return Unix time in seconds, or in its thousandths by the number of digits; ValueError."""
    match = _EPOCH.match(field.strip())
    if match is None:
        raise ValueError('epoch')
    unit_ns: int = 10 ** (19 - len(match[1]))
    return int(match[1]) * unit_ns + fraction_ns(match[2]) * unit_ns // SECOND_NS


DATED_CLOCKS: dict[str, Callable[[bytes], int]] = {
    'yyyymmddhhmmss': _date_and_time_ns, 'epoch': _epoch_ns}
"""Times with their date in one field of a sentence, nanoseconds UTC; ValueError if it is none."""


def zda_ns(fields: list[bytes]) -> int:
    """
    Return the time of a ZDA sentence.

    Parameters
    ----------
    fields
        Its fields with the address: `xxZDA,hhmmss.ss,dd,mm,yyyy,...`. The time is UTC; the local
        zone after the year is ignored.

    Returns
    -------
    int
        Nanoseconds UTC.

    Raises
    ------
    ValueError
        If time or date is missing or impossible.

    Examples
    --------
    >>> zda_ns(b'INZDA,000000.17,01,08,2014,,'.split(b','))
    1406851200170000000

    """
    if len(fields) < 5 or not all(f.isdigit() for f in fields[2:5]) or len(fields[4]) != 4:
        raise ValueError('date')
    return (date_ns(int(fields[4]), int(fields[3]), int(fields[2]))
            + day_time_ns(fields[1]))


def rmc_ns(fields: list[bytes]) -> int:
    """
    Return the time of an RMC sentence.

    Parameters
    ----------
    fields
        Its fields with the address: `xxRMC,hhmmss.ss,A,lat,N,lon,E,speed,course,ddmmyy,...`.

    Returns
    -------
    int
        Nanoseconds UTC; a year of two digits as in POSIX.

    Raises
    ------
    ValueError
        If the receiver warns (V), or time or date is missing or impossible.

    Examples
    --------
    >>> rmc_ns(b'GPRMC,000000.17,A,1,S,1,W,9.5,218.5,010814,,'.split(b','))
    1406851200170000000

    """
    if len(fields) < 10 or fields[2] != b'A' or len(fields[9]) != 6 or not fields[9].isdigit():
        raise ValueError('date')
    day, month, year = (int(fields[9][at:at + 2]) for at in (0, 2, 4))
    return date_ns(short_year(year), month, day) + day_time_ns(fields[1])


_is_decimal = re.compile(rb'(\d+)(?:\.(\d*))?\Z').match
#: GPS minus UTC in seconds, from the start of a day on. Bulletin C of IERS announces new ones.
_LEAP_SECONDS = (((2017, 1, 1), 18), ((2015, 7, 1), 17), ((2012, 7, 1), 16), ((2009, 1, 1), 15),
                 ((2006, 1, 1), 14), ((1999, 1, 1), 13))


def gps_ns(week: int, of_week_ns: int, undo: Callable[[int], int] = lambda ns: ns) -> int:
    """
    Return a time of GPS, nanoseconds UTC; ValueError before 1999 or beyond the week.

    Parameters
    ----------
    week, of_week_ns
        Week of GPS, and nanoseconds of the week.
    undo
        Undoes rollovers of the week that the receiver has missed.

    Examples
    --------
    >>> gps_ns(2316, 244_818 * SECOND_NS) == date_ns(2024, 5, 28) + 20 * 3600 * SECOND_NS
    True

    """
    ns = undo(date_ns(1980, 1, 6) + week * WEEK_NS + of_week_ns)
    if of_week_ns < WEEK_NS:
        for day, leap_s in _LEAP_SECONDS:
            if ns - leap_s * SECOND_NS >= date_ns(*day):
                return ns - leap_s * SECOND_NS
    raise ValueError('GPS time')


def receiver_log_ns(fields: list[bytes], week: int = 0,
                    undo: Callable[[int], int] = lambda ns: ns) -> int:
    """
    Return the time of a log of a receiver.

    Parameters
    ----------
    fields
        Its fields with the name. The header is `#name,port,sequence,idle,status,week,second,...`
        (NovAtel), `#name,idle,GPS,status,week,millisecond,...` (Unicore), or the short one,
        `%name,week,second`.
    week
        Field of the week of GPS, before that of its second; 0: the header has them.
    undo
        As for `gps_ns`.

    Returns
    -------
    int
        Nanoseconds UTC.

    Raises
    ------
    ValueError
        If the receiver does not know the time of GPS finely, or it is missing or impossible.

    """
    unit_ns = SECOND_NS
    if not week and fields[0][:1] == b'%':
        week = 1
    elif not week:
        week, unit_ns = (4, 1_000_000) if fields[2] == b'GPS' else (5, SECOND_NS)
        if not fields[week - 1].startswith(b'FINE'):
            raise ValueError('time status')
    second = _is_decimal(fields[week + 1])
    if second is None or not fields[week].isdigit():
        raise ValueError('GPS time')
    return gps_ns(int(fields[week]),
                  int(second[1]) * unit_ns + fraction_ns(second[2]) * unit_ns // SECOND_NS, undo)


def gga_ns(fields: list[bytes]) -> int:
    """
    Return the time of day of a GGA sentence.

    Parameters
    ----------
    fields
        Its fields with the address: `xxGGA,hhmmss.ss,lat,N,lon,E,quality,...`.

    Returns
    -------
    int
        Nanoseconds since midnight UTC.

    Raises
    ------
    ValueError
        If the receiver has no fix (quality 0 or empty), or the time is missing.

    """
    if len(fields) < 7 or fields[6] in (b'', b'0'):
        raise ValueError('no fix')
    return day_time_ns(fields[1])


def nearest_day_ns(time_of_day_ns: int, near_ns: int) -> int:
    """Return the instant of this time of day that is nearest to `near_ns`, nanoseconds UTC."""
    days = (near_ns - time_of_day_ns + DAY_NS // 2) // DAY_NS
    return days * DAY_NS + time_of_day_ns
