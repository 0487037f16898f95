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

"""Fits to measurements at rest: meter biases, azimuth, drifts, accelerometer biases."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.records import Reals


class RotationFit(NamedTuple):
    """
    Result of one revolution of the meter; rates in the unit given.

    Attributes
    ----------
    bias_x, bias_y
        Biases of the meter, in the axes of its case.
    rate_x, rate_y
        Rates along the axes of the platform.
    residual
        Weighted root mean square of what the fit leaves.
    bias_sigma
        Standard deviation of a bias, if what the fit leaves is independent from sector to sector.

    """

    bias_x: float
    bias_y: float
    rate_x: float
    rate_y: float
    residual: float
    bias_sigma: float


def hann(n: int) -> Reals:
    """Return n weights sin^2(pi (i + 1/2) / n), which vanish smoothly at both ends."""
    return np.sin(math.pi * (np.arange(n) + 0.5) / n) ** 2


class WindowedMean:
    """
    Hann-weighted mean of several quantities over a known number of steps.

    Parameters
    ----------
    n
        Number of steps to add.
    columns
        Number of quantities per step.

    """

    def __init__(self, n: int, columns: int) -> None:
        self._weights = hann(n).tolist()
        self._sums = [0.0] * columns
        self._weight = 0.0
        self._next = 0

    def add(self, *values: float) -> None:
        """Add the quantities of the next step."""
        w = self._weights[self._next]
        self._next += 1
        self._weight += w
        for i, value in enumerate(values):
            self._sums[i] += w * value

    def mean(self) -> list[float]:
        """Return the means of the quantities added."""
        return [total / self._weight for total in self._sums]


def fit_rotation(cosine: ArrayLike, sine: ArrayLike, rate_x: ArrayLike, rate_y: ArrayLike,
                 weights: ArrayLike | None = None) -> RotationFit:
    """
    Separate the biases of a two-axis rate meter from the rates it measures.

    Parameters
    ----------
    cosine, sine : array_like, shape (n,)
        Mean cosine and sine of the angle of the rotation unit over each sector.
    rate_x, rate_y : array_like, shape (n,)
        Mean readings of the two axes of the meter over each sector.
    weights : array_like, shape (n,), optional
        Weights of the sectors; default equal.

    Returns
    -------
    RotationFit

    Raises
    ------
    ValueError
        For fewer than three sectors, which do not safely determine the four unknowns.

    References
    ----------
    S (5), S (6): weighted least squares in m_x = c cos + s sin + d_x,
    m_y = -c sin + s cos + d_y.

    Examples
    --------
    >>> angle = np.radians([0.0, 90.0, 180.0, 270.0])
    >>> c, s = np.cos(angle), np.sin(angle)
    >>> fit = fit_rotation(c, s, 10.0 * c + 0.5, -10.0 * s - 0.2)
    >>> round(fit.bias_x, 9), round(fit.bias_y, 9), round(fit.rate_x, 9)
    (0.5, -0.2, 10.0)

    """
    c, s = np.asarray(cosine, dtype=float), np.asarray(sine, dtype=float)
    x, y = np.asarray(rate_x, dtype=float), np.asarray(rate_y, dtype=float)
    if c.size < 3:
        raise ValueError(f'{c.size} sectors: at least 3 are needed')
    w = np.ones(c.shape) if weights is None else np.asarray(weights, dtype=float)
    ones, zeros = np.ones(c.shape), np.zeros(c.shape)
    design = np.concatenate((np.stack((c, s, ones, zeros), 1), np.stack((-s, c, zeros, ones), 1)))
    both, root = np.concatenate((x, y)), np.sqrt(np.concatenate((w, w)))
    solution = np.linalg.lstsq(root[:, None] * design, root * both, rcond=None)[0]
    left = root * (both - design @ solution)
    residual = math.sqrt(float(left @ left) / float(root @ root))
    # Two equations a sector for four unknowns; the rates cancel over a full turn.
    scale = math.sqrt(c.size / max(c.size - 2.0, 1.0))
    return RotationFit(float(solution[2]), float(solution[3]), float(solution[0]),
                       float(solution[1]), residual,
                       scale * residual * math.sqrt(float(w @ w)) / float(w.sum()))


def azimuth_from_rates(rate_x: float, rate_y: float) -> float:
    """
    Return the azimuth of the platform from the Earth rate along its axes, radians.

    Parameters
    ----------
    rate_x, rate_y
        Horizontal Earth rate along x and y of the platform, in any unit.

    Returns
    -------
    float
        Azimuth of x, in (-pi, pi].

    References
    ----------
    S (8), S (9), with the quadrants of atan2. The rates are averaged before the angle is computed,
    because a mean of angles fails at +-180 degrees.

    Examples
    --------
    >>> round(math.degrees(azimuth_from_rates(0.0, -1.0)), 9)
    90.0

    """
    return math.atan2(-rate_y, rate_x)


def course_drift(angle: ArrayLike, step_s: float, method: str = 'lsq') -> tuple[float, float]:
    """
    Return the drift of an angle read at even intervals.

    Parameters
    ----------
    angle : array_like, shape (n,)
        Readings, at least 3; for 'pairs' an even number.
    step_s
        Interval of the readings, seconds.
    method : {'lsq', 'pairs'}
        Slope of the straight line, or mean of the slopes of successive pairs.

    Returns
    -------
    drift, residual : float
        Drift, in the unit of the angle per second; root mean square about the straight line.

    Raises
    ------
    ValueError
        If the readings are too few or the method is unknown.

    References
    ----------
    S (15) with the factor 1/3 that the printed sum lacks; the line has 3.4 times less noise for
    six readings with white errors.

    Examples
    --------
    >>> course_drift([0.0, 9.0, 18.0, 27.0, 36.0, 45.0], 90.0, 'pairs')[0]
    0.1

    """
    psi = np.asarray(angle, dtype=float)
    if method not in ('lsq', 'pairs'):
        raise ValueError(f"method = {method!r}: must be 'lsq' or 'pairs'")
    if psi.size < 3 or (method == 'pairs' and psi.size % 2):
        raise ValueError(f'{psi.size} readings: at least 3, and pairs need an even number')
    t = step_s * (np.arange(psi.size) - 0.5 * (psi.size - 1))
    slope = float(t @ psi) / float(t @ t)
    left = psi - psi.mean() - slope * t
    residual = math.sqrt(float(left @ left) / psi.size)
    if method == 'pairs':
        slope = float(np.mean(psi[1::2] - psi[0::2])) / step_s
    return slope, residual


def course_drift_sigma(reading: float, step_s: float, n: int, method: str = 'lsq') -> float:
    """
    Return the standard deviation of the drift of n readings with independent errors.

    Parameters
    ----------
    reading
        Standard deviation of a reading.
    step_s
        Interval of the readings, seconds.
    n
        Number of readings.
    method : {'lsq', 'pairs'}
        As for `course_drift`.

    Examples
    --------
    >>> round(course_drift_sigma(1.0, 2.0, 6) * 2.0 * math.sqrt(17.5), 9)
    1.0

    """
    if method == 'pairs':
        return reading * math.sqrt(4.0 / n) / step_s
    return reading * math.sqrt(12.0 / (n * (n * n - 1.0))) / step_s


def gps_drift(difference_1: float, difference_2: float, step_s: float) -> tuple[float, float]:
    """
    Return the mean offset and the drift of the heading from two satellite fixes.

    Parameters
    ----------
    difference_1, difference_2
        Indicated minus satellite heading at the two fixes, wrapped.
    step_s
        Time between them, seconds.

    Returns
    -------
    offset, drift : float
        Half the sum, and the difference per second.

    References
    ----------
    S (14), corrected: the half-sum printed as a drift is the offset.

    Examples
    --------
    >>> gps_drift(1.0, 3.0, 2.0)
    (2.0, 1.0)

    """
    return 0.5 * (difference_1 + difference_2), (difference_2 - difference_1) / step_s


def drift_correction(t_s: ArrayLike, difference: ArrayLike, corrected: ArrayLike,
                     method: str = 'rls') -> float:
    """
    Return the estimate of the course gyro drift after the newest satellite fix.

    Parameters
    ----------
    t_s : array_like, shape (n,)
        Times of the fixes, seconds, n >= 2.
    difference : array_like, shape (n,)
        Indicated minus satellite heading, continuous.
    corrected : array_like, shape (n,)
        Integral of the current drift estimate up to each fix: the amount that the corrections so
        far have added to the difference.
    method : {'rls', 'pair'}
        A line through all fixes with the corrections undone; or the current estimate, changed by
        half of the drift between the last two fixes.

    References
    ----------
    S (14). The indicated heading moves with minus (drift - estimate).

    """
    t, e, done = (np.asarray(v, dtype=float) for v in (t_s, difference, corrected))
    if method == 'rls':
        free = e - done
        at = t - t.mean()
        return -float(at @ free) / float(at @ at)
    step = t[-1] - t[-2]
    in_force: float = (done[-1] - done[-2]) / step
    return in_force - 0.5 * gps_drift(e[-2], e[-1], step)[1]


def accelerometer_bias(force: ArrayLike, step_s: float) -> float:
    """
    Return the bias of an accelerometer at rest from its first and second integrals.

    Parameters
    ----------
    force : array_like, shape (n,)
        Readings, each the mean over an interval, n >= 1.
    step_s
        Interval, seconds.

    Returns
    -------
    float
        Mean of 2 S / t^2 and V / t, in the unit of the readings.

    References
    ----------
    S (16)-(19). On a platform levelled by the same accelerometers the result is zero, whatever
    their bias: tilt and bias cannot be separated without turning the platform.

    Examples
    --------
    >>> round(accelerometer_bias([0.2] * 1000, 0.1), 12)
    0.2

    """
    a = np.asarray(force, dtype=float)
    t = step_s * a.size
    velocity = np.concatenate(([0.0], np.cumsum(a) * step_s))
    path = float(np.sum(0.5 * (velocity[:-1] + velocity[1:]))) * step_s
    return 0.5 * (2.0 * path / t**2 + float(velocity[-1]) / t)
