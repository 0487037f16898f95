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

"""Fields of ROS message types, read from definition texts."""

from __future__ import annotations

from dataclasses import dataclass
import re
from typing import Iterator, Mapping

from .errors import MessageError

#: Letters of `struct` for the primitive types; 's' stands for strings here.
CODES = {'bool': '?', 'byte': 'B', 'octet': 'B', 'char': 'B', 'uint8': 'B', 'int8': 'b',
         'int16': 'h', 'uint16': 'H', 'int32': 'i', 'uint32': 'I', 'int64': 'q', 'uint64': 'Q',
         'float32': 'f', 'float64': 'd', 'string': 's'}

#: Marks a field that is a sequence of any length.
SEQUENCE = -1

_DEEPEST = 20
_SEPARATOR = re.compile(r'^={3,}[ \t]*\r?\n', re.MULTILINE)
_FIELD = re.compile(r'(?P<type>[A-Za-z][\w/]*)(?:<=\d+)?(?:\[(?P<size>(?:<=)?\d*)\])?'
                    r'[ \t]+(?P<name>[A-Za-z]\w*)[ \t]*(?P<constant>=(?!=))?')


@dataclass(frozen=True, slots=True)
class Field:
    """
    One field of a message.

    Attributes
    ----------
    name
        As in the definition.
    type
        A key of `CODES`, or a message type as package/Type.
    size
        Elements of a fixed array, `SEQUENCE`, or None for a single value.

    """

    name: str
    type: str
    size: int | None


Definitions = Mapping[str, tuple[Field, ...]]


def full_name(type_name: str) -> str:
    """Return package/Type as package/msg/Type; other names unchanged."""
    return type_name if '/msg/' in type_name else type_name.replace('/', '/msg/', 1)


def short_name(type_name: str) -> str:
    """Return package/msg/Type as package/Type; other names unchanged."""
    return type_name.replace('/msg/', '/')


def _fields(package: str, text: str) -> Iterator[Field]:
    for line in text.splitlines():
        line = line.split('#', 1)[0].strip()
        if not line:
            continue
        match = _FIELD.match(line)
        if match is None:
            raise MessageError(f'message definition of package {package!r}: cannot read {line!r}')
        if match['constant']:
            continue
        kind = short_name(match['type'])
        if kind not in CODES and '/' not in kind:
            kind = f'{package}/{kind}'
        size = match['size']
        if size is not None:
            size = int(size) if size.isdigit() else SEQUENCE
        yield Field(match['name'], kind, size)


def definitions_in(type_name: str, text: str) -> Definitions:
    """
    Return the fields of a type and of the types it depends on.

    Parameters
    ----------
    type_name
        The type that the text begins with.
    text
        A definition, then the definitions it depends on. Each of these follows a line of equals
        signs and a line 'MSG: package/Type', as in MCAP schemas of encoding ros2msg.

    Raises
    ------
    MessageError
        If a line is not a field, a constant or a comment.

    """
    first, *others = _SEPARATOR.split(text)
    definitions = {}
    sections = [(short_name(type_name), first)]
    for section in others:
        head, _, body = section.partition('\n')
        sections.append((short_name(head.partition('MSG:')[2].strip()), body))
    for name, body in sections:
        definitions[name] = tuple(_fields(name.partition('/')[0], body))
    return definitions


def leaves(type_name: str, definitions: Definitions,
           depth: int = _DEEPEST) -> Iterator[tuple[str, str, int | None]]:
    """
    Yield path, letter of `CODES` and size of all primitive fields, in wire order.

    Raises
    ------
    MessageError
        If a type is not defined, has no field, or contains itself.

    """
    if type_name not in definitions or not depth:
        raise MessageError(f'message type {type_name} is not defined in the schema')
    if not definitions[type_name]:
        # Nested, such types would take a time that doubles with each line of the text.
        raise MessageError(f'message type {type_name} has no field')
    for field in definitions[type_name]:
        if field.type in CODES:
            yield field.name, CODES[field.type], field.size
            continue
        if field.size is not None:
            yield f'{field.name}[]', '', field.size
        for path, code, size in leaves(field.type, definitions, depth - 1):
            yield f'{field.name}.{path}', code, size
