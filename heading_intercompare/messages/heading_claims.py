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
The standard deviation that messages claim for their headings, in the covariance beside each.

Drivers that know none leave zeros there, or a number that no angle has.
"""

from __future__ import annotations

from functools import lru_cache
import struct
from typing import Callable, NamedTuple, Sequence

import numpy as np

from heading_intercompare.core.records import Integers, Quality, Reals, UNKNOWN_QUALITY

from .byte_columns import BytesLike, decode_stamped
from .errors import MessageError
from .field_columns import decode_values, FieldPlace, find_field, find_offset
from .heading_messages import AZIMUTH_TYPES, IMU
from .schemas import definitions_of

_NO_ORIENTATION = -1.0
_IN_DEGREES = 1.0
_SMALLEST_DEG, _LARGEST_DEG = 1e-9, 180.0
_FIGURES = 3


class _Beside(NamedTuple):
    """Names of fields: the heading, its variance, and what says how to read that ('': nothing)."""

    heading: str
    variance: str
    remark: str = ''


_OF_POSE = _Beside('pose.pose.orientation', 'pose.covariance[35]')
_FIELDS = {
    IMU: _Beside('orientation', 'orientation_covariance[8]', 'orientation_covariance[0]'),
    'geometry_msgs/msg/PoseWithCovarianceStamped': _OF_POSE,
    'nav_msgs/msg/Odometry': _OF_POSE,
    **dict.fromkeys(AZIMUTH_TYPES, _Beside('azimuth', 'variance', 'unit')),
}

#: Bytes of a header that tell the byte order, and the length of the name of the frame.
_ORDER_AT, _LENGTH_AT = 0, 12
_FEW = 3


class Claims(NamedTuple):
    """
    What reads the claims of messages.

    Attributes
    ----------
    fields
        The variance, and what says how to read it.
    state
        Returns the standard deviations that values of these fields claim.

    """

    fields: Sequence[FieldPlace]
    state: Callable[..., Reals]

    def decode(self, data: BytesLike, start: Integers, stop: Integers) -> Quality:
        """Return a row of each message, as `decode_headings` does; nan without a claim."""
        def decode_one(data: BytesLike, start: Integers, size: Integers,
                       header: np.ndarray) -> Quality:
            columns = [decode_values(field, data, start, size, header) for field in self.fields]
            return Quality(columns[0].stamp_ns, self.state(*(column.values for column in columns)),
                           np.full(len(header), UNKNOWN_QUALITY))
        return decode_stamped(self.fields[0].type_name, data, start, stop, decode_one)

    def are_alike(self, data: BytesLike, start: Integers, stop: Integers) -> bool:
        """Tell whether all messages of a length, evenly spread, have one claim; most have."""
        if len(start) < _FEW:
            return False
        step = int(start[1] - start[0])
        if (np.diff(start) != step).any() or (stop - start != stop[0] - start[0]).any():
            return False
        try:
            places = [(find_offset(field, data, start, stop), struct.calcsize(f'<{field.code}'))
                      for field in self.fields]
        except MessageError:
            return False
        for at, width in ((_ORDER_AT, 4), (_LENGTH_AT, 4), *places):
            column = np.ndarray(len(start), f'u{width}', data, int(start[0]) + at, (step,))
            if (column != column[0]).any():
                return False
        return True


@lru_cache
def find_claims(type_name: str, part: str) -> Claims | None:
    """
    Return what reads the claims in messages of a type.

    Parameters
    ----------
    type_name
        The type of the messages.
    part
        The field with the headings; '' for what the type has.

    Returns
    -------
    Claims or None
        The standard deviations have three figures, nan where a message claims none that an angle
        can have. None if the type has no variance beside this field.

    """
    names = _FIELDS.get(type_name)
    if names is None or part not in ('', names.heading):
        return None
    fields = [find_field(type_name, definitions_of(type_name), name)
              for name in names[1:] if name]
    return Claims(fields,
                  _state_azimuth if type_name in AZIMUTH_TYPES else _state_covariance)


def _state_covariance(variance: Reals, *first: Reals) -> Reals:
    """Return the claims in square radians, none where an Imu says that it has no orientation."""
    is_known = np.all([values != _NO_ORIENTATION for values in first], axis=0)
    return _state(np.where(is_known, variance, np.nan), is_degrees=np.zeros(len(variance), bool))


def _state_azimuth(variance: Reals, unit: Reals) -> Reals:
    """Return the claims in squares of the unit that each message names."""
    return _state(variance, is_degrees=unit == _IN_DEGREES)


def _state(variance: Reals, *, is_degrees: np.ndarray) -> Reals:
    stated: Reals = np.sqrt(np.where(variance > 0.0, variance, np.nan))
    stated_deg = np.where(is_degrees, stated, np.degrees(stated))
    is_claim = (stated_deg >= _SMALLEST_DEG) & (stated_deg <= _LARGEST_DEG)
    return _round(np.where(is_claim, stated_deg, np.nan))


def _round(stated_deg: Reals) -> Reals:
    """Return claims to three figures: the last digits of a filter differ in each message."""
    scale = 10.0 ** (_FIGURES - 1 - np.floor(np.log10(stated_deg)))
    return np.rint(stated_deg * scale) / scale
