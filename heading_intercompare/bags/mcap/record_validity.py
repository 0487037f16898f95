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

"""Whether the lengths and counts within a record agree with each other."""

from __future__ import annotations

from typing import Callable

from mcap import records as mcap
from mcap.opcode import Opcode

from heading_intercompare.bags.errors import BagError
from heading_intercompare.messages.byte_columns import BytesLike

from .message_blocks import INDEX_LEAST, Record
from .record_stream import parse_record

__all__ = ['find_attached', 'is_disguised', 'is_formed', 'SMALL']

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


def is_formed(read: _Read, record: Record) -> bool:
    """Tell whether the lengths and counts of a record agree; its kind is in a table above."""
    opcode, start, length = record
    if opcode in _FIXED:
        return length == _FIXED[opcode]
    if opcode in _FIELD:
        at, begin = _FIELD[opcode]
        return int.from_bytes(read(start + at, 4), 'little') == length - begin
    if length > _SMALL_BYTES:
        return False
    try:
        content = parse_record(SMALL[opcode], read(start, length))
    except BagError:
        return False
    # Without counts per channel nothing could show that statistics are wrong.
    return _written_size(content) == length and (
        not isinstance(content, mcap.Statistics) or not content.channel_message_counts
        or sum(content.channel_message_counts.values()) == content.message_count)


def is_disguised(read: _Read, record: Record) -> bool:
    """Tell whether a message is in fact a record of another kind with a wrong opcode."""
    return any(is_formed(read, record._replace(opcode=opcode)) for opcode in _LIKE_MESSAGES)


def find_attached(read: _Read, record: Record) -> int | None:
    """Return where the data of an attachment begins; None if its lengths do not agree."""
    at, end = record.start + 16, record.start + record.length - 4
    for width in (4, 4, 8):
        if at + width > end:
            return None
        begin = at + width
        at = begin + int.from_bytes(read(at, width), 'little')
    return begin if at == end else None


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
