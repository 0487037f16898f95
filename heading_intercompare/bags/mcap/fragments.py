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

"""Clues in damaged bytes: where records may begin, and the records a cut chunk begins with."""

from __future__ import annotations

import struct
from typing import NamedTuple

import lz4.frame
from mcap.opcode import Opcode
import numpy as np
import zstandard

from heading_intercompare.core.records import Integers
from heading_intercompare.messages.byte_columns import BytesLike

from .chunks import CHUNK_HEAD
from .message_blocks import HEAD, INVALID_OPCODE, MESSAGE_HEAD
from .record_stream import MAGIC

#: Records that may be inside or outside a chunk.
BARE = (Opcode.MESSAGE, Opcode.SCHEMA, Opcode.CHANNEL)
#: Length of a message without payload.
MESSAGE_LEAST = MESSAGE_HEAD.size - HEAD.size
#: Longest name of a compression.
_LETTERS = 8
_COMPRESSIONS = ('', 'lz4', 'zstd')
_LENGTH = struct.Struct('<Q')
#: The longest head of a frame of lz4 or zstd.
_FRAME_HEAD = 19
#: Most bytes from the opcode of a chunk to its compressed records, and the head of their frame.
HEAD_BYTES = HEAD.size + CHUNK_HEAD.size + _LETTERS + _LENGTH.size + _FRAME_HEAD
#: A chunk that claims to be larger is not believed.
CHUNK_BYTES = 2**31


class ChunkHead(NamedTuple):
    """What a chunk says about itself; `packed` is the length of its compressed records."""

    length: int
    first_ns: int
    last_ns: int
    size: int
    crc: int
    compression: str
    packed: int

    @property
    def needed(self) -> int:
        """Return the least length that its fields need; it may be longer, as records may grow."""
        return CHUNK_HEAD.size + len(self.compression) + _LENGTH.size + self.packed

    def build(self) -> bytes:
        """Return its bytes, from the opcode to the compressed records."""
        return b''.join((
            HEAD.pack(Opcode.CHUNK, self.length),
            CHUNK_HEAD.pack(self.first_ns, self.last_ns, self.size, self.crc,
                            len(self.compression)),
            self.compression.encode(), _LENGTH.pack(self.packed)))


def find_chunk_head(data: bytes) -> ChunkHead | None:
    """
    Return the head of the chunk whose record begins these bytes; None if it contradicts itself.

    The opcode may be wrong if the head has a checksum, because that can prove the chunk.
    """
    if len(data) < HEAD.size + CHUNK_HEAD.size:
        return None
    length = HEAD.unpack_from(data)[1]
    first, last, size, crc, letters = CHUNK_HEAD.unpack_from(data, HEAD.size)
    start = HEAD.size + CHUNK_HEAD.size
    if letters > _LETTERS or len(data) < start + letters + _LENGTH.size or not (
            crc or data[0] == Opcode.CHUNK):
        return None
    packed = _LENGTH.unpack_from(data, start + letters)[0]
    head = ChunkHead(length=length, first_ns=first, last_ns=last, size=size, crc=crc,
                     compression=data[start:start + letters].decode('latin-1'), packed=packed)
    grown = data[0] == Opcode.CHUNK and head.needed < length
    return head if max(size, length) <= CHUNK_BYTES and (
        grown or head.needed == length) else None


def possible_heads(data: bytes, indexed: ChunkHead | None) -> list[ChunkHead]:
    """
    Return the heads that a chunk may have had before some bytes of its head changed.

    Parameters
    ----------
    data
        Its first bytes.
    indexed
        Its head by the index of the file, which does not know the checksum.

    Returns
    -------
    list of ChunkHead
        Only the checksum can tell which is right; empty if there is none.

    """
    if len(data) < HEAD_BYTES or not (crc := CHUNK_HEAD.unpack_from(data, HEAD.size)[3]):
        return []
    length = HEAD.unpack_from(data)[1]
    first, last, size, *_ = CHUNK_HEAD.unpack_from(data, HEAD.size)
    heads = [] if indexed is None else [indexed._replace(crc=crc)]
    for compression in _COMPRESSIONS:
        start = HEAD.size + CHUNK_HEAD.size + len(compression)
        head = ChunkHead(length, first, last, size, crc, compression, 0)
        for packed in dict.fromkeys((_LENGTH.unpack_from(data, start)[0], length - head.needed)):
            sizes = {size, packed if not compression else _frame_size(
                compression, data[start + _LENGTH.size:]), 0 if indexed is None else indexed.size}
            changed = head._replace(packed=packed)
            heads += [changed._replace(length=changed.needed, size=records) for records in sizes]
    return [head for head in heads
            if 0 < head.size <= CHUNK_BYTES and 0 < head.packed and head.length <= CHUNK_BYTES]


def _frame_size(compression: str, data: bytes) -> int:
    """Return what the beginning of a compressed frame says of its size; 0 if nothing."""
    try:
        return int(zstandard.frame_content_size(data) if compression == 'zstd' else
                   lz4.frame.get_frame_info(data)['content_size'])
    except (zstandard.ZstdError, RuntimeError):
        return 0


def measure_leading(data: BytesLike, times: tuple[int, int] | None) -> int:
    """
    Return the size of the intact records at the start of a chunk.

    Parameters
    ----------
    data : bytes-like
        The decompressed records.
    times
        First and last log time in the head of a chunk that no checksum proves. Then a message at
        another time, or a record of another kind, is not believed.

    """
    at = 0
    while at + HEAD.size <= len(data):
        opcode, length = HEAD.unpack_from(data, at)
        behind = at + HEAD.size + length
        if (behind > len(data) or opcode == INVALID_OPCODE
                or opcode == Opcode.MESSAGE and length < MESSAGE_LEAST):
            break
        if times is not None:
            if opcode not in BARE:
                break
            if opcode == Opcode.MESSAGE:
                log = MESSAGE_HEAD.unpack_from(data, at)[4]
                if not times[0] <= log <= times[1]:
                    break
        at = behind
    return at


def find_candidates(window: bytes, room: int, opcodes: tuple[int, ...]) -> Integers:
    """Return where in a window a record of these opcodes may begin and end within `room` bytes."""
    count = len(window) - HEAD.size + 1
    if count <= 0:
        return np.empty(0, np.int64)
    data = np.frombuffer(window, np.uint8)
    likely = np.isin(data[:count], opcodes)
    for byte in range(5, HEAD.size):
        likely &= data[byte:byte + count] == 0
    places = np.flatnonzero(likely)
    length = np.zeros(len(places), np.int64)
    for byte in range(4):
        length |= data[places + 1 + byte].astype(np.int64) << (8 * byte)
    # A chunk may be cut by the end of the file.
    good = (data[places] == Opcode.CHUNK) | (places + HEAD.size + length <= room)
    magic = window.find(MAGIC)
    return places[good] if magic < 0 else np.sort(np.append(places[good], magic))
