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

"""Short ways on the Earth as metres to the east and the north, on the ellipsoid of WGS-84."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.records import Reals

_SEMI_MAJOR_M = 6378137.0
_ECCENTRICITY2 = 6.69437999014e-3


def radii_m(latitude_deg: ArrayLike) -> tuple[Reals, Reals]:
    """
    Return the radii of curvature of the ellipsoid.

    Parameters
    ----------
    latitude_deg : array_like, shape (n,)
        Geodetic latitude, degrees.

    Returns
    -------
    meridian_m, normal_m : ndarray, shape (n,)
        Radius of the meridian and of the prime vertical, metres.

    References
    ----------
    NIMA TR8350.2 (WGS-84).

    Examples
    --------
    >>> [round(float(r)) for r in radii_m(0.0)]
    [6335439, 6378137]

    """
    w2 = 1.0 - _ECCENTRICITY2 * np.sin(np.radians(latitude_deg)) ** 2
    normal = _SEMI_MAJOR_M / np.sqrt(w2)
    return normal * (1.0 - _ECCENTRICITY2) / w2, normal


def steps_m(from_deg: tuple[ArrayLike, ArrayLike],
            to_deg: tuple[ArrayLike, ArrayLike]) -> tuple[Reals, Reals]:
    """
    Return the way from one position to another in the tangent plane.

    Parameters
    ----------
    from_deg, to_deg : tuple of two array_like, each of shape (n,)
        Latitudes and longitudes, degrees; any turn of longitude.

    Returns
    -------
    east_m, north_m : ndarray, shape (n,)
        Metres. The error is below a millionth of the way for ways up to 1 km, away from the poles.

    Examples
    --------
    >>> east, north = steps_m((60.0, 179.9995), (60.0, -179.9995))
    >>> round(float(east), 2), round(float(north), 2)
    (55.8, 0.0)

    """
    start, end = np.asarray(from_deg, np.float64), np.asarray(to_deg, np.float64)
    middle = 0.5 * (start[0] + end[0])
    meridian, normal = radii_m(middle)
    north = meridian * np.radians(end[0] - start[0])
    east = normal * np.cos(np.radians(middle)) * np.radians(wrap180(end[1] - start[1]))
    return east, north
