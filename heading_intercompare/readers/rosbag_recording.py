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
An unreadable message is an invalid reading at its log time, as in MCAP bags.
"""

from __future__ import annotations

from contextlib import contextmanager
import os
from pathlib import Path
import sqlite3
import struct
from typing import Any, Callable, Iterable, Iterator, Mapping
import weakref

from rosbags.rosbag1 import Reader as Ros1Reader, ReaderError as Ros1Error
from rosbags.rosbag2 import Reader as Ros2Reader, reader as ros2, ReaderError as Ros2Error
from rosbags.serde import SerdeError
from rosbags.typesys import get_types_from_msg, get_typestore, Stores

from heading_intercompare.bags.packed_files import unpack_payload
from heading_intercompare.bags.rosbag2.bag_reader import BagMessage, TopicInfo
from heading_intercompare.bags.rosbag2.topic_names import clean_namespace, find_topic, list_topics
from heading_intercompare.core.records import Headings, Losses
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.fields import short_name
from heading_intercompare.messages.schemas import DEFINITIONS
from heading_intercompare.messages.sentence_messages import SENTENCE, TOPIC_TYPES
from heading_intercompare.natural_order import natural_key

from .stream_recording import ReaderError
from .topic_decoding import list_keys, Logged, read_topics, TopicDecoder, TopicKey

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
        if self._store is not None:
            self._store.register(get_types_from_msg(
                DEFINITIONS[short_name(SENTENCE)], SENTENCE))
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
        keys = list_keys(self.resolve, conventions)
        for key in keys.values():
            type_name = self.topics[key.name].type_name
            if type_name not in TOPIC_TYPES:
                raise ReaderError(self.path, f'topic {key.name} is {type_name}; a heading is '
                                  f'{", ".join(TOPIC_TYPES)}')
            if key.part and type_name != SENTENCE:
                raise ReaderError(self.path, f'topic {key.name}: the field {key.part} of its '
                                  'messages is read from MCAP bags only')
        try:
            decoders = {key: TopicDecoder(self.topics[key.name].type_name, key.place,
                                          key.convention) for key in keys.values()}
        except ValueError as error:
            raise ReaderError(self.path, f'{error}') from error
        return self._read_messages(keys, decoders)

    def _read_messages(self, keys: Mapping[str, TopicKey],
                       decoders: Mapping[TopicKey, TopicDecoder]) -> Iterator[dict[str, Headings]]:
        with self._named():
            yield from read_topics(
                ((name, Logged(time_ns, 0, data)) for name, time_ns, data in self._raw(
                    {key.name for key in decoders})), keys, decoders, self.oddities)

    def _raw(self, topics: Iterable[str]) -> Iterator[tuple[str, int, bytes]]:
        """
        Yield topic, log time and data of messages, as CDR.

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
