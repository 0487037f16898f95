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

"""Bags in SQLite, compressed bags and ROS 1 bags, all written by `rosbags`, and their verdicts."""

from __future__ import annotations

from functools import reduce
import shutil
import sqlite3

from command_line import analyze_json, NORMS
import numpy as np
import pytest

from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.cli import main
from heading_intercompare.core.records import Headings
from heading_intercompare.messages.heading_messages import IMU, imu_messages
from heading_intercompare.messages.status_messages import encode_mark, MARKER_TOPIC, STATUS_TYPE
from heading_intercompare.readers.registry import find_format, open_recording
from heading_intercompare.readers.stream_recording import ReaderError

pytest.importorskip('rosbags', reason='rosbags is not installed')

from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import get_types_from_msg, get_typestore, Stores

S = 1_000_000_000
T0 = 1_400_000_000 * S
N = 9000
QUIET_NORMS = (*NORMS, '--quiet')
SENTENCE = 'nmea_msgs/msg/Sentence'
QUATERNION = 'geometry_msgs/msg/QuaternionStamped'
LAYOUT = 'std_msgs/Header header\nstring sentence'


def readings():
    """Return 15 minutes of a TS and of an RS at 10 Hz, half a period apart."""
    rng = np.random.default_rng(4)
    found = []
    for sigma, late_ns in ((0.1, 0), (0.02, S // 20)):
        stamps = T0 + late_ns + np.arange(N) * (S // 10)
        ship = 90.0 + 20.0 * np.sin(np.arange(N) / 900.0)
        found.append(Headings.of(stamps, ship + sigma * rng.standard_normal(N)))
    return found


def messages():
    """Yield topic, type, time and CDR of both sensors, a mark and a text, in order of time."""
    rows = [(int(ns), topic, IMU, data) for topic, headings in zip(
        ('/ts/heading', '/rs/heading'), readings())
        for ns, data in zip(headings.stamp_ns, imu_messages(headings, 'gyro'))]
    rows.append((T0 + 100 * S, f'/{MARKER_TOPIC}', STATUS_TYPE,
                 encode_mark('start', T0 + 100 * S)))
    yield from sorted(rows)


def write_rosbag2(path, *, storage=StoragePlugin.SQLITE3, mode=None):
    """Write a bag of rosbag2."""
    writer = Writer(path, version=9, storage_plugin=storage)
    if mode is not None:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    store = get_typestore(Stores.ROS2_JAZZY)
    with writer:
        topics = {}
        for ns, topic, kind, data in messages():
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(topics[topic], ns, data)
    return path


@pytest.fixture(scope='module')
def bags(tmp_path_factory):
    """Return a bag of each kind, with the same messages."""
    folder = tmp_path_factory.mktemp('bags')
    found = {
        'sqlite': write_rosbag2(folder / 'sqlite'),
        'by file': write_rosbag2(folder / 'by_file', mode=CompressionMode.FILE),
        'by message': write_rosbag2(folder / 'by_message', mode=CompressionMode.MESSAGE),
        'mcap by file': write_rosbag2(folder / 'mcap_by_file', storage=StoragePlugin.MCAP,
                                      mode=CompressionMode.FILE),
        'ros1': folder / 'trial.bag',
    }
    found['alone'], = found['sqlite'].glob('*.db3')
    bare = shutil.copytree(found['sqlite'], folder / 'bare')
    (bare / 'metadata.yaml').unlink()
    found['without metadata'] = bare
    store, plain = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_HUMBLE)
    with Ros1Writer(found['ros1']) as writer:
        topics = {}
        for ns, topic, kind, data in messages():
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(topics[topic], ns, plain.cdr_to_ros1(data, kind))
    with BagWriter(folder / 'ours') as bag:
        for topic, kind in {topic: kind for _, topic, kind, _ in messages()}.items():
            bag.add_topic(topic, kind)
        bag.write_rows([Rows(topic, np.frombuffer(data, np.uint8)[None], np.array([ns]))
                        for ns, topic, _, data in messages()])
    found['ours'] = folder / 'ours'
    return found


KINDS = ('sqlite', 'alone', 'without metadata', 'by file', 'by message', 'mcap by file', 'ros1')


@pytest.mark.parametrize('kind', KINDS)
def test_a_bag_gives_the_verdict_of_the_same_messages_in_mcap(bags, capsys, kind):
    # The reader of MCAP reads its compressed files itself.
    assert (find_format(bags[kind]) is None) == (kind == 'mcap by file')
    ours, _ = analyze_json(capsys, bags['ours'])
    theirs, notes = analyze_json(capsys, bags[kind])
    for one in (ours, theirs):
        run, = one['runs']
        run.pop('source')
    assert theirs['runs'] == ours['runs'] and theirs['headline'] == ours['headline']
    assert theirs['runs'][0]['start_ns'] > T0 + 100 * S, 'the mark is in force'
    assert len(theirs['inputs'][0]['sha256']) == 64
    assert ('metadata.yaml is missing' in ''.join(notes)) == (kind == 'without metadata')


@pytest.mark.parametrize('kind', KINDS)
def test_many_messages_at_once_are_those_that_come_one_by_one(bags, kind):
    bag = open_recording(bags[kind])
    messages = [(bytes(many.data[start:stop]), log_time_ns)
                for many in bag.payloads('/rs/heading') for start, stop, log_time_ns in zip(
                    many.start.tolist(), many.stop.tolist(), many.log_time_ns.tolist())]
    assert len(messages) == N and messages == [
        (message.data, message.log_time_ns) for message in bag.messages(['/rs/heading'])]


@pytest.mark.parametrize('kind', ['sqlite', 'by message', 'ros1', 'ours'])
def test_an_import_gives_the_verdict_of_the_bag(bags, capsys, tmp_path, kind):
    assert main(['import', str(bags[kind]), '-o', str(tmp_path / 'bag'), '--quiet']) == 0
    theirs, ours = (analyze_json(capsys, path)[0] for path in (bags[kind], tmp_path / 'bag'))
    assert ours['headline'] == theirs['headline']
    (run,), (of_theirs,) = ours['runs'], theirs['runs']
    assert (run['n'], run['start_ns'], run['pairing']) == (
        of_theirs['n'], of_theirs['start_ns'], of_theirs['pairing'])
    assert run['variance_deg2'] == pytest.approx(of_theirs['variance_deg2'], rel=1e-9)


@pytest.mark.parametrize('kind', KINDS)
def test_info_shows_what_a_bag_holds(bags, capsys, kind):
    assert main(['info', str(bags[kind])]) == 0
    out = capsys.readouterr().out
    assert f'/ts/heading         {IMU}' in out or '/ts/heading' in out and IMU in out
    assert f'{N}' in out


def sentence(name, heading_deg):
    body = f'{name},{heading_deg:.3f},T'
    return f'${body}*{reduce(lambda a, b: a ^ b, body.encode()):02X}'


@pytest.mark.parametrize('ros1', [True, False])
def test_topics_of_sentences_and_quaternions_are_read(tmp_path, capsys, ros1):
    """The headings of sentences have three decimals; those of quaternions are exact."""
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(LAYOUT if ros1 else LAYOUT.replace(
        'std_msgs/Header', 'std_msgs/msg/Header'), SENTENCE))
    sentences, quaternions = readings()
    path = tmp_path / ('a.bag' if ros1 else 'a')
    writer = Ros1Writer(path) if ros1 else Writer(path, version=9)
    types = store.types
    header, time = types['std_msgs/msg/Header'], types['builtin_interfaces/msg/Time']
    more = {'seq': 0} if ros1 else {}

    def head(ns, frame):
        return header(stamp=time(sec=int(ns // S), nanosec=int(ns % S)), frame_id=frame, **more)

    serialize = store.serialize_ros1 if ros1 else store.serialize_cdr
    with writer:
        nmea, imu = (writer.add_connection(topic, kind, typestore=store)
                     for topic, kind in (('/nmea', SENTENCE), ('/imu', QUATERNION)))
        for n, (ns, heading) in enumerate(zip(sentences.stamp_ns, sentences.heading_deg)):
            frame = 'gps' * (n % 4)
            text = sentence('HEHDT', heading) + '\r\n' * (n % 2)
            message = types[SENTENCE](head(ns, frame), text)
            writer.write(nmea, int(ns), serialize(message, SENTENCE))
        for ns, heading in zip(quaternions.stamp_ns, quaternions.heading_deg):
            half = np.radians(90.0 - heading) / 2.0
            message = types[QUATERNION](head(ns, 'x'), types['geometry_msgs/msg/Quaternion'](
                x=0.0, y=0.0, z=float(np.sin(half)), w=float(np.cos(half))))
            writer.write(imu, int(ns), serialize(message, QUATERNION))
    reader = open_recording(path)
    chunks = list(reader.headings({'nmea': 'enu', '/imu': 'enu'}))
    assert reader.oddities == ['nmea: headings of HEHDT; not taken: nothing']
    found = {name: Headings.concatenate([chunk[name] for chunk in chunks])
             for name in ('nmea', '/imu')}
    for name, expected, within in (('nmea', sentences, 5.1e-4), ('/imu', quaternions, 1e-9)):
        assert found[name].stamp_ns.tolist() == expected.stamp_ns.tolist()
        assert np.abs(found[name].heading_deg - expected.heading_deg).max() < within
    verdict, _ = analyze_json(capsys, path, '--ts', '/nmea', '--rs', '/imu')
    assert verdict['outcome'] == 'compliant' and verdict['runs'][0]['n'] > N - 10


def test_a_topic_that_is_not_there_or_no_heading_is_one_line(bags):
    reader = open_recording(bags['sqlite'])
    with pytest.raises(ReaderError, match="has no topic 'x'; it has /compliance/marker"):
        reader.headings({'x': 'enu'})
    with pytest.raises(ReaderError, match='topic /compliance/marker is diagnostic_msgs'):
        reader.headings({MARKER_TOPIC: 'enu'})


@pytest.mark.parametrize('kind, flipped', [('sqlite', False), ('by file', False),
                                           ('by file', True), ('ros1', False)])
def test_a_damaged_bag_is_one_line(bags, tmp_path, capsys, kind, flipped):
    path = tmp_path / 'bag'
    if bags[kind].is_dir():
        shutil.copytree(bags[kind], path)
        victim, = (one for one in path.iterdir() if '.db3' in one.name)
    else:
        victim = path
        path.write_bytes(bags[kind].read_bytes())
    data = victim.read_bytes()
    half = len(data) // 2
    victim.write_bytes(data[:half] + (b'\xa5' * 5000 + data[half + 5000:] if flipped else b''))
    assert main(['analyze', str(path), *QUIET_NORMS]) == 2
    out, err = capsys.readouterr()
    assert err.count('\n') == 1 and f'{path}' in err and 'Traceback' not in err


#: What a recorder, a network or a disk may make of a message.
WRONG = {
    'short': lambda data: data[:20],
    'a length beyond its end': lambda data: data[:12] + b'\xff\xff\xff\x7f' + data[16:],
    'another encoding': lambda data: b'{"z": 1}' + data[8:],
    'nothing': lambda data: b'',
}


def spoil(bag, wrong):
    """Spoil three messages of the TS in the SQLite file of a bag."""
    place, = bag.glob('*.db3*')
    with sqlite3.connect(place) as file:
        topic, = file.execute("SELECT id FROM topics WHERE name = '/ts/heading'").fetchone()
        rows = file.execute('SELECT id, data FROM messages WHERE topic_id = ? ORDER BY timestamp',
                            (topic,)).fetchall()
        for number, data in rows[4000:4003]:
            file.execute('UPDATE messages SET data = ? WHERE id = ?', (wrong(data), number))
    file.close()


def assert_three_rejected(capsys, path, *arguments):
    verdict, notes = analyze_json(capsys, path, *arguments)
    assert [line for line in notes if '3 messages cannot be read and count as invalid readings; '
            'the first: ' in line]
    assert verdict['runs'][0]['pairing']['rejected'] == {'ts': {'invalid': 3}, 'rs': {}}
    assert verdict['outcome'] == 'compliant'


@pytest.mark.parametrize('wrong', [*WRONG, 'a number'])
def test_an_unreadable_message_in_sqlite_is_a_rejected_reading(bags, tmp_path, capsys, wrong):
    path = shutil.copytree(bags['sqlite'], tmp_path / 'sqlite')
    spoil(path, WRONG.get(wrong, lambda data: 7))
    assert_three_rejected(capsys, path)


@pytest.mark.parametrize('wrong', WRONG)
def test_an_unreadable_message_compressed_by_itself_is_a_rejected_reading(bags, tmp_path, capsys,
                                                                         wrong):
    path = shutil.copytree(bags['by message'], tmp_path / 'by_message')
    spoil(path, WRONG[wrong])
    assert_three_rejected(capsys, path)


@pytest.mark.parametrize('wrong', ['short', 'a length beyond its end', 'nothing'])
def test_an_unreadable_message_of_ros1_is_a_rejected_reading(tmp_path, capsys, wrong):
    store, plain = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_HUMBLE)
    count = 0
    with Ros1Writer(tmp_path / 'a.bag') as writer:
        topics = {}
        for ns, topic, kind, data in messages():
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, kind, typestore=store)
            data = bytes(plain.cdr_to_ros1(data, kind))
            count += topic == '/ts/heading'
            if topic == '/ts/heading' and 4000 <= count < 4003:
                data = WRONG[wrong](data)
            writer.write(topics[topic], ns, data)
    assert_three_rejected(capsys, tmp_path / 'a.bag')


@pytest.mark.parametrize('wrong', WRONG)
def test_an_unreadable_sentence_is_an_invalid_reading_at_its_log_time(tmp_path, wrong):
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(LAYOUT.replace('std_msgs/Header', 'std_msgs/msg/Header'),
                                      SENTENCE))
    types = store.types
    with Writer(tmp_path / 'a', version=9) as writer:
        nmea = writer.add_connection('/nmea', SENTENCE, typestore=store)
        for n in range(10):
            stamp = types['builtin_interfaces/msg/Time'](sec=T0 // S + n, nanosec=0)
            message = types[SENTENCE](types['std_msgs/msg/Header'](stamp=stamp, frame_id='abc'),
                                      sentence('HEHDT', 10.0 + n))
            data = bytes(store.serialize_cdr(message, SENTENCE))
            writer.write(nmea, T0 + n * S, WRONG[wrong](data) if n in (0, 5) else data)
    reader = open_recording(tmp_path / 'a')
    found = Headings.concatenate([chunk['/nmea'] for chunk in reader.headings({'/nmea': 'enu'})])
    assert found.stamp_ns.tolist() == [T0 + n * S for n in range(10)]
    assert np.flatnonzero(np.isnan(found.heading_deg)).tolist() == [0, 5]
    assert '2 messages cannot be read' in reader.oddities[0]
