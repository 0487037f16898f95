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

"""The Earth as gyros and accelerometers on a ship sense it: WGS-84, rotation, gravity."""

from __future__ import annotations

import math

EARTH_RATE_RAD_S = 7.292115e-5
"""Rotation of the Earth, rad/s (WGS-84)."""

SEMI_MAJOR_M = 6378137.0
ECCENTRICITY2 = 6.69437999014e-3

RAD_PER_DEG_H = math.radians(1.0) / 3600.0
"""1 deg/h in rad/s, which is one arc second per second."""

RAD_PER_DEG_SQRT_H = math.radians(1.0) / 60.0
"""1 deg/sqrt(h) in rad/sqrt(s)."""

UG_M_S2 = 9.80665e-6
"""One millionth of standard gravity, m/s^2."""

KNOT_M_S = 1852.0 / 3600.0
"""One knot, m/s."""


def radii(latitude_rad: float) -> tuple[float, float]:
    """
    Return the radii of curvature of the WGS-84 ellipsoid.

    Parameters
    ----------
    latitude_rad
        Geodetic latitude, radians.

    Returns
    -------
    meridian_m, normal_m : float
        Radius of the meridian R_M and of the prime vertical R_N, metres.

    References
    ----------
    NIMA TR8350.2 (WGS-84).

    Examples
    --------
    >>> [round(r) for r in radii(0.0)]
    [6335439, 6378137]

    """
    s = math.sin(latitude_rad)
    w2 = 1.0 - ECCENTRICITY2 * s * s
    normal = SEMI_MAJOR_M / math.sqrt(w2)
    return normal * (1.0 - ECCENTRICITY2) / w2, normal


def gravity(latitude_rad: float) -> float:
    """
    Return normal gravity on the ellipsoid, m/s^2.

    Parameters
    ----------
    latitude_rad
        Geodetic latitude, radians.

    References
    ----------
    Somigliana's closed formula, NIMA TR8350.2 (4-1).

    Examples
    --------
    >>> round(gravity(math.radians(45.0)), 6)
    9.806198

    """
    s = math.sin(latitude_rad)
    s2 = s * s
    return 9.7803253359 * (1.0 + 1.931852652458e-3 * s2) / math.sqrt(1.0 - ECCENTRICITY2 * s2)


def earth_rate(latitude_rad: float) -> tuple[float, float]:
    """
    Return the horizontal (north) and the vertical (up) component of the Earth rate, rad/s.

    Examples
    --------
    >>> north, up = earth_rate(math.radians(30.0))
    >>> round(up / EARTH_RATE_RAD_S, 6)
    0.5

    """
    return EARTH_RATE_RAD_S * math.cos(latitude_rad), EARTH_RATE_RAD_S * math.sin(latitude_rad)
