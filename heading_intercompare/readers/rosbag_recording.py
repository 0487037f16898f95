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
Bags that `rosbags` reads: rosbag2 in SQLite or compressed by file or message, and ROS 1.

Messages come one by one from the library, and are decoded in columns like those of MCAP bags.
Topics of `nmea_msgs/Sentence` are read as a log, with the stamps of their headers. An unreadable
message is an invalid reading at its log time, as in MCAP bags.
"""

from __future__ import annotations

from contextlib import contextmanager
from functools import partial
from itertools import islice
import os
from pathlib import Path
import sqlite3
import struct
from tempfile import NamedTemporaryFile
from typing import Any, Callable, IO, Iterable, Iterator, Mapping, Sequence
import weakref

import numpy as np
from rosbags.rosbag1 import Reader as Ros1Reader, ReaderError as Ros1Error
from rosbags.rosbag2 import Reader as Ros2Reader, reader as ros2, ReaderError as Ros2Error
from rosbags.serde import SerdeError
from rosbags.typesys import get_typestore, Stores

from heading_intercompare.bags.packed_files import unpack_payload
from heading_intercompare.bags.rosbag2.bag_reader import BagMessage, TopicInfo
from heading_intercompare.bags.rosbag2.topic_names import clean_namespace, find_topic, list_topics
from heading_intercompare.core.records import Headings, Losses
from heading_intercompare.drivers.logs import LogReader
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.messages.byte_columns import decode_readable, join_messages
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.heading_messages import decode_headings, HEADING_TYPES
from heading_intercompare.natural_order import natural_key

from .stream_recording import ReaderError

SENTENCE = 'nmea_msgs/msg/Sentence'
"""The type of a topic with NMEA sentences."""

_MESSAGES = 4_000
_FAULTS = (Ros1Error, Ros2Error, SerdeError, MessageError, sqlite3.Error, struct.error, EOFError,
           KeyError, IndexError, AssertionError, RuntimeError, UnicodeDecodeError,
           getattr(getattr(ros2, 'zstd', None), 'ZstdError', RuntimeError))
#: Errors of a single message of ROS 1 that cannot be converted.
_UNREADABLE = (SerdeError, struct.error, IndexError, ValueError)


def _faults() -> tuple[type[Exception], ...]:
    """Return the errors of damaged bags; newer versions of the library bring an own SQLite."""
    try:
        import apsw
    except ImportError:
        return _FAULTS
    return (*_FAULTS, apsw.Error)


def _take_packed(reader: Any) -> bool:
    """
    Tell whether the messages of a bag are compressed one by one; then have them come as they are.

    The library ends at the first one that it cannot decompress.
    """
    storage = getattr(reader, 'storage', None)
    if storage is None or reader.compression_mode != 'message':
        return False
    storage.metadata = storage.metadata._replace(compression_mode=None)
    return True


def _sentence_line(data: bytes, ros1: bool) -> bytes:
    """Return the line of a log for the sentence in a message; MessageError if it has none."""
    if not ros1 and data[:2] not in (b'\0\0', b'\0\1'):
        raise MessageError(f'{SENTENCE} message does not start as CDR')
    at, sign = (4, '<') if ros1 else (4, '<' if data[1] & 1 else '>')
    try:
        sec, nsec, size = struct.unpack_from(f'{sign}III', data, at)
        at += 12 + size
        if not ros1:
            # Strings end with a zero, and the next length is aligned after the head of 4 bytes.
            at += -(at - 4) % 4
        size, = struct.unpack_from(f'{sign}I', data, at)
    except struct.error:
        size = len(data)
    if at + 4 + size > len(data):
        raise MessageError(f'{SENTENCE} message of {len(data)} bytes is too short')
    text = bytes(data[at + 4:at + 4 + size]).rstrip(b'\0\r\n')
    return b'%010d.%09d %s\r\n' % (sec, nsec, text)


class _Topic:
    """Decodes the messages of a topic."""

    def __init__(self, info: TopicInfo, convention: str, ros1: bool) -> None:
        self._type, self._convention, self._ros1 = info.type_name, convention, ros1
        self._log: IO[bytes] | None = None
        #: Log times of sentences that cannot be read.
        self._refused_ns: list[int] = []
        self.unreadable = 0
        self.problem = ''

    def _refuse(self, count: int, problem: str) -> None:
        self.unreadable += count
        self.problem = self.problem or problem

    def decode(self, raw: Sequence[tuple[int, bytes]], last: bool) -> Headings:
        """Return the headings of messages, each given with its log time."""
        if self._type == SENTENCE:
            return self._take_sentences(raw, last)
        if not raw:
            return Headings.empty()
        data, starts, stops = join_messages([message for _, message in raw])
        headings, readable, problem = decode_readable(
            partial(decode_headings, self._type, self._convention, data), starts, stops)
        if not problem:
            return headings
        self._refuse(int((~readable).sum()), problem)
        stamp_ns, heading_deg = np.array([ns for ns, _ in raw]), np.full(len(raw), np.nan)
        stamp_ns[readable], heading_deg[readable] = headings.stamp_ns, headings.heading_deg
        return Headings(stamp_ns, heading_deg)

    def _take_sentences(self, raw: Sequence[tuple[int, bytes]], last: bool) -> Headings:
        """Write sentences into a log; return its headings at the end."""
        if self._log is None:
            self._log = NamedTemporaryFile(suffix='.log')
        for ns, message in raw:
            try:
                self._log.write(_sentence_line(message, self._ros1))
            except MessageError as error:
                self._refuse(1, error.problem)
                self._refused_ns.append(ns)
        if not last:
            return Headings.empty()
        headings = Headings.empty()
        with self._log as log:
            log.flush()
            if log.tell():
                headings = Headings.concatenate(list(LogReader(log.name, DriverSettings(
                    stamp_format='epoch'))))
        refused_ns = np.sort(np.array(self._refused_ns, np.int64))
        places = np.searchsorted(np.maximum.accumulate(headings.stamp_ns), refused_ns)
        return Headings(np.insert(headings.stamp_ns, places, refused_ns),
                        np.insert(headings.heading_deg, places, np.nan))


class RosbagRecording:
    """
    A bag that `rosbags` reads; offers what `BagReader` offers.

    Parameters
    ----------
    path
        A ``.bag`` of ROS 1, a ``.db3`` file, or the directory of a rosbag2. A directory without
        metadata.yaml is read by its files.
    namespace
        Where topics without a leading slash are; none: in the root.

    Attributes
    ----------
    topics, incomplete, oddities, recovered, start_ns, end_ns
        As of `BagReader`.

    Raises
    ------
    OSError
        If the bag cannot be read.
    ReaderError
        If it is damaged.

    """

    recovered: str | None = None

    def __init__(self, path: str | os.PathLike[str], namespace: str | None = None) -> None:
        self.path = Path(path)
        self.ros1 = self.path.is_file() and self.path.suffix != '.db3'
        # Its headers have no number, which the conversion leaves out.
        self._store = get_typestore(Stores.ROS2_HUMBLE) if self.ros1 else None
        self.incomplete: str | None = None
        self.oddities: list[str] = []
        self.namespace = clean_namespace(namespace or '')
        paths = [self.path]
        if self.path.is_dir() and not (self.path / 'metadata.yaml').exists():
            paths = sorted(self.path.glob('*.db3'), key=natural_key)
            self.incomplete = 'metadata.yaml is missing'
        #: The readers, and whether their messages are compressed one by one.
        self._readers: list[tuple[Any, bool]] = []
        self.topics: dict[str, TopicInfo] = {}
        with self._named():
            for file in paths:
                reader: Any = Ros1Reader(file) if self.ros1 else Ros2Reader(file)
                reader.open()
                weakref.finalize(self, reader.close)
                self._readers.append((reader, not self.ros1 and _take_packed(reader)))
                for connection in reader.connections:
                    info = self.topics.get(connection.topic, TopicInfo(connection.msgtype, 0))
                    if info.type_name != connection.msgtype:
                        raise ReaderError(self.path, f'topic {connection.topic} is both '
                                          f'{info.type_name} and {connection.msgtype}')
                    self.topics[connection.topic] = TopicInfo(
                        connection.msgtype, info.count + connection.msgcount)
            full = [reader for reader, _ in self._readers if reader.message_count]
            self.start_ns = min((reader.start_time for reader in full), default=None)
            self.end_ns = max((reader.end_time - 1 for reader in full), default=None)

    @contextmanager
    def _named(self) -> Iterator[None]:
        """Turn the errors of the library into one line."""
        try:
            yield
        except ReaderError:
            raise
        except _faults() as error:
            raise ReaderError(self.path, f'is damaged, or no bag: {error}') from error

    def find(self, topic: str) -> str | None:
        """Return the name in the bag of a topic within the namespace; None if there is none."""
        return find_topic(self.topics, topic, self.namespace)

    def resolve(self, topic: str) -> str:
        """Return the name in the bag of a topic within the namespace."""
        name = self.find(topic)
        if name is None:
            raise ReaderError(self.path, list_topics(self.topics, topic, self.namespace))
        return name

    def headings(self, conventions: Mapping[str, str], helpers: int = 0,
                 lost: Callable[[str, str, Losses], None] | None = None,
                 ) -> Iterator[dict[str, Headings]]:
        """Return an iterator over the headings of some topics; see `BagReader.headings`."""
        allowed = (*HEADING_TYPES, SENTENCE)
        for asked in conventions:
            name = self.resolve(asked)
            if self.topics[name].type_name not in allowed:
                raise ReaderError(self.path, f'topic {name} is {self.topics[name].type_name}; a '
                                  f'heading is {", ".join(allowed)}')
        return self._headings(conventions)

    def _headings(self, conventions: Mapping[str, str]) -> Iterator[dict[str, Headings]]:
        names = {asked: self.resolve(asked) for asked in conventions}
        once = {(names[asked], convention): _Topic(self.topics[names[asked]], convention,
                                                   self.ros1)
                for asked, convention in conventions.items()}
        raw: dict[str, list[tuple[int, bytes]]] = {name: [] for name in names.values()}

        def hand_out(last: bool) -> dict[str, Headings]:
            headings = {key: topic.decode(raw[key[0]], last) for key, topic in once.items()}
            for data in raw.values():
                data.clear()
            return {asked: headings[names[asked], convention]
                    for asked, convention in conventions.items()}
        with self._named():
            messages = self._raw(raw)
            append = {name: data.append for name, data in raw.items()}
            while batch := list(islice(messages, _MESSAGES)):
                for name, time_ns, data in batch:
                    append[name]((time_ns, data))
                yield hand_out(False)
            yield hand_out(True)
        unreadable = sum(topic.unreadable for topic in once.values())
        if unreadable:
            problem = next(topic.problem for topic in once.values() if topic.problem)
            self.oddities.append(f'{unreadable} messages cannot be read and count as invalid '
                                 f'readings; the first: {problem}')

    def _raw(self, topics: Iterable[str]) -> Iterator[tuple[str, int, bytes]]:
        """
        Yield topic, log time and data of messages, as CDR but for sentences of ROS 1.

        A message that cannot be decompressed or converted is empty.
        """
        topics = set(topics)
        for reader, packed in self._readers:
            mine = [connection for connection in reader.connections if connection.topic in topics]
            messages = reader.messages(mine) if mine else ()
            if self._store is None:
                for connection, time_ns, data in messages:
                    # A row of SQLite may hold a number or a text.
                    data = bytes(data) if isinstance(data, (bytes, memoryview)) else b''
                    yield (connection.topic, time_ns,
                           (unpack_payload(data) or b'') if packed else data)
                continue
            convert = self._store.ros1_to_cdr
            for connection, time_ns, data in messages:
                if connection.msgtype != SENTENCE:
                    try:
                        data = convert(data, connection.msgtype)
                    except _UNREADABLE:
                        data = b''
                yield connection.topic, time_ns, data

    def keeps_numbers(self) -> bool:
        """Tell that the numbers of the publishers are not kept."""
        return False

    def messages(self, topics: Iterable[str] | None = None) -> Iterator[BagMessage]:
        """Return an iterator over messages as CDR, in file order; of all topics by default."""
        names = {*self.topics} if topics is None else {self.resolve(topic) for topic in topics}
        with self._named():
            for name, time_ns, data in self._raw(names):
                yield BagMessage(name, self.topics[name].type_name, time_ns, time_ns, 0, data)

    def metadata(self) -> dict[str, dict[str, str]]:
        """Return no metadata records."""
        return {}
