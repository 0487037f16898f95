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

"""Short ways on the ellipsoid, against positions in space."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.ahrs.ship import earth
from heading_intercompare.core.motion.tangent_plane import radii_m, steps_m


def in_space(latitude_deg, longitude_deg):
    """Return earth-centred coordinates of a point on the ellipsoid, metres."""
    a, e2 = 6378137.0, 6.69437999014e-3
    phi, lam = np.radians(latitude_deg), np.radians(longitude_deg)
    n = a / np.sqrt(1.0 - e2 * np.sin(phi) ** 2)
    return np.array([n * np.cos(phi) * np.cos(lam), n * np.cos(phi) * np.sin(lam),
                     n * (1.0 - e2) * np.sin(phi)])


@pytest.mark.parametrize('latitude', [-75.0, -22.0, 0.0, 40.0, 60.0, 80.0])
def test_the_way_is_that_in_space(latitude, rng):
    """Over 100 m the chord is the way to a millionth."""
    for azimuth in rng.uniform(0.0, 2.0 * np.pi, 20):
        here = latitude, 179.9999
        there = (latitude + np.degrees(100.0 * np.cos(azimuth) / 6.37e6),
                 179.9999 + np.degrees(100.0 * np.sin(azimuth) / 6.37e6
                                       / np.cos(np.radians(latitude))))
        east, north = steps_m(here, there)
        chord = np.linalg.norm(in_space(*there) - in_space(*here))
        assert np.hypot(east, north) == pytest.approx(chord, rel=2e-6)
        assert (north > 0.0) == (np.cos(azimuth) > 0.0) and (east > 0.0) == (np.sin(azimuth) > 0.0)


def test_the_radii_are_those_of_the_simulator():
    assert [float(r) for r in radii_m(53.0)] == pytest.approx(earth.radii(np.radians(53.0)))
