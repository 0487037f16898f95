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
Topics of `nmea_msgs/Sentence` are read as a log, with the stamps of their headers.
"""

from __future__ import annotations

from contextlib import contextmanager
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
from rosbags.rosbag2 import Reader as Ros2Reader, ReaderError as Ros2Error
from rosbags.serde import SerdeError
from rosbags.typesys import get_typestore, Stores

from heading_intercompare.bags.rosbag2.bag_reader import BagMessage, TopicInfo
from heading_intercompare.core.records import Headings, Losses
from heading_intercompare.drivers.logs import LogReader
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.heading_messages import decode_headings, HEADING_TYPES
from heading_intercompare.natural_order import natural_key

from .errors import ReaderError

__all__ = ['RosbagRecording', 'SENTENCE']

SENTENCE = 'nmea_msgs/msg/Sentence'
"""The type of a topic with NMEA sentences."""

_MESSAGES = 4_000
_FAULTS = (Ros1Error, Ros2Error, SerdeError, MessageError, sqlite3.Error, struct.error, EOFError,
           KeyError, IndexError, AssertionError, RuntimeError, UnicodeDecodeError)


def _faults() -> tuple[type[Exception], ...]:
    """Return the errors of damaged bags; newer versions of the library bring an own SQLite."""
    try:
        import apsw
    except ImportError:
        return _FAULTS
    return (*_FAULTS, apsw.Error)


def _sentence_line(data: bytes, ros1: bool) -> bytes:
    """Return the line of a log for the sentence in a message."""
    at, sign = (4, '<') if ros1 else (4, '<' if data[1] & 1 else '>')
    sec, nsec, size = struct.unpack_from(f'{sign}III', data, at)
    at += 12 + size
    if not ros1:
        # Strings end with a zero, and the next length is aligned after the head of 4 bytes.
        at += -(at - 4) % 4
    size, = struct.unpack_from(f'{sign}I', data, at)
    text = bytes(data[at + 4:at + 4 + size]).rstrip(b'\0\r\n')
    return b'%010d.%09d %s\r\n' % (sec, nsec, text)


class _Topic:
    """Decodes the messages of a topic."""

    def __init__(self, info: TopicInfo, convention: str, ros1: bool) -> None:
        self._type, self._convention, self._ros1 = info.type_name, convention, ros1
        self._log: IO[bytes] | None = None

    def decode(self, raw: Sequence[bytes], last: bool) -> Headings:
        """Return the headings of messages."""
        if self._type == SENTENCE:
            return self._take_sentences(raw, last)
        if not raw:
            return Headings.empty()
        stops = np.cumsum(np.fromiter(map(len, raw), np.int64, len(raw)))
        starts = np.concatenate(([0], stops[:-1]))
        return decode_headings(self._type, self._convention, b''.join(raw), starts, stops)

    def _take_sentences(self, raw: Sequence[bytes], last: bool) -> Headings:
        """Write sentences into a log; return its headings at the end."""
        if self._log is None:
            self._log = NamedTemporaryFile(suffix='.log')
        self._log.write(b''.join(_sentence_line(one, self._ros1) for one in raw))
        if not last:
            return Headings.empty()
        with self._log as log:
            log.flush()
            if not log.tell():
                return Headings.empty()
            return Headings.concatenate(list(LogReader(log.name, DriverSettings(
                stamp_format='epoch'))))


class RosbagRecording:
    """
    A bag that `rosbags` reads; offers what `BagReader` offers.

    Parameters
    ----------
    path : str or path
        A ``.bag`` of ROS 1, a ``.db3`` file, or the directory of a rosbag2. A directory without
        metadata.yaml is read by its files.

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

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self.ros1 = self.path.is_file() and self.path.suffix != '.db3'
        # Its headers have no number, which the conversion leaves out.
        self._store = get_typestore(Stores.ROS2_HUMBLE) if self.ros1 else None
        self.incomplete: str | None = None
        self.oddities: list[str] = []
        paths = [self.path]
        if self.path.is_dir() and not (self.path / 'metadata.yaml').exists():
            paths = sorted(self.path.glob('*.db3'), key=natural_key)
            self.incomplete = 'metadata.yaml is missing'
        self._readers: list[Any] = []
        self.topics: dict[str, TopicInfo] = {}
        with self._named():
            for each in paths:
                reader: Any = Ros1Reader(each) if self.ros1 else Ros2Reader(each)
                reader.open()
                weakref.finalize(self, reader.close)
                self._readers.append(reader)
                for one in reader.connections:
                    known = self.topics.get(one.topic, TopicInfo(one.msgtype, 0))
                    if known.type_name != one.msgtype:
                        raise ReaderError(self.path, f'topic {one.topic} is both '
                                          f'{known.type_name} and {one.msgtype}')
                    self.topics[one.topic] = TopicInfo(one.msgtype, known.count + one.msgcount)
            full = [one for one in self._readers if one.message_count]
            self.start_ns = min((one.start_time for one in full), default=None)
            self.end_ns = max((one.end_time - 1 for one in full), default=None)

    @contextmanager
    def _named(self) -> Iterator[None]:
        """Turn the errors of the library into one line."""
        try:
            yield
        except ReaderError:
            raise
        except _faults() as error:
            raise ReaderError(self.path, f'is damaged, or no bag: {error}') from error

    def resolve(self, topic: str) -> str:
        """Return the name in the bag of a topic given with or without a leading slash."""
        for name in (topic, f'/{topic}'):
            if name in self.topics:
                return name
        present = ', '.join(f'{name} ({info.type_name})'
                            for name, info in sorted(self.topics.items()))
        raise ReaderError(self.path, f'has no topic {topic!r}; it has {present or "no topics"}')

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
        raw: dict[str, list[bytes]] = {name: [] for name in names.values()}

        def hand_out(last: bool) -> dict[str, Headings]:
            found = {key: topic.decode(raw[key[0]], last) for key, topic in once.items()}
            for data in raw.values():
                data.clear()
            return {asked: found[names[asked], convention]
                    for asked, convention in conventions.items()}
        with self._named():
            messages = self._raw(raw)
            append = {name: data.append for name, data in raw.items()}
            while batch := list(islice(messages, _MESSAGES)):
                for name, _, data in batch:
                    append[name](data)
                yield hand_out(False)
            yield hand_out(True)

    def _raw(self, wanted: Iterable[str]) -> Iterator[tuple[str, int, bytes]]:
        """Yield topic, log time and data of messages, as CDR but for sentences of ROS 1."""
        wanted = set(wanted)
        for reader in self._readers:
            mine = [one for one in reader.connections if one.topic in wanted]
            messages = reader.messages(mine) if mine else ()
            if self._store is None:
                for one, time_ns, data in messages:
                    yield one.topic, time_ns, data
                continue
            convert = self._store.ros1_to_cdr
            for one, time_ns, data in messages:
                if one.msgtype != SENTENCE:
                    data = convert(data, one.msgtype)
                yield one.topic, time_ns, data

    def keeps_numbers(self) -> bool:
        """Tell that the numbers of the publishers are not kept."""
        return False

    def messages(self, topics: Iterable[str] | None = None) -> Iterator[BagMessage]:
        """Return an iterator over messages as CDR, in file order; of all topics by default."""
        wanted = {*self.topics} if topics is None else {self.resolve(one) for one in topics}
        with self._named():
            for name, time_ns, data in self._raw(wanted):
                yield BagMessage(name, self.topics[name].type_name, time_ns, time_ns, 0, data)

    def metadata(self) -> dict[str, dict[str, str]]:
        """Return no metadata records."""
        return {}
