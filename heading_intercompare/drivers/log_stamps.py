# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Times in text: stamps before the sentences of a log, ZDA, time of day. All exact integers.

Text is always ASCII bytes. Decimals after the ninth are cut off.
"""

from __future__ import annotations

from datetime import date
from functools import lru_cache, reduce
from operator import xor
import re

__all__ = ['DAY_NS', 'day_time_ns', 'log_stamp_ns', 'nearest_day_ns', 'zda_ns']

SECOND_NS = 1_000_000_000
DAY_NS = 86_400 * SECOND_NS

_TAGS = re.compile(rb'(?:\\[^\\]*\\\s*)+\Z')
_TAG = re.compile(rb'\\([^\\*]*)\*([0-9A-Fa-f]{2})\\')
_CLOCK = re.compile(rb'(\d\d)(\d\d)(\d\d)(?:\.(\d*))?\Z')
_FORMS = {
    'iso': rb'(\d{4}-\d\d-\d\d[T :_]\d\d:\d\d:\d\d)(?:[.,](\d+))?(?:Z|([+-]\d\d:?\d\d))?',
    'doy': rb'((?:\d\d|\d{4})[+:-]\d{3}:\d\d:\d\d:\d\d)(?:[.,](\d+))?Z?()',
    'epoch': rb'(\d{10})(?:\.(\d+))?()|(\d{13}|\d{16}|\d{19})()()',
}


def _pattern(*names: str) -> re.Pattern:
    """Return a pattern for a stamp at the end of a text; groups: seconds, decimals, zone."""
    forms = b'|'.join(_FORMS[name] for name in names)
    return re.compile(rb'(?<![0-9A-Za-z.+-])(?:' + forms + rb')[\s,;:]*\Z')


_PATTERNS = {'auto': _pattern(*_FORMS), **{name: _pattern(name) for name in _FORMS}}


def _fraction_ns(digits: bytes | None) -> int:
    return int(digits[:9].ljust(9, b'0')) if digits else 0


def _clock_ns(hours: bytes, minutes: bytes, seconds: bytes) -> int:
    h, m, s = int(hours), int(minutes), int(seconds)
    if h > 23 or m > 59 or s > 60:
        raise ValueError('time of day')
    return (h * 3600 + m * 60 + s) * SECOND_NS


@lru_cache(maxsize=64)
def _date_ns(year: int, month: int, day: int) -> int:
    if not 1970 <= year <= 2261:
        raise ValueError('year')
    return (date(year, month, day).toordinal() - date(1970, 1, 1).toordinal()) * DAY_NS


def _year_day_ns(year: bytes, day: bytes) -> int:
    """Return the start of a day of the year, 1 to 366; years of two digits as in POSIX."""
    y, d = int(year), int(day)
    if len(year) == 2:
        y += 2000 if y < 69 else 1900
    first = _date_ns(y, 1, 1)
    if not 1 <= d <= (_date_ns(y + 1, 1, 1) - first) // DAY_NS:
        raise ValueError('day of the year')
    return first + (d - 1) * DAY_NS


@lru_cache(maxsize=1024)
def _second_ns(text: bytes) -> int:
    """Return the part of a stamp before its fraction, nanoseconds."""
    if b':' not in text:
        return int(text) * 10 ** (19 - len(text))
    day, clock = text[:-9], text[-8:].split(b':')
    if len(day) == 10:
        day_ns = _date_ns(int(day[0:4]), int(day[5:7]), int(day[8:10]))
    else:
        day_ns = _year_day_ns(day[:-4], day[-3:])
    return day_ns + _clock_ns(*clock)


def _stamp_ns(text: bytes, stamp_format: str) -> int | None:
    match = _PATTERNS[stamp_format].search(text)
    if match is None:
        return None
    first = (match.lastindex - 1) // 3 * 3 + 1
    seconds, digits, zone = match.group(first, first + 1, first + 2)
    ns = _second_ns(seconds)
    if digits:
        ns += _fraction_ns(digits)
    if zone:
        offset_ns = (int(zone[1:3]) * 3600 + int(zone[-2:]) * 60) * SECOND_NS
        ns -= offset_ns if zone[:1] == b'+' else -offset_ns
    if not 0 <= ns < 2 ** 63:
        raise ValueError('year')
    return ns


def _tag(prefix: bytes) -> int | None:
    """Return the time `c:` of the last TAG block that has one and a correct checksum."""
    for text, checksum in reversed(_TAG.findall(prefix)):
        if reduce(xor, text, 0) == int(checksum, 16):
            for field in text.split(b','):
                if field.startswith(b'c:'):
                    return _stamp_ns(field[2:], 'epoch')
    return None


def log_stamp_ns(prefix: bytes, stamp_format: str = 'auto') -> int | None:
    """
    Return the stamp that a logger wrote before a sentence.

    Parameters
    ----------
    prefix : bytes
        The bytes from the start of the line, or from the sentence before, to the sentence. The
        stamp is at the end; only separators and TAG blocks may follow it. Anything may precede it.
    stamp_format : {'auto', 'iso', 'doy', 'epoch', 'tag'}
        'iso': `2014-08-01T00:00:00.183000Z`, also with a blank or a colon for the T, without Z
        (UTC), or with an offset such as `+02:00`. 'doy': `19+085:10:05:54.447`, year with two or
        four digits and day of the year. 'epoch': Unix time in decimal seconds, or in integer
        milli-, micro- or nanoseconds by the number of digits. 'tag': `c:` of a TAG block, seconds
        or milliseconds, if the checksum of the block is correct. 'auto': any of them, a TAG block
        last.

    Returns
    -------
    int or None
        Nanoseconds UTC; None if there is no such stamp.

    Raises
    ------
    ValueError
        If it has the form of a stamp but no such instant exists: month 13, hour 24.

    Examples
    --------
    >>> log_stamp_ns(b'2014-08-01T00:00:00.183000Z ')
    1406851200183000000
    >>> log_stamp_ns(b'19+085:10:05:54.447 ')
    1553594754447000000

    """
    if b'\\' not in prefix:
        return None if stamp_format == 'tag' else _stamp_ns(prefix, stamp_format)
    stamp_ns = None
    if stamp_format != 'tag':
        stamp_ns = _stamp_ns(_TAGS.sub(b'', prefix), stamp_format)
    if stamp_ns is None and stamp_format in ('auto', 'tag'):
        stamp_ns = _tag(prefix)
    return stamp_ns


def day_time_ns(field: bytes) -> int:
    """Return nanoseconds since midnight of `hhmmss.sss`; ValueError if it is not a time."""
    match = _CLOCK.match(field.strip())
    if match is None:
        raise ValueError('time of day')
    return _clock_ns(*match.group(1, 2, 3)) + _fraction_ns(match[4])


def zda_ns(fields: list[bytes]) -> int:
    """
    Return the time of a ZDA sentence.

    Parameters
    ----------
    fields : list of bytes
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
    return (_date_ns(int(fields[4]), int(fields[3]), int(fields[2]))
            + day_time_ns(fields[1]))


def nearest_day_ns(time_of_day_ns: int, near_ns: int) -> int:
    """Return the instant of this time of day that is nearest to `near_ns`, nanoseconds UTC."""
    days = (near_ns - time_of_day_ns + DAY_NS // 2) // DAY_NS
    return days * DAY_NS + time_of_day_ns
