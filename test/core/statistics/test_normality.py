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

"""Normality: by hand, against scipy, on real logs, and by the rate of false alarms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import special, stats

from heading_intercompare.core.statistics import blocking
from heading_intercompare.core.statistics.autocorrelation import effective_size
from heading_intercompare.core.statistics.normality import (
    apply_anderson_darling,
    examine_normality,
    measure_shape,
    moving_average_residual,
    symmetric_difference,
    thin,
)

PAIRS = ['gyr1-s330', 'gyr1-seap', 's330-gyr1', 'seap-s330', 'adcp-seap', 'lgyr-lsep',
         'lsep-lgyr']


# --- moments ---

def test_shape_by_hand():
    """Eight values, half 0 and half 2: g_1 = 0, m_4/m_2^2 = 1, g_2 = -2."""
    found = measure_shape([0.0, 2.0] * 4)
    assert (found.skewness, found.excess_kurtosis) == (0.0, -2.0)
    assert found.kurtosis_z == pytest.approx(-2.0 * math.sqrt(8.0 / 24.0))
    assert found.jarque_bera == pytest.approx(4.0 / 3.0)
    assert found.p == pytest.approx(math.exp(-2.0 / 3.0))
    assert found.std_deg == pytest.approx(math.sqrt(8.0 / 7.0))


def test_shape_agrees_with_scipy(rng):
    x = 100.0 + rng.gamma(3.0, 1.0, 300_000)
    found = measure_shape(x)
    assert found.skewness == pytest.approx(stats.skew(x), rel=1e-9)
    assert found.excess_kurtosis == pytest.approx(stats.kurtosis(x), rel=1e-9)
    assert found.jarque_bera == pytest.approx(stats.jarque_bera(x).statistic, rel=1e-9)


def test_shape_depends_neither_on_mean_nor_on_scale(rng):
    x = rng.standard_normal(1000)
    assert measure_shape(170.0 - 0.1 * x).skewness == pytest.approx(-measure_shape(x).skewness,
                                                                    rel=1e-9)
    assert measure_shape(170.0 - 0.1 * x).p == pytest.approx(measure_shape(x).p, rel=1e-9)


def test_correlated_normal_values_are_normal_at_their_effective_size(ar1):
    """Of 200 at 1 %, 11 would be six standard errors too many; at the full n most reject."""
    runs = [ar1(4000, 20.0) for _ in range(200)]
    effective = sum(measure_shape(x, effective_size(x)).p < 0.01 for x in runs)
    assert effective < 11
    assert sum(measure_shape(x).p < 0.01 for x in runs) > 100


@pytest.mark.parametrize('values', [[], [1.0], [0.3] * 7])
def test_too_few_values_have_no_shape(values):
    found = measure_shape(values)
    assert (found.n, found.skewness, found.p) == (len(values), None, None)
    assert (found.std_deg is None) == (len(values) < 2)


def test_equal_values_have_no_shape():
    assert measure_shape(np.full(100, 0.1)).p is None
    assert measure_shape(np.full(100, 0.1)).std_deg == 0.0


# --- distribution ---

def test_anderson_darling_agrees_with_its_integral(rng):
    """The integral of n (F_n - F)^2 / [F (1 - F)] dF, by the midpoint rule."""
    x = 5.0 + rng.standard_normal(60)
    z = np.sort((x - x.mean()) / x.std(ddof=1))
    f = (np.arange(2_000_000) + 0.5) / 2_000_000
    steps = np.searchsorted(stats.norm.cdf(z), f, side='right') / 60
    expected = 60 * np.mean((steps - f) ** 2 / (f * (1.0 - f)))
    assert apply_anderson_darling(x).statistic == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize('level, statistic', [(0.15, 0.561), (0.10, 0.631), (0.05, 0.752),
                                              (0.025, 0.873), (0.01, 1.035)])
def test_p_of_anderson_darling_has_its_published_quantiles(level, statistic, monkeypatch):
    """Agree with D'Agostino & Stephens 1986, table 4.7, case 3, at n -> infinity; to 3 %."""
    n = 100_000
    x = np.sort(np.random.default_rng(1).standard_normal(n))
    base = apply_anderson_darling(x).statistic
    monkeypatch.setattr(special, 'log_ndtr', lambda z, f=special.log_ndtr: (
        f(z) - 0.5 * (statistic - base) / n))
    found = apply_anderson_darling(x)
    assert found.statistic == pytest.approx(statistic, rel=1e-6)
    assert found.p == pytest.approx(level, rel=0.03)


def test_far_values_do_not_overflow():
    found = apply_anderson_darling([0.0] * 999 + [1e6])
    assert found.p == 3.7e-24
    assert math.isfinite(found.statistic)


def test_no_anderson_darling_of_too_few_or_equal_values():
    assert apply_anderson_darling([]) is None
    assert apply_anderson_darling(np.arange(7.0)) is None
    assert apply_anderson_darling(np.full(20, 0.1)) is None


@pytest.mark.parametrize('name', PAIRS)
def test_normality_of_real_logs_agrees_with_independent_programs(name, real, golden):
    _, x = real(name)
    few, step = thin(x)
    for values, expected in ((x, golden['pairs'][name]['normality']['full']),
                             (few, golden['pairs'][name]['normality']['thinned'])):
        moments, distance = measure_shape(values), apply_anderson_darling(values)
        got = {'g1': moments.skewness, 'g2': moments.excess_kurtosis, 'JB': moments.jarque_bera,
               'JB_p': moments.p, 'A2': distance.statistic, 'A2star': distance.adjusted,
               'A2_p': distance.p}
        assert got == pytest.approx({key: expected[key] for key in got}, rel=1e-7)
    assert (step, few.size) == (expected['step'], expected['n'])


# --- noise of one sensor ---

def test_symmetric_differences_by_hand():
    assert symmetric_difference([359.0, 0.0, 2.0, 5.0]).tolist() == [-3.0, -5.0]
    assert symmetric_difference([]).size == symmetric_difference([1.0, 2.0]).size == 0


def test_moving_average_by_hand():
    """359, 361, 360 and 361, 360, 365 about 360 and 362."""
    assert moving_average_residual([359.0, 1.0, 0.0, 5.0], 3) == pytest.approx([1.0, -2.0])
    assert moving_average_residual([1.0, 2.0], 3).size == moving_average_residual([], 3).size == 0


@pytest.mark.parametrize('width', [1, 4, -3])
def test_a_moving_average_has_a_middle(width):
    with pytest.raises(ValueError, match=f'width = {width}'):
        moving_average_residual(np.zeros(10), width)


def test_a_straight_turn_leaves_no_residual():
    assert np.abs(moving_average_residual(np.arange(1000.0) * 3.7 % 360.0, 11)).max() < 1e-9
    assert symmetric_difference(np.arange(100.0) * 3.0 % 360.0) == pytest.approx(-6.0)


def test_white_noise_passes_with_the_factors_of_the_docstrings(rng):
    """Sqrt(2) and sqrt(1 - 1/W), over north; six standard errors, doubled for correlation."""
    noise = 0.1 * rng.standard_normal(100_000)
    heading = noise % 360.0
    tolerance = 12.0 / math.sqrt(2.0 * noise.size)
    assert symmetric_difference(heading).std() == pytest.approx(0.1 * math.sqrt(2.0),
                                                                rel=tolerance)
    assert moving_average_residual(heading, 5).std() == pytest.approx(
        0.1 * math.sqrt(0.8), rel=tolerance)


# --- a run ---

def test_a_run_of_normal_noise(rng):
    n = 5000
    heading = 100.0 + 5.0 * np.sin(np.arange(n) / 300.0)
    ts = np.round(heading + 0.1 * rng.standard_normal(n), 1)
    rs = heading + 0.05 * rng.standard_normal(n)
    found = examine_normality(ts - rs, ts, rs, n_effective=n)
    assert found.difference.p > 1e-4
    assert found.thinned_n == -(-n // found.thinned_step)
    assert (found.ts_step_deg, found.rs_step_deg) == (pytest.approx(0.1), None)
    assert found.rounding_variance_deg2 == pytest.approx(0.01 / 12.0)
    assert found.ts_moving_average.std_deg == pytest.approx(
        math.sqrt((0.01 + 0.01 / 12.0) * 2.0 / 3.0), rel=0.05)


def test_long_headings_are_looked_at_in_stretches(rng, monkeypatch):
    heading = rng.standard_normal(40_000)
    whole = examine_normality(heading, heading, heading, n_effective=1.0)
    monkeypatch.setattr(blocking, '_MOST', 16_000)
    monkeypatch.setattr(blocking, '_STRETCH', 1000)
    parts = examine_normality(heading, heading, heading, n_effective=1.0)
    assert parts.difference == whole.difference
    assert parts.ts_first_difference.n == 16 * 998
    assert parts.ts_first_difference.std_deg == pytest.approx(
        whole.ts_first_difference.std_deg, rel=0.05)


@pytest.mark.parametrize('n', [0, 1, 2, 7])
def test_a_run_of_too_few_samples_is_not_tested(n):
    found = examine_normality(np.zeros(n), np.zeros(n), np.zeros(n), n_effective=float(n))
    assert (found.difference.p, found.anderson_darling, found.thinned_n) == (None, None, n)
    assert found.ts_first_difference.n == max(0, n - 2)
