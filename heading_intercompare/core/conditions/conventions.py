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

"""Whether both sensors use the same heading convention, and their mean difference."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.angles import circular_mean, wrap180
from heading_intercompare.core.records import Reals
from heading_intercompare.core.statistics.blocking import (
    block_means,
    block_size,
    samples_per_average,
    student_95,
    sum_covariance,
)
from heading_intercompare.core.timing.skew_instrument import common_tracks, Tracks
from heading_intercompare.core.timing.skew_search import coarsen

_GRID_S = 0.25
_COARSEST_S = 1.0
_MOST = 1 << 18
_LEAST_WINDOWS, _MANY_WINDOWS = 8, 32
_CLEAR, _CLEARER = 4.0, 1.001
_TURNED_DEG = 3.0
_ABOVE_NOISE = 20.0
_SURE = 7.0
_LEAST_SAMPLES = 16
_UNEVEN, _UNEVENEST = 0.01, 0.2
_FASTEST_YAW_S = 5.0


class Direction(NamedTuple):
    """
    How the TS turns.

    Attributes
    ----------
    word : {'with', 'against', 'not_testable'}
    turned_deg
        Range of the means of the RS over the span that shows it best, degrees; 0 if none does.
    balance
        For the same span, the sum of squared changes of TS + RS over that of TS - RS, each at the
        skew that minimises it.

    """

    word: str = 'not_testable'
    turned_deg: float = 0.0
    balance: float | None = None


def find_turn_direction(stamp_ns: np.ndarray, x_deg: np.ndarray, rs_deg: np.ndarray,
                        range_s: float = 2.0, tracks: Tracks | None = None) -> Direction:
    """
    Find how the TS turns, from the pairs of a run.

    Parameters
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        Stamps of the pairs in increasing order, nanoseconds.
    x_deg, rs_deg : ndarray, shape (n,)
        Differences and RS headings, finite, degrees.
    range_s
        Largest skew to allow for, in either direction, seconds.
    tracks : pair of Track, optional
        `common_tracks` of the pairs, if already known.

    Returns
    -------
    Direction

    Notes
    -----
    Both headings are put on even times a quarter of a second apart. More than 2^18 of these make
    the step longer, up to a second, and after that only the middle of the run is used. D is the
    mean of a heading over a span minus that over the span before, for spans of 0.25, 0.5, 1, ...
    s, with at least eight spans in the run.

    At every skew L up to the range plus one step, V(+) = sum (D_ts + D_rs(L))^2 and
    V(-) = sum (D_ts - D_rs(L))^2. The balance is the least V(+) over the least V(-), so half a
    yaw period of skew does not look mirrored. The direction is clear if the balance is above 4 or
    below 1/4. For this test a hundredth of the power of both D, more if interpolation leaves
    more, is added to each V, because the skew moves in steps.

    The motion must also show. One of these suffices:

    * the means of the RS range over 3 deg;
    * they range over 20 times the root of the lesser V per sample, in at least 32 spans;
    * the sum of D_ts (D_rs(L+) + D_rs(L-)) is 7 times its uncertainty, in at least 128 spans.

    References
    ----------
    E.17 of ``docs/diagnostics.md``.

    """
    if x_deg.size < _LEAST_WINDOWS or stamp_ns[-1] == stamp_ns[0]:
        return Direction()
    ts, rs, grid_s, step_s = _put_on_even_times(
        tracks or common_tracks(stamp_ns, x_deg, rs_deg))
    most = round((range_s + _GRID_S) / grid_s)
    uneven = min(_UNEVENEST, _UNEVEN * (grid_s / _GRID_S) ** 2 + _interpolation_share(step_s))
    best, clearest = Direction(), 0.0
    width = 1
    while rs.size >= _LEAST_WINDOWS * width:
        direction, clear = _compare_turns(ts, rs, width, min(most, rs.size // 4), uneven)
        if clear > _CLEARER * clearest:
            best, clearest = direction, clear
        width *= 2
    return best


def _put_on_even_times(tracks: Tracks) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Return both headings, unwrapped, at even times; the new step and the old one, seconds."""
    ts, rs = (coarsen(track, _GRID_S) for track in tracks)
    span = float(rs.t_s[-1] - rs.t_s[0])
    grid_s = _GRID_S
    while span / grid_s > _MOST and grid_s < _COARSEST_S:
        grid_s *= 2.0
    half = 0.5 * min(span, grid_s * _MOST)
    middle = 0.5 * float(rs.t_s[0] + rs.t_s[-1])
    t = np.arange(middle - half, middle + half + 1e-9, grid_s, dtype=np.float64)
    return ts.at(t), rs.at(t), grid_s, rs.step_s


def _interpolation_share(step_s: float) -> float:
    """Return the error share of a yaw of five seconds after interpolating both sensors, E.21."""
    return 2.0 * (2.0 * math.pi * step_s / _FASTEST_YAW_S) ** 4 / 120.0


def _compare_turns(ts: np.ndarray, rs: np.ndarray, width: int, most: int,
             uneven: float) -> tuple[Direction, float]:
    """Return the direction by spans of `width` samples, and how clear the balance is."""
    d_ts, (d_rs, mean_rs) = _mean_changes(ts, width)[0], _mean_changes(rs, width)
    n = d_ts.size - 2 * most
    if n < 2:
        return Direction(), 0.0
    ts_changes = d_ts[most:most + n]
    power = float(_sum_products(ts_changes, ts_changes)[0][0])
    products, powers = _sum_products(ts_changes, d_rs)
    up, down = (int(np.argmin(powers + sign * 2.0 * products)) for sign in (-1.0, 1.0))
    apart = max(0.0, power + float(powers[up] - 2.0 * products[up]))
    together = max(0.0, power + float(powers[down] + 2.0 * products[down]))
    if together + apart <= 0.0:
        return Direction(), 0.0
    ratio = together / apart if apart > 0.0 else math.inf
    # The remainder of a yaw of five seconds at the true skew.
    floor = uneven * (power + float(powers[most]))
    surer = (together + floor) / (apart + floor)
    clear = max(surer, 1.0 / surer)
    turned = float(np.ptp(mean_rs))
    windows = ts.size // width
    noise = math.sqrt(min(together, apart) / n)
    shows = turned >= _TURNED_DEG or (
        windows >= _MANY_WINDOWS and turned >= _ABOVE_NOISE * noise and clear > _CLEAR)
    if not shows and windows >= 4 * _MANY_WINDOWS and n >= _LEAST_SAMPLES and clear > _CLEAR:
        terms = ts_changes * (d_rs[up:up + n] + d_rs[down:down + n])
        shows = abs(float(terms.sum())) > _SURE * math.sqrt(float(sum_covariance(terms)[0]))
    if not shows:
        return Direction(), 0.0
    word = 'not_testable' if clear <= _CLEAR else 'with' if ratio > 1.0 else 'against'
    return Direction(word, turned, ratio if math.isfinite(ratio) else None), clear


def _sum_products(ts_changes: Reals, rs_changes: Reals) -> tuple[Reals, Reals]:
    """Return the sums of products with RS changes that begin later and later, and of squares."""
    lags = rs_changes.size - ts_changes.size + 1
    products, powers = np.zeros(lags), np.zeros(lags)
    for lo in range(0, ts_changes.size, _PIECE):
        # The cache holds a piece for all lags.
        ts_piece = ts_changes[lo:lo + _PIECE]
        for lag in range(lags):
            rs_piece = rs_changes[lo + lag:lo + lag + ts_piece.size]
            products[lag] += ts_piece @ rs_piece
            powers[lag] += rs_piece @ rs_piece
    return products, powers


def _mean_changes(heading: np.ndarray, width: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the changes from mean to mean over `width` samples, and the means."""
    total = np.concatenate(([0.0], np.cumsum(heading - heading[0])))
    mean = (total[width:] - total[:-width]) / width
    return mean[width:] - mean[:-width], mean


_CONCENTRATED = 0.9
_ON_SEAM_SIGMAS = 5.0
_LOOKED_AT = 1 << 17
_STEP_NS = 250_000_000
#: Differences wrapped at once.
_PIECE = 1 << 15


@dataclass(frozen=True, slots=True)
class Convention:
    """
    Whether the two sensors report headings by different conventions.

    Attributes
    ----------
    kind : {'consistent', 'offset', 'mirrored', 'not_testable'}
        'offset': TS - RS is near 90, -90 or 180. 'mirrored': TS turns against RS, so the
        difference turns by -2 times the heading. 'not_testable': no samples.
    angle_deg
        Mean of TS - RS, or of TS + RS if mirrored; degrees.
    spread_deg
        Circular standard deviation of the same.
    direction : {'with', 'against', 'not_testable'}
        How TS turns: with RS, against it, or unknown because no motion shows above the noise.
    turned_deg
        Range of the RS heading, degrees, in means over the span that shows the direction best; 0
        if none does.
    balance
        For the same span, the sum of squared changes of TS + RS over that of TS - RS. Above 4 the
        sensors turn together, below 1/4 against each other. None if no motion shows.

    """

    kind: str
    angle_deg: float | None
    spread_deg: float | None
    direction: str = 'not_testable'
    turned_deg: float = 0.0
    balance: float | None = None


def find_convention(x_deg: ArrayLike, rs_deg: ArrayLike, tolerance_deg: float = 10.0, *,
                    stamp_ns: ArrayLike | None = None, range_s: float = 2.0,
                    tracks: Tracks | None = None) -> Convention:
    """
    Look for different heading conventions of the sensors.

    Parameters
    ----------
    x_deg, rs_deg : array_like, shape (n,)
        Differences and headings of the RS, in sample order, finite, degrees.
    tolerance_deg
        A mean difference within this of 90, -90 or 180 is suspicious, degrees.
    stamp_ns : array_like of int, shape (n,), optional
        Stamps of the pairs in increasing order, nanoseconds. Without them no skew is allowed for.
    range_s
        Largest skew to allow for, in either direction, seconds.
    tracks : pair of Track, optional
        `common_tracks` of the pairs, if already known.

    Returns
    -------
    Convention

    Notes
    -----
    `find_turn_direction` finds the direction. A TS that reports yaw as heading, TS = 90 -
    heading, gives 'mirrored' with 90. The means are circular, so the seam of the wrap does not
    matter. Long records are thinned evenly to at most 131072 samples for the means.

    References
    ----------
    E.17 of ``docs/diagnostics.md``.

    """
    x, rs = np.asarray(x_deg, dtype=np.float64), np.asarray(rs_deg, dtype=np.float64)
    if not x.size:
        return Convention('not_testable', None, None)
    if stamp_ns is None:
        stamp_ns, range_s = np.arange(x.size) * _STEP_NS, 0.0
    direction, turned, balance = find_turn_direction(np.asarray(stamp_ns), x, rs, range_s,
                                                     tracks)
    every = max(1, -(-x.size // _LOOKED_AT))
    x, rs = x[::every], rs[::every]
    mirrored = direction == 'against'
    angle, length = circular_mean(x + 2.0 * rs if mirrored else x)
    off = min(abs(float(wrap180(angle - wrong))) for wrong in (90.0, -90.0, 180.0)) \
        if math.isfinite(angle) else math.inf
    wrong = length > _CONCENTRATED and off <= tolerance_deg
    spread = _spread(length)
    return Convention('mirrored' if mirrored else 'offset' if wrong else 'consistent',
                      angle if math.isfinite(angle) else None,
                      spread if math.isfinite(spread) else None, direction, turned, balance)


def _spread(length: float) -> float:
    """Return the circular standard deviation, degrees."""
    return math.degrees(math.sqrt(-2.0 * math.log(length))) if length > 0.0 else math.inf


@dataclass(frozen=True, slots=True)
class MeanDifference:
    """
    The mean difference on the circle, and how well it is known.

    Attributes
    ----------
    n
        Number of differences.
    mean_deg
        Mean of the differences wrapped about their circular mean, in [-180, 180); None for
        n = 0 or if no direction is preferred.
    resultant
        Length of the mean resultant of up to 131072 differences, in [0, 1]; None for n = 0.
    u_deg
        Standard uncertainty of the mean, which allows for correlation; None for n < 16.
    interval_deg : pair of float or None
        95 % interval, not wrapped.
    seam_share
        Share of the differences that the seam of the wrap moves a whole turn away from the rest.

    """

    n: int
    mean_deg: float | None = None
    resultant: float | None = None
    u_deg: float | None = None
    interval_deg: tuple[float, float] | None = None
    seam_share: float = 0.0

    def is_torn(self, wrap_center_deg: float) -> bool:
        """Tell whether the differences lie on both sides of the seam of their wrap."""
        if self.mean_deg is None or self.resultant is None or not self.seam_share:
            return False
        if self.resultant <= _CONCENTRATED:
            return False
        away = abs(float(wrap180(self.mean_deg - wrap_center_deg - 180.0)))
        return away <= _ON_SEAM_SIGMAS * _spread(self.resultant)

    def surely_exceeds(self, limit_deg: float) -> bool:
        """Tell whether the whole interval lies beyond plus or minus a limit, degrees."""
        if self.interval_deg is None:
            return False
        low, high = self.interval_deg
        return low > limit_deg or high < -limit_deg


def _count_beyond_half(off_deg: np.ndarray) -> int:
    """Count the deviations of more than half a turn."""
    if -180.0 <= off_deg.min() and off_deg.max() <= 180.0:
        return 0
    return int(np.count_nonzero(np.abs(off_deg) > 180.0))


def estimate_mean_difference(x_deg: ArrayLike) -> MeanDifference:
    """
    Return the mean difference on the circle.

    Parameters
    ----------
    x_deg : array_like, shape (n,)
        Differences in sample order, finite, degrees; wrapped about any centre.

    Returns
    -------
    MeanDifference

    Notes
    -----
    The uncertainty is that of the mean of the deviations, wrapped about the circular mean, from
    16 to 31 block means. It is valid if the correlation time is short compared with a block.

    References
    ----------
    E.17 of ``docs/diagnostics.md``.

    Examples
    --------
    >>> difference = estimate_mean_difference([179.0, -179.0] * 8)
    >>> round(abs(difference.mean_deg), 6), difference.resultant > 0.999
    (180.0, True)

    """
    x = np.ravel(np.asarray(x_deg, dtype=np.float64))
    if not x.size:
        return MeanDifference(0)
    centre, length = circular_mean(x[::max(1, -(-x.size // _LOOKED_AT))])
    if not math.isfinite(centre):
        return MeanDifference(x.size, None, length)
    size, beyond, total = samples_per_average(x.size), 0, 0.0
    means = np.empty(x.size // size)
    for lo in range(0, x.size, _PIECE):
        part = x[lo:lo + _PIECE] - centre
        beyond += _count_beyond_half(part)
        part = wrap180(part)
        total += float(part.sum())
        few = block_means(part, size)
        means[lo // size:lo // size + few.size] = few
    share = min(beyond, x.size - beyond) / x.size
    mean = float(wrap180(centre + total / x.size))
    if not block_size(x.size, 16):
        return MeanDifference(x.size, mean, length, seam_share=share)
    covariance, dof = sum_covariance(means)
    u = math.sqrt(float(covariance)) / means.size
    half = student_95(dof) * u
    return MeanDifference(x.size, mean, length, u, (mean - half, mean + half), share)
