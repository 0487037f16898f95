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

"""The hash chain through the chunks of a bag, which its writer and its readers compute alike."""

from __future__ import annotations

from dataclasses import dataclass
from hashlib import sha256
from io import BufferedReader, FileIO
from pathlib import Path
from typing import Iterator, Protocol

from mcap.opcode import Opcode

from heading_intercompare.bags.errors import BagError

from .message_blocks import HEAD, Record
from .record_stream import MAGIC, RecordStream

_PIECE_BYTES = 1 << 20


class ChunkHash(Protocol):
    """The SHA-256 of the record of a chunk, which `hashlib` makes."""

    def hexdigest(self) -> str:
        """Return the SHA-256 in hexadecimal digits."""


@dataclass(frozen=True, slots=True)
class ChunkChain:
    """
    The chain after some chunks of a bag; at first that before any chunk.

    Attributes
    ----------
    chunks
        Number of chunks, over all files of the bag in order.
    sha256
        64 zeros before the first chunk. After it the SHA-256 of: the value before, a space, and
        the SHA-256 of the record of the chunk as it is in the file, both in hexadecimal digits.

    """

    chunks: int = 0
    sha256: str = '0' * 64

    def after(self, chunk: ChunkHash) -> ChunkChain:
        """Return the chain after one more chunk, given the SHA-256 of its record."""
        text = f'{self.sha256} {chunk.hexdigest()}'
        return ChunkChain(self.chunks + 1, sha256(text.encode()).hexdigest())


def hash_record(stream: RecordStream, record: Record) -> ChunkHash:
    """Return the SHA-256 of a whole record of a file, read piece by piece."""
    digest = sha256()
    start, stop = record.start - HEAD.size, record.start + record.length
    for at in range(start, stop, _PIECE_BYTES):
        digest.update(stream.content(Record(0, at, min(_PIECE_BYTES, stop - at))))
    return digest


def hash_chunks(path: Path) -> Iterator[ChunkHash]:
    """
    Yield the SHA-256 of each chunk of an MCAP file, up to where the file breaks off.

    Raises
    ------
    OSError
        If the file cannot be read.

    """
    with BufferedReader(FileIO(path), _PIECE_BYTES) as file:
        stream = RecordStream(file)
        at = len(MAGIC)
        while at < stream.size:
            try:
                record = stream.record(at)
            except BagError:
                return
            if record.opcode == Opcode.DATA_END:
                return
            if record.opcode == Opcode.CHUNK:
                yield hash_record(stream, record)
            at = record.start + record.length
