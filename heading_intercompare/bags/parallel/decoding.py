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

"""Decoding of the headings in stretches of the files of a bag."""

from __future__ import annotations

from contextlib import ExitStack
from functools import partial
from typing import Callable, Iterable, Iterator, Mapping, NamedTuple, Sequence

import numpy as np

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.mcap_file import Part, Stretch
from heading_intercompare.bags.mcap.message_blocks import Block
from heading_intercompare.bags.mcap.record_stream import RecordStream
from heading_intercompare.bags.packed_files import is_packed, unpack_payloads
from heading_intercompare.core.records import Headings, Integers, Quality
from heading_intercompare.messages.byte_columns import BytesLike, decode_readable
from heading_intercompare.messages.heading_claims import find_claims
from heading_intercompare.messages.heading_messages import decode_headings
from heading_intercompare.messages.schemas import layout_problem

#: At most this many bytes of records, and this many messages, are decoded at once.
_MOST_BYTES = 2**26
_MOST_MESSAGES = 2**20


class Kind(NamedTuple):
    """
    Topics decoded alike: their type and convention, and the index of each by name.

    `claiming` are the indexes of those whose claims are read too.
    """

    type_name: str
    convention: str
    places: Mapping[str, int]
    claiming: Sequence[int] = ()


class Found(NamedTuple):
    """
    Headings of a kind in file order: log time in ns, index of the topic, number, reading.

    `unreadable` is the number of messages that cannot be read, and what is wrong with one.
    `claims` is what messages claim of their readings, each with the index of its topic.
    """

    log_time_ns: Integers
    place: np.ndarray
    sequence: np.ndarray
    headings: Headings
    unreadable: tuple[int, str] = (0, '')
    claims: tuple[tuple[int, Quality], ...] = ()

    @classmethod
    def concatenate(cls, parts: Sequence['Found']) -> 'Found':
        """Return the headings of at least one part, one after the other."""
        if len(parts) == 1:
            return parts[0]
        log_time_ns, place, sequence = (np.concatenate(column)
                                        for column in list(zip(*parts))[:3])
        return cls(log_time_ns, place, sequence,
                   Headings.concatenate([part.headings for part in parts]),
                   add_unreadable(part.unreadable for part in parts),
                   tuple(claims for part in parts for claims in part.claims))

    def take(self, rows: Integers) -> 'Found':
        """Return some of the headings."""
        return self._replace(log_time_ns=self.log_time_ns[rows], place=self.place[rows],
                             sequence=self.sequence[rows], headings=self.headings[rows])


def add_unreadable(counts: Iterable[tuple[int, str]]) -> tuple[int, str]:
    """Return a total number of unreadable messages, and what is wrong with the first."""
    counts = list(counts)
    return sum(n for n, _ in counts), next((problem for _, problem in counts if problem), '')


def order_by_time(readings: Found) -> Found:
    """
    Return headings with each topic in the order of its log times if more stamps rise in it.

    The clock of a recorder may go back while the clocks of the sensors go on. Then the headings
    stay as found.
    """
    log_time_ns, stamp_ns = readings.log_time_ns, readings.headings.stamp_ns
    if (log_time_ns[1:] >= log_time_ns[:-1]).all():
        return readings
    rows = np.arange(len(log_time_ns))
    for place in np.unique(readings.place):
        mine = np.flatnonzero(readings.place == place)
        ordered = mine[np.argsort(log_time_ns[mine], kind='stable')]
        if count_falls(stamp_ns[ordered]) < count_falls(stamp_ns[mine]):
            rows[mine] = ordered
    return readings.take(rows)


def count_falls(stamp_ns: Integers) -> int:
    """Return how many stamps are earlier than the one before."""
    return int((stamp_ns[1:] < stamp_ns[:-1]).sum())


class Decoded(NamedTuple):
    """A block: the number of its messages, of all topics, and its headings by kind."""

    messages: int
    found: list[Found]


def find_channel_problem(part: Part, number: int, type_name: str) -> str | None:
    """Return why the messages of a channel cannot be read as headings of a type; None if so."""
    channel = part.channels[number]
    if channel.message_encoding != 'cdr':
        return f'its messages are encoded as {channel.message_encoding!r}, not cdr'
    schema = part.schemas.get(channel.schema_id)
    if schema is None:
        return 'its channel has no schema'
    return layout_problem(type_name, schema.encoding, schema.data.decode(errors='replace'))


def _find_headings(block: Block, kind: Kind, place_of: np.ndarray,
                   strange: Mapping[int, str]) -> Found:
    """
    Return the headings in a block.

    Parameters
    ----------
    block
        Messages that were read together.
    kind
        The topics to find; all are decoded alike.
    place_of : ndarray of int16
        The topic index of each channel, or -1.
    strange
        Channels of these topics that cannot be read, and why.

    """
    place = place_of[block.heads['channel']]
    which: slice | Integers = slice(None)
    if place.size and place.min() < 0:
        which = np.flatnonzero(place >= 0)
        place = place[which]
    heads = block.heads[which]
    log_time_ns = heads['log_time'].copy()
    data, start, stop = block.data, block.start[which], block.stop[which]
    if is_packed(data, start):
        data, start, stop = unpack_payloads(data, start, stop)
    is_strange = np.isin(heads['channel'], [*strange]) if strange else None
    headings, unreadable = _decode(
        partial(decode_headings, kind.type_name, kind.convention, data), start, stop,
        log_time_ns, is_strange, next(iter(strange.values()), ''))
    return order_by_time(Found(
        log_time_ns, place, heads['sequence'].copy(), headings, unreadable,
        tuple(_find_claims(kind, place, data, start, stop, is_strange))))


def _find_claims(kind: Kind, place: np.ndarray, data: BytesLike, start: Integers, stop: Integers,
                 is_strange: np.ndarray | None) -> Iterator[tuple[int, Quality]]:
    """Yield what the readable messages of each topic claim of their headings."""
    claims = find_claims(kind.type_name, '') if kind.claiming else None
    if claims is None:
        return
    for topic in kind.claiming:
        is_mine = place == topic if is_strange is None else (place == topic) & ~is_strange
        mine = np.flatnonzero(is_mine)
        if claims.are_alike(data, start[mine], stop[mine]):
            mine = mine[[0, -1]]
        rows, _, _ = decode_readable(partial(claims.decode, data), start[mine], stop[mine])
        if len(rows):
            yield topic, rows.without_repeats()


def _decode(decode: Callable[[Integers, Integers], Headings], start: Integers, stop: Integers,
            log_time_ns: Integers, is_strange: np.ndarray | None,
            why_strange: str) -> tuple[Headings, tuple[int, str]]:
    """
    Return the readings in some messages of a block; count the unreadable messages, and say why.

    An unreadable message is an invalid reading at its log time, which is all that is known of it.
    """
    if is_strange is None:
        headings, readable, problem = decode_readable(decode, start, stop)
        if not problem:
            return headings, (0, '')
    else:
        readable = ~is_strange
        headings, within, problem = decode_readable(decode, start[readable], stop[readable])
        if not readable.all():
            problem = problem or why_strange
        readable[readable] = within
    stamp_ns, heading_deg = log_time_ns.copy(), np.full(len(log_time_ns), np.nan)
    stamp_ns[readable], heading_deg[readable] = headings.stamp_ns, headings.heading_deg
    return Headings(stamp_ns, heading_deg), (int((~readable).sum()), problem)


class Decoder:
    """
    Reads headings from files, one file open at a time.

    Parameters
    ----------
    parts
        The files; a file is identified by its index.
    kinds
        The topics to read.

    """

    def __init__(self, parts: Sequence[Part], kinds: Sequence[Kind]) -> None:
        self.parts = parts
        self._kinds = kinds
        self._number = -1
        self._file = ExitStack()

    def __enter__(self) -> 'Decoder':
        return self

    def __exit__(self, *exc: object) -> None:
        self._number = -1
        self._file.close()

    def _open(self, number: int) -> RecordStream:
        if number != self._number:
            self.__exit__()
            part = self.parts[number]
            self._stream = self._file.enter_context(part.open())
            self._places = [np.full(2**16, -1, np.int16) for _ in self._kinds]
            self._strange: list[dict[int, str]] = [{} for _ in self._kinds]
            for channel in part.channels:
                for kind, place_of, strange in zip(self._kinds, self._places, self._strange):
                    place_of[channel] = kind.places.get(part.channels[channel].topic, -1)
                    if place_of[channel] >= 0 and (
                            problem := find_channel_problem(part, channel, kind.type_name)):
                        strange[channel] = problem
            self._number = number
        return self._stream

    def blocks(self, number: int, begin: int, end: int | None = None) -> Iterator[Decoded]:
        """
        Yield the blocks between two bytes of a file, or up to its end.

        Raises
        ------
        OSError, BagError
            If a block cannot be read; the blocks before it have been yielded.

        """
        part = self.parts[number]
        for block in part.blocks_of(self._open(number), begin, end):
            yield Decoded(len(block.start), [_find_headings(block, *kind) for kind in zip(
                self._kinds, self._places, self._strange)])

    def stretch(self, number: int, stretch: Stretch) -> list[Decoded] | None:
        """Return the blocks of a stretch; None if it is damaged or too large to hold in memory."""
        if stretch.size > _MOST_BYTES:
            return None
        decoded, count = [], 0
        try:
            for block in self.blocks(number, stretch.begin, stretch.end):
                decoded.append(block)
                count += block.messages
                if count > _MOST_MESSAGES:
                    return None
        except (BagError, OSError):
            return None
        return decoded
