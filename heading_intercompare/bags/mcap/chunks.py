# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""MCAP chunks: decompress them, check them, and join several to one block."""

from __future__ import annotations

import struct
from typing import BinaryIO, NamedTuple

import lz4.frame
import numpy as np
import zstandard

from heading_intercompare.bags.errors import BagError

from .checksum import crc32
from .message_blocks import Block, block_of, HEAD

__all__ = ['CHUNK_HEAD', 'Gathering', 'unpack']

#: First and last log time, size and checksum of the decompressed records, length of the
#: compression's name.
CHUNK_HEAD = struct.Struct('<QQQII')
_LENGTH = struct.Struct('<Q')
#: A chunk that claims to be larger is not believed.
_CHUNK_LIMIT = 2**31
_NAME_LIMIT = 32
#: One byte of lz4 decompresses to at most this many.
_LZ4_MOST = 255


class _Head(NamedTuple):
    """What a chunk says about itself; `size` and `crc` are those of its decompressed records."""

    first_ns: int
    last_ns: int
    size: int
    crc: int
    compression: str
    length: int


def _read_head(begun: bytes | memoryview, length: int) -> tuple[_Head, int]:
    """Return the head of a chunk of a given length, and its size; BagError if it is damaged."""
    try:
        first, last, size, crc, letters = CHUNK_HEAD.unpack_from(begun)
        start = CHUNK_HEAD.size + letters
        if letters > _NAME_LIMIT:
            raise BagError('chunk damaged: it names an impossible compression')
        compression = bytes(begun[CHUNK_HEAD.size:start]).decode()
        inner = _LENGTH.unpack_from(begun, start)[0]
    except (struct.error, UnicodeDecodeError):
        raise BagError('chunk damaged: its head is cut or invalid') from None
    start += _LENGTH.size
    if size > _CHUNK_LIMIT:
        raise BagError(f'chunk damaged: it claims {size} bytes')
    if start + inner > length or (not compression and inner != size) or (
            compression == 'lz4' and size > _LZ4_MOST * inner):
        raise BagError('chunk damaged: its lengths do not agree')
    return _Head(first, last, size, crc, compression, inner), start


def _decompress(head: _Head, data: memoryview, zstd: zstandard.ZstdDecompressor) -> bytes:
    """Return the decompressed records; BagError unless they have the size in the head."""
    try:
        if head.compression == 'zstd':
            # Use no more memory than the head says, whatever the frame claims.
            if zstandard.frame_content_size(data) not in (head.size, -1):
                raise BagError('chunk damaged: its compressed data has another size than its '
                               'head says')
            found = zstd.decompress(data, max_output_size=head.size)
        elif head.compression == 'lz4':
            # With a bound it allocates memory once; one byte more shows the end of the frame.
            frame = lz4.frame.LZ4FrameDecompressor()
            found = frame.decompress(data, max_length=head.size + 1)
            if not frame.eof:
                raise BagError('chunk damaged: its compressed data does not end where it should')
        else:
            raise BagError(f'chunk compressed with {head.compression!r}; known are zstd and lz4')
    except (zstandard.ZstdError, RuntimeError, MemoryError) as error:
        raise BagError(f'chunk damaged: {error}') from None
    if len(found) != head.size:
        raise BagError('chunk damaged: it decompresses to another size than its head says')
    return found


def _check(head: _Head, data: bytes | memoryview) -> None:
    if head.crc and crc32(data) != head.crc:
        raise BagError('chunk damaged: its checksum does not match')


def unpack(content: bytes, zstd: zstandard.ZstdDecompressor) -> bytes | memoryview:
    """
    Decompress and check the records in the content of a chunk.

    Raises
    ------
    BagError
        If it is damaged: its sizes do not agree, or its checksum is wrong.

    """
    head, start = _read_head(content, len(content))
    data = memoryview(content)[start:start + head.length]
    found = _decompress(head, data, zstd) if head.compression else data
    _check(head, found)
    return found


class Gathering:
    """
    Collects chunks into one block, with the message indexes that follow them.

    Their records lie one after the other in memory that the next block uses again, because
    allocating memory takes longer than reading.

    Attributes
    ----------
    size : int
        Bytes of records.
    end : int
        The byte of the file after the last chunk taken.

    """

    def __init__(self) -> None:
        self._zstd = zstandard.ZstdDecompressor()
        self._memory = self._packed = memoryview(bytearray())
        self.clear()

    def clear(self) -> None:
        """Begin the next block."""
        self.size = self.end = self._base = self._offset = 0
        self._index: list[bytes] = []
        self._bases: list[int] = []
        self._usable = True
        self._awaited = False

    def __bool__(self) -> bool:
        return bool(self.end)

    def take(self, file: BinaryIO, length: int, start_ns: int, stop_ns: int,
             indexed: tuple[int, int, int] | None = None) -> bool:
        """
        Take a chunk; the file stands at its content, which has this length.

        Parameters
        ----------
        file : binary file
        length : int
        start_ns, stop_ns : int
            Log times to read.
        indexed : tuple of int, optional
            What the index of the file says: first and last log time, and size of the records.

        Returns
        -------
        bool
            False if the chunk lies outside [start, stop) in log time and is skipped.

        Raises
        ------
        BagError
            If the chunk is damaged or is not the one in the index; the chunks taken before stay
            usable.

        """
        at = file.tell()
        begun = file.read(min(CHUNK_HEAD.size + _LENGTH.size + 4, length))
        head, start = _read_head(begun, length)
        if indexed is not None and indexed != (head.first_ns, head.last_ns, head.size):
            raise BagError('the index of the file does not fit this chunk; `recover` copies all '
                           'chunks and writes a new index')
        if head.first_ns >= stop_ns or head.last_ns < start_ns:
            return False
        file.seek(at + start)
        if head.compression:
            records = _decompress(head, self._read(file, head.length), self._zstd)
            into = self._reserve(head.size)
            into[:] = records
        else:
            into = self._reserve(head.size)
            if file.readinto(into) < head.size:
                raise BagError('chunk damaged: it ends early')
        _check(head, into)
        if not self:
            self._offset = at - HEAD.size
        self._usable = self._usable and not self._awaited
        self._awaited = True
        self._base, self.size, self.end = self.size, self.size + head.size, at + length
        return True

    def _reserve(self, size: int) -> memoryview:
        """Return memory after the records taken so far; enlarge it if needed."""
        if self.size + size > len(self._memory):
            larger = memoryview(bytearray(max(self.size + size, 2 * self.size)))
            larger[:self.size] = self._memory[:self.size]
            self._memory = larger
        return self._memory[self.size:self.size + size]

    def _read(self, file: BinaryIO, length: int) -> memoryview:
        if length > len(self._packed):
            self._packed = memoryview(bytearray(length))
        return self._packed[:file.readinto(self._packed[:length])]

    def add_index(self, entries: bytes) -> None:
        """Take the entries of a message index of the newest chunk."""
        self._awaited = False
        self._index.append(entries)
        self._bases.append(self._base)

    def block(self) -> Block:
        """Return the messages as a block, valid until the next chunk is taken."""
        return block_of(self._memory[:self.size], self._offset, self._offsets)

    def _offsets(self) -> np.ndarray | None:
        """Return the message offsets that the indexes name; None unless each chunk has indexes."""
        if not self._usable or self._awaited or not self._index:
            return None
        counts = [len(entries) >> 4 for entries in self._index]
        entries = np.frombuffer(b''.join(self._index), '<i8')
        return entries[1::2] + np.repeat(np.array(self._bases, np.int64), counts)
