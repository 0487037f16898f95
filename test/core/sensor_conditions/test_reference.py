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

"""An RS out of its own norm rejects no TS, and excuses none that breaks its own."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter
from trials import find_finding, judge_headings

from heading_intercompare import analyze, Headings, Settings
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.validity.condition import HOLDS, NOT_TESTABLE, VOID

NORMS = {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1}


def judge(rng, *, ts_deg, rs_deg, hz=10, rs_step_deg=0.0, yaw_deg=1.0, ts_scale=1.0):
    """Judge half an hour of white errors of these standard deviations, degrees."""
    n = 1800 * hz
    t = np.arange(1, n + 1) / hz
    yaw = yaw_deg * np.sin(2.0 * np.pi * t / 8.0 + np.sin(t / 40.0))
    course = 90.0 + 40.0 * np.sin(2.0 * np.pi * t / 600.0)
    ts = course + ts_scale * yaw + ts_deg * rng.standard_normal(n)
    rs = course + yaw + rs_deg * rng.standard_normal(n)
    if rs_step_deg:
        rs = np.round(rs / rs_step_deg) * rs_step_deg
    stamps = 10 ** 18 + np.arange(1, n + 1) * (10 ** 9 // hz)
    return judge_headings(np.round(ts, 3), np.round(rs, 3), stamps, norms=NORMS)


@pytest.mark.slow
@pytest.mark.parametrize('hz', [1, 10])
@pytest.mark.parametrize('noise', [{'rs_deg': 0.3}, {'rs_deg': 0.05, 'rs_step_deg': 1.0}])
def test_an_rs_out_of_its_norm_rejects_no_ts(rng, hz, noise):
    """White noise of three norms, or whole degrees: both were NON-COMPLIANT, firm."""
    verdict = judge(rng, ts_deg=0.1, hz=hz, **noise)
    assert verdict.runs[0].reason == 'void.reference'
    assert verdict.headline.startswith('INDETERMINATE, VOID: the RS breaks its norm of 0.1 deg')


@pytest.mark.slow
@pytest.mark.parametrize('hz', [1, 10])
def test_a_ts_that_breaks_its_norm_without_the_excess_stays_rejected(rng, hz):
    """0.6² + 0.3² less the excess of 0.3² - 0.1² is far above 0.2² + 0.1²."""
    verdict = judge(rng, ts_deg=0.6, rs_deg=0.3, hz=hz)
    assert verdict.outcome is Outcome.NON_COMPLIANT
    assert find_finding(verdict.runs[0], 'reference').effect == HOLDS
    assert 'the outcome is the same without the excess' in (
        find_finding(verdict.runs[0], 'reference').evidence)


def test_a_rejection_says_what_it_rests_on(rng):
    verdict = judge(rng, ts_deg=0.6, rs_deg=0.05)
    assert verdict.headline.endswith(
        '(rests on the RS meeting its norm; which of the two is wrong is not shown)')


@pytest.mark.parametrize('rs_deg', [0.05, 0.1])
def test_a_sound_rs_is_not_blamed(rng, rs_deg):
    found = find_finding(judge(rng, ts_deg=0.1, rs_deg=rs_deg).runs[0], 'reference')
    assert found.effect == HOLDS and 'its norm is 0.1 deg' in found.evidence


@pytest.mark.slow
def test_a_ts_of_another_scale_is_not_taken_for_noise_of_the_rs(rng):
    """A tenth of a yaw of 3 deg: an error in proportion to the motion is rejected, not void."""
    verdict = judge(rng, ts_deg=0.1, rs_deg=0.05, yaw_deg=6.0, ts_scale=0.9)
    assert verdict.outcome is Outcome.NON_COMPLIANT
    assert find_finding(verdict.runs[0], 'reference').effect in (HOLDS, NOT_TESTABLE)


@pytest.mark.slow
def test_coloured_noise_that_shows_is_void_too(rng):
    n = 18_000
    t = np.arange(1, n + 1) / 10.0
    ship = 90.0 + 40.0 * np.sin(2.0 * np.pi * t / 600.0)
    noise = 0.3 * lfilter([np.sqrt(1.0 - 0.8 ** 2)], [1.0, -0.8], rng.standard_normal(n))
    stamps = 10 ** 18 + np.arange(1, n + 1) * 10 ** 8
    verdict = analyze(Headings.as_sent(stamps, ship + 0.1 * rng.standard_normal(n)),
                      Headings.as_sent(stamps, ship + noise),
                      Settings.from_mapping({'norms': NORMS}))
    assert find_finding(verdict.runs[0], 'reference').effect == VOID
