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
The intact records of an MCAP file, whatever happened to it.

A record counts only if it proves itself: a chunk by its checksum, even if its head is wrong;
others by lengths that agree with each other and with the following record. After damage, the
scanner searches for the next record that proves itself.
"""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, replace
from io import BufferedIOBase
from itertools import chain
from typing import Callable, Iterator

from mcap.opcode import Opcode

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.checksum import crc32
from heading_intercompare.bags.mcap.chunk_runs import ChunkRun, ChunkRuns
from heading_intercompare.bags.mcap.chunks import begin_chunk, LARGE_BYTES, LargeChunk
from heading_intercompare.bags.mcap.fragments import (
    BARE,
    CHUNK_BYTES,
    ChunkHead,
    find_candidates,
    find_chunk_head,
    HEAD_BYTES,
    measure_leading,
    MESSAGE_LEAST,
    possible_heads,
)
from heading_intercompare.bags.mcap.index_records import (
    find_attached,
    is_disguised,
    measure_fields,
    SMALL,
)
from heading_intercompare.bags.mcap.message_blocks import (
    Block,
    block_of,
    HEAD,
    MESSAGE_HEAD,
    Record,
)
from heading_intercompare.bags.mcap.record_stream import MAGIC, RecordStream

from .mended_file import MendedFile, read_chunk_heads
from .unreadable_sectors import HOLE_BYTES

_HIGHEST = int(Opcode.DATA_END)
#: MCAP leaves opcodes from here on to applications.
_PRIVATE = 0x80
#: Records whose fields say how long they are.
_FORMED = (*SMALL, Opcode.MESSAGE_INDEX, Opcode.DATA_END, Opcode.FOOTER)
#: Records with a checksum, and those whose lengths have to agree with each other.
_CHECKED = (Opcode.CHUNK, Opcode.ATTACHMENT)
_TELLING = (*_CHECKED, Opcode.HEADER, Opcode.METADATA, Opcode.MESSAGE_INDEX, Opcode.STATISTICS,
            Opcode.DATA_END, Opcode.FOOTER)
#: A record cut by the end of the file is believed only if it claims at most this length.
_USUAL_BYTES = 2**26
#: A search for records starts with the first window and grows it up to the second.
_FIRST_BYTES, _WINDOW_BYTES = 2**12, 2**22
#: Messages outside chunks are taken in pieces of this many bytes.
_BARE_BYTES = 2**20
#: After the searches have read this many times the size of the file, they skip candidates that
#: overlap an earlier one.
_PATIENCE = 8
_CONTRADICTS = 'chunk damaged: its head does not agree with itself'


class Part:
    """
    A chunk that is read block by block: it is large, or not all of it is intact.

    Parameters
    ----------
    chunk
        The chunk, or what is left of it.
    head
        What it says about itself.
    times
        First and last log time of its messages; None if it is proved.
    fault
        What is wrong with it.
    unproven
        Its checksum is wrong; its messages are possible, and nothing more is known of them.

    Attributes
    ----------
    size
        Bytes of intact records in the blocks so far.
    checked
        Its checksum is right.

    """

    def __init__(self, chunk: LargeChunk, head: ChunkHead, times: tuple[int, int] | None,
                 fault: str, unproven: bool) -> None:
        self._chunk, self._times = chunk, times
        self.head, self.fault, self.unproven = head, fault, unproven
        self.checked = head.crc > 0 and not fault
        self.size = 0
        self._blocks = self._read()
        self._begun = [next(self._blocks, None)]

    @property
    def empty(self) -> bool:
        """Whether not one record of it is intact."""
        return self._begun[0] is None

    @property
    def lost(self) -> float:
        """Return the share of its records that are not intact, once all blocks are read."""
        return 1.0 - self.size / max(self._chunk.size, 1)

    def blocks(self) -> Iterator[Block]:
        """Yield its intact messages; only once."""
        first = self._begun.pop()
        return chain(() if first is None else (first,), self._blocks)

    def _read(self) -> Iterator[Block]:
        try:
            for block in self._chunk.blocks(lambda data: measure_leading(data, self._times)):
                self.size += len(block.data)
                yield block
        except BagError:
            self.fault = self.fault or 'chunk damaged: a record in it has a wrong length'


@dataclass(frozen=True, slots=True)
class Sound:
    """
    Something that can be read.

    Attributes
    ----------
    record
        Its place; the first record of consecutive chunks, or of messages outside chunks.
    end
        The byte after it, and after the message indexes of consecutive chunks.
    block
        Messages and definitions outside chunks.
    run
        Consecutive chunks, each whole.
    part
        A chunk that is read block by block.
    sure
        Up to this byte no other record can be hidden in it.
    begins
        It is the header of a file, just after the magic bytes.

    """

    record: Record
    end: int
    block: Block | None = None
    run: ChunkRun | None = None
    part: Part | None = None
    sure: int = 0
    begins: bool = False


@dataclass(frozen=True, slots=True)
class Gap:
    """
    Bytes that cannot be read.

    Attributes
    ----------
    start, end
        The first byte, and the byte after the last.
    fault
        What is wrong at the first byte.
    chunk
        They begin with a chunk.

    """

    start: int
    end: int
    fault: str
    chunk: bool


class Salvage:
    """
    An open file that once was MCAP; never raises BagError.

    Parameters
    ----------
    file : binary file
        Open for reading, seekable.
    unproven
        Also keep the messages of chunks whose checksum is wrong, as far as they are possible.

    Attributes
    ----------
    file : MendedFile
        The same file, with the heads of chunks that their checksums prove.
    heads : dict
        What the index of the file says of its chunks, by place.
    size : int
        Size of the file in bytes.
    chunked : bool
        A chunk was seen so far, sound or damaged, or the index after one.

    """

    def __init__(self, file: BufferedIOBase, unproven: bool = False) -> None:
        self.file = MendedFile(file)
        self._unproven = unproven
        self._stream = RecordStream(self.file)
        self.size = self._stream.size
        self.heads = read_chunk_heads(self._stream)
        self._indexed = sorted(self.heads)
        self._runs = ChunkRuns(self._read, self.size)
        self.chunked = False
        self._previous = 0
        #: Where the record after the last one begins.
        self._next = 0
        self._fault = ''
        self._looked_at = 0

    def content(self, record: Record) -> bytes:
        """Return the bytes of a record after its head."""
        return self._stream.content(record)

    def _read(self, at: int, size: int) -> bytes:
        """Return `size` bytes of the file, fewer at its end or at a hole."""
        self.file.seek(at)
        return self.file.read(size)

    def scan(self) -> Iterator[Sound | Gap]:
        """Yield the parts of the file in file order; memory stays that of a few chunks."""
        at = unsure = 0
        begins = False
        while at < self.size:
            if self._read(at, len(MAGIC)) == MAGIC:
                at += len(MAGIC)
                begins = True
                continue
            sound = self._sound(at, awaited=True)
            if sound is not None:
                unsure = sound.sure
                at = self._next = sound.end
                self._previous = sound.record.opcode
                self.chunked = self.chunked or sound.record.opcode in (
                    Opcode.CHUNK, Opcode.MESSAGE_INDEX)
                header = begins and sound.record.opcode == Opcode.HEADER
                yield replace(sound, begins=True) if header else sound
            else:
                head = self._chunk_head(at)
                # What is left of it would look like messages outside chunks.
                self.chunked = self.chunked or head is not None
                chunk = head is not None or self._read(at, 1) == bytes([Opcode.CHUNK])
                fault = self._fault
                # The record before, if it has no checksum, may have swallowed a chunk.
                swallowed = self._search(unsure + 1, at, (Opcode.CHUNK,)) if unsure < at else at
                start = min(at, swallowed)
                at = swallowed if swallowed < at else self._find_next(at)
                unsure = at
                yield Gap(start, at, fault, chunk)
            begins = False

    def _chunk_head(self, at: int) -> ChunkHead | None:
        return find_chunk_head(self._read(at, HEAD_BYTES))

    def _head(self, at: int) -> Record | None:
        """Return the record at a byte if its head is possible and it ends within the file."""
        head = self._read(at, HEAD.size)
        if len(head) < HEAD.size:
            self._fault = ('a record ends early' if at + HEAD.size > self.size else
                           'the disk cannot read it')
            return None
        opcode, length = HEAD.unpack(head)
        end = at + HEAD.size + length
        if not (1 <= opcode <= _HIGHEST or opcode >= _PRIVATE):
            self._fault = 'no record begins' if any(head) else 'zero bytes'
        elif end > self.size:
            self._fault = 'a record ends early'
        else:
            return Record(opcode, at + HEAD.size, length)
        return None

    def _can_follow(self, end: int) -> bool:
        """Tell whether a record that ends at a byte is followed by something plausible."""
        return (end == self.size or self._head(end) is not None
                or self._read(end, len(MAGIC)) == MAGIC or self._chunk_head(end) is not None)

    def _is_cut_record(self, at: int) -> bool:
        """Tell whether a record of usual length may begin at a byte and be cut by the end."""
        head = self._read(at, HEAD.size)
        length = int.from_bytes(head[1:], 'little')
        return b'\1' <= head[:1] <= bytes([_HIGHEST]) and (
            len(head) < HEAD.size
            or length <= _USUAL_BYTES and at + HEAD.size + length > self.size)

    def _sound(self, at: int, awaited: bool = False) -> Sound | None:
        """
        Return what is at a byte if it proves itself; otherwise set `_fault` to the reason.

        Where a record is awaited, as the one before ends there, its head is mended if possible.
        """
        try:
            head = self._chunk_head(at)
            if head is not None or at in self.heads or awaited and (
                    self._read(at, 1) == bytes([Opcode.CHUNK])):
                chunk = self._chunk(at, head, awaited)
                if chunk is not None or head is not None:
                    return chunk
            return self._record(at)
        except MemoryError:
            self._fault = 'a record does not fit into memory'
            return None

    def _record(self, at: int) -> Sound | None:
        """Return a record that is no chunk, or messages outside chunks."""
        record = self._head(at)
        if record is None:
            return None
        opcode, end = record.opcode, record.start + record.length
        if opcode == Opcode.CHUNK:
            self._fault = _CONTRADICTS
            return None
        if opcode == Opcode.MESSAGE:
            return self._messages(at, record)
        self._fault = 'a record is damaged'
        if opcode == Opcode.ATTACHMENT:
            return self._attachment(record)
        fields = measure_fields(self._read, record) if opcode in _FORMED else 0
        if fields is None or fields < record.length and not self._can_follow(end):
            return None
        block = block_of(self._read(at, end - at), at) if opcode in BARE else None
        return Sound(record, end, block, sure=at)

    def _messages(self, at: int, record: Record) -> Sound | None:
        """Return messages outside chunks; a single one between chunks may be a wrong guess."""
        self._fault = 'a record is damaged'
        end = record.start + record.length
        if not MESSAGE_LEAST <= record.length <= CHUNK_BYTES or not (
                self._can_follow(end) or self._is_cut_record(end)):
            return None
        data = self._read(at, max(min(_BARE_BYTES, self.size - at), HEAD.size + record.length))
        size = last = count = 0
        while size + HEAD.size <= len(data):
            opcode, length = HEAD.unpack_from(data, size)
            behind = size + HEAD.size + length
            if opcode != Opcode.MESSAGE or length < MESSAGE_LEAST or behind > len(data):
                break
            last, size, count = size, behind, count + 1
        if not count:
            return None
        alone = (count == 1 and self.chunked and self._previous != Opcode.MESSAGE
                 and self._read(at + size, 1) != bytes([Opcode.MESSAGE]))
        if alone and (at != self._next or is_disguised(self._read, record)):
            return None
        if not (self._can_follow(at + size) or self._is_cut_record(at + size)):
            size = last
        block = block_of(data[:size], at)
        return Sound(record, at + size, block,
                     sure=at + int(block.start[-1]) - MESSAGE_HEAD.size)

    def _attachment(self, record: Record) -> Sound | None:
        """Return an attachment if its lengths and checksum agree."""
        attached, end = find_attached(self._read, record), record.start + record.length
        if attached is None or attached[1] + 4 < end and not self._can_follow(end):
            return None
        data_at, crc_at = attached
        crc = int.from_bytes(self._read(crc_at, 4), 'little')
        # pybag computes it over the data only.
        whole = self._crc(record.start, crc_at)
        if whole is None or crc and crc not in (whole, self._crc(data_at, crc_at)):
            return None
        # If bytes of it are lost, the zeros may come from the head of the next chunk.
        return Sound(record, end, sure=end if crc else end - HEAD_BYTES)

    def _crc(self, at: int, end: int) -> int | None:
        """Return the checksum of the bytes [at, end); None if they cannot be read."""
        crc = 0
        while at < end and (piece := self._read(at, min(_WINDOW_BYTES, end - at))):
            crc, at = crc32(piece, crc), at + len(piece)
        return crc if at == end else None

    def _chunk(self, at: int, head: ChunkHead | None, awaited: bool) -> Sound | None:
        """Return the intact chunks from a byte on, or the intact part of one."""
        run = self._run(at, head)
        if run is None and (awaited or at in self.heads) and not self._is_protected(at):
            head = self._mend(at) or head
            run = self._run(at, head)
        if head is None:
            return None
        record = Record(Opcode.CHUNK, at + HEAD.size, head.length)
        if run is None:
            return self._part(record, head, awaited and self._unproven)
        last = run.chunks[-1]
        return Sound(record, last.index_end, run.block, run,
                     sure=last.index_end if last.indexed else last.end)

    def _run(self, at: int, head: ChunkHead | None, end: int | None = None) -> ChunkRun | None:
        """Return the intact chunks from a byte on, up to byte `end`, unless the first is large."""
        if head is None or head.size > LARGE_BYTES or not self._ends_well(at, head):
            return None
        return self._runs.run(at, end)

    def _ends_well(self, at: int, head: ChunkHead) -> bool:
        """Tell whether the length of a chunk that has grown is right."""
        start = at + HEAD.size
        return head.needed == head.length or (
            self._can_follow(start + head.length) and not self._can_follow(start + head.needed))

    def _find_fault(self, at: int, head: ChunkHead) -> str:
        """Return why the records of a chunk are not those of its head; empty if they are."""
        try:
            self._open(at, head, self.size).verify()
        except BagError as error:
            return error.problem
        return '' if self._ends_well(at, head) else _CONTRADICTS

    def _open(self, at: int, head: ChunkHead, end: int) -> LargeChunk:
        """Return the chunk at a byte, up to byte `end`; BagError if its head is damaged."""
        self.file.seek(at + HEAD.size)
        return LargeChunk(self.file, begin_chunk(self.file, head.length).cut(end))

    def _is_protected(self, at: int) -> bool:
        """Tell whether a chunk with a correct checksum begins at a byte."""
        head = self._chunk_head(at)
        if head is None or not head.crc or at + HEAD.size + head.length > self.size:
            return False
        if head.size > LARGE_BYTES:
            return not self._find_fault(at, head)
        return self._run(at, head, at + 1) is not None

    def _mend(self, at: int) -> ChunkHead | None:
        """Return the head of a chunk that its checksum proves, if there is one."""
        for head in possible_heads(self._read(at, HEAD_BYTES), self.heads.get(at)):
            end = at + HEAD.size + head.length
            # A frame in a chunk that is too long would be right as well.
            if not self._can_follow(end) or self._looked_at > _PATIENCE * self.size:
                continue
            self._looked_at += head.length
            self.file.mend(at, head)
            if self._is_protected(at):
                return head
            self.file.mend(at, None)
        return None

    def _part(self, record: Record, head: ChunkHead, unproven: bool) -> Sound | None:
        """Return what is intact of a chunk that is large, cut, or damaged."""
        at, end = record.start - HEAD.size, record.start + record.length
        cut = end > self.size
        if cut:
            end = self._search(at + 1, self.size, (Opcode.CHUNK,), self._is_protected)
            fault = 'the file ends within a chunk' if end == self.size else 'a chunk ends early'
        else:
            fault = self._find_fault(at, head)
            if fault and self._crc(at, end) is None:
                cut, fault = True, 'the disk cannot read all of a chunk'
        self._fault = fault
        if fault and (head.first_ns > head.last_ns or not (cut or unproven)):
            self._fault = fault if not cut else _CONTRADICTS
            return None
        if fault and not cut:
            fault += '; what it holds is kept without proof'
        proved = not fault and (head.crc or head.size > LARGE_BYTES)
        try:
            part = Part(self._open(at, head, end), head, None if proved else (
                head.first_ns, head.last_ns), fault, unproven=bool(fault) and not cut)
        except BagError:
            self._fault = _CONTRADICTS
            return None
        self._fault = part.fault
        return None if part.empty else Sound(
            Record(Opcode.CHUNK, record.start, end - record.start), end, sure=end, part=part)

    def _find_next(self, at: int) -> int:
        """Return where the next intact record begins after damage at a byte."""
        head = self._chunk_head(at)
        if head is not None:
            end = at + HEAD.size + head.length
            if end <= self.size and self._can_follow(end):
                return end
        record = self._head(at)
        # Records inside an attached file are not records of this file.
        if record is not None and (
                record.opcode == Opcode.STATISTICS or record.opcode == Opcode.ATTACHMENT
                and find_attached(self._read, record) is not None):
            end = record.start + record.length
            is_opcode = self._read(end, 1) <= bytes([_HIGHEST])
            if end == self.size or is_opcode and self._sound(end) is not None:
                return end
        return self._search(at + 1, self.size,
                            _TELLING if self.chunked else (*_TELLING, *BARE))

    def _search(self, at: int, end: int, opcodes: tuple[int, ...],
                proof: Callable[[int], object] | None = None) -> int:
        """
        Return where in [at, end) one of these records first proves itself; `end` if nowhere.

        The proof is `_sound` unless another is given.
        """
        proof = proof or self._sound
        barred, window_bytes = 0, _FIRST_BYTES
        while at < end:
            step = min(window_bytes, end - at)
            window_bytes = min(4 * window_bytes, _WINDOW_BYTES)
            self.file.seek(at)
            window = self.file.read(step + HEAD.size - 1)
            for place in self._places(window, at, opcodes):
                if self._read(place, len(MAGIC)) == MAGIC:
                    return place
                if place < barred:
                    continue
                if proof(place):
                    return place
                opcode, length = HEAD.unpack_from(window, place - at)
                if opcode in _CHECKED or opcode in SMALL:
                    length = min(length, self.size - place)
                    self._looked_at += length
                    if self._looked_at > _PATIENCE * self.size:
                        barred = place + length
            # A window ends at a block that the disk cannot read.
            at += min(step, len(window)) or HOLE_BYTES - at % HOLE_BYTES
        return end

    def _places(self, window: bytes, at: int, opcodes: tuple[int, ...]) -> list[int]:
        """Return where records may begin in a window, which is at a byte of the file."""
        places = (find_candidates(window, self.size - at, opcodes) + at).tolist()
        first = bisect_left(self._indexed, at)
        indexed = self._indexed[first:bisect_left(
            self._indexed, at + len(window) - HEAD.size + 1)]
        return sorted({*places, *indexed}) if indexed else places
