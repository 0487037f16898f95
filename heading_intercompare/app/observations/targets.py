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

"""What an observer takes a bearing of, where the table does not say its true bearing."""

from __future__ import annotations

from dataclasses import dataclass
import re

import numpy as np

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.observations.sight_lines import (
    bearing_between,
    bearing_uncertainty,
    line_bearing,
)
from heading_intercompare.core.records import Integers, Reals

OWN_BEARINGS = 'the bearings of the table'
"""What was observed, in words, if each row has its own bearing."""

_HALF_SPAN_NS = 30_000_000_000
_LOWEST_SUN_DEG = -1.0


def parse_position(text: str, option: str, points: int = 1) -> tuple[float, ...]:
    """
    Return the latitudes and longitudes of points written as ``54.32 10.15``, or with commas.

    Raises
    ------
    ValueError
        If there are more or fewer numbers, or one is out of range; names the option.

    """
    words = [word for word in re.split(r'[\s,;]+', text.strip()) if word]
    try:
        numbers = tuple(map(float, words))
    except ValueError:
        numbers = ()
    if len(numbers) != 2 * points or not all(
            abs(number) <= (90.0, 180.0)[place % 2] for place, number in enumerate(numbers)):
        form = ' '.join(['LATITUDE LONGITUDE'] * points)
        raise ValueError(f'--{option} {text!r}: must be {form} in decimal degrees, north and '
                         'east positive')
    return numbers


@dataclass(frozen=True, slots=True)
class TargetBearings:
    """
    True bearings of a target, one per observation.

    Attributes
    ----------
    bearing_deg : ndarray, shape (n,)
        Degrees; nan where the place of the observer is needed and not given.
    turn_deg_s : ndarray, shape (n,)
        Rate at which the bearing changes by itself, degrees per second.
    common_u_deg
        Standard uncertainty that all share, from that of the points, degrees.
    words
        What the target is.
    below_horizon : ndarray of bool, shape (n,)
        Where the sun cannot be seen.

    """

    bearing_deg: Reals
    turn_deg_s: Reals
    common_u_deg: float
    words: str
    below_horizon: np.ndarray


@dataclass(frozen=True, slots=True)
class Target:
    """
    What the observers take bearings of.

    Attributes
    ----------
    kind : {'none', 'bearing', 'line', 'mark', 'sun'}
        'bearing': a fixed true bearing, such as that of a quay; 'line': two charted points in
        one, the nearer one first, or the ends of a quay from stern to bow; 'mark': a charted
        point seen from the ship; 'sun'; 'none': each row of the table has its own.
    numbers
        The bearing, or latitudes and longitudes of the points; degrees.
    point_u_m
        Standard uncertainty of each point across the line of sight, metres.

    """

    kind: str = 'none'
    numbers: tuple[float, ...] = ()
    point_u_m: float = 0.0

    def find_bearings(self, stamp_ns: Integers, latitude_deg: Reals,
                      longitude_deg: Reals) -> TargetBearings:
        """
        Return the true bearings at the times and places of the observers.

        Raises
        ------
        ModuleNotFoundError
            If the azimuth of the sun is wanted and `ephem` is not installed.
        ValueError
            If the points of a line coincide.

        """
        n = stamp_ns.size
        bearing, turn, common = np.full(n, np.nan), np.zeros(n), 0.0
        below, words = np.zeros(n, bool), OWN_BEARINGS
        located = np.isfinite(latitude_deg) & np.isfinite(longitude_deg)
        if self.kind == 'bearing':
            bearing[:], words = self.numbers[0], f'a true bearing of {self.numbers[0]:g} deg'
        elif self.kind == 'line':
            first, second, third, fourth = self.numbers
            front, rear = (first, second), (third, fourth)
            bearing[:], length_m = line_bearing(front, rear)
            located = np.isfinite(longitude_deg)
            bearing[located] = line_bearing(front, rear, longitude_deg[located])[0]
            common = float(bearing_uncertainty(self.point_u_m, length_m))
            words = f'a line of two points {length_m:.1f} m apart'
            words += f', {line_bearing(front, rear)[0]:.3f} deg at the first'
        elif self.kind == 'mark':
            seen, distance_m = bearing_between(latitude_deg[located], longitude_deg[located],
                                               *self.numbers)
            bearing[located] = seen
            if distance_m.size:
                common = float(bearing_uncertainty(self.point_u_m, distance_m.min()))
                words = f'a mark at {distance_m.min():.0f} m or more'
        elif self.kind == 'sun':
            from .sun import find_sun
            places = latitude_deg[located], longitude_deg[located]
            azimuth, altitude = find_sun(stamp_ns[located], *places)
            later = find_sun(stamp_ns[located] + _HALF_SPAN_NS, *places)[0]
            earlier = find_sun(stamp_ns[located] - _HALF_SPAN_NS, *places)[0]
            bearing[located], turn[located] = azimuth, wrap180(later - earlier) / (
                2e-9 * _HALF_SPAN_NS)
            below[located] = altitude < _LOWEST_SUN_DEG
            words = 'the sun'
            if altitude.size:
                words += f', {altitude.min():.1f} to {altitude.max():.1f} deg above the horizon'
        return TargetBearings(bearing, turn, common, words, below)
