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

"""Times of GPS whose receiver has missed rollovers of the weeks, and stamps far from any trial."""

from __future__ import annotations

from heading_intercompare.core.utc_text import DAY_NS, utc

from .days import Days
from .times import date_ns, WEEK_NS

ROLLOVER_NS = 1024 * WEEK_NS
"""The weeks of GPS count from 0 again after this time."""

#: The clock of a logger may be in any zone, and a date is that of its first line.
_NEAR_NS = DAY_NS * 3 // 2
#: Earlier stamps count from a start, or are of a simulation.
_LONGEST_COUNT_NS = 366 * DAY_NS


class Rollovers:
    """
    Undoes rollovers of the weeks of GPS that a receiver has missed, if the logger's clock says so.

    That clock is the stamp of the line, or the time of receipt. Without both it is the date given,
    or the date in the name of the file. It says so if a time lies a multiple of 1024 weeks before
    it, to a day and a half. Where it cannot tell, what it said before stays, until the times
    jump.

    Parameters
    ----------
    days
        The date given, or in the name of the file.

    Attributes
    ----------
    words : str
        What was undone, for people; empty if nothing was.

    """

    def __init__(self, days: Days) -> None:
        self._days = days
        self._n = 0
        self._last_ns: int | None = None
        self.words = ''

    def undo(self, ns: int, logger_ns: int | None) -> int:
        """
        Return a time of GPS with the rollovers that its receiver has missed, nanoseconds.

        Parameters
        ----------
        ns
            The time as the receiver tells it.
        logger_ns
            The logger's clock then; None: the date given, or in the name of the file.

        """
        near_ns = self._days.noon_ns if logger_ns is None else logger_ns
        n = 0 if near_ns is None else _count_missed(ns, near_ns)
        if logger_ns is None and not n and self._last_ns is not None and (
                abs(ns - self._last_ns) < ROLLOVER_NS // 2):
            n = self._n
        self._n, self._last_ns = n, ns
        if n and not self.words:
            source = 'date' if logger_ns is None else "logger's clock"
            self.words = (f'the receiver of GPS tells times {1024 * n} weeks early, such as '
                          f'{utc(ns)}: undone by the {source}')
        return ns + n * ROLLOVER_NS

    def is_idle(self, earliest_ns: int, latest_ns: int) -> bool:
        """Tell whether `undo` leaves the times of a span, without a logger's clock."""
        near_ns = self._days.noon_ns
        if near_ns is None or self._n:
            return near_ns is None
        most = (near_ns - earliest_ns + _NEAR_NS) // ROLLOVER_NS
        least = -((latest_ns + _NEAR_NS - near_ns) // ROLLOVER_NS)
        return most < max(1, least)


def _count_missed(ns: int, near_ns: int) -> int:
    """Return how many rollovers put a time near another one; 0 if none do."""
    n = (near_ns - ns + ROLLOVER_NS // 2) // ROLLOVER_NS
    return n if n > 0 and abs(ns + n * ROLLOVER_NS - near_ns) <= _NEAR_NS else 0


def describe_far(first_ns: int, last_ns: int, now_ns: int) -> str:
    """
    Return what is wrong with stamps before 2000 or in the future, and what to do; or nothing.

    Parameters
    ----------
    first_ns, last_ns
        The earliest and the latest stamp.
    now_ns
        The time now, nanoseconds UTC.

    Examples
    --------
    >>> describe_far(10 ** 18, 2 * 10 ** 18, 3 * 10 ** 18)
    ''

    """
    if last_ns > now_ns + DAY_NS:
        far_ns, where = last_ns, 'in the future'
    elif _LONGEST_COUNT_NS < first_ns < date_ns(2000, 1, 1):
        far_ns, where = first_ns, 'before 2000'
    else:
        return ''
    return (f'the stamp {utc(far_ns)} is {where}: the clock that gave it is wrong; take another '
            'one with `time`, or shift the stamps with --set alignment.skew_s')
