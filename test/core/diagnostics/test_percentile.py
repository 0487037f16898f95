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

"""The limit of 95 % of the differences: by hand, by simulation, and with too few of them."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.diagnostics.percentile import estimate_percentile


def test_the_limit_of_normal_errors_is_two_standard_deviations(rng):
    """1.96 of 0.1 deg; the bounds of 40000 are within 1 % of it."""
    limit = estimate_percentile(0.3 + 0.1 * rng.standard_normal(40_000), 0.3, 40_000.0)
    assert limit.limit_deg == pytest.approx(0.196, rel=0.02)
    assert limit.lower_deg < 0.196 < limit.upper_deg
    assert limit.upper_deg - limit.lower_deg < 0.03 * limit.limit_deg


def test_the_bounds_hold_the_limit_in_nineteen_of_twenty(rng):
    """400 records of 500 white differences: 380 are expected, 360 is 4.6 standard deviations."""
    limits = [estimate_percentile(rng.laplace(size=500), 0.0, 500.0) for _ in range(400)]
    true_deg = -np.log(0.05)
    assert sum(one.lower_deg <= true_deg <= one.upper_deg for one in limits) > 360


def test_few_independent_differences_have_no_upper_bound(rng):
    x = rng.standard_normal(1000)
    assert estimate_percentile(x, 0.0, 30.0).upper_deg is None
    assert estimate_percentile(x, 0.0, 19.0) is None
    assert estimate_percentile(x[:0], 0.0, 0.0) is None


def test_correlated_differences_have_wider_bounds(rng):
    x = rng.standard_normal(1000)
    wide, narrow = (estimate_percentile(x, 0.0, n) for n in (150.0, 1000.0))
    assert wide.limit_deg == narrow.limit_deg
    assert wide.lower_deg < narrow.lower_deg and wide.upper_deg > narrow.upper_deg
