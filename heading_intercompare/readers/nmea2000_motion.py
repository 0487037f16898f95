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

"""The motion of the ship in messages of NMEA 2000: position, course and speed, rate of turn."""

from __future__ import annotations

import math
from typing import Any, Callable, Mapping

from heading_intercompare.core.motion.moved_rows import (
    make_position,
    make_rate,
    make_velocity,
    MovedRow,
)

__all__ = ['decode_motion_fields', 'decode_motion_pgn', 'MOTION_PGNS']


_BEYOND = 'out_of_range'
_TRUE = 0
_NO_ANGLE, _NO_SPEED = 65533, 65533
_NO_LONG, _NO_LONGER = 0x7FFFFFFD, 0x7FFFFFFFFFFFFFFD
_RATE_DEG_S = math.degrees(1e-6 / 32.0)


def _signed(data: bytes, at: int, size: int) -> int:
    return int.from_bytes(data[at:at + size], 'little', signed=True)


def _decode_rate(data: bytes) -> MovedRow | str:
    """Read PGN 127251: sequence, rate in 1e-6 / 32 rad/s."""
    rate = _signed(data, 1, 4)
    return 'empty' if rate >= _NO_LONG else make_rate(rate * _RATE_DEG_S) or _BEYOND


def _decode_rapid_position(data: bytes) -> MovedRow | str:
    """Read PGN 129025: latitude and longitude in 1e-7 deg."""
    latitude, longitude = _signed(data, 0, 4), _signed(data, 4, 4)
    if latitude >= _NO_LONG or longitude >= _NO_LONG:
        return 'empty'
    return make_position(latitude * 1e-7, longitude * 1e-7) or _BEYOND


def _decode_course(data: bytes) -> MovedRow | str:
    """Read PGN 129026: sequence, reference, course in 1e-4 rad, speed in cm/s."""
    course, speed = (int.from_bytes(data[at:at + 2], 'little') for at in (2, 4))
    if course >= _NO_ANGLE or speed >= _NO_SPEED:
        return 'empty'
    return ('not_true' if data[1] & 3 != _TRUE
            else make_velocity(course * 1e-4, speed * 0.01) or _BEYOND)


def _decode_position(data: bytes) -> MovedRow | str:
    """Read PGN 129029: sequence, day, time, then latitude and longitude in 1e-16 deg."""
    latitude, longitude = _signed(data, 7, 8), _signed(data, 15, 8)
    if latitude >= _NO_LONGER or longitude >= _NO_LONGER:
        return 'empty'
    # The high half of the byte with the method: 0 is no fix.
    if not data[31] >> 4:
        return 'no_fix'
    return make_position(latitude * 1e-16, longitude * 1e-16) or _BEYOND


MOTION_PGNS: dict[int, tuple[int, Callable[[bytes], MovedRow | str]]] = {
    129026: (8, _decode_course), 129025: (8, _decode_rapid_position), 127251: (5, _decode_rate),
    129029: (32, _decode_position)}
"""Bytes needed and decoder, by PGN; of two that tell one thing, the earlier is preferred."""


def decode_motion_pgn(pgn: int, data: bytes) -> MovedRow | str:
    """
    Decode a message; a str says why it tells nothing.

    Parameters
    ----------
    pgn : int
        One of `MOTION_PGNS`.
    data : bytes
        Its bytes; those of a fast packet already joined.

    Examples
    --------
    >>> row = decode_motion_pgn(129026, bytes.fromhex('01 fc 5c 3d e8 03 ff ff'))
    >>> row.what, round(row.values[0], 6)
    ('velocity', 10.0)

    """
    least, decode = MOTION_PGNS[pgn]
    return 'too_few_fields' if len(data) < least else decode(data)


def decode_motion_fields(pgn: int, fields: Mapping[str, Any], radians: float) -> MovedRow | str:
    """
    Decode the fields of a message as canboat's analyzer names them.

    Parameters
    ----------
    pgn : int
        One of `MOTION_PGNS`.
    fields : mapping
        By name.
    radians : float
        Makes radians of their angles.

    """
    names = {129026: ('COG', 'SOG'), 127251: ('Rate',)}.get(pgn, ('Latitude', 'Longitude'))
    values = []
    for name in names:
        value = fields.get(name)
        if isinstance(value, Mapping):
            value = value.get('value')
        if value is None:
            return 'empty'
        if not isinstance(value, (int, float)) or isinstance(value, bool):
            return 'bad_field'
        values.append(float(value))
    if pgn == 127251:
        return make_rate(math.degrees(values[0] * radians)) or _BEYOND
    if pgn != 129026:
        # Positions are degrees in any units.
        return make_position(values[0], values[1]) or _BEYOND
    reference = fields.get('COG Reference')
    if isinstance(reference, Mapping):
        reference = reference.get('value', reference.get('name'))
    return ('not_true' if reference not in ('True', _TRUE)
            else make_velocity(values[0] * radians, values[1]) or _BEYOND)
