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

"""The records of an MCAP file in file order, with the messages grouped into blocks."""

from __future__ import annotations

from io import BufferedIOBase, BytesIO
import os
import struct
from typing import Any, Iterator, Mapping, Protocol, TypeVar

from mcap import records as mcap
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode

from heading_intercompare.bags.errors import BagError
from heading_intercompare.messages.byte_columns import BytesLike

from .chunks import begin_chunk, BegunChunk, Gathering, LargeChunk, RECORD_BYTES, UNFIT
from .message_blocks import (
    Block,
    block_of,
    ENTRY_BYTES,
    HEAD,
    INDEX_LEAST,
    measure_whole,
    MESSAGE_HEAD,
    passed_block,
    Record,
    refuse_untimed,
)

MAGIC = b'\x89MCAP0\r\n'

_BARE = (Opcode.MESSAGE, Opcode.SCHEMA, Opcode.CHANNEL)
#: Messages outside chunks are read in pieces of this many bytes.
_BARE_BYTES = 1048576
#: A record that claims to be larger is not read.
_RECORD_LIMIT = 2**31


class _Readable(Protocol):
    """A kind of MCAP record that can be read."""

    @staticmethod
    def read(stream: ReadDataStream) -> Any:
        """Return a record of this kind."""


_AnyRecord = TypeVar('_AnyRecord', bound=_Readable)


class _AnyText(ReadDataStream):
    """Reads texts that are no UTF-8; wrong bytes become escapes, as Python writes them."""

    def read_prefixed_string(self) -> str:
        """Return the next text, whose length comes before it."""
        return self.read(self.read4()).decode(errors='backslashreplace')


def parse_record(kind: type[_AnyRecord], content: BytesLike, *,
                 any_text: bool = False) -> _AnyRecord:
    """
    Return an MCAP record from the bytes after its head.

    Parameters
    ----------
    kind
        The kind of record.
    content : bytes-like
        The bytes.
    any_text
        Its texts may be no UTF-8, as where its checksum proves that it was written like that.

    Raises
    ------
    BagError
        If it is damaged.

    """
    stream = _AnyText if any_text else ReadDataStream
    try:
        record: _AnyRecord = kind.read(stream(BytesIO(content)))
        return record
    except (McapError, struct.error, ValueError, OverflowError, MemoryError):
        raise BagError(f'a record of type {kind.__name__} is damaged') from None


def meaning_of(definition: mcap.Schema | mcap.Channel) -> tuple[object, ...]:
    """Return what decides to which topic and type messages belong; first its name."""
    if isinstance(definition, mcap.Schema):
        return definition.name, definition.encoding, definition.data
    return definition.topic, definition.message_encoding, definition.schema_id


class RecordStream:
    """
    The records of an open MCAP file. Errors carry the byte, not the path.

    Parameters
    ----------
    file : binary file
        Open for reading, buffered, seekable.

    """

    def __init__(self, file: BufferedIOBase) -> None:
        self._file = file
        self._chunks = Gathering()
        self.size = file.seek(0, os.SEEK_END)

    def record(self, at: int, end: int | None = None) -> Record:
        """Return the record at byte `at`, ending by `end`; leave the file just after its head."""
        if at >= self.size:
            raise BagError('it has no end', offset=at)
        self._file.seek(at)
        head = self._file.read(HEAD.size)
        if len(head) < HEAD.size:
            raise BagError('a record ends early', offset=at)
        opcode, length = HEAD.unpack(head)
        if not opcode:
            raise BagError('no record begins', offset=at)
        if at + HEAD.size + length > (self.size if end is None else end):
            raise BagError('a record ends early', offset=at)
        return Record(opcode, at + HEAD.size, length)

    def content(self, record: Record) -> bytes:
        """Return the bytes of a record after its head."""
        return self._read(record.start, record.length)

    def _read(self, at: int, length: int) -> bytes:
        if length <= _RECORD_LIMIT:
            self._file.seek(at)
            try:
                return self._file.read(length)
            except MemoryError:
                pass
        raise BagError(f'a record of {length} bytes does not fit into memory', offset=at)

    def _read_bare(self, record: Record, end: int) -> tuple[Block, int]:
        """Return the messages outside chunks from a record on, and where they end."""
        at = record.start - HEAD.size
        if record.opcode == Opcode.MESSAGE and RECORD_BYTES < record.length <= _RECORD_LIMIT:
            head = self._read(at, MESSAGE_HEAD.size)
            return passed_block(head, at), record.start + record.length
        data = self._read(at, min(max(_BARE_BYTES, HEAD.size + record.length), end - at))
        block = block_of(data[:measure_whole(data, _BARE)], at)
        try:
            refuse_untimed(block, lambda place: at + place)
        except BagError as error:
            # The messages before it are sound; the next call begins with it.
            if error.offset in (None, at):
                raise
            block = block_of(data[:error.offset - at], at)
        return block, at + len(block.data)

    def _read_index(self, record: Record, after_chunk: bool) -> int:
        """Return the bytes of its entries; BagError if it is malformed or follows no chunk."""
        at = record.start - HEAD.size
        if not after_chunk:
            raise BagError('damaged: a message index follows no chunk', offset=at)
        room = record.length - INDEX_LEAST
        size = int.from_bytes(self._file.read(INDEX_LEAST)[2:], 'little')
        if not 0 <= size <= room or size % ENTRY_BYTES:
            raise BagError('message index damaged: its lengths do not agree', offset=at)
        return size

    def _large(self, begun: BegunChunk, at: int) -> Iterator[tuple[Block, int]]:
        """Yield the blocks of a large chunk, once all of it is proved; it ends with the last."""
        chunk = LargeChunk(self._file, begun)
        chunk.verify()
        for block in chunk.blocks(passes_over=True):
            refuse_untimed(block, lambda place: at)
            yield block, at
        yield block_of(b'', at), begun.end

    def pieces(self, at: int, end: int, least: int, start_ns: int = 0, stop_ns: int = 2**64,
               heads: Mapping[int, tuple[int, int, int]] | None = None,
               ) -> Iterator[tuple[Block | Record, int]]:
        """
        Yield blocks and other records, each with the byte after it, up to the end of the data.

        A block is valid until the next piece is requested, from this or another call.

        Parameters
        ----------
        at, end
            Bytes of the file between which to read; a record begins at each.
        least
            Chunks are joined to a block until they have this many bytes, for speed.
        start_ns, stop_ns
            Chunks that lie outside [start, stop) in log time are skipped.
        heads
            For each chunk in the index of the file, by offset: its first and last log time, and
            the size of its records. Empty or None if there is no index.

        Raises
        ------
        BagError
            At the first record that cannot be read, after yielding everything before it.

        """
        chunks, in_span, after_chunk = self._chunks, False, False
        chunks.clear()
        while at < end:
            try:
                record = self.record(at, end)
                opcode, start, length = record
                if opcode == Opcode.MESSAGE_INDEX:
                    size = self._read_index(record, after_chunk)
                    if in_span:
                        chunks.add_index(self._read(start + INDEX_LEAST, size))
                    at = start + length
                    continue
            except BagError:
                yield from self._take_block()
                raise
            after_chunk = opcode == Opcode.CHUNK
            if chunks and (opcode != Opcode.CHUNK or chunks.size >= least):
                yield from self._take_block()
                self._file.seek(start)
            if opcode == Opcode.CHUNK:
                try:
                    begun = begin_chunk(self._file, length)
                    if heads and heads.get(at) != begun.said:
                        raise BagError(UNFIT)
                    first_ns, last_ns, _ = begun.said
                    in_span = first_ns < stop_ns and last_ns >= start_ns
                    if in_span and begun.is_large:
                        yield from self._take_block()
                        in_span = False
                        yield from self._large(begun, at)
                    elif in_span:
                        chunks.take(self._file, begun)
                except BagError as error:
                    yield from self._take_block()
                    raise error.locate('', at) from None
                at = start + length
            elif opcode in _BARE:
                block, at = self._read_bare(record, end)
                yield block, at
            else:
                at = start + length
                yield record, at
                if opcode == Opcode.DATA_END:
                    return
        yield from self._take_block()

    def _take_block(self) -> Iterator[tuple[Block, int]]:
        """Yield the chunks read so far as a block, if there are any."""
        if self._chunks:
            yield self._chunks.block(), self._chunks.end
            self._chunks.clear()
