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

"""The check of a whole bag: every kind of damage is found, and gaps in the numbers are counted."""

from __future__ import annotations

from io import BytesIO
import struct
import zlib

from bags.mcap_bytes import channel, indexed, message, schema, write
from deadlines import Stopwatch
from mcap.writer import CompressionType, Writer
import numpy as np
import pytest

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.bag_check import check_bag
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.messages.heading_messages import encode_imu, IMU


@pytest.fixture
def three_files(tmp_path, two_sensors):
    """Return a bag of both sensors in three files; one topic is numbered."""
    ts, rs = two_sensors
    with BagWriter(tmp_path / 'trial', BagSettings(chunk_bytes=20_000)) as bag:
        for topic in ('/ts/heading', '/rs/heading'):
            bag.add_topic(topic, IMU)
        for part in range(3):
            if part:
                bag.split()
            for topic, all_of_it, numbered in (('/ts/heading', ts, 1), ('/rs/heading', rs, 0)):
                n = len(all_of_it)
                some = np.arange(n * part // 3, n * (part + 1) // 3)
                bag.write_rows([Rows(topic, encode_imu(all_of_it[some], 'x'),
                                     all_of_it.stamp_ns[some], sequence=some * numbered)])
    return bag.path


def test_a_sound_bag_is_read_through(three_files):
    told = []
    found = check_bag(three_files, told.append)
    assert (found.files, found.messages, found.unprotected) == (3, 3000, 0)
    assert found.faults == [] and found.chunks > 10
    assert told[-1] == '3,000 messages'
    ts, rs = (found.topics[name] for name in ('/ts/heading', '/rs/heading'))
    assert (ts.numbered, ts.missing, ts.restarts) == (True, 0, 0)
    assert not rs.numbered


def test_a_gap_is_counted_across_files(tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.add_topic('/x', 'std_msgs/msg/String')
        for number in (3, 4, 8):
            bag.write('/x', b'\0\1\0\0\1\0\0\0\0', number, None, number)
        bag.split()
        bag.write('/x', b'\0\1\0\0\1\0\0\0\0', 20, None, 11)
    assert check_bag(tmp_path / 'bag').topics['/x'].missing == 5


@pytest.mark.slow
def test_every_byte_that_turns_over_is_seen_or_does_no_harm(write_bag, rng):
    """Each of many single damages is a fault, or the bag reads the same as before."""
    path = write_bag(chunk_bytes=20_000)
    file, = path.glob('*.mcap')
    sound = file.read_bytes()
    before = list(BagReader(path).messages())
    seen = 0
    for at in rng.integers(0, len(sound), 60).tolist():
        content = bytearray(sound)
        content[at] ^= 0x10
        file.write_bytes(content)
        if check_bag(path).faults:
            seen += 1
        else:
            assert list(BagReader(path).messages()) == before
    assert seen > 40


def damaged(write_bag, find):
    """Return the faults of a bag after flipping a byte near some others."""
    path = write_bag(chunk_bytes=20_000)
    with BagWriter(path.with_name('other')) as bag:
        bag.attachment('log.txt', 'text/plain', b'a service log, 2026')
        bag.metadata('remark', {'text': 'nothing'})
    file, = (path if find != b'service' else bag.path).glob('*.mcap')
    content = bytearray(file.read_bytes())
    content[content.index(find) if isinstance(find, bytes) else find] ^= 0x01
    file.write_bytes(content)
    return check_bag(file.parent).faults


def test_a_damaged_chunk_is_named_with_its_place(write_bag):
    (fault,) = damaged(write_bag, 5000)
    assert fault.startswith('trial_0.mcap: chunk damaged: ') and '(at byte ' in fault


def test_a_damaged_attachment_is_named(write_bag):
    (fault,) = damaged(write_bag, b'service')
    assert fault.startswith('other_0.mcap: attachment damaged: its checksum does not match (at')


def test_a_damaged_index_is_named_and_its_messages_are_there(write_bag):
    (fault,) = damaged(write_bag, -10)
    assert fault == ('trial_0.mcap: the checksum of its index does not match; its messages are '
                     'there')


def test_files_that_are_missing_cut_or_empty_are_named(three_files):
    path, names = three_files, [f'trial_{number}.mcap' for number in range(3)]
    (path / names[0]).unlink()
    (path / names[1]).write_bytes(b'')
    content = (path / names[2]).read_bytes()
    (path / names[2]).write_bytes(content[:-1000])
    found = check_bag(path)
    assert found.faults[:2] == [f'{names[0]} is missing', f'{names[1]}: is empty (0 bytes)']
    assert found.faults[2].startswith(f'{names[2]} was not closed')
    assert len(found.faults) == 3 and found.messages > 100


def foreign(**options):
    """Return an MCAP file written by another library."""
    file = BytesIO()
    writer = Writer(file, chunk_size=500, compression=CompressionType.NONE, **options)
    writer.start('ros2', 'other')
    schema = writer.register_schema('std_msgs/msg/String', 'ros2msg', b'string data\n')
    channel = writer.register_channel('/x', 'cdr', schema)
    for i in range(100):
        writer.add_message(channel, i, b'\0\1\0\0\6\0\0\0hello\0', i, 0)
    writer.finish()
    return file.getvalue()


def test_chunks_without_a_checksum_are_counted(tmp_path):
    (tmp_path / 'x.mcap').write_bytes(foreign(enable_crcs=False))
    found = check_bag(tmp_path / 'x.mcap')
    assert found.unprotected == found.chunks > 5
    assert found.faults == [] and found.messages == 100


def test_the_checksum_of_all_the_data_is_verified_where_there_is_one(tmp_path):
    content = foreign(enable_data_crcs=True)
    (tmp_path / 'x.mcap').write_bytes(content)
    assert check_bag(tmp_path / 'x.mcap').faults == []
    end = content.index(struct.pack('<BQ', 0x0F, 4)) + 9
    assert struct.unpack_from('<I', content, end)[0] == zlib.crc32(content[:end - 9]) != 0
    wrong = bytearray(content)
    wrong[end] ^= 1
    (tmp_path / 'x.mcap').write_bytes(wrong)
    assert check_bag(tmp_path / 'x.mcap').faults == [
        'x.mcap: the checksum of all its data does not match']


def test_messages_outside_chunks_are_read(tmp_path):
    (tmp_path / 'x.mcap').write_bytes(foreign(use_chunking=False))
    found = check_bag(tmp_path / 'x.mcap')
    assert (found.messages, found.chunks, found.faults) == (100, 0, [])


def test_the_remains_of_a_chunk_with_which_a_file_breaks_off_are_not_looked_at(tmp_path):
    content = foreign()
    begin = content.index(struct.pack('<BQ', 0x0F, 4))
    (tmp_path / 'x.mcap').write_bytes(content[:begin] + struct.pack('<BQ', 6, 5) + bytes(5))
    found = check_bag(tmp_path / 'x.mcap')
    assert found.messages == 100
    (fault,) = found.faults
    assert fault.startswith('x.mcap was not closed: chunk damaged: its head is cut')


def test_what_is_no_bag_is_refused(tmp_path):
    with pytest.raises(BagError, match='holds no .mcap file'):
        check_bag(tmp_path)
    with pytest.raises(FileNotFoundError):
        check_bag(tmp_path / 'nowhere.mcap')
    (tmp_path / 'text.mcap').write_bytes(b'no bag')
    assert check_bag(tmp_path / 'text.mcap').faults == ['text.mcap: is not an MCAP file']


def test_settings_of_the_chunks_do_not_matter(write_bag):
    for compression in ('none', 'lz4', 'zstd'):
        path = write_bag(compression, compression=compression)
        assert check_bag(path).faults == [] and check_bag(path).messages == 3000


def test_time_of_a_check_grows_with_the_channels_of_a_chunk_not_with_their_square(tmp_path):
    """Each channel is defined just before its message: 20 000 took a quarter of a minute."""
    count = 20_000
    path = write(tmp_path / 'x.mcap', indexed(schema(1), *(
        channel(n, f'/topic_{n}') + message(n, n, b'x') for n in range(count))))
    watch = Stopwatch()
    check = check_bag(path)
    assert watch.passed_s < 8.0
    assert (check.messages, len(check.topics)) == (count, count)
