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

"""The check of the indexes of a file: whether each says of its chunk what is so."""

from __future__ import annotations

from io import BufferedIOBase
from typing import Callable, Iterator

from mcap import records as mcap
from mcap.opcode import Opcode

from heading_intercompare.bags.mcap.chunk_runs import Chunk, ChunkRuns
from heading_intercompare.bags.mcap.fragments import find_chunk_head, HEAD_BYTES
from heading_intercompare.bags.mcap.mcap_file import Part
from heading_intercompare.bags.mcap.message_blocks import HEAD, INDEX_HEAD
from heading_intercompare.bags.mcap.record_stream import parse_record, RecordStream

__all__ = ['find_index_faults']

_MOST_FAULTS = 5

#: Given an offset and a size, returns that many bytes of a file, fewer at its end.
_Read = Callable[[int, int], bytes]


def find_index_faults(file: BufferedIOBase, part: Part) -> Iterator[str]:
    """
    Yield what is wrong with the indexes of a file, at most a few faults.

    For each chunk, its head, its entry in the index of the file and its message indexes are
    compared with the chunk: offset, length, log times, sizes, and each message.

    Parameters
    ----------
    file : binary file
        The file, open for reading.
    part : Part
        The same file.

    Raises
    ------
    OSError, BagError
        If the file cannot be read.

    """
    stream = RecordStream(file)
    faults = _compare(file, stream, part, _read_chunk_indexes(stream, part))
    for number, fault in enumerate(faults, 1):
        if number > _MOST_FAULTS:
            yield f'{part.path.name}: there are more such faults'
            return
        yield f'{part.path.name}: {fault}'


def _compare(file: BufferedIOBase, stream: RecordStream, part: Part,
             indexed: dict[int, mcap.ChunkIndex]) -> Iterator[str]:
    def read(at: int, size: int) -> bytes:
        file.seek(at)
        return file.read(size)
    runs = ChunkRuns(read, part.end)
    whole = bool(indexed)
    at = part.stretches()[0].begin
    while at < part.end:
        record = stream.record(at, part.end)
        at = record.start + record.length
        run = None
        if record.opcode == Opcode.CHUNK:
            run = runs.run(record.start - HEAD.size, part.end)
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
