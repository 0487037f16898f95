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
The pass through a damaged file: what is intact goes to the copier, and what is lost is counted.

Some things only the end of a file tells: definitions may stand after their messages, and messages
outside chunks may be the rest of a chunk. A copy that assumed something else is made again with a
plan that knows them.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Sequence

from mcap import records as mcap
from mcap.opcode import Opcode

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.chunk_runs import ChunkRun
from heading_intercompare.bags.mcap.message_blocks import (
    Block,
    ENTRY_BYTES,
    HEAD,
    INDEX_LEAST,
    Record,
)
from heading_intercompare.bags.mcap.record_stream import parse_record
from heading_intercompare.bags.packed_files import MOST_MESSAGE_BYTES, PlainFile
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.core.count_words import count_words

from .copier import Copier, define
from .definitions import Definitions, Section
from .recovered import Recovered
from .scanner import Gap, Part, Salvage, Sound
from .unreadable_sectors import open_with_holes


@dataclass(frozen=True, slots=True)
class Plan:
    """
    What a copy assumes of the files.

    Attributes
    ----------
    compression
        MCAP's name of the compression of most chunks.
    chunked
        Files whose messages outside chunks after damage are left out, because they have chunks.
    sections
        The definitions of each section; where none are, those before a message are all.

    """

    compression: str
    chunked: frozenset[Path] = frozenset()
    sections: Sequence[Definitions] = ()


class FileSalvage:
    """
    Copies the files of a bag one after the other.

    Parameters
    ----------
    bag
        The new bag.
    plan
        What is assumed of the files.
    compression
        Compression that chunks must have, by MCAP's name; None: they keep their own.
    unproven
        Also keep the possible messages of chunks whose checksum is wrong.

    Attributes
    ----------
    total
        What was kept and lost.
    worthwhile
        A file has metadata or attachments, or it is closed and without damage.
    earlier
        The metadata records `recovery` in the files, from earlier recoveries.

    """

    def __init__(self, bag: BagWriter, plan: Plan, *, compression: str | None,
                 unproven: bool) -> None:
        self._bag, self._plan, self._unproven = bag, plan, unproven
        self.total = Recovered()
        self._copier = Copier(bag, self.total, compression, self._note)
        self._sections: list[Section] = []
        self._chunked = set(plan.chunked)
        #: Compressed bytes of whole chunks, by compression.
        self._packed: Counter[str] = Counter()
        self.worthwhile = False
        self.earlier: list[dict[str, str]] = []

    def next_plan(self) -> Plan | None:
        """Return the plan with which a copy is right; None if this one is."""
        most = self._plan.compression
        if self._copier.compresses:
            most = max(self._packed, key=self._packed.__getitem__, default=most)
        if most == self._plan.compression and self._chunked == self._plan.chunked and all(
                section.settled for section in self._sections):
            return None
        return Plan(most, frozenset(self._chunked), [s.definitions for s in self._sections])

    def _note(self, text: str) -> None:
        self.total.note(self._path, text)

    def copy(self, source: PlainFile, holes: list[int], progress: Callable[[str], None]) -> None:
        """
        Copy the intact records of a file.

        Parameters
        ----------
        source
            The file.
        holes
            The unreadable blocks known so far; others are added.
        progress
            Called with the progress in words.

        Raises
        ------
        OSError
            If the file cannot be read or the bag cannot be written.
        BagError
            If the file becomes shorter while it is read.

        """
        with open_with_holes(source.place, holes) as file:
            self._path, self._salvage = source.path, Salvage(file, self._unproven)
            self._begun = self._doubtful = False
            self._gaps = self._chunk_gaps = self._chunks = self._misplaced = 0
            first = len(self._sections)
            self._begin_section()
            self._begin_index(chunk_lost=None)
            for item in self._salvage.scan():
                self._take(item)
                progress(f'{item.end / self._salvage.size:.0%} copied')
            self._end_index()
            if source.place.stat().st_size < self._salvage.size:
                raise BagError('has changed while it was read', source.path)
        if self._doubtful and self._salvage.chunked:
            self._chunked.add(source.path)
        self._sum_up(self._sections[first:])

    def _begin_section(self) -> None:
        definitions, number = Definitions(), len(self._sections)
        # A file that grows may have more sections than before.
        known = self._plan.sections[number:number + 1] or [definitions]
        self._sections.append(Section(known[0], definitions))

    def _begin_index(self, chunk_lost: bool | None, readable: int = 0) -> None:
        """
        Begin to count the messages that the indexes after a chunk name.

        Parameters
        ----------
        chunk_lost
            Whether the chunk is damaged; None: no chunk precedes them.
        readable
            Messages of a damaged chunk that can be read.

        """
        self._named, self._readable, self._chunk_lost = 0, readable, chunk_lost

    def _end_index(self) -> None:
        self._sections[-1].indexed += max(self._named - self._readable, 0)

    def _take_index(self, record: Record) -> None:
        head = self._salvage.content(record._replace(length=INDEX_LEAST))
        names = int.from_bytes(head[2:], 'little') // ENTRY_BYTES
        if names and self._chunk_lost is None:
            at, self._chunk_lost = record.start - HEAD.size, True
            self._damage(at, at, 'the chunk before its message indexes is missing', chunk=True)
        self._named += names if self._chunk_lost else 0

    def _damage(self, start: int, end: int, fault: str, *, chunk: bool,
                lost: float = 1.0) -> None:
        """Count a damaged stretch of bytes, a chunk or not, and a share of it as lost."""
        self._gaps += 1
        self._chunk_gaps += chunk
        self.total.chunks_lost += chunk
        self.total.bytes_lost += round(lost * (end - start))
        self._note(f'bytes {start} to {end}: {fault}')

    def _take(self, item: Sound | Gap) -> None:
        if isinstance(item, Sound) and item.record.opcode == Opcode.MESSAGE_INDEX:
            self._take_index(item.record)
            return
        self._end_index()
        self._begin_index(chunk_lost=None)
        if isinstance(item, Gap):
            self._damage(item.start, item.end, item.fault, chunk=item.chunk)
            self._begin_index(item.chunk)
            return
        if item.begins:
            # Only a header just after magic bytes begins another file; elsewhere it was torn.
            if self._begun:
                self._begin_section()
            self._begun = True
        if item.run is not None:
            self._take_run(item.run)
        elif item.part is not None:
            self._take_part(item.part, item.record.start - HEAD.size, item.end)
        elif item.block is not None:
            self._take_bare(item.block, item.record.start - HEAD.size, item.end)
        else:
            self._take_record(item.record)

    def _take_run(self, run: ChunkRun) -> None:
        """Take whole chunks."""
        self._begin_index(chunk_lost=False)
        self._chunks += len(run.chunks)
        for chunk in run.chunks:
            if chunk.counts:
                self._packed[chunk.compression] += chunk.packed
                head = self._salvage.heads.get(chunk.start)
                self._misplaced += head is None or (head.first_ns, head.last_ns, head.size) != (
                    chunk.first_ns, chunk.last_ns, chunk.size)
        self._copier.copy_run(run, self._salvage.file, self._sections[-1])

    def _take_part(self, part: Part, start: int, end: int) -> None:
        """Take a chunk that is large, cut or damaged."""
        section, readable = self._sections[-1], 0
        for block in part.blocks():
            define(section, block, slice(None), part.checked)
            self._copier.write(block, section)
            readable += len(block.start)
        self._chunks += 1
        self._begin_index(bool(part.fault), readable)
        if part.fault:
            self._damage(start, end, part.fault, chunk=True, lost=part.lost)
        else:
            self._packed[part.head.compression] += part.head.packed
        self.total.messages_unproven += readable if part.unproven else 0

    def _take_bare(self, block: Block, start: int, end: int) -> None:
        """Take messages or a definition outside chunks."""
        define(self._sections[-1], block, slice(None), False)
        if self._gaps and not self._chunks and len(block.start):
            if self._salvage.chunked or self._path in self._plan.chunked:
                # They may be the rest of a chunk whose head, with its checksum, is lost.
                self._damage(start, end, 'messages without their chunk', chunk=False)
                return
            self._doubtful = True
        self._copier.write(block, self._sections[-1])

    def _take_record(self, record: Record) -> None:
        opcode, section = record.opcode, self._sections[-1]
        if opcode == Opcode.STATISTICS:
            statistics = parse_record(mcap.Statistics, self._salvage.content(record))
            if statistics.channel_message_counts or not statistics.message_count:
                section.expected.append(statistics.message_count)
        elif opcode == Opcode.FOOTER:
            section.closed = True
        elif opcode == Opcode.METADATA:
            metadata = parse_record(mcap.Metadata, self._salvage.content(record))
            if metadata.name == 'recovery' and metadata.metadata not in self.earlier:
                self.earlier.append(metadata.metadata)
            if metadata.name not in ('recovery', 'rosbag2'):
                self.worthwhile = True
                self._bag.chunks.add_metadata(metadata.name, metadata.metadata)
        elif opcode == Opcode.ATTACHMENT:
            self._take_attachment(record)

    def _take_attachment(self, record: Record) -> None:
        start, end = record.start - HEAD.size, record.start + record.length
        try:
            data = bytearray(end - start)
        except MemoryError:
            self._note(f'bytes {start} to {end}: do not fit into memory')
            return
        self._salvage.file.seek(start)
        data[:] = self._salvage.file.read(len(data))
        self.worthwhile = True
        self._bag.chunks.append_attachment(data)

    def _sum_up(self, sections: Sequence[Section]) -> None:
        """Count what is lost of a file, and on its own of each file that was appended to it."""
        total, before = self.total, self.total.messages_lost
        total.files += 1
        total.bytes += self._salvage.size
        total.chunks += self._chunks
        for section in sections:
            self._sum_up_section(section)
        if total.messages_lost == before and self._chunk_gaps:
            # A chunk is lost but no message is missing: some messages are there twice.
            total.messages_known = False
        if self._misplaced and len(sections) == 1 and len(self._salvage.heads) == self._chunks:
            self._note(f'{self._misplaced} chunks are not the chunks that its index names in '
                       'their place')
        if mended := len(self._salvage.file.places):
            self._note(f'{count_words(mended, "chunk")} had a damaged head; the checksum proves '
                       'what it was')
        closed = all(section.closed for section in sections)
        if not self._salvage.size:
            self._note('is empty (0 bytes)')
        elif not closed:
            self._note('was not closed')
            total.messages_known = total.messages_known and not self._gaps
        self.worthwhile = self.worthwhile or closed and not self._gaps

    def _sum_up_section(self, section: Section) -> None:
        total, undefined, untimed = self.total, section.undefined, section.untimed
        if undefined:
            self._note(f'{undefined} messages of topics that are not defined, or defined in two '
                       'ways')
        for contradiction in section.definitions.contradictions:
            self._note(contradiction)
        if untimed:
            self._note(f'{untimed} messages with impossible log times')
        if section.unpackable:
            self._note(f'{section.unpackable} messages cannot be decompressed, or claim more than '
                       f'{MOST_MESSAGE_BYTES} bytes')
        seen = undefined + untimed
        lost = seen + section.indexed
        if len(section.expected) == 1:
            missing = section.expected[0] - section.copied - section.unpackable
            if missing > lost:
                self._note(f'{missing - lost} messages are missing, according to its summary')
            elif missing < 0:
                self._note(f'{-missing} messages more than its summary says')
            # Fewer than were seen to be lost: some messages are there twice, or an index is wrong.
            total.messages_known = total.messages_known and missing >= lost
            lost = max(missing, seen)
        elif self._gaps:
            total.messages_known = False
        total.messages_lost += lost + section.unpackable
