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

"""A damaged file, some bytes of which are replaced by those that it had."""

from __future__ import annotations

from bisect import bisect_right, insort
from io import BufferedIOBase
import os

from mcap import records as mcap
from mcap.opcode import Opcode

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.fragments import ChunkHead, HEAD_BYTES
from heading_intercompare.bags.mcap.index_records import read_chunk_index
from heading_intercompare.bags.mcap.message_blocks import Record
from heading_intercompare.bags.mcap.record_stream import MAGIC, parse_record, RecordStream

_FOOTER_BYTES = 20


class MendedFile(BufferedIOBase):
    """
    A file, open for reading, with mended heads of chunks.

    Parameters
    ----------
    file : binary file
        Open for reading, seekable. It stays as it is.

    Attributes
    ----------
    places : list of int
        The first bytes of the heads mended so far, in order.

    """

    def __init__(self, file: BufferedIOBase) -> None:
        self._file = file
        self._heads: dict[int, bytes] = {}
        self.places: list[int] = []

    def mend(self, at: int, head: ChunkHead | None) -> None:
        """Replace the head of the chunk at a byte; None: leave it as it was."""
        if self._heads.pop(at, None) is not None:
            self.places.remove(at)
        if head is not None:
            self._heads[at] = head.build()
            insort(self.places, at)

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        return self._file.tell()

    def read(self, size: int | None = -1) -> bytes:
        at = self._file.tell() if self.places else 0
        data = self._file.read(size)
        if not self.places:
            return data
        first = bisect_right(self.places, at - HEAD_BYTES)
        for place in self.places[first:bisect_right(self.places, at + len(data))]:
            head, begin = self._heads[place], place - at
            shown = head[max(-begin, 0):max(len(data) - begin, 0)]
            begin = max(begin, 0)
            data = data[:begin] + shown + data[begin + len(shown):]
        return data


def read_chunk_heads(stream: RecordStream) -> dict[int, ChunkHead]:
    """Return the heads of chunks, by place, by the index at the end of a file, as far as it is."""
    heads: dict[int, ChunkHead] = {}
    at = stream.size - len(MAGIC) - _FOOTER_BYTES
    try:
        footer = parse_record(mcap.Footer, stream.content(Record(0, max(at, 0), _FOOTER_BYTES)))
        at = footer.summary_start or stream.size
        while at < stream.size:
            record = stream.record(at)
            if record.opcode == Opcode.CHUNK_INDEX:
                place, head, _ = read_chunk_index(stream.content(record))
                heads[place] = head
            at = record.start + record.length
    except BagError:
        pass
    return heads
