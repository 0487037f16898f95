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

"""The reader of bags: topics, headings by the minute, messages, metadata and attachments."""

from __future__ import annotations

from contextlib import closing
from copy import deepcopy
from dataclasses import dataclass
from itertools import groupby
import os
from pathlib import Path
from typing import Callable, Collection, Iterable, Iterator, Mapping, NamedTuple, Sequence

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.chunks import RECORD_BYTES
from heading_intercompare.bags.mcap.mcap_file import NeverBegun, Part
from heading_intercompare.bags.mcap.message_blocks import Block, find_passed
from heading_intercompare.bags.packed_files import is_packed, unpack_payload, unpack_payloads
from heading_intercompare.bags.parallel.by_minute import Window
from heading_intercompare.bags.parallel.decode_workers import (
    can_fork,
    decode_stretches,
    run_ahead,
    Task,
)
from heading_intercompare.bags.parallel.decoding import (
    add_unreadable,
    Decoded,
    Decoder,
    find_channel_problem,
    Found,
    Kind,
)
from heading_intercompare.bags.parallel.reading_order import (
    cut_pieces,
    is_in_order,
    merge_by_time,
    Piece,
    read_by_time,
    rises_by_time,
)
from heading_intercompare.core.records import Headings, Integers, Losses, Quality
from heading_intercompare.messages.byte_columns import BytesLike
from heading_intercompare.messages.fields import full_name
from heading_intercompare.messages.heading_messages import HEADING_TYPES

from .bag_files import find_files
from .bag_yaml import Qos
from .provenance import RECORD
from .publisher_starts import KnownStarts, read_starts
from .sequence_gaps import Numbering
from .topic_names import clean_namespace, find_topic, list_topics, locate_in, read_namespace

#: Records of the programs that keep the numbers of the publishers. Others may number the messages
#: of all topics together, or in any other way.
_NUMBERED_BY = (RECORD, 'rosbag2')
_DISORDER = ('its chunks are not in the order of time; its readings are read in the order of '
             'their log times')


@dataclass(frozen=True, slots=True)
class TopicInfo:
    """
    What a bag says about a topic.

    Attributes
    ----------
    type_name
        Message type, as package/msg/Type.
    count
        Number of messages.
    qos
        The QoS its publisher offered; the default of `Qos` where the bag does not say.

    """

    type_name: str
    count: int
    qos: Qos = Qos()


class BagMessage(NamedTuple):
    """One message as it is stored; times in nanoseconds."""

    topic: str
    type_name: str
    log_time_ns: int
    publish_time_ns: int
    sequence: int
    data: bytes


class Payloads(NamedTuple):
    """
    Messages of a topic that were read together.

    Attributes
    ----------
    data : bytes-like
        Bytes that hold the messages.
    start, stop : ndarray of int64, shape (n,)
        First byte of each message, and the byte after its last.
    log_time_ns, publish_time_ns : ndarray of int64, shape (n,)
        Times of each message, nanoseconds.

    """

    data: BytesLike
    start: Integers
    stop: Integers
    log_time_ns: Integers
    publish_time_ns: Integers


@dataclass(frozen=True, slots=True)
class Attachment:
    """A file inside the bag."""

    name: str
    media_type: str
    log_time_ns: int
    data: bytes


def _open_files(path: Path, oddities: list[str]) -> tuple[list[Part], list[str]]:
    """Return the files of a bag in order, and why some files are missing; say what else is odd."""
    files = find_files(path)
    oddities += files.oddities
    parts, refused = [], []
    for file in files.paths:
        try:
            parts.append(Part(file))
        except NeverBegun as error:
            refused.append(error)
    if len(files.paths) == 1 and refused:
        raise refused[0]
    absent = files.missing
    absent += [f'{Path(error.path).name} {error.problem}' for error in refused]
    if not parts:
        raise BagError(f'no file of it can be read: {"; ".join(absent)}', path)
    return parts, absent


class TopicNumbers(NamedTuple):
    """The numbers of a topic so far, and who is known to begin with a message."""

    numbering: Numbering
    starts: KnownStarts

    def find_gaps(self, sequence: ArrayLike, stamp_ns: Integers) -> Iterator[tuple[str, Losses]]:
        """Take the next numbers and stamps; yield what they lack, each as one of `LOST_AS`."""
        losses = self.starts.find_gaps(self.numbering, sequence, stamp_ns)
        for lost_as, gaps in (('lost.before_start', self.numbering.take_before()),
                              ('lost.on_the_way', losses)):
            if len(gaps):
                yield lost_as, gaps


def _find_gaps(by_kind: Sequence[Found],
               numbers: Sequence[TopicNumbers]) -> Iterator[tuple[int, str, Losses]]:
    """Yield what the numbers of a block lack: the index of the topic, one of `LOST_AS`, gaps."""
    for readings in by_kind:
        for place in np.flatnonzero(np.bincount(readings.place)).tolist():
            mine = np.flatnonzero(readings.place == place)
            for lost_as, gaps in numbers[place].find_gaps(
                    readings.sequence[mine], readings.headings.stamp_ns[mine]):
                yield place, lost_as, gaps


class BagReader:
    """
    A bag: one .mcap file, or a rosbag2 directory with all its files.

    Parameters
    ----------
    path
        The file or directory. Files of a directory are read in natural order of their names;
        metadata.yaml may be absent.
    namespace
        Where topics without a leading slash are. None: in that of the recorder, or in the root.

    Attributes
    ----------
    topics
        The topics in the bag.
    incomplete : str or None
        Why part of the recording is missing (cut, never closed, a file missing); None if the bag
        is complete. The rest can still be read.
    start_ns, end_ns : int or None
        Smallest and largest log time; None without messages.
    oddities
        What is odd about the bag, and how it is read; more may be found while it is read.

    Raises
    ------
    OSError
        If a file cannot be read.
    BagError
        If it is not a bag.

    """

    def __init__(self, path: str | os.PathLike[str], namespace: str | None = None) -> None:
        self.path = Path(path)
        self.oddities: list[str] = []
        self._parts, absent = _open_files(self.path, self.oddities)
        reasons = absent + [part.incomplete for part in self._parts if part.incomplete]
        self.incomplete = '; '.join(reasons) or None
        self._metadata: dict[str, dict[str, str]] | None = None
        self._numberings: dict[tuple[str, str], Numbering] = {}
        self._earlier: Mapping[tuple[str, str], Numbering] = {}
        self._namespace = None if namespace is None else clean_namespace(namespace)
        self.start_ns = min((p.start_ns for p in self._parts if p.start_ns is not None),
                            default=None)
        self.end_ns = max((p.end_ns for p in self._parts if p.end_ns is not None), default=None)
        self.topics: dict[str, TopicInfo] = {}
        for part in self._parts:
            for number, channel in part.channels.items():
                kind = self._type_of(part, number)
                qos = Qos.of_yaml(channel.metadata.get('offered_qos_profiles', ''))
                info = self.topics.get(channel.topic, TopicInfo(kind, 0, qos))
                # A channel without a schema has no type that could contradict that of others.
                if kind and info.type_name and info.type_name != kind:
                    raise BagError(f'topic {channel.topic} is both {info.type_name} and {kind}; '
                                   '"recover" makes two topics of it', self.path)
                count = info.count + part.counts.get(number, 0)
                self.topics[channel.topic] = TopicInfo(info.type_name or kind, count, info.qos)

    @staticmethod
    def _type_of(part: Part, number: int) -> str:
        schema = part.schemas.get(part.channels[number].schema_id)
        return full_name(schema.name) if schema else ''

    @property
    def namespace(self) -> str:
        """Return the namespace of topics without a leading slash; '' for the root."""
        if self._namespace is None:
            self._namespace = read_namespace(self.metadata())
        return self._namespace

    def find(self, topic: str) -> str | None:
        """Return the name in the bag of a topic within the namespace; None if there is none."""
        return find_topic(self.topics, topic, self.namespace)

    def resolve(self, topic: str) -> str:
        """
        Return the name in the bag of a topic within the namespace.

        Raises
        ------
        BagError
            If there is no such topic; the message lists the topics of the bag.

        """
        name = self.find(topic)
        if name is None:
            cut = f' ({self.incomplete})' if self.incomplete else ''
            raise BagError(list_topics(self.topics, topic, self.namespace) + cut, self.path)
        return name

    def headings(self, conventions: Mapping[str, str], helpers: int = 0,
                 lost: Callable[[str, str, Losses], None] | None = None,
                 claimed: Mapping[str, Callable[[Quality], None]] | None = None,
                 ) -> Iterator[dict[str, Headings]]:
        """
        Return an iterator over the headings of some topics.

        Parameters
        ----------
        conventions : mapping of str to {'enu', 'ned'}
            World axes of the orientations, by topic.
        helpers
            Processes to decode in parallel with this one, for large bags; the result is the
            same. None are started where a fork is unsafe: while other threads run, in a worker of
            `multiprocessing`, or outside Linux.
        lost
            Called with a requested topic, one of `LOST_AS`, and the messages missing among the
            numbers of its publisher or before the first one, before the chunk with the reading
            after them is yielded or later. Never called for a bag of a program that does not keep
            these numbers.
        claimed
            By requested topic, called with what its messages claim of their headings, before the
            chunk with these is yielded or earlier; where neighbours claim the same, the first and
            the last suffice.

        Returns
        -------
        iterator of dict of str to Headings
            Chunks of at most a minute of log time, in file order. Each has every requested topic,
            under the requested name. Memory stays bounded.

        Raises
        ------
        BagError
            At once if a topic is absent, is not a heading, or its layout differs from that of
            its type; while iterating, if the file is damaged.

        """
        for topic, convention in conventions.items():
            name = self.resolve(topic)
            self.check_heading(name)
            if part := locate_in(name, topic).part:
                raise BagError(f'topic {name}: {part!r} of its messages cannot be read here; '
                               'analyze reads it', self.path)
            if convention not in ('enu', 'ned'):
                raise BagError(f"convention of topic {topic} = {convention!r}: use 'enu' or "
                               "'ned'", self.path)
        return self._headings(conventions, helpers, lost, claimed or {})

    def check_heading(self, topic: str, types: Sequence[str] = HEADING_TYPES) -> None:
        """Raise BagError unless a topic of the bag has one of some types, with its layout."""
        kind = self.topics[topic].type_name
        if kind not in types:
            raise BagError(f'topic {topic} is {kind or "without a schema"}; a heading is '
                           f'{", ".join(types)}', self.path)
        problems = {(part.path, find_channel_problem(part, number, kind)) for part in self._parts
                    for number, channel in part.channels.items() if channel.topic == topic}
        # The messages of one odd channel among others are unreadable readings.
        if all(problem for _, problem in problems):
            path, problem = min(problems)
            raise BagError(f'topic {topic} ({kind}) cannot be read: {problem}', path)

    def _headings(self, conventions: Mapping[str, str], helpers: int,
                  lost: Callable[[str, str, Losses], None] | None,
                  claimed: Mapping[str, Callable[[Quality], None]],
                  ) -> Iterator[dict[str, Headings]]:
        topics = {asked: (self.resolve(asked), convention)
                  for asked, convention in conventions.items()}
        once = list(dict.fromkeys(topics.values()))
        helpers = helpers if can_fork() else 0
        numbers = None
        if lost is not None and self.keeps_numbers():
            numbers = self.begin_numbers(once)
        minutes = self._minutes(self._kinds(once, [topics[asked] for asked in claimed]),
                                len(once), helpers, numbers)
        # Without helpers, decode ahead in a prefetch thread.
        for minute, gaps, claims in minutes if helpers else run_ahead(minutes):
            by_topic = dict(zip(once, minute))
            for place, rows in claims:
                for asked in claimed:
                    if topics[asked] == once[place]:
                        claimed[asked](rows)
            if lost is not None:
                for place, lost_as, losses in gaps:
                    for asked in (asked for asked, topic in topics.items()
                                  if topic == once[place]):
                        lost(asked, lost_as, losses)
            yield {asked: by_topic[topic] for asked, topic in topics.items()}

    def begin_numbers(self, topics: Sequence[tuple[str, str]]) -> list[TopicNumbers]:
        """Return the numbers of topics, each given with how it is read, before the first one."""
        starts = read_starts(self)
        self._numberings = {topic: deepcopy(self._earlier.get(topic)) or Numbering()
                            for topic in topics}
        return [TopicNumbers(self._numberings[topic], KnownStarts(starts.get(topic[0], ())))
                for topic in topics]

    def go_on_from(self, before: 'BagReader') -> None:
        """Count what is missing from the last numbers of an earlier part, which was read."""
        self._earlier = before._numberings

    def tells_claims(self, conventions: Mapping[str, str]) -> bool:
        """Tell whether `headings` of these topics tells their claims, if it is asked to."""
        return bool(conventions)

    def keeps_numbers(self) -> bool:
        """Tell whether the numbers of the messages are those of their publishers."""
        return self._has_record(*_NUMBERED_BY)

    def is_ours(self) -> bool:
        """Tell whether this program wrote the bag: its publish times are those of sending."""
        return self._has_record(RECORD)

    def _has_record(self, *names: str) -> bool:
        try:
            return any(name in self.metadata() for name in names)
        except BagError:
            # The reading of the messages says what is damaged.
            return False

    def _minutes(self, kinds: Sequence[Kind], count: int, helpers: int,
                 numbers: Sequence[TopicNumbers] | None,
                 ) -> Iterator[tuple[list[Headings], list[tuple[int, str, Losses]],
                                     list[tuple[int, Quality]]]]:
        """Yield the headings of topics by the minute, the gaps in their numbers, their claims."""
        window = Window(count)
        gaps: list[tuple[int, str, Losses]] = []
        claims: list[tuple[int, Quality]] = []
        unreadable = 0, ''
        for block in self._decode(kinds, helpers):
            unreadable = add_unreadable(
                [unreadable, *(readings.unreadable for readings in block.found)])
            if numbers is not None:
                gaps += _find_gaps(block.found, numbers)
            claims += (rows for readings in block.found for rows in readings.claims)
            for minute in window.add(block.found):
                yield minute, gaps, claims
                gaps, claims = [], []
        for minute in window.rest():
            yield minute, gaps, claims
        if unreadable[0]:
            self.oddities.append(f'{unreadable[0]} messages cannot be read and count as invalid '
                                 f'readings; the first: {unreadable[1]}')

    def _kinds(self, topics: Sequence[tuple[str, str]],
               claiming: Collection[tuple[str, str]] = ()) -> list[Kind]:
        """Return what to decode as one: topics of one type and convention."""
        places: dict[tuple[str, str], dict[str, int]] = {}
        for place, (topic, convention) in enumerate(topics):
            places.setdefault((self.topics[topic].type_name, convention), {})[topic] = place
        return [Kind(*alike, of, [place for place in of.values() if topics[place] in claiming])
                for alike, of in places.items()]

    def _decode(self, kinds: Sequence[Kind], helpers: int) -> Iterator[Decoded]:
        """Yield the decoded blocks of all files, in the order in which their stamps rise."""
        topics = {topic for kind in kinds for topic in kind.places}
        if not is_in_order(self._parts, topics):
            pieces = cut_pieces(self._parts)
            with Decoder(self._parts, kinds) as decoder:
                if rises_by_time(decoder, pieces):
                    yield from self._decode_by_time(decoder, pieces)
                    return
        tasks = [Task(number, stretch) for number, part in enumerate(self._parts)
                 for stretch in part.stretches()]
        by_blocks: set[int] = set()
        with Decoder(self._parts, kinds) as decoder, closing(
                decode_stretches(decoder, tasks, helpers, by_blocks)) as results:
            of_parts = groupby(zip(tasks, results), lambda decoded: decoded[0].number)
            for number, stretches in of_parts:
                yield from self._decode_file(decoder, number, stretches, by_blocks)

    def _decode_by_time(self, decoder: Decoder, pieces: Sequence[Piece]) -> Iterator[Decoded]:
        """Yield the readings of all files in the order of their log times; say so."""
        if _DISORDER not in self.oddities:
            self.oddities.append(_DISORDER)
        counts: dict[int, int] = {}
        yield from read_by_time(decoder, pieces, counts)
        for number, part in enumerate(self._parts):
            part.check_count(counts.get(number, 0))

    def _decode_file(self, decoder: Decoder, number: int,
                     stretches: Iterable[tuple[Task, list[Decoded] | None]],
                     by_blocks: set[int]) -> Iterator[Decoded]:
        """Yield the decoded blocks of a file; BagError where it is damaged."""
        count = 0
        for (_, stretch), whole in stretches:
            blocks: Iterable[Decoded] | None = whole
            if blocks is None:
                # Damaged, too large, or not where the index says: continue block by block.
                by_blocks.add(number)
                blocks = decoder.blocks(number, stretch.begin)
            for block in blocks:
                count += block.messages
                yield block
            if number in by_blocks:
                break
        self._parts[number].check_count(count)

    def messages(self, topics: Iterable[str] | None = None, start_ns: int = 0,
                 stop_ns: int = 2**64, *, in_order: bool = False) -> Iterator[BagMessage]:
        """
        Return an iterator over messages as they are stored, in file order.

        Parameters
        ----------
        topics
            Topics to read; all by default.
        start_ns, stop_ns
            Log times to read: start <= log time < stop.
        in_order
            In the order in which `headings` reads, instead of that of the files.

        Raises
        ------
        BagError
            At once if a topic is absent; while iterating, if the file is damaged.

        """
        names = None if topics is None else {self.resolve(topic) for topic in topics}
        span = start_ns, stop_ns
        headings = [topic for topic in self.topics if (names is None or topic in names)
                    and self.topics[topic].type_name in HEADING_TYPES] if in_order else []
        if headings and not is_in_order(self._parts, headings):
            pieces = cut_pieces(self._parts)
            with Decoder(self._parts, self._kinds([(topic, 'enu') for topic in headings])
                         ) as decoder:
                if rises_by_time(decoder, pieces):
                    return merge_by_time(pieces, lambda piece: self._in_piece(piece, names, span))
        return (message for part in self._parts for block in part.blocks(*span)
                for message in self._in_block(part, block, names, span))

    def _in_piece(self, piece: Piece, names: set[str] | None,
                  span: tuple[int, int]) -> Iterator[tuple[int, BagMessage]]:
        """Yield the messages of a piece, each with its log time."""
        part, stretch = self._parts[piece.number], piece.stretch
        with part.open() as stream:
            for block in part.blocks_of(stream, stretch.begin, stretch.end, *span):
                for message in self._in_block(part, block, names, span):
                    yield message.log_time_ns, message

    def _in_block(self, part: Part, block: Block, names: set[str] | None,
                  span: tuple[int, int]) -> Iterator[BagMessage]:
        """Yield the messages of a block; of many mostly a few are wanted."""
        channels = {number: (channel.topic, self._type_of(part, number))
                    for number, channel in part.channels.items()
                    if names is None or channel.topic in names}
        packed = is_packed(block.data, block.start)
        channel = block.heads['channel']
        wanted = np.isin(channel, [*channels]) | ~np.isin(channel, [*part.channels])
        passed = find_passed(block)
        rows = np.flatnonzero(wanted & ~passed)
        for number in np.unique(channel[wanted & passed]).tolist():
            self._note_passed(channels[number][0])
        for head, lo, hi in zip(block.heads[rows].tolist(), block.start[rows].tolist(),
                                block.stop[rows].tolist()):
            _, _, number, sequence, log, publish = head
            if number not in part.channels:
                raise BagError(f'a message belongs to channel {number}, which is not defined',
                               part.path, block.offset)
            if span[0] <= log < span[1]:
                data = bytes(block.data[lo:hi])
                yield BagMessage(*channels[number], log, publish, sequence,
                                 (unpack_payload(data) or data) if packed else data)

    def _note_passed(self, topic: str) -> None:
        oddity = f'messages of {topic} with more than {RECORD_BYTES} bytes are passed over'
        if oddity not in self.oddities:
            self.oddities.append(oddity)

    def payloads(self, topic: str) -> Iterator[Payloads]:
        """Yield the readable messages of a topic in file order; BagError as of `messages`."""
        for part in self._parts:
            channels = [number for number, channel in part.channels.items()
                        if channel.topic == topic and not find_channel_problem(
                            part, number, self.topics[topic].type_name)]
            for block in part.blocks() if channels else ():
                rows = np.flatnonzero(np.isin(block.heads['channel'], channels))
                if not rows.size:
                    continue
                heads, within = block.heads[rows], (block.start[rows], block.stop[rows])
                data, start, stop = (unpack_payloads(block.data, *within)
                                     if is_packed(block.data, within[0])
                                     else (block.data, *within))
                yield Payloads(data, start, stop, heads['log_time'].astype(np.int64),
                               heads['publish_time'].astype(np.int64))

    @property
    def missing_messages(self) -> int:
        """Return how many messages the indexes of its files count that are not there."""
        return sum(part.missing for part in self._parts)

    @property
    def recovered(self) -> str | None:
        """Return what was lost when this bag was recovered from a damaged one; None if nothing."""
        try:
            recovery = self.metadata().get('recovery', {})
        except BagError:
            return None
        if not any(key.startswith('note.') for key in recovery):
            return None
        bound = 'at least ' if recovery.get('messages_lost_is') == 'at least' else ''
        unproven = recovery.get('messages_unproven', '')
        return (f'recovered from a damaged bag: {bound}{recovery.get("messages_lost", "?")} '
                f'messages and {recovery.get("bytes_lost", "?")} bytes were lost'
                + (f'; {unproven} messages are in it though their checksum is wrong'
                   if unproven else ''))

    def metadata(self) -> dict[str, dict[str, str]]:
        """Return the metadata records by name; of several with one name the last. Read once."""
        if self._metadata is None:
            self._metadata = {record.name: dict(record.metadata) for part in self._parts
                              for record in part.metadata()}
        return self._metadata

    def attachments(self) -> list[Attachment]:
        """Return the files inside the bag, in file order."""
        return [Attachment(record.name, record.media_type, record.log_time, record.data)
                for part in self._parts for record in part.attachments()]
