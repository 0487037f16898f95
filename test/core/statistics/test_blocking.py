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

"""Block means: by hand, against simulated correlated sums, and at the smallest sizes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.core.statistics.blocking import (
    average,
    Averages,
    block_means,
    block_size,
    pick_stretches,
    samples_per_average,
    student_95,
    sum_covariance,
)
from heading_intercompare.core.statistics.cells import Cells


@pytest.mark.parametrize('n, least, size', [(0, 16, 0), (15, 16, 0), (16, 16, 1), (31, 16, 1),
                                            (32, 16, 2), (1000, 64, 8), (1 << 20, 16, 1 << 16)])
def test_block_size_by_hand(n, least, size):
    assert block_size(n, least) == size


def test_there_are_at_least_as_many_blocks_as_asked_for_and_less_than_twice_as_many():
    for n in range(16, 2000):
        assert 16 <= n // block_size(n, 16) < 32


def test_block_means_drop_the_incomplete_block():
    assert block_means([1.0, 3.0, 5.0, 7.0, 100.0], 2).tolist() == [2.0, 6.0]
    assert block_means([[1.0, 0.0], [3.0, 4.0]], 2).tolist() == [[2.0, 2.0]]
    assert block_means([], 4).size == 0


def test_the_covariance_of_a_sum_by_hand():
    """Sixteen blocks of one, half 1 and half -1: variance 16/15, times n = 16."""
    covariance, dof = sum_covariance([1.0, -1.0] * 8)
    assert (float(covariance), dof) == (pytest.approx(16.0 * 16.0 / 15.0), 15)


def test_the_covariance_of_a_sum_allows_for_correlation(ar1):
    """
    The ratio to the truth has relative standard error sqrt(2 / (400 dof)): six of them.

    The truth for AR(1) is n (1 + phi)/(1 - phi), the end of the record neglected.
    """
    phi, n = math.exp(-1.0 / 3.0), 4000
    ratio = np.mean([float(sum_covariance(ar1(n, 3.0))[0]) for _ in range(400)])
    ratio /= n * (1.0 + phi) / (1.0 - phi)
    assert ratio == pytest.approx(1.0, abs=6.0 * math.sqrt(2.0 / (400 * 30)) + 6.0 / 128)


def test_fewer_terms_than_blocks_are_refused():
    with pytest.raises(ValueError, match='15 terms'):
        sum_covariance(np.zeros(15))


def test_student_factors_of_the_table():
    assert [round(student_95(f), 3) for f in (1, 10, 30)] == [12.706, 2.228, 2.042]
    assert student_95(0) == math.inf


@pytest.mark.parametrize('size', [1, 2, 3, 4, 8, 12, 16, 32, 64, 4096])
def test_means_of_short_blocks_are_those_of_the_plain_sum(size, rng):
    x = 100.0 + rng.standard_normal(70_000)
    expected = [x[lo:lo + size].mean() for lo in range(0, x.size // size * size, size)]
    assert block_means(x, size) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize('n', [0, 1, 100, 262_144, 262_145, 300_000, 524_288, 4_319_999, 10 ** 8])
def test_a_long_record_leaves_131072_to_262144_averages(n):
    size = samples_per_average(n)
    assert size & (size - 1) == 0
    assert n // size <= 262_144 and (size == 1 or n // size >= 131_072)


@pytest.mark.parametrize('size', [1, 2, 8, 64, 1024])
def test_averages_in_pieces_are_those_of_the_whole(rng, size):
    for n in (size - 1, size, 3 * size + 1, 70_001):
        x = rng.standard_normal(n)
        assert average(x, size).tolist() == block_means(x, size).tolist()
        stamps = 10 ** 18 + np.cumsum(rng.integers(1, 10 ** 9, n))
        expected = block_means(stamps - stamps[0], size) if n else np.empty(0)
        assert average(stamps, size) == pytest.approx(expected, rel=1e-15)


def test_stretches_cover_a_short_record_and_both_ends_of_a_long_one():
    assert pick_stretches(262_144) == [slice(0, 262_144)]
    parts = pick_stretches(262_145)
    assert (parts[0].start, parts[-1].stop) == (0, 262_145)
    assert {part.stop - part.start for part in parts} == {16_384}
    assert all(a.stop <= b.start for a, b in zip(parts, parts[1:]))


def test_averages_keep_the_variance(rng):
    """What the averages lose is within their blocks; the last block is incomplete."""
    n = 300_001
    x, stamps = 50.0 + rng.standard_normal(n), 10 ** 18 + 10 ** 7 * np.arange(n)
    found = Averages.of(stamps, x)
    assert (found.n, found.size, found.x_deg.size) == (n, 2, 150_000)
    assert found.within_deg2 + np.var(found.x_deg) == pytest.approx(np.var(x[:-1]), rel=1e-12)
    assert found.stamp_ns[:2].tolist() == [stamps[0] + 5 * 10 ** 6, stamps[2] + 5 * 10 ** 6]
    values, whole = Cells.of(found.x_deg, found.stamp_ns).values(), Cells.of(x, stamps).values()
    assert found.with_noise(values).mean_square_deg2 == pytest.approx(
        whole.mean_square_deg2, rel=1e-5)
    assert found.with_noise(values).n == n and found.with_noise(None) is None


def test_a_short_record_is_its_own_average(rng):
    x = rng.standard_normal(1000)
    found = Averages.of(np.arange(1000), x)
    assert found.x_deg.tolist() == x.tolist() and (found.size, found.within_deg2) == (1, 0.0)
    values = Cells.of(x).values()
    assert values is not None and found.with_noise(values) is values
