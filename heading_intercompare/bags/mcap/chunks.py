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

"""MCAP chunks: decompress them, check them, and join several to one block."""

from __future__ import annotations

from bisect import bisect_right
from contextlib import suppress
from io import BufferedIOBase
from operator import itemgetter
import struct
from typing import Callable, Iterable, Iterator, NamedTuple

import lz4.frame
from mcap.opcode import Opcode
import numpy as np
import zstandard

from heading_intercompare.bags.errors import BagError
from heading_intercompare.core.records import Integers
from heading_intercompare.messages.byte_columns import BytesLike

from .checksum import crc32
from .message_blocks import (
    Block,
    block_of,
    HEAD,
    measure_whole,
    MESSAGE_HEAD,
    passed_block,
    refuse_definitions,
    refuse_untimed,
)

#: First and last log time, size and checksum of the decompressed records, length of the
#: compression's name.
CHUNK_HEAD = struct.Struct('<QQQII')
_LENGTH = struct.Struct('<Q')
#: A chunk that claims to be larger is not believed.
_CHUNK_LIMIT = 2**31
_NAME_LIMIT = 32
_HEAD_BYTES = CHUNK_HEAD.size + _NAME_LIMIT + _LENGTH.size
#: One byte of lz4 decompresses to at most this many.
_LZ4_MOST = 255
_PIECE_BYTES, _PACKED_BYTES = 2**23, 2**18


RECORD_BYTES = 2**27
"""A longer message is passed over, and a longer record of another kind is not believed."""

LARGE_BYTES = 2**26
"""The records of a chunk that has more are decompressed piece by piece."""

UNFIT = ('the index of the file does not fit this chunk; `recover` copies all chunks and writes a '
         'new index')
"""What is wrong with a chunk that is not the one that its file's index names."""


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
            records = _decompress_zstd(data, head.size, zstd)
        elif head.compression == 'lz4':
            records = _decompress_lz4(data, head.size)
        else:
            raise BagError(f'chunk compressed with {head.compression!r}; known are zstd and lz4')
    except (zstandard.ZstdError, RuntimeError, MemoryError) as error:
        raise BagError(f'chunk damaged: {error}') from None
    if len(records) != head.size:
        raise BagError('chunk damaged: it decompresses to another size than its head says')
    return records


def _decompress_zstd(data: memoryview, size: int, zstd: zstandard.ZstdDecompressor) -> bytes:
    """Return the content of frames of zstd that hold `size` bytes, or fewer than that."""
    claim = zstandard.frame_content_size(data)
    if claim > size:
        raise BagError('chunk damaged: its compressed data has another size than its head says')
    if claim in (size, -1):
        # Use no more memory than the head says, whatever the frame claims.
        records = zstd.decompress(data, max_output_size=size)
        if len(records) == size:
            return records
    return b''.join(read_zstd_frames(data, size, _PIECE_BYTES))


def read_zstd_frames(source: BytesLike | _Span, size: int, most: int) -> Iterator[bytes]:
    """
    Yield the content of frames of zstd in pieces of at most `most` bytes.

    It ends after `size` bytes, or one more if there are more. What follows the frames is ignored.
    """
    # The source need only have `read`, but the types ask for a whole IO.
    with zstandard.ZstdDecompressor().stream_reader(
            source, read_across_frames=True) as frames:  # type: ignore[arg-type]
        while size and (piece := frames.read(min(size, most))):
            size -= len(piece)
            yield piece
        with suppress(zstandard.ZstdError):
            if not size and (piece := frames.read(1)):
                yield piece


def read_lz4_frames(packed: Iterable[BytesLike], size: int, most: int) -> Iterator[bytes]:
    """Yield the content of frames of lz4, which come in pieces, as `read_zstd_frames` does."""
    frame = lz4.frame.LZ4FrameDecompressor()
    for rest in packed:
        while len(rest) or not (frame.eof or frame.needs_input):
            if frame.eof:
                frame = lz4.frame.LZ4FrameDecompressor()
            if piece := frame.decompress(rest, most):
                size -= len(piece)
                yield piece
            if size < 0 or frame.eof and not size:
                return
            rest = frame.unused_data or b''


def _decompress_lz4(data: memoryview, size: int) -> bytes:
    """Return the content of frames of lz4 that hold `size` bytes; BagError if one is cut."""
    records = b''
    rest: BytesLike = data
    while len(rest):
        # With a bound it allocates memory once; one byte more shows the end of the frame.
        frame = lz4.frame.LZ4FrameDecompressor()
        records += frame.decompress(rest, max_length=size + 1 - len(records))
        if not frame.eof:
            raise BagError('chunk damaged: its compressed data does not end where it should')
        rest = frame.unused_data or b'' if len(records) < size else b''
    return records


def _decompress_into(into: memoryview, head: _Head, data: memoryview,
                     zstd: zstandard.ZstdDecompressor) -> bool:
    """Decompress records without a copy if that is sure to work; tell whether it did."""
    if head.compression != 'zstd':
        return False
    try:
        # A frame that does not say its size would need memory for its window.
        if zstandard.frame_content_size(data) != head.size:
            return False
        with zstd.stream_reader(data) as frame:
            return frame.readinto(into) == head.size
    except (zstandard.ZstdError, MemoryError):
        return False


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
    records = _decompress(head, data, zstd) if head.compression else data
    _check(head, records)
    return records


class BegunChunk(NamedTuple):
    """A chunk of which the head has been read: its place in the file, and its head."""

    at: int
    start: int
    end: int
    head: _Head

    @property
    def is_large(self) -> bool:
        """Whether it is too large to decompress at once."""
        return self.head.size > LARGE_BYTES

    @property
    def said(self) -> tuple[int, int, int]:
        """First and last log time, and size of the records, as its head says."""
        return self.head.first_ns, self.head.last_ns, self.head.size

    def cut(self, end: int) -> 'BegunChunk':
        """Return the chunk as it is if its file, or what can be read of it, ends at a byte."""
        length = min(self.head.length, max(end - self.start, 0))
        return self._replace(end=min(self.end, end), head=self.head._replace(length=length))


def begin_chunk(file: BufferedIOBase, length: int) -> BegunChunk:
    """
    Read the head of a chunk; the file stands at its content, which has this length.

    Raises
    ------
    BagError
        If the head is damaged.

    """
    at = file.tell()
    head, start = _read_head(file.read(min(_HEAD_BYTES, length)), length)
    return BegunChunk(at, at + start, at + length, head)


class LargeChunk:
    """
    A chunk of many records, which are decompressed and checked piece by piece.

    A small file may unpack to gigabytes; memory stays that of a few pieces.

    Attributes
    ----------
    size : int
        Bytes of records that `blocks` has decompressed.

    """

    def __init__(self, file: BufferedIOBase, begun: BegunChunk) -> None:
        self._file, (self._at, self._start, _, self._head) = file, begun
        self.size = 0

    def verify(self) -> None:
        """Raise BagError unless the records have the size and the checksum in the head."""
        crc = size = 0
        for piece in self._pieces():
            crc, size = crc32(piece, crc), size + len(piece)
            if size > self._head.size:
                break
        if size != self._head.size:
            raise BagError('chunk damaged: it decompresses to another size than its head says')
        if self._head.crc and crc != self._head.crc:
            raise BagError('chunk damaged: its checksum does not match')

    def blocks(self, measure: Callable[[BytesLike], int] = measure_whole, *,
               passes_over: bool = False) -> Iterator[Block]:
        """
        Yield its messages block by block.

        Parameters
        ----------
        measure
            Returns the size of the sound records at the start of some bytes.
        passes_over
            Of a message that would fill the memory, yield the head; otherwise it is an error.

        Raises
        ------
        BagError
            If a record in it is damaged, after the blocks before that.

        """
        pieces, rest, others, messages, ahead = self._pieces(), bytearray(), 0, 0, 0
        damage: BagError | None = None
        more = True
        while more:
            try:
                piece = next(pieces, b'')
            except BagError as error:
                piece, damage = b'', error
            more = bool(piece)
            self.size += len(piece)
            ahead, piece = max(ahead - len(piece), 0), piece[ahead:]
            rest += piece
            if more and len(rest) < _PIECE_BYTES:
                continue
            size = measure(rest)
            if size:
                whole, rest = rest, rest[size:]
                block = block_of(memoryview(whole)[:size], self._at - HEAD.size)
                others, messages = others + len(block.others), messages + len(block.start)
                refuse_definitions(others, messages)
                yield block
                del whole, block
            if len(rest) >= MESSAGE_HEAD.size:
                opcode, length = HEAD.unpack_from(rest)
                if length > RECORD_BYTES and passes_over and opcode == Opcode.MESSAGE:
                    yield passed_block(bytes(rest[:MESSAGE_HEAD.size]), self._at - HEAD.size)
                    messages += 1
                    ahead = max(HEAD.size + length - len(rest), 0)
                    rest = rest[HEAD.size + length:]
                    # What is left of this piece is measured with the next one, if there is one.
                elif length > RECORD_BYTES:
                    raise BagError('chunk damaged: a record in it claims more than '
                                   f'{RECORD_BYTES} bytes')
                else:
                    more = more and HEAD.size + length > len(rest)
        if damage or rest or ahead:
            raise damage or BagError('chunk damaged: a record in it has a wrong length')

    def _pieces(self) -> Iterator[bytes]:
        """Yield the decompressed records in pieces of some megabytes."""
        try:
            yield from self._decompress()
        except (zstandard.ZstdError, RuntimeError, MemoryError, EOFError) as error:
            raise BagError(f'chunk damaged: {error}') from None

    def _packed(self) -> Iterator[bytes]:
        at, end = self._start, self._start + self._head.length
        while at < end:
            self._file.seek(at)
            piece = self._file.read(min(_PACKED_BYTES, end - at))
            if not piece:
                raise BagError('chunk damaged: it ends early')
            at += len(piece)
            yield piece

    def _decompress(self) -> Iterator[bytes]:
        if not self._head.compression:
            yield from self._packed()
        elif self._head.compression == 'lz4':
            yield from read_lz4_frames(self._packed(), self._head.size, _PIECE_BYTES)
        elif self._head.compression == 'zstd':
            source = _Span(self._file, self._start, self._start + self._head.length)
            yield from read_zstd_frames(source, self._head.size, _PIECE_BYTES)
        else:
            raise BagError(f'chunk compressed with {self._head.compression!r}; known are zstd and '
                           'lz4')


class _Span:
    """The bytes of a file between two places, to read in order."""

    def __init__(self, file: BufferedIOBase, at: int, end: int) -> None:
        self._file, self._next, self._end = file, at, end

    def read(self, size: int) -> bytes:
        self._file.seek(self._next)
        piece = self._file.read(min(size, self._end - self._next))
        self._next += len(piece)
        return piece


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
        self.size = self.end = self._base = 0
        self._index: list[bytes] = []
        self._bases: list[int] = []
        self._starts: list[tuple[int, int]] = []
        self._usable = True
        self._awaited = False

    def __bool__(self) -> bool:
        return bool(self.end)

    def take(self, file: BufferedIOBase, begun: BegunChunk) -> None:
        """Take a chunk; BagError if it is damaged, and the chunks taken before stay usable."""
        head = begun.head
        file.seek(begun.start)
        into = self._reserve(head.size)
        if head.compression:
            packed = self._read(file, head.length)
            if not _decompress_into(into, head, packed, self._zstd):
                into[:] = _decompress(head, packed, self._zstd)
        elif file.readinto(into) < head.size:
            raise BagError('chunk damaged: it ends early')
        _check(head, into)
        self._starts.append((self.size, begun.at - HEAD.size))
        self._usable = self._usable and not self._awaited
        self._awaited = True
        self._base, self.size, self.end = self.size, self.size + head.size, begun.end

    def _reserve(self, size: int) -> memoryview:
        """Return memory after the records taken so far; enlarge it if needed."""
        if self.size + size > len(self._memory):
            larger = memoryview(bytearray(max(self.size + size, 2 * self.size)))
            larger[:self.size] = self._memory[:self.size]
            self._memory = larger
        return self._memory[self.size:self.size + size]

    def _read(self, file: BufferedIOBase, length: int) -> memoryview:
        if length > len(self._packed):
            self._packed = memoryview(bytearray(length))
        return self._packed[:file.readinto(self._packed[:length])]

    def add_index(self, entries: bytes) -> None:
        """Take the entries of a message index of the newest chunk."""
        self._awaited = False
        self._index.append(entries)
        self._bases.append(self._base)

    def block(self) -> Block:
        """
        Return the messages as a block, valid until the next chunk is taken.

        Raises
        ------
        BagError
            If the records do not fill the chunks, or a message has an impossible log time.

        """
        block = block_of(self._memory[:self.size], self._starts[0][1], self._offsets)
        refuse_untimed(block, self._locate)
        return block

    def _locate(self, at: int) -> int:
        """Return where in the file the chunk with a byte of the block begins."""
        return self._starts[bisect_right(self._starts, at, key=itemgetter(0)) - 1][1]

    def _offsets(self) -> Integers | None:
        """Return the message offsets that the indexes name; None unless each chunk has indexes."""
        if not self._usable or self._awaited or not self._index:
            return None
        counts = [len(entries) >> 4 for entries in self._index]
        entries = np.frombuffer(b''.join(self._index), '<i8')
        return entries[1::2] + np.repeat(np.array(self._bases, np.int64), counts)
