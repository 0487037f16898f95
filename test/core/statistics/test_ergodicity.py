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

"""Homogeneity of runs: by hand, against scipy, by false alarms, and in any order."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from heading_intercompare.core.statistics.stationarity import examine_homogeneity, RunFigures


def test_means_by_hand():
    """
    Means 0 and 3 with variances 1 and 4: weights 1 and 1/4, mean 0.6, Q = 0.36 + 5.76/4 = 1.8.

    Between: (1.8 - 1)/(1.25 - 1.0625/1.25) = 0.8/0.4 = 2.
    """
    found = examine_homogeneity([RunFigures(0.0, 1.0, 5.0, 10.0), RunFigures(3.0, 4.0, 5.0, 10.0)])
    assert found.m == 2
    assert found.weighted_mean_deg == pytest.approx(0.6)
    assert found.q == pytest.approx(1.8)
    assert found.q_p == pytest.approx(math.erfc(math.sqrt(0.9)))
    assert found.birge_ratio == pytest.approx(math.sqrt(1.8))
    assert found.between_variance_deg2 == pytest.approx(2.0)
    assert (found.bartlett, found.bartlett_p) == (0.0, 1.0)
    assert (found.means_equal, found.variances_equal) == (True, True)


def test_variances_agree_with_bartlett_of_scipy(rng):
    samples = [s * rng.standard_normal(n) for s, n in ((1.0, 20), (1.5, 35), (0.8, 12))]
    found = examine_homogeneity([RunFigures(0.0, 1.0, float(np.var(s, ddof=1)), s.size - 1.0)
                                 for s in samples])
    expected = stats.bartlett(*samples)
    assert found.bartlett == pytest.approx(expected.statistic, rel=1e-9)
    assert found.bartlett_p == pytest.approx(expected.pvalue, rel=1e-9)


def test_runs_of_one_process_are_seldom_called_different(rng):
    """400 campaigns of six runs; 17 are six standard errors above 1 %."""
    means, variances = 0, 0
    for _ in range(400):
        runs = [RunFigures(0.1 * rng.standard_normal(), 0.01, rng.chisquare(20.0) / 20.0, 20.0)
                for _ in range(6)]
        found = examine_homogeneity(runs)
        means += not found.means_equal
        variances += not found.variances_equal
    assert max(means, variances) < 17


def test_a_mean_that_changes_from_run_to_run_is_measured(rng):
    """200 runs: the variance between has relative standard error sqrt(2/199) (1 + 0.01/0.04)."""
    runs = [RunFigures(0.2 * rng.standard_normal() + 0.1 * rng.standard_normal(), 0.01, 1.0, 30.0)
            for _ in range(200)]
    found = examine_homogeneity(runs)
    assert found.means_equal is False
    assert found.between_variance_deg2 == pytest.approx(
        0.04, rel=6.0 * math.sqrt(2.0 / 199.0) * 1.25)


def test_the_order_of_the_runs_does_not_matter(rng):
    runs = [RunFigures(*np.abs(rng.standard_normal(3)), 20.0) for _ in range(5)]
    a, b = examine_homogeneity(runs), examine_homogeneity(runs[::-1])
    assert (b.q, b.bartlett) == pytest.approx((a.q, a.bartlett), rel=1e-12)


ONE, FROZEN = RunFigures(0.0, 1.0, 1.0, 20.0), RunFigures(0.0, 0.0, 0.0, 9.0)


@pytest.mark.parametrize('runs', [[], [ONE], [ONE, FROZEN]])
def test_fewer_than_two_runs_are_not_compared(runs):
    found = examine_homogeneity(runs)
    assert found.m == min(1, len(runs))
    assert (found.q, found.bartlett, found.means_equal) == (None, None, None)


def test_the_orders_of_the_drift_are_those_of_the_runs_compared():
    """A frozen run is not compared; one of unknown order leaves the constancy unknown."""
    runs = [RunFigures(0.0, 1.0, 1.0, 20.0, order) for order in (0, 2, 1)]
    assert examine_homogeneity([*runs, FROZEN]).drift_orders == (0, 2, 1)
    assert examine_homogeneity([*runs, ONE]).drift_orders is None
