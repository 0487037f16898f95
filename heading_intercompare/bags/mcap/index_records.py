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

"""The MCAP records that say where others are, and whether the counts in a record agree."""

from __future__ import annotations

import struct
from typing import Callable, Iterable, Sequence
import zlib

from mcap import records as mcap
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode

from heading_intercompare.bags.errors import BagError
from heading_intercompare.messages.byte_columns import BytesLike

from .fragments import ChunkHead
from .message_blocks import ENTRY_BYTES, HEAD, INDEX_HEAD, INDEX_LEAST, Record
from .record_stream import MAGIC, parse_record

_Small = mcap.Header | mcap.Schema | mcap.Channel | mcap.Metadata | mcap.Statistics
#: Records of a few fields.
SMALL: dict[int, type[_Small]] = {
    Opcode.HEADER: mcap.Header, Opcode.SCHEMA: mcap.Schema, Opcode.CHANNEL: mcap.Channel,
    Opcode.METADATA: mcap.Metadata, Opcode.STATISTICS: mcap.Statistics}
#: A record of these that claims to be larger is not believed.
_SMALL_BYTES = 2**26
_FIXED: dict[int, int] = {Opcode.DATA_END: 4, Opcode.FOOTER: 20}
#: For records with one field of variable length: where its length is, and where it begins.
_FIELD: dict[int, tuple[int, int]] = {Opcode.MESSAGE_INDEX: (2, INDEX_LEAST),
                                      Opcode.METADATA_INDEX: (16, 20)}
#: Records that one wrong bit turns into a message.
_LIKE_MESSAGES = (Opcode.HEADER, Opcode.CHANNEL, Opcode.MESSAGE_INDEX, Opcode.METADATA_INDEX)

#: Given an offset and a size, returns that many bytes of a file, fewer at its end.
_Read = Callable[[int, int], BytesLike]


def measure_fields(read: _Read, record: Record) -> int | None:
    """
    Return the length of the fields of a record; its kind is in a table above.

    A record may be longer, as records may grow. None if its lengths and counts do not agree.
    """
    opcode, start, length = record
    if opcode in _FIXED:
        size = _FIXED[opcode]
    elif opcode in _FIELD:
        at, begin = _FIELD[opcode]
        size = begin + int.from_bytes(read(start + at, 4), 'little')
    elif length > _SMALL_BYTES:
        return None
    else:
        try:
            content = parse_record(SMALL[opcode], read(start, length))
        except BagError:
            return None
        # Without counts per channel nothing could show that statistics are wrong.
        if isinstance(content, mcap.Statistics) and content.channel_message_counts and (
                sum(content.channel_message_counts.values()) != content.message_count):
            return None
        size = _written_size(content)
    return size if size <= length else None


def is_disguised(read: _Read, record: Record) -> bool:
    """Tell whether a message is in fact a record of another kind with a wrong opcode."""
    return any(measure_fields(read, record._replace(opcode=opcode)) == record.length
               for opcode in _LIKE_MESSAGES)


def find_attached(read: _Read, record: Record) -> tuple[int, int] | None:
    """
    Return where the data of an attachment begins and ends; None if its lengths do not agree.

    The checksum follows the data; the record may be longer, as records may grow.
    """
    at, end = record.start + 16, record.start + record.length - 4
    for width in (4, 4, 8):
        if at + width > end:
            return None
        begin = at + width
        at = begin + int.from_bytes(read(at, width), 'little')
    return (begin, at) if at <= end else None


def _written_size(record: _Small) -> int:
    """Return the length of the content of a small record when it is written."""
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


#: Opcode and length of a record; first and last log time, offset and length of a chunk, and bytes
#: of the places of its message indexes. After these: bytes of its message indexes and letters of
#: the compression; after its name the sizes of its records, compressed and decompressed.
_CHUNK_INDEX = struct.Struct('<BQQQQQI')
_CHUNK_INDEX_FIELDS = struct.Struct('<QQQQI')
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
    start, end
        First byte of the chunk, and the byte after its last.
    counts : iterable of pairs of int
        Channel and number of messages of each message index.
    first_ns, last_ns
        Smallest and largest log time.
    compression
        MCAP's name of the compression.
    packed, size
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


def read_chunk_index(content: bytes) -> tuple[int, ChunkHead, bytes]:
    """
    Return what the index says of a chunk; BagError if the record is cut.

    Returns
    -------
    start : int
        First byte of the chunk.
    head : ChunkHead
        Its head without the checksum, which the index does not know.
    places : bytes
        Where its message indexes are, each a channel (2 bytes) and an offset (8 bytes).

    """
    begin = _CHUNK_INDEX_FIELDS.size
    try:
        first_ns, last_ns, start, length, size_of_places = _CHUNK_INDEX_FIELDS.unpack_from(content)
        at = begin + size_of_places
        _, letters = _TAIL.unpack_from(content, at)
        at += _TAIL.size
        packed, size = _SIZES.unpack_from(content, at + letters)
    except struct.error:
        raise BagError('a record of the index is cut') from None
    head = ChunkHead(length - HEAD.size, first_ns, last_ns, size, 0,
                     content[at:at + letters].decode('latin-1'), packed)
    return start, head, content[begin:begin + size_of_places]


def build_ending(start: int, schemas: Sequence[mcap.Schema], channels: Sequence[mcap.Channel],
                 chunk_indexes: Sequence[bytes], attachment_indexes: Sequence[bytes],
                 metadata_indexes: Sequence[bytes],
                 counts: dict[int, int], span_ns: tuple[int, int]) -> bytes:
    """
    Return the end of a file: end of the data, summary, footer.

    Parameters
    ----------
    start
        The offset in the file at which it begins.
    schemas, channels, chunk_indexes, attachment_indexes, metadata_indexes
        The contents of the file.
    counts
        Messages by channel.
    span_ns
        Smallest and largest log time.

    """
    statistics = mcap.Statistics(
        attachment_count=len(attachment_indexes), channel_count=len(channels),
        channel_message_counts=counts, chunk_count=len(chunk_indexes),
        message_count=sum(counts.values()), message_end_time=span_ns[1],
        message_start_time=span_ns[0], metadata_count=len(metadata_indexes),
        schema_count=len(schemas))
    end = build_record(mcap.DataEnd(0))
    start += len(end)
    groups = {Opcode.SCHEMA: map(build_record, schemas),
              Opcode.CHANNEL: map(build_record, channels),
              Opcode.STATISTICS: [build_record(statistics)], Opcode.CHUNK_INDEX: chunk_indexes,
              Opcode.ATTACHMENT_INDEX: attachment_indexes,
              Opcode.METADATA_INDEX: metadata_indexes}
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
