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

"""The scenario files are right and show what they say."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from heading_intercompare import analyze, analyze_sensors, Headings, Settings
from heading_intercompare.ahrs.settings import Scenario
from heading_intercompare.ahrs.simulator import Simulation
from heading_intercompare.core.angles import wrap180

yaml = pytest.importorskip('yaml')

FOLDER = Path(__file__).resolve().parents[2] / 'config' / 'scenarios'
FILES = sorted(FOLDER.glob('*.yaml'))


def read(path):
    """Return the scenario of a file."""
    return Scenario.from_mapping(yaml.safe_load(path.read_text(encoding='utf-8')))


def test_there_are_scenarios():
    assert {'demo', 'harbour_alignment', 'sea_trial_12h', 'warm_up', 'ts_below_norm',
            'ts_at_norm', 'ts_above_norm', 'degraded_rs'} <= {path.stem for path in FILES}


@pytest.mark.parametrize('path', FILES, ids=lambda path: path.stem)
def test_scenario_runs(path):
    scenario = replace(read(path), duration_s=60.0)
    assert scenario.title
    assert sum(len(chunk.ts) for chunk in Simulation(scenario).chunks()) > 0


@pytest.mark.slow
@pytest.mark.parametrize('name, outcome', [
    ('demo', 'compliant'), ('ts_below_norm', 'compliant'), ('ts_at_norm', 'indeterminate'),
    ('ts_above_norm', 'non_compliant'), ('degraded_rs', 'indeterminate')])
def test_verdict_of_the_scenario(name, outcome):
    """The outcome each file promises under the norms 0.3 and 0.1 degrees."""
    chunks = list(Simulation(read(FOLDER / f'{name}.yaml')).chunks())
    ts, rs = (Headings.concatenate(getattr(chunk, role) for chunk in chunks)
              for role in ('ts', 'rs'))
    verdict = analyze(ts, rs, Settings.from_mapping(
        {'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1}))
    assert verdict.to_dict()['outcome'] == outcome


@pytest.mark.slow
def test_the_swing_finds_the_deviation_of_its_ts():
    """A = 0.1, B = 0.4, C = -0.3, D = 0.2, E = 0, each within four standard uncertainties."""
    chunks = list(Simulation(read(FOLDER / 'swing.yaml')).chunks())
    ts, rs = (Headings.concatenate(getattr(chunk, role) for chunk in chunks)
              for role in ('ts', 'rs'))
    verdict = analyze(ts, rs, Settings.from_mapping(
        {'norms.sigma_max_deg': 0.6, 'norms.sigma_ref_max_deg': 0.1}))
    fit = verdict.runs[0].heading_dependence
    for found, u, given in zip(fit.coefficients_deg, fit.u_deg, (0.1, 0.4, -0.3, 0.2, 0.0)):
        assert abs(found - given) < 4.0 * u < 0.1


def errors_of(name, until_s):
    """Return seconds since the start and errors of the TS of a scenario, without the RS."""
    trial = Simulation(replace(read(FOLDER / f'{name}.yaml'), duration_s=until_s))
    ts = Headings.concatenate(chunk.ts for chunk in trial.chunks())
    t_s, ship = (ts.stamp_ns - trial.start_ns) / 1e9, trial.truth()
    return (t_s, wrap180(ts.heading_deg - ship.heading_deg(t_s)),
            np.degrees(ship.heading_rate_rad_s(t_s)))


@pytest.mark.parametrize('name, lag_s, fastest_deg_s', [
    ('zigzag', 0.3, 1.0), ('fast_zigzag', 0.02, 17.0)])
def test_a_zigzag_shows_its_rate_and_its_lag(name, lag_s, fastest_deg_s):
    """The slope of the error over the rate of turn, within six standard errors."""
    t_s, error_deg, turn_deg_s = errors_of(name, 900.0)
    assert np.abs(turn_deg_s).max() == pytest.approx(fastest_deg_s, rel=0.05)
    slope = np.sum(error_deg * turn_deg_s) / np.sum(turn_deg_s**2)
    assert slope == pytest.approx(-lag_s, abs=6.0 * 0.06 / np.sqrt(np.sum(turn_deg_s**2)))


def test_the_swell_has_a_ts_with_its_tone():
    """An amplitude of 0.4 degrees: rms 0.4 / sqrt 2 beside the white noise."""
    t_s, error_deg, _ = errors_of('swell', 3600.0)
    assert np.std(error_deg) == pytest.approx(np.hypot(0.4 / np.sqrt(2.0), 0.05), rel=0.02)


def test_each_run_up_settles_where_the_file_says():
    t_s, error_deg, _ = errors_of('run_ups', 97200.0)
    for begin_s, settle_point_deg in ((0.0, 0.1), (32400.0, 0.5), (64800.0, -0.25)):
        run = (t_s >= begin_s) & (t_s < begin_s + 31200.0)
        assert error_deg[run][0] == pytest.approx(settle_point_deg + 20.0, abs=0.5)
        assert np.mean(error_deg[run][-7200:]) == pytest.approx(settle_point_deg, abs=0.1)
        assert np.sum(run) == 31200


@pytest.mark.slow
@pytest.mark.parametrize('name, settings, states', [
    ('run_ups', {'preset': 'imo_a821', 'stabilization_s': 'auto', 'latitude_deg': 54.3}, {
        'settling_time': 'met', 'settle_point': 'met', 'rms_of_ten': 'met',
        'repeatability': 'not_met'}),
    ('zigzag', {'preset': 'imo_msc116'}, {
        'static_error': 'not_sailed', 'dynamic_error': 'not_sailed', 'follow_up': 'open'}),
    ('fast_zigzag', {'preset': 'imo_msc116'}, {'resolution': 'met', 'follow_up': 'met'}),
    ('swell', {'preset': 'imo_msc116'}, {
        'dynamic_error': 'met', 'fast_dynamic_error': 'met', 'follow_up': 'not_sailed'}),
    ('swing', {'preset': 'imo_msc116'}, {'static_error': 'met', 'resolution': 'met'})])
def test_a_scenario_sails_the_tests_that_it_names(name, settings, states):
    chunks = list(Simulation(read(FOLDER / f'{name}.yaml')).chunks())
    ts, rs = (Headings.concatenate(getattr(chunk, role) for chunk in chunks)
              for role in ('ts', 'rs'))
    verdict = analyze(ts, rs, Settings.of(sigma_ref_max_deg=0.1, **settings))
    rows = {row.kind: row.state for row in reversed(verdict.campaign.norm_tests)}
    assert {kind: rows[kind] for kind in states} == states


@pytest.mark.slow
def test_the_wrong_one_of_four_sensors_is_named():
    chunks = list(Simulation(read(FOLDER / 'four_sensors.yaml')).chunks())
    headings = {'gyro1': Headings.concatenate(chunk.ts for chunk in chunks),
                'gnss': Headings.concatenate(chunk.rs for chunk in chunks)}
    for name in ('gyro2', 'ins'):
        headings[name] = Headings.concatenate(chunk.others[name][0].headings for chunk in chunks)
    for reference in (' rs', ''):
        verdict = analyze_sensors(headings, Settings.of(
            slowest_error_s=60.0, sensors='gyro1 sigma_max_deg=0.3; gyro2 sigma_max_deg=0.3; '
            f'ins sigma_max_deg=0.1; gnss sigma_max_deg=0.1{reference}'))
        assert verdict.vote.wrong == ('gyro2',)
        assert verdict.outcome.value == 'non_compliant'


def test_demo_is_short_and_turns():
    scenario = read(FOLDER / 'demo.yaml')
    truth = Headings.concatenate(chunk.truth for chunk in Simulation(scenario).chunks())
    assert scenario.duration_s <= 1200.0
    assert np.ptp(truth.heading_deg) > 180.0


def analysed(faults):
    """Return the dictionary of the verdict on a sound, turning TS with these faults."""
    scenario = Scenario.from_mapping({
        'duration_s': 1200.0, 'seaway': 'ss3', 'legs': '0 45 12; 400 160 12; 800 250 12',
        'seed': 6, 'ts': {'white_deg': 0.1, 'faults': faults}, 'rs': {'white_deg': 0.05}})
    chunks = list(Simulation(scenario).chunks())
    ts, rs = (Headings.concatenate(getattr(chunk, role) for chunk in chunks)
              for role in ('ts', 'rs'))
    return analyze(ts, rs, Settings.from_mapping(
        {'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1})).to_dict()


def test_sound_sensor_complies():
    found = analysed('')
    assert found['outcome'] == 'compliant'
    assert found['runs'][0]['pairing']['ts_received'] == 12000


@pytest.mark.slow
@pytest.mark.parametrize('fault', ['300 freeze', '300 jump 5', '300 rotated', '300 mirrored',
                                   '300 clock_step 5'])
def test_analysis_sees_a_wrong_reading(fault):
    """From a quarter of the trial on; each of them is far beyond 0.3 degrees in a turn."""
    found = analysed(fault)
    assert found['outcome'] != 'compliant'
    assert max(run['max_abs_deg'] for run in found['runs']) > 3.0


@pytest.mark.parametrize('fault, received, rejected', [
    ('300 silent 0 20', 11800, {}), ('300 invalid 0 20', 12000, {'invalid': 200}),
    ('300 clock_step -20 50', 12000, {})])
def test_analysis_counts_a_missing_reading(fault, received, rejected):
    """200 readings in 20 s; stamps set back by 20 s go on in the next run."""
    pairings = [run['pairing'] for run in analysed(fault)['runs']]
    assert sum(pairing['ts_received'] for pairing in pairings) == received
    assert pairings[0]['rejected']['ts'] == rejected
