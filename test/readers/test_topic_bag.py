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

"""MCAP bags with sentences and with fields of messages of other types."""

from __future__ import annotations

from checksums import with_checksum
from command_line import analyze_json
import numpy as np
import pytest

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.provenance import RECORD
from heading_intercompare.core.records import Headings
from heading_intercompare.messages.cdr import encode
from heading_intercompare.messages.heading_messages import IMU, imu_messages
from heading_intercompare.messages.sentence_messages import SENTENCE
from heading_intercompare.readers import topic_decoding
from heading_intercompare.readers.registry import open_recording

S = 10 ** 9
T0 = 1_500_000_000 * S
#: Messages are recorded this long after their stamps.
LATE_NS = 3_000_000
VELOCITY = 'geometry_msgs/msg/TwistStamped'


def head(stamp_ns, frame='gps'):
    """Return a header."""
    return {'stamp': {'sec': stamp_ns // S, 'nanosec': stamp_ns % S}, 'frame_id': frame}


def of_sentence(stamp_ns, text, frame='gps'):
    """Return a sentence as a message."""
    return encode(SENTENCE, {'header': head(stamp_ns, frame), 'sentence': text})


def hdt(heading_deg, talker='HE'):
    """Return a sentence."""
    return with_checksum(f'{talker}HDT,{heading_deg:.2f},T')


def write(path, rows, numbers=None, record=True):
    """Write topic, type, stamp and data of messages; numbers by place, else 1, 2 ..."""
    count = {}
    with BagWriter(path) as bag:
        if record:
            bag.metadata(RECORD, {'software': 'x'})
        for topic, kind in {topic: kind for topic, kind, _, _ in rows}.items():
            bag.add_topic(topic, kind)
        for place, (topic, _, ns, data) in enumerate(rows):
            count[topic] = count.get(topic, 0) + 1
            bag.write(topic, data, ns + LATE_NS,
                      sequence=(numbers or {}).get(place, count[topic]))
    return path


def read(path, topics, lost=None):
    """Return the headings of topics, and what is odd about the bag."""
    reader = open_recording(path)
    chunks = list(reader.headings(dict.fromkeys(topics, 'enu'), 0, lost))
    return {topic: Headings.concatenate([chunk[topic] for chunk in chunks])
            for topic in topics}, reader.oddities


@pytest.fixture(params=[1, 7, 4000])
def at_once(request, monkeypatch):
    """Decode so many messages at once: nothing may depend on it."""
    monkeypatch.setattr(topic_decoding, '_MESSAGES', request.param)


def test_two_talkers_of_a_topic_are_two_sensors_beside_another_topic(tmp_path, at_once):
    rows = []
    for n in range(20):
        ns = T0 + n * S
        rows += [('/nmea', SENTENCE, ns, of_sentence(ns, hdt(n), 'x' * (n % 5))),
                 ('/nmea', SENTENCE, ns + 1, of_sentence(ns + 1, hdt(n + 0.5, 'GP') + '\r\n')),
                 ('/nmea', SENTENCE, ns + 2, of_sentence(ns + 2, '$HEHDT,9.0,T*00')),
                 ('/imu', IMU, ns, imu_messages(Headings.of([ns], [n + 0.25]), 'x')[0])]
    headings, oddities = read(write(tmp_path / 'bag', rows),
                              ['nmea.HEHDT', '/nmea.GPHDT', 'nmea.HDT', 'imu'])
    for topic, more, late in (('nmea.HEHDT', 0.0, 0), ('/nmea.GPHDT', 0.5, 1),
                              ('nmea.HDT', 0.0, 0), ('imu', 0.25, 0)):
        assert headings[topic].stamp_ns.tolist() == [T0 + n * S + late for n in range(20)]
        assert headings[topic].heading_deg == pytest.approx(np.arange(20) + more)
    assert 'nmea.HEHDT: headings of HEHDT; not taken: 20 bad_checksum, 20 other_talker.GP' in (
        oddities)


def test_the_sentence_is_chosen_as_live_by_the_first_two_seconds(tmp_path, at_once):
    """THS comes a second late; a better talker after two seconds is another one."""
    rows = [('/nmea', SENTENCE, T0 + n * S, of_sentence(T0 + n * S, text))
            for n in range(6) for text in [hdt(n)] + [with_checksum(f'GPTHS,{n}.5,A')] * (n > 0)]
    headings, _ = read(write(tmp_path / 'bag', rows), ['nmea'])
    assert headings['nmea'].heading_deg.tolist() == [n + 0.5 for n in range(1, 6)]


def test_a_bag_that_ends_before_the_choice_has_its_headings(tmp_path, at_once):
    rows = [('/nmea', SENTENCE, T0 + n, of_sentence(T0 + n, hdt(n))) for n in range(3)]
    headings, _ = read(write(tmp_path / 'bag', rows), ['nmea'])
    assert headings['nmea'].heading_deg.tolist() == [0.0, 1.0, 2.0]


def test_an_unreadable_sentence_is_an_invalid_reading_and_a_missing_one_is_lost(
        tmp_path, at_once):
    rows = [('/nmea', SENTENCE, T0 + n * S,
             of_sentence(T0 + n * S, hdt(n))[:30 if n in (0, 5) else None]) for n in range(10)]
    lost = []
    path = write(tmp_path / 'bag', rows, {n: n + (4 if n > 6 else 1) for n in range(10)})
    headings, oddities = read(path, ['nmea.HEHDT'], lambda topic, lost_as, losses: lost.append(
        (topic, lost_as, losses.count.tolist(), losses.stamp_ns.tolist())))
    assert headings['nmea.HEHDT'].stamp_ns.tolist() == [
        T0 + n * S + LATE_NS * (n in (0, 5)) for n in range(10)]
    assert np.flatnonzero(np.isnan(headings['nmea.HEHDT'].heading_deg)).tolist() == [0, 5]
    assert lost == [('nmea.HEHDT', 'lost.on_the_way', [3], [T0 + 7 * S])]
    assert oddities[0].startswith('2 messages cannot be read and count as invalid readings; '
                                  'the first: nmea_msgs/msg/Sentence message of 30 bytes')


def test_a_field_is_read_by_the_schema_of_the_bag(tmp_path, at_once):
    rows = [('/course', VELOCITY, T0 + n * S, encode(VELOCITY, {
        'header': head(T0 + n * S, 'x' * (n % 9)),
        'twist': {'linear': {'z': 0.1 * n}, 'angular': {'x': 500.0 if n == 3 else 2.5 * n}}}))
        for n in range(20)]
    headings, _ = read(write(tmp_path / 'bag', rows), [
        'course.twist.angular.x', 'course.twist.linear.z@rad'])
    degrees = headings['course.twist.angular.x'].heading_deg
    assert headings['course.twist.angular.x'].stamp_ns.tolist() == [
        T0 + n * S for n in range(20)]
    assert np.flatnonzero(np.isnan(degrees)).tolist() == [3]
    assert np.nanmax(np.abs(degrees - 2.5 * np.arange(20))) == 0.0
    assert headings['course.twist.linear.z@rad'].heading_deg == pytest.approx(
        np.degrees(0.1 * np.arange(20)))


@pytest.mark.parametrize('topic, wrong', [
    ('nmea.HEROT', 'topic /nmea: HEROT: is no sentence with a heading; must be THS, HDT'),
    ('imu.angular_velocity', 'topic /imu: angular_velocity: angular_velocity is a message; choose '
     'one of its fields: x, y, z'),
    ('imu.orientation_covariance', 'topic /imu: orientation_covariance: orientation_covariance '
     'is a list; choose a single value'),
    ('imu.course', "topic /imu: course: sensor_msgs/Imu has no field 'course'; it has header"),
    ('imu.header.frame_id', 'topic /imu: header.frame_id: lies in the header'),
    ('note.data', 'topic /note: data: is a text; name a sentence in it, as in data.HDT'),
    ('note', 'topic /note is std_msgs/msg/String; a heading is sensor_msgs/msg/Imu, '),
    ('imu.orientation@enu@ned', 'states both enu and ned; leave one out'),
    ('nmea.HDT@grad', "nmea.HDT@grad: unit 'grad' must be one of deg, rad, rev"),
    ('imu.orientation.z@0deg', "unit '0deg' must be one of deg, rad, rev, or a number before")])
def test_what_is_no_heading_is_one_line(tmp_path, capsys, topic, wrong):
    path = write(tmp_path / 'bag', [
        ('/nmea', SENTENCE, T0, of_sentence(T0, hdt(1))),
        ('/imu', IMU, T0, imu_messages(Headings.of([T0], [1.0]), 'x')[0]),
        ('/note', 'std_msgs/msg/String', T0, encode('std_msgs/msg/String', {'data': 'x'}))])
    from heading_intercompare.cli import main
    assert main(['analyze', str(path), '--ts', topic, '--rs', 'imu', '--set',
                 'norms.sigma_max_deg=0.2', '--set', 'norms.sigma_ref_max_deg=0.1']) == 2
    out, err = capsys.readouterr()
    assert wrong in err and err.count('\n') == 1 and not out


def test_a_reader_of_bags_alone_refuses_what_it_cannot_read(tmp_path):
    """It would take the orientation where a field is meant."""
    path = write(tmp_path / 'bag', [
        ('/nmea', SENTENCE, T0, of_sentence(T0, hdt(1))),
        ('/imu', IMU, T0, imu_messages(Headings.of([T0], [1.0]), 'x')[0])])
    for topic in ('nmea', 'imu.orientation.z'):
        with pytest.raises(BagError):
            BagReader(path).headings({topic: 'enu'})


def test_a_bag_with_sentences_is_judged(tmp_path, capsys, rng):
    ship = 90.0 + 20.0 * np.sin(np.arange(6000) / 900.0)
    rows = []
    for n, heading in enumerate(ship):
        ns = T0 + n * (S // 10)
        rows += [('/nmea', SENTENCE, ns, of_sentence(ns, hdt(heading + rng.normal(0.0, 0.1)))),
                 ('/nmea', SENTENCE, ns + 5, of_sentence(ns + 5, hdt(heading, 'GP')))]
    verdict, _ = analyze_json(capsys, write(tmp_path / 'bag', rows), '--ts', 'nmea.HEHDT',
                              '--rs', 'nmea.GPHDT')
    run, = verdict['runs']
    assert run['n'] > 5900 and 0.09 < run['std_deg'] < 0.11
