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

"""MCAP bags whose headings are sentences, or a field of messages of any type, beside the rest."""

from __future__ import annotations

import os
from typing import Callable, Iterable, Iterator, Mapping, Sequence

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.rosbag2.bag_reader import BagReader, TopicNumbers
from heading_intercompare.core.records import Headings, Losses, Quality
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.fields import Definitions, definitions_in
from heading_intercompare.messages.heading_messages import HEADING_TYPES
from heading_intercompare.messages.heading_places import LOG_TIME, PUBLISH_TIME
from heading_intercompare.messages.sentence_messages import SENTENCE, TOPIC_TYPES
from heading_intercompare.messages.transform_messages import TRANSFORMS

from .stream_recording import tell_no_unit
from .topic_decoding import (
    explain_type,
    find_absence,
    list_keys,
    Logged,
    read_topics,
    TopicDecoder,
    TopicKey,
)

#: A longer schema is not read.
_MOST_LETTERS = 2**18


class TopicBag(BagReader):
    """
    A bag that also reads sentences, and fields of messages; otherwise a `BagReader`.

    With such a topic among those requested, messages are read one by one, in the order of
    `BagReader.messages`.

    Parameters
    ----------
    path, namespace
        As for `BagReader`.
    unit_of
        Returns the unit that is stated for the headings of a topic, 'auto' if none.

    """

    def __init__(self, path: str | os.PathLike[str], namespace: str | None = None,
                 unit_of: Callable[[str], str] = tell_no_unit) -> None:
        super().__init__(path, namespace)
        self._unit_of = unit_of

    def headings(self, conventions: Mapping[str, str], helpers: int = 0,
                 lost: Callable[[str, str, Losses], None] | None = None,
                 claimed: Mapping[str, Callable[[Quality], None]] | None = None,
                 ) -> Iterator[dict[str, Headings]]:
        """Return an iterator over the headings of some topics; see `BagReader.headings`."""
        if self.tells_claims(conventions):
            return super().headings(conventions, helpers, lost, claimed)
        keys = self._list_keys(conventions)
        decoders = {key: self._make_decoder(key) for key in keys.values()}
        return self._read_messages(keys, decoders, lost)

    def _list_keys(self, conventions: Mapping[str, str]) -> dict[str, TopicKey]:
        return list_keys(self.resolve, conventions, self._unit_of)

    def tells_claims(self, conventions: Mapping[str, str]) -> bool:
        """Tell whether the messages are not read one by one."""
        return not any(key.place.part or self.topics[key.name].type_name not in HEADING_TYPES
                       for key in self._list_keys(conventions).values())

    def _make_decoder(self, key: TopicKey) -> TopicDecoder:
        """Return what decodes a topic; BagError if its messages have no such headings."""
        type_name = self.topics[key.name].type_name
        definitions: Definitions = {}
        if key.place.part and type_name == TRANSFORMS:
            self.check_heading(key.name, (TRANSFORMS,))
        elif key.place.part and type_name != SENTENCE:
            definitions = self._read_definitions(key.name)
        elif type_name not in TOPIC_TYPES:
            raise BagError(explain_type(key.name, type_name, self._read_definitions), self.path)
        else:
            self.check_heading(key.name, TOPIC_TYPES)
        try:
            return TopicDecoder(type_name, key.place, key.convention, definitions,
                                PUBLISH_TIME if self.is_ours() else LOG_TIME)
        except ValueError as error:
            raise BagError(f'topic {key.name}: {error}', self.path) from error

    def _read_definitions(self, name: str) -> Definitions:
        """Return the fields of the type of a topic, by the schema of its first channel."""
        part, schema = next((part, part.schemas.get(channel.schema_id)) for part in self._parts
                            for channel in part.channels.values() if channel.topic == name)
        if schema is None or schema.encoding != 'ros2msg' or len(schema.data) > _MOST_LETTERS:
            encoding = 'no schema' if schema is None else f'a schema of {len(schema.data)} bytes, '
            raise BagError(f'topic {name}: its channel has {encoding}'
                           + (f'{schema.encoding!r}; must be ros2msg' if schema else ''),
                           part.path)
        try:
            return definitions_in(schema.name, schema.data.decode(errors='replace'))
        except MessageError as error:
            raise BagError(f'topic {name}: {error}', part.path) from error

    def _read_messages(self, keys: Mapping[str, TopicKey],
                       decoders: Mapping[TopicKey, TopicDecoder],
                       lost: Callable[[str, str, Losses], None] | None,
                       ) -> Iterator[dict[str, Headings]]:
        numbers = self._begin_counts(decoders) if lost is not None else {}

        def tell_gaps(key: TopicKey, messages: Sequence[Logged]) -> None:
            if lost is None or key not in numbers or not messages:
                return
            for lost_as, losses in numbers[key].find_gaps(
                    [message.sequence for message in messages], decoders[key].stamp_ns):
                for asked in (asked for asked, of in keys.items() if of == key):
                    lost(asked, lost_as, losses)
        messages = ((message.topic, Logged(message.log_time_ns, message.sequence, message.data,
                                           message.publish_time_ns))
                    for message in self.messages({key.name for key in decoders}, in_order=True))
        yield from read_topics(messages, keys, decoders, self.oddities, tell_gaps)
        if absence := find_absence(decoders):
            raise BagError(absence, self.path)

    def _begin_counts(self, keys: Iterable[TopicKey]) -> Mapping[TopicKey, TopicNumbers]:
        """Return the numbers of the topics whose losses count, before the first one."""
        # Each publisher of transforms numbers its own.
        counted = [key for key in keys if self.topics[key.name].type_name != TRANSFORMS]
        if not self.keeps_numbers():
            return {}
        return dict(zip(counted, self.begin_numbers(
            [(key.name, ' '.join((*key.place[1:], key.convention))) for key in counted])))
