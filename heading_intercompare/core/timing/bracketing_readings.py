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

"""How many readings a slow sensor has per pair, recovered from its pairs alone."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.angles import unwrap_deg

_SLOPE = 1e-6
_EQUAL_DEG = 1e-7
_LOOKED_AT = 100_000
_LEAST_SHARE = 0.1
_PHASES = 4096
_LEAST_POWER, _LEAST_CHANGE = 0.5, 0.01
_SHORT = 0.05
_REGULAR = 0.3


def _slopes(stamp_ns: np.ndarray, heading: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the slopes from pair to pair, deg/s, and whether three pairs are not in line."""
    slope = np.diff(heading) / np.maximum(np.diff(stamp_ns) / 1e9, 1e-9)
    kink = np.abs(np.diff(slope)) > _SLOPE * (1.0 + np.abs(slope[1:]))
    return slope, kink


def readings_per_pair(stamp_ns: ArrayLike, heading_deg: ArrayLike) -> int:
    """
    Return the number of pairs per new reading of a sensor.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps in increasing order, nanoseconds.
    heading_deg : array_like, shape (n,)
        Headings of the pairs, finite, degrees.

    Returns
    -------
    int
        1 for a sensor as fast as the pairs. Slower sensors show by repeated values, or by values
        in a line between readings. Only the first 100000 pairs are examined.

    Examples
    --------
    >>> readings_per_pair(range(0, 10**12, 10**9), [k // 5 for k in range(1000)])
    5

    """
    stamps = np.asarray(stamp_ns)[:_LOOKED_AT]
    heading = unwrap_deg(np.asarray(heading_deg)[:_LOOKED_AT])
    if stamps.size < 3:
        return 1
    repeated = _usual_distance(np.flatnonzero(np.abs(np.diff(heading)) > _EQUAL_DEG))
    slope, kink = _slopes(stamps, heading)
    moving = (np.abs(slope) > _SLOPE)[1:]
    if not moving.any() or float(np.mean(kink[moving])) > 1.0 - _LEAST_SHARE:
        return repeated
    # A reading between two pairs makes two kinks in a row, one at a pair makes one.
    kinks = np.flatnonzero(kink)
    begins = np.flatnonzero(np.diff(kinks, prepend=-2) > 1)
    if np.count_nonzero(np.diff(begins, append=kinks.size) > 2) > _SHORT * begins.size:
        return repeated
    return max(repeated, _usual_distance(kinks[begins]))


def pairs_per_reading(factor: ArrayLike) -> float:
    """
    Return the largest possible number of pairs per reading of an interpolated sensor.

    Parameters
    ----------
    factor : array_like, shape (n,)
        Factor by which interpolation changes the variance of white noise.

    Returns
    -------
    float
        From 1 to 2; 1 if the factors do not show it.

    Notes
    -----
    The factor depends on the place of a stamp between two readings alone. With even stamps it has
    a period, whose frequency is the number of readings per pair, folded: 0.6 cannot be told from
    0.4 or 1.4. The result is for the slowest sensor with at most two pairs per reading. A slower
    one shows by three pairs in a line, see `readings_per_pair`.

    Examples
    --------
    >>> w = [0.1 + 0.7 * k % 1.0 for k in range(200)]
    >>> round(pairs_per_reading([(1.0 - v) ** 2 + v ** 2 for v in w]), 3)
    1.429

    """
    factors = np.asarray(factor, dtype=np.float64)[:_PHASES]
    if factors.size < _PHASES // 32:
        return 1.0
    if float(np.std(factors)) < _LEAST_CHANGE:
        return 1.0
    power = np.abs(np.fft.rfft((factors - factors.mean()) * np.hanning(factors.size))) ** 2
    at = int(np.argmax(power))
    near = slice(max(0, at - 2), at + 3)
    if power[near].sum() < _LEAST_POWER * power.sum():
        return 1.0
    folded = float(np.arange(power.size)[near] @ power[near] / power[near].sum()) / factors.size
    return 1.0 / (1.0 - min(0.5, folded))


def _usual_distance(where: np.ndarray) -> int:
    """Return the usual distance of the events of a slow sensor; 1 if the sensor is not slow."""
    if where.size < 2:
        return 1
    # Rounding also repeats values or puts them in a line, but at irregular distances.
    apart = np.diff(where)
    least = float(np.quantile(apart, _SHORT, method='lower'))
    usual = float(apart[apart < 1.5 * least].mean())
    if float(np.mean(np.cos(2.0 * np.pi / usual * apart))) < _REGULAR:
        return 1
    return max(1, math.floor(usual + 0.5))
