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

"""The azimuth of the sun, by the library `ephem` of the extra `sun`; no network, no data files."""

from __future__ import annotations

import ephem
import numpy as np

from heading_intercompare.core.records import Integers, Reals
from heading_intercompare.core.utc_text import DAY_NS

#: Days of the library count from 1899-12-31 12:00.
_DAYS_TO_1970 = 25567.5


def find_sun(stamp_ns: Integers, latitude_deg: Reals,
             longitude_deg: Reals) -> tuple[Reals, Reals]:
    """
    Return the true azimuth and the altitude of the centre of the sun.

    Parameters
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        UTC nanoseconds.
    latitude_deg, longitude_deg : ndarray, shape (n,)
        Place of the observer, degrees, north and east positive.

    Returns
    -------
    azimuth_deg, altitude_deg : ndarray, shape (n,)
        Degrees; the altitude without refraction. UTC stands for UT1, which adds up to 0.004 deg
        to the hour angle.

    Examples
    --------
    >>> import numpy as np
    >>> noon = np.array([1_774_008_000_000_000_000])
    >>> azimuth, altitude = find_sun(noon, np.array([54.0]), np.array([10.0]))
    >>> round(float(azimuth[0]), 1), round(float(altitude[0]), 1)
    (190.0, 35.5)

    """
    azimuth_altitude_rad = np.empty((2, stamp_ns.size))
    observer, sun = ephem.Observer(), ephem.Sun()
    observer.pressure = 0.0
    for i, at_ns in enumerate(stamp_ns.tolist()):
        observer.lat = float(np.radians(latitude_deg[i]))
        observer.lon = float(np.radians(longitude_deg[i]))
        observer.date = at_ns / DAY_NS + _DAYS_TO_1970
        sun.compute(observer)
        azimuth_altitude_rad[:, i] = float(sun.az), float(sun.alt)
    azimuth_deg, altitude_deg = np.degrees(azimuth_altitude_rad)
    return azimuth_deg, altitude_deg
