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
Instants at which the clock cuts runs: every few hours, and at times of the day.

The instants depend on nothing but UTC. So they are the same live, in replay and offline, after a
restart, on every ship of a fleet, and however the streams are cut into chunks.
"""

from __future__ import annotations

from bisect import bisect_right
import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    # The settings import this module, and the Tab key needs them without numpy.
    import numpy as np
    from numpy.typing import NDArray


_DAY_NS = 86_400_000_000_000
_HOUR_NS = 3_600_000_000_000
_TIME = re.compile(r'([01][0-9]|2[0-3]):([0-5][0-9])(?::([0-5][0-9]))?', re.ASCII)


def _parse_times(text: str) -> list[int]:
    """Return times of the day in nanoseconds after midnight, ascending."""
    times_ns = []
    for word in text.split(','):
        match = _TIME.fullmatch(word.strip())
        if match is None:
            raise ValueError("must be times of the day such as '00:00,08:00,16:00' (HH:MM or "
                             'HH:MM:SS, in quotes)')
        hours, minutes, seconds = (int(part or 0) for part in match.groups())
        times_ns.append(((hours * 60 + minutes) * 60 + seconds) * 1_000_000_000)
    return sorted(set(times_ns))


class ClockCuts:
    """
    The instants at which the clock cuts; none if both parameters are None.

    Parameters
    ----------
    every_h
        Cut at every multiple of this time since 1970-01-01 00:00 UTC, hours.
    cut_at_utc
        Cut at these times of every day, ``HH:MM`` or ``HH:MM:SS`` with commas between.

    Raises
    ------
    ValueError
        If a time of the day is wrong.

    Examples
    --------
    >>> cuts = ClockCuts(None, '00:00,08:00')
    >>> [ns // 3_600_000_000_000 for ns in (cuts.last(9 * 3_600_000_000_000),
    ...                                     cuts.next(9 * 3_600_000_000_000))]
    [8, 24]
    >>> bool(ClockCuts(None, None))
    False

    """

    def __init__(self, every_h: float | None, cut_at_utc: str | None) -> None:
        #: Period, and instants within it, of each rule.
        self._rules: list[tuple[int, list[int]]] = []
        if every_h is not None:
            self._rules.append((round(every_h * _HOUR_NS), [0]))
        if cut_at_utc is not None:
            self._rules.append((_DAY_NS, _parse_times(cut_at_utc)))

    def __bool__(self) -> bool:
        return bool(self._rules)

    def last(self, stamp_ns: int) -> int:
        """Return the newest cut at or before a stamp; there must be cuts."""
        return max(self._step(rule, stamp_ns, 0) for rule in self._rules)

    def next(self, stamp_ns: int) -> int:
        """Return the first cut after a stamp; there must be cuts."""
        return min(self._step(rule, stamp_ns, 1) for rule in self._rules)

    @staticmethod
    def _step(rule: tuple[int, list[int]], stamp_ns: int, ahead: int) -> int:
        """Return the last cut of a rule up to a stamp, or the one after it."""
        period_ns, instants = rule
        whole, rest_ns = divmod(stamp_ns, period_ns)
        more, at = divmod(bisect_right(instants, rest_ns) - 1 + ahead, len(instants))
        return (whole + more) * period_ns + instants[at]

    def before(self, stamp_ns: int, n: int) -> int:
        """Return the newest cut at or before a stamp, after stepping back n cuts."""
        cut_ns = self.last(stamp_ns)
        for _ in range(n):
            cut_ns = self.last(cut_ns - 1)
        return cut_ns

    def find_crossed(self, stamp_ns: NDArray[np.int64], before_ns: int) -> NDArray[np.int64]:
        """
        Find the stamps that are separated from the stamp before them by a cut.

        Parameters
        ----------
        stamp_ns : ndarray of int64, shape (n,)
            Increasing stamps, n >= 0.
        before_ns
            The stamp before the first of `stamp_ns`.

        Returns
        -------
        ndarray of int64, shape (m,)
            Indices i with a cut t such that stamp i - 1 < t <= stamp i.

        """
        import numpy as np

        if not self._rules:
            return np.empty(0, np.int64)
        crossed = np.zeros(len(stamp_ns), bool)
        for period_ns, instants in self._rules:
            whole, rest_ns = np.divmod(np.concatenate(([before_ns], stamp_ns)), period_ns)
            serial = whole * len(instants) + np.searchsorted(instants, rest_ns, side='right')
            crossed |= np.diff(serial) > 0
        return np.flatnonzero(crossed)
