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

"""The node that judges."""

from __future__ import annotations

from dataclasses import replace
import json
import shutil
import time

from deadlines import DEADLINE_S, Stopwatch
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from diagnostic_msgs.srv import AddDiagnostics
from geometry_msgs.msg import TwistStamped
from journals import plain
from nodes.inside_nodes import judge_of, judgement_of, pairer_of
from nodes.killed import kill
from nodes.processes import wait_for
from nodes.rclpy_objects import marker_message, marks_from
from nodes.ros_nodes import EITHER_EXECUTOR, NORMS
import numpy as np
import pytest
from rclpy.duration import Duration
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Imu
from std_msgs.msg import Float64, String
from std_srvs.srv import Trigger

from heading_intercompare.app.analysis import judge_bags
from heading_intercompare.app.config import settings_for
from heading_intercompare.app.inputs import load_config_or_journal
from heading_intercompare.bags.recording.recorded_headings import read_marks
from heading_intercompare.bags.rosbag2.bag_chain import read_chain
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.provenance import read_notes
from heading_intercompare.core import pipeline
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.pairing.ledger import Ledger, LedgerSegment
from heading_intercompare.core.records import Headings, Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.compare_verdicts import find_differences
from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.logbook.logbook_file import Logbook
from heading_intercompare.messages.heading_messages import imu_messages, pair_messages
from heading_intercompare.messages.ledger_messages import encode_ledger
from heading_intercompare.messages.status_messages import (
    decode_statuses,
    encode_statuses,
    OK,
    Status,
)
from heading_intercompare.nodes import compliance
from heading_intercompare.nodes.compliance import Compliance
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.judging.figures import SCALARS
from heading_intercompare.nodes.recorder import Recorder
from heading_intercompare.nodes.synchronizer import Synchronizer
from heading_intercompare.web.bridge.bridge_records import Tone
from heading_intercompare.web.bridge.verdict_lamp import light_lamp

T0_NS = 1_700_000_000_000_000_000
S_NS = 1_000_000_000


def some_pairs(rng, lo_s, hi_s):
    """Return one pair per second, T0 + lo to hi - 1 seconds."""
    stamps = T0_NS + np.arange(lo_s, hi_s) * S_NS
    return Pairs.of(stamps, 90.0 + rng.normal(0.0, 0.1, hi_s - lo_s), np.full(hi_s - lo_s, 90.0))


class Graph:
    """A compliance node, a stand-in for the synchronizer, and what the node publishes."""

    def __init__(self, ros, **values):
        self.ros = ros
        self.pairs = ros.plain.create_publisher(TwistStamped, 'pairs', qos.PAIRS)
        self.ledger = ros.plain.create_publisher(DiagnosticArray, 'pairs/ledger', qos.LEDGER)
        self.marker = ros.plain.create_publisher(DiagnosticArray, 'compliance/marker', qos.MARKER)
        self.node = ros.ours(Compliance, **values)
        self.heard = {topic: ros.listen(kind, f'compliance/{topic}', profile)
                      for topic, kind, profile in (
                          ('rolling', DiagnosticArray, qos.STATUS),
                          ('run', DiagnosticArray, qos.STATUS),
                          ('verdict', DiagnosticArray, qos.STATE_IN),
                          ('marker', DiagnosticArray, qos.MARKER),
                          ('report', String, qos.REPORT))}
        ros.spin_until(lambda: self.pairs.get_subscription_count() == 1
                       and self.ledger.get_subscription_count() == 1)

    def send(self, pairs, started_ns=1):
        """Publish pairs, at most the queue depth at once, and wait until they have been taken."""
        for lo in range(0, len(pairs), 500):
            piece = pairs[lo:lo + 500]
            n = self.node._pairs.received + len(piece)
            for message in pair_messages(piece, str(started_ns)):
                self.pairs.publish(message)
            self.ros.spin_until(lambda n=n: self.node._pairs.received == n)

    def book(self, counts, final=False, more=(), started_ns=1):
        """Publish a ledger."""
        segments = [LedgerSegment(None, counts), *(LedgerSegment(ns, c) for ns, c in more)]
        self.ledger.publish(encode_ledger(Ledger.from_segments(segments, T0_NS), final,
                                          started_ns))

    def call(self, name):
        """Call a service of the node."""
        client = self.ros.plain.create_client(Trigger, f'compliance/{name}')
        self.ros.spin_until(client.service_is_ready)
        future = client.call_async(Trigger.Request())
        self.ros.spin_until(future.done)
        return future.result()

    def act(self, text):
        """Ask the node for an action in the name of an operator."""
        client = self.ros.plain.create_client(AddDiagnostics, 'compliance/operator_action')
        self.ros.spin_until(client.service_is_ready)
        future = client.call_async(AddDiagnostics.Request(load_namespace=text))
        self.ros.spin_until(future.done)
        return future.result()

    def reports(self):
        """Return the reports heard so far."""
        return [json.loads(m.data) for m in self.heard['report']]

    def end(self):
        """End the node as its process would; return the last report."""
        self.ros.end(self.node)
        report = self.node.verdict.to_dict()
        self.ros.spin_until(lambda: report in self.reports())
        return report


def values(message):
    """Return the values of the first status."""
    return {pair.key: pair.value for pair in message.status[0].values}


def stamp_ns(message):
    """Return the stamp of a message."""
    return message.header.stamp.sec * S_NS + message.header.stamp.nanosec


def offline(pairs, marks=(), **more):
    """Return the result of the pure part for the pairs."""
    compliance = pipeline.Compliance(Settings.from_mapping({**NORMS, **more}), source='live')
    for kind, stamp_ns in marks:
        compliance.mark(kind, stamp_ns)
    compliance.update(pairs)
    compliance.finish()
    return json.loads(json.dumps(compliance.verdict().to_dict()))


def without_ledger(run):
    """Return a run without its share of the ledger, which the pure part has not seen."""
    return {**run, 'pairing': None,
            'validity': [f for f in run['validity'] if f['condition'] != 'losses']}


def test_before_the_first_run_has_ended_the_verdict_says_so(ros):
    """A display that was connected heard nothing, as if no verdict were published."""
    graph = Graph(ros)
    ros.spin_until(lambda: graph.heard['verdict'])
    (said,), = [message.status for message in graph.heard['verdict']]
    assert (said.level, said.message) == (DiagnosticStatus.WARN, 'no run has ended')
    shown = light_lamp(decode_statuses(serialize_message(graph.heard['verdict'][0]))[1], 0)
    assert (shown.tone, shown.what) == (Tone.NONE, 'at the end of the run')


def test_a_late_subscriber_gets_the_newest_verdict_alone(ros, rng):
    """``ros2 topic echo --once`` shows the first message that comes: it is the last verdict."""
    began_ns = time.time_ns()
    graph, pairs = Graph(ros), some_pairs(rng, 0, 600)
    ros.spin_until(lambda: graph.heard['verdict'])
    for run, lo in enumerate((0, 200, 400), 1):
        graph.send(pairs[lo:lo + 200])
        graph.book({'paired': lo + 200, 'ts_paired': lo + 200, 'rs_used': lo + 200})
        graph.call('stop_run')
        graph.call('start_run')
        ros.spin_until(lambda run=run: values(graph.heard['verdict'][-1])['runs'] == str(run))
    late = [ros.listen(DiagnosticArray, 'compliance/verdict', profile)
            for profile in (qos.STATE_IN, qos.STATE)]
    ros.spin_until(lambda: all(late))
    ros.spin_until(lambda: ros.executor.spin_once(0.2) is None)
    assert [[values(message)['runs'] for message in heard] for heard in late] == [['3'], ['3']]
    first, last = graph.heard['verdict'][0], late[0][0]
    assert stamp_ns(first) >= began_ns
    assert stamp_ns(last) == pairs.stamp_ns[-1]
    for status in (*first.status, *last.status):
        assert status.hardware_id.split() == ['/compliance', graph.node.health.owner.split()[1]]


def test_the_window_can_be_changed_while_the_node_runs(ros, rng):
    """It keeps what it holds; the verdict is the same."""
    graph = Graph(ros, window_s=100.0)
    graph.send(some_pairs(rng, 0, 400))
    for window_s, n in ((50.0, 50), (200.0, 150)):
        graph.node.set_parameters([Parameter('window_s', value=window_s)])
        if window_s == 200.0:
            graph.send(some_pairs(rng, 400, 500))
        ros.spin_until(lambda n=n: graph.heard['rolling'] and abs(
            int(values(graph.heard['rolling'][-1])['n']) - n) <= 5)
    graph.end()


def test_a_setting_changed_while_the_node_runs_is_said_everywhere(ros, rng, tmp_path, capfd):
    """The JSON said 600 s while it was 5, and no log, bag or warning told of the change."""
    graph, recorder = Graph(ros), ros.ours(Recorder, output=str(tmp_path / 'bag'), end_wait_s=2.0)
    synchronizer = ros.ours(Synchronizer, subscribers=0)
    states = ros.listen(DiagnosticArray, '/diagnostics', qos.DIAGNOSTICS_IN)
    graph.send(some_pairs(rng, 0, 100))
    before_ns = time.time_ns()
    for node, name, value in ((graph.node, 'window_s', 5.0), (graph.node, 'stale_s', 3.0),
                              (synchronizer, 'stale_s', 3600.0), (graph.node, 'window_s', 600.0)):
        node.set_parameters([Parameter(name, value=value)])
    words = ['compliance: window_s changed from 600.0 to 5.0 [by unknown operator]',
             'synchronizer: stale_s changed from 3.0 to 3600.0 [by unknown operator]',
             'compliance: window_s changed from 5.0 to 600.0 [by unknown operator]']
    ros.spin_until(lambda: recorder.written >= 3 and len(graph.node.actions.notes) == 3)
    shown = {status.name: status for message in states for status in message.status}
    for name in ('compliance', 'synchronizer'):
        assert shown[f'{name}: settings'].level == DiagnosticStatus.WARN
    report = graph.end()
    assert sorted(note['text'] for note in report['operator_actions']) == sorted(words)
    assert all(note['stamp_ns'] >= before_ns for note in report['operator_actions'])
    assert all(line in str(graph.node.verdict) for line in words)
    ros.end(synchronizer, recorder)
    noted = read_notes(BagReader(tmp_path / 'bag'))
    assert sorted(note.text for note in noted) == sorted(words)
    assert {note.stamp_ns for note in noted} == {
        note['stamp_ns'] for note in report['operator_actions']}
    logged = capfd.readouterr().err
    assert all(line.partition(': ')[2] in logged for line in words)


def test_the_verdict_names_the_chain_of_the_bag_recorded_meanwhile(ros, rng, tmp_path):
    graph, recorder = Graph(ros), ros.ours(Recorder, output=str(tmp_path / 'bag'), end_wait_s=2.0)
    graph.send(some_pairs(rng, 0, 700))
    ros.spin_until(lambda: graph.node.recorders.recordings)
    report = graph.end()
    ros.end(recorder)
    recording, = report['recordings']
    assert recording['path'] == str(tmp_path / 'bag') and recording['chunks'] > 0
    chain = read_chain(tmp_path / 'bag', recording['chunks'])
    assert (chain.chunks, chain.sha256) == (recording['chunks'], recording['sha256'])


def test_what_no_recorder_of_this_graph_says_is_not_in_the_verdict(ros, rng):
    graph = Graph(ros)
    forger = ros.plain.create_publisher(DiagnosticArray, '/diagnostics', qos.STATUS)
    ros.spin_until(lambda: forger.get_subscription_count() >= 1)
    figures = {'path': 'x', 'chain_chunks': 3, 'chain_sha256': '0' * 64}
    for name, owner, more in (
            ('ship2/recorder: bag', '/ship2/recorder 5', {}), ('recorder: bag', '/other 5', {}),
            ('recorder: bag', '', {}), ('recorder: disk', '/recorder 5', {}),
            ('recorder: bag', '/recorder 5', {'chain_chunks': 'many'}),
            ('recorder: bag', '/recorder 5', {'path': 'y'}),
            ('recorder: bag', '/recorder 6', {})):
        forger.publish(encode_statuses(
            1, [Status(name, OK, '', figures | more)], owner))
    graph.send(some_pairs(rng, 0, 700))
    ros.spin_until(lambda: graph.node.recorders.recordings)
    assert graph.end()['recordings'] == [
        {'path': 'y', 'chunks': 3, 'sha256': '0' * 64}]


@pytest.mark.parametrize('asked, author', [
    (('start_run', 'stop_run'), 'unknown operator'),
    (('start [by J. Smith]', 'stop [by J. Smith]'), 'J. Smith')])
def test_each_mark_has_its_operator_in_the_bag_and_in_the_verdict(
        ros, rng, tmp_path, asked, author):
    """A touch at hour 11 took 11 hours from the record, and nobody knew whose it was."""
    graph, recorder = Graph(ros), ros.ours(Recorder, output=str(tmp_path / 'bag'), end_wait_s=2.0)
    pairs = some_pairs(rng, 0, 300)
    for at, name in zip((100, 200), asked):
        graph.send(pairs[at - 100:at])
        assert (graph.call(name) if '_' in name else graph.act(name)).success
    graph.send(pairs[200:])
    ros.spin_until(lambda: len(graph.node.actions.notes) == 2)
    report = graph.end()
    ros.end(recorder)
    texts = [note['text'] for note in report['operator_actions']]
    assert [text.partition(' after')[0] for text in texts] == [
        'compliance: start', 'compliance: stop']
    assert all(text.endswith(f' [by {author}]') for text in texts)
    bag = BagReader(tmp_path / 'bag')
    assert [note.text for note in read_notes(bag)] == texts
    assert [decode_statuses(message.data)[1][0].values for message in bag.messages(
        ['compliance/marker'])] == [{'operator': author}] * 2
    marks = [*zip(('start', 'stop'), (int(pairs.stamp_ns[at]) for at in (99, 199)))]
    assert [*read_marks(bag)] == marks
    assert [without_ledger(run) for run in report['runs']] == [
        without_ledger(run) for run in offline(pairs, marks)['runs']]


@pytest.mark.parametrize('wrong', ['', 'pause [by J. Smith]', '[by J. Smith]'])
def test_an_action_that_is_none_is_refused(ros, wrong):
    graph = Graph(ros)
    answer = graph.act(wrong)
    assert not answer.success and 'must be one of start, stop, acknowledge' in answer.message
    assert not graph.node.actions.notes and not graph.heard['marker']


def test_the_verdict_is_that_without_a_change_of_a_setting(ros, rng):
    graph, pairs = Graph(ros), some_pairs(rng, 0, 100)
    graph.send(pairs)
    graph.node.set_parameters([Parameter('window_s', value=5.0)])
    ros.spin_until(lambda: graph.node.actions.notes)
    graph.end()
    compliance = pipeline.Compliance(Settings.from_mapping(NORMS), source='live')
    compliance.update(pairs)
    compliance.finish()
    verdict = replace(graph.node.verdict, ledger_problems=(),
                      runs=compliance.verdict().runs)
    assert not [*find_differences(verdict, compliance.verdict())]
    assert Verdict.from_dict(graph.node.verdict.to_dict()) == graph.node.verdict


def test_the_warning_of_a_changed_setting_ends_where_it_is_as_at_the_start(ros):
    graph = Graph(ros)
    states = ros.listen(DiagnosticArray, '/diagnostics', qos.DIAGNOSTICS_IN)

    def level():
        return [status.level for message in states for status in message.status
                if status.name == 'compliance: settings'][-1:]
    for window_s, expected in ((5.0, DiagnosticStatus.WARN), (600.0, DiagnosticStatus.OK)):
        graph.node.set_parameters([Parameter('window_s', value=window_s)])
        graph.call('acknowledge')
        ros.spin_until(lambda expected=expected: level() == [expected])


@EITHER_EXECUTOR
def test_the_last_report_is_the_verdict_of_the_pure_part(ros, rng):
    graph, pairs = Graph(ros), some_pairs(rng, 0, 300)
    for lo in range(0, 300, 60):
        graph.send(pairs[lo:lo + 60])
    graph.book({'paired': 300, 'ts_paired': 300, 'rs_used': 300}, final=True)
    report, expected = graph.end(), offline(pairs)
    assert {k: v for k, v in report.items() if k != 'runs'} == {
        k: v for k, v in expected.items() if k != 'runs'}
    assert [without_ledger(run) for run in report['runs']] == [
        without_ledger(run) for run in expected['runs']]
    assert report['runs'][0]['pairing'] == expected['runs'][0]['pairing']
    ros.spin_until(lambda: len(graph.heard['verdict']) == 2)
    assert values(graph.heard['verdict'][-1])['outcome'] == graph.reports()[-1]['outcome']


def test_the_end_waits_for_the_pairs_that_the_final_ledger_knows(ros, rng):
    graph, pairs = Graph(ros), some_pairs(rng, 0, 200)
    graph.send(pairs[:100])
    graph.book({'paired': 200, 'ts_paired': 200, 'rs_used': 200}, final=True)
    graph.node.end()
    ros.spin_until(lambda: ros.executor.spin_once(0.2) is None)
    assert not graph.node.ended
    graph.send(pairs[100:])
    ros.spin_until(lambda: graph.node.ended)
    assert graph.node.verdict.to_dict()['runs'][0]['n'] == 200


def test_a_final_ledger_that_has_come_is_read_before_the_end(ros, rng, monkeypatch):
    """On a busy computer a drain may be served before it; the report said it did not come."""
    monkeypatch.setattr(compliance, '_ALONE_S', 0.0)
    graph = Graph(ros)
    graph.send(some_pairs(rng, 0, 100))
    for timer in graph.node.timers:
        timer.cancel()
    graph.book({'paired': 100, 'ts_paired': 100, 'rs_used': 100}, final=True)
    for publisher in (graph.pairs, graph.ledger):
        publisher.wait_for_all_acked(Duration(seconds=DEADLINE_S))
        ros.plain.destroy_publisher(publisher)
    # Its executor lets go of them, without serving anything.
    ros.executor.remove_node(ros.plain)
    wait_for(lambda: not graph.node.count_publishers('pairs'))
    graph.node.end()
    graph.node._drain()
    assert not graph.node.ended
    ros.spin_until(lambda: graph.node._heard.covers(100))
    graph.node._drain()
    assert graph.node.ended and graph.node.verdict.to_dict()['ledger_complete']


def test_a_synchronizer_that_has_gone_is_not_waited_for(ros, rng):
    graph = Graph(ros, end_wait_s=5.0)
    graph.send(some_pairs(rng, 0, 100))
    ros.plain.destroy_publisher(graph.pairs)
    watch = Stopwatch()
    graph.node.end()
    ros.spin_until(lambda: graph.node.ended)
    assert watch.passed_s < 4.9
    assert graph.node.verdict.to_dict()['runs'][0]['n'] == 100


def test_without_pairs_the_end_still_gives_a_report(ros):
    graph = Graph(ros)
    ros.plain.destroy_publisher(graph.pairs)
    report = graph.end()
    assert (report['outcome'], report['runs']) == ('indeterminate', [])


def test_a_run_that_falls_silent_is_reported_once_its_ledger_has_come(ros, rng):
    graph = Graph(ros, ledger_wait_s=60.0)
    graph.send(some_pairs(rng, 0, 100))
    graph.send(some_pairs(rng, 200, 210))
    graph.book({'paired': 100, 'ts_paired': 100, 'rs_used': 100})
    ros.spin_until(lambda: ros.executor.spin_once(0.2) is None)
    assert graph.reports() == []
    graph.book({'paired': 100, 'ts_paired': 100, 'rs_used': 100, 'ts_unpaired': 3},
               more=[(T0_NS + 200 * S_NS, {'paired': 10, 'ts_paired': 10, 'rs_used': 10})])
    ros.spin_until(lambda: graph.reports())
    run, = graph.reports()[0]['runs']
    assert (run['n'], run['pairing']['ts_unpaired'], run['pairing']['paired']) == (100, 3, 100)


def test_a_report_whose_ledger_does_not_come_is_published_all_the_same(ros, rng):
    graph = Graph(ros, ledger_wait_s=0.2)
    states = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    graph.send(some_pairs(rng, 0, 100))
    graph.send(some_pairs(rng, 200, 210))
    ros.spin_until(lambda: graph.reports())
    ros.spin_until(lambda: any('last report is incomplete' in s.message for m in states
                               for s in m.status))


def test_marks_of_a_recording_take_effect_by_their_stamps(ros, rng):
    marks = [('start', T0_NS + 49 * S_NS), ('stop', T0_NS + 199 * S_NS)]
    graph, pairs = Graph(ros), some_pairs(rng, 0, 300)
    for mark in marks:
        graph.marker.publish(marker_message(*mark))
    ros.spin_until(lambda: len(graph.heard['marker']) == 2)
    graph.send(pairs)
    graph.book({'paired': 300, 'ts_paired': 300, 'rs_used': 300}, final=True)
    runs = graph.end()['runs']
    assert runs[0]['start_ns'] == T0_NS + 50 * S_NS
    expected = offline(pairs, marks)['runs'][0]
    assert without_ledger(runs[0]) == without_ledger(expected)
    assert runs[0]['n'] == 150


@EITHER_EXECUTOR
def test_the_services_cut_behind_the_newest_pair_and_leave_marks(ros, rng):
    graph, pairs = Graph(ros), some_pairs(rng, 0, 300)
    graph.send(pairs[:50])
    assert graph.call('start_run').success
    graph.send(pairs[50:200])
    assert graph.call('stop_run').success
    graph.send(pairs[200:])
    graph.book({'paired': 300, 'ts_paired': 300, 'rs_used': 300}, final=True)
    run, = graph.end()['runs']
    assert (run['start_ns'], run['end_ns'], run['n']) == (
        T0_NS + 50 * S_NS, T0_NS + 199 * S_NS, 150)
    ros.spin_until(lambda: len(graph.heard['marker']) == 2)
    assert [m for message in graph.heard['marker'] for m in marks_from(message)] == [
        ('start', T0_NS + 49 * S_NS), ('stop', T0_NS + 199 * S_NS)]


def test_a_mark_that_is_neither_start_nor_stop_is_a_warning(ros):
    graph = Graph(ros)
    states = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    graph.marker.publish(encode_statuses(T0_NS, [Status('marker', OK, 'pause')]))
    ros.spin_until(lambda: any("mark 'pause' is neither start nor stop" in s.message
                               for m in states for s in m.status))


def test_a_bad_verdict_stays_in_the_diagnostics_until_it_is_acknowledged(ros, rng):
    graph = Graph(ros, norms__sigma_max_deg=0.001, norms__sigma_ref_max_deg=0.001)
    states = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    graph.send(some_pairs(rng, 0, 2000))
    graph.book({'paired': 2000, 'ts_paired': 2000, 'rs_used': 2000})
    assert graph.call('stop_run').success
    ros.spin_until(lambda: graph.reports())
    assert graph.reports()[0]['outcome'] == 'non_compliant'
    ros.spin_until(lambda: any(s.name == 'compliance: verdict' and s.level == b'\2'
                               for m in states for s in m.status))
    assert graph.call('acknowledge').message == '1 alert acknowledged'
    # The newest verdict is what it was: acknowledged or not, it is not OK.
    states.clear()
    ros.spin_until(lambda: states)
    assert next(s.level for m in states[-1:] for s in m.status
                if s.name == 'compliance: verdict') == b'\2'


def test_figures_of_the_window_and_of_the_run_come_every_second(ros, rng):
    graph = Graph(ros)
    graph.send(some_pairs(rng, 0, 100))
    ros.spin_until(lambda: graph.heard['run'] and values(graph.heard['run'][-1])['n'] == '100')
    ros.spin_until(lambda: values(graph.heard['rolling'][-1])['n'] == '100')
    float(values(graph.heard['run'][-1])['mean_deg'])


def test_the_mean_of_the_window_follows_each_batch_and_the_bounds_follow_once_a_second(
        ros, rng, monkeypatch):
    """The bounds say how old they are."""
    graph = Graph(ros)
    graph.send(some_pairs(rng, 0, 100))
    ros.spin_until(lambda: judgement_of(graph.node)._figures._bounds.get('n') == '100')
    monkeypatch.setattr(Compliance, '_beat', lambda self: None)
    pairs = some_pairs(rng, 100, 140)
    graph.send(pairs)
    ros.spin_until(lambda: values(graph.heard['rolling'][-1])['n'] == '140')
    newest = values(graph.heard['rolling'][-1])
    figures = judge_of(graph.node).rolling_figures()
    assert float(newest['mean_deg']) == figures['mean_deg']
    assert float(newest['std_deg']) == figures['std_deg']
    assert int(newest['bounds_newest_ns']) < int(newest['newest_ns']) == pairs.stamp_ns[-1]
    assert 'limit_deg2' in newest


def test_a_report_is_also_written_as_a_file(ros, rng, tmp_path):
    graph = Graph(ros, report_dir=str(tmp_path / 'reports'))
    graph.send(some_pairs(rng, 0, 100))
    graph.book({'paired': 100, 'ts_paired': 100, 'rs_used': 100}, final=True)
    report = graph.end()
    written, = (tmp_path / 'reports').iterdir()
    assert written.name == 'verdict_20231114T221459Z.json'
    assert json.loads(written.read_text('utf-8')) == report


def test_a_report_that_cannot_be_written_is_an_error_in_the_diagnostics(ros, rng, tmp_path):
    folder = tmp_path / 'reports'
    graph = Graph(ros, report_dir=str(folder))
    states = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    shutil.rmtree(folder)
    graph.send(some_pairs(rng, 0, 100))
    graph.book({'paired': 100, 'ts_paired': 100, 'rs_used': 100})
    graph.call('stop_run')
    ros.spin_until(lambda: any('No such file' in s.message for m in states for s in m.status))


@pytest.mark.parametrize('values, message', [
    ({'norms__sigma_max_deg': 'none'}, 'norms.sigma_max_deg'),
    ({'norms__sigma_ref_max_deg': -1.0}, 'norms.sigma_ref_max_deg = -1.0'),
    ({'report_directory': 'x'}, "unknown parameter 'report_directory'; did you mean 'report_dir'"),
])
def test_a_wrong_setting_ends_the_node_before_it_begins(ros, values, message):
    with pytest.raises(SettingsError) as error:
        ros.ours(Compliance, **values)
    assert message in str(error.value)


def test_a_look_at_the_run_in_progress_that_decides_is_a_verdict_but_no_report(ros, rng):
    graph = Graph(ros, sequential__plan_s=800.0, sequential__looks=2,
                  risk__min_duration_s=0.0, norms__sigma_max_deg=1.0,
                  norms__sigma_ref_max_deg=0.5)
    graph.send(some_pairs(rng, 0, 500))
    ros.spin_until(lambda: len(graph.heard['verdict']) == 2)
    whole, progress = graph.heard['verdict'][1].status
    assert (whole.message, progress.name) == ('INDETERMINATE: there is no run', 'run in progress')
    shown = {pair.key: pair.value for pair in progress.values}
    assert (shown['look'], shown['looks'], shown['outcome']) == ('1', '2', 'compliant')
    assert graph.reports() == []


def test_pairs_and_ledgers_that_cannot_be_read_are_counted(ros, rng):
    graph = Graph(ros)
    states = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    good = pair_messages(some_pairs(rng, 0, 4), '1')
    for data in (good[0], b'\0\3' + good[1][2:], good[2][:40], good[3]):
        graph.pairs.publish(data)
    graph.ledger.publish(encode_statuses(T0_NS, [Status('segment 0', OK, '', {'paired': 'two'})]))

    def said(part):
        return {s.message for m in states for s in m.status if s.name == f'compliance: {part}'}
    ros.spin_until(lambda: '2 messages refused: geometry_msgs/msg/TwistStamped message of 40 '
                   'bytes is too short' in said('pairs lost'))
    ros.spin_until(lambda: "1 messages refused: ledger: paired = 'two' must be an integer of 64 "
                   'bits' in said('pairs/ledger'))
    assert graph.node._pairs.received == 4
    assert judge_of(graph.node).newest_ns == T0_NS + 3 * S_NS


def test_pairs_with_the_stamp_of_the_pair_before_are_refused(ros, rng):
    """A run of them ended the node: division by zero. Only a foreign node sends such pairs."""
    graph = Graph(ros)
    states = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    twice = some_pairs(rng, 0, 400)[np.arange(800) // 2]
    graph.send(twice[:401])
    graph.send(twice[401:])
    ros.spin_until(lambda: any(
        s.message == f'400 messages refused: the stamp {T0_NS + 399 * S_NS} ns is that of the '
        'pair before' for m in states for s in m.status if s.name == 'compliance: pairs lost'))
    graph.call('stop_run')
    ros.spin_until(graph.reports)
    run, = graph.reports()[-1]['runs']
    assert run['n_input'] == 400


def test_each_run_gets_a_row_in_the_logbook(ros, rng, tmp_path):
    graph = Graph(ros, logbook=str(tmp_path / 'l'), ship='MV Example')
    pairs = some_pairs(rng, 0, 200)
    graph.send(pairs[:100])
    graph.call('stop_run')
    graph.call('start_run')
    graph.send(pairs[100:])
    graph.book({'paired': 200, 'ts_paired': 200, 'rs_used': 200}, final=True)
    runs = graph.end()['runs']
    rows = Logbook(tmp_path / 'l').read()
    assert [(row.ship, row.start_ns, row.n) for row in rows] == [
        ('MV Example', run['start_ns'], run['n']) for run in runs]


def test_a_logbook_that_cannot_be_written_does_not_end_the_trial(ros, rng, tmp_path):
    graph = Graph(ros, logbook=str(tmp_path / 'away' / 'l'))
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    graph.send(some_pairs(rng, 0, 100))
    graph.book({'paired': 100, 'ts_paired': 100, 'rs_used': 100})
    graph.call('stop_run')
    ros.spin_until(lambda: any(
        'logbook' in status.name and 'cannot be opened' in status.message
        for message in diagnostics for status in message.status))
    graph.book({'paired': 100, 'ts_paired': 100, 'rs_used': 100}, final=True)
    assert len(graph.end()['runs']) == 1
def test_a_restart_of_the_synchronizer_ends_the_run_and_the_report_says_so(ros, rng):
    """What the one before still held is not known to the next: no run goes on across."""
    graph, pairs = Graph(ros), some_pairs(rng, 0, 5693)
    states = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    graph.send(pairs[:2999])
    graph.book({'paired': 2999, 'ts_paired': 2999, 'rs_used': 2999, 'ts_pending': 1})
    ros.plain.destroy_publisher(graph.pairs)
    graph.pairs = ros.plain.create_publisher(TwistStamped, 'pairs', qos.PAIRS)
    ros.spin_until(lambda: graph.pairs.get_subscription_count() == 1)
    graph.send(pairs[2999:], 1_700_003_000 * S_NS)
    graph.book({'paired': 2694, 'ts_paired': 2694, 'rs_used': 2694}, final=True,
               started_ns=1_700_003_000 * S_NS)
    report = graph.end()
    assert [(run['n_input'], run['pairing']['paired'], run['pairing']['ts_received'],
             run['pairing']['ts_unpaired']) for run in report['runs']] == [
        (2999, 2999, 3000, 1), (2694, 2694, 2694, 0)]
    assert [run.get('clock_segment') for run in report['runs']] == [None, 1]
    assert report['ledger_complete'] is False
    assert report['ledger_problems'] == [
        'the synchronizer was restarted at 2023-11-14 23:03:20.000 UTC, and the run ended there; '
        'its last ledger was not final: up to 1 s of readings is missing, and those that came '
        'while it was down']
    ros.spin_until(lambda: any('incomplete: the synchronizer was restarted' in s.message
                               for m in states for s in m.status))


class Synchronizers:
    """Publishers of pairs and ledgers of several synchronizers, by the time of their start."""

    def __init__(self, ros, node):
        self.ros, self.node, self.publishers = ros, node, {}

    def send(self, started_ns, pairs, final=False):
        """Publish pairs of a synchronizer, and its ledger."""
        if started_ns not in self.publishers:
            self.publishers[started_ns] = (
                self.ros.plain.create_publisher(TwistStamped, 'pairs', qos.PAIRS),
                self.ros.plain.create_publisher(DiagnosticArray, 'pairs/ledger', qos.LEDGER))
            self.ros.spin_until(lambda: all(
                p.get_subscription_count() for p in self.publishers[started_ns]))
        publisher, ledger = self.publishers[started_ns]
        n = self.node._pairs.received + len(pairs)
        for message in pair_messages(pairs, str(started_ns)):
            publisher.publish(message)
        self.ros.spin_until(lambda: self.node._pairs.received == n)
        counts = dict.fromkeys(('paired', 'ts_paired', 'rs_used'), len(pairs))
        ledger.publish(encode_ledger(Ledger.from_segments([LedgerSegment(None, counts)], T0_NS),
                                     final, started_ns))


def test_the_pairs_of_an_earlier_synchronizer_do_not_mix_with_those_of_the_last(ros, rng):
    """Before, both were judged together: 100 deg and 0 deg of mean difference."""
    node = ros.ours(Compliance)
    both = Synchronizers(ros, node)
    sound, wrong = some_pairs(rng, 0, 300), some_pairs(rng, 0, 300)
    wrong = Pairs.of(wrong.stamp_ns, wrong.ts_deg + 100.0, wrong.rs_deg)
    both.send(2000, sound[:1])
    for lo in range(1, 300, 50):
        both.send(1000, wrong[lo:lo + 50])
        both.send(2000, sound[lo:lo + 50])
    both.send(2000, sound[:0], final=True)
    ros.spin_until(lambda: node._pairs.left_out == 299)
    ros.end(node)
    report = node.verdict.to_dict()
    run, = report['runs']
    assert (run['n'], run['mean_deg']) == (300, offline(sound)['runs'][0]['mean_deg'])
    assert '299 pairs of another synchronizer were left out' in report['ledger_problems']


def test_a_compliance_that_is_killed_knows_in_which_segment_its_synchronizer_was(
        ros, rng, tmp_path):
    """The synchronizer was started again before, and sets a clock back after."""
    trial, pairs = Killed(ros, tmp_path), some_pairs(rng, 0, 900)
    trial.send(pairs[:300])
    trial.send(pairs[300:400], '2000')
    trial.kill()
    trial.start()
    trial.send(pairs[400:600], '2000')
    trial.send(pairs[600:], '2000/1')
    ros.end(trial.node)
    runs = trial.node.verdict.to_dict()['runs']
    assert [(run['n'], run.get('clock_segment')) for run in runs] == [
        (300, None), (300, 1), (300, 2)]


def test_a_compliance_that_was_restarted_says_how_many_pairs_it_missed(ros, rng):
    """Without a journal; the synchronizer keeps the last 5000 pairs."""
    graph, pairs = Graph(ros), some_pairs(rng, 0, 6500)
    graph.send(pairs[:6200])
    graph.book({'paired': 6200, 'ts_paired': 6200, 'rs_used': 6200})
    ros.executor.remove_node(graph.node)
    ros.nodes.remove(graph.node)
    graph.node.destroy_node()
    ros.spin_until(lambda: graph.pairs.get_subscription_count() == 0)
    graph.node = ros.ours(Compliance)
    ros.spin_until(lambda: graph.pairs.get_subscription_count() == 1
                   and graph.ledger.get_subscription_count() == 1)
    ros.spin_until(lambda: graph.node._pairs.received >= 5000)
    graph.send(pairs[6200:])
    graph.book({'paired': 6500, 'ts_paired': 6500, 'rs_used': 6500}, final=True)
    report = graph.end()
    assert (report['runs'][0]['n'], report['ledger_complete']) == (5300, False)
    assert report['ledger_problems'] == ['1200 pairs were published before this node started']


def test_a_complete_ledger_is_called_so(ros, rng):
    graph = Graph(ros)
    graph.send(some_pairs(rng, 0, 100))
    graph.book({'paired': 100, 'ts_paired': 100, 'rs_used': 100}, final=True)
    report = graph.end()
    assert (report['ledger_complete'], report['ledger_problems']) == (True, [])


def test_a_ledger_that_did_not_come_is_told(ros, rng):
    graph = Graph(ros)
    graph.send(some_pairs(rng, 0, 100))
    ros.plain.destroy_publisher(graph.pairs)
    report = graph.end()
    assert report['ledger_problems'] == ['the ledger that covers the last pairs did not come']


def test_pairs_that_never_came_are_told_even_if_they_come_after_the_end(ros, rng):
    """The last report stands: what DDS sends again later does not hide what it lacks."""
    graph, pairs = Graph(ros, end_wait_s=0.1), some_pairs(rng, 0, 200)
    graph.send(pairs[:100])
    graph.book({'paired': 200, 'ts_paired': 200, 'rs_used': 200}, final=True)
    ros.spin_until(lambda: graph.node._heard.covers(200))
    graph.node.end()
    ros.spin_until(lambda: graph.node.ended)
    for message in pair_messages(pairs[100:], '1'):
        graph.pairs.publish(message)
    ros.spin_until(graph.reports)
    # On a busy computer the node beats once more before its process is gone.
    graph.node._beat()
    ros.spin_until(lambda: ros.executor.spin_once(0.3) is None)
    report = graph.node.verdict.to_dict()
    assert report['ledger_problems'] == ['the last 100 pairs did not come to this node']
    assert [run['n'] for run in report['runs']] == [100]
    assert graph.reports() == [report]


@EITHER_EXECUTOR
def test_with_a_real_synchronizer_that_is_killed_the_sums_hold(ros, rng):
    """The driver goes on: each of its readings stands in one row, and the run has ended."""
    values_of = {'pairing.method': 'interpolate', 'runs.min_duration_s': 0.0}
    sensors = [ros.plain.create_publisher(Imu, f'{role}/heading', qos.HEADINGS_OUT)
               for role in ('ts', 'rs')]
    compliance = ros.ours(Compliance, **values_of)
    stamps = T0_NS + np.arange(400) * S_NS // 10
    readings = Headings.of(stamps, 90.0 + rng.normal(0.0, 0.1, 400))

    def send(synchronizer, lo, hi, paired):
        ros.spin_until(lambda: all(s.get_subscription_count() == 1 for s in sensors))
        for sensor in sensors:
            for message in imu_messages(readings[lo:hi], 'x'):
                sensor.publish(message)
        last = int(stamps[hi - 1])
        ros.spin_until(lambda: pairer_of(synchronizer).ledger.paired == paired
                       and pairer_of(synchronizer).ledger.newest_ns == last)
    first = ros.ours(Synchronizer, **values_of)
    send(first, 0, 150, 150)
    ros.spin_until(lambda: compliance._heard.covers(150) and compliance.n_pairs == 150)
    ros.executor.remove_node(first)
    ros.nodes.remove(first)
    first.destroy_node()
    ros.spin_until(lambda: all(s.get_subscription_count() == 0 for s in sensors))
    for sensor in sensors:
        for message in imu_messages(readings[150:160], 'x'):
            sensor.publish(message)
    second = ros.ours(Synchronizer, **values_of)
    send(second, 160, 400, 240)
    for sensor in sensors:
        ros.plain.destroy_publisher(sensor)
    ros.end(second, compliance)
    report = compliance.verdict.to_dict()
    assert [(run['n'], run['pairing']['paired'], run['pairing']['ts_received'])
            for run in report['runs']] == [(150, 150, 150), (240, 240, 240)]
    # The numbers of their publishers show those in between, which belong to the run before.
    assert report['runs'][0]['pairing']['lost'] == {'ts': {'on_the_way': 10},
                                                    'rs': {'on_the_way': 10}}
    problem, = report['ledger_problems']
    assert 'was restarted at' in problem and 'and the run ended there' in problem
    assert '10 TS and 10 RS readings came after its last ledger, and count as lost' in problem


def ledger_of(n, final=False):
    """Return the ledger of a synchronizer started at 1000 that made n pairs."""
    counts = dict.fromkeys(('paired', 'ts_paired', 'rs_used'), n)
    return encode_ledger(Ledger.from_segments([LedgerSegment(None, counts)], T0_NS), final, 1000)


class Killed:
    """A node that is killed now and then, and the synchronizer whose pairs it takes."""

    def __init__(self, ros, folder, **values):
        self.ros, self.values = ros, {'report_dir': str(folder), **values}
        self.pairs = ros.plain.create_publisher(TwistStamped, 'pairs', qos.PAIRS)
        self.ledger = ros.plain.create_publisher(DiagnosticArray, 'pairs/ledger', qos.LEDGER)
        self.start()

    def start(self):
        """Start the node, as its respawn would."""
        self.node = self.ros.ours(Compliance, **self.values)
        self.ros.spin_until(lambda: self.pairs.get_subscription_count()
                            and self.ledger.get_subscription_count())

    def publish(self, pairs, frame='1000'):
        """Publish pairs, whether the node lives or not."""
        for message in pair_messages(pairs, frame):
            self.pairs.publish(message)

    def send(self, pairs, frame='1000'):
        """Publish pairs and wait until they have been judged."""
        self.publish(pairs, frame)
        self.ros.spin_until(lambda: judge_of(self.node).newest_ns == pairs.stamp_ns[-1])

    def kill(self):
        """Kill the node once the pairs that it took are a second old."""
        began_s = time.monotonic()
        self.ros.spin_until(lambda: time.monotonic() > began_s + 0.5)
        kill(self.ros, self.node, self.node.journal)
        self.ros.spin_until(lambda: not self.pairs.get_subscription_count()
                            and not self.ledger.get_subscription_count())


@pytest.mark.parametrize('every_h', [None, 0.25])
def test_a_node_that_was_killed_goes_on_and_misses_nothing(ros, rng, tmp_path, every_h):
    """Before, the report covered only what came after the last start: 1950 of 3000 pairs."""
    pairs, values = some_pairs(rng, 0, 3000), {'runs__every_h': every_h} if every_h else {}
    trial = Killed(ros, tmp_path, **values)
    for lo in range(0, 3000, 1000):
        trial.send(pairs[lo:lo + 900])
        trial.ledger.publish(ledger_of(lo + 900))
        trial.kill()
        trial.publish(pairs[lo + 900:lo + 950])
        trial.start()
        trial.send(pairs[lo + 950:lo + 1000])
    trial.ledger.publish(ledger_of(3000, final=True))
    ros.end(trial.node)
    report = json.loads(json.dumps(trial.node.verdict.to_dict()))
    expected = pipeline.Compliance(Settings.from_mapping(
        {**NORMS, **{k.replace('__', '.'): v for k, v in values.items()}}), source='live')
    expected.update(pairs)
    expected.finish()
    for run, other in zip(report['runs'], expected.verdict().to_dict()['runs'], strict=True):
        assert without_ledger(run) == without_ledger(json.loads(json.dumps(other)))
    assert report['ledger_problems'] == []
    assert sum(run['pairing']['paired'] for run in report['runs']) == 3000
    assert not [path for path in tmp_path.iterdir() if 'journal' in path.name]


def test_a_mark_survives_a_kill_at_once(ros, rng, tmp_path):
    """It was lost if the node was killed within a quarter of a second of its answer."""
    pairs = some_pairs(rng, 0, 2000)
    trial = Killed(ros, tmp_path)
    trial.send(pairs[:1000])
    assert trial.node._command('start', 'J. Smith').startswith('start after')
    kill(ros, trial.node, trial.node.journal)
    trial.start()
    trial.send(pairs[1000:])
    trial.ledger.publish(ledger_of(2000, final=True))
    ros.end(trial.node)
    assert [run['n'] for run in trial.node.verdict.to_dict()['runs']] == [1000]


def test_pairs_that_nobody_can_send_again_are_counted(ros, rng, tmp_path):
    """6000 pairs come while the node is down; the synchronizer keeps 5000 of them."""
    pairs, trial = some_pairs(rng, 0, 7000), Killed(ros, tmp_path)
    trial.send(pairs[:500])
    trial.kill()
    trial.publish(pairs[500:6500])
    trial.start()
    # Within one process the middleware never sends again what a full subscription has refused.
    ros.spin_until(lambda: judge_of(trial.node).newest_ns == pairs.stamp_ns[6499])
    trial.send(pairs[6500:])
    trial.ledger.publish(ledger_of(7000, final=True))
    ros.end(trial.node)
    report = trial.node.verdict.to_dict()
    n = sum(run['n_input'] for run in report['runs'])
    assert 6000 - 5000 <= 7000 - n < 6000
    assert report['ledger_problems'] == [
        f'{7000 - n} pairs were published while this node was down']


def test_marks_hold_after_the_node_was_killed(ros, rng, tmp_path):
    """The marks come back from their publisher or the journal, and count once."""
    pairs, trial = some_pairs(rng, 0, 1000), Killed(ros, tmp_path)
    graph = Graph.__new__(Graph)
    graph.ros, graph.node = ros, trial.node
    trial.send(pairs[:100])
    graph.call('start_run')
    trial.send(pairs[100:400])
    trial.kill()
    trial.start()
    graph.node = trial.node
    trial.send(pairs[400:500])
    graph.call('stop_run')
    trial.send(pairs[500:600])
    trial.kill()
    trial.start()
    trial.send(pairs[600:])
    trial.ledger.publish(ledger_of(1000, final=True))
    ros.end(trial.node)
    run, = trial.node.verdict.to_dict()['runs']
    assert (run['start_ns'], run['end_ns']) == (pairs.stamp_ns[100], pairs.stamp_ns[499])


def test_a_journal_of_another_trial_is_named_and_set_aside(ros, rng, tmp_path):
    trial = Killed(ros, tmp_path)
    shown = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    trial.send(some_pairs(rng, 0, 100))
    trial.kill()
    trial.values['norms__sigma_max_deg'] = 0.3
    node = ros.ours(Compliance, **trial.values)
    assert judge_of(node).newest_ns is None
    ros.spin_until(lambda: any('other settings: norms.sigma_max_deg; it is kept as' in s.message
                               for m in shown for s in m.status))
    aside = tmp_path / 'compliance.journal.1'
    assert any(s.message.endswith(f'heading-intercompare analyze {aside}')
               for m in shown for s in m.status)
    settings = settings_for(load_config_or_journal(None, [str(aside)]))
    assert settings.norms.sigma_max_deg == 0.2
    assert judge_bags([aside], settings).verdict.runs[0].n == 100


@pytest.mark.parametrize('every_h', [None, 0.25])
def test_the_journal_gives_the_verdict_of_its_node(ros, rng, tmp_path, every_h):
    """`analyze` reads it while the node runs, and the node then reports the same figures."""
    trial = Killed(ros, tmp_path, **({'runs__every_h': every_h} if every_h else {}))
    path = tmp_path / 'compliance.journal'
    for lo in range(0, 2000, 500):
        trial.send(some_pairs(rng, lo, lo + 500))
    trial.ledger.publish(ledger_of(2000, final=True))

    def judge():
        settings = settings_for(load_config_or_journal(None, [str(path)]))
        return judge_bags([path], settings).verdict
    ros.spin_until(lambda: trial.node._heard.covers(2000))
    # The journal is written with the next batch of pairs.
    ros.spin_until(lambda: trial.node._drain() or 'ledger' not in str(judge().ledger_problems))
    judged = plain(judge())
    ros.end(trial.node)
    assert judged == plain(trial.node.verdict)
    assert not path.exists()


def test_a_journal_that_cannot_be_opened_is_a_warning_and_the_trial_goes_on(ros, rng, tmp_path):
    shown = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    (tmp_path / 'compliance.journal').mkdir()
    trial = Killed(ros, tmp_path)
    trial.send(some_pairs(rng, 0, 300))
    ros.spin_until(lambda: any('is not kept: ' in s.message and 'compliance.journal' in s.message
                               for m in shown for s in m.status))
    ros.end(trial.node)
    assert trial.node.verdict.runs[0].n == 300


def test_an_intermediate_report_says_what_a_stop_now_would_give_and_changes_nothing(
        ros, rng, tmp_path):
    pairs, book = some_pairs(rng, 0, 900), tmp_path / 'book.sqlite'
    graph = Graph(ros, report_dir=str(tmp_path), logbook=str(book))
    between = ros.listen(String, 'compliance/intermediate_report', qos.REPORT)
    assert graph.call('report').message == 'no pair has come yet'
    graph.send(pairs[:400])
    graph.book({'paired': 400, 'ts_paired': 400, 'rs_used': 400})
    said = graph.call('report')
    assert said.success and said.message.startswith('INTERMEDIATE, what a stop now would give')
    ros.spin_until(lambda: between)
    found, expected = json.loads(between[0].data), offline(pairs[:400])
    assert found['intermediate'] is True and found['outcome'] == expected['outcome']
    assert without_ledger(found['runs'][0]) == without_ledger(expected['runs'][0])
    assert [json.loads(p.read_text('utf-8')) for p in tmp_path.glob('intermediate_*.json')] == [
        found]
    assert not book.exists() and not graph.reports() and not list(tmp_path.glob('verdict_*'))
    graph.send(pairs[400:])
    graph.book({'paired': 900, 'ts_paired': 900, 'rs_used': 900}, final=True)
    report, whole = graph.end(), offline(pairs)
    assert 'intermediate' not in report
    assert without_ledger(report['runs'][0]) == without_ledger(whole['runs'][0])
    assert len(Logbook(str(book)).read()) == 1


def test_intermediate_reports_come_by_the_stamps(ros, rng):
    graph = Graph(ros, report_every_h=0.1)
    between = ros.listen(String, 'compliance/intermediate_report', qos.REPORT)
    for lo in range(0, 1200, 60):
        graph.send(some_pairs(rng, lo, lo + 60))
    ros.spin_until(lambda: len(between) == 3)
    ends = [json.loads(m.data)['runs'][0]['end_ns'] for m in between]
    assert [round((end - T0_NS) / S_NS) for end in ends] == [419, 779, 1139]


def test_stretches_taken_out_by_hand_are_left_out_live_as_offline(ros, rng):
    out = {'exclusions': f'{T0_NS + 100 * S_NS}, {T0_NS + 160 * S_NS}, tug alongside'}
    graph, pairs = Graph(ros, **out), some_pairs(rng, 0, 900)
    graph.send(pairs)
    graph.book({'paired': 900, 'ts_paired': 900, 'rs_used': 900}, final=True)
    report, expected = graph.end(), offline(pairs, **out)
    run, = report['runs']
    assert run['n'] == 840 and run['taken_out']['stretches'][0]['reason'] == 'tug alongside'
    assert report['taken_out']['as_recorded']['n'] == 900
    assert report['taken_out'] == expected['taken_out']
    for key in ('n', 'std_deg', 'headline', 'taken_out'):
        assert run[key] == expected['runs'][0][key], key


def test_displays_get_the_newest_figures_as_numbers(ros, rng):
    """Lichtblick, PlotJuggler and rqt_plot plot std_msgs/Float64; the seam of 360 is no jump."""
    graph = Graph(ros, scalars_hz=1000.0, installation_offset_deg=2.0)
    heard = {topic: ros.listen(Float64, topic, qos.STATUS) for topic in SCALARS}
    ros.spin_until(lambda: graph.node.count_subscribers('scalar/lag_s') == 1)
    stamps = T0_NS + np.arange(300) * S_NS
    graph.send(Pairs.of(stamps, np.full(300, 361.5), np.full(300, 359.0),
                        lag_ns=np.full(300, 20_000_000)))

    def newest():
        return {topic.removeprefix('scalar/'): got[-1].data for topic, got in heard.items() if got}
    more = iter(range(300, 3000))
    ros.spin_until(lambda: graph.send(Pairs.of([T0_NS + next(more) * S_NS], [361.5], [359.0],
                                               lag_ns=[20_000_000]))
                   or len(newest()) == len(SCALARS)
                   and 'limit_deg2' in values(graph.heard['rolling'][-1]))
    assert newest() == pytest.approx({
        'ts_heading_deg': 1.5, 'rs_heading_deg': 359.0, 'difference_deg': 0.5, 'lag_s': 0.02,
        'mean_deg': 0.5, 'std_deg': 0.0, 'std_limit_deg': np.sqrt(
            float(values(graph.heard['rolling'][-1])['limit_deg2']))}, abs=1e-9)


def test_the_numbers_for_displays_can_be_switched_off(ros):
    graph = Graph(ros, scalars_hz=0.0)
    topics = [name for name, _ in graph.node.get_topic_names_and_types()]
    assert not any(name.startswith('/scalar') for name in topics)
