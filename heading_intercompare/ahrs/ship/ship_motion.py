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

"""The motion of the ship, on its course and moved by the sea: the true heading."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import NamedTuple, Sequence

import numpy as np

from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.records import Reals

from .course import Course, Current, NO_CURRENT
from .earth import EARTH_RATE_RAD_S, gravity, radii
from .seaway import BLOCK_S, BLOCK_STEPS, CHANNELS, GRID_S, Sea, Seaway
from .steering import Leg, Steering, USUAL_TURN_DEG_S
from .track_course import SeaAboard, Track, TrackCourse
from .wave_sea import Hull, USUAL_HULL, Waves, WaveSea

SENSOR_HEIGHT_M = 10.0


@dataclass(frozen=True, slots=True)
class ShipBlock:
    """
    The motion that the AHRS senses over one block of the grid, both ends included.

    All attributes are ndarrays of shape (601,), in rad, m and s: heading (continuous, not
    wrapped) and its rate; speed through the water along the ship axis; velocity over ground;
    latitude; roll and pitch with their rates; rate of the level frame and specific force along
    north, east and down.
    """

    heading_rad: Reals
    heading_rate_rad_s: Reals
    speed_m_s: Reals
    north_m_s: Reals
    east_m_s: Reals
    latitude_rad: Reals
    roll_rad: Reals
    roll_rate_rad_s: Reals
    pitch_rad: Reals
    pitch_rate_rad_s: Reals
    turn_north_rad_s: Reals
    turn_east_rad_s: Reals
    turn_down_rad_s: Reals
    force_north_m_s2: Reals
    force_east_m_s2: Reals
    force_down_m_s2: Reals


class Attitude(NamedTuple):
    """
    The attitude of the ship at some instants, each of shape (n,).

    Heading as a continuous angle, rad, and its rate, rad/s; roll, starboard down, and pitch, bow
    up, rad.
    """

    heading_rad: Reals
    heading_rate_rad_s: Reals
    roll_rad: Reals
    pitch_rad: Reals


class ShipTruth:
    """
    Motion of the ship as a pure function of time.

    Two objects with the same arguments describe the same ship to the bit, whatever calls are made
    and in whatever order. Only a cache is kept between calls.

    Parameters
    ----------
    legs
        Course plan; the first leg starts at 0 and sets the initial heading and speed. A track
        takes its place.
    latitude_deg, longitude_deg
        Initial position, degrees.
    seaway
        A name of `seaway.SEAWAYS`.
    seed
        Seed of the simulation.
    current
        A steady current; default none.
    waves
        Waves that the ship meets; they take the place of `seaway`.
    hull
        How the ship answers these waves.
    track
        A recorded voyage to repeat.
    turn_deg_s
        Greatest rate of turn that the autopilot orders.

    Attributes
    ----------
    course
        Where it points and goes, apart from the sea.

    """

    def __init__(self, legs: Sequence[Leg], latitude_deg: float, longitude_deg: float = 0.0,
                 seaway: str = 'calm', seed: int = 0, *, current: Current = NO_CURRENT,
                 waves: Waves | None = None, hull: Hull = USUAL_HULL,
                 track: Track | None = None,
                 turn_deg_s: float = USUAL_TURN_DEG_S) -> None:
        self.course: Course = (
            Steering(legs, latitude_deg, longitude_deg, current, turn_deg_s) if track is None
            else TrackCourse(track, latitude_deg, longitude_deg, current))
        sea: Sea = (Seaway(seaway, seed) if waves is None
                    else WaveSea(waves, hull, self.course, seed))
        self._sea: Sea = sea if track is None else SeaAboard(track, sea)
        self._block: tuple[int, ShipBlock] | None = None

    def heading_deg(self, t_s: Reals) -> Reals:
        """Return the true heading at any instants, shape (n,), degrees in [0, 360)."""
        return wrap360(np.degrees(self.heading_rad(t_s)))

    def heading_rad(self, t_s: Reals) -> Reals:
        """Return the true heading as a continuous angle, shape (n,), radians."""
        t = np.asarray(t_s, dtype=np.float64)
        return self.course.read_heading(t)[0] + self._sea.read(t, ('yaw', 0))[0]

    def heading_rate_rad_s(self, t_s: Reals) -> Reals:
        """Return the rate of turn to starboard, shape (n,), rad/s."""
        t = np.asarray(t_s, dtype=np.float64)
        return self.course.read_heading(t)[1] + self._sea.read(t, ('yaw', 1))[0]

    def read_heading(self, t_s: Reals) -> tuple[Reals, Reals]:
        """Return `heading_rad` and `heading_rate_rad_s` in less time than one by one."""
        t = np.asarray(t_s, dtype=np.float64)
        (steered, turn), (yaw, rate) = (self.course.read_heading(t),
                                        self._sea.read(t, ('yaw', 0), ('yaw', 1)))
        return steered + yaw, turn + rate

    def read_attitude(self, t_s: Reals) -> Attitude:
        """Return heading, roll and pitch in less time than one by one."""
        t = np.asarray(t_s, dtype=np.float64)
        steered, turn = self.course.read_heading(t)
        yaw, rate, roll, pitch = self._sea.read(
            t, ('yaw', 0), ('yaw', 1), ('roll', 0), ('pitch', 0))
        return Attitude(steered + yaw, turn + rate, roll, pitch)

    def speed_m_s(self, t_s: Reals) -> Reals:
        """Return the speed through the water along the ship axis, shape (n,), m/s."""
        return self.course.read_speed(np.asarray(t_s, dtype=np.float64))

    def position_deg(self, t_s: Reals) -> tuple[Reals, Reals]:
        """Return latitude and longitude, each of shape (n,), degrees."""
        return self.course.read_position(np.asarray(t_s, dtype=np.float64))

    def velocity_m_s(self, t_s: Reals) -> tuple[Reals, Reals]:
        """Return the velocity over ground to the east and north, without the sea, (n,), m/s."""
        return self.course.read_velocity(np.asarray(t_s, dtype=np.float64))

    def block(self, index: int) -> ShipBlock:
        """Return the ship on the grid of the control loop, over the minute number `index`."""
        if self._block is None or self._block[0] != index:
            self._block = index, self._tabulate(index)
        return self._block[1]

    def _tabulate(self, index: int) -> ShipBlock:
        t = index * BLOCK_S + GRID_S * np.arange(BLOCK_STEPS + 1, dtype=np.float64)
        steered, turn = self.course.read_heading(t)
        east, north = self.course.read_velocity(t)
        push = self.course.read_push(t)
        latitude = np.radians(self.position_deg(t)[0])
        sea = dict(zip(CHANNELS, self._sea.block(index)))
        # One latitude per block suffices for radii and gravity: at 15 knots a block is a quarter
        # of a mile.
        middle = float(latitude[BLOCK_STEPS // 2])
        meridian, normal = radii(middle)
        turning = 2.0 * EARTH_RATE_RAD_S * math.sin(middle) + east * math.tan(middle) / normal
        ahead = push.ahead_m_s2 + sea['surge'][2] - SENSOR_HEIGHT_M * sea['pitch'][2]
        aside = push.aside_m_s2 + sea['sway'][2] + SENSOR_HEIGHT_M * sea['roll'][2]
        return ShipBlock(
            heading_rad=steered + sea['yaw'][0],
            heading_rate_rad_s=turn + sea['yaw'][1],
            speed_m_s=self.course.read_speed(t),
            north_m_s=north,
            east_m_s=east,
            latitude_rad=latitude,
            roll_rad=sea['roll'][0],
            roll_rate_rad_s=sea['roll'][1],
            pitch_rad=sea['pitch'][0],
            pitch_rate_rad_s=sea['pitch'][1],
            turn_north_rad_s=EARTH_RATE_RAD_S * np.cos(latitude) + east / normal,
            turn_east_rad_s=-north / meridian,
            turn_down_rad_s=-EARTH_RATE_RAD_S * np.sin(latitude)
            - east * np.tan(latitude) / normal,
            force_north_m_s2=ahead * np.cos(steered) - aside * np.sin(steered) + turning * east,
            force_east_m_s2=ahead * np.sin(steered) + aside * np.cos(steered) - turning * north,
            force_down_m_s2=-gravity(middle) + sea['heave'][2])
