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

"""Drift: by hand, against numpy's own fits, on real logs, and under shifts of time and value."""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial import legendre
import pytest

from heading_intercompare.core.statistics.blocking import Averages, block_means
from heading_intercompare.core.statistics.drift import (
    average_blocks,
    Detrended,
    drift_left_deg2,
    fit_slope,
    remove_polynomial,
    select_order,
)

PAIRS = ['gyr1-s330', 'gyr1-seap', 's330-gyr1', 'seap-s330', 'adcp-seap', 'lgyr-lsep',
         'lsep-lgyr']


def stamps(n, step_s=1.0):
    return 10 ** 18 + np.arange(n) * round(step_s * 1e9)


@pytest.mark.parametrize('n', [64, 127, 128, 99_999])
def test_blocks_one_by_one_have_the_times_of_all_at_once(n, rng):
    stamp_ns = 10 ** 18 + np.cumsum(rng.integers(1, 10 ** 7, n))
    t_s, _, size = average_blocks(stamp_ns, rng.normal(size=n))
    assert t_s.tolist() == block_means((stamp_ns - stamp_ns[0]) / 1e9, size).tolist()


# --- removal ---

def test_a_line_by_hand():
    """1, 2, 3, 4 at u = -1, -1/3, 1/3, 1: 2.5 P_0 + 1.5 P_1."""
    fit = remove_polynomial(stamps(4), [1.0, 2.0, 3.0, 4.0], 1)
    assert fit.coefficients_deg == pytest.approx((2.5, 1.5), abs=1e-14)
    assert np.abs(fit.residual_deg).max() < 1e-14


def test_order_zero_takes_out_the_mean():
    fit = remove_polynomial(stamps(3), [1.0, 2.0, 6.0], 0)
    assert fit.coefficients_deg == (3.0,)
    assert fit.residual_deg.tolist() == [-2.0, -1.0, 3.0]


@pytest.mark.parametrize('order', [0, 1, 2, 3])
def test_removal_on_uneven_stamps_agrees_with_numpy(order, rng):
    t = np.sort(rng.choice(10 ** 12, 3000, replace=False))
    x = 170.0 + 3.0 * rng.standard_normal(3000) + 5.0 * (t / 1e12) ** 2
    u = (2.0 * t - t[0] - t[-1]) / (t[-1] - t[0])
    expected = legendre.legfit(u, x, order)
    fit = remove_polynomial(10 ** 18 + t, x, order)
    assert fit.coefficients_deg == pytest.approx(expected, rel=1e-10)
    assert fit.residual_deg == pytest.approx(x - legendre.legval(u, expected), abs=1e-10)


def test_long_runs_are_fitted_in_pieces_with_the_same_result(rng):
    n = 200_001
    u = np.linspace(-1.0, 1.0, n)
    x = legendre.legval(u, [1.0, -2.0, 0.5, 0.25])
    fit = remove_polynomial(stamps(n), x, 3)
    assert fit.coefficients_deg == pytest.approx((1.0, -2.0, 0.5, 0.25), abs=1e-12)
    assert np.abs(fit.residual_deg).max() < 1e-12


def test_residuals_are_the_same_whatever_polynomial_is_added(rng):
    x = rng.standard_normal(500)
    t = stamps(500)
    trend = legendre.legval(np.linspace(-1.0, 1.0, 500), [30.0, 5.0, -4.0, 2.0])
    assert remove_polynomial(t, x + trend, 3).residual_deg == pytest.approx(
        remove_polynomial(t, x, 3).residual_deg, abs=1e-12)


@pytest.mark.parametrize('n, order', [(0, 0), (1, 0), (2, 0), (3, 1), (4, 2), (5, 3), (6, 3)])
def test_few_samples_lower_the_order(n, order):
    x = np.linspace(0.0, 1.0, n) ** 2
    fit = remove_polynomial(stamps(n), x, 3)
    assert fit.order == order
    assert len(fit.coefficients_deg) == (order + 1 if n else 0)
    assert fit.residual_deg.shape == (n,)
    assert np.isfinite(fit.residual_deg).all()


@pytest.mark.parametrize('order', [-1, 4])
def test_an_order_outside_its_range_is_refused(order):
    with pytest.raises(ValueError, match=f'order = {order}'):
        remove_polynomial([], [], order)


# --- order ---

@pytest.mark.parametrize('order', [0, 1, 2, 3])
def test_the_order_of_a_clear_drift_is_found(order, rng):
    """Never lower, and higher in 3 % of the cases: more than 12 of 50 are six errors off."""
    n = 2000
    drift = 5.0 + legendre.legval(np.linspace(-1.0, 1.0, n), [0.0] * order + [1.0])
    found = [select_order(stamps(n), drift + 0.1 * rng.standard_normal(n)) for _ in range(50)]
    assert {f.blocks for f in found} == {125}
    assert min(f.order for f in found) == order
    assert sum(f.order != order or f.beyond for f in found) <= 12


def test_the_criterion_agrees_with_its_formula(rng):
    """B ln(RSS/B) + (p + 2) ln B of polynomials through the means of blocks of four."""
    x = rng.standard_normal(300)
    z, t = x.reshape(75, 4).mean(axis=1), np.arange(75.0)
    expected = []
    for p in range(5):
        rss = np.sum((z - np.polyval(np.polyfit(t - 37.0, z, p), t - 37.0)) ** 2)
        expected.append(75 * math.log(rss / 75) + (p + 2) * math.log(75))
    assert select_order(stamps(300), x).bic == pytest.approx(expected, rel=1e-9)


def test_a_drift_beyond_order_three_is_said_to_be(rng):
    u = np.linspace(-1.0, 1.0, 4000)
    found = select_order(stamps(4000), np.cos(6.0 * u) + 0.01 * rng.standard_normal(4000))
    assert found.beyond


def test_a_drift_without_noise_takes_the_least_order_that_leaves_nothing():
    n = 640
    found = select_order(stamps(n), 3.0 + np.linspace(0.0, 1.0, n))
    assert found.order == 1
    assert found.bic[1:] == (None,) * 4
    assert select_order(stamps(n), np.full(n, 0.3)).order == 0


def test_white_noise_seldom_looks_like_drift(rng):
    """The criterion errs for 2 P(chi^2_1 > ln 100) = 3 % or so; 25 of 300 are six errors off."""
    orders = [select_order(stamps(200), rng.standard_normal(200)).order for _ in range(300)]
    assert np.count_nonzero(orders) < 25


@pytest.mark.parametrize('n', [0, 1, 63])
def test_no_order_of_too_few_samples(n):
    assert select_order(stamps(n), np.zeros(n)) is None


# --- what a drift left in may make ---

def test_the_drift_left_in_by_hand():
    """
    A line from -1 to 1 has the variance c_1^2 / 3 = 1/3, c_1 its Legendre coefficient.

    Without noise v of the residuals is 0; the bound is the variance of the line itself.
    """
    line = np.linspace(-1.0, 1.0, 2000)
    found = drift_left_deg2(Detrended.of(Averages.of(stamps(2000), line), 1))
    assert found == pytest.approx(1.0 / 3.0, rel=1e-3)
    bowl = 1.5 * line ** 2 - 0.5
    assert drift_left_deg2(Detrended.of(Averages.of(stamps(2000), line + bowl), 2)) == \
        pytest.approx(1.0 / 3.0 + 1.0 / 5.0, rel=1e-2)


def test_the_drift_left_in_is_seldom_above_its_bound(rng):
    """White errors and a line of variance 1/12, 200 times: a bound of 95 %, six errors."""
    line = np.linspace(-0.5, 0.5, 1000)
    found = [drift_left_deg2(Detrended.of(Averages.of(stamps(1000), x), 1))
             for x in line + rng.standard_normal((200, 1000))]
    assert np.mean(np.array(found) < 1.0 / 12.0) < 0.05 + 6.0 * math.sqrt(0.05 * 0.95 / 200)
    assert drift_left_deg2(Detrended.of(Averages.of(stamps(127), line[:127]), 1)) is None


# --- slope ---

def test_slope_by_hand():
    """0, 1, 1 at 0, 1, 2 h: slope 1/2, residuals -1/6, 1/3, -1/6 and RSS 1/6."""
    found = fit_slope(stamps(3, 3600.0), [0.0, 1.0, 1.0])
    assert found.slope_deg_per_h == pytest.approx(0.5)
    assert found.intercept_deg == pytest.approx(1.0 / 6.0)
    assert found.u_naive_deg_per_h == pytest.approx(math.sqrt(1.0 / 12.0))
    assert found.residual_std_deg == pytest.approx(math.sqrt(1.0 / 12.0))


@pytest.mark.parametrize('name', PAIRS)
def test_slopes_of_real_logs_agree_with_independent_programs(name, real, golden):
    pairs, x = real(name)
    found, expected = fit_slope(pairs.stamp_ns, x), golden['pairs'][name]['drift']
    got = {'slope_deg_per_h': found.slope_deg_per_h, 'intercept': found.intercept_deg,
           'se_naive': found.u_naive_deg_per_h, 'tau_resid': found.tau_samples,
           'se_corr': found.u_naive_deg_per_h * math.sqrt(max(1.0, found.tau_samples)),
           'sd_resid': found.residual_std_deg}
    assert got == pytest.approx({name: expected[name] for name in got}, rel=1e-9)


@pytest.mark.slow
def test_the_standard_error_of_a_slope_allows_for_correlation(ar1):
    """Scatter over its own standard error, 150 times: 1 within six standard errors and bias."""
    n = 5000
    z = [f.slope_deg_per_h / f.u_deg_per_h
         for f in (fit_slope(stamps(n), ar1(n, 10.0)) for _ in range(150))]
    assert np.std(z) == pytest.approx(1.0, abs=6.0 / math.sqrt(300.0))


def test_slope_does_not_depend_on_the_date_or_the_mean(rng):
    x = rng.standard_normal(100)
    t = np.arange(100) * 10 ** 9
    a, b = fit_slope(t, x), fit_slope(t + 17 * 10 ** 17, x + 40.0)
    assert b.slope_deg_per_h == pytest.approx(a.slope_deg_per_h, rel=1e-9)
    assert b.intercept_deg - 40.0 == pytest.approx(a.intercept_deg, abs=1e-12)


def test_slope_of_too_few_samples():
    assert fit_slope([], []) is None
    assert fit_slope([5], [1.0]) is None
    two = fit_slope([0, 3_600_000_000_000], [1.0, 2.0])
    assert (two.slope_deg_per_h, two.u_deg_per_h) == (1.0, None)


def test_a_long_record_is_fitted_like_a_short_one(rng):
    """Three pieces: coefficients and residuals by numpy, the slope by the textbook."""
    n = 20_000
    t_ns = 10 ** 18 + np.cumsum(rng.integers(1, 2 * 10 ** 8, n))
    x = 150.0 + 1e-3 * np.arange(n) + rng.standard_normal(n)
    u = 2.0 * (t_ns - t_ns[0]) / (t_ns[-1] - t_ns[0]) - 1.0
    for order in range(4):
        fit = remove_polynomial(t_ns, x, order)
        expected = legendre.legfit(u, x, order)
        assert fit.coefficients_deg == pytest.approx(expected, rel=1e-11, abs=1e-11)
        assert fit.residual_deg == pytest.approx(x - legendre.legval(u, expected), abs=1e-10)
    found, t_h = fit_slope(t_ns, x), (t_ns - t_ns[0]) / 3.6e12
    slope, start = np.polyfit(t_h, x, 1)
    rest = x - start - slope * t_h
    assert (found.slope_deg_per_h, found.intercept_deg) == pytest.approx((slope, start), rel=1e-9)
    assert found.residual_std_deg == pytest.approx(math.sqrt(rest @ rest / (n - 1)), rel=1e-11)
    assert found.u_naive_deg_per_h == pytest.approx(
        math.sqrt(rest @ rest / (n - 2) / np.sum((t_h - t_h.mean()) ** 2)), rel=1e-10)
