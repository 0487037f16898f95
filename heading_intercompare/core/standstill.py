# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Sensors that repeat a value: frozen, dead, or of a ship that does not move."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike

from .angles import unwrap_deg, wrap180
from .resolution import resolution

__all__ = ['Frozen', 'frozen', 'resolution_of', 'standstill', 'Standstill']

_EQUAL_DEG = 1e-7
_DECIMAL_DEG = 1e-6
_MOST_DECIMALS = 4
_REPEATED = 0.9
_MARGIN_S = 2.0
_PART_S = 1.0
_MOST_PARTS = 512
_LOOKED_AT = 1 << 14
_WINDOWS = 64
_LEAST_WINDOWS = 8
_LEAST_READINGS = 4
_FOLLOWS = 0.3
_FOLLOWS_S = 16.0
_SPAN_SHARE = 0.9
_LONGEST_STRETCHES = 256
_DEAD_S = 3600.0
_STEPS = 2.0


@dataclass(frozen=True, slots=True)
class Frozen:
    """
    Values that a sensor repeats.

    Attributes
    ----------
    longest_s : float
        Longest time without a change, seconds; 0 for n < 2.
    stretches : int
        Times it repeated its value for long while the other sensor turned.
    start_ns : int or None
        Stamp of the one of these during which the other turned most, nanoseconds.
    duration_s, other_moved_deg : float or None
        How long it lasted, and by how much the other turned meanwhile.
    kind : {'alive', 'frozen', 'dead', 'not_testable'}
        'frozen': there are such stretches. 'dead': one value for an hour from a sensor that
        reports decimals, while the other's value changed. 'not_testable': n < 2.
    frozen_s : float
        Total duration of these stretches, seconds.
    resolution_deg : float or None
        Step in which it reports, degrees: from its changes, or else from its decimals. None if
        it has none of up to four decimals.
    hold_s : float or None
        Usual time from one of its changes to the next, seconds, in the first 16384 readings;
        None without any change in them.
    allowed_deg : float or None
        Of the stretch at `start_ns`: how far the other may turn while a sensor that works
        repeats its value, degrees.

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


def resolution_of(heading_deg: ArrayLike) -> float | None:
    """
    Return the step in which a heading is reported, also of one that hardly changes.

    Parameters
    ----------
    heading_deg : array_like, shape (n,)
        Headings in sample order, finite, degrees.

    Returns
    -------
    float or None
        The step of its changes; where they are too few to tell, or fewer than a tenth of the
        readings, the last decimal that a thousand readings show: those that occur more than
        once, if any, for others may be interpolated. None without readings, or beyond four
        decimals.

    Examples
    --------
    >>> resolution_of([123.4] * 50), resolution_of([123.0])
    (0.1, 1.0)

    """
    heading = np.asarray(heading_deg, dtype=np.float64)
    found = resolution(heading)
    if found.step_deg is not None and found.repeated_share < _REPEATED:
        return found.step_deg
    some, often = np.unique(np.round(heading[::max(1, heading.size // 1000)], 7),
                            return_counts=True)
    some = some[often > 1] if (often > 1).any() else some
    for decimals in range(_MOST_DECIMALS + 1):
        scaled = some * 10.0 ** decimals
        if (np.abs(scaled - np.rint(scaled)) <= _DECIMAL_DEG * 10.0 ** decimals).all():
            return 10.0 ** -decimals if some.size else None
    return found.step_deg


def frozen(stamp_ns: ArrayLike, heading_deg: ArrayLike, other_deg: ArrayLike, *,
           least_s: float = 5.0, moved_deg: float = 0.5,
           sigma_deg: float | None = None) -> Frozen:
    """
    Look for times when a sensor repeats its value while the other one turns.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps in increasing order, nanoseconds.
    heading_deg, other_deg : array_like, shape (n,)
        Headings of the sensor looked at, and of the other, finite, degrees.
    least_s : float
        Shortest time counted, seconds. A coarse sensor on a steady course repeats itself for
        seconds without a fault.
    moved_deg : float
        Least range of the other sensor within that time, degrees.
    sigma_deg : float, optional
        Norm of the standard deviation of the difference, degrees: bounds the errors where the
        sensor repeats itself for so much of the run that the rest does not tell.

    Returns
    -------
    Frozen

    Notes
    -----
    Judged is the range of the other's means over about a second, within the stretch less two
    seconds and one hold at either end: a skew, or a sensor slower than its messages, repeats
    values into and out of a turn. A sensor that works may repeat a value while the ship stays
    within two of its steps; the errors of both add twice the range that the difference has in
    nine of ten other windows as long. Of normal errors twice that range is exceeded with a
    probability below 1e-6. Nothing is added where in nine of ten windows as long, of 16
    seconds or more, in which the other moved about as much (half to twice), the sensor followed
    by 0.3 of it or more: then the difference ranges because of a skew. Windows that overlap a
    long repetition are left out. Where fewer than eight are left, 8 `sigma_deg` are added
    instead.

    References
    ----------
    E.18 of ``docs/diagnostics.md``.

    """
    stamps = np.asarray(stamp_ns)
    if stamps.size < 2:
        return Frozen(0.0, kind='not_testable')
    heading = np.asarray(heading_deg, dtype=np.float64)
    other = np.asarray(other_deg, dtype=np.float64)
    first, last, hold = _stretches(stamps, heading)
    lasted = (stamps[last] - stamps[first]) / 1e9
    longest = float(lasted.max(initial=0.0))
    step = resolution_of(heading)
    dead = longest >= _DEAD_S and step is not None and step < 1.0 and not _is_still(other)
    margin = _MARGIN_S + (hold or 0.0)
    long = np.flatnonzero(lasted >= max(least_s, 2.0 * margin + _PART_S))
    long = long[np.argsort(-lasted[long], kind='stable')][:_LONGEST_STRETCHES]
    alive = Frozen(longest, kind='dead' if dead else 'alive', resolution_deg=step, hold_s=hold)
    if not long.size:
        return alive
    busy = np.zeros(stamps.size, bool)
    for lo, hi in zip(first[long], last[long]):
        busy[lo:hi + 1] = True
    windows = _Windows(stamps, heading, other, busy, sigma_deg)
    grain = max(moved_deg, _STEPS * (step or 0.0))
    found = []
    for at in long:
        lo, hi = _within(stamps, int(first[at]), int(last[at]), margin)
        moved = _moved(stamps, other[lo:hi], lo, hi)
        if moved <= grain:
            continue
        allowed = windows.allowed_deg((int(stamps[hi - 1]) - int(stamps[lo])) / 1e9, moved, grain)
        if moved > allowed:
            found.append((moved, allowed, float(lasted[at]), int(stamps[first[at]])))
    if not found:
        return alive
    moved, allowed, duration, start = max(found)
    return Frozen(longest, len(found), start, duration, moved, 'dead' if dead else 'frozen',
                  sum(f[2] for f in found), step, hold, allowed)


def _stretches(stamps: np.ndarray,
               heading: np.ndarray) -> tuple[np.ndarray, np.ndarray, float | None]:
    """Return first and last index of every stretch of equal readings, and the usual hold, s."""
    steps = np.diff(heading)
    np.abs(steps, out=steps)
    same = steps <= _EQUAL_DEG
    if steps.max() >= 360.0 - _EQUAL_DEG:
        same |= steps >= 360.0 - _EQUAL_DEG
    changes = np.flatnonzero(~same[:_LOOKED_AT])
    hold = float(np.median(np.diff(stamps[changes]))) / 1e9 if changes.size > 1 else None
    repeats = np.flatnonzero(same)
    begins = np.diff(repeats, prepend=-2) > 1
    return repeats[begins], repeats[np.append(begins[1:], True)[:begins.size]] + 1, hold


def _within(stamps: np.ndarray, lo: int, hi: int, margin_s: float) -> tuple[int, int]:
    """Return the half-open range of a stretch without its margins."""
    margin = round(margin_s * 1e9)
    first, last = np.searchsorted(stamps[lo:hi + 1], [stamps[lo] + margin, stamps[hi] - margin])
    return lo + int(first), lo + max(int(last), int(first)) + 1


def _moved(stamps: np.ndarray, values: np.ndarray, lo: int, hi: int) -> float:
    """Return the range of the means over about a second; of readings, if they are fewer."""
    values = unwrap_deg(values[::max(1, values.size // _LOOKED_AT)])
    span = (int(stamps[hi - 1]) - int(stamps[lo])) / 1e9
    parts = min(_MOST_PARTS, values.size, max(1, math.floor(span / _PART_S)))
    if parts < 2:
        return float(np.ptp(values)) if values.size else 0.0
    edges = np.linspace(0, values.size, parts + 1).astype(np.int64)
    return float(np.ptp(np.add.reduceat(values, edges[:-1]) / np.diff(edges)))


class _Windows:
    """What both sensors do in windows that hold no long repetition."""

    def __init__(self, stamps: np.ndarray, heading: np.ndarray, other: np.ndarray,
                 busy: np.ndarray, sigma_deg: float | None) -> None:
        self._stamps, self._heading, self._other = stamps, heading, other
        self._busy = busy
        self._sigma_deg = sigma_deg
        self._least_s = _LEAST_READINGS * float(np.median(np.diff(stamps[:_LOOKED_AT]))) / 1e9
        self._known: dict[float, np.ndarray] = {}

    def allowed_deg(self, span_s: float, moved_deg: float, grain_deg: float) -> float:
        """Return how far the other may move in a stretch that a working sensor repeats."""
        span_s = _PART_S * 2.0 ** math.ceil(math.log2(max(span_s, self._least_s, _PART_S)))
        if span_s not in self._known:
            self._known[span_s] = self._ranges(span_s)
        own, others, errors = self._known[span_s]
        if errors.size < _LEAST_WINDOWS:
            mostly = np.count_nonzero(self._busy) > 0.5 * self._busy.size
            return grain_deg + (8.0 * self._sigma_deg if self._sigma_deg is not None
                                else 0.0 if mostly else math.inf)
        alike = (others >= 0.5 * moved_deg) & (others <= 2.0 * moved_deg)
        if span_s >= _FOLLOWS_S and np.count_nonzero(alike) >= _LEAST_WINDOWS and np.quantile(
                own[alike] / others[alike], 1.0 - _SPAN_SHARE) >= _FOLLOWS:
            return grain_deg
        return grain_deg + 2.0 * float(np.quantile(errors, _SPAN_SHARE))

    def _ranges(self, span_s: float) -> np.ndarray:
        """Return the ranges of the sensor, of the other and of the difference by window."""
        stamps, whole = self._stamps, int(self._stamps[-1]) - int(self._stamps[0])
        length = round(span_s * 1e9)
        rows = []
        if 2 * length < whole:
            begins = stamps[0] + np.linspace(0, whole - length, _WINDOWS).astype(np.int64)
            lo, hi = np.searchsorted(stamps, begins), np.searchsorted(stamps, begins + length)
            for a, b in zip(lo.tolist(), hi.tolist()):
                if b - a < 2 or stamps[b - 1] - stamps[a] < 0.5 * length \
                        or self._busy[a:b].any():
                    continue
                own, other = self._heading[a:b], self._other[a:b]
                rows.append([_moved(stamps, h, a, b) for h in (own, other, own - other)])
        return np.array(rows).reshape(-1, 3).T


def _is_still(heading: np.ndarray) -> bool:
    """Tell whether a heading stays within two of its steps."""
    still = _still_deg(resolution_of(heading))
    return _range_of(heading, still) <= still


def _still_deg(step: float | None) -> float:
    return _STEPS * (step or 0.0) * 1.01 + _EQUAL_DEG


def _range_of(heading: np.ndarray, enough_deg: float = math.inf) -> float:
    """Return the range about the first heading, on the circle; of some of them if it is enough."""
    for every in (max(1, heading.size // _LOOKED_AT), 1):
        off = wrap180(heading[::every] - heading[0])
        found = float(off.max() - off.min())
        if found > enough_deg:
            break
    return found


@dataclass(frozen=True, slots=True)
class Standstill:
    """
    Whether both sensors hardly change: then the run does not show that they work.

    Attributes
    ----------
    kind : {'moving', 'still', 'not_testable'}
        'still': both readings stay within two of their steps all the run. 'not_testable': n < 2.
    ts_range_deg, rs_range_deg : float
        Largest less smallest heading, degrees; of 16384 of them, where that is enough to tell.
    ts_step_deg, rs_step_deg : float or None
        Steps in which they report, `resolution_of`.

    """

    kind: str
    ts_range_deg: float
    rs_range_deg: float
    ts_step_deg: float | None
    rs_step_deg: float | None


def standstill(ts_deg: ArrayLike, rs_deg: ArrayLike) -> Standstill:
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
    >>> standstill([10.1, 10.1, 10.2], [10.0, 10.0, 10.0]).kind
    'still'

    """
    ts, rs = (np.asarray(h, dtype=np.float64) for h in (ts_deg, rs_deg))
    if ts.size < 2:
        return Standstill('not_testable', 0.0, 0.0, None, None)
    steps = resolution_of(ts), resolution_of(rs)
    limits = tuple(_still_deg(step) for step in steps)
    ranges = _range_of(ts, limits[0]), _range_of(rs, limits[1])
    still = all(r <= limit for r, limit in zip(ranges, limits))
    return Standstill('still' if still else 'moving', *ranges, *steps)
