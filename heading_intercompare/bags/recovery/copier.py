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
The copier of the intact records of damaged files into a bag.

A chunk is copied unchanged, still compressed, if its channels have the same numbers in the new
bag, its definitions are those of the new bag, and all its messages are wanted. Its message indexes
are copied too if they are right. The messages of other chunks are gathered and compressed again.
"""

from __future__ import annotations

from collections import Counter
from functools import partial
from io import BufferedIOBase
from typing import Callable, Iterator, Mapping

from mcap import records as mcap
from mcap.opcode import Opcode
import numpy as np

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.chunk_runs import Chunk, ChunkRun, ChunkRuns
from heading_intercompare.bags.mcap.chunk_writer import ChunkWriter, Records
from heading_intercompare.bags.mcap.chunks import CHUNK_HEAD
from heading_intercompare.bags.mcap.index_records import message_index
from heading_intercompare.bags.mcap.message_blocks import Block, block_of, HEAD, MESSAGE_HEAD
from heading_intercompare.bags.mcap.record_stream import parse_record
from heading_intercompare.bags.packed_files import is_packed, MOST_MESSAGE_BYTES, unpack_payload
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.bag_yaml import Qos
from heading_intercompare.core.records import Integers
from heading_intercompare.messages.byte_columns import BytesLike
from heading_intercompare.messages.fields import full_name
from heading_intercompare.messages.schemas import Schema

from .inventory import Inventory, Kind, Piece
from .large_chunks import read_blocks
from .scanner import Salvage
from .unreadable_sectors import open_with_holes

#: Most bytes of chunks to pass on, or to gather, at once.
_PASSED_BYTES = 2**22
_GATHERED_BYTES = 2**20
_CHANNELS = 2**16
#: Offsets of the channel and the times in a message record.
_CHANNEL_AT, _LOG_AT, _PUBLISH_AT = 9, 15, 23


class Transfer:
    """
    Copies the intact records of the files of a damaged bag into a new one.

    Parameters
    ----------
    bag
        The new bag.
    compression
        Compression that chunks must have, by MCAP's name; None: they keep their own.
    singly
        Copy chunks one at a time, so that the bag may continue in a new file after each.
    note
        Called with the file and the remark for anything notable.

    Attributes
    ----------
    counts
        Messages by topic.
    refused : int
        Messages that could not be decompressed one by one, and are left out.

    """

    def __init__(self, bag: BagWriter, compression: str | None, singly: bool,
                 note: Callable[[Inventory, str], None]) -> None:
        self._bag = bag
        self._compression = compression
        self._singly = singly
        self._note = note
        self._types: dict[str, tuple[str, bytes]] = {}
        self._names: dict[int, str] = {}
        self.counts: dict[str, int] = {}
        self.refused = 0

    def copy(self, inventory: Inventory, progress: Callable[[str], None]) -> None:
        """
        Copy the intact records of a file.

        Raises
        ------
        OSError
            If the file cannot be read or the bag cannot be written.
        BagError
            If the file has changed since the inventory.

        """
        numbers = {key: self._add_topic(inventory, *key) for key in sorted(inventory.counts)}
        with open_with_holes(inventory.file.place, inventory.holes) as file:
            copying = _Copying(file, inventory, self._bag, numbers)
            for piece in inventory.pieces:
                if piece.kind == Kind.EXTRA:
                    self._copy_extra(inventory, file, piece.chunk)
                elif piece.kind == Kind.CHUNK:
                    copying.take(piece, self._compression, self._singly)
                elif piece.kind == Kind.LARGE:
                    copying.take_large(piece)
                else:
                    copying.take_part(piece)
                progress(f'{piece.chunk.end / inventory.size:.0%} copied')
            copying.flush()
        self._leave_out(inventory, copying.refused)

    def _leave_out(self, inventory: Inventory, refused: Mapping[int, int]) -> None:
        """Take messages that are not in the new bag from the counts."""
        for number, count in refused.items():
            self.counts[self._names[number]] -= count
            self.refused += count
        if refused:
            self._note(inventory, f'{sum(refused.values())} messages cannot be decompressed, or '
                       f'claim more than {MOST_MESSAGE_BYTES} bytes')

    def _add_topic(self, inventory: Inventory, section: int, number: int) -> int:
        """Add the topic of a channel to the new bag; return its number there, -1 without topic."""
        definition = inventory.topic(section, number)
        if definition is None:
            return -1
        channel, schema = definition
        topic = channel.topic if channel.topic.startswith('/') else f'/{channel.topic}'
        name, kind = topic, full_name(schema.name)
        while self._types.setdefault(name, (kind, schema.data))[0] != kind:
            # A rosbag2 cannot hold one topic with two types: keep both, rename the second.
            name = f'{name}_{kind.rpartition("/")[2].lower()}'
        if name != topic:
            self._note(inventory, f'{topic} is also {kind}: kept as {name}')
        elif self._types[name][1] != schema.data:
            self._note(inventory, f'{topic}: {kind} is defined in two ways; the first is kept')
        self.counts[name] = self.counts.get(name, 0) + inventory.counts[section, number]
        new = self._bag.add_topic(
            name, kind, Qos.of_yaml(channel.metadata.get('offered_qos_profiles', '')),
            schema=Schema(kind, schema.data.decode(errors='replace'),
                          channel.metadata.get('topic_type_hash', ''), schema.encoding),
            numbers=(channel.id, schema.id))
        self._names[new] = name
        return new

    def _copy_extra(self, inventory: Inventory, file: BufferedIOBase, place: Chunk) -> None:
        try:
            data = bytearray(place.end - place.start)
        except MemoryError:
            self._note(inventory, f'bytes {place.start} to {place.end}: do not fit into memory')
            return
        file.seek(place.start)
        if file.readinto(data) < len(data):
            raise _blame_change(inventory)
        if data[0] == Opcode.ATTACHMENT:
            self._bag.chunks.append_attachment(data)
        else:
            metadata = parse_record(mcap.Metadata, data[HEAD.size:])
            self._bag.metadata(metadata.name, metadata.metadata)


def _blame_change(inventory: Inventory) -> BagError:
    return BagError('has changed while it was read', inventory.path)


def _read(file: BufferedIOBase, at: int, size: int) -> bytes:
    """Return bytes of a file, fewer at its end."""
    file.seek(at)
    return file.read(size)


class _Copying:
    """The copying of one file."""

    def __init__(self, file: BufferedIOBase, inventory: Inventory, bag: BagWriter,
                 numbers: dict[tuple[int, int], int]) -> None:
        self._file = file
        self._inventory = inventory
        self._bag = bag
        self._numbers = numbers
        self.salvage = Salvage(file, inventory.unproven > 0)
        # No method of this object, which would keep it, and what it has unpacked, alive.
        self._read = partial(_read, file)
        self._runs = ChunkRuns(self._read, self.salvage.size)
        self._same: dict[object, bool] = {}
        self._tables: tuple[int, Integers] = (-1, np.empty(0, np.int64))
        #: Chunks to pass on unchanged, and chunks to gather; one of the lists is empty.
        self._passed: list[Chunk] = []
        self._gathered: list[Chunk] = []
        self._section = 0
        self._memory = bytearray()
        #: Messages that cannot be decompressed, by channel in the new bag.
        self.refused: Counter[int] = Counter()

    def take(self, piece: Piece, compression: str | None, singly: bool) -> None:
        """Take the next whole chunk."""
        chunk = piece.chunk
        if not (compression in (None, chunk.compression) and self._is_same(piece)):
            self._gather(piece)
            return
        if self._gathered:
            self.flush()
        chunks = self._bag.chunks
        if not self._passed:
            chunks.end_chunk()
            self._bag.split_if_due()
            chunks = self._bag.chunks
            if not chunks.due <= chunk.definitions:
                self._gather(piece)
                return
        elif not chunk.indexed or self._passed[-1].index_end != chunk.start or (
                len(self._passed) >= chunks.until_due
                or chunk.index_end - self._passed[0].start > _PASSED_BYTES):
            self.flush()
            self.take(piece, compression, singly)
            return
        self._passed.append(chunk)
        if singly or not chunk.indexed:
            self.flush()

    def _is_same(self, piece: Piece) -> bool:
        """Tell whether a chunk can be copied unchanged: it means the same in the new bag."""
        chunk = piece.chunk
        key = piece.section, chunk.counts, chunk.definitions
        if key not in self._same:
            self._same[key] = chunk.definitions <= self._bag.chunks.defined and all(
                self._numbers.get((piece.section, number)) == number
                for number, _ in chunk.counts)
        return self._same[key] and chunk.plain

    def _gather(self, piece: Piece) -> None:
        chunk = piece.chunk
        if self._passed or (self._gathered and (
                piece.section != self._section or self._gathered[-1].index_end != chunk.start
                or chunk.index_end - self._gathered[0].start > _GATHERED_BYTES)):
            self.flush()
        self._gathered.append(chunk)
        self._section = piece.section

    def flush(self) -> None:
        """Write the chunks taken so far."""
        passed, gathered = self._passed, self._gathered
        self._passed, self._gathered = [], []
        if passed:
            self._pass_on(passed)
        at = gathered[0].start if gathered else 0
        while gathered and at < gathered[-1].index_end:
            run = self._runs.run(at, gathered[-1].index_end)
            if run is None:
                raise _blame_change(self._inventory)
            self._write(run.block, self._section)
            at = run.chunks[-1].index_end

    def _pass_on(self, chunks: list[Chunk]) -> None:
        """Write chunks unchanged, but with the values found for their heads."""
        start, end = chunks[0].start, chunks[-1].index_end
        if not chunks[0].indexed:
            end = chunks[0].end
        if end - start > len(self._memory):
            self._memory = bytearray(end - start)
        passed = memoryview(self._memory)[:end - start]
        self._file.seek(start)
        if self._file.readinto(passed) < len(passed):
            raise _blame_change(self._inventory)
        for chunk in chunks:
            passed[chunk.start - start] = Opcode.CHUNK
            CHUNK_HEAD.pack_into(passed, chunk.start - start + HEAD.size, chunk.first_ns,
                                 chunk.last_ns, chunk.size, chunk.crc, len(chunk.compression))
        data: BytesLike = passed
        if not chunks[0].indexed:
            run = self._runs.run(start, chunks[0].end)
            if run is None:
                raise _blame_change(self._inventory)
            data = b''.join((passed, _indexes(run, chunks[0])))
        self._bag.chunks.append(data, chunks)
        self._bag.split_if_due()

    def take_part(self, piece: Piece) -> None:
        """Take a piece that is not a whole chunk."""
        self.flush()
        at, end = piece.chunk.start, piece.chunk.end
        if piece.kind == Kind.FRAGMENT:
            item = self.salvage.fragment(at, end) or self.salvage.unproved(at)
            block = item.block if item is not None else None
        else:
            data = self._read(at, end - at)
            block = block_of(data, at) if len(data) == end - at else None
        if block is None:
            raise _blame_change(self._inventory)
        self._write(block, piece.section)

    def take_large(self, piece: Piece) -> None:
        """Take a chunk that is too large to decompress at once; it becomes several."""
        self.flush()
        at, base = piece.chunk.start, 0
        for block in read_blocks(self._file, at, piece.chunk.end, self._inventory.large[at]):
            self._write(block, piece.section)
            base += len(block.data)
        if base != piece.chunk.size:
            raise _blame_change(self._inventory)

    def _table(self, section: int) -> Integers:
        """Return the number in the new bag of each channel of a section, -1 for none."""
        if self._tables[0] != section:
            table = np.full(_CHANNELS, -1, np.int64)
            for (channel_section, number), new in self._numbers.items():
                if channel_section == section:
                    table[number] = new
            self._tables = section, table
        return self._tables[1]

    def _write(self, block: Block, section: int) -> None:
        """Write the messages of a block that have a topic and a time, in order."""
        at = block.start - MESSAGE_HEAD.size
        channel = block.heads['channel'].astype(np.int64)
        log, publish = block.heads['log_time'].copy(), block.heads['publish_time'].copy()
        new = self._table(section)[channel]
        writable = (new >= 0) & (log >= 0)
        data: BytesLike = block.data
        if (new != channel)[writable].any() or (publish < 0)[writable].any():
            data = bytearray(data)
            every = np.frombuffer(data, np.uint8)
            every[at[writable] + _CHANNEL_AT] = new[writable] & 255
            every[at[writable] + _CHANNEL_AT + 1] = new[writable] >> 8
            unsent = at[writable & (publish < 0)]
            for byte in range(_PUBLISH_AT - _LOG_AT):
                every[unsent + _PUBLISH_AT + byte] = every[unsent + _LOG_AT + byte]
        columns = data, at[writable], block.stop[writable], new[writable], log[writable]
        packed = is_packed(block.data, block.start)
        for records in self._unpack(*columns) if packed else (Records(*columns),):
            lo = 0
            while lo < len(records):
                chunks: ChunkWriter = self._bag.chunks
                lo = chunks.fill(records, lo)
                if not chunks.pending:
                    self._bag.split_if_due()

    def _unpack(self, data: BytesLike, start: Integers, stop: Integers, channel: Integers,
                log_time_ns: Integers) -> Iterator[Records]:
        """Yield records with payloads decompressed, in pieces; count payloads that cannot be."""
        rows: list[int] = []
        records: list[bytes] = []
        size = 0
        for number, (lo, hi) in enumerate(zip(start.tolist(), stop.tolist())):
            begin = lo + MESSAGE_HEAD.size
            stored = bytes(data[begin:hi])
            payload = unpack_payload(stored) if is_packed(data, np.array([begin])) else stored
            if payload is None:
                self.refused[int(channel[number])] += 1
            else:
                length = MESSAGE_HEAD.size - HEAD.size + len(payload)
                head = HEAD.pack(Opcode.MESSAGE, length) + bytes(data[lo + HEAD.size:begin])
                records.append(head + payload)
                rows.append(number)
                size += len(records[-1])
            if records and (size > _GATHERED_BYTES or number == len(start) - 1):
                ends = np.cumsum([0, *map(len, records)], dtype=np.int64)
                yield Records(b''.join(records), ends[:-1], ends[1:], channel[rows],
                              log_time_ns[rows])
                rows, records, size = [], [], 0


def _indexes(run: ChunkRun, chunk: Chunk) -> bytes:
    """Return the message indexes of the only chunk of a run."""
    heads = run.block.heads
    channel, log = heads['channel'].copy(), heads['log_time'].copy()
    entries = np.stack((log, run.block.start - MESSAGE_HEAD.size), axis=1).astype('<i8')
    return b''.join([message_index(number, entries[channel == number].tobytes())
                     for number, _ in chunk.counts])
