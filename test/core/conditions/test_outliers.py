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

"""Outliers: planted ones are named, and values that only look like outliers are not."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.core.conditions.outliers import find_outliers


def stamps(n, rate=10):
    return np.arange(n) * (10 ** 9 // rate)


def test_one_bad_reading_of_twelve_thousand_by_hand(rng):
    """
    40 deg beside sigma 0.1 and n = 12000.

    The 90 % quantile of |x| is 0.1645, the point 0.1645 (1 + (ln 1200 + 5) / ln 10) = 1.03; the
    share is (40^2 / 12000) / (40^2 / 12000 + 0.01) = 0.93.
    """
    x = 0.1 * rng.standard_normal(12_000)
    x[7000] = 40.0
    found = find_outliers(stamps(12_000), x)
    assert (found.kind, found.index.tolist(), found.count) == ('found', [7000], 1)
    (one,) = found.largest
    assert (one.index, one.n, one.stamp_ns) == (7000, 1, 700 * 10 ** 9)
    assert one.size_deg == pytest.approx(40.0, abs=0.2)
    assert found.threshold_deg == pytest.approx(
        0.1645 * (1.0 + (math.log(1200.0) + 5.0) / math.log(10.0)), rel=0.05)
    assert found.share == pytest.approx(0.93, abs=0.01)
    assert found.variance_without_deg2 == pytest.approx(np.var(np.delete(x, 7000), ddof=1))
    assert found.variance_deg2 == pytest.approx(np.var(x, ddof=1))


def test_a_bad_reading_of_an_interpolated_rs_is_one_outlier(rng):
    """It draws a triangle of two seconds: 19 pairs at 10 Hz, most of them far out."""
    x = 0.1 * rng.standard_normal(6000)
    x[3000:3021] += 20.0 * (1.0 - np.abs(np.arange(21) - 10.0) / 10.0)
    found = find_outliers(stamps(6000), x)
    assert (found.count, found.largest[0].index) == (1, 3010)
    assert found.largest[0].size_deg == pytest.approx(20.0, abs=0.5)
    assert set(range(3002, 3019)) <= set(found.index.tolist()) <= set(range(2999, 3022))


@pytest.mark.parametrize('law', [
    lambda rng, n: rng.standard_normal(n), lambda rng, n: rng.uniform(-1.7, 1.7, n),
    lambda rng, n: np.round(rng.standard_normal(n) / 3.0) * 3.0])
def test_normal_uniform_and_coarse_differences_have_none(law, rng):
    for n in (100, 1000, 12_000):
        for _ in range(30):
            assert find_outliers(stamps(n), law(rng, n), step_deg=3.0).kind == 'none'


@pytest.mark.parametrize('law, most', [
    (lambda rng, n: rng.laplace(size=n), 0.1), (lambda rng, n: rng.standard_t(5, n), 0.1)])
def test_heavy_tails_have_few_that_do_not_matter(law, most, rng):
    found = [find_outliers(stamps(12_000), law(rng, 12_000)) for _ in range(30)]
    assert sum(f.count for f in found) <= 60
    assert max(f.share for f in found) < most


def test_correlated_errors_have_none_but_show_a_spike(ar1):
    for _ in range(20):
        x = ar1(12_000, 300.0)
        assert find_outliers(stamps(12_000), x).kind == 'none'
        x[5000] += 30.0
        assert find_outliers(stamps(12_000), x).index.tolist() == [5000]


def test_a_slow_excursion_is_none(rng):
    """Half a minute at 15 deg, and a bump as long: not isolated, but counted."""
    x = 0.1 * rng.standard_normal(12_000)
    x[2000:2300] += 15.0
    x += 20.0 * np.exp(-0.5 * ((np.arange(12_000) - 8000.0) / 50.0) ** 2)
    found = find_outliers(stamps(12_000), x)
    assert (found.kind, found.index.size) == ('none', 0)
    assert found.excursions >= 2


def test_a_spike_on_constant_differences():
    """The median distance is zero, so any change of more than three steps is far out."""
    x = np.full(500, 0.3)
    x[[100, 300]] = -39.7, 0.4
    assert find_outliers(stamps(500), x).index.tolist() == [100, 300]
    found = find_outliers(stamps(500), x, step_deg=0.1)
    assert (found.index.tolist(), found.share) == ([100], pytest.approx(1.0, abs=1e-4))
    assert found.largest[0].size_deg == pytest.approx(-40.0)


def test_ten_are_named_the_largest_first(rng):
    x = 0.1 * rng.standard_normal(10_000)
    at = np.arange(100, 10_000, 500)
    x[at] = 5.0 + np.arange(at.size)
    found = find_outliers(stamps(10_000), x)
    assert found.index.tolist() == at.tolist()
    assert [o.index for o in found.largest] == at[::-1][:10].tolist()


def test_outliers_at_both_ends(rng):
    x = 0.1 * rng.standard_normal(1000)
    x[[0, -1]] = 30.0, -30.0
    assert find_outliers(stamps(1000), x).index.tolist() == [0, 999]


def test_shifting_turning_and_reversing_change_nothing(rng):
    x = 0.1 * rng.standard_normal(3000)
    x[[10, 2000]] = 9.0, -7.0
    here = find_outliers(stamps(3000), x)
    there = find_outliers(stamps(3000) + 10 ** 18, 50.0 - x[::-1])
    assert there.index.tolist() == [999, 2989]
    assert there.share == pytest.approx(here.share)
    assert there.threshold_deg == pytest.approx(here.threshold_deg)


@pytest.mark.parametrize('name', ['gyr1-s330', 'seap-s330', 'lgyr-lsep', 'adcp-s330'])
def test_real_differences_have_none(name, real):
    pairs, x = real(name)
    assert find_outliers(pairs.stamp_ns, x).kind == 'none'


@pytest.mark.parametrize('n', [0, 1, 29])
def test_too_few_differences_are_not_testable(n):
    found = find_outliers(stamps(n), np.zeros(n))
    assert (found.kind, found.index.size, found.variance_deg2) == ('not_testable', 0, None)


def test_equal_differences_have_no_share():
    found = find_outliers(stamps(100), np.full(100, 2.0))
    assert (found.kind, found.share, found.variance_deg2) == ('none', 0.0, 0.0)
