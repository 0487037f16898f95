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

"""Whether mean and variance stay the same within a run, and from run to run."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Sequence

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.declared_figures import figure

from .blocking import block_means, block_size

SIGNIFICANT = 0.01
"""Runs differ if the probability of their differences by chance is below this."""


@dataclass(frozen=True, slots=True)
class RunFigures:
    """
    The figures of one run that are compared with those of other runs.

    Attributes
    ----------
    mean_deg
        Mean difference, degrees.
    mean_variance_deg2
        Variance of that mean, allowing for correlation, square degrees.
    variance_deg2
        Variance of the differences, square degrees.
    nu
        Effective degrees of freedom of that variance.
    drift_order
        Order of the drift that the differences call for; None if unknown.

    """

    mean_deg: float
    mean_variance_deg2: float
    variance_deg2: float
    nu: float
    drift_order: int | None = None


@dataclass(frozen=True, slots=True)
class Homogeneity:
    """How far the runs agree with each other; keys of the JSON."""

    m: int = figure('runs compared', 'those with figures and a variance above zero; with fewer '
                    'than two, all figures below are null')
    weighted_mean_deg: float | None = figure('mean of the means, weighted by their uncertainties',
                                             default=None)
    q: float | None = figure("Cochran's statistic of equal means", default=None)
    q_p: float | None = figure('probability of one as large if the means are equal', default=None)
    birge_ratio: float | None = figure(
        'Birge ratio: above 1 the means scatter more than they should', '√(Q/(m−1))', default=None)
    between_variance_deg2: float | None = figure(
        'variance of the systematic error from run to run', default=None)
    bartlett: float | None = figure("Bartlett's statistic of equal variances", 'with effective '
                                    'degrees of freedom', default=None)
    bartlett_p: float | None = figure('probability of one as large if the variances are equal',
                                      default=None)
    means_equal: bool | None = figure('the means agree', 'the probability is at least 0.01; means '
                                      'that differ call for variant C', default=None)
    variances_equal: bool | None = figure('the variances agree', default=None)
    drift_orders: tuple[int, ...] | None = figure(
        'order of the drift of each run', 'GK assumes the same', absent='if one is unknown')


def examine_homogeneity(runs: Sequence[RunFigures]) -> Homogeneity:
    """
    Compare the means and the variances of runs.

    Parameters
    ----------
    runs
        Any number. Runs with zero variance are left out: their weight would be infinite.

    Returns
    -------
    Homogeneity

    References
    ----------
    Cochran 1937, Birge ratio; between-run variance by DerSimonian & Laird 1986; Bartlett 1937.
    GK assumes an ergodic process: the same form in every run. E.5 of ``docs/diagnostics.md``.

    Examples
    --------
    >>> two = [RunFigures(0.0, 0.01, 0.04, 20.0), RunFigures(0.2, 0.01, 0.04, 20.0)]
    >>> homogeneity = examine_homogeneity(two)
    >>> round(homogeneity.q, 9), round(homogeneity.between_variance_deg2, 9), homogeneity.bartlett
    (2.0, 0.01, 0.0)

    """
    runs = [r for r in runs if r.mean_variance_deg2 > 0.0 and r.variance_deg2 > 0.0
            and r.nu > 0.0]
    m = len(runs)
    if m < 2:
        return Homogeneity(m)
    weights = [1.0 / r.mean_variance_deg2 for r in runs]
    total = math.fsum(weights)
    mean = math.fsum(w * r.mean_deg for w, r in zip(weights, runs)) / total
    q = math.fsum(w * (r.mean_deg - mean) ** 2 for w, r in zip(weights, runs))
    spread = total - math.fsum(w * w for w in weights) / total
    between = max(0.0, (q - (m - 1)) / spread)
    nu = math.fsum(r.nu for r in runs)
    pooled = math.fsum(r.nu * r.variance_deg2 for r in runs) / nu
    correction = 1.0 + (math.fsum(1.0 / r.nu for r in runs) - 1.0 / nu) / (3.0 * (m - 1))
    bartlett = max(0.0, math.fsum(r.nu * math.log(pooled / r.variance_deg2) for r in runs)
                   / correction)
    q_p, bartlett_p = (float(scipy.special.chdtrc(m - 1, z)) for z in (q, bartlett))
    orders = [r.drift_order for r in runs if r.drift_order is not None]
    return Homogeneity(
        m=m, weighted_mean_deg=mean, q=q, q_p=q_p, birge_ratio=math.sqrt(q / (m - 1)),
        between_variance_deg2=between, bartlett=bartlett, bartlett_p=bartlett_p,
        means_equal=q_p >= SIGNIFICANT, variances_equal=bartlett_p >= SIGNIFICANT,
        drift_orders=tuple(orders) if len(orders) == m else None)


LEAST_SAMPLES = 64
"""Fewest samples for a test of stationarity: 16 blocks of four."""


@dataclass(frozen=True, slots=True)
class Arrangements:
    """
    Reverse arrangements of a few values: a trend gives too few or too many.

    Attributes
    ----------
    count
        Pairs whose earlier value is the larger one; equal ones count half.
    z
        Count minus its expectation, in standard deviations; positive if the values fall.
    p
        Two-sided probability of a deviation at least this large without a trend.

    """

    count: float
    z: float
    p: float


def count_arrangements(values: ArrayLike) -> Arrangements | None:
    """
    Test a few independent values for a trend.

    Parameters
    ----------
    values : array_like, shape (k,)
        Tens of values in time order; run time and memory grow with the square of k.

    Returns
    -------
    Arrangements or None
        None for fewer than 10 values, whose count is not normally distributed.

    References
    ----------
    Bendat & Piersol, *Random Data*: mean k (k - 1)/4, variance k (2k + 5)(k - 1)/72.

    Examples
    --------
    >>> count_arrangements(range(10)).count
    0.0

    """
    z = np.asarray(values, dtype=np.float64)
    k = z.size
    if k < 10:
        return None
    row, column = np.triu_indices(k, 1)
    count = (float(np.count_nonzero(z[row] > z[column]))
             + 0.5 * float(np.count_nonzero(z[row] == z[column])))
    deviation = (count - 0.25 * k * (k - 1)) / math.sqrt(k * (2 * k + 5) * (k - 1) / 72.0)
    return Arrangements(count, deviation, float(2.0 * scipy.special.ndtr(-abs(deviation))))


@dataclass(frozen=True, slots=True)
class Kpss:
    """
    Statistic of Kwiatkowski, Phillips, Schmidt & Shin for a constant level.

    Attributes
    ----------
    statistic
        Mean square of the cumulative deviations, divided by n times the long-run variance; 5 %
        of stationary series exceed 0.463.
    lags
        Lags of the Bartlett kernel.
    p
        Asymptotic probability of a statistic at least this large for a stationary series.

    """

    statistic: float
    lags: int
    p: float


def apply_kpss(values: ArrayLike) -> Kpss | None:
    """
    Test a series for a constant level.

    Parameters
    ----------
    values : array_like, shape (n,)
        In time order; here block means.

    Returns
    -------
    Kpss or None
        None for n < 20, or if the long-run variance is zero.

    Notes
    -----
    The number of lags is the integer part of 12 (n/100)^(1/4). The limiting distribution is that
    of the Cramer-von Mises statistic, the integral of a squared Brownian bridge.

    References
    ----------
    Kwiatkowski et al. 1992 (J. Econometrics 54, 159).

    """
    z = np.asarray(values, dtype=np.float64)
    n = z.size
    if n < 20 or float(z.max()) == float(z.min()):
        return None
    e = z - z.mean()
    lags = int(12.0 * (n / 100.0) ** 0.25)
    long_run = float(e @ e)
    for k in range(1, lags + 1):
        long_run += 2.0 * (1.0 - k / (lags + 1.0)) * float(e[k:] @ e[:-k])
    if long_run <= 0.0:
        return None
    walk = np.cumsum(e)
    statistic = float(walk @ walk) / (n * long_run)
    return Kpss(statistic, lags, _bridge_tail(statistic))


def _bridge_tail(value: float) -> float:
    """
    Return the probability that the integral of a squared Brownian bridge exceeds a value.

    By the series of Anderson & Darling 1952 (Ann. Math. Stat. 23, 193).
    """
    if value <= 0.0:
        return 1.0
    if value >= 6.0:
        # Less than exp(-pi^2 value / 2): below the rounding of the series.
        return 0.0
    j = np.arange(25.0)
    u = (4.0 * j + 1.0) ** 2 / (16.0 * value)
    logs = scipy.special.gammaln(j + 0.5) - scipy.special.gammaln(j + 1.0)
    terms = np.exp(logs - 2.0 * u) * np.sqrt(4.0 * j + 1.0) * scipy.special.kve(0.25, u)
    below: float = float(terms.sum()) / (math.pi ** 1.5 * math.sqrt(value))
    return min(1.0, max(0.0, 1.0 - below))


@dataclass(frozen=True, slots=True)
class Stationarity:
    """Whether the moments of a run are constant, judged from its blocks; keys of the JSON."""

    blocks: int = figure('blocks compared', 'for a trend, 16 to 31; 0 for fewer than 64 '
                         'differences, and then all below are null')
    block_s: float | None = figure('their length', default=None)
    mean_z: float | None = figure('trend of the mean, in its standard deviations',
                                  'reverse arrangements of the block means', default=None)
    mean_p: float | None = figure('its probability', default=None)
    square_z: float | None = figure('trend of the variance, in its standard deviations',
                                    'the same for the squared deviations', default=None)
    square_p: float | None = figure('its probability', default=None)
    kpss: float | None = figure('KPSS statistic of a constant level', 'on 64 to 127 block means; '
                                'null if these are all equal', default=None)
    kpss_lags: int | None = figure('lags that it allows for', default=None)
    kpss_p: float | None = figure('its probability', default=None)

    @property
    def least_p(self) -> float | None:
        """Smallest probability times the number of tests (Bonferroni); None if untested."""
        values = [p for p in (self.mean_p, self.square_p, self.kpss_p) if p is not None]
        return min(1.0, len(values) * min(values)) if values else None


def examine_stationarity(x_deg: ArrayLike, step_s: float) -> Stationarity:
    """
    Test whether mean and variance of the differences are constant within a run.

    Parameters
    ----------
    x_deg : array_like, shape (n,)
        Differences or residuals, in sample order, finite, degrees.
    step_s
        Time from sample to sample, seconds.

    Returns
    -------
    Stationarity

    Notes
    -----
    The blocks must be long compared with the correlation time of the errors. If the record is too
    short for that (`assumptions.resolved`), a slow error looks like a change of the mean.

    References
    ----------
    GK asks for moments that are constant within a run. E.4 of ``docs/diagnostics.md``.

    """
    x = np.asarray(x_deg, dtype=np.float64)
    size = block_size(x.size, 16)
    if x.size < LEAST_SAMPLES:
        return Stationarity(blocks=0)
    small, centre = block_size(x.size, 64), float(x.mean())
    parts = block_means(x, small) - centre
    means = block_means(parts, size // small)
    squares = np.array([float(np.mean((x[lo:lo + size] - centre) ** 2))
                        for lo in range(0, means.size * size, size)])
    by_mean, by_square = count_arrangements(means), count_arrangements(squares)
    level = apply_kpss(parts)
    return Stationarity(
        blocks=means.size, block_s=size * step_s,
        mean_z=by_mean.z if by_mean else None, mean_p=by_mean.p if by_mean else None,
        square_z=by_square.z if by_square else None, square_p=by_square.p if by_square else None,
        kpss=level.statistic if level else None, kpss_lags=level.lags if level else None,
        kpss_p=level.p if level else None)
