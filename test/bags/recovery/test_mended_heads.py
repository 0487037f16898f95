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

"""Chunks whose head is damaged, but which their checksum and the index of the file prove."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
import struct
import zlib

from bags.mcap_bytes import assert_exact, channel, indexed, message, record, schema, sent, write
import lz4.frame
from mcap.records import Chunk
from mcap.writer import CompressionType, Writer
import pytest

from heading_intercompare.bags.recovery.recover_bag import recover
from heading_intercompare.bags.recovery.scanner import Salvage
from heading_intercompare.messages.cdr import encode

STRING = 'std_msgs/msg/String'
TWO = schema(1), channel(1, '/a')
#: Where the fields of a chunk lie from its opcode on, as far as no checksum is needed for them.
LENGTH, TIMES, SIZE, CRC, LETTERS, NAME, PACKED = 1, 9, 25, 33, 37, 41, 45
COMPRESSIONS = ['', 'lz4', 'zstd']


def ten(begin: int) -> list[bytes]:
    return [message(1, begin + n, encode(STRING, {'data': f'{begin + n} ' + 'x' * n}), sequence=n)
            for n in range(10)]


def flipped(data: bytes, bit: int) -> bytes:
    at = bit // 8
    return data[:at] + bytes([data[at] ^ 1 << bit % 8]) + data[at + 1:]


def recovered(path: Path) -> tuple[list, object]:
    total = recover(path, path.with_suffix('.new'))
    assert_exact(path.with_suffix('.new'))
    return sent(path.with_suffix('.new')), total


@pytest.mark.slow
@pytest.mark.parametrize('compression', COMPRESSIONS)
@pytest.mark.parametrize('alone', [True, False])
def test_no_bit_of_a_head_but_those_of_the_checksum_loses_a_chunk(tmp_path, compression, alone):
    """Of the only chunk of a file, and of one between others."""
    piece = indexed(*TWO, *ten(2000), compression=compression)
    before, after = (b'', b'') if alone else (indexed(*TWO, *ten(1000)), indexed(*ten(3000)))
    path = write(tmp_path / 'x.mcap', before, piece, after)
    recover(path, tmp_path / 'whole')
    whole, head = sent(tmp_path / 'whole'), PACKED - 4 + len(compression) + 8
    for bit in range(8 * head):
        if CRC <= bit // 8 < LETTERS:
            continue
        write(path, before, flipped(piece, bit), after)
        messages = [item for item in Salvage(BytesIO(path.read_bytes())).scan()
                    if getattr(item, 'run', None)]
        assert sum(len(item.block.start) for item in messages) == len(whole), bit


@pytest.mark.parametrize('compression', COMPRESSIONS)
@pytest.mark.parametrize('at', [LENGTH, LENGTH + 2, SIZE, SIZE + 3, LETTERS, NAME, PACKED])
def test_a_chunk_with_a_damaged_head_is_copied_whole_and_noted(tmp_path, compression, at):
    if at == NAME and not compression:
        pytest.skip('it has no name')
    piece = indexed(*TWO, *ten(2000), compression=compression)
    path = write(tmp_path / 'x.mcap', flipped(piece, 8 * at), indexed(*ten(3000)))
    messages, total = recovered(path)
    assert [m.log_time_ns for m in messages] == [*range(2000, 2010), *range(3000, 3010)]
    assert (total.messages_lost, total.chunks_lost, total.bytes_lost) == (0, 0, 0)
    assert total.notes[0] == ('x.mcap: 1 chunk had a damaged head; the checksum proves what it '
                              'was')
    assert piece in next(path.with_suffix('.new').glob('*.mcap')).read_bytes()


def test_the_checksum_is_the_judge(tmp_path):
    """A head that fits and a checksum that does not are no chunk, nor is a changed message."""
    piece = bytearray(flipped(indexed(*TWO, *ten(2000), compression=''), 8 * LENGTH))
    piece[200] ^= 1
    path = write(tmp_path / 'x.mcap', bytes(piece), indexed(*TWO, *ten(3000)))
    messages, total = recovered(path)
    assert [m.log_time_ns for m in messages] == [*range(3000, 3010)] and total.chunks_lost == 1


def by_mcap(compression: CompressionType) -> tuple[bytes, int]:
    """Return a closed file of one chunk, and where its chunk is."""
    file = BytesIO()
    writer = Writer(file, compression=compression)
    writer.start('ros2')
    number = writer.register_channel('/a', 'cdr', writer.register_schema(
        STRING, 'ros2msg', b'string data\n'))
    for n in range(100):
        writer.add_message(number, n, encode(STRING, {'data': f'{n}'}), n)
    writer.finish()
    data = file.getvalue()
    at = 8
    while data[at] != 6:
        at += 9 + struct.unpack_from('<Q', data, at + 1)[0]
    return data, at


@pytest.mark.parametrize('compression', list(CompressionType))
@pytest.mark.parametrize('lost', [(0, CRC), (LETTERS, LETTERS + 8), (0, LENGTH), (SIZE, CRC)])
def test_the_index_of_the_file_gives_a_head_of_which_only_the_checksum_is_left(
        tmp_path, compression, lost):
    data, at = by_mcap(compression)
    begin, end = (at + place for place in lost)
    path = tmp_path / 'x.mcap'
    path.write_bytes(data[:begin] + b'\xee' * (end - begin) + data[end:])
    messages, total = recovered(path)
    assert [m.log_time_ns for m in messages] == [*range(100)]
    assert (total.messages_lost, total.messages_known) == (0, True)


def test_a_frame_that_does_not_say_its_size_needs_the_index(tmp_path):
    """As the C++ library writes lz4: the size is nowhere but in the head of the chunk."""
    records = b''.join((*TWO, *ten(1000)))
    piece = record(Chunk(compression='lz4', data=lz4.frame.compress(records, store_size=False),
                         message_start_time=1000, message_end_time=1009,
                         uncompressed_crc=zlib.crc32(records), uncompressed_size=len(records)))
    path = write(tmp_path / 'x.mcap', flipped(piece, 8 * SIZE), indexed(*TWO, *ten(2000)))
    messages, total = recovered(path)
    assert [m.log_time_ns for m in messages] == [*range(2000, 2010)] and total.chunks_lost == 1
