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

"""A simulated trial is the same however it is cut (A11), and fast (A10)."""

from __future__ import annotations

from dataclasses import replace
import resource

import numpy as np
import pytest

from heading_intercompare.ahrs.settings import Scenario
from heading_intercompare.ahrs.simulator import Simulation
from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.records import Headings

TRIAL = {
    'duration_s': 205.3, 'seaway': 'ss3', 'legs': '0 20 12; 60 100 12', 'seed': 9,
    'ts': {'model': 'marine_0p1', 'rate_hz': 12.5, 'white_deg': 0.05, 'markov_deg': 0.05,
           'stamp_jitter_s': 0.01, 'dropout': 0.05, 'latency_s': 0.35, 'phase_s': 0.013,
           'faults': '50 freeze 0 5; 120 jump 3', 'ahrs': {
               'initial_state': 'aligned', 'events': '100 gyro_azimuth'}},
    'rs': {'model': 'gnss_compass', 'rate_hz': 7.0, 'white_deg': 0.05}}


def joined(scenario, chunk_s):
    """Return all data that a trial delivers."""
    chunks = list(Simulation(scenario).chunks(chunk_s))
    return ([Headings.concatenate(getattr(chunk, name) for chunk in chunks)
             for name in ('ts', 'rs', 'truth')]
            + [np.concatenate([getattr(getattr(chunk, name), column) for chunk in chunks])
               for name in ('ts_readings', 'rs_readings') for column in (
                   't_s', 'sigma_deg', 'rate_deg_s')],
            [status for chunk in chunks for status in chunk.ts_statuses])


@pytest.mark.slow
@pytest.mark.parametrize('chunk_s', [0.1, 7.3, 1000.0])
def test_a11_a_trial_is_the_same_to_the_bit_however_it_is_cut(chunk_s):
    scenario = Scenario.from_mapping(TRIAL)
    arrays, statuses = joined(scenario, 60.0)
    others, other_statuses = joined(scenario, chunk_s)
    for one, other in zip(arrays[:3], others[:3]):
        assert one == other
    for one, other in zip(arrays[3:], others[3:]):
        assert np.array_equal(one, other, equal_nan=True)
    assert statuses == other_statuses
    assert len(arrays[0]) > 2000


def test_a11_the_platform_does_not_know_the_rate_of_the_readings():
    scenario = Scenario.from_mapping(TRIAL)
    faster = replace(scenario, ts=replace(scenario.ts, rate_hz=25.0))
    assert joined(scenario, 60.0)[1] == joined(faster, 60.0)[1]


def test_further_sensors_change_nothing_of_ts_and_rs_and_have_errors_of_their_own():
    alone = Scenario.from_mapping(TRIAL)
    ship = replace(alone, others='a model=dtg_precision rate_hz=5 ahrs.initial_state=aligned\n'
                                 'b rate_hz=2 white_deg=0.1; c rate_hz=2 white_deg=0.1')
    assert joined(ship, 60.0)[1] == joined(alone, 60.0)[1]
    assert joined(ship, 60.0)[0][:3] == joined(alone, 60.0)[0][:3]

    def others(chunk_s):
        chunks = list(Simulation(ship).chunks(chunk_s))
        return {name: (Headings.concatenate(chunk.others[name][0].headings for chunk in chunks),
                       [said for chunk in chunks for said in chunk.others[name][1]])
                for name in 'abc'}
    found = others(60.0)
    assert found == others(7.3)
    assert found['a'][1] and not found['b'][1]
    truth = joined(ship, 60.0)[0][2]
    errors = {name: wrap180(found[name][0].heading_deg - np.interp(
        found[name][0].stamp_ns, truth.stamp_ns, np.unwrap(truth.heading_deg, period=360.0)))
        for name in 'bc'}
    assert 0.05 < np.std(errors['b']) < 0.3
    assert abs(np.corrcoef(errors['b'], errors['c'])[0, 1]) < 0.4


@pytest.mark.parametrize('others, reason', [
    ('ts rate_hz=1', 'others: ts is the name of another stream'),
    ('a rate_hz=0', 'others, row 1 (a rate_hz=0): rate_hz = 0.0: must be'),
    ('a ahrs.gyro=1', "unknown setting 'ahrs.gyro'"),
    ('a; A', 'the name A is given twice')])
def test_wrong_further_sensors_are_refused_with_one_line(others, reason):
    with pytest.raises(SettingsError) as error:
        Scenario(others=others)
    assert reason in str(error.value) and '\n' not in str(error.value)


def test_seed_changes_the_trial():
    scenario = Scenario.from_mapping(TRIAL)
    arrays, _ = joined(scenario, 60.0)
    others, _ = joined(replace(scenario, seed=10), 60.0)
    assert arrays[0] != others[0]
    assert arrays[2] != others[2]


def test_readings_are_handed_over_when_their_latency_is_over():
    for chunk in Simulation(Scenario.from_mapping(TRIAL)).chunks(5.0):
        assert (chunk.ts_readings.t_s + 0.35 < chunk.end_s).all()
        assert (chunk.ts_readings.t_s + 0.35 >= chunk.end_s - 5.0).all()
        assert all(said.t_s + 0.35 < chunk.end_s for said in chunk.ts_statuses)


def test_every_instant_is_read_once():
    scenario = Scenario.from_mapping({'duration_s': 100.0, 'ts.rate_hz': 3.0,
                                      'rs.rate_hz': 0.3, 'rs.phase_s': 1.0})
    (ts, rs, truth, *_), _ = joined(scenario, 0.7)
    assert len(ts) == len(truth) == 300
    assert len(rs) == 30
    assert ts == truth
    assert np.diff(ts.stamp_ns).max() - np.diff(ts.stamp_ns).min() <= 1


def test_a_live_sender_sets_the_start():
    scenario = Scenario.from_mapping({'duration_s': 1.0})
    chunk = next(Simulation(scenario, start_ns=5_000).chunks())
    assert chunk.ts.stamp_ns[0] == 5_000


@pytest.mark.slow
def test_cold_ahrs_is_invalid_until_it_has_settled():
    """At berth: nothing before the meridian is found, then better than 0.3 degrees."""
    scenario = Scenario.from_mapping({
        'duration_s': 5400.0, 'seaway': 'moored', 'ts': {'model': 'dtg_precision',
                                                         'rate_hz': 1.0}})
    (ts, _, truth, _, sigma_deg, *_), statuses = joined(scenario, 60.0)
    valid = np.isfinite(ts.heading_deg)
    found = next(said.t_s for said in statuses if 'meridian found' in said.message)
    assert not valid[:int(found)].any()
    assert valid[int(found) + 2:].all()
    x = wrap180(ts.heading_deg - truth.heading_deg)[valid]
    assert np.abs(x).max() < 0.3
    assert np.isfinite(sigma_deg).tolist() == valid.tolist()
    assert 0.02 < sigma_deg[-1] < 0.2


@pytest.mark.parametrize('mapping, reason', [
    ({'duration': 5}, "unknown setting 'duration'; did you mean 'duration_s'"),
    ({'seaway': 'ss9'}, "seaway = 'ss9': must be 'calm' or"),
    ({'start_utc': '1.1.2026'}, 'start_utc'),
    ({'ts': {'ahrs': {'errors': {'log_scale': -1}}}}, 'log_scale'),
    ({'ts': {'ahrs': {'events': '5 dance'}}}, "kind 'dance'"),
    ({'legs': '0 0'}, 'legs entry 1')])
def test_wrong_scenarios_are_refused_with_one_line(mapping, reason):
    with pytest.raises(SettingsError, match=reason) as caught:
        Scenario.from_mapping(mapping)
    assert '\n' not in str(caught.value)


def test_chunk_must_have_a_length():
    with pytest.raises(ValueError, match='chunk_s = 0'):
        next(Simulation(Scenario()).chunks(0.0))


@pytest.mark.slow
@pytest.mark.endurance
def test_a10_the_memory_does_not_grow_in_twelve_hours_at_100_hz():
    """TS an AHRS, RS a satellite compass."""
    scenario = Scenario.from_mapping({
        'duration_s': 43200.0, 'seaway': 'ss5', 'legs': '0 30 10; 7200 120 12',
        'ts': {'model': 'dtg_precision', 'rate_hz': 100.0, 'ahrs.initial_state': 'aligned'},
        'rs': {'model': 'gnss_compass', 'rate_hz': 100.0}})
    n, at_first = 0, None
    for chunk in Simulation(scenario).chunks():
        n += len(chunk.ts) + len(chunk.rs)
        if at_first is None and chunk.end_s > 600.0:
            at_first = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert n == 2 * 4_320_000
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - at_first
    assert grown < 50_000, f'{grown} kB more after 12 h than after 10 min'
