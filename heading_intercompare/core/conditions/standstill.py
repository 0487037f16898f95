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

"""Sensors that repeat a value because they are frozen or dead, or the ship does not move."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.statistics.resolution import find_resolution

from .repetition import Windows

FROZEN_S = 5.0
"""A sensor is frozen if it repeats its value for at least this time."""

_EQUAL_DEG = 1e-7
_DECIMAL_DEG = 1e-6
_MOST_DECIMALS = 4
_CHANGES_IN = 100_000
_LEAST_CHANGES = 3
_OFF = 1e-3
_REPEATED = 0.9
_MARGIN_S = 2.0
_PART_S = 1.0
_LOOKED_AT = 1 << 14
_LONGEST_STRETCHES = 256
_DEAD_S = 3600.0
_NEARLY_ALL = 0.9
_STEPS = 2.0
_PLAIN_STEPS, _PLAIN_NORMS = 10.0, 2.0


@dataclass(frozen=True, slots=True)
class Frozen:
    """
    The times when a sensor repeats its value.

    Attributes
    ----------
    longest_s
        Longest time without a change, seconds; 0 for n < 2.
    stretches
        Number of long repetitions while the other sensor turned.
    start_ns
        Start of the repetition during which the other sensor turned most, nanoseconds.
    duration_s, other_moved_deg
        Duration of that repetition, seconds, and turn of the other sensor meanwhile, degrees.
    kind : {'alive', 'frozen', 'dead', 'constant', 'not_testable'}
        'frozen': there are such repetitions. 'dead': one value for an hour from a sensor that
        reports decimals, while the value of the other sensor changed. 'constant': the same for
        nine tenths of a shorter run. 'not_testable': n < 2.
    frozen_s
        Total duration of these repetitions, seconds.
    resolution_deg
        Step in which the sensor reports, degrees: from its changes, otherwise from its decimals.
        None if it shows no step of up to four decimals.
    hold_s
        Usual time from one change to the next, seconds, in the first 16384 readings; None if
        they hold fewer than two changes.
    allowed_deg
        Turn of the other sensor that the repetition at `start_ns` allows a working sensor,
        degrees.

    """

    longest_s: float
    stretches: int = 0
    start_ns: int | None = None
    duration_s: float | None = None
    other_moved_deg: float | None = None
    kind: str = 'alive'
    frozen_s: float = 0.0
    resolution_deg: float | None = None
    hold_s: float | None = None
    allowed_deg: float | None = None

    def is_plain(self, sigma_deg: float) -> bool:
        """
        Tell whether the other sensor moved so far that no working sensor misses it.

        Parameters
        ----------
        sigma_deg
            The larger of the norms of both sensors, degrees.

        Notes
        -----
        That is ten steps of the sensor and two norms. A sound gyro of a moored ship may stick for
        less.

        """
        return self.other_moved_deg is not None and self.other_moved_deg > max(
            _PLAIN_STEPS * (self.resolution_deg or 0.0), _PLAIN_NORMS * sigma_deg)

    @property
    def moved_variance_deg2(self) -> float:
        """Variance of the motion that the sensor missed at most, square degrees."""
        return (self.other_moved_deg or 0.0) ** 2 / 12.0


def find_coarse_resolution(heading_deg: ArrayLike) -> float | None:
    """
    Return the step in which a heading is reported, even if it hardly changes.

    Parameters
    ----------
    heading_deg : array_like, shape (n,)
        Headings in sample order, finite, degrees.

    Returns
    -------
    float or None
        The step of the changes, if there are enough of them and they make up at least a tenth of
        the readings. Otherwise the unit of the last decimal of a thousand readings; values that
        occur only once are ignored if others repeat, because they may be interpolated. Three or
        more changes refine this to the largest common step of all changes. With fewer, a last
        decimal that is always 5 or 0 gives five units. None without readings, or for more than
        four decimals.

    Examples
    --------
    >>> find_coarse_resolution([123.4] * 50), find_coarse_resolution([123.0])
    (0.1, 1.0)

    """
    heading = np.asarray(heading_deg, dtype=np.float64)
    resolution = find_resolution(heading)
    step_deg, repeated = resolution.step_deg, resolution.repeated_share
    if step_deg is not None and repeated is not None and repeated < _REPEATED:
        return step_deg
    levels, often = np.unique(np.round(heading[::max(1, heading.size // 1000)], 7),
                              return_counts=True)
    levels = levels[often > 1] if (often > 1).any() else levels
    for decimals in range(_MOST_DECIMALS + 1):
        scaled = levels * 10.0 ** decimals
        if (np.abs(scaled - np.rint(scaled)) <= _DECIMAL_DEG * 10.0 ** decimals).all():
            return _find_coarsest(heading, levels, 10.0 ** -decimals) if levels.size else None
    return resolution.step_deg


def _find_coarsest(heading: np.ndarray, values: np.ndarray, unit_deg: float) -> float:
    """Return the coarsest step that fits a heading with this unit of the last decimal."""
    changes = np.abs(wrap180(np.diff(heading[:_CHANGES_IN])))
    changes = changes[changes > _EQUAL_DEG] / unit_deg
    if changes.size >= _LEAST_CHANGES and (np.abs(changes - np.rint(changes)) < _OFF).all():
        return unit_deg * int(np.gcd.reduce(np.rint(changes).astype(np.int64)))
    halves = np.rint(values / unit_deg).astype(np.int64) % 5 == 0
    return 5.0 * unit_deg if unit_deg < 1.0 and halves.all() else unit_deg


def find_frozen(stamp_ns: ArrayLike, heading_deg: ArrayLike, other_deg: ArrayLike, *,
                least_s: float = FROZEN_S, moved_deg: float = 0.5,
                sigma_deg: float | None = None, still_frozen: bool = False) -> Frozen:
    """
    Look for times when a sensor repeats its value while the other sensor turns.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps in increasing order, nanoseconds.
    heading_deg, other_deg : array_like, shape (n,)
        Headings of the sensor examined, and of the other sensor, finite, degrees.
    least_s
        Shortest repetition that counts, seconds. A coarse sensor on a steady course repeats
        itself for seconds without a fault.
    moved_deg
        Least range of the other sensor within that time, degrees.
    sigma_deg
        Norm of the standard deviation of the other sensor's errors, degrees; default 0. Bounds
        these errors if the sensor repeats itself for most of the run, so that the rest cannot
        show the errors.
    still_frozen
        Judge only the repetition that goes on at the last reading.

    Returns
    -------
    Frozen

    Notes
    -----
    The test takes the range of the other sensor's means over about a second, within the
    repetition less two seconds and one hold at either end. The margins are needed because a skew,
    or a sensor slower than its messages, repeats values into and out of a turn.

    A working sensor may repeat a value while the ship stays within two of its steps and the other
    sensor rounds by one of its own. The errors of both sensors add twice the range that the
    difference has in nine of ten other windows of that length; normal errors exceed this with a
    probability below 1e-6. Nothing is added if the sensor follows the other one: that is, if in
    nine of ten windows of at least 16 s in which the other moved about as much (half to twice),
    the sensor moved by at least 0.3 of that and by more than those steps. Then a skew makes the
    difference range.

    Windows that overlap a long repetition are left out. If fewer than eight remain, windows of
    half the length, a quarter, and so on down to eight seconds are tried, until eight remain that
    do not overlap. The repetition is then judged by the one window in it in which the other moved
    most, and as a whole with 8 `sigma_deg` more. If there are none, and the repetitions make up
    more than half of the run, the other sensor may range over 8 `sigma_deg` more than two steps,
    and within half a minute scatter by 1.5 `sigma_deg` and one step.

    References
    ----------
    E.18 of ``docs/diagnostics.md``.

    """
    stamps = np.asarray(stamp_ns)
    if stamps.size < 2:
        return Frozen(0.0, kind='not_testable')
    heading = np.asarray(heading_deg, dtype=np.float64)
    partner = np.asarray(other_deg, dtype=np.float64)
    first, last, hold = _stretches(stamps, heading)
    lasted = (stamps[last] - stamps[first]) / 1e9
    longest = float(lasted.max(initial=0.0))
    step = find_coarse_resolution(heading)
    kind = _kind(stamps, longest, step, partner, least_s)
    margin = _MARGIN_S + (hold or 0.0)
    long = np.flatnonzero(lasted >= max(least_s, 2.0 * margin + _PART_S))
    long = long[np.argsort(-lasted[long], kind='stable')][:_LONGEST_STRETCHES]
    alive = Frozen(longest, kind=kind, resolution_deg=step, hold_s=hold)
    if not long.size:
        return alive
    busy = np.zeros(stamps.size, bool)
    for lo, hi in zip(first[long], last[long]):
        busy[lo:hi + 1] = True
    if still_frozen:
        long = long[last[long] == stamps.size - 1]
    windows = Windows(stamps, heading, partner, busy, find_coarse_resolution(partner) or 0.0,
                      sigma_deg)
    grain = max(moved_deg, _STEPS * (step or 0.0))
    frozen = []
    for at in long:
        lo, hi = _cut_margins(stamps, int(first[at]), int(last[at]), margin)
        excess = windows.excess(lo, hi, grain)
        if excess is not None:
            frozen.append((*excess, float(lasted[at]), int(stamps[first[at]])))
    if not frozen:
        return alive
    moved, allowed, duration, start = max(frozen)
    return Frozen(longest_s=longest, stretches=len(frozen), start_ns=start, duration_s=duration,
                  other_moved_deg=moved, kind='dead' if kind == 'dead' else 'frozen',
                  frozen_s=sum(f[2] for f in frozen), resolution_deg=step, hold_s=hold,
                  allowed_deg=allowed)


def _kind(stamps: np.ndarray, longest_s: float, step: float | None, partner: np.ndarray,
          least_s: float) -> str:
    """Return the kind that follows from the longest repetition alone."""
    whole_s = (int(stamps[-1]) - int(stamps[0])) / 1e9
    # A value is held until the next one: n readings last n steps.
    lasted = longest_s + float(np.median(np.diff(stamps[:_LOOKED_AT]))) / 1e9
    is_dead = lasted >= _DEAD_S
    is_constant = longest_s >= max(least_s, _NEARLY_ALL * whole_s)
    if not (is_dead or is_constant) or (step is not None and step >= 1.0) or _is_still(partner):
        return 'alive'
    return 'dead' if is_dead else 'constant'


def _stretches(stamps: np.ndarray,
               heading: np.ndarray) -> tuple[np.ndarray, np.ndarray, float | None]:
    """Return first and last index of every run of equal readings, and the usual hold, s."""
    same = np.empty(heading.size - 1, bool)
    for lo in range(0, same.size, _LOOKED_AT):
        steps = np.diff(heading[lo:lo + _LOOKED_AT + 1])
        np.abs(steps, out=steps)
        part = np.less_equal(steps, _EQUAL_DEG, out=same[lo:lo + _LOOKED_AT])
        if steps.max() >= 360.0 - _EQUAL_DEG:
            part |= steps >= 360.0 - _EQUAL_DEG
    changes = np.flatnonzero(~same[:_LOOKED_AT])
    hold = float(np.median(np.diff(stamps[changes]))) / 1e9 if changes.size > 1 else None
    repeats = np.flatnonzero(same)
    begins = np.diff(repeats, prepend=-2) > 1
    return repeats[begins], repeats[np.append(begins[1:], True)[:begins.size]] + 1, hold


def _cut_margins(stamps: np.ndarray, lo: int, hi: int, margin_s: float) -> tuple[int, int]:
    """Return the half-open index range of a repetition without its margins."""
    margin = round(margin_s * 1e9)
    first, last = np.searchsorted(stamps[lo:hi + 1], [stamps[lo] + margin, stamps[hi] - margin])
    return lo + int(first), lo + max(int(last), int(first)) + 1


def _is_still(heading: np.ndarray) -> bool:
    """Tell whether a heading stays within two of its steps."""
    still = _still_deg(find_coarse_resolution(heading))
    return _range_of(heading, still) <= still


def _still_deg(step: float | None) -> float:
    return _STEPS * (step or 0.0) * 1.01 + _EQUAL_DEG


def _range_of(heading: np.ndarray, enough_deg: float = math.inf) -> float:
    """Return the range of headings on the circle; of a few if that already exceeds enough."""
    for every in (max(1, heading.size // _LOOKED_AT), 1):
        off = wrap180(heading[::every] - heading[0])
        range_deg = float(off.max() - off.min())
        if range_deg > enough_deg:
            break
    return range_deg


@dataclass(frozen=True, slots=True)
class Standstill:
    """
    Whether both sensors hardly change, so that the run does not show that they work.

    Attributes
    ----------
    kind : {'moving', 'still', 'not_testable'}
        'still': both sensors stay within two of their steps for the whole run. 'not_testable':
        n < 2.
    ts_range_deg, rs_range_deg
        Largest minus smallest heading, degrees; of 16384 headings if they suffice to decide.
    ts_step_deg, rs_step_deg
        Steps in which the sensors report, by `find_coarse_resolution`.

    """

    kind: str
    ts_range_deg: float
    rs_range_deg: float
    ts_step_deg: float | None
    rs_step_deg: float | None


def find_standstill(ts_deg: ArrayLike, rs_deg: ArrayLike) -> Standstill:
    """
    Tell whether the motion is too small to show that the sensors work.

    Parameters
    ----------
    ts_deg, rs_deg : array_like, shape (n,)
        Headings of TS and RS, finite, degrees.

    Returns
    -------
    Standstill

    References
    ----------
    E.18 of ``docs/diagnostics.md``.

    Examples
    --------
    >>> find_standstill([10.1, 10.1, 10.2], [10.0, 10.0, 10.0]).kind
    'still'

    """
    ts, rs = (np.asarray(h, dtype=np.float64) for h in (ts_deg, rs_deg))
    if ts.size < 2:
        return Standstill('not_testable', 0.0, 0.0, None, None)
    steps = find_coarse_resolution(ts), find_coarse_resolution(rs)
    limits = tuple(_still_deg(step) for step in steps)
    ranges = _range_of(ts, limits[0]), _range_of(rs, limits[1])
    still = all(r <= limit for r, limit in zip(ranges, limits))
    return Standstill('still' if still else 'moving', *ranges, *steps)
