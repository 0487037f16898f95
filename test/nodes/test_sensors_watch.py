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
import json
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
from heading_intercompare.core.pairing.ledger import LedgerKey
from heading_intercompare.core.records import Headings
from heading_intercompare.core.sensor_table import read_sensors
from heading_intercompare.core.sensors.pair_settings import settings_of_tested
from heading_intercompare.core.sensors.sensors_verdict import (
    find_sensor_differences,
    SensorsVerdict,
)
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.compare_verdicts import find_differences
from heading_intercompare.messages.status_messages import decode_statuses
from heading_intercompare.nodes.compliance import Compliance
from heading_intercompare.nodes.graph import intercompare, Source
from heading_intercompare.nodes.replayer import Replayer
from heading_intercompare.nodes.ros import qos
from heading_intercompare.nodes.ros.parameters import make_overrides
from heading_intercompare.nodes.sensor_simulator import SensorSimulator
from heading_intercompare.nodes.sensors.places import remap_rules
from heading_intercompare.nodes.sensors_watch import SensorsWatch
from heading_intercompare.nodes.synchronizer import Synchronizer

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
    assert SensorsVerdict.from_dict(json.loads(attached['report.json'])) == live
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
    raised = [line for line in told if line.startswith('sensors_watch: alarm raised')]
    assert len(raised) == 1
    assert raised[0].startswith('sensors_watch: alarm raised: gyro2_wrong: gyro2 differs from '
                                'gyro1, ins and gnss')


def several(ros, make, sensor='', settings=SETTINGS, **values):
    """Make a node of the graph of several sensors; with a sensor, in its namespace."""
    remaps = remap_rules(read_sensors(SETTINGS['sensors']), '/') if sensor else {}
    rules = {'__ns': f'/{sensor}', **remaps}
    named = {'sensor': sensor} if sensor else {}
    return ros.add(make, cli_args=['--ros-args', *(
        word for old, new in rules.items() for word in ('-r', f'{old}:={new}'))],
        parameter_overrides=make_overrides({**settings, **named, **values}))


def test_how_long_a_sensor_may_be_silent_changes_while_the_node_runs(ros):
    watch, sender = several(ros, SensorsWatch), ros.add(Node, 'sender')
    publisher = sender.create_publisher(Imu, 'rs/heading', qos.HEADINGS_OUT)
    ros.spin_until(lambda: publisher.get_subscription_count() == 1)
    publisher.publish(heading_messages(Headings.of([START_NS], [90.0]), 'rs')[0])

    def heading():
        return watch._headings.view()['gnss'].heading_deg
    ros.spin_until(lambda: heading() is not None)
    ros.spin_until(lambda: heading() is None)
    assert watch.set_parameters([Parameter('stale_s', value=3600.0)])[0].successful
    assert heading() == pytest.approx(90.0)


def test_a_compliance_node_that_starts_again_goes_on_and_the_others_do_not_notice(
        ros, tmp_path, trial):
    """That of gyro1 is destroyed as by a crash; its journal and its synchronizer keep all."""
    _, folder, _ = trial
    reports = str(tmp_path)
    watch = several(ros, SensorsWatch, report_dir=reports)
    names = 'gyro1', 'gyro2', 'ins'
    judges = {name: several(ros, Compliance, name, report_dir=reports) for name in names}
    pairing = [several(ros, Synchronizer, name, subscribers=1) for name in names]
    simulator = several(ros, SensorSimulator, **{**TRIAL, 'subscribers': 2, 'speed': 15.0})
    ros.spin_until(lambda: judges['gyro1'].n_pairs > 200)
    # What waits longest for the disk: a quarter of a second.
    killed = judges.pop('gyro1')
    ros.executor.remove_node(killed)
    ros.nodes.remove(killed)
    killed.destroy_node()
    judges['gyro1'] = several(ros, Compliance, 'gyro1', report_dir=reports)
    ros.spin_until(lambda: simulator.done)
    ros.end(simulator, *pairing, *judges.values(), watch)
    found = watch.verdict
    assert found.vote.wrong == ('gyro2',)
    whole = offline(str(folder / 'bag'), SETTINGS)
    differences = [one for one in find_sensor_differences(found, whole)
                   if 'ledger_problems' not in one]
    assert differences == []


class Trial:
    """A graph of several sensors whose node `sensors_watch` is killed now and then."""

    def __init__(self, ros, settings, folder):
        self.ros, self.settings, self.folder = ros, settings, folder
        self.start()
        names = ('gyro1', 'gyro2', 'ins') if settings is SETTINGS else ()
        self.nodes = [several(ros, make, name, **own) for make, own in (
            (Synchronizer, {'subscribers': 1}), (Compliance, {})) for name in names]
        self.simulator = several(ros, SensorSimulator, settings=settings, **{
            **TRIAL, 'subscribers': 2 if names else 1, 'speed': 15.0})

    def start(self):
        """Start the node, as its respawn would."""
        self.watch = several(self.ros, SensorsWatch, settings=self.settings,
                             report_dir=str(self.folder))
        self.booked, journals = set(), self.watch._journals._journals
        for names, journal in journals.items():
            journal.book = partial(self.book, names, journal.book)

    def book(self, names, book, ledger):
        """Note that the ledger of a pair is kept. What came before the first is not counted."""
        book(ledger)
        self.booked.add(names)

    def wait(self, seconds):
        """Wait until so many seconds of the trial are judged of every pair, and counted."""
        others = self.watch._comparison.others
        self.ros.spin_until(lambda: self.booked == {*others} and all(
            (one.compliance.newest_ns or 0) > START_NS + round(seconds * 1e9)
            for one in others.values()))

    def stop_writing(self, names):
        """Leave a journal as it is while the next ledger is kept in the other ones."""
        kept = self.watch._journals
        journals, look = {**kept._journals}, kept.look
        self.await_ledgers(journals)
        journals.pop(names).tick = lambda clear: None
        # On a busy computer another one would come before this one is written.
        kept.look = lambda newest_ns: None if self.booked >= {*journals} else look(newest_ns)
        self.await_ledgers(journals)

    def await_ledgers(self, journals):
        """Wait until another ledger is in each of these journals."""
        self.booked.clear()
        self.ros.spin_until(lambda: self.booked >= {*journals} and not any(
            one._journal._changed for one in journals.values()))

    def kill(self):
        """Kill it; the readings go on for a second, 15 s of the trial."""
        kill(self.ros, self.watch, *self.watch._journals._journals.values())
        began_s = time.monotonic()
        self.ros.spin_until(lambda: time.monotonic() > began_s + 1.0)
        self.start()

    def count(self):
        """Return what became of all readings, by pair."""
        return {names: self.watch._journals._sum(names).total.total
                for names in self.watch._comparison.others}

    def end(self):
        """Let the trial end; return the verdict."""
        self.ros.spin_until(lambda: self.simulator.done)
        self.ros.end(self.simulator, *self.nodes, self.watch)
        return self.watch.verdict


@pytest.mark.parametrize('settings', [SETTINGS, FREE], ids=['reference', 'free'])
def test_a_watch_that_is_killed_goes_on_and_misses_nothing(ros, tmp_path, trial, settings):
    """Before, the pairs without the reference began again at each start."""
    _, folder, _ = trial
    trial = Trial(ros, settings, tmp_path)
    for seconds in (40.0, 80.0):
        trial.wait(seconds)
        trial.kill()
    found = trial.end()
    whole = offline(str(folder / 'bag'), settings)
    assert [*find_sensor_differences(found, whole)] == []
    assert found.vote.wrong == ('gyro2',)
    assert not [path for path in tmp_path.rglob('*') if 'journal' in path.name]


@pytest.mark.slow
@pytest.mark.parametrize('names', [('gyro1', 'gyro2'), ('gyro1', 'ins'), ('gyro2', 'ins')])
def test_a_watch_that_is_killed_while_it_writes_its_ledgers_counts_nothing_twice(
        ros, tmp_path, trial, names):
    """The readings between the ledgers of two journals were counted twice, or not at all."""
    _, folder, _ = trial
    trial = Trial(ros, FREE, tmp_path)
    trial.wait(40.0)
    trial.stop_writing(names)
    trial.kill()
    found = trial.end()
    whole = offline(str(folder / 'bag'), FREE)
    assert [*find_sensor_differences(found, whole)] == []
    rates_hz = {'gyro1': 5, 'gyro2': 5, 'ins': 10, 'gnss': 4}
    for pair, ledger in trial.count().items():
        assert [ledger.received(stream) for stream in ('ts', 'rs')] == [
            150 * rates_hz[name] for name in pair]
        assert ledger.counts[LedgerKey.TS_PAIRED] >= 150 * rates_hz[pair[0]] - 10


def test_a_mark_that_one_journal_lacks_acts_on_its_pair_too(ros, tmp_path, trial):
    """The node was killed while it wrote a mark; the pair went on with one run."""
    trial = Trial(ros, FREE, tmp_path)
    trial.wait(40.0)
    trial.watch._journals._journals['gyro1', 'ins'].mark = lambda *_: None
    answer = trial.watch._command('start', Trigger.Request(), Trigger.Response())
    assert answer.success
    trial.kill()
    found = trial.end()
    n = {(pair.first, pair.second): pair.n for pair in found.pairs}
    # Two a second; the runs of both began at the mark, after some 40 s of 150.
    assert n['gyro1', 'ins'] == pytest.approx(n['gyro1', 'gyro2'], abs=3)
    assert n['gyro1', 'ins'] < 230


def test_what_nobody_sends_again_is_counted_and_said(ros, tmp_path):
    """Readings of publishers that keep none, while the node is down; no sensor is the RS."""
    rows = 'a sigma_max_deg=0.3; b sigma_max_deg=0.3'
    settings = {'sensors': rows, **COMMON, 'report_dir': str(tmp_path)}
    publishers = {name: ros.plain.create_publisher(Imu, f'{name}/heading', QoSProfile(depth=100))
                  for name in 'ab'}

    def start():
        watch = ros.add(SensorsWatch, parameter_overrides=make_overrides(settings))
        ros.spin_until(lambda: watch._headings.heard.count_publishers() and all(
            one.get_subscription_count() == 1 for one in publishers.values()))
        return watch

    def publish(first_s, last_s):
        stamps = [(1_700_000_000 + at) * 10 ** 9 for at in range(first_s, last_s)]
        for message in heading_messages(Headings.of(stamps, [90.0] * len(stamps)), 'x'):
            for publisher in publishers.values():
                publisher.publish(message)
    watch = start()
    journal = watch._journals._journals['a', 'b']
    # The ledger of the first 20 readings is kept once those after it make pairs.
    for at in range(0, 60, 20):
        publish(at, at + 20)
        ros.spin_until(lambda at=at: (taken := watch._journals._taken)
                       and taken.newest_ns // 10 ** 9 == 1_700_000_019 + at)
    ledger, = journal.kept.ledgers.values()
    counted = ledger.numbers['ts'].last
    assert 20 <= counted < 60
    began_s = time.monotonic()
    ros.spin_until(lambda: time.monotonic() > began_s + 0.5)
    kill(ros, watch, journal)
    ros.spin_until(lambda: not any(p.get_subscription_count() for p in publishers.values()))
    publish(60, 90)
    watch = start()
    publish(90, 150)
    ros.spin_until(lambda: (watch._comparison.newest_ns or 0) // 10 ** 9 == 1_700_000_149)
    ros.end(watch)
    pair, = watch.verdict.pairs
    # The newest pair waits for the next half second, and so is not in the journal.
    assert pair.runs == 1 and pair.n in (119, 120)
    said, = [words for words in pair.findings if 'was restarted' in words]
    assert said.startswith('sensors_watch was restarted at ')
    assert said.endswith(f'; {90 - counted} a and {90 - counted} b readings came after its last '
                         'ledger, and count as lost')


def sensors_of(ros, names):
    """Return publishers of the headings of sensors, by topic."""
    return {name: ros.plain.create_publisher(Imu, name, qos.HEADINGS_OUT) for name in names}


def test_a_mark_acts_on_the_runs_of_all_pairs_a_second_after_the_newest_reading(ros):
    rows = 'a sigma_max_deg=0.3; b sigma_max_deg=0.3; c sigma_max_deg=0.3'
    watch = ros.add(SensorsWatch, parameter_overrides=make_overrides({'sensors': rows, **COMMON}))
    marks = ros.listen(DiagnosticArray, 'compliance/marker', qos.MARKER)
    figures = ros.listen(DiagnosticArray, 'sensors/figures', qos.STATUS)
    publishers = sensors_of(ros, ['a/heading', 'b/heading', 'c/heading'])
    caller = ros.plain.create_client(Trigger, 'compliance/start_run')
    ros.spin_until(lambda: all(p.get_subscription_count() for p in publishers.values())
                   and caller.service_is_ready())

    def publish(first_s, last_s):
        stamps = [(1_700_000_000 + at) * 10 ** 9 for at in range(first_s, last_s)]
        for message in heading_messages(Headings.of(stamps, [90.0] * len(stamps)), 'x'):
            for publisher in publishers.values():
                publisher.publish(message)
    publish(0, 10)

    def newest():
        return figures[-1].header.stamp.sec if figures else 0
    ros.spin_until(lambda: newest() == 1_700_000_009)
    answer = caller.call_async(Trigger.Request())
    ros.spin_until(answer.done)
    ros.spin_until(lambda: marks)
    assert answer.result().success
    assert marks[0].header.stamp.sec == 1_700_000_010
    publish(10, 40)
    ros.spin_until(lambda: newest() == 1_700_000_039)
    ros.end(watch)
    runs = [pair.runs for pair in watch.verdict.pairs]
    assert runs == [1, 1, 1]
    # The pair at 10 s is of before the run, by its stamp.
    assert {pair.n for pair in watch.verdict.pairs} == {29}


def test_a_sensor_that_is_not_tested_has_no_node(ros):
    with pytest.raises(SettingsError, match="sensor = 'gnss': must be one of gyro1, gyro2, ins"):
        several(ros, Compliance, 'gnss')
    with pytest.raises(SettingsError, match="sensor = 'x': no row of sensors has the word rs"):
        ros.add(Synchronizer, parameter_overrides=make_overrides({**FREE, 'sensor': 'x'}))
