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

"""
The writer of MCAP files, chunk by chunk and many messages at a time.

The file on disk always ends with a whole chunk. A write that fails, for instance because the disk
is full, is undone, and the data is kept for the next attempt.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from hashlib import sha256
from itertools import count
import os
import struct
from typing import BinaryIO, Callable, Iterator, Mapping, Sequence
import zlib

import lz4.frame
from mcap import records as mcap
from mcap.opcode import Opcode
import numpy as np
from numpy.typing import ArrayLike
import zstandard

from heading_intercompare.core.records import Integers
from heading_intercompare.messages.byte_columns import BytesLike

from .attachments import read_attachment
from .checksum import crc32
from .chunk_chain import ChunkChain
from .chunk_runs import Chunk
from .index_records import build_ending, build_record, chunk_index, find_attached, message_index
from .message_blocks import ENTRY_BYTES, HEAD, MESSAGE_HEAD, MESSAGE_HEADS, Record, walk
from .record_stream import MAGIC


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """
    Many messages of one topic.

    Attributes
    ----------
    topic
        A topic that was added.
    data : ndarray of uint8, shape (n, size)
        One CDR message per row.
    log_time_ns : array_like of int, shape (n,)
        Nanoseconds; also the publish time, unless one is given.
    publish_time_ns : array_like of int, shape (n,), optional
        Nanoseconds.
    sequence : array_like of int, shape (n,) or scalar
        Sequence numbers.

    """

    topic: str
    data: np.ndarray
    log_time_ns: ArrayLike
    publish_time_ns: ArrayLike | None = None
    sequence: ArrayLike = 0

    def records(self, channel: int) -> list[bytes]:
        """Return the messages as MCAP records."""
        count, size = self.data.shape
        log = np.asarray(self.log_time_ns)
        head = np.empty(count, MESSAGE_HEADS)
        head['opcode'], head['channel'] = Opcode.MESSAGE, channel
        head['length'] = head.itemsize - HEAD.size + size
        head['sequence'], head['log_time'] = self.sequence, log
        head['publish_time'] = log if self.publish_time_ns is None else self.publish_time_ns
        records = np.empty((count, head.itemsize + size), np.uint8)
        records[:, :head.itemsize] = head.view(np.uint8).reshape(count, head.itemsize)
        records[:, head.itemsize:] = self.data
        return records.view(f'V{records.shape[1]}').ravel().tolist()


class Records:
    """
    Message records within some data, in the order to write them.

    Parameters
    ----------
    data : bytes-like
        The bytes that hold the records.
    start, stop : ndarray of int64, shape (n,)
        First byte of each record, and the byte after its last; rising, without overlap.
    channel, log_time_ns : ndarray of int, shape (n,)
        Channel and log time of each record, as they are in it.

    Attributes
    ----------
    ends : ndarray of int64, shape (n,)
        Where each record ends when they are written without gaps.

    """

    def __init__(self, data: BytesLike, start: Integers, stop: Integers, channel: Integers,
                 log_time_ns: Integers) -> None:
        self.channel, self.log_time_ns = channel, log_time_ns
        self.ends = np.cumsum(stop - start)
        self._data, self._start, self._stop = memoryview(data), start, stop
        self._breaks = np.flatnonzero(start[1:] != stop[:-1]) + 1

    def __len__(self) -> int:
        return len(self.ends)

    def piece(self, lo: int, hi: int) -> bytes:
        """Return the records `lo` to `hi`, `hi` excluded, without gaps."""
        first = np.searchsorted(self._breaks, lo, 'right')
        edges = [lo, *self._breaks[first:np.searchsorted(self._breaks, hi)].tolist(), hi]
        return b''.join([self._data[self._start[a]:self._stop[b - 1]]
                         for a, b in zip(edges[:-1], edges[1:])])


#: Fast; on these messages higher levels hardly compress better.
_ZSTD_LEVEL = 1

_CRC = struct.Struct('<I')

#: Every so often a chunk defines all topics again: a file whose first chunk is damaged and whose
#: summary is cut can then still be read. Counted in chunks.
_DEFINED_EVERY = 32

_COMPRESS: dict[str, tuple[str, Callable[[bytes], bytes]]] = {
    'none': ('', bytes),
    'lz4': ('lz4', lz4.frame.compress),
    'zstd': ('zstd', lambda data: zstandard.ZstdCompressor(level=_ZSTD_LEVEL).compress(data)),
}

#: MCAP's names of the compressions, by their names in the settings.
COMPRESSIONS = {name: written for name, (written, _) in _COMPRESS.items()}


#: The number of a channel or schema that may have any.
ANY_NUMBER = -1


def _free(used: Mapping[int, object], preferred_id: int, numbers: Iterator[int]) -> int:
    """Return an unused number: `preferred_id` if it is free, otherwise the next of `numbers`."""
    if preferred_id != ANY_NUMBER and preferred_id not in used:
        return preferred_id
    return next(number for number in numbers if number not in used)


class ChunkWriter:
    """
    An MCAP file with chunks, indexes, checksums and statistics.

    Parameters
    ----------
    file : binary file
        New, unbuffered, open for writing.
    compression : {'none', 'lz4', 'zstd'}
        Compression of the chunks.
    chunk_bytes
        Size at which a chunk ends.
    library
        Program and version, for the header.

    Attributes
    ----------
    chain : ChunkChain
        The chain through the chunks written; a file that goes on after another one is given its.

    """

    def __init__(self, file: BinaryIO, compression: str, chunk_bytes: int, library: str) -> None:
        self._file = file
        self._compression, self._compress = _COMPRESS[compression]
        self._chunk_bytes = chunk_bytes
        self._end = 0
        self._schemas: dict[int, mcap.Schema] = {}
        self._channels: dict[int, mcap.Channel] = {}
        self._schema_ids: dict[tuple[str, str, bytes], int] = {}
        #: Numbers not tried yet, for channels and schemas: a number is never used again.
        self._numbers = count(1), count(1)
        #: The records of schemas and channels, in order of arrival.
        self._defined: dict[bytes, None] = {}
        self._chunk_indexes: list[bytes] = []
        #: Chunks since the last one that defines all topics.
        self._undefined = 0
        self.chain = ChunkChain()
        self._attachment_indexes: list[bytes] = []
        self._metadata_indexes: list[bytes] = []
        self.counts: dict[int, int] = {}
        self.start_ns: int | None = None
        self.end_ns: int | None = None
        self._begin_chunk()
        self._append(MAGIC + build_record(mcap.Header('ros2', library)))

    @property
    def pending(self) -> bool:
        """Whether messages wait in memory."""
        return bool(self._index)

    # The chunk in memory

    def _begin_chunk(self) -> None:
        self._pieces: list[bytes] = []
        self._size = 0
        self._first, self._last = 2**64, 0
        #: The entries of the message index of each channel: log time and offset.
        self._index: dict[int, bytearray] = {}
        self._held: set[bytes] = set()
        if self._undefined >= _DEFINED_EVERY - 1:
            self._redefine()

    def _redefine(self) -> None:
        for definition in self._defined:
            if definition not in self._held:
                self._hold(definition)

    def _hold(self, definition: bytes) -> None:
        self._held.add(definition)
        self._add(definition)

    def _add(self, piece: bytes) -> None:
        self._pieces.append(piece)
        self._size += len(piece)

    def _define(self, record: mcap.Schema | mcap.Channel) -> None:
        definition = build_record(record)
        self._defined[definition] = None
        self._hold(definition)

    def add_channel(self, topic: str, type_name: str, schema_text: str,
                    metadata: Mapping[str, str]) -> int:
        """Add a channel of ROS 2 and return its number."""
        return self.define(
            mcap.Channel(id=ANY_NUMBER, topic=topic, message_encoding='cdr',
                         metadata=dict(metadata), schema_id=ANY_NUMBER),
            mcap.Schema(id=ANY_NUMBER, name=type_name, encoding='ros2msg',
                        data=schema_text.encode()))

    def define(self, channel: mcap.Channel, schema: mcap.Schema | None) -> int:
        """
        Add a channel and return its number; its definition goes into the chunk in memory.

        It and its schema keep their numbers if these are free. A channel may have no schema.
        """
        schema_id = 0
        if schema is not None:
            key = schema.name, schema.encoding, schema.data
            if key not in self._schema_ids:
                schema = replace(schema, id=_free(self._schemas, schema.id, self._numbers[1]))
                self._schemas[schema.id], self._schema_ids[key] = schema, schema.id
                self._define(schema)
            schema_id = self._schema_ids[key]
        channel = replace(channel, id=_free(self._channels, channel.id, self._numbers[0]),
                          schema_id=schema_id)
        self._channels[channel.id] = channel
        self._define(channel)
        return channel.id

    def add(self, channel: int, data: bytes, log_time_ns: int, publish_time_ns: int,
            sequence: int) -> None:
        """Take one message."""
        head = MESSAGE_HEAD.pack(Opcode.MESSAGE, MESSAGE_HEAD.size - HEAD.size + len(data),
                                 channel, sequence, log_time_ns, publish_time_ns)
        entry = log_time_ns.to_bytes(8, 'little') + self._size.to_bytes(8, 'little')
        self._index.setdefault(channel, bytearray()).extend(entry)
        self._first, self._last = min(self._first, log_time_ns), max(self._last, log_time_ns)
        self._add(head)
        self._add(data)
        if self._size >= self._chunk_bytes:
            self.end_chunk()

    def add_records(self, records: list[bytes], channel: Integers,
                    log_time_ns: Integers) -> None:
        """
        Take whole message records.

        Parameters
        ----------
        records
            n records, in the order to write them.
        channel, log_time_ns : ndarray of int64, shape (n,)
            Channel and log time of each record.

        """
        ends = np.cumsum(np.fromiter(map(len, records), np.int64, len(records)))
        starts = np.concatenate(([0], ends[:-1]))
        lo = 0
        while lo < len(records):
            room = self._chunk_bytes - self._size
            hi = int(np.searchsorted(ends, starts[lo] + max(room, 0))) + 1
            hi = min(max(hi, lo + 1), len(records))
            self._index_all(channel[lo:hi], log_time_ns[lo:hi], starts[lo:hi] - starts[lo])
            self._add(b''.join(records[lo:hi]))
            if self._size >= self._chunk_bytes:
                self.end_chunk()
            lo = hi

    def _index_all(self, channel: Integers, log: Integers, at: Integers) -> None:
        """Index messages that will lie `at` bytes after the records in memory."""
        entries = np.stack((log, at + self._size), axis=1)
        for number in np.unique(channel).tolist():
            mine = entries[channel == number].astype('<i8').tobytes()
            self._index.setdefault(number, bytearray()).extend(mine)
        self._first = min(self._first, int(log.min()))
        self._last = max(self._last, int(log.max()))

    def fill(self, records: Records, lo: int) -> int:
        """Take records from `lo` on until a chunk is full; return the index of the next record."""
        ends = records.ends
        begin = int(ends[lo - 1]) if lo else 0
        hi = int(np.searchsorted(ends, begin + max(self._chunk_bytes - self._size, 0))) + 1
        hi = min(hi, len(records))
        starts = np.concatenate(([0], ends[lo:hi - 1] - begin))
        self._index_all(records.channel[lo:hi], records.log_time_ns[lo:hi], starts)
        self._add(records.piece(lo, hi))
        if self._size >= self._chunk_bytes:
            self.end_chunk()
        return hi

    # Chunks copied unchanged

    def defines(self, definitions: frozenset[bytes]) -> bool:
        """Tell whether these records of definitions are those of this file."""
        return definitions <= self._defined.keys()

    def can_begin_with(self, chunk: Chunk) -> bool:
        """Tell whether a chunk holds the definitions that the next chunk must hold."""
        return self._held <= chunk.definitions

    def append(self, data: BytesLike, chunk: Chunk) -> None:
        """
        Write a chunk unchanged, with its message indexes, after the messages in memory.

        Parameters
        ----------
        data : bytes-like
            The chunk and its indexes.
        chunk
            Its contents: channels and definitions of this file, with which the next can begin.

        """
        self.end_chunk()
        start, size = self._end, chunk.end - chunk.start
        self._append(data)
        self.chain = self.chain.after(sha256(memoryview(data)[:size]))
        self._list(start, start + size, chunk.counts, chunk.first_ns, chunk.last_ns,
                   chunk.compression, chunk.packed, chunk.size, chunk.definitions)
        self._begin_chunk()

    def take_pending(self) -> list[tuple[int, bytes, int, int, int]]:
        """Take the messages out of memory, each as arguments of `add`; definitions stay."""
        data = b''.join(self._pieces)
        messages, _ = walk(data, 0, len(data))
        pending = []
        for at in messages:
            _, length, channel, sequence, log, publish = MESSAGE_HEAD.unpack_from(data, at)
            payload = data[at + MESSAGE_HEAD.size:at + HEAD.size + length]
            pending.append((channel, payload, log, publish, sequence))
        self._begin_chunk()
        self._redefine()
        return pending

    # The file

    @property
    def size(self) -> int:
        """Bytes written to the file."""
        return self._end

    def _append(self, data: BytesLike) -> None:
        """Write all the data; or write nothing and raise OSError."""
        rest = memoryview(data)
        try:
            while rest:
                rest = rest[self._file.write(rest):]
        except OSError as error:
            with suppress(OSError):
                self._file.truncate(self._end)
            self._file.seek(self._end)
            error.filename = error.filename or os.fspath(self._file.name)
            raise
        self._end += len(data)

    def end_chunk(self) -> None:
        """Write the messages in memory as a chunk; OSError leaves them there."""
        if not self._index:
            return
        data = b''.join(self._pieces)
        packed = self._compress(data)
        chunk = build_record(mcap.Chunk(compression=self._compression, data=packed,
                                        message_start_time=self._first,
                                        message_end_time=self._last,
                                        uncompressed_crc=zlib.crc32(data),
                                        uncompressed_size=len(data)))
        start = self._end
        self._append(b''.join((chunk, *(message_index(channel, entries)
                                        for channel, entries in self._index.items()))))
        self.chain = self.chain.after(sha256(chunk))
        counts = [(channel, len(entries) // ENTRY_BYTES)
                  for channel, entries in self._index.items()]
        self._list(start, start + len(chunk), counts, self._first, self._last, self._compression,
                   len(packed), len(data), self._held)
        self._begin_chunk()

    def _list(self, start: int, end: int, counts: Sequence[tuple[int, int]], first_ns: int,
              last_ns: int, compression: str, packed: int, size: int,
              definitions: set[bytes] | frozenset[bytes]) -> None:
        """Enter a written chunk into the indexes and statistics."""
        self._chunk_indexes.append(
            chunk_index(start, end, counts, first_ns, last_ns, compression, packed, size))
        for channel, number in counts:
            self.counts[channel] = self.counts.get(channel, 0) + number
        self.start_ns = first_ns if self.start_ns is None else min(first_ns, self.start_ns)
        self.end_ns = last_ns if self.end_ns is None else max(last_ns, self.end_ns)
        self._undefined = 0 if self._defined.keys() <= definitions else self._undefined + 1

    def add_metadata(self, name: str, mapping: Mapping[str, str]) -> None:
        """Write a metadata record."""
        record = build_record(mcap.Metadata(name=name, metadata=dict(mapping)))
        index = mcap.MetadataIndex(offset=self._end, length=len(record), name=name)
        self._append(record)
        self._metadata_indexes.append(build_record(index))

    def add_attachment(self, name: str, media_type: str, data: bytes, time_ns: int) -> None:
        """Write an attachment."""
        self.append_attachment(bytearray(build_record(mcap.Attachment(
            create_time=time_ns, log_time=time_ns, name=name, media_type=media_type, data=data))))

    def append_attachment(self, record: bytearray) -> None:
        """
        Write an attachment from a whole record whose lengths agree; set its checksum.

        Nothing that follows its fields is kept.
        In names that are no UTF-8, which few readers accept, U+FFFD replaces what is none.
        """
        attached = find_attached(lambda at, size: record[at:at + size],
                                 Record(Opcode.ATTACHMENT, HEAD.size, len(record) - HEAD.size))
        assert attached is not None
        data_at, crc_at = attached
        # The fields before the data, followed by empty data.
        begun = bytes(record[HEAD.size:data_at - 8]) + bytes(8 + _CRC.size)
        head = read_attachment(begun)
        if not all(name.encode() in begun for name in (head.name, head.media_type)):
            head.data = bytes(record[data_at:crc_at])
            self.append_attachment(bytearray(build_record(head)))
            return
        del record[crc_at + _CRC.size:]
        HEAD.pack_into(record, 0, Opcode.ATTACHMENT, len(record) - HEAD.size)
        with memoryview(record) as view:
            crc = crc32(view[HEAD.size:crc_at])
        _CRC.pack_into(record, crc_at, crc)
        index = mcap.AttachmentIndex(offset=self._end, length=len(record),
                                     create_time=head.create_time, log_time=head.log_time,
                                     data_size=crc_at - data_at, name=head.name,
                                     media_type=head.media_type)
        self._append(record)
        self._attachment_indexes.append(build_record(index))

    def sync(self) -> None:
        """Wait until the written data is on the disk."""
        os.fsync(self._file.fileno())

    def finish(self) -> None:
        """Write the summary and the end of the file."""
        self.end_chunk()
        self._append(build_ending(self._end, tuple(self._schemas.values()),
                                  tuple(self._channels.values()), self._chunk_indexes,
                                  self._attachment_indexes, self._metadata_indexes, self.counts,
                                  (self.start_ns or 0, self.end_ns or 0)))
