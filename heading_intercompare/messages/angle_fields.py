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

"""Angles in a field of messages of any type to headings, live and in bags."""

from __future__ import annotations

import numpy as np

from heading_intercompare.core import angles
from heading_intercompare.core.records import Headings, Integers, Reals
from heading_intercompare.core.units.full_turns import ANGLE_UNITS

from .byte_columns import BytesLike
from .errors import MessageError
from .field_columns import decode_field, FieldPlace, find_field
from .fields import Definitions

#: A device that counts 1e-4 rad rounds a full turn up.
_ROUNDED_UP = 1.0001


def find_angle(type_name: str, definitions: Definitions, path: str) -> FieldPlace:
    """Return where a field with a number is, as `find_field`; MessageError if it is a text."""
    place = find_field(type_name, definitions, path)
    if place.code in 's?':
        raise MessageError(f'{path}: is no number')
    return place


def decode_angles(place: FieldPlace, unit: str, data: BytesLike, start: Integers,
                  stop: Integers) -> Headings:
    """
    Return the headings in a field of the messages of a stretch of bytes.

    Parameters
    ----------
    place
        Where the field is: an angle clockwise from true north.
    unit : {'deg', 'rad', 'rev'}
        Its unit.
    data, start, stop
        As for `decode_field`.

    Returns
    -------
    Headings
        In the order of `start`; nan where the angle is not from minus a half turn to a full one.

    """
    column = decode_field(place, data, start, stop)
    values: Reals = column.values
    angle_deg = values * (360.0 / ANGLE_UNITS[unit])
    with np.errstate(invalid='ignore'):
        is_heading = (angle_deg >= -180.0 * _ROUNDED_UP) & (angle_deg <= 360.0 * _ROUNDED_UP)
    return Headings(column.stamp_ns,
                    np.where(is_heading, angles.wrap360(np.where(is_heading, angle_deg, 0.0)),
                             np.nan))
