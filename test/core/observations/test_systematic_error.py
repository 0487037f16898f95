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

"""The decision on a systematic error: by hand, its risks by simulation, its reasons."""

from __future__ import annotations

import math

from core.observations.make_corrections import corrections
import numpy as np
import pytest

from heading_intercompare.core.observations.systematic_error import judge_corrections
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.settings import Settings

NORM = Settings.of(systematic_max_deg=0.75)


def test_the_bounds_by_hand():
    """
    C - O of 0.1, 0.2, 0.3 and a shared 0.05 deg.

    u_A = 0.1 / sqrt(3) = 0.0577350; t(0.95; 2) = 2.919986, z(0.95) = 1.644854:
    0.2 + sqrt((2.919986 · 0.0577350)² + (1.644854 · 0.05)²) = 0.3875834.
    t(0.975; 2) = 4.302653, z(0.975) = 1.959964: 0.2 - 0.2669863 is below 0.
    """
    found = judge_corrections(corrections([0.1, 0.2, 0.3]), NORM, common_u_deg=0.05)
    assert found.high_deg == pytest.approx(0.2 + math.hypot(2.919986 * 0.0577350, 0.0822427))
    assert found.low_deg == 0.0
    assert found.outcome is Outcome.COMPLIANT and found.reason == 'bound_within_norm'
    assert found.correction_deg == pytest.approx(0.2)
    # s = 0.1 with 2 degrees of freedom: chi-square 5.991465 and 0.102587 at 5 % and 95 %.
    assert found.std_low_deg == pytest.approx(0.1 * math.sqrt(2 / 5.991465))
    assert found.std_high_deg == pytest.approx(0.1 * math.sqrt(2 / 0.102587), rel=1e-5)


def test_the_expanded_uncertainty_has_the_factor_of_student():
    """Ten observations, nothing shared: t(0.975; 9) = 2.262157."""
    found = judge_corrections(corrections(np.linspace(-0.1, 0.1, 10)), NORM, common_u_deg=0.0)
    assert found.nu == pytest.approx(9.0) and found.k == pytest.approx(2.262157)
    assert found.expanded_u_deg == pytest.approx(found.k * found.u_deg)


@pytest.mark.parametrize('sign', [-1.0, 1.0])
def test_an_error_far_above_the_norm_is_rejected_on_either_side(sign):
    found = judge_corrections(corrections(sign * np.array([1.4, 1.5, 1.6, 1.5])), NORM,
                              common_u_deg=0.1)
    assert found.outcome is Outcome.NON_COMPLIANT and found.reason == 'bound_above_norm'
    assert found.correction_deg == pytest.approx(sign * 1.5)


def test_what_all_share_decides_when_more_observations_do_not_help():
    found = judge_corrections(corrections(0.6 + np.tile([-0.01, 0.01], 50)), NORM,
                              common_u_deg=0.2)
    assert found.outcome is Outcome.INDETERMINATE and found.reason == 'reference_limited'
    assert found.n_needed is None


def test_few_observations_say_how_many_would_do():
    x = 0.5 + 0.2 * np.array([-1.0, 1.0, -1.0, 1.0])
    found = judge_corrections(corrections(x), NORM, common_u_deg=0.02)
    assert found.reason == 'data_limited' and found.n_needed > 4
    # As many with the same mean and scatter comply, one fewer does not.
    spread = found.std_deg * np.sqrt((found.n_needed - 1) / found.n_needed)
    for n, outcome in ((found.n_needed, Outcome.COMPLIANT),):
        signs = np.resize([-1.0, 1.0], n)
        signs = (signs - signs.mean()) / signs.std()
        again = judge_corrections(corrections(0.5 + spread * signs), NORM, common_u_deg=0.02)
        assert again.outcome is outcome


def test_too_few_no_norm_and_a_bearing_the_wrong_way_round_are_open():
    assert judge_corrections(corrections([]), NORM, common_u_deg=0.0).reason == (
        'insufficient_data')
    one = judge_corrections(corrections([0.1]), NORM, common_u_deg=0.0)
    assert one.reason == 'insufficient_data' and one.correction_deg == pytest.approx(0.1)
    assert one.high_deg is None
    free = judge_corrections(corrections([0.1, 0.2]), Settings(), common_u_deg=0.0)
    assert free.reason == 'no_norm' and free.high_deg is not None
    turned = judge_corrections(corrections([179.9, 179.8, 179.9]), NORM, common_u_deg=0.1)
    assert turned.outcome is Outcome.INDETERMINATE and turned.reason == 'void.mean_difference'


def test_one_wild_observation_decides_nothing():
    x = [0.10, 0.12, 0.11, 0.09, 0.10, 0.11, 3.0]
    found = judge_corrections(corrections(x), NORM, common_u_deg=0.01)
    assert found.questionable == (6,) and found.reason == 'outliers_decide'
    # Far from the norm it decides nothing, and is only marked.
    mild = judge_corrections(corrections([*x[:-1], 0.3]), NORM, common_u_deg=0.01)
    assert mild.questionable == (6,) and mild.outcome is Outcome.COMPLIANT


def test_a_preset_gives_the_norm_of_the_settle_point():
    """0.75 / cos 60° = 1.5; and 0.25 / cos 60° = 0.5 with a slow error stated widens."""
    settings = Settings.of(preset='imo_a821', norms_latitude_deg=60.0)
    found = judge_corrections(corrections([1.2, 1.21, 1.19]), settings, common_u_deg=0.05)
    assert found.norm_deg == pytest.approx(1.5) and found.outcome is Outcome.COMPLIANT
    slow = Settings.of(preset='imo_a821', norms_latitude_deg=60.0, sensor_class='gyrocompass')
    found = judge_corrections(corrections([1.2, 1.21, 1.19]), slow, common_u_deg=0.05)
    assert found.outcome is Outcome.INDETERMINATE


def simulate(rng, n, sigma, common, error, trials=2000):
    """Return the shares of compliant and non-compliant in simulated sets of observations."""
    counts = dict.fromkeys(Outcome, 0)
    for _ in range(trials):
        x = error + common * rng.standard_normal() + sigma * rng.standard_normal(n)
        counts[judge_corrections(corrections(x), NORM, common_u_deg=common).outcome] += 1
    return counts[Outcome.COMPLIANT] / trials, counts[Outcome.NON_COMPLIANT] / trials


@pytest.mark.parametrize('n, sigma, common', [
    (2, 0.2, 0.05), (3, 0.1, 0.1), (5, 0.3, 0.0), (10, 0.05, 0.2), (30, 0.2, 0.05)])
@pytest.mark.slow
def test_a_ts_at_its_norm_is_accepted_and_rejected_at_most_at_the_stated_risks(
        rng, n, sigma, common):
    """Six standard errors of 2000 trials at 5 % are 0.029."""
    accepted, rejected = simulate(rng, n, sigma, common, 0.75)
    assert accepted <= 0.05 + 0.029 and rejected <= 0.025 + 0.021


def test_a_shared_error_that_is_not_stated_breaks_the_risk(rng):
    """The same trials with 0.3 deg shared and 0 stated accept far too often: it must be stated."""
    stated, concealed = 0, 0
    for _ in range(300):
        x = 0.75 + 0.3 * rng.standard_normal() + 0.05 * rng.standard_normal(8)
        stated += judge_corrections(corrections(x), NORM,
                                    common_u_deg=0.3).outcome is Outcome.COMPLIANT
        concealed += judge_corrections(corrections(x), NORM,
                                       common_u_deg=0.0).outcome is Outcome.COMPLIANT
    assert stated / 300 <= 0.05 + 6 * math.sqrt(0.05 * 0.95 / 300)
    assert concealed / 300 > 0.3
