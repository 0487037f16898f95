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

"""The graph in one process: live, replayed and offline verdicts are the same."""

from __future__ import annotations

import json
import os
import signal
import threading
import time

from deadlines import DEADLINE_S
from nodes.graph_checks import assert_same, log, offline
from nodes.rclpy_objects import heading_messages, headings_from
from nodes.ros_nodes import EITHER_EXECUTOR, NORMS, Ros
import pytest
from ros_domain import take_domain
from sensor_msgs.msg import Imu

from heading_intercompare.ahrs.settings import Scenario
from heading_intercompare.ahrs.simulator import Simulation
from heading_intercompare.app.analysis import judge_bags
from heading_intercompare.app.config import Config
from heading_intercompare.app.recorded_looks import find_looks
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.cli import main
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.records import Headings
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.all_runs import join
from heading_intercompare.logbook.logbook_file import Logbook
from heading_intercompare.logbook.run_row import make_rows
from heading_intercompare.messages.status_messages import decode_statuses
from heading_intercompare.nodes import graph
from heading_intercompare.nodes.compliance import Compliance
from heading_intercompare.nodes.graph import intercompare, Source
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.nmea_driver import NmeaDriver
from heading_intercompare.nodes.recorder import Recorder
from heading_intercompare.nodes.replayer import Replayer
from heading_intercompare.nodes.sensor_simulator import SensorSimulator

TRIAL = {'duration_s': 120.0, 'seed': 5, 'ts.white_deg': 0.1, 'ts.rate_hz': 10.0,
         'rs.rate_hz': 4.0, 'rs.phase_s': 0.03, 'rs.white_deg': 0.02, 'rs.dropout': 0.1,
         'legs': '0 350 12; 40 20 12', 'stamps': 'scenario', 'speed': 0.0}


@pytest.fixture(scope='module')
def trial(tmp_path_factory):
    """Return the live verdict on a simulated trial, and its bag."""
    bag = str(tmp_path_factory.mktemp('trial') / 'bag')
    live = intercompare([Source(SensorSimulator, 'sensor_simulator', TRIAL)], NORMS, output=bag,
                        private=True).to_dict()
    return live, bag


def test_the_live_verdict_is_that_of_the_recording(trial):
    live, bag = trial
    # A tenth of the readings of the RS is missing, and no pair bridges that.
    assert live['runs'][0]['n'] > 900
    assert_same(live, offline(bag))


def test_looks_at_a_live_run_are_those_of_its_recording_and_of_its_replay(tmp_path):
    bag = str(tmp_path / 'bag')
    rule = {**NORMS, 'risk.min_duration_s': 20.0}
    live = intercompare([Source(SensorSimulator, 'sensor_simulator', TRIAL)], {
        **rule, 'sequential.plan_s': 'open'}, output=bag, private=True).to_dict()
    assert [look['look'] for look in live['runs'][0]['looks']] == [1, 2, 3]
    looks = find_looks(Config(), (), [bag])
    assert_same(live, offline(bag, **rule, **looks))
    replayed = intercompare([Source(Replayer, 'replayer', {'bag': bag, 'rate': 0.0})],
                            {**rule, **looks}, private=True).to_dict()
    assert_same(replayed, live)


@pytest.mark.parametrize('stated, plan_s', [((), 'open'), (('sequential.plan_s=none',), None),
                                            (('sequential.plan_s=900',), 900.0)])
def test_the_command_live_looks_at_its_runs_unless_the_user_states_otherwise(
        tmp_path, monkeypatch, stated, plan_s):
    given = {}

    def take(sources, settings, **_):
        given.update(settings)
        return join([], Settings.from_mapping(settings))
    monkeypatch.setattr(graph, 'intercompare', take)
    monkeypatch.chdir(tmp_path)
    main(['live', '--quiet', *(word for assignment in (
        *(f'{name}={value}' for name, value in NORMS.items()), *stated)
        for word in ('--set', assignment))])
    assert given.get('sequential.plan_s') == plan_s
    assert {name: given[name] for name in NORMS} == NORMS


def test_with_a_slow_rs_the_live_verdict_is_that_of_the_recording(tmp_path):
    """Stamps run at 40 times their pace: readings also wait for the choice by the clock."""
    bag = str(tmp_path / 'bag')
    live = intercompare([Source(SensorSimulator, 'sensor_simulator',
                                {**TRIAL, 'rs.rate_hz': 1.0, 'speed': 40.0})],
                        NORMS, output=bag, private=True).to_dict()
    pairing = live['runs'][0]['pairing']
    assert pairing['paired'] > 90 and pairing['rs_variance_factor'] == 1.0
    assert pairing['ts_received'] == (pairing['ts_paired'] + pairing['ts_used']
                                      + pairing['ts_unpaired'])
    assert 0.5 <= pairing['ts_variance_factor'] < 1.0
    assert_same(live, offline(bag))


@EITHER_EXECUTOR
def test_while_a_run_is_judged_readings_are_recorded(tmp_path, monkeypatch):
    """The judge waits for the recorder; in a single thread it would wait for ever."""
    judging, recorded = threading.Event(), threading.Event()
    beat, drain = Compliance._beat, Recorder._drain

    def judge(self):
        judging.set()
        assert recorded.wait(DEADLINE_S)
        beat(self)

    def record(self):
        drain(self)
        if judging.is_set():
            recorded.set()
    monkeypatch.setattr(Compliance, '_beat', judge)
    monkeypatch.setattr(Recorder, '_drain', record)
    intercompare([Source(SensorSimulator, 'sensor_simulator', {**TRIAL, 'speed': 40.0})], NORMS,
                 output=str(tmp_path / 'bag'), private=True)
    assert recorded.is_set()


@EITHER_EXECUTOR
def test_an_error_of_the_judge_ends_the_graph(monkeypatch):
    def fail(self):
        raise OSError(28, 'No space left on device')
    monkeypatch.setattr(Compliance, '_beat', fail)
    with pytest.raises(OSError, match='No space left'):
        intercompare([Source(SensorSimulator, 'sensor_simulator', {**TRIAL, 'speed': 1.0})], NORMS,
                     private=True)


@pytest.mark.parametrize('rate', [0.0, 4.0])
def test_a_replay_at_any_rate_gives_the_live_verdict(trial, rate):
    live, bag = trial
    replayed = intercompare([Source(Replayer, 'replayer', {'bag': bag, 'rate': rate})], NORMS,
                            private=True).to_dict()
    assert_same(replayed, live)


@pytest.fixture
def domain(monkeypatch):
    """Let contexts of this process find each other, and nobody else, in a ROS domain."""
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    monkeypatch.setenv('ROS_DOMAIN_ID', str(take_domain()))


@EITHER_EXECUTOR
def test_without_sources_the_graph_listens_to_the_topics_of_others(domain, tmp_path):
    """Another program publishes 200 headings of each sensor; then the user presses Ctrl-C."""
    other = Ros()
    sensors = [other.plain.create_publisher(Imu, f'{role}/heading', qos.HEADINGS_OUT)
               for role in ('ts', 'rs')]
    stamps = [(1_700_000_000 + i) * 10 ** 9 for i in range(200)]
    messages = heading_messages(Headings.of(stamps, [90.0] * 200), 'gyro')
    published = []
    deadline_s = time.monotonic() + DEADLINE_S

    def watch(n_pairs):
        if not published and all(s.get_subscription_count() == 2 for s in sensors):
            for message in messages:
                for sensor in sensors:
                    sensor.publish(message)
            published.append(True)
        if n_pairs == 200 or time.monotonic() > deadline_s:
            os.kill(os.getpid(), signal.SIGINT)
    bag = str(tmp_path / 'bag')
    settings = {**NORMS, 'pairing.method': 'nearest'}
    try:
        live = intercompare([], settings, output=bag, progress=watch).to_dict()
    finally:
        other.close()
    assert live['runs'][0]['pairing']['paired'] == 200
    assert_same(live, offline(bag, **{'pairing.method': 'nearest'}))


def test_alarms_are_told_and_recorded_and_do_not_change_the_verdict(tmp_path):
    """A quarter turn for 30 s of 120, at ten times the pace."""
    bag, told = str(tmp_path / 'bag'), []
    live = intercompare([Source(SensorSimulator, 'sensor_simulator', {
        **TRIAL, 'ts.faults': '40 rotated 90 30', 'speed': 10.0})],
        {**NORMS, 'pairing.method': 'interpolate'}, output=bag, private=True, tell=told.append)
    lines = [line for line in told if 'rotated' in line]
    assert lines[0].startswith('compliance: alarm raised: rotated: TS - RS is near 90 deg')
    assert lines[1].startswith('compliance: alarm cleared, not acknowledged: rotated')
    assert_same(live.to_dict(), offline(bag, **{'pairing.method': 'interpolate'}))
    states = [status.values['state'] for message in BagReader(bag).messages(['/compliance/alarms'])
              for status in decode_statuses(message.data)[1]
              if status.name == 'compliance: rotated']
    assert list(dict.fromkeys(states)) == ['normal', 'active_unacknowledged',
                                           'rectified_unacknowledged']


CUTS = {**NORMS, 'runs.every_h': 0.01, 'runs.keep': 2}
"""A cut every 36 s: four or five runs in 120 s, of which a verdict covers three."""


@pytest.mark.parametrize('rate', [0.0, 4.0])
def test_runs_that_the_clock_cuts_are_the_same_live_in_replay_and_offline(tmp_path, rate):
    bag, books = str(tmp_path / 'bag'), [tmp_path / name for name in ('live', 'replay', 'offline')]
    live = intercompare([Source(SensorSimulator, 'sensor_simulator', TRIAL)], CUTS, output=bag,
                        own={'compliance': {'logbook': str(books[0])}}, private=True).to_dict()
    assert 2 <= len(live['runs']) <= 3
    replayed = intercompare([Source(Replayer, 'replayer', {'bag': bag, 'rate': rate})], CUTS,
                            own={'compliance': {'logbook': str(books[1])}}, private=True)
    assert_same(replayed.to_dict(), live)
    settings = Settings.from_mapping(CUTS)
    judged = judge_bags([bag], settings)
    assert_same(json.loads(json.dumps(judged.verdict.to_dict())), live)
    Logbook(books[2]).write(make_rows(judged.verdict, earlier=judged.earlier['ts']))
    rows = [Logbook(book).read() for book in books]
    assert {row.bag for row in rows[0]} == {bag} and len(rows[0]) >= 4
    assert sum(row.n for row in rows[0]) == sum(row.paired for row in rows[0]) > 900
    for found in rows[1:]:
        assert [(row.key, row.n, row.outcome, row.paired, row.ts_received, row.rs_unused)
                for row in found] == [
            (row.key, row.n, row.outcome, row.paired, row.ts_received, row.rs_unused)
            for row in rows[0]]


def test_the_bag_holds_all_that_was_published_and_the_report(trial):
    live, bag = trial
    reader = BagReader(bag)
    run = live['runs'][0]['pairing']
    counts = {name: info.count for name, info in reader.topics.items()}
    assert counts['/ts/heading'] == run['ts_received']
    assert counts['/rs/heading'] == run['rs_received']
    assert counts['/pairs'] == run['paired']
    assert reader.incomplete is None
    attached = {a.name: a.data for a in reader.attachments()}
    assert json.loads(attached['report.json']) == live


def test_the_bag_of_a_simulation_holds_its_settings_and_the_whole_truth(trial):
    reader = BagReader(trial[1])
    said = reader.metadata()['heading_intercompare']
    assert said['source.sensor_simulator.seed'] == '5'
    assert said['source.sensor_simulator.legs'] == '0 350 12; 40 20 12'
    simulation = Simulation(Scenario.from_mapping(
        {name: value for name, value in TRIAL.items() if name not in ('stamps', 'speed')}))
    truth = Headings.concatenate([chunk.truth for chunk in simulation.chunks()])
    found = Headings.concatenate([chunk['truth/heading'] for chunk in reader.headings(
        {'truth/heading': 'enu'})])
    assert len(found) > 1000
    assert found == headings_from(heading_messages(truth, ''), 'enu')


def drivers(tmp_path):
    """Return two drivers, whose logs begin 8 s apart."""
    return [Source(NmeaDriver, 'ts_driver', {'source': log(tmp_path / 'ts.log', 300, 0.0, 90.0),
                                             'speed': 100.0}),
            Source(NmeaDriver, 'rs_driver', {'source': log(tmp_path / 'rs.log', 300, 8.05, 90.1),
                                             'topic': 'rs/heading', 'speed': 100.0})]


def test_two_logs_are_played_in_step_and_every_reading_is_accounted_for(tmp_path):
    """60 s each, 8 s apart, at 100 times the speed: out of step they would not pair."""
    bag = str(tmp_path / 'bag')
    live = intercompare(drivers(tmp_path), {**NORMS, 'pairing.max_wait_s': 0.3}, output=bag,
                        private=True).to_dict()
    run, = live['runs']
    assert (run['pairing']['ts_received'], run['pairing']['rs_received']) == (300, 300)
    assert run['pairing']['paired'] == 259
    assert_same(live, offline(bag, **{'pairing.max_wait_s': 0.3}))


def test_reports_are_written_and_progress_is_told(tmp_path):
    told = []
    intercompare(drivers(tmp_path), {**NORMS, 'pairing.method': 'interpolate'},
                 report_dir=str(tmp_path / 'reports'), private=True, progress=told.append)
    assert told[-1] == 259 and told == sorted(told)
    assert len(list((tmp_path / 'reports').glob('verdict_*.json'))) == 1


def test_a_mistake_in_one_node_leaves_nothing_running(tmp_path):
    before = os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE']
    sources = drivers(tmp_path)
    with pytest.raises(SettingsError, match='unknown parameter'):
        intercompare([*sources, Source(NmeaDriver, 'third', {'sourse': 'x'})], NORMS)
    assert os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] == before
    assert intercompare(sources, NORMS, private=True).runs[0].n == 259
