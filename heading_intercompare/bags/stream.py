# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
The records of an MCAP file in their order, with the messages gathered into blocks.

While one block is used, a second thread decompresses and checks the next one.
"""

from __future__ import annotations

from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
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

__all__ = ['CHUNK_HEAD', 'MAGIC', 'RecordStream', 'unpacked']

MAGIC = b'\x89MCAP0\r\n'

#: First and last log time, size and checksum of the decompressed records, length of a name.
CHUNK_HEAD = struct.Struct('<QQQII')
_BARE = (Opcode.MESSAGE, Opcode.SCHEMA, Opcode.CHANNEL)
#: Messages outside chunks are read by this many bytes.
_BARE_BYTES = 1048576
#: No chunk is believed that claims to be larger.
_CHUNK_LIMIT = 2**31


def _unzstd(data: memoryview, size: int, zstd: zstandard.ZstdDecompressor) -> bytes:
    """Return what decompresses to `size` bytes; never more, whatever the frame claims."""
    claimed = zstandard.frame_content_size(data)
    if claimed not in (size, -1):
        raise BagError('chunk damaged: its compressed data has another size than its head says')
    return zstd.decompress(data, max_output_size=size)


def unpacked(content: bytes, zstd: zstandard.ZstdDecompressor) -> bytes | memoryview:
    """
    Return the records in the content of a chunk, decompressed and checked.

    Raises
    ------
    BagError
        If it is damaged: sizes that do not agree, a wrong checksum.

    """
    view = memoryview(content)
    try:
        _, _, size, crc, letters = CHUNK_HEAD.unpack_from(view)
        start = CHUNK_HEAD.size + letters
        compression = bytes(view[CHUNK_HEAD.size:start]).decode()
        length = struct.unpack_from('<Q', view, start)[0]
        data = view[start + 8:start + 8 + length]
        if size > _CHUNK_LIMIT:
            raise BagError(f'chunk damaged: it claims {size} bytes')
        if compression == 'zstd':
            data = _unzstd(data, size, zstd)
        elif compression == 'lz4':
            data = lz4.frame.decompress(data)
        elif compression:
            raise BagError(f'chunk compressed with {compression!r}; known are zstd and lz4')
    except (struct.error, UnicodeDecodeError, zstandard.ZstdError, RuntimeError,
            MemoryError) as error:
        raise BagError(f'chunk damaged: {error}') from None
    if len(data) != size or (crc and zlib.crc32(data) != crc):
        raise BagError('chunk damaged: its checksum does not match')
    return data


class _Group:
    """Chunks that become one block, with the message indexes that follow them."""

    def __init__(self) -> None:
        self.size = 0
        self.end = 0
        self._chunks: list[tuple[int, bytes]] = []
        self._index: list[np.ndarray] = []
        self._base = 0
        self._usable = True
        self._awaited = False

    def add(self, content: bytes, offset: int, end: int) -> None:
        """Take the next chunk as it is in the file, between two bytes of it."""
        self._usable = self._usable and not self._awaited
        self._awaited = True
        self._base = self.size
        self._chunks.append((offset, content))
        self.size += struct.unpack_from('<Q', content, 16)[0] if len(content) >= 24 else 0
        self.end = end

    def add_index(self, content: bytes) -> None:
        """Take a message index of the newest chunk."""
        self._awaited = False
        if len(content) % 16 == 6:
            self._index.append(np.frombuffer(content, '<i8', offset=6)[1::2] + self._base)
        else:
            self._usable = False

    def __bool__(self) -> bool:
        return bool(self._chunks)

    def unpack(self) -> tuple[list[bytes | memoryview], BagError | None]:
        """Return the decompressed chunks, and why one is not among them, nor those behind it."""
        chunks, zstd = [], zstandard.ZstdDecompressor()
        for offset, content in self._chunks:
            try:
                chunks.append(unpacked(content, zstd))
            except BagError as error:
                return chunks, error.at('', offset)
        return chunks, None

    def block(self, chunks: list[bytes | memoryview]) -> Block:
        """Return the messages of the decompressed chunks."""
        data = chunks[0] if len(chunks) == 1 else b''.join(chunks)
        usable = self._usable and not self._awaited and self._index
        return block_of(data, self._chunks[0][0],
                        np.concatenate(self._index) if usable else None)


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

    def _overlaps(self, start_ns: int, stop_ns: int) -> bool:
        """Tell whether the chunk at whose content the file is may have messages of a time."""
        content = self._file.read(16)
        if len(content) < 16:
            return True
        first, last = struct.unpack('<QQ', content)
        return first < stop_ns and last >= start_ns

    def _bare(self, record: Record, end: int) -> tuple[Block, int]:
        """Return the messages outside chunks from a record on, and where they end."""
        at = record.start - HEAD.size
        self._file.seek(at)
        data = self._file.read(min(max(_BARE_BYTES, HEAD.size + record.length), end - at))
        size = whole(data, _BARE)
        return block_of(data[:size], at), at + size

    def _items(self, at: int, end: int, least: int, start_ns: int,
               stop_ns: int) -> Iterator[tuple[_Group | Block | Record, int]]:
        """Yield the same as `pieces`, but chunks as they are in the file."""
        group, wanted = _Group(), False
        while at < end:
            try:
                record = self.record(at)
            except BagError:
                if group:
                    yield group, group.end
                raise
            joins = record.opcode == Opcode.CHUNK and group.size < least
            if group and not joins and record.opcode != Opcode.MESSAGE_INDEX:
                yield group, group.end
                group = _Group()
            start, at = at, record.start + record.length
            if record.opcode == Opcode.CHUNK:
                wanted = start_ns <= 0 and stop_ns >= 2**64 or self._overlaps(start_ns, stop_ns)
                if wanted:
                    group.add(self.content(record), start, at)
            elif record.opcode == Opcode.MESSAGE_INDEX:
                if wanted:
                    group.add_index(self.content(record))
            elif record.opcode in _BARE:
                block, at = self._bare(record, end)
                yield block, at
            else:
                yield record, at
                if record.opcode == Opcode.DATA_END:
                    return
        if group:
            yield group, group.end

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
        items = self._items(at, end, least, start_ns, stop_ns)
        coming: deque[tuple[_Group | Block | Record, int, Future | None]] = deque()
        problem, more = None, True
        with ThreadPoolExecutor(1) as worker:
            while more or coming:
                try:
                    item, behind = next(items)
                    unpacking = worker.submit(item.unpack) if isinstance(item, _Group) else None
                    coming.append((item, behind, unpacking))
                except StopIteration:
                    more = False
                except BagError as error:
                    problem, more = error, False
                if coming and (len(coming) > 1 or not more):
                    yield from self._finished(*coming.popleft())
        if problem:
            raise problem

    @staticmethod
    def _finished(item: _Group | Block | Record, behind: int, unpacking: Future | None
                  ) -> Iterator[tuple[Block | Record, int]]:
        """Yield an item when it is unpacked, then raise what was wrong with it."""
        if unpacking is None:
            yield item, behind
            return
        chunks, damage = unpacking.result()
        if chunks:
            yield item.block(chunks), behind
        if damage:
            raise damage
