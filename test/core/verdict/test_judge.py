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

"""The judgement of one run: its edges, and its place in a campaign."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from trials import judge_pairs, make_settings

from heading_intercompare import analyze, Compliance, Headings, Pairs
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.runs.run_series import RunSeries
from heading_intercompare.core.verdict.judge import judge_run

S = 10 ** 9


def judge(pairs, **settings):
    """Return the verdict on pairs with the usual norms and these settings."""
    return judge_pairs(pairs, make_settings(**settings))



@pytest.fixture
def pairs(rng):
    """Return 1000 s of pairs, one a second, of a ship that turns."""
    stamps = np.arange(1, 1001) * S
    rs = 200.0 + 30.0 * np.sin(np.arange(1000) / 40.0)
    return Pairs.of(stamps, rs + 0.1 * rng.standard_normal(1000), rs)


@pytest.mark.parametrize('least_s, runs', [(998.9, 1), (999.0, 1), (999.1, 0)])
def test_a_run_just_as_long_as_it_must_be_is_one(pairs, least_s, runs):
    """1000 pairs a second apart last 999 s."""
    assert len(judge(pairs, runs__min_duration_s=least_s).runs) == runs


@pytest.mark.parametrize('least_s, outcome', [(999.0, Outcome.COMPLIANT),
                                              (999.1, Outcome.INDETERMINATE)])
def test_a_run_just_as_long_as_it_must_be_may_comply(pairs, least_s, outcome):
    assert judge(pairs, risk__min_duration_s=least_s).outcome is outcome


def test_a_run_without_a_pair_is_refused():
    settings = make_settings()
    with pytest.raises(ValueError, match='has no pair'):
        judge_run(RunSeries(0, settings), settings, 1, '')


def test_the_stabilisation_period_is_half_open(pairs):
    """The pair 10 s after the first one is analysed: 0 to 9 s are left out."""
    run = judge(pairs, runs__stabilization_s=10.0).runs[0]
    assert (run.n_stabilization, run.n) == (10, 990)


def test_an_invalid_pair_of_the_stabilisation_period_counts_as_invalid(pairs):
    ts = pairs.ts_deg.copy()
    ts[[3, 500]] = np.nan
    run = judge(Pairs.of(pairs.stamp_ns, ts, pairs.rs_deg),
                 runs__stabilization_s=10.0).runs[0]
    assert (run.n_input, run.n_invalid, run.n_stabilization, run.n) == (1000, 2, 9, 989)


def test_the_figures_of_a_run_by_hand():
    """
    Differences 0.1 and 0.3 in turn about 0.2: sum of squares 1000 0.01, variance 10 / 999.

    Mean square 0.05; nothing is slow, so D is the mean square about the mean, 0.01.
    """
    stamps = np.arange(1, 1001) * S
    rs = np.linspace(0.0, 90.0, 1000)
    run = judge(Pairs.of(stamps, rs + np.tile([0.1, 0.3], 500), rs)).runs[0]
    assert (run.start_ns, run.end_ns, run.duration_s, run.n_input) == (S, 1000 * S, 999.0, 1000)
    assert run.mean_deg == pytest.approx(0.2) and run.circular_mean_deg == pytest.approx(0.2)
    assert (run.min_deg, run.max_deg) == (pytest.approx(0.1), pytest.approx(0.3))
    assert run.max_abs_deg == pytest.approx(0.3)
    assert run.mean_square_deg2 == pytest.approx(0.05)
    assert run.variance_deg2 == pytest.approx(10.0 / 999.0)
    assert run.std_deg == pytest.approx((10.0 / 999.0) ** 0.5)
    assert run.guarded.d_hat_deg2 == pytest.approx(0.01, rel=1e-5)
    assert run.drift_coefficients_deg == () and run.looks == ()
    assert run.coverage.span_s == 999.0


def test_drift_that_is_removed_is_named(pairs):
    run = judge(pairs, drift_order=2).runs[0]
    assert len(run.drift_coefficients_deg) == 3
    assert any(w.startswith('drift_removed: a polynomial of order 2') for w in run.warnings)


def test_a_preset_is_named(pairs):
    run = judge(pairs, norms__preset='imo_a424', norms__latitude_deg=0.0).runs[0]
    assert 'sigma_max = 0.25 deg follows from the norm imo_a424' in run.warnings


def test_a_variance_below_that_of_the_rs_is_named(pairs):
    run = judge(pairs, norms__sigma_ref_max_deg=0.4, norms__m_low=1.0).runs[0]
    assert any(w.startswith('difference_variance_below_reference_variance') for w in run.warnings)


def test_a_mean_in_variant_a_is_named(pairs):
    moved = Pairs.of(pairs.stamp_ns, pairs.ts_deg + 0.2, pairs.rs_deg)
    words = 'variant_A_mean_not_zero'
    assert any(w.startswith(words) for w in judge(moved, variant='A').runs[0].warnings)
    assert not any(w.startswith(words) for w in judge(pairs, variant='A').runs[0].warnings)


def test_short_pieces_are_counted(pairs):
    gap = np.concatenate((pairs.stamp_ns[:990], pairs.stamp_ns[990:] + 100 * S))
    verdict = judge(Pairs.of(gap, pairs.ts_deg, pairs.rs_deg), runs__min_duration_s=60.0)
    assert '1 pieces shorter than runs.min_duration_s were left out' in verdict.runs[0].warnings


def test_one_run_of_three_is_rejected_at_a_third_of_the_risk(rng):
    """
    A variance just above its limit: rejected alone, not among three.

    White errors, n = 2000, nu = n: cv = sqrt(2 / 2000) = 0.0316. L = D exp(-t cv) with Student's t
    of 12 at 0.045, 1.842, and at 0.015, 2.462: factors 1.060 and 1.081. D is put between.
    """
    stamps = np.arange(1, 2001) * S
    rs = 180.0 + 30.0 * np.sin(np.arange(2000) / 40.0)
    e = rng.standard_normal(2000)
    e *= np.sqrt(0.1 * 1.070 / np.mean((e - e.mean()) ** 2))
    bad = Headings.as_sent(stamps, rs + e), Headings.as_sent(stamps, rs)
    good = (Headings.as_sent(stamps, rs + 0.1 * rng.standard_normal(2000)),
            Headings.as_sent(stamps, rs))
    settings = make_settings()
    alone = analyze(*bad, settings)
    assert alone.runs[0].guarded.nu == pytest.approx(2000.0, rel=0.2)
    among = analyze([bad[0], good[0], good[0]], [bad[1], good[1], good[1]], settings)
    if alone.outcome is Outcome.NON_COMPLIANT:
        assert among.runs[0].outcome is Outcome.NON_COMPLIANT
    assert among.outcome is not Outcome.COMPLIANT


def test_the_runs_by_outcome_are_counted(pairs, rng):
    ts = Headings.as_sent(pairs.stamp_ns, pairs.ts_deg)
    bad = Headings.as_sent(pairs.stamp_ns, pairs.rs_deg + rng.standard_normal(1000))
    rs = Headings.as_sent(pairs.stamp_ns, pairs.rs_deg)
    verdict = analyze([ts, bad], [rs, rs], make_settings())
    assert verdict.campaign.runs_by_outcome == {
        'compliant': 1, 'indeterminate': 0, 'non_compliant': 1}
    first, second = verdict.runs
    worst = verdict.campaign
    assert worst.worst_variance_run == 2 and worst.worst_variance_deg2 == second.variance_deg2
    # The bad one has a standard deviation of 1, so a third of it lies beyond 3 sigma of 0.316.
    assert first.count_criterion.n_plus == 0 < second.count_criterion.n_plus
    assert worst.worst_plus_rate == second.count_criterion.n_plus / 1000
    assert worst.worst_plus_plus_rate == second.count_criterion.n_plus_plus / 1000
    means = first.mean_deg, second.mean_deg
    assert (worst.a_low_deg, worst.a_up_deg) == (min(means), max(means))
    assert worst.low_worst_deg == min(r.total_error.low_deg for r in verdict.runs)
    assert worst.up_worst_deg == max(r.total_error.up_deg for r in verdict.runs)
    assert (verdict.campaign.rule, verdict.campaign.reason) == ('every_run', 'a_run_non_compliant')


def test_a_run_rejected_at_a_look_complies_among_no_others(pairs):
    """Its end would comply. Alone it stays rejected; among others it makes them indeterminate."""
    settings = make_settings()
    found = Compliance(settings)
    found.update(pairs)
    found.finish()
    (result,) = found.results()
    assert result.outcome_among(2) is Outcome.COMPLIANT
    rejected = replace(result, verdict=replace(
        result.verdict, outcome=Outcome.NON_COMPLIANT, reason='rejected_at_a_look'))
    assert rejected.outcome_among(1) is Outcome.NON_COMPLIANT
    assert rejected.outcome_among(2) is Outcome.INDETERMINATE
