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

"""Readings that their own sensor calls poor: named, and doubtful only where they decide."""

from __future__ import annotations

import numpy as np
import pytest
from trials import find_finding, make_settings

from heading_intercompare import Headings, Verdict
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.pipeline import Intercomparison
from heading_intercompare.core.records import Quality, QUALITY_FLAGS
from heading_intercompare.core.validity.condition import DOUBTFUL, HOLDS, NOT_TESTABLE
from heading_intercompare.core.verdict.consistency import check_consistency

NORMAL, FLOAT = QUALITY_FLAGS.index('normal'), QUALITY_FLAGS.index('float solution')
N = 3600
STAMPS = 1_800_000_000 * 10 ** 9 + np.arange(N) * 10 ** 9
#: Thirty stretches of 20 s at unequal distances.
POOR = np.isin(np.arange(N) // 20, np.random.default_rng(7).choice(N // 20, 30, replace=False))
ALL = np.ones(N, bool)
NORMS = {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1}


def judge(rng, poor, *, of='rs', error_deg=0.0, stated_deg=np.nan, ts_deg=0.08, rs_deg=0.02):
    """Judge an hour; the sensor that calls some readings poor errs by more there."""
    ship = 180.0 + 30.0 * np.sin(np.arange(N) / 60.0)
    streams = {'ts': ship + ts_deg * rng.standard_normal(N),
               'rs': ship + rs_deg * rng.standard_normal(N)}
    streams[of] = streams[of] + np.where(poor, error_deg * rng.standard_normal(N), 0.0)
    comparison = Intercomparison(make_settings(NORMS))
    comparison.take_quality(of, Quality.of(STAMPS, np.full(N, stated_deg),
                                           np.where(poor, FLOAT, NORMAL)))
    comparison.update(*(Headings.of(STAMPS, streams[name]) for name in ('ts', 'rs')))
    comparison.finish()
    return comparison.verdict()


def test_poor_readings_that_decide_make_the_outcome_doubtful(rng):
    """A sixth of the readings errs by 0.8 deg: 0.08² + 0.64 / 6 is rejected, 0.08² complies."""
    verdict = judge(rng, POOR, of='ts', error_deg=0.8)
    run = verdict.runs[0]
    assert verdict.outcome is Outcome.NON_COMPLIANT
    assert find_finding(run, 'reduced_quality').effect == DOUBTFUL
    assert run.quality.without_reduced is Outcome.COMPLIANT
    assert ('DOUBTFUL: readings decide that their sensor calls poor (TS float solution 600), '
            'without them compliant') in verdict.headline


def test_an_rs_that_is_void_by_its_noise_still_names_its_poor_readings(rng):
    verdict = judge(rng, POOR, error_deg=0.8)
    finding = find_finding(verdict.runs[0], 'reduced_quality')
    assert verdict.runs[0].reason == 'void.reference' and finding.effect == DOUBTFUL
    assert '(RS float solution 600), without them compliant' in finding.words


@pytest.mark.parametrize('errors, outcome', [
    ({}, Outcome.COMPLIANT), ({'ts_deg': 0.5}, Outcome.NON_COMPLIANT)])
def test_poor_readings_that_do_not_decide_are_only_named(rng, errors, outcome):
    verdict = judge(rng, POOR, **errors)
    finding = find_finding(verdict.runs[0], 'reduced_quality')
    assert verdict.outcome is outcome and finding.effect == HOLDS
    assert 'the RS calls 16.7 % of its readings poor (float solution 600)' in finding.evidence
    assert verdict.runs[0].quality.without_reduced is outcome


def test_a_sensor_that_calls_all_its_readings_poor_is_judged_as_it_is(rng):
    """A compass may run in float all its life: there is nothing to compare with."""
    verdict = judge(rng, ALL)
    finding = find_finding(verdict.runs[0], 'reduced_quality')
    assert verdict.outcome is Outcome.COMPLIANT and finding.effect == NOT_TESTABLE
    assert verdict.runs[0].quality.without_reduced is None


def test_sound_readings_leave_the_verdict_as_it_is(rng):
    """Every figure is that without the quality."""
    verdict = judge(rng, ~ALL)
    alone = judge(np.random.default_rng(rng.bit_generator.seed_seq), ~ALL)
    assert find_finding(verdict.runs[0], 'reduced_quality').effect == HOLDS
    assert verdict.headline.startswith('COMPLIANT for') and verdict.runs[0].quality is not None
    assert alone.outcome is verdict.outcome


@pytest.mark.parametrize('stated_deg, effect, words', [
    (0.05, HOLDS, ''), (0.25, DOUBTFUL, 'the RS contradicts its norm of 0.1 deg: it claims 0.25 '
                                        'deg')])
def test_an_rs_that_claims_more_than_its_norm_is_doubted_where_it_decides(
        rng, stated_deg, effect, words):
    """0.28² = 0.0784 is rejected, and less the excess 0.25² - 0.1² = 0.0525 it is 0.0259."""
    verdict = judge(rng, ~ALL, ts_deg=0.28, stated_deg=stated_deg)
    finding = find_finding(verdict.runs[0], 'reference')
    assert verdict.outcome is Outcome.NON_COMPLIANT
    assert (finding.effect, finding.words) == (effect, words)


def test_a_claim_of_the_rs_changes_no_certificate(rng):
    verdict = judge(rng, ~ALL, stated_deg=0.25)
    assert verdict.outcome is Outcome.COMPLIANT
    assert find_finding(verdict.runs[0], 'reference').effect == HOLDS


@pytest.mark.parametrize('stated_deg, said', [
    (0.05, 'its claim is too small'), (0.3, 'its claim is honest'),
    (0.9, 'its claim is too large')])
def test_the_claim_of_the_ts_is_compared_and_changes_nothing(rng, stated_deg, said):
    verdict = judge(rng, ~ALL, of='ts', ts_deg=0.3, stated_deg=stated_deg)
    run = verdict.runs[0]
    assert said in find_finding(run, 'reduced_quality').evidence
    assert verdict.validity_effect == HOLDS and verdict.outcome is Outcome.NON_COMPLIANT
    assert [warning for warning in run.warnings if warning.startswith('claim_of_ts:')] == [
        warning for warning in run.warnings if 'the TS claims 0.05 deg' in warning]


def test_a_verdict_that_was_read_follows_from_its_figures(rng):
    for poor, error_deg in ((POOR, 1.0), (POOR, 0.0), (~ALL, 0.0), (ALL, 0.0)):
        verdict = judge(rng, poor, error_deg=error_deg, stated_deg=0.02)
        read = Verdict.from_dict(verdict.to_dict())
        assert read.runs[0].quality == verdict.runs[0].quality
        check_consistency(read)
