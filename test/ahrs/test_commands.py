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

"""A command during a trial acts like the same entry of the scenario, to the bit."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.ahrs.faults import FAULTS
from heading_intercompare.ahrs.settings import Scenario
from heading_intercompare.ahrs.simulator import Simulation
from heading_intercompare.core.records import Headings

TRIAL = {'duration_s': 100.0, 'seed': 3, 'seaway': 'ss3', 'legs': '0 20 12; 30 100 12',
         'ts': {'model': 'marine_0p1', 'rate_hz': 8.0, 'latency_s': 0.3, 'dropout': 0.1,
                'ahrs.initial_state': 'aligned'}}


def begun(**ts):
    """Return the trial, with more settings of the TS."""
    return Simulation(Scenario.from_mapping({**TRIAL, 'ts': {**TRIAL['ts'], **ts}})).begin()


def rest_of(trial, step_s=0.7):
    """Return the chunks up to the end."""
    chunks = []
    while not trial.over:
        chunks.append(trial.advance(trial.now_s + step_s))
    return chunks


def statuses(chunks):
    """Return the statuses of the TS in chunks."""
    return [status for chunk in chunks for status in chunk.ts_statuses]


def said(chunks):
    """Return readings and statuses of the TS in chunks, to be compared; nan is equal to nan."""
    ts = Headings.concatenate(chunk.ts for chunk in chunks)
    sigma_deg = np.concatenate([chunk.ts_readings.sigma_deg for chunk in chunks])
    return (ts.stamp_ns.tolist(), ts.heading_deg.tobytes(), sigma_deg.tobytes(),
            repr(statuses(chunks)))


def scheduled(**ts):
    """Return readings and statuses with everything in the scenario."""
    return said(rest_of(begun(**ts), 100.0))


def test_a_trial_ends_when_all_is_handed_over():
    trial = begun()
    chunks = rest_of(trial, 40.0)
    assert [chunk.end_s for chunk in chunks] == [40.0, 80.0, 120.0]
    assert trial.now_s == 120.0 and trial.over


@pytest.mark.slow
@pytest.mark.parametrize('kind', FAULTS)
def test_fault_injected_now_is_the_fault_of_the_scenario(kind):
    """Injected when 33.6 s are delivered; mended when 61.6 s are."""
    trial = begun()
    chunks = [trial.advance(33.6)]
    assert trial.inject('ts', kind) == 33.6
    chunks += [trial.advance(50.0), trial.advance(61.6)]
    assert trial.mend('ts', kind) == 61.6
    value = FAULTS[kind][1]
    assert said(chunks + rest_of(trial)) == scheduled(faults=f'33.6 {kind} {value} 28')
    assert said(chunks) != scheduled()


def test_fault_may_be_injected_ahead_and_with_a_value():
    trial = begun()
    assert trial.inject('ts', 'jump', -7.0, t_s=42.0) == 42.0
    assert said(rest_of(trial)) == scheduled(faults='42 jump -7')


def test_fault_of_the_scenario_can_be_mended():
    trial = begun(faults='20 mirrored')
    chunks = [trial.advance(30.0)]
    trial.mend('ts', 'mirrored')
    assert said(chunks + rest_of(trial)) == scheduled(faults='20 mirrored 90 10')


def test_the_other_sensor_does_not_notice():
    trial, sound = begun(), begun()
    trial.inject('rs', 'rotated')
    one, other = rest_of(trial), rest_of(sound)
    assert said(one) == said(other)
    assert one[5].rs != other[5].rs


@pytest.mark.parametrize('kind, mode', [('gyro_azimuth', 'GYRO_AZIMUTH'),
                                        ('fail_gyro', 'FAULT')])
def test_command_ahead_of_time_is_the_event_of_the_scenario(kind, mode):
    trial = begun()
    chunks = [trial.advance(5.0)]
    assert trial.command('ts', kind, t_s=46.3) == 46.3
    chunks += rest_of(trial)
    assert said(chunks) == scheduled(**{'ahrs.events': f'46.3 {kind}'})
    assert statuses(chunks)[-1].mode == mode


@pytest.mark.parametrize('step_s', [0.05, 3.7, 11.9])
def test_command_of_now_happens_with_the_next_block(step_s):
    """With 33.9 s delivered by a sensor 0.3 s late, the block up to 40 s has been made."""
    trial = begun()
    chunks = [trial.advance(20.0), trial.advance(33.9)]
    assert trial.command('ts', 'gyro_azimuth') == pytest.approx(40.0)
    chunks += [trial.advance(50.0)]
    assert trial.command('ts', 'gyrocompass') == pytest.approx(50.0)
    chunks += rest_of(trial, step_s)
    assert said(chunks) == scheduled(**{'ahrs.events': '40 gyro_azimuth; 50 gyrocompass'})
    assert [status.message for status in statuses(chunks) if status.message] == [
        'mode GYROCOMPASS', 'mode GYRO_AZIMUTH', 'mode GYROCOMPASS']


@pytest.mark.parametrize('act, words', [
    (lambda t: t.inject('ts', 'melt'), "fault 'melt': must be freeze or"),
    (lambda t: t.command('ts', 'dance'), "command 'dance': must be gyrocompass or"),
    (lambda t: t.command('rs', 'gyrocompass'), "a sensor of the model 'ideal' has no modes"),
    (lambda t: t.inject('ts', 'jump', t_s=10.0), r't_s = 10.0: must be at least 20 s'),
    (lambda t: t.mend('ts', 'jump'), 'jump is not present'),
    (lambda t: (t.inject('rs', 'jump'), t.inject('rs', 'jump')), 'jump is already present')])
def test_what_cannot_be_is_refused_with_its_reason(act, words):
    trial = begun()
    trial.advance(20.0)
    with pytest.raises(ValueError, match=words):
        act(trial)
