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

"""Several runs together: each row of both rules by name, and the risks of the rules."""

from __future__ import annotations

from dataclasses import fields, replace
import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

from heading_intercompare import analyze, Headings, join, Settings, SettingsError
from heading_intercompare.core.decision.campaign import (
    CAMPAIGN_REASONS,
    conclude_every_run,
    conclude_sensor,
    judge_together,
    LEAST_RUNS,
    Together,
)
from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.decision.guarded import gather_evidence
from heading_intercompare.core.declared_figures import is_left_out
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.settings import Norms, Risk
from heading_intercompare.core.statistics.cells import Cells
from heading_intercompare.core.statistics.variance_uncertainty import (
    between_runs,
    lower_bound,
    pool,
    scatter_of_runs,
    upper_bound,
)

GOOD, BAD, OPEN = Outcome.COMPLIANT, Outcome.NON_COMPLIANT, Outcome.INDETERMINATE
LIMITS = Limits.of(Norms(sigma_max_deg=1.0, sigma_ref_max_deg=0.5, m_low=0.9))
"""A = 1 + 0.45^2 = 1.2025, R = 1.25."""

S = 1_000_000_000
T0 = 1_400_000_000 * S


def run(x, n_plus=0, span_s=None, mean=None, slowest_s=None):
    """Return the evidence of a run of these differences."""
    return gather_evidence(Cells.of(x), n_plus=n_plus, n_plus_plus=n_plus,
                           span_s=float(len(x)) if span_s is None else span_s,
                           mean_deg=float(np.mean(x)) if mean is None else mean,
                           slowest_s=slowest_s)


def white(rng, m, sigma=1.0, n=2000):
    """Return m runs of white errors."""
    return [run(sigma * rng.standard_normal(n)) for _ in range(m)]


def concluded(runs, risk=None, variant='B', limits=LIMITS, totals_met=True):
    risk = risk or Risk()
    each = [limits] * len(runs)
    return conclude_sensor(judge_together(runs, each, risk, variant), each, totals_met, risk)


# --- every run must comply ---

@pytest.mark.parametrize('alone, among, expected', [
    ([], [], (OPEN, 'no_run')),
    ([GOOD, GOOD], [GOOD, GOOD], (GOOD, 'every_run_compliant')),
    ([GOOD, BAD], [GOOD, BAD], (BAD, 'a_run_non_compliant')),
    ([GOOD, BAD], [GOOD, OPEN], (OPEN, 'no_run_rejected_at_its_share')),
    ([OPEN, BAD], [OPEN, OPEN], (OPEN, 'no_run_rejected_at_its_share')),
    ([GOOD, OPEN], [GOOD, OPEN], (OPEN, 'a_run_indeterminate'))])
def test_every_run_must_comply_and_one_rejects(alone, among, expected):
    assert conclude_every_run(alone, among) == expected


# --- the sensor, row by row ---

def test_runs_within_the_acceptance_limit_together_comply(rng):
    assert concluded(white(rng, 5)) == (GOOD, 'upper_bound_within_acceptance_limit')


def test_runs_above_the_rejection_limit_together_do_not(rng):
    assert concluded(white(rng, 5, 1.3), Risk(min_duration_s=1e9)) == \
        (BAD, 'lower_bound_above_rejection_limit')


def test_no_single_run_rejects_the_sensor(rng):
    """One run of twenty far above the limit: 19 and 4 give a mean variance of 1.15."""
    runs = [*white(rng, 19), run(2.0 * rng.standard_normal(2000))]
    outcome, reason = concluded(runs, variant='A')
    assert (outcome, reason) != (BAD, 'lower_bound_above_rejection_limit')
    assert outcome is not BAD


def test_too_many_extreme_differences_of_all_runs_reject(rng):
    """0.003 are allowed: 60 of 2000 in one run of three are 0.01 of all."""
    runs = [*white(rng, 2), run(rng.standard_normal(2000), n_plus=60)]
    assert concluded(runs) == (BAD, 'count_lower_bound_above_allowed')
    few = [*white(rng, 2), run(rng.standard_normal(2000), n_plus=18)]
    assert concluded(few)[0] is GOOD


def test_the_lengths_of_the_runs_add_up(rng):
    runs = white(rng, 5)
    assert concluded(runs, Risk(min_duration_s=10_000.0), 'C')[0] is GOOD
    assert concluded(runs, Risk(slowest_error_s=500.1), 'C') == (OPEN, 'insufficient_duration')


def test_the_means_of_five_runs_stand_in_for_length(rng):
    """In variant B they cover errors slower than a run, but not a stated minimum duration."""
    runs, slow = white(rng, 5), Risk(slowest_error_s=500.1)
    assert concluded(runs, slow)[0] is GOOD
    assert concluded(runs[:4], slow) == (OPEN, 'insufficient_duration')
    assert concluded(runs, Risk(min_duration_s=10_000.1)) == (OPEN, 'insufficient_duration')


@pytest.mark.parametrize('risk, apart_s, has', [
    (Risk(), 600.0, False), (Risk(), 600.1, True), (Risk(), -10.0, False),
    (Risk(slowest_error_s=50.0), 50.0, False), (Risk(slowest_error_s=50.0), 50.1, True),
    (Risk(sensor_class='gyrocompass'), 2300.0, False)])
def test_means_count_of_runs_further_apart_than_the_slowest_error(risk, apart_s, has, rng):
    found = judge_together(white(rng, 5), [LIMITS] * 5, risk, 'B', apart_s)
    assert (found.between_upper_bound_deg2 is not None, found.apart_s) == (has, apart_s)


def test_five_short_pieces_of_one_record_certify_nothing(rng):
    """65 s cut in five: no rule sees the errors of 10 min that all parts share."""
    assert concluded([run(0.1 * rng.standard_normal(130), span_s=13.0) for _ in range(5)]) == \
        (OPEN, 'insufficient_duration')


def test_one_record_given_twice_shows_the_sensor_once(rng):
    ts, rs = inputs(rng, [0.2])
    found = analyze(ts * 5, rs * 5, settings(campaign__rule='sensor'))
    assert (found.outcome, found.campaign.reason) == (OPEN, 'a_run_repeated')


@pytest.mark.parametrize('rule', ['every_run', 'sensor'])
def test_an_input_without_a_run_leaves_the_campaign_open(rule, rng):
    ts, rs = inputs(rng, [0.2, 0.2])
    none = Headings.empty()
    found = analyze([*ts, none], [*rs, none], settings(campaign__rule=rule))
    assert (found.outcome, found.campaign.reason) == (OPEN, 'an_input_not_judged')
    assert found.headline == 'INDETERMINATE: not every input could be judged'
    worse = analyze([*ts, none], [*rs, none], settings(
        campaign__rule=rule, norms__sigma_max_deg=0.1))
    assert worse.outcome is BAD


def test_the_headline_names_the_run_that_keeps_it_open(rng):
    ts, rs = inputs(rng, [0.2, 0.2])
    found = analyze([ts[0], ts[1][:1]], rs, settings())
    assert found.headline == ('INDETERMINATE: not every run complies, and none is rejected (run '
                              '2: fewer than 128 differences, or too unevenly spread in time; '
                              'measure at least 128 differences)')


def test_a_total_error_out_of_its_norm_keeps_the_sensor_open(rng):
    assert concluded(white(rng, 5), totals_met=False) == (OPEN, 'total_error_not_within_norm')


def drifting(rng, m):
    """Return runs whose errors have a slow part of 0.2 that shows in each of them."""
    slow = math.sqrt(0.6) * np.linspace(-1.0, 1.0, 2000)
    return [run(slow + 0.4 * rng.standard_normal(2000), mean=0.0) for _ in range(m)]


def test_a_slow_part_in_few_runs_is_not_resolved(rng):
    assert concluded(drifting(rng, 4)) == (OPEN, 'slow_errors_not_resolved')


def test_the_means_of_five_runs_of_one_constant_mean_resolve_it(rng):
    """They agree, so the slow part is no more than what each run shows; other variants differ."""
    runs = drifting(rng, 5)
    assert concluded(runs) == (GOOD, 'upper_bound_within_acceptance_limit')
    assert concluded(runs, variant='A') == concluded(runs, variant='C') == \
        (OPEN, 'slow_errors_not_resolved')


def test_means_that_differ_show_a_part_slower_than_a_run(rng):
    """White errors of 0.5 about means that scatter by 0.9: no single run shows it."""
    runs = [run(math.sqrt(0.5) * rng.standard_normal(2000) + a)
            for a in 0.9 * np.array([1.0, -1.0, 0.5, -0.5, 1.0, -1.0])]
    assert concluded(runs, variant='C') == (GOOD, 'upper_bound_within_acceptance_limit')
    assert concluded(runs) == (OPEN, 'data_limited')


def test_a_variance_between_the_limits_waits_for_the_reference(rng):
    limits = Limits.of(Norms(sigma_max_deg=1.0, sigma_ref_max_deg=1.0, m_low=0.0))
    assert concluded(white(rng, 5, math.sqrt(1.5), 20_000), limits=limits) == \
        (OPEN, 'reference_limited')


def test_a_variance_near_its_limit_waits_for_data(rng):
    assert concluded(white(rng, 3, math.sqrt(1.2), 300)) == (OPEN, 'data_limited')


def test_no_run_and_no_difference_leave_it_open():
    assert concluded([]) == (OPEN, 'no_run')
    short = run(np.ones(127))
    assert judge_together([short], [LIMITS], Risk(), 'B') is None
    assert concluded([short]) == (OPEN, 'insufficient_data')


@pytest.mark.parametrize('rule,reason', [
    ('every_run', 'a_run_non_compliant'), ('sensor', 'a_test_not_met')])
def test_a_run_that_breaks_a_test_of_the_norm_rejects_the_campaign(rule, reason, rng):
    ts, rs = inputs(rng, [0.2] * 3)
    ts[1] = Headings.of(ts[1].stamp_ns, (ts[1].heading_deg + 1.5) % 360.0)
    verdict = analyze(ts, rs, settings(campaign__rule=rule, norms__tests='static_error 1.0',
                                       installation_offset_u_deg=0.01))
    assert (verdict.outcome, verdict.campaign.reason) == (Outcome.NON_COMPLIANT, reason)
    row, = verdict.campaign.norm_tests
    assert (row.kind, row.state, row.run) == ('static_error', 'not_met', 2)
    assert row.line in verdict.headline


def test_every_reason_is_reached_by_a_test_of_this_file():
    text = Path(__file__).read_text('utf-8')
    assert {code for code in CAMPAIGN_REASONS if f"'{code}'" not in text} == set()
    assert all(words and code == code.lower() for code, words in CAMPAIGN_REASONS.items())


# --- the figures ---

def test_the_shared_figures_follow_from_the_runs(rng):
    runs = [run(rng.standard_normal(n), n_plus=2) for n in (2000, 500, 3000, 800, 700)]
    each = [LIMITS, replace(LIMITS, tightened_limit_deg2=1.1), *[LIMITS] * 3]
    risk = Risk(alpha_consumer=0.02, alpha_producer=0.1)
    found = judge_together(runs, each, risk, 'B')
    shared = pool([e.spread for e in runs])
    assert (found.runs, found.n, found.span_s) == (5, 7000, 7000.0)
    assert (found.d_hat_deg2, found.nu, found.f) == (shared.d_deg2, shared.nu, shared.f)
    assert found.pooled_upper_bound_deg2 == upper_bound(shared, 0.02)
    spreads, means = [e.spread for e in runs], [e.mean_deg for e in runs]
    assert found.between_upper_bound_deg2 == between_runs(spreads, means, 0.02)
    assert found.scatter_upper_bound_deg2 == scatter_of_runs(spreads, means, 0.02)
    assert found.upper_bound_deg2 == max(found.between_upper_bound_deg2,
                                         found.scatter_upper_bound_deg2)
    assert found.lower_bound_deg2 == pytest.approx(lower_bound(shared, 0.09), rel=1e-12)
    assert found.acceptance_limit_deg2 == pytest.approx((6500 * 1.2025 + 500 * 1.1) / 7000)
    assert found.rejection_limit_deg2 == pytest.approx(1.25)
    assert 0.0 < found.rate_plus_lower < 10.0 / 7000


@pytest.mark.parametrize('variant, m, has', [
    ('B', LEAST_RUNS - 1, False), ('B', LEAST_RUNS, True), ('A', 8, False), ('C', 8, False)])
def test_the_means_speak_only_in_variant_b_and_of_five_runs_or_more(variant, m, has, rng):
    found = judge_together(white(rng, m), [LIMITS] * m, Risk(), variant)
    assert (found.between_upper_bound_deg2 is not None) is has
    assert (found.scatter_upper_bound_deg2 is not None) is has
    if not has:
        assert found.upper_bound_deg2 == found.pooled_upper_bound_deg2


@pytest.mark.parametrize('slowest_s, alpha', [(None, 0.05), (200.0, 0.05), (201.0, 0.025)])
def test_the_means_of_runs_shorter_than_ten_slowest_errors_have_half_the_risk(
        slowest_s, alpha, rng):
    runs = [run(rng.standard_normal(2000), slowest_s=slowest_s) for _ in range(5)]
    found = judge_together(runs, [LIMITS] * 5, Risk(slowest_error_s=slowest_s), 'B')
    spreads, means = [e.spread for e in runs], [e.mean_deg for e in runs]
    assert found.upper_bound_deg2 == max(between_runs(spreads, means, alpha),
                                         scatter_of_runs(spreads, means, alpha))


@pytest.mark.parametrize('variant, slowest_s, m, has', [
    ('A', 100.0, 5, True), ('C', 100.0, 5, True), ('B', 100.0, 5, False), ('A', 101.0, 5, False),
    ('A', 100.0, 4, False), ('A', None, 5, False)])
def test_a_statement_counts_together_in_a_and_c_of_five_runs_of_twenty_times(
        variant, slowest_s, m, has, rng):
    runs = [run(rng.standard_normal(2000), slowest_s=slowest_s) for _ in range(m)]
    found = judge_together(runs, [LIMITS] * m, Risk(slowest_error_s=slowest_s), variant)
    assert found.stated_times == (20.0 if has else None)
    assert found.pooled_upper_bound_deg2 == upper_bound(
        pool([e.spread for e in runs], by_statement=has), 0.05)


def test_runs_too_short_are_not_among_the_five(rng):
    runs = [*white(rng, 4), run(np.ones(100))]
    found = judge_together(runs, [LIMITS] * 5, Risk(), 'B')
    assert (found.runs, found.n) == (4, 8000) and found.between_upper_bound_deg2 is None


# --- the whole path ---

def settings(**names):
    return Settings.from_mapping({
        'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1, 'norms.m_low': 0.0,
        'risk.min_duration_s': 0.0,
        **{k.replace('__', '.'): v for k, v in names.items()}})


def inputs(rng, sigmas, n=700):
    """Return TS and RS of runs with white errors of these standard deviations."""
    stamps = T0 + S // 10 * np.arange(n)
    rs = Headings.of(stamps, np.full(n, 90.0))
    return ([Headings.of(stamps, 90.0 + s * rng.standard_normal(n)) for s in sigmas],
            [rs] * len(sigmas))


def test_the_rule_is_chosen_by_a_setting_and_stands_in_the_json(rng):
    ts, rs = inputs(rng, [0.25] * 4 + [0.31])
    every = analyze(ts, rs, settings()).to_dict()
    sensor = analyze(ts, rs, settings(campaign__rule='sensor')).to_dict()
    assert every['settings']['campaign.rule'] == 'every_run'
    assert (every['outcome'], every['campaign']['reason']) == \
        ('indeterminate', 'a_run_indeterminate')
    assert (sensor['outcome'], sensor['campaign']['reason']) == \
        ('compliant', 'upper_bound_within_acceptance_limit')
    assert sensor['campaign']['rule'] == 'sensor'
    assert sensor['campaign']['runs_by_outcome'] == \
        {'compliant': 4, 'indeterminate': 1, 'non_compliant': 0}
    assert sensor['campaign']['sensor'] == every['campaign']['sensor']
    assert list(sensor['campaign']['sensor']) == [
        f.name for f in fields(Together) if not is_left_out(f, None)]
    assert [r['outcome'] for r in sensor['runs']] == [r['outcome'] for r in every['runs']]
    json.dumps(sensor, allow_nan=False)


@pytest.mark.slow
def test_a_run_rejected_alone_is_said_among_many(rng):
    """Each share is a twentieth of the producer's risk: a run just above its own bound stays."""
    for sigma in np.arange(0.33, 0.40, 0.002):
        ts, rs = inputs(rng, [sigma, *[0.1] * 19])
        alone = analyze(ts[:1], rs[:1], settings())
        if alone.outcome is BAD:
            break
    assert alone.campaign.reason == 'a_run_non_compliant'
    among = analyze(ts, rs, settings())
    assert among.runs[0].outcome is BAD
    assert (among.outcome, among.campaign.reason) == (OPEN, 'no_run_rejected_at_its_share')
    sensor = analyze(ts, rs, settings(campaign__rule='sensor'))
    assert sensor.outcome is GOOD


def test_a_total_error_of_one_run_keeps_the_sensor_open(rng):
    """Variant C, means 0.4 apart, total error 0.7: three of a sigma of 0.2 fit about 0 only."""
    ts, rs = inputs(rng, [0.2, 0.2])
    moved = Headings.of(ts[1].stamp_ns, ts[1].heading_deg + 0.4)
    given = {'campaign__rule': 'sensor', 'norms__total_error_max_deg': 0.7, 'variant': 'C'}
    found = analyze([ts[0], moved], rs, settings(**given))
    assert (found.outcome, found.campaign.reason) == (OPEN, 'total_error_not_within_norm')
    assert analyze(ts, rs, settings(**given)).outcome is GOOD


@pytest.mark.parametrize('rule', ['every_run', 'sensor'])
def test_a_void_run_leaves_the_campaign_open_unless_the_others_reject(rule, rng):
    """A TS 90 degrees off is no measurement, and does not enter the common variance."""
    ts, rs = inputs(rng, [0.2] * 3)
    ts[1] = Headings.of(ts[1].stamp_ns, (ts[1].heading_deg + 90.0) % 360.0)
    found = analyze(ts, rs, settings(campaign__rule=rule))
    assert (found.outcome, found.campaign.reason) == (OPEN, 'a_run_void')
    assert found.campaign.sensor.runs == 2
    worse = analyze(ts, rs, settings(campaign__rule=rule, norms__sigma_max_deg=0.1))
    assert worse.outcome is BAD


@pytest.mark.parametrize('rule', ['every_run', 'sensor'])
def test_no_input_at_all_is_indeterminate_by_either_rule(rule):
    verdict = join([], settings(campaign__rule=rule))
    assert (verdict.outcome, verdict.campaign.reason) == (OPEN, 'no_run')
    assert verdict.to_dict()['campaign']['sensor'] is None


def test_another_rule_is_refused():
    with pytest.raises(SettingsError, match="campaign.rule = 'best'.*'every_run' or 'sensor'"):
        settings(campaign__rule='best')


# --- measured ---

@pytest.mark.slow
def test_a_slow_part_that_no_run_shows_is_caught_by_the_means(rng):
    """
    Half of the variance is one constant a run, all of it at the limit; 300 campaigns of 8.

    Every run complies in nearly all of them; the means certify in 0.05, six standard errors.
    """
    limits = Limits.of(Norms(sigma_max_deg=1.0, sigma_ref_max_deg=0.0))
    every = sensor = 0
    for _ in range(300):
        runs = [run(math.sqrt(0.5) * (rng.standard_normal(500) + rng.standard_normal()))
                for _ in range(8)]
        each = [limits] * 8
        every += all(upper_bound(e.spread, 0.05) <= 1.0 for e in runs)
        found = judge_together(runs, each, Risk(), 'B')
        sensor += conclude_sensor(found, each, True, Risk())[0] is GOOD
    assert every > 270
    assert sensor / 300 < 0.05 + 6.0 * math.sqrt(0.05 * 0.95 / 300)


@pytest.mark.slow
def test_four_runs_certify_what_no_single_one_does(rng):
    """AR(1), 50 correlation times, 0.7 of the norm: 0.97 together, 0.16 all four alone."""
    phi = math.exp(-1.0 / 20.0)
    every = sensor = 0
    for _ in range(100):
        x = 0.7 * lfilter([math.sqrt(1.0 - phi * phi)], [1.0, -phi],
                          rng.standard_normal((4, 1200)), axis=1)[:, 200:]
        runs = [run(row) for row in x]
        every += all(upper_bound(e.spread, 0.05) <= 1.0 for e in runs)
        sensor += upper_bound(pool([e.spread for e in runs]), 0.05) <= 1.0
    assert sensor > 97 - 6.0 * math.sqrt(100 * 0.97 * 0.03)
    assert every < 16 + 6.0 * math.sqrt(100 * 0.16 * 0.84)
