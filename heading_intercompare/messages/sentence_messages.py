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

"""NMEA sentences in messages: their stamps and texts, for bags and live topics alike."""

from __future__ import annotations

from typing import Sequence

from heading_intercompare.core.records import Integers

from .byte_columns import BytesLike, FieldColumn, read_sound
from .field_columns import decode_field, find_field
from .heading_messages import HEADING_TYPES
from .schemas import definitions_of

SENTENCE = 'nmea_msgs/msg/Sentence'
"""The type of messages with a sentence."""

TOPIC_TYPES = (*HEADING_TYPES, SENTENCE)
"""All types whose messages have headings without a part being named."""

_PLACE = find_field(SENTENCE, definitions_of(SENTENCE), 'sentence')


def decode_sentences(data: BytesLike, start: Integers, stop: Integers) -> FieldColumn:
    """Return the sentences in the messages of a stretch of bytes; see `decode_field`."""
    return decode_field(_PLACE, data, start, stop)


def read_sentences(messages: Sequence[bytes]) -> tuple[FieldColumn, list[str]]:
    """Return the sentences in single messages, and what is wrong with each unreadable one."""
    return read_sound(decode_sentences, messages, FieldColumn)
