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

"""The end of warm-up: by hand, against scipy's own fit, and on data that only look like one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import curve_fit, minimize_scalar

from heading_intercompare.core.statistics.warm_up import fit_warm_up, mser5


def stamps(n, step_s=1.0):
    return 10 ** 18 + np.arange(n) * round(step_s * 1e9)


def test_a_pure_warm_up_by_hand():
    """0.2 + exp(-t/300): within 0.02 deg after 300 ln 50 = 1173.6 s."""
    t = np.arange(4000.0)
    found = fit_warm_up(stamps(4000), 0.2 + np.exp(-t / 300.0), 0.02)
    assert found.preferred
    assert found.level_deg == pytest.approx(0.2, abs=1e-6)
    assert found.amplitude_deg == pytest.approx(1.0, rel=1e-5)
    assert found.tau_s == pytest.approx(300.0, rel=1e-5)
    assert found.settle_s == pytest.approx(300.0 * math.log(50.0), rel=1e-5)
    assert found.stabilization_s == found.settle_s


def test_the_amplitude_is_corrected_for_the_averaging_within_blocks():
    """A time constant of two blocks of 32: without the correction the amplitude is 1 % off."""
    t = np.arange(4000.0)
    assert fit_warm_up(stamps(4000), np.exp(-t / 64.0), 0.01).amplitude_deg == pytest.approx(
        1.0, rel=1e-6)


def test_a_noisy_warm_up_agrees_with_the_fit_of_scipy(rng):
    """Both fits see the same noise; blocks differ from samples by less than the error of each."""
    t = np.arange(3600.0)
    x = -0.5 * np.exp(-t / 400.0) + 0.1 + 0.05 * rng.standard_normal(t.size)
    found = fit_warm_up(stamps(3600), x, 0.02)
    expected, covariance = curve_fit(lambda t, a, b, tau: a + b * np.exp(-t / tau), t, x,
                                     (0.0, -1.0, 500.0))
    u = np.sqrt(np.diag(covariance))
    got = (found.level_deg, found.amplitude_deg, found.tau_s)
    assert found.preferred
    assert (np.abs(got - expected) < u).all()


def test_an_amplitude_within_the_tolerance_has_settled(rng):
    t = np.arange(3600.0)
    found = fit_warm_up(stamps(3600),
                        0.1 * np.exp(-t / 400.0) + 0.01 * rng.standard_normal(t.size),
                        0.2)
    assert (found.settle_s, found.stabilization_s) == (0.0, 0.0)


def test_a_warm_up_longer_than_the_run_leaves_nothing():
    t = np.arange(1000.0)
    found = fit_warm_up(stamps(1000), 5.0 * np.exp(-t / 600.0), 0.02)
    assert found.settle_s > found.span_s
    assert found.stabilization_s == found.span_s == 999.0


def test_a_straight_line_is_no_warm_up(rng):
    t = np.arange(3600.0)
    found = fit_warm_up(stamps(3600), t / 3600.0 + 0.1 * rng.standard_normal(t.size), 0.02)
    assert not found.preferred
    assert found.stabilization_s == 0.0


def test_noise_is_hardly_ever_a_warm_up(ar1):
    """Correlated over 1/120 of the run; at most 1 %, so 9 of 200 would be five errors off."""
    count = sum(fit_warm_up(stamps(1200), 0.1 * ar1(1200, 10.0), 0.02).preferred
                for _ in range(200))
    assert count < 9


def test_time_scales_with_the_step_of_the_stamps():
    x = np.exp(-np.arange(2000.0) / 150.0)
    slow, fast = fit_warm_up(stamps(2000), x, 0.02), fit_warm_up(stamps(2000, 0.1), x, 0.02)
    assert fast.tau_s == pytest.approx(0.1 * slow.tau_s, rel=1e-7)
    assert fast.amplitude_deg == pytest.approx(slow.amplitude_deg, rel=1e-7)


@pytest.mark.parametrize('n', [0, 1, 63])
def test_no_warm_up_of_too_few_samples(n):
    assert fit_warm_up(stamps(n), np.zeros(n), 0.02) is None


def test_constant_differences_have_no_warm_up():
    assert not fit_warm_up(stamps(100), np.full(100, 0.3), 0.02).preferred


@pytest.mark.parametrize('tolerance', [0.0, -1.0, math.nan])
def test_a_tolerance_that_is_not_positive_is_refused(tolerance):
    with pytest.raises(ValueError, match='tolerance_deg = '):
        fit_warm_up([], [], tolerance)


def test_mser5_agrees_with_its_definition(rng):
    x = rng.standard_normal(103) + 4.0 * np.exp(-np.arange(103) / 8.0)
    z = x[:100].reshape(20, 5).mean(axis=1)
    criterion = [np.sum((z[d:] - z[d:].mean()) ** 2) / (20 - d) ** 2 for d in range(11)]
    d = int(np.argmin(criterion))
    assert d > 0
    assert mser5(stamps(103), x) == 5.0 * d


def test_mser5_keeps_all_of_a_constant_and_judges_no_short_run():
    assert mser5(stamps(50), np.full(50, 0.7)) == 0.0
    assert mser5(stamps(19), np.zeros(19)) is None
    assert mser5([], []) is None


def test_the_time_constant_is_the_one_of_least_squares(rng):
    """A minimiser of scipy finds none that fits better, whatever the errors are."""
    n = 6400
    t = np.arange(float(n))
    for x in (rng.standard_normal(n), np.exp(-t / 700.0) + 0.1 * rng.standard_normal(n),
              np.cumsum(0.01 * rng.standard_normal(n)), np.sin(t / 900.0), t / n):
        mine = fit_warm_up(stamps(n), x, 0.02)
        blocks, times = x.reshape(100, 64).mean(axis=1), t.reshape(100, 64).mean(axis=1)

        def squares(log_tau, blocks=blocks, times=times):
            basis = np.stack((np.ones(100), np.exp(-times / math.exp(log_tau))))
            return np.linalg.lstsq(basis.T, blocks, rcond=None)[1][0]
        log_tau = math.log(mine.tau_s)
        ends = math.log((n - 1) / 100.0), math.log(n - 1.0)
        near = minimize_scalar(squares, method='bounded', bounds=(
            max(ends[0], log_tau - 0.01), min(ends[1], log_tau + 0.01))).fun
        assert squares(log_tau) <= min(near, *map(squares, ends)) * (1.0 + 1e-7)
