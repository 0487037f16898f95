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

"""Stationarity: by hand, against scipy and published quantiles, and by false alarms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import kendalltau

from heading_intercompare.core.statistics.stationarity import (
    _bridge_tail,
    apply_kpss,
    count_arrangements,
    examine_stationarity,
)

# --- reverse arrangements ---

def test_reverse_arrangements_by_hand():
    """Ten falling values: 45 pairs, expected 22.5, variance 10 25 9/72 = 31.25."""
    found = count_arrangements(range(10, 0, -1))
    assert found.count == 45
    assert found.z == pytest.approx(22.5 / math.sqrt(31.25))
    assert found.p == pytest.approx(math.erfc(22.5 / math.sqrt(62.5)))


def test_the_count_is_that_of_kendall(rng):
    """The tau of Kendall is 1 - 4 A/(k (k - 1)) for values against their order."""
    z = rng.standard_normal(25)
    tau = kendalltau(np.arange(25), z).statistic
    assert count_arrangements(z).count == pytest.approx((1.0 - tau) * 25 * 24 / 4.0)


def test_equal_values_have_no_trend():
    assert count_arrangements(np.full(20, 0.3)).z == 0.0


def test_the_statistic_depends_on_the_order_of_the_values_alone(rng):
    z = rng.standard_normal(30)
    assert count_arrangements(z) == count_arrangements(np.exp(z))
    assert count_arrangements(z[::-1]).z == pytest.approx(-count_arrangements(z).z)


def test_no_reverse_arrangements_of_too_few_values():
    assert count_arrangements([]) is None
    assert count_arrangements(range(9)) is None


# --- KPSS ---

@pytest.mark.parametrize('statistic, p', [(0.34730, 0.10), (0.46136, 0.05), (0.58061, 0.025),
                                          (0.74346, 0.01)])
def test_the_limit_distribution_has_its_published_quantiles(statistic, p):
    """Anderson & Darling 1952, table of the integral of a squared Brownian bridge."""
    assert _bridge_tail(statistic) == pytest.approx(p, rel=2e-4)


def test_the_limit_distribution_agrees_with_its_product_form(rng):
    """The integral is sum of z_k^2/(k pi)^2; 200 000 draws, six standard errors."""
    draws = np.zeros(200_000)
    for k in range(1, 60):
        draws += rng.standard_normal(draws.size) ** 2 / (k * math.pi) ** 2
    draws += np.sum(1.0 / (np.arange(60, 100_000) * math.pi) ** 2)
    for value in (0.05, 0.12, 0.3, 0.8):
        p = _bridge_tail(value)
        assert np.mean(draws > value) == pytest.approx(
            p, abs=6.0 * math.sqrt(p * (1.0 - p) / draws.size))


def test_kpss_agrees_with_its_definition(rng):
    z = 3.0 + rng.standard_normal(80)
    e = z - z.mean()
    lags = int(12 * (80 / 100) ** 0.25)
    gamma = [np.sum(e[k:] * e[:80 - k]) / 80 for k in range(lags + 1)]
    long_run = gamma[0] + 2 * sum((1 - k / (lags + 1)) * gamma[k] for k in range(1, lags + 1))
    found = apply_kpss(z)
    assert found.lags == lags
    assert found.statistic == pytest.approx(np.sum(np.cumsum(e) ** 2) / 80 ** 2 / long_run)


def test_a_step_is_no_constant_level(rng):
    """The kernel mistakes most of a step for long memory: even without noise p is 0.011."""
    z = rng.standard_normal(100) + 3.0 * (np.arange(100) >= 50)
    assert apply_kpss(z).p < 0.05


def test_kpss_depends_neither_on_level_nor_on_scale(rng):
    z = rng.standard_normal(70)
    assert apply_kpss(5.0 - 3.0 * z).statistic == pytest.approx(apply_kpss(z).statistic)


def test_no_kpss_of_too_few_or_equal_values():
    assert apply_kpss([]) is None
    assert apply_kpss(np.arange(19.0)) is None
    assert apply_kpss(np.full(50, 0.1)) is None


# --- a run ---

def test_stationary_errors_are_seldom_called_otherwise(ar1):
    """At 1 % of the Bonferroni p; 17 of 400 would be six standard errors too many."""
    low = sum(examine_stationarity(ar1(4000, 5.0), 1.0).least_p < 0.01 for _ in range(400))
    assert low < 17


def test_a_trend_of_the_mean_is_seen(ar1):
    found = examine_stationarity(ar1(4000, 5.0) + np.linspace(-2.0, 2.0, 4000), 0.5)
    assert found.mean_p < 0.001
    assert found.mean_z < 0.0
    assert found.kpss_p < 0.01
    assert (found.blocks, found.block_s) == (31, 64.0)


def test_a_growing_variance_is_seen(ar1):
    found = examine_stationarity(ar1(4000, 5.0) * np.linspace(1.0, 3.0, 4000), 1.0)
    assert found.square_p < 0.001
    assert found.mean_p > 0.001


def test_the_level_of_the_differences_does_not_matter(rng):
    x = rng.standard_normal(1000)
    a, b = examine_stationarity(x, 1.0), examine_stationarity(x + 179.0, 1.0)
    assert b.square_z == pytest.approx(a.square_z)
    assert b.kpss == pytest.approx(a.kpss, rel=1e-9)


@pytest.mark.parametrize('n', [0, 1, 63])
def test_too_few_samples_are_not_tested(n):
    found = examine_stationarity(np.zeros(n), 1.0)
    assert (found.blocks, found.mean_p, found.kpss, found.least_p) == (0, None, None, None)


def test_equal_samples_have_no_trend_and_no_kpss():
    found = examine_stationarity(np.full(64, 0.3), 1.0)
    assert (found.mean_z, found.square_z, found.kpss) == (0.0, 0.0, None)
    assert found.least_p == 1.0


def test_the_figures_of_a_run_are_those_of_its_blocks(rng):
    """Of 5000 values: 19 blocks of 256, and 78 of 64."""
    x = 170.0 + rng.standard_normal(5000)
    e = x - x.mean()
    found = examine_stationarity(x, 1.0)
    means, squares = (v[:19 * 256].reshape(19, 256).mean(axis=1) for v in (e, e * e))
    assert (found.mean_z, found.square_z) == pytest.approx(
        (count_arrangements(means).z, count_arrangements(squares).z))
    assert found.kpss == pytest.approx(
        apply_kpss(e[:78 * 64].reshape(78, 64).mean(axis=1)).statistic, rel=1e-9)
