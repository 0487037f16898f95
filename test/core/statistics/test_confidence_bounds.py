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

"""Confidence bounds: exact cases, other routes to the same number, properties."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import binomtest, chi2, t as student

from heading_intercompare.core.statistics.cells import Cells
from heading_intercompare.core.statistics.confidence_bounds import (
    confidence,
    duration_factor,
    interval_factors,
    LEAST_RISK,
    mean_confidence,
    rate_lower,
    rate_upper,
)
from heading_intercompare.core.statistics.variance_uncertainty import (
    estimate_spread,
    excess,
    lower_bound,
    Spread,
    upper_bound,
)


def made(d=1.0, s=0.2, f=50.0, low=0.01, middle=0.01):
    """Return a spread with these figures."""
    nu = 2.0 * (d / s) ** 2 if s else 1000.0
    return Spread(1000, 0, d, 0.01, s, nu, f, 8.0, low, middle)


SLOW = made(low=0.02)


@pytest.mark.parametrize('found', [made(), made(s=0.8, f=3.0), made(s=0.01, f=1e9), SLOW])
def test_bounds_enclose_the_estimate_and_widen_as_the_risk_falls(found):
    alphas = np.geomspace(1e-6, 0.5, 40)
    up = np.array([upper_bound(found, a) for a in alphas])
    low = np.array([lower_bound(found, a) for a in alphas])
    assert np.all(low <= 1.0) and np.all(up >= 1.0)
    finite = np.isfinite(up)
    assert np.all(np.diff(up[finite]) < 0.0) and not np.any(np.diff(finite.astype(int)) < 0)
    assert np.all(np.diff(low) >= 0.0)


@pytest.mark.parametrize('found', [made(), made(s=0.7, f=6.0), made(s=0.02, f=5000.0), SLOW])
@pytest.mark.parametrize('alpha', [1e-5, 0.01, 0.05, 0.2, 0.49])
def test_confidence_is_the_inverse_of_the_bounds(found, alpha):
    assert 1.0 - confidence(found, upper_bound(found, alpha)) == pytest.approx(alpha, rel=1e-8)
    assert confidence(found, lower_bound(found, alpha)) == pytest.approx(alpha, rel=1e-8)


def test_confidence_rises_with_the_limit_within_its_range():
    found = made(s=0.1)
    values = [confidence(found, limit) for limit in np.geomspace(1e-3, 1e3, 200)]
    assert np.all(np.diff(values) >= -1e-12)
    assert values[0] == 1e-6 and values[-1] == 1.0 - 1e-6
    assert confidence(found, 1.0) == 0.5


def test_confidence_does_not_know_a_slow_part_it_allows_for():
    """The allowance is the same at every risk: 0.5 for limits between D and D + G."""
    room = upper_bound(SLOW, 0.5) - 1.0
    assert room > SLOW.slow_allowance_deg2 > 0.0
    for share in (0.0, 0.5, 0.99):
        assert confidence(SLOW, 1.0 + share * room) == 0.5
    assert confidence(SLOW, 1.0 + 1.01 * room) > 0.5


def test_zero_residuals_are_within_any_limit():
    found = estimate_spread(Cells.of(np.zeros(200)))
    assert confidence(found, 1e-9) == 1.0 - LEAST_RISK
    assert duration_factor(found, 1.0, 1.2, 0.05, 0.05) == 1.0


def test_mean_confidence_agrees_with_a_dense_sum():
    """Confidence jumps to 0.5 at the bounds of 0.5, which costs the 20 points some digits."""
    found = made(s=0.15)
    mu = (np.arange(2000) + 0.5) / 2000 * 0.8 + 0.1
    expected = np.mean([confidence(found, 0.8 ** 2 + m * m) for m in mu])
    assert mean_confidence(found, 0.8, 0.1, 0.9) == pytest.approx(expected, abs=0.01)
    assert mean_confidence(found, 0.8, 0.5, 0.5) == confidence(found, 0.8 ** 2 + 0.25)


# --- planning: S.15 ---

def longer(found, r):
    """Return the spread of a record r times as long, other things being equal."""
    return Spread(1000, 0, found.d_deg2, 0.01, found.s_deg2 / math.sqrt(r), found.nu * r,
                  found.f * r, 8.0, found.low_deg2, found.middle_deg2)


@pytest.mark.parametrize('d', [0.2, 0.8, 0.9])
@pytest.mark.parametrize('s, f', [(0.1, 40.0), (0.3, 9.0), (1.0, 1.5), (0.05, 1e5)])
@pytest.mark.parametrize('low', [0.01, 0.012])
def test_after_that_time_the_upper_bound_is_the_acceptance_limit(d, s, f, low):
    found = made(d, s * d, f, low)
    r = duration_factor(found, 1.0, 1.25, 0.05, 0.1)
    if r == 1.0:
        assert upper_bound(found, 0.05) <= 1.0
    else:
        assert upper_bound(longer(found, r), 0.05) == pytest.approx(1.0, abs=1e-9)
        assert upper_bound(longer(found, 0.99 * r), 0.05) > 1.0


@pytest.mark.parametrize('d', [1.26, 1.4, 3.0])
@pytest.mark.parametrize('s', [0.02, 0.4, 2.0])
def test_after_that_time_the_lower_bound_is_the_rejection_limit(d, s):
    found = made(d, s)
    r = duration_factor(found, 1.0, 1.25, 0.05, 0.1)
    if r == 1.0:
        assert lower_bound(found, 0.1) >= 1.25
    else:
        assert lower_bound(longer(found, r), 0.1) == pytest.approx(1.25, rel=1e-12)
    a = (student.ppf(0.9, 12) * s / d / math.log(d / 1.25)) ** 2
    assert r == pytest.approx(max(1.0, max(np.roots([1.0, -a, -a / found.f]))))


def test_the_time_agrees_with_bisection():
    found, lo, hi = made(0.7, 0.3, 12.0), 1.0, 1e6
    while hi - lo > 1e-9 * lo:
        r = 0.5 * (lo + hi)
        bound = 0.7 + excess(12.0 * r, 0.05) * 0.3 / math.sqrt(r)
        lo, hi = (r, hi) if bound > 1.0 else (lo, r)
    assert duration_factor(found, 1.0, 1.25, 0.05, 0.05) == pytest.approx(lo, rel=1e-8)


def test_no_time_decides_between_the_limits():
    for d in (1.0, 1.1, 1.25):
        assert duration_factor(made(d), 1.0, 1.25, 0.05, 0.05) == math.inf
    near = duration_factor(made(np.nextafter(1.0, 0.0)), 1.0, 1.25, 0.05, 0.05)
    assert near == math.inf or near > 1e12
    assert duration_factor(made(100.0), 1.0, 1.25, 0.05, 0.05) == 1.0


def test_no_time_decides_where_a_slow_part_fills_the_room():
    """D = 0.9, R = 2: G = 4/8 * 4 * 0.01 = 0.02; R = 4: G = 2 * 4 * 0.03 = 0.24 > 0.1."""
    resolved, slow = made(0.9, low=0.02), made(0.9, low=0.04)
    assert resolved.slow_allowance_deg2 == pytest.approx(0.02)
    assert slow.slow_allowance_deg2 == pytest.approx(0.24)
    assert math.isfinite(duration_factor(resolved, 1.0, 1.25, 0.05, 0.05))
    assert duration_factor(slow, 1.0, 1.25, 0.05, 0.05) == math.inf


def test_a_variance_known_exactly_decides_at_once_or_never():
    assert duration_factor(made(0.5, 0.0), 1.0, 1.25, 0.05, 0.05) == 1.0
    assert duration_factor(made(0.99, 0.0, low=0.02), 1.0, 1.25, 0.05, 0.05) == math.inf
    assert duration_factor(made(1.3, 0.0), 1.0, 1.25, 0.05, 0.05) == 1.0


# --- rates: S.14 ---

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


def test_the_interval_of_a_power_has_its_probability_on_both_sides():
    low, up = interval_factors([3.0, 40.0], 0.9)
    for dof, factor, p in ((3.0, low[0], 0.95), (3.0, up[0], 0.05), (40.0, low[1], 0.95)):
        assert dof / factor == pytest.approx(chi2.ppf(p, dof))
