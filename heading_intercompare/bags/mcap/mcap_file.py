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
One MCAP file: its contents, and its messages block by block.

A closed file lists its contents at its end. A file that was never closed is read once up to the
point where it breaks off, and then treated as if it ended there.
"""

from __future__ import annotations

from contextlib import contextmanager, suppress
from functools import partial
from io import BufferedReader, FileIO
import math
import os
from pathlib import Path
from typing import Callable, Iterator, NamedTuple, TypeVar
import zlib

from mcap import records as mcap
from mcap.opcode import Opcode
import numpy as np

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.packed_files import PACKED, plain_name, PlainFile
from heading_intercompare.natural_order import natural_key

from .attachments import find_records, parse_attachment
from .index_records import read_chunk_index
from .message_blocks import Block, HEAD, LAST_NS, Record, walk
from .record_stream import MAGIC, meaning_of, parse_record, RecordStream

_FOOTER = HEAD.size + 20
_DATA_END = HEAD.pack(Opcode.DATA_END, 4)
#: Records that cannot come after the end of the data.
_DATA = (Opcode.HEADER, Opcode.MESSAGE, Opcode.CHUNK, Opcode.MESSAGE_INDEX, Opcode.ATTACHMENT,
         Opcode.METADATA, Opcode.DATA_END)
_DEFINITIONS = (Opcode.SCHEMA, Opcode.CHANNEL)
_BUFFER_BYTES = 131072
#: Bytes of the place of a message index: a channel and an offset.
_PLACE = 10
#: Bytes of a block, and blocks of a stretch, at least; the last of a file may be smaller.
_BLOCK_BYTES = 3145728
_STRETCH_BLOCKS = 4

#: Messages by channel, first and last log time, and the number of blocks.
_Counted = tuple[dict[int, int], int | None, int | None, int]
_Extra = TypeVar('_Extra', mcap.Metadata, mcap.Attachment)


class Stretch(NamedTuple):
    """Whole records between two bytes of a file, and their size when decompressed."""

    begin: int
    end: int
    size: int


class ChunkRow(NamedTuple):
    """
    What the index of a file says about a chunk, or a scan about a block.

    `size` is that of its records when decompressed. The log times are those of its first and last
    message, in nanoseconds. `channels` has the low and the high bytes of the numbers of its
    channels; empty if unknown.
    """

    begin: int
    size: int
    first_ns: int
    last_ns: int
    channels: tuple[bytes, bytes]


def mcap_files(path: Path) -> list[Path]:
    """
    Return the MCAP files of a bag in natural order of their names; some may be compressed whole.

    Parameters
    ----------
    path
        A rosbag2 directory; or a file of any name, which is then the only one.

    Raises
    ------
    BagError
        If a directory holds no MCAP file.

    """
    if not path.is_dir():
        return [path]
    plain = set(filter(Path.is_file, path.glob('*.mcap')))
    # Where the compression was interrupted, both files are there.
    packed = {file for file in path.glob(f'*.mcap{PACKED}')
              if file.is_file() and file.with_name(plain_name(file.name)) not in plain}
    paths = sorted(plain | packed, key=natural_key)
    if not paths:
        raise BagError('holds no .mcap file (`ros2 bag convert` converts other storage formats)',
                       path)
    return paths


class NeverBegun(BagError):
    """The file is empty, not MCAP, or was never written."""


def _read_row(content: bytes) -> ChunkRow:
    """Return the row of a chunk from the record in the index; BagError if it is cut."""
    begin, head, places = read_chunk_index(content)
    return ChunkRow(begin, head.size, head.first_ns, head.last_ns,
                    (places[::_PLACE], places[1::_PLACE]))


def _definitions_in(block: Block) -> Iterator[tuple[int, bytes]]:
    """Yield opcode and content of the schemas and channels among the records of a block."""
    for opcode, start, length in block.others:
        if opcode in _DEFINITIONS:
            yield opcode, bytes(block.data[start:start + length])


class Part:
    """
    One MCAP file, open only while it is read.

    Parameters
    ----------
    path
        The file; one that rosbag2 compressed whole is unpacked.

    Attributes
    ----------
    channels, schemas : dict
        MCAP records by id.
    counts : dict
        Number of messages by channel id.
    start_ns, end_ns : int or None
        Smallest and largest log time, None without messages.
    profile : str
        Profile in the header, 'ros2' in a rosbag2.
    end : int
        The byte after the last record that is read.
    incomplete
        Why part of the recording is missing; None if the file was closed properly.
    missing
        Messages that its index counts and that are not in it.

    Raises
    ------
    OSError
        If the file cannot be read.
    NeverBegun
        If it is empty or not MCAP.
    BagError
        If a closed file has no usable index and is damaged.

    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._file = PlainFile(Path(path))
        self.path = self._file.path
        cut = self._file.problem
        self.missing = 0
        self.incomplete = cut and f'{self._file.source.name} {cut}'
        self._forget()
        with BufferedReader(FileIO(self._file.place), _BUFFER_BYTES) as file:
            magic = file.read(len(MAGIC))
            if magic != MAGIC:
                problem = (cut or 'is empty (0 bytes)' if not magic else
                           'is not an MCAP file' if any(magic) else
                           'starts with zero bytes; it was never written')
                raise NeverBegun(problem, self._file.source if cut else self.path)
            stream = RecordStream(file)
            if not self._read_summary(stream):
                self._forget()
                self._scan(stream)

    def _forget(self) -> None:
        self.channels: dict[int, mcap.Channel] = {}
        self.schemas: dict[int, mcap.Schema] = {}
        #: Opcodes and contents of the definitions taken or compared.
        self._seen: set[tuple[int, bytes]] = set()
        self.counts: dict[int, int] = {}
        self.start_ns: int | None = None
        self.end_ns: int | None = None
        self.profile = ''
        #: The records lie between the first two; the dict has the offsets of the extras.
        self._begin = self.end = len(MAGIC)
        self._extras: dict[int, list[int]] = {Opcode.METADATA: [], Opcode.ATTACHMENT: []}
        self._chunks: list[ChunkRow] = []
        self._indexed = False
        self._heads: dict[int, tuple[int, int, int]] | None = None

    def _read_summary(self, stream: RecordStream) -> bool:
        """Read the contents from the end of the file; False if that is incomplete."""
        at = stream.size - len(MAGIC) - _FOOTER
        tail = stream.content(Record(0, max(at, 0), len(MAGIC) + _FOOTER))
        if at < len(MAGIC) or tail[:HEAD.size] != HEAD.pack(Opcode.FOOTER, 20) or (
                tail[_FOOTER:] != MAGIC):
            return False
        footer = parse_record(mcap.Footer, tail[HEAD.size:])
        length = at - footer.summary_start
        ahead = Record(0, max(footer.summary_start - len(_DATA_END) - 4, 0), len(_DATA_END))
        if length <= 0 or stream.content(ahead) != _DATA_END:
            return False
        try:
            summary = stream.content(Record(0, footer.summary_start, length))
            if footer.summary_crc not in (0, zlib.crc32(summary + tail[:_FOOTER - 4])):
                return False
            self._take_header(stream)
            complete = self._take_summary(summary)
        except BagError:
            return False
        self.end, self._indexed = footer.summary_start, True
        return complete

    def _take_summary(self, summary: bytes) -> bool:
        """Take the contents from the summary section; False if something is missing."""
        statistics = None
        for record in walk(summary, 0, len(summary), math.inf)[1]:
            content = summary[record.start:record.start + record.length]
            if record.opcode == Opcode.STATISTICS:
                statistics = parse_record(mcap.Statistics, content)
            elif record.opcode == Opcode.METADATA_INDEX:
                at = parse_record(mcap.MetadataIndex, content).offset
                self._extras[Opcode.METADATA].append(at)
            elif record.opcode == Opcode.ATTACHMENT_INDEX:
                at = parse_record(mcap.AttachmentIndex, content).offset
                self._extras[Opcode.ATTACHMENT].append(at)
            elif record.opcode == Opcode.CHUNK_INDEX:
                self._chunks.append(_read_row(content))
            else:
                self._take_definition(record.opcode, content)
        if statistics is None or max(statistics.message_start_time,
                                     statistics.message_end_time) > LAST_NS:
            return False
        self.counts = dict(statistics.channel_message_counts)
        if statistics.message_count:
            self.start_ns = statistics.message_start_time
            self.end_ns = statistics.message_end_time
        needed = {c.schema_id for c in self.channels.values()} - {0}
        return (self.counts.keys() <= self.channels.keys() and needed <= self.schemas.keys()
                and statistics.channel_count <= len(self.channels)
                and sum(self.counts.values()) == statistics.message_count
                and len(self._extras[Opcode.METADATA]) == statistics.metadata_count
                and len(self._extras[Opcode.ATTACHMENT]) == statistics.attachment_count)

    def _take_definition(self, opcode: int, content: bytes) -> None:
        """Take a schema or a channel; BagError if it contradicts an earlier one."""
        if problem := self._define(opcode, content):
            # Nobody knows which of its messages belong to which definition.
            raise BagError(problem)

    def _define(self, opcode: int, content: bytes) -> str | None:
        """Take a definition unless an index lacks it; return how it contradicts an earlier one."""
        if opcode not in _DEFINITIONS or (opcode, content) in self._seen:
            return None
        self._seen.add((opcode, content))
        definition: mcap.Schema | mcap.Channel
        first_definition: mcap.Schema | mcap.Channel | None
        if opcode == Opcode.SCHEMA:
            definition = parse_record(mcap.Schema, content, any_text=True)
            first_definition = self.schemas.get(definition.id)
            if first_definition is None and not self._indexed:
                self.schemas[definition.id] = definition
        else:
            definition = parse_record(mcap.Channel, content, any_text=True)
            first_definition = self.channels.get(definition.id)
            if first_definition is None and not self._indexed:
                self.channels[definition.id] = definition
        if first_definition is None or meaning_of(first_definition) == meaning_of(definition):
            return None
        kind = f'{Opcode(opcode).name.lower()} {definition.id}'
        names = meaning_of(first_definition)[0], meaning_of(definition)[0]
        return (f'{kind} is both {names[0]} and {names[1]}' if names[0] != names[1] else
                f'{kind} ({names[0]}) is defined in two ways')

    def _compare_definitions(self, block: Block) -> None:
        """Raise BagError if a definition in the data contradicts that in the index."""
        for opcode, content in _definitions_in(block) if self._indexed else ():
            problem = None
            with suppress(BagError):
                problem = self._define(opcode, content)
            if problem:
                raise BagError(f'{problem}: the index of the file contradicts the data; '
                               '`recover` writes a new index', offset=block.offset)

    def _take_header(self, stream: RecordStream) -> None:
        """Read the first record."""
        record = stream.record(len(MAGIC))
        if record.opcode != Opcode.HEADER:
            raise BagError('it has no header', offset=len(MAGIC))
        self.profile = parse_record(mcap.Header, stream.content(record)).profile
        self._begin = self.end = record.start + record.length

    def _scan(self, stream: RecordStream) -> None:
        """Read the whole file; note its contents, and where it breaks off."""
        finished = False
        begun: _Counted | None = None
        problem: str | None
        closed = stream.content(Record(0, stream.size - len(MAGIC), len(MAGIC))) == MAGIC
        try:
            self._take_header(stream)
            for piece, end in stream.pieces(self._begin, stream.size, 0):
                if isinstance(piece, Block):
                    # Of a large chunk, which ends with its last block, all counts or nothing.
                    begun = (begun or self._counted()) if end == piece.offset else None
                    self._take_block(piece)
                elif piece.opcode in self._extras:
                    self._extras[piece.opcode].append(piece.start - HEAD.size)
                self.end = end
                finished = isinstance(piece, Record) and piece.opcode == Opcode.DATA_END
            problem, at = 'it has no end', self.end
        except BagError as error:
            if closed and stream.size > len(MAGIC):
                raise error.locate(self.path, error.offset) from None
            problem, at = error.problem, self.end if error.offset is None else error.offset
            if begun is not None:
                self.counts, self.start_ns, self.end_ns, chunks = begun
                del self._chunks[chunks:]
        if finished:
            problem = self._ending_problem(stream, closed)
        else:
            problem = (f'was not closed: {problem} at byte {at} of {stream.size}; the data '
                       'before that is read')
        self.incomplete = '; '.join(filter(None, (
            self.incomplete, problem and f'{self.path.name} {problem}'))) or None

    def _counted(self) -> _Counted:
        return dict(self.counts), self.start_ns, self.end_ns, len(self._chunks)

    def _ending_problem(self, stream: RecordStream, closed: bool) -> str | None:
        """Return what is wrong after the end of the data; None if nothing is missing."""
        at, opcode, expected = self.end, 0, None
        goes_on = 'continues after its end, at byte {} of {}; the rest is not read'
        problem = None if closed else ('was not closed: its index is cut; all its messages are '
                                       'there')
        try:
            while opcode != Opcode.FOOTER:
                opcode, start, length = record = stream.record(at)
                if opcode in _DATA:
                    return goes_on.format(at, stream.size)
                if opcode == Opcode.STATISTICS:
                    expected = parse_record(mcap.Statistics, stream.content(record)).message_count
                at = start + length
            if at + len(MAGIC) < stream.size:
                problem = goes_on.format(at + len(MAGIC), stream.size)
        except BagError:
            problem = problem or (f'has an index that is damaged at byte {at}; its messages are '
                                  'there')
        n_messages = sum(self.counts.values())
        if expected is not None and expected != n_messages:
            self.missing = max(expected - n_messages, 0)
            problem = f'has {n_messages} messages where its index says {expected}'
        return problem

    def _take_block(self, block: Block) -> None:
        for opcode, content in _definitions_in(block):
            self._take_definition(opcode, content)
        if not len(block.start):
            return
        present, counts = np.unique(block.heads['channel'], return_counts=True)
        for channel, count in zip(present.tolist(), counts.tolist()):
            self.counts[channel] = self.counts.get(channel, 0) + count
        log = block.heads['log_time']
        first, last = int(log.min()), int(log.max())
        self._chunks.append(ChunkRow(
            block.offset, len(block.data), first, last,
            ((present & 255).astype(np.uint8).tobytes(), (present >> 8).astype('u1').tobytes())))
        self.start_ns = first if self.start_ns is None else min(self.start_ns, first)
        self.end_ns = last if self.end_ns is None else max(self.end_ns, last)

    def chunk_rows(self) -> list[ChunkRow]:
        """Return what is known of the chunks without reading them, in file order."""
        return sorted(self._chunks)

    def stretches(self) -> list[Stretch]:
        """
        Divide the messages of the file into stretches that can be read on their own.

        A stretch has a few blocks, or more where the index names no place to divide. If the index
        of the file is wrong, a stretch may begin or end within a record.
        """
        cuts, size = [(self._begin, 0)], 0
        for row in self.chunk_rows():
            if size >= _STRETCH_BLOCKS * _BLOCK_BYTES and cuts[-1][0] < row.begin < self.end:
                cuts.append((row.begin, size))
                size = 0
            size += row.size
        if not self._chunks:
            size = self.end - self._begin
        ends = [begin for begin, _ in cuts[1:]] + [self.end]
        sizes = [size for _, size in cuts[1:]] + [size]
        return [Stretch(begin, end, size) for (begin, _), end, size in zip(cuts, ends, sizes)]

    def blocks(self, start_ns: int = 0, stop_ns: int = 2**64) -> Iterator[Block]:
        """
        Yield the messages in file order, skipping chunks that lie outside [start, stop).

        A block is valid until the next one is requested.

        Raises
        ------
        BagError
            If a closed file is damaged, with the byte of the damage.

        """
        count = 0
        with self.open() as stream:
            for block in self.blocks_of(stream, self._begin, None, start_ns, stop_ns):
                count += len(block.start)
                yield block
        if start_ns <= 0 and stop_ns >= 2**64:
            self.check_count(count)

    @contextmanager
    def open(self) -> Iterator[RecordStream]:
        """Open the file for the time of a `with` block."""
        with BufferedReader(FileIO(self._file.place), _BUFFER_BYTES) as file:
            yield RecordStream(file)

    def blocks_of(self, stream: RecordStream, begin: int, end: int | None = None,
                  start_ns: int = 0, stop_ns: int = 2**64) -> Iterator[Block]:
        """
        Yield the messages of the open file between two bytes or up to the end, in file order.

        A block is valid until the next one is requested. Raises BagError as `blocks` does.
        """
        try:
            end = self.end if end is None else end
            for piece, _ in stream.pieces(begin, end, _BLOCK_BYTES, start_ns, stop_ns,
                                          self._find_heads()):
                if isinstance(piece, Block):
                    self._compare_definitions(piece)
                    yield piece
        except BagError as error:
            raise error.locate(self.path, error.offset) from None

    def _find_heads(self) -> dict[int, tuple[int, int, int]]:
        """Return what the index says of each chunk, by offset: its log times and its size."""
        if self._heads is None:
            rows = self._chunks if self._indexed else []
            self._heads = {row.begin: (row.first_ns, row.last_ns, row.size) for row in rows}
        return self._heads

    def check_count(self, count: int) -> None:
        """Raise BagError unless the message count matches the index of the file."""
        expected = sum(self.counts.values())
        if count != expected:
            raise BagError(f'damaged: {count} messages where its index says {expected}',
                           self.path)

    def metadata(self) -> Iterator[mcap.Metadata]:
        """Yield the metadata records in file order; BagError if one is damaged."""
        yield from self._read_extras(Opcode.METADATA, partial(parse_record, mcap.Metadata,
                                                                 any_text=True))

    def attachments(self) -> Iterator[mcap.Attachment]:
        """Yield the attachments in file order; BagError if one is damaged."""
        yield from self._read_extras(Opcode.ATTACHMENT, parse_attachment)

    def _read_extras(self, opcode: int, read: Callable[[bytes], _Extra]) -> Iterator[_Extra]:
        with self.open() as stream:
            at = None
            try:
                for at in find_records(stream, opcode, self._extras[opcode], self._begin,
                                       self.end):
                    yield read(stream.content(stream.record(at)))
            except BagError as error:
                raise error.locate(self.path, error.offset if at is None else at) from None
