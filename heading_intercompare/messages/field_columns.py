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
One field of messages of any type, in columns, by the definition of the type.

The definition may come from an installed package, a schema in a bag, or from `schemas`. The walk
to the field goes through all messages at once: what lies before it may differ in length.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from itertools import chain, islice, repeat
import re
import struct
from typing import Iterator, Literal, NamedTuple, Sequence

import numpy as np

from heading_intercompare.core.records import Integers

from .byte_columns import (
    align,
    BytesLike,
    check_size,
    decode_stamped,
    end_of_strings,
    FieldColumn,
    find_byte_order,
    gather,
    read_stamps,
)
from .errors import MessageError
from .fields import CODES, Definitions, Field, SEQUENCE, short_name

_HEADER = 'std_msgs/Header'
_HEAD_BYTES = 4
#: Arrays and lists of messages are walked element by element.
_MOST_STEPS = 10_000
_ELEMENT = re.compile(r'(\w+)\[(\d{1,4})\]')


class _Step(NamedTuple):
    """
    Values, a text or a list to go past: letter of `CODES`, and how many; SEQUENCE: a list.

    A list of texts or messages has the steps of one element instead of a letter.
    """

    code: str
    n: int
    element: tuple[_Step, ...] = ()

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
        What lies between the header, or the beginning, and the field.
    is_stamped
        The messages begin with a header.

    """

    type_name: str
    path: str
    code: str
    steps: tuple[_Step, ...]
    is_stamped: bool = True


def find_field(type_name: str, definitions: Definitions, path: str) -> FieldPlace:
    """
    Return where a field is in the messages of a type.

    Parameters
    ----------
    type_name
        The type.
    definitions
        Its fields and those of the types in it, from `definitions_in`.
    path
        Names with dots between them, the last with the number of an element if it is an array:
        `pose.orientation.z`, `angles[2]`.

    Raises
    ------
    MessageError
        If the type has no such field, or if the field is a message or a list.

    Examples
    --------
    >>> from .schemas import definitions_of
    >>> odometry = 'nav_msgs/msg/Odometry'
    >>> find_field(odometry, definitions_of(odometry), 'pose.pose.position.y').code
    'd'

    """
    owner = short_name(type_name)
    is_stamped = _begins_with_header(_fields_of(owner, definitions))
    steps: list[_Step] = []
    lists: dict[str, tuple[_Step, ...]] = {}
    words = path.split('.')
    if is_stamped and words[0] == definitions[owner][0].name:
        raise MessageError(f'{path}: lies in the header, which has no heading')
    for depth, word in enumerate(words):
        fields = _fields_of(owner, definitions)
        target = _choose_field(fields, word.partition('[')[0], owner, path)
        for field in fields[int(is_stamped and not depth):fields.index(target)]:
            steps += _limit(_list_steps(field, definitions, lists), field.name, type_name)
        steps += _enter(target, word, path)
        owner = target.type
        if depth < len(words) - 1 and owner in CODES:
            raise MessageError(f'{path}: {word} is not a message; it has no fields')
    if owner not in CODES:
        names = ', '.join(field.name for field in _fields_of(owner, definitions))
        raise MessageError(f'{path}: {words[-1]} is a message; choose one of its fields: {names}')
    return FieldPlace(type_name, path, CODES[owner], tuple(steps), is_stamped)


def _begins_with_header(fields: Sequence[Field]) -> bool:
    return bool(fields) and (fields[0].type, fields[0].size) == (_HEADER, None)


def _choose_field(fields: Sequence[Field], word: str, owner: str, path: str) -> Field:
    for field in fields:
        if field.name == word:
            return field
    names = ', '.join(field.name for field in fields)
    raise MessageError(f'{path}: {owner} has no field {word!r}; it has {names}')


def _enter(target: Field, word: str, path: str) -> list[_Step]:
    """Return what to go past within a field, for a word with the number of an element."""
    element = _ELEMENT.fullmatch(word)
    if element is None:
        if word != target.name:
            raise MessageError(f'{path}: {word!r} is no field; an element is {target.name}[0]')
        if target.size is not None:
            raise MessageError(f'{path}: {word} is a list; choose a single value'
                               + (f', such as {word}[0]' if target.size > 0 else ''))
        return []
    if target.size is None or target.type not in CODES or target.type == 'string':
        raise MessageError(f'{path}: {target.name} is no array of numbers')
    number = int(element[2])
    if number >= target.size:
        raise MessageError(f'{path}: {target.name} has no element {number} in every message')
    return [_Step(CODES[target.type], number)] if number else []


def list_fields(type_name: str, definitions: Definitions, path: str) -> tuple[Field, ...]:
    """Return the fields of the message at a path, '' for the whole; () if no message is there."""
    owner = short_name(type_name)
    for word in path.split('.') if path else ():
        owner = next((field.type for field in definitions.get(owner, ())
                      if field.name == word and field.size is None), '')
    return tuple(definitions.get(owner, ()))


def _fields_of(name: str, definitions: Definitions) -> tuple[Field, ...]:
    try:
        return definitions[name]
    except KeyError:
        raise MessageError(f'message type {name} is not defined in the schema') from None


def _limit(steps: Iterator[_Step], name: str, owner: str) -> list[_Step]:
    """Return steps; MessageError for too many: few lines of types can mean any number."""
    listed = list(islice(steps, _MOST_STEPS + 1))
    if len(listed) > _MOST_STEPS:
        raise MessageError(f'too much lies within {name} of {owner}')
    return listed


def _list_steps(field: Field, definitions: Definitions, lists: dict[str, tuple[_Step, ...]],
                depth: int = 20) -> Iterator[_Step]:
    """Yield what to go past for a field; `lists` keeps the steps of an element by its type."""
    if field.size == 0:
        raise MessageError(f'{field.name} is an empty list')
    if field.size == SEQUENCE and field.type not in CODES.keys() - {'string'}:
        if field.type not in lists:
            element = Field(field.name, field.type, None)
            lists[field.type] = tuple(_limit(
                _list_steps(element, definitions, lists, depth), field.name, field.type))
        yield _Step('', SEQUENCE, lists[field.type])
        return
    count = 1 if field.size is None else field.size
    if field.type == 'string':
        yield from repeat(_Step('s', 1), count)
        return
    if field.type in CODES:
        yield _Step(CODES[field.type], count)
        return
    if not depth:
        raise MessageError(f'message type {field.type} lies too deep')
    fields = _fields_of(field.type, definitions)
    if not fields:
        # Nested, such types would take a time that doubles with each line of the text.
        raise MessageError(f'message type {field.type} has no field')
    for part in chain.from_iterable(repeat(fields, count)):
        yield from _list_steps(part, definitions, lists, depth - 1)


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
        In the order of `start`; texts as bytes without the zero at their end. Stamps are 0 where
        the messages have none.

    Raises
    ------
    MessageError
        If a message is too short or does not start as CDR; the offset is its place in `data`.

    """
    return decode_stamped(place.type_name, data, start, stop, partial(decode_values, place),
                          is_stamped=place.is_stamped)


def decode_values(place: FieldPlace, data: BytesLike, start: Integers, size: Integers,
                  header: np.ndarray) -> FieldColumn:
    """Return the field in messages of one byte order."""
    stamp_ns = read_stamps(header) if place.is_stamped else np.zeros(len(header), np.int64)
    walk = _walk_to(place, data, start, size, header)
    values = walk.take_texts() if place.code == 's' else walk.take_values(place.code)
    return FieldColumn(stamp_ns, values)


def find_offset(place: FieldPlace, data: BytesLike, start: Integers, stop: Integers) -> int:
    """Return where a number lies in the first of some messages, counted from its first byte."""
    def decode_one(data: BytesLike, start: Integers, size: Integers,
                   header: np.ndarray) -> FieldColumn:
        walk = _walk_to(place, data, start, size, header)
        return FieldColumn(start, walk.take_offsets(place.code) - start)
    return int(decode_stamped(place.type_name, data, start[:1], stop[:1], decode_one,
                              is_stamped=place.is_stamped).values[0])


def _walk_to(place: FieldPlace, data: BytesLike, start: Integers, size: Integers,
             header: np.ndarray) -> _Walk:
    """Return the place of a field in messages of one byte order."""
    sign, end = end_of_strings(header) if place.is_stamped else (find_byte_order(header), 0)
    walk = _Walk(place.type_name, data, start, size, sign, end)
    for step in place.steps:
        walk.go_past(step)
    return walk


class _Walk:
    """A place in each message of one byte order, counted from the end of its first four bytes."""

    def __init__(self, type_name: str, data: BytesLike, start: Integers, size: Integers,
                 sign: Literal['<', '>'], end: Integers | int) -> None:
        self._type_name, self._data, self._start, self._size = type_name, data, start, size
        self._sign, self._at = sign, end

    def take_offsets(self, code: str, count: int = 1) -> Integers:
        """Go past values of one size; return the offset of the first in the data."""
        width = struct.calcsize(f'<{code}')
        at = align(self._at, width)
        self._at = at + width * count
        check_size(self._type_name, self._start, self._size, self._at + _HEAD_BYTES)
        offsets: Integers = self._start + (at + _HEAD_BYTES)
        return offsets

    def _take_length(self) -> Integers:
        lengths = gather(self._data, f'{self._sign}u4', self.take_offsets('I'))
        return lengths.astype(np.int64)

    def go_past(self, step: _Step) -> None:
        """Go past a value, a text or a list."""
        if step.code == 's':
            self._at = self._at_end_of(self._take_length())
        elif step.element:
            self._go_past_elements(self._take_length(), step.element)
        elif step.n == SEQUENCE:
            lengths = self._take_length()
            self._at = np.where(lengths > 0, align(self._at, step.width), self._at)
            self._at = self._at_end_of(lengths * step.width)
        else:
            self.take_offsets(step.code, step.n)

    def _go_past_elements(self, lengths: Integers, element: Sequence[_Step]) -> None:
        """Go past the texts or messages of a list, whose number differs."""
        check_size(self._type_name, self._start, self._size, lengths + self._at + _HEAD_BYTES)
        too_many = lengths > _MOST_STEPS
        if too_many.any():
            raise MessageError(f'{self._type_name} message has a list of {lengths.max()} elements '
                               f'before the field: must be at most {_MOST_STEPS}',
                               offset=int(self._start[too_many][0]),
                               offsets=self._start[too_many].tolist())
        ends: Integers = np.broadcast_to(self._at, lengths.shape).copy()
        for number in range(int(lengths.max(initial=0))):
            rows = np.flatnonzero(lengths > number)
            walk = _Walk(self._type_name, self._data, self._start[rows], self._size[rows],
                         self._sign, ends[rows])
            for step in element:
                walk.go_past(step)
            ends[rows] = walk._at
        self._at = ends

    def _at_end_of(self, lengths: Integers) -> Integers:
        ends: Integers = self._at + lengths
        check_size(self._type_name, self._start, self._size, ends + _HEAD_BYTES)
        return ends

    def take_values(self, code: str) -> np.ndarray:
        """Return the value in each message as a float."""
        return gather(self._data, f'{self._sign}{code}', self.take_offsets(code)).astype(float)

    def take_texts(self) -> np.ndarray:
        """Return the text in each message as bytes."""
        lengths = self._take_length()
        begins = self._start + (self._at + _HEAD_BYTES)
        self._at_end_of(lengths)
        texts = np.empty(len(lengths), object)
        texts[:] = [bytes(self._data[begin:begin + length]).rstrip(b'\0')
                    for begin, length in zip(begins.tolist(), lengths.tolist())]
        return texts
