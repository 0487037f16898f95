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

"""The criteria as printed, joined: worked by hand."""

from __future__ import annotations

import pytest

from heading_intercompare.core.decision.criteria import apply_gk, Limits
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.settings import Settings

C, I, N = Outcome.COMPLIANT, Outcome.INDETERMINATE, Outcome.NON_COMPLIANT


def printed(variance, counts, n=1000, mean=0.0, **norms):
    settings = Settings.from_mapping({'norms': {
        'sigma_max_deg': 0.3, 'sigma_ref_max_deg': 0.4, 'm_low': 0.5, **norms}})
    limits = Limits.of(settings.norms, settings.model)
    given = iter(counts)
    return apply_gk(n, mean, variance, lambda limit: next(given), limits, settings)


@pytest.mark.parametrize('variance, counts, outcome', [
    (0.13, (0, 3), C), (0.1301, (0, 3), I), (0.25, (0, 3), I), (0.2501, (0, 3), N),
    (0.1, (3, 3), C), (0.1, (3, 4), I), (0.1, (4, 4), N)])
def test_the_worst_of_variance_and_counts(variance, counts, outcome):
    """0.3^2 + (0.5 0.4)^2 = 0.13, 0.3^2 + 0.4^2 = 0.25; 1000 (1 - 0.997) = 3."""
    found = printed(variance, counts)
    assert found.outcome is outcome
    assert (found.counts.n_plus, found.counts.n_plus_plus) == counts
    assert found.counts.allowed == 3.0


def test_the_total_error_counts_if_it_has_a_norm():
    """sigma_up = sqrt(0.1 - 0.04) = 0.2449; times 3: 0.7348, about a mean of 0.1: 0.8348."""
    norms = {'k_rule': 'three', 'total_error_max_deg': 0.84}
    found = printed(0.1, (0, 0), mean=0.1, **norms)
    assert found.total.up_deg == pytest.approx(0.8348, abs=1e-4)
    assert found.outcome is C
    assert printed(0.1, (0, 0), mean=0.1, **{**norms, 'total_error_max_deg': 0.83}).outcome is I


@pytest.mark.parametrize('k_rule, k', [('three', 3.0), (2.5, 2.5), ('exact', 2.967738)])
def test_k_of_the_total_error_follows_its_rule(k_rule, k):
    assert printed(0.1, (0, 0), k_rule=k_rule).total.k == pytest.approx(k, abs=1e-6)


def test_too_few_differences_are_indeterminate():
    assert printed(None, (0, 0), n=1, mean=0.0).outcome is I
