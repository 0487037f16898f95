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

"""Tests whether values are normal, at their effective number of independent values."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.angles import unwrap_deg, wrap180
from heading_intercompare.core.declared_figures import figure

from .autocorrelation import effective_size, sokal_times
from .blocking import pick_stretches
from .resolution import find_resolution, find_step_seen, Resolution

#: Few enough that BLAS stays in one thread.
_PIECE = 1 << 13
_LEAST = 8


@dataclass(frozen=True, slots=True)
class Shape:
    """Skewness and kurtosis of values, and how unlikely they are for normal values."""

    n: int = figure('values')
    n_effective: float = figure('independent values they are worth for the shape')
    std_deg: float | None = figure('standard deviation', 'null for n < 2', default=None)
    skewness: float | None = figure('skewness', '0 for normal values; null, like all below, for '
                                    'fewer than 8 values or equal ones', default=None)
    excess_kurtosis: float | None = figure(
        'excess kurtosis', '0 for normal values, −1.2 for uniform ones', default=None)
    skewness_z: float | None = figure(
        'skewness, in its standard deviations', 'for `n_effective` normal values', default=None)
    kurtosis_z: float | None = figure('excess kurtosis, in its standard deviations',
                                      'for `n_effective` normal values', default=None)
    jarque_bera: float | None = figure('Jarque-Bera statistic', default=None)
    p: float | None = figure('its probability', default=None)


def measure_shape(values: ArrayLike, n_effective: float | None = None) -> Shape:
    """
    Test values for normality by their third and fourth moments.

    Parameters
    ----------
    values : array_like, shape (n,)
        Finite, degrees.
    n_effective
        Number of independent values they are equivalent to; default n. Hundreds of thousands
        of correlated values never pass as normal at their full number.

    Returns
    -------
    Shape

    References
    ----------
    z_1 = g_1/sqrt(6/nu), z_2 = g_2/sqrt(24/nu), chi-square with two degrees of freedom: Jarque &
    Bera 1987; for correlated values Bai & Ng 2005 (JBES 23, 49). E.6 of ``docs/diagnostics.md``.

    """
    x = np.asarray(values, dtype=np.float64)
    n = x.size
    nu = float(n if n_effective is None else n_effective)
    if n < 2:
        return Shape(n, nu)
    first = float(x[0])
    mean = first + math.fsum(float((x[lo:lo + _PIECE] - first).sum())
                             for lo in range(0, n, _PIECE)) / n
    m2 = m3 = m4 = 0.0
    for lo in range(0, n, _PIECE):
        e = x[lo:lo + _PIECE] - mean
        e2 = e * e
        m2 += float(e @ e)
        m3 += float(e @ e2)
        m4 += float(e2 @ e2)
    std = math.sqrt(m2 / (n - 1))
    if n < _LEAST or m2 / n <= (1e-13 * (1.0 + abs(mean))) ** 2:
        return Shape(n, nu, std)
    m2, m3, m4 = m2 / n, m3 / n, m4 / n
    g1, g2 = m3 / (m2 * math.sqrt(m2)), m4 / (m2 * m2) - 3.0
    z1, z2 = g1 * math.sqrt(nu / 6.0), g2 * math.sqrt(nu / 24.0)
    jb = z1 * z1 + z2 * z2
    return Shape(n=n, n_effective=nu, std_deg=std, skewness=g1, excess_kurtosis=g2, skewness_z=z1,
                 kurtosis_z=z2, jarque_bera=jb, p=math.exp(-0.5 * jb))


@dataclass(frozen=True, slots=True)
class AndersonDarling:
    """
    Distance of values from the normal distribution with their mean and standard deviation.

    Attributes
    ----------
    statistic, adjusted
        A^2, and A^2 (1 + 0.75/n + 2.25/n^2).
    p
        Probability of a distance at least this large for independent normal values.

    """

    statistic: float
    adjusted: float
    p: float


def apply_anderson_darling(values: ArrayLike) -> AndersonDarling | None:
    """
    Test independent values for normality by their whole distribution.

    Parameters
    ----------
    values : array_like, shape (n,)
        Finite; thin correlated ones first, see `thin`.

    Returns
    -------
    AndersonDarling or None
        None for n < 8, or if all values are equal.

    References
    ----------
    Anderson & Darling 1954; p by Stephens (D'Agostino & Stephens 1986, table 4.9).

    """
    x = np.sort(np.asarray(values, dtype=np.float64))
    n = x.size
    if n < _LEAST or x[-1] == x[0]:
        return None
    z = (x - x.mean()) / x.std(ddof=1)
    odd = 2.0 * np.arange(1, n + 1) - 1.0
    logs = scipy.special.log_ndtr(z) + scipy.special.log_ndtr(-z[::-1])
    statistic = -n - float(np.mean(odd * logs))
    a = statistic * (1.0 + 0.75 / n + 2.25 / (n * n))
    if a >= 10.0:
        p = 3.7e-24
    elif a >= 0.6:
        p = math.exp(1.2937 - 5.709 * a + 0.0186 * a * a)
    elif a >= 0.34:
        p = math.exp(0.9177 - 4.279 * a - 1.38 * a * a)
    elif a >= 0.2:
        p = 1.0 - math.exp(-8.318 + 42.796 * a - 59.938 * a * a)
    else:
        p = 1.0 - math.exp(-13.436 + 101.14 * a - 223.73 * a * a)
    return AndersonDarling(statistic, a, p)


def thin(values: ArrayLike, tau: float | None = None) -> tuple[np.ndarray, int]:
    """Return every k-th value, and k: Sokal's correlation time, known or not, rounded up."""
    x = np.asarray(values, dtype=np.float64)
    step = max(1, math.ceil(sokal_times(x).tau_1 if tau is None else tau))
    return x[::step], step


def symmetric_difference(heading_deg: ArrayLike) -> np.ndarray:
    """
    Return the symmetric first differences of a heading.

    Parameters
    ----------
    heading_deg : array_like, shape (n,)
        Headings in stamp order, degrees.

    Returns
    -------
    ndarray, shape (max(n - 2, 0),)
        Each reading minus the one after the next, wrapped. White noise of standard deviation s
        gives s sqrt(2); slow changes of the heading nearly cancel.

    References
    ----------
    GK, checking the error models: theta_{i-1} - theta_{i+1}.

    """
    heading = np.asarray(heading_deg, dtype=np.float64)
    return wrap180(heading[:-2] - heading[2:])


def moving_average_residual(heading_deg: ArrayLike, width: int) -> np.ndarray:
    """
    Return a heading minus its centred moving average.

    Parameters
    ----------
    heading_deg : array_like, shape (n,)
        Headings in stamp order, degrees; they are unwrapped before averaging.
    width
        Readings per average, odd, at least 3.

    Returns
    -------
    ndarray, shape (max(n - width + 1, 0),)
        White noise of standard deviation s gives s sqrt(1 - 1/width).

    Raises
    ------
    ValueError
        If the width is even or below 3.

    References
    ----------
    GK, checking the error models.

    """
    if width < 3 or width % 2 == 0:
        raise ValueError(f'width = {width!r}: must be odd and at least 3')
    heading = unwrap_deg(heading_deg)
    if heading.size < width:
        return np.empty(0)
    heading -= heading[0]
    sums = np.concatenate(([0.0], np.cumsum(heading)))
    result = heading[width // 2:heading.size - width // 2]
    result -= (sums[width:] - sums[:-width]) / width
    return result


@dataclass(frozen=True, slots=True)
class Normality:
    """The normality of a run; keys of the JSON."""

    difference: Shape = figure('differences', 'at their effective size')
    thinned_step: int = figure('step between nearly independent differences', unit='readings')
    thinned_n: int = figure('number of these')
    anderson_darling: float | None = figure('Anderson-Darling statistic of these',
                                            'null for fewer than 8, or equal ones')
    anderson_darling_p: float | None = figure('its probability')
    ts_first_difference: Shape = figure('change of the TS', 'θ(i−1) − θ(i+1)')
    rs_first_difference: Shape = figure('change of the RS', 'θ(i−1) − θ(i+1)')
    ts_moving_average: Shape = figure('TS about its moving average')
    rs_moving_average: Shape = figure('RS about its moving average')
    moving_average_width: int = figure('width of the moving average', 'about 1 s', unit='readings')
    ts_step_deg: float | None = figure(
        'resolution of the TS', 'as paired; null if there is none, as for an interpolated sensor')
    rs_step_deg: float | None = figure('resolution of the RS', 'as paired')
    ts_repeated_share: float | None = figure('share of TS readings equal to the one before')
    rs_repeated_share: float | None = figure('share of RS readings equal to the one before')
    rounding_variance_deg2: float = figure('variance that rounding adds', 'it is not subtracted')
    ts_step_seen_deg: float = figure('coarsest step of the TS whose rounding would show',
                                     'by the motion that the RS saw, E.28; 0 if none would')
    rs_step_seen_deg: float = figure('coarsest step of the RS whose rounding would show')


def examine_normality(x_deg: ArrayLike, ts_deg: ArrayLike, rs_deg: ArrayLike, *,
                      n_effective: float, tau: float | None = None,
                      width: int = 3) -> Normality:
    """
    Test the normality of a run.

    Parameters
    ----------
    x_deg, ts_deg, rs_deg : array_like, shape (n,)
        Differences or their residuals, and headings, in sample order, finite, degrees.
    n_effective
        Effective size of the differences.
    tau
        Sokal's correlation time of the differences, if already known, in samples.
    width
        Readings per moving average, odd, at least 3.

    Returns
    -------
    Normality

    Notes
    -----
    Of more than 262144 headings, only 16 stretches of 16384 each, spread over the run, are used.

    References
    ----------
    GK asks for normality of the differences, of symmetric first differences, and of headings
    minus a moving average. Effective sizes instead of n: Bai & Ng 2005.

    """
    few, step = thin(x_deg, tau)
    distance = apply_anderson_darling(few)
    sensors = [_examine_sensor(np.asarray(h, dtype=np.float64), width) for h in (ts_deg, rs_deg)]
    (ts_first, ts_average, ts_step), (rs_first, rs_average, rs_step) = sensors
    return Normality(
        difference=measure_shape(x_deg, n_effective), thinned_step=step, thinned_n=few.size,
        anderson_darling=distance.adjusted if distance else None,
        anderson_darling_p=distance.p if distance else None, ts_first_difference=ts_first,
        rs_first_difference=rs_first, ts_moving_average=ts_average, rs_moving_average=rs_average,
        moving_average_width=width, ts_step_deg=ts_step.step_deg, rs_step_deg=rs_step.step_deg,
        ts_repeated_share=ts_step.repeated_share, rs_repeated_share=rs_step.repeated_share,
        rounding_variance_deg2=ts_step.variance_deg2 + rs_step.variance_deg2,
        ts_step_seen_deg=find_step_seen(rs_deg), rs_step_seen_deg=find_step_seen(ts_deg))


def _examine_sensor(heading_deg: np.ndarray, width: int) -> tuple[Shape, Shape, Resolution]:
    parts = [heading_deg[stretch] for stretch in pick_stretches(heading_deg.size)]
    first = np.concatenate([symmetric_difference(h) for h in parts])
    average = np.concatenate([moving_average_residual(h, width) for h in parts])
    return (measure_shape(first, effective_size(first)),
            measure_shape(average, effective_size(average)),
            find_resolution(heading_deg))
