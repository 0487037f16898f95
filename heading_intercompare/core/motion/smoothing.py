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

"""A recorded quantity as a smooth function of time: a quintic spline with a stated bandwidth."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.records import Reals
from heading_intercompare.core.statistics.quadrature import gauss_legendre

_KNOTS_A_PERIOD = 8
#: Pieces of the quintic B-spline over one knot interval: coefficients of 1, u, ... u^5.
_PIECES = np.array([
    [1.0, -5.0, 10.0, -10.0, 5.0, -1.0],
    [26.0, -50.0, 20.0, 20.0, -20.0, 5.0],
    [66.0, 0.0, -60.0, 0.0, 30.0, -10.0],
    [26.0, 50.0, 20.0, -20.0, -20.0, 10.0],
    [1.0, 5.0, 10.0, 10.0, 5.0, -5.0],
    [0.0, 0.0, 0.0, 0.0, 0.0, 1.0]]) / 120.0
_BANDS = len(_PIECES)
_NEIGHBOURS = 9
_SIGMAS = 6.0
_SIGMA_PER_MAD = 1.4826
_BATCH = 1 << 16


@dataclass(frozen=True, slots=True, eq=False)
class Smooth:
    """
    A quintic spline on evenly spaced knots, which is smooth up to its fourth derivative.

    Attributes
    ----------
    start_s, step_s
        First knot, and the distance of the knots, seconds.
    pieces : ndarray, shape (n, 6)
        Coefficients of the polynomial of each interval, in its fraction.

    """

    start_s: float
    step_s: float
    pieces: np.ndarray

    @property
    def end_s(self) -> float:
        """Return the last knot, seconds."""
        return self.start_s + self.step_s * len(self.pieces)

    def read(self, t_s: Reals, derivative: int = 0) -> Reals:
        """
        Return the value or a derivative at any instants.

        Parameters
        ----------
        t_s : ndarray, shape (n,)
            Seconds. Before the first and after the last knot the function is a straight line.
        derivative : {0, 1, 2}
            0 for the value.

        Returns
        -------
        ndarray, shape (n,)
            An instant gives the same bits whatever other instants are read with it.

        """
        inside = np.clip(t_s, self.start_s, self.end_s)
        if derivative == 2:
            return np.where(inside == t_s, self._evaluate(inside, 2), 0.0)
        value = self._evaluate(inside, derivative)
        if derivative == 0:
            value = value + (t_s - inside) * self._evaluate(inside, 1)
        return value

    def _evaluate(self, t_s: Reals, derivative: int) -> Reals:
        position = (t_s - self.start_s) / self.step_s
        knot = np.minimum(position.astype(np.int64), len(self.pieces) - 1)
        u, value = position - knot, np.zeros(t_s.shape)
        for power in range(_BANDS - 1, derivative - 1, -1):
            factor = math.perm(power, derivative) / self.step_s**derivative
            value = value * u + factor * self.pieces[knot, power]
        return value


def find_spikes(values: Reals, least: float) -> np.ndarray:
    """
    Find samples that lie far from their neighbours.

    Parameters
    ----------
    values : ndarray, shape (n,)
        In the order of time.
    least
        A sample is no spike unless it lies further than this from the median of its neighbours.

    Returns
    -------
    ndarray of bool, shape (n,)
        True for a sample further than six standard deviations from the median of the nine around
        it. The standard deviation is taken from the median distance of the same nine.

    References
    ----------
    Hampel, "The influence curve and its role in robust estimation", 1974.

    """
    spikes = np.zeros(values.shape, dtype=bool)
    if values.size < _NEIGHBOURS:
        return spikes
    half = _NEIGHBOURS // 2
    padded = np.concatenate((values[half:0:-1], values, values[-2:-2 - half:-1]))
    windows = np.lib.stride_tricks.sliding_window_view(padded, _NEIGHBOURS)
    for first in range(0, values.size, _BATCH):
        batch = windows[first:first + _BATCH]
        median = np.median(batch, axis=1)
        spread = np.median(np.abs(batch - median[:, np.newaxis]), axis=1)
        limit = np.maximum(least, _SIGMAS * _SIGMA_PER_MAD * spread)
        spikes[first:first + _BATCH] = np.abs(values[first:first + _BATCH] - median) > limit
    return spikes


def bridge_gaps(t_s: Reals, values: Reals, longest_s: float) -> tuple[Reals, Reals]:
    """
    Fill the gaps between samples, so that a spline has something to follow there.

    Parameters
    ----------
    t_s, values : ndarray, shape (n,)
        Rising seconds, and values without spikes.
    longest_s
        A longer step is a gap.

    Returns
    -------
    t_s, values : ndarray, shape (m,)
        The samples, and in each gap further ones on a smooth way from the mean before it to the
        mean after it. Each mean is that of the samples within half of `longest_s`.

    """
    gaps = np.flatnonzero(np.diff(t_s) > longest_s)
    times, levels = [t_s], [values]
    for gap in gaps.tolist():
        begin, end = float(t_s[gap]), float(t_s[gap + 1])
        before = values[np.searchsorted(t_s, begin - 0.5 * longest_s):gap + 1].mean()
        after = values[gap + 1:np.searchsorted(t_s, end + 0.5 * longest_s, 'right')].mean()
        n = math.ceil((end - begin) / longest_s * _KNOTS_A_PERIOD)
        u = np.arange(1, n) / n
        times.append(begin + u * (end - begin))
        levels.append(before + (after - before) * u**3 * (10.0 - 15.0 * u + 6.0 * u**2))
    joined, at = np.concatenate(levels), np.concatenate(times)
    order = np.argsort(at, kind='stable')
    return at[order], joined[order]


def fit_smooth(t_s: Reals, values: Reals, period_s: float) -> Smooth:
    """
    Return a smooth function through samples.

    Parameters
    ----------
    t_s, values : ndarray, shape (n,)
        Rising seconds, and values; at least two samples.
    period_s
        An oscillation of this period keeps half its amplitude, whatever the rate of the samples.
        The share kept is 1 / (1 + (period_s / T)^6) for the period T: 98 % at twice the period.

    Raises
    ------
    ValueError
        If there are fewer than two samples, or the period is not positive.

    References
    ----------
    Eilers and Marx, "Flexible smoothing with B-splines and penalties", Statistical Science 11
    (1996): the sum of squared residuals, weighted by the time that a sample stands for, plus a
    penalty on the third differences of the coefficients.

    """
    if t_s.size < 2 or not period_s > 0.0:
        raise ValueError(f'{t_s.size} samples, period_s = {period_s!r}: must be at least 2 '
                         'samples and a period greater than 0')
    start_s, span_s = float(t_s[0]), float(t_s[-1] - t_s[0])
    n = max(1, math.ceil(span_s / period_s * _KNOTS_A_PERIOD))
    step_s = span_s / n
    position = (t_s - start_s) / step_s
    knot = np.minimum(position.astype(np.int64), n - 1)
    powers = (position - knot)[:, np.newaxis] ** np.arange(_BANDS)
    basis = powers @ _PIECES.T
    weights = _weigh(t_s) / step_s
    size = n + _BANDS - 1
    bands, right = np.zeros((_BANDS, size)), np.zeros(size)
    for i in range(_BANDS):
        right += np.bincount(knot + i, weights * basis[:, i] * values, size)
        for j in range(i, _BANDS):
            bands[j - i] += np.bincount(knot + i, weights * basis[:, i] * basis[:, j], size)
    penalty = _find_penalty(2.0 * math.pi * step_s / period_s)
    differences = np.array([-1.0, 3.0, -3.0, 1.0])
    for i in range(4):
        for j in range(i, 4):
            bands[j - i, i:size - 3 + i] += penalty * differences[i] * differences[j]
    coefficients = scipy.linalg.solveh_banded(bands, right, lower=True)
    pieces = np.zeros((n, _BANDS))
    for i in range(_BANDS):
        pieces += coefficients[i:i + n, np.newaxis] * _PIECES[i]
    return Smooth(start_s, step_s, pieces)


def _weigh(t_s: Reals) -> Reals:
    """Return the time that each sample stands for; of one beside a gap, what is usual."""
    steps = np.diff(t_s)
    steps = np.minimum(steps, 4.0 * np.median(steps))
    return 0.5 * (np.append(steps, steps[-1]) + np.insert(steps, 0, steps[0]))


def _find_penalty(angle_rad: float) -> float:
    """Return the penalty that halves an oscillation with this angle from knot to knot."""
    # Integrals of products of two B-splines, by quadrature that is exact for polynomials.
    nodes, share = gauss_legendre(_BANDS)
    values = ((nodes[:, np.newaxis] + 1.0) / 2.0) ** np.arange(_BANDS) @ _PIECES.T
    gram = sum(
        0.5 * float(np.sum(share * values[:, i] * values[:, j])) * math.cos((i - j) * angle_rad)
        for i in range(_BANDS) for j in range(_BANDS))
    return gram / (2.0 * math.sin(0.5 * angle_rad)) ** 6
