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

"""A simulated voyage: headings, and the motion of a ship with current and leeway."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from heading_intercompare.ahrs.ship.ship_motion import ShipTruth
from heading_intercompare.ahrs.ship.steering import Leg
from heading_intercompare.core.records import KNOT_M_S, Motion

START_NS = 1_700_000_000 * 10 ** 9


class Voyage(NamedTuple):
    """
    A voyage of 40 minutes with turns of 90, 90 and 60 degrees, in a seaway.

    Attributes
    ----------
    stamp_ns, heading_deg : ndarray
        The true heading, five times a second.
    courses, rates, positions
        Once a second, with the noise of a receiver.

    """

    stamp_ns: np.ndarray
    heading_deg: np.ndarray
    courses: Motion
    rates: Motion
    positions: Motion

    def sensors(self, rng):
        """Return the headings of a sound TS (0.1 deg) and RS (0.05 deg)."""
        n = self.heading_deg.size
        return (self.heading_deg + 0.1 * rng.standard_normal(n),
                self.heading_deg + 0.05 * rng.standard_normal(n))


def sail(seed: int, *, speed_kn: float = 10.0, current_kn: float = 1.5, leeway_deg: float = 4.0,
         duration_s: float = 2400.0) -> Voyage:
    """Sail a voyage with a current from a random direction."""
    rng = np.random.default_rng(seed)
    first, current = rng.uniform(0.0, 360.0), rng.uniform(0.0, 2.0 * np.pi)
    ship = ShipTruth([Leg(600.0 * k, (first + turn) % 360.0, speed_kn)
                      for k, turn in enumerate((0.0, 90.0, 180.0, 240.0))], 40.0, 5.0, 'ss3', seed)
    t, whole = np.arange(0.0, duration_s, 0.2), np.arange(0.0, duration_s)
    stamps, seconds = (START_NS + np.rint(each * 1e9).astype(np.int64) for each in (t, whole))
    through = ship.heading_rad(whole) + np.radians(leeway_deg)
    speed, drift = ship.speed_m_s(whole), current_kn * KNOT_M_S
    east = speed * np.sin(through) + drift * np.sin(current)
    north = speed * np.cos(through) + drift * np.cos(current)
    latitude = 40.0 + np.degrees(np.cumsum(north) / 6.36e6)
    longitude = 5.0 + np.degrees(np.cumsum(east) / 6.39e6 / np.cos(np.radians(40.0)))
    noise = 0.1 * rng.standard_normal((2, whole.size))
    jitter = 1e-5 * rng.standard_normal((2, whole.size))
    return Voyage(stamps, ship.heading_deg(t),
                  Motion.of_velocities(seconds, east + noise[0], north + noise[1]),
                  Motion.of_rates(seconds, np.degrees(ship.heading_rate_rad_s(whole))),
                  Motion.of_positions(seconds, latitude + jitter[0], longitude + jitter[1]))
