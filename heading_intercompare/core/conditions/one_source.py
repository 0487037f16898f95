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

"""All signs that both headings of a run come from one sensor, and the conclusion from them."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.statistics.moments import Moments
from heading_intercompare.core.statistics.resolution import find_resolution, LOOKED_AT, Resolution

from .common_glitches import CommonGlitches, find_common_glitches
from .common_noise import CommonNoise, find_common_noise

_EQUAL_DEG = 1e-7
_LEAST_CHANGES = 300
#: The sensors are one if at most this share of the changing readings differs.
_DIFFERING_SHARE = 0.001
#: Headings compared at once: intermediate results stay in the cache.
_PIECE = 1 << 14


@dataclass(frozen=True, slots=True)
class SameSource:
    """
    Whether both headings are the same except for a constant.

    Attributes
    ----------
    suspected
        None if the headings change too rarely: then two sensors may agree by chance.
    std_deg
        Standard deviation of the difference; None for n < 2.
    rounding_deg
        Standard deviation that rounding of both headings alone would give.

    """

    suspected: bool | None
    std_deg: float | None
    rounding_deg: float


def find_same_source(x_deg: ArrayLike, rs_deg: ArrayLike, ts: Resolution,
                     rs: Resolution) -> SameSource:
    """
    Tell whether one stream repeats the other, reading by reading.

    Parameters
    ----------
    x_deg, rs_deg : array_like, shape (n,)
        Differences and headings of the RS, in sample order, finite, degrees.
    ts, rs
        Resolution of the TS and RS headings.

    Returns
    -------
    SameSource

    Notes
    -----
    A small difference proves nothing: two good sensors that round the same motion differ by no
    more than rounding, and by less if their steps begin at the same angle. But if the errors of
    two sensors are e apart, their readings differ in at least a share e/q of the changes, where q
    is the coarser step. With 300 changes or more, fewer than one in a thousand that differ means
    that the errors agree to a thousandth of a step. A copy that is late, filtered, interpolated
    or rounded again is found by its noise, if it has any, in `common_noise`.

    """
    x = np.asarray(x_deg, dtype=np.float64)
    rounding = math.sqrt(ts.variance_deg2 + rs.variance_deg2)
    if x.size < 2:
        return SameSource(None, None, rounding)
    first = float(x[0])
    moments = sum((Moments.of(x[lo:lo + _PIECE] - first) for lo in range(0, x.size, _PIECE)),
                  start=Moments())
    std = math.sqrt(moments.m2_deg2 / (x.size - 1))
    heading = np.asarray(rs_deg, dtype=np.float64)
    ts_changes = rs_changes = 0
    for lo in range(0, x.size - 1, _PIECE):
        part = slice(lo, lo + _PIECE + 1)
        rs_changes += _count_nonzero(np.diff(heading[part]))
        ts_changes += _count_nonzero(np.diff(x[part] - first + heading[part]))
    changes = min(ts_changes, rs_changes)
    if changes < _LEAST_CHANGES:
        return SameSource(None, std, rounding)
    middle = float(np.median(x[::max(1, x.size // 100_000)]))
    differing = sum(_count_nonzero(x[lo:lo + _PIECE] - middle)
                    for lo in range(0, x.size, _PIECE))
    return SameSource(differing <= _DIFFERING_SHARE * changes, std, rounding)


def _count_nonzero(difference: np.ndarray) -> int:
    """Count the differences that are no whole number of turns."""
    off = np.abs(difference)
    if off.max(initial=0.0) >= 180.0:
        off = np.abs(off - 360.0 * np.rint(off / 360.0))
    return int(np.count_nonzero(off > _EQUAL_DEG))


@dataclass(frozen=True, slots=True)
class OneSource:
    """
    Signs of one source.

    Attributes
    ----------
    readings
        Whether the TS repeats the RS, reading by reading.
    noise
        Whether one sensor follows the noise of the other.
    glitches
        Whether the TS follows the glitches of the RS.

    """

    readings: SameSource
    noise: CommonNoise
    glitches: CommonGlitches

    @property
    def kind(self) -> str:
        """
        Return the conclusion from all signs.

        'common': one source. 'unsure': they share noise, but less than a copy would.
        'independent': both show noise of their own or the RS shows glitches, and the other does
        not follow. 'suspected': the TS repeats the RS, which shows neither, reading by reading;
        so would a copy, but also a second sensor without errors. Otherwise 'not_testable'.
        """
        kinds = self.noise.kind, self.glitches.kind
        if 'common' in kinds:
            return 'common'
        if 'unsure' in kinds:
            return 'unsure'
        if 'independent' in kinds:
            return 'independent'
        is_repeated = self.readings.suspected and self.noise.of_rs.kind != 'independent'
        return 'suspected' if is_repeated else 'not_testable'


def find_one_source(stamp_ns: ArrayLike, x_deg: ArrayLike, rs_deg: ArrayLike, *,
                    factor: ArrayLike | None = None, interpolates_ts: bool = False) -> OneSource:
    """
    Look for signs of one source in the pairs of a run.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps of the pairs in increasing order, nanoseconds.
    x_deg, rs_deg : array_like, shape (n,)
        Differences and headings of the RS, finite, degrees.
    factor : array_like, shape (n,), optional
        Factor by which interpolation changes the variance of white noise; default 1.
    interpolates_ts
        Whether the TS is interpolated, not the RS.

    Returns
    -------
    OneSource

    Notes
    -----
    Uses nothing but pairs, so the result is the same live, in replay and offline.

    References
    ----------
    E.20 of ``docs/diagnostics.md``.

    """
    x, rs = (np.asarray(v, dtype=np.float64) for v in (x_deg, rs_deg))
    steps = find_resolution(wrap360(x[:LOOKED_AT] + rs[:LOOKED_AT])), find_resolution(rs)
    return OneSource(
        find_same_source(x, rs, *steps),
        find_common_noise(stamp_ns, x, rs, factor=factor, interpolates_ts=interpolates_ts,
                          ts_step_deg=steps[0].step_deg, rs_step_deg=steps[1].step_deg),
        find_common_glitches(stamp_ns, x, rs))
