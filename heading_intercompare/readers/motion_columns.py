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

"""Columns of a table whose names tell the motion of the ship, with the unit in the name."""

from __future__ import annotations

from typing import NamedTuple, Sequence

import numpy as np

from heading_intercompare.core.records import (
    FASTEST_M_S,
    FASTEST_TURN_DEG_S,
    Integers,
    KNOT_M_S,
    Motion,
    Reals,
)

_LATITUDES = ('latitude_deg', 'latitude', 'lat_deg', 'lat')
_LONGITUDES = ('longitude_deg', 'longitude', 'lon_deg', 'lon', 'long')
_COURSES = ('course_over_ground_deg', 'course_over_ground', 'cog_deg', 'cog')
_SPEEDS = {f'{name}_{unit}': factor for name in ('speed_over_ground', 'sog')
           for unit, factor in (('kn', KNOT_M_S), ('kt', KNOT_M_S), ('kts', KNOT_M_S),
                                ('knots', KNOT_M_S), ('m_s', 1.0), ('mps', 1.0))}
_RATES = {f'{name}_{unit}': factor for name in ('rate_of_turn', 'rot')
          for unit, factor in (('deg_s', 1.0), ('deg_min', 1.0 / 60.0))}


class MotionColumn(NamedTuple):
    """
    One or two columns that tell a thing.

    Attributes
    ----------
    what : {'fix', 'velocity', 'rate'}
    names
        Latitude and longitude; course and speed; or the rate of turn.
    factor
        Makes m/s of a speed, and degrees per second of a rate.

    """

    what: str
    names: tuple[str, ...]
    factor: float = 1.0


def find_motion_columns(names: Sequence[str]) -> list[MotionColumn]:
    """
    Return the columns that tell the motion of the ship.

    A speed or a rate without a unit in its name tells nothing.

    Examples
    --------
    >>> columns = find_motion_columns(['Lat', 'Lon', 'COG', 'SOG'])
    >>> [(column.what, column.names) for column in columns]
    [('fix', ('Lat', 'Lon'))]

    """
    by_name = {name.lower(): name for name in reversed(names)}

    def first(candidates: Sequence[str]) -> str | None:
        return next((name for name in candidates if name in by_name), None)
    columns = []
    latitude, longitude = first(_LATITUDES), first(_LONGITUDES)
    if latitude and longitude:
        columns.append(MotionColumn('fix', (by_name[latitude], by_name[longitude])))
    course, speed = first(_COURSES), first([*_SPEEDS])
    if course and speed:
        columns.append(MotionColumn('velocity', (by_name[course], by_name[speed]), _SPEEDS[speed]))
    if rate := first([*_RATES]):
        columns.append(MotionColumn('rate', (by_name[rate],), _RATES[rate]))
    return columns


def make_motion(column: MotionColumn, stamp_ns: Integers,
                values: Sequence[Reals]) -> tuple[Motion, int]:
    """
    Return the motion that some columns tell, and the number of values out of range.

    Parameters
    ----------
    column
        What the values are, and in which units.
    stamp_ns : ndarray of int64, shape (n,)
        Stamps, nanoseconds UTC.
    values : sequence of ndarray, shape (n,)
        Of each name; nan where a row has none.

    """
    complete = np.all([np.isfinite(numbers) for numbers in values], axis=0)
    if column.what == 'fix':
        good = (np.abs(values[0]) <= 90.0) & (np.abs(values[1]) <= 180.0)
    elif column.what == 'velocity':
        good = ((values[0] >= 0.0) & (values[0] <= 360.0) & (values[1] >= 0.0)
                & (values[1] * column.factor <= FASTEST_M_S))
    else:
        good = np.abs(values[0] * column.factor) <= FASTEST_TURN_DEG_S
    valid, wrong = complete & good, int(np.count_nonzero(complete & ~good))
    stamps, columns = stamp_ns[valid], [numbers[valid] for numbers in values]
    columns[-1] = columns[-1] * column.factor
    if column.what == 'velocity':
        return Motion.of_courses(stamps, columns[0], columns[1] / KNOT_M_S), wrong
    return Motion.of(column.what, stamps, *columns), wrong
