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

"""The analysed part of a run: GK (4) with and without a drift removed."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.diagnostics.run_columns import prepare_run
from heading_intercompare.core.pairing.difference import subtract
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.runs.run_series import RunSeries
from heading_intercompare.core.settings import Settings

S = 1_000_000_000


def taken(x, **names):
    settings = Settings.from_mapping({
        'norms.sigma_max_deg': 0.2, 'norms.sigma_ref_max_deg': 0.1,
        **{k.replace('__', '.'): v for k, v in names.items()}})
    run = RunSeries(S, settings)
    n = len(x)
    pairs = Pairs.of(S * np.arange(1, n + 1), 100.0 + np.asarray(x), np.full(n, 100.0))
    run.update(pairs, subtract(pairs))
    return prepare_run(run, Limits.of(settings.norms), settings)


def test_the_variance_by_hand():
    """1, 2, 6: (4 + 1 + 9) / 2 = 7."""
    found = taken([1.0, 2.0, 6.0])
    assert found.variance_deg2 == pytest.approx(7.0) and found.coefficients_deg == ()
    assert [found.count_outside('B', limit) for limit in (0.9, 1.1, 2.1, 3.1)] == [3, 2, 1, 0]
    assert [found.count_outside('A', limit) for limit in (0.9, 1.1, 2.1, 6.1)] == [3, 2, 1, 0]


def test_a_line_costs_a_degree_of_freedom():
    """0, 1, 2, 3 and 1, -1, -1, 1 on top: squares 4, over 4 - 1 - 1 = 2."""
    found = taken([1.0, 0.0, 1.0, 4.0], drift_order=1)
    assert found.variance_deg2 == pytest.approx(2.0)
    assert found.residual_deg == pytest.approx([1.0, -1.0, -1.0, 1.0])
    assert found.coefficients_deg == pytest.approx((1.5, 1.5))


def test_the_variance_is_that_of_an_independent_fit(rng):
    x = 0.1 * rng.standard_normal(500) + np.linspace(0, 1, 500) ** 3
    for order in (0, 1, 2, 3):
        residual = x - np.polyval(np.polyfit(np.arange(500), x, order), np.arange(500))
        found = taken(x, drift_order=order)
        assert found.variance_deg2 == pytest.approx(residual @ residual / (499 - order), rel=1e-9)


@pytest.mark.parametrize('order, n', [(0, 1), (1, 2), (3, 4)])
def test_too_few_differences_have_no_variance(order, n):
    assert taken(np.arange(n, dtype=float), drift_order=order).variance_deg2 is None


def test_nothing_at_all_is_nothing():
    found = taken([])
    assert found.moments.n == 0 and found.variance_deg2 is None and found.span_s == 0.0
