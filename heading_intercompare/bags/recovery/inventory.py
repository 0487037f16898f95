# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""A damaged file read once: what of it can be copied, which topics there are, what is lost."""

from __future__ import annotations

from array import array
from dataclasses import dataclass, field
from enum import IntEnum
from pathlib import Path
from typing import Callable, Iterator, NamedTuple

from mcap import records as mcap
from mcap.opcode import Opcode
import numpy as np

from heading_intercompare.bags.mcap.chunk_runs import Chunk, ChunkRun, count_messages, Counts
from heading_intercompare.bags.mcap.message_blocks import (
    Block,
    ENTRY_BYTES,
    HEAD,
    INDEX_LEAST,
    MESSAGE_HEAD,
)
from heading_intercompare.bags.mcap.record_stream import parse_record

from .channel_topics import Definitions
from .scanner import Gap, Salvage, Sound
from .unreadable_sectors import open_with_holes

__all__ = ['Damage', 'Inventory', 'Kind', 'Piece', 'Pieces', 'Section', 'split_epochs',
           'take_inventory']

_ROWS = 4096


class Kind(IntEnum):
    """What a piece is."""

    CHUNK = 0
    #: A chunk of which only the beginning is sound.
    FRAGMENT = 1
    #: Messages and definitions outside chunks.
    BARE = 2
    #: Metadata or an attachment.
    EXTRA = 3


class Piece(NamedTuple):
    """Something to copy, in the epoch of definitions in which it begins."""

    kind: Kind
    epoch: int
    chunk: Chunk


class Pieces:
    """The pieces of a file in their order, in little memory."""

    _WIDTH = 14

    def __init__(self) -> None:
        self._rows = array('q')
        self._things: list[object] = []
        self._places: dict[object, int] = {}

    def __len__(self) -> int:
        return len(self._rows) // self._WIDTH

    def _place(self, thing: object) -> int:
        place = self._places.setdefault(thing, len(self._things))
        if place == len(self._things):
            self._things.append(thing)
        return place

    def add(self, kind: Kind, epoch: int, chunk: Chunk) -> None:
        """Take the next."""
        (start, end, behind, first_ns, last_ns, size, crc, compression, packed, counts,
         definitions, plain, indexed, protected) = chunk
        self._rows.extend((
            kind, epoch, start, end, behind, first_ns, last_ns, size, crc,
            self._place(compression), packed, self._place(counts), self._place(definitions),
            4 * protected + 2 * plain + indexed))

    def drop(self, number: int) -> None:
        """Take one back, given its number; others keep theirs."""
        self._rows[number * self._WIDTH] = -1

    def __iter__(self) -> Iterator[Piece]:
        things, width = self._things, self._WIDTH
        for lo in range(0, len(self._rows), width * _ROWS):
            rows = np.array(self._rows[lo:lo + width * _ROWS], np.int64).reshape(-1, width)
            for row in rows.tolist():
                *whole, compression, packed, counts, definitions, flags = row
                if whole[0] >= 0:
                    yield Piece(Kind(whole[0]), whole[1], Chunk(
                        *whole[2:], things[compression], packed, things[counts],
                        things[definitions], bool(flags & 2), bool(flags & 1), flags > 3))


class Damage(NamedTuple):
    """Bytes with something wrong; `chunk`: it is one, `lost`: so many of them cannot be read."""

    start: int
    end: int
    fault: str
    chunk: bool
    lost: int


@dataclass(slots=True)
class Section:
    """
    A file, or one of several that were appended to each other.

    Attributes
    ----------
    epoch : int
        In which it begins.
    said : list of int
        Numbers of messages that its statistics name; there should be one.
    indexed : int
        Messages that indexes behind chunks name which are damaged or not there.
    untimed : int
        Messages with log times that cannot be.
    closed : bool
        It has an end.

    """

    epoch: int
    said: list[int] = field(default_factory=list)
    indexed: int = 0
    untimed: int = 0
    closed: bool = False


@dataclass(slots=True)
class Inventory:
    """
    What is in a file.

    Attributes
    ----------
    path : Path
        The file.
    size : int
        Its bytes.
    holes : list of int
        Where blocks begin that the disk cannot read.
    definitions : Definitions
        Its topics.
    pieces : Pieces
        What can be copied.
    counts : dict of tuple to int
        Messages by epoch and channel.
    chunks : int
        Chunks of which something can be copied.
    packed : dict of str to int
        Compressed bytes of whole chunks by compression.
    damage : list of Damage
        What is wrong.
    sections : list of Section
        The file, and those that were appended to it.
    begun : bool
        It has a beginning.
    extras : int
        Metadata and attachments.
    earlier : list of dict
        What was written into it when it was recovered itself.
    doubtful : list
        Numbers, epochs and rows of pieces that are only believed if there is no chunk.

    """

    path: Path
    size: int = 0
    holes: list[int] = field(default_factory=list)
    definitions: Definitions = field(default_factory=Definitions)
    pieces: Pieces = field(default_factory=Pieces)
    counts: dict[tuple[int, int], int] = field(default_factory=dict)
    chunks: int = 0
    packed: dict[str, int] = field(default_factory=dict)
    damage: list[Damage] = field(default_factory=list)
    sections: list[Section] = field(default_factory=lambda: [Section(0)])
    begun: bool = False
    extras: int = 0
    earlier: list[dict[str, str]] = field(default_factory=list)
    doubtful: list[tuple[int, int, Chunk]] = field(default_factory=list)

    @property
    def closed(self) -> bool:
        """Whether it has an end, and each file in it."""
        return all(section.closed for section in self.sections)

    def count(self, epoch: int, counts: Counts, sign: int = 1) -> None:
        """Count messages of channels."""
        for number, messages in counts:
            total = self.counts.get((epoch, number), 0) + sign * messages
            self.counts[epoch, number] = total
            if not total:
                del self.counts[epoch, number]

    def withdraw(self) -> None:
        """
        Leave out the messages outside chunks that came behind damage, for there are chunks.

        They may be what is left of a chunk without its head, and its checksum.
        """
        for number, epoch, row in self.doubtful:
            self.pieces.drop(number)
            self.count(epoch, row.counts, -1)
            self.damage.append(Damage(row.start, row.end, 'messages without their chunk', False,
                                      row.end - row.start))
        self.doubtful.clear()
        self.damage.sort()


def split_epochs(definitions: Definitions, start: int, epoch: int,
                 at: np.ndarray) -> Iterator[tuple[int, slice]]:
    """
    Yield the epochs within a chunk, and the messages of each.

    Parameters
    ----------
    definitions : Definitions
        Of the file.
    start : int
        First byte of the chunk.
    epoch : int
        In which it begins.
    at : ndarray of int64
        Where in its records the messages are.

    """
    lo = 0
    for offset, following in definitions.within(start):
        hi = int(np.searchsorted(at, offset))
        yield epoch, slice(lo, hi)
        epoch, lo = following, hi
    yield epoch, slice(lo, len(at))


def take_inventory(path: Path, progress: Callable[[str], None]) -> Inventory:
    """
    Read a file through.

    Parameters
    ----------
    path : Path
        The file.
    progress : callable
        Told how far.

    Raises
    ------
    OSError
        If it cannot be read.

    """
    found = Inventory(path)
    #: Behind a damaged chunk: messages that its indexes name, and those of it that can be read.
    named, kept = 0, 0
    #: Whether message indexes would be of a damaged chunk; None: there is no chunk before them.
    indexing: bool | None = None
    with open_with_holes(path, found.holes) as file:
        salvage = Salvage(file)
        found.size = salvage.size
        for item in salvage.scan():
            index = isinstance(item, Sound) and item.record.opcode == Opcode.MESSAGE_INDEX
            if index:
                names = (item.record.length - INDEX_LEAST) // ENTRY_BYTES
                if names and indexing is None:
                    at, indexing = item.record.start - HEAD.size, True
                    found.damage.append(Damage(at, at, 'the chunk before its message indexes is '
                                               'missing', True, 0))
                named += names if indexing else 0
                continue
            found.sections[-1].indexed += max(named - kept, 0)
            named, kept, indexing = 0, 0, None
            if isinstance(item, Gap):
                found.damage.append(Damage(item.start, item.end, item.fault, item.chunk,
                                           item.end - item.start))
                indexing = item.chunk
                continue
            if item.record.opcode == Opcode.CHUNK:
                indexing = False
            if item.fault:
                found.damage.append(Damage(item.record.start - HEAD.size, item.end, item.fault,
                                           True, item.lost))
                indexing, kept = True, len(item.block.start)
            _take(found, item, salvage)
            if item.block is not None:
                progress(f'{item.end / salvage.size:.0%} looked at')
    found.sections[-1].indexed += max(named - kept, 0)
    return found


def _take(found: Inventory, item: Sound, salvage: Salvage) -> None:
    opcode = item.record.opcode
    if item.begins:
        # Where a file does not begin with its header it was torn apart, not written to another.
        if found.begun:
            found.definitions.begin_file()
            found.sections.append(Section(found.definitions.epoch))
        found.begun = True
    if item.record.opcode == Opcode.CHUNK and found.doubtful:
        found.withdraw()
    if item.run is not None:
        _take_run(found, item.run)
    elif item.block is not None:
        kind = Kind.FRAGMENT if opcode == Opcode.CHUNK else Kind.BARE
        found.chunks += kind == Kind.FRAGMENT
        _define(found.definitions, item.block, slice(None), False, 0)
        log = item.block.heads['log_time'].copy()
        counts = count_messages(item.block.heads['channel'][log >= 0])
        found.sections[-1].untimed += int((log < 0).sum())
        found.count(found.definitions.epoch, counts)
        if counts:
            row = _outside(item.record.start - HEAD.size, item.end, counts)
            if kind == Kind.BARE and found.damage and not found.chunks:
                found.doubtful.append((len(found.pieces), found.definitions.epoch, row))
            found.pieces.add(kind, found.definitions.epoch, row)
    elif opcode == Opcode.STATISTICS:
        said = parse_record(mcap.Statistics, salvage.content(item.record))
        if said.channel_message_counts or not said.message_count:
            found.sections[-1].said.append(said.message_count)
    elif opcode == Opcode.FOOTER:
        found.sections[-1].closed = True
    elif opcode in (Opcode.METADATA, Opcode.ATTACHMENT):
        if opcode == Opcode.METADATA:
            metadata = parse_record(mcap.Metadata, salvage.content(item.record))
            if metadata.name == 'recovery':
                found.earlier.append(metadata.metadata)
            if metadata.name in ('recovery', 'rosbag2'):
                return
        found.extras += 1
        start = item.record.start - HEAD.size
        found.pieces.add(Kind.EXTRA, found.definitions.epoch, _outside(start, item.end, ()))


def _outside(start: int, end: int, counts: Counts) -> Chunk:
    """Return what is no whole chunk as a row of the table."""
    return Chunk(start, end, end, 0, 0, 0, 0, '', 0, counts, frozenset(), False, False, False)


def _define(definitions: Definitions, block: Block, which: slice, checked: bool, start: int,
            base: int = 0) -> None:
    """Take the definitions among other records of a block."""
    for record in block.others[which]:
        if record.opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            content = bytes(block.data[record.start:record.start + record.length])
            definitions.take(record.opcode, content, checked, (start, record.start - base))


def _take_run(found: Inventory, run: ChunkRun) -> None:
    """Take whole chunks."""
    definitions, block = found.definitions, run.block
    found.chunks += len(run.chunks)
    found.sections[-1].untimed += run.untimed
    behind = np.searchsorted([r.start - HEAD.size for r in block.others], run.bases).tolist()
    for i, chunk in enumerate(run.chunks):
        epoch = definitions.epoch
        if chunk.definitions:
            _define(definitions, block, slice(behind[i], behind[i + 1]), chunk.protected,
                    chunk.start, int(run.bases[i]))
        if definitions.epoch != epoch:
            mine = slice(run.edges[i], run.edges[i + 1])
            at = block.start[mine] - MESSAGE_HEAD.size - run.bases[i]
            timed = block.heads['log_time'][mine] >= 0
            channels = block.heads['channel'][mine]
            for each, part in split_epochs(definitions, chunk.start, epoch, at):
                found.count(each, count_messages(channels[part][timed[part]]))
        else:
            found.count(epoch, chunk.counts)
        if chunk.counts:
            found.packed[chunk.compression] = (found.packed.get(chunk.compression, 0)
                                               + chunk.packed)
            found.pieces.add(Kind.CHUNK, epoch, chunk)
