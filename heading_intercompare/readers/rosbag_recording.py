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
from itertools import islice
import os
from pathlib import Path
import sqlite3
import struct
from typing import Any, Callable, Iterable, Iterator, Mapping
import weakref

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.rosbag1 import Reader as Ros1Reader, ReaderError as Ros1Error
from rosbags.rosbag2 import Reader as Ros2Reader, reader as ros2, ReaderError as Ros2Error
from rosbags.serde import SerdeError
from rosbags.typesys import (
    get_types_from_idl,
    get_types_from_msg,
    get_typestore,
    Stores,
    TypesysError,
)

from heading_intercompare.bags.packed_files import unpack_payload
from heading_intercompare.bags.rosbag2.bag_reader import BagMessage, Payloads, TopicInfo
from heading_intercompare.bags.rosbag2.topic_names import clean_namespace, find_topic, list_topics
from heading_intercompare.core.records import Headings, Losses, Quality
from heading_intercompare.messages.byte_columns import join_messages
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.fields import Definitions, Field, leaves, SEQUENCE, short_name
from heading_intercompare.messages.heading_places import LOG_TIME, PUBLISH_TIME
from heading_intercompare.messages.schemas import DEFINITIONS, definitions_of
from heading_intercompare.messages.sentence_messages import SENTENCE, TOPIC_TYPES
from heading_intercompare.messages.transform_messages import TRANSFORM_TYPES, TRANSFORMS
from heading_intercompare.natural_order import natural_key

from .stream_recording import ReaderError, tell_no_unit
from .topic_decoding import (
    explain_type,
    find_absence,
    list_keys,
    Logged,
    read_topics,
    TopicDecoder,
    TopicKey,
)

_FAULTS = (Ros1Error, Ros2Error, SerdeError, MessageError, sqlite3.Error, struct.error, EOFError,
           KeyError, IndexError, AssertionError, RuntimeError, UnicodeDecodeError,
           getattr(getattr(ros2, 'zstd', None), 'ZstdError', RuntimeError))
#: Errors of a single message of ROS 1 that cannot be converted.
_UNREADABLE = (SerdeError, struct.error, IndexError, ValueError)
#: Before each definition in IDL.
_RULE = '=' * 80 + '\n'
#: Types that the conversion from ROS 1 turns into those of ROS 2.
_CONVERTED = ('std_msgs/msg/Header', 'builtin_interfaces/msg/Time',
              'builtin_interfaces/msg/Duration')
#: A longer definition is not read.
_MOST_LETTERS = 2**18
_AT_ONCE = 4_000


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


def _as_field(name: str, description: Any) -> Field:
    """Return a field as the library describes it."""
    kind, content = description
    size = None
    if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        size = content[1] if kind == Nodetype.ARRAY else SEQUENCE
        kind, content = content[0]
    return Field(name, content[0] if kind == Nodetype.BASE else short_name(content), size)


def _list_types(store: Any) -> Mapping[str, Any]:
    """Return the types that the library holds; earlier versions have another name for them."""
    types: Mapping[str, Any] = getattr(store, 'fielddefs', None) or store.FIELDDEFS
    return types


def _parse_types(text: str, type_name: str) -> Mapping[str, Any]:
    """Return the types in a definition: of messages, or in IDL, section by section."""
    if not text.startswith(f'{_RULE}IDL: '):
        return get_types_from_msg(text, type_name)
    types: dict[str, Any] = {}
    for section in text.split(_RULE)[1:]:
        types |= get_types_from_idl(section.partition('\n')[2])
    return types


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
    unit_of
        Returns the unit that is stated for the headings of a topic, 'auto' if none.

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

    def __init__(self, path: str | os.PathLike[str], namespace: str | None = None,
                 unit_of: Callable[[str], str] = tell_no_unit) -> None:
        self.path, self._unit_of = Path(path), unit_of
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
                 claimed: Mapping[str, Callable[[Quality], None]] | None = None,
                 ) -> Iterator[dict[str, Headings]]:
        """Return an iterator over the headings of some topics; see `BagReader.headings`."""
        keys = list_keys(self.resolve, conventions, self._unit_of)
        return self._read_messages(
            keys, {key: self._make_decoder(key) for key in keys.values()})

    def _make_decoder(self, key: TopicKey) -> TopicDecoder:
        """Return what decodes a topic; ReaderError if its messages have no such headings."""
        type_name = self.topics[key.name].type_name
        definitions: Definitions = {}
        if key.place.clock == PUBLISH_TIME:
            raise ReaderError(self.path, f'topic {key.name}: SQLite and ROS 1 keep no publish '
                              f'time; leave @{PUBLISH_TIME} out, or write @{LOG_TIME}')
        if key.place.part and type_name != SENTENCE:
            definitions = self._read_definitions(key.name)
        elif type_name not in TOPIC_TYPES:
            raise ReaderError(self.path, explain_type(key.name, type_name,
                                                      self._read_definitions))
        if key.place.part and type_name in TRANSFORM_TYPES and [
                *leaves(short_name(type_name), definitions)] != [
                *leaves(short_name(TRANSFORMS), definitions_of(TRANSFORMS))]:
            raise ReaderError(self.path, f'topic {key.name}: {type_name} has other fields in the '
                              f'bag than {TRANSFORMS}')
        try:
            return TopicDecoder(type_name, key.place, key.convention, definitions)
        except ValueError as error:
            raise ReaderError(self.path, f'topic {key.name}: {error}') from error

    def _read_definitions(self, name: str) -> Definitions:
        """Return the fields of the type of a topic: those in the bag, or those of ROS itself."""
        type_name = self.topics[name].type_name
        # Earlier versions of the library give the text itself.
        texts = (getattr(connection.msgdef, 'data', connection.msgdef)
                 for reader, _ in self._readers for connection in reader.connections
                 if connection.topic == name)
        text = next(filter(None, texts), '')
        types: Mapping[str, Any] = {} if text else _list_types(get_typestore(Stores.LATEST))
        if not text and type_name not in types:
            raise ReaderError(self.path, f'topic {name}: the bag holds no definition of '
                              f'{type_name}; write it with one (ros2 bag convert to mcap, where '
                              'the package of the type is installed)')
        if len(text) > _MOST_LETTERS:
            raise ReaderError(self.path, f'topic {name}: its definition has more than '
                              f'{_MOST_LETTERS} letters')
        try:
            types = types or _parse_types(text, type_name)
        except TypesysError as error:
            raise ReaderError(self.path, f'topic {name}: the definition of {type_name} cannot be '
                              'read') from error
        types = types if self._store is None else self._add_types(name, types)
        return {short_name(kind): tuple(_as_field(*field) for field in fields)
                for kind, (_, fields) in types.items()}

    def _add_types(self, name: str, types: Mapping[str, Any]) -> Mapping[str, Any]:
        """Have the library convert types of ROS 1; return all types as they are converted."""
        assert self._store is not None
        held = _list_types(self._store)
        for kind, (_, fields) in types.items():
            if kind in held and kind not in _CONVERTED and held[kind][1] != fields:
                raise ReaderError(self.path, f'topic {name}: {kind} has other fields in the bag '
                                  'than in ROS 2')
        self._store.register({kind: fields for kind, fields in types.items() if kind not in held})
        return held

    def _read_messages(self, keys: Mapping[str, TopicKey],
                       decoders: Mapping[TopicKey, TopicDecoder]) -> Iterator[dict[str, Headings]]:
        with self._named():
            yield from read_topics(
                ((name, Logged(time_ns, 0, data)) for name, time_ns, data in self._raw(
                    {key.name for key in decoders})), keys, decoders, self.oddities)
        if absence := find_absence(decoders):
            raise ReaderError(self.path, absence)

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

    def tells_claims(self, conventions: Mapping[str, str]) -> bool:
        """Tell that claims are not told beside the headings."""
        return False

    def keeps_numbers(self) -> bool:
        """Tell that the numbers of the publishers are not kept."""
        return False

    def messages(self, topics: Iterable[str] | None = None) -> Iterator[BagMessage]:
        """Return an iterator over messages as CDR, in file order; of all topics by default."""
        names = {*self.topics} if topics is None else {self.resolve(topic) for topic in topics}
        with self._named():
            for name, time_ns, data in self._raw(names):
                yield BagMessage(name, self.topics[name].type_name, time_ns, time_ns, 0, data)

    def payloads(self, topic: str) -> Iterator[Payloads]:
        """Yield the messages of a topic in file order, many at once."""
        messages = self.messages([topic])
        while batch := list(islice(messages, _AT_ONCE)):
            time_ns = np.array([message.log_time_ns for message in batch], np.int64)
            yield Payloads(*join_messages([message.data for message in batch]), time_ns, time_ns)

    def metadata(self) -> dict[str, dict[str, str]]:
        """Return no metadata records."""
        return {}
