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

"""Nanoseconds to message stamps and back."""

from __future__ import annotations

import struct
from typing import Mapping

import numpy as np

from .cdr import encode

CLOCK_TYPE = 'rosgraph_msgs/msg/Clock'

TIME_LIMIT_NS = 2 ** 31 * 1_000_000_000
"""Stamps of ROS messages are below this (January 2038)."""

_SECOND_NS = 1_000_000_000


def fits_message(stamps_ns: np.ndarray) -> np.ndarray:
    """Tell which stamps a message can hold: from 1970 to January 2038."""
    return (stamps_ns >= 0) & (stamps_ns < TIME_LIMIT_NS)


def stamp_ns(fields: Mapping[str, int]) -> int:
    """Return the fields of a stamp in nanoseconds."""
    return fields['sec'] * _SECOND_NS + fields['nanosec']


def header_stamp_ns(data: bytes) -> int:
    """
    Return the stamp of a message that begins with a header, nanoseconds; 0 if it is cut.

    Examples
    --------
    >>> header_stamp_ns(bytes.fromhex('00010000' '02000000' '03000000'))
    2000000003

    """
    if len(data) < 12:
        return 0
    sec, nanosec = struct.unpack_from('<iI' if data[1] & 1 else '>iI', data, 4)
    return int(sec * _SECOND_NS + nanosec)


def header_frame(data: bytes) -> str:
    """
    Return the frame of a message that begins with a header; '' if it is cut.

    Examples
    --------
    >>> header_frame(bytes.fromhex('00010000' '02000000' '03000000' '03000000' '313200'))
    '12'

    """
    if len(data) < 16:
        return ''
    size, = struct.unpack_from('<I' if data[1] & 1 else '>I', data, 12)
    return data[16:16 + max(0, size - 1)].decode('utf-8', 'replace')


def stamp_fields(ns: int) -> dict[str, int]:
    """Return nanoseconds as the fields of a stamp."""
    sec, nanosec = divmod(int(ns), _SECOND_NS)
    return {'sec': sec, 'nanosec': nanosec}


def encode_clock(ns: int) -> bytes:
    """Return a time as rosgraph_msgs/msg/Clock."""
    return encode(CLOCK_TYPE, {'clock': stamp_fields(ns)})
