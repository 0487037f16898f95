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
The intact messages of a chunk that is too large to decompress at once.

They are read in blocks, as often as they are needed. So a file of some kilobytes that unpacks to
gigabytes takes no more memory than others.
"""

from __future__ import annotations

from functools import partial
from io import BufferedIOBase
from typing import Iterator, NamedTuple

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.chunks import begin_chunk, LargeChunk
from heading_intercompare.bags.mcap.fragments import ChunkHead, measure_leading
from heading_intercompare.bags.mcap.message_blocks import Block, HEAD


class Large(NamedTuple):
    """
    What a large chunk holds.

    Attributes
    ----------
    head
        What it says about itself.
    proved
        Its records have the size and the checksum in its head.
    size
        Bytes of intact records.
    decompressed
        Bytes of records that could be decompressed.
    messages
        Intact messages.

    """

    head: ChunkHead
    proved: bool
    size: int = 0
    decompressed: int = 0
    messages: int = 0


def _open(file: BufferedIOBase, at: int, end: int, head: ChunkHead) -> LargeChunk:
    """Return the chunk at a byte, up to byte `end`; BagError if its head is damaged."""
    file.seek(at + HEAD.size)
    return LargeChunk(file, begin_chunk(file, head.length).cut(end))


def find_fault(file: BufferedIOBase, at: int, head: ChunkHead) -> str:
    """Return why a large chunk at a byte is damaged; empty if it proves itself."""
    try:
        _open(file, at, at + HEAD.size + head.length, head).verify()
    except BagError as error:
        return error.problem
    return ''


def read_blocks(file: BufferedIOBase, at: int, end: int, large: Large) -> Iterator[Block]:
    """
    Yield the intact messages of a large chunk, block by block.

    Parameters
    ----------
    file : binary file
        Open for reading.
    at, end
        The first byte of the chunk, and the byte after what is left of it.
    large
        Its head, and whether it proved itself.

    """
    yield from _blocks(_open(file, at, end, large.head), large)


def _blocks(chunk: LargeChunk, large: Large) -> Iterator[Block]:
    times = None if large.proved else (large.head.first_ns, large.head.last_ns)
    try:
        yield from chunk.blocks(partial(measure_leading, times=times))
    except BagError:
        # The rest is damaged; a survey says how much that is.
        return


def survey(file: BufferedIOBase, at: int, end: int, head: ChunkHead, proved: bool) -> Large | None:
    """Return what a large chunk holds between two bytes; None if its head is damaged."""
    try:
        chunk = _open(file, at, end, head)
    except BagError:
        return None
    size = messages = 0
    for block in _blocks(chunk, Large(head, proved)):
        size += len(block.data)
        messages += len(block.start)
    return Large(head, proved, size, chunk.size, messages)
