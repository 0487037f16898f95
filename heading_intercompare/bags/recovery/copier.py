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
The copier of intact chunks and messages into a bag.

A chunk is copied unchanged, still compressed, if its channels have the same numbers in the new
bag, its definitions are those of the new bag, and all its messages are wanted. Its message indexes
are copied too if they are right. The messages of other chunks are compressed again.
"""

from __future__ import annotations

from dataclasses import replace
from io import BufferedIOBase
from typing import Callable

from mcap.opcode import Opcode
import numpy as np

from heading_intercompare.bags.mcap.chunk_runs import Chunk, ChunkRun, count_messages, Counts
from heading_intercompare.bags.mcap.chunk_writer import Records
from heading_intercompare.bags.mcap.fragments import ChunkHead
from heading_intercompare.bags.mcap.index_records import message_index
from heading_intercompare.bags.mcap.message_blocks import are_timed, Block, HEAD, MESSAGE_HEAD
from heading_intercompare.bags.packed_files import is_packed, unpack_payload
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.core.records import Integers
from heading_intercompare.messages.byte_columns import BytesLike
from heading_intercompare.messages.fields import full_name

from .definitions import Section, Topic
from .recovered import Recovered

#: Offsets of the channel and the times in a message record.
_CHANNEL_AT, _LOG_AT, _PUBLISH_AT = 9, 15, 23


class Copier:
    """
    Copies chunks and messages into a bag, and counts the messages.

    Parameters
    ----------
    bag
        The new bag.
    total
        What is copied.
    compression
        Compression that chunks must have, by MCAP's name; None: they keep their own.
    note
        Called with a remark for anything notable.

    Attributes
    ----------
    compresses : bool
        Messages were compressed again.

    """

    def __init__(self, bag: BagWriter, total: Recovered, compression: str | None,
                 note: Callable[[str], None]) -> None:
        self._bag, self._total = bag, total
        self._compression, self._note = compression, note
        self._types: dict[str, tuple[tuple[str, str], bytes]] = {}
        self._numbers: dict[str, int] = {}
        self._names: dict[int, str] = {}
        self.compresses = False

    def _number(self, section: Section, channel: int) -> int:
        """Return the number in the new bag of a channel, -1 without topic."""
        if channel not in section.numbers:
            section.topics[channel] = topic = section.known.topic(channel)
            section.numbers[channel] = -1 if topic is None else self._add_topic(topic)
        return section.numbers[channel]

    def _add_topic(self, definition: Topic) -> int:
        """Add a topic to the new bag; return its number there."""
        channel, schema = definition
        topic = channel.topic if channel.topic.startswith('/') else f'/{channel.topic}'
        name, kind, data = topic, '', b''
        if schema is not None:
            kind = full_name(schema.name) if channel.message_encoding == 'cdr' else schema.name
            data = schema.data
        meaning = kind, channel.message_encoding
        while self._types.setdefault(name, (meaning, data))[0] != meaning:
            # A rosbag2 cannot hold one topic with two types: keep both, rename the second.
            name = f'{name}_{(kind or channel.message_encoding).rpartition("/")[2].lower()}'
        if name != topic:
            self._note(f'{topic} is also {kind or channel.message_encoding}: kept as {name}')
        elif self._types[name][1] != data:
            self._note(f'{topic}: {kind} is defined in two ways; the first is kept')
        if name not in self._numbers:
            self._numbers[name] = self._bag.add_channel(replace(channel, topic=name), schema, kind)
            self._names[self._numbers[name]] = name
        return self._numbers[name]

    def _count(self, section: Section, counts: Counts) -> None:
        """Count messages copied, by channel in the new bag."""
        for number, messages in counts:
            self._total.count(self._names[number], messages)
            section.copied += messages

    def copy_run(self, run: ChunkRun, file: BufferedIOBase, section: Section) -> None:
        """Copy whole chunks."""
        begins = [record.start - HEAD.size for record in run.block.others]
        behind = np.searchsorted(begins, run.bases).tolist()
        for i, chunk in enumerate(run.chunks):
            if chunk.definitions:
                define(section, run.block, slice(behind[i], behind[i + 1]), chunk.protected)
            if self._passes(chunk, section):
                self._pass_on(chunk, run, file, section)
            else:
                self.write(run.block, section, int(run.edges[i]), int(run.edges[i + 1]))

    def _passes(self, chunk: Chunk, section: Section) -> bool:
        """Tell whether a chunk can be copied unchanged: it means the same in the new bag."""
        if not (chunk.counts and chunk.plain and self._compression in (None, chunk.compression)
                and all(self._number(section, number) == number for number, _ in chunk.counts)
                and self._bag.chunks.defines(chunk.definitions)):
            return False
        self._bag.chunks.end_chunk()
        self._bag.split_if_due()
        return self._bag.chunks.can_begin_with(chunk)

    def _pass_on(self, chunk: Chunk, run: ChunkRun, file: BufferedIOBase,
                 section: Section) -> None:
        """Write a chunk unchanged, but with the values found for its head and its indexes."""
        file.seek(chunk.start)
        data = file.read((chunk.index_end if chunk.indexed else chunk.end) - chunk.start)
        head = ChunkHead(chunk.end - chunk.start - HEAD.size, chunk.first_ns, chunk.last_ns,
                         chunk.size, chunk.crc, chunk.compression, chunk.packed).build()
        if data[:len(head)] != head or not chunk.indexed:
            data = b''.join((head, data[len(head):],
                             b'' if chunk.indexed else _indexes(run, chunk)))
        self._bag.chunks.append(data, chunk)
        self._bag.split_if_due()
        self._count(section, chunk.counts)

    def write(self, block: Block, section: Section, lo: int = 0, hi: int | None = None) -> None:
        """Write the messages of a block that have a topic and a time, in order."""
        heads, stop = block.heads[lo:hi], block.stop[lo:hi]
        at = block.start[lo:hi] - MESSAGE_HEAD.size
        channel, log = heads['channel'].astype(np.int64), heads['log_time'].copy()
        present, places = np.unique(channel, return_inverse=True)
        new = np.array([self._number(section, number) for number in present.tolist()],
                       np.int64)[places]
        timed = are_timed(log)
        section.untimed += int((~timed).sum())
        section.undefined += int((new[timed] < 0).sum())
        writable = (new >= 0) & timed
        self._count(section, count_messages(new[writable]))
        data: BytesLike = block.data
        unsent = writable & (heads['publish_time'] < 0)
        if (new != channel)[writable].any() or unsent.any():
            data = bytearray(data)
            every = np.frombuffer(data, np.uint8)
            every[at[writable] + _CHANNEL_AT] = new[writable] & 255
            every[at[writable] + _CHANNEL_AT + 1] = new[writable] >> 8
            for byte in range(_PUBLISH_AT - _LOG_AT):
                every[at[unsent] + _PUBLISH_AT + byte] = every[at[unsent] + _LOG_AT + byte]
        if is_packed(block.data, block.start[lo:hi]):
            self._unpack(section, data, at[writable], stop[writable])
            return
        records = Records(data, at[writable], stop[writable], new[writable], log[writable])
        self.compresses = self.compresses or len(records) > 0
        place = 0
        while place < len(records):
            place = self._bag.chunks.fill(records, place)
            self._split_if_due()

    def _split_if_due(self) -> None:
        if not self._bag.chunks.pending:
            self._bag.split_if_due()

    def _unpack(self, section: Section, data: BytesLike, start: Integers, stop: Integers) -> None:
        """Write messages that are compressed one by one; count those that cannot be unpacked."""
        for at, end in zip(start.tolist(), stop.tolist()):
            _, _, number, sequence, log_ns, publish_ns = MESSAGE_HEAD.unpack_from(data, at)
            begin = at + MESSAGE_HEAD.size
            payload: bytes | None = bytes(data[begin:end])
            if is_packed(data, np.array([begin])):
                payload = unpack_payload(payload or b'')
            if payload is None:
                self._count(section, [(number, -1)])
                section.unpackable += 1
                continue
            self.compresses = True
            self._bag.chunks.add(number, payload, log_ns, publish_ns, sequence)
            self._split_if_due()


def define(section: Section, block: Block, which: slice, checked: bool) -> None:
    """Take the definitions among the other records of a block."""
    for record in block.others[which]:
        if record.opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            content = bytes(block.data[record.start:record.start + record.length])
            section.definitions.take(record.opcode, content, checked)


def _indexes(run: ChunkRun, chunk: Chunk) -> bytes:
    """Return the message indexes of a chunk of a run."""
    place = run.chunks.index(chunk)
    which = slice(int(run.edges[place]), int(run.edges[place + 1]))
    channel, log = run.block.heads['channel'][which].copy(), run.block.heads['log_time'][which]
    at = run.block.start[which] - MESSAGE_HEAD.size - run.bases[place]
    entries = np.stack((log, at), axis=1).astype('<i8')
    return b''.join([message_index(number, entries[channel == number].tobytes())
                     for number, _ in chunk.counts])
