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
The places of the messages in a stretch of MCAP records.

Messages of one length lie at a constant stride. For others, the message indexes after a chunk say
where they are. The indexes are believed only if the messages they name fill the chunk without a
gap. Otherwise the records are walked one by one.
"""

from __future__ import annotations

from dataclasses import dataclass
import struct
from typing import Callable, NamedTuple

from mcap.opcode import Opcode
import numpy as np

from heading_intercompare.bags.errors import BagError
from heading_intercompare.core.records import Integers
from heading_intercompare.messages.byte_columns import BytesLike, gather

#: Opcode and length of a record.
HEAD = struct.Struct('<BQ')
#: The same for a message, then channel, sequence, log time, publish time; the payload follows.
MESSAGE_HEAD = struct.Struct('<BQHIQQ')

#: Opcode and length of a message index, then channel and bytes of its entries.
INDEX_HEAD = struct.Struct('<BQHI')
#: Length of a message index without entries, and of an entry: log time and place of a message.
INDEX_LEAST, ENTRY_BYTES = INDEX_HEAD.size - HEAD.size, 16

_FIXED = MESSAGE_HEAD.size - HEAD.size
INVALID_OPCODE = 0
"""No record has it. Without this rule, gigabytes of zeros would be records without content."""

#: A file can number this many schemas and channels.
_MOST_DEFINITIONS = 2 * 2**16
#: Some writers define a channel again for each message.
_DEFINITIONS_OF_MESSAGE = 4
#: Most other records to skip before the first message.
_DEFINITIONS = 64
#: `MESSAGE_HEAD` as an array dtype.
MESSAGE_HEADS = np.dtype([('opcode', 'u1'), ('length', '<i8'), ('channel', '<u2'),
                          ('sequence', '<u4'), ('log_time', '<i8'), ('publish_time', '<i8')])


LAST_NS = 2**63 - 1
"""The latest possible time of a message, in 2262; in `MESSAGE_HEADS` later ones are negative."""


class Record(NamedTuple):
    """Opcode of a record, first byte after its head, and length of its content."""

    opcode: int
    start: int
    length: int


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """
    Messages that were read together.

    Attributes
    ----------
    offset
        Where the block starts in its file.
    data : bytes-like
        The records, decompressed.
    start, stop : ndarray of int64, shape (n,)
        First byte of each payload in `data`, and the byte after its last; in file order.
    heads : ndarray, shape (n,)
        Fields channel, sequence, log_time, publish_time of each message; times in nanoseconds.
        They may be a strided view of `data`: copy a field that is used more than once.
    others
        The records that are not messages.

    """

    offset: int
    data: BytesLike
    start: Integers
    stop: Integers
    heads: np.ndarray
    others: tuple[Record, ...]


def are_timed(log_time_ns: Integers) -> np.ndarray:
    """Tell which log times are possible: none is after `LAST_NS`."""
    return log_time_ns >= 0


def refuse_untimed(block: Block, locate: Callable[[int], int]) -> None:
    """
    Raise BagError if a message has an impossible log time.

    Parameters
    ----------
    block
        The messages.
    locate
        Returns the byte of the file to name, given the first byte of the record in the block.

    """
    untimed = np.flatnonzero(~are_timed(block.heads['log_time']))
    if untimed.size:
        raise BagError('a message that `recover` leaves out has an impossible log time',
                       offset=locate(int(block.start[untimed[0]]) - MESSAGE_HEAD.size))


def _most_definitions(messages: int) -> int:
    return max(_MOST_DEFINITIONS, _DEFINITIONS_OF_MESSAGE * messages)


def refuse_definitions(others: int, messages: int) -> None:
    """Raise BagError for more other records than messages need, which would fill the memory."""
    if others > _most_definitions(messages):
        raise BagError('too many records that are no messages')


def walk(data: BytesLike, begin: int, end: int, definitions: float = _MOST_DEFINITIONS
         ) -> tuple[list[int], list[Record]]:
    """
    Return message offsets and the other records; BagError unless they end at `end`.

    More other records are refused than `definitions` and than the messages need.
    """
    messages, others = [], []
    unpack, message = HEAD.unpack_from, int(Opcode.MESSAGE)
    at = begin
    while at < end:
        if at + HEAD.size > end:
            raise BagError('a record ends early', offset=at)
        opcode, length = unpack(data, at)
        behind = at + HEAD.size + length
        if behind > end or (opcode == message and length < _FIXED):
            raise BagError(f'a record of type {opcode} has a wrong length', offset=at)
        if opcode == message:
            messages.append(at)
        else:
            if opcode == INVALID_OPCODE:
                raise BagError('a record of type 0', offset=at)
            others.append(Record(opcode, at + HEAD.size, length))
            if len(others) > max(definitions, _DEFINITIONS_OF_MESSAGE * len(messages)):
                raise BagError('too many records that are no messages')
        at = behind
    return messages, others


def passed_block(head: bytes, offset: int) -> Block:
    """Return a message as a block from its head alone: its payload is empty."""
    at = np.array([len(head)])
    return Block(offset, head, at, at, np.frombuffer(head, MESSAGE_HEADS), ())


def find_passed(block: Block) -> np.ndarray:
    """Tell which messages of a block were passed over, because of their size."""
    passed: np.ndarray = block.heads['length'] - _FIXED != block.stop - block.start
    return passed


def measure_whole(data: BytesLike, opcodes: tuple[int, ...] | None = None) -> int:
    """Return the size of the whole records of some or all opcodes at the start of the data."""
    at = 0
    while at + HEAD.size <= len(data):
        opcode, length = HEAD.unpack_from(data, at)
        behind = at + HEAD.size + length
        if (opcode == INVALID_OPCODE or opcodes is not None and opcode not in opcodes
                or behind > len(data)):
            break
        at = behind
    return at


#: Offsets of messages, their heads, the bytes after their ends, other records.
_Layout = tuple[Integers, np.ndarray, Integers, list[Record]]


def _find_regular(data: BytesLike) -> _Layout | None:
    """Return messages of one length that follow the definitions; None if the data differs."""
    others: list[Record] = []
    at = opcode = length = 0
    while at + MESSAGE_HEAD.size <= len(data) and len(others) < _DEFINITIONS:
        opcode, length = HEAD.unpack_from(data, at)
        if opcode in (Opcode.MESSAGE, INVALID_OPCODE):
            break
        others.append(Record(opcode, at + HEAD.size, length))
        at += HEAD.size + length
    stride = HEAD.size + length
    if opcode != Opcode.MESSAGE or length < _FIXED or (len(data) - at) % stride:
        return None
    heads = np.ndarray((len(data) - at) // stride, MESSAGE_HEADS, data, at, (stride,))
    # Every opcode and length must equal the first: compare eight bytes, then the ninth.
    begun = np.ndarray(len(heads), '<u8', data, at, (stride,))
    ninth = np.ndarray(len(heads), 'u1', data, at + 8, (stride,))
    if (begun != begun[0]).any() or ninth.any():
        return None
    first = np.arange(at, len(data), stride)
    return first, heads, first + stride, others


def _follow_index(data: BytesLike, at: Integers) -> _Layout | None:
    """Return the messages that the index names; None if it misses or misplaces one."""
    at = np.sort(at, kind='stable')
    if not at.size or at[0] < 0 or at[-1] > len(data) - MESSAGE_HEAD.size:
        return None
    heads = gather(data, MESSAGE_HEADS, at)
    length = heads['length'].copy()
    behind = at + length + HEAD.size
    ahead = np.append(at[1:], len(data))
    if (length.min() < _FIXED or length.max() > len(data) or (behind > ahead).any()
            or (heads['opcode'] != Opcode.MESSAGE).any()):
        return None
    others: list[Record] = []
    # Before each hole lie this many messages.
    holes = [(0, 0, int(at[0]))] if at[0] else []
    for number in np.flatnonzero(behind != ahead).tolist():
        holes.append((number + 1, int(behind[number]), int(ahead[number])))
    for before, begin, end in holes:
        try:
            messages, definitions = walk(data, begin, end, _most_definitions(before) - len(others))
        except BagError:
            # The index may name a message within the payload of another.
            return None
        if messages:
            return None
        others += definitions
    return at, heads, behind, others


def block_of(data: BytesLike, offset: int,
             index: Callable[[], Integers | None] = lambda: None) -> Block:
    """
    Return the messages in decompressed records.

    Parameters
    ----------
    data : bytes-like
        Whole records.
    offset
        Where they start in their file.
    index
        Returns offsets of messages in `data`, int64 in any order, or None. It is called only if
        they are needed. Wrong offsets cost time but do no harm.

    Raises
    ------
    BagError
        If the records do not fill `data`; its offset is `offset`.

    """
    try:
        layout = _find_regular(data)
        if layout is None and (offsets := index()) is not None:
            layout = _follow_index(data, offsets)
        if layout is None:
            messages, others = walk(data, 0, len(data))
            at = np.array(messages, np.int64)
            heads = gather(data, MESSAGE_HEADS, at)
            layout = at, heads, at + HEAD.size + heads['length'], others
    except BagError as error:
        raise BagError(f'chunk damaged: {error.problem}', offset=offset) from None
    at, heads, behind, others = layout
    return Block(offset, data, at + MESSAGE_HEAD.size, behind, heads, tuple(others))
