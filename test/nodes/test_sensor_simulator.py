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

"""The node that simulates both sensors."""

from __future__ import annotations

import time

from deadlines import Stopwatch
from diagnostic_msgs.msg import DiagnosticArray
from nodes.rclpy_objects import heading_messages, headings_from
import pytest
from sensor_msgs.msg import Imu
from std_srvs.srv import SetBool, Trigger

from heading_intercompare.ahrs.faults import FAULTS
from heading_intercompare.ahrs.plans import EVENTS
from heading_intercompare.ahrs.settings import Scenario
from heading_intercompare.ahrs.simulator import Simulation
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.messages.status_messages import ERROR, OK
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.sensor_simulator import SensorSimulator

TRIAL = {'duration_s': 20.0, 'ts.rate_hz': 10.0, 'rs.rate_hz': 4.0, 'ts.white_deg': 0.1,
         'legs': '0 350 10; 10 20 10'}


def run(ros, **values):
    """Return the messages on both topics until the trial is over."""
    node = ros.ours(SensorSimulator, **{k.replace('.', '__'): v for k, v in TRIAL.items()},
                    **values)
    heard = [ros.listen(Imu, f'{role}/heading', qos.PAIRS_TAKEN) for role in ('ts', 'rs')]
    ros.spin_until(lambda: node.done)
    ros.spin_until(lambda: (len(heard[0]), len(heard[1])) == (200, 80))
    return heard


@pytest.mark.parametrize('speed', [0.0, 40.0])
def test_the_published_trial_is_that_of_the_pure_simulation(ros, speed):
    heard = run(ros, speed=speed, stamps='scenario')
    chunk, = Simulation(Scenario.from_mapping(TRIAL)).chunks(20.0)
    assert headings_from(heard[0], 'enu') == headings_from(heading_messages(chunk.ts, ''), 'enu')
    assert headings_from(heard[1], 'enu') == headings_from(heading_messages(chunk.rs, ''), 'enu')
    assert heard[0][0].angular_velocity_covariance[0] == 0.0
    assert heard[0][0].orientation_covariance[8] > 0.0


def test_a_live_trial_begins_now(ros):
    before_ns = time.time_ns()
    heard = run(ros, speed=0.0)
    assert before_ns <= headings_from(heard[0][:1], 'enu').stamp_ns[0] <= time.time_ns()


def test_the_speed_is_kept(ros):
    """The trial lasts 20 s."""
    began_s, watch = time.monotonic(), Stopwatch()
    run(ros, speed=20.0)
    assert time.monotonic() - began_s > 0.95 and watch.passed_s < 10.0


def test_a_trial_is_not_begun_before_both_topics_are_heard(ros):
    node = ros.ours(SensorSimulator, duration_s=5.0, speed=0.0)
    ts = ros.listen(Imu, 'ts/heading', qos.PAIRS_TAKEN)
    ros.spin_until(lambda: ros.executor.spin_once(0.3) is None)
    assert (ts, node.done) == ([], False)
    ros.listen(Imu, 'rs/heading', qos.PAIRS_TAKEN)
    ros.spin_until(lambda: node.done)


def test_of_several_sensors_ts_and_rs_are_those_that_the_scenario_does_not_name(ros):
    """gyro1 and gnss had no publisher: their headings were on ts/heading and rs/heading."""
    ros.ours(SensorSimulator, others='gyro2 rate_hz=10', sensors=(
        'gyro1 sigma_max_deg=0.3; gyro2 sigma_max_deg=0.3; gnss sigma_max_deg=0.1 rs'))
    assert [ros.plain.count_publishers(f'{name}/heading')
            for name in ('gyro1', 'gyro2', 'gnss', 'ts', 'rs')] == [1, 1, 1, 0, 0]


def test_a_wrong_scenario_ends_the_node_before_it_begins(ros):
    with pytest.raises(SettingsError, match="unknown parameter 'ts.white'; did you mean"):
        ros.ours(SensorSimulator, ts__white=0.1)
    with pytest.raises(SettingsError, match='only the command simulate reads a recorded voyage'):
        ros.ours(SensorSimulator, track__file='gyro.log')


def called(ros, kind, name, **request):
    """Return the answer of a service of the node."""
    client = ros.plain.create_client(kind, f'/sensor_simulator/{name}')
    ros.spin_until(client.service_is_ready)
    answer = client.call_async(kind.Request(**request))
    ros.spin_until(answer.done)
    return answer.result()


def values(heard, part):
    """Return the figures of each status of a part on /diagnostics, its words and level."""
    return [{**{pair.key: pair.value for pair in status.values}, 'words': status.message,
             'level': status.level[0]} for message in heard for status in message.status
            if status.name == f'sensor_simulator: {part}']


def begun(ros, **settings):
    """Return a node with a long trial, the messages of its TS, and the diagnostics."""
    node = ros.ours(SensorSimulator, stamps='scenario', duration_s=100000.0, **settings)
    ts, _ = (ros.listen(Imu, f'{role}/heading', qos.PAIRS_TAKEN) for role in ('ts', 'rs'))
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    ros.spin_until(lambda: ts)
    return node, ts, diagnostics


def trial_times_s(messages):
    """Return the stamps of headings as times of the trial."""
    return (headings_from(messages, 'enu').stamp_ns - Simulation(Scenario()).start_ns) / 1e9


def test_injected_fault_begins_and_ends_when_the_service_says(ros):
    """An ideal TS on a steady ship: only the fault turns its heading, by 5 degrees."""
    _, ts, diagnostics = begun(ros, legs='0 70 10', speed=5.0)
    times_s = []
    for on in (True, False):
        answer = called(ros, SetBool, 'inject_jump', data=on)
        assert answer.success
        assert f'TS: jump {"begins" if on else "ends"} at ' in answer.message
        times_s.append(float(answer.message.split()[-5]))
        # What was sent before the answer may come after it.
        ros.spin_until(lambda: trial_times_s(ts).max() > times_s[-1] + 0.5)
        if on:
            ros.spin_until(lambda: any(shown.get('ts_faults') == 'jump'
                                       for shown in values(diagnostics, 'simulation')))
    read = headings_from(ts, 'enu')
    turned = trial_times_s(ts)[abs(read.heading_deg - 75.0) < 1e-9]
    assert len(turned) + (abs(read.heading_deg - 70.0) < 1e-9).sum() == len(ts)
    assert turned.min() == pytest.approx(times_s[0], abs=0.11)
    assert turned.max() == pytest.approx(times_s[1], abs=0.11)


def test_commanded_mode_shows_on_diagnostics_with_progress_and_tests(ros):
    """The command acts with the next 10 s of the trial, a tenth of a second here."""
    settings = {'ts__model': 'dtg_precision', 'ts__ahrs__initial_state': 'aligned'}
    _, _, diagnostics = begun(ros, speed=100.0, **settings)
    ros.spin_until(lambda: values(diagnostics, 'ts'))
    assert values(diagnostics, 'ts')[-1]['mode'] == 'GYROCOMPASS'
    answer = called(ros, Trigger, 'gyro_azimuth')
    assert answer.success and 'TS: gyro_azimuth at ' in answer.message
    ros.spin_until(lambda: values(diagnostics, 'ts')[-1]['mode'] == 'GYRO_AZIMUTH')
    shown = values(diagnostics, 'ts')[-1]
    assert (shown['words'], shown['level']) == ('gyro azimuth, heading valid', OK)
    assert (shown['mode_progress'], shown['test_gyro']) == ('1.0', 'passed')
    assert float(shown['mode_time_s']) >= 0.0
    assert called(ros, Trigger, 'fail_gyro').success
    ros.spin_until(lambda: values(diagnostics, 'ts')[-1]['level'] == ERROR)
    assert values(diagnostics, 'ts')[-1]['words'] == 'fault: gyro'
    assert values(diagnostics, 'ts')[-1]['test_gyro'] == 'failed'
    assert not values(diagnostics, 'rs')


def test_trial_as_fast_as_possible_leaves_others_of_its_process_their_turn(ros):
    """No limit of the rate stops it: before, one turn took the whole trial of two hours."""
    ros.ours(SensorSimulator, stamps='scenario', duration_s=7200.0, speed=0.0, max_rate_hz=1e5,
             ts__rate_hz=1.0, rs__rate_hz=1.0)
    ts, _ = (ros.listen(Imu, f'{role}/heading', qos.PAIRS_TAKEN) for role in ('ts', 'rs'))
    ros.spin_until(lambda: ts)
    assert called(ros, SetBool, 'inject_jump', data=True).success


def test_service_says_why_it_cannot(ros):
    node, _, _ = begun(ros, speed=20.0)
    for kind, name, request, words in (
            (Trigger, 'gyrocompass', {}, "TS: a sensor of the model 'ideal' has no modes"),
            (SetBool, 'inject_freeze', {'data': False}, 'TS: freeze is not present')):
        answer = called(ros, kind, name, **request)
        assert not answer.success and answer.message.startswith(words)
    ros.end(node)


def test_command_that_changes_nothing_is_refused_with_the_reason(ros):
    """Both sensors are aligned gyrocompasses; each has services of its own."""
    settings = {f'{role}__ahrs__initial_state': 'aligned' for role in ('ts', 'rs')}
    node, _, diagnostics = begun(ros, speed=20.0, ts__model='dtg_precision',
                                 rs__model='marine_0p1', **settings)
    for place, who in (('', 'TS'), ('rs/', 'RS')):
        for kind, why in (('gyrocompass', 'it is the mode already'),
                          ('reset', 'there is no fault; the mode is GYROCOMPASS'),
                          ('force_on', 'only THERMOSTAT_WAIT can be cut short')):
            answer = called(ros, Trigger, place + kind)
            assert not answer.success
            assert answer.message.startswith(f'{who}: {kind} refused: {why}')
    answer = called(ros, Trigger, 'rs/gyro_azimuth')
    assert answer.success and answer.message.startswith('RS: gyro_azimuth at ')
    ros.spin_until(lambda: values(diagnostics, 'rs')[-1:]
                   and values(diagnostics, 'rs')[-1]['mode'] == 'GYRO_AZIMUTH')
    assert values(diagnostics, 'ts')[-1]['mode'] == 'GYROCOMPASS'
    answer = called(ros, SetBool, 'rs/inject_freeze', data=True)
    assert answer.success and answer.message.startswith('RS: freeze begins at ')
    ros.end(node)


def test_service_waits_for_the_trial_to_begin(ros):
    ros.ours(SensorSimulator, duration_s=5.0)
    answer = called(ros, SetBool, 'inject_jump', data=True)
    assert (answer.success, answer.message) == (False, 'the trial has not begun')


def test_every_fault_and_event_has_its_service(ros):
    node = ros.ours(SensorSimulator, duration_s=5.0, others='gyro2 rate_hz=5')
    offered = {name for name, _ in node.get_service_names_and_types_by_node(
        'sensor_simulator', '/')}
    names = {*EVENTS, *(f'inject_{kind}' for kind in FAULTS)}
    assert {f'/sensor_simulator/{place}{name}' for place in ('', 'rs/', 'gyro2/')
            for name in names} <= offered


def test_further_sensors_are_published_on_their_topics_and_nobody_need_hear_them(ros):
    others = 'gyro2 rate_hz=5 white_deg=0.1; ins rate_hz=10'
    heard = ros.listen(Imu, 'gyro2/heading', qos.PAIRS_TAKEN)
    run(ros, speed=0.0, stamps='scenario', others=others)
    ros.spin_until(lambda: len(heard) == 100)
    chunk, = Simulation(Scenario.from_mapping({**TRIAL, 'others': others})).chunks(20.0)
    readings, _ = chunk.others['gyro2']
    assert headings_from(heard, 'enu') == headings_from(
        heading_messages(readings.headings, ''), 'enu')
    assert heard[0].header.frame_id == 'gyro2_heading'
