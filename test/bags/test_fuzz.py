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

"""
Bags with bytes flipped, cut and repeated: one clear error or the data that is there, nothing else.

`make release` looks longer than CI does.
"""

from __future__ import annotations

from collections import Counter
from functools import lru_cache
from pathlib import Path
import resource
import shutil
import struct
import tempfile
import time
import tracemalloc
from typing import Callable, Iterator
import zlib

from bags.mcap_bytes import assert_exact, record, sent
import lz4.frame
from mcap.opcode import Opcode
from mcap.records import Chunk
from mcap.writer import CompressionType, IndexType, Writer
import numpy as np
import pytest
import zstandard

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.recovery.recover_bag import recover
from heading_intercompare.bags.recovery.scanner import Salvage, Sound
from heading_intercompare.bags.rosbag2.bag_check import check_bag
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.core.records import Headings
from heading_intercompare.messages.cdr import encode
from heading_intercompare.messages.heading_messages import encode_imu, IMU
from heading_intercompare.messages.schemas import shipped_schema

hypothesis = pytest.importorskip('hypothesis')
st = hypothesis.strategies

STRING = 'std_msgs/msg/String'


def by_us(compression: str) -> bytes:
    """Return a file of this package: headings, a text, metadata, an attachment."""
    stamps = 10**18 + np.arange(200) * 10**8
    with tempfile.TemporaryDirectory() as folder:
        with BagWriter(Path(folder, 'x'), BagSettings(compression=compression,
                                                      chunk_bytes=8000)) as bag:
            bag.metadata('heading_intercompare', {'version': '1'})
            for topic in ('/ts/heading', '/rs/heading'):
                bag.add_topic(topic, IMU)
                rows = encode_imu(Headings.of(stamps, np.linspace(0.0, 359.0, 200)), 'gyro')
                bag.write_rows([Rows(topic, rows, stamps)])
            bag.add_topic('/remark', STRING)
            bag.write('/remark', encode(STRING, {'data': 'x'}), 10**18)
            bag.attachment('runs.csv', 'text/csv', b'start,stop\n')
        return Path(folder, 'x', 'x_0.mcap').read_bytes()


def by_mcap(**options) -> bytes:
    """Return a file of the mcap library."""
    with tempfile.TemporaryFile() as file:
        writer = Writer(file, chunk_size=4000, **options)
        writer.start('ros2')
        number = writer.register_schema(IMU, 'ros2msg', shipped_schema(IMU).text.encode())
        channels = [writer.register_channel(t, 'cdr', number)
                    for t in ('/ts/heading', '/rs/heading')]
        rows = encode_imu(Headings.of(10**18 + np.arange(60), np.arange(60.0)), 'gyro')
        for i, row in enumerate(rows):
            writer.add_message(channels[i % 2], 10**18 + i, row.tobytes(), 10**18 + i, i)
        writer.add_metadata('settings', {'a': 'b'})
        writer.finish()
        file.seek(0)
        return file.read()


@lru_cache(maxsize=None)
def originals() -> tuple[bytes, ...]:
    return (*(by_us(c) for c in ('none', 'lz4', 'zstd')),
            by_mcap(compression=CompressionType.NONE, use_chunking=False),
            by_mcap(compression=CompressionType.ZSTD, enable_crcs=False),
            by_mcap(compression=CompressionType.LZ4, index_types=IndexType.NONE))


#: Those of them with chunks that have checksums.
PROTECTED = (0, 1, 2, 5)


@lru_cache(maxsize=None)
def messages(which: int) -> Counter:
    """Return the messages of an original without their topics, which are found elsewhere."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, 'x.mcap')
        path.write_bytes(originals()[which])
        return Counter(message[1:] for message in sent(path))


def unproved(path: Path) -> int:
    """Return the number of messages of a chunk in which the file ends."""
    with open(path, 'rb') as file:
        return sum(len(block.start) for item in Salvage(file).scan()
                   if isinstance(item, Sound) and item.part for block in item.part.blocks())


SHARE = st.floats(0.0, 1.0, exclude_max=True)
SIZE = st.integers(1, 3000)
DAMAGE = st.one_of(
    st.tuples(st.just('flip'), SHARE, st.integers(1, 255)),
    st.tuples(st.just('cut'), SHARE, SIZE),
    st.tuples(st.just('end'), SHARE, SIZE),
    st.tuples(st.just('zero'), SHARE, SIZE),
    st.tuples(st.just('repeat'), SHARE, SIZE),
    st.tuples(st.just('swap'), SHARE, SIZE),
    # Lengths and counts that claim much.
    st.tuples(st.just('huge'), SHARE, st.integers(1, 8)))


def damaged(data: bytes, damages: list[tuple[str, float, int]]) -> bytes:
    """Return the bytes after each of the damages."""
    for kind, share, size in damages:
        at = int(share * len(data))
        head, piece, tail = data[:at], data[at:at + size], data[at + size:]
        if kind == 'flip' and data:
            data = head + bytes([data[at] ^ size]) + data[at + 1:]
        elif kind == 'cut':
            data = head + tail
        elif kind == 'end':
            data = head
        elif kind == 'zero':
            data = head + bytes(len(piece)) + tail
        elif kind == 'repeat':
            data = head + piece + piece + tail
        elif kind == 'swap':
            data = tail + piece + head
        elif kind == 'huge':
            data = head + b'\xff' * len(piece) + tail
    return data


def read_all(path: Path) -> int:
    """Use all of the reader; return the number of messages read before the first error."""
    count = 0
    try:
        reader = BagReader(path)
        reader.metadata()
        reader.attachments()
        for _ in reader.messages():
            count += 1
        for _ in reader.headings(dict.fromkeys(set(reader.topics) & {'/ts/heading',
                                                                     '/rs/heading'}, 'enu')):
            pass
    except BagError as error:
        assert '\n' not in str(error)
    return count


def recovered(path: Path, target: Path) -> list:
    """Recover a file; check that the result is complete and matches its record."""
    try:
        total = recover(path, target)
    except BagError as error:
        assert 'nothing in it is readable' in str(error) and '\n' not in str(error)
        return []
    assert BagReader(target).incomplete is None
    assert_exact(target)
    found = sent(target)
    assert len(found) == total.messages == sum(total.counts.values())
    assert 0 <= total.bytes_lost <= total.bytes and total.messages_lost >= 0
    return found


def megabytes() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


@hypothesis.given(which=st.integers(0, 5), damages=st.lists(DAMAGE, min_size=1, max_size=4))
def examine(which: int, damages: list[tuple[str, float, int]]) -> None:
    """Read and recover one damaged file."""
    folder = Path(tempfile.mkdtemp(prefix='fuzz_'))
    try:
        path = folder / 'x.mcap'
        path.write_bytes(damaged(originals()[which], damages))
        began_s = time.monotonic()
        read_all(path)
        found = recovered(path, folder / 'new')
        assert time.monotonic() - began_s < 30.0
        if which in PROTECTED:
            # Of a chunk in which the file ends nobody can tell whether its checksum is right.
            proved = found[:len(found) - unproved(path)]
            kept = Counter(message[1:] for message in proved)
            assert kept.keys() <= messages(which).keys(), 'a message was changed'
            if all(kind != 'repeat' for kind, _, _ in damages):
                assert kept <= messages(which), 'a message came twice'
    finally:
        shutil.rmtree(folder)


@pytest.mark.slow
def test_damaged_bags_never_end_in_anything_but_one_clear_error():
    """The peak memory may grow by no more than the files, their chunks and a library."""
    originals()
    before = megabytes()
    examine()
    assert megabytes() - before < 300.0


@pytest.mark.parametrize('which', range(6))
def test_the_originals_are_whole(which, tmp_path):
    (tmp_path / 'x.mcap').write_bytes(originals()[which])
    found = recovered(tmp_path / 'x.mcap', tmp_path / 'new')
    assert read_all(tmp_path / 'x.mcap') == len(found) > 50
    assert found == sent(tmp_path / 'x.mcap')


def records_in(data: bytes) -> Iterator[tuple[int, int]]:
    """Yield the first byte of each record of a whole file, and the byte after it."""
    at = 8
    while at < len(data) - 8:
        end = at + 9 + int.from_bytes(data[at + 1:at + 9], 'little')
        yield at, end
        at = end


def places(data: bytes) -> list[int]:
    """Return bytes in the head, the middle and at the end of each record of a whole file."""
    found = {0, 4, len(data) - 8, len(data) - 1}
    for at, end in records_in(data):
        found |= {at + 4, (at + 9 + end) // 2, end - 1}
    return sorted(found)


def unfinished(which: int) -> bytes:
    """Return an original up to the end of its data."""
    data = originals()[which]
    return data[:next(at for at, _ in records_in(data) if data[at] == Opcode.DATA_END)]


def damaged_once(which: int, folder: Path, change: Callable[[bytes, int], bytes]) -> list[int]:
    """Recover an original changed at each of its `places`; return how many messages are left."""
    data = originals()[which]
    (folder / 'x.mcap').write_bytes(data)
    whole, left = Counter(sent(folder / 'x.mcap')), []
    for at in places(data):
        (folder / 'x.mcap').write_bytes(change(data, at))
        found = Counter(recovered(folder / 'x.mcap', folder / 'new'))
        assert which == 3 or found <= whole, at
        left.append(sum(found.values()))
        shutil.rmtree(folder / 'new', ignore_errors=True)
    return left


@pytest.mark.slow
@pytest.mark.parametrize('which', [2, 3])
def test_cut_in_any_part_of_any_record_all_messages_before_are_recovered(which, tmp_path):
    left = damaged_once(which, tmp_path, lambda data, at: data[:at])
    assert left == sorted(left) and left[0] == 0 and left[-1] == sum(messages(which).values())


@pytest.mark.slow
@pytest.mark.parametrize('which', [0, 3, 5])
def test_flipped_in_any_part_of_any_record_few_messages_are_lost(which, tmp_path):
    """One chunk, or the messages around it; nothing appears under another topic."""
    left = damaged_once(which, tmp_path,
                        lambda data, at: data[:at] + bytes([data[at] ^ 0x20]) + data[at + 1:])
    total = sum(messages(which).values())
    assert min(left) > 0.6 * total and np.mean(left) > 0.85 * total


def zeros_of_gigabytes(compression: str) -> bytes:
    """
    Return a chunk of hardly any bytes that claims, and with zstd has, almost 2 GB of zeros.

    The chunk `records` has millions of records without content.
    """
    size = 2**31 - 1
    if compression == 'zstd':
        # A frame of blocks that repeat one byte; the first three say how often, 128 kB at most.
        blocks, rest = divmod(size, 2**17)
        packed = (b'\x28\xb5\x2f\xfd\x80\x38' + size.to_bytes(4, 'little')
                  + ((2**17 << 3) + 2).to_bytes(3, 'little').ljust(4, b'\0') * blocks
                  + ((rest << 3) + 3).to_bytes(3, 'little') + b'\0')
        assert zstandard.frame_content_size(packed) == size
    elif compression == 'unsized':
        compression = 'zstd'
        packed = zstandard.ZstdCompressor(write_content_size=False).compress(bytes(10**7))
        assert zstandard.frame_content_size(packed) == -1
    elif compression == 'records':
        compression = 'zstd'
        size = 9 * 2**24
        packed = zstandard.compress((b'\x80' + bytes(8)) * 2**24)
    else:
        packed = lz4.frame.compress(bytes(2**24))
    return record(Chunk(compression=compression, data=packed, message_start_time=0,
                        message_end_time=0, uncompressed_crc=0, uncompressed_size=size))


@pytest.mark.parametrize('place', ['middle', 'cut'])
@pytest.mark.parametrize('compression', ['zstd', 'unsized', 'lz4'])
def test_a_chunk_that_claims_gigabytes_takes_no_memory(compression, place, tmp_path):
    """After the others of a file without an end; cut, the file ends within it."""
    piece = zeros_of_gigabytes(compression)
    path = tmp_path / 'x.mcap'
    path.write_bytes(unfinished(2) + (piece if place == 'middle' else piece[:-4]))
    recover(path, tmp_path / 'warm')
    tracemalloc.start()
    try:
        total = recover(path, tmp_path / 'new')
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert total.messages == sum(messages(2).values())
    assert total.chunks_lost == 1 and peak < 100e6


def test_a_chunk_of_millions_of_empty_records_is_damaged(tmp_path):
    path = tmp_path / 'x.mcap'
    path.write_bytes(unfinished(2) + zeros_of_gigabytes('records'))
    total = recover(path, tmp_path / 'new')
    assert total.messages == sum(messages(2).values()) and total.chunks_lost == 1


def test_heads_of_chunks_within_heads_of_chunks_do_not_take_forever(tmp_path):
    """Each claims to reach past all others, and could be disproved only by reading it."""
    count, zeros = 40_000, bytes(1000)
    heads = b''.join(
        b'\x06' + struct.pack('<QQQQIIQ', left - 9, 1, 2, left - 49, 1, 0, left - 49)
        + b'\x03' + bytes(11) for left in range(61 * count + 500, 500, -61))
    path = tmp_path / 'x.mcap'
    path.write_bytes(unfinished(2) + heads + zeros + unfinished(2))
    began_s = time.monotonic()
    total = recover(path, tmp_path / 'new')
    assert time.monotonic() - began_s < 30.0
    assert total.messages == 2 * sum(messages(2).values())


@pytest.mark.slow
def test_many_small_gaps_do_not_take_forever(tmp_path):
    """After each the next record is near, and only nearby bytes are searched."""
    piece = b'\0\x0f' + struct.pack('<QI', 4, 0)
    path = tmp_path / 'x.mcap'
    path.write_bytes(unfinished(2) + 3000 * piece + bytes(10**7))
    began_s = time.monotonic()
    total = recover(path, tmp_path / 'new')
    assert time.monotonic() - began_s < 30.0
    assert total.messages == sum(messages(2).values()) and len(total.notes) == 100


HOSTILE = ('swap chunks', 'cut payload', 'strange payload', 'long name', 'forged index',
           'pasted twice', 'reversed chunks')


def hostile(data: bytes, kind: str, rng: np.random.Generator) -> bytes:
    """Return a file of this package changed by somebody who keeps every checksum right."""
    spans = list(records_in(data))
    begins = [at for at, _ in spans if data[at] == Opcode.CHUNK]
    # A chunk with the message indexes after it, up to the next chunk or other record.
    pieces = []
    for at in begins:
        end = next(stop for start, stop in spans if start == at)
        while data[end] == Opcode.MESSAGE_INDEX:
            end = next(stop for start, stop in spans if start == end)
        pieces.append((at, end))
    first, last = pieces[0][0], pieces[-1][1]
    chunks = [data[lo:hi] for lo, hi in pieces]
    if sum(map(len, chunks)) != last - first:
        return data
    if kind == 'swap chunks':
        a, b = rng.choice(len(chunks), 2, replace=False)
        chunks[a], chunks[b] = chunks[b], chunks[a]
    elif kind == 'reversed chunks':
        chunks.reverse()
    elif kind == 'pasted twice':
        return data + data
    elif kind == 'forged index':
        changed = bytearray(data)
        place = int(rng.integers(last, len(data) - 8))
        changed[place:place + 8] = rng.bytes(8)
        return bytes(changed)
    else:
        bad = {'cut payload': b'\0\1\0\0', 'strange payload': b'{"a": 1}',
               'long name': b'\0\1\0\0' + bytes(8) + b'\xff\xff\xff\x7f' + bytes(40)}[kind]
        message = b'\x05' + struct.pack('<QHIQQ', 22 + len(bad), 1, 7, 10**18, 10**18) + bad
        chunks.insert(int(rng.integers(len(chunks))), record(Chunk(
            compression='', data=message, message_start_time=10**18, message_end_time=10**18,
            uncompressed_crc=zlib.crc32(message), uncompressed_size=len(message))))
        # Its index would name other places: leave the file without an end.
        return data[:first] + b''.join(chunks)
    return data[:first] + b''.join(chunks) + data[last:]


def examine_hostile(count: int) -> None:
    """Read, check and recover files with a fixed seed; nothing foreign comes in."""
    for number in range(count):
        rng = np.random.default_rng(number)
        which, kind = number % 3, HOSTILE[number % len(HOSTILE)]
        with tempfile.TemporaryDirectory(prefix='hostile_') as folder:
            path = Path(folder, 'x.mcap')
            path.write_bytes(hostile(originals()[which], kind, rng))
            read_all(path)
            assert all('\n' not in fault for fault in check_bag(path).faults)
            found = Counter(message[1:] for message in recovered(path, Path(folder, 'new')))
            foreign = found - messages(which) - (
                messages(which) if kind == 'pasted twice' else Counter())
            assert sum(foreign.values()) <= ('payload' in kind or kind == 'long name'), kind
            if 'chunks' in kind:
                assert found == messages(which)
                chunks = list(BagReader(Path(folder, 'new')).headings({'/ts/heading': 'enu'}))
                stamps = np.concatenate([chunk['/ts/heading'].stamp_ns for chunk in chunks])
                assert (np.diff(stamps) > 0).all(), kind


def test_what_nothing_proves_ends_in_no_traceback_and_costs_no_proved_message(tmp_path):
    """Random damage with a fixed seed: `unproven` keeps every message that recovery keeps."""
    unsure = 0
    for number in range(24):
        rng = np.random.default_rng(number)
        path = tmp_path / f'{number}.mcap'
        path.write_bytes(damaged(originals()[number % 3], [
            (('flip', 'zero', 'huge')[int(rng.integers(3))], rng.uniform(0.05, 0.9),
             int(rng.integers(1, 200))) for _ in range(3)]))
        try:
            sure = recover(path, tmp_path / f'sure_{number}')
            found = recover(path, tmp_path / f'all_{number}', unproven=True)
        except BagError as error:
            assert '\n' not in str(error)
            continue
        assert found.messages >= sure.messages
        kept = Counter(message[1:] for message in sent(tmp_path / f'all_{number}'))
        assert Counter(message[1:] for message in sent(tmp_path / f'sure_{number}')) <= kept
        unsure += found.messages_unproven
    assert unsure > 0


def test_hostile_bags_are_read_refused_or_recovered():
    examine_hostile(2 * len(HOSTILE))


@pytest.mark.slow
@pytest.mark.endurance
def test_five_hundred_hostile_bags_are_read_refused_or_recovered():
    examine_hostile(500)
