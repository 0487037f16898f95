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
The files of the conformance tests of MCAP, byte for byte.

The tests are those of github.com/foxglove/mcap (MIT licence), folder tests/conformance. They
combine six inputs with ten features, such as chunks, message indexes, or bytes after the fields
of a record. This module writes the 416 files from the specification of the format; nothing of
them is stored here. Their names are those of the original files.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from hashlib import sha256
from itertools import chain, combinations
import struct
from typing import Iterator, NamedTuple
import zlib

from bags.mcap_bytes import chunk, entries_of, MAGIC, message_index, record
from mcap import records as mcap
from mcap.opcode import Opcode

CHUNKS, CHUNK_INDEX, MESSAGE_INDEX = 'ch', 'chx', 'mx'
SCHEMAS, CHANNELS, STATISTICS = 'rsh', 'rch', 'st'
ATTACHMENT_INDEX, METADATA_INDEX, SUMMARY_OFFSETS, PADDING = 'ax', 'mdx', 'sum', 'pad'
_FEATURES = sorted((CHUNKS, CHUNK_INDEX, MESSAGE_INDEX, SCHEMAS, CHANNELS, STATISTICS,
                    ATTACHMENT_INDEX, METADATA_INDEX, SUMMARY_OFFSETS, PADDING))
_NEEDS = {CHUNK_INDEX: CHUNKS, MESSAGE_INDEX: CHUNKS}
_IN_SUMMARY = {CHUNK_INDEX, SCHEMAS, CHANNELS, METADATA_INDEX, ATTACHMENT_INDEX, STATISTICS}

PADDING_BYTES = b'\x01\xff\xff'


@dataclass(frozen=True, slots=True)
class Contents:
    """What a file of the conformance tests holds, in the order in which it is written."""

    schemas: tuple[mcap.Schema, ...] = ()
    channels: tuple[mcap.Channel, ...] = ()
    messages: tuple[mcap.Message, ...] = ()
    attachments: tuple[mcap.Attachment, ...] = ()
    metadata: tuple[mcap.Metadata, ...] = ()

    def lacks(self, feature: str) -> bool:
        """Tell whether a feature has nothing to act on."""
        of_messages = not (self.schemas or self.channels or self.messages)
        return {CHUNKS: of_messages, SCHEMAS: not self.schemas, CHANNELS: not self.channels,
                ATTACHMENT_INDEX: not self.attachments,
                METADATA_INDEX: not self.metadata}.get(feature, False)


def _message(sequence: int, log_ns: int, publish_ns: int) -> mcap.Message:
    return mcap.Message(channel_id=1, data=b'\1\2\3', log_time=log_ns, publish_time=publish_ns,
                        sequence=sequence)


_SCHEMA = mcap.Schema(id=1, name='Example', encoding='c', data=b'\4\5\6')
_CHANNEL = mcap.Channel(id=1, topic='example', message_encoding='a', metadata={'foo': 'bar'},
                        schema_id=1)
_BARE_CHANNEL = mcap.Channel(id=1, topic='example', message_encoding='text', metadata={},
                             schema_id=0)

CONTENTS = {
    'NoData': Contents(),
    'OneSchemalessMessage': Contents(channels=(_BARE_CHANNEL,), messages=(_message(10, 2, 1),)),
    'OneMessage': Contents((_SCHEMA,), (_CHANNEL,), (_message(10, 2, 1),)),
    'OneAttachment': Contents(attachments=(mcap.Attachment(
        create_time=1, log_time=2, name='myFile', media_type='application/octet-stream',
        data=b'\1\2\3'),)),
    'OneMetadata': Contents(metadata=(mcap.Metadata(name='myMetadata',
                                                    metadata={'foo': 'bar'}),)),
    'TenMessages': Contents((_SCHEMA,), (_CHANNEL,), tuple(
        _message(sequence, time_ns, time_ns)
        for sequence, time_ns in enumerate((0, 2, 1, 3, 3, 5, 4, 7, 8, 9))))}
"""The inputs by name."""


class Case(NamedTuple):
    """A file of the conformance tests: its name, what it holds, its features, its bytes."""

    name: str
    contents: Contents
    features: frozenset[str]
    data: bytes


@lru_cache(maxsize=None)
def cases() -> tuple[Case, ...]:
    """Return the files of all inputs, in the order of their names."""
    return tuple(sorted(chain.from_iterable(map(_variants, CONTENTS))))


def digest(name: str) -> str:
    """Return the SHA-256 of the list of the files of an input: name, SHA-256 and size of each."""
    lines = [f'{case.name}.mcap {sha256(case.data).hexdigest()} {len(case.data)}\n'
             for case in cases() if case.name.partition('-')[0] == name]
    return sha256(''.join(lines).encode()).hexdigest()


def extend(content: bytes) -> bytes:
    """Return a record with bytes after its fields, as later versions of MCAP may write."""
    length, = struct.unpack_from('<Q', content, 1)
    return (content[:1] + struct.pack('<Q', length + len(PADDING_BYTES)) + content[9:]
            + PADDING_BYTES)


def extended_everywhere(name: str) -> bytes:
    """Return a file with all features of an input, its chunk and what is in it extended too."""
    usable = frozenset(feature for feature in _FEATURES
                       if not CONTENTS[name].lacks(_NEEDS.get(feature, feature)))
    return _Writer(CONTENTS[name], usable, with_chunk=True).file()


def _variants(name: str) -> Iterator[Case]:
    contents = CONTENTS[name]
    usable = [feature for feature in _FEATURES
              if not contents.lacks(_NEEDS.get(feature, feature))]
    for number in range(len(usable) + 1):
        for chosen in combinations(usable, number):
            features = frozenset(chosen)
            needed = {_NEEDS[feature] for feature in features if feature in _NEEDS}
            if needed <= features and (SUMMARY_OFFSETS not in features
                                       or features & _IN_SUMMARY):
                yield Case('-'.join((name, *chosen)), contents, features,
                           _Writer(contents, features).file())


class _Writer:
    """Writes one file; it extends its chunk too `with_chunk`, which the originals do not."""

    def __init__(self, contents: Contents, features: frozenset[str], *,
                 with_chunk: bool = False) -> None:
        self._contents, self._features, self._with_chunk = contents, features, with_chunk
        self._data = bytearray(MAGIC)
        self._chunk_indexes: list[mcap.ChunkIndex] = []
        self._attachment_indexes: list[mcap.AttachmentIndex] = []
        self._metadata_indexes: list[mcap.MetadataIndex] = []

    def file(self) -> bytes:
        self._write(mcap.Header(profile='', library=''))
        definitions = *self._contents.schemas, *self._contents.channels, *self._contents.messages
        if CHUNKS in self._features:
            self._write_chunk(b''.join(
                extend(record(item)) if self._with_chunk and not isinstance(item, mcap.Message)
                else record(item) for item in definitions))
        else:
            for definition in definitions:
                self._write(definition)
        self._write_attachments()
        self._data += record(mcap.DataEnd(zlib.crc32(self._data)))
        self._write_summary()
        return bytes(self._data)

    def _write(self, item: mcap.McapRecord) -> int:
        """Write a record, with bytes after its fields if it may have some; return its length."""
        return self._write_bytes(record(item), not isinstance(item, mcap.Message))

    def _write_bytes(self, content: bytes, extensible: bool = True) -> int:
        if extensible and PADDING in self._features:
            content = extend(content)
        self._data += content
        return len(content)

    def _write_chunk(self, records: bytes) -> None:
        begin = len(self._data)
        length = self._write_bytes(chunk(records, compression=''), self._with_chunk)
        end, places = len(self._data), {}
        for number, entries in (entries_of(records).items()
                                if MESSAGE_INDEX in self._features else ()):
            places[number] = len(self._data)
            self._write_bytes(message_index(number, entries))
        if CHUNK_INDEX in self._features:
            first_ns, last_ns = self._span()
            self._chunk_indexes.append(mcap.ChunkIndex(
                chunk_length=length, chunk_start_offset=begin, compression='',
                compressed_size=len(records), message_end_time=last_ns,
                message_index_length=len(self._data) - end, message_index_offsets=places,
                message_start_time=first_ns, uncompressed_size=len(records)))

    def _write_attachments(self) -> None:
        for attachment in self._contents.attachments:
            begin = len(self._data)
            length = self._write(attachment)
            if ATTACHMENT_INDEX in self._features:
                self._attachment_indexes.append(mcap.AttachmentIndex(
                    offset=begin, length=length, create_time=attachment.create_time,
                    log_time=attachment.log_time, data_size=len(attachment.data),
                    name=attachment.name, media_type=attachment.media_type))
        for metadata in self._contents.metadata:
            begin = len(self._data)
            length = self._write(metadata)
            if METADATA_INDEX in self._features:
                self._metadata_indexes.append(mcap.MetadataIndex(
                    offset=begin, length=length, name=metadata.name))

    def _span(self) -> tuple[int, int]:
        times = [message.log_time for message in self._contents.messages]
        return min(times, default=0), max(times, default=0)

    def _statistics(self) -> mcap.Statistics:
        contents, (first_ns, last_ns) = self._contents, self._span()
        counts: dict[int, int] = {}
        for message in contents.messages:
            counts[message.channel_id] = counts.get(message.channel_id, 0) + 1
        return mcap.Statistics(
            attachment_count=len(contents.attachments), channel_count=len(contents.channels),
            channel_message_counts=counts, chunk_count=int(CHUNKS in self._features),
            message_count=len(contents.messages), message_end_time=last_ns,
            message_start_time=first_ns, metadata_count=len(contents.metadata),
            schema_count=len(contents.schemas))

    def _write_summary(self) -> None:
        start = len(self._data)
        offsets = []
        for opcode, feature, items in (
                (Opcode.SCHEMA, SCHEMAS, self._contents.schemas),
                (Opcode.CHANNEL, CHANNELS, self._contents.channels),
                (Opcode.STATISTICS, STATISTICS, (self._statistics(),)),
                (Opcode.METADATA_INDEX, METADATA_INDEX, self._metadata_indexes),
                (Opcode.ATTACHMENT_INDEX, ATTACHMENT_INDEX, self._attachment_indexes),
                (Opcode.CHUNK_INDEX, CHUNK_INDEX, self._chunk_indexes)):
            if feature in self._features and items:
                begin = len(self._data)
                length = sum(map(self._write, items))
                offsets.append(mcap.SummaryOffset(group_opcode=opcode, group_start=begin,
                                                  group_length=length))
        end = len(self._data)
        with_offsets = SUMMARY_OFFSETS in self._features
        for offset in offsets if with_offsets else ():
            self._write(offset)
        footer = record(mcap.Footer(start if end > start else 0, end if with_offsets else 0, 0))
        summary = self._data[start:] + footer[:-4]
        self._data += footer[:-4] + struct.pack('<I', zlib.crc32(summary)) + MAGIC
