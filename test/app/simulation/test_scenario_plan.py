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

"""The plan from a scenario: verdicts on cut records, and what the sensors are in truth."""

from __future__ import annotations

from dataclasses import replace
import math
import os

import numpy as np
import pytest

from heading_intercompare import analyze, Headings, Settings
from heading_intercompare.ahrs.plans import parse_legs
from heading_intercompare.ahrs.settings import Scenario
from heading_intercompare.ahrs.simulator import Simulation
from heading_intercompare.app.simulation.scenario_plan import (
    lengthen,
    plan_scenario,
    SHARES,
    TrueDeviation,
)
from heading_intercompare.app.simulation.seeds import run_seeds
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.records import Motion

SETTINGS = Settings.of(sigma_max_deg=0.3, sigma_ref_max_deg=0.1, slowest_error_s=4.0)
TRIAL = {'duration_s': 400.0, 'seed': 7, 'ts.white_deg': 0.2, 'ts.rate_hz': 4.0,
         'rs.white_deg': 0.05, 'rs.rate_hz': 4.0, 'legs': '0 20 8; 100 80 8'}


def scenario(**changes):
    """Return a short trial of a TS at two thirds of its norm."""
    return Scenario.from_mapping({**TRIAL, **changes})


def ignore(text):
    """Show no progress."""


@pytest.mark.slow
def test_the_chances_are_the_verdicts_on_recordings_of_these_lengths():
    """Each trial is simulated at its length alone, and judged by `analyze`."""
    trial = scenario(**{'ts.white_deg': 0.26, 'duration_s': 200.0})
    plan = plan_scenario(trial, SETTINGS, trials=4)
    assert [chance.duration_s for chance in plan.chances] == [200.0 * share for share in SHARES]
    outcomes = set()
    for chance in plan.chances:
        verdicts = []
        for seed in range(7, 11):
            chunks = [*Simulation(replace(trial, seed=seed,
                                          duration_s=chance.duration_s + 2.5)).chunks()]
            verdicts.append(analyze(
                Headings.concatenate([chunk.ts for chunk in chunks]),
                Headings.concatenate([chunk.rs for chunk in chunks]), SETTINGS,
                motion=Motion.concatenate([chunk.motion for chunk in chunks])).outcome.value)
        assert chance.shares == tuple(
            verdicts.count(outcome) / 4 for outcome in ('compliant', 'non_compliant',
                                                        'indeterminate'))
        outcomes.update(verdicts)
    assert len(outcomes) > 1


@pytest.mark.slow
@pytest.mark.parametrize('white_deg, outcome', [(0.1, 'compliant'), (0.6, 'non_compliant')])
def test_a_good_and_a_bad_sensor_are_told_apart(white_deg, outcome):
    plan = plan_scenario(scenario(**{'ts.white_deg': white_deg}), SETTINGS, trials=3)
    assert plan.least_s == 80.0 and plan.seeds == (7, 8, 9)
    short, *_, longest = plan.chances
    assert short.duration_s < plan.least_s and short.compliant == 0.0
    assert getattr(longest, outcome) == 1.0 and longest.level is None
    assert sum(plan.reasons.values()) == 3
    assert {reason.partition(':')[0].replace('-', '_') for reason in plan.reasons} == {outcome}
    reached = [chance.duration_s for chance in plan.chances if chance.compliant >= 0.8]
    assert plan.advised_s == min(reached, default=None)


def test_the_true_deviations_are_those_of_the_scenario():
    """2000 white errors by seed have a standard deviation within 1.6 %; five of these errors."""
    plan = plan_scenario(scenario(duration_s=500.0), SETTINGS, trials=2)
    for sensor, norm_deg, std_deg in ((plan.ts, 0.3, 0.2), (plan.rs, 0.1, 0.05)):
        assert sensor.norm_deg == norm_deg
        assert sensor.std_deg == pytest.approx(std_deg, rel=0.08)
        low_deg, up_deg = sensor.range_deg
        assert low_deg <= sensor.std_deg <= up_deg
    assert f'{plan.ts.std_deg / 0.3:.2f} of its norm of 0.3 deg' in plan.ts.words


def test_true_deviations_by_hand():
    """sqrt((0.3² + 0.4²) / 2) = 0.3536; a seed without a reading does not count."""
    deviation = TrueDeviation.of(0.5, [0.3, math.nan, 0.4])
    assert deviation.std_deg == pytest.approx(math.sqrt(0.125))
    assert deviation.range_deg == (0.3, 0.4)
    assert TrueDeviation.of(0.5, [math.nan]).words == 'no reading'


def test_further_sensors_change_nothing():
    others = scenario(others='gyro2 rate_hz=2', duration_s=120.0)
    alone = scenario(duration_s=120.0)
    assert plan_scenario(others, SETTINGS, trials=1) == plan_scenario(alone, SETTINGS, trials=1)


@pytest.mark.process
@pytest.mark.slow
def test_processes_give_the_same_plan():
    trial = scenario(duration_s=120.0)
    plans = [plan_scenario(trial, SETTINGS, trials=3, jobs=jobs) for jobs in (1, 2)]
    assert plans[0] == plans[1]


@pytest.mark.process
@pytest.mark.slow
def test_a_process_that_dies_is_named():
    with pytest.raises(ValueError, match='--jobs 2: a process that simulated died'):
        run_seeds(os._exit, (1, 2), 60.0, 2, ignore)


@pytest.mark.parametrize('duration_s', [150.0, 400.0, 1000.0])
def test_a_longer_scenario_begins_with_the_shorter_one_and_sails_its_legs_again(duration_s):
    trial = scenario(legs='0 20 8; 100 80 8; 390 30 8; 500 10 8')
    changed = lengthen(trial, duration_s)
    legs = parse_legs(changed.legs)
    assert changed.duration_s == duration_s
    assert [leg.t_s for leg in legs] == [
        t_s for t_s in (0.0, 100.0, 390.0, 400.0, 500.0, 790.0, 800.0, 900.0) if t_s < duration_s]
    assert [leg.course_deg for leg in legs] == [(20.0, 80.0, 30.0)[at % 3]
                                                for at in range(len(legs))]
    shorter, longer = (next(Simulation(sailed).chunks(120.0)).ts
                       for sailed in (trial, changed))
    assert np.array_equal(shorter.heading_deg, longer.heading_deg)


@pytest.mark.parametrize('settings, options, words', [
    (Settings.of(sigma_ref_max_deg=0.1), {}, 'norms.sigma_max_deg is missing'),
    (SETTINGS, {'trials': 0}, 'trials = 0: must be at least 1'),
    (SETTINGS, {'probability': 1.5}, 'probability = 1.5: must be from 0 to 1')])
def test_what_is_wrong_is_named_before_anything_is_simulated(settings, options, words):
    with pytest.raises((SettingsError, ValueError), match=words):
        plan_scenario(scenario(duration_s=2e6), settings, **options)
