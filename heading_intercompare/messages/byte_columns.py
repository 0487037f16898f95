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
Bytes to columns and back: values at any offsets, single messages to chunks.

A chunk of n messages is n rows of bytes. Decoding gathers each field of all messages with one
numpy call, wherever the messages lie and however long their frame names are. It reads either byte
order, and rejects messages that do not start as plain CDR.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Callable, Iterable, Literal, Sequence, TypeVar

import numpy as np
from numpy.typing import DTypeLike

from heading_intercompare.core.records import (
    Attitude,
    Headings,
    Integers,
    Motion,
    Pairs,
    Quality,
    Reals,
)

from .cdr import encode
from .errors import MessageError
from .stamps import TIME_LIMIT_NS

#: Some data that holds messages.
BytesLike = bytes | bytearray | memoryview

_SECOND_NS = 1_000_000_000
_HEADER = np.dtype([('order', '<u2'), ('options', '<u2'), ('sec', '<i4'), ('nanosec', '<u4'),
                    ('length', '<u4')])
#: The first bytes of a message that does not begin with a header.
_BARE = np.dtype([('order', '<u2'), ('options', '<u2')])
#: `order` of a header: bytes 0, 0 for big-endian, bytes 0, 1 for little-endian.
_BIG, _LITTLE = 0x0000, 0x0100


@dataclass(frozen=True, slots=True, eq=False)
class FieldColumn:
    """
    One field of n messages.

    Attributes
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        Stamps of the headers, nanoseconds.
    values : ndarray, shape (n,)
        Numbers, or texts as bytes.

    """

    stamp_ns: Integers
    values: np.ndarray

    @classmethod
    def empty(cls) -> 'FieldColumn':
        """Return a column without messages."""
        return cls(np.empty(0, np.int64), np.empty(0, object))

    @classmethod
    def concatenate(cls, parts: Iterable['FieldColumn']) -> 'FieldColumn':
        """Return columns joined in their order."""
        parts = [part for part in parts if len(part)] or [cls.empty()]
        return cls(np.concatenate([part.stamp_ns for part in parts]),
                   np.concatenate([part.values for part in parts]))

    def __len__(self) -> int:
        return len(self.stamp_ns)

    def __getitem__(self, which: Integers | slice) -> 'FieldColumn':
        """Return the field of some messages."""
        return FieldColumn(self.stamp_ns[which], self.values[which])


_Chunk = TypeVar('_Chunk', Attitude, FieldColumn, Headings, Motion, Pairs,
                 Quality)
#: Converts messages of one byte order to a chunk, from the data, their first bytes, their sizes
#: and their headers.
_DecodeOne = Callable[[BytesLike, Integers, Integers, np.ndarray], _Chunk]
_ByteOrder = Literal['<', '>']


def _plain(dtype: np.dtype) -> np.dtype:
    """Return the dtype as raw bytes: numpy copies these at once, but structures by field."""
    return np.dtype(f'V{dtype.itemsize}') if dtype.names or dtype.shape else dtype


def gather(data: BytesLike, kind: DTypeLike, at: Integers) -> np.ndarray:
    """
    Return the values at the given byte offsets of some data, aligned or not.

    Parameters
    ----------
    data : bytes-like
        The bytes that hold the values.
    kind : dtype
        Type of the values, with its byte order; several in a row if it has a shape.
    at : ndarray of int64, shape (n,)
        Offset of each value; it must lie within the data.

    """
    dtype = np.dtype(kind)
    plain = _plain(dtype)
    everywhere = np.ndarray(max(len(data) - dtype.itemsize + 1, 0), plain, data, 0, (1,))
    values: np.ndarray = everywhere[at].view(dtype.base)
    return values.reshape(-1, *dtype.shape)


def join_messages(messages: Sequence[bytes]) -> tuple[bytes, Integers, Integers]:
    """Return n >= 0 messages joined, the first byte of each, and the byte after its last."""
    ends = np.cumsum([0, *map(len, messages)], dtype=np.int64)
    return b''.join(messages), ends[:-1], ends[1:]


def split_rows(rows: np.ndarray) -> list[bytes]:
    """Return the rows of a uint8 array, shape (n, size), as n messages."""
    data, size = rows.tobytes(), rows.shape[1]
    return [data[at:at + size] for at in range(0, len(data), size)]


@lru_cache(maxsize=64)
def _template(type_name: str, frame_id: str) -> np.ndarray:
    """Return a message with this frame and zeros otherwise."""
    return np.frombuffer(encode(type_name, {'header': {'frame_id': frame_id}}), np.uint8)


def stamped_rows(type_name: str, stamp_ns: Integers, frame_id: str, reals: Reals,
                 after: int = 0) -> np.ndarray:
    """
    Return messages with a header and reals.

    Parameters
    ----------
    type_name, frame_id
        Type of the messages, and frame of their headers.
    stamp_ns : ndarray of int64, shape (n,)
        Nanoseconds.
    reals : ndarray of float64, shape (n, k)
        The last k reals of the message; the fields before them are zero.
    after
        Bytes after them, which are zero.

    Raises
    ------
    MessageError
        If a stamp is beyond the range of builtin_interfaces/Time.

    """
    sec, nanosec = np.divmod(stamp_ns, _SECOND_NS)
    beyond = (stamp_ns < -TIME_LIMIT_NS) | (stamp_ns >= TIME_LIMIT_NS)
    if beyond.any():
        raise MessageError(f'stamp {stamp_ns[np.argmax(beyond)]} ns does not fit a ROS message: '
                           'must be before 19 January 2038')
    template = _template(type_name, frame_id)
    rows = np.empty((len(stamp_ns), len(template)), np.uint8)
    rows[:] = template
    stamps = np.empty((len(rows), 2), '<u4')
    stamps[:, 0], stamps[:, 1] = sec.astype('<i4').view('<u4'), nanosec
    rows[:, 4:12] = stamps.view(np.uint8)
    end = rows.shape[1] - after
    rows[:, end - 8 * reals.shape[1]:end] = reals.view(np.uint8)
    return rows


def align(position: Integers | int, size: int) -> Integers | int:
    """Return the next multiple of a size, which is a power of two."""
    return (position + (size - 1)) & -size


def gather_reals(type_name: str, data: BytesLike, start: Integers, size: Integers,
                 at: Integers | int, sign: _ByteOrder, n: int) -> np.ndarray:
    """
    Return n reals of each message that follow each other, shape (n, messages).

    Parameters
    ----------
    type_name
        Type of the messages.
    data : bytes-like
        The bytes that hold the messages.
    start, size : ndarray of int64
        First byte and length of each message.
    at : ndarray of int64 or int
        Offset of the first real in each message.
    sign : {'<', '>'}
        Byte order.
    n
        Number of reals.

    Raises
    ------
    MessageError
        If a message is too short for them.

    """
    kind = np.dtype((f'{sign}f8', n))
    check_size(type_name, start, size, at + kind.itemsize)
    return gather(data, kind, start + at).T


def check_size(type_name: str, start: Integers, size: Integers,
               least: Integers | int) -> None:
    """Raise MessageError if a message is shorter than its fields need."""
    refuse_messages(type_name, start, size < least,
                    lambda first: f'of {size[first]} bytes is too short')


def refuse_messages(type_name: str, start: Integers, wrong: np.ndarray,
                    describe: Callable[[int], str]) -> None:
    """
    Raise MessageError with the offsets of the messages that are wrong, if there are any.

    Parameters
    ----------
    type_name
        Type of the messages.
    start : ndarray of int64, shape (n,)
        First byte of each message.
    wrong : ndarray of bool, shape (n,)
        Which are wrong.
    describe
        Returns what is wrong, given the number of the first one.

    """
    if wrong.any():
        first = int(np.argmax(wrong))
        raise MessageError(f'{type_name} message {describe(first)}', offset=int(start[first]),
                           offsets=start[wrong].tolist())


def decode_stamped(type_name: str, data: BytesLike, start: Integers, stop: Integers,
                   decode_one: _DecodeOne[_Chunk], *, is_stamped: bool = True) -> _Chunk:
    """
    Return the chunk in a stretch of bytes; each message may have either byte order.

    Messages begin with a header, unless they are not stamped. MessageError if one does not, or if
    its stamp has a second or more of nanoseconds.
    """
    size, kind = stop - start, _HEADER if is_stamped else _BARE
    check_size(type_name, start, size, kind.itemsize)
    header = gather(data, kind, start)
    little = header['order'] == _LITTLE
    if little.all():
        if is_stamped:
            check_nanoseconds(type_name, start, header['nanosec'])
        return decode_one(data, start, size, header)
    refuse_messages(type_name, start, ~little & (header['order'] != _BIG),
                    lambda first: 'does not start as CDR')
    which = np.flatnonzero(little), np.flatnonzero(~little)
    signs: tuple[_ByteOrder, _ByteOrder] = '<', '>'
    parts = []
    for at, sign in zip(which, signs):
        begun = header[at].view(kind.newbyteorder(sign))
        if is_stamped:
            check_nanoseconds(type_name, start[at], begun['nanosec'])
        parts.append(decode_one(data, start[at], size[at], begun))
    return type(parts[0]).concatenate(parts)[np.argsort(np.concatenate(which))]


def check_nanoseconds(type_name: str, start: Integers, nanosec: np.ndarray) -> None:
    """Raise MessageError if a stamp has a second or more of nanoseconds: no clock writes that."""
    refuse_messages(type_name, start, nanosec >= _SECOND_NS, lambda first: (
        f'has a stamp with {nanosec[first]} nanoseconds: must be below {_SECOND_NS}'))


def find_byte_order(header: np.ndarray) -> _ByteOrder:
    """Return the byte order of messages with these first bytes."""
    return '>' if header.dtype['order'].byteorder == '>' else '<'


def end_of_strings(header: np.ndarray) -> tuple[_ByteOrder, Integers | int]:
    """Return the byte order of messages, and where their frame names end."""
    sign = find_byte_order(header)
    length = header['length'].astype(np.int64)
    if length.size and (length == length[0]).all():
        length = length[0]
    return sign, length + (_HEADER.itemsize - 4)


def read_stamps(header: np.ndarray) -> Integers:
    """Return the stamps in headers, nanoseconds."""
    stamp_ns: Integers = header['sec'].astype(np.int64) * _SECOND_NS
    stamp_ns += header['nanosec']
    return stamp_ns


def decode_readable(decode: Callable[[Integers, Integers], _Chunk], start: Integers,
                    stop: Integers) -> tuple[_Chunk, np.ndarray, str]:
    """
    Return the chunk in the readable messages of a stretch of bytes.

    Parameters
    ----------
    decode
        Returns the chunk of the messages between the given first and last bytes. If some are
        unreadable, it raises MessageError with their offsets.
    start, stop : ndarray of int64, shape (n,)
        First byte of each message, and the byte after its last.

    Returns
    -------
    chunk : Headings, Motion, Pairs or Quality
        One row for each readable message.
    readable : ndarray of bool, shape (n,)
        Which messages these are.
    problem : str
        What is wrong with the first of the others; empty if there are none.

    """
    # An empty message has the offset of the next one.
    readable = stop > start
    problem = '' if readable.all() else 'a message of 0 bytes'
    while True:
        try:
            return decode(start[readable], stop[readable]), readable, problem
        except MessageError as error:
            if not len(error.offsets):
                raise
            readable &= ~np.isin(start, error.offsets)
            problem = problem or error.problem


def read_sound(decode: Callable[..., _Chunk], messages: Sequence[bytes],
               kind: type[_Chunk]) -> tuple[_Chunk, list[str]]:
    """Return the chunk of the readable messages, and what is wrong with the others."""
    if not messages:
        return kind.empty(), []
    try:
        return decode(*join_messages(messages)), []
    except MessageError:
        pass
    chunks, refused = [], []
    for message in messages:
        try:
            chunks.append(decode(*join_messages([message])))
        except MessageError as error:
            refused.append(error.problem)
    return kind.concatenate(chunks), refused
