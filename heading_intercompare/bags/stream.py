# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The records of an MCAP file in their order, with the messages gathered into blocks."""

from __future__ import annotations

import os
import struct
from typing import BinaryIO, Iterator
import zlib

import lz4.frame
from mcap.opcode import Opcode
import numpy as np
import zstandard

from .blocks import Block, block_of, HEAD, Record, whole
from .errors import BagError

__all__ = ['MAGIC', 'RecordStream']

MAGIC = b'\x89MCAP0\r\n'

_CHUNK_HEAD = struct.Struct('<QQQII')
_BARE = (Opcode.MESSAGE, Opcode.SCHEMA, Opcode.CHANNEL)
#: Messages outside chunks are read by this many bytes.
_BARE_BYTES = 1048576
#: No chunk is believed that claims to be larger.
_CHUNK_LIMIT = 2**31


def _decompressed(compression: str, packed: memoryview, size: int) -> bytes | memoryview:
    if compression == '':
        return packed
    if compression == 'lz4':
        return lz4.frame.decompress(packed)
    if compression == 'zstd':
        return zstandard.ZstdDecompressor().decompress(packed, max_output_size=size)
    raise BagError(f'chunk compressed with {compression!r}; known are zstd and lz4')


class _Pending:
    """Chunks that become one block, with the message indexes that follow them."""

    def __init__(self) -> None:
        self.size = 0
        self._offset = 0
        self._base = 0
        self._chunks: list[bytes | memoryview] = []
        self._index: list[np.ndarray] = []
        self._usable = True
        self._awaited = False

    def add(self, data: bytes | memoryview, offset: int) -> None:
        """Take the next chunk."""
        if not self._chunks:
            self._offset = offset
        self._usable = self._usable and not self._awaited
        self._awaited = True
        self._base = self.size
        self._chunks.append(data)
        self.size += len(data)

    def add_index(self, content: bytes) -> None:
        """Take a message index of the newest chunk."""
        self._awaited = False
        if len(content) % 16 == 6:
            self._index.append(np.frombuffer(content, '<i8', offset=6)[1::2] + self._base)
        else:
            self._usable = False

    def block(self) -> Block:
        """Return the messages of the chunks."""
        data = self._chunks[0] if len(self._chunks) == 1 else b''.join(self._chunks)
        usable = self._usable and not self._awaited and self._index
        return block_of(data, self._offset, np.concatenate(self._index) if usable else None)


class RecordStream:
    """
    The records of an open MCAP file. Errors carry the byte, not the path.

    Parameters
    ----------
    file : binary file
        Open for reading, seekable.

    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self.size = file.seek(0, os.SEEK_END)

    def record(self, at: int) -> Record:
        """Return the record at a byte and leave the file behind its head."""
        self._file.seek(at)
        head = self._file.read(HEAD.size)
        if len(head) < HEAD.size:
            raise BagError('a record ends early' if head else 'it has no end', offset=at)
        opcode, length = HEAD.unpack(head)
        if not opcode:
            raise BagError('no record begins', offset=at)
        if at + HEAD.size + length > self.size:
            raise BagError('a record ends early', offset=at)
        return Record(opcode, at + HEAD.size, length)

    def content(self, record: Record) -> bytes:
        """Return the bytes of a record behind its head."""
        self._file.seek(record.start)
        return self._file.read(record.length)

    def _times(self, chunk: Record) -> tuple[int, int]:
        """Return first and last log time of a chunk; the file is at its content."""
        content = self._file.read(16)
        return struct.unpack('<QQ', content) if len(content) == 16 else (0, 2**64)

    def _chunk(self, record: Record) -> bytes | memoryview:
        """Return the records of a chunk, decompressed and checked."""
        content = memoryview(self.content(record))
        try:
            _, _, size, crc, letters = _CHUNK_HEAD.unpack_from(content)
            start = _CHUNK_HEAD.size + letters
            compression = bytes(content[_CHUNK_HEAD.size:start]).decode()
            length = struct.unpack_from('<Q', content, start)[0]
            if size > _CHUNK_LIMIT:
                raise BagError(f'chunk damaged: it claims {size} bytes')
            data = _decompressed(compression, content[start + 8:start + 8 + length], size)
        except (struct.error, UnicodeDecodeError, zstandard.ZstdError, RuntimeError) as error:
            raise BagError(f'chunk damaged: {error}') from None
        if len(data) != size or (crc and zlib.crc32(data) != crc):
            raise BagError('chunk damaged: its checksum does not match')
        return data

    def _bare(self, record: Record, end: int) -> tuple[Block, int]:
        """Return the messages outside chunks from a record on, and where they end."""
        at = record.start - HEAD.size
        self._file.seek(at)
        data = self._file.read(min(max(_BARE_BYTES, HEAD.size + record.length), end - at))
        size = whole(data, _BARE)
        return block_of(data[:size], at), at + size

    def pieces(self, at: int, end: int, least: int, start_ns: int = 0,
               stop_ns: int = 2**64) -> Iterator[tuple[Block | Record, int]]:
        """
        Yield blocks and other records, each with the byte behind it, up to the end of the data.

        Parameters
        ----------
        at, end : int
            Bytes of the file between which the records are.
        least : int
            Chunks are joined to a block until they have this many bytes, for speed.
        start_ns, stop_ns : int
            Chunks that lie outside [start, stop) in log time are left out.

        Raises
        ------
        BagError
            At the first record that cannot be read, after all that is before it.

        """
        pending, behind, wanted = _Pending(), at, False
        try:
            while at < end:
                record = self.record(at)
                joins = record.opcode == Opcode.CHUNK and pending.size < least
                if pending.size and not joins and record.opcode != Opcode.MESSAGE_INDEX:
                    complete, pending = pending, _Pending()
                    yield complete.block(), behind
                start, at = at, record.start + record.length
                if record.opcode == Opcode.CHUNK:
                    first, last = self._times(record)
                    wanted = first < stop_ns and last >= start_ns
                    if wanted:
                        pending.add(self._chunk(record), start)
                    behind = at
                elif record.opcode == Opcode.MESSAGE_INDEX:
                    if wanted:
                        pending.add_index(self.content(record))
                elif record.opcode in _BARE:
                    block, at = self._bare(record, end)
                    yield block, at
                else:
                    yield record, at
                    if record.opcode == Opcode.DATA_END:
                        return
        except BagError as error:
            if pending.size:
                yield pending.block(), behind
            raise BagError(error.problem, offset=start if error.offset is None else error.offset
                           ) from None
        if pending.size:
            yield pending.block(), behind
