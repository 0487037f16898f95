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

"""True bearings of what an observer sees: a mark, a leading line, a quay along the ship."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.angles import wrap180, wrap360
from heading_intercompare.core.records import Reals

#: WGS-84: semi-major axis in metres, and the square of the eccentricity.
_A_M, _E2 = 6_378_137.0, 6.694_379_990_141e-3


def _place(latitude_deg: ArrayLike, longitude_deg: ArrayLike) -> Reals:
    """Return the earth-fixed coordinates of points on the ellipsoid, metres, one row each."""
    latitude, longitude = np.broadcast_arrays(np.radians(latitude_deg), np.radians(longitude_deg))
    radius = _A_M / np.sqrt(1.0 - _E2 * np.sin(latitude) ** 2)
    return np.stack([radius * np.cos(latitude) * np.cos(longitude),
                     radius * np.cos(latitude) * np.sin(longitude),
                     radius * (1.0 - _E2) * np.sin(latitude)], axis=-1)


def bearing_between(from_latitude_deg: ArrayLike, from_longitude_deg: ArrayLike,
                    to_latitude_deg: ArrayLike,
                    to_longitude_deg: ArrayLike) -> tuple[Reals, Reals]:
    """
    Return the true bearing and the distance of points from other points, on WGS-84.

    Parameters
    ----------
    from_latitude_deg, from_longitude_deg, to_latitude_deg, to_longitude_deg : array_like
        Shape (n,) or scalar; degrees, north and east positive.

    Returns
    -------
    bearing_deg : ndarray
        In [0, 360), degrees; nan where the points coincide.
    distance_m : ndarray
        Straight line, metres.

    Notes
    -----
    The bearing is that of the plane through the vertical of the observer and the point seen. A
    pelorus or theodolite measures this angle, so no geodesic is needed. The two differ by
    less than 0.001 deg up to 100 km.

    Examples
    --------
    >>> bearing, distance = bearing_between(54.0, 10.0, 54.0, 10.1)
    >>> round(float(bearing), 4), round(float(distance), 1)
    (89.9595, 6557.6)

    """
    latitude, longitude = np.radians(from_latitude_deg), np.radians(from_longitude_deg)
    x, y, z = np.moveaxis(_place(to_latitude_deg, to_longitude_deg)
                          - _place(from_latitude_deg, from_longitude_deg), -1, 0)
    east = -np.sin(longitude) * x + np.cos(longitude) * y
    outward = np.cos(longitude) * x + np.sin(longitude) * y
    north = np.cos(latitude) * z - np.sin(latitude) * outward
    distance = np.sqrt(x * x + y * y + z * z)
    bearing = wrap360(np.degrees(np.arctan2(east, north)))
    return np.where(distance > 0.0, bearing, np.nan), distance


def line_bearing(front: tuple[float, float], rear: tuple[float, float],
                 longitude_deg: ArrayLike | None = None) -> tuple[Reals, float]:
    """
    Return the true bearing of a leading line, as a ship on it sees both marks in one.

    Parameters
    ----------
    front, rear
        Latitude and longitude of the mark nearer to the ship, and of the other one, degrees.
    longitude_deg : array_like, shape (n,), optional
        Longitude of the ship, degrees; without it the bearing is that at the front mark.

    Returns
    -------
    bearing_deg : ndarray
        In [0, 360), degrees.
    length_m : float
        Distance between the marks, metres.

    Raises
    ------
    ValueError
        If the marks coincide.

    Notes
    -----
    The meridians converge: towards a ship further west the bearing of one line falls by the
    difference in longitude times the sine of the latitude.

    Examples
    --------
    >>> bearing, length_m = line_bearing((54.4, 10.2), (54.41, 10.2))
    >>> round(float(bearing), 6), round(length_m)
    (0.0, 1113)

    """
    bearing, length = bearing_between(*front, *rear)
    if not length > 0.0:
        raise ValueError('the two points of the line are one point')
    if longitude_deg is None:
        return bearing, float(length)
    turned = wrap180(np.asarray(longitude_deg, float) - front[1]) * math.sin(
        math.radians(front[0]))
    return wrap360(bearing + turned), float(length)


def bearing_uncertainty(point_u_m: float, distance_m: ArrayLike) -> Reals:
    """
    Return the standard uncertainty of the bearing between two points.

    Parameters
    ----------
    point_u_m
        Standard uncertainty of each point across the line, metres.
    distance_m : array_like
        Distance between them, metres.

    Returns
    -------
    ndarray
        Degrees: sqrt(2) u / distance.

    Examples
    --------
    >>> round(float(bearing_uncertainty(0.02, 150.0)), 4)
    0.0108

    """
    return np.degrees(math.sqrt(2.0) * point_u_m / np.asarray(distance_m, float))


def quay_angle(fore_m: float, aft_m: float, base_m: float, side: str) -> float:
    """
    Return the angle from the direction of a quay to the heading of the ship along it.

    Parameters
    ----------
    fore_m, aft_m
        Distances of the ship's side from the edge of the quay, at two frames where the side is
        parallel to the keel, metres.
    base_m
        Distance between the frames, metres.
    side : {'port', 'starboard'}
        The side of the ship that lies at the quay.

    Returns
    -------
    float
        Degrees, clockwise: the heading minus the bearing of the quay, taken from stern to bow.

    Raises
    ------
    ValueError
        If `side` is another word, or `base_m` is not above zero.

    Examples
    --------
    >>> round(quay_angle(1.90, 1.50, 80.0, 'port'), 3)
    0.286

    """
    if side not in ('port', 'starboard'):
        raise ValueError(f"side = {side!r}: must be 'port' or 'starboard'")
    if not base_m > 0.0:
        raise ValueError(f'base_m = {base_m!r}: must be above 0')
    outwards = math.degrees(math.atan2(fore_m - aft_m, base_m))
    return outwards if side == 'port' else -outwards
