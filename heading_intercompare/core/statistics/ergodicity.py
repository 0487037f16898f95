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

"""Whether several runs are records of one process: their means, and their variances."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Sequence

import scipy

from heading_intercompare.core.declared_figures import figure

__all__ = ['examine_homogeneity', 'Homogeneity', 'RunFigures']

SIGNIFICANT = 0.01
"""Runs differ if the probability of their differences by chance is below this."""


@dataclass(frozen=True, slots=True)
class RunFigures:
    """
    The figures of one run that are compared with those of other runs.

    Attributes
    ----------
    mean_deg : float
        Mean difference, degrees.
    mean_variance_deg2 : float
        Variance of that mean, allowing for correlation, square degrees.
    variance_deg2 : float
        Variance of the differences, square degrees.
    nu : float
        Effective degrees of freedom of that variance.
    drift_order : int or None
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
    variances_equal: bool | None = figure(
        'the variances agree', 'the probability is at least 0.01', default=None)
    drift_orders: tuple[int, ...] | None = figure('order of the drift of each run',
                                                  'GK assumes the same in every run',
                                                  absent='if one is unknown')


def examine_homogeneity(runs: Sequence[RunFigures]) -> Homogeneity:
    """
    Compare the means and the variances of runs.

    Parameters
    ----------
    runs : sequence of RunFigures
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
    return Homogeneity(m, mean, q, q_p, math.sqrt(q / (m - 1)), between, bartlett, bartlett_p,
                       q_p >= SIGNIFICANT, bartlett_p >= SIGNIFICANT,
                       tuple(orders) if len(orders) == m else None)
