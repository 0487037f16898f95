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

"""Bags that rosbag2 compressed by file or by message are read, checked and recovered."""

from __future__ import annotations

from functools import partial
import os
from pathlib import Path
import re
import shutil
import signal
import subprocess
import sys
import tracemalloc
from types import SimpleNamespace
from typing import Callable

from bags.mcap_bytes import channel, chunk, message, schema, write
import numpy as np
import pytest
import zstandard

from heading_intercompare.bags import packed_files
from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.mcap_file import mcap_files
from heading_intercompare.bags.packed_files import unpack_payload
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.recovery import copier
from heading_intercompare.bags.recovery.recover_bag import recover
from heading_intercompare.bags.rosbag2.bag_check import check_bag
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.messages.heading_messages import encode_imu, IMU
from heading_intercompare.readers.registry import open_recording

TOPICS = ('/ts/heading', '/rs/heading')
BOTH = dict.fromkeys(TOPICS, 'enu')


def one_by_one(path: Path, two_sensors, pack: Callable[[bytes], bytes] = bytes,
               **settings) -> Path:
    """Write a bag message by message."""
    with BagWriter(path, BagSettings(**settings)) as bag:
        for topic, headings in zip(TOPICS, two_sensors):
            bag.add_topic(topic, IMU)
            for row, stamp in zip(encode_imu(headings, 'ts'), headings.stamp_ns.tolist()):
                bag.write(topic, pack(row.tobytes()), stamp)
    return path


def by_message(path: Path, two_sensors, **settings) -> Path:
    """Write a bag as `ros2 bag record --compression-mode message` does."""
    one_by_one(path, two_sensors, zstandard.ZstdCompressor().compress, **settings)
    text = (path / 'metadata.yaml').read_text()
    (path / 'metadata.yaml').write_text(text.replace(
        'compression_format: ""', 'compression_format: zstd').replace(
            'compression_mode: ""', 'compression_mode: MESSAGE'))
    return path


def by_file(path: Path) -> Path:
    """Compress the files of a bag as `ros2 bag record --compression-mode file` does."""
    for each in mcap_files(path):
        each.with_name(each.name + '.zstd').write_bytes(
            zstandard.ZstdCompressor().compress(each.read_bytes()))
        each.unlink()
    text = (path / 'metadata.yaml').read_text()
    (path / 'metadata.yaml').write_text(text.replace('.mcap', '.mcap.zstd'))
    return path


@pytest.fixture(params=['by message', 'by file'])
def packed(request, two_sensors, write_bag, tmp_path) -> Path:
    if request.param == 'by message':
        return by_message(tmp_path / 'packed', two_sensors)
    return by_file(write_bag('packed', split_bytes=200_000))


def columns(path: Path) -> list[list]:
    chunks = list(open_recording(path).headings(BOTH))
    return [np.concatenate([getattr(chunk[topic], name) for chunk in chunks]).tolist()
            for topic in TOPICS for name in ('stamp_ns', 'heading_deg')]


def payloads(path: Path) -> list[bytes]:
    return [bytes(messages.data[start:stop]) for topic in TOPICS
            for messages in BagReader(path).payloads(topic)
            for start, stop in zip(messages.start.tolist(), messages.stop.tolist())]


def test_a_compressed_bag_is_read_like_another(packed, write_bag):
    np.testing.assert_array_equal(columns(packed)[0], columns(write_bag('plain'))[0])
    for one, other in zip(columns(packed), columns(write_bag('again'))):
        np.testing.assert_array_equal(one, other)
    assert payloads(packed) == [message.data for topic in TOPICS
                                for message in BagReader(packed).messages([topic])]
    assert BagReader(packed).incomplete is None
    assert check_bag(packed).faults == []


def test_a_recovered_bag_is_one_that_everybody_can_read(packed, write_bag, tmp_path):
    total = recover(packed, tmp_path / 'new')
    assert total.messages == 3000 and not total.damaged
    assert 'compression_mode: ""' in (tmp_path / 'new' / 'metadata.yaml').read_text()
    from rosbags.rosbag2 import Reader
    with Reader(tmp_path / 'new') as reader:
        data = {raw[:4] for _, _, raw in reader.messages()}
    assert data == {b'\0\1\0\0'}
    assert check_bag(tmp_path / 'new').faults == []
    for one, other in zip(columns(tmp_path / 'new'), columns(write_bag('plain'))):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize('share', [0.2, 0.5, 0.7, 0.85])
@pytest.mark.parametrize('kind', ['by message', 'by file'])
def test_of_a_killed_compressed_bag_reading_and_recovery_name_the_same_end(
        kind, share, two_sensors, tmp_path):
    """rosbag2 compresses a file when it begins the next one: the last file is still plain."""
    if kind == 'by message':
        path = by_message(tmp_path / 'packed', two_sensors, chunk_bytes=8000)
    else:
        path = by_file(one_by_one(tmp_path / 'packed', two_sensors, split_bytes=60_000,
                                  chunk_bytes=8000))
        last = max(path.glob('*.zstd'))
        last.with_suffix('').write_bytes(zstandard.decompress(last.read_bytes()))
        last.unlink()
    (path / 'metadata.yaml').unlink()
    file = max(path.glob('*.mcap'))
    data = file.read_bytes()
    size = int(share * len(data))
    file.write_bytes(data[:size])
    reader = BagReader(path)
    read = [message.data for message in reader.messages()]
    total = recover(path, tmp_path / 'new')
    begin, end = re.search(r'at byte (\d+) of (\d+)', reader.incomplete).groups()
    # Just after a record there is no damage but the missing end.
    assert int(end) == size and (int(begin) == size or any(
        f'{file.name}: bytes {begin} to {end}: ' in note for note in total.notes))
    assert f'{file.name}: was not closed' in total.notes
    new = BagReader(tmp_path / 'new')
    kept = [message.data for message in new.messages()]
    assert new.incomplete is None and kept[:len(read)] == read
    assert {data[:4] for data in kept} == {b'\0\1\0\0'}


def bomb(path: Path, count: int, zeros: int) -> Path:
    """Write messages that take a thousand times their size when they are unpacked."""
    data = zstandard.ZstdCompressor().compress(b'\0\1\0\0' + bytes(zeros))
    sound = zstandard.ZstdCompressor().compress(b'\0\1\0\0')
    return write(path, chunk(schema(1), channel(1, '/a'), channel(2, '/b'), *(
        message(1 + n % 2, n, sound if n % 2 else data) for n in range(count))))


@pytest.mark.slow
def test_payloads_that_unpack_to_gigabytes_are_unpacked_one_by_one(tmp_path):
    path = bomb(tmp_path / 'x.mcap', 200, 2**23)
    assert path.stat().st_size < 100_000
    tracemalloc.start()
    try:
        total = recover(path, tmp_path / 'new')
        sizes = [len(found.data) for found in BagReader(path).messages()]
        assert check_bag(path).messages == 200
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert total.messages == 200 and sum(sizes) > 8e8 and peak < 100e6


def test_a_payload_that_cannot_be_unpacked_is_lost_and_counted(tmp_path, monkeypatch):
    monkeypatch.setattr(copier, 'unpack_payload', partial(unpack_payload, most=1000))
    total = recover(bomb(tmp_path / 'x.mcap', 20, 2000), tmp_path / 'new')
    assert (total.messages, total.messages_lost, total.counts) == (10, 10, {'/a': 0, '/b': 10})
    assert any('10 messages cannot be decompressed' in note for note in total.notes)
    new = BagReader(tmp_path / 'new')
    assert [found.data for found in new.messages()] == 10 * [b'\0\1\0\0']
    assert new.metadata()['recovery']['messages'] == '10'


def test_a_compressed_file_that_is_cut_before_its_first_block_is_named(two_sensors, tmp_path):
    path = by_file(one_by_one(tmp_path / 'trial', two_sensors, split_bytes=60_000,
                              chunk_bytes=8000))
    first = path / 'trial_0.mcap.zstd'
    first.write_bytes(first.read_bytes()[:12])
    reader = BagReader(path)
    why = 'is empty or cut: nothing of it can be unpacked'
    assert f'trial_0.mcap.zstd {why}' in reader.incomplete
    assert 0 < len(list(reader.messages())) < 3000
    for command in (BagReader, lambda place: recover(place, tmp_path / 'new')):
        with pytest.raises(BagError, match=f'trial_0.mcap.zstd: {why}') as caught:
            command(first)
        assert str(caught.value).startswith(str(first))


def test_damage_in_a_compressed_file_is_named_by_the_place_of_the_bag(write_bag):
    path = write_bag('trial', chunk_bytes=5000, compression='none')
    file = path / 'trial_0.mcap'
    data = bytearray(file.read_bytes())
    data[data.index(b'ts', len(data) // 3)] ^= 1
    file.write_bytes(data)
    reader = BagReader(by_file(path))
    with pytest.raises(BagError, match=f'^{re.escape(str(file))}: '):
        list(reader.messages())


def test_messages_come_unpacked(packed, write_bag):
    plain = [message.data for message in BagReader(write_bag('plain')).messages(TOPICS[:1])]
    assert [message.data for message in BagReader(packed).messages(TOPICS[:1])] == plain


def test_a_file_beside_its_compressed_one_is_read_once(write_bag):
    path = write_bag('trial')
    shutil.copy(path / 'trial_0.mcap', path.parent / 'kept')
    by_file(path)
    (path.parent / 'kept').rename(path / 'trial_0.mcap')
    assert [each.name for each in mcap_files(path)] == ['trial_0.mcap']
    assert BagReader(path).incomplete is None and len(list(BagReader(path).messages())) == 3000


def test_a_cut_compressed_file_is_read_up_to_the_cut_and_recovered(write_bag, tmp_path):
    path = by_file(write_bag('trial', chunk_bytes=5000))
    file = path / 'trial_0.mcap.zstd'
    file.write_bytes(file.read_bytes()[:-file.stat().st_size // 3])
    reader = BagReader(path)
    count = len(list(reader.messages()))
    assert 1000 < count < 3000 and 'was not closed' in reader.incomplete
    assert recover(path, tmp_path / 'new').messages >= count


def test_a_damaged_compressed_file_is_named(write_bag, tmp_path):
    path = by_file(write_bag('trial', chunk_bytes=5000))
    file = path / 'trial_0.mcap.zstd'
    data = bytearray(file.read_bytes())
    data[len(data) // 2:len(data) // 2 + 50] = bytes(50)
    file.write_bytes(data)
    try:
        reader = BagReader(path)
        assert 'is damaged' in reader.incomplete or 'was not closed' in reader.incomplete
    except BagError as error:
        assert 'trial_0.mcap' in str(error)


def count_open_files() -> int:
    return len(os.listdir('/proc/self/fd'))


def test_unpacked_files_have_no_name_and_last_as_long_as_their_reader(write_bag, monkeypatch,
                                                                      tmp_path):
    (tmp_path / 'temp').mkdir()
    monkeypatch.setattr('tempfile.tempdir', str(tmp_path / 'temp'))
    path = by_file(write_bag('trial'))
    files, before = len(mcap_files(path)), count_open_files()
    reader = BagReader(path)
    assert list((tmp_path / 'temp').iterdir()) == []
    assert count_open_files() == before + files
    assert len(list(reader.messages())) == len(list(reader.messages())) > 0
    del reader
    check_bag(path)
    recover(path, tmp_path / 'new')
    assert list((tmp_path / 'temp').iterdir()) == [] and count_open_files() == before


@pytest.mark.process
@pytest.mark.parametrize('number', [signal.SIGTERM, signal.SIGHUP, signal.SIGKILL])
@pytest.mark.parametrize('helpers', [0, 2])
def test_a_process_that_a_signal_ends_leaves_nothing_unpacked(write_bag, tmp_path, number,
                                                              helpers):
    (tmp_path / 'temp').mkdir()
    script = f"""if True:
        import os
        from heading_intercompare.bags.rosbag2.bag_reader import BagReader
        reader = BagReader({str(by_file(write_bag('trial', chunk_bytes=5000)))!r})
        next(reader.headings({BOTH!r}, helpers={helpers}))
        os.kill(os.getpid(), {int(number)})
    """
    ended = subprocess.run([sys.executable, '-c', script], check=False,
                           env={**os.environ, 'TMPDIR': str(tmp_path / 'temp')})
    assert ended.returncode == -number
    assert list((tmp_path / 'temp').iterdir()) == []


@pytest.mark.process
def test_a_bag_may_have_more_compressed_files_than_a_process_may_open(two_sensors, tmp_path):
    path = by_file(one_by_one(tmp_path / 'trial', two_sensors, split_duration_s=2.0,
                              chunk_bytes=1024))
    assert len(mcap_files(path)) > 30
    script = f"""if True:
        import resource
        from heading_intercompare.bags.rosbag2.bag_reader import BagReader
        _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (20, most))
        print(len([*BagReader({str(path)!r}).messages()]))
    """
    ended = subprocess.run([sys.executable, '-c', script], check=True, capture_output=True)
    assert int(ended.stdout) == len([*BagReader(path).messages()])


def test_a_file_that_unpacks_to_far_too_much_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(packed_files, '_MOST_FILE_BYTES', 2**22)
    file = tmp_path / 'x.mcap.zstd'
    file.write_bytes(zstandard.ZstdCompressor().compress(bytes(2**24)))
    with pytest.raises(BagError, match='unpacks to more than 4194304 bytes'):
        BagReader(file)


def test_a_file_that_would_fill_the_disk_is_refused(write_bag, monkeypatch):
    path = by_file(write_bag('trial'))
    monkeypatch.setattr(packed_files.shutil, 'disk_usage', lambda _: SimpleNamespace(free=2**28))
    with pytest.raises(BagError, match='set TMPDIR'):
        BagReader(path)


def test_a_message_that_claims_too_much_stays_packed():
    data = zstandard.ZstdCompressor().compress(bytes(10_000))
    assert unpack_payload(data) == bytes(10_000) and unpack_payload(data, 9_999) is None
    assert unpack_payload(data[:-3]) is None and unpack_payload(b'\0\1\0\0') is None


def skippable(content: bytes) -> bytes:
    """Return a frame of zstd that readers skip."""
    return b'\x50\x2a\x4d\x18' + len(content).to_bytes(4, 'little') + content


PACK = zstandard.ZstdCompressor().compress
FRAMES = {
    'two': lambda data: PACK(data[:9]) + PACK(data[9:]),
    'two without sizes': lambda data: b''.join(
        zstandard.ZstdCompressor(write_content_size=False).compress(part)
        for part in (data[:9], data[9:])),
    'a skippable one first': lambda data: skippable(PACK(b'other')) + PACK(data),
    'a skippable one between': lambda data: PACK(data[:9]) + skippable(b'x') + PACK(data[9:]),
    'a skippable one last': lambda data: PACK(data) + skippable(b''),
}


@pytest.mark.parametrize('join', FRAMES.values(), ids=FRAMES)
@pytest.mark.parametrize('by', ['message', 'file'])
def test_frames_of_zstd_are_joined(by, join, two_sensors, write_bag, tmp_path):
    """Each frame is a valid stream, and so are several: programs for many cores write them."""
    plain = write_bag('plain', chunk_bytes=20_000)
    if by == 'message':
        bag = one_by_one(tmp_path / 'packed', two_sensors, join)
    else:
        bag = tmp_path / 'packed.mcap.zstd'
        bag.write_bytes(join((plain / 'plain_0.mcap').read_bytes()))
    for packed_column, column in zip(columns(bag), columns(plain)):
        np.testing.assert_array_equal(packed_column, column)
    assert check_bag(bag).faults == []


@pytest.mark.parametrize('data', [
    b'', b'rubbish', PACK(b'ab')[:-1], PACK(b'ab') + PACK(b'cd')[:-1],
    skippable(b'ab')[:-1], PACK(b'ab') + PACK(bytes(100_000))])
def test_cut_and_too_large_frames_are_no_message(data):
    """The last one claims more than is allowed in its second frame only."""
    assert unpack_payload(data, 50_000) is None


def test_bytes_after_a_frame_change_no_message():
    assert unpack_payload(PACK(b'ab') + b'rubbish') == b'ab'
    assert unpack_payload(PACK(b'ab') + PACK(b'cd') + b'rubbish') == b'abcd'
