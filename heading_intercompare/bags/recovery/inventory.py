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
The inventory of a damaged file: what can be copied, which topics it has, what is lost.

A definition may stand before or after its messages, and more than once. One in a chunk with a
checksum counts more than others. If two of those disagree, nobody knows which messages belong to
which: the number means nothing, so that no message comes under the topic of another.
"""

from __future__ import annotations

from array import array
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass, field
from enum import IntEnum
from io import BufferedIOBase
from pathlib import Path
from typing import Any, Callable, Iterator, NamedTuple

from mcap import records as mcap
from mcap.opcode import Opcode
import numpy as np

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.chunk_runs import Chunk, ChunkRun, count_messages, Counts
from heading_intercompare.bags.mcap.mcap_file import ChunkRow, read_chunk_index
from heading_intercompare.bags.mcap.message_blocks import (
    Block,
    ENTRY_BYTES,
    HEAD,
    INDEX_LEAST,
)
from heading_intercompare.bags.mcap.record_stream import parse_record
from heading_intercompare.bags.packed_files import PlainFile

from .large_chunks import Large, read_blocks
from .scanner import Gap, Salvage, Sound
from .unreadable_sectors import open_with_holes

_Definition = mcap.Schema | mcap.Channel
#: Opcode and number of a definition.
_Key = tuple[int, int]


class Definitions:
    """The schemas and channels found in a file."""

    def __init__(self) -> None:
        #: Definitions in chunks with a checksum, and the first ones elsewhere.
        self._checked: dict[_Key, _Definition] = {}
        self._others: dict[_Key, _Definition] = {}
        self._contradicted: dict[_Key, str] = {}
        self._seen: set[tuple[int, bytes, bool]] = set()

    @property
    def contradictions(self) -> list[str]:
        """Return what is defined in two ways, in words."""
        return list(self._contradicted.values())

    def take(self, opcode: int, content: bytes, checked: bool) -> None:
        """
        Take a definition.

        Parameters
        ----------
        opcode, content
            Opcode and content of its record; a damaged one is ignored.
        checked
            It is in a chunk with a correct checksum.

        """
        key = opcode, int.from_bytes(content[:2], 'little')
        if key in self._contradicted or (opcode, content, checked) in self._seen:
            return
        self._seen.add((opcode, content, checked))
        try:
            kind: type[_Definition] = (mcap.Schema if opcode == Opcode.SCHEMA
                                       else mcap.Channel)
            definition = parse_record(kind, content, any_text=checked)
        except BagError:
            return
        first_definition = (self._checked if checked else self._others).setdefault(key, definition)
        if checked and _meaning(first_definition) != _meaning(definition):
            what = 'schema' if opcode == Opcode.SCHEMA else 'channel'
            self._contradicted[key] = (
                f'{what} {key[1]} is both {_meaning(first_definition)[0]} and '
                f'{_meaning(definition)[0]}')

    def topic(self, number: int) -> tuple[mcap.Channel, mcap.Schema] | None:
        """Return channel and schema of a number; None if lost, contradicted or not of ROS 2."""
        channel = self._find(Opcode.CHANNEL, number)
        if not isinstance(channel, mcap.Channel) or channel.message_encoding != 'cdr':
            return None
        schema = self._find(Opcode.SCHEMA, channel.schema_id)
        return (channel, schema) if isinstance(schema, mcap.Schema) else None

    def _find(self, opcode: int, number: int) -> _Definition | None:
        key = opcode, number
        if key in self._contradicted:
            return None
        return self._checked.get(key) or self._others.get(key)


def _meaning(definition: _Definition) -> tuple[object, ...]:
    """Return what decides to which topic and type messages belong; first its name."""
    if isinstance(definition, mcap.Schema):
        return definition.name, definition.encoding, definition.data
    return definition.topic, definition.message_encoding, definition.schema_id


_ROWS = 4096


class Kind(IntEnum):
    """The kind of a piece."""

    CHUNK = 0
    #: A chunk of which only the beginning is intact.
    FRAGMENT = 1
    #: Messages and definitions outside chunks.
    BARE = 2
    #: Metadata or an attachment.
    EXTRA = 3
    #: A chunk that is read in blocks, or the intact beginning of one.
    LARGE = 4


class Piece(NamedTuple):
    """Something to copy, and the number of its section."""

    kind: Kind
    section: int
    chunk: Chunk


class Pieces:
    """The pieces of a file in file order, stored compactly."""

    _WIDTH = 14

    def __init__(self) -> None:
        self._rows = array('q')
        self._things: list[Any] = []
        self._places: dict[object, int] = {}

    def __len__(self) -> int:
        return len(self._rows) // self._WIDTH

    def _place(self, thing: object) -> int:
        place = self._places.setdefault(thing, len(self._things))
        if place == len(self._things):
            self._things.append(thing)
        return place

    def add(self, kind: Kind, section: int, chunk: Chunk) -> None:
        """Append the next piece."""
        (start, end, index_end, first_ns, last_ns, size, crc, compression, packed, counts,
         definitions, plain, indexed, protected) = chunk
        self._rows.extend((
            kind, section, start, end, index_end, first_ns, last_ns, size, crc,
            self._place(compression), packed, self._place(counts), self._place(definitions),
            4 * protected + 2 * plain + indexed))

    def drop(self, number: int) -> None:
        """Remove a piece, given its number; the others keep their numbers."""
        self._rows[number * self._WIDTH] = -1

    def __iter__(self) -> Iterator[Piece]:
        things, width = self._things, self._WIDTH
        for lo in range(0, len(self._rows), width * _ROWS):
            rows = np.array(self._rows[lo:lo + width * _ROWS], np.int64).reshape(-1, width)
            for row in rows.tolist():
                (kind, section, start, end, index_end, first_ns, last_ns, size, crc, compression,
                 packed, counts, definitions, flags) = row
                if kind >= 0:
                    yield Piece(Kind(kind), section, Chunk(
                        start=start, end=end, index_end=index_end, first_ns=first_ns,
                        last_ns=last_ns, size=size, crc=crc, compression=things[compression],
                        packed=packed, counts=things[counts], definitions=things[definitions],
                        plain=bool(flags & 2), indexed=bool(flags & 1), protected=flags > 3))


class Damage(NamedTuple):
    """A damaged stretch of bytes; `chunk`: it was a chunk, `lost`: bytes that cannot be read."""

    start: int
    end: int
    fault: str
    chunk: bool
    lost: int


@dataclass(slots=True)
class Section:
    """
    A file, or one of several files that were appended to each other.

    Attributes
    ----------
    definitions
        Its topics; nothing carries over from one file to another.
    said
        Message counts in its statistics; there should be one.
    indexed
        Lost messages that the indexes after damaged or missing chunks name.
    untimed
        Messages with impossible log times.
    closed
        It has an end.

    """

    definitions: Definitions = field(default_factory=Definitions)
    said: list[int] = field(default_factory=list)
    indexed: int = 0
    untimed: int = 0
    closed: bool = False


@dataclass(slots=True)
class Inventory:
    """
    The contents of a file.

    Attributes
    ----------
    file
        The file, unpacked if it was compressed whole.
    size
        Its size in bytes.
    holes
        Offsets of the blocks that the disk cannot read.
    pieces
        The pieces that can be copied.
    counts
        Messages by section and channel.
    chunks
        Chunks that can be copied, wholly or in part.
    packed
        Compressed bytes of whole chunks, by compression.
    damage
        The damaged stretches.
    sections
        The file itself, and the files that were appended to it.
    begun
        It has a beginning.
    extras
        Number of metadata records and attachments.
    earlier
        The metadata records `recovery` in it, from earlier recoveries.
    indexed
        What its index says of the chunks.
    unproven
        Messages that are kept though the checksum of their chunk is wrong.
    large
        What the large chunks hold, by their first bytes.
    doubtful
        Numbers, sections and rows of pieces that are believed only if the file has no chunk.

    """

    file: PlainFile
    size: int = 0
    holes: list[int] = field(default_factory=list)
    pieces: Pieces = field(default_factory=Pieces)
    counts: dict[tuple[int, int], int] = field(default_factory=dict)
    chunks: int = 0
    packed: dict[str, int] = field(default_factory=dict)
    damage: list[Damage] = field(default_factory=list)
    sections: list[Section] = field(default_factory=lambda: [Section()])
    begun: bool = False
    extras: int = 0
    earlier: list[dict[str, str]] = field(default_factory=list)
    indexed: list[ChunkRow] = field(default_factory=list)
    unproven: int = 0
    large: dict[int, Large] = field(default_factory=dict)
    doubtful: list[tuple[int, int, Chunk]] = field(default_factory=list)

    @property
    def path(self) -> Path:
        """Return the name of the file in messages."""
        return self.file.path

    @property
    def closed(self) -> bool:
        """Whether the file, and each file appended to it, has an end."""
        return all(section.closed for section in self.sections)

    def count_misplaced(self) -> int:
        """Return how many chunks are not those that the index of the file names in their place."""
        chunks = [piece.chunk for piece in self.pieces
                  if piece.kind in (Kind.CHUNK, Kind.LARGE)]
        if len(self.indexed) != len(chunks) or len(self.sections) > 1:
            # Something is missing, which is said elsewhere.
            return 0
        entries = {row.begin: (row.first_ns, row.last_ns, row.size) for row in self.indexed}
        return sum(entries.get(chunk.start, ()) != (chunk.first_ns, chunk.last_ns, chunk.size)
                   for chunk in chunks)

    @property
    def section(self) -> int:
        """Return the number of the newest section."""
        return len(self.sections) - 1

    def topic(self, section: int, number: int) -> tuple[mcap.Channel, mcap.Schema] | None:
        """Return channel and schema of a number in a section; None if it means no topic."""
        return self.sections[section].definitions.topic(number)

    def count(self, section: int, counts: Counts, sign: int = 1) -> None:
        """Add the messages of channels to the counts of a section."""
        for number, messages in counts:
            total = self.counts.get((section, number), 0) + sign * messages
            self.counts[section, number] = total
            if not total:
                del self.counts[section, number]

    def withdraw(self) -> None:
        """
        Drop the messages outside chunks that follow damage, because the file has chunks.

        They may be the rest of a chunk whose head, with its checksum, is lost.
        """
        for number, section, row in self.doubtful:
            self.pieces.drop(number)
            self.count(section, row.counts, -1)
            self.damage.append(Damage(row.start, row.end, 'messages without their chunk', False,
                                      row.end - row.start))
        self.doubtful.clear()
        self.damage.sort()


def take_inventory(path: Path, progress: Callable[[str], None],
                   unproven: bool = False) -> Inventory:
    """
    Read a whole file, and list its contents.

    Parameters
    ----------
    path
        The file.
    progress
        Called with the progress in words.
    unproven
        Also keep the possible messages of chunks whose checksum is wrong.

    Raises
    ------
    OSError
        If the file cannot be read.
    BagError
        If it is compressed whole and unpacks to far too much.

    """
    inventory = Inventory(PlainFile(path))
    #: For a damaged chunk: messages that its indexes name, and messages of it that can be read.
    named, readable = 0, 0
    #: Whether message indexes here belong to a damaged chunk; None: no chunk precedes them.
    indexing: bool | None = None
    with open_with_holes(inventory.file.place, inventory.holes) as file:
        salvage = Salvage(file, unproven)
        inventory.size = salvage.size
        for item in salvage.scan():
            if isinstance(item, Sound) and item.record.opcode == Opcode.MESSAGE_INDEX:
                names = (item.record.length - INDEX_LEAST) // ENTRY_BYTES
                if names and indexing is None:
                    at, indexing = item.record.start - HEAD.size, True
                    inventory.damage.append(Damage(at, at, 'the chunk before its message indexes '
                                                   'is missing', True, 0))
                named += names if indexing else 0
                continue
            inventory.sections[-1].indexed += max(named - readable, 0)
            named, readable, indexing = 0, 0, None
            if isinstance(item, Gap):
                inventory.damage.append(Damage(item.start, item.end, item.fault, item.chunk,
                                               item.end - item.start))
                indexing = item.chunk
                continue
            if item.record.opcode == Opcode.CHUNK:
                indexing = False
            if item.fault:
                inventory.damage.append(Damage(item.record.start - HEAD.size, item.end, item.fault,
                                               True, item.lost))
                indexing = True
                readable = (item.large.messages if item.large else
                            len(item.block.start) if item.block else 0)
                inventory.unproven += readable if item.unproven else 0
            _take(inventory, item, salvage, file)
            if item.block is not None or item.large is not None:
                progress(f'{item.end / salvage.size:.0%} examined')
        if salvage.chunked:
            inventory.withdraw()
    inventory.sections[-1].indexed += max(named - readable, 0)
    return inventory


def _take(inventory: Inventory, item: Sound, salvage: Salvage, file: BufferedIOBase) -> None:
    opcode = item.record.opcode
    if item.begins:
        # Only a header just after magic bytes begins another file; elsewhere the file was torn.
        if inventory.begun:
            inventory.sections.append(Section())
        inventory.begun = True
    if item.record.opcode == Opcode.CHUNK and inventory.doubtful:
        inventory.withdraw()
    if item.run is not None:
        _take_run(inventory, item.run)
    elif item.large is not None:
        _take_large(inventory, item.record.start - HEAD.size, item.end, item.large, file)
    elif item.block is not None:
        _take_block(inventory, item, item.block)
    elif opcode == Opcode.STATISTICS:
        statistics = parse_record(mcap.Statistics, salvage.content(item.record))
        if statistics.channel_message_counts or not statistics.message_count:
            inventory.sections[-1].said.append(statistics.message_count)
    elif opcode == Opcode.CHUNK_INDEX:
        with suppress(BagError):
            inventory.indexed.append(read_chunk_index(salvage.content(item.record)))
    elif opcode == Opcode.FOOTER:
        inventory.sections[-1].closed = True
    elif opcode in (Opcode.METADATA, Opcode.ATTACHMENT):
        if opcode == Opcode.METADATA:
            metadata = parse_record(mcap.Metadata, salvage.content(item.record))
            if metadata.name == 'recovery':
                inventory.earlier.append(metadata.metadata)
            if metadata.name in ('recovery', 'rosbag2'):
                return
        inventory.extras += 1
        start = item.record.start - HEAD.size
        inventory.pieces.add(Kind.EXTRA, inventory.section, _make_row(start, item.end, ()))


def _take_block(inventory: Inventory, item: Sound, block: Block) -> None:
    """Take messages of a cut chunk, or messages outside chunks."""
    kind = Kind.FRAGMENT if item.record.opcode == Opcode.CHUNK else Kind.BARE
    inventory.chunks += kind == Kind.FRAGMENT
    _define(inventory, block, slice(None), False)
    log = block.heads['log_time'].copy()
    counts = count_messages(block.heads['channel'][log >= 0])
    inventory.sections[-1].untimed += int((log < 0).sum())
    inventory.count(inventory.section, counts)
    if counts:
        row = _make_row(item.record.start - HEAD.size, item.end, counts)
        if kind == Kind.BARE and inventory.damage and not inventory.chunks:
            inventory.doubtful.append((len(inventory.pieces), inventory.section, row))
        inventory.pieces.add(kind, inventory.section, row)


def _make_row(start: int, end: int, counts: Counts) -> Chunk:
    """Return the table row of a piece that is not a whole chunk."""
    return Chunk(start=start, end=end, index_end=end, first_ns=0, last_ns=0, size=0, crc=0,
                 compression='', packed=0, counts=counts, definitions=frozenset(), plain=False,
                 indexed=False, protected=False)


def _define(inventory: Inventory, block: Block, which: slice, checked: bool) -> None:
    """Take the definitions among the other records of a block."""
    for record in block.others[which]:
        if record.opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            content = bytes(block.data[record.start:record.start + record.length])
            inventory.sections[-1].definitions.take(record.opcode, content, checked)


def _take_run(inventory: Inventory, run: ChunkRun) -> None:
    """Take whole chunks."""
    inventory.chunks += len(run.chunks)
    inventory.sections[-1].untimed += run.untimed
    behind = np.searchsorted([r.start - HEAD.size for r in run.block.others], run.bases).tolist()
    for i, chunk in enumerate(run.chunks):
        if chunk.definitions:
            _define(inventory, run.block, slice(behind[i], behind[i + 1]), chunk.protected)
        inventory.count(inventory.section, chunk.counts)
        if chunk.counts:
            inventory.packed[chunk.compression] = (inventory.packed.get(chunk.compression, 0)
                                                   + chunk.packed)
            inventory.pieces.add(Kind.CHUNK, inventory.section, chunk)


def _take_large(inventory: Inventory, start: int, end: int, large: Large,
                file: BufferedIOBase) -> None:
    """Take a large chunk; its messages are counted block by block."""
    totals: Counter[int] = Counter()
    first_ns, last_ns = 2**63 - 1, 0
    for block in read_blocks(file, start, end, large):
        _define(inventory, block, slice(None), large.proved and large.head.crc > 0)
        log, channels = block.heads['log_time'].copy(), block.heads['channel']
        timed = log >= 0
        inventory.sections[-1].untimed += int((~timed).sum())
        totals.update(dict(count_messages(channels[timed])))
        if timed.any():
            first_ns = min(first_ns, int(log[timed].min()))
            last_ns = max(last_ns, int(log[timed].max()))
    inventory.chunks += 1
    counts = tuple(totals.items())
    inventory.count(inventory.section, counts)
    if totals:
        compression = large.head.compression
        inventory.packed[compression] = inventory.packed.get(compression, 0) + large.head.packed
        inventory.large[start] = large
        inventory.pieces.add(Kind.LARGE, inventory.section, _make_row(start, end, counts)._replace(
            first_ns=first_ns, last_ns=last_ns, size=large.size))
