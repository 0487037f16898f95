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

"""The graph of several sensors: live, replayed and offline verdicts are the same."""

from __future__ import annotations

from functools import partial
import time

from diagnostic_msgs.msg import DiagnosticArray
from nodes.killed import kill
from nodes.rclpy_objects import heading_messages
import pytest
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile
from sensor_msgs.msg import Imu
from std_srvs.srv import Trigger

from heading_intercompare import judge_bags
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.records import Headings
from heading_intercompare.core.sensors.comparison import SensorsComparison
from heading_intercompare.core.sensors.pair_settings import settings_of_tested
from heading_intercompare.core.sensors.sensors_verdict import find_sensor_differences
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.compare_verdicts import find_differences
from heading_intercompare.messages.status_messages import decode_statuses
from heading_intercompare.nodes.compliance import Compliance
from heading_intercompare.nodes.graph import intercompare, Source
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.interface.parameters import make_overrides
from heading_intercompare.nodes.replayer import Replayer
from heading_intercompare.nodes.sensor_simulator import SensorSimulator
from heading_intercompare.nodes.synchronizer import Synchronizer
from heading_intercompare.report.json import render

ROWS = """
    gyro1  topic=ts/heading  sigma_max_deg=0.3
    gyro2  sigma_max_deg=0.3
    ins    sigma_max_deg=0.2
    gnss   topic=rs/heading  sigma_max_deg=0.2  """

# Two pairs a second are judged of those without the reference, and 128 differences are needed.
COMMON = {'pairing.method': 'interpolate', 'risk.min_duration_s': 60.0}
SETTINGS = {'sensors': ROWS + 'rs', **COMMON}
FREE = {'sensors': ROWS, **COMMON}

TRIAL = {'duration_s': 150.0, 'seed': 5, 'legs': '0 350 12; 40 20 12', 'stamps': 'scenario',
         'speed': 0.0, 'ts.rate_hz': 5.0, 'ts.white_deg': 0.05, 'rs.rate_hz': 4.0,
         'rs.phase_s': 0.03, 'rs.white_deg': 0.05, 'others':
         'gyro2 rate_hz=5 phase_s=0.05 white_deg=2; ins rate_hz=10 white_deg=0.05'}


#: 2026-01-01, when the scenario begins.
START_NS = 1_767_225_600_000_000_000


def simulate(settings, **more):
    """Return the verdict of a graph on the simulated trial."""
    return intercompare([Source(SensorSimulator, 'sensor_simulator', TRIAL)], settings,
                        private=True, **more)


def offline(bag, settings):
    """Return the verdict on a bag."""
    return judge_bags([bag], Settings.from_mapping(settings)).verdict


@pytest.fixture(scope='module')
def trial(tmp_path_factory):
    """Return the live verdict of a trial with a reference, its folder, and what was told."""
    folder, told = tmp_path_factory.mktemp('several'), []
    live = simulate(SETTINGS, output=str(folder / 'bag'), report_dir=str(folder / 'reports'),
                    tell=told.append)
    return live, folder, told


def test_the_live_verdict_on_several_sensors_is_that_of_the_recording(trial):
    live, folder, _ = trial
    assert live.vote.wrong == ('gyro2',)
    assert live.verdicts['gyro2'].outcome is Outcome.NON_COMPLIANT
    assert sorted(live.verdicts) == ['gyro1', 'gyro2', 'ins'] and len(live.pairs) == 6
    assert [*find_sensor_differences(live, offline(str(folder / 'bag'), SETTINGS))] == []


def test_each_tested_sensor_has_the_verdict_of_a_graph_of_two(trial):
    """The same path, once per pair: gyro1 and the reference alone give the same figures."""
    live, _, _ = trial
    own = settings_of_tested(Settings.from_mapping(SETTINGS), 'gyro1').to_mapping()
    alone = intercompare(
        [Source(SensorSimulator, 'sensor_simulator', TRIAL)],
        {name: value for name, value in own.items() if value is not None}, private=True)
    assert [*find_differences(live.verdicts['gyro1'], alone)] == []


def test_the_bag_holds_all_sensors_and_what_was_said_of_them(trial):
    live, folder, _ = trial
    reader = BagReader(str(folder / 'bag'))
    counts = {name: info.count for name, info in reader.topics.items()}
    run = live.verdicts['ins'].runs[0].pairing
    assert counts['/ins/heading'] == run.ts_received == 1500
    assert counts['/rs/heading'] == run.rs_received == 600
    assert counts['/gyro2/heading'] == counts['/ts/heading'] == 750
    for name in ('gyro1', 'gyro2', 'ins'):
        assert counts[f'/{name}/pairs'] == live.verdicts[name].runs[0].pairing.paired > 500
        assert counts[f'/{name}/compliance/report'] == 1
    attached = {a.name: a.data for a in reader.attachments()}
    assert attached['report.json'].decode() == render(live)
    said = [decode_statuses(message.data)[1]
            for message in reader.messages(['/sensors/verdict'])][-1]
    assert [one.name for one in said] == ['verdict', 'gyro1', 'gyro2', 'ins', 'gnss', 'vote']
    assert said[-1].values['wrong'] == 'gyro2'


def test_reports_are_in_a_folder_per_sensor_with_the_verdict_on_all_beside(trial):
    live, folder, _ = trial
    reports = folder / 'reports'
    assert {path.name for path in reports.iterdir() if path.is_dir()} == {'gyro1', 'gyro2', 'ins'}
    for name in ('gyro1', 'gyro2', 'ins'):
        assert [path.name[:8] for path in (reports / name).iterdir()] == ['verdict_']
    written = sorted(path.suffix for path in reports.glob('sensors_*'))
    assert written == ['.json', '.txt']
    text, = reports.glob('sensors_*.txt')
    assert text.read_text() == f'{live}\n'


def test_without_a_reference_all_pairs_are_compared_and_the_wrong_one_is_named(tmp_path):
    bag = str(tmp_path / 'bag')
    live = simulate(FREE, output=bag)
    assert live.vote.wrong == ('gyro2',) and not live.verdicts and len(live.pairs) == 6
    assert [*find_sensor_differences(live, offline(bag, FREE))] == []
    assert not [name for name in BagReader(bag).topics if name.endswith('/pairs')]


@pytest.mark.parametrize('settings', [SETTINGS, FREE], ids=['reference', 'free'])
def test_a_replay_of_several_sensors_gives_the_live_verdict(trial, settings):
    _, folder, _ = trial
    replayed = intercompare(
        [Source(Replayer, 'replayer', {'bag': str(folder / 'bag'), 'rate': 0.0})], settings,
        private=True)
    assert [*find_sensor_differences(replayed, offline(str(folder / 'bag'), settings))] == []


def test_the_alarm_names_the_wrong_sensor_while_it_happens():
    """At twenty times the pace the window is looked at every 20 s."""
    told = []
    intercompare([Source(SensorSimulator, 'sensor_simulator', {**TRIAL, 'speed': 20.0})], SETTINGS,
                 private=True, tell=told.append)
    raised = [line for line in told if 'alarm raised: gyro2_wrong' in line]
    assert len(raised) == 1
    assert raised[0].startswith('compliance: alarm raised: gyro2_wrong: gyro2 differs from gyro1, '
                                'ins and gnss')


def several(ros, make, settings=SETTINGS, **values):
    """Make a node of the graph of several sensors."""
    return ros.add(make, parameter_overrides=make_overrides({**settings, **values}))


def join(ros, settings=SETTINGS, **values):
    """Make the two nodes of the process that pairs and judges; return the synchronizer."""
    judge = several(ros, partial(Compliance, True), {**settings, **values})
    return several(ros, partial(Synchronizer, judge), settings, subscribers=0)


def end(ros, synchronizer):
    """End both nodes, as their process would; return the verdict."""
    ros.end(synchronizer, synchronizer.judge)
    return synchronizer.judge.verdict


def test_how_long_a_sensor_may_be_silent_changes_while_the_node_runs(ros):
    synchronizer, sender = join(ros), ros.add(Node, 'sender')
    publisher = sender.create_publisher(Imu, 'rs/heading', qos.HEADINGS_OUT)
    ros.spin_until(lambda: publisher.get_subscription_count() == 1)
    publisher.publish(heading_messages(Headings.of([START_NS], [90.0]), 'rs')[0])

    def heading():
        return synchronizer.judge._now.view()['gnss'].heading_deg
    ros.spin_until(lambda: heading() is not None)
    ros.spin_until(lambda: heading() is None)
    assert synchronizer.judge.set_parameters(
        [Parameter('stale_s', value=3600.0)])[0].successful
    assert heading() == pytest.approx(90.0)


def test_a_compliance_node_apart_that_starts_again_goes_on_and_the_others_do_not_notice(
        ros, tmp_path, trial):
    """That of gyro1 is destroyed as by a crash; its journal and the synchronizer keep all."""
    live, _, _ = trial

    def judge(name):
        return ros.add(
            Compliance, cli_args=['--ros-args', '-r', f'__node:={name}_compliance'],
            parameter_overrides=make_overrides({**SETTINGS, 'sensor': name,
                                                'report_dir': str(tmp_path)}))
    judges = {name: judge(name) for name in ('gyro1', 'gyro2', 'ins')}
    synchronizer = several(ros, Synchronizer, subscribers=1)
    simulator = several(ros, SensorSimulator, **{**TRIAL, 'subscribers': 1, 'speed': 15.0})
    ros.spin_until(lambda: judges['gyro1'].n_pairs > 200)
    kill(ros, judges['gyro1'], judges['gyro1'].journal)
    judges['gyro1'] = judge('gyro1')
    ros.spin_until(lambda: simulator.done)
    ros.end(simulator, synchronizer, *judges.values())
    for name, node in judges.items():
        differences = [text for text in find_differences(node.verdict, live.verdicts[name])
                       if 'ledger_problems' not in text]
        assert differences == [], name


class Trial:
    """A graph of several sensors whose nodes that pair and judge are killed now and then."""

    def __init__(self, ros, settings, folder):
        self.ros, self.settings, self.folder = ros, settings, folder
        self.start()
        self.simulator = several(ros, SensorSimulator, settings, **{
            **TRIAL, 'subscribers': 1, 'speed': 15.0})

    def start(self):
        """Start the nodes, as their respawn would."""
        self.synchronizer = join(self.ros, self.settings, report_dir=str(self.folder))

    @property
    def pairs(self):
        """All pairs of sensors."""
        return self.synchronizer.judge.comparison.pairs

    def wait(self, seconds):
        """Wait until so many seconds of the trial are judged of every pair."""
        self.ros.spin_until(lambda: all(
            (pair.compliance.newest_ns or 0) > START_NS + round(seconds * 1e9)
            for pair in self.pairs.values()))

    def kill(self):
        """Kill them; the readings go on for a second, 15 s of the trial."""
        judge = self.synchronizer.judge
        kill(self.ros, self.synchronizer)
        kill(self.ros, judge, judge.journal)
        began_s = time.monotonic()
        self.ros.spin_until(lambda: time.monotonic() > began_s + 1.0)
        self.start()

    def count(self):
        """Return what became of all readings, by pair."""
        return {names: pair.ledger.total for names, pair in self.pairs.items()}

    def end(self):
        """Let the trial end; return the verdict."""
        self.ros.spin_until(lambda: self.simulator.done)
        self.ros.end(self.simulator)
        return end(self.ros, self.synchronizer)


@pytest.mark.parametrize('settings', [SETTINGS, FREE], ids=['reference', 'free'])
def test_a_comparison_that_is_killed_goes_on_and_misses_nothing(ros, tmp_path, trial, settings):
    """Before, the pairs without the reference began again at each start."""
    _, folder, _ = trial
    trial = Trial(ros, settings, tmp_path)
    for seconds in (40.0, 80.0):
        trial.wait(seconds)
        trial.kill()
    verdict = trial.end()
    whole = offline(str(folder / 'bag'), settings)
    assert [*find_sensor_differences(verdict, whole)] == []
    assert verdict.vote.wrong == ('gyro2',)
    assert not [path for path in tmp_path.rglob('*') if 'journal' in path.name]
    rates_hz = {'gyro1': 5, 'gyro2': 5, 'ins': 10, 'gnss': 4}
    for pair, ledger in trial.count().items():
        assert [ledger.received(stream) for stream in ('ts', 'rs')] == [
            150 * rates_hz[name] for name in pair]


def test_what_nobody_sends_again_is_counted(ros, tmp_path):
    """Readings of publishers that keep none, while the nodes are down; no sensor is the RS."""
    rows = 'a sigma_max_deg=0.3; b sigma_max_deg=0.3'
    settings = {'sensors': rows, **COMMON}
    publishers = {name: ros.plain.create_publisher(Imu, f'{name}/heading', QoSProfile(depth=100))
                  for name in 'ab'}

    def start():
        synchronizer = join(ros, settings, report_dir=str(tmp_path))
        ros.spin_until(lambda: synchronizer._headings.count_publishers() and all(
            publisher.get_subscription_count() == 1 for publisher in publishers.values()))
        return synchronizer

    def publish(first_s, last_s):
        stamps = [(1_700_000_000 + at) * 10 ** 9 for at in range(first_s, last_s)]
        for message in heading_messages(Headings.of(stamps, [90.0] * len(stamps)), 'x'):
            for publisher in publishers.values():
                publisher.publish(message)

    def newest_s(synchronizer):
        return (synchronizer.judge.comparison.newest_ns or 0) // 10 ** 9
    synchronizer = start()
    publish(0, 60)
    ros.spin_until(lambda: newest_s(synchronizer) == 1_700_000_059)
    for node in (synchronizer, synchronizer.judge):
        kill(ros, node, *([node.journal] if node is synchronizer.judge else []))
    ros.spin_until(lambda: not any(p.get_subscription_count() for p in publishers.values()))
    publish(60, 90)
    synchronizer = start()
    publish(90, 150)
    ros.spin_until(lambda: newest_s(synchronizer) == 1_700_000_149)
    verdict = end(ros, synchronizer)
    pair, = verdict.pairs
    assert pair.runs == 1 and pair.n == 120
    run, = synchronizer.judge.comparison.others['a', 'b'].results()
    assert (run.verdict.pairing.lost.ts, run.verdict.pairing.lost.rs) == ({'on_the_way': 30},) * 2


def sensors_of(ros, names):
    """Return publishers of the headings of sensors, by topic."""
    return {name: ros.plain.create_publisher(Imu, name, qos.HEADINGS_OUT) for name in names}


def test_a_mark_acts_on_the_runs_of_all_pairs_after_the_newest_pair(ros):
    """Two pairs a second are judged of sensors without a reference; the newest is no such pair."""
    rows = 'a sigma_max_deg=0.3; b sigma_max_deg=0.3; c sigma_max_deg=0.3'
    synchronizer = join(ros, {'sensors': rows, **COMMON})
    marks = ros.listen(DiagnosticArray, 'compliance/marker', qos.MARKER)
    publishers = sensors_of(ros, ['a/heading', 'b/heading', 'c/heading'])
    caller = ros.plain.create_client(Trigger, 'compliance/start_run')
    ros.spin_until(lambda: all(p.get_subscription_count() for p in publishers.values())
                   and caller.service_is_ready())

    def publish(first, last):
        stamps = [1_700_000_000_000_000_000 + at * 10 ** 8 for at in range(first, last)]
        for message in heading_messages(Headings.of(stamps, [90.0] * len(stamps)), 'x'):
            for publisher in publishers.values():
                publisher.publish(message)
        ros.spin_until(lambda: synchronizer.judge.newest_ns == stamps[-1])
    publish(0, 104)
    answer = caller.call_async(Trigger.Request())
    ros.spin_until(answer.done)
    ros.spin_until(lambda: marks)
    assert answer.result().success
    stamp = marks[0].header.stamp
    assert (stamp.sec, stamp.nanosec) == (1_700_000_010, 300_000_000)
    publish(104, 400)
    verdict = end(ros, synchronizer)
    assert [pair.runs for pair in verdict.pairs] == [1, 1, 1]
    stamps = [1_700_000_000_000_000_000 + at * 10 ** 8 for at in range(400)]
    whole = SensorsComparison(Settings.from_mapping({'sensors': rows, **COMMON}))
    whole.mark('start', 1_700_000_010_300_000_000)
    whole.update(dict.fromkeys('abc', Headings.of(stamps, [90.0] * len(stamps))))
    whole.finish()
    for names, pair in synchronizer.judge.comparison.others.items():
        (run,), (expected,) = pair.results(), whole.others[names].results()
        assert run.verdict.start_ns > 1_700_000_010_300_000_000
        assert (run.verdict.n, run.verdict.pairing) == (expected.verdict.n,
                                                        expected.verdict.pairing)


def test_a_sensor_that_is_not_tested_has_no_node(ros):
    with pytest.raises(SettingsError, match="sensor = 'gnss': must be one of gyro1, gyro2, ins"):
        several(ros, Compliance, sensor='gnss')
    with pytest.raises(SettingsError, match='sensor is required with the setting sensors'):
        several(ros, Compliance)
    with pytest.raises(SettingsError, match="sensor = 'gyro1': this process judges all sensors"):
        several(ros, partial(Compliance, True), sensor='gyro1')
