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

from .field_columns import FieldPlace, find_field, list_fields
from .fields import Definitions
from .heading_messages import HEADING_TYPES
from .schemas import definitions_of

SENTENCE = 'nmea_msgs/msg/Sentence'
"""The type of messages with a sentence."""

TOPIC_TYPES = (*HEADING_TYPES, SENTENCE)
"""All types whose messages have headings without a part being named."""

_PLACE = find_field(SENTENCE, definitions_of(SENTENCE), 'sentence')


def find_sentences(type_name: str, definitions: Definitions,
                   part: str) -> tuple[FieldPlace, str] | None:
    """
    Return where the sentences in messages of a type are, and which is asked for.

    Parameters
    ----------
    type_name
        The type.
    definitions
        Its fields, as for `find_field`; those of `SENTENCE` are known.
    part
        A sentence, `HEHDT`; of another type after a field with a text, `data.HEHDT`.

    Returns
    -------
    tuple or None
        None if the part names no text.

    """
    if type_name == SENTENCE:
        return _PLACE, part
    path, _, sentence = part.rpartition('.')
    owner, _, name = path.rpartition('.')
    is_text = any((field.name, field.type, field.size) == (name, 'string', None)
                  for field in list_fields(type_name, definitions, owner))
    return (find_field(type_name, definitions, path), sentence) if is_text else None
