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

The chart learns from a baseline, the first k runs, and then from each run that it has judged,
until a change is noticed. Its limits are prediction limits: they allow for the baseline being
short, for the uncertainty of each figure, and for a correlation from run to run.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
import math
from pathlib import Path
from typing import Any, Callable

import numpy as np

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.records import Reals
from heading_intercompare.core.statistics import root_finding

from .design_file import find_place, read_design, write_design

LEAST_BASELINE = 8
"""Least number of runs in a baseline."""

#: Standard deviation of normal values over their median absolute deviation.
_SIGMA_OF_MAD = 1.482602218505602
#: Standardized values count at most this much in the sums, so one wild run is no lasting change.
_MOST = 3.0
#: The sums look for a shift of twice this many standard deviations.
_SLACK = 0.5
_MOST_CORRELATION = 0.8
#: Equal figures without an uncertainty leave no scale: any other figure differs.
_TINY = float(np.finfo(float).tiny)
#: A chart learns of standardized values up to this, and the mean square of such normal values.
_MOST_LEARNED, _MEAN_SQUARE = 2.0, 0.920540
#: Limits are found at this many runs that are spread over those watched.
_RUNS_OF_LIMITS = 12
#: Simulated charts: so many that some ten of them have a sum above the threshold.
_LEAST_PATHS, _MOST_PATHS, _ABOVE = 4000, 40_000, 10
_SEED = 20161019


@dataclass(frozen=True, slots=True)
class Design:
    """
    The numbers of a chart that follow from its rate of false alarms.

    Attributes
    ----------
    step
        Runs from one factor to the next; the first one is that of the first run watched.
    factors
        K: the limits are center ± K sigma. It falls as the chart learns.
    threshold
        H: a sum above it means a lasting change.

    """

    step: int
    factors: tuple[float, ...]
    threshold: float

    def factors_of(self, n: int, baseline: int) -> Reals:
        """Return K of n runs, the baseline among them."""
        at = baseline + self.step * np.arange(len(self.factors))
        return np.interp(np.arange(n), at, self.factors)


@dataclass(frozen=True, slots=True)
class Change:
    """
    A lasting change.

    Attributes
    ----------
    since, noticed
        Indices of its first run, and of the run that showed it.
    until
        Index of its last run; None if it has not ended.

    """

    since: int
    noticed: int
    until: int | None


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
    changes
        Lasting changes, in the order in which they were noticed.
    baseline
        Number of runs k of the baseline.

    """

    center: float
    between: float
    correlation: float
    low: Reals
    high: Reals
    outside: np.ndarray
    changes: tuple[Change, ...]
    baseline: int

    @property
    def lasting(self) -> Change | None:
        """Return the change that has not ended, the earliest of two; None if there is none."""
        return min((change for change in self.changes if change.until is None),
                   key=lambda change: change.since, default=None)


def _estimate(x: Reals) -> tuple[Reals, Reals]:
    """Return center and standard deviation of the columns of an array, by medians."""
    center = np.median(x, axis=0)
    mad = np.median(np.abs(x - center), axis=0)
    k = len(x)
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


def _learn(center: Any, variance: Any, y: Any, sigma: Any, n: int) -> tuple[Any, Any]:
    """
    Return center and variance after a run, the n-th one.

    c + sigma y / n and v (1 + (y² / 0.9205 - 1) / n) with y its standardized value, but within
    ± 2: running means, and a wild run counts little.
    """
    return (center + sigma * y / n,
            variance * (1.0 + (y * y / _MEAN_SQUARE - 1.0) / n))


class _Sum:
    """
    The sum that looks for a change upwards.

    S_i = max(0, S_(i-1) + z_i - 1/2), from 0, and at most the threshold H. A change is noticed
    when S would exceed H, began with the run after the last zero, and ended with the last run at
    which S would exceed H before the next zero. The bound of S lets it come back to zero after a
    false alarm, so that it hides no true change.
    """

    def __init__(self, threshold: float, begin: int) -> None:
        self._threshold = threshold
        self._total, self._since = 0.0, begin
        self._above: list[int] = []
        self.changes: list[Change] = []

    @property
    def open_change(self) -> Change | None:
        """Return the change that has not ended."""
        return Change(self._since, self._above[0], None) if self._above else None

    def add(self, at: int, z: float) -> None:
        """Take the standardized value of a run."""
        self._total = max(0.0, self._total + min(max(z, -_MOST), _MOST) - _SLACK)
        if self._total > self._threshold:
            self._above.append(at)
            self._total = self._threshold
        if self._total == 0.0:
            if self._above:
                self.changes.append(Change(self._since, self._above[0], self._above[-1]))
            self._since, self._above = at + 1, []


def round_to_two_digits(n: int, towards: Callable[[float], int]) -> int:
    """Return a number of runs with two digits that count, so that a design serves many charts."""
    unit: int = 10 ** max(0, len(str(n)) - 2)
    return towards(n / unit) * unit


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
    simulated chart estimates its center c and sigma s from its own values, as `make_chart` does.

    * K of a run solves E[Phi(c - K s) + 1 - Phi(c + K s)] = 1 / N over the simulated charts: the
      chance that a run of an unchanged sensor is outside. It is found at some 12 of the runs.
    * H is the quantile of the largest sum of the n values watched at the probability
      (1 - 1/N)^n. So a chart of n runs shows a lasting change that is none with the probability
      1 - (1 - 1/N)^n, like n runs at the rate of one in N.

    The seed is fixed, so the same runs always give the same chart. A design that was simulated
    before is read from the disk.

    References
    ----------
    Page 1954 for the sums; the prediction interval for a single future value.

    """
    code = b''.join(Path(file).read_bytes() for file in (__file__, root_finding.__file__))
    place = find_place(code, (baseline, ahead, correlation, runs_between))
    if (numbers := read_design(place)) is not None:
        return Design(*numbers)
    design = _simulate(baseline, ahead, correlation, runs_between)
    write_design(place, design.step, design.factors, design.threshold)
    return design


def _simulate(baseline: int, ahead: int, correlation: float, runs_between: float) -> Design:
    chance = 1.0 - (1.0 - 1.0 / runs_between) ** ahead
    paths = min(_MOST_PATHS, max(_LEAST_PATHS, int(_ABOVE / chance)))
    rng = np.random.default_rng(_SEED)
    innovation = math.sqrt(1.0 - correlation ** 2)
    x = rng.standard_normal((baseline, paths))
    for i in range(1, baseline):
        x[i] = correlation * x[i - 1] + innovation * x[i]
    center, sigma = _estimate(x)
    newest, variance = x[-1], sigma ** 2
    up = down = largest = np.zeros(paths)
    step = max(1, ahead // _RUNS_OF_LIMITS)
    factors = []
    for i in range(ahead):
        if i % step == 0:
            factors.append(_find_factor(center[:_LEAST_PATHS], sigma[:_LEAST_PATHS],
                                        1.0 / runs_between))
        newest = correlation * newest + innovation * rng.standard_normal(paths)
        standardized = (newest - center) / sigma
        z = np.clip(standardized, -_MOST, _MOST)
        up = np.maximum(0.0, up + z - _SLACK)
        down = np.maximum(0.0, down - z - _SLACK)
        largest = np.maximum(largest, np.maximum(up, down))
        learned = np.clip(standardized, -_MOST_LEARNED, _MOST_LEARNED)
        center, variance = _learn(center, variance, learned, sigma, baseline + i + 1)
        sigma = np.sqrt(variance)
    return Design(step, tuple(factors), float(np.quantile(largest, 1.0 - chance)))


def _find_factor(center: Reals, sigma: Reals, share: float) -> float:
    """Return K with that share of standard normal values outside center ± K sigma."""
    phi = scipy.special.ndtr

    def excess(factor: float) -> float:
        width = factor * sigma
        return float(np.mean(phi(center - width) + phi(-center - width))) - share

    return root_finding.find_root(excess, 0.0, 1000.0)


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
    In the baseline c is the median, and s the standard deviation by the median deviation. With
    w² the median of u² there, between² = max(0, s² - w²), sigma_i² = between² + u_i², limits
    c ± K sigma_i. A run that is known less well has wider limits. Where the uncertainties make up
    much of the scatter, there are fewer false alarms than stated.

    After the baseline c and s² are running means, see `_learn`, so that a short baseline costs no
    power later. While a change lasts they stay as they were before it.

    The sums, one upwards and one downwards, add z_i = (x_i - c) / sigma_i after the baseline.

    """
    if baseline < LEAST_BASELINE:
        raise ValueError(f'baseline = {baseline}: must be at least {LEAST_BASELINE} runs')
    ahead = len(x) - baseline
    if ahead < 1:
        raise ValueError(f'{len(x)} runs: a chart needs more than its baseline of {baseline}')
    center, scatter = (float(v) for v in _estimate(x[:baseline]))
    own2 = float(np.median(u[:baseline] ** 2))
    between2, variance = max(0.0, scatter ** 2 - own2), scatter ** 2
    sigma = np.maximum(np.sqrt(between2 + u ** 2), _TINY)
    correlation = estimate_correlation((x[:baseline] - center) / sigma[:baseline])
    # Rounded to the safe side, so that one design serves many charts.
    design = design_chart(
        round_to_two_digits(baseline, math.floor), round_to_two_digits(ahead, math.ceil),
        math.ceil(20.0 * correlation) / 20.0, runs_between)
    centers, variances = [center] * baseline, [variance] * baseline
    sums = (_Sum(design.threshold, baseline), _Sum(design.threshold, baseline))
    # Floats of Python: a loop with numbers of numpy takes ten times as long.
    for at, (figure, u2) in enumerate(zip(x[baseline:].tolist(), (u[baseline:] ** 2).tolist()),
                                      baseline):
        centers.append(center)
        variances.append(variance)
        scale = max(math.sqrt(max(0.0, variance - own2) + u2), _TINY)
        z = (figure - center) / scale
        sigma[at] = scale
        sums[0].add(at, z)
        sums[1].add(at, -z)
        since = min((c.since for s in sums if (c := s.open_change)), default=None)
        if since is None:
            center, variance = _learn(
                center, variance, min(max(z, -_MOST_LEARNED), _MOST_LEARNED), scale, at + 1)
        else:
            center, variance = centers[since], variances[since]
    width = design.factors_of(len(x), baseline) * sigma
    middles = np.array(centers)
    outside = np.abs(x - middles) > width
    outside[:baseline] = False
    changes = [*sums[0].changes, *sums[1].changes, *(c for s in sums if (c := s.open_change))]
    return Chart(center=float(np.median(x[:baseline])),
                 between=math.sqrt(between2), correlation=correlation,
                 low=middles - width, high=middles + width, outside=outside,
                 changes=tuple(sorted(changes, key=lambda change: change.noticed)),
                 baseline=baseline)
