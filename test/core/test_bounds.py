# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Confidence bounds: exact cases, other routes to the same number, properties."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import binomtest, chi2, norm, t as student

from heading_intercompare.core.bounds import (
    confidence,
    lower_bound,
    mean_confidence,
    nu_needed,
    rate_lower,
    rate_upper,
    upper_bound,
)
from heading_intercompare.core.dyadic import Components, Dyadic


def components(octaves=(0.5, 0.3), dof=(32, 16), slow=0.2, slow_dof=15):
    """Return components of a run of 64."""
    return Components(64, 0, np.array(octaves), np.array(dof), slow, slow_dof, 4,
                      (0.01, 0.02, 0.03), 0.0, 0.1)


ALL_SLOW = components(octaves=(0.0, 0.0), slow=2.0)


@pytest.mark.parametrize('alpha', [1e-6, 0.01, 0.05, 0.3])
def test_one_component_has_the_exact_interval_of_chi_square(alpha):
    """With very many nu the components decide; one of them: f v / chi2 is exact."""
    assert upper_bound(ALL_SLOW, 1e9, alpha) == \
        pytest.approx(2.0 * 15 / chi2.ppf(alpha, 15), rel=1e-12)
    assert lower_bound(ALL_SLOW, 1e9, alpha) == \
        pytest.approx(2.0 * 15 / chi2.isf(alpha, 15), rel=1e-12)


@pytest.mark.parametrize('alpha', [0.01, 0.05, 0.3])
@pytest.mark.parametrize('nu', [3.0, 16.0, 40.0, 1000.0])
def test_bounds_agree_with_the_formulas(nu, alpha):
    c = components()
    v, f = np.array([0.5, 0.3, 0.2]), np.array([32, 16, 15])
    h = 2.0 / (9.0 * nu)
    up = [1.0 + math.sqrt(sum((f / chi2.ppf(alpha, f) - 1.0) ** 2 * v * v))]
    low = [1.0 - math.sqrt(sum((1.0 - f / chi2.ppf(1.0 - alpha, f)) ** 2 * v * v))]
    root = 1.0 - h - student.ppf(1.0 - alpha, 15) * math.sqrt(h)
    up.append(1.0 / root ** 3 if root > 0.0 else math.inf)
    low.append(1.0 / (1.0 - h + student.ppf(1.0 - alpha, 15) * math.sqrt(h)) ** 3)
    assert upper_bound(c, nu, alpha) == pytest.approx(max(up), rel=1e-12)
    assert lower_bound(c, nu, alpha) == pytest.approx(max(0.0, min(low)), rel=1e-12)


def test_too_few_degrees_of_freedom_bound_nothing():
    assert upper_bound(components(), 0.3, 0.05) == math.inf
    assert 0.0 <= lower_bound(components(), 0.01, 0.05) < 0.1
    assert lower_bound(components(slow_dof=1, slow=100.0), 2.0, 0.05) >= 0.0


@pytest.mark.parametrize('nu', [0.5, 5.0, 80.0])
def test_bounds_enclose_the_estimate_and_widen_as_the_risk_falls(nu):
    c = components()
    alphas = np.geomspace(1e-6, 0.3, 40)
    up = np.array([upper_bound(c, nu, a) for a in alphas])
    low = np.array([lower_bound(c, nu, a) for a in alphas])
    assert np.all(low <= 1.0) and np.all(up >= 1.0)
    finite = np.isfinite(up)
    assert np.all(np.diff(up[finite]) < 0.0) and not np.any(np.diff(finite.astype(int)) < 0)
    assert np.all(np.diff(low) >= 0.0)


def test_bounds_of_zero_residuals_are_zero():
    c = Dyadic.of(np.zeros(100)).components()
    assert (upper_bound(c, 99.0, 0.05), lower_bound(c, 99.0, 0.05)) == (0.0, 0.0)
    assert upper_bound(c, 0.001, 0.05) == 0.0
    assert confidence(c, 99.0, 1e-9) == 1.0 - 1e-6


@pytest.mark.parametrize('nu', [2.0, 20.0, 5000.0])
@pytest.mark.parametrize('alpha', [1e-5, 0.01, 0.05, 0.2, 0.3])
def test_confidence_is_the_inverse_of_the_bounds(nu, alpha):
    c = components()
    up = upper_bound(c, nu, alpha)
    if math.isfinite(up):
        assert 1.0 - confidence(c, nu, up) == pytest.approx(alpha, rel=1e-8)
    low = lower_bound(c, nu, alpha)
    if low > 0.0:
        assert confidence(c, nu, low) == pytest.approx(alpha, rel=1e-8)


def test_confidence_rises_with_the_limit_within_its_range():
    c = components()
    values = [confidence(c, 30.0, limit) for limit in np.geomspace(1e-3, 1e3, 200)]
    assert np.all(np.diff(values) >= -1e-12)
    assert values[0] == 1e-6 and values[-1] == 1.0 - 1e-6
    assert confidence(c, 30.0, 1.0) == 0.5


def test_mean_confidence_agrees_with_a_dense_sum():
    """Confidence jumps to 0.5 at the bounds of 0.5, which costs the 20 points some digits."""
    c = components()
    mu = (np.arange(2000) + 0.5) / 2000 * 0.8 + 0.1
    expected = np.mean([confidence(c, 60.0, 0.8 ** 2 + m * m) for m in mu])
    assert mean_confidence(c, 60.0, 0.8, 0.1, 0.9) == pytest.approx(expected, abs=0.01)
    assert mean_confidence(c, 60.0, 0.8, 0.5, 0.5) == confidence(c, 60.0, 0.8 ** 2 + 0.25)


@pytest.mark.parametrize('d_hat', [0.0, 0.2, 0.8, 0.99, 1.3, 1.4])
def test_with_the_degrees_of_freedom_needed_the_bound_is_the_limit(d_hat):
    alpha, beta = 0.05, 0.1
    nu = nu_needed(d_hat, 1.0, 1.25, alpha, beta)
    h = 2.0 / (9.0 * nu)
    if d_hat < 1.0:
        bound = (1.0 - h + norm.ppf(alpha) * math.sqrt(h)) ** 3
        assert bound == pytest.approx(d_hat, abs=1e-12)
    else:
        bound = d_hat / (1.0 - h - norm.ppf(beta) * math.sqrt(h)) ** 3
        assert bound == pytest.approx(1.25, rel=1e-12)


def test_no_amount_of_data_decides_between_the_limits_and_any_does_far_above():
    for d_hat in (1.0, 1.1, 1.25):
        assert nu_needed(d_hat, 1.0, 1.25, 0.05, 0.05) == math.inf
    assert nu_needed(100.0, 1.0, 1.25, 0.05, 0.05) == 0.0
    assert nu_needed(2.0, 1.0, 1.25, 0.5, 0.5) == 0.0
    assert nu_needed(np.nextafter(1.0, 0.0), 1.0, 1.25, 0.05, 0.05) > 1e30


@pytest.mark.parametrize('k, n', [(0, 20), (1, 20), (7, 50), (50, 50), (3, 1000)])
def test_rates_of_integers_have_the_bounds_of_clopper_and_pearson(k, n):
    both = binomtest(k, n).proportion_ci(0.9, 'exact')
    assert rate_lower(k, n, 0.05) == pytest.approx(both.low, rel=1e-9)
    assert rate_upper(k, n, 0.05) == pytest.approx(both.high, rel=1e-9)


def test_certifying_997_permille_without_any_event_takes_997_trials():
    """(1 - 0.003)^n = 0.05 at n = ln 0.05 / ln 0.997 = 997.07."""
    assert rate_upper(0.0, 997.0, 0.05) > 0.003 > rate_upper(0.0, 998.0, 0.05)


def test_rates_of_part_events_lie_between_those_of_whole_ones():
    low = [rate_lower(k, 25.5, 0.05) for k in (0.0, 0.4, 1.0, 1.7, 2.0)]
    up = [rate_upper(k, 25.5, 0.05) for k in (0.0, 0.4, 1.0, 1.7, 25.4, 25.5)]
    assert np.all(np.diff(low) > 0.0) and np.all(np.diff(up) > 0.0)
    assert low[0] == 0.0 and up[-1] == 1.0
