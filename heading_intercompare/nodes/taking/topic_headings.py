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
from typing import Callable, Sequence

from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.records import Headings
from heading_intercompare.drivers.sentence_topic import choose_by_name, SentenceTopic
from heading_intercompare.messages.byte_columns import read_sound
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.field_columns import FieldPlace
from heading_intercompare.messages.fields import Definitions, definitions_in
from heading_intercompare.messages.heading_fields import find_heading_field
from heading_intercompare.messages.heading_messages import read_headings
from heading_intercompare.messages.heading_places import HeadingPlace
from heading_intercompare.messages.schemas import schema_of
from heading_intercompare.messages.sentence_messages import (
    find_sentences,
    read_sentences,
    SENTENCE,
)
from heading_intercompare.messages.transform_messages import TRANSFORMS

_Rows = tuple[Headings, list[str]]


def _need_header(type_name: str, is_stamped: bool) -> None:
    if not is_stamped:
        raise MessageError(f'messages of the type {type_name} do not begin with a header, whose '
                           'stamp a reading needs')


class TopicHeadings:
    """
    Reads the headings in the messages of a topic, of the type that its publisher has.

    Parameters
    ----------
    place
        What to take from the messages.
    convention
        World axes of orientations.

    """

    def __init__(self, place: HeadingPlace, convention: str) -> None:
        self._place, self._convention = place, convention
        self._read: Callable[[Sequence[bytes]], _Rows] | None = None
        self._sentences: SentenceTopic | None = None

    def read(self, type_name: str, messages: Sequence[bytes]) -> _Rows:
        """Return the headings in messages of a type, and what is wrong with the unreadable."""
        if not messages:
            return Headings.empty(), []
        try:
            self._read = self._read or self._choose(type_name)
        except (MessageError, SettingsError) as error:
            return Headings.empty(), [str(error)] * len(messages)
        return self._read(messages)

    def _choose(self, type_name: str) -> Callable[[Sequence[bytes]], _Rows]:
        """Return what reads messages of a type; an error if they have no such part."""
        part, clock = self._place.part, self._place.clock
        if clock:
            raise MessageError(f'{part}@{clock}: is a time of a recording; live the stamp is that '
                               'of the header')
        if type_name == TRANSFORMS:
            raise MessageError('transforms are read from recordings, not live')
        definitions: Definitions = {} if type_name == SENTENCE or not part else definitions_in(
            type_name, schema_of(type_name).text)
        text = find_sentences(type_name, definitions, part)
        if text is not None:
            _need_header(type_name, text[0].is_stamped)
            self._sentences = SentenceTopic(choose_by_name(text[1]))
            return partial(self._read_sentences, text[0])
        if not part:
            return partial(read_headings, type_name, self._convention)
        field = find_heading_field(type_name, definitions, self._place, self._convention)
        _need_header(type_name, field.is_stamped)
        return partial(read_sound, field.decode, kind=Headings)

    def _read_sentences(self, place: FieldPlace, messages: Sequence[bytes]) -> _Rows:
        assert self._sentences is not None
        column, refused = read_sentences(place, messages)
        return self._sentences.take(column.stamp_ns, column.values), refused

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
