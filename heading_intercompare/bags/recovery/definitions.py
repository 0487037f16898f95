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
The schemas and channels of a damaged file.

A definition may stand before or after its messages, and more than once. One in a chunk with a
checksum counts more than others. If two of those disagree, nobody knows which messages belong to
which: the number means nothing, so that no message comes under the topic of another.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from mcap import records as mcap
from mcap.opcode import Opcode

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.record_stream import meaning_of, parse_record

_Definition = mcap.Schema | mcap.Channel
#: Opcode and number of a definition.
_Key = tuple[int, int]

#: A channel, and its schema if it has one.
Topic = tuple[mcap.Channel, mcap.Schema | None]


class Definitions:
    """The schemas and channels found in a file."""

    def __init__(self) -> None:
        #: Definitions in chunks with a checksum, and the first ones elsewhere.
        self._checked: dict[_Key, _Definition] = {}
        self._others: dict[_Key, _Definition] = {}
        self._contradicted: dict[_Key, str] = {}
        self._seen: set[tuple[int, bytes, bool]] = set()

    @property
    def contradictions(self) -> list[str]:
        """Return what is defined in two ways, in words."""
        return list(self._contradicted.values())

    def take(self, opcode: int, content: bytes, checked: bool) -> None:
        """
        Take a definition.

        Parameters
        ----------
        opcode, content
            Opcode and content of its record; a damaged one is ignored.
        checked
            It is in a chunk with a correct checksum.

        """
        key = opcode, int.from_bytes(content[:2], 'little')
        if key in self._contradicted or (opcode, content, checked) in self._seen:
            return
        self._seen.add((opcode, content, checked))
        kind: type[_Definition] = mcap.Schema if opcode == Opcode.SCHEMA else mcap.Channel
        try:
            definition = parse_record(kind, content, any_text=checked)
        except BagError:
            return
        first_definition = (self._checked if checked else self._others).setdefault(key, definition)
        if checked and meaning_of(first_definition) != meaning_of(definition):
            what = 'schema' if opcode == Opcode.SCHEMA else 'channel'
            self._contradicted[key] = (
                f'{what} {key[1]} is both {meaning_of(first_definition)[0]} and '
                f'{meaning_of(definition)[0]}')

    def topic(self, number: int) -> Topic | None:
        """Return channel and schema of a number; None if either is lost or contradicted."""
        channel = self._find(Opcode.CHANNEL, number)
        if not isinstance(channel, mcap.Channel):
            return None
        schema = self._find(Opcode.SCHEMA, channel.schema_id) if channel.schema_id else None
        if isinstance(schema, mcap.Schema):
            return channel, schema
        return None if channel.schema_id else (channel, None)

    def _find(self, opcode: int, number: int) -> _Definition | None:
        key = opcode, number
        if key in self._contradicted:
            return None
        return self._checked.get(key) or self._others.get(key)


def means_the_same(first: Topic | None, second: Topic | None) -> bool:
    """Tell whether messages of two channels belong to the same topic and type."""
    return _meaning(first) == _meaning(second)


def _meaning(topic: Topic | None) -> list[tuple[object, ...]]:
    return [meaning_of(part) if part is not None else () for part in topic or ()]


@dataclass(slots=True)
class Section:
    """
    A file, or one of several files that were appended to each other.

    Attributes
    ----------
    known
        The definitions by which its messages have topics; by default those that come before.
    definitions
        Those in it; nothing carries over from one file to another.
    topics
        The topic of each channel that has messages; None if it has none.
    numbers
        The number in the new bag of each of these channels, -1 without topic.
    expected
        Message counts in its statistics; there should be one.
    copied, undefined, untimed, unpackable
        Messages that are copied, that have no topic, that have impossible log times, and that
        were compressed one by one and cannot be decompressed.
    indexed
        Lost messages that the indexes after damaged or missing chunks name.
    closed
        It has an end.

    """

    known: Definitions
    definitions: Definitions
    topics: dict[int, Topic | None] = field(default_factory=dict)
    numbers: dict[int, int] = field(default_factory=dict)
    expected: list[int] = field(default_factory=list)
    copied: int = 0
    undefined: int = 0
    untimed: int = 0
    unpackable: int = 0
    indexed: int = 0
    closed: bool = False

    @property
    def settled(self) -> bool:
        """Whether its messages have the topics that all of its definitions give them."""
        return self.known is not self.definitions or all(
            means_the_same(topic, self.definitions.topic(number))
            for number, topic in self.topics.items())
