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

"""The part of messages that holds the headings, by their type, for bags and live topics alike."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Callable

from heading_intercompare.core.records import Headings, Integers

from .byte_columns import BytesLike, FieldColumn
from .errors import MessageError
from .field_columns import decode_field
from .fields import Definitions
from .heading_fields import find_heading_field
from .heading_messages import decode_headings
from .heading_places import HeadingPlace, LOG_TIME, PUBLISH_TIME
from .sentence_messages import find_sentences
from .transform_messages import TRANSFORM_TYPES, TransformTopic

#: What the stamps are, in words, by their clock.
_CLOCKS = {LOG_TIME: 'the times at which the messages were recorded, later than the headings',
           PUBLISH_TIME: 'the times at which the messages were published'}


@dataclass(frozen=True, slots=True)
class HeadingPart:
    """
    The part of the messages of one type that holds the headings.

    Attributes
    ----------
    decode
        Returns, of the messages of a stretch of bytes, a heading of each, its text, or the
        `Headings` of its transforms; as `decode_field`.
    clock : {'', 'log_time', 'publish_time'}
        Where the stamps come from; '' for the messages themselves.
    sentence
        The sentence to take from the texts; '' for the first present, None if there are no texts.
    transforms
        What reads the transforms; None for other messages.
    assumption
        What was assumed of a field, in words; '' for nothing.

    """

    decode: Callable[[BytesLike, Integers, Integers], FieldColumn]
    clock: str
    sentence: str | None = None
    transforms: TransformTopic | None = None
    assumption: str = ''

    @property
    def remark_on_stamps(self) -> str:
        """Return in words what the stamps are; '' for those of the messages."""
        return f'the stamps are {_CLOCKS[self.clock]}' if self.clock else ''

    @property
    def absence(self) -> str:
        """Return in words that no message had the frames asked for; '' if one had."""
        return self.transforms.absence if self.transforms else ''


def find_part(type_name: str, definitions: Definitions, place: HeadingPlace, convention: str,
              unstamped_clock: str) -> HeadingPart:
    """
    Return the part of the messages of a type that holds the headings.

    Parameters
    ----------
    type_name
        The type of the messages.
    definitions
        The fields of the type, where the place names one.
    place
        What to take from the messages.
    convention : {'enu', 'ned'}
        World axes of orientations, where the place does not state them.
    unstamped_clock : {'log_time', 'publish_time'}
        The clock of messages without a header.

    Raises
    ------
    MessageError
        If the messages have no such part.

    """
    text = find_sentences(type_name, definitions, place.part)
    if text is not None:
        return HeadingPart(partial(decode_field, text[0]),
                           place.clock or ('' if text[0].is_stamped else unstamped_clock),
                           sentence=text[1])
    if not place.part:
        return HeadingPart(
            partial(_as_column, partial(decode_headings, type_name, convention)), place.clock)
    if type_name in TRANSFORM_TYPES:
        if place.clock:
            raise MessageError(f'{place.part}@{place.clock}: each transform has a stamp of '
                               f'its own; leave @{place.clock} out')
        transforms = TransformTopic(place.part, place.axes or convention)
        return HeadingPart(transforms.decode, '', transforms=transforms)
    field = find_heading_field(type_name, definitions, place, convention)
    return HeadingPart(partial(_as_column, field.decode),
                       place.clock or ('' if field.is_stamped else unstamped_clock),
                       assumption=field.remark)


def _as_column(decode: Callable[[BytesLike, Integers, Integers], Headings], data: BytesLike,
               start: Integers, stop: Integers) -> FieldColumn:
    headings = decode(data, start, stop)
    return FieldColumn(headings.stamp_ns, headings.heading_deg)
