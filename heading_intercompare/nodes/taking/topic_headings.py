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

"""The messages of a topic to the headings of a sensor, as they come."""

from __future__ import annotations

from functools import partial
from typing import Sequence

import numpy as np

from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.records import Headings
from heading_intercompare.drivers.sentence_topic import choose_by_name, SentenceTopic
from heading_intercompare.messages.byte_columns import (
    decode_readable,
    FieldColumn,
    join_messages,
)
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.fields import Definitions, definitions_in
from heading_intercompare.messages.heading_parts import find_part, HeadingPart
from heading_intercompare.messages.heading_places import HeadingPlace, LOG_TIME, PUBLISH_TIME
from heading_intercompare.messages.schemas import schema_of
from heading_intercompare.messages.sentence_messages import SENTENCE

from .reception import Message


class TopicHeadings:
    """
    Reads the headings in the messages of a topic, of the type that its publisher has.

    Messages without a header have the time at which they were sent. It is the same for all who
    hear the topic, and the publish time in a bag; each receives them at a time of its own.

    Parameters
    ----------
    place
        What to take from the messages.
    convention
        World axes of orientations.

    """

    def __init__(self, place: HeadingPlace, convention: str) -> None:
        self._place, self._convention = place, convention
        self._part: HeadingPart | None = None
        self._sentences: SentenceTopic | None = None

    def read(self, type_name: str, messages: Sequence[Message]) -> tuple[Headings, list[str]]:
        """Return the headings in messages of a type, and what is wrong with the unreadable."""
        if not messages:
            return Headings.empty(), []
        try:
            part = self._part or self._choose(type_name)
        except (MessageError, SettingsError) as error:
            return Headings.empty(), [str(error)] * len(messages)
        data, starts, stops = join_messages([data for data, _ in messages])
        column, readable, problem = decode_readable(partial(part.decode, data), starts, stops)
        if part.clock:
            sent_ns = np.array([info['source_timestamp'] for _, info in messages], np.int64)
            column = FieldColumn(sent_ns[readable], column.values)
        return self._take(column), [problem] * int((~readable).sum())

    def _choose(self, type_name: str) -> HeadingPart:
        """Choose what to read in messages of a type; an error if they have no such part."""
        name = self._place.part
        if self._place.clock == LOG_TIME:
            raise MessageError(f'{name}@{LOG_TIME}: is the time of one recorder; live write '
                               f'{name}@{PUBLISH_TIME}, which all who hear the topic share')
        definitions: Definitions = {} if type_name == SENTENCE or not name else definitions_in(
            type_name, schema_of(type_name).text)
        part = find_part(type_name, definitions, self._place, self._convention, PUBLISH_TIME)
        if part.sentence is not None:
            self._sentences = SentenceTopic(choose_by_name(part.sentence))
        self._part = part
        return part

    def _take(self, column: FieldColumn) -> Headings:
        if self._sentences is not None:
            return self._sentences.take(column.stamp_ns, column.values)
        if self._part is not None and self._part.transforms is not None:
            return Headings.concatenate(column.values)
        return Headings(column.stamp_ns, column.values)

    def flush(self) -> Headings:
        """Return the headings held until a sentence is chosen, at the end of the topic."""
        return Headings.empty() if self._sentences is None else self._sentences.flush()

    @property
    def sentence(self) -> str | None:
        """Return the sentence taken; None while it listens, and for other messages."""
        return None if self._sentences is None else self._sentences.sentence

    @property
    def counts(self) -> dict[str, int] | None:
        """Return the sentences that gave no heading, by reason; None for other messages."""
        return None if self._sentences is None else self._sentences.counts

    @property
    def remark(self) -> str:
        """Return what is assumed of the headings, and what their stamps are; '' for nothing."""
        part = self._part
        return '; '.join(filter(None, [part.assumption, part.remark_on_stamps])) if part else ''

    @property
    def absence(self) -> str:
        """Return in words that no message had the frames asked for; '' if one had."""
        return '' if self._part is None else self._part.absence
