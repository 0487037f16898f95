#!/usr/bin/env python3
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
"""The units in which headings come: by the name of a column, by a setting, or by the numbers."""

from __future__ import annotations

import math
import re

import numpy as np
from numpy.typing import NDArray

from .full_turns import ANGLE_UNITS

_Reals = NDArray[np.float64]

_NAMES = {'deg': ('deg', 'degs', 'degree', 'degrees', '°'),
          'rad': ('rad', 'rads', 'radian', 'radians'),
          'rev': ('rev', 'revs', 'revolution', 'revolutions', 'turns', 'cycles')}
_WORD = re.compile(r'[A-Z]?[a-z]+|[A-Z]+|°')
#: A device that counts 1e-4 rad rounds a full turn up; so does a text of four decimals.
_ROUNDED_UP = 1.0001
#: A wrap goes farther than the first share of a turn, a step of a ship less far than the second.
_WRAPS, _GOES = 0.8, 0.15
_MOST_OTHER = 0.02
#: Angles in radians that turn without a wrap cover this share of a turn, and most have a fourth
#: decimal. Their mean rate, 1/s, is that of a ship, and their noise, the mean of the second
#: differences, that of a heading sensor: in degrees either would be far too small.
_COVERS, _FINE, _FINE_SHARE, _MOST_RATE, _MOST_BEND = 0.25, 1000.0, 0.5, 0.12, 0.016
_LEAST = 60
_WORDS = {'rad': 'radians', 'rev': 'revolutions'}


def find_named_unit(name: str) -> str | None:
    """
    Return the unit that the name of a column tells; None if it tells none.

    Examples
    --------
    >>> [find_named_unit(name) for name in ('gyro_heading_rad', 'HeadingDeg', 'HDT (rev)', 'hdg')]
    ['rad', 'deg', 'rev', None]

    """
    words = {word.lower() for word in _WORD.findall(name)}
    return next((unit for unit, names in _NAMES.items() if words.intersection(names)), None)


def read_angles(values: _Reals, unit: str = 'deg') -> tuple[_Reals, np.ndarray]:
    """
    Return the headings that a whole stream of angles tells.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Angles; nan where there is none.
    unit : {'deg', 'rad', 'rev'}
        Their unit.

    Returns
    -------
    heading_deg : ndarray, shape (n,)
        Degrees, [0, 360); nan where the angle is no heading.
    wrong : ndarray of bool, shape (n,)
        Where the angle is out of range.

    Notes
    -----
    A turn counts from 0 or from minus a half. A stream with angles beyond a half turn is of the
    first kind, and its negative numbers are none. Neither is a negative number that comes again
    and again, five degrees off all other angles: it flags a missing reading.

    Examples
    --------
    >>> read_angles(np.array([-170.0, 179.5, -400.0, np.nan]))[0].tolist()
    [190.0, 179.5, nan, nan]

    """
    angle_deg = _degrees_of(values, unit)
    most_deg = 360.0 if unit == 'deg' else 360.0 * _ROUNDED_UP
    good = (angle_deg >= 0.0) & (angle_deg <= most_deg)
    below = (angle_deg < 0.0) & (angle_deg >= -180.0 * (most_deg / 360.0))
    if below.any() and not (angle_deg[good] > 180.0 * (most_deg / 360.0)).any() and (
            not _is_flag(angle_deg[below], angle_deg[good])):
        good |= below
    turned = np.mod(angle_deg, 360.0, where=good, out=np.full(angle_deg.shape, np.nan))
    turned[turned >= 360.0] = 0.0
    return turned, np.isfinite(angle_deg) & ~good


def fold_angles(values: _Reals, unit: str = 'deg') -> _Reals:
    """Return the headings of `read_angles`; what is out of range stays as it is, in degrees."""
    if unit == 'deg' and not (values < 0.0).any():
        return values
    heading_deg, wrong = read_angles(values, unit)
    return np.where(wrong, _degrees_of(values, unit), heading_deg)


def _degrees_of(values: _Reals, unit: str) -> _Reals:
    if unit not in ANGLE_UNITS:
        raise ValueError(f'unit = {unit!r}: use {", ".join(map(repr, ANGLE_UNITS))}')
    return values if unit == 'deg' else values * (360.0 / ANGLE_UNITS[unit])


def _is_flag(below_deg: _Reals, others_deg: _Reals) -> bool:
    """Tell whether the negative numbers of a stream are one that stands for no reading."""
    if not len(others_deg) or len(below_deg) < 2 or np.ptp(below_deg) > 0.0:
        return False
    off = np.abs((others_deg - below_deg[0] + 180.0) % 360.0 - 180.0)
    return bool(off.min() > 5.0)


class AngleWatch:
    """
    Watches the angles of one stream for signs that they are not degrees.

    The chunks do not matter, only the order of the angles.

    Notes
    -----
    Angles in radians step from 6.28 to 0 where the ship passes north. Degrees within 0 to 6.28
    never do: a ship that lies on 003 steps to 359 there. Without such a step, angles with four
    decimals that turn by a quarter of a circle and more, slowly and quietly, are radians too. A
    steady ship shows nothing, and a noisy sensor does not without a wrap.

    Examples
    --------
    >>> watch = AngleWatch()
    >>> t = np.arange(1000)
    >>> watch.update(10 ** 18 + t * 10 ** 9, (6.2 + 0.01 * t) % 6.28318)
    >>> watch.unit
    'rad'

    """

    def __init__(self) -> None:
        self._n = self._fine = 0
        self._low, self._high = math.inf, -math.inf
        self._wraps = dict.fromkeys(_WORDS, 0)
        self._others = dict.fromkeys(_WORDS, 0)
        self._last = np.full(2, math.nan)
        self._way = self._bends = 0.0
        self._first_ns = self._last_ns = 0

    def update(self, stamp_ns: NDArray[np.int64], values: _Reals) -> None:
        """Take angles in order; those that are zero or not finite do not count."""
        # A number of exactly zero may stand for no reading.
        is_reading = np.isfinite(values) & (values != 0.0)
        angle, stamps = values[is_reading], stamp_ns[is_reading]
        if not angle.size:
            return
        self._first_ns = self._first_ns or int(stamps[0])
        self._last_ns = int(stamps[-1])
        self._low, self._high = (min(self._low, float(angle.min())),
                                 max(self._high, float(angle.max())))
        self._n += angle.size
        if self._high > ANGLE_UNITS['rad'] * _ROUNDED_UP:
            return
        both = np.concatenate((self._last, angle))
        self._last = both[-2:]
        steps = np.abs(np.diff(both))[1:]
        self._way += float(np.nansum(steps))
        self._bends += float(np.nansum(np.abs(np.diff(both, 2))))
        for unit in _WORDS:
            share = steps / ANGLE_UNITS[unit]
            self._wraps[unit] += int(np.count_nonzero(share > _WRAPS))
            self._others[unit] += int(np.count_nonzero((share > _GOES) & (share <= _WRAPS)))
        fine = angle * _FINE
        self._fine += int(np.count_nonzero(np.abs(fine - np.rint(fine)) > 1e-6))

    @property
    def unit(self) -> str | None:
        """Return the unit that the angles show, 'rad' or 'rev'; None if they may be degrees."""
        if self._n < _LEAST:
            return None
        for unit in ('rev', 'rad'):
            turn = ANGLE_UNITS[unit]
            most = turn * _ROUNDED_UP
            within = (self._low >= 0.0 and self._high <= most
                      or self._low >= -0.5 * most and self._high <= 0.5 * most)
            if within and self._wraps[unit] and self._others[unit] <= _MOST_OTHER * self._n:
                return unit
        span_s = (self._last_ns - self._first_ns) / 1e9
        turns_through = (self._low >= 0.0 and self._high <= ANGLE_UNITS['rad'] * _ROUNDED_UP
                         and self._high - self._low >= _COVERS * ANGLE_UNITS['rad']
                         and self._fine >= _FINE_SHARE * self._n
                         and self._way <= _MOST_RATE * span_s
                         and self._bends <= _MOST_BEND * self._n)
        return 'rad' if turns_through else None

    @property
    def words(self) -> str:
        """Why the angles are not degrees, in words; empty if they may be."""
        unit = self.unit
        if unit is None:
            return ''
        how = ('step by a turn of' if self._wraps[unit] else 'turn smoothly through a circle of')
        return (f'the headings lie within {self._low:.4g} to {self._high:.4g} and {how} '
                f'{ANGLE_UNITS[unit]:.4g}: they look like {_WORDS[unit]}, not degrees')
