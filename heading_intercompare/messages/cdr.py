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
Single messages to bytes and back: XCDR1, as ROS 2 sends and records it.

The first four bytes give the byte order. The fields follow, each aligned to its own size, counted
from the end of those four bytes. `heading_messages` converts whole chunks at once.
"""

from __future__ import annotations

from functools import lru_cache
import struct
from typing import Any, Mapping

from .errors import MessageError
from .fields import CODES, Field, SEQUENCE, short_name
from .schemas import definitions_of

_LITTLE = b'\x00\x01\x00\x00'
_BYTE_ORDER = {b'\x00\x00': '>', b'\x00\x01': '<'}
#: Format of the lengths of strings and sequences, by byte order.
_LENGTH = {order: struct.Struct(f'{order}I') for order in '<>'}
_SIZE = {code: struct.calcsize(f'<{code}') for code in CODES.values()}


@lru_cache(maxsize=None)
def _names(type_name: str, name: str) -> frozenset[str]:
    """Return the field names of a type, or of a type nested in it."""
    return frozenset(field.name for field in definitions_of(type_name)[name])


def _padding(position: int, size: int) -> int:
    return -position % size


class _Encoder:
    """Appends fields to a little-endian body."""

    def __init__(self, type_name: str) -> None:
        self._type_name = type_name
        self._definitions = definitions_of(type_name)
        self.body = bytearray()

    def _put(self, code: str, *values: Any) -> None:
        self.body += bytes(_padding(len(self.body), _SIZE[code]))
        self.body += struct.pack(f'<{len(values)}{code}', *values)

    def _put_length(self, length: int) -> None:
        self.body += bytes(_padding(len(self.body), 4)) + _LENGTH['<'].pack(length)

    def message(self, name: str, message: Mapping[str, Any]) -> None:
        names = _names(self._type_name, name)
        if not names.issuperset(message):
            raise MessageError(f'{name} has no field {min(message.keys() - names)!r}')
        for field in self._definitions[name]:
            self._field(name, field, message.get(field.name))

    def _field(self, owner: str, field: Field, value: Any) -> None:
        if field.type == 'string' and field.size is None:
            self._string(value)
            return
        if field.size is None:
            values = [value]
        else:
            values = [None] * max(field.size, 0) if value is None else list(value)
            if field.size == SEQUENCE:
                self._put_length(len(values))
            elif len(values) != field.size:
                raise MessageError(f'{owner}.{field.name} has {len(values)} elements instead of '
                                   f'{field.size}')
        if field.type not in CODES:
            for element in values:
                self.message(field.type, element or {})
        elif field.type == 'string':
            for element in values:
                self._string(element)
        elif values:
            try:
                self._put(CODES[field.type], *(0 if v is None else v for v in values))
            except struct.error as error:
                raise MessageError(f'{owner}.{field.name} = {value!r}: {error}') from None

    def _string(self, value: str | None) -> None:
        data = (value or '').encode() + b'\0'
        self._put_length(len(data))
        self.body += data


class _Decoder:
    """Takes fields from a body."""

    def __init__(self, type_name: str, data: bytes) -> None:
        order = _BYTE_ORDER.get(bytes(data[:2]))
        if order is None or len(data) < 4:
            raise MessageError(f'{type_name} message does not start as CDR: {bytes(data[:4])!r}')
        self._type_name = type_name
        self._definitions = definitions_of(type_name)
        self._order = order
        self._unpack_length = _LENGTH[order].unpack_from
        self._body = memoryview(data)[4:]
        self._at = 0

    def _cut(self) -> MessageError:
        return MessageError(f'{self._type_name} message ends early: {len(self._body) + 4} bytes')

    def _skip(self, size: int) -> int:
        start, self._at = self._at, self._at + size
        if self._at > len(self._body):
            raise self._cut()
        return start

    def _length(self) -> int:
        self._at += _padding(self._at, 4)
        length: int = self._unpack_length(self._body, self._skip(4))[0]
        return length

    def _get(self, code: str, count: int) -> tuple[Any, ...]:
        size = _SIZE[code]
        self._at += _padding(self._at, size)
        start = self._skip(size * count)
        return struct.unpack_from(f'{self._order}{count}{code}', self._body, start)

    def _string(self) -> str:
        length = self._length()
        start = self._skip(length)
        data = bytes(self._body[start:self._at]).removesuffix(b'\0')
        return data.decode(errors='replace')

    def message(self, name: str) -> dict[str, Any]:
        return {f.name: self._field(f) for f in self._definitions[name]}

    def _field(self, field: Field) -> Any:
        if field.type == 'string' and field.size is None:
            return self._string()
        count = 1 if field.size is None else field.size
        if count == SEQUENCE:
            count = self._length()
        if count > len(self._body):
            raise self._cut()
        if field.type not in CODES:
            values: list[Any] = [self.message(field.type) for _ in range(count)]
        elif field.type == 'string':
            values = [self._string() for _ in range(count)]
        else:
            values = list(self._get(CODES[field.type], count)) if count else []
        return values[0] if field.size is None else values


def encode(type_name: str, message: Mapping[str, Any]) -> bytes:
    """
    Return a message as little-endian CDR.

    Parameters
    ----------
    type_name
        A key of `schemas.TYPE_HASHES`, such as 'std_msgs/msg/String'.
    message
        Field names to numbers, strings, sequences and nested mappings. Absent fields are zero.

    Raises
    ------
    MessageError
        For a field that the type does not have, or a value that does not fit.

    Examples
    --------
    >>> encode('std_msgs/msg/String', {'data': 'hi'}).hex()
    '0001000003000000686900'

    """
    encoder = _Encoder(type_name)
    encoder.message(short_name(type_name), message)
    return _LITTLE + bytes(encoder.body)


def decode(type_name: str, data: bytes) -> dict[str, Any]:
    """
    Return the fields of a CDR message of either byte order.

    Parameters
    ----------
    type_name
        A key of `schemas.TYPE_HASHES`.
    data
        The message with its four bytes of encapsulation.

    Raises
    ------
    MessageError
        If the message is shorter than its type says.

    Examples
    --------
    >>> decode('std_msgs/msg/String', bytes.fromhex('0001000003000000686900'))
    {'data': 'hi'}

    """
    return _Decoder(type_name, data).message(short_name(type_name))
