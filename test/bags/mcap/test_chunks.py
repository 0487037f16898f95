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

"""Consecutive chunks in reused memory: nothing of one block is left in the next."""

from __future__ import annotations

from io import BytesIO
import zlib

import lz4.frame
from mcap.opcode import Opcode
import numpy as np
import pytest
import zstandard

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.chunks import (
    begin_chunk,
    CHUNK_HEAD,
    Gathering,
    LargeChunk,
    unpack,
)
from heading_intercompare.bags.mcap.message_blocks import MESSAGE_HEAD

PACK = {'': bytes, 'lz4': lz4.frame.compress, 'zstd': zstandard.ZstdCompressor().compress}


def messages(first: int, count: int, size: int = 40) -> bytes:
    return b''.join(
        MESSAGE_HEAD.pack(Opcode.MESSAGE, 22 + size, 1, n, n, n) + bytes([n % 256]) * size
        for n in range(first, first + count))


def chunk(data: bytes, compression: str = '', *, size: int | None = None, crc: int | None = None,
          packed: bytes | None = None, inner: int | None = None) -> bytes:
    """Return the content of a chunk record; its head may be wrong."""
    packed = PACK[compression](data) if packed is None else packed
    return CHUNK_HEAD.pack(3, 7, len(data) if size is None else size,
                           zlib.crc32(data) if crc is None else crc, len(compression)) + (
        compression.encode() + (len(packed) if inner is None else inner).to_bytes(8, 'little')
        + packed)


def take(gathering: Gathering, content: bytes) -> None:
    """Take a chunk from its content."""
    file = BytesIO(content)
    gathering.take(file, begin_chunk(file, len(content)))


@pytest.mark.parametrize('compression', PACK)
def test_chunks_are_joined_in_their_order_and_memory_is_used_again(compression):
    gathering = Gathering()
    for first in (0, 100, 1000):
        gathering.clear()
        for lo in (first, first + 7):
            content = chunk(messages(lo, 7), compression)
            take(gathering, content)
        block = gathering.block()
        assert bytes(block.data) == messages(first, 14)
        assert block.heads['sequence'].tolist() == list(range(first, first + 14))
        assert [block.data[at] for at in block.start] == [
            n % 256 for n in range(first, first + 14)]


@pytest.mark.parametrize('compression', PACK)
def test_memory_grows_without_losing_what_was_taken(compression):
    gathering = Gathering()
    for number in range(6):
        content = chunk(messages(50 * number, 50, 10 ** (number % 4)), compression)
        take(gathering, content)
    assert gathering.block().heads['sequence'].tolist() == list(range(300))


def test_a_chunk_says_its_times_and_its_size_before_it_is_read():
    data = messages(3, 5)
    content = chunk(data, 'zstd')
    begun = begin_chunk(BytesIO(content), len(content))
    assert begun.said == (3, 7, len(data))
    assert (begun.at, begun.end, begun.is_large) == (0, len(content), False)


DATA = messages(0, 9)
DAMAGED = {
    'flipped': chunk(DATA, crc=zlib.crc32(DATA) ^ 1),
    'cut head': chunk(DATA)[:20],
    'no name': chunk(DATA)[:CHUNK_HEAD.size - 4] + (2**31).to_bytes(4, 'little') + bytes(40),
    'plain longer than the record': chunk(DATA, inner=len(DATA) + 1, size=len(DATA) + 1),
    'plain of another size': chunk(DATA, size=len(DATA) - 1),
    'claims two gigabytes': chunk(DATA, 'zstd', size=2**32),
    'zstd of another size': chunk(DATA, 'zstd', size=len(DATA) + 1),
    'lz4 of another size': chunk(DATA, 'lz4', size=len(DATA) - 1),
    'lz4 that is larger than can be': chunk(DATA, 'lz4', size=2**30),
    'lz4 without its end': chunk(DATA, 'lz4', packed=lz4.frame.compress(DATA)[:-6]),
    'no zstd': chunk(DATA, 'zstd', packed=b'rubbish'),
    'no lz4': chunk(DATA, 'lz4', packed=b'rubbish' * 50),
}


@pytest.mark.parametrize('content', DAMAGED.values(), ids=DAMAGED.keys())
def test_a_damaged_chunk_is_refused_and_what_was_taken_stays(content):
    with pytest.raises(BagError, match='chunk damaged'):
        unpack(content, zstandard.ZstdDecompressor())
    gathering, good = Gathering(), chunk(messages(20, 4))
    take(gathering, good)
    with pytest.raises(BagError, match='chunk damaged'):
        take(gathering, content)
    assert bytes(gathering.block().data) == messages(20, 4)


@pytest.mark.parametrize('compression', PACK)
def test_an_index_tells_where_messages_of_unequal_length_are(compression, monkeypatch):
    gathering, expected = Gathering(), []
    for lo in (0, 40):
        parts = [messages(n, 1, n % 13) for n in range(lo, lo + 40)]
        content = chunk(b''.join(parts), compression)
        take(gathering, content)
        offsets = np.cumsum([0, *map(len, parts[:-1])])
        entries = np.stack([np.arange(lo, lo + 40), offsets], axis=1).astype('<i8')
        for half in (entries[::2], entries[1::2]):
            gathering.add_index(half.tobytes())
        expected += range(lo, lo + 40)
    # The walk would find them too, but not be needed.
    monkeypatch.setattr('heading_intercompare.bags.mcap.message_blocks.walk', None)
    assert gathering.block().heads['sequence'].tolist() == expected


def skippable(compressed: bytes) -> bytes:
    """Return a frame that readers of zstd and lz4 skip, with any bytes in it."""
    return b'\x5a\x2a\x4d\x18' + len(compressed).to_bytes(4, 'little') + compressed


def zstd_without_size(data: bytes) -> bytes:
    return zstandard.ZstdCompressor(write_content_size=False).compress(data)


FRAMES = {
    'two': lambda pack, data: pack(data[:100]) + pack(data[100:]),
    'an empty one first': lambda pack, data: pack(b'') + pack(data),
    'a skippable one first': lambda pack, data: skippable(b'ab') + pack(data),
    'a skippable one between': lambda pack, data: (pack(data[:100]) + skippable(pack(data))
                                                   + pack(data[100:])),
    'a skippable one last': lambda pack, data: pack(data) + skippable(b''),
    'bytes after them': lambda pack, data: pack(data[:100]) + pack(data[100:]) + b'rubbish',
}


@pytest.mark.parametrize('join', FRAMES.values(), ids=FRAMES)
@pytest.mark.parametrize(('compression', 'pack'), [
    ('zstd', PACK['zstd']), ('zstd', zstd_without_size), ('lz4', PACK['lz4'])],
    ids=['zstd', 'zstd without sizes', 'lz4'])
def test_a_chunk_may_have_several_frames(join, compression, pack, monkeypatch):
    content = chunk(DATA, compression, packed=join(pack, DATA))
    assert bytes(unpack(content, zstandard.ZstdDecompressor())) == DATA
    gathering = Gathering()
    take(gathering, content)
    assert bytes(gathering.block().data) == DATA
    monkeypatch.setattr('heading_intercompare.bags.mcap.chunks._PACKED_BYTES', 7)
    large = LargeChunk(BytesIO(content), begin_chunk(BytesIO(content), len(content)))
    large.verify()
    assert b''.join(bytes(block.data) for block in large.blocks()) == DATA


@pytest.mark.parametrize('size', [len(DATA) - 1, len(DATA) - 101, len(DATA) + 1])
@pytest.mark.parametrize('compression', ['zstd', 'lz4'])
def test_frames_of_another_total_size_are_damage(compression, size):
    pack = PACK[compression]
    content = chunk(DATA[:size], compression, packed=pack(DATA[:100]) + pack(DATA[100:]),
                    size=size)
    large = LargeChunk(BytesIO(content), begin_chunk(BytesIO(content), len(content)))
    for refuse in (lambda: unpack(content, zstandard.ZstdDecompressor()),
                   lambda: take(Gathering(), content), large.verify):
        with pytest.raises(BagError, match='chunk damaged'):
            refuse()


@pytest.mark.parametrize('compression', ['zstd', 'lz4'])
def test_a_cut_second_frame_is_damage(compression):
    pack = PACK[compression]
    content = chunk(DATA, compression, packed=pack(DATA[:100]) + pack(DATA[100:])[:-9])
    with pytest.raises(BagError, match='chunk damaged'):
        unpack(content, zstandard.ZstdDecompressor())
