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

"""The split of variances: exact ones, negative ones, interpolation, and the range that is told."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from heading_intercompare.core.sensors.variance_split import PairVariance, split_variances
from heading_intercompare.core.statistics.cells import Cells
from heading_intercompare.core.statistics.variance_uncertainty import estimate_spread


@pytest.mark.parametrize('u_deg2', [0.0, 0.1])
def test_exact_variances_are_found(u_deg2):
    true = [1.0, 4.0, 9.0, 0.25]
    found = split_variances(4, [PairVariance(i, j, true[i] + true[j], u_deg2)
                                for i, j in combinations(range(4), 2)])
    assert [one.variance_deg2 for one in found] == pytest.approx(true)
    for one, v in zip(found, true):
        low, high = one.interval_deg2
        assert low - 1e-9 <= v <= high + 1e-9


def test_a_negative_variance_is_told_as_it_is():
    found = split_variances(3, [PairVariance(0, 1, 1.0, 0.01), PairVariance(0, 2, 1.0, 0.01),
                                PairVariance(1, 2, 4.0, 0.01)])
    assert found[0].variance_deg2 == pytest.approx(-1.0) and found[0].std_deg is None
    assert found[0].is_negative and not found[1].is_negative


def test_too_few_sensors_or_pairs():
    pairs = [PairVariance(0, 1, 1.0, 0.1), PairVariance(0, 2, 1.0, 0.1)]
    assert split_variances(2, pairs[:1]) is None
    assert split_variances(3, pairs) is None
    assert split_variances(3, []) is None


def test_the_factors_of_interpolation_widen_the_range():
    """White noise of 1 deg2 that shows only two thirds of itself where it is interpolated."""
    true, factor = [1.0, 1.0, 1.0], 2.0 / 3.0
    found = split_variances(3, [PairVariance(i, j, true[i] + factor * true[j], 1e-9, 1.0, factor)
                                for i, j in combinations(range(3), 2)])
    for one in found:
        low, high = one.interval_deg2
        assert low <= 1.0 <= high


def test_the_range_covers_the_truth_at_least_as_often_as_stated():
    rng = np.random.default_rng(8)
    true = [0.04, 0.01, 0.25]
    missed = 0
    for _ in range(200):
        errors = [np.sqrt(v) * rng.standard_normal(2000) for v in true]
        pairs = []
        for i, j in combinations(range(3), 2):
            spread = estimate_spread(Cells.of(errors[i] - errors[j]))
            pairs.append(PairVariance(i, j, spread.d_deg2, spread.s_deg2))
        found = split_variances(3, pairs)
        missed += sum(not one.interval_deg2[0] <= v <= one.interval_deg2[1]
                      for one, v in zip(found, true))
    assert missed <= 0.05 * 600
