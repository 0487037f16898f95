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

"""Runs that the clock cuts: the same for any chunks, live and offline, and flat over a month."""

from __future__ import annotations

import gc
import json
import tracemalloc

import numpy as np
import pytest

from heading_intercompare import (
    analyze,
    Compliance,
    Headings,
    Intercomparison,
    Settings,
)
from heading_intercompare.core.pairing.pairer import Pairer
from heading_intercompare.messages.ledger_messages import decode_ledger, encode_ledger

S = 1_000_000_000
H = 3600 * S
DAY = 24 * H
NOON = 20_000 * DAY + 12 * H
NORMS = {'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1, 'risk.min_duration_s': 0.0}


def settings(**names):
    return Settings.from_mapping({**NORMS, **{k.replace('__', '.'): v for k, v in names.items()}})


def sensors(rng, span_s, step_s=1.0, start_ns=NOON, without=()):
    """Return the headings of a ship that turns, without the readings of the TS in some spans."""
    t = np.arange(0.0, span_s, step_s)
    heading = 350.0 + 20.0 * np.sin(t / 300.0)
    stamp = start_ns + np.round(t * 1e9).astype(np.int64)
    ts = Headings.of(stamp, (heading + 0.05 + 0.2 * rng.standard_normal(len(t))) % 360.0)
    rs = Headings.of(stamp, (heading + 0.05 * rng.standard_normal(len(t))) % 360.0)
    for lo_s, hi_s in without:
        ts = ts[(ts.stamp_ns < start_ns + lo_s * S) | (ts.stamp_ns >= start_ns + hi_s * S)]
    return ts, rs


def exact(results):
    return [json.dumps([r.verdict.start_ns, r.verdict.end_ns, r.verdict.n, r.verdict.mean_deg,
                        r.verdict.std_deg, str(r.verdict.outcome), r.verdict.headline,
                        r.verdict.n_stabilization, r.verdict.pairing.ts_received,
                        r.verdict.pairing.rs_received, r.verdict.pairing.paired,
                        r.verdict.pairing.ts_unpaired, r.verdict.pairing.rs_unused,
                        [f.evidence for f in r.verdict.validity if f.condition == 'losses']])
            for r in results]


def judge(ts, rs, rule, chunk_s=None):
    comparison = Intercomparison(rule)
    bounds = [None, None] if chunk_s is None else range(
        int(rs.stamp_ns[0]), int(rs.stamp_ns[-1]) + chunk_s * S + 1, chunk_s * S)
    if chunk_s is None:
        comparison.update(ts, rs)
    else:
        for lo, hi in zip(bounds, bounds[1:]):
            for name, h in (('ts', ts), ('rs', rs)):
                comparison.update(**{name: h[(h.stamp_ns >= lo) & (h.stamp_ns < hi)]})
    comparison.finish()
    return comparison


def judge_live(ts, rs, rule, chunk_s):
    """Judge as the two nodes do: pairs and ledger come apart, the ledger as a message."""
    pairer, compliance = Pairer(rule), Compliance(rule)
    earlier, sizes = [], []
    for lo in range(int(rs.stamp_ns[0]), int(rs.stamp_ns[-1]) + 1, chunk_s * S):
        pick = (h[(h.stamp_ns >= lo) & (h.stamp_ns < lo + chunk_s * S)] for h in (ts, rs))
        n = compliance.finished_runs
        compliance.update(pairer.update(*pick))
        pairer.forget_earlier()
        sizes.append(len(pairer.ledger.segments))
        if compliance.finished_runs != n:
            compliance.results(decode_ledger(encode_ledger(pairer.ledger))[0])
            earlier += compliance.take_earlier()
    compliance.update(pairer.flush())
    compliance.finish()
    return compliance, decode_ledger(encode_ledger(pairer.ledger, True))[0], earlier, sizes


@pytest.mark.slow
@pytest.mark.parametrize('rule', [{'runs__every_h': 1.0}, {'runs__cut_at_utc': '13:00,14:00'},
                                  {'runs__every_h': 0.5, 'runs__stabilization_s': 2400.0},
                                  {'runs__every_h': 1.0, 'pairing__method': 'nearest'},
                                  {'runs__every_h': 1.0, 'sequential__plan_s': 3600.0}])
def test_any_chunks_give_the_runs_of_the_whole(rng, rule):
    rule = settings(**rule)
    ts, rs = sensors(rng, 9000, without=[(3590, 3640), (5000, 5200)])
    whole = judge(ts, rs, rule)
    for chunk_s in (61, 1207):
        assert exact(judge(ts, rs, rule, chunk_s).results()) == exact(whole.results())
    compliance, ledger, earlier, _ = judge_live(ts, rs, rule, 101)
    assert exact(compliance.results(ledger)) == exact(whole.results()) and not earlier


def test_a_cut_opens_a_segment_and_every_reading_belongs_to_one_run(rng):
    """4 h at 1 Hz from noon, cut at 13, 14 and 15 h: 3600 readings of each sensor to a run."""
    ts, rs = sensors(rng, 4 * 3600)
    runs = analyze(ts, rs, settings(runs__every_h=1.0)).runs
    assert [run.start_ns for run in runs] == [NOON + k * H for k in range(4)]
    assert [run.n for run in runs] == [3600] * 4
    for run in runs:
        assert run.pairing.ts_received == run.pairing.rs_received == run.pairing.paired == 3600


@pytest.mark.slow
def test_a_dead_rs_around_a_cut_is_charged_to_the_run_before_it(rng):
    """The RS is silent 300 s over a cut: two runs, the TS readings without partner in none."""
    ts, rs = sensors(rng, 2 * 3600)
    dead = (rs.stamp_ns > NOON + H - 100 * S) & (rs.stamp_ns < NOON + H + 200 * S)
    rs = rs[~dead]
    rule = settings(runs__every_h=1.0, runs__gap_s=600.0)
    whole = judge(ts, rs, rule).results()
    for chunk_s in (30, 1000):
        assert exact(judge(ts, rs, rule, chunk_s).results()) == exact(whole)
    assert [r.verdict.end_ns for r in whole] == [NOON + H - 100 * S, NOON + 2 * H - S]
    received = [r.verdict.pairing.ts_received for r in whole]
    assert sum(received) == len(ts)


def test_only_the_first_run_after_a_silence_has_a_stabilisation_period(rng):
    """900 s from noon and again from 14:30; what is left of it at a cut goes on after the cut."""
    ts, rs = sensors(rng, 4 * 3600, without=[(2 * 3600, 2.5 * 3600)])
    runs = analyze(ts, rs, settings(runs__every_h=1.0, runs__stabilization_s=900.0)).runs
    assert [run.n_stabilization for run in runs] == [900, 0, 900, 0]
    late = sensors(rng, 3600, start_ns=NOON - 300 * S)
    runs = analyze(*late, settings(runs__every_h=1.0, runs__stabilization_s=900.0)).runs
    assert [run.n_stabilization for run in runs] == [300, 600]


def test_an_automatic_stabilisation_period_is_not_looked_for_in_a_run_that_goes_on(rng):
    ts, rs = sensors(rng, 2 * 3600, step_s=2.0)
    t = (ts.stamp_ns - NOON) / 1e9
    warm = 3.0 * (np.exp(-t / 300.0) + np.exp(-np.maximum(t - 3600.0, 0) / 300.0) * (t >= 3600))
    ts = Headings.of(ts.stamp_ns, ts.heading_deg + warm)
    runs = analyze(ts, rs, settings(runs__every_h=1.0, runs__stabilization_s='auto')).runs
    assert runs[0].n_stabilization > 100 and runs[1].n_stabilization == 0


@pytest.mark.parametrize('stabilization', [600.0, 'auto'])
def test_an_aligned_run_that_goes_on_has_no_stabilisation_period_either(rng, stabilization):
    ts, rs = sensors(rng, 3600, start_ns=NOON - 1800 * S)
    rule = settings(runs__every_h=1.0, runs__stabilization_s=stabilization,
                    alignment__skew='apply')
    plain = settings(runs__every_h=1.0, runs__stabilization_s=stabilization)
    aligned, whole = analyze(ts, rs, rule).runs, analyze(ts, rs, plain).runs
    assert len(aligned) == len(whole) == 2
    assert aligned[1].n_stabilization == whole[1].n_stabilization == 0


@pytest.mark.slow
def test_looks_begin_anew_with_each_run(rng):
    ts, rs = sensors(rng, 3 * 3600)
    runs = analyze(ts, rs, settings(runs__every_h=1.0, sequential__plan_s=3600.0)).runs
    assert len(runs) == 3
    assert len({tuple(look.look for look in run.looks) for run in runs}) == 1
    assert all(len(run.looks) > 2 for run in runs)


@pytest.mark.slow
def test_adjacent_runs_do_not_stand_in_for_slow_errors(rng):
    """Runs without a pause between them say nothing new about errors slower than a run."""
    ts, rs = sensors(rng, 6 * 3600)
    verdict = analyze(ts, rs, settings(runs__every_h=1.0, campaign__rule='sensor'))
    assert verdict.campaign.m == 6
    assert verdict.campaign.sensor.apart_s == pytest.approx(1.0)


@pytest.mark.slow
def test_a_verdict_covers_the_newest_cuts_and_hands_out_the_runs_before(rng):
    ts, rs = sensors(rng, 6 * 3600)
    every = judge(ts, rs, settings(runs__every_h=1.0)).results()
    rule = settings(runs__every_h=1.0, runs__keep=2)
    offline = judge(ts, rs, rule)
    kept = offline.results()
    assert exact(kept) == exact(every[3:])
    state = offline.compliance.keep().to_text()
    assert offline.verdict() and offline.compliance.preview()
    assert exact(offline.results()) == exact(kept), 'a second call gives the same'
    assert offline.compliance.keep().to_text() == state, 'a question changes nothing'
    assert exact(offline.compliance.take_earlier()) == exact(every[:3])
    assert offline.compliance.take_earlier() == []
    assert any(w.startswith('earlier_runs: 3 runs before') for w in kept[0].verdict.warnings)
    compliance, ledger, earlier, _ = judge_live(ts, rs, rule, 60)
    assert exact(compliance.results(ledger)) == exact(kept)
    assert exact(earlier + compliance.take_earlier()) == exact(every[:3])


@pytest.mark.slow
@pytest.mark.endurance
def test_thirty_days_take_no_more_memory_than_three():
    """A month at one reading in 5 s, cut each day, as the nodes judge it."""
    rng = np.random.default_rng(30)
    rule = settings(runs__cut_at_utc='00:00', runs__keep=2, window_s=600.0)
    pairer, compliance = Pairer(rule), Compliance(rule)
    held, segments, documents, rows = [], [], [], 0
    tracemalloc.start()
    try:
        for day in range(30):
            for part in range(24):
                ts, rs = sensors(rng, 3600, 5.0, NOON + day * DAY + part * H)
                compliance.update(pairer.update(ts, rs))
                pairer.forget_earlier()
            results = compliance.results(decode_ledger(encode_ledger(pairer.ledger))[0])
            documents.append(len(results))
            rows += len(compliance.take_earlier())
            segments.append(len(pairer.ledger.segments))
            del results
            gc.collect()
            held.append(tracemalloc.get_traced_memory()[0])
    finally:
        tracemalloc.stop()
    assert compliance.finished_runs == 30 and rows == 28
    assert documents[3:] == [2] * 27
    assert max(segments[5:]) == max(segments[5:8]) <= 2 * 2 + 3
    assert max(held[20:]) < max(held[5:10]) + 300_000, held
