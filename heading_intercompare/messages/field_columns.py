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
One field of messages of any type with a header, in columns, by the definition of the type.

The definition may come from an installed package, a schema in a bag, or from `schemas`. The walk
to the field goes through all messages at once: what lies before it may differ in length.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from itertools import chain, islice, repeat
import struct
from typing import Iterator, Literal, NamedTuple

import numpy as np

from heading_intercompare.core.records import Integers

from .byte_columns import (
    align,
    BytesLike,
    check_size,
    decode_stamped,
    end_of_strings,
    FieldColumn,
    gather,
    read_stamps,
)
from .errors import MessageError
from .fields import CODES, Definitions, Field, SEQUENCE, short_name

_HEADER = 'std_msgs/Header'
_HEAD_BYTES = 4
#: Fixed arrays of messages are walked element by element.
_MOST_STEPS = 10_000


class _Step(NamedTuple):
    """Values, a text or a list to go past: letter of `CODES`, and how many; SEQUENCE: a list."""

    code: str
    n: int

    @property
    def width(self) -> int:
        return struct.calcsize(f'<{self.code}')


@dataclass(frozen=True, slots=True)
class FieldPlace:
    """
    Where a field is in the messages of a type.

    Attributes
    ----------
    type_name
        The type.
    path
        Names of the field and of those it is in, with dots between them.
    code
        Letter of `CODES`; 's' for a text.
    steps
        What lies between the header and the field.

    """

    type_name: str
    path: str
    code: str
    steps: tuple[_Step, ...]


def find_field(type_name: str, definitions: Definitions, path: str) -> FieldPlace:
    """
    Return where a field is in the messages of a type.

    Parameters
    ----------
    type_name
        The type, which begins with a header.
    definitions
        Its fields and those of the types in it, from `definitions_in`.
    path
        Names with dots between them: `pose.orientation.z`.

    Raises
    ------
    MessageError
        If the type has no header or no such field, or if the field is a message or a list, or lies
        after a list of messages or texts.

    Examples
    --------
    >>> from .schemas import definitions_of
    >>> odometry = 'nav_msgs/msg/Odometry'
    >>> find_field(odometry, definitions_of(odometry), 'pose.pose.position.y').code
    'd'

    """
    name = short_name(type_name)
    fields = _fields_of(name, definitions)
    if not fields or (fields[0].type, fields[0].size) != (_HEADER, None):
        raise MessageError(f'messages of the type {type_name} do not begin with a header, whose '
                           'stamp a reading needs')
    steps: list[_Step] = []
    owner, words = name, path.split('.')
    for depth, word in enumerate(words):
        fields = _fields_of(owner, definitions)
        target = next((field for field in fields if field.name == word), None)
        if target is None:
            known = ', '.join(field.name for field in fields)
            raise MessageError(f'{path}: {owner} has no field {word!r}; it has {known}')
        for field in fields[not depth:fields.index(target)]:
            # A few lines of types within types can mean more values than any memory holds.
            steps += islice(_list_steps(field, definitions), _MOST_STEPS + 1)
            if len(steps) > _MOST_STEPS:
                raise MessageError(f'{path}: too much lies before it in {type_name}')
        if target.size is not None:
            raise MessageError(f'{path}: {word} is a list; choose a single value')
        owner = target.type
        is_last = depth == len(words) - 1
        if is_last != (owner in CODES):
            raise MessageError(f'{path}: {word} is {"" if is_last else "not "}a message; '
                               + ('choose one of its fields' if is_last else 'it has no fields'))
    return FieldPlace(type_name, path, CODES[owner], tuple(steps))


def _fields_of(name: str, definitions: Definitions) -> tuple[Field, ...]:
    try:
        return definitions[name]
    except KeyError:
        raise MessageError(f'message type {name} is not defined in the schema') from None


def _list_steps(field: Field, definitions: Definitions, depth: int = 20) -> Iterator[_Step]:
    """Yield what to go past for a field; MessageError for a list whose elements differ in size."""
    if field.size == 0:
        raise MessageError(f'{field.name} is an empty list')
    if field.type in CODES and (field.size != SEQUENCE or field.type != 'string'):
        count = 1 if field.size is None else field.size
        if field.type == 'string':
            yield from repeat(_Step('s', 1), count)
        else:
            yield _Step(CODES[field.type], count)
        return
    if field.size == SEQUENCE or not depth:
        raise MessageError(f'what lies after {field.name}, a list of {field.type}, cannot be read')
    fields = _fields_of(field.type, definitions)
    if not fields:
        # Nested, such types would take a time that doubles with each line of the text.
        raise MessageError(f'message type {field.type} has no field')
    for part in chain.from_iterable(repeat(fields, 1 if field.size is None else field.size)):
        yield from _list_steps(part, definitions, depth - 1)


def decode_field(place: FieldPlace, data: BytesLike, start: Integers,
                 stop: Integers) -> FieldColumn:
    """
    Return the stamps and the values of a field in the messages of a stretch of bytes.

    Parameters
    ----------
    place
        Where the field is.
    data : bytes-like
        Any bytes that hold the messages.
    start, stop : ndarray of int64, shape (n,)
        First byte of each message, and the byte after its last.

    Returns
    -------
    FieldColumn
        In the order of `start`; texts as bytes without the zero at their end.

    Raises
    ------
    MessageError
        If a message is too short or does not start as CDR; the offset is its place in `data`.

    """
    return decode_stamped(place.type_name, data, start, stop, partial(_decode, place))


def _decode(place: FieldPlace, data: BytesLike, start: Integers, size: Integers,
            header: np.ndarray) -> FieldColumn:
    """Return the field in messages of one byte order."""
    sign, end = end_of_strings(header)
    walk = _Walk(place.type_name, data, start, size, sign, end)
    for step in place.steps:
        walk.go_past(step)
    values = walk.take_texts() if place.code == 's' else walk.take_values(place.code)
    return FieldColumn(read_stamps(header), values)


class _Walk:
    """A place in each message of one byte order, counted from the end of its first four bytes."""

    def __init__(self, type_name: str, data: BytesLike, start: Integers, size: Integers,
                 sign: Literal['<', '>'], end: Integers | int) -> None:
        self._type_name, self._data, self._start, self._size = type_name, data, start, size
        self._sign, self._at = sign, end

    def _take(self, code: str, count: int = 1) -> Integers:
        """Go past values of one size; return the offset of the first in the data."""
        width = struct.calcsize(f'<{code}')
        at = align(self._at, width)
        self._at = at + width * count
        check_size(self._type_name, self._start, self._size, self._at + _HEAD_BYTES)
        offsets: Integers = self._start + (at + _HEAD_BYTES)
        return offsets

    def _take_length(self) -> Integers:
        lengths: Integers = gather(self._data, f'{self._sign}u4', self._take('I')).astype(np.int64)
        return lengths

    def go_past(self, step: _Step) -> None:
        """Go past a value, a text or a list."""
        if step.code == 's':
            self._at = self._at_end_of(self._take_length())
        elif step.n == SEQUENCE:
            lengths = self._take_length()
            self._at = np.where(lengths > 0, align(self._at, step.width), self._at)
            self._at = self._at_end_of(lengths * step.width)
        else:
            self._take(step.code, step.n)

    def _at_end_of(self, lengths: Integers) -> Integers:
        ends: Integers = self._at + lengths
        check_size(self._type_name, self._start, self._size, ends + _HEAD_BYTES)
        return ends

    def take_values(self, code: str) -> np.ndarray:
        """Return the value in each message as a float."""
        return gather(self._data, f'{self._sign}{code}', self._take(code)).astype(float)

    def take_texts(self) -> np.ndarray:
        """Return the text in each message as bytes."""
        lengths = self._take_length()
        begins = self._start + (self._at + _HEAD_BYTES)
        self._at_end_of(lengths)
        texts = np.empty(len(lengths), object)
        texts[:] = [bytes(self._data[begin:begin + length]).rstrip(b'\0')
                    for begin, length in zip(begins.tolist(), lengths.tolist())]
        return texts
