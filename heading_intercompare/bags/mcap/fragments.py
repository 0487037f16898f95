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

from mcap.opcode import Opcode
import numpy as np
import zstandard

from heading_intercompare.core.records import Integers
from heading_intercompare.messages.byte_columns import BytesLike

from .chunks import CHUNK_HEAD, read_lz4_frames, read_zstd_frames
from .message_blocks import HEAD, INVALID_OPCODE, MESSAGE_HEAD
from .record_stream import MAGIC

#: Records that may be inside or outside a chunk.
BARE = (Opcode.MESSAGE, Opcode.SCHEMA, Opcode.CHANNEL)
#: Length of a message without payload.
MESSAGE_LEAST = MESSAGE_HEAD.size - HEAD.size
#: Longest name of a compression.
_LETTERS = 8
#: Most bytes from the opcode of a chunk to its compressed records.
HEAD_BYTES = HEAD.size + CHUNK_HEAD.size + _LETTERS + 8
#: A chunk that claims to be larger is not believed.
CHUNK_BYTES = 2**31
_PIECE_BYTES = 2**20
_LENGTH = struct.Struct('<Q')


class ChunkHead(NamedTuple):
    """
    What a chunk says about itself.

    `packed` is the length of its compressed records, `rest` that of what follows its fields.
    """

    length: int
    first_ns: int
    last_ns: int
    size: int
    crc: int
    compression: str
    packed: int
    rest: int


def find_chunk_head(data: bytes, *, extended: bool = False) -> ChunkHead | None:
    """
    Return the head of the chunk whose record begins these bytes; None if it contradicts itself.

    The opcode may be wrong if the head has a checksum, because that can prove the chunk. The
    record may have more after its fields, as later versions of MCAP may write, if `extended`.
    """
    if len(data) < HEAD.size + CHUNK_HEAD.size:
        return None
    length = HEAD.unpack_from(data)[1]
    first, last, size, crc, letters = CHUNK_HEAD.unpack_from(data, HEAD.size)
    start = HEAD.size + CHUNK_HEAD.size
    if letters > _LETTERS or len(data) < start + letters + 8 or not (
            crc or data[0] == Opcode.CHUNK):
        return None
    packed = _LENGTH.unpack_from(data, start + letters)[0]
    rest = length - CHUNK_HEAD.size - letters - 8 - packed
    if rest < 0 or rest and not extended or max(size, length) > CHUNK_BYTES:
        return None
    return ChunkHead(length=length, first_ns=first, last_ns=last, size=size, crc=crc,
                     compression=data[start:start + letters].decode(errors='replace'),
                     packed=packed, rest=rest)


def _is_plausible(begun: bytearray, size: int) -> bool:
    """Tell whether these bytes can begin the records of a chunk of this size."""
    if len(begun) < HEAD.size:
        return False
    opcode, length = HEAD.unpack_from(begun)
    return opcode in BARE and HEAD.size + length <= size


def decompress_begun(content: bytes) -> bytearray:
    """
    Return the records that can be decompressed from a chunk that may be cut; its lengths agree.

    It works piece by piece and stops if the first bytes are not plausible. So a chunk that claims
    to be large takes no more memory than its actual data.
    """
    _, _, size, _, letters = CHUNK_HEAD.unpack_from(content)
    start = CHUNK_HEAD.size + letters
    compression, data = content[CHUNK_HEAD.size:start], content[start + 8:]
    if not compression:
        return bytearray(data[:size])
    records = bytearray()
    try:
        for piece in (read_zstd_frames(data, size, _PIECE_BYTES) if compression == b'zstd' else
                      read_lz4_frames([data], size, _PIECE_BYTES) if compression == b'lz4' else
                      ()):
            records += piece
            if len(records) == len(piece) and not _is_plausible(records, size):
                break
    except (zstandard.ZstdError, RuntimeError, MemoryError, EOFError):
        pass
    del records[size:]
    return records


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
