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
What the stamps of the first minute tell: the usual steps, and the sensor to interpolate.

Halfway between two readings h apart, linear interpolation misses the curvature of the heading:
about (pi h / T)^2 / 2 of the amplitude of a yaw of period T. So the sensor to interpolate is the
one that reports often.
"""

from __future__ import annotations

from bisect import insort

import numpy as np

from heading_intercompare.core.settings import Pairing

_RATIO = (3, 2)
"""An RS is slower if its step exceeds that of the TS by this factor, numerator and denominator."""

#: A faster RS is never slow, seconds.
_SLOW_RS_S = 0.25

_USUAL = 0.6
#: Where the usual steps cover less of the time than this, one part in, they are those in bursts.
_COVERED = 10
#: The least number of steps for which a slow sensor is watched.
_LEAST_STEPS = 4
#: More steps tell nothing new, and live the first pairs wait for them.
_MOST_STEPS = 64


def typical_step_ns(stamp_ns: np.ndarray) -> int | None:
    """
    Return the typical step: half of the time passes in steps of at most this length.

    Parameters
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        Increasing stamps, nanoseconds.

    Returns
    -------
    int or None
        Nanoseconds; None for fewer than 2 stamps.

    Notes
    -----
    Steps weigh by their length. For readings in bursts, the result is the pause between bursts.
    A silence shorter than half of the time does not count.

    Examples
    --------
    >>> typical_step_ns(np.array([0, 1, 2, 100, 101, 102, 200]))
    98

    """
    if len(stamp_ns) < 2:
        return None
    steps = np.sort(np.diff(stamp_ns))
    bridged = np.cumsum(steps)
    return int(steps[np.searchsorted(2 * bridged, bridged[-1])])


def usual_step_ns(stamp_ns: np.ndarray) -> int | None:
    """
    Return the usual step of a sensor: its own step, even if a third of its readings is missing.

    Parameters
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        Increasing stamps, nanoseconds.

    Returns
    -------
    int or None
        Nanoseconds; None for fewer than 2 stamps.

    Notes
    -----
    The lower quantile 0.6 of the steps. If steps of that length cover less than a tenth of the
    time, the readings come in bursts, and the result is the typical step.

    Examples
    --------
    >>> usual_step_ns(np.array([0, 10, 20, 40, 50, 60, 80]))
    10

    """
    if len(stamp_ns) < 2:
        return None
    steps = np.diff(stamp_ns)
    usual = int(np.quantile(steps, _USUAL, method='lower'))
    if _COVERED * int(steps[2 * steps <= 3 * usual].sum()) < int(steps.sum()):
        return typical_step_ns(stamp_ns)
    return usual


class UsualSteps:
    """
    The usual step of one sensor in each stretch of its stream.

    A stretch starts with the first reading, with the first one after a silence, and where a logger
    begins or ceases to hold values. Its step is that of its first minute, of its first 64 steps
    if they are over sooner, or of its first four steps if they last longer. So it depends on the
    stream alone, however it is cut into chunks.

    Parameters
    ----------
    silence_ns
        A longer step is a silence, nanoseconds.
    watched_ns
        How long a stretch is watched, nanoseconds.

    Notes
    -----
    A step of 0 is that of a stretch of one reading.

    """

    def __init__(self, silence_ns: int, watched_ns: int) -> None:
        self._silence_ns, self._watched_ns = silence_ns, watched_ns
        self._starts: list[int] = []
        self._steps: list[int | None] = []
        self._watched = np.empty(0, np.int64)

    def note(self, stamp_ns: np.ndarray,
             turned_ns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """
        Take the stamps of new readings, n >= 1, and those at which a hold begins or has ended.

        Returns
        -------
        stamp_ns, n : ndarray of int64, shape (m,)
            Readings after a gap, and how many usual steps without a reading the gap has; as far
            as the usual steps are now known.

        """
        stamps = np.concatenate((self._watched, stamp_ns))
        is_silence = np.diff(stamps) > self._silence_ns
        begins = np.flatnonzero(is_silence | np.isin(stamps[1:], turned_ns)) + 1
        if not self._starts:
            self._begin(int(stamps[0]))
        gaps = []
        for lo, hi in zip([0, *begins], [*begins, len(stamps)]):
            part = stamps[lo:hi]
            if lo:
                if is_silence[lo - 1] and (usual := self._steps[-1]):
                    # A silence lies in its middle, between the runs that it parts.
                    silence_ns = int(part[0] - stamps[lo - 1])
                    gaps.append((part[:1] - silence_ns // 2,
                                 np.array([(silence_ns + usual // 2) // usual - 1])))
                self._begin(int(part[0]))
            is_over = hi < len(stamps)
            if self._steps[-1] is None:
                self._decide(part, is_over)
            gaps.append(self._find_gaps(part))
            self._watched = part if self._steps[-1] is None else part[-1:]
        stamps, n = (np.concatenate(column) for column in zip(*gaps))
        return stamps, n

    def end(self) -> tuple[np.ndarray, np.ndarray]:
        """End the stream; return the gaps that are known only now."""
        if self._steps and self._steps[-1] is None:
            self._decide(self._watched, True)
            return self._find_gaps(self._watched)
        return np.empty(0, np.int64), np.empty(0, np.int64)

    def _begin(self, stamp_ns: int) -> None:
        self._starts.append(stamp_ns)
        self._steps.append(None)

    def _decide(self, stamps: np.ndarray, is_over: bool) -> None:
        until = int(np.searchsorted(stamps, self._starts[-1] + self._watched_ns, side='right'))
        until = min(max(until, _LEAST_STEPS + 1), _MOST_STEPS + 1)
        if is_over or len(stamps) > until:
            self._steps[-1] = usual_step_ns(stamps[:until]) or 0

    def _find_gaps(self, stamps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        usual = self._steps[-1]
        if not usual:
            return np.empty(0, np.int64), np.empty(0, np.int64)
        steps = np.diff(stamps)
        long = 2 * steps > 3 * usual
        return stamps[1:][long], (steps[long] + usual // 2) // usual - 1

    @property
    def newest_ns(self) -> int:
        """Return the newest usual step, nanoseconds; 0 if unknown."""
        return next((step for step in reversed(self._steps) if step is not None), 0)

    def stretches(self, from_ns: int) -> list[tuple[int, int | None]]:
        """Return start and usual step, None if unknown, of the stretches of a time and after."""
        first = max(0, int(np.searchsorted(self._starts, from_ns, side='right')) - 1)
        return [*zip(self._starts[first:], self._steps[first:])]

    def forget(self, before_ns: int) -> None:
        """Forget the stretches that end before a stamp."""
        n = max(0, int(np.searchsorted(self._starts, before_ns, side='right')) - 1)
        del self._starts[:n], self._steps[:n]


def is_slower(ts_step_ns: int | None, rs_step_ns: int | None, slow_ns: int) -> bool | None:
    """
    Tell whether the RS is the slower sensor, and slow enough for that to matter.

    Parameters
    ----------
    ts_step_ns, rs_step_ns
        Typical steps of both over the same time, nanoseconds.
    slow_ns
        Longest typical step of an RS that is not slow, nanoseconds.

    Returns
    -------
    bool or None
        None if one of the sensors has no step.

    Examples
    --------
    >>> is_slower(2, 10, 5), is_slower(2, 3, 1), is_slower(2, 4, 5)
    (True, False, False)

    """
    if ts_step_ns is None or rs_step_ns is None:
        return None
    more, than = _RATIO
    return rs_step_ns > slow_ns and than * rs_step_ns > more * ts_step_ns


class Direction:
    """
    Choose for each stretch of the two streams whether the TS is interpolated.

    A stretch starts with the first reading of a sensor, and with the first one after a silence of
    that sensor that no pair can bridge: the longer of `runs.gap_s` and `pairing.max_gap_s`. A run
    ends there, too. A stretch also starts where a logger begins or ceases to hold values. Both
    sensors are watched for the first `pairing.auto_s` of a stretch. If one of them has fewer than
    2 readings by then, the stretch takes the choice of the next one; the last stretch takes that
    of the stretch before.

    Parameters
    ----------
    rule
        `max_gap_s` and `auto_s` are used.
    gap_ns
        `runs.gap_s`, nanoseconds.

    Attributes
    ----------
    interpolates_ts
        Whether the TS is interpolated to the stamps of the RS in the current stretch; None until
        that is chosen.
    start_ns
        Start of the current stretch, or of the first one that shares its choice; None until that
        is chosen.

    """

    def __init__(self, rule: Pairing, gap_ns: int) -> None:
        self.interpolates_ts: bool | None = None
        self.start_ns: int | None = None
        self._before: bool | None = False
        self._silence_ns = max(gap_ns, round(rule.longest_gap_s * 1e9))
        self._watched_ns = round(rule.auto_s * 1e9)
        self._slow_ns = round(_SLOW_RS_S * 1e9)
        self._starts: list[int] = []
        self._last_ns: dict[str, int] = {}
        self._stamp_ns = {'ts': np.empty(0, np.int64), 'rs': np.empty(0, np.int64)}

    def note(self, sensor: str, stamp_ns: np.ndarray, turned_ns: np.ndarray) -> None:
        """Take the stamps of new readings, n >= 1, and those where a hold begins or ends."""
        last_ns = self._last_ns.get(sensor)
        steps = np.diff(stamp_ns, prepend=stamp_ns[0] if last_ns is None else last_ns)
        begins = steps > self._silence_ns
        begins[0] |= last_ns is None
        if len(turned_ns):
            begins |= np.isin(stamp_ns, turned_ns)
        for start_ns in stamp_ns[begins].tolist():
            if start_ns not in self._starts:
                insort(self._starts, start_ns)
        self._last_ns[sensor] = int(stamp_ns[-1])
        self._stamp_ns[sensor] = np.concatenate((self._stamp_ns[sensor], stamp_ns))
        if len(self._last_ns) > 1:
            oldest = min(*self._starts[:1], *self._last_ns.values())
            for name, stamps in self._stamp_ns.items():
                self._stamp_ns[name] = stamps[np.searchsorted(stamps, oldest):]

    def forget(self) -> None:
        """Drop the stamps of expired readings, except those that a choice can depend on."""
        newest = max(self._last_ns.values()) - self._watched_ns
        first = self._starts[0] + self._watched_ns if self._starts else newest
        for name, stamps in self._stamp_ns.items():
            self._stamp_ns[name] = stamps[(stamps < first) | (stamps >= newest)]

    @property
    def limit_ns(self) -> int | None:
        """Start of the next stretch; None if unknown."""
        at = 1 if self.interpolates_ts is None else 0
        return self._starts[at] if len(self._starts) > at else None

    def has_heard(self, stamp_ns: int) -> bool:
        """Tell whether both sensors have reported up to a stamp."""
        return len(self._last_ns) > 1 and min(self._last_ns.values()) >= stamp_ns

    def choose(self, end: bool) -> bool:
        """
        Choose for the current stretch, if that is still open and possible.

        Parameters
        ----------
        end
            True if no more readings will come.

        Returns
        -------
        bool
            Whether the choice is made.

        """
        while self.interpolates_ts is None and self._starts:
            start_ns, limit_ns = self._starts[0], self.limit_ns
            until_ns = start_ns + self._watched_ns
            if limit_ns is not None:
                until_ns = min(until_ns, limit_ns)
            if not end and not self.has_heard(until_ns):
                return False
            ts_step_ns, rs_step_ns = (
                typical_step_ns(s[slice(*np.searchsorted(s, (start_ns, until_ns)))])
                for s in (self._stamp_ns['ts'], self._stamp_ns['rs']))
            choice = is_slower(ts_step_ns, rs_step_ns, self._slow_ns)
            self._starts.pop(0)
            self.start_ns = start_ns if self.start_ns is None else self.start_ns
            if choice is None and limit_ns is None:
                choice = self._before
            self.interpolates_ts = choice
        return self.interpolates_ts is not None

    def leave(self) -> None:
        """Move on to the next stretch."""
        self._before = self.interpolates_ts
        self.interpolates_ts = self.start_ns = None
