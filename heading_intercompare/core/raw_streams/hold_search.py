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

"""The search of a stream for values that a logger repeats, from the changes of value alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from heading_intercompare.core.records import Headings, Integers, Reals

_TURN = 360_000_000
_WINDOW, _PERIODS = 32, 64
"""Times between large changes, and distances between changes, that are looked at together."""
_LARGE_2 = 3
_MOST_SINGLES = 4
_ODD = 2
_LEAST_MEAN_10, _MOST_CV2, _LEAST_SIZE_CV2, _MORE = 17, 0.36, 0.16, 1.7
_BREAK_NS, _LONGEST_NS, _BEGIN_NS = 15 * 10**9, 300 * 10**9, 120 * 10**9
_FIRST_NS, _POLL_NS = 3 * 10**9, 3 * 10**9
_PRIMES = np.array([2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59])
_LONGEST_PERIOD = 60
_KEPT = 4 * (_WINDOW + _PERIODS)


def find_period(distances: np.ndarray) -> int:
    """
    Return the number of readings of which nearly all distances are multiples.

    Parameters
    ----------
    distances : ndarray of int64, shape (n,)
        Readings from each change of value to the next.

    Returns
    -------
    int
        The largest number from 2 to 60 that divides 97 % of the distances; 1 if there is none.

    Examples
    --------
    >>> find_period(np.array([4, 8, 4, 12])), find_period(np.array([4, 5, 4, 5]))
    (4, 1)

    """
    periods = np.arange(2, _LONGEST_PERIOD + 1)
    odd = np.count_nonzero(distances[:, None] % periods, axis=0)
    fitting = periods[33 * odd <= len(distances)]
    return int(fitting[-1]) if len(fitting) else 1


@dataclass(frozen=True, slots=True)
class Held:
    """
    What the search knows of some readings.

    Attributes
    ----------
    is_held : ndarray of bool, shape (n,)
        A hold covers the reading, as far as is known.
    is_open : ndarray of bool, shape (n,)
        Later readings may still show that a hold covers the reading.
    period : ndarray of int64, shape (n,)
        Readings for which each value stands; 0 where that number is not constant, or no hold.
    usual : ndarray, shape (n,)
        Their usual number, constant or not.
    longest : ndarray of int64, shape (n,)
        A value that stands for more readings was reported again.
    poll_ns : ndarray, shape (n,)
        Usual time from one reading to the next there, nanoseconds.
    until_row : ndarray of int64, shape (n,)
        Number of the reading that showed a hold which covers earlier readings; 0 for none.

    """

    is_held: np.ndarray
    is_open: np.ndarray
    period: Integers
    usual: Reals
    longest: Integers
    poll_ns: Reals
    until_row: Integers

    def __getitem__(self, which: slice) -> 'Held':
        """Return what is known of some of the readings."""
        return Held(*(getattr(self, name)[which] for name in Held.__slots__))


@dataclass(slots=True)
class _Changes:
    """Changes of value: where, when, by how much, and whether by more than a step."""

    row: Integers
    stamp_ns: Integers
    size: Integers
    is_large: np.ndarray
    #: Distances of one reading so far.
    singles: Integers
    #: The constant period that the distances up to the change show; 1 if none.
    period: Integers


@dataclass(slots=True)
class _Times:
    """Times between two neighbouring large changes, in readings."""

    first_row: Integers
    end_row: Integers
    first_ns: Integers
    end_ns: Integers
    size: Integers
    #: Distances of one reading between any changes so far, at both ends.
    first_singles: Integers
    end_singles: Integers
    #: No hold spans what lies between the time before and this time.
    is_apart: np.ndarray
    #: Nothing was between the start of the stream and this time.
    begins: np.ndarray
    #: The window that ends with the time shows a hold; one shown earlier still lasts.
    passes: np.ndarray
    lasts: np.ndarray
    period: Integers
    usual: Reals
    longest: Integers


class HoldSearch:
    """
    Find the parts of a stream in which each value stands for several readings.

    Notes
    -----
    A change is large if it exceeds one and a half times the smallest change so far, the step of
    the sensor. Two rules find a hold.

    *Wandering*: a window holds the times, in readings, between 32 pairs of neighbouring large
    changes. In it, at most 4 changes of any size come one reading after another. The mean of the
    times is at least 1.7, and they scatter
    by at most 0.6 of their mean. The changes scatter in size by at least 0.4 of their mean, and
    relatively more than the times: a hold has even times and uneven sizes, a sticky sensor has
    the reverse. All readings of the window are held, and those after it until more than 4 changes
    in the newest 32 times come one reading after another, or until 15 s pass without such a time.

    *Constant*: one number from 2 to 60 divides at least 62 of the last 64 distances between any
    changes. This holds from the change on that shows it, until 64 distances contradict it. If the
    first two minutes of a stream show it, without 15 s between changes, it holds from their start.

    A reading is open as long as a window that covers it may still pass. A window cannot pass with
    more than 4 such changes, with 15 s between two of its times, or in more than 5 minutes.
    The first value of a stream is open for 3 s. A value that is the same after more than 3 s
    without a reading is a new one: no logger polls so slowly.

    References
    ----------
    E.26 of ``docs/diagnostics.md``.

    """

    def __init__(self) -> None:
        none, no = np.empty(0, np.int64), np.empty(0, bool)
        self._changes = _Changes(none, none, none, no, none, none)
        self._times = _Times(*(none,) * 7, *(no,) * 4, none, np.empty(0), none)
        self._rows = self._newest_ns = 0
        self._value: int | None = None
        self._step = _TURN
        # The period that the first distances show, and the reading that showed it: 1 is none.
        self._first_period = self._shown_row = 0
        # The first reading of which it counts that it repeats a value, and its stamp.
        self._begin_row = self._begin_ns = 0
        self._has_changed = False

    def take(self, headings: Headings) -> np.ndarray:
        """Take readings with increasing stamps, n >= 1; return which ones repeat a value."""
        stamps = headings.stamp_ns
        value = np.rint(headings.heading_deg * 1e6).astype(np.int64)
        if value.min() < 0 or value.max() >= _TURN:
            value %= _TURN
        if self._value is None:
            self._value, self._newest_ns = int(value[0]), int(stamps[0])
            self._begin_ns = self._newest_ns
        size = np.abs(np.diff(value, prepend=self._value))
        size = np.minimum(size, _TURN - size)
        is_near = np.diff(stamps, prepend=self._newest_ns) <= _POLL_NS
        repeats: np.ndarray = (size == 0) & is_near
        at = np.flatnonzero(~repeats)
        self._value, self._newest_ns = int(value[-1]), int(stamps[-1])
        if len(at):
            if not self._has_changed and stamps[at[0]] - self._begin_ns > _FIRST_NS:
                # The first value of all lasted so long that it shows nothing.
                self._begin_row, self._begin_ns = self._rows + int(at[0]), int(stamps[at[0]])
            self._has_changed = True
            self._take_changes(self._rows + at, stamps[at], size[at])
        self._rows += len(stamps)
        if self._rows == len(stamps):
            repeats[0] = False
        return repeats

    @property
    def shows_hold(self) -> bool:
        """Whether a hold may cover readings that repeat no value."""
        times = self._times
        return bool(self._first_period != 1 or times.lasts.any() or times.passes.any()
                    or (self._changes.period > 1).any())

    def judge(self, row: Integers, stamp_ns: Integers) -> Held:
        """Return what is known of consecutive readings, n >= 1, by number and stamp."""
        n = len(row)
        held = Held(is_held=np.zeros(n, bool), is_open=np.zeros(n, bool),
                    period=np.zeros(n, np.int64), usual=np.ones(n), longest=np.ones(n, np.int64),
                    poll_ns=np.ones(n), until_row=np.zeros(n, np.int64))
        self._judge_wandering(row, stamp_ns, held)
        self._judge_constant(row, held)
        shows_nothing = not self._has_changed and self._newest_ns - self._begin_ns > _FIRST_NS
        held.is_open[(row < self._begin_row) | shows_nothing] = False
        return held

    def forget(self, row: int) -> None:
        """Forget what the readings from this number on do not need."""
        times, changes = self._times, self._changes
        n = int(np.searchsorted(times.end_row, row, side='right')) - 2 * _WINDOW
        if n > _KEPT:
            self._times = _Times(*(getattr(times, name)[n:] for name in _Times.__slots__))
        n = int(np.searchsorted(changes.row, row, side='right')) - 2 * _PERIODS
        if n > _KEPT:
            self._changes = _Changes(*(getattr(changes, name)[n:]
                                       for name in _Changes.__slots__))

    def _take_changes(self, row: Integers, stamp_ns: Integers, size: Integers) -> None:
        """Add changes; of many that come one reading after another only the first and the last."""
        n = len(row)
        if n <= 4 * _KEPT or row[-1] - row[0] != n - 1:
            self._add_changes(row, stamp_ns, size)
            return
        self._add_changes(row[:_KEPT], stamp_ns[:_KEPT], size[:_KEPT])
        first = _KEPT
        if not self.shows_hold and len(self._times.end_ns):
            # No window with any of those between may pass, nor show a period.
            first = n - _KEPT
            self._skip_changes(row[:first], stamp_ns[:first], size[:first])
        self._add_changes(row[first:], stamp_ns[first:], size[first:])

    def _skip_changes(self, row: Integers, stamp_ns: Integers, size: Integers) -> None:
        """Keep only the last of changes that come one reading after another and show nothing."""
        self._step = min(self._step, int(np.min(size[size > 0], initial=_TURN)))
        singles = self._changes.singles[-1] + row[-1] - self._changes.row[-1]
        self._changes = _Changes(row[-1:], stamp_ns[-1:], size[-1:],
                                 2 * size[-1:] >= _LARGE_2 * self._step,
                                 np.array([singles]), np.ones(1, np.int64))

    def _add_changes(self, row: Integers, stamp_ns: Integers, size: Integers) -> None:
        # A value that came again after a pause has changed by nothing.
        step = np.minimum(np.minimum.accumulate(np.where(size > 0, size, _TURN)), self._step)
        self._step = int(step[-1])
        old, n = self._changes, len(row)
        n_old = len(old.row)
        now = self._changes = _Changes(
            np.concatenate((old.row, row)), np.concatenate((old.stamp_ns, stamp_ns)),
            np.concatenate((old.size, size)),
            np.concatenate((old.is_large, 2 * size >= _LARGE_2 * step)),
            np.concatenate((old.singles, self._count_singles(row))),
            np.concatenate((old.period, np.ones(n, np.int64))))
        at = np.arange(max(1, n_old), n_old + n)
        at = at[now.is_large[at - 1] & now.is_large[at]]
        at = at[now.stamp_ns[at] - now.stamp_ns[at - 1] <= _BREAK_NS]
        if len(at):
            self._add_times(at)
        self._find_periods(n_old)

    def _count_singles(self, row: Integers) -> Integers:
        """Return the number of distances of one reading up to each of new changes."""
        changes = self._changes
        last, before = row[0] - 2, 0
        if len(changes.row):
            last, before = changes.row[-1], changes.singles[-1]
        singles: Integers = before + np.cumsum(np.diff(row, prepend=last) == 1)
        return singles

    def _add_times(self, at: Integers) -> None:
        now, old, n = self._changes, self._times, len(at)
        n_old = len(old.end_ns)
        first_ns, end_ns = now.stamp_ns[at - 1], now.stamp_ns[at]
        last_ns = np.concatenate((old.end_ns[-1:] if n_old else [self._begin_ns], end_ns[:-1]))
        is_apart = first_ns - last_ns > _BREAK_NS
        begins = np.zeros(n, bool)
        begins[0] = not n_old and not is_apart[0]
        self._times = _Times(
            first_row=np.concatenate((old.first_row, now.row[at - 1])),
            end_row=np.concatenate((old.end_row, now.row[at])),
            first_ns=np.concatenate((old.first_ns, first_ns)),
            end_ns=np.concatenate((old.end_ns, end_ns)),
            size=np.concatenate((old.size, now.size[at])),
            first_singles=np.concatenate((old.first_singles, now.singles[at - 1])),
            end_singles=np.concatenate((old.end_singles, now.singles[at])),
            is_apart=np.concatenate((old.is_apart, is_apart)),
            begins=np.concatenate((old.begins, begins)),
            passes=np.concatenate((old.passes, np.zeros(n, bool))),
            lasts=np.concatenate((old.lasts, np.zeros(n, bool))),
            period=np.concatenate((old.period, np.zeros(n, np.int64))),
            usual=np.concatenate((old.usual, np.ones(n))),
            longest=np.concatenate((old.longest, np.ones(n, np.int64))))
        self._test(n_old)

    def _test(self, first_new: int) -> None:
        """Test the windows that end with the times from `first_new` on."""
        now = self._times
        ends = np.arange(max(first_new, _WINDOW - 1), len(now.end_ns))
        singles = now.end_singles[ends] - now.first_singles[ends - _WINDOW + 1]
        if not len(ends) or singles.min() > _MOST_SINGLES:
            # No window may pass, so none lasts.
            return
        lo = int(ends[0]) - _WINDOW + 1
        length, size = now.end_row[lo:] - now.first_row[lo:], now.size[lo:]

        def windows(column: np.ndarray) -> np.ndarray:
            # Wraps around without harm: the differences are small.
            sums = np.concatenate(([0], np.cumsum(column)))
            return sums[_WINDOW:] - sums[:-_WINDOW]

        total = windows(length)
        apart = windows(now.is_apart[lo:].astype(np.int64)) - now.is_apart[lo:][:len(ends)]
        span_ns = now.end_ns[ends] - now.first_ns[ends - _WINDOW + 1]
        mean, mean_size = total / _WINDOW, windows(size) / _WINDOW
        cv2 = windows(length ** 2) / _WINDOW / mean ** 2 - 1.0
        size_cv2 = windows(size ** 2) / _WINDOW / mean_size ** 2 - 1.0
        may_pass = (singles <= _MOST_SINGLES) & (apart == 0)
        passes = (may_pass & (10 * total >= _LEAST_MEAN_10 * _WINDOW) & (cv2 <= _MOST_CV2)
                  & (size_cv2 >= np.maximum(_LEAST_SIZE_CV2, _MORE * cv2))
                  & (span_ns <= _LONGEST_NS))
        now.passes[ends] = passes
        count = np.arange(1, len(ends) + 1)
        shown = np.maximum.accumulate(np.where(passes, count, 0))
        ended = np.maximum.accumulate(np.where(may_pass, 0, count))
        before = bool(ends[0]) and bool(now.lasts[ends[0] - 1])
        now.lasts[ends] = (shown > ended) | ((ended == 0) & before)
        for end in ends[now.lasts[ends]].tolist():
            of = slice(end - _WINDOW + 1, end + 1)
            lengths = now.end_row[of] - now.first_row[of]
            period = find_period(lengths)
            median = np.median(lengths)
            now.period[end] = period if period > 1 else 0
            usual = lengths[2 * lengths <= 3 * median].mean()
            now.usual[end], now.longest[end] = (period, period) if period > 1 else (
                usual, max(lengths[lengths <= 2 * median].max(), np.ceil(1.5 * usual)))

    def _judge_wandering(self, row: Integers, stamp_ns: Integers, held: Held) -> None:
        times, changes = self._times, self._changes
        n = len(times.end_ns)
        is_under_way = bool(len(changes.row) and changes.is_large[-1] and (
            self._newest_ns - int(changes.stamp_ns[-1]) <= _BREAK_NS))
        if not n:
            is_open = self._newest_ns - self._begin_ns <= _BREAK_NS
            if is_under_way:
                is_open |= int(changes.stamp_ns[-1]) - self._begin_ns <= _BREAK_NS
                held.is_open[:] = row >= changes.row[-1]
            held.is_open[:] |= is_open
            return
        last = np.searchsorted(times.end_row, row, side='right') - 1
        at = np.maximum(last, 0)
        sticks = (last >= 0) & times.lasts[at] & (stamp_ns - times.end_ns[at] <= _BREAK_NS)
        passing = _WINDOW - 1 + np.flatnonzero(times.passes[_WINDOW - 1:])
        window = np.where(sticks, at, 0)
        if len(passing):
            first = passing - _WINDOW + 1
            begin = np.maximum(self._begin_row, np.where(
                times.begins[first], 0, times.first_row[first]))
            change = np.zeros(len(row) + 1, np.int64)
            np.add.at(change, np.searchsorted(row, begin), 1)
            np.add.at(change, np.searchsorted(row, times.end_row[passing]), -1)
            covered = np.cumsum(change[:-1]) > 0
            later = np.minimum(np.searchsorted(times.end_row[passing], row, side='right'),
                               len(passing) - 1)
            window = np.where(sticks, at, np.where(covered, passing[later], 0))
            early = covered & ~sticks
            held.until_row[early] = times.end_row[window[early]]
            held.is_held[:] = covered | sticks
        which = held.is_held
        of = window[which]
        held.period[which] = times.period[of]
        held.usual[which] = times.usual[of]
        held.longest[which] = times.longest[of]
        first = np.maximum(of - _WINDOW + 1, 0)
        held.poll_ns[which] = (times.end_ns[of] - times.first_ns[first]) / (
            times.end_row[of] - times.first_row[first])
        self._find_open(row, last, is_under_way, held.is_open)

    def _find_open(self, row: Integers, last: np.ndarray, is_under_way: bool,
                   is_open: np.ndarray) -> None:
        """Find the readings that a window still to come may cover; `last` is the time before."""
        times, changes = self._times, self._changes
        n = len(times.end_ns)
        apart = np.concatenate(([0], np.cumsum(times.is_apart)))
        is_broken = self._newest_ns - int(times.end_ns[-1]) > _BREAK_NS and not (
            is_under_way and int(changes.stamp_ns[-1]) - int(times.end_ns[-1]) <= _BREAK_NS)
        s = np.arange(n)
        may_pass = ((s + _WINDOW > n)
                    & (changes.singles[-1] - times.first_singles <= _MOST_SINGLES)
                    & (apart[n] == apart[s + 1])
                    & (self._newest_ns - times.first_ns <= _LONGEST_NS))
        if is_broken:
            may_pass[:] = False
        may_pass = np.append(may_pass, is_under_way)
        begin = np.append(times.first_row, changes.row[-1] if is_under_way else self._rows)
        following = last + 1
        inside = begin[following] <= row
        at = np.where(inside, following, last)
        # Before the first time of a stream, the window that begins with it.
        if times.begins[0]:
            at = np.maximum(at, 0)
        is_open[:] = (at >= 0) & may_pass[np.maximum(at, 0)]

    def _find_periods(self, first_new: int) -> None:
        """Find the constant period for the changes from `first_new` on."""
        now = self._changes
        ends = np.arange(max(first_new, _PERIODS), len(now.row))
        # A distance of one reading is no multiple of any period.
        ends = ends[now.singles[ends] - now.singles[ends - _PERIODS] <= _ODD]
        if len(ends):
            lo, first_end = int(ends[0]) - _PERIODS, int(ends[0])
            distances = np.diff(now.row[lo:int(ends[-1]) + 1])
            odd = (distances[:, None] % _PRIMES != 0).astype(np.int64)
            sums = np.concatenate((np.zeros((1, len(_PRIMES)), np.int64), np.cumsum(odd, axis=0)))
            least = (sums[_PERIODS:] - sums[:-_PERIODS]).min(axis=1)
            for end in ends[least[ends - first_end] <= _ODD].tolist():
                now.period[end] = self._find_period(end)
        if not self._first_period:
            self._decide_first()

    def _find_period(self, end: int) -> int:
        distances = np.diff(self._changes.row[end - _PERIODS:end + 1])
        last = int(self._changes.period[end - 1])
        if last > 1 and np.count_nonzero(distances % last) <= _ODD:
            return last
        return find_period(distances)

    def _decide_first(self) -> None:
        """Decide whether the start of the stream shows a constant period, if that is possible."""
        now = self._changes
        distances = np.diff(now.row[:_PERIODS + 1])
        stamp_ns = now.stamp_ns[:_PERIODS + 1]
        odd = np.count_nonzero(distances[:, None] % _PRIMES, axis=0)
        if odd.min(initial=len(distances)) > _ODD or stamp_ns[-1] - stamp_ns[0] > _BEGIN_NS or (
                np.diff(stamp_ns).max(initial=0) > _BREAK_NS):
            self._first_period = 1
        elif len(now.row) > _PERIODS:
            self._first_period = int(now.period[_PERIODS])
            self._shown_row = int(now.row[_PERIODS])

    def _judge_constant(self, row: Integers, held: Held) -> None:
        changes = self._changes
        if not self._first_period and len(changes.row) and (
                self._newest_ns - int(changes.stamp_ns[-1]) > _BREAK_NS
                or self._newest_ns - self._begin_ns > _BEGIN_NS):
            self._first_period = 1
        if not self._first_period:
            held.is_open[:] = True
        period = np.ones(len(row), np.int64)
        if len(changes.row):
            at = np.searchsorted(changes.row, row, side='right') - 1
            period = np.where(at >= 0, changes.period[np.maximum(at, 0)], 1)
        causal = period > 1
        held.until_row[causal] = 0
        if self._first_period > 1:
            early = ((row >= self._begin_row) & (row < self._shown_row)
                     & ~held.is_held & ~causal)
            period[early] = self._first_period
            held.until_row[early] = self._shown_row
        which = period > 1
        held.is_held[which] = True
        held.period[which] = period[which]
        held.usual[which] = period[which]
        held.longest[which] = period[which]
