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

"""The command simulate: the contents of its bag, and the result of an analysis."""

from __future__ import annotations

import json
import math

from command_line import NORMS, refusal
import numpy as np
import pytest

from heading_intercompare.ahrs.settings import Scenario
from heading_intercompare.ahrs.simulator import Simulation
from heading_intercompare.app.scenarios import read_scenario
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.cli import main
from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.records import Headings
from heading_intercompare.core.version import VERSION
from heading_intercompare.messages.cdr import decode

TRIAL = """\
title: A trial of the test
duration_s: 130
start_utc: '2026-05-06T07:08:09Z'
seed: 4
seaway: ss3
legs: 0 350 12; 60 20 12
ts:
  model: marine_0p1
  rate_hz: 5
  latency_s: 0.4
  dropout: 0.02
  faults: 100 invalid 0 10; 50 clock_step -3 20
  ahrs: {initial_state: aligned, events: 65 gyro_azimuth}
rs: {rate_hz: 4, phase_s: 0.1, claimed_sigma_deg: 0.5}
"""


@pytest.fixture(scope='module')
def scenario(tmp_path_factory):
    """Return the file of a short trial with many events."""
    path = tmp_path_factory.mktemp('scenario') / 'trial.yaml'
    path.write_text(TRIAL, encoding='utf-8')
    return path


@pytest.fixture(scope='module')
def bag(scenario, tmp_path_factory):
    """Return the bag of the trial."""
    path = tmp_path_factory.mktemp('bag') / 'trial'
    assert main(['simulate', '--scenario', str(scenario), '-o', str(path)]) == 0
    return path


@pytest.fixture(scope='module')
def simulated(scenario):
    """Return the trial as the simulator gives it, in one chunk."""
    return next(Simulation(read_scenario(str(scenario)).scenario).chunks(1000.0))


def headings(bag, topic):
    """Return all headings of a topic."""
    return Headings.concatenate(c[topic] for c in BagReader(bag).headings({topic: 'enu'}))


@pytest.mark.parametrize('topic, role', [
    ('ts/heading', 'ts'), ('rs/heading', 'rs'), ('truth/heading', 'truth')])
def test_bag_holds_what_was_simulated(bag, simulated, topic, role):
    """Stamps agree to the nanosecond, headings to the precision of a quaternion."""
    read, made = headings(bag, topic), getattr(simulated, role)
    assert len(read) > 500
    assert read.stamp_ns.tolist() == made.stamp_ns.tolist()
    assert np.array_equal(np.isnan(read.heading_deg), np.isnan(made.heading_deg))
    assert np.nanmax(np.abs(wrap180(read.heading_deg - made.heading_deg))) < 1e-12


def test_ideal_sensor_reads_the_truth(bag):
    """The RS here; interpolated over 0.2 s in a seaway that yaws by 0.3 degrees rms."""
    truth, rs = headings(bag, 'truth/heading'), headings(bag, 'rs/heading')
    at_rs = np.interp(rs.stamp_ns, truth.stamp_ns, np.unwrap(truth.heading_deg, period=360.0))
    assert np.abs(wrap180(rs.heading_deg - at_rs)).max() < 0.02


def test_messages_claim_a_deviation_and_a_rate_of_turn(bag, simulated):
    messages = [decode(m.type_name, m.data) for m in BagReader(bag).messages(['rs/heading'])]
    assert {m['header']['frame_id'] for m in messages} == {'rs_heading'}
    assert {m['orientation_covariance'][8] for m in messages} == {math.radians(0.5)**2}
    rates = [-math.degrees(m['angular_velocity']['z']) for m in messages]
    assert rates == pytest.approx(simulated.rs_readings.rate_deg_s.tolist())
    assert max(rates) > 0.5


def test_messages_are_logged_when_they_are_handed_over(bag, simulated):
    """They come 0.4 s after their instants, in order although the TS clock steps back by 3 s."""
    logs = [m.log_time_ns for m in BagReader(bag).messages()]
    assert logs == sorted(logs)
    start_ns = Simulation(Scenario(start_utc='2026-05-06T07:08:09Z')).start_ns
    of_ts = np.array([m.log_time_ns for m in BagReader(bag).messages(['ts/heading'])])
    assert (of_ts - start_ns) / 1e9 == pytest.approx(simulated.ts_readings.t_s + 0.4, abs=1e-6)
    assert (np.diff(headings(bag, 'ts/heading').stamp_ns) < 0).any()


def test_diagnostics_tell_mode_progress_and_tests_of_the_ahrs(bag):
    said = [decode(m.type_name, m.data) for m in BagReader(bag).messages(['/diagnostics'])]
    assert len(said) == 130
    assert {status['name'] for m in said for status in m['status']} == {'sensor_simulator: ts'}
    rows = [{pair['key']: pair['value'] for pair in m['status'][0]['values']} for m in said]
    modes = [row['mode'] for row in rows]
    assert modes == ['GYROCOMPASS'] * 65 + ['GYRO_AZIMUTH'] * 65
    assert rows[65]['event'] == 'mode GYRO_AZIMUTH'
    assert [float(row['mode_time_s']) for row in rows[64:68]] == [64.0, 0.0, 1.0, 2.0]
    assert all(row['test_gyro'] == 'passed' and row['mode_progress'] == '1.0' for row in rows)
    assert said[7]['header']['stamp']['sec'] - said[0]['header']['stamp']['sec'] == 7
    assert {m['status'][0]['level'] for m in said} == {0}


def test_bag_says_how_to_make_it_again(bag, scenario):
    reader = BagReader(bag)
    found = reader.metadata()
    assert found['heading_intercompare']['version'] == VERSION
    assert found['heading_intercompare']['settings.ts_topic'] == 'ts/heading'
    assert found['scenario']['seed'] == '4' and found['scenario']['ts.rate_hz'] == '5.0'
    attached, = reader.attachments()
    assert attached.name == 'trial.yaml' and attached.data == scenario.read_bytes()
    assert reader.incomplete is None


def test_seed_decides_every_byte(scenario, bag, tmp_path):
    for folder, seed in (('same', '4'), ('other', '5')):
        (tmp_path / folder).mkdir()
        assert main(['simulate', '--scenario', str(scenario), '--seed', seed,
                     '-o', str(tmp_path / folder / 'trial')]) == 0
    for file in ('trial_0.mcap', 'metadata.yaml'):
        assert (tmp_path / 'same' / 'trial' / file).read_bytes() == (bag / file).read_bytes()
    other = tmp_path / 'other' / 'trial'
    assert headings(other, 'truth/heading') != headings(bag, 'truth/heading')
    assert BagReader(other).metadata()['scenario']['seed'] == '5'


def test_further_sensors_have_topics_of_their_own(tmp_path, capsys):
    path, bag = tmp_path / 'ship.yaml', tmp_path / 'bag'
    path.write_text(TRIAL + 'others: gyro2 rate_hz=2 model=imo ahrs.initial_state=aligned\n')
    assert main(['simulate', '--scenario', str(path), '-o', str(bag)]) == 0
    assert 'gyro2 260 headings on gyro2/heading, 0 of them marked invalid' in (
        capsys.readouterr().out)
    reader = BagReader(bag)
    headings = Headings.concatenate(
        chunk['gyro2/heading'] for chunk in reader.headings({'gyro2/heading': 'enu'}))
    simulated = list(Simulation(read_scenario(str(path)).scenario).chunks())
    expected = Headings.concatenate(chunk.others['gyro2'][0].headings for chunk in simulated)
    assert np.array_equal(headings.stamp_ns, expected.stamp_ns)
    assert headings.heading_deg == pytest.approx(expected.heading_deg)
    assert any(b'sensor_simulator: gyro2' in message.data
               for message in reader.messages(['/diagnostics']))


def test_topics_are_those_of_the_settings(scenario, tmp_path, capsys):
    path = tmp_path / 'trial'
    assert main(['simulate', '--scenario', str(scenario), '-o', str(path), '--set',
                 'ts_topic=gyro', '--set', 'rs_topic=/gnss/heading']) == 0
    assert set(BagReader(path).topics) == {
        '/gyro', '/gnss/heading', '/truth/heading', '/diagnostics', '/ship/fix',
        '/ship/velocity', '/ship/rate_of_turn'}
    out, err = capsys.readouterr()
    assert f'bag: {path}' in out and 'seed 4: A trial of the test' in out
    assert err == ''


def test_a_simulated_bag_tells_the_motion_of_its_ship_unless_it_is_switched_off(tmp_path, capsys):
    norms = ['--set', 'norms.sigma_max_deg=0.3', '--set', 'norms.sigma_ref_max_deg=0.1']
    kinds = {}
    for rate_hz in (0, 1):
        scenario, bag = tmp_path / f'{rate_hz}.yaml', str(tmp_path / f'bag{rate_hz}')
        scenario.write_text(f"legs: '0 30 12'\nduration_s: 200\nmotion_hz: {rate_hz}\n"
                            'ts: {white_deg: 0.1}\n')
        assert main(['simulate', '--scenario', str(scenario), '-o', bag]) == 0
        said = capsys.readouterr().out
        assert ('200 messages of the motion of the ship on ship/velocity' in said) is (rate_hz > 0)
        assert main(['analyze', bag, *norms, '--json', '-']) == 0
        kinds[rate_hz] = json.loads(capsys.readouterr().out)['runs'][0].get('motion')
    assert kinds[0] is None or kinds[0]['n_velocities'] == 0
    assert kinds[1]['kind'] == 'agrees' and kinds[1]['n_velocities'] == 200


def test_scenarios_of_the_package_go_by_their_name():
    assert read_scenario('demo').scenario.title.startswith('Short trial')
    assert read_scenario('demo', seed=99).scenario.seed == 99


@pytest.mark.parametrize('content, options, words', [
    ('seed: 1', ['--seed', '-1'], 'seed = -1: must be'),
    ('duration_s: -5', [], 'trial.yaml: duration_s = -5.0: must be'),
    ('durations: 5', [], "trial.yaml: unknown setting 'durations'; did you mean 'duration_s'"),
    ('a: [', [], 'trial.yaml, line 1: not YAML'),
    ('- 5', [], 'trial.yaml: is not a scenario'),
    ("start_utc: '2039-01-01'\nduration_s: 5", [], 'January 2038'),
    ('seed: 1', ['--set', 'rs_topic=/ts/heading'], 'must differ'),
    ('seed: 1', ['--set', 'ts_topic=truth/heading'], 'must differ')])
def test_mistakes_give_one_line(tmp_path, capsys, content, options, words):
    path = tmp_path / 'trial.yaml'
    path.write_text(content, encoding='utf-8')
    err = refusal(capsys, 'simulate', '--scenario', path, '-o', tmp_path / 'bag', *options)
    assert words in err


def test_a_folder_of_the_name_of_a_scenario_does_not_hide_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'demo').mkdir()
    assert read_scenario('demo').scenario.duration_s == 1200.0


def test_absent_scenario_and_present_bag_are_named(scenario, bag, tmp_path, capsys):
    for given, output, words in (
            ('no_such', tmp_path / 'a', 'neither a file nor one of the scenarios after_service, '),
            ('no_such.yaml', tmp_path / 'a', 'no_such.yaml: No such file'),
            (scenario, bag, 'already exists')):
        assert main(['simulate', '--scenario', str(given), '-o', str(output)]) == 2
        err = capsys.readouterr().err
        assert words in err and err.count('\n') == 1
        assert not (tmp_path / 'a').exists()


@pytest.mark.slow
@pytest.mark.parametrize('name, outcome, code', [
    ('ts_below_norm', 'compliant', 0), ('ts_at_norm', 'indeterminate', 3),
    ('ts_above_norm', 'non_compliant', 1), ('degraded_rs', 'indeterminate', 3)])
def test_scenario_is_judged_as_its_file_promises(name, outcome, code, tmp_path):
    """
    Under norms of 0.3 and 0.1 degrees; the truth in the bag tells who is to blame.

    About 3900 of the 72000 readings are independent as far as variances go: these have a standard
    error of 2.3 %, standard deviations one of 1.2 %. The means, of noise that lasts 10 s, have
    0.005 degrees, 0.013 with the poor RS.
    """
    path = tmp_path / name
    assert main(['simulate', '--scenario', name, '-o', str(path)]) == 0
    assert main(['analyze', str(path), *NORMS, '--check', '--json', str(tmp_path / 'f')]) == code
    verdict = json.loads((tmp_path / 'f').read_text(encoding='utf-8'))
    assert verdict['outcome'] == outcome
    run, = verdict['runs']
    truth, ts = headings(path, 'truth/heading'), headings(path, 'ts/heading')
    assert np.array_equal(ts.stamp_ns, truth.stamp_ns)
    error_deg = wrap180(ts.heading_deg - truth.heading_deg)
    own_deg = {'ts_at_norm': 0.3, 'ts_above_norm': 0.45}.get(name, 0.15)
    assert error_deg.std() == pytest.approx(own_deg, rel=0.07)
    assert error_deg.mean() == pytest.approx(0.15, abs=0.06)
    assert run['mean_deg'] == pytest.approx(error_deg.mean(), abs=0.08)
    # Interpolation removes a part of the white noise of the RS.
    white_deg, markov_deg = (0.32, 0.24) if name == 'degraded_rs' else (0.04, 0.03)
    factor = run['pairing']['rs_variance_factor']
    rs_deg2 = factor * white_deg**2 + markov_deg**2
    assert run['variance_deg2'] == pytest.approx(error_deg.var() + rs_deg2, rel=0.14)
