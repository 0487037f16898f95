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

"""A lower bound of the noise of the RS, from the two headings themselves."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.records import Reals
from heading_intercompare.core.statistics.moments import Moments

QUIET = 0.1
"""An octave is used if the standard error is below this share of its variance of x."""

_LEAST_PAIRS = 16
#: Differences on either side by which the motion is predicted: a yaw has that much memory.
_NEIGHBOURS = 2
#: Smaller powers, relative to the largest, are rounding errors of the normal equations.
_LEAST_POWER = 1e-12
_RISK_FACTOR = 1.6448536269514722
_PIECE = 1 << 13


@dataclass(frozen=True, slots=True)
class ReferenceNoise:
    """The variance of x split between TS and RS, by octaves of averaging time."""

    octaves: tuple[int, ...] = figure('readings averaged', 'in the octaves in which the ship is '
                                      'quiet enough to tell the sensors apart', default=())
    ts_variance_deg2: tuple[float, ...] = figure('variance of the TS', default=())
    rs_variance_deg2: tuple[float, ...] = figure(
        'variance of the RS, with its standard uncertainty', default=(), u='u_deg2')
    u_deg2: tuple[float, ...] = figure('standard uncertainty of that of the RS', default=())
    sigma_ref_lower_deg: float | None = figure('standard deviation of the RS, lower 95 % bound',
                                               'minus a possible offset; null without octaves, 0 '
                                               'if the bound is below zero', default=None)
    following_deg2: tuple[float, ...] | None = figure(
        'of it in proportion to the motion', 'of the variance of the RS, as an error of either '
        'sensor in proportion to the motion is; the bound leaves it out', absent='without octaves')

    @property
    def white_upper_deg2(self) -> float | None:
        """
        Upper 95 % bound of the variance of the RS noise if it is white beyond the octaves used.

        Each further octave of white noise holds half of the one before: together they hold as
        much as the last. Square degrees; None without any octave.
        """
        if not self.octaves:
            return None
        total = sum(self.rs_variance_deg2) + self.rs_variance_deg2[-1]
        return total + _RISK_FACTOR * math.hypot(*self.u_deg2[:-1], 2.0 * self.u_deg2[-1])

    def m_lower(self, sigma_ref_max_deg: float) -> float | None:
        """Return the lower bound of M = sigma_ref / sigma_ref_max; None if unknown."""
        if self.sigma_ref_lower_deg is None or not sigma_ref_max_deg > 0.0:
            return None
        return self.sigma_ref_lower_deg / sigma_ref_max_deg


def estimate_reference_noise(ts_deg: ArrayLike, rs_deg: ArrayLike, *,
                             skew_variance_deg2: float = 0.0,
                             averages: tuple[int, Reals, Reals] | None = None,
                             ) -> ReferenceNoise:
    """
    Bound the noise of the RS from below, by the readings of both sensors.

    Parameters
    ----------
    ts_deg, rs_deg : array_like, shape (n,)
        Unwrapped headings of the pairs in sample order, finite, degrees.
    skew_variance_deg2
        Largest variance that a time skew may add to x, square degrees. Half of it may look like
        noise of the RS, and is subtracted from the bound.
    averages : int, ndarray, ndarray, optional
        For a long record: a power of two, and TS and RS averaged over that many samples, from
        which the octaves from there on are taken. `ts_deg` and `rs_deg` may then be stretches of
        the record, whose lengths are multiples of it.

    Returns
    -------
    ReferenceNoise

    Notes
    -----
    Let d and d_ref be the differences of neighbouring block means of TS and RS. The mean of
    d_ref (d_ref - d)/4 is the variance of the RS noise in that octave, that of d (d - d_ref)/4
    the variance of the TS noise: the heading cancels, whatever it does. If the heading moves
    much, the mean is uncertain and the octave is left out. This is valid if the errors of both
    and the heading are uncorrelated. With a skew s the heading leaves g(0) - g(s) of its
    autocovariance, half of what it adds to x. Interpolating the RS lowers the bound, which is the
    safe side.

    An error in proportion to the motion would look like noise of the RS. Let p be d as two
    neighbours on either side predict it, which hold no RS noise of the same time. The slope
    mean((d_ref - d) p) / mean(d p) times the power mean(d d_ref)/4 of the motion is subtracted.

    References
    ----------
    Two-sensor covariance: Holcomb 1989 (BSSA 79) for seismometers; E.11 of
    ``docs/diagnostics.md``.

    """
    ts, rs = (np.asarray(h, dtype=np.float64) for h in (ts_deg, rs_deg))
    rows = []
    size = 1
    while rs.size // 2 >= _LEAST_PAIRS:
        if averages is not None and size == averages[0]:
            _, ts, rs = averages
        d, d_ref = ts[1::2] - ts[:-1:2], rs[1::2] - rs[:-1:2]
        whole, rs_terms, (ts, rs) = _split_octave(ts, rs)
        variance = rs_terms.mean_deg
        u = math.sqrt((rs_terms.variance_deg2 or 0.0) / rs_terms.n)
        if u < QUIET * whole:
            rows.append((size, whole - variance, variance, u, *_find_following(d, d_ref)))
        size *= 2
    if not rows:
        return ReferenceNoise()
    octaves, ts_variances, rs_variances, us, following, u_following = zip(*rows)
    lower = (sum(rs_variances) - sum(following) - _RISK_FACTOR * math.hypot(*us, *u_following)
             - 0.5 * skew_variance_deg2)
    return ReferenceNoise(octaves, ts_variances, rs_variances, us, math.sqrt(max(0.0, lower)),
                          following)


def _find_following(d: Reals, d_ref: Reals) -> tuple[float, float]:
    """Return the part of the RS variance that follows the motion, and its standard error."""
    reach = _NEIGHBOURS
    inner = slice(reach, -reach)
    # The stretches of a long run are joined, which makes one wrong neighbour for each.
    neighbours = np.stack([np.roll(d, lag)[inner] for lag in range(-reach, reach + 1) if lag], 1)
    gram = neighbours.T @ neighbours
    weights = np.linalg.lstsq(gram, neighbours.T @ d[inner], rcond=_LEAST_POWER)[0]
    predicted = neighbours @ weights
    power = float(predicted @ predicted)
    motion_deg2 = max(0.0, 0.25 * float(np.mean(d * d_ref)))
    if not power > 0.0 or not motion_deg2:
        return 0.0, 0.0
    apart = (d_ref - d)[inner]
    slope = float(apart @ predicted) / power
    u_slope = math.sqrt(float(apart @ apart) / apart.size / power)
    return max(0.0, slope) * motion_deg2, u_slope * motion_deg2


def _split_octave(ts: np.ndarray, rs: np.ndarray,
                  ) -> tuple[float, Moments, tuple[np.ndarray, np.ndarray]]:
    """Return the variance of x in an octave, the terms of the RS, and both headings halved."""
    pairs = rs.size // 2
    halves = np.empty(pairs), np.empty(pairs)
    square, rs_terms = 0.0, Moments()
    for lo in range(0, pairs, _PIECE):
        hi = min(lo + _PIECE, pairs)
        steps = []
        for heading, half in zip((ts, rs), halves):
            before, after = heading[2 * lo:2 * hi:2], heading[2 * lo + 1:2 * hi:2]
            np.add(before, after, out=half[lo:hi])
            half[lo:hi] *= 0.5
            steps.append(after - before)
        d, d_ref = steps
        apart = d_ref - d
        square += float(apart @ apart)
        apart *= d_ref
        apart *= 0.25
        rs_terms += Moments.of(apart)
    return 0.25 * square / pairs, rs_terms, halves
