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

"""A systematic error that moves from run to run binds in variant B."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare import analyze, Headings, Settings
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.record_conditions.mean_over_runs import judge_mean_over_runs
from heading_intercompare.core.statistics.stationarity import examine_homogeneity, RunFigures
from heading_intercompare.core.validity.condition import DOUBTFUL, HOLDS

N = 12_000
T_S = np.arange(1, N + 1) / 10.0
SHIP = 90.0 + 30.0 * np.sin(2.0 * np.pi * T_S / 900.0) + np.sin(2.0 * np.pi * T_S / 8.0)


def compare(means_deg, u_deg=0.01):
    """Return the comparison of runs with these means, each known to `u_deg`."""
    return examine_homogeneity([RunFigures(m, u_deg ** 2, 0.01, 100.0) for m in means_deg])


@pytest.mark.parametrize('means_deg, effect', [
    ((0.0, 0.0, 0.01), HOLDS), ((0.0, 0.05, -0.05), HOLDS), ((0.0, 0.4, -0.4), DOUBTFUL)])
def test_a_mean_binds_if_it_moves_significantly_and_far(means_deg, effect):
    """A third of 0.2 deg is 0.067 deg."""
    finding = judge_mean_over_runs(compare(means_deg), 0.2, Outcome.INDETERMINATE)
    assert finding.effect == effect
    assert ('by variant C indeterminate' in finding.words) == (effect == DOUBTFUL)


def test_a_single_run_has_no_such_finding():
    assert judge_mean_over_runs(compare((0.4,)), 0.2, Outcome.COMPLIANT) is None


@pytest.mark.parametrize('variant, effect', [('B', DOUBTFUL), ('C', HOLDS)])
def test_the_headline_of_the_campaign_says_so(rng, variant, effect):
    runs = []
    for day, mean_deg in enumerate((-0.3, 0.0, 0.3)):
        stamps = (1_800_000_000 + 86_400 * day) * 10 ** 9 + np.arange(N) * 10 ** 8
        runs.append([Headings.as_sent(stamps, SHIP + shift + 0.05 * rng.standard_normal(N))
                     for shift in (mean_deg, 0.0)])
    verdict = analyze([ts for ts, _ in runs], [rs for _, rs in runs], Settings.from_mapping({
        'variant': variant, 'norms': {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1}}))
    assert verdict.outcome is Outcome.COMPLIANT and verdict.validity_effect == effect
    said = 'and variant B takes it for the same'
    assert (said in verdict.headline) == (variant == 'B')
    assert [f.condition for f in verdict.campaign.validity] == (
        ['mean_over_runs'] if variant == 'B' else [])
