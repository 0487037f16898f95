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

"""The check of a whole bag: verify checksums, count messages, find gaps in their numbers."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import chain
import os
from pathlib import Path
from typing import Callable, Iterator

from mcap import records as mcap
from mcap.opcode import Opcode
import numpy as np

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.checksum import crc32
from heading_intercompare.bags.mcap.chunk_chain import ChunkChain, hash_record
from heading_intercompare.bags.mcap.chunk_runs import Chunk, ChunkRuns
from heading_intercompare.bags.mcap.chunks import CHUNK_HEAD
from heading_intercompare.bags.mcap.fragments import find_chunk_head, HEAD_BYTES
from heading_intercompare.bags.mcap.mcap_file import Part
from heading_intercompare.bags.mcap.message_blocks import Block, HEAD, INDEX_HEAD, Record
from heading_intercompare.bags.mcap.record_stream import MAGIC, parse_record, RecordStream
from heading_intercompare.core.records import Integers

from .bag_files import find_files
from .sequence_gaps import Numbering

_MOST_FAULTS = 5

#: Given an offset and a size, returns that many bytes of a file, fewer at its end.
_Read = Callable[[int, int], bytes]


def find_index_faults(stream: RecordStream, part: Part) -> Iterator[str]:
    """
    Yield what is wrong with the indexes of a file, at most a few faults.

    For each chunk, its head, its entry in the index of the file and its message indexes are
    compared with the chunk: offset, length, log times, sizes, and each message.

    Parameters
    ----------
    stream
        The records of the file.
    part
        The same file.

    Raises
    ------
    OSError, BagError
        If the file cannot be read.

    """
    faults = _compare(stream, part, _read_chunk_indexes(stream, part))
    for number, fault in enumerate(faults, 1):
        if number > _MOST_FAULTS:
            yield f'{part.path.name}: there are more such faults'
            return
        yield f'{part.path.name}: {fault}'


def _compare(stream: RecordStream, part: Part,
             indexed: dict[int, mcap.ChunkIndex]) -> Iterator[str]:
    def read(at: int, size: int) -> bytes:
        return stream.content(Record(0, at, size))
    runs = ChunkRuns(read, part.end, extended=True)
    whole = bool(indexed)
    at = part.stretches()[0].begin
    while at < part.end:
        record = stream.record(at, part.end)
        at = record.start + record.length
        run = None
        if record.opcode == Opcode.CHUNK:
            run = runs.run(record.start - HEAD.size, part.end)
            if run is None:
                # It is large, and reading it compared it with its entry.
                indexed.pop(record.start - HEAD.size, None)
        for chunk in run.chunks if run is not None else ():
            entry = indexed.pop(chunk.start, None)
            yield from _compare_chunk(chunk, read, entry)
            if whole and entry is None:
                yield f'the index does not name the chunk at byte {chunk.start}'
            at = chunk.index_end
    yield from (f'the index names a chunk at byte {place}, where none is' for place in indexed)


def _read_chunk_indexes(stream: RecordStream, part: Part) -> dict[int, mcap.ChunkIndex]:
    """Return the entries of the index of a closed file, by offset."""
    entries: dict[int, mcap.ChunkIndex] = {}
    at = part.end
    while part.incomplete is None and at < stream.size:
        opcode, start, length = record = stream.record(at)
        if opcode == Opcode.CHUNK_INDEX:
            entry = parse_record(mcap.ChunkIndex, stream.content(record))
            entries[entry.chunk_start_offset] = entry
        if opcode == Opcode.FOOTER:
            break
        at = start + length
    return entries


def _compare_chunk(chunk: Chunk, read: _Read,
                   entry: mcap.ChunkIndex | None) -> Iterator[str]:
    """Yield what is wrong with what is said about an intact chunk."""
    head = find_chunk_head(read(chunk.start, HEAD_BYTES))
    place = f'the chunk at byte {chunk.start}'
    times = chunk.first_ns, chunk.last_ns
    empty = not chunk.counts
    if head is not None and not empty and (head.first_ns, head.last_ns) != times:
        yield f'{place} does not have the log times that its head says'
    if chunk.index_end > chunk.end and not chunk.indexed:
        yield f'the message indexes after {place} do not name its messages'
    if entry is None:
        return
    wrong = [what for what, stated, actual in (
        ('length', entry.chunk_length, chunk.end - chunk.start),
        ('log times', (entry.message_start_time, entry.message_end_time),
         (entry.message_start_time, entry.message_end_time) if empty else times),
        ('sizes', (entry.compressed_size, entry.uncompressed_size), (chunk.packed, chunk.size)),
        ('compression', entry.compression, chunk.compression),
        ('places of its message indexes', dict(entry.message_index_offsets),
         _find_message_indexes(chunk, read)),
    ) if stated != actual]
    if wrong:
        yield f'the index has other {" and ".join(wrong)} of {place}'


def _find_message_indexes(chunk: Chunk, read: _Read) -> dict[int, int]:
    """Return where the message index of each channel after a chunk is."""
    offsets, data, at = {}, read(chunk.end, chunk.index_end - chunk.end), 0
    while at + INDEX_HEAD.size <= len(data):
        _, length, number, _ = INDEX_HEAD.unpack_from(data, at)
        offsets[number] = chunk.end + at
        at += HEAD.size + length
    return offsets


_FOOTER = HEAD.size + 20
_READ_BYTES = 1 << 20


@dataclass(slots=True)
class BagCheck:
    """
    What a check of a bag found.

    Attributes
    ----------
    files, messages
        Numbers read.
    unprotected
        Chunks that have no checksum.
    chain
        The chain through the chunks read.
    faults
        What is wrong, at most a few faults per file; the messages of a file are not read any
        further after its first fault.
    topics
        Sequence numbers of the messages, by topic.
    late
        Messages that lie after one of their topic with a later log time, by topic.

    """

    files: int = 0
    chain: ChunkChain = ChunkChain()
    messages: int = 0
    unprotected: int = 0
    faults: list[str] = field(default_factory=list)
    topics: dict[str, Numbering] = field(default_factory=dict)
    late: dict[str, int] = field(default_factory=dict)
    _newest_ns: dict[str, int] = field(default_factory=dict)

    @property
    def chunks(self) -> int:
        """Return the number of chunks read."""
        return self.chain.chunks

    def take_times(self, topic: str, log_time_ns: Integers) -> None:
        """Take the log times of messages of a topic, at least one, as they lie."""
        before = np.maximum.accumulate(np.append(self._newest_ns.get(topic, 0), log_time_ns))
        self._newest_ns[topic] = int(before[-1])
        if late := int((log_time_ns < before[:-1]).sum()):
            self.late[topic] = self.late.get(topic, 0) + late


def check_bag(path: str | os.PathLike[str],
              progress: Callable[[str], None] = lambda text: None) -> BagCheck:
    """
    Read a whole bag and check it.

    Parameters
    ----------
    path
        An MCAP file or a rosbag2 directory.
    progress
        Called with the progress in words.

    Raises
    ------
    OSError
        If a file cannot be read.
    BagError
        If a directory holds no MCAP file.

    """
    check = BagCheck()
    place = Path(path)
    files = find_files(place)
    check.faults += files.missing
    for file in files.paths:
        check.files += 1
        check.faults += _faults(file, check, progress)
    return check


def _faults(file: Path, check: BagCheck, progress: Callable[[str], None]) -> Iterator[str]:
    """Read a file; count what it holds and yield what is wrong with it."""
    try:
        part = Part(file)
    except BagError as error:
        yield f'{file.name}: {_text(error)}'
        return
    if part.incomplete:
        yield part.incomplete
    try:
        for block in part.blocks():
            _take(block, part, check)
            progress(f'{check.messages:,} messages')
        for _ in chain(part.metadata(), part.attachments()):
            pass
        with part.open() as stream:
            yield from _check_rest(stream, part, check)
            yield from find_index_faults(stream, part)
    except BagError as error:
        yield f'{file.name}: {_text(error)}'


def _text(error: BagError) -> str:
    return error.problem + ('' if error.offset is None else f' (at byte {error.offset})')


def _take(block: Block, part: Part, check: BagCheck) -> None:
    channels, numbers = block.heads['channel'].copy(), block.heads['sequence'].astype(np.uint32)
    check.messages += len(channels)
    # In one pass: a bag may have as many channels as messages.
    order = np.argsort(channels, kind='stable')
    present, begins = np.unique(channels[order], return_index=True)
    for number, mine in zip(present.tolist(), np.split(order, begins[1:])):
        if number not in part.channels:
            raise BagError(f'a message belongs to channel {number}, which is not defined',
                           offset=block.offset)
        topic = part.channels[number].topic
        check.topics.setdefault(topic, Numbering()).take(numbers[mine])
        check.take_times(topic, block.heads['log_time'][mine])


def _check_rest(stream: RecordStream, part: Part, check: BagCheck) -> Iterator[str]:
    """Check what reading messages does not: missing checksums, checksums of data and summary."""
    at = len(MAGIC)
    while at < part.end:
        record = stream.record(at, part.end)
        if record.opcode == Opcode.CHUNK:
            head = stream.content(Record(record.opcode, record.start, CHUNK_HEAD.size))
            check.chain = check.chain.after(hash_record(stream, record))
            check.unprotected += not CHUNK_HEAD.unpack(head)[3]
        elif record.opcode == Opcode.DATA_END:
            expected = parse_record(mcap.DataEnd, stream.content(record)).data_section_crc
            if expected and _crc(stream, 0, at) != expected:
                yield f'{part.path.name}: the checksum of all its data does not match'
            break
        at = record.start + record.length
    if part.incomplete is None:
        at = stream.size - len(MAGIC) - _FOOTER
        footer = parse_record(mcap.Footer, stream.content(stream.record(at)))
        if footer.summary_crc and footer.summary_start and footer.summary_crc != _crc(
                stream, footer.summary_start, at + _FOOTER - 4):
            yield (f'{part.path.name}: the checksum of its index does not match; its messages '
                   'are there')


def _crc(stream: RecordStream, start: int, stop: int) -> int:
    """Return the checksum of the bytes [start, stop) of a file."""
    crc = 0
    for at in range(start, stop, _READ_BYTES):
        crc = crc32(stream.content(Record(0, at, min(_READ_BYTES, stop - at))), crc)
    return crc
