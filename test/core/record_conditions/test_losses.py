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

"""Lost readings bind the verdict, at a look as at the end."""

from __future__ import annotations

import numpy as np
import pytest
from trials import find_finding, judge_headings

from heading_intercompare import analyze, Headings, Settings, Verdict
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.record_conditions.losses import judge_losses
from heading_intercompare.core.validity.condition import DOUBTFUL, HOLDS, NOT_TESTABLE, VOID

STEP_NS = 10 ** 8
START_NS = 1_700_000_000 * 10 ** 9


@pytest.mark.parametrize('share, effect', [
    (0.1, HOLDS), (0.1001, DOUBTFUL), (0.5, DOUBTFUL), (0.5001, VOID)])
def test_losses_bind_above_their_limits_not_at_them(share, effect):
    found = judge_losses([('lost', share), ('without partner', 0.01)])
    assert found.effect == effect


def test_losses_of_a_single_pair_cannot_be_told():
    assert judge_losses([]).effect == NOT_TESTABLE


@pytest.mark.slow
@pytest.mark.parametrize('kept, expected', [
    (0.95, 'compliant'), (0.3, 'indeterminate')])
def test_a_look_judges_the_gaps_between_the_pairs(rng, kept, expected):
    """Of an hour, only a share of the first 15 min is kept, and all of the rest."""
    stamps = np.arange(1, 36_001) * STEP_NS
    stamps = stamps[(stamps > 900 * 10 ** 9) | (rng.random(stamps.size) < kept)]
    t = stamps / 1e9
    ship = 90.0 + 40.0 * np.sin(t / 100.0) + np.sin(2.0 * np.pi * t / 8.0)
    ts, rs = (Headings.as_sent(stamps, ship + s * rng.standard_normal(stamps.size))
              for s in (0.1, 0.05))
    verdict = analyze(ts, rs, Settings.from_mapping({
        'norms': {'sigma_max_deg': 0.3, 'sigma_ref_max_deg': 0.1},
        'sequential': {'plan_s': 3600.0, 'looks': 3}}))
    run = verdict.runs[0]
    first, second = run.looks[:2]
    assert first.outcome.value == expected
    assert first.reason == ('void.losses' if kept < 0.5 else 'upper_bound_within_acceptance_limit')
    assert second.outcome.value == 'compliant'
    assert run.outcome.value == 'compliant'


def judge(rng, **stamps):
    """Judge 36 000 readings of sound sensors at 10 Hz; `ts` and `rs` give other stamps."""
    regular = START_NS + np.arange(1, 36_001) * STEP_NS
    ship = 90.0 + 40.0 * np.sin(regular / 1e11)
    ts_deg, rs_deg = (ship + sigma * rng.standard_normal(regular.size) for sigma in (0.1, 0.05))
    return judge_headings(ts_deg, rs_deg, stamps.get('ts', regular), stamps.get('rs', regular))


@pytest.mark.parametrize('who', ['ts', 'rs'])
@pytest.mark.parametrize('rows', [[0], [7000], [7000, 7001], [7000, 9000, 20_000],
                                  [*range(7000, 7050)], [35_999]])
def test_stamps_of_the_future_cost_only_their_readings(rng, rows, who):
    stamps = START_NS + np.arange(1, 36_001) * STEP_NS
    stamps[rows] += 86_400 * 10 ** 9
    (run,) = judge(rng, **{who: stamps}).runs
    assert run.outcome is Outcome.COMPLIANT and run.validity_effect == HOLDS
    assert run.n >= 36_000 - len(rows)
    rejected = getattr(run.pairing.rejected, who)
    assert rejected == {'jump': len(rows)}


@pytest.mark.parametrize('who', ['ts', 'rs'])
def test_a_clock_ahead_for_a_while_ends_the_run_and_the_next_one_is_judged(rng, who):
    """Stamped tomorrow for 8 s: then the clock is set back."""
    stamps = START_NS + np.arange(1, 36_001) * STEP_NS
    stamps[7000:7080] += 86_400 * 10 ** 9
    run, after = judge(rng, **{who: stamps}).runs
    assert (run.n, after.n, after.clock_segment) == (7000, 28_920, 1)
    assert find_finding(run, 'losses').effect == find_finding(after, 'clocks').effect == HOLDS
    assert find_finding(run, 'clocks').words == (
        f'the clock of the {who.upper()} was set back by 86400.0 s at 2023-11-15 22:25:08.000 UTC')


@pytest.mark.parametrize('both', [True, False])
def test_a_clock_set_back_by_an_hour_is_named(rng, both):
    """After 40 min; of one sensor alone, what follows has no partner."""
    stamps = START_NS + np.arange(1, 36_001) * STEP_NS
    stamps[24_000:] -= 3600 * 10 ** 9
    verdict = judge(rng, ts=stamps, **({'rs': stamps} if both else {}))
    run, *after = verdict.runs
    assert (run.n, run.outcome) == (24_000, Outcome.COMPLIANT)
    assert [(later.n, later.clock_segment) for later in after] == [(12_000, 1)] * both
    words = 'the clock of the TS was set back by 3600.0 s at 2023-11-14 22:53:20.000 UTC'
    assert find_finding(run, 'clocks').effect == DOUBTFUL
    assert words in find_finding(run, 'clocks').words
    assert ('of the RS' in find_finding(run, 'clocks').words) == both
    assert words in verdict.headline
    assert sum(judged.pairing.ts_received for judged in verdict.runs) == 36_000
    assert run.pairing.rejected.ts == {}
    assert Verdict.from_dict(verdict.to_dict()).to_dict() == verdict.to_dict()


@pytest.mark.parametrize('who', ['ts', 'rs'])
def test_a_clock_set_forward_by_an_hour_is_a_warning(rng, who):
    """After 40 min: no stamp contradicts it, and the verdict did not say a word."""
    stamps = START_NS + np.arange(1, 36_001) * STEP_NS
    stamps[24_000:] += 3600 * 10 ** 9
    (run,) = judge(rng, **{who: stamps}).runs
    assert run.n == 24_000
    assert [words for words in run.warnings if 'perhaps a clock stepped' in words] == [
        '33 % of the TS readings and 33 % of the RS readings came before the first pair or after '
        'the last one, and have no partner: perhaps a clock stepped']


@pytest.mark.parametrize('span', [(0, 24_000), (12_000, 36_000), (6000, 30_000)])
def test_a_sensor_that_started_later_or_ended_earlier_is_no_warning(rng, span):
    stamps = START_NS + np.arange(1, 36_001) * STEP_NS
    ship = 90.0 + 40.0 * np.sin(stamps / 1e11)
    part = slice(*span)
    ts = Headings.as_sent(stamps[part], ship[part] + 0.1 * rng.standard_normal(24_000))
    rs = Headings.as_sent(stamps, ship + 0.05 * rng.standard_normal(36_000))
    (run,) = analyze(ts, rs, Settings.from_mapping({
        'norms': {'sigma_max_deg': 0.3, 'sigma_ref_max_deg': 0.1}})).runs
    assert run.n == 24_000 and not [w for w in run.warnings if 'clock' in w]


def test_a_clock_set_back_by_half_a_second_costs_half_a_second(rng):
    stamps = START_NS + np.arange(1, 36_001) * STEP_NS
    stamps[24_000:] -= STEP_NS * 5
    (run,) = judge(rng, ts=stamps, rs=stamps).runs
    assert run.outcome is Outcome.COMPLIANT and run.validity_effect == HOLDS
    assert run.pairing.rejected.ts == {'stamp_not_increasing': 5}


def test_a_silence_of_two_hours_makes_two_runs_and_costs_nothing(rng):
    stamps = START_NS + np.arange(1, 36_001) * STEP_NS
    stamps[18_000:] += 2 * 3600 * 10 ** 9
    verdict = judge(rng, ts=stamps, rs=stamps)
    assert [run.n for run in verdict.runs] == [18_000, 18_000]
    assert verdict.outcome is Outcome.COMPLIANT and verdict.validity_effect == HOLDS


def test_readings_rejected_between_runs_are_not_lost_from_a_run(rng):
    """At berth, after the stop mark, a TS that flags itself as invalid for an hour."""
    stamps = np.arange(1, 50_001) * STEP_NS
    ship = 90.0 + 40.0 * np.sin(stamps / 1e11)
    ts = ship + 0.1 * rng.standard_normal(stamps.size)
    ts[14_000:] = np.nan
    rs = ship + 0.05 * rng.standard_normal(stamps.size)
    both = Headings.as_sent(stamps, ts), Headings.as_sent(stamps, rs)
    run = analyze(*both, Settings.from_mapping({
        'norms': {'sigma_max_deg': 0.3, 'sigma_ref_max_deg': 0.1}})).runs[0]
    assert find_finding(run, 'losses').effect == HOLDS
@pytest.mark.parametrize('twin', ['TS', 'RS'])
def test_a_sound_sensor_that_sends_two_sentences_a_reading_is_certified(twin, rng):
    """HDT and THS 5 ms apart: void before, with 90 % lost."""
    t = np.arange(1, 12_001) * 0.1
    ship = 90.0 + 40.0 * np.sin(t / 100.0) + np.sin(2.0 * np.pi * t / 8.0)
    streams = []
    for name, sigma in (('TS', 0.1), ('RS', 0.05)):
        heading, at = ship + sigma * rng.standard_normal(t.size), t
        if name == twin:
            heading, at = np.repeat(heading, 2), np.sort(np.concatenate((t, t + 0.005)))
        streams.append(Headings.as_sent(np.rint(at * 1e9).astype(np.int64), heading))
    verdict = analyze(*streams, Settings.from_mapping({
        'norms': {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1}}))
    losses = find_finding(verdict.runs[0], 'losses')
    assert (losses.effect, verdict.outcome.value) == (HOLDS, 'compliant')
