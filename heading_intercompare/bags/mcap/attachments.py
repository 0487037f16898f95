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

"""The metadata and attachments of an MCAP file: where they are, and whether they are intact."""

from __future__ import annotations

import struct
from typing import Sequence
import zlib

from mcap import records as mcap
from mcap.opcode import Opcode

from heading_intercompare.bags.errors import BagError

from .record_stream import RecordStream

#: Log time and time of creation; length of a text, and of the data.
_TIMES, _COUNT, _SIZE = struct.Struct('<QQ'), struct.Struct('<I'), struct.Struct('<Q')


def parse_attachment(content: bytes) -> mcap.Attachment:
    """Return an attachment from the bytes after its head; BagError if it is damaged."""
    attachment, end = _read_fields(content)
    crc, = _COUNT.unpack_from(content, end)
    # The checksum covers all fields; pybag 0.13 computes it over the data only.
    if crc not in (0, zlib.crc32(memoryview(content)[:end])) and (
            crc != zlib.crc32(attachment.data)):
        raise BagError('attachment damaged: its checksum does not match')
    return attachment


def read_attachment(content: bytes) -> mcap.Attachment:
    """Return an attachment unchecked; what is no UTF-8 in its names is replaced."""
    return _read_fields(content)[0]


def _read_fields(content: bytes) -> tuple[mcap.Attachment, int]:
    """Return an attachment and where its checksum is; later versions may have more after it."""
    try:
        log_time, create_time = _TIMES.unpack_from(content)
        texts, at = [], _TIMES.size
        for _ in ('name', 'media type'):
            begin = at + _COUNT.size
            at = begin + _COUNT.unpack_from(content, at)[0]
            texts.append(content[begin:at].decode(errors='replace'))
        begin = at + _SIZE.size
        end = begin + _SIZE.unpack_from(content, at)[0]
    except struct.error:
        end = -1
    if not 0 <= end <= len(content) - _COUNT.size:
        raise BagError('a record of type Attachment is damaged')
    return mcap.Attachment(create_time=create_time, log_time=log_time, name=texts[0],
                           media_type=texts[1], data=content[begin:end]), end


def find_records(stream: RecordStream, opcode: int, indexed: Sequence[int], begin: int,
                 end: int) -> list[int]:
    """
    Return the offsets of the records of a kind, in file order.

    Parameters
    ----------
    stream
        The file.
    opcode
        The kind.
    indexed
        Their offsets in the index. If any is wrong, the file is searched.
    begin, end
        Bytes of the file between which to search.

    Raises
    ------
    BagError
        If a search finds fewer records than the index lists, or a damaged record.

    """
    try:
        if all(stream.record(at, end).opcode == opcode for at in indexed):
            return sorted(indexed)
    except BagError:
        pass
    offsets, at = [], begin
    while at < end:
        record = stream.record(at, end)
        if record.opcode == opcode:
            offsets.append(at)
        at = record.start + record.length
    if len(offsets) < len(indexed):
        kind = Opcode(opcode).name.title()
        raise BagError(f'damaged: {len(offsets)} records of type {kind} where its index says '
                       f'{len(indexed)}')
    return offsets
