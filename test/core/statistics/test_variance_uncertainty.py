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

"""The spectrum of the squares: by hand, against a plain program, degenerate data, properties."""

from __future__ import annotations

from dataclasses import replace
import math

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import chi2, norm, t as student

from heading_intercompare.core.statistics.cells import Cells, CellValues
from heading_intercompare.core.statistics.variance_uncertainty import (
    between_runs,
    estimate_spread,
    excess,
    lower_bound,
    pool,
    scatter_of_runs,
    Spread,
    upper_bound,
)

pytestmark = pytest.mark.filterwarnings('error')


def noise(n, tau, rng):
    """Return AR(1) noise of unit variance in its stationary state."""
    phi = math.exp(-1.0 / tau)
    white = rng.standard_normal(n) * math.sqrt(1.0 - phi * phi)
    return lfilter([1.0], [1.0, -phi], white, zi=[phi * rng.standard_normal()])[0]


def waves(power):
    """Return cell values whose power at 1, 2, ... half-periods is this; their mean is 0."""
    k = len(power) + 1
    at = np.arange(k) + 0.5
    return sum(math.sqrt(2.0 * p / k) * np.cos(math.pi * (j + 1) * at / k)
               for j, p in enumerate(power))


def record(a, c, n=1280, q=1.0, kurtosis=3.0, rounding_deg=0.0, occupied=1.0):
    """Return 128 cells with this power of the deviations and of the squares."""
    return CellValues(n, 0.0, q, kurtosis, rounding_deg, waves(a), q + waves(c), occupied)


FLAT, LOW = [12.8] * 127, [32.0] * 16 + [2.0] * 111


def made(d=1.0, s=0.2, f=50.0, n=1000, v=0.01, low=0.01, middle=0.01, dof=12):
    """Return a spread with these figures."""
    return Spread(n, 0, d, v, s, 2.0 * (d / s) ** 2, f, 8.0, low, middle, dof)


def by_the_page(values, order, alpha):
    """Return the figures of S.1 to S.11 as written, with plain loops."""
    k, n, q = len(values.b_deg), values.n, values.mean_square_deg2

    def spectrum(series):
        power = [0.0]
        for j in range(1, k):
            wave = math.fsum(series * np.cos(math.pi * j * (np.arange(k) + 0.5) / k))
            power.append(2.0 / k * wave ** 2)
        return lambda i, j: math.fsum(power[i:j + 1]) / (j + 1 - i)

    a, c = spectrum(values.b_deg), spectrum(values.y_deg2)
    p, m = order, k - 1
    v = a(p + 1, p + 8) / k
    low, middle = a(p + 1, p + 4), a(p + 13, p + 28)
    d = q + v if p == 0 else q + (1 + p) * low / k
    w = max(c(1, 6), c(1, 12), c(1, 24))
    s = math.sqrt((1.0 + 30.0 / n) * max(w / k + 6.0 * (1 + p) ** 2 * v ** 2, 2.0 * d ** 2 / n))
    nu = 2.0 * d ** 2 / s ** 2
    corners, slow = [], []
    for width in {64, min(128, m), m}:
        plateau = c(1, 16)
        floor = min(plateau, c(3 * width // 4 + 1, width))
        h = (plateau - floor) / plateau
        area = width * c(1, width) - width * floor
        if area > 0.0 and h > 0.0:
            corners.append(max(8.0, 2.0 / math.pi * area / (plateau - floor)))
            slow.append(0.45 * corners[-1] / (h * max(1.0, values.kurtosis / 3.0) ** 2))
    f = min([nu, *slow])
    t = student.ppf(1.0 - alpha, 12)
    x = math.sqrt(f / 2.0) * (f / chi2.ppf(norm.cdf(-t), f) - 1.0)
    r, slow_variance = low / middle, 4.0 * max(0.0, low - middle) / k
    allowance = min(254.3, r ** 2 / 8.0) * slow_variance
    return {'d_deg2': d, 'mean_variance_deg2': v, 's_deg2': s, 'nu': nu, 'f': f,
            'corner_j': min(corners, default=math.inf), 'r_slow': r,
            'slow_variance_deg2': slow_variance, 'slow_allowance_deg2': allowance,
            'upper': d + x * s + allowance,
            'lower': d * math.exp(-t * s / d * math.sqrt(1.0 + 1.0 / f))}


# --- by hand ---

def test_variance_of_the_mean_by_hand():
    """S.1, S.2: power 12.8 everywhere over 128 cells is 0.1 a mode; D = 1 + 0.1."""
    found = estimate_spread(record(FLAT, LOW))
    assert found.mean_variance_deg2 == pytest.approx(0.1, rel=1e-12)
    assert found.d_deg2 == pytest.approx(1.1, rel=1e-12)


def test_the_standard_error_by_hand():
    """
    S.3, S.4: means of C over 6, 12 and 24 modes: 32, 32, (16 * 32 + 8 * 2)/24 = 22.

    s^2 = (32/128 + 6 * 0.1^2)(1 + 30/1280) = 0.31 * 1.0234375; nu = 2 * 1.1^2 / s^2.
    """
    found = estimate_spread(record(FLAT, LOW))
    assert found.s_deg2 == pytest.approx(math.sqrt(0.31 * 1.0234375), rel=1e-12)
    assert found.nu == pytest.approx(2.42 / 0.31 / 1.0234375, rel=1e-12)
    late = estimate_spread(record(FLAT, [0.0] * 20 + [64.0] * 4 + [0.0] * 103))
    assert late.s_deg2 ** 2 == pytest.approx(
        1.0234375 * (64.0 * 4 / 24 / 128 + 0.06), rel=1e-12)


def test_no_sum_of_squares_is_known_better_than_that_of_white_errors():
    """S.4: s^2 is at least 2 D^2 (1 + 30/n) / n, so nu is at most n / (1 + 30/n)."""
    found = estimate_spread(record([0.0] * 127, [0.0] * 127))
    assert found.s_deg2 ** 2 == pytest.approx(1.0234375 * 2.0 / 1280, rel=1e-12)
    assert found.nu == found.f == pytest.approx(1280.0 / 1.0234375)


def test_the_corner_by_hand():
    """
    S.5, S.6: P = 32, F = 2, h = 30/32; M = 16 * 30 = 480 in every window.

    J = 2/pi * 480/30 = 32/pi = 10.19; f = 0.45 J / h; a quarter of it for k4 = 6.
    """
    found, tails = (estimate_spread(record(FLAT, LOW, kurtosis=k4)) for k4 in (3.0, 6.0))
    assert found.corner_j == tails.corner_j == pytest.approx(32.0 / math.pi, rel=1e-12)
    assert found.f == pytest.approx(0.45 * 32.0 / math.pi / 0.9375, rel=1e-12)
    assert tails.f == pytest.approx(found.f / 4.0, rel=1e-12)
    assert estimate_spread(record(FLAT, LOW, kurtosis=1.0)).f == found.f


def test_a_corner_below_eight_is_taken_for_eight():
    """All power in the first half-period: M = 16 - 64/.., P = 1, h = 1: 2/pi * 16/1 = 10.2."""
    assert estimate_spread(record(FLAT, [32.0] * 2 + [0.0] * 125)).corner_j == \
        pytest.approx(2.0 / math.pi * 16.0)
    # Lobes below the floor of the last quarter take area away.
    dented = [32.0] * 16 + [0.0] * 32 + [4.0] * 79
    assert estimate_spread(record(FLAT, dented)).corner_j == 8.0


def test_squares_without_a_slow_part_have_no_corner():
    """P = F gives h = 0, and P = 0 too: J is infinite, and f is nu."""
    for c in ([3.0] * 127, [0.0] * 127, [1.0] * 16 + [5.0] * 111):
        found = estimate_spread(record(FLAT, c))
        assert found.corner_j == math.inf and found.f == found.nu


def test_the_worst_window_counts():
    """A slow corner under a fast fluctuation shows in 64 modes and is hidden in all 127."""
    c = [32.0] * 16 + [2.0] * 48 + [20.0] * 31 + [0.0] * 32
    first = 2.0 / math.pi * 480.0 / 30.0
    whole = 2.0 / math.pi * (16 * 32.0 + 48 * 2.0 + 31 * 20.0) / 32.0
    found = estimate_spread(record(FLAT, c))
    assert whole > first and found.corner_j == pytest.approx(first, rel=1e-12)


def test_the_slow_part_by_hand():
    """
    S.8, S.9: four lowest half-periods 64, the middle ones 12.8: R = 5; 0: R is infinite.

    V_s = 4 * (64 - 12.8)/128 = 1.6; G = 25/8 * 1.6 = 5; where R > 45: 254.3 V_s.
    """
    a = [64.0] * 4 + [12.8] * 123
    found = estimate_spread(record(a, LOW))
    assert found.r_slow == pytest.approx(5.0)
    assert found.slow_variance_deg2 == pytest.approx(1.6)
    assert found.slow_allowance_deg2 == pytest.approx(5.0)
    steep = estimate_spread(record([640.0] * 4 + [12.8] * 123, LOW))
    assert steep.slow_allowance_deg2 == pytest.approx(254.3 * 4.0 * (640.0 - 12.8) / 128)
    alone = estimate_spread(record([64.0] * 4 + [0.0] * 123, LOW, rounding_deg=1e-13))
    assert alone.r_slow == math.inf
    assert alone.slow_allowance_deg2 == pytest.approx(254.3 * 2.0)
    silent = estimate_spread(record([0.0] * 127, LOW, rounding_deg=1e-13))
    assert (silent.r_slow, silent.slow_allowance_deg2) == (0.0, 0.0)
    quiet = estimate_spread(record([1.0] * 4 + [12.8] * 123, LOW))
    assert (quiet.slow_variance_deg2, quiet.slow_allowance_deg2) == (0.0, 0.0)


def test_the_largest_allowance_is_that_of_one_degree_of_freedom():
    """1 / chi-square(0.05, 1) = 254.3."""
    assert 1.0 / chi2.ppf(0.05, 1) == pytest.approx(254.3, abs=0.02)


def test_a_polynomial_takes_its_modes_and_gives_them_back():
    """
    S.1, S.2, S.4 with p = 2: modes 3 to 10, of which two are 12.8, six 25.6.

    v = (2 * 12.8 + 6 * 25.6)/8/128; the lowest four of them average 19.2: D = 1 + 3 * 0.15.
    """
    a = [1e6] * 2 + [12.8] * 2 + [25.6] * 123
    found = estimate_spread(record(a, LOW), 2)
    v = (2 * 12.8 + 6 * 25.6) / 8 / 128
    assert found.mean_variance_deg2 == pytest.approx(v, rel=1e-12)
    assert found.d_deg2 == pytest.approx(1.45, rel=1e-12)
    assert found.s_deg2 ** 2 == pytest.approx(
        1.0234375 * (0.25 + 6.0 * 9.0 * v * v), rel=1e-12)
    assert found.low_deg2 == pytest.approx(0.15) and found.middle_deg2 == pytest.approx(0.2)


@pytest.mark.parametrize('f, factor', [
    (1e12, 1.8), (100.0, 2.2), (40.0, 2.5), (20.0, 3.0), (10.0, 3.9), (4.0, 8.0)])
def test_the_excess_has_the_values_of_the_page(f, factor):
    assert round(excess(f, 0.05), 1) == factor


def test_the_bounds_by_hand():
    """S.10, S.11: D = 1, s = 0.2, very many f: 1 + 1.7823 * 0.2 and exp(-1.7823 * 0.2)."""
    found = made(f=1e300)
    assert student.ppf(0.95, 12) == pytest.approx(1.7823, abs=1e-4)
    assert upper_bound(found, 0.05) == pytest.approx(1.35646, abs=1e-5)
    assert lower_bound(found, 0.05) == pytest.approx(math.exp(-0.35646), abs=1e-5)
    slow = made(f=1e300, low=0.05)
    assert upper_bound(slow, 0.05) - upper_bound(found, 0.05) == \
        pytest.approx(25.0 / 8.0 * 4.0 * 0.04)


# --- against the page ---

@pytest.mark.slow
@pytest.mark.parametrize('n', [128, 400, 1023, 3000])
@pytest.mark.parametrize('order', [0, 1, 3])
@pytest.mark.parametrize('law', ['normal', 'heavy', 'slow'])
def test_all_figures_agree_with_a_plain_program(n, order, law, rng):
    x = 170.0 + noise(n, n / 40.0, rng) + rng.standard_normal(n)
    if law == 'heavy':
        x = 170.0 + rng.standard_t(3, n) * np.exp(0.5 * noise(n, n / 30.0, rng))
    if law == 'slow':
        x += np.linspace(0.0, 3.0, n) ** 2
    cells = Cells.of(x)
    found, expected = estimate_spread(cells, order), by_the_page(cells.values(), order, 0.03)
    for name, value in expected.items():
        if name not in ('upper', 'lower'):
            assert getattr(found, name) == pytest.approx(value, rel=1e-9), name
    assert upper_bound(found, 0.03) == pytest.approx(expected['upper'], rel=1e-9)
    assert lower_bound(found, 0.03) == pytest.approx(expected['lower'], rel=1e-9)


@pytest.mark.parametrize('f', [0.3, 2.0, 15.0, 1e3, 1e6])
@pytest.mark.parametrize('alpha', [0.001, 0.05, 0.5])
@pytest.mark.parametrize('dof', [12, 60])
def test_the_excess_agrees_with_its_formula(f, alpha, dof):
    t = student.ppf(1.0 - alpha, dof)
    assert excess(f, alpha, dof) == pytest.approx(
        math.sqrt(f / 2.0) * (f / chi2.ppf(norm.cdf(-t), f) - 1.0), rel=1e-8)


def test_the_excess_is_smooth_falls_with_f_and_rises_as_the_risk_falls():
    f = np.geomspace(0.05, 1e14, 400)
    values = [excess(v, 0.05) for v in f]
    assert np.all(np.diff(values) < 1e-9)
    assert excess(1e8 * (1 + 1e-9), 0.05) == pytest.approx(excess(1e8, 0.05), rel=1e-6)
    assert values[-1] == pytest.approx(student.ppf(0.95, 12), rel=1e-6)
    assert np.all(np.diff([excess(10.0, a) for a in (0.5, 0.1, 0.05, 0.01, 1e-4)]) > 0.0)
    assert excess(0.001, 0.05) == math.inf


# --- degenerate data ---

@pytest.mark.parametrize('value', [0.0, 0.1, -179.99])
@pytest.mark.parametrize('order', [0, 3])
def test_equal_differences_have_bounds_of_zero(value, order):
    found = estimate_spread(Cells.of(np.full(300, value)), order)
    assert (found.d_deg2, found.s_deg2, found.cv) == (0.0, 0.0, 0.0)
    assert found.nu == found.f == 299.0 - order
    assert (upper_bound(found, 0.05), lower_bound(found, 0.05)) == (0.0, 0.0)
    assert pool([found, found]).f == 2.0 * (299.0 - order)
    assert between_runs([found] * 3, [value] * 3, 0.05) == pytest.approx(0.0, abs=1e-20)


@pytest.mark.parametrize('x', [
    np.tile([1.0, -1.0], 100), np.append(np.zeros(199), 1e6), np.append(1e6, np.zeros(1999)),
    np.linspace(0.0, 1.0, 500), np.tile([0.01, 0.02], 400), np.repeat([0.0, 1.0], 100),
    np.append(1e-200, np.zeros(199)), np.tile([0.0, 5e-324], 100),
    1e-100 * np.arange(300.0) ** 2 % 7.0, 1e-155 * (np.arange(300.0) ** 2 % 7.0),
    1e60 * (np.arange(300.0) ** 2 % 7.0)],
    ids=['alternating', 'one outlier', 'the first', 'ramp', 'two values', 'one step', 'tiny',
         'denormal', 'squares that vanish', 'squares that are denormal', 'huge'])
@pytest.mark.parametrize('order', [0, 2])
def test_no_figure_is_ever_nan(x, order):
    found = estimate_spread(Cells.of(x), order)
    both = pool([found, found])
    for one in (found, both):
        figures = [getattr(one, name) for name in (
            'd_deg2', 'mean_variance_deg2', 's_deg2', 'nu', 'f', 'corner_j', 'low_deg2',
            'middle_deg2', 'cv', 'r_slow', 'slow_variance_deg2', 'slow_allowance_deg2')]
        figures += [upper_bound(one, 0.05), lower_bound(one, 0.05)]
        assert not any(math.isnan(v) for v in figures) and min(figures) >= 0.0
        assert one.f > 0.0 and upper_bound(one, 0.05) >= one.d_deg2 >= lower_bound(one, 0.05)
    assert not math.isnan(between_runs([found] * 3, [0.0, 1.0, 2.0], 0.05))


def test_a_single_outlier_bounds_nothing():
    """A single difference of 200 carries everything: the bound is infinite, not small."""
    assert upper_bound(estimate_spread(Cells.of(np.append(np.zeros(199), 1e6))), 0.05) == math.inf


def test_a_ramp_is_one_observation():
    """Nothing but a trend: its variance may be 254 times as large, or more."""
    found = estimate_spread(Cells.of(np.linspace(-1.0, 1.0, 5000)))
    assert found.slow_allowance_deg2 == pytest.approx(254.3 * found.slow_variance_deg2)
    assert upper_bound(found, 0.05) > 200.0 * found.d_deg2


@pytest.mark.parametrize('n', [0, 1, 127])
def test_too_few_differences_have_no_spread(n):
    assert estimate_spread(Cells.of(np.arange(float(n)))) is None


# --- properties ---

FIGURES = ('nu', 'f', 'corner_j', 'r_slow', 'cv')
VARIANCES = ('d_deg2', 'mean_variance_deg2', 's_deg2', 'low_deg2', 'middle_deg2',
             'slow_variance_deg2', 'slow_allowance_deg2')


@pytest.mark.parametrize('scale', [2.0 ** -30, -8.0])
def test_the_unit_does_not_matter(scale, rng):
    x = noise(3000, 30.0, rng)
    a, b = estimate_spread(Cells.of(x)), estimate_spread(Cells.of(scale * x))
    assert [getattr(a, n) for n in FIGURES] == [getattr(b, n) for n in FIGURES]
    assert [getattr(a, n) * scale ** 2 for n in VARIANCES] == \
        [getattr(b, n) for n in VARIANCES]


def test_an_offset_does_not_matter(rng):
    """Steps of 2^-20 degree on 170 degrees are exact."""
    x = np.rint(noise(3000, 30.0, rng) * 2 ** 20) / 2 ** 20
    a, b = estimate_spread(Cells.of(x)), estimate_spread(Cells.of(x + 170.0))
    names = (*FIGURES, *VARIANCES)
    assert [getattr(a, n) for n in names] == \
        pytest.approx([getattr(b, n) for n in names], rel=1e-10)


def test_time_backwards_says_the_same(rng):
    x = noise(1024 * 4, 30.0, rng)
    a, b = estimate_spread(Cells.of(x)), estimate_spread(Cells.of(x[::-1]))
    names = (*FIGURES, *VARIANCES)
    assert [getattr(a, n) for n in names] == \
        pytest.approx([getattr(b, n) for n in names], rel=1e-9)


@pytest.mark.slow
def test_white_errors_keep_nearly_all_their_degrees_of_freedom(rng):
    """Theory: D = 1, s = sqrt(2/n), v = 1/n; means of 300 within six of their standard errors."""
    n, found = 1000, []
    for _ in range(300):
        one = estimate_spread(Cells.of(rng.standard_normal(n)))
        found.append((one.d_deg2, one.mean_variance_deg2))
    mean, error = np.mean(found, axis=0), np.std(found, axis=0) / math.sqrt(300)
    assert np.all(np.abs(mean - (1.0, 1.0 / n)) < 6.0 * error)


# --- several runs ---

def test_equal_runs_together_are_known_better_by_the_root_of_their_number():
    """S.12: s / sqrt(m), f m; D stays, and 12 m degrees of freedom carry Student's t."""
    one = made(s=0.3, f=11.0, low=0.05)
    both = pool([one] * 5)
    assert (both.n, both.d_deg2, both.student_dof) == (5000, pytest.approx(1.0), 60)
    assert both.s_deg2 == pytest.approx(0.3 / math.sqrt(5.0))
    assert both.f == pytest.approx(55.0)
    assert both.mean_variance_deg2 == pytest.approx(0.01 / 5.0)
    assert (both.r_slow, both.slow_allowance_deg2) == pytest.approx(
        (one.r_slow, one.slow_allowance_deg2))


def test_one_run_together_is_the_run(rng):
    one = estimate_spread(Cells.of(noise(2000, 30.0, rng)))
    both = pool([one])
    for name in (*FIGURES, *VARIANCES):
        assert getattr(both, name) == pytest.approx(getattr(one, name), rel=1e-12), name


def test_unequal_runs_weigh_by_their_differences():
    """
    S.12: 3000 and 1000 differences, w = 3/4 and 1/4; D = 0.75 * 1 + 0.25 * 2.

    s^2 = (0.75 * 0.2)^2 + (0.25 * 0.4)^2 = 0.0325; skewness (0.15^3 sqrt(8/50) + 0.1^3) / s^3.
    """
    both = pool([made(n=3000), made(d=2.0, s=0.4, f=8.0, n=1000, low=0.05)])
    assert both.d_deg2 == pytest.approx(1.25)
    assert both.s_deg2 == pytest.approx(math.sqrt(0.0325))
    gamma = (0.15 ** 3 * math.sqrt(8.0 / 50.0) + 0.1 ** 3) / 0.0325 ** 1.5
    assert both.f == pytest.approx(8.0 / gamma ** 2)
    assert both.low_deg2 == pytest.approx(0.02) and both.middle_deg2 == pytest.approx(0.01)
    assert both.slow_variance_deg2 == pytest.approx(0.04)


def test_the_bound_from_the_means_of_runs_by_hand():
    """
    S.13: three runs, D = 1, v = 0.01, means -0.3, 0, 0.3: s_b^2 = 0.09.

    D' = 1 - 0.01 + 0.09. chi-square(0.05, 2) = -2 ln 0.95 = 0.10259: 2/0.10259 - 1 = 18.496.
    """
    runs = [made(f=1e300)] * 3
    inside = student.ppf(0.95, 36) * 0.2 / math.sqrt(3.0)
    slow = (-1.0 / math.log(0.95) - 1.0) * 0.09
    assert slow == pytest.approx(18.496 * 0.09, rel=1e-4)
    assert between_runs(runs, [-0.3, 0.0, 0.3], 0.05) == pytest.approx(
        1.08 + math.hypot(inside, slow), rel=1e-9)


@pytest.mark.parametrize('m, factor', [(2, 253.3), (3, 18.5), (5, 4.6), (8, 2.2), (12, 1.4)])
def test_what_the_means_of_runs_are_worth(m, factor):
    """Runs whose s is 0: U' - D' is that factor of the variance of the means, here 1."""
    means = np.zeros(m)
    means[0], means[1] = 1.0, -1.0
    means *= math.sqrt(0.5 * (m - 1))
    runs = [made(d=1.0, s=1e-12, f=1e300, v=0.0)] * m
    assert between_runs(runs, list(means), 0.05) - 2.0 == pytest.approx(factor, abs=0.05)


def test_an_offset_of_all_means_does_not_matter():
    runs = [made()] * 4
    assert between_runs(runs, [1.0, 2.0, 4.0, 3.0], 0.05) == pytest.approx(
        between_runs(runs, [171.0, 172.0, 174.0, 173.0], 0.05))


# --- the slowest error is stated: S.17 to S.19 ---

def test_the_bound_with_a_stated_error_by_hand():
    """
    S.17, 60 slowest errors, 128 cells: B = 20 modes of the squares, (16 x 4 + 4 x 0.25) / 20.

    v = 0.01, D = 1.01. W / K + 6 v^2 = 3.25 / 128 + 0.0006 = 0.025991 is below
    2 D^2 / 60 = 0.034003. f = min(nu, max(0.45 x 60, f_S / 2)) = 27.
    """
    cells = record([1.28] * 127, [4.0] * 16 + [0.25] * 111, n=100_000)
    found = estimate_spread(cells, times=60.0)
    s2 = (1.0 + 3e-4) * (3.25 / 128.0 + 0.0006)
    assert found.above.s_deg2 == pytest.approx(math.sqrt(s2), rel=1e-12)
    assert (found.above.student_dof, found.above.f) == (20, pytest.approx(27.0))
    assert upper_bound(found, 0.05) == pytest.approx(
        1.01 + 1.1 * excess(27.0, 0.05, 20) * math.sqrt(s2), rel=1e-12)


def test_no_noise_of_the_squares_exceeds_what_the_stated_errors_can_do():
    """Power 32 in the squares would give s = 0.56; errors of 20 times give D sqrt(2 / 20)."""
    found = estimate_spread(record(FLAT, LOW, n=100_000), times=20.0)
    assert found.above.s_deg2 == pytest.approx(1.1 * math.sqrt(0.1 * 1.0003), rel=1e-12)
    tails = estimate_spread(record(FLAT, LOW, n=100_000, kurtosis=6.0), times=20.0)
    assert tails.above.s_deg2 == pytest.approx(1.1 * math.sqrt(0.25 * 1.0003), rel=1e-12)
    assert tails.above.widening == pytest.approx(1.1 * (1.0 + 0.7 * math.log(2.0)))


def test_a_statement_changes_nothing_but_the_upper_bound(rng):
    cells = Cells.of(noise(3000, 30.0, rng))
    alone, stated = estimate_spread(cells), estimate_spread(cells, times=100.0)
    assert replace(stated, stated=None, times=None) == alone
    assert lower_bound(stated, 0.05) == lower_bound(alone, 0.05)
    assert upper_bound(stated, 0.05) < upper_bound(alone, 0.05)
    for times in (None, 19.9):
        assert upper_bound(estimate_spread(cells, times=times), 0.05) == upper_bound(alone, 0.05)


def test_a_record_that_contradicts_the_statement_keeps_its_allowance():
    """R0(100) = 1.40: above three times that the lowest modes deny errors that fast."""
    flat = (1.0 + (0.205 * math.pi) ** 2) / (1.0 + (0.025 * math.pi) ** 2)
    for ratio, keeps in ((2.99 * flat, False), (3.01 * flat, True)):
        cells = record([ratio] * 4 + [1.0] * 123, LOW)
        alone, stated = estimate_spread(cells), estimate_spread(cells, times=100.0)
        assert alone.slow_allowance_deg2 > 0.0
        assert stated.slow_allowance_deg2 == (alone.slow_allowance_deg2 if keeps else 0.0)


def test_a_gap_does_not_count_as_time_that_was_seen():
    whole, half = (estimate_spread(record(FLAT, LOW, occupied=share), times=100.0)
                   for share in (1.0, 0.5))
    assert half.above.student_dof == 16 and whole.above.student_dof == 32
    assert half.above.f == pytest.approx(22.5) and whole.above.f == pytest.approx(45.0)


def test_the_pooled_bound_with_a_stated_error_by_hand():
    """S.18: v = 0.01 is low by c(20) = 8 / sum of 1 / (1 + (j pi / 20)^2) = 1.4788."""
    runs = [replace(made(f=1e300), times=20.0, kurtosis=3.0 * math.e)] * 5
    c = 8.0 / sum(1.0 / (1.0 + (j * math.pi / 20.0) ** 2) for j in range(1, 9))
    assert c == pytest.approx(1.4788, abs=1e-4)
    found = pool(runs, by_statement=True)
    assert upper_bound(found, 0.05) == pytest.approx(
        1.0 + (c - 1.0) * 0.01 + 1.5 * student.ppf(0.95, 60) * 0.2 / math.sqrt(5.0), rel=1e-9)
    assert lower_bound(found, 0.05) == lower_bound(pool(runs), 0.05)


def test_the_scatter_of_runs_by_hand():
    """S.19: mean squares 0.8, 1.0, 1.2 of runs with equal means: s_Q^2 = 3/2 x 0.08 / 9."""
    runs = [made(d=d, v=0.0, f=1e300) for d in (0.8, 1.0, 1.2)]
    scatter = math.sqrt(0.12 / 9.0)
    assert scatter_of_runs(runs, [0.5] * 3, 0.05) == pytest.approx(
        1.0 + excess(2.0 / scatter ** 2, 0.05, 2) * scatter, rel=1e-12)
    apart = scatter_of_runs([made(d=1.0, v=0.0, f=1e300)] * 3, [-0.3, 0.0, 0.3], 0.05)
    squares = [1.09, 1.0, 1.09]
    q, s2 = 1.06, 1.5 / 9.0 * sum((one - 1.06) ** 2 for one in squares)
    assert apart == pytest.approx(
        q + 0.03 + excess(2.0 * 1.09 ** 2 / s2, 0.05, 2) * math.sqrt(s2), rel=1e-12)


def test_one_run_alone_is_itself_among_several():
    one = made()
    assert pool([one]) is one
