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

"""The whole path: any chunks and any order of arrival give the same verdict."""

from __future__ import annotations

import gc
import json
import math
import warnings

import numpy as np
import pytest
from trials import find_finding

from heading_intercompare import (
    analyze,
    Compliance,
    Headings,
    Intercomparison,
    join,
    Outcome,
    pair,
    Pairs,
    Settings,
    SettingsError,
)

S = 1_000_000_000
T0 = 1_400_000_000 * S
NORMS = {'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1, 'risk.min_duration_s': 0.0}


def settings(**names):
    return Settings.from_mapping({**NORMS, **{k.replace('__', '.'): v for k, v in names.items()}})


def sensors(rng, n=3000, ts_rate_hz=10.0, rs_rate_hz=4.0, sigma=0.2, mean=0.05):
    """Return the headings of a ship that turns, TS and RS with white errors."""
    def stream(rate_hz, error):
        t = np.arange(int(n * rate_hz / ts_rate_hz)) / rate_hz
        heading = 350.0 + 20.0 * np.sin(t / 30.0) + error(len(t))
        return Headings.of(T0 + np.round(t * 1e9).astype(np.int64), heading % 360.0)
    return (stream(ts_rate_hz, lambda k: mean + sigma * rng.standard_normal(k)),
            stream(rs_rate_hz, lambda k: 0.05 * rng.standard_normal(k)))


def exact(verdict):
    """Return the verdict as JSON text, which any difference to the bit changes."""
    return json.dumps(verdict.to_dict(), allow_nan=False)


def close(a, b, path=''):
    """Assert equal integers and words, and reals to 1e-12 relative."""
    assert type(a) is type(b), path
    if isinstance(a, dict):
        assert list(a) == list(b), path
        for key in a:
            close(a[key], b[key], f'{path}.{key}')
    elif isinstance(a, list):
        assert len(a) == len(b), path
        for at, (x, y) in enumerate(zip(a, b)):
            close(x, y, f'{path}[{at}]')
    elif isinstance(a, float):
        assert math.isclose(a, b, rel_tol=1e-12, abs_tol=1e-15), (path, a, b)
    else:
        assert a == b, path


@pytest.mark.slow
@pytest.mark.parametrize('chunk', [1, 17, 600])
def test_chunks_give_the_verdict_of_the_whole(rng, chunk):
    ts, rs = sensors(rng, n=1200)
    whole = analyze(ts, rs, settings())
    comparison = Intercomparison(settings())
    for k in range(0, len(ts), chunk):
        comparison.update(ts=ts[k:k + chunk])
        comparison.update(rs=rs[k * 2 // 5:(k + chunk) * 2 // 5])
    comparison.finish()
    close(comparison.verdict().to_dict(), whole.to_dict())


def test_a_good_sensor_complies_and_a_bad_one_does_not(rng):
    ts, rs = sensors(rng)
    assert analyze(ts, rs, settings()).outcome is Outcome.COMPLIANT
    assert analyze(ts, rs, settings(norms__sigma_max_deg=0.1)).outcome is Outcome.NON_COMPLIANT


def test_the_share_of_a_run_that_is_judged_is_told(rng):
    told = []
    ts, rs = sensors(rng)
    comparison = Intercomparison(settings(), progress=told.append)
    comparison.update(ts, rs)
    assert told == []
    comparison.finish()
    shares = [int(text.removesuffix('% of run 1 judged')) for text in told]
    assert len(shares) > 2 and shares == sorted(shares) and 0 < shares[0] < shares[-1] <= 100


def test_a_silence_makes_two_runs_and_divides_the_ledger(rng):
    ts, rs = sensors(rng)
    late = 100 * S
    ts2, rs2 = (Headings.concatenate((h, Headings.of(
        h.stamp_ns + (int(ts.stamp_ns[-1]) - T0) + late, h.heading_deg))) for h in (ts, rs))
    verdict = analyze(ts2, rs2, settings())
    assert [r.run for r in verdict.runs] == [1, 2]
    for run in verdict.runs:
        assert run.pairing.ts_received == 3000 and run.pairing.paired == run.n_input
        assert run.pairing.ts_received == run.pairing.ts_paired + run.pairing.ts_unpaired
        assert run.pairing.rs_received == run.pairing.rs_used + run.pairing.rs_unused
    assert verdict.campaign.m == 2
    assert verdict.campaign.worst_variance_deg2 == max(r.variance_deg2 for r in verdict.runs)


def test_readings_of_a_ts_between_two_stamps_of_a_slow_rs_are_not_lost(rng):
    ts, rs = sensors(rng, rs_rate_hz=1.0)
    ts = Headings.of(ts.stamp_ns + 13_000_000, ts.heading_deg)
    both = [Headings.concatenate((h, Headings.of(h.stamp_ns + 400 * S, h.heading_deg)))
            for h in (ts, rs)]
    run = analyze(*both, settings()).runs[1]
    assert run.pairing.ts_unpaired > 0.5 * run.pairing.ts_received
    found = find_finding(run, 'losses')
    assert found.effect == 'holds'


def test_marks_set_early_or_live_give_the_same_runs(rng):
    # Live, the method 'auto' makes no pair for a minute that could be marked, and a pair between
    # two readings waits for the readings after it.
    ts, rs = sensors(rng, rs_rate_hz=10.0)
    early = Intercomparison(settings(pairing__method='interpolate'))
    early.mark('start', T0 + 50 * S)
    early.mark('stop', T0 + 150 * S)
    early.update(ts, rs)
    early.finish()
    live = Intercomparison(settings(pairing__method='interpolate'))
    for at, kind in ((50, 'start'), (150, 'stop'), (400, None)):
        until = T0 + at * S
        # Live, a mark is set when the pair of its stamp has come.
        taken = [h[(h.stamp_ns <= until) & (h.stamp_ns > (live.compliance.newest_ns or 0))]
                 for h in (ts, rs)]
        live.update(*taken)
        if kind:
            assert live.compliance.newest_ns == until
            live.mark(kind, until)
    live.finish()
    assert exact(early.verdict()) == exact(live.verdict())
    (run,) = early.verdict().runs
    assert run.start_ns == T0 + 50 * S + S // 10 and run.end_ns == T0 + 150 * S
    assert run.n == 1000


def test_the_first_start_mark_withdraws_what_ran_before(rng):
    ts, rs = sensors(rng)
    comparison = Intercomparison(settings())
    comparison.update(ts[:1000], rs[:401])
    comparison.mark('start', int(ts.stamp_ns[999]))
    comparison.update(ts[1000:], rs[401:])
    comparison.finish()
    (run,) = comparison.verdict().runs
    assert run.start_ns == ts.stamp_ns[1000]
    assert run.pairing.ts_received == 3000, 'readings before the first run count with it'


def test_a_table_of_runs_rules(rng):
    ts, rs = sensors(rng)
    comparison = Intercomparison(settings(), table=[(T0, T0 + 60 * S), (T0 + 90 * S,
                                                                       T0 + 100 * S)])
    comparison.update(ts, rs)
    comparison.finish()
    runs = comparison.verdict().runs
    assert [r.n for r in runs] == [600, 100]
    assert runs[1].pairing.ts_received == 3000 - 900


def test_the_stabilisation_restarts_with_each_run(rng):
    ts, rs = sensors(rng)
    comparison = Intercomparison(settings(runs__stabilization_s=10.0),
                                 table=[(T0, T0 + 60 * S), (T0 + 90 * S, T0 + 150 * S)])
    comparison.update(ts, rs)
    comparison.finish()
    for run in comparison.verdict().runs:
        assert (run.n_stabilization, run.n) == (100, 500)
        assert run.n_input == run.n_invalid + run.n_stabilization + run.n


def test_several_inputs_are_several_runs(rng):
    inputs = [sensors(rng) for _ in range(3)]
    verdict = analyze([ts for ts, _ in inputs], [rs for _, rs in inputs], settings())
    assert [r.run for r in verdict.runs] == [1, 2, 3]
    with pytest.raises(ValueError, match='one RS for each TS'):
        analyze([inputs[0][0]], [], settings())


def test_a_run_too_short_is_left_out_and_said(rng):
    ts, rs = sensors(rng)
    comparison = Intercomparison(settings(runs__min_duration_s=30.0),
                                 table=[(T0, T0 + 20 * S), (T0 + 90 * S, T0 + 150 * S)])
    comparison.update(ts, rs)
    comparison.finish()
    (run,) = comparison.verdict().runs
    assert run.n == 600
    assert any('min_duration_s' in w for w in run.warnings)


def test_a_missing_norm_is_an_error_at_once():
    with pytest.raises(SettingsError, match='norms.sigma_max_deg is missing'):
        Compliance(Settings())


@pytest.mark.parametrize('n', [0, 1, 2, 3, 63, 64])
@pytest.mark.parametrize('x', [0.0, 0.25, 179.9, -180.0, np.nan])
@pytest.mark.parametrize('more', [{}, {'norms__sigma_ref_max_deg': 0}, {'model': 'UU'},
                                  {'variant': 'A'}, {'drift_order': 'auto'},
                                  {'runs__stabilization_s': 'auto', 'drift_order': 3}])
def test_few_or_constant_or_invalid_differences_give_a_stated_result(n, x, more):
    stamps = T0 + np.arange(n) * S
    compliance = Compliance(settings(**more))
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        compliance.update(Pairs.of(stamps, np.full(n, 180.0 + x), np.full(n, 180.0)))
        compliance.run_figures()
        compliance.rolling_figures()
        compliance.finish()
        text = exact(compliance.verdict())
    assert 'NaN' not in text and 'Infinity' not in text
    if n < 2 or np.isnan(x):
        assert compliance.verdict().outcome is Outcome.INDETERMINATE


def test_the_figures_of_the_run_in_progress_are_those_at_its_end(rng):
    ts, rs = sensors(rng, rs_rate_hz=10.0)
    comparison = Intercomparison(settings())
    comparison.update(ts, rs)
    progress = comparison.compliance.run_figures()
    comparison.finish()
    (run,) = comparison.verdict().runs
    # Equal stamps need no later reading: no pair is added at the end.
    assert progress['n'] == run.n
    assert progress['variance_deg2'] == pytest.approx(run.variance_deg2, rel=1e-12)
    assert progress['n_plus'] == run.count_criterion.n_plus
    assert comparison.compliance.run_figures() == {
        'run': 0, 'marked': False, 'n': 0}


LIVE = ('nu', 'f', 'slow_allowance_deg2', 'lower_bound_deg2', 'upper_bound_deg2',
        'acceptance_limit_deg2', 'rejection_limit_deg2', 'sigma_ts_lower_deg',
        'sigma_ts_upper_deg', 'bias_u_deg')


@pytest.mark.slow
@pytest.mark.parametrize('chunk', [1, 700, 10_000])
def test_live_and_final_bounds_are_the_same_to_the_bit(rng, chunk):
    """With no drift removed and a fixed stabilisation; a gap and lost readings in between."""
    ts, rs = sensors(rng)
    kept = (rng.random(len(ts)) < 0.9) & ((ts.stamp_ns < T0 + 100 * S)
                                          | (ts.stamp_ns > T0 + 120 * S))
    given = settings(runs__stabilization_s=10.0, runs__gap_s=60.0)
    pairs, _ = pair(ts[kept], rs, given)
    compliance = Compliance(given)
    for k in range(0, len(pairs), chunk):
        compliance.update(pairs[k:k + chunk])
    live = compliance.run_figures()
    compliance.finish()
    (run,) = compliance.verdict().runs
    assert run.n == live['n'] > 2000
    assert [live[name] for name in LIVE] == [getattr(run.guarded, name) for name in LIVE]


def test_a_drift_removed_is_allowed_for_and_live_figures_are_about_the_mean(rng):
    ts, rs = sensors(rng)
    given = settings(drift_order='auto')
    compliance = Compliance(given)
    compliance.update(pair(ts, rs, given)[0])
    live = compliance.run_figures()
    compliance.finish()
    (auto,) = compliance.verdict().runs
    assert auto.drift_coefficients_deg == ()
    # Third order is allowed for, whatever order the data have chosen.
    assert auto.guarded.lower_bound_deg2 != live['lower_bound_deg2']
    (fixed,) = analyze(ts, rs, settings()).runs
    assert live['lower_bound_deg2'] == fixed.guarded.lower_bound_deg2


def test_interpolation_is_taken_into_account(rng):
    ts, rs = sensors(rng, ts_rate_hz=10.0, rs_rate_hz=1.0)
    (run,) = analyze(ts, rs, settings(norms__m_low=0.9, pairing__method='interpolate',
                                      pairing__kernel='line')).runs
    factor = run.pairing.rs_variance_factor
    assert factor == pytest.approx(np.mean([(1 - w) ** 2 + w ** 2 for w in
                                            np.arange(10) / 10]), rel=1e-3)
    assert run.variance_criterion.tightened_limit_deg2 == pytest.approx(
        0.3 ** 2 + factor * 0.9 ** 2 * 0.1 ** 2)
    # The TS put onto the stamps of the RS: each of these meets a reading of the TS.
    (run,) = analyze(ts, rs, settings(norms__m_low=0.9)).runs
    assert (run.pairing.rs_variance_factor, run.pairing.ts_variance_factor) == (1.0, 1.0)
    assert (run.pairing.paired, run.pairing.ts_paired, run.pairing.ts_used) == (300, 300, 0)
    # With stamps of its own it lies halfway between two: 2 (9^2 + 1) / 16^2 of its noise are left.
    late = Headings.of(ts.stamp_ns + 50_000_000, ts.heading_deg)
    (run,) = analyze(late, rs, settings(norms__m_low=0.9)).runs
    assert run.pairing.ts_variance_factor == pytest.approx(0.640625)
    assert (run.pairing.paired, run.pairing.ts_paired, run.pairing.ts_used) == (299, 0, 4 * 299)
    assert run.pairing.ts_received == 4 * 299 + run.pairing.ts_unpaired
    assert run.variance_criterion.tightened_limit_deg2 == pytest.approx(
        0.640625 * 0.3 ** 2 + 0.9 ** 2 * 0.1 ** 2)
    assert run.variance_criterion.limit_deg2 == pytest.approx(0.3 ** 2 + 0.1 ** 2)


def test_the_largest_lag_of_a_run_has_no_sign():
    compliance = Compliance(settings())
    lags = np.array([1, -3, 2]) * (S // 100)
    compliance.update(Pairs.of(T0 + np.arange(3) * S, np.full(3, 9.0), np.full(3, 9.0), lags))
    compliance.finish()
    (run,) = compliance.verdict().runs
    assert (run.pairing.max_lag_s, run.pairing.mean_lag_s) == (0.03, 0.0)


def test_no_input_at_all_is_indeterminate():
    verdict = join([], settings())
    assert verdict.outcome is Outcome.INDETERMINATE and verdict.to_dict()['runs'] == []


@pytest.mark.slow
def test_looks_do_not_depend_on_chunks(rng):
    ts, rs = sensors(rng)
    plan = settings(sequential__plan_s=600.0, sequential__looks=4, norms__sigma_max_deg=0.5)
    texts = set()
    for chunk in (1, 250, 3000):
        compliance = Compliance(plan)
        pairs, _ = pair(ts, rs, plan)
        looks = []
        for k in range(0, len(pairs), chunk):
            compliance.update(pairs[k:k + chunk])
            if compliance.early:
                looks.append(compliance.early)
        # Looks at 75, 150, 300 and 600 s; the run ends after 299.8 s.
        assert looks[-1].outcome is Outcome.COMPLIANT and looks[-1].look == 2
        assert chunk == 3000 or looks[0].look == 1 and looks[0].span_s < 80.0
        compliance.finish()
        (run,) = compliance.verdict().runs
        assert run.outcome is Outcome.COMPLIANT
        assert [(look.look, look.looks, look.outcome) for look in run.looks] == \
            [(1, 4, Outcome.COMPLIANT), (2, 4, Outcome.COMPLIANT)]
        texts.add(str(run.looks))
    assert len(texts) == 1


@pytest.mark.parametrize('chunk', [1, 250, 3000])
def test_open_looks_decide_in_progress_and_the_end_has_what_they_left(rng, chunk):
    """Looks at 75 and 150 s of 299.8 s: each has 1 / 6 of the half, the end 5 / 6 of the whole."""
    ts, rs = sensors(rng)
    rule = {'norms__sigma_max_deg': 0.5, 'risk__min_duration_s': 75.0}
    compliance = Compliance(settings(sequential__plan_s='open', **rule))
    pairs, _ = pair(ts, rs, compliance.settings)
    following = []
    for k in range(0, len(pairs), chunk):
        compliance.update(pairs[k:k + chunk])
        following.append(compliance.run_figures()['next_look_ns'])
    assert following[-1] == int(pairs.stamp_ns[0]) + 300 * 10 ** 9
    assert compliance.early.outcome is Outcome.COMPLIANT
    compliance.finish()
    (run,) = compliance.verdict().runs
    assert [(look.look, look.looks, look.outcome) for look in run.looks] == \
        [(1, 7, Outcome.COMPLIANT), (2, 7, Outcome.COMPLIANT)]
    left = 0.05 / (12 / 10)
    (alone,) = analyze(ts, rs, settings(risk__alpha_consumer=left, risk__alpha_producer=left,
                                        **rule)).runs
    assert run.outcome is Outcome.COMPLIANT and run.guarded == alone.guarded
    assert run.looks == analyze(ts, rs, compliance.settings).runs[0].looks


@pytest.mark.parametrize('plan_s', ['open', 36_000.0])
def test_a_risk_too_small_for_the_looks_is_refused_before_the_first_pair(plan_s):
    rule = {'risk__alpha_consumer': 5e-6}
    with pytest.raises(SettingsError, match='at least 12e-06, or sequential.plan_s must be none'):
        Compliance(settings(sequential__plan_s=plan_s, risk__min_duration_s=1.0, **rule))
    assert not Compliance(settings(**rule)).finished_runs


def test_with_a_plan_the_end_of_a_run_takes_the_share_of_the_last_look(rng):
    ts, rs = sensors(rng, sigma=0.28)
    (plain,) = analyze(ts, rs, settings()).runs
    (planned,) = analyze(ts, rs, settings(sequential__plan_s=1e5)).runs
    assert planned.guarded.upper_bound_deg2 > plain.guarded.upper_bound_deg2
    (half,) = analyze(ts, rs, settings(risk__alpha_consumer=0.025,
                                       risk__alpha_producer=0.025)).runs
    assert planned.guarded == half.guarded


@pytest.mark.slow
def test_among_several_runs_the_producers_risk_is_shared(rng):
    """One run just above the limit is rejected alone, but not as one of twenty."""
    def runs(sigma):
        return sensors(rng, n=700, sigma=sigma, mean=0.0)
    for sigma in np.arange(0.33, 0.40, 0.002):
        bad = runs(sigma)
        alone = analyze(*bad, settings())
        guarded = alone.runs[0].guarded
        share = guarded.lower_bound_deg2 / guarded.rejection_limit_deg2
        if alone.outcome is Outcome.NON_COMPLIANT and share < 1.05:
            break
    good = [runs(0.1) for _ in range(19)]
    together = analyze([bad[0], *(g[0] for g in good)], [bad[1], *(g[1] for g in good)],
                       settings())
    assert together.runs[0].outcome is Outcome.NON_COMPLIANT
    assert together.outcome is Outcome.INDETERMINATE


def test_an_automatic_stabilisation_leaves_the_warm_up_out(rng):
    ts, rs = sensors(rng, n=18000, mean=0.0, sigma=0.05)
    t = (ts.stamp_ns - T0) / S
    warm = Headings.of(ts.stamp_ns, (ts.heading_deg + 2.0 * np.exp(-t / 100.0)) % 360.0)
    (given,) = analyze(warm, rs, settings()).runs
    (auto,) = analyze(warm, rs, settings(runs__stabilization_s='auto')).runs
    # 2 exp(-t / 100) falls to a tenth of the norm, 0.03, after 100 ln(2 / 0.03) = 420 s.
    assert auto.n_stabilization == pytest.approx(4200, rel=0.1)
    assert auto.n_input == auto.n_invalid + auto.n_stabilization + auto.n
    assert given.outcome is not Outcome.COMPLIANT and auto.outcome is Outcome.COMPLIANT


def test_a_drift_is_taken_out_only_where_asked_for(rng):
    ts, rs = sensors(rng, n=18000, mean=0.0, sigma=0.05)
    hours = (ts.stamp_ns - T0) / S / 3600.0
    drifting = Headings.of(ts.stamp_ns, (ts.heading_deg + 4.0 * hours) % 360.0)
    (counted,) = analyze(drifting, rs, settings()).runs
    assert counted.drift_coefficients_deg == () and counted.outcome is not Outcome.COMPLIANT
    for order in (1, 'auto'):
        (removed,) = analyze(drifting, rs, settings(drift_order=order)).runs
        # Legendre on [-1, 1]: a slope of 4 deg/h over half an hour is 1 deg to either side.
        assert removed.drift_coefficients_deg[1] == pytest.approx(1.0, abs=0.01)
        assert removed.outcome is Outcome.COMPLIANT
        assert any('drift_removed' in w for w in removed.warnings)


def test_a_skew_is_applied_only_where_asked_for(rng):
    t = np.arange(0.0, 1800.0, 0.1)
    stamps = T0 + np.round(t * 1e9).astype(np.int64)

    def heading(at):
        return 100.0 + 20.0 * np.sin(at / 8.0)

    rs = Headings.of(stamps, heading(t) + 0.02 * rng.standard_normal(t.size))
    late = Headings.of(stamps, heading(t - 0.5) + 0.05 * rng.standard_normal(t.size))
    (reported,) = analyze(late, rs, settings()).runs
    assert reported.outcome is Outcome.NON_COMPLIANT
    assert reported.skew.outcome_aligned is Outcome.COMPLIANT
    assert reported.skew.estimate.skew_s == pytest.approx(0.5, abs=0.02)
    verdict = analyze(late, rs, settings(alignment__skew='apply'))
    (applied,) = verdict.runs
    assert applied.outcome is Outcome.COMPLIANT and applied.run == 1
    assert applied.skew.scan.skew_s == pytest.approx(0.5, abs=0.02)
    assert applied.pairing.ts_received == len(late)
    exact(verdict)


@pytest.mark.slow
def test_a_preview_is_what_a_stop_would_give_and_changes_nothing(rng):
    """With runs that are too old for the verdict, and with looks."""
    rule = Settings.from_mapping({
        'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1, 'runs.every_h': 0.5,
        'runs.keep': 2, 'sequential.plan_s': 1800.0})
    stamps = 1_700_000_000_000_000_000 + np.arange(10_000) * 1_000_000_000
    pairs = Pairs.of(stamps, 90.0 + rng.normal(0.0, 0.1, 10_000), np.full(10_000, 90.0))
    plain, watched = Compliance(rule), Compliance(rule)
    for lo in range(0, 10_000, 2500):
        for one in (plain, watched):
            one.update(pairs[lo:lo + 2500])
        seen = watched.preview()
        stopped = Compliance(rule)
        stopped.update(pairs[:lo + 2500])
        stopped.finish()
        assert seen.intermediate and seen.headline.startswith('INTERMEDIATE')
        assert [*seen.runs] == [*stopped.verdict().runs]
        assert type(seen).from_dict(json.loads(json.dumps(seen.to_dict()))).to_dict() == (
            seen.to_dict())
    for one in (plain, watched):
        one.finish()
    assert plain.verdict() == watched.verdict()
    assert plain.take_earlier() == watched.take_earlier()


@pytest.mark.parametrize('more', [{}, {'alignment__skew': 'off'}, {'variant': 'B'},
                                  {'drift_order': 'auto', 'runs__stabilization_s': 'auto'}])
def test_a_judged_run_is_freed_without_the_collector_of_garbage(rng, more):
    """Its columns held themselves: 5 MB of each run of 2 h at 10 Hz stayed for hours."""
    comparison = Intercomparison(settings(pairing__method='interpolate', runs__every_h=0.02,
                                          **more))
    ts, rs = sensors(rng)
    comparison.update(ts=ts[:1500], rs=rs[:600])
    gc.collect()
    gc.disable()
    try:
        comparison.update(ts=ts[1500:], rs=rs[600:])
        n_garbage = gc.collect()
    finally:
        gc.enable()
    assert comparison.compliance.finished_runs >= 3 and n_garbage == 0
