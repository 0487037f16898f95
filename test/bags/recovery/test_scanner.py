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

"""Intact records of files that are cut, flipped and zero-filled at every byte."""

from __future__ import annotations

from io import BytesIO

from mcap.writer import CompressionType, Writer
import numpy as np
import pytest

from heading_intercompare.bags.mcap.chunk_writer import ChunkWriter
from heading_intercompare.bags.mcap.message_blocks import HEAD
from heading_intercompare.bags.mcap.record_stream import MAGIC
from heading_intercompare.bags.recovery.scanner import Gap, Salvage, Sound
from heading_intercompare.messages.cdr import encode

N = 36
PER_CHUNK = 8


class Bytes(BytesIO):
    """The part of a file that the writer of chunks needs."""

    def fileno(self) -> int:
        raise OSError


def small_file(compression: str) -> bytes:
    """Return a file of `N` short messages, numbered, in chunks of about `PER_CHUNK`."""
    file = Bytes()
    writer = ChunkWriter(file, compression, 400, 'test')
    number = writer.add_channel('/remark', 'std_msgs/msg/String', 'string data\n', {})
    writer.add_metadata('settings', {'a': 'b'})
    for i in range(N):
        text = encode('std_msgs/msg/String', {'data': f'{i * 7919 % 1000:03d} abcdef'})
        writer.add(number, text, 10**18 + i, 10**18 + i, i)
    writer.add_attachment('runs.csv', 'text/csv', b'start,stop\n', 5)
    writer.finish()
    return file.getvalue()


def scanned(data: bytes) -> list:
    return list(Salvage(BytesIO(data)).scan())


def blocks_of(item: Sound | Gap) -> list:
    if isinstance(item, Gap):
        return []
    return list(item.part.blocks()) if item.part else [item.block] if item.block else []


def messages(found: list) -> dict[int, bytes]:
    """Return the messages by sequence, each with its times."""
    kept = {}
    for item in found:
        for block in blocks_of(item):
            for head, lo, hi in zip(block.heads.tolist(), block.start, block.stop):
                assert head[3] not in kept, 'a message came twice'
                kept[head[3]] = bytes(block.data[lo:hi]) + repr(head[2:]).encode()
    return kept


def chunks(data: bytes) -> list[tuple[int, int, int]]:
    """Return where the chunks of a whole file start and end, and their numbers of messages."""
    return [(chunk.start, chunk.end, sum(count for _, count in chunk.counts))
            for item in scanned(data) if item.run for chunk in item.run.chunks]


@pytest.mark.parametrize('compression', ['none', 'lz4', 'zstd'])
def test_a_whole_file_has_no_gap(compression):
    data = small_file(compression)
    found = scanned(data)
    assert not any(isinstance(item, Gap) or item.part for item in found)
    assert sorted(messages(found)) == list(range(N))
    assert len(chunks(data)) >= 4


@pytest.mark.slow
@pytest.mark.parametrize('compression', ['none', 'lz4', 'zstd'])
def test_cut_at_any_byte_everything_before_the_cut_is_kept(compression):
    data = small_file(compression)
    whole, rows = messages(scanned(data)), chunks(data)
    for size in range(len(data)):
        kept = messages(scanned(data[:size]))
        assert kept.items() <= whole.items()
        assert len(kept) >= sum(count for _, end, count in rows if end <= size), size


def test_of_a_chunk_that_the_file_ends_in_the_messages_before_are_kept():
    data = small_file('none')
    (_, _, count), (second, end, _) = chunks(data)[:2]
    assert len(messages(scanned(data[:(second + end) // 2]))) > count
    assert len(messages(scanned(data[:second + 60]))) == count


@pytest.mark.slow
@pytest.mark.parametrize('compression, bits', [
    ('none', 0x01), ('none', 0x80), ('none', 0xff), ('lz4', 0x01), ('zstd', 0x80)])
def test_flipped_at_any_byte_only_the_chunk_around_is_lost(compression, bits):
    """No message is changed: the CRC of the chunk, 32 bits, finds every burst of 8 bits."""
    data = small_file(compression)
    whole, rows = messages(scanned(data)), chunks(data)
    for at in range(0, len(data)):
        found = scanned(data[:at] + bytes([data[at] ^ bits]) + data[at + 1:])
        kept = messages(found)
        assert kept.items() <= whole.items(), at
        around = sum(count for start, end, count in rows if start <= at < end)
        assert len(kept) >= N - around, at


@pytest.mark.slow
def test_zeros_written_over_any_stretch_lose_only_the_chunks_they_touch():
    data = small_file('zstd')
    whole, rows = messages(scanned(data)), chunks(data)
    for at in range(0, len(data) - 100, 7):
        kept = messages(scanned(data[:at] + bytes(100) + data[at + 100:]))
        assert kept.items() <= whole.items(), at
        touched = sum(count for start, end, count in rows if start < at + 100 and at < end)
        assert len(kept) >= N - touched, at


@pytest.mark.slow
@pytest.mark.parametrize('cut', [1, 50, 333])
def test_bytes_missing_in_the_middle_lose_only_the_chunks_they_touch(cut):
    data = small_file('lz4')
    rows = chunks(data)
    for at in range(0, len(data) - cut, 11):
        kept = messages(scanned(data[:at] + data[at + cut:]))
        touched = sum(count for start, end, count in rows if start < at + cut and at < end)
        assert len(kept) >= N - touched, at


@pytest.mark.parametrize('data', [b'', b'\0', MAGIC, MAGIC * 9, bytes(5000), b'\xff' * 5000,
                                  b'no bag at all, but a text\n' * 100])
def test_what_is_no_file_of_mcap_gives_nothing(data):
    assert messages(scanned(data)) == {}


def test_two_files_in_a_row_are_both_read():
    data = small_file('zstd')
    found = scanned(data + data)
    assert not any(isinstance(item, Gap) for item in found)
    assert sum(item.block is not None and len(item.block.start) for item in found) == 2 * N


@pytest.mark.slow
@pytest.mark.parametrize('crcs', [True, False])
@pytest.mark.parametrize('chunking', [True, False])
def test_files_of_the_mcap_library_survive_a_flip(chunking, crcs, rng):
    file = BytesIO()
    writer = Writer(file, chunk_size=400, compression=CompressionType.NONE, enable_crcs=crcs,
                    use_chunking=chunking)
    writer.start('ros2', 'test')
    schema = writer.register_schema('std_msgs/msg/String', 'ros2msg', b'string data\n')
    channel = writer.register_channel('/remark', 'cdr', schema)
    for i in range(N):
        writer.add_message(channel, 10**18 + i, b'\0\1\0\0' + bytes([4, 0, 0, 0]) + b'abc\0',
                           10**18 + i, i)
    writer.finish()
    data = file.getvalue()
    assert len(messages(scanned(data))) == N
    largest = max([count for _, _, count in chunks(data)], default=2)
    for at in rng.integers(0, len(data), 300).tolist():
        kept = messages(scanned(data[:at] + bytes([data[at] ^ 0x40]) + data[at + 1:]))
        assert len(kept) >= N - largest, at


def test_a_chunk_that_claims_gigabytes_is_not_believed():
    data = small_file('zstd')
    start, end, count = chunks(data)[2]
    size_at = start + HEAD.size + 16
    for claimed in (2**31 - 1, 2**40, 2**63):
        broken = data[:size_at] + claimed.to_bytes(8, 'little') + data[size_at + 8:]
        assert len(messages(scanned(broken))) == N, 'its checksum proves what it was'
        broken = broken[:size_at + 8] + b'\1\2\3\4' + broken[size_at + 12:]
        assert len(messages(scanned(broken))) == N - count


def test_a_gap_says_where_it_is_and_that_it_was_a_chunk():
    data = small_file('zstd')
    start, end, _ = chunks(data)[3]
    middle = (start + end) // 2
    gaps = [item for item in scanned(data[:middle] + b'\x55\xaa\x55' + data[middle + 3:])
            if isinstance(item, Gap)]
    assert [(gap.start, gap.end, gap.chunk) for gap in gaps] == [(start, end, True)]
    assert 'damaged' in gaps[0].fault


def test_random_bytes_give_no_message(rng):
    noise = rng.integers(0, 256, 300_000).astype(np.uint8).tobytes()
    assert messages(scanned(MAGIC + noise)) == {}
    data = small_file('zstd')
    assert len(messages(scanned(data + noise))) == N
    assert len(messages(scanned(noise + data))) == N
