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

"""A ship that repeats a recorded voyage."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import TYPE_CHECKING

import numpy as np

from heading_intercompare.core.records import Reals

from .course import Current, interpolate_way, NO_CURRENT, Push
from .earth import radii
from .seaway import BLOCK_S, BLOCK_STEPS, CHANNELS, GRID_S, Sea

if TYPE_CHECKING:
    from heading_intercompare.core.motion.smoothing import Smooth


STEP_S = 0.5
_BEYOND_S = 120.0


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """
    A recorded voyage as smooth functions of the seconds since its start.

    Attributes
    ----------
    start_ns
        UTC stamp of the start, nanoseconds.
    duration_s
        Length of the record, seconds.
    heading_rad
        True heading as a continuous angle.
    east_m_s, north_m_s
        Velocity over ground.
    position_deg
        Latitude and longitude at the start; None if the record has none.
    roll_rad, pitch_rad
        Starboard down, and bow up; None if the record has none.

    """

    start_ns: int
    duration_s: float
    heading_rad: 'Smooth'
    east_m_s: 'Smooth'
    north_m_s: 'Smooth'
    position_deg: tuple[float, float] | None = None
    roll_rad: 'Smooth | None' = None
    pitch_rad: 'Smooth | None' = None


class TrackCourse:
    """
    The motion of a ship along a track: a `course.Course`.

    Parameters
    ----------
    track
        What was recorded.
    latitude_deg, longitude_deg
        Initial position, degrees, if the record has none.
    current
        The current that the ship had: the speed through the water is the recorded velocity minus
        this, along the axis of the ship. What remains across is leeway.

    Notes
    -----
    Positions and ways are the integral of the velocity, so that they agree with it.

    """

    def __init__(self, track: Track, latitude_deg: float, longitude_deg: float = 0.0,
                 current: Current = NO_CURRENT) -> None:
        self._track, self._current_m_s = track, current.velocity_m_s
        first = track.position_deg or (latitude_deg, longitude_deg)
        t_s = STEP_S * np.arange(math.ceil((track.duration_s + _BEYOND_S) / STEP_S),
                                 dtype=np.float64)
        east, north = self.read_velocity(t_s)
        middle = [0.5 * STEP_S * (speed[:-1] + speed[1:]) for speed in (east, north)]
        latitude, longitude = math.radians(first[0]), math.radians(first[1])
        rows = [(latitude, longitude)]
        for to_east, to_north in zip(middle[0].tolist(), middle[1].tolist()):
            meridian, normal = radii(latitude)
            latitude += to_north / meridian
            longitude += to_east / (normal * math.cos(latitude))
            rows.append((latitude, longitude))
        self._positions_deg = np.degrees(np.array(rows).T)
        self._grid_s = t_s
        self._speeds = east - self._current_m_s[0], north - self._current_m_s[1]
        self._ways = [_integrate(speed) for speed in self._speeds]

    def read_heading(self, t_s: Reals) -> tuple[Reals, Reals]:
        """Return the heading, rad, and the rate of turn, rad/s."""
        return self._track.heading_rad.read(t_s), self._track.heading_rad.read(t_s, 1)

    def read_velocity(self, t_s: Reals) -> tuple[Reals, Reals]:
        """Return the velocity over ground to the east and the north, m/s."""
        return self._track.east_m_s.read(t_s), self._track.north_m_s.read(t_s)

    def read_speed(self, t_s: Reals) -> Reals:
        """Return the speed through the water along the ship axis, m/s."""
        heading, (east, north) = self._track.heading_rad.read(t_s), self.read_velocity(t_s)
        return ((east - self._current_m_s[0]) * np.sin(heading)
                + (north - self._current_m_s[1]) * np.cos(heading))

    def read_push(self, t_s: Reals) -> Push:
        """Return the acceleration over ground in the axes of the ship."""
        heading = self._track.heading_rad.read(t_s)
        east, north = self._track.east_m_s.read(t_s, 1), self._track.north_m_s.read(t_s, 1)
        c, s = np.cos(heading), np.sin(heading)
        return Push(north * c + east * s, east * c - north * s)

    def read_position(self, t_s: Reals) -> tuple[Reals, Reals]:
        """Return latitude and longitude, degrees."""
        latitude, longitude = self._positions_deg
        return np.interp(t_s, self._grid_s, latitude), np.interp(t_s, self._grid_s, longitude)

    def read_way(self, t_s: Reals) -> tuple[Reals, Reals]:
        """Return the way through the water to the east and the north, metres."""
        east, north = (interpolate_way(way, speed, STEP_S, t_s)
                       for way, speed in zip(self._ways, self._speeds))
        return east, north


def _integrate(speed_m_s: Reals) -> Reals:
    """Return the way from the start of the grid, by trapezoids."""
    return np.concatenate(([0.0], np.cumsum(0.5 * STEP_S * (speed_m_s[:-1] + speed_m_s[1:]))))


class SeaAboard:
    """
    The sea on a recorded voyage: what the record tells of it, the rest simulated.

    The recorded heading has the yaw of the ship in it, so there is no other. Recorded roll and
    pitch take the place of simulated ones.

    Parameters
    ----------
    track
        The record.
    sea
        The simulated sea.

    """

    def __init__(self, track: Track, sea: Sea) -> None:
        self._sea = sea
        self._angles = {channel: function for channel, function in (
            ('roll', track.roll_rad), ('pitch', track.pitch_rad)) if function is not None}
        self.calm = sea.calm and not self._angles

    def block(self, index: int) -> Reals:
        """Return the motion over one block of the grid, shape (6, 3, 601); see `Seaway.block`."""
        values = self._sea.block(index).copy()
        values[CHANNELS.index('yaw')] = 0.0
        t_s = index * BLOCK_S + GRID_S * np.arange(BLOCK_STEPS + 1, dtype=np.float64)
        for channel, function in self._angles.items():
            values[CHANNELS.index(channel)] = [function.read(t_s, order) for order in range(3)]
        return values

    def read(self, t_s: Reals, *channels: tuple[str, int]) -> list[Reals]:
        """Return channels or their rates at any instants; see `Seaway.read`."""
        simulated = self._sea.read(t_s, *channels)
        return [np.zeros(t_s.shape) if channel == 'yaw' else
                self._angles[channel].read(t_s, order) if channel in self._angles else value
                for (channel, order), value in zip(channels, simulated)]
