# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
MCAP written chunk by chunk, many messages at a time.

The file on disk ends with a whole chunk at every moment: a write that fails, for instance because
the disk is full, is taken back, and what was to be written is kept for the next attempt.
"""

from __future__ import annotations

from contextlib import suppress
import os
from typing import BinaryIO, Callable, Mapping
import zlib

import lz4.frame
from mcap import records as mcap
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
import numpy as np
import zstandard

from .blocks import HEAD, MESSAGE_HEAD, walk
from .stream import MAGIC

__all__ = ['ChunkWriter']

#: Fast, and on these messages hardly larger than higher levels.
_ZSTD_LEVEL = 1

#: Chunks from one that defines all topics to the next: a file whose first chunk is damaged and
#: whose summary is cut can then still be understood.
_DEFINED_EVERY = 32

_COMPRESS: dict[str, tuple[str, Callable[[bytes], bytes]]] = {
    'none': ('', bytes),
    'lz4': ('lz4', lz4.frame.compress),
    'zstd': ('zstd', lambda data: zstandard.ZstdCompressor(level=_ZSTD_LEVEL).compress(data)),
}


def _built(record: mcap.McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return builder.end()


class ChunkWriter:
    """
    An MCAP file with chunks, indexes, checksums and statistics.

    Parameters
    ----------
    file : binary file
        New, unbuffered, open for writing.
    compression : {'none', 'lz4', 'zstd'}
        Of the chunks.
    chunk_bytes : int
        Size at which a chunk ends.
    library : str
        Program and version, for the header.

    """

    def __init__(self, file: BinaryIO, compression: str, chunk_bytes: int, library: str) -> None:
        self._file = file
        self._compression, self._compress = _COMPRESS[compression]
        self._chunk_bytes = chunk_bytes
        self._end = 0
        self._schemas: list[mcap.Schema] = []
        self._channels: list[mcap.Channel] = []
        self._chunk_indexes: list[mcap.ChunkIndex] = []
        self._extra_indexes: list[mcap.AttachmentIndex | mcap.MetadataIndex] = []
        self.counts: dict[int, int] = {}
        self.start_ns: int | None = None
        self.end_ns: int | None = None
        self._begin_chunk()
        self._append(MAGIC + _built(mcap.Header('ros2', library)))

    @property
    def pending(self) -> bool:
        """Whether messages wait in memory."""
        return bool(self._index)

    # The chunk in memory

    def _begin_chunk(self) -> None:
        self._pieces: list[bytes] = []
        self._size = 0
        self._first, self._last = 2**64, 0
        #: By channel, the entries of its message index: log time and offset.
        self._index: dict[int, bytearray] = {}
        if self._chunk_indexes and len(self._chunk_indexes) % _DEFINED_EVERY == 0:
            self._redefine()

    def _redefine(self) -> None:
        for definition in (*self._schemas, *self._channels):
            self._add(_built(definition))

    def _add(self, piece: bytes) -> None:
        self._pieces.append(piece)
        self._size += len(piece)

    def add_channel(self, topic: str, type_name: str, schema_text: str,
                    metadata: Mapping[str, str], encoding: str = 'ros2msg') -> int:
        """Return the number of a new channel; its definition opens the next chunk."""
        schema = next((s for s in self._schemas if s.name == type_name), None)
        if schema is None:
            schema = mcap.Schema(id=len(self._schemas) + 1, name=type_name, encoding=encoding,
                                 data=schema_text.encode())
            self._schemas.append(schema)
            self._add(_built(schema))
        channel = mcap.Channel(id=len(self._channels) + 1, topic=topic, message_encoding='cdr',
                          metadata=dict(metadata), schema_id=schema.id)
        self._channels.append(channel)
        self._add(_built(channel))
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

    def add_records(self, records: list[bytes], channel: np.ndarray,
                    log_time_ns: np.ndarray) -> None:
        """
        Take whole message records.

        Parameters
        ----------
        records : list of bytes
            n records, in the order in which they shall be in the file.
        channel, log_time_ns : ndarray of int64, shape (n,)
            Of each record.

        """
        ends = np.cumsum(np.fromiter(map(len, records), np.int64, len(records)))
        starts = np.concatenate(([0], ends[:-1]))
        lo = 0
        while lo < len(records):
            room = self._chunk_bytes - self._size
            hi = int(np.searchsorted(ends, starts[lo] + max(room, 0))) + 1
            hi = min(max(hi, lo + 1), len(records))
            log = log_time_ns[lo:hi]
            entries = np.stack((log, starts[lo:hi] - starts[lo] + self._size), axis=1)
            for number in np.unique(channel[lo:hi]).tolist():
                mine = entries[channel[lo:hi] == number].astype('<i8').tobytes()
                self._index.setdefault(number, bytearray()).extend(mine)
            self._first = min(self._first, int(log.min()))
            self._last = max(self._last, int(log.max()))
            self._add(b''.join(records[lo:hi]))
            if self._size >= self._chunk_bytes:
                self.end_chunk()
            lo = hi

    def take_pending(self) -> list[tuple[int, bytes, int, int, int]]:
        """Take the messages out of memory, each as `add` takes it; definitions stay."""
        data = b''.join(self._pieces)
        messages, _ = walk(data, 0, len(data))
        taken = []
        for at in messages:
            _, length, channel, sequence, log, publish = MESSAGE_HEAD.unpack_from(data, at)
            payload = data[at + MESSAGE_HEAD.size:at + HEAD.size + length]
            taken.append((channel, payload, log, publish, sequence))
        self._begin_chunk()
        self._redefine()
        return taken

    # The file

    @property
    def size(self) -> int:
        """Bytes written."""
        return self._end

    def _append(self, data: bytes) -> None:
        """Write all of it, or none and raise OSError."""
        rest = memoryview(data)
        try:
            while rest:
                rest = rest[self._file.write(rest):]
        except OSError:
            with suppress(OSError):
                self._file.truncate(self._end)
            self._file.seek(self._end)
            raise
        self._end += len(data)

    def end_chunk(self) -> None:
        """Write the messages in memory as a chunk; OSError leaves them there."""
        if not self._index:
            return
        data = b''.join(self._pieces)
        packed = self._compress(data)
        chunk = _built(mcap.Chunk(compression=self._compression, data=packed,
                             message_start_time=self._first, message_end_time=self._last,
                             uncompressed_crc=zlib.crc32(data), uncompressed_size=len(data)))
        indexes, offsets = [], {}
        behind = self._end + len(chunk)
        for channel, entries in self._index.items():
            offsets[channel] = behind
            indexes.append(HEAD.pack(Opcode.MESSAGE_INDEX, 6 + len(entries))
                           + channel.to_bytes(2, 'little') + len(entries).to_bytes(4, 'little')
                           + entries)
            behind += len(indexes[-1])
        index = mcap.ChunkIndex(chunk_length=len(chunk), chunk_start_offset=self._end,
                           compression=self._compression, compressed_size=len(packed),
                           message_end_time=self._last, message_index_length=behind - self._end
                           - len(chunk), message_index_offsets=offsets,
                           message_start_time=self._first, uncompressed_size=len(data))
        self._append(b''.join((chunk, *indexes)))
        self._chunk_indexes.append(index)
        for channel, entries in self._index.items():
            self.counts[channel] = self.counts.get(channel, 0) + len(entries) // 16
        self.start_ns = min(self._first, self._first if self.start_ns is None else self.start_ns)
        self.end_ns = max(self._last, self._last if self.end_ns is None else self.end_ns)
        self._begin_chunk()

    def add_metadata(self, name: str, mapping: Mapping[str, str]) -> None:
        """Write a metadata record."""
        record = _built(mcap.Metadata(name=name, metadata=dict(mapping)))
        index = mcap.MetadataIndex(offset=self._end, length=len(record), name=name)
        self._append(record)
        self._extra_indexes.append(index)

    def add_attachment(self, name: str, media_type: str, data: bytes, time_ns: int) -> None:
        """Write an attachment."""
        record = _built(mcap.Attachment(create_time=time_ns, log_time=time_ns, name=name,
                                   media_type=media_type, data=data))
        index = mcap.AttachmentIndex(offset=self._end, length=len(record), create_time=time_ns,
                                log_time=time_ns, data_size=len(data), name=name,
                                media_type=media_type)
        self._append(record)
        self._extra_indexes.append(index)

    def sync(self) -> None:
        """Return when what was written is on the disk."""
        os.fsync(self._file.fileno())

    def finish(self) -> None:
        """Write the summary and the end of the file."""
        self.end_chunk()
        attachments = [x for x in self._extra_indexes if isinstance(x, mcap.AttachmentIndex)]
        metadata = [x for x in self._extra_indexes if isinstance(x, mcap.MetadataIndex)]
        statistics = mcap.Statistics(
            attachment_count=len(attachments), channel_count=len(self._channels),
            channel_message_counts=self.counts, chunk_count=len(self._chunk_indexes),
            message_count=sum(self.counts.values()), message_end_time=self.end_ns or 0,
            message_start_time=self.start_ns or 0, metadata_count=len(metadata),
            schema_count=len(self._schemas))
        end = _built(mcap.DataEnd(0))
        start = self._end + len(end)
        groups = {Opcode.SCHEMA: self._schemas, Opcode.CHANNEL: self._channels,
                  Opcode.STATISTICS: [statistics], Opcode.CHUNK_INDEX: self._chunk_indexes,
                  Opcode.ATTACHMENT_INDEX: attachments, Opcode.METADATA_INDEX: metadata}
        summary, offsets = bytearray(), bytearray()
        for opcode, records in groups.items():
            if records:
                group = b''.join(map(_built, records))
                offsets += _built(mcap.SummaryOffset(group_opcode=opcode, group_length=len(group),
                                                group_start=start + len(summary)))
                summary += group
        offset_start = start + len(summary)
        summary += offsets
        footer = _built(mcap.Footer(start, offset_start, 0))
        crc = zlib.crc32(summary + footer[:-4])
        self._append(end + summary + footer[:-4] + crc.to_bytes(4, 'little') + MAGIC)
