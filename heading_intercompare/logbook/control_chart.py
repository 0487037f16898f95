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

"""
A control chart of run figures with a stated rate of false alarms, and since when they differ.

The chart learns from a baseline, the first k runs, and watches the runs after it. Its limits are
prediction limits: they allow for the baseline being short, for the uncertainty of each figure,
and for a correlation from run to run.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
import math

import numpy as np

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.records import Reals

LEAST_BASELINE = 8
"""Least number of runs in a baseline."""

#: Standard deviation of normal values over their median absolute deviation.
_SIGMA_OF_MAD = 1.482602218505602
#: Standardized values count at most this much in the sums, so one wild run is no lasting change.
_MOST = 3.0
#: The sums look for a shift of twice this many standard deviations.
_SLACK = 0.5
_MOST_CORRELATION = 0.8
#: Simulated charts; fewer of long ones, so that no design takes more than a second.
_PATHS, _LEAST_PATHS, _MOST_VALUES = 4000, 500, 4_000_000
_SEED = 20161019


@dataclass(frozen=True, slots=True)
class Design:
    """
    The numbers of a chart that follow from its rate of false alarms.

    Attributes
    ----------
    factor
        K: the limits are center ± K sigma.
    threshold
        H: a sum above it means a lasting change.

    """

    factor: float
    threshold: float


@dataclass(frozen=True, slots=True, eq=False)
class Chart:
    """
    A chart of the figures of runs.

    Attributes
    ----------
    center
        Median of the baseline.
    between
        Standard deviation from run to run beyond the uncertainties of the figures.
    correlation
        Correlation from run to run that the chart allows for, 0 to 0.8.
    low, high : ndarray, shape (n,)
        Limits of each run.
    outside : ndarray of bool, shape (n,)
        Runs after the baseline outside their limits.
    since
        Index of the first run of a lasting change; None if there is none.
    noticed
        Index of the run that showed it.
    baseline
        Number of runs k of the baseline.

    """

    center: float
    between: float
    correlation: float
    low: Reals
    high: Reals
    outside: np.ndarray
    since: int | None
    noticed: int | None
    baseline: int


def _estimate(x: Reals) -> tuple[Reals, Reals]:
    """Return center and standard deviation of the rows of an array, by medians."""
    center = np.median(x, axis=-1)
    mad = np.median(np.abs(x - center[..., None]), axis=-1)
    k = x.shape[-1]
    # In short samples the median deviation falls short by this much.
    return center, _SIGMA_OF_MAD * mad * k / (k - 0.8)


def estimate_correlation(z: Reals) -> float:
    """
    Return a cautious correlation from run to run of standardized values, within 0 and 0.8.

    Parameters
    ----------
    z : ndarray, shape (k,)
        Standardized values; they count at most ± 2.

    Notes
    -----
    r = Σ z_i z_(i+1) / Σ z_i², plus its bias (1 + 3 r) / k (Marriott & Pope 1954), plus its
    standard error 1 / sqrt(k). A correlation taken too small would give false alarms.

    """
    z = np.clip(z, -2.0, 2.0)
    squares = float(np.dot(z, z))
    if squares == 0.0:
        return 0.0
    r = float(np.dot(z[:-1], z[1:])) / squares
    bias, error = (1.0 + 3.0 * r) / len(z), 1.0 / math.sqrt(len(z))
    return min(max(r + bias + error, 0.0), _MOST_CORRELATION)


def _accumulate(z: Reals) -> tuple[Reals, Reals]:
    """
    Return the upper and lower sums of values along the last axis.

    S+_i = max(0, S+_(i-1) + z_i - 1/2), S-_i = max(0, S-_(i-1) - z_i - 1/2), from 0.
    """
    z = np.clip(z, -_MOST, _MOST)
    sums = np.zeros((2, *z.shape))
    up = down = np.zeros(z.shape[:-1])
    for i in range(z.shape[-1]):
        up = np.maximum(0.0, up + z[..., i] - _SLACK)
        down = np.maximum(0.0, down - z[..., i] - _SLACK)
        sums[0, ..., i], sums[1, ..., i] = up, down
    return sums[0], sums[1]


@lru_cache(maxsize=64)
def design_chart(baseline: int, ahead: int, correlation: float, runs_between: float) -> Design:
    """
    Find the limits and the threshold that give the stated rate of false alarms.

    Parameters
    ----------
    baseline
        Number of runs k of the baseline.
    ahead
        Number of runs n watched, at least 1.
    correlation
        Correlation rho of adjacent runs.
    runs_between
        A run that has not changed is outside its limits once in this number of runs, N.

    Returns
    -------
    Design

    Notes
    -----
    The figures are simulated: normal, stationary, x_i = rho x_(i-1) + sqrt(1 - rho²) e_i. Each
    simulated chart estimates its center c and sigma s from its own k values, as `make_chart` does.

    * K solves E[Phi(c - K s) + 1 - Phi(c + K s)] = 1 / N over the simulated baselines: the chance
      that a new run of an unchanged sensor is outside.
    * H is the quantile of the largest sum of the n values watched at the probability
      (1 - 1/N)^n. So a chart of n runs shows a lasting change that is none with the probability
      1 - (1 - 1/N)^n, like n runs at the rate of one in N.

    The seed is fixed, so the same runs always give the same chart.

    References
    ----------
    Page 1954 for the sums; the prediction interval for a single future value.

    """
    paths = min(_PATHS, max(_LEAST_PATHS, _MOST_VALUES // (baseline + ahead)))
    rng = np.random.default_rng(_SEED)
    x = rng.standard_normal((baseline + ahead, paths))
    for i in range(1, len(x)):
        x[i] = correlation * x[i - 1] + math.sqrt(1.0 - correlation ** 2) * x[i]
    x = x.T
    center, sigma = _estimate(x[:, :baseline])
    phi = scipy.special.ndtr

    def excess(factor: float) -> float:
        width = factor * sigma
        return float(np.mean(phi(center - width) + phi(-center - width))) - 1.0 / runs_between

    factor = float(scipy.optimize.brentq(excess, 0.0, 1000.0))
    sums = _accumulate((x[:, baseline:] - center[:, None]) / sigma[:, None])
    largest = np.maximum(*sums).max(axis=1)
    return Design(factor, float(np.quantile(largest, (1.0 - 1.0 / runs_between) ** ahead)))


def make_chart(x: Reals, u: Reals, *, baseline: int = 20, runs_between: float = 370.0) -> Chart:
    """
    Compare each run after a baseline with that baseline.

    Parameters
    ----------
    x, u : ndarray, shape (n,)
        Figures of the runs in the order of time, and their standard uncertainties.
    baseline
        Number of runs k to learn from, at least 8.
    runs_between
        False alarms: one in this number of runs.

    Raises
    ------
    ValueError
        If the baseline is shorter than 8, or there are not more runs than that.

    Notes
    -----
    With c the median and s the standard deviation by the median deviation of the baseline:
    between² = max(0, s² - median u²), sigma_i² = between² + u_i², limits c ± K sigma_i. A run
    that is known less well has wider limits. Where the uncertainties make up much of the scatter,
    there are fewer false alarms than stated.

    The sums add z_i = (x_i - c) / sigma_i after the baseline. A lasting change began with the run
    after the last zero of the sum that exceeds H.

    """
    if baseline < LEAST_BASELINE:
        raise ValueError(f'baseline = {baseline}: must be at least {LEAST_BASELINE} runs')
    ahead = len(x) - baseline
    if ahead < 1:
        raise ValueError(f'{len(x)} runs: a chart needs more than its baseline of {baseline}')
    learned = x[:baseline]
    center, scale = (float(v) for v in _estimate(learned))
    own2 = float(np.median(u[:baseline] ** 2))
    between2 = max(0.0, scale ** 2 - own2)
    sigma = np.sqrt(between2 + u ** 2)
    # Equal figures without an uncertainty leave no scale: any other figure differs.
    sigma = np.maximum(sigma, np.finfo(float).tiny)
    z = (x - center) / sigma
    correlation = estimate_correlation(z[:baseline])
    # Round up, so that one design serves many charts.
    design = design_chart(baseline, ahead, math.ceil(20.0 * correlation) / 20.0, runs_between)
    width = design.factor * sigma
    outside = np.abs(x - center) > width
    outside[:baseline] = False
    since = noticed = None
    for sums in _accumulate(z[baseline:]):
        above = np.flatnonzero(sums > design.threshold)
        if above.size and (noticed is None or baseline + above[0] < noticed):
            noticed = baseline + int(above[0])
            zeros = np.flatnonzero(sums[:above[0]] == 0.0)
            since = baseline + (int(zeros[-1]) + 1 if zeros.size else 0)
    return Chart(center=center, between=math.sqrt(between2), correlation=correlation,
                 low=center - width, high=center + width, outside=outside, since=since,
                 noticed=noticed, baseline=baseline)
