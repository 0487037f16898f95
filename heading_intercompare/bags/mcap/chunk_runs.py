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
Intact chunks of a file, several at once, and whether they can be copied unchanged.

A chunk is intact if its checksum is right or missing, and its records fill it. The message
indexes after it are believed if they name each of its messages once, with its log time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Collection, NamedTuple, Sequence

from mcap.opcode import Opcode
import numpy as np
import zstandard

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.packed_files import is_packed
from heading_intercompare.core.records import Integers
from heading_intercompare.messages.byte_columns import BytesLike

from .checksum import crc32
from .chunks import LARGE_BYTES, unpack
from .fragments import ChunkHead, find_chunk_head, HEAD_BYTES
from .message_blocks import (
    are_timed,
    Block,
    block_of,
    ENTRY_BYTES,
    HEAD,
    INDEX_HEAD,
    INDEX_LEAST,
    MESSAGE_HEAD,
)

#: Small chunks are checked together, up to this many bytes of records, or this many chunks.
_RUN_BYTES, _RUN_CHUNKS = 2**20, 256
#: Bytes read at once after a chunk, in search of message indexes.
_INDEX_BYTES = 2**13

#: Channels, each with its number of messages.
Counts = Sequence[tuple[int, int]]


class Chunk(NamedTuple):
    """
    An intact chunk.

    Attributes
    ----------
    start, end, index_end
        Its first byte in the file, the byte after its last, and the byte after its message
        indexes.
    first_ns, last_ns
        Smallest and largest log time of its messages; 0 without messages.
    size, crc
        Length and checksum of its records.
    compression
        MCAP's name of the compression.
    packed
        Length of its compressed records.
    counts
        Its messages with valid log times, in the order of the indexes if these are right.
    definitions
        The schemas and channels in it, as whole records.
    plain
        It holds schemas and channels, then messages with valid times, and nothing else; the same
        definitions may be repeated among the messages. The messages are not compressed one by
        one. Nothing follows the fields of the chunk or of its message indexes.
    indexed
        The message indexes after it are right.
    protected
        It has a checksum.

    """

    start: int
    end: int
    index_end: int
    first_ns: int
    last_ns: int
    size: int
    crc: int
    compression: str
    packed: int
    counts: Counts
    definitions: frozenset[bytes]
    plain: bool
    indexed: bool
    protected: bool


@dataclass(frozen=True, slots=True, eq=False)
class ChunkRun:
    """
    Consecutive chunks of a file.

    Attributes
    ----------
    chunks
        n >= 1 chunks.
    bases : ndarray of int64, shape (n + 1,)
        Where in the block the records of each chunk begin, and where those of the last end.
    edges : ndarray of int64, shape (n + 1,)
        The index in the block of the first message of each chunk, and the number of messages.
    block
        The records of all chunks.
    untimed
        Messages with impossible log times.

    """

    chunks: list[Chunk]
    bases: Integers
    edges: Integers
    block: Block
    untimed: int


class _Part(NamedTuple):
    """A decompressed and checked chunk, with the message indexes after it."""

    start: int
    head: ChunkHead
    index_end: int
    data: BytesLike
    crc: int
    indexes: list[tuple[int, bytes]]

    @property
    def is_extended(self) -> bool:
        """Whether more follows the fields of its record, or of a message index."""
        fields = HEAD.size + self.head.needed + sum(
            INDEX_HEAD.size + len(entries) for _, entries in self.indexes)
        return self.start + fields != self.index_end


def count_messages(channels: np.ndarray) -> Counts:
    """Return the number of messages of each channel."""
    numbers, counts = np.unique(channels, return_counts=True)
    return tuple(zip(numbers.tolist(), counts.tolist()))


class ChunkRuns:
    """
    Finds intact chunks in a file, but no large ones; never raises BagError.

    Parameters
    ----------
    read
        Given an offset and a size, returns that many bytes of the file, fewer at its end.
    size
        Size of the file.
    extended
        More may follow the fields of a message index, as later versions of MCAP may write. Without
        it a wrong length of a damaged file is not taken for that.

    """

    def __init__(self, read: Callable[[int, int], bytes], size: int, *,
                 extended: bool = False) -> None:
        self._read = read
        self._size = size
        self._extended = extended
        self._zstd = zstandard.ZstdDecompressor()
        self._record_sets: dict[tuple[bytes, ...], frozenset[bytes]] = {}

    def run(self, at: int, end: int | None = None) -> ChunkRun | None:
        """Return the intact chunks from byte `at` on, up to byte `end`; None if there is none."""
        parts: list[_Part] = []
        size = 0
        end = self._size if end is None else end
        while size < _RUN_BYTES and len(parts) < _RUN_CHUNKS and at < end:
            part = self._part(at, _RUN_BYTES - size if parts else LARGE_BYTES)
            if part is None or parts and part.is_extended:
                # Only what follows can tell whether the length of an extended chunk is right.
                break
            parts.append(part)
            size += part.head.size
            at = part.index_end
        run = self._join(parts) if parts else None
        return self._join(parts[:1]) if run is None and len(parts) > 1 else run

    def _part(self, at: int, most: int) -> _Part | None:
        """Return the chunk at a byte if it is intact and has at most `most` bytes of records."""
        head = find_chunk_head(self._read(at, HEAD_BYTES))
        if head is None or head.size > most or at + HEAD.size + head.length > self._size:
            return None
        content = self._read(at + HEAD.size, head.length)
        try:
            data = unpack(content, self._zstd)
        except BagError:
            return None
        index, index_end = self._index(at + HEAD.size + head.length, head.size)
        return _Part(at, head, index_end, data, head.crc or crc32(data), index)

    def _index(self, at: int, size: int) -> tuple[list[tuple[int, bytes]], int]:
        """Return channel and entries of each message index from a byte on, and their end."""
        indexes = []
        most = size // MESSAGE_HEAD.size * ENTRY_BYTES
        ahead, begin = b'', at
        while True:
            place = at - begin
            if place + INDEX_HEAD.size > len(ahead):
                ahead, begin, place = self._read(at, _INDEX_BYTES), at, 0
                if len(ahead) < INDEX_HEAD.size:
                    break
            opcode, length, number, count = INDEX_HEAD.unpack_from(ahead, place)
            rest = length - count - INDEX_LEAST
            if (opcode != Opcode.MESSAGE_INDEX or rest < 0 or rest and not self._extended
                    or at + HEAD.size + length > self._size
                    or count > most or count % ENTRY_BYTES):
                break
            place += INDEX_HEAD.size
            entries = ahead[place:place + count]
            if len(entries) < count:
                entries = self._read(at + INDEX_HEAD.size, count)
                if len(entries) < count:
                    break
            indexes.append((number, entries))
            at += HEAD.size + length
        return indexes, at

    def _join(self, parts: list[_Part]) -> ChunkRun | None:
        """Join chunks to one block; None if their records do not fill them."""
        data = parts[0].data if len(parts) == 1 else b''.join([part.data for part in parts])
        bases = np.cumsum([0, *(part.head.size for part in parts)])
        entries = _Entries(parts, bases)
        try:
            block = block_of(data, parts[0].start, entries.offsets)
        except BagError:
            return None
        at = block.start - MESSAGE_HEAD.size
        edges = np.searchsorted(at, bases)
        if len(parts) > 1 and not _are_apart(block, bases, edges):
            return None
        log = block.heads['log_time'].copy()
        indexed = entries.verify(block, at, log, edges)
        chunks, untimed = self._chunks(parts, block, bases, edges, log, indexed)
        return ChunkRun(chunks, bases, edges, block, untimed)

    def _chunks(self, parts: list[_Part], block: Block, bases: Integers, edges: Integers,
                log: Integers, indexed: list[bool]) -> tuple[list[Chunk], int]:
        filled = np.flatnonzero(np.diff(edges))
        first, last = np.zeros(len(parts), np.int64), np.zeros(len(parts), np.int64)
        published = np.zeros(len(parts), np.int64)
        if filled.size:
            lows = edges[filled]
            first[filled] = np.minimum.reduceat(log, lows)
            last[filled] = np.maximum.reduceat(log, lows)
            published[filled] = np.minimum.reduceat(block.heads['publish_time'], lows)
        timed = are_timed(first)
        plain = timed & (published >= 0)
        others: dict[int, dict[bytes, None]] = {}
        begins = np.append(block.start, len(block.data))[edges[:-1]]
        heads = np.array([r.start - HEAD.size for r in block.others], np.int64)
        for record, place in zip(block.others, np.searchsorted(bases, heads, 'right').tolist()):
            if record.opcode not in (Opcode.SCHEMA, Opcode.CHANNEL):
                plain[place - 1] = False
                continue
            mine = others.setdefault(place - 1, {})
            definition = bytes(block.data[record.start - HEAD.size:record.start + record.length])
            if begins[place - 1] < record.start and definition not in mine:
                plain[place - 1] = False
            mine[definition] = None
        chunks, untimed = [], 0
        spans = zip(edges[:-1].tolist(), edges[1:].tolist())
        for i, (part, (lo, hi), begin_ns, end_ns) in enumerate(zip(
                parts, spans, first.tolist(), last.tolist())):
            head = part.head
            indexed[i] = indexed[i] and bool(timed[i])
            counts: Counts
            if indexed[i]:
                counts = tuple([(n, len(content) // ENTRY_BYTES) for n, content in part.indexes])
            else:
                possible = are_timed(log[lo:hi])
                counts = count_messages(block.heads['channel'][lo:hi][possible])
                untimed += int((~possible).sum())
            chunks.append(Chunk(
                start=part.start, end=part.start + HEAD.size + head.length,
                index_end=part.index_end, first_ns=begin_ns, last_ns=end_ns, size=head.size,
                crc=part.crc, compression=head.compression, packed=head.packed, counts=counts,
                definitions=self._intern(others.get(i, ())),
                plain=bool(plain[i]) and not part.is_extended and not is_packed(
                    block.data, block.start[lo:hi]),
                indexed=indexed[i], protected=head.crc > 0))
        return chunks, untimed

    def _intern(self, records: Collection[bytes]) -> frozenset[bytes]:
        """Return records as a set; equal records share one set."""
        return self._record_sets.setdefault(tuple(records), frozenset(records))


def _are_apart(block: Block, bases: Integers, edges: Integers) -> bool:
    """Tell whether no record reaches from one chunk into the next."""
    inner, before = bases[1:-1], edges[1:-1] - 1
    within = before >= 0
    if (block.stop[before[within]] > inner[within]).any():
        return False
    return not any(((r.start - HEAD.size < inner) & (inner < r.start + r.length)).any()
                   for r in block.others)


class _Entries:
    """What the message indexes of several chunks say about their messages."""

    def __init__(self, parts: list[_Part], bases: Integers) -> None:
        contents = [content for part in parts for _, content in part.indexes]
        lengths = np.array([len(content) // ENTRY_BYTES for content in contents], np.int64)
        places = np.array([i for i, part in enumerate(parts) for _ in part.indexes], np.int64)
        self._places = np.repeat(places, lengths)
        numbers = np.array([n for part in parts for n, _ in part.indexes], np.uint16)
        self._channels = np.repeat(numbers, lengths)
        entries = np.frombuffer(b''.join(contents), '<i8').reshape(-1, 2)
        self._times = entries[:, 0]
        self._at = entries[:, 1] + bases[:-1][self._places]
        self._doubled = [len({n for n, _ in part.indexes}) < len(part.indexes) for part in parts]
        self._complete = all(part.indexes for part in parts)

    def offsets(self) -> Integers | None:
        """Return the offsets of the messages they name; None if a chunk has no index."""
        return self._at if self._complete else None

    def verify(self, block: Block, at: Integers, log: Integers,
               edges: Integers) -> list[bool]:
        """Return for each chunk whether its indexes name each of its messages once."""
        order = np.argsort(self._at, kind='stable')
        channels = block.heads['channel']
        if len(at) == len(order) and (
                (self._at[order] == at).all() and (self._times[order] == log).all()
                and (self._channels[order] == channels).all()):
            return [not doubled for doubled in self._doubled]
        verdicts = []
        limits = np.searchsorted(self._places, np.arange(len(edges)))
        for lo, hi, begin, end, doubled in zip(limits[:-1], limits[1:], edges[:-1], edges[1:],
                                               self._doubled):
            mine = lo + np.argsort(self._at[lo:hi], kind='stable')
            verdicts.append(not doubled and hi - lo == end - begin and bool(
                (self._at[mine] == at[begin:end]).all()
                and (self._times[mine] == log[begin:end]).all()
                and (self._channels[mine] == channels[begin:end]).all()))
        return verdicts

