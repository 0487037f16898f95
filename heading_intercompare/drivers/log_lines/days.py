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

"""The day of a time of day: from a date given, from the stream, or from the name of the file."""

from __future__ import annotations

from datetime import datetime, tzinfo
import os
import re
from typing import Callable

from heading_intercompare.core.utc_text import DAY_NS

from .times import date_ns, nearest_day_ns, SECOND_NS, year_day_ns

#: A clock that goes back by less than this stepped back; otherwise midnight has passed.
_LONGEST_STEP_BACK_NS = 3600 * SECOND_NS

_DATE = re.compile(r'(?<!\d)(20\d\d)[-_.]?(0[1-9]|1[0-2])[-_.]?(0[1-9]|[12]\d|3[01])(?!\d)')
_DAY_OF_YEAR = re.compile(r'(20\d\d)_(\d{3})_\d{5}(?!\d)')


def date_in_name(path: str) -> int | None:
    """
    Return the start of the one day that the name of a file states, nanoseconds; None if none.

    Year, month and day in this order, or year, day counted from 0, and second, as UHDAS names
    its files.

    Examples
    --------
    >>> date_in_name('gyro_2014-08-01.log') == date_in_name('km2014_212_07200.hdg')
    True

    """
    name = os.path.basename(path)
    days = set()
    for match in _DATE.finditer(name):
        try:
            days.add(date_ns(*(int(part) for part in match.groups())))
        except ValueError:
            continue
    for match in _DAY_OF_YEAR.finditer(name):
        try:
            days.add(year_day_ns(int(match[1]), int(match[2]) + 1))
        except ValueError:
            continue
    return days.pop() if len(days) == 1 else None


class Days:
    """
    Puts times of day on the right day.

    The first time of day falls on the date given. Without a date it falls on the date in the name
    of its file, or on the day that puts it nearest to the first time that the stream tells with
    its date. After a time told with its date, a time of day falls nearest to that. Any other later
    one follows the one before it: a clock that goes back by an hour or more has passed midnight.

    Parameters
    ----------
    date
        The date given, YYYY-MM-DD.
    search
        Returns the first time that the stream tells with its date, nanoseconds UTC, or None.
    zone
        The zone of the times of day; UTC unless given.

    Attributes
    ----------
    origin : str
        Where the date came from, in words; empty while none was needed.

    """

    def __init__(self, date: str | None, search: Callable[[], int | None] = lambda: None,
                 zone: tzinfo | None = None) -> None:
        self._given_ns = (None if date is None else
                          date_ns(*(int(part) for part in date.split('-'))))
        self._search, self._zone = search, zone
        self._name_ns: int | None = None
        self._told_ns: int | None = None
        self._last_ns: int | None = None
        self.origin = ''

    def begin_file(self, path: str) -> None:
        """Take note that the next time of day is from another file."""
        self._name_ns = date_in_name(path)
        if self._given_ns is None and self._name_ns is not None:
            self._last_ns = None

    @property
    def noon_ns(self) -> int | None:
        """Return the middle of the date given, or of that in the name of the file."""
        day_ns = self._given_ns if self._given_ns is not None else self._name_ns
        return None if day_ns is None else day_ns + DAY_NS // 2

    def tell(self, ns: int) -> None:
        """Take a time of the stream with its date, nanoseconds UTC."""
        self._told_ns = self._local(ns)

    def place(self, time_of_day_ns: int) -> int | None:
        """Return the instant of a time of day, nanoseconds; None if nothing says its date."""
        last_ns = self._last_ns
        if self._told_ns is not None:
            ns = nearest_day_ns(time_of_day_ns, self._told_ns)
            self._told_ns = None
        elif last_ns is not None:
            step_ns = (time_of_day_ns - last_ns) % DAY_NS
            ns = last_ns + (step_ns if step_ns < DAY_NS - _LONGEST_STEP_BACK_NS
                            else step_ns - DAY_NS)
        else:
            first_ns = self._first(time_of_day_ns)
            if first_ns is None:
                return None
            ns = first_ns
        self._last_ns = ns
        return ns

    def year_start(self) -> int | None:
        """Return the start of the year, nanoseconds; None if nothing says the year."""
        near_ns = self._given_ns if self._given_ns is not None else self._name_ns
        if near_ns is None:
            return None
        self.origin = ('year as given' if self._given_ns is not None else
                       'year by the name of the file')
        year = 1970
        while date_ns(year + 1, 1, 1) <= near_ns:
            year += 1
        return date_ns(year, 1, 1)

    def _first(self, time_of_day_ns: int) -> int | None:
        if self._given_ns is not None:
            self.origin = 'date as given'
            return self._given_ns + time_of_day_ns
        if self._name_ns is not None:
            self.origin = 'date by the name of the file'
            return self._name_ns + time_of_day_ns
        told_ns, self._search = self._search(), lambda: None
        if told_ns is None:
            return None
        self.origin = 'date by ZDA or RMC'
        return nearest_day_ns(time_of_day_ns, self._local(told_ns))

    def _local(self, ns: int) -> int:
        """Return the clock of the zone at an instant."""
        if self._zone is None:
            return ns
        shift = datetime.fromtimestamp(ns // SECOND_NS, self._zone).utcoffset()
        return ns + (0 if shift is None else int(shift.total_seconds()) * SECOND_NS)
