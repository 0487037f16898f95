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

"""Assumptions of GK that the data refute bind where they decide, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest
from trials import find_finding, judge_headings

from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.validity.condition import DOUBTFUL, HOLDS

N = 18_000
T_S = np.arange(1, N + 1) / 10.0
STAMPS = 1_800_000_000 * 10 ** 9 + np.arange(1, N + 1) * 10 ** 8
SHIP = 90.0 + 30.0 * np.sin(2.0 * np.pi * T_S / 900.0) + np.sin(2.0 * np.pi * T_S / 8.0)


def judge(error_deg, rng, ship=SHIP, **settings):
    """Judge a TS with these errors against an RS with 0.05 deg of white noise."""
    return judge_headings(ship + error_deg, ship + 0.05 * rng.standard_normal(N), STAMPS,
                          norms={'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1}, **settings)


def test_a_mean_beside_zero_is_doubtful_in_variant_a_and_says_what_b_decides(rng):
    errors = 0.4 + 0.05 * rng.standard_normal(N)
    verdict = judge(errors, rng, variant='A')
    assert verdict.outcome is Outcome.COMPLIANT and verdict.validity_effect == DOUBTFUL
    assert ('DOUBTFUL: the mean difference is 0.4 deg, and variant A takes it for zero; by '
            'variant B compliant') in verdict.headline
    assert judge(errors, rng, variant='B').validity_effect == HOLDS


def test_a_rejection_that_variant_b_confirms_is_not_doubtful(rng):
    verdict = judge(0.4 + 0.5 * rng.standard_normal(N), rng, variant='A')
    assert verdict.outcome is Outcome.NON_COMPLIANT
    assert find_finding(verdict.runs[0], 'assumptions').effect == HOLDS
    assert 'violated: (e)' in find_finding(verdict.runs[0], 'assumptions').evidence


@pytest.mark.slow
def test_a_dependence_on_the_heading_that_decides_is_named(rng):
    ship = 1.2 * T_S % 360.0
    errors = 0.6 * np.sin(np.radians(ship)) + 0.05 * rng.standard_normal(N)
    verdict = judge(errors, rng, ship)
    assert verdict.outcome is Outcome.NON_COMPLIANT
    assert find_finding(verdict.runs[0], 'assumptions').effect == DOUBTFUL
    assert 'the difference depends on the heading, by up to 0.6 deg, without that compliant' in (
        verdict.headline)


@pytest.mark.parametrize('errors', [
    lambda rng: 0.1 * rng.standard_normal(N), lambda rng: 0.07 * rng.laplace(size=N),
    lambda rng: rng.uniform(-0.3, 0.3, N), lambda rng: 0.5 * rng.standard_normal(N)],
    ids=['normal', 'heavy tails', 'uniform', 'bad'])
def test_significance_alone_does_not_bind(errors, rng):
    assert find_finding(judge(errors(rng), rng).runs[0], 'assumptions').effect == HOLDS
