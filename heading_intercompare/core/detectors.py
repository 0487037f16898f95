# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Signs that the two streams should not be compared as they are."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike

from .angles import circular_mean, unwrap_deg, wrap180
from .resolution import Resolution

__all__ = ['Convention', 'convention', 'Frozen', 'frozen', 'SameSource',
           'same_source', 'stamp_steps', 'StampSteps']

_EQUAL_DEG = 1e-7
_CONCENTRATED = 0.9
_TURNED_DEG = 5.0


@dataclass(frozen=True, slots=True)
class Convention:
    """
    Whether one heading is reported by another convention than the other.

    Attributes
    ----------
    kind : {'consistent', 'offset', 'mirrored', 'not_testable'}
        'offset': TS - RS is near 90, -90 or 180. 'mirrored': TS turns against RS, so that the
        difference turns with -2 times the heading. 'not_testable': no samples.
    angle_deg : float or None
        Mean of TS - RS, or of TS + RS if mirrored; degrees.
    spread_deg : float or None
        Circular standard deviation of the same.

    """

    kind: str
    angle_deg: float | None
    spread_deg: float | None


def convention(x_deg: ArrayLike, rs_deg: ArrayLike,
               tolerance_deg: float = 10.0) -> Convention:
    """
    Look for a difference of conventions between the sensors.

    Parameters
    ----------
    x_deg, rs_deg : array_like, shape (n,)
        Differences and headings of the RS, finite, degrees.
    tolerance_deg : float
        How near to 90, -90 or 180 a mean difference is suspicious, degrees.

    Returns
    -------
    Convention

    Notes
    -----
    Mirrored headings are found once the ship has turned: the spread of TS - RS must exceed 5
    degrees and four times that of TS + RS. A yaw taken for a heading, TS = 90 - heading, gives
    'mirrored' with 90.

    """
    x, rs = np.asarray(x_deg, dtype=np.float64), np.asarray(rs_deg, dtype=np.float64)
    if not x.size:
        return Convention('not_testable', None, None)
    angle, length = circular_mean(x)
    spread = _spread(length)
    mirrored, mirrored_length = circular_mean(x + 2.0 * rs)
    if spread > max(_TURNED_DEG, 4.0 * _spread(mirrored_length)):
        return Convention('mirrored', mirrored, _spread(mirrored_length))
    off = min(abs(float(wrap180(angle - wrong))) for wrong in (90.0, -90.0, 180.0)) \
        if math.isfinite(angle) else math.inf
    wrong = length > _CONCENTRATED and off <= tolerance_deg
    return Convention('offset' if wrong else 'consistent',
                      angle if math.isfinite(angle) else None,
                      spread if math.isfinite(spread) else None)


def _spread(length: float) -> float:
    """Return the circular standard deviation, degrees."""
    return math.degrees(math.sqrt(-2.0 * math.log(length))) if length > 0.0 else math.inf


@dataclass(frozen=True, slots=True)
class SameSource:
    """
    Whether the difference is too small to be that of two sensors.

    Attributes
    ----------
    suspected : bool or None
        None where the ship did not turn: then two sensors may agree by chance.
    std_deg : float or None
        Standard deviation of the difference; None for n < 2.
    rounding_deg : float
        What rounding of both headings alone gives.

    """

    suspected: bool | None
    std_deg: float | None
    rounding_deg: float


def same_source(x_deg: ArrayLike, rs_deg: ArrayLike, ts: Resolution, rs: Resolution,
                ratio: float = 1.5) -> SameSource:
    """
    Tell whether both streams may come from one sensor.

    Parameters
    ----------
    x_deg, rs_deg : array_like, shape (n,)
        Differences and headings of the RS, in sample order, finite, degrees.
    ts, rs : Resolution
        Of the headings of TS and RS.
    ratio : float
        Up to so many times the variance of rounding the sensors are taken for one.

    Returns
    -------
    SameSource

    """
    x = np.asarray(x_deg, dtype=np.float64)
    rounding = math.sqrt(ts.variance_deg2 + rs.variance_deg2)
    if x.size < 2:
        return SameSource(None, None, rounding)
    x = x - x[0]
    std = float(x.std(ddof=1))
    # A ship does not turn by 180 degrees from one of a hundred thousand readings to the next.
    some = np.asarray(rs_deg)[::max(1, x.size // 100_000)]
    turned = float(unwrap_deg(some).std(ddof=1))
    if turned <= max(_EQUAL_DEG, 3.0 * (ts.step_deg or 0.0), 3.0 * (rs.step_deg or 0.0)):
        return SameSource(None, std, rounding)
    return SameSource(std <= math.sqrt(ratio) * rounding + _EQUAL_DEG, std, rounding)


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

    """

    longest_s: float
    stretches: int = 0
    start_ns: int | None = None
    duration_s: float | None = None
    other_moved_deg: float | None = None


def frozen(stamp_ns: ArrayLike, heading_deg: ArrayLike, other_deg: ArrayLike, *,
           least_s: float = 5.0, moved_deg: float = 0.5) -> Frozen:
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

    Returns
    -------
    Frozen

    """
    stamps = np.asarray(stamp_ns)
    if stamps.size < 2:
        return Frozen(0.0)
    steps = np.diff(np.asarray(heading_deg, dtype=np.float64))
    np.abs(steps, out=steps)
    repeats = np.flatnonzero((steps <= _EQUAL_DEG) | (steps >= 360.0 - _EQUAL_DEG))
    begins = np.diff(repeats, prepend=-2) > 1
    first, last = repeats[begins], repeats[np.append(begins[1:], True)[:begins.size]] + 1
    lasted = (stamps[last] - stamps[first]) / 1e9
    longest = float(lasted.max(initial=0.0))
    long = np.flatnonzero(lasted >= least_s)
    if not long.size:
        return Frozen(longest)
    other = np.asarray(other_deg, dtype=np.float64)
    moved = np.array([np.ptp(unwrap_deg(other[lo:hi + 1]))
                      for lo, hi in zip(first[long], last[long])])
    count = int(np.count_nonzero(moved >= moved_deg))
    if not count:
        return Frozen(longest)
    worst = int(np.argmax(moved))
    at = long[worst]
    return Frozen(longest, count, int(stamps[first[at]]), float(lasted[at]), float(moved[worst]))


@dataclass(frozen=True, slots=True)
class StampSteps:
    """
    How the stamps of one stream follow each other.

    Attributes
    ----------
    n : int
        Number of stamps.
    typical_s : float or None
        Median step, seconds; None for n < 2.
    backward, equal, silences : int
        Steps back, steps of zero, and steps much longer than usual.
    longest_back_s, longest_s : float or None
        Longest step back without its sign (None if there is none), and longest step.

    """

    n: int
    typical_s: float | None
    backward: int
    equal: int
    silences: int
    longest_back_s: float | None
    longest_s: float | None


def stamp_steps(stamp_ns: ArrayLike, silence_steps: float = 10.0) -> StampSteps:
    """
    Look at the steps from stamp to stamp.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps in the order in which they came, nanoseconds.
    silence_steps : float
        A longer step than so many typical ones is a silence.

    Returns
    -------
    StampSteps

    Examples
    --------
    >>> found = stamp_steps([0, 1_000_000_000, 2_000_000_000, 500_000_000, 30_000_000_000])
    >>> found.backward, found.longest_back_s, found.silences
    (1, 1.5, 1)

    """
    steps = np.diff(np.asarray(stamp_ns, dtype=np.int64))
    if not steps.size:
        return StampSteps(int(np.size(stamp_ns)), None, 0, 0, 0, None, None)
    typical = float(np.median(steps))
    least = int(steps.min())
    return StampSteps(
        steps.size + 1, typical / 1e9, int(np.count_nonzero(steps < 0)),
        int(np.count_nonzero(steps == 0)),
        int(np.count_nonzero(steps > silence_steps * typical)) if typical > 0.0 else 0,
        -least / 1e9 if least < 0 else None, int(steps.max()) / 1e9)
