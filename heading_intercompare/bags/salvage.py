# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
The sound records of an MCAP file, whatever happened to it.

A record is taken if it proves itself: a chunk by its checksum, others by lengths that agree with
each other and with what follows. Behind damage the next record that proves itself is looked for.
"""

from __future__ import annotations

from dataclasses import dataclass
import struct
from typing import BinaryIO, Iterator
import zlib

import lz4.frame
from mcap import records as mcap
from mcap.opcode import Opcode
import numpy as np
import zstandard

from .blocks import Block, block_of, HEAD, MESSAGE_HEAD, Record
from .chunks import CHUNK_HEAD, unpacked
from .errors import BagError
from .part import parsed
from .stream import MAGIC, RecordStream

__all__ = ['Gap', 'Salvage', 'Sound']

_FIXED = MESSAGE_HEAD.size - HEAD.size
_HIGHEST = int(Opcode.DATA_END)
#: From here on opcodes are of whoever uses them.
_PRIVATE = 0x80
_BARE = (Opcode.MESSAGE, Opcode.SCHEMA, Opcode.CHANNEL)
_SMALL = {Opcode.HEADER: mcap.Header, Opcode.SCHEMA: mcap.Schema, Opcode.CHANNEL: mcap.Channel,
          Opcode.METADATA: mcap.Metadata, Opcode.STATISTICS: mcap.Statistics}
#: Records with a checksum, and those whose lengths have to agree with each other.
_CHECKED = (Opcode.CHUNK, Opcode.ATTACHMENT)
_TELLING = (*_CHECKED, Opcode.HEADER, Opcode.METADATA, Opcode.MESSAGE_INDEX, Opcode.STATISTICS,
            Opcode.DATA_END, Opcode.FOOTER)
#: No record of `_SMALL` is believed that claims to be larger.
_SMALL_BYTES = 2**26
_CHUNK_BYTES = 2**31
_WINDOW_BYTES = 2**22
_PIECE_BYTES = 2**20


@dataclass(frozen=True, slots=True)
class Sound:
    """
    Something that can be read.

    Attributes
    ----------
    record : Record
        Where it is; of messages outside chunks the first.
    end : int
        The byte behind it.
    block : Block or None
        The messages and definitions in it.
    fault : str
        Why the block is not all of a chunk, empty if it is.

    """

    record: Record
    end: int
    block: Block | None = None
    fault: str = ''


@dataclass(frozen=True, slots=True)
class Gap:
    """
    Bytes that cannot be read.

    Attributes
    ----------
    start, end : int
        The first byte, and the one behind the last.
    fault : str
        What is wrong with the first of them.
    chunk : bool
        They begin with a chunk.

    """

    start: int
    end: int
    fault: str
    chunk: bool


def _chunk_records(content: bytes) -> tuple[str, bytes]:
    """Return compression and compressed records of a chunk that may be cut; lengths agree."""
    letters = CHUNK_HEAD.unpack_from(content)[4]
    start = CHUNK_HEAD.size + letters
    return content[CHUNK_HEAD.size:start].decode(errors='replace'), content[start + 8:]


def _begun(content: bytes) -> bytes:
    """Return what can be decompressed of a chunk whose end is missing."""
    compression, data = _chunk_records(content)
    size = CHUNK_HEAD.unpack_from(content)[2]
    begun = bytearray()
    try:
        if compression == 'zstd':
            with zstandard.ZstdDecompressor().stream_reader(data) as reader:
                while len(begun) < size and (piece := reader.read(_PIECE_BYTES)):
                    begun += piece
        elif compression == 'lz4':
            begun += lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size)
        elif not compression:
            begun += data
    except (zstandard.ZstdError, RuntimeError, MemoryError, EOFError):
        pass
    return bytes(begun[:size])


def _leading(data: bytes, first_ns: int, last_ns: int) -> int:
    """Return the size of the records with which a chunk of these log times begins soundly."""
    at = 0
    while at + HEAD.size <= len(data):
        opcode, length = HEAD.unpack_from(data, at)
        behind = at + HEAD.size + length
        if opcode not in _BARE or behind > len(data) or (
                opcode == Opcode.MESSAGE and length < _FIXED):
            break
        if opcode == Opcode.MESSAGE:
            log = MESSAGE_HEAD.unpack_from(data, at)[4]
            if not first_ns <= log <= last_ns:
                break
        at = behind
    return at


class Salvage:
    """
    An open file that once was MCAP; never raises BagError.

    Parameters
    ----------
    file : binary file
        Open for reading, seekable.

    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._stream = RecordStream(file)
        self.size = self._stream.size
        self._zstd = zstandard.ZstdDecompressor()
        self._chunked = False
        self._previous = 0
        self._fault = ''

    def content(self, record: Record) -> bytes:
        """Return the bytes of a record behind its head."""
        return self._stream.content(record)

    def _read(self, at: int, size: int) -> bytes:
        self._file.seek(at)
        return self._file.read(size)

    def scan(self) -> Iterator[Sound | Gap]:
        """Yield what the file consists of, in its order; memory stays that of a chunk."""
        at = len(MAGIC) if self._read(0, len(MAGIC)) == MAGIC else 0
        unsure = at
        while at < self.size:
            if self._read(at, len(MAGIC)) == MAGIC:
                at += len(MAGIC)
                continue
            found = self._sound(at)
            if found is not None:
                unsure = found.end if found.record.opcode in _CHECKED else at
                at, self._previous = found.end, found.record.opcode
                self._chunked = self._chunked or found.record.opcode == Opcode.CHUNK
                yield found
                continue
            fault, chunk = self._fault, self._read(at, 1) == bytes([Opcode.CHUNK])
            # The record before, if no checksum vouches for it, may have swallowed a chunk.
            swallowed = self._search(unsure + 1, at, (Opcode.CHUNK,)) if unsure < at else at
            start, at = min(at, swallowed), swallowed if swallowed < at else self._behind(at)
            unsure = at
            yield Gap(start, at, fault, chunk)

    def _head(self, at: int) -> Record | None:
        """Return the record at a byte if its head is possible and it ends within the file."""
        head = self._read(at, HEAD.size)
        if len(head) < HEAD.size:
            self._fault = 'a record ends early'
            return None
        opcode, length = HEAD.unpack(head)
        end = at + HEAD.size + length
        if not (1 <= opcode <= _HIGHEST or opcode >= _PRIVATE):
            self._fault = 'no record begins' if any(head) else 'zero bytes'
        elif end > self.size:
            self._fault = 'a record ends early'
        else:
            return Record(opcode, at + HEAD.size, length)
        return None

    def _followed(self, end: int) -> bool:
        """Tell whether something that can follow a record is at a byte."""
        return (end == self.size or self._head(end) is not None
                or self._read(end, len(MAGIC)) == MAGIC or self._cut_chunk(end) is not None)

    def _sound(self, at: int) -> Sound | None:
        """Return what is at a byte, if it proves itself; else say why not in `_fault`."""
        record = self._head(at)
        if record is None:
            return self._cut_chunk(at)
        opcode, end = record.opcode, record.start + record.length
        if opcode == Opcode.CHUNK:
            return self._chunk(at, record)
        self._fault = 'a record is damaged'
        if opcode == Opcode.MESSAGE:
            good = record.length >= _FIXED and self._followed(end) and self._among_messages(end)
        elif opcode in _SMALL:
            good = self._parses(record)
        elif opcode == Opcode.ATTACHMENT:
            good = self._attachment(record)
        elif opcode == Opcode.MESSAGE_INDEX:
            good = record.length >= 6 and self._read(
                record.start + 2, 4) == (record.length - 6).to_bytes(8, 'little')[:4]
        elif opcode == Opcode.DATA_END:
            good = record.length == 4
        elif opcode == Opcode.FOOTER:
            good = record.length == 20
        else:
            good = self._followed(end)
        if not good:
            return None
        if opcode in _BARE:
            return Sound(record, end, block_of(self._read(at, end - at), at))
        return Sound(record, end)

    def _among_messages(self, end: int) -> bool:
        """Tell whether a message outside chunks has its like beside it; alone it is a mistake."""
        return (not self._chunked or self._previous == Opcode.MESSAGE
                or self._read(end, 1) == bytes([Opcode.MESSAGE]))

    def _parses(self, record: Record) -> bool:
        if record.length > _SMALL_BYTES:
            return False
        try:
            read = parsed(_SMALL[record.opcode], self.content(record))
        except BagError:
            return False
        return _written_size(read) == record.length

    def _attachment(self, record: Record) -> bool:
        """Tell whether lengths and checksum of an attachment agree."""
        at, end = record.start + 16, record.start + record.length - 4
        for width in (4, 4, 8):
            if at + width > end:
                return False
            at += width + int.from_bytes(self._read(at, width), 'little')
        if at != end:
            return False
        crc, at = 0, record.start
        while at < end:
            piece = self._read(at, min(_WINDOW_BYTES, end - at))
            crc, at = zlib.crc32(piece, crc), at + len(piece)
        return int.from_bytes(self._read(end, 4), 'little') in (0, crc)

    def _chunk_head(self, at: int) -> tuple[int, int, int] | None:
        """Return length of a chunk, first and last log time, if its head agrees with itself."""
        data = self._read(at, HEAD.size + CHUNK_HEAD.size + 16)
        if len(data) < HEAD.size + CHUNK_HEAD.size or data[0] != Opcode.CHUNK:
            return None
        length = HEAD.unpack_from(data)[1]
        first, last, size, _, letters = CHUNK_HEAD.unpack_from(data, HEAD.size)
        start = HEAD.size + CHUNK_HEAD.size + letters
        if letters > 8 or len(data) < start + 8 or first > last:
            return None
        inner = struct.unpack_from('<Q', data, start)[0]
        if (CHUNK_HEAD.size + letters + 8 + inner != length
                or max(size, length) > _CHUNK_BYTES):
            return None
        return length, first, last

    def _chunk(self, at: int, record: Record) -> Sound | None:
        """Return a whole chunk whose checksum is right."""
        head = self._chunk_head(at)
        if head is None:
            self._fault = 'chunk damaged: its head does not agree with itself'
            return None
        content = self.content(record)
        try:
            data = unpacked(content, self._zstd)
        except BagError as error:
            self._fault = error.problem
            return None
        end = record.start + record.length
        try:
            return Sound(record, end, block_of(bytes(data), at))
        except BagError as error:
            # Without a checksum in its head, or written so: what comes first may be right.
            data = bytes(data[:_leading(data, *head[1:])])
            return Sound(record, end, block_of(data, at), error.problem)

    def _cut_chunk(self, at: int) -> Sound | None:
        """Return what a chunk that the file ends in begins with."""
        head = self._chunk_head(at)
        if head is None or at + HEAD.size + head[0] <= self.size:
            return None
        content = self._read(at + HEAD.size, self.size - at - HEAD.size)
        data = _begun(content)
        data = bytes(data[:_leading(data, *head[1:])])
        return Sound(Record(Opcode.CHUNK, at + HEAD.size, len(content)), self.size,
                     block_of(data, at), 'the file ends within a chunk')

    def _behind(self, at: int) -> int:
        """Return where, behind damage that begins at a byte, a sound record begins."""
        head = self._chunk_head(at)
        if head is not None and at + HEAD.size + head[0] <= self.size and self._followed(
                at + HEAD.size + head[0]):
            return at + HEAD.size + head[0]
        return self._search(at + 1, self.size,
                            _TELLING if self._chunked else (*_TELLING, *_BARE))

    def _search(self, at: int, end: int, opcodes: tuple[int, ...]) -> int:
        """Return where between two bytes one of these records proves itself; `end` if nowhere."""
        while at < end:
            step = min(_WINDOW_BYTES, end - at)
            window = self._read(at, step + HEAD.size - 1)
            for place in _candidates(window, self.size - at, opcodes).tolist():
                if self._read(at + place, len(MAGIC)) == MAGIC or self._sound(at + place):
                    return at + place
            at += step
        return end


def _written_size(record: mcap.McapRecord) -> int:
    """Return how long the content of a record of `_SMALL` is when it is written."""
    if isinstance(record, mcap.Header):
        return 8 + len(record.profile.encode()) + len(record.library.encode())
    if isinstance(record, mcap.Schema):
        return 14 + sum(len(x) for x in (record.name.encode(), record.encoding.encode(),
                                         record.data))
    if isinstance(record, mcap.Statistics):
        return 46 + 10 * len(record.channel_message_counts)
    size = sum(8 + len(k.encode()) + len(v.encode()) for k, v in record.metadata.items())
    if isinstance(record, mcap.Channel):
        return 16 + size + len(record.topic.encode()) + len(record.message_encoding.encode())
    return 8 + size + len(record.name.encode())


def _candidates(window: bytes, room: int, opcodes: tuple[int, ...]) -> np.ndarray:
    """Return where in a window such a record may begin that ends within `room` bytes."""
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
