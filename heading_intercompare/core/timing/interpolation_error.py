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

"""The variance that linear interpolation between readings far apart adds to the differences."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Callable

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.angles import unwrap_deg
from heading_intercompare.core.statistics.blocking import block_means, block_size, student_95

from .bracketing_readings import find_brackets, readings_per_pair

__all__ = ['estimate_interpolation_error', 'InterpolationError']

_MOST = 1 << 19
_LEAST = 64
_EACH = 3
_FOLDED = 2.0
_LEAST_ANGLE = 0.05
_LEVELS = (np.arange(64) + 0.5) / 64.0
_MODEL = 1.2


@dataclass(frozen=True, slots=True)
class InterpolationError:
    """
    The error of linear interpolation in the differences.

    Attributes
    ----------
    kind : {'none', 'estimated', 'not_testable'}
        'none': no reading is interpolated. 'not_testable': too few pairs, or the interval
        between readings is unknown.
    method : str
        'brackets' if the other sensor has three or more readings between two readings,
        'differences' if it has fewer; empty unless estimated.
    variance_deg2, upper_deg2 : float or None
        Variance that interpolation adds to the difference, and its upper 95 % bound, square
        degrees.
    interval_s : float or None
        Time from reading to reading, seconds.
    angle_rad : float or None
        Phase advance of the motion from reading to reading, as weighted by its curvature.
    folded : bool
        Whether that phase exceeds 2 rad, less than 3.1 readings per period: then the readings
        hardly show the motion, and the figures are too small.

    """

    kind: str
    method: str = ''
    variance_deg2: float | None = None
    upper_deg2: float | None = None
    interval_s: float | None = None
    angle_rad: float | None = None
    folded: bool = False


def estimate_interpolation_error(stamp_ns: ArrayLike, interpolated_deg: ArrayLike,
                                 other_deg: ArrayLike,
                                 factor: ArrayLike, *,
                                 interval_s: float | None = None) -> InterpolationError:
    """
    Estimate the variance that linear interpolation between readings adds.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps of the pairs in increasing order, nanoseconds.
    interpolated_deg, other_deg : array_like, shape (n,)
        Headings of the sensor that was interpolated, and of the other, finite, degrees.
    factor : array_like, shape (n,)
        (1-w)^2 + w^2 of the interpolation; 1 where the reading is not interpolated.
    interval_s : float, optional
        Usual time from one reading of the interpolated sensor to the next, seconds. By default
        found from its values, which needs three or more pairs between two readings.

    Returns
    -------
    InterpolationError

    Notes
    -----
    All figures are means of products of both sensors, so that their noise cancels.

    'brackets': a is the parabola of the other sensor above the line between two readings; u and v
    are the second differences of both sensors there. Then mean(a u)^2 / mean(u v) is the mean
    square of the parabola, for motion of any single frequency.

    'differences': the second and third differences of both sensors from pair to pair give the
    curvature and the frequency of a sine, and so its error. The upper bound adds a fifth, because
    real motion is no sine.

    A skew between the sensors reduces the figures by the cosine of its phase. Of more than 2^19
    pairs, those in the middle of the run are used.

    References
    ----------
    Error of linear interpolation h^4/120 mean(r''^2) for slow motion; E.21 of
    ``docs/diagnostics.md``.

    """
    f = np.asarray(factor)
    if not f.size or f.min() >= 1.0 - 1e-12:
        return InterpolationError('none' if f.size else 'not_testable',
                                  variance_deg2=0.0 if f.size else None,
                                  upper_deg2=0.0 if f.size else None)
    part = _part(f.size)
    stamps = np.asarray(stamp_ns)[part]
    own, other = (unwrap_deg(np.asarray(h, dtype=np.float64)[part])
                  for h in (interpolated_deg, other_deg))
    if stamps.size < _LEAST or stamps[-1] == stamps[0]:
        return InterpolationError('not_testable')
    w = 0.5 - 0.5 * np.sqrt(np.clip(2.0 * f[part].astype(np.float64) - 1.0, 0.0, 1.0))
    step = float(np.median(np.diff(stamps))) / 1e9
    each = readings_per_pair(stamps, own)
    if interval_s is not None:
        each = max(1, round(interval_s / step))
    if each >= _EACH:
        found = _estimate_by_brackets(stamps, own, other, interval_s or each * step)
        if found is not None:
            return found
    if interval_s is None and each < _EACH:
        return InterpolationError('not_testable')
    return _estimate_by_differences(stamps, own, other, w, each, interval_s or each * step)


def _part(n: int) -> slice:
    """Return the middle part of a run; all of it if it is not too long."""
    first = max(0, (n - _MOST) // 2)
    return slice(first, min(n, first + _MOST))


def _estimate_by_brackets(stamps: np.ndarray, own: np.ndarray, other: np.ndarray,
                          interval_s: float) -> InterpolationError | None:
    """Estimate the error by the parabolas of the other sensor; None for too few brackets."""
    pieces = find_brackets(stamps, own)
    t = (stamps - stamps[0]) / 1e9
    # Unresolved nodes, as with a constant heading, leave gaps; neighbours lie an interval apart.
    node, value = (v[np.isfinite(pieces.node_s)] for v in (pieces.node_s, pieces.node_deg))
    if node.size < _LEAST:
        return None
    near = np.diff(node) < 1.5 * interval_s
    good = np.flatnonzero(near[:-2] & near[1:-1] & near[2:]) + 1
    if good.size < _LEAST:
        return None
    seen = np.interp(node, t, other)
    u, v = (0.5 * (h[good - 1] - h[good] - h[good + 1] + h[good + 2]) for h in (value, seen))
    bracket = np.searchsorted(node, t, side='right') - 1
    inside = (bracket >= 0) & (bracket < node.size - 1)
    bracket, at = bracket[inside], t[inside]
    w = (at - node[bracket]) / (node[bracket + 1] - node[bracket])
    off = other[inside] - (1.0 - w) * seen[bracket] - w * seen[bracket + 1]
    p = w * (1.0 - w)
    power = np.bincount(bracket, p * p, node.size)[good]
    parabola = np.bincount(bracket, off * p, node.size)[good] / np.maximum(power, 1e-12)
    number = np.bincount(bracket, minlength=node.size)[good]
    shape = float(power.sum() / number.sum())
    whole = float(np.mean(np.bincount(bracket, off * off, node.size)[good] / number))
    columns = np.stack((parabola * u, u * v), axis=1)

    def variance(means: np.ndarray) -> float:
        found, curved = means.tolist()
        # The parabola opposes the second difference; in slow motion it has half its size.
        return shape * found * found / curved if curved > 0.0 and found < 0.0 else 0.0

    estimate, upper = _jackknife(columns, variance)
    upper = max(upper, shape / 4.0 * _upper_mean(columns[:, 1]))
    third = np.diff(value, 3) * np.diff(seen, 3)
    second = np.diff(value, 2) * np.diff(seen, 2)
    angle = _angle(float(second.mean()), float(third.mean()))
    return InterpolationError('estimated', 'brackets', estimate, min(upper, max(whole, estimate)),
                              interval_s, angle, angle > _FOLDED)


def _estimate_by_differences(stamps: np.ndarray, own: np.ndarray, other: np.ndarray,
                             w: np.ndarray, each: int, interval_s: float) -> InterpolationError:
    """Estimate the error as that of a sine with these second and third differences."""
    step = each * float(np.median(np.diff(stamps))) / 1e9
    t = (stamps[::each] - stamps[0]) / 1e9
    own, other = own[::each], other[::each]
    even = np.diff(t)
    even = np.abs(even - step) <= 0.2 * step
    good = even[:-2] & even[1:-1] & even[2:]
    if np.count_nonzero(good) < _LEAST:
        return InterpolationError('not_testable')
    second, third = (np.diff(own, k) * np.diff(other, k) for k in (2, 3))
    columns = np.stack((second[:-1][good], third[good]), axis=1)
    w = np.quantile(w, _LEVELS)

    def variance(means: np.ndarray) -> float:
        return _sine_error(float(means[0]), _angle(*means.tolist()), step, interval_s, w)

    estimate, upper = _jackknife(columns, variance)
    upper = max(upper, _MODEL * estimate,
                _sine_error(_upper_mean(columns[:, 0]), 0.0, step, interval_s, w))
    angle = _angle(*columns.mean(axis=0).tolist()) * interval_s / step
    return InterpolationError('estimated', 'differences', estimate, upper, interval_s, angle,
                              angle > _FOLDED)


def _angle(second: float, third: float) -> float:
    """Return the phase step of a sine with these mean squared second and third differences."""
    if not (second > 0.0 and third > 0.0):
        return 0.0
    return math.acos(max(-1.0, 1.0 - 0.5 * third / second))


def _sine_error(second: float, angle: float, step_s: float, interval_s: float,
                w: np.ndarray) -> float:
    """Return the mean square error of a sine that is interpolated with these weights."""
    if second <= 0.0:
        return 0.0
    angle = max(angle, _LEAST_ANGLE)
    phase = angle * interval_s / step_s
    line = (1.0 - w) * np.exp(-1j * phase * w) + w * np.exp(1j * phase * (1.0 - w))
    seen = max(0.1, float(line.real.mean()))
    power = second / (4.0 * (1.0 - math.cos(angle)) ** 2) / seen
    return power * float(np.mean(np.abs(1.0 - line) ** 2))


def _upper_mean(values: np.ndarray) -> float:
    """Return an upper 95 % bound of a mean of correlated values, from 16 to 31 block means."""
    means = block_means(values, block_size(values.size, 16))
    return max(0.0, float(means.mean())) + student_95(means.size - 1) * float(
        means.std(ddof=1)) / math.sqrt(means.size)


def _jackknife(columns: np.ndarray, of: Callable[[np.ndarray], float]) -> tuple[float, float]:
    """Return a function of the column means, and its upper 95 % bound."""
    means = block_means(columns, block_size(columns.shape[0], 16))
    k = means.shape[0]
    estimate = of(columns.mean(axis=0))
    left = np.array([of((means.sum(axis=0) - one) / (k - 1)) for one in means])
    u = math.sqrt((k - 1) / k * float(np.sum((left - left.mean()) ** 2)))
    return estimate, estimate + student_95(k - 1) * u
