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

A record counts only if it proves itself: a chunk by its checksum, even if its opcode is wrong;
others by lengths that agree with each other and with the following record. After damage, the
scanner searches for the next record that proves itself.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from io import BufferedIOBase
from typing import Callable, Iterator

from mcap.opcode import Opcode
import zstandard

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.checksum import crc32
from heading_intercompare.bags.mcap.chunk_runs import ChunkRun, ChunkRuns
from heading_intercompare.bags.mcap.chunks import LARGE_BYTES, unpack
from heading_intercompare.bags.mcap.fragments import (
    BARE,
    CHUNK_BYTES,
    ChunkHead,
    decompress_begun,
    find_candidates,
    find_chunk_head,
    HEAD_BYTES,
    measure_leading,
    MESSAGE_LEAST,
)
from heading_intercompare.bags.mcap.index_records import (
    find_attached,
    is_disguised,
    is_formed,
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
from heading_intercompare.messages.byte_columns import BytesLike

from .large_chunks import find_fault, Large, survey
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
#: Bytes read ahead for small reads.
_AHEAD_BYTES = 2**18
#: Messages outside chunks are taken in pieces of this many bytes.
_BARE_BYTES = 2**20
#: After the searches have read this many times the size of the file, they skip candidates that
#: overlap an earlier one.
_PATIENCE = 8


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
        The messages and definitions in it.
    fault
        Why the block is only part of a chunk; empty if it is complete.
    run
        Consecutive chunks, each whole.
    large
        A chunk that is too large for a block, or what is intact of it.
    unproven
        Its checksum is wrong; its messages are possible, and nothing more is known of them.
    sure
        Up to this byte no other record can be hidden in it.
    begins
        It is the header of a file, just after the magic bytes.
    lost
        About how many of its bytes are missing from the block.

    """

    record: Record
    end: int
    block: Block | None = None
    fault: str = ''
    run: ChunkRun | None = None
    large: Large | None = None
    unproven: bool = False
    sure: int = 0
    begins: bool = False
    lost: int = 0


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
    size : int
        Size of the file in bytes.
    chunked : bool
        A chunk was seen so far, sound or damaged, or the index after one.

    """

    def __init__(self, file: BufferedIOBase, unproven: bool = False) -> None:
        self._file = file
        self._unproven = unproven
        self._stream = RecordStream(file)
        self.size = self._stream.size
        self._window, self._window_at = b'', 0
        self._runs = ChunkRuns(self._read, self.size)
        self._zstd = zstandard.ZstdDecompressor()
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
        if size > _AHEAD_BYTES:
            self._file.seek(at)
            return self._file.read(size)
        begin = at - self._window_at
        if begin < 0 or begin + size > len(self._window):
            self._file.seek(at)
            self._window, self._window_at, begin = self._file.read(_AHEAD_BYTES), at, 0
        return self._window[begin:begin + size]

    def scan(self) -> Iterator[Sound | Gap]:
        """Yield the parts of the file in file order; memory stays that of a few chunks."""
        at = unsure = 0
        begins = False
        while at < self.size:
            if self._read(at, len(MAGIC)) == MAGIC:
                at += len(MAGIC)
                begins = True
                continue
            part = self._sound(at) or self.unproved(at)
            if part is not None:
                unsure = part.sure
                at = self._next = part.end
                self._previous = part.record.opcode
                self.chunked = self.chunked or part.record.opcode in (
                    Opcode.CHUNK, Opcode.MESSAGE_INDEX)
                header = begins and part.record.opcode == Opcode.HEADER
                yield replace(part, begins=True) if header else part
            else:
                fault, chunk = self._fault, self._may_be_chunk(at)
                # What is left of it would look like messages outside chunks.
                self.chunked = self.chunked or find_chunk_head(
                    self._read(at, HEAD_BYTES)) is not None
                # The record before, if it has no checksum, may have swallowed a chunk.
                swallowed = self._search(unsure + 1, at, (Opcode.CHUNK,)) if unsure < at else at
                start = min(at, swallowed)
                at = swallowed if swallowed < at else self._find_next(at)
                unsure = at
                yield Gap(start, at, fault, chunk)
            begins = False

    def _may_be_chunk(self, at: int) -> bool:
        data = self._read(at, HEAD_BYTES)
        return data[:1] == bytes([Opcode.CHUNK]) or find_chunk_head(data) is not None

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
                or self._read(end, len(MAGIC)) == MAGIC
                or find_chunk_head(self._read(end, HEAD_BYTES)) is not None)

    def _is_cut_record(self, at: int) -> bool:
        """Tell whether a record of usual length may begin at a byte and be cut by the end."""
        head = self._read(at, HEAD.size)
        length = int.from_bytes(head[1:], 'little')
        return b'\1' <= head[:1] <= bytes([_HIGHEST]) and (
            len(head) < HEAD.size
            or length <= _USUAL_BYTES and at + HEAD.size + length > self.size)

    def _sound(self, at: int) -> Sound | None:
        """Return what is at a byte if it proves itself; otherwise set `_fault` to the reason."""
        try:
            return self._prove(at)
        except MemoryError:
            self._fault = 'a record does not fit into memory'
            return None

    def _prove(self, at: int) -> Sound | None:
        head = find_chunk_head(self._read(at, HEAD_BYTES))
        if head is not None:
            return self._chunks(at, head)
        record = self._head(at)
        if record is None:
            return None
        opcode, end = record.opcode, record.start + record.length
        if opcode == Opcode.CHUNK:
            self._fault = 'chunk damaged: its head does not agree with itself'
            return None
        if opcode == Opcode.MESSAGE:
            return self._messages(at, record)
        self._fault = 'a record is damaged'
        if opcode == Opcode.ATTACHMENT:
            return self._attachment(record)
        if opcode in _FORMED:
            good = is_formed(self._read, record)
        else:
            good = self._can_follow(end)
        if not good:
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
        data_at, end = find_attached(self._read, record), record.start + record.length
        if data_at is None:
            return None
        crc = int.from_bytes(self._read(end - 4, 4), 'little')
        # pybag computes it over the data only.
        whole = self._crc(record.start, end - 4)
        if whole is None or crc and crc not in (whole, self._crc(data_at, end - 4)):
            return None
        # If bytes of it are lost, the zeros may come from the head of the next chunk.
        return Sound(record, end, sure=end if crc else end - HEAD_BYTES)

    def _crc(self, at: int, end: int) -> int | None:
        """Return the checksum of the bytes [at, end); None if they cannot be read."""
        crc = 0
        while at < end and (piece := self._read(at, min(_WINDOW_BYTES, end - at))):
            crc, at = crc32(piece, crc), at + len(piece)
        return crc if at == end else None

    def _chunks(self, at: int, head: ChunkHead) -> Sound | None:
        """Return the intact chunks from a byte on, or the intact part of one."""
        end = at + HEAD.size + head.length
        if head.size > LARGE_BYTES:
            return self._large(at, head)
        if end > self.size:
            return self.fragment(at, self._search(at + 1, self.size, (Opcode.CHUNK,),
                                                  self._is_protected))
        run = self._runs.run(at)
        if run is None:
            return self.fragment(at, end)
        last = run.chunks[-1]
        return Sound(Record(Opcode.CHUNK, at + HEAD.size, head.length), last.index_end, run.block,
                     run=run, sure=last.index_end if last.indexed else last.end)

    def _is_protected(self, at: int) -> bool:
        """Tell whether a chunk with a correct checksum begins at a byte."""
        head = find_chunk_head(self._read(at, HEAD_BYTES))
        if head is not None and head.size > LARGE_BYTES:
            return bool(head.crc) and not find_fault(self._file, at, head)
        run = self._runs.run(at, at + 1)
        return run is not None and run.chunks[0].protected

    def _large(self, at: int, head: ChunkHead) -> Sound | None:
        """Return a large chunk, or the intact beginning of one that ends early."""
        end = at + HEAD.size + head.length
        fault = 'a chunk ends early'
        if end > self.size:
            end = self._search(at + 1, self.size, (Opcode.CHUNK,), self._is_protected)
            if end == self.size:
                fault = 'the file ends within a chunk'
        else:
            fault = find_fault(self._file, at, head)
            if fault and self._crc(at, end) is None:
                fault = 'the disk cannot read all of a chunk'
            elif fault:
                self._fault = fault
                return None
        large = survey(self._file, at, end, head, proved=not fault)
        if large is None or fault and head.first_ns > head.last_ns:
            self._fault = 'chunk damaged: its head does not agree with itself'
            return None
        if not fault and large.size < head.size:
            fault = 'chunk damaged: a record in it has a wrong length'
        length = end - at - HEAD.size
        lost = end - at - HEAD.size - length * large.size // max(large.decompressed, 1)
        return Sound(record=Record(Opcode.CHUNK, at + HEAD.size, length), end=end, block=None,
                     fault=fault, sure=end, lost=lost if fault else 0, large=large)

    def fragment(self, at: int, end: int) -> Sound | None:
        """Return the intact beginning of a chunk that ends early or has wrong records."""
        head = find_chunk_head(self._read(at, HEAD_BYTES))
        if head is None:
            return None
        content = self._read(at + HEAD.size, end - at - HEAD.size)
        data: BytesLike
        if len(content) < head.length:
            if head.first_ns > head.last_ns:
                self._fault = 'chunk damaged: its head does not agree with itself'
                return None
            data = decompress_begun(content)
            fault = ('the disk cannot read all of a chunk' if len(content) < end - at - HEAD.size
                     else 'the file ends within a chunk' if end == self.size
                     else 'a chunk ends early')
        else:
            try:
                data = unpack(content, self._zstd)
            except BagError as error:
                self._fault = error.problem
                return None
            fault = 'chunk damaged: a record in it has a wrong length'
        leading = measure_leading(data, (head.first_ns, head.last_ns))
        lost = end - at - (HEAD.size + len(content) * leading // len(data) if data else 0)
        return Sound(record=Record(Opcode.CHUNK, at + HEAD.size, len(content)), end=end,
                     block=block_of(data[:leading], at), fault=fault, sure=end, lost=lost)

    def unproved(self, at: int) -> Sound | None:
        """Return the possible messages of a chunk whose checksum is wrong, if they are wanted."""
        head = find_chunk_head(self._read(at, HEAD_BYTES)) if self._unproven else None
        if head is None or head.first_ns > head.last_ns:
            return None
        end = at + HEAD.size + head.length
        record = Record(Opcode.CHUNK, at + HEAD.size, head.length)
        fault = f'{self._fault}; what it holds is kept without proof'
        if end > self.size:
            return None
        if head.size > LARGE_BYTES:
            large = survey(self._file, at, end, head, proved=False)
            if large is None or not large.messages:
                return None
            return Sound(record=record, end=end, block=None, fault=fault, sure=end, large=large,
                         unproven=True)
        data = decompress_begun(self._read(at + HEAD.size, head.length))
        block = block_of(data[:measure_leading(data, (head.first_ns, head.last_ns))], at)
        if not len(block.start):
            return None
        lost = head.packed * (len(data) - len(block.data)) // len(data)
        return Sound(record=record, end=end, block=block, fault=fault, sure=end, lost=lost,
                     unproven=True)

    def _find_next(self, at: int) -> int:
        """Return where the next intact record begins after damage at a byte."""
        head = find_chunk_head(self._read(at, HEAD_BYTES))
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
            self._file.seek(at)
            window = self._file.read(step + HEAD.size - 1)
            places: list[int] = find_candidates(window, self.size - at, opcodes).tolist()
            for place in places:
                if self._read(at + place, len(MAGIC)) == MAGIC:
                    return at + place
                if at + place < barred:
                    continue
                if proof(at + place):
                    return at + place
                opcode, length = HEAD.unpack_from(window, place)
                if opcode in _CHECKED or opcode in SMALL:
                    length = min(length, self.size - at - place)
                    self._looked_at += length
                    if self._looked_at > _PATIENCE * self.size:
                        barred = at + place + length
            # A window ends at a block that the disk cannot read.
            at += min(step, len(window)) or HOLE_BYTES - at % HOLE_BYTES
        return end
