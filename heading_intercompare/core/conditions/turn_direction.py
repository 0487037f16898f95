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

"""Whether the TS turns with the RS or against it, at any small skew."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from heading_intercompare.core.statistics.blocking import sum_covariance
from heading_intercompare.core.timing.skew_instrument import common_tracks, Tracks
from heading_intercompare.core.timing.skew_search import coarsen

__all__ = ['Direction', 'find_turn_direction']

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
    turned_deg : float
        Range of the means of the RS over the span that shows it best, degrees; 0 if none does.
    balance : float or None
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
    range_s : float
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
        direction, clear = _compare(ts, rs, width, min(most, rs.size // 4), uneven)
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


def _compare(ts: np.ndarray, rs: np.ndarray, width: int, most: int,
             uneven: float) -> tuple[Direction, float]:
    """Return the direction by spans of `width` samples, and how clear the balance is."""
    d_ts, (d_rs, mean_rs) = _changes(ts, width)[0], _changes(rs, width)
    n = d_ts.size - 2 * most
    if n < 2:
        return Direction(), 0.0
    ts_changes = d_ts[most:most + n]
    power = float(ts_changes @ ts_changes)
    rs_changes = {k: d_rs[most + k:most + k + n] for k in range(-most, most + 1)}
    products = {k: float(ts_changes @ d) for k, d in rs_changes.items()}
    powers = {k: float(d @ d) for k, d in rs_changes.items()}
    up = min(products, key=lambda k: powers[k] - 2.0 * products[k])
    down = min(products, key=lambda k: powers[k] + 2.0 * products[k])
    apart = max(0.0, power + powers[up] - 2.0 * products[up])
    together = max(0.0, power + powers[down] + 2.0 * products[down])
    if together + apart <= 0.0:
        return Direction(), 0.0
    ratio = together / apart if apart > 0.0 else math.inf
    # The remainder of a yaw of five seconds at the true skew.
    floor = uneven * (power + powers[0])
    surer = (together + floor) / (apart + floor)
    clear = max(surer, 1.0 / surer)
    turned = float(np.ptp(mean_rs))
    windows = ts.size // width
    noise = math.sqrt(min(together, apart) / n)
    shows = turned >= _TURNED_DEG or (
        windows >= _MANY_WINDOWS and turned >= _ABOVE_NOISE * noise and clear > _CLEAR)
    if not shows and windows >= 4 * _MANY_WINDOWS and n >= _LEAST_SAMPLES and clear > _CLEAR:
        terms = ts_changes * (rs_changes[up] + rs_changes[down])
        shows = abs(float(terms.sum())) > _SURE * math.sqrt(float(sum_covariance(terms)[0]))
    if not shows:
        return Direction(), 0.0
    word = 'not_testable' if clear <= _CLEAR else 'with' if ratio > 1.0 else 'against'
    return Direction(word, turned, ratio if math.isfinite(ratio) else None), clear


def _changes(heading: np.ndarray, width: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the changes from mean to mean over `width` samples, and the means."""
    total = np.concatenate(([0.0], np.cumsum(heading - heading[0])))
    mean = (total[width:] - total[:-width]) / width
    return mean[width:] - mean[:-width], mean
