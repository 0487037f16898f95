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

"""What a simulated ship tells of its motion, against the truth."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.ahrs.settings import Scenario
from heading_intercompare.ahrs.ship.ship_motion import ShipTruth
from heading_intercompare.ahrs.ship.steering import Leg
from heading_intercompare.ahrs.simulator import (
    POSITION_SIGMA_M,
    RATE_SIGMA_DEG_S,
    Simulation,
    ToldMotion,
    VELOCITY_SIGMA_M_S,
)
from heading_intercompare.core.motion.tangent_plane import steps_m
from heading_intercompare.core.records import Motion

START_NS = 1_700_000_000 * 10 ** 9
LEGS = [Leg(0.0, 30.0, 12.0), Leg(600.0, 150.0, 12.0)]


def ship():
    return ShipTruth(LEGS, 55.0, 4.0, 'ss3', 7)


def told(rate_hz=1.0, duration_s=3000.0):
    return ToldMotion(ship(), START_NS, 7, rate_hz, duration_s)


def test_the_noise_is_white_and_as_large_as_stated():
    """3000 rows: a standard deviation is known to 1.3 %; six of those are allowed."""
    rows, true = told().take(3000.0), ship()
    t = np.arange(3000.0)
    east, north = true.velocity_m_s(t)
    velocity, rate, fix = rows.velocities(), rows.rates(), rows.positions()
    off_m = steps_m(true.position_deg(t), (fix.latitude_deg, fix.longitude_deg))
    for noise, sigma in ((velocity.east_m_s - east, VELOCITY_SIGMA_M_S),
                         (velocity.north_m_s - north, VELOCITY_SIGMA_M_S),
                         (rate.rate_deg_s - np.degrees(true.heading_rate_rad_s(t)),
                          RATE_SIGMA_DEG_S), (off_m[0], POSITION_SIGMA_M),
                         (off_m[1], POSITION_SIGMA_M)):
        assert noise.size == 3000
        assert noise.std() == pytest.approx(sigma, rel=0.08)
        assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 6 / np.sqrt(3000)


def test_the_rows_do_not_depend_on_the_chunks(rng):
    whole, cut = told().take(3000.0), told()
    edges = [*np.sort(rng.uniform(0.0, 3000.0, 50)).tolist(), 3000.0]
    parts = Motion.concatenate([cut.take(edge) for edge in edges])
    for what, rows in whole.split().items():
        for name in Motion.__slots__:
            np.testing.assert_array_equal(getattr(parts.split()[what], name),
                                          getattr(rows, name))


def test_a_trial_tells_its_motion_at_its_rate_or_not_at_all():
    def count(rate_hz):
        trial = Scenario.from_mapping({'duration_s': 20.0, 'motion_hz': rate_hz})
        return sum(len(chunk.motion.rates()) for chunk in Simulation(trial).chunks(7.0))
    assert [count(rate) for rate in (0.0, 1.0, 5.0)] == [0, 20, 100]


def test_motion_changes_no_heading():
    def headings(rate_hz):
        trial = Scenario.from_mapping({'duration_s': 30.0, 'motion_hz': rate_hz,
                                       'ts': {'white_deg': 0.1}})
        return np.concatenate([chunk.ts.heading_deg for chunk in Simulation(trial).chunks()])
    np.testing.assert_array_equal(headings(0.0), headings(10.0))


def test_the_velocity_is_the_way_of_the_position():
    true, t = ship(), np.arange(0.0, 1200.0, 0.5)
    east, north = true.velocity_m_s(t)
    latitude, longitude = true.position_deg(t)
    gone = steps_m((latitude[:-1], longitude[:-1]), (latitude[1:], longitude[1:]))
    for step, speed in zip(gone, (east, north)):
        assert step == pytest.approx(0.25 * (speed[1:] + speed[:-1]), abs=0.02)
