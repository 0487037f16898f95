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

"""Bags we write: how other libraries read them, what is on the disk, what a full disk leaves."""

from __future__ import annotations

import errno
from io import FileIO
import shutil

from mcap.reader import make_reader
from mcap.records import Chunk, ChunkIndex, MessageIndex
from mcap.stream_reader import StreamReader
import numpy as np
import pytest

from heading_intercompare import replaced_file
from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.chunk_writer import ChunkWriter, Rows
from heading_intercompare.bags.recording import bag_writer
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.bag_yaml import Qos
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.messages.cdr import decode, encode
from heading_intercompare.messages.heading_messages import IMU
from heading_intercompare.messages.schemas import schema_of, TYPE_HASHES

STRING = 'std_msgs/msg/String'


def text(words: str) -> bytes:
    return encode(STRING, {'data': words})


def as_fields(message: object) -> object:
    """Return a decoded message of another library as our decoder would."""
    if hasattr(message, 'tolist'):
        return message.tolist()
    if isinstance(message, (list, tuple)):
        return [as_fields(m) for m in message]
    if isinstance(message, (str, int, float)):
        return message
    names = getattr(message, '__slots__', None) or vars(message)
    return {n: as_fields(getattr(message, n)) for n in names if n != '__msgtype__'}


@pytest.mark.slow
@pytest.mark.parametrize('compression', ['none', 'lz4', 'zstd'])
def test_rosbags_decodes_every_message(write_bag, compression):
    anyreader = pytest.importorskip('rosbags.highlevel')
    path = write_bag(compression=compression)
    ours = {(m.topic, m.log_time_ns): decode(IMU, m.data) for m in BagReader(path).messages()}
    with anyreader.AnyReader([path]) as bag:
        theirs = {(c.topic, stamp): as_fields(bag.deserialize(data, c.msgtype))
                  for c, stamp, data in bag.messages()}
    assert len(theirs) == 3000
    assert theirs == ours


@pytest.mark.slow
@pytest.mark.parametrize('compression', ['none', 'lz4', 'zstd'])
def test_mcap_ros2_decodes_every_message(write_bag, compression):
    decoder = pytest.importorskip('mcap_ros2.decoder')
    path = write_bag(compression=compression)
    ours = [(m.topic, m.log_time_ns, m.publish_time_ns, m.sequence, decode(IMU, m.data))
            for m in BagReader(path).messages()]
    with open(path / 'trial_0.mcap', 'rb') as file:
        reader = make_reader(file, validate_crcs=True,
                             decoder_factories=[decoder.DecoderFactory()])
        theirs = [(c.topic, m.log_time, m.publish_time, m.sequence, as_fields(d))
                  for _, c, m, d in reader.iter_decoded_messages()]
    assert len(theirs) == 3000
    assert theirs == ours


def test_metadata_yaml_says_what_rosbags_and_yaml_find(write_bag, two_sensors):
    rosbag2 = pytest.importorskip('rosbags.rosbag2')
    yaml = pytest.importorskip('yaml')
    ts, rs = two_sensors
    path = write_bag()
    start_ns, end_ns = int(ts.stamp_ns[0]), int(max(ts.stamp_ns[-1], rs.stamp_ns[-1] + 500))
    row = yaml.safe_load((path / 'metadata.yaml').read_text())['rosbag2_bagfile_information']
    assert row['version'] == 9 and row['storage_identifier'] == 'mcap'
    assert row['starting_time'] == {'nanoseconds_since_epoch': start_ns}
    assert row['duration'] == {'nanoseconds': end_ns - start_ns}
    assert row['relative_file_paths'] == ['trial_0.mcap']
    with rosbag2.Reader(path) as bag:
        assert bag.message_count == 3000
        assert bag.start_time == start_ns
        assert {c.topic: (c.msgtype, c.msgcount, c.digest) for c in bag.connections} == {
            '/ts/heading': (IMU, 2000, TYPE_HASHES[IMU]),
            '/rs/heading': (IMU, 1000, TYPE_HASHES[IMU])}
        assert bag.connections[0].ext.offered_qos_profiles[0].depth == 1000


def test_the_record_rosbag2_is_written_at_open_and_at_close(write_bag):
    yaml = pytest.importorskip('yaml')
    path = write_bag()
    with open(path / 'trial_0.mcap', 'rb') as file:
        records = [m for m in make_reader(file).iter_metadata() if m.name == 'rosbag2']
    first, last = (yaml.safe_load(r.metadata['serialized_metadata']) for r in records)
    assert first['message_count'] == 0 and last['message_count'] == 3000
    whole = yaml.safe_load((path / 'metadata.yaml').read_text())
    assert {'rosbag2_bagfile_information': last} == whole


def test_schema_qos_and_hash_are_in_the_channel(tmp_path):
    qos = Qos(depth=100, durability='transient_local')
    with BagWriter(tmp_path / 'bag') as bag:
        bag.add_topic('/remark', STRING, qos)
        bag.write('/remark', text('x'), 1)
    with open(tmp_path / 'bag' / 'bag_0.mcap', 'rb') as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        assert reader.get_header().profile == 'ros2'
    schema, channel = summary.schemas[1], summary.channels[1]
    assert (schema.name, schema.encoding) == (STRING, 'ros2msg')
    assert schema.data.decode() == schema_of(STRING).text
    assert channel.topic == '/remark' and channel.message_encoding == 'cdr'
    assert channel.metadata == {'offered_qos_profiles': qos.to_yaml(),
                                'topic_type_hash': TYPE_HASHES[STRING]}


def test_chunks_have_the_size_asked_for_and_a_checksum(write_bag):
    path = write_bag(chunk_bytes=20_000)
    with open(path / 'trial_0.mcap', 'rb') as file:
        chunks = [r for r in StreamReader(file, emit_chunks=True).records if isinstance(r, Chunk)]
    sizes = [c.uncompressed_size for c in chunks]
    assert len(chunks) > 50 and all(c.uncompressed_crc for c in chunks)
    assert min(sizes[:-1]) >= 20_000 and max(sizes) < 20_400


def test_indexes_point_at_the_messages(write_bag):
    path = write_bag(chunk_bytes=20_000)
    data = (path / 'trial_0.mcap').read_bytes()
    with open(path / 'trial_0.mcap', 'rb') as file:
        records = list(StreamReader(file, emit_chunks=True).records)
    chunks = {c.message_start_time: c for c in records if isinstance(c, Chunk)}
    for index in (r for r in records if isinstance(r, ChunkIndex)):
        chunk = chunks[index.message_start_time]
        assert data[index.chunk_start_offset] == 6
        assert index.message_end_time == chunk.message_end_time
        assert index.compressed_size == len(chunk.data)
        assert {data[at] for at in index.message_index_offsets.values()} == {7}
    entries = sum(len(r.records) for r in records if isinstance(r, MessageIndex))
    assert entries == 3000


def test_rows_at_once_are_single_messages(write_bag, tmp_path):
    with BagWriter(tmp_path / 'single') as bag:
        for topic in ('/ts/heading', '/rs/heading'):
            bag.add_topic(topic, IMU)
        for m in BagReader(write_bag()).messages():
            bag.write(m.topic, m.data, m.log_time_ns, m.publish_time_ns, m.sequence)
    assert list(BagReader(bag.path).messages()) == list(BagReader(tmp_path / 'trial').messages())
    ours, theirs = (tmp_path / 'single/single_0.mcap', tmp_path / 'trial/trial_0.mcap')
    assert list(BagReader(ours).messages()) == list(BagReader(theirs).messages())


def test_rows_of_several_topics_are_merged_by_log_time(tmp_path):
    with BagWriter(tmp_path / 'bag', BagSettings(chunk_bytes=1024)) as bag:
        bag.add_topic('a', STRING)
        bag.add_topic('b', STRING)
        rows = np.frombuffer(text('aa') + text('bb'), np.uint8).reshape(2, -1)
        bag.write_rows([Rows('a', np.repeat(rows[:1], 100, 0), np.arange(100) * 10),
                        Rows('/b', np.repeat(rows[1:], 50, 0), np.arange(50) * 20 + 10),
                        Rows('b', rows[:0], [])])
    found = [(m.log_time_ns, m.topic) for m in BagReader(bag.path).messages()]
    expected = [(i * 10, '/a') for i in range(100)] + [(i * 20 + 10, '/b') for i in range(50)]
    assert found == sorted(expected)


def test_no_rows_write_nothing(tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.add_topic('/a', STRING)
        bag.write_rows([])
        bag.write_rows([Rows('/a', np.empty((0, 8), np.uint8), [])])
    assert list(BagReader(bag.path).messages()) == []
    assert BagReader(bag.path).incomplete is None


def test_what_was_flushed_is_on_the_disk(tmp_path):
    bag = BagWriter(tmp_path / 'bag')
    bag.add_topic('/remark', STRING)
    bag.write('/remark', text('one'), 1)
    bag.flush()
    bag.write('/remark', text('two'), 2)
    shutil.copytree(bag.path, tmp_path / 'killed')
    bag.close()
    killed = BagReader(tmp_path / 'killed')
    assert [m.data for m in killed.messages()] == [text('one')]
    assert 'was not closed' in killed.incomplete
    assert [m.data for m in BagReader(bag.path).messages()] == [text('one'), text('two')]


def test_a_flush_is_due_once_an_interval(tmp_path):
    with BagWriter(tmp_path / 'bag', BagSettings(flush_interval_s=1.0)) as bag:
        bag.add_topic('/remark', STRING)
        due = []
        for tenth in range(35):
            bag.write('/remark', text('x'), tenth)
            due.append(bag.flush_if_due(1000.0 + tenth / 8))
    assert [i for i, flushed in enumerate(due) if flushed] == [8, 16, 24, 32]


def test_a_flush_without_messages_writes_no_chunk(tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.add_topic('/remark', STRING)
        size = (bag.path / 'bag_0.mcap').stat().st_size
        bag.flush()
        assert (bag.path / 'bag_0.mcap').stat().st_size == size


def test_metadata_and_attachments_come_back(tmp_path):
    with BagWriter(tmp_path / 'bag', software='tester 1') as bag:
        bag.add_topic('/remark', STRING)
        bag.metadata('settings', {'norms.sigma_max_deg': 0.2, 'model': 'NN'})
        bag.write('/remark', text('x'), 5)
        bag.attachment('runs.csv', 'text/csv', b'start,stop\n', 7)
        bag.metadata('settings', {'norms.sigma_max_deg': 0.3})
    reader = BagReader(bag.path)
    assert reader.metadata()['settings'] == {'norms.sigma_max_deg': '0.3'}
    attachment, = reader.attachments()
    assert (attachment.name, attachment.media_type) == ('runs.csv', 'text/csv')
    assert (attachment.data, attachment.log_time_ns) == (b'start,stop\n', 7)
    with open(bag.path / 'bag_0.mcap', 'rb') as file:
        assert make_reader(file).get_header().library == 'tester 1'


@pytest.mark.parametrize('make', ['mkdir', 'touch'])
def test_an_existing_path_is_not_overwritten(tmp_path, make):
    getattr(tmp_path / 'bag', make)()
    with pytest.raises(BagError, match='bag: already exists'):
        BagWriter(tmp_path / 'bag')


def test_a_link_that_leads_to_itself_is_not_overwritten(tmp_path):
    (tmp_path / 'bag').symlink_to('bag')
    with pytest.raises(BagError, match='bag: already exists'):
        BagWriter(tmp_path / 'bag')


def test_a_folder_that_cannot_be_made_is_an_os_error(tmp_path):
    (tmp_path / 'file').touch()
    with pytest.raises(OSError):
        BagWriter(tmp_path / 'file' / 'bag')


class FullFile(FileIO):
    """A file on a disk that takes `room` bytes."""

    def __init__(self, path, mode, room: int) -> None:
        super().__init__(path, mode)
        self.room = room

    def write(self, data) -> int:
        if self.tell() + len(data) > self.room:
            raise OSError(errno.ENOSPC, 'No space left on device')
        return super().write(data)


@pytest.mark.parametrize('room, file', [(0, 'bag_0.mcap'), (100, 'bag_0.mcap'),
                                        (10**6, 'metadata.yaml')])
def test_a_bag_that_cannot_be_begun_names_the_file_and_leaves_nothing(
        tmp_path, monkeypatch, room, file):
    with monkeypatch.context() as patch:
        patch.setattr(bag_writer, 'open', lambda path, mode, **_: FullFile(path, mode, room),
                      raising=False)
        patch.setattr(replaced_file, 'open', lambda path, mode, **_: FullFile(path, mode, 0),
                      raising=False)
        with pytest.raises(OSError) as caught:
            BagWriter(tmp_path / 'bag')
    assert caught.value.filename == str(tmp_path / 'bag' / file)
    assert not (tmp_path / 'bag').exists()
    BagWriter(tmp_path / 'bag').close()


def test_a_name_that_is_too_long_for_the_files_leaves_no_folder(tmp_path):
    with pytest.raises(OSError, match='File name too long'):
        BagWriter(tmp_path / ('x' * 252))
    assert list(tmp_path.iterdir()) == []


def test_a_topic_that_was_not_added_is_refused(tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.add_topic('/remark', STRING)
        with pytest.raises(BagError, match='/remrk was not added; the topics added are /remark'):
            bag.write('/remrk', b'', 1)


def test_a_topic_has_one_type(tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.add_topic('/remark', STRING)
        bag.add_topic('remark', STRING)
        with pytest.raises(BagError, match=f'/remark is already {STRING}'):
            bag.add_topic('/remark', IMU)
        assert bag.topics == ('/remark',)


@pytest.mark.parametrize('time_ns', [-1, 2**63])
def test_a_time_that_mcap_cannot_hold_is_refused(tmp_path, time_ns):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.add_topic('/remark', STRING)
        with pytest.raises(BagError, match=f'{time_ns} ns'):
            bag.write('/remark', b'', time_ns)


def test_a_setting_out_of_range_is_refused():
    with pytest.raises(SettingsError, match="compression = 'gzip'"):
        BagSettings(compression='gzip')


def test_closing_twice_does_nothing(tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.close()
    bag.close()
    assert BagReader(bag.path).incomplete is None


def test_a_bag_is_closed_when_its_writer_fails(tmp_path):
    with pytest.raises(ZeroDivisionError):
        with BagWriter(tmp_path / 'bag') as bag:
            bag.add_topic('/remark', STRING)
            bag.write('/remark', text('last'), 1)
            raise ZeroDivisionError
    reader = BagReader(tmp_path / 'bag')
    assert reader.incomplete is None and reader.topics['/remark'].count == 1


class SmallDisk:
    """A file on a disk that takes `room` bytes, in pieces of at most 100."""

    def __init__(self, path, room: int) -> None:
        self.file = open(path, 'wb', buffering=0)
        self.room = room

    def write(self, data) -> int:
        bite = min(len(data), 100, self.room - self.file.tell())
        if bite <= 0:
            raise OSError(errno.ENOSPC, 'No space left on device')
        return self.file.write(data[:bite])

    def __getattr__(self, name):
        return getattr(self.file, name)


@pytest.mark.parametrize('room', range(800, 8000, 700))
def test_a_full_disk_leaves_whole_chunks_and_the_rest_can_be_written_later(tmp_path, room, rng):
    path = tmp_path / 'small.mcap'
    disk = SmallDisk(path, room)
    writer = ChunkWriter(disk, 'none', 1000, 'test')
    number = writer.add_channel('/remark', STRING, 'string data\n', {})
    failures = 0
    for i in range(200):
        try:
            writer.add(number, text(f'{i:03d}'), i, i, i)
        except OSError as error:
            assert (error.errno, error.filename) == (errno.ENOSPC, str(path))
            assert path.stat().st_size == writer.size
            failures += 1
    if failures:
        kept = list(BagReader(path).messages())
        assert [m.sequence for m in kept] == list(range(len(kept)))
        disk.room = 10**6
    writer.finish()
    disk.close()
    assert failures or room > 7000
    reader = BagReader(path)
    assert reader.incomplete is None
    assert [m.sequence for m in reader.messages()] == list(range(200))


def test_a_full_disk_at_the_end_is_an_os_error(tmp_path, monkeypatch):
    bag = BagWriter(tmp_path / 'bag')
    bag.add_topic('/remark', STRING)
    bag.write('/remark', text('x'), 1)
    bag.flush()

    def full(*_):
        raise OSError(errno.ENOSPC, 'No space left on device')
    monkeypatch.setattr(ChunkWriter, '_append', full)
    with pytest.raises(OSError, match='No space left'):
        bag.close()
    assert BagReader(bag.path).topics['/remark'].count == 1


def test_a_file_of_somebody_else_is_left_alone_by_a_split(tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        (bag.path / 'bag_1.mcap').write_bytes(b'mine')
        bag.split()
    assert (bag.path / 'bag_1.mcap').read_bytes() == b'mine'
    assert (bag.path / 'bag_2.mcap').exists()


def test_what_was_taken_out_of_memory_leaves_the_definitions_there(tmp_path):
    bag = BagWriter(tmp_path / 'bag')
    bag.add_topic('/remark', STRING)
    bag.write('/remark', text('x'), 1)
    taken, = bag.take_pending()
    bag.write(*taken)
    bag.flush()
    # A file without a summary, as after a kill.
    assert [m.data for m in BagReader(bag.path).messages()] == [text('x')]
    bag.close()


def test_a_split_takes_what_is_in_memory_along(tmp_path, monkeypatch):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.add_topic('/remark', STRING)
        bag.write('/remark', text('x'), 1)
        old, end_chunk = bag.chunks, ChunkWriter.end_chunk

        def fail(chunks):
            if chunks is old:
                raise OSError(errno.ENOSPC, 'No space left on device')
            end_chunk(chunks)
        monkeypatch.setattr(ChunkWriter, 'end_chunk', fail)
        bag.split()
    assert [m.data for m in BagReader(bag.path / 'bag_1.mcap').messages()] == [text('x')]


def test_headings_come_back_from_the_bag(write_bag, two_sensors):
    found = {'ts/heading': [], 'rs/heading': []}
    for chunk in BagReader(write_bag()).headings(dict.fromkeys(found, 'enu')):
        for topic, part in chunk.items():
            found[topic].append(part)
    for parts, sent in zip(found.values(), two_sensors):
        received = type(sent).concatenate(parts)
        assert np.array_equal(received.stamp_ns, sent.stamp_ns)
        assert np.array_equal(np.isnan(received.heading_deg), np.isnan(sent.heading_deg))
        assert np.nanmax(np.abs(received.heading_deg - sent.heading_deg)) < 1e-11
