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

"""The MCAP records that say where others are: message indexes, chunk indexes, the summary."""

from __future__ import annotations

import struct
from typing import Iterable, Sequence
import zlib

from mcap import records as mcap
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode

from .message_blocks import ENTRY_BYTES, HEAD, INDEX_HEAD
from .record_stream import MAGIC

__all__ = ['build_ending', 'build_record', 'chunk_index', 'message_index']

_CHUNK_INDEX = struct.Struct('<BQQQQQI')
_OFFSET = struct.Struct('<HQ')
_TAIL = struct.Struct('<QI')
_SIZES = struct.Struct('<QQ')


def build_record(record: mcap.McapRecord) -> bytes:
    """Return the bytes of a record."""
    builder = RecordBuilder()
    record.write(builder)
    content: bytes = builder.end()
    return content


def message_index(channel: int, entries: bytes | bytearray) -> bytes:
    """Return the message index of a channel; each entry is a log time and an offset in a chunk."""
    return INDEX_HEAD.pack(Opcode.MESSAGE_INDEX, 6 + len(entries), channel, len(entries)) + entries


def chunk_index(start: int, end: int, counts: Iterable[tuple[int, int]], first_ns: int,
                last_ns: int, compression: str, packed: int, size: int) -> bytes:
    """
    Return the record that says where a chunk and the message indexes after it are.

    Parameters
    ----------
    start, end : int
        First byte of the chunk, and the byte after its last.
    counts : iterable of pairs of int
        Channel and number of messages of each message index.
    first_ns, last_ns : int
        Smallest and largest log time.
    compression : str
        MCAP's name of the compression.
    packed, size : int
        Length of the records, compressed and decompressed.

    """
    offsets, at = [], end
    for channel, count in counts:
        offsets.append(_OFFSET.pack(channel, at))
        at += INDEX_HEAD.size + ENTRY_BYTES * count
    name = compression.encode()
    places = b''.join(offsets)
    length = (_CHUNK_INDEX.size - HEAD.size + len(places) + _TAIL.size + len(name) + _SIZES.size)
    return b''.join((
        _CHUNK_INDEX.pack(Opcode.CHUNK_INDEX, length, first_ns, last_ns, start, end - start,
                          len(places)),
        places, _TAIL.pack(at - end, len(name)), name, _SIZES.pack(packed, size)))


def build_ending(start: int, schemas: Sequence[mcap.Schema], channels: Sequence[mcap.Channel],
                 chunk_indexes: Sequence[bytes],
                 extra_indexes: Sequence[mcap.AttachmentIndex | mcap.MetadataIndex],
                 counts: dict[int, int], span_ns: tuple[int, int]) -> bytes:
    """
    Return the end of a file: end of the data, summary, footer.

    Parameters
    ----------
    start : int
        The offset in the file at which it begins.
    schemas, channels, chunk_indexes, extra_indexes : sequence
        The contents of the file.
    counts : dict of int to int
        Messages by channel.
    span_ns : tuple of int
        Smallest and largest log time.

    """
    attachments = [x for x in extra_indexes if isinstance(x, mcap.AttachmentIndex)]
    metadata = [x for x in extra_indexes if isinstance(x, mcap.MetadataIndex)]
    statistics = mcap.Statistics(
        attachment_count=len(attachments), channel_count=len(channels),
        channel_message_counts=counts, chunk_count=len(chunk_indexes),
        message_count=sum(counts.values()), message_end_time=span_ns[1],
        message_start_time=span_ns[0], metadata_count=len(metadata), schema_count=len(schemas))
    end = build_record(mcap.DataEnd(0))
    start += len(end)
    groups = {Opcode.SCHEMA: map(build_record, schemas),
              Opcode.CHANNEL: map(build_record, channels),
              Opcode.STATISTICS: [build_record(statistics)], Opcode.CHUNK_INDEX: chunk_indexes,
              Opcode.ATTACHMENT_INDEX: map(build_record, attachments),
              Opcode.METADATA_INDEX: map(build_record, metadata)}
    summary, offsets = bytearray(), bytearray()
    for opcode, records in groups.items():
        group = b''.join(records)
        if group:
            offsets += build_record(mcap.SummaryOffset(group_opcode=opcode,
                                                       group_length=len(group),
                                                       group_start=start + len(summary)))
            summary += group
    offset_start = start + len(summary)
    summary += offsets
    footer = build_record(mcap.Footer(start, offset_start, 0))
    crc = zlib.crc32(summary + footer[:-4])
    return b''.join((end, summary, footer[:-4], crc.to_bytes(4, 'little'), MAGIC))
