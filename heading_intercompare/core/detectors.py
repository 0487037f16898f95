# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Signs that the two streams should not be compared as they are."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike

from .angles import unwrap_deg
from .conventions import Convention, convention
from .resolution import Resolution
from .standstill import Frozen, frozen

__all__ = ['Convention', 'convention', 'Frozen', 'frozen', 'SameSource',
           'same_source', 'stamp_steps', 'StampSteps']

_EQUAL_DEG = 1e-7
_SHORT_STEPS, _OFF, _NEARLY_ALL = 0.1, 0.2, 0.9


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
class StampSteps:
    """
    How the stamps of one stream follow each other.

    Attributes
    ----------
    n : int
        Number of stamps.
    typical_s : float or None
        Median step, seconds; None for n < 2.
    nominal_s : float or None
        Step of which nearly all are multiples, seconds: that of the sensor, however many of its
        readings are missing. None for n < 2, and where the steps have no common measure.
    backward, equal, silences : int
        Steps back, steps of zero, and steps much longer than usual.
    longest_back_s, longest_s : float or None
        Longest step back without its sign (None if there is none), and longest step.

    """

    n: int
    typical_s: float | None
    nominal_s: float | None
    backward: int
    equal: int
    silences: int
    longest_back_s: float | None
    longest_s: float | None


def _nominal_s(steps: np.ndarray) -> float | None:
    """Return the step that nearly all are multiples of, seconds."""
    step = float(np.quantile(steps[::max(1, steps.size // 100_000)], _SHORT_STEPS))
    if not step > 0.0:
        return None
    times = steps / step
    even = np.abs(times - np.rint(times)) <= _OFF * np.maximum(1.0, np.sqrt(np.abs(times)))
    return step / 1e9 if float(np.mean(even)) >= _NEARLY_ALL else None


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
        return StampSteps(int(np.size(stamp_ns)), None, None, 0, 0, 0, None, None)
    typical = float(np.median(steps))
    least = int(steps.min())
    return StampSteps(
        steps.size + 1, typical / 1e9, _nominal_s(steps), int(np.count_nonzero(steps < 0)),
        int(np.count_nonzero(steps == 0)),
        int(np.count_nonzero(steps > silence_steps * typical)) if typical > 0.0 else 0,
        -least / 1e9 if least < 0 else None, int(steps.max()) / 1e9)
