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

"""Deviation coefficients: against numpy's least squares, with known truth, and withheld."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.core.diagnostics.deviation import (
    deviation_at,
    fit_deviation,
    largest_empty_arc,
)

TRUTH = (0.1, 0.3, -0.2, 0.05, 0.15)


def curve(heading_deg, coefficients=TRUTH):
    psi = np.radians(heading_deg)
    terms = (1.0, np.sin(psi), np.cos(psi), np.sin(2 * psi), np.cos(2 * psi))
    return sum(c * t for c, t in zip(coefficients, terms))


def test_coefficients_without_noise_are_exact():
    heading = np.arange(720) * 1.5 % 360.0
    found = fit_deviation(curve(heading), heading)
    assert found.coefficients_deg == pytest.approx(TRUTH, abs=1e-12)
    assert found.condition == pytest.approx(2.0)
    assert found.residual_std_deg < 1e-12
    assert (found.f, found.p) == (None, None)


def test_the_fit_agrees_with_numpy_in_pieces_too(rng):
    n = 150_000
    heading = rng.uniform(0.0, 250.0, n)
    x = 170.0 + curve(heading) + rng.standard_normal(n)
    psi = np.radians(heading)
    basis = np.stack((np.ones(n), np.sin(psi), np.cos(psi), np.sin(2 * psi), np.cos(2 * psi)), 1)
    expected, rss, _, _ = np.linalg.lstsq(basis, x, rcond=None)
    found = fit_deviation(x, heading)
    assert found.coefficients_deg == pytest.approx(expected, rel=1e-8)
    assert found.residual_std_deg == pytest.approx(math.sqrt(rss[0] / (n - 5)), rel=1e-9)
    assert found.condition == pytest.approx(np.linalg.cond(basis.T @ basis / n), rel=1e-8)


@pytest.mark.slow
def test_the_uncertainties_survive_correlation(ar1):
    """Eight turns, errors correlated over a fiftieth of a block; 1 within six errors and 10 %."""
    n = 8000
    heading = np.linspace(0.0, 8 * 360.0, n) % 360.0
    found = [fit_deviation(ar1(n, 5.0), heading) for _ in range(200)]
    for which in range(5):
        z = [f.coefficients_deg[which] / f.u_deg[which] for f in found]
        assert np.std(z) == pytest.approx(1.0, abs=0.1 + 6.0 / math.sqrt(400.0))
    assert sum(f.p < 0.01 for f in found) < 2 + 6.0 * math.sqrt(2.0) + 4


def test_the_covariance_is_symmetric_and_holds_the_uncertainties(ar1):
    found = fit_deviation(ar1(2000, 3.0), np.linspace(0.0, 700.0, 2000) % 360.0)
    covariance = np.array(found.covariance_deg2)
    assert (covariance == covariance.T).all()
    assert np.sqrt(np.diag(covariance)) == pytest.approx(found.u_deg)


def test_a_quadrantal_error_is_significant(rng):
    heading = rng.uniform(0.0, 360.0, 5000)
    found = fit_deviation(curve(heading, (0, 0, 0, 0.2, 0)) + 0.5 * rng.standard_normal(5000),
                          heading)
    assert found.p < 1e-6
    assert found.amplitude_deg == pytest.approx(0.2, abs=6 * 0.5 * math.sqrt(2 / 5000) * 2)


def test_turning_the_compass_turns_the_coefficients():
    """B sin(psi + 90) + C cos(psi + 90) = B cos(psi) - C sin(psi); D and E change sign."""
    heading = np.arange(0.0, 1800.0, 2.5) % 360.0
    a, b, c, d, e = fit_deviation(curve(heading + 90.0), heading).coefficients_deg
    assert (a, b, c, d, e) == pytest.approx((0.1, 0.2, 0.3, -0.05, -0.15), abs=1e-12)


def test_headings_in_a_narrow_arc_are_refused(rng):
    found = fit_deviation(rng.standard_normal(5000), rng.uniform(80.0, 140.0, 5000))
    assert found.reason == 'headings_too_narrow'
    assert found.condition == pytest.approx(5e6, rel=0.7)
    assert found.empty_arc_deg == pytest.approx(300.0, abs=0.5)
    assert found.coefficients_deg is None


def test_one_heading_alone_is_refused():
    found = fit_deviation(np.zeros(100), np.full(100, 30.0))
    assert (found.reason, found.empty_arc_deg) == ('headings_too_narrow', 360.0)


@pytest.mark.parametrize('n', [0, 1, 63])
def test_too_few_samples_have_no_coefficients(n):
    found = fit_deviation(np.zeros(n), np.arange(n) * 5.0)
    assert (found.reason, found.condition, found.p) == ('insufficient_data', None, None)


def test_equal_differences_all_round_depend_on_nothing():
    found = fit_deviation(np.full(360, 0.3), np.arange(360.0))
    assert found.coefficients_deg == pytest.approx((0.3, 0, 0, 0, 0), abs=1e-12)
    assert found.p is None


@pytest.mark.parametrize('heading, arc', [([], None), ([7.0], 360.0), ([10.0, 350.0], 340.0),
                                          ([0.0, 90.0, 180.0, 270.0], 90.0),
                                          ([-10.0, 10.0, 100.0], 250.0)])
def test_empty_arcs_by_hand(heading, arc):
    assert largest_empty_arc(heading) == arc


def test_the_fit_at_a_heading_by_hand(rng):
    """At 90 deg: A + B - E; its variance is that of the sum, with the covariances."""
    psi = np.linspace(0.0, 3600.0, 20_000) % 360.0
    found = fit_deviation(0.3 * np.cos(np.radians(psi)) + 0.1 * rng.standard_normal(psi.size), psi)
    x, u = deviation_at(found, [90.0, 0.0])
    a, b, c, d, e = found.coefficients_deg
    assert x == pytest.approx([a + b - e, a + c + e])
    row = np.array([1.0, 1.0, 0.0, 0.0, -1.0])
    assert u[0] ** 2 == pytest.approx(row @ np.array(found.covariance_deg2) @ row)
    assert np.isnan(deviation_at(fit_deviation([], []), [0.0])).all()


def test_the_largest_arc_of_many_headings_is_that_of_all_sorted(rng):
    """Even, in a swing, in islands, in one place, in steps, and with one heading far away."""
    n = 150_000
    for heading in (360.0 * rng.random(n), 90.0 + 40.0 * np.sin(np.arange(n) / 5000.0),
                    np.concatenate((50.0 * rng.random(n), 200. + 1e-3 * rng.random(999), [355.])),
                    np.full(n, 359.9999999999), np.round(360.0 * rng.random(n), 1),
                    np.append(300.0 * rng.random(n), 330.0)):
        heading = np.sort(heading % 360.0)
        expected = np.diff(heading, append=heading[0] + 360.0).max()
        assert largest_empty_arc(heading) == pytest.approx(expected, rel=1e-12)
