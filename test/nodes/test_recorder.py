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

"""The node that writes bags."""

from __future__ import annotations

import json
import shutil
import time
from types import SimpleNamespace

from deadlines import Stopwatch
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import QuaternionStamped, TwistStamped
from nodes.rclpy_objects import heading_messages, headings_from, marker_message
from nodes.ros_nodes import EITHER_EXECUTOR, NORMS
import pytest
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import Imu
from std_msgs.msg import String

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.chunk_writer import ChunkWriter
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.provenance import read_notes
from heading_intercompare.bags.rosbag2.publisher_starts import read_starts
from heading_intercompare.cli import main
from heading_intercompare.core.pairing.incarnations import StreamNumbers
from heading_intercompare.core.pairing.ledger import Ledger, LedgerSegment
from heading_intercompare.core.pairing.names import Span
from heading_intercompare.core.records import Headings
from heading_intercompare.core.version import VERSION
from heading_intercompare.messages.ledger_messages import encode_ledger
from heading_intercompare.messages.status_messages import (
    decode_statuses,
    encode_statuses,
    ERROR,
    OK,
    Status,
    WARN,
)
from heading_intercompare.nodes import recorder
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.interface.parameters import make_overrides
from heading_intercompare.nodes.recorder import Recorder
from heading_intercompare.nodes.taking import recorded_topics

REPORT = json.dumps({'runs': [{'start_ns': 5, 'end_ns': 9}]})


def some_headings(n):
    """Return messages stamped 1 to n seconds."""
    return heading_messages(Headings.as_sent([i * 10 ** 9 for i in range(1, n + 1)],
                                        [i / 10 for i in range(n)]), 'gyro')


def sensor_of(ros, topic='ts/heading', kind=Imu):
    """Return a publisher that the recorder listens to."""
    sensor = ros.plain.create_publisher(kind, topic, qos.HEADINGS_OUT)
    ros.spin_until(lambda: sensor.get_subscription_count() == 1)
    return sensor


def of_bag(states):
    """Return the states of the bag on /diagnostics."""
    return [s for m in states for s in m.status if s.name == 'recorder: bag']


def figures(state):
    """Return the figures of a state."""
    return {value.key: value.value for value in state.values}


def recorder_of(ros, tmp_path, **values):
    """Return a recorder that leaves out the diagnostics, unless it is asked for them."""
    return ros.ours(Recorder, output=str(tmp_path / 'bag'),
                    **{'diagnostics_period_s': 0.0, **values})


def finish(ros, node, *publishers):
    """Let the publishers go, then end the recorder; return the bag."""
    for publisher in publishers:
        ros.plain.destroy_publisher(publisher)
    ros.end(node)
    return BagReader(node.path)


@EITHER_EXECUTOR
def test_headings_are_written_as_they_were_sent(ros, tmp_path):
    node = recorder_of(ros, tmp_path)
    sensor, sent = sensor_of(ros), some_headings(300)
    for message in sent:
        sensor.publish(message)
    ros.spin_until(lambda: node.written == 300)
    bag = finish(ros, node, sensor)
    assert bag.incomplete is None
    stored = list(bag.messages(['/ts/heading']))
    assert [m.sequence for m in stored] == list(range(1, 301))
    assert all(m.publish_time_ns <= m.log_time_ns for m in stored)
    chunk, = bag.headings({'ts/heading': 'enu'})
    assert chunk['ts/heading'] == headings_from(sent, 'enu')


def test_a_type_that_is_accepted_is_recorded_as_it_is(ros, tmp_path):
    node = recorder_of(ros, tmp_path)
    sensor = sensor_of(ros, 'rs/heading', QuaternionStamped)
    sensor.publish(QuaternionStamped())
    ros.spin_until(lambda: node.written == 1)
    bag = finish(ros, node, sensor)
    assert bag.topics['/rs/heading'].type_name == 'geometry_msgs/msg/QuaternionStamped'


def test_what_comes_of_the_comparison_is_written_too(ros, tmp_path):
    node = recorder_of(ros, tmp_path)
    made = [(ros.plain.create_publisher(kind, topic, profile), message)
            for kind, topic, profile, message in (
                (DiagnosticArray, 'pairs/ledger', qos.LEDGER, DiagnosticArray()),
                (DiagnosticArray, 'compliance/marker', qos.MARKER, marker_message('start', 7)),
                (DiagnosticArray, 'compliance/verdict', qos.STATE, DiagnosticArray()),
                (String, 'compliance/report', qos.REPORT, String(data=REPORT)))]
    for publisher, message in made:
        ros.spin_until(lambda p=publisher: p.get_subscription_count() == 1)
        publisher.publish(message)
    ros.spin_until(lambda: node.written == 4)
    bag = finish(ros, node, *(publisher for publisher, _ in made))
    assert {name: info.count for name, info in bag.topics.items()} == {
        '/pairs/ledger': 1, '/compliance/marker': 1, '/compliance/verdict': 1,
        '/compliance/report': 1}
    # A publisher of a state keeps its newest message alone: what replaces another is no loss.
    assert [message.sequence for message in bag.messages(['/compliance/verdict'])] == [0]
    attached = {a.name: a.data.decode() for a in bag.attachments()}
    assert attached == {'report.json': REPORT, 'runs.csv': 'start,stop\n5,10\n'}


def test_a_report_that_is_none_does_not_keep_the_bag_from_being_closed(ros, tmp_path):
    node = recorder_of(ros, tmp_path)
    report = ros.plain.create_publisher(String, 'compliance/report', qos.REPORT)
    report.publish(String(data='none'))
    ros.spin_until(lambda: node.written == 1)
    bag = finish(ros, node, report)
    assert bag.incomplete is None
    assert {a.name: a.data for a in bag.attachments()} == {'report.json': b'none'}


def test_notes_given_at_the_start_and_while_recording_are_in_the_bag(ros, tmp_path):
    node = recorder_of(ros, tmp_path, note='MV Example\n2014-08-01T00:05:00Z left port')
    before_ns = time.time_ns()
    notes = ros.plain.create_publisher(String, 'operator/note', qos.NOTE)
    ros.spin_until(lambda: notes.get_subscription_count() == 1)
    notes.publish(String(data='course change'))
    ros.spin_until(lambda: node.written == 1)
    # Its publisher goes on, and is not waited for.
    watch = Stopwatch()
    bag = finish(ros, node)
    assert watch.passed_s < 5.9
    early, ship, turn = read_notes(bag)
    assert early == (1406851500 * 10 ** 9, 'left port')
    assert ship.text == 'MV Example' and ship.stamp_ns < before_ns
    message, = bag.messages(['operator/note'])
    assert turn == (message.log_time_ns, 'course change') and turn.stamp_ns >= before_ns


def test_what_is_cut_of_notes_and_parts_is_counted_in_the_diagnostics(ros, tmp_path):
    node = recorder_of(ros, tmp_path, diagnostics_period_s=10.0)
    states = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    notes = ros.plain.create_publisher(String, 'operator/note', qos.NOTE)
    parts = ros.plain.create_publisher(DiagnosticArray, '/diagnostics', qos.STATUS)
    ros.spin_until(lambda: notes.get_subscription_count() == 1
                   and parts.get_subscription_count() == 3)
    notes.publish(String(data='x' * 10_001 + '\ncalm sea'))
    parts.publish(DiagnosticArray(status=[DiagnosticStatus(name='n' * 501)]))

    def shown():
        of_bags = of_bag(states)
        found = figures(of_bags[-1]) if of_bags else {}
        return [found.get(name) for name in ('notes_cut', 'notes_left_out', 'parts_cut')]
    ros.spin_until(lambda: shown() == ['1', '0', '1'])
    assert len(read_notes(finish(ros, node, notes, parts))) == 2


def test_a_note_that_is_no_text_is_recorded_and_does_no_harm(ros, tmp_path):
    node = recorder_of(ros, tmp_path)
    notes = ros.plain.create_publisher(String, 'operator/note', qos.NOTE)
    ros.spin_until(lambda: notes.get_subscription_count() == 1)
    data = serialize_message(String(data='wind XX'))
    notes.publish(data.replace(b'XX', b'\xff\xfe'))
    ros.spin_until(lambda: node.written == 1)
    note, = read_notes(finish(ros, node, notes))
    assert note.text == 'wind \ufffd\ufffd'


def test_the_true_heading_is_recorded_and_nothing_is_wrong_without_it(ros, tmp_path):
    node = recorder_of(ros, tmp_path, first_wait_s=0.0)
    states = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    ros.spin_until(lambda: any('operator/note' in s.name for m in states for s in m.status))
    levels = {s.name.partition(': ')[2]: s.level[0] for m in states for s in m.status}
    assert levels['operator/note'] == levels['truth/heading'] == OK
    assert levels['ts/heading'] == WARN
    truth = sensor_of(ros, 'truth/heading')
    truth.publish(some_headings(1)[0])
    ros.spin_until(lambda: node.written == 1)
    bag = finish(ros, node, truth)
    assert bag.topics['/truth/heading'].count == 1
    losses = bag.metadata()['recording']
    assert losses['received./truth/heading'] == '1'
    assert 'received./operator/note' not in losses


def test_a_sensor_on_the_topic_of_the_truth_is_recorded_once(ros, tmp_path):
    node = recorder_of(ros, tmp_path, rs_topic='/truth/heading')
    sensor = sensor_of(ros, 'truth/heading')
    sensor.publish(some_headings(1)[0])
    ros.spin_until(lambda: node.written == 1)
    assert finish(ros, node, sensor).topics['/truth/heading'].count == 1


def test_a_copy_of_the_parameter_file_is_kept(ros, tmp_path):
    (tmp_path / 'mine.yaml').write_text('# MV Example, gyro 4711\n')
    node = recorder_of(ros, tmp_path, parameter_file=str(tmp_path / 'mine.yaml'))
    kept, = finish(ros, node).attachments()
    assert (kept.name, kept.data) == ('mine.yaml', b'# MV Example, gyro 4711\n')


def test_a_parameter_file_that_is_not_there_is_a_mistake_and_leaves_no_bag(ros, tmp_path):
    with pytest.raises(FileNotFoundError, match='nowhere.yaml'):
        recorder_of(ros, tmp_path, parameter_file=str(tmp_path / 'nowhere.yaml'))
    assert not (tmp_path / 'bag').exists()


def test_sources_are_stated_in_the_bag(ros, tmp_path):
    node = recorder_of(ros, tmp_path)
    node.state_sources({'ts_driver': {'source': 'udp://:10110', 'talker': None}})
    stated = finish(ros, node).metadata()['heading_intercompare']
    assert stated['source.ts_driver.source'] == 'udp://:10110'
    assert stated['version'] == VERSION and 'source.ts_driver.talker' not in stated


def test_settings_and_version_are_in_the_bag(ros, tmp_path):
    node = recorder_of(ros, tmp_path, variant='C')
    stated = finish(ros, node).metadata()['heading_intercompare']
    assert stated['version'] == VERSION
    assert stated['settings.variant'] == 'C'
    assert stated['settings.norms.sigma_max_deg'] == '0.2'


def test_the_namespace_of_the_graph_is_in_the_bag(ros, tmp_path):
    """Without it the settings of the graph do not name the topics of its bag."""
    node = ros.add(Recorder, cli_args=['--ros-args', '-r', '__ns:=/ship1'],
                   parameter_overrides=make_overrides({**NORMS, 'output': str(tmp_path / 'bag')}))
    sensor = sensor_of(ros, '/ship1/ts/heading')
    sensor.publish(some_headings(1)[0])
    ros.spin_until(lambda: node.written == 1)
    bag = finish(ros, node, sensor)
    assert bag.metadata()['heading_intercompare']['namespace'] == bag.namespace == '/ship1'
    assert bag.resolve('ts/heading') == '/ship1/ts/heading'
    root = finish(ros, recorder_of(ros, tmp_path / 'root'))
    assert 'namespace' not in root.metadata()['heading_intercompare'] and root.namespace == ''


def test_after_a_second_what_came_is_on_the_disk(ros, tmp_path):
    """The test reads the files as a killed process would leave them."""
    node = recorder_of(ros, tmp_path)
    sensor, sent = sensor_of(ros), some_headings(50)
    for message in sent:
        sensor.publish(message)
    ros.spin_until(lambda: node.written == 50)

    def on_disk():
        info = BagReader(node.path).topics.get('/ts/heading')
        return info.count if info else 0
    ros.spin_until(lambda: on_disk() == 50)
    assert BagReader(node.path).incomplete


def kill_recorder(ros, node):
    """End a recorder as by `kill -9`: its bag is cut off."""
    ros.executor.remove_node(node)
    ros.nodes.remove(node)
    node.ended = True
    node.destroy_node()


@pytest.mark.parametrize('n_written', [20, 0])
def test_the_next_recorder_takes_what_the_publishers_still_hold(ros, tmp_path, n_written):
    """Also where the one before was killed before it had written a heading."""
    node = recorder_of(ros, tmp_path, go_on=True)
    sensor, messages = sensor_of(ros), some_headings(60)
    marker = ros.plain.create_publisher(DiagnosticArray, 'compliance/marker', qos.MARKER)
    for message in messages[:n_written]:
        sensor.publish(message)
    if n_written:
        marker.publish(marker_message('start', 7))
        ros.spin_until(lambda: node.written == n_written + 1
                       and count_on_disk(node.path) == n_written)
    kill_recorder(ros, node)
    for message in messages[n_written:50]:
        sensor.publish(message)
    node = recorder_of(ros, tmp_path, go_on=True)
    ros.spin_until(lambda: node.written == 50 - n_written)
    for message in messages[50:]:
        sensor.publish(message)
    ros.spin_until(lambda: node.written == 60 - n_written)
    bag = finish(ros, node, sensor)
    assert bag.path.name == 'bag_2'
    assert bag.metadata()['heading_intercompare']['continues'] == 'bag'
    assert [message.sequence for message in bag.messages(['/ts/heading'])] == [
        *range(n_written + 1, 61)]
    # The mark is in the first bag.
    assert '/compliance/marker' not in bag.topics
    counts = bag.metadata()['recording']
    assert counts['received./ts/heading'] == str(60 - n_written)
    assert counts['lost_on_the_way./ts/heading'] == counts['missed_at_first./ts/heading'] == '0'
    starts = [read_starts(BagReader(tmp_path / name))['/ts/heading']
              for name in ('bag', 'bag_2')[not n_written:]]
    assert len({start.publisher for of_bag in starts for start in of_bag}) == 1


def count_on_disk(path):
    """Return how many headings of the TS a killed recorder would leave."""
    info = BagReader(path).topics.get('/ts/heading')
    return info.count if info else 0


@EITHER_EXECUTOR
def test_the_end_waits_for_the_last_verdict(ros, tmp_path):
    node = recorder_of(ros, tmp_path)
    report = ros.plain.create_publisher(String, 'compliance/report', qos.REPORT)
    ros.spin_until(lambda: report.get_subscription_count() == 1)
    node.end()
    ros.spin_until(lambda: ros.executor.spin_once(0.5) is None)
    assert not node.ended
    report.publish(String(data=REPORT))
    assert report.wait_for_all_acked()
    bag = finish(ros, node, report)
    assert bag.topics['/compliance/report'].count == 1


@pytest.mark.parametrize('publishers, readings', [(1, False), (0, True)])
def test_the_end_waits_for_publishers_and_for_readings_until_its_time_is_up(
        ros, tmp_path, monkeypatch, publishers, readings):
    """A publisher of verdicts, or readings whose verdict is missing: then 0.3 s more."""
    clock = SimpleNamespace(now_s=100.0)
    monkeypatch.setattr(recorder, 'time', SimpleNamespace(
        monotonic=lambda: clock.now_s, time_ns=time.time_ns))

    def begin(name):
        node = recorder_of(ros, tmp_path / name, end_wait_s=8.0)
        awaited = SimpleNamespace(publishers=publishers, readings=readings)
        monkeypatch.setattr(node, 'count_publishers', lambda topic: awaited.publishers)
        monkeypatch.setattr(node._judged, 'may_come', lambda: awaited.readings)
        clock.now_s = 100.0
        node.end()
        return node, awaited

    def is_closed(node, now_s):
        clock.now_s = now_s
        node._close_if_quiet(node._end_s)
        return node.ended

    node, awaited = begin('until_quiet')
    assert not is_closed(node, 100.1) and not is_closed(node, 101.0)
    awaited.publishers, awaited.readings = 0, False
    assert not is_closed(node, 101.2) and is_closed(node, 101.31)
    node, _ = begin('until_the_end')
    assert not is_closed(node, 107.9) and is_closed(node, 108.0)


def test_headings_that_the_synchronizer_had_but_the_recorder_missed_at_the_end_are_counted(
        ros, tmp_path, capfd):
    """A recorder that was stopped for longer than DDS waits for it: the last ones never come."""
    node = recorder_of(ros, tmp_path)
    ledgers = ros.plain.create_publisher(DiagnosticArray, 'pairs/ledger', qos.LEDGER)
    sensors = [sensor_of(ros, f'{name}/heading') for name in ('ts', 'rs')]
    ros.spin_until(lambda: ledgers.get_subscription_count() == 1)
    for message in some_headings(20):
        for sensor in sensors:
            sensor.publish(message)
    # Of the 46, 3 were rejected by the driver and not published; 4 more were lost on the way.
    counts = {'ts_unpaired': 46, 'ts_rejected.burst': 3, 'ts_lost.on_the_way': 4, 'rs_unused': 18}
    ledgers.publish(deserialize_message(encode_ledger(
        Ledger.from_segments([LedgerSegment(None, counts)]), True, 7,
        {stream: StreamNumbers('', 1, '', last, (Span('', 1, last),))
         for stream, last in (('ts', 50), ('rs', 18))}), DiagnosticArray))
    ros.spin_until(lambda: node.written == 41)
    bag = finish(ros, node, ledgers, *sensors)
    said = bag.metadata()['recording']
    assert (said['received./ts/heading'], said['lost_on_the_way./ts/heading']) == ('20', '30')
    assert (said['received./rs/heading'], said['lost_on_the_way./rs/heading']) == ('20', '0')
    assert 'bag: 30 messages lost on the way' in capfd.readouterr().err


def test_headings_that_the_synchronizer_had_before_the_recorder_are_counted(ros, tmp_path):
    """A sensor that publishes already: before, the bag said that nothing was lost."""
    ledgers = ros.plain.create_publisher(DiagnosticArray, 'pairs/ledger', qos.LEDGER)
    sensor = ros.plain.create_publisher(Imu, 'ts/heading', QoSProfile(depth=100))
    for message in some_headings(10):
        sensor.publish(message)
    node = recorder_of(ros, tmp_path)
    ros.spin_until(lambda: ledgers.get_subscription_count() == 1)
    ros.spin_until(lambda: sensor.get_subscription_count() == 1)
    for message in some_headings(30)[10:]:
        sensor.publish(message)
    ledgers.publish(deserialize_message(encode_ledger(Ledger.from_segments([]), True, 7, {
        'ts': StreamNumbers('', 4, '', 30, (Span('', 4, 30),)),
        'rs': StreamNumbers('', 0, '', 0)}),
        DiagnosticArray))
    ros.spin_until(lambda: node.written == 21)
    said = finish(ros, node, ledgers, sensor).metadata()['recording']
    assert said['missed_at_first./ts/heading'] == '7'
    assert said['lost_on_the_way./ts/heading'] == '0'


def test_pairs_are_heard_only_once_the_headings_are(ros, tmp_path, monkeypatch):
    """The synchronizer begins when they are; before, it began up to a second earlier."""
    monkeypatch.setattr(recorded_topics, 'is_alone', lambda: False)
    monkeypatch.setattr(recorded_topics, '_KNOWN_S', 3600.0)
    pairs = ros.plain.create_publisher(TwistStamped, 'pairs', qos.PAIRS)
    sensors = [ros.plain.create_publisher(Imu, f'{name}/heading', qos.HEADINGS_OUT)
               for name in ('ts', 'rs')]
    node = recorder_of(ros, tmp_path)
    ros.spin_until(lambda: all(one.get_subscription_count() for one in sensors))
    sensors[0].publish(some_headings(1)[0])
    ros.spin_until(lambda: node._topics['ts/heading'].intake.received)
    assert pairs.get_subscription_count() == 0
    sensors[1].publish(some_headings(1)[0])
    ros.spin_until(pairs.get_subscription_count)


def test_headings_from_before_and_after_the_verdict_are_not_in_the_bag(ros, tmp_path):
    """Sensors of other packages begin before the graph, and go on when it has ended."""
    node = recorder_of(ros, tmp_path)
    ledgers = ros.plain.create_publisher(DiagnosticArray, 'pairs/ledger', qos.LEDGER)
    sensor = sensor_of(ros)
    ros.spin_until(lambda: ledgers.get_subscription_count() == 1)

    def tell(final, last):
        ledgers.publish(deserialize_message(encode_ledger(Ledger.from_segments([]), final, 7, {
            'ts': StreamNumbers('', 5, '', last), 'rs': StreamNumbers('', 0, '', 0)}),
            DiagnosticArray))

    messages = some_headings(30)
    for message in messages[:10]:
        sensor.publish(message)
    ros.spin_until(lambda: node._topics['ts/heading'].intake.received == 10)
    assert node.written == 0
    tell(False, 10)
    ros.spin_until(lambda: node.written == 7)
    node.health.mute()
    for message in messages[10:]:
        sensor.publish(message)
    ros.spin_until(lambda: node._topics['ts/heading'].intake.received == 30)
    tell(True, 22)
    ros.spin_until(lambda: node.written == 8)
    bag = finish(ros, node, ledgers)
    assert sensor.get_subscription_count() == 0, 'it still is there'
    chunks = list(bag.headings({'ts/heading': 'enu'}))
    stamps = Headings.concatenate(c['ts/heading'] for c in chunks).stamp_ns
    assert (stamps // 10 ** 9).tolist() == [*range(5, 23)]
    assert bag.metadata()['recording']['received./ts/heading'] == '18'
    assert bag.incomplete is None


def test_a_disk_that_fails_is_an_error_and_nothing_is_lost_when_it_works_again(
        ros, tmp_path, monkeypatch):
    node = recorder_of(ros, tmp_path)
    states = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    sensor = sensor_of(ros)

    def fail(bag, now_s):
        raise OSError(28, 'No space left on device', 'bag_0.mcap')
    with monkeypatch.context() as patch:
        patch.setattr(BagWriter, 'flush_if_due', fail)
        for message in some_headings(20):
            sensor.publish(message)
        ros.spin_until(lambda: any('No space left on device' in s.message
                                   for m in states for s in m.status))
    ros.spin_until(lambda: node.written == 20)
    ros.spin_until(lambda: of_bag(states)[-1].level[0] == WARN)
    assert of_bag(states)[-1].message == 'recording again after 1 fault'
    bag = finish(ros, node, sensor)
    assert bag.topics['/ts/heading'].count == 20
    losses = bag.metadata()['recording']
    assert (losses['faults'], losses['received./ts/heading']) == ('1', '20')
    assert losses['lost_on_the_way./ts/heading'] == losses['not_written./ts/heading'] == '0'


def test_what_waits_at_the_end_and_cannot_be_written_is_in_the_bag_as_not_written(
        ros, tmp_path, monkeypatch, capfd):
    node = recorder_of(ros, tmp_path)
    states = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    sensor = sensor_of(ros)
    end_chunk = ChunkWriter.end_chunk

    def fail(writer):
        if writer.pending:
            raise OSError(28, 'No space left on device', 'bag_0.mcap')
        end_chunk(writer)
    monkeypatch.setattr(ChunkWriter, 'end_chunk', fail)
    for message in some_headings(20):
        sensor.publish(message)
    ros.spin_until(lambda: of_bag(states)[-1:] and figures(of_bag(states)[-1])['waiting'] == '20')
    losses = finish(ros, node, sensor).metadata()['recording']
    assert 'bag: 20 messages received but not written' in capfd.readouterr().err
    assert losses['received./ts/heading'] == losses['not_written./ts/heading'] == '20'


def test_a_folder_that_is_removed_is_an_error_at_once_and_recording_goes_on(
        ros, tmp_path, capfd):
    node = recorder_of(ros, tmp_path)
    states = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    sensor, sent = sensor_of(ros), some_headings(20)
    for message in sent[:10]:
        sensor.publish(message)
    ros.spin_until(lambda: node.written == 10)
    # At once, for something may be written into it meanwhile.
    shutil.rmtree((tmp_path / 'bag').rename(tmp_path / 'removed'))
    ros.spin_until(lambda: any(s.level[0] == ERROR and 'No such file' in s.message
                               for m in states for s in m.status))
    for message in sent[10:]:
        sensor.publish(message)
    ros.spin_until(lambda: node.written == 20)
    ros.spin_until(lambda: figures(of_bag(states)[-1])['messages'] == '20')
    bag = finish(ros, node, sensor)
    kept = [m.sequence for m in bag.messages(['/ts/heading'])]
    assert kept[-10:] == list(range(11, 21))
    said = f'{20 - len(kept)} messages in files that were removed or moved'
    # When it goes on, and at the end; before, too, if they are missed before the next write fails.
    assert capfd.readouterr().err.count(said) in (2, 3)
    state = of_bag(states)[-1]
    assert (state.level[0], state.message) == (WARN, f'recording again after 1 fault; {said}')
    assert figures(state)['messages'] == '20'
    losses = bag.metadata()['recording']
    assert losses['absent'] == str(20 - len(kept)) and losses['faults'] == '1'


def test_a_bag_is_never_overwritten(ros, tmp_path):
    with pytest.raises(BagError, match='already exists'):
        ros.ours(Recorder, output=str(tmp_path))


def test_the_recorded_message_is_the_one_that_was_published(ros, tmp_path):
    node = recorder_of(ros, tmp_path)
    marker = ros.plain.create_publisher(DiagnosticArray, 'compliance/marker', qos.MARKER)
    message = marker_message('stop', 123_456_789_000)
    marker.publish(message)
    ros.spin_until(lambda: node.written == 1)
    stored, = finish(ros, node, marker).messages()
    assert len(stored.data) == len(serialize_message(message))
    from heading_intercompare.messages.cdr import decode
    assert decode(stored.type_name, stored.data)['status'][0]['message'] == 'stop'


def test_the_diagnostics_are_in_the_bag_kept_small_with_the_last_state_of_each_part(
        ros, tmp_path, capsys):
    """A state once a second, which changes once: of more than twenty messages, two."""
    node = recorder_of(ros, tmp_path, diagnostics_period_s=3600.0)
    driver = ros.plain.create_publisher(DiagnosticArray, '/diagnostics', qos.STATUS)
    ros.spin_until(lambda: driver.get_subscription_count() == 2)

    def say(level, dropped):
        driver.publish(deserialize_message(encode_statuses(0, [
            Status('ts_driver: source', level, 'listening', {'kernel_dropped': dropped})]),
            DiagnosticArray))
    for n in range(21):
        say(WARN if n == 20 else OK, n)
    ros.spin_until(lambda: 'WARN' in node._states.record().get('ts_driver: source', ''))
    bag = finish(ros, node, driver)
    said = [values for message in bag.messages(['/diagnostics'])
            for status in decode_statuses(message.data)[1]
            if status.name == 'ts_driver: source' for values in [status.values]]
    assert said[0] == {'kernel_dropped': '0'} and said[-1] == {'kernel_dropped': '20'}
    # The recorder speaks too, on messages of its own.
    assert len(said) == 2
    assert {message.sequence for message in bag.messages(['/diagnostics'])} == {0}
    assert not any('diagnostics' in key for key in bag.metadata()['recording'])
    assert main(['info', node.path]) == 0
    printed = capsys.readouterr().out
    assert 'last state of each part:' in printed
    line, = [line for line in printed.splitlines() if line.startswith('  ts_driver: source ')]
    assert 'WARN' in line and line.endswith('listening')
