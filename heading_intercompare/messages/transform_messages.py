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

"""Transforms between two frames in messages of TF to headings, for bags and live topics alike."""

from __future__ import annotations

from collections import Counter
import struct
from typing import Literal

import numpy as np

from heading_intercompare.core.angles import heading_from_quaternion
from heading_intercompare.core.records import Headings, Integers

from .byte_columns import (
    align,
    BytesLike,
    check_nanoseconds,
    decode_stamped,
    FieldColumn,
    find_byte_order,
)
from .errors import MessageError
from .quaternion_norms import check_norms

TRANSFORMS = 'tf2_msgs/msg/TFMessage'
TRANSFORM_TYPES = (TRANSFORMS, 'tf/msg/tfMessage')
"""The types of messages with transforms: that of today, and its name in early ROS 1."""

_SECOND_NS = 1_000_000_000
#: Between the frames and the rotation: x, y and z.
_TRANSLATION_BYTES = 24
_MOST_NAMED = 10


class _Body:
    """The bytes of a message after its first four, and how far they are read."""

    def __init__(self, data: memoryview, sign: Literal['<', '>']) -> None:
        self._data, self._at = data, 0
        self._pair, self._length, self._rotation = (
            struct.Struct(f'{sign}{form}') for form in ('iI', 'I', '4d'))

    def take(self, form: struct.Struct, width: int) -> tuple[float, ...]:
        """Return values of one width, and go past them."""
        self._at = int(align(self._at, width))
        values = form.unpack_from(self._data, self._at)
        self._at += form.size
        return values

    def take_length(self) -> int:
        """Return a length, and go past it."""
        return int(self.take(self._length, 4)[0])

    def take_frame(self) -> bytes:
        """Return the name of a frame without a leading slash, and go past it."""
        length = self.take_length()
        if self._at + length > len(self._data):
            raise struct.error(f'a name of {length} bytes')
        name = bytes(self._data[self._at:self._at + length])
        self._at += length
        return name.rstrip(b'\0').lstrip(b'/')

    def take_transform(self) -> tuple[tuple[float, ...], bytes, bytes, tuple[float, ...]]:
        """Return stamp, parent, child and rotation of a transform, and go past it."""
        stamp = self.take(self._pair, 4)
        parent, child = self.take_frame(), self.take_frame()
        self._at = int(align(self._at, 8)) + _TRANSLATION_BYTES
        return stamp, parent, child, self.take(self._rotation, 8)


class TransformTopic:
    """
    Turns the messages of TF into the headings of one frame in another.

    A message holds any number of transforms. Those of other frames are no readings.

    Parameters
    ----------
    frames
        Parent and child with a colon between them: `map:base_link`.
    convention : {'enu', 'ned'}
        World axes of the parent.

    Raises
    ------
    MessageError
        If there are not two frames.

    Examples
    --------
    >>> TransformTopic('map:base_link', 'enu').absence
    'no transform from map to base_link; the topic has none'

    """

    def __init__(self, frames: str, convention: str) -> None:
        parent, colon, child = frames.partition(':')
        self._frames = tuple(name.lstrip('/').encode() for name in (parent, child))
        if not colon or not all(self._frames):
            raise MessageError(f'{frames}: must be two frames of TF, parent and child, as in '
                               'map:base_link')
        self._convention = convention
        self._counts: Counter[tuple[bytes, ...]] = Counter()

    def decode(self, data: BytesLike, start: Integers, stop: Integers) -> FieldColumn:
        """
        Return the headings in the messages of a stretch of bytes, `Headings` for each message.

        Raises
        ------
        MessageError
            If a message is cut, does not start as CDR, or has an impossible stamp or rotation of
            these frames; the offset is its place in `data`.

        """
        return decode_stamped(TRANSFORMS, data, start, stop, self._decode, is_stamped=False)

    def _decode(self, data: BytesLike, start: Integers, size: Integers,
                header: np.ndarray) -> FieldColumn:
        """Return the headings in messages of one byte order."""
        view, sign = memoryview(data), find_byte_order(header)
        stamps, rotations, begins, ends, cut = [], [], [], [], []
        counts: Counter[tuple[bytes, ...]] = Counter()
        for begin, end in zip(start.tolist(), (start + size).tolist()):
            try:
                body = _Body(view[begin + 4:end], sign)
                for _ in range(body.take_length()):
                    stamp, parent, child, rotation = body.take_transform()
                    counts[parent, child] += 1
                    if (parent, child) == self._frames:
                        stamps.append(stamp)
                        rotations.append(rotation)
                        begins.append(begin)
            except struct.error:
                cut.append(begin)
            ends.append(len(stamps))
        if cut:
            raise MessageError(f'{TRANSFORMS} message ends within a transform', offset=cut[0],
                               offsets=cut)
        at = np.array(begins, np.int64)
        sec, nanosec = np.array(stamps, np.int64).reshape(-1, 2).T
        x, y, z, w = quaternions = np.array(rotations, float).reshape(-1, 4).T
        check_nanoseconds(TRANSFORMS, at, nanosec)
        check_norms(TRANSFORMS, at, quaternions)
        self._counts += counts
        headings = Headings(sec * _SECOND_NS + nanosec,
                            heading_from_quaternion(x, y, z, w, self._convention))
        values = np.empty(len(ends), object)
        values[:] = [headings[begin:end] for begin, end in zip([0, *ends], ends)]
        return FieldColumn(np.zeros(len(ends), np.int64), values)

    @property
    def absence(self) -> str:
        """Return in words that the frames were not there, and which were; '' if they were."""
        if self._counts[self._frames]:
            return ''
        named = [b':'.join(pair).decode(errors='replace')
                 for pair, _ in self._counts.most_common(_MOST_NAMED)]
        more = len(self._counts) - len(named)
        parent, child = (name.decode(errors='replace') for name in self._frames)
        return (f'no transform from {parent} to {child}; the topic has '
                + (', '.join(named) or 'none') + (f' and {more} more' if more else ''))
