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

from functools import partial
from typing import Callable, NamedTuple

import numpy as np

from heading_intercompare.core.records import Integers, Quality, Reals, UNKNOWN_QUALITY

from .byte_columns import BytesLike
from .field_columns import decode_field, FieldPlace, find_field
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

DecodeClaims = Callable[[BytesLike, Integers, Integers], Quality]


def find_claims(type_name: str, part: str) -> DecodeClaims | None:
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
    decode : callable or None
        As `decode_headings`, with a row of each message: the standard deviation to three figures,
        nan where the message claims none that an angle can have. None if the type has no variance
        beside this field.

    """
    names = _FIELDS.get(type_name)
    if names is None or part not in ('', names.heading):
        return None
    fields = [find_field(type_name, definitions_of(type_name), name)
              for name in names[1:] if name]
    return partial(_decode_azimuth if type_name in AZIMUTH_TYPES else _decode_covariance, fields)


def _decode_covariance(fields: list[FieldPlace], data: BytesLike, start: Integers,
                       stop: Integers) -> Quality:
    """Return the claims in square radians, none where an Imu says that it has no orientation."""
    variance, *first = (decode_field(field, data, start, stop) for field in fields)
    is_known = [column.values != _NO_ORIENTATION for column in first]
    return _as_rows(variance.stamp_ns, np.where(np.all(is_known, axis=0), variance.values, np.nan),
                    is_degrees=np.zeros(len(variance), bool))


def _decode_azimuth(fields: list[FieldPlace], data: BytesLike, start: Integers,
                    stop: Integers) -> Quality:
    """Return the claims in squares of the unit that each message names."""
    variance, unit = (decode_field(field, data, start, stop) for field in fields)
    return _as_rows(variance.stamp_ns, variance.values, is_degrees=unit.values == _IN_DEGREES)


def _as_rows(stamp_ns: Integers, variance: Reals, *, is_degrees: np.ndarray) -> Quality:
    stated: Reals = np.sqrt(np.where(variance > 0.0, variance, np.nan))
    stated_deg = np.where(is_degrees, stated, np.degrees(stated))
    is_claim = (stated_deg >= _SMALLEST_DEG) & (stated_deg <= _LARGEST_DEG)
    return Quality(stamp_ns, _round(np.where(is_claim, stated_deg, np.nan)),
                   np.full(len(stamp_ns), UNKNOWN_QUALITY))


def _round(stated_deg: Reals) -> Reals:
    """Return claims to three figures: the last digits of a filter differ in each message."""
    scale = 10.0 ** (_FIGURES - 1 - np.floor(np.log10(stated_deg)))
    return np.rint(stated_deg * scale) / scale
