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

"""The variance of each of three or more sensors without a reference."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Sequence

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.records import Headings
from heading_intercompare.core.statistics.blocking import block_size, student_95, sum_covariance
from heading_intercompare.core.statistics.drift import remove_polynomial
from heading_intercompare.core.timing.heading_track import Track


@dataclass(frozen=True, slots=True)
class Hats:
    """
    Variances of sensors whose errors are uncorrelated with each other.

    Attributes
    ----------
    n
        Readings of each sensor.
    pairs : tuple of pair of int
        The sensors of each difference, numbered from 0.
    pair_variance_deg2
        Variances of these differences, divisor n - 1.
    variance_deg2
        Variance of each sensor, by least squares on all pairs. May be negative, and is reported
        so, if the errors are correlated or the record is short.
    interval_deg2 : tuple of pair of float, or None
        95 % intervals; None for n < 16.
    std_deg
        Roots of the variances; None where negative.
    point_deg2
        Best-fitting variances that are not negative.

    """

    n: int
    pairs: tuple[tuple[int, int], ...]
    pair_variance_deg2: tuple[float, ...]
    variance_deg2: tuple[float, ...]
    interval_deg2: tuple[tuple[float, float], ...] | None
    std_deg: tuple[float | None, ...]
    point_deg2: tuple[float, ...]

    def __repr__(self) -> str:
        """Return the standard deviation of each sensor; nan where the variance is negative."""
        stds = ', '.join('nan' if std is None else f'{std:.4f}' for std in self.std_deg)
        return f'<Hats: {stds} deg, n = {self.n}>'


def at_common_stamps(sensors: Sequence[Headings],
                     skew_s: Sequence[float] | None = None) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the headings of several sensors at the stamps of the first.

    Parameters
    ----------
    sensors
        At least two.
    skew_s
        Age of the first sensor's data relative to each sensor's, seconds, as `scan_skew` of the
        first and each gives it; the first number is 0. Default no skew.

    Returns
    -------
    stamp_ns : ndarray of int64, shape (n,)
        Stamps of the first sensor that are within the readings of all others.
    heading_deg : ndarray, shape (k, n)
        Unwrapped headings; those of the others are interpolated at the stamp minus their skew.

    """
    origin = int(sensors[0].stamp_ns[0]) if len(sensors[0]) else 0
    tracks = [Track(s, origin) for s in sensors]
    skews = [0.0] * len(tracks) if skew_s is None else list(skew_s)
    t = tracks[0].t_s
    inside = np.ones(t.shape, bool)
    for track in tracks[1:]:
        # Tests the stamp without its skew, so that all skews use the same set of stamps.
        inside &= track.covers(t, t)
    t = t[inside]
    headings = [tracks[0].heading_deg[inside]]
    headings += [track.at(t - d) for track, d in zip(tracks[1:], skews[1:])]
    return origin + np.rint(t * 1e9).astype(np.int64), np.array(headings)


def three_cornered_hat(heading_deg: ArrayLike, stamp_ns: ArrayLike | None = None,
                       order: int = 0) -> Hats:
    """
    Split the variances of the differences among the sensors.

    Parameters
    ----------
    heading_deg : array_like, shape (k, n)
        Headings of k >= 3 sensors at common stamps, degrees.
    stamp_ns : array_like of int, shape (n,), optional
        The stamps; needed for an order above 0.
    order
        Order of the polynomial first removed from each difference, 0 to 3; 0 is the mean.

    Returns
    -------
    Hats

    Raises
    ------
    ValueError
        For fewer than three sensors, fewer than two readings, or an order without stamps.

    Notes
    -----
    For three sensors s_1^2 = (D_12 + D_13 - D_23)/2, which equals cov(x_12, x_13). The intervals
    follow from the scatter of block means of that product, with Student's factor.

    It needs all headings at common stamps, and gives the interval of these readings. The verdict
    on several sensors has only the variance of each pair, from stamps of its own, with its
    uncertainty: `core.sensors.variance_split` splits those.

    References
    ----------
    Gray & Allan 1974; the covariance form is that of Groslambert et al. 1981. E.12 of
    ``docs/diagnostics.md``.

    Examples
    --------
    >>> errors_deg = np.random.default_rng(1).standard_normal((3, 10000))
    >>> three_cornered_hat(100.0 + np.array([[0.3], [0.2], [0.1]]) * errors_deg)
    <Hats: 0.2955, 0.1941, 0.1079 deg, n = 10000>

    """
    heading = np.asarray(heading_deg, dtype=np.float64)
    if heading.ndim != 2 or heading.shape[0] < 3 or heading.shape[1] < 2:
        raise ValueError(f'heading_deg has shape {heading.shape}: at least 3 sensors by 2 '
                         'readings are needed')
    if order and stamp_ns is None:
        raise ValueError(f'order = {order!r}: a polynomial needs stamp_ns')
    k, n = heading.shape
    stamps = np.arange(n) if stamp_ns is None else np.asarray(stamp_ns)
    pairs = tuple((i, j) for i in range(k) for j in range(i + 1, k))
    design = np.zeros((len(pairs), k))
    squares = np.empty((len(pairs), n))
    for row, (i, j) in enumerate(pairs):
        design[row, [i, j]] = 1.0
        x = remove_polynomial(stamps, wrap180(heading[i] - heading[j]), order).residual_deg
        x -= x.mean()
        squares[row] = x * x
    variances = squares.sum(axis=1) / (n - 1)
    solve = np.linalg.pinv(design)
    estimate = solve @ variances
    point, _ = scipy.optimize.nnls(design, variances)
    return Hats(
        n=n, pairs=pairs, pair_variance_deg2=tuple(variances.tolist()),
        variance_deg2=tuple(estimate.tolist()), interval_deg2=_intervals(estimate, solve, squares),
        std_deg=tuple(math.sqrt(v) if v >= 0.0 else None for v in estimate.tolist()),
        point_deg2=tuple(point.tolist()))


def _intervals(estimate: np.ndarray, solve: np.ndarray,
               squares: np.ndarray) -> tuple[tuple[float, float], ...] | None:
    n = squares.shape[1]
    if not block_size(n, 16):
        return None
    covariance, dof = sum_covariance((solve @ squares).T / n)
    half = student_95(dof) * np.sqrt(np.diag(covariance))
    return tuple(zip((estimate - half).tolist(), (estimate + half).tolist()))
