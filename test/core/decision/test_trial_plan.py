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

"""The chances of a plan are those of real verdicts on simulated trials."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare import analyze, Headings, Settings
from heading_intercompare.core.decision.trial_plan import LEVELS, plan_trial, SimulatedErrors
from heading_intercompare.core.declared_settings import SettingsError

GIVEN = {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1, 'm_low': 0.9, 'slowest_error_s': 20.0}
SETTINGS = Settings.of(**GIVEN)


def ornstein_uhlenbeck(rng, n, step_s, slowest_s):
    """Return a process of unit variance, step by step."""
    x, phi = [rng.standard_normal()], math.exp(-step_s / slowest_s)
    for _ in range(n - 1):
        x.append(phi * x[-1] + math.sqrt(1.0 - phi * phi) * rng.standard_normal())
    return np.array(x)


def single(plan):
    """Return the chances of single runs."""
    return [chance for chance in plan.chances if chance.runs == 1]


@pytest.mark.slow
@pytest.mark.endurance
@pytest.mark.parametrize('level, factor', [(0.5, 1.0), (0.7, 1.5)])
def test_the_chances_are_those_of_real_verdicts(rng, level, factor):
    """60 verdicts of `analyze`, on a process made step by step: within five standard errors."""
    plan = plan_trial(SETTINGS, np.random.default_rng(2), rate_hz=2.0, trials=200,
                      times=(factor,), runs=())
    chance = single(plan)[LEVELS.index(level)]
    # One pair more, so that the last one is not short of the least duration.
    n = round(chance.duration_s * 2.0) + 1
    stamps = 10 ** 18 + np.arange(n) * 500_000_000
    trials, compliant = 60, 0
    for _ in range(trials):
        ts = 0.2 * level * ornstein_uhlenbeck(rng, n, 0.5, 20.0)
        rs = 0.1 * rng.standard_normal(n)
        outcome = analyze(Headings.of(stamps, 90.0 + ts), Headings.of(stamps, 90.0 + rs),
                          SETTINGS).outcome
        compliant += outcome.value == 'compliant'
    error = math.sqrt(0.25 / trials + 0.25 / plan.trials)
    assert 0.2 < chance.compliant < 0.98
    assert abs(compliant / trials - chance.compliant) < 5.0 * error


def test_longer_runs_and_better_sensors_have_better_chances(rng):
    plan = plan_trial(SETTINGS, rng, trials=60, times=(1.0, 16.0), runs=())
    short, long = single(plan)[:3], single(plan)[3:]
    assert plan.least_s == 400.0 and [c.duration_s for c in short + long] == [400.0] * 3 + [
        6400.0] * 3
    assert short[0].compliant > short[2].compliant
    assert all(b.compliant > a.compliant for a, b in zip(short, long))
    for each in plan.chances:
        assert each.compliant + each.non_compliant + each.indeterminate == pytest.approx(1.0)
        assert each.non_compliant <= 0.05


def test_a_run_shorter_than_the_least_duration_is_never_certified(rng):
    plan = plan_trial(SETTINGS, rng, trials=20, times=(0.5,), runs=())
    assert {c.compliant for c in single(plan)} == {0.0} and plan.advised_s == (None,) * 3


def test_the_advice_is_the_shortest_run_that_reaches_the_chance_wanted(rng):
    plan = plan_trial(SETTINGS, rng, trials=40, wanted=0.8, runs=())
    for level, advised in zip(LEVELS, plan.advised_s):
        reached = [c.duration_s for c in single(plan) if c.level == level and c.compliant >= 0.8]
        assert advised == min(reached, default=None)
    assert plan.advised_s[0] < plan.advised_s[1]


@pytest.mark.parametrize('variant, times', [('B', 10.0), ('A', 20.0), ('C', 20.0)])
def test_several_short_runs_are_tried_first_and_certify_in_less(variant, times, rng):
    """Ten runs of 10 slowest errors (S.13, S.19), or five of 20 (S.18), certify 0.7 of a norm."""
    plan = plan_trial(Settings.of(variant=variant, **GIVEN), rng, trials=30, times=(1.0,))
    assert plan.chances[0].runs == 5 and plan.short_s == 20.0 * times
    assert plan.advised_runs[0] == 5 and plan.advised_runs[1] in (5, 7, 10)
    for level, advised in zip(LEVELS, plan.advised_runs):
        reached = [c.runs for c in plan.chances if c.level == level and c.runs > 1
                   and c.compliant >= 0.8]
        assert advised == min(reached, default=None)


def test_the_errors_have_the_variance_and_the_correlation_asked_for():
    """The slow one falls to 1/e in 20 steps; both have unit variance and know nothing of it."""
    slow, white = np.array([SimulatedErrors((7, seed), 1.0, 20.0).draw(4000)
                            for seed in range(200)]).transpose(1, 0, 2)
    assert np.mean(slow ** 2) == pytest.approx(1.0, rel=0.05)
    assert np.mean(white ** 2) == pytest.approx(1.0, rel=0.01)
    assert np.mean(slow[:, 20:] * slow[:, :-20]) == pytest.approx(1.0 / math.e, abs=0.05)
    assert abs(np.mean(slow * white)) < 0.02 and abs(np.mean(white[:, 1:] * white[:, :-1])) < 0.01


def test_a_longer_run_goes_on_with_the_errors_of_the_shorter_one():
    pieces, whole = SimulatedErrors((3, 1), 1.0, 20.0), SimulatedErrors((3, 1), 1.0, 20.0)
    drawn = np.concatenate([pieces.draw(n) for n in (0, 1, 250, 749)], axis=1)
    assert drawn == pytest.approx(np.array(whole.draw(1000)), rel=1e-9)


def test_chances_rise_with_the_length_and_do_not_waver():
    """With errors of their own for each length, seed 2 gave 7, 14, 8, 10, 7, 13, ... percent."""
    settings = Settings.of(sigma_max_deg=0.3, sigma_ref_max_deg=0.2, slowest_error_s=60.0)
    plan = plan_trial(settings, np.random.default_rng(2), times=(1.0, 2.0, 4.0, 16.0), trials=60,
                      runs=())
    chances = [c.compliant for c in single(plan) if c.level == 0.7]
    assert all(longer >= shorter - 0.02 for shorter, longer in zip(chances, chances[1:]))
    assert chances[-1] > chances[0] + 0.15


def test_what_a_user_can_change_is_tried_and_the_best_comes_first(rng):
    """An RS that is hardly known, or as bad as the TS, is what makes the trial long."""
    norms = {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1, 'slowest_error_s': 20.0}
    lengths = {'trials': 30, 'times': (1.0, 2.0, 4.0, 8.0), 'runs': ()}
    plan = plan_trial(Settings.of(**norms), rng, **lengths)
    assert plan.total_s is not None
    assert 'norms.m_low=0.9' in {remedy.change for remedy in plan.remedies}
    totals_s = [remedy.total_s for remedy in plan.remedies]
    assert totals_s == sorted(totals_s) and max(totals_s) < plan.total_s
    better = plan_trial(Settings.of(m_low=0.9, **norms), rng, **lengths)
    assert better.total_s is not None and better.total_s < plan.total_s
    assert 'norms.m_low=0.9' not in {remedy.change for remedy in better.remedies}


@pytest.mark.parametrize('settings, given, words', [
    (Settings.of(sigma_max_deg=0.2, sigma_ref_max_deg=0.1), {}, 'risk.slowest_error_s is missing'),
    (Settings.of(sensor_class='ins'), {}, 'norms.sigma_max_deg is missing'),
    (SETTINGS, {'rate_hz': 0.0}, 'rate_hz = 0.0: must be greater than 0'),
    (SETTINGS, {'trials': 0}, 'trials = 0: must be at least 1'),
    (SETTINGS, {'slow_share': 1.5}, 'slow_share = 1.5: must be from 0 to 1'),
    (SETTINGS, {'wanted': -0.1}, 'wanted = -0.1: must be from 0 to 1')])
def test_what_is_missing_is_said(settings, given, words, rng):
    with pytest.raises((SettingsError, ValueError), match=words):
        plan_trial(settings, rng, **given)
