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
A field of messages of any type to headings, live and in bags: an angle or a quaternion.

An angle may run clockwise from north, as a heading, or the other way from east, as a yaw of
REP-103. Which of them a field holds is stated (`HeadingPlace.axes`), or its name tells it.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import partial
from itertools import islice
from typing import Callable

import numpy as np

from heading_intercompare.core import angles
from heading_intercompare.core.records import Headings, Integers, Reals
from heading_intercompare.core.units.full_turns import full_turn

from .byte_columns import BytesLike
from .errors import MessageError
from .field_columns import decode_field, FieldPlace, find_field, list_fields
from .fields import Definitions, leaves, short_name
from .heading_places import HeadingPlace
from .quaternion_norms import check_norms

#: A device that counts 1e-4 rad rounds a full turn up.
_ROUNDED_UP = 1.0001
#: The least angle, degrees: drivers may write 90 - heading as it is.
_LEAST_DEG = {'': -180.0, 'ned': -180.0, 'enu': -270.0}
_HEADING_WORDS = ('heading', 'hdg', 'hdt', 'azimuth', 'bearing')
#: The fields of a quaternion.
_AXES = ('x', 'y', 'z', 'w')
_ENDS = tuple(f'.{axis}' for axis in _AXES)
#: Fields of a type that are looked at for candidates.
_MOST_FIELDS = 1_000
_UNKNOWN = -1.0
#: Integers of these lengths hold fractions of a degree.
_WIDE = 'iIqQ'
#: The unit of integers in the types of a package, as its makers state it.
_UNITS = {'ublox_msgs': '1e-5deg', 'ublox_ubx_msgs': '1e-5deg'}
#: Packages whose drivers turn all angles to ENU, or not, by a parameter.
_TURNED_BY = {'sbg_driver': 'use_enu', 'septentrio_gnss_driver': 'use_ros_axis_orientation'}


@dataclass(frozen=True, slots=True)
class HeadingField:
    """
    A field with headings in the messages of a type.

    Attributes
    ----------
    decode
        Returns the headings in the messages of a stretch of bytes, as `decode_field`; nan where
        there is none.
    is_stamped
        The messages begin with a header, whose stamp is that of the heading.
    remark
        What was assumed of the field, in words; '' for nothing.

    """

    decode: Callable[[BytesLike, Integers, Integers], Headings]
    is_stamped: bool
    remark: str = ''


def find_heading_field(type_name: str, definitions: Definitions, place: HeadingPlace,
                       convention: str) -> HeadingField:
    """
    Return the field with the headings in messages of a type.

    Parameters
    ----------
    type_name, definitions
        As for `find_field`.
    place
        The field, and what is stated of it.
    convention : {'enu', 'ned'}
        World axes of a quaternion, where the place does not state them.

    Raises
    ------
    MessageError
        If there is no such field, if it is neither a number nor a quaternion, or if nobody states
        which way it turns and neither its name nor its type tells it.

    """
    path = place.part
    is_quaternion = set(_AXES) <= {
        field.name for field in list_fields(type_name, definitions, path)}
    _check_axes(type_name, place, is_quaternion)
    if is_quaternion:
        axes = [_find_real(type_name, definitions, f'{path}.{axis}') for axis in _AXES]
        return HeadingField(
            partial(_decode_quaternions, axes, _find_validity(type_name, definitions, path),
                    place.axes or convention), axes[0].is_stamped)
    field = _find_real(type_name, definitions, path)
    package = type_name.partition('/')[0]
    unit = place.unit or (_UNITS.get(package, '') if field.code in _WIDE else 'deg')
    if not unit:
        raise MessageError(f'{path}: is an integer of {8 * np.dtype(field.code).itemsize} bits, '
                           f'whose unit nobody states: write {path}@deg or, for instance, '
                           f'{path}@1e-5deg')
    return HeadingField(partial(decode_angles, field, unit, place.axes), field.is_stamped,
                        _describe_assumption(place, unit))


def list_candidates(type_name: str, definitions: Definitions) -> list[str]:
    """
    Return the fields of a type that may hold a heading: quaternions, and what is named so.

    A single field may hold one, too. A type whose fields cannot be listed has none.

    Examples
    --------
    >>> from .schemas import definitions_of
    >>> odometry = 'nav_msgs/msg/Odometry'
    >>> list_candidates(odometry, definitions_of(odometry))
    ['pose.pose.orientation']

    """
    try:
        fields = [*islice(leaves(short_name(type_name), definitions), _MOST_FIELDS)]
    except MessageError:
        return []
    if len(fields) == 1 and fields[0][2] is None:
        path, code, _ = fields[0]
        return [f'{path}.HDT' if code == 's' else path]
    paths = [path for path, code, size in fields
             if size is None and code not in 's?' and '[]' not in path]
    owners = Counter(path.rpartition('.')[0] for path in paths if path[-2:] in _ENDS)
    named = [path for path in paths if any(
        word in path.rpartition('.')[2].lower() for word in ('yaw', *_HEADING_WORDS))]
    return [*filter(None, (owner for owner, n in owners.items() if n == len(_AXES))), *named]


def _check_axes(type_name: str, place: HeadingPlace, is_quaternion: bool) -> None:
    """Raise MessageError if nobody states the axes of a field that may have either."""
    if place.axes:
        return
    parameter = _TURNED_BY.get(type_name.partition('/')[0])
    if parameter or not is_quaternion and _find_word(place) == 'yaw':
        why = (f'the driver turns angles to ENU by its parameter {parameter}' if parameter else
               'a yaw may turn either way')
        raise MessageError(f'{place.part}: {why}: write {place.part}@ned if it turns from north '
                           f'over east, {place.part}@enu if from east over north')


def _find_word(place: HeadingPlace) -> str:
    """Return the word that tells which way an angle turns, nearest to its end; '' for none."""
    names = [place.topic.rpartition('/')[2], *place.part.split('.')]
    return next((word for name in reversed(names) for word in ('yaw', *_HEADING_WORDS)
                 if word in name.lower()), '')


def _describe_assumption(place: HeadingPlace, unit: str) -> str:
    if place.axes or _find_word(place):
        return ''
    return (f'neither the field nor its topic is named a heading; it is read as {unit} clockwise '
            f'from true north: {place.part}@ned states that, {place.part}@enu the contrary')


def _find_real(type_name: str, definitions: Definitions, path: str) -> FieldPlace:
    """Return where a field with a number is, as `find_field`; MessageError if it is a text."""
    field = find_field(type_name, definitions, path)
    if field.code == 's':
        raise MessageError(f'{path}: is a text; name a sentence in it, as in {path}.HDT')
    if field.code == '?':
        raise MessageError(f'{path}: is no number')
    return field


def _find_validity(type_name: str, definitions: Definitions, path: str) -> FieldPlace | None:
    """Return the first covariance of a quaternion, which is -1 where it is unknown, if any."""
    parent, _, name = path.rpartition('.')
    has_covariance = any(field.name == f'{name}_covariance' and (field.size or 0) > 0
                         for field in list_fields(type_name, definitions, parent))
    return (_find_real(type_name, definitions, f'{path}_covariance[0]') if has_covariance
            else None)


def _decode_quaternions(axes: list[FieldPlace], validity: FieldPlace | None, convention: str,
                        data: BytesLike, start: Integers, stop: Integers) -> Headings:
    """Return the headings of quaternions; nan where one is zero, or called unknown."""
    columns = [decode_field(axis, data, start, stop) for axis in axes]
    x, y, z, w = quaternions = np.array([column.values for column in columns])
    has_orientation = (np.ones(start.shape, bool) if validity is None else
                       decode_field(validity, data, start, stop).values != _UNKNOWN)
    check_norms(axes[0].type_name, start, quaternions, has_orientation)
    heading_deg = angles.heading_from_quaternion(x, y, z, w, convention)
    return Headings(columns[0].stamp_ns, np.where(has_orientation, heading_deg, np.nan))


def decode_angles(field: FieldPlace, unit: str, axes: str, data: BytesLike, start: Integers,
                  stop: Integers) -> Headings:
    """
    Return the headings in a field of the messages of a stretch of bytes.

    Parameters
    ----------
    field
        Where the field is.
    unit
        Its unit (`full_turn`).
    axes : {'', 'enu', 'ned'}
        'enu': it is an angle from east over north; otherwise clockwise from true north.
    data, start, stop
        As for `decode_field`.

    Returns
    -------
    Headings
        In the order of `start`; nan where the angle is not from minus a half turn (three quarters
        of one from east) to a full one.

    """
    column = decode_field(field, data, start, stop)
    values: Reals = column.values
    angle_deg = values * (360.0 / full_turn(unit))
    with np.errstate(invalid='ignore'):
        is_heading = ((angle_deg >= _LEAST_DEG[axes] * _ROUNDED_UP)
                      & (angle_deg <= 360.0 * _ROUNDED_UP))
    if axes == 'enu':
        angle_deg = 90.0 - angle_deg
    return Headings(column.stamp_ns,
                    np.where(is_heading, angles.wrap360(np.where(is_heading, angle_deg, 0.0)),
                             np.nan))
