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

"""Headings from sentences, and from a field of any messages, live and from the bag of the same."""

from __future__ import annotations

from importlib import import_module
import os
import sys
import time
from types import SimpleNamespace

from checksums import with_checksum
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Pose, PoseStamped, TransformStamped
from nodes.graph_checks import assert_same
from nodes.message_packages import make_package, SENTENCE as SENTENCE_FIELDS
from nodes.rclpy_objects import heading_messages
from nodes.ros_nodes import NORMS
import numpy as np
import pytest
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Imu
from std_msgs.msg import Float32, Float64, String

from heading_intercompare.app.analysis import judge_bags
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.cli import main
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.records import Headings
from heading_intercompare.core.settings import Settings
from heading_intercompare.messages.schemas import DEFINITIONS
from heading_intercompare.messages.sentence_messages import SENTENCE
from heading_intercompare.nodes.compliance import Compliance
from heading_intercompare.nodes.graph import intercompare, Source
from heading_intercompare.nodes.interface import message_types, qos
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.recorder import Recorder
from heading_intercompare.nodes.replayer import Replayer
from heading_intercompare.nodes.settings import Taking
from heading_intercompare.nodes.synchronizer import Synchronizer
from heading_intercompare.nodes.taking.headings_intake import HeadingsIntake
from heading_intercompare.readers.topic_bag import TopicBag

T0 = 1_700_000_000
S = 10 ** 9
N = 900
GYRO_FIELDS = """\
std_msgs/Header header
string maker
int16[] raw
float64[3] rates
float32 yaw_rad
float64 heading
string word
"""


@pytest.fixture(scope='module')
def packages(tmp_path_factory):
    """Build the package of sentences, and one of no other use; return where they are."""
    definitions = {'nmea_msgs': {'Sentence': SENTENCE_FIELDS},
                   'gyro_test_msgs': {'Gyro': GYRO_FIELDS},
                   'tf2_msgs': {'TFMessage': DEFINITIONS['tf2_msgs/TFMessage']}}
    return [make_package(tmp_path_factory.mktemp(package), package, fields)
            for package, fields in definitions.items()]


@pytest.fixture
def types(packages, monkeypatch):
    """Return the types of the packages, installed for this test."""
    for folder in packages:
        monkeypatch.syspath_prepend(str(folder))
    monkeypatch.setenv('AMENT_PREFIX_PATH', os.pathsep.join(
        [*(str(folder.parent) for folder in packages),
         os.environ.get('AMENT_PREFIX_PATH', sys.prefix)]))
    sentence = import_module('nmea_msgs.msg').Sentence
    monkeypatch.setitem(message_types.HEADING_TYPES, SENTENCE, sentence)
    return sentence, import_module('gyro_test_msgs.msg').Gyro


def set_stamp(message, stamp_ns):
    """Set the stamp of a message."""
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(int(stamp_ns), S)
    return message


def of_sentence(make, stamp_ns, body, frame='gps'):
    """Return a sentence as a message; a body with a star has its checksum."""
    message = make(sentence=f'${body}' if '*' in body else with_checksum(body))
    message.header.frame_id = frame
    return set_stamp(message, stamp_ns)


def sensors():
    """Return 90 s of two sensors at 10 Hz, half a period apart, in hundredths of a degree."""
    rng = np.random.default_rng(7)
    stamps = T0 * S + np.arange(N) * (S // 10)
    ship = 90.0 + 20.0 * np.sin(np.arange(N) / 300.0)
    return [Headings.of(stamps + late, np.round(ship + sigma * rng.standard_normal(N), 2))
            for sigma, late in ((0.1, 0), (0.02, S // 20))]


def make_intake(ros, **streams):
    """Return an intake of streams, each given by its place."""
    node = ros.add(Node, 'taker')
    return HeadingsIntake(node, Health(node), Taking(), {
        name: (place, 'enu', None) for name, place in streams.items()},
        lambda name, lost_as, losses: None)


def take_all(ros, intake, publisher, messages, n):
    """Publish messages; return the n headings of each stream that they give."""
    ros.spin_until(lambda: not any(map(len, intake.take().values()))
                   and publisher.get_subscription_count() == len(intake.intakes))
    for message in messages:
        publisher.publish(message)
    return take_until(ros, intake, n)


def take_until(ros, intake, n, streams=None, received=0):
    """Return the headings of each stream once n of some, and as many messages, have come."""
    taken = {name: [] for name in intake.intakes}

    def took():
        for name, headings in intake.take().items():
            taken[name].append(headings)
        return all(sum(map(len, taken[name])) >= n and intake.intakes[name].received >= received
                   for name in streams or taken)
    ros.spin_until(took)
    last = intake.take(last=True)
    return {name: Headings.concatenate([*chunks, last[name]]) for name, chunks in taken.items()}


def test_the_sentences_of_one_topic_are_two_sensors(ros, types):
    """Each sentence is a message; others, damaged ones and those of the other talker give none."""
    sentence, _ = types
    ts, rs = sensors()
    intake = make_intake(ros, ts='nmea.HEHDT', rs='nmea.GPHDT')
    publisher = ros.plain.create_publisher(sentence, 'nmea', qos.HEADINGS_OUT)
    messages = []
    for at in range(40):
        messages += [of_sentence(sentence, ts.stamp_ns[at], f'HEHDT,{ts.heading_deg[at]:.2f},T'),
                     of_sentence(sentence, ts.stamp_ns[at] + 1, 'HEHDT,1.0,T*00'),
                     of_sentence(sentence, ts.stamp_ns[at] + 2, 'GPVTG,1.0,T,,M,2.0,N,3.7,K'),
                     of_sentence(sentence, rs.stamp_ns[at], f'GPHDT,{rs.heading_deg[at]:.2f},T',
                                 'x' * (at % 5))]
    taken = take_all(ros, intake, publisher, messages, 40)
    assert taken == {'ts': ts[:40], 'rs': rs[:40]}
    shown = intake._health

    def count(part):
        return {value.key: value.value for message in heard for status in message.status
                if status.name == f'taker: {part}' for value in status.values}
    heard = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    ros.spin_until(lambda: shown.publish() or count('rs sentences'))
    assert count('ts sentences') == {
        'bad_checksum': '40', 'not_heading': '40', 'other_talker.GP': '40'}
    assert count('rs sentences') == {
        'bad_checksum': '40', 'not_heading': '40', 'other_talker.HE': '40'}


def test_sentences_in_a_text_of_any_messages_are_headings(ros, types):
    _, gyro = types
    intake = make_intake(ros, ts='gyro.word.HEHDT')
    publisher = ros.plain.create_publisher(gyro, 'gyro', qos.HEADINGS_OUT)
    messages = [set_stamp(gyro(maker='m' * (at % 7), word=with_checksum(body)), (T0 + at) * S)
                for at in range(20) for body in (f'HEHDT,{at}.5,T', 'HEROT,1.0,A')]
    taken = take_all(ros, intake, publisher, messages, 20)['ts']
    assert taken.heading_deg.tolist() == [at + 0.5 for at in range(20)]
    assert taken.stamp_ns.tolist() == [(T0 + at) * S for at in range(20)]


def test_a_sentence_is_chosen_from_the_first_seconds_of_the_stamps(ros, types):
    """THS is better than HDT, and is heard a second later."""
    sentence, _ = types
    intake = make_intake(ros, ts='nmea')
    publisher = ros.plain.create_publisher(sentence, 'nmea', qos.HEADINGS_OUT)
    messages = [of_sentence(sentence, (T0 + at) * S, body) for at in range(10)
                for body in ([f'HEHDT,{at}.0,T'] + [f'GPTHS,{at}.5,A'] * (at > 0))]
    taken = take_all(ros, intake, publisher, messages, 9)['ts']
    assert taken.heading_deg.tolist() == [at + 0.5 for at in range(1, 10)]
    assert taken.stamp_ns.tolist() == [(T0 + at) * S for at in range(1, 10)]


def test_sentences_held_for_the_choice_are_taken_at_the_end(ros, types):
    sentence, _ = types
    intake = make_intake(ros, ts='nmea')
    publisher = ros.plain.create_publisher(sentence, 'nmea', qos.HEADINGS_OUT)
    ros.spin_until(lambda: not len(intake.take()['ts']) and publisher.get_subscription_count())
    for at in range(3):
        publisher.publish(of_sentence(sentence, T0 * S + at, f'HEHDT,{at}.0,T'))
    ros.spin_until(lambda: not len(intake.take()['ts']) and intake.intakes['ts'].received == 3)
    assert intake.take(last=True)['ts'].heading_deg.tolist() == [0.0, 1.0, 2.0]


def test_without_the_package_one_line_says_what_to_install(ros, types, monkeypatch):
    sentence, _ = types
    monkeypatch.delitem(message_types.HEADING_TYPES, SENTENCE)
    intake = make_intake(ros, ts='nmea')
    ros.plain.create_publisher(sentence, 'nmea', qos.HEADINGS_OUT)
    ros.spin_until(lambda: intake.count_publishers() == 1)
    assert intake.intakes['ts'].look() == (
        'nmea: messages of the type nmea_msgs/msg/Sentence need the package nmea_msgs: install '
        'it, for instance ros-jazzy-nmea-msgs')


def test_a_field_of_messages_of_any_type_is_a_heading(ros, types):
    """Before it lie texts and lists of every length; one heading is no number, one beyond 360."""
    _, gyro = types
    intake = make_intake(ros, deg='gyro.heading', rad='gyro.yaw_rad@ned', rev='gyro.heading@rev')
    publisher = ros.plain.create_publisher(gyro, 'gyro', qos.HEADINGS_OUT)
    headings = [float('nan'), 511.0, *(0.9 * at for at in range(28))]
    messages = [set_stamp(gyro(maker='m' * (at % 7), raw=[1] * (at % 4), heading=heading,
                               yaw_rad=float(np.radians(at))), (T0 + at) * S)
                for at, heading in enumerate(headings)]
    taken = take_all(ros, intake, publisher, messages, 30)
    assert np.flatnonzero(np.isnan(taken['deg'].heading_deg)).tolist() == [0, 1]
    assert taken['deg'].heading_deg[2:].tolist() == headings[2:]
    assert taken['rad'].heading_deg == pytest.approx(np.arange(30.0), abs=1e-5)
    assert taken['rev'].heading_deg[3] == pytest.approx(0.9 * 360.0)
    assert taken['deg'].stamp_ns.tolist() == [(T0 + at) * S for at in range(30)]


@pytest.mark.parametrize('place, wrong', [
    ('gyro.course', "course: gyro_test_msgs/Gyro has no field 'course'; it has header, maker"),
    ('gyro.word', 'word: is a text; name a sentence in it, as in word.HDT'),
    ('gyro.raw', 'raw: raw is a list'),
    ('gyro.header', 'header: lies in the header, which has no heading'),
    ('gyro.yaw_rad', 'yaw_rad: a yaw may turn either way: write yaw_rad@ned if it turns from'),
    ('gyro.heading@log_time', 'heading@log_time: is the time of one recorder')])
def test_a_field_that_is_no_heading_is_refused_with_the_reason(ros, types, place, wrong):
    _, gyro = types
    intake = make_intake(ros, ts=place)
    publisher = ros.plain.create_publisher(gyro, 'gyro', qos.HEADINGS_OUT)
    ros.spin_until(lambda: not len(intake.take()['ts']) and publisher.get_subscription_count())
    publisher.publish(set_stamp(gyro(), T0 * S))
    ros.spin_until(lambda: not len(intake.take()['ts']) and intake.intakes['ts'].refused)
    assert wrong in intake.intakes['ts']._why_refused


def number(kind, heading_deg):
    """Return a message of a type without a header, with a heading."""
    if kind is Pose:
        return Pose(orientation=pose(0, heading_deg).pose.orientation)
    return kind(data=with_checksum(f'HEHDT,{heading_deg},T') if kind is String else
                float(heading_deg))


@pytest.mark.parametrize('kind, part', [
    (Float64, 'data'), (Float32, 'data@deg'), (String, 'data.HEHDT'), (Pose, 'orientation')])
def test_messages_without_a_header_have_the_time_at_which_they_were_sent(ros, kind, part):
    """Each node receives them at a time of its own; the stamps are the same to all."""
    intakes = [make_intake(ros, ts=f'compass.{part}', rs=f'compass.{part}@publish_time')
               for _ in range(2)]
    logged = []
    intakes[0]._node = SimpleNamespace(get_logger=lambda: SimpleNamespace(warning=logged.append))
    publisher = ros.plain.create_publisher(kind, 'compass', qos.HEADINGS_OUT)
    ros.spin_until(lambda: not any(len(rows) for intake in intakes
                                   for rows in intake.take().values())
                   and publisher.get_subscription_count() == 4)
    before_ns = time.time_ns()
    for at in range(20):
        publisher.publish(number(kind, 5 * at))
    taken = [take_until(ros, intake, 20) for intake in intakes]
    for headings in (rows for streams in taken for rows in streams.values()):
        assert headings.heading_deg == pytest.approx(5.0 * np.arange(20))
        assert headings == taken[0]['ts']
    stamps = taken[0]['ts'].stamp_ns
    assert before_ns <= stamps[0] and stamps[-1] <= time.time_ns() and (np.diff(stamps) > 0).all()
    assert [words.partition(': ')[0] for words in logged] == ['ts', 'rs']
    assert all('the stamps are the times at which the messages were published' in words
               for words in logged)


def test_the_time_of_sending_may_replace_the_stamp_of_a_header(ros, types):
    _, gyro = types
    intake = make_intake(ros, ts='gyro.heading@publish_time', rs='gyro.heading')
    publisher = ros.plain.create_publisher(gyro, 'gyro', qos.HEADINGS_OUT)
    before_ns = time.time_ns()
    taken = take_all(ros, intake, publisher, [set_stamp(gyro(), 0) for _ in range(5)], 5)
    assert (taken['ts'].stamp_ns > before_ns).all() and not taken['rs'].stamp_ns.any()


def transforms(kind, *rows):
    """Return a message of TF with transforms: stamp, parent, child and heading of each."""
    message = kind()
    for ns, parent, child, heading_deg in rows:
        transform = set_stamp(TransformStamped(child_frame_id=child), ns)
        transform.header.frame_id = parent
        transform.transform.rotation = pose(0, heading_deg).pose.orientation
        message.transforms.append(transform)
    return message


def test_of_transforms_two_frames_are_a_heading_whoever_else_publishes(ros, types):
    """Each publisher has its own numbers: nothing is lost, and nobody is a rival."""
    kind = import_module('tf2_msgs.msg').TFMessage
    intake = make_intake(ros, ts='tf.map:ship', rs='tf.map:hull@ned')
    publisher, other = (ros.plain.create_publisher(kind, 'tf', QoSProfile(depth=100))
                        for _ in range(2))
    ros.spin_until(lambda: not len(intake.take()['ts'])
                   and publisher.get_subscription_count() == 2 == other.get_subscription_count())
    for at in range(30):
        publisher.publish(transforms(kind, *[(at * S, 'map', 'ship', 12.0 * at)] * (at != 4),
                                     (at * S, 'map', 'odom', 1.0)))
        for _ in range(at % 4):
            other.publish(transforms(kind, (at * S, 'odom', 'map', 2.0)))
    received = 30 + sum(at % 4 for at in range(30))
    taken = take_until(ros, intake, 29, {'ts'}, received)
    assert taken['ts'].stamp_ns.tolist() == [at * S for at in range(30) if at != 4]
    assert taken['ts'].heading_deg == pytest.approx([12.0 * at for at in range(30) if at != 4])
    assert not len(taken['rs'])
    assert [intake.intakes[name].look() for name in ('ts', 'rs')] == ['', '']
    assert intake.intakes['ts'].lost == 0
    heard = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)

    def absences():
        return {status.message for message in heard for status in message.status
                if status.name == 'taker: rs frames'}
    ros.spin_until(lambda: intake._health.publish() or absences())
    assert absences() == {'no transform from map to hull; the topic has odom:map, '
                          'map:odom, map:ship'}


@pytest.mark.parametrize('kind, place, wrong', [
    ('std_msgs/Float64', 'gyro.gone', "gone: std_msgs/Float64 has no field 'gone'; it has data"),
    ('std_msgs/Float64', 'gyro.data@log_time', 'data@log_time: is the time of one recorder; live '
     'write data@publish_time'),
    ('std_msgs/String', 'gyro.data', 'data: is a text; name a sentence in it, as in data.HDT'),
    ('tf2_msgs/TFMessage', 'gyro.map', 'map: must be two frames of TF'),
    ('tf2_msgs/TFMessage', 'gyro.map:ship@publish_time', 'leave @publish_time out')])
def test_messages_without_a_header_that_hold_no_heading_are_refused_with_the_reason(
        ros, types, kind, place, wrong):
    package, _, name = kind.partition('/')
    message_type = getattr(import_module(f'{package}.msg'), name)
    intake = make_intake(ros, ts=place)
    publisher = ros.plain.create_publisher(message_type, 'gyro', qos.HEADINGS_OUT)
    ros.spin_until(lambda: not len(intake.take()['ts']) and publisher.get_subscription_count())
    publisher.publish(message_type())
    ros.spin_until(lambda: not len(intake.take()['ts']) and intake.intakes['ts'].refused)
    assert wrong in intake.intakes['ts']._why_refused


def pose(stamp_ns, heading_deg, convention='enu'):
    """Return a pose with a heading."""
    half = np.radians(heading_deg if convention == 'ned' else 90.0 - heading_deg) / 2.0
    message = PoseStamped()
    message.header.frame_id = 'x' * int(heading_deg % 5)
    message.pose.orientation.z, message.pose.orientation.w = np.sin(half), np.cos(half)
    return set_stamp(message, stamp_ns)


@pytest.mark.parametrize('convention, axes', [('enu', ''), ('enu', '@enu'), ('ned', '@ned')])
def test_a_quaternion_of_messages_of_any_type_is_a_heading(ros, convention, axes):
    intake = make_intake(ros, ts=f'pose.pose.orientation{axes}')
    publisher = ros.plain.create_publisher(PoseStamped, 'pose', qos.HEADINGS_OUT)
    messages = [pose((T0 + at) * S, 12.0 * at, convention) for at in range(30)]
    taken = take_all(ros, intake, publisher, messages, 30)['ts']
    assert taken.heading_deg == pytest.approx(12.0 * np.arange(30))
    assert taken.stamp_ns.tolist() == [(T0 + at) * S for at in range(30)]


def run_trial(ros, publisher, messages, reference, tmp_path, ts_topic):
    """
    Judge and record messages of the TS and readings of the RS; return verdict and bag.

    Without a reference its readings are stamped as they are sent, in turn with the messages.
    """
    recorder = ros.ours(Recorder, output=str(tmp_path / 'bag'), diagnostics_period_s=0.0,
                        ts_topic=ts_topic)
    synchronizer = ros.ours(Synchronizer, subscribers=2, startup_wait_s=600.0, ts_topic=ts_topic)
    compliance = ros.ours(Compliance, journal='-', ts_topic=ts_topic)
    rs = ros.plain.create_publisher(Imu, 'rs/heading', qos.HEADINGS_OUT)
    ros.spin_until(lambda: publisher.get_subscription_count() == 2 == rs.get_subscription_count())
    for message in messages:
        publisher.publish(message)
        if reference is None:
            rs.publish(set_stamp(Imu(), time.time_ns()))
    for message in heading_messages(reference or Headings.empty(), 'x'):
        rs.publish(message)
    ros.spin_until(lambda: all(intake.received >= len(messages)
                               for intake in synchronizer._headings.intakes.values())
                   if reference is None else compliance.n_pairs >= N - 30)
    for sensor in (publisher, rs):
        ros.plain.destroy_publisher(sensor)
    ros.end(synchronizer, compliance, recorder)
    return compliance.verdict.to_dict(), recorder.path


def judge_again(bag, ts_topic):
    """Return the verdict on a bag."""
    settings = Settings.from_mapping({**NORMS, 'ts_topic': ts_topic})
    return judge_bags([bag], settings).verdicts['ts'].to_dict()


def test_the_verdict_on_the_bag_of_a_trial_with_sentences_is_the_live_one(ros, types, tmp_path):
    """The bag has every sentence as it came, and its replay gives the verdict too."""
    sentence, _ = types
    ts, rs = sensors()
    publisher = ros.plain.create_publisher(sentence, 'nmea', qos.HEADINGS_OUT)
    messages = [of_sentence(sentence, ns, body) for ns, heading in zip(ts.stamp_ns, ts.heading_deg)
                for body in (f'HEHDT,{heading:.2f},T', 'HEROT,1.0,A')]
    live, bag = run_trial(ros, publisher, messages, rs, tmp_path, 'nmea.HEHDT')
    recorded = list(BagReader(bag).messages(['/nmea']))
    assert [message.data for message in recorded] == [serialize_message(m) for m in messages]
    assert {message.type_name for message in recorded} == {SENTENCE}
    assert live['runs'][0]['pairing']['ts_received'] == N
    assert_same(live, judge_again(bag, 'nmea.HEHDT'))
    replayed = intercompare([Source(Replayer, 'replayer', {'bag': str(bag), 'rate': 0.0})],
                            {**NORMS, 'ts_topic': 'nmea.HEHDT'}, private=True)
    assert_same(live, replayed.to_dict())


def test_the_verdict_on_the_bag_of_a_trial_with_a_field_is_the_live_one(ros, types, tmp_path):
    _, gyro = types
    ts, rs = sensors()
    publisher = ros.plain.create_publisher(gyro, 'gyro', qos.HEADINGS_OUT)
    messages = [set_stamp(gyro(heading=float(heading), raw=[1] * (at % 3)), ns)
                for at, (ns, heading) in enumerate(zip(ts.stamp_ns, ts.heading_deg))]
    live, bag = run_trial(ros, publisher, messages, rs, tmp_path, 'gyro.heading')
    assert live['runs'][0]['pairing']['ts_received'] == N
    assert_same(live, judge_again(bag, 'gyro.heading'))


def test_the_verdict_on_the_bag_of_a_trial_with_a_quaternion_is_the_live_one(ros, tmp_path):
    ts, rs = sensors()
    publisher = ros.plain.create_publisher(PoseStamped, 'pose', qos.HEADINGS_OUT)
    messages = [pose(ns, heading) for ns, heading in zip(ts.stamp_ns, ts.heading_deg)]
    live, bag = run_trial(ros, publisher, messages, rs, tmp_path, 'pose.pose.orientation')
    assert live['runs'][0]['pairing']['ts_received'] == N
    assert_same(live, judge_again(bag, 'pose.pose.orientation'))


@pytest.mark.parametrize('word', ['', '@publish_time'])
def test_the_verdict_on_the_bag_of_a_trial_without_headers_is_the_live_one(ros, tmp_path, word):
    """The recorder keeps the times of sending, which its bag has where no clock is stated."""
    ts_topic = f'compass.data{word}'
    publisher = ros.plain.create_publisher(Float64, 'compass', qos.HEADINGS_OUT)
    messages = [number(Float64, at % 90) for at in range(N)]
    live, bag = run_trial(ros, publisher, messages, None, tmp_path, ts_topic)
    assert live['runs'][0]['pairing']['ts_received'] == N
    assert_same(live, judge_again(bag, ts_topic))
    published = [message.publish_time_ns for message in BagReader(bag).messages(['/compass'])]
    taken, = TopicBag(bag).headings({ts_topic: 'enu'})
    assert taken[ts_topic].stamp_ns.tolist() == published
    with pytest.raises(SettingsError, match='topic /compass: its readings have the times at whi'):
        ros.ours(Replayer, bag=str(bag), ts_topic=ts_topic)
    imported = tmp_path / 'imported'
    assert main(['import', str(bag), '--ts', ts_topic, '-o', str(imported), '--quiet']) == 0
    source = Source(Replayer, 'replayer', {'bag': str(imported), 'rate': 0.0})
    replayed = intercompare([source], NORMS, private=True).to_dict()
    assert_same(live['runs'], replayed['runs'])


def test_the_verdict_on_the_bag_of_a_trial_with_transforms_is_the_live_one(ros, types, tmp_path):
    kind = import_module('tf2_msgs.msg').TFMessage
    ts, rs = sensors()
    publisher = ros.plain.create_publisher(kind, 'tf', qos.HEADINGS_OUT)
    messages = [transforms(kind, (ns, 'map', 'ship', heading), (ns, 'map', 'odom', 1.0))
                for ns, heading in zip(ts.stamp_ns, ts.heading_deg)]
    live, bag = run_trial(ros, publisher, messages, rs, tmp_path, 'tf.map:ship')
    assert live['runs'][0]['pairing']['ts_received'] == N
    assert_same(live, judge_again(bag, 'tf.map:ship'))
    replayed = intercompare([Source(Replayer, 'replayer', {'bag': str(bag), 'rate': 0.0})],
                            {**NORMS, 'ts_topic': 'tf.map:ship'}, private=True)
    assert_same(live, replayed.to_dict())
