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

"""Whether the TS follows the glitches of the RS, which means that both have one source."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.angles import unwrap_deg
from heading_intercompare.core.records import Reals
from heading_intercompare.core.statistics.blocking import pick_stretches
from heading_intercompare.core.statistics.resolution import find_resolution

_LEAST = 200
_LOOKED_AT = 200_000
_BESIDE = 3
_LONGEST = 3
_QUANTILE = 0.9
_SURPLUS = 5.0
_GRAIN = 3.0
_FLANK = 0.2
_SHIP_DEG_S2 = 30.0
_EVEN = 0.2
_APART_S = 10.0
_FEWEST, _MOST = 3, 200
_FOLLOWS = 3.0
_ALIKE = 2.0
_EARLIEST_S, _LATEST_S = 1.0, 10.0
_NEAR_S = 120.0
_FILTER_S = 5.0
_LEAST_DEG = 1e-4
_CHANCE = 1e-5
_PIECE = 1 << 13
#: Exchanges, the smaller value first, after which the fourth of seven values is their median.
_MEDIAN_OF_SEVEN = ((0, 5), (0, 3), (1, 6), (2, 4), (0, 1), (3, 5), (2, 6), (2, 3), (3, 6), (4, 5),
                    (1, 4), (1, 3), (3, 4))


@dataclass(frozen=True, slots=True)
class CommonGlitches:
    """
    The glitches of the RS, and those that the TS follows.

    Attributes
    ----------
    kind : {'common', 'independent', 'not_testable'}
        'common': the sensors have one source. 'not_testable': the RS has fewer than three
        glitches, more than ten seconds apart, that a filter of five seconds would leave visible.
    count
        Glitches of the RS.
    followed
        Those that the TS follows after the same delay.
    delay_s
        That delay, seconds; None if the TS follows fewer than three.
    chance
        Upper bound of the probability that `followed` or more match by chance, over all delays.

    """

    kind: str
    count: int = 0
    followed: int = 0
    delay_s: float | None = None
    chance: float | None = None


def find_common_glitches(stamp_ns: ArrayLike, x_deg: ArrayLike,
                         rs_deg: ArrayLike) -> CommonGlitches:
    """
    Look for the glitches of the RS in the TS.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps of the pairs in increasing order, nanoseconds.
    x_deg, rs_deg : array_like, shape (n,)
        Differences and headings of the RS, finite, degrees.

    Returns
    -------
    CommonGlitches

    Notes
    -----
    A glitch returns within three readings, stands out from everything else that the RS does, and
    would need an acceleration above 30 deg/s^2, which no ship reaches. An abrupt turn is no
    glitch: both sensors see it.

    A TS that copies the RS late or through a filter jumps by a constant share of the glitch after
    a constant delay. Only jumps above three times the 90 % quantile count. Within two minutes of
    each glitch, the share of jumps at least as large as the smallest one that follows a glitch is
    found. The product of these shares, times the ways to choose the followed glitches and the
    smallest of them, times the delays tried, bounds the probability of chance. The TS must follow
    at least three glitches and half of all, and this bound must be below 1e-5.

    References
    ----------
    E.20 of ``docs/diagnostics.md``.

    """
    stamps = np.asarray(stamp_ns)
    if stamps.size < _LEAST:
        return CommonGlitches('not_testable')
    rs = np.asarray(rs_deg, dtype=np.float64)
    step_s = float(np.median(np.diff(stamps[:_LOOKED_AT]))) / 1e9
    if not step_s > 0.0:
        return CommonGlitches('not_testable')
    where, size = _glitches(stamps, rs, step_s)
    if where.size < _FEWEST:
        return CommonGlitches('not_testable', int(where.size))
    # Compares with earlier readings only, because a filter returns slowly.
    jump = np.diff(unwrap_deg(rs) + unwrap_deg(x_deg), 2, prepend=(0.0, 0.0))
    jump[:2] = 0.0
    least = _FOLLOWS * float(np.quantile(np.abs(jump[::max(1, jump.size // _LOOKED_AT)]),
                                         _QUANTILE))
    least = max(least, _LEAST_DEG)
    jumps = np.abs(jump)
    large = jumps > least
    # The slowest filter, and falling between two stamps, leave half of this of a glitch.
    shown = np.abs(size) * min(1.0, step_s / _FILTER_S) > 2.0 * least
    kind = 'independent' if np.count_nonzero(shown) >= _FEWEST else 'not_testable'
    lags = np.arange(-round(_EARLIEST_S / step_s), round(_LATEST_S / step_s) + 1)
    best = CommonGlitches(kind, int(where.size))
    for lag in lags.tolist():
        at = where + lag
        inside = (at >= 2) & (at < jump.size)
        at = np.clip(at, 0, jump.size - 1)
        hit = inside & large[at]
        if np.count_nonzero(hit) < _FEWEST:
            continue
        gain = jump[at] / size
        usual = float(np.median(gain[hit]))
        hit &= (gain * usual > 0.0) & (np.abs(gain) < _ALIKE * abs(usual)) \
            & (np.abs(gain) > abs(usual) / _ALIKE)
        followed = int(np.count_nonzero(hit))
        if followed < max(_FEWEST, 0.5 * where.size):
            continue
        share = _share(jumps >= float(jumps[at[hit]].min()), at[hit], round(_NEAR_S / step_s))
        chance = math.exp(min(0.0, math.log(math.comb(where.size, followed))
                              + math.log(where.size * lags.size) + float(np.log(share).sum())))
        # On a tie the earliest delay wins, because a glitch also returns.
        if (chance < _CHANCE, followed) > (best.kind == 'common', best.followed):
            best = CommonGlitches('common' if chance < _CHANCE else kind, int(where.size),
                                  followed, lag * step_s, chance)
    return best


def _share(large: np.ndarray, at: np.ndarray, reach: int) -> np.ndarray:
    """Return the share of large jumps around each of some places, without the place itself."""
    count = np.concatenate(([0], np.cumsum(large)))
    both = []
    for width in (reach, _LONGEST + 2):
        lo, hi = np.maximum(at - width, 0), np.minimum(at + width + 1, large.size)
        both.append((count[hi] - count[lo], hi - lo))
    (wide, n), (at_place, _) = both
    share: Reals = (wide - at_place + 1.0) / (n + 1.0)
    return share


def _subtract_medians(heading: np.ndarray, lo: int, hi: int) -> np.ndarray:
    """Return the readings in a range, each minus the median of seven, itself in the middle."""
    part = unwrap_deg(heading[max(0, lo - _BESIDE):hi + _BESIDE])
    beyond = max(0, _BESIDE - lo), max(0, hi + _BESIDE - heading.size)
    if any(beyond):
        part = np.pad(part, beyond, mode='edge')
    rows = [part[k:part.size - 2 * _BESIDE + k] for k in range(2 * _BESIDE + 1)]
    for a, b in _MEDIAN_OF_SEVEN:
        rows[a], rows[b] = np.minimum(rows[a], rows[b]), np.maximum(rows[a], rows[b])
    off: Reals = part[_BESIDE:part.size - _BESIDE] - rows[_BESIDE]
    return off


def _find_far(heading: np.ndarray, least_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the readings that lie far from the median of seven, and how far, degrees."""
    where, how_far = [], []
    for lo in range(0, heading.size, _PIECE):
        off = _subtract_medians(heading, lo, min(lo + _PIECE, heading.size))
        far = np.flatnonzero((off > least_deg) | (off < -least_deg))
        where.append(lo + far)
        how_far.append(off[far])
    return np.concatenate(where), np.concatenate(how_far)


def _glitches(stamps: np.ndarray, rs: np.ndarray,
              step_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the index of the first reading of each glitch of the RS, and its size, degrees."""
    deviations = np.concatenate([_subtract_medians(rs, part.start, part.stop)
                                 for part in pick_stretches(rs.size)])
    looked_at = deviations[::max(1, deviations.size // _LOOKED_AT)]
    outer = float(np.quantile(np.abs(looked_at), _QUANTILE))
    beyond = outer / math.log(10.0) * (math.log(0.1 * rs.size) + _SURPLUS)
    least = max(outer + beyond, _GRAIN * (find_resolution(rs).step_deg or 0.0),
                0.5 * _SHIP_DEG_S2 * step_s ** 2)
    far, how_far = _find_far(rs, 0.5 * least)
    if not far.size:
        return far, how_far
    begins = np.flatnonzero(np.diff(far, prepend=-2) > 1)
    ends = np.append(begins[1:], far.size)
    high = np.maximum.reduceat(np.abs(how_far), begins) > least
    uneven = np.concatenate(([0], np.cumsum(
        np.abs(np.diff(stamps) / 1e9 - step_s) > _EVEN * step_s)))
    glitches, last_ns = [], None
    for lo, hi in zip(begins[high].tolist(), ends[high].tolist()):
        peak = float(how_far[lo + np.argmax(np.abs(how_far[lo:hi]))])
        size = abs(peak)
        before, after = max(0, int(far[lo]) - 2), min(rs.size, int(far[hi - 1]) + 3)
        of_glitch = before + np.flatnonzero(
            np.abs(_subtract_medians(rs, before, after)) > _FLANK * size)
        first, last = int(of_glitch[0]), int(of_glitch[-1])
        # Half of the time out and back, from the reading before to the reading after.
        lasts = 0.5 * (last - first + 2) * step_s
        needed = 0.5 * _SHIP_DEG_S2 * lasts ** 2 / (1.0 - _FLANK)
        if last - first >= _LONGEST or size <= needed:
            continue
        if first <= _BESIDE or last + _BESIDE >= rs.size \
                or uneven[first - _BESIDE - 1] != uneven[last + _BESIDE]:
            continue
        if last_ns is None or int(stamps[first]) - last_ns > _APART_S * 1e9:
            glitches.append((first, peak))
            last_ns = int(stamps[first])
        if len(glitches) == _MOST:
            break
    return np.array([f[0] for f in glitches], np.int64), np.array([f[1] for f in glitches])
