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

"""The azimuth of the sun against a published example, and against the almanac's formulae."""

from __future__ import annotations

from datetime import datetime, timezone

import numpy as np
import pytest

from heading_intercompare.core.angles import wrap180

pytest.importorskip('ephem')

from heading_intercompare.app.observations.sun import find_sun  # noqa: E402


def stamp(*moment):
    """Return a UTC moment in nanoseconds."""
    return int(datetime(*moment, tzinfo=timezone.utc).timestamp()) * 1_000_000_000


def test_the_published_example_of_the_solar_position_algorithm():
    """Reda & Andreas 2004, NREL/TP-560-34302, table A5.1: azimuth 194.340241, zenith 50.111622."""
    azimuth, altitude = find_sun(np.array([stamp(2003, 10, 17, 19, 30, 30)]),
                                 np.array([39.742476]), np.array([-105.1786]))
    assert azimuth[0] == pytest.approx(194.340241, abs=0.002)
    # Their zenith has refraction of 0.016 deg in it.
    assert altitude[0] == pytest.approx(90.0 - 50.111622 - 0.016, abs=0.005)


def low_precision(stamp_ns, latitude_deg, longitude_deg):
    """Return azimuth and altitude by the low-precision formulae of the Astronomical Almanac."""
    days = stamp_ns / 86_400e9 + 2440587.5 - 2451545.0
    mean, anomaly = 280.460 + 0.9856474 * days, np.radians(357.528 + 0.9856003 * days)
    ecliptic = np.radians(mean + 1.915 * np.sin(anomaly) + 0.020 * np.sin(2.0 * anomaly))
    tilt = np.radians(23.439 - 4e-7 * days)
    ascension = np.degrees(np.arctan2(np.cos(tilt) * np.sin(ecliptic), np.cos(ecliptic)))
    declination = np.arcsin(np.sin(tilt) * np.sin(ecliptic))
    sidereal = 280.46061837 + 360.98564736629 * days
    hour, latitude = np.radians(sidereal + longitude_deg - ascension), np.radians(latitude_deg)
    east = -np.cos(declination) * np.sin(hour)
    north = (np.sin(declination) * np.cos(latitude)
             - np.cos(declination) * np.sin(latitude) * np.cos(hour))
    up = (np.sin(declination) * np.sin(latitude)
          + np.cos(declination) * np.cos(latitude) * np.cos(hour))
    return np.degrees(np.arctan2(east, north)), np.degrees(np.arcsin(up))


def test_it_agrees_with_the_almanac_over_decades_and_the_globe(rng):
    """Those formulae are good to 0.01 deg from 1950 to 2050; azimuths near the zenith suffer."""
    n = 500
    stamps = rng.integers(stamp(1990, 1, 1), stamp(2045, 1, 1), n)
    latitude, longitude = rng.uniform(-75.0, 75.0, n), rng.uniform(-180.0, 180.0, n)
    azimuth, altitude = find_sun(stamps, latitude, longitude)
    other, other_altitude = low_precision(stamps, latitude, longitude)
    seen = (altitude > 0.0) & (altitude < 60.0)
    assert seen.sum() > 150
    assert np.abs(wrap180(azimuth - other))[seen].max() < 0.03
    assert np.abs(altitude - other_altitude)[seen].max() < 0.02
