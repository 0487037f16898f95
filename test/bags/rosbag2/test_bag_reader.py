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

"""Reading of bags: of any writer, complete, cut or damaged."""

from __future__ import annotations

import shutil
import time

from mcap.writer import CompressionType, IndexType, Writer
import numpy as np
import pytest

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.bag_check import check_bag
from heading_intercompare.bags.rosbag2.bag_reader import BagReader, TopicInfo
from heading_intercompare.bags.rosbag2.bag_yaml import Qos
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.core.angles import quaternion_from_heading, wrap180
from heading_intercompare.core.records import Headings
from heading_intercompare.messages.cdr import encode
from heading_intercompare.messages.heading_messages import encode_imu, IMU, ORIENTATION_TYPES
from heading_intercompare.messages.schemas import shipped_schema

STRING = 'std_msgs/msg/String'
BOTH = {'/ts/heading': 'enu', '/rs/heading': 'enu'}


def read(path, conventions: dict[str, str]) -> dict[str, Headings]:
    """Return all headings of a bag by topic."""
    parts = {topic: [] for topic in conventions}
    for chunk in BagReader(path).headings(conventions):
        assert chunk.keys() == parts.keys()
        for topic, headings in chunk.items():
            parts[topic].append(headings)
    return {topic: Headings.concatenate(found) for topic, found in parts.items()}


def orientation(type_name: str, heading_deg: float, stamp_ns: int) -> dict:
    """Return the fields of a level message of an accepted type."""
    z, w = quaternion_from_heading([heading_deg])
    q = {'z': float(z[0]), 'w': float(w[0])}
    header = {'stamp': {'sec': stamp_ns // 10**9, 'nanosec': stamp_ns % 10**9}, 'frame_id': 'x'}
    name = {IMU: 'orientation', 'geometry_msgs/msg/QuaternionStamped': 'quaternion'}.get(type_name)
    return {'header': header, name: q} if name else {
        'header': header, 'pose': {'pose': {'orientation': q}}}


def mcap_file(path, messages, type_name=STRING, *, text=None, encoding='cdr', schema='ros2msg',
              **options):
    """Write (topic, data) with the writer of mcap, one chunk for about 1000 bytes."""
    with open(path, 'wb') as file:
        writer = Writer(file, chunk_size=1000, **options)
        writer.start('ros2')
        definition = shipped_schema(type_name).text if text is None else text
        number = writer.register_schema(type_name, schema, definition.encode())
        channels = {}
        for i, (topic, data) in enumerate(messages):
            if topic not in channels:
                channels[topic] = writer.register_channel(topic, encoding, number)
            writer.add_message(channels[topic], 1000 + i, data, 2000 + i, i)
        writer.finish()
    return path


def remarks(count: int) -> list[tuple[str, bytes]]:
    """Return messages of three topics and many lengths in no regular order."""
    return [(f'/{"abc"[i * i % 7 % 3]}', encode(STRING, {'data': 'x' * (i * 13 % 31)}))
            for i in range(count)]


# What others wrote


@pytest.mark.parametrize('options', [
    {}, {'compression': CompressionType.NONE}, {'compression': CompressionType.LZ4},
    {'index_types': IndexType.NONE}, {'index_types': IndexType.CHUNK},
    {'index_types': IndexType.MESSAGE}, {'use_chunking': False}, {'use_statistics': False},
    {'repeat_channels': False}, {'repeat_schemas': False}, {'enable_crcs': False},
    {'use_summary_offsets': False}, {'repeat_channels': False, 'repeat_schemas': False,
                                     'use_statistics': False, 'index_types': IndexType.NONE,
                                     'use_summary_offsets': False}], ids=str)
def test_mcap_files_of_any_shape_give_all_messages_in_order(tmp_path, options):
    sent = remarks(300)
    reader = BagReader(mcap_file(tmp_path / 'a.mcap', sent, **options))
    assert reader.incomplete is None
    assert {topic: info.count for topic, info in reader.topics.items()} == {
        t: sum(topic == t for topic, _ in sent) for t in ('/a', '/b', '/c')}
    assert (reader.start_ns, reader.end_ns) == (1000, 1299)
    assert [tuple(m) for m in reader.messages()] == [
        (topic, STRING, 1000 + i, 2000 + i, i, data) for i, (topic, data) in enumerate(sent)]


def test_messages_outside_chunks_are_read_across_the_ends_of_blocks(tmp_path, monkeypatch):
    monkeypatch.setattr('heading_intercompare.bags.mcap.record_stream._BARE_BYTES', 500)
    sent = remarks(300) + [('/a', encode(STRING, {'data': 'y' * 2000}))] + remarks(9)
    reader = BagReader(mcap_file(tmp_path / 'a.mcap', sent, use_chunking=False))
    assert [m.data for m in reader.messages()] == [data for _, data in sent]


def test_chunks_with_and_without_index_are_read_alike(write_bag, tmp_path, monkeypatch):
    path = write_bag(chunk_bytes=5000)
    expected = read(path, BOTH)
    monkeypatch.setattr('heading_intercompare.bags.mcap.chunks.Gathering.add_index',
                        lambda self, content: None)
    assert read(path, BOTH) == expected


@pytest.mark.parametrize('type_name', ORIENTATION_TYPES)
def test_all_accepted_types_are_read_from_bags_of_rosbags(tmp_path, type_name):
    rosbag2 = pytest.importorskip('rosbags.rosbag2')
    typesys = pytest.importorskip('rosbags.typesys')
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    stamps = [10**18 + i * 10**8 for i in range(100)]
    with rosbag2.Writer(tmp_path / 'bag', version=9,
                        storage_plugin=rosbag2.StoragePlugin.MCAP) as bag:
        connection = bag.add_connection('/ts/heading', type_name, typestore=store)
        for i, stamp_ns in enumerate(stamps):
            bag.write(connection, stamp_ns, encode(type_name, orientation(type_name, 3.5 * i,
                                                                          stamp_ns)))
    found = read(tmp_path / 'bag', {'ts/heading': 'enu'})['ts/heading']
    assert found.stamp_ns.tolist() == stamps
    assert np.abs(found.heading_deg - 3.5 * np.arange(100)).max() < 1e-11
    assert BagReader(tmp_path / 'bag').topics == {'/ts/heading': TopicInfo(type_name, 100)}


@pytest.mark.parametrize('type_name', ORIENTATION_TYPES)
def test_all_accepted_types_are_read_from_bags_of_mcap_ros2(tmp_path, type_name):
    theirs = pytest.importorskip('mcap_ros2.writer')
    with open(tmp_path / 'a.mcap', 'wb') as file:
        writer = theirs.Writer(file, chunk_size=4000)
        schema = writer.register_msgdef(type_name.replace('/msg/', '/'),
                                        shipped_schema(type_name).text)
        for i in range(100):
            message = {**orientation(type_name, 3.5 * i, 10**18 + i), 'child_frame_id': ''}
            writer.write_message('/ts/heading', schema, filled(type_name, message), i)
        writer.finish()
    found = read(tmp_path / 'a.mcap', {'/ts/heading': 'enu'})['/ts/heading']
    assert np.abs(found.heading_deg - 3.5 * np.arange(100)).max() < 1e-11


def test_azimuths_are_read_from_a_bag_without_their_package(tmp_path):
    type_name = 'compass_interfaces/msg/Azimuth'
    with BagWriter(tmp_path / 'bag') as bag:
        bag.add_topic('/ts/heading', type_name)
        stamps = 10**18 + np.arange(20) * 10**9
        rows = [encode(type_name, {
            'header': {'stamp': {'sec': 10**9 + i}}, 'azimuth': 3.5 * i, 'unit': 1,
            'orientation': 1, 'reference': int(i != 7)}) for i in range(20)]
        bag.write_rows([Rows('/ts/heading', np.frombuffer(b''.join(rows), np.uint8).reshape(
            20, -1), stamps)])
    reader = BagReader(tmp_path / 'bag')
    found = Headings.concatenate([one['ts/heading'] for one in reader.headings(
        {'ts/heading': 'enu'})])
    assert np.flatnonzero(np.isnan(found.heading_deg)).tolist() == [7]
    assert np.nanmax(np.abs(found.heading_deg - 3.5 * np.arange(20))) < 1e-11
    assert 'a magnetic azimuth' in reader.oddities[0]


def filled(type_name: str, message: dict) -> dict:
    """Return a message with the fields that mcap_ros2 would miss."""
    from heading_intercompare.messages.cdr import decode
    message = {k: v for k, v in message.items() if k != 'child_frame_id' or 'Odom' in type_name}
    return decode(type_name, encode(type_name, message))


def test_convention_ned_reads_yaw_as_heading(write_bag, two_sensors):
    found = read(write_bag(), {'/ts/heading': 'ned'})['/ts/heading']
    expected = (90.0 - two_sensors[0].heading_deg) % 360.0
    assert np.nanmax(np.abs((found.heading_deg - expected + 180.0) % 360.0 - 180.0)) < 1e-11


# Chunks


def test_a_topic_asked_for_under_two_conventions_is_read_under_both(write_bag):
    path = write_bag()
    both = {'/ts/heading': 'enu', 'ts/heading': 'ned'}
    enu, ned = read(path, both)['/ts/heading'], read(path, both)['ts/heading']
    assert enu == read(path, {'/ts/heading': 'enu'})['/ts/heading']
    assert ned == read(path, {'ts/heading': 'ned'})['ts/heading'] != enu


def test_topics_of_several_types_and_frames_are_read_side_by_side(tmp_path, monkeypatch):
    monkeypatch.setattr('heading_intercompare.bags.mcap.mcap_file._BLOCK_BYTES', 3000)
    types = {'/a': IMU, '/b': IMU, '/c': 'geometry_msgs/msg/QuaternionStamped'}
    frames = {'/a': 'a', '/b': 'a_much_longer_frame', '/c': ''}
    heading_deg = np.linspace(0.0, 359.0, 300)
    sent = {topic: [] for topic in types}
    with BagWriter(tmp_path / 'bag', BagSettings(chunk_bytes=2000)) as bag:
        for topic, type_name in types.items():
            bag.add_topic(topic, type_name)
        for number, each in enumerate(heading_deg):
            topic = '/' + 'abcab'[number * number % 5]
            message = orientation(types[topic], each, 5 * 10**9 + number)
            message['header']['frame_id'] = frames[topic]
            bag.write(topic, encode(types[topic], message), 10**18 + number, 10**18 + number, 0)
            sent[topic].append(number)
    found = read(tmp_path / 'bag', dict.fromkeys(types, 'enu'))
    for topic, numbers in sent.items():
        assert (found[topic].stamp_ns - 5 * 10**9).tolist() == numbers
        error = wrap180(found[topic].heading_deg - heading_deg[numbers])
        np.testing.assert_allclose(error, 0.0, atol=1e-9)


@pytest.mark.parametrize('chunk_bytes', [2000, 1_000_000])
def test_chunks_span_at_most_a_minute_and_lose_nothing(tmp_path, rng, chunk_bytes, write_bag,
                                                       two_sensors):
    path = write_bag(chunk_bytes=chunk_bytes)
    spans, counts = [], dict.fromkeys(BOTH, 0)
    for chunk in BagReader(path).headings(BOTH):
        stamps = np.concatenate([c.stamp_ns for c in chunk.values()])
        spans.append(np.ptp(stamps))
        for topic, headings in chunk.items():
            counts[topic] += len(headings)
    assert max(spans) <= 60 * 10**9 and len(spans) in (2, 3)
    assert counts == {'/ts/heading': 2000, '/rs/heading': 1000}


def test_a_block_of_many_minutes_is_split_by_minutes(tmp_path):
    stamp_ns = 10**18 + np.arange(600) * 10**9
    headings = Headings.of(stamp_ns, np.full(600, 45.0))
    with BagWriter(tmp_path / 'bag') as bag:
        bag.add_topic('/ts/heading', IMU)
        bag.write_rows([Rows('/ts/heading', encode_imu(headings, ''), stamp_ns)])
    chunks = [c['/ts/heading'] for c in BagReader(bag.path).headings({'/ts/heading': 'enu'})]
    assert [len(c) for c in chunks] == [60] * 10
    assert np.array_equal(Headings.concatenate(chunks).stamp_ns, stamp_ns)


def test_topics_written_minute_by_minute_come_out_whole(tmp_path, two_sensors):
    ts, rs = two_sensors
    with BagWriter(tmp_path / 'bag') as bag:
        for topic in BOTH:
            bag.add_topic(topic, IMU)
        for topic, headings in (('/rs/heading', rs), ('/ts/heading', ts)):
            bag.write_rows([Rows(topic, encode_imu(headings, ''), headings.stamp_ns)])
    found = read(bag.path, BOTH)
    assert np.array_equal(found['/ts/heading'].stamp_ns, ts.stamp_ns)
    assert np.array_equal(found['/rs/heading'].stamp_ns, rs.stamp_ns)


def test_messages_are_chosen_by_topic_and_time(tmp_path):
    sent = remarks(300)
    reader = BagReader(mcap_file(tmp_path / 'a.mcap', sent))
    found = list(reader.messages(['b', '/c'], 1100, 1200))
    assert [(m.topic, m.log_time_ns) for m in found] == [
        (topic, 1000 + i) for i, (topic, _) in enumerate(sent)
        if topic != '/a' and 100 <= i < 200]
    assert list(reader.messages(start_ns=1300)) == []


# Cut and damaged


@pytest.mark.slow
def test_a_bag_cut_anywhere_is_read_up_to_the_cut(tmp_path):
    whole = mcap_file(tmp_path / 'a.mcap', remarks(150)).read_bytes()
    sent = [data for _, data in remarks(150)]
    cut = tmp_path / 'cut.mcap'
    counts = []
    for size in [*range(8, len(whole), 13), len(whole) - 1]:
        cut.write_bytes(whole[:size])
        reader = BagReader(cut)
        found = [m.data for m in reader.messages()]
        assert found == sent[:len(found)]
        assert reader.incomplete.startswith('cut.mcap was not closed')
        assert sum(info.count for info in reader.topics.values()) == len(found)
        counts.append(len(found))
    assert counts == sorted(counts) and counts[0] == 0 and counts[-1] == 150
    assert len(set(counts)) > 5


@pytest.mark.slow
@pytest.mark.parametrize('options', [{'use_chunking': False}, {'index_types': IndexType.NONE},
                                     {'compression': CompressionType.NONE}], ids=str)
def test_a_bag_of_another_shape_cut_anywhere_is_read_up_to_the_cut(tmp_path, options):
    whole = mcap_file(tmp_path / 'a.mcap', remarks(60), **options).read_bytes()
    sent = [data for _, data in remarks(60)]
    cut = tmp_path / 'cut.mcap'
    for size in range(8, len(whole), 31):
        cut.write_bytes(whole[:size])
        reader = BagReader(cut)
        found = [m.data for m in reader.messages()]
        assert found == sent[:len(found)] and reader.incomplete
    assert found == sent


def test_a_bag_cut_behind_its_last_message_says_that_nothing_is_lost(tmp_path):
    path = mcap_file(tmp_path / 'a.mcap', remarks(150))
    path.write_bytes(path.read_bytes()[:-3])
    assert 'all its messages are there' in BagReader(path).incomplete


@pytest.mark.parametrize('tail', [bytes(5000), b'\xff' * 5000, b'\x06' * 5000])
def test_rubbish_behind_a_cut_is_left_out(tmp_path, tail):
    path = mcap_file(tmp_path / 'a.mcap', remarks(150))
    whole = path.read_bytes()
    clean = tmp_path / 'clean.mcap'
    clean.write_bytes(whole[:2000])
    path.write_bytes(whole[:2000] + tail)
    expected = list(BagReader(clean).messages())
    assert list(BagReader(path).messages()) == expected and expected
    assert 'was not closed' in BagReader(path).incomplete


@pytest.mark.slow
def test_no_flipped_byte_goes_unnoticed_or_ends_in_a_traceback(tmp_path, rng):
    """Every byte of the data section has a checksum, or changing it breaks the format."""
    sent = list(BagReader(mcap_file(tmp_path / 'a.mcap', remarks(60))).messages())
    whole = (tmp_path / 'a.mcap').read_bytes()
    path = tmp_path / 'b.mcap'
    harmless = 0
    for at in range(0, len(whole), 5):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ (1 << int(rng.integers(8)))])
                         + whole[at + 1:])
        try:
            reader = BagReader(path)
            found = list(reader.messages())
            reader.metadata()
        except BagError as error:
            assert str(error).startswith(str(path))
            continue
        if found != sent:
            assert reader.incomplete is not None and found == sent[:len(found)]
        harmless += found == sent
    assert harmless > 0


def test_a_damaged_chunk_of_a_closed_bag_is_an_error_with_its_place(tmp_path):
    path = mcap_file(tmp_path / 'a.mcap', remarks(150), compression=CompressionType.NONE)
    whole = bytearray(path.read_bytes())
    at = whole.index(b'xxxxxxxxxxxx', len(whole) // 3)
    whole[at] = ord('y')
    path.write_bytes(whole)
    reader = BagReader(path)
    with pytest.raises(BagError, match=r'a\.mcap: chunk damaged: its checksum.* \(at byte') as e:
        list(reader.messages())
    assert 0 < at - e.value.offset < 1200


def test_messages_before_the_damage_are_given(tmp_path):
    path = mcap_file(tmp_path / 'a.mcap', remarks(150), compression=CompressionType.NONE)
    whole = bytearray(path.read_bytes())
    whole[whole.index(b'xxxxxxxxxxxx', len(whole) // 2)] = ord('y')
    path.write_bytes(whole)
    found = []
    with pytest.raises(BagError, match='chunk damaged'):
        for message in BagReader(path).messages():
            found.append(message.data)
    assert found == [data for _, data in remarks(150)][:len(found)] and len(found) > 30


def test_a_damaged_attachment_is_an_error(tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.attachment('a', 'text/plain', b'to be damaged')
    path = bag.path / 'bag_0.mcap'
    path.write_bytes(path.read_bytes().replace(b'to be damaged', b'to be damagef'))
    with pytest.raises(BagError, match='attachment damaged'):
        BagReader(path).attachments()


@pytest.mark.parametrize('options', [{}, {'enable_crcs': False}], ids=str)
def test_a_compression_that_is_not_known_is_named(tmp_path, options):
    path = mcap_file(tmp_path / 'a.mcap', remarks(20), compression=CompressionType.LZ4, **options)
    path.write_bytes(path.read_bytes().replace(b'\x03\0\0\0lz4', b'\x03\0\0\0rot'))
    with pytest.raises(BagError, match=r"a\.mcap: chunk compressed with 'rot'; known are zstd"):
        list(BagReader(path).messages())


# Directories


def split_bag(tmp_path, count: int):
    """Return a directory with one message in each of many files."""
    folder = tmp_path / 'split'
    folder.mkdir()
    for i in range(count):
        mcap_file(folder / f'split_{i}.mcap', [('/a', encode(STRING, {'data': str(i)}))])
    return folder


@pytest.mark.slow
def test_headings_stay_in_file_order_where_the_clock_of_the_recorder_goes_back(tmp_path):
    stamps = 10**18 + np.arange(6000) * 10**8
    log = stamps - np.where(np.arange(6000) >= 3000, 150 * 10**9, 0)
    both = {topic: Headings.of(stamps, np.arange(6000) / 20.0) for topic in BOTH}
    with BagWriter(tmp_path / 'back') as bag:
        for topic in BOTH:
            bag.add_topic(topic, IMU)
        for lo in range(0, 6000, 10):
            bag.write_rows([Rows(topic, encode_imu(headings[lo:lo + 10], 'x'), log[lo:lo + 10])
                            for topic, headings in both.items()])
    for headings in read(tmp_path / 'back', BOTH).values():
        assert headings.stamp_ns.tolist() == stamps.tolist()


def test_files_of_a_directory_are_read_in_natural_order(tmp_path):
    reader = BagReader(split_bag(tmp_path, 12))
    assert reader.incomplete is None
    assert reader.topics == {'/a': TopicInfo(STRING, 12)}
    assert [m.data for m in reader.messages()] == [
        encode(STRING, {'data': str(i)}) for i in range(12)]


def test_a_missing_or_empty_file_makes_the_bag_incomplete(tmp_path):
    folder = split_bag(tmp_path, 3)
    (folder / 'metadata.yaml').write_text(
        'rosbag2_bagfile_information:\n  relative_file_paths:\n' + ''.join(
            f'    - split_{i}.mcap\n' for i in range(5)))
    (folder / 'split_3.mcap').touch()
    reader = BagReader(folder)
    assert reader.incomplete == 'split_4.mcap is missing; split_3.mcap is empty (0 bytes)'
    assert reader.topics['/a'].count == 3


@pytest.mark.parametrize('read', [BagReader, check_bag])
@pytest.mark.parametrize('text', ['', 'rosbag2_bagfile_information:\n  relative_file_paths: [a'])
def test_damaged_metadata_are_refused_and_name_the_way_out(tmp_path, read, text):
    folder = split_bag(tmp_path, 2)
    (folder / 'metadata.yaml').write_text(text)
    with pytest.raises(BagError, match=r'metadata\.yaml: .*`recover` reads the bag without this'):
        read(folder)
    # A file of the bag is read by itself, and all of them once the metadata are gone.
    assert BagReader(folder / 'split_0.mcap').topics['/a'].count == 1
    (folder / 'metadata.yaml').unlink()
    assert BagReader(folder).topics['/a'].count == 2


@pytest.mark.parametrize('content, problem', [
    (bytes(5000), 'starts with zero bytes; it was never written'),
    (b'\x89MC', 'is not an MCAP file'), (b'hello world' * 100, 'is not an MCAP file')])
def test_a_file_that_was_never_begun_does_not_keep_the_others_from_being_read(
        tmp_path, content, problem):
    folder = split_bag(tmp_path, 3)
    (folder / 'split_1.mcap').write_bytes(content)
    reader = BagReader(folder)
    assert reader.incomplete == f'split_1.mcap {problem}'
    assert [m.data for m in reader.messages()] == [
        encode(STRING, {'data': text}) for text in '02']


def test_what_is_called_like_a_file_of_the_bag_and_is_none_is_left_out(tmp_path):
    folder = split_bag(tmp_path, 2)
    (folder / 'split_2.mcap').mkdir()
    mcap_file(folder / '²1.mcap', [('/a', encode(STRING, {'data': '2'}))])
    assert BagReader(folder).topics['/a'].count == 3
    assert check_bag(folder).faults == []


def test_a_cut_last_file_is_read_up_to_the_cut(tmp_path):
    folder = split_bag(tmp_path, 3)
    last = folder / 'split_2.mcap'
    last.write_bytes(last.read_bytes()[:60])
    reader = BagReader(folder)
    assert len(list(reader.messages())) == 2 and 'split_2.mcap was not closed' in reader.incomplete


def test_a_directory_without_metadata_is_read(write_bag):
    path = write_bag()
    (path / 'metadata.yaml').unlink()
    assert BagReader(path).topics['/ts/heading'].count == 2000


def test_a_single_file_of_a_bag_is_a_bag(write_bag):
    path = write_bag()
    assert read(path, BOTH) == read(path / 'trial_0.mcap', BOTH)


def test_one_topic_with_two_types_is_refused(tmp_path):
    folder = split_bag(tmp_path, 1)
    mcap_file(folder / 'split_1.mcap', [('/a', encode(IMU, {}))], IMU)
    with pytest.raises(BagError, match=f'topic /a is both {STRING} and {IMU}'):
        BagReader(folder)


# What cannot be a bag, or not the topic


@pytest.mark.parametrize('content, problem', [
    (b'', 'is empty'), (bytes(100), 'zero bytes'), (b'stamp_s,ts_deg\n', 'not an MCAP file'),
    (b'\x89MCAP', 'not an MCAP file'), (b'SQLite format 3\0', 'not an MCAP file')])
def test_a_file_that_is_no_bag_is_refused_in_one_line(tmp_path, content, problem):
    path = tmp_path / 'a.mcap'
    path.write_bytes(content)
    with pytest.raises(BagError, match=problem) as caught:
        BagReader(path)
    assert str(caught.value).startswith(f'{path}: ') and '\n' not in str(caught.value)


def test_a_file_that_is_not_there_is_an_os_error(tmp_path):
    with pytest.raises(FileNotFoundError):
        BagReader(tmp_path / 'a.mcap')


def test_a_directory_without_mcap_is_refused(tmp_path):
    (tmp_path / 'bag_0.db3').touch()
    with pytest.raises(BagError, match='holds no .mcap file'):
        BagReader(tmp_path)


def test_a_directory_of_empty_files_is_refused(tmp_path):
    (tmp_path / 'a_0.mcap').touch()
    with pytest.raises(BagError, match='is empty'):
        BagReader(tmp_path)
    (tmp_path / 'a_1.mcap').touch()
    with pytest.raises(BagError, match='empty'):
        BagReader(tmp_path)


def test_an_absent_topic_lists_those_present(write_bag):
    reader = BagReader(write_bag())
    expected = rf"no topic 'heading'; it has /rs/heading \({IMU}\), /ts/heading \({IMU}\)"
    with pytest.raises(BagError, match=expected):
        reader.headings({'heading': 'enu'})
    with pytest.raises(BagError, match=expected):
        reader.messages(['heading'])


def test_of_many_topics_a_few_are_named(tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        for number in range(300):
            bag.add_topic(f'/topic_{number:03}', STRING)
    with pytest.raises(BagError, match=r'/topic_019 \(std_msgs/msg/String\) and 280 more$'):
        BagReader(tmp_path / 'bag').resolve('heading')


def test_a_bag_cut_before_its_topics_says_so(write_bag):
    path = write_bag() / 'trial_0.mcap'
    path.write_bytes(path.read_bytes()[:60])
    with pytest.raises(BagError, match=r'it has no topics \(trial_0.mcap was not closed: '):
        BagReader(path).headings({'ts/heading': 'enu'})


def test_the_quality_of_service_is_that_of_the_publisher(tmp_path):
    qos = Qos(depth=100, durability='transient_local')
    with BagWriter(tmp_path / 'bag') as bag:
        bag.add_topic('/marker', STRING, qos)
    assert BagReader(bag.path).topics == {'/marker': TopicInfo(STRING, 0, qos)}


def test_a_topic_that_is_no_heading_is_refused(tmp_path):
    reader = BagReader(mcap_file(tmp_path / 'a.mcap', remarks(3)))
    with pytest.raises(BagError, match=f'topic /a is {STRING}; a heading is {IMU}'):
        reader.headings({'a': 'enu'})


def test_an_unknown_convention_is_refused(write_bag):
    with pytest.raises(BagError, match="convention of topic ts/heading = 'NED': use 'enu' or"):
        BagReader(write_bag()).headings({'ts/heading': 'NED'})


@pytest.mark.parametrize('options, problem', [
    ({'text': 'std_msgs/Header header\n'}, 'std_msgs/Header is not defined'),
    ({'text': shipped_schema(IMU).text.replace('orientation_cov', 'cov')}, 'field covariance'),
    ({'schema': 'ros2idl'}, "encoding 'ros2idl'"), ({'encoding': 'json'}, "'json', not cdr")])
def test_a_heading_of_another_layout_is_refused(tmp_path, options, problem):
    path = mcap_file(tmp_path / 'a.mcap', [('/ts/heading', encode(IMU, {}))], IMU, **options)
    with pytest.raises(BagError, match=problem) as caught:
        BagReader(path).headings({'ts/heading': 'enu'})
    assert f'topic /ts/heading ({IMU}) cannot be read' in str(caught.value)


GOOD = encode(IMU, {'orientation': {'w': 1.0}})
#: Too short, a name that reaches beyond the end, JSON, no bytes at all.
BAD = [GOOD[:20], GOOD[:12] + b'\xff\xff\xff\x7f' + GOOD[16:], b'{"orientation": 1}', b'']


@pytest.mark.parametrize('helpers', [0, 2])
@pytest.mark.parametrize('bad', BAD)
def test_an_unreadable_message_is_an_invalid_reading_at_its_log_time(tmp_path, bad, helpers):
    path = mcap_file(tmp_path / 'a.mcap', [('/ts', GOOD)] * 3 + [('/ts', bad), ('/ts', GOOD)], IMU)
    log = [message.log_time_ns for message in BagReader(path).messages()]
    reader = BagReader(path)
    chunks = list(reader.headings({'/ts': 'enu'}, helpers))
    found = Headings.concatenate([chunk['/ts'] for chunk in chunks])
    assert np.isnan(found.heading_deg).tolist() == [False] * 3 + [True, False]
    assert found.stamp_ns[3] == log[3]
    assert [text.partition(';')[0] for text in reader.oddities] == [
        '1 messages cannot be read and count as invalid readings']


def test_nothing_but_unreadable_messages_takes_no_time(tmp_path):
    def timed(messages):
        path = mcap_file(tmp_path / 'a.mcap', [('/ts', m) for m in messages], IMU)
        took_s = []
        # The least of several: another process may hold one up.
        for _ in range(4):
            began_s = time.process_time()
            found = read(path, {'/ts': 'enu'})['/ts']
            took_s.append(time.process_time() - began_s)
        return found, min(took_s)

    _, few_s = timed([BAD[n % 4] for n in range(10_000)])
    found, many_s = timed([BAD[n % 4] for n in range(40_000)])
    assert many_s < 10.0 * few_s, 'in proportion: 4 times'
    assert len(found) == 40_000 and np.isnan(found.heading_deg).all()


def test_a_channel_in_another_encoding_is_unreadable_beside_a_sound_one(tmp_path):
    """Its bytes are not taken for headings, even if they could be."""
    (tmp_path / 'bag').mkdir()
    mcap_file(tmp_path / 'bag' / 'a_0.mcap', [('/ts', GOOD)] * 2, IMU)
    mcap_file(tmp_path / 'bag' / 'a_1.mcap', [('/ts', GOOD)] * 3, IMU, encoding='json')
    reader = BagReader(tmp_path / 'bag')
    found = Headings.concatenate([chunk['/ts'] for chunk in reader.headings({'/ts': 'enu'})])
    assert np.isnan(found.heading_deg).sum() == 3 and len(found) == 5
    assert 'encoded as' in reader.oddities[-1]


@pytest.mark.parametrize('first', [False, True])
def test_a_channel_without_a_schema_is_unreadable_beside_a_sound_one(tmp_path, first):
    path = tmp_path / 'a.mcap'
    with open(path, 'wb') as file:
        writer = Writer(file)
        writer.start('ros2')
        number = writer.register_schema(IMU, 'ros2msg', shipped_schema(IMU).text.encode())
        channels = [writer.register_channel('/ts', 'cdr', schema)
                    for schema in ((0, number) if first else (number, 0))]
        for i in range(5):
            writer.add_message(channels[i == 3], 1000 + i, GOOD, 2000 + i, i)
        writer.finish()
    reader = BagReader(path)
    assert (reader.topics['/ts'].type_name, reader.topics['/ts'].count) == (IMU, 5)
    found = Headings.concatenate([chunk['/ts'] for chunk in reader.headings({'/ts': 'enu'})])
    bad = 4 if first else 1
    assert np.isnan(found.heading_deg).sum() == bad and len(found) == 5
    assert reader.oddities[-1].startswith(f'{bad} messages') and 'no schema' in reader.oddities[-1]


def test_a_bag_that_is_moved_is_the_same_bag(write_bag, tmp_path):
    path = write_bag()
    expected = read(path, BOTH)
    shutil.move(path, tmp_path / 'elsewhere')
    assert read(tmp_path / 'elsewhere', BOTH) == expected
