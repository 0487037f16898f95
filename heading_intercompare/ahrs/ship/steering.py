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

"""A ship that an autopilot steers along a course plan."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Any, Callable, NamedTuple, Sequence

import numpy as np

from heading_intercompare.core.records import Integers, Reals

from .course import Current, interpolate_way, NO_CURRENT, Push
from .earth import KNOT_M_S, radii

State = tuple[float, float, float, float, float, float, float]

STEP_S = 0.5
HORIZON_STEPS = 7200
NOMOTO_S = 20.0
RUDDER_GAIN_1_S = 0.08
RUDDER_RAD = math.radians(25.0)
USUAL_TURN_DEG_S = 2.0
COURSE_GAIN_1_S = 0.02
RATE_GAIN = 1.5
SPEED_LAG_S = 90.0


@dataclass(frozen=True, slots=True)
class Leg:
    """From `t_s` on, the autopilot steers `course_deg` at `speed_kn` through the water."""

    t_s: float
    course_deg: float
    speed_kn: float


class Helm(NamedTuple):
    """
    How a ship answers its autopilot.

    Attributes
    ----------
    turn_rad_s
        Greatest rate of turn that the autopilot orders.
    rudder_rad_s
        Rate of turn with the rudder hard over.
    course_gain_1_s
        Rate of turn ordered for an angle off the course.
    lag_s
        Time in which the rate of turn follows the rudder.
    decay
        What a step leaves of a difference of the rate of turn.

    """

    turn_rad_s: float
    rudder_rad_s: float
    course_gain_1_s: float
    lag_s: float
    decay: float

    @classmethod
    def of_turn(cls, turn_deg_s: float) -> 'Helm':
        """Return that of a ship; one that turns faster than the usual ship answers faster."""
        agility = max(1.0, turn_deg_s / USUAL_TURN_DEG_S)
        lag_s = NOMOTO_S / agility
        return cls(math.radians(turn_deg_s), RUDDER_GAIN_1_S * RUDDER_RAD * agility,
                   COURSE_GAIN_1_S * agility, lag_s, math.exp(-STEP_S / lag_s))


class Steering:
    """
    The motion of a ship along a course plan, as a pure function of time: a `course.Course`.

    Only a cache is kept between calls.

    Parameters
    ----------
    legs
        Course plan; the first leg starts at 0 and sets the initial heading and speed.
    latitude_deg, longitude_deg
        Initial position, degrees.
    current
        Carries the ship along; the plan is one of headings and of speeds through the water.
    turn_deg_s
        Greatest rate of turn that the autopilot orders, degrees per second.

    Attributes
    ----------
    sail
        `sail`, or the same compiled.

    References
    ----------
    First-order steering T r' + r = K delta (Nomoto 1957) under a rate-limited autopilot that moves
    the rudder every 0.5 s. Between these steps the exponentials are evaluated by power series,
    because sums and products give the same bits in arrays of any length. Dead reckoning by
    trapezoids on the same grid.

    """

    def __init__(self, legs: Sequence[Leg], latitude_deg: float, longitude_deg: float = 0.0,
                 current: Current = NO_CURRENT, turn_deg_s: float = USUAL_TURN_DEG_S) -> None:
        self._helm = Helm.of_turn(turn_deg_s)
        self._legs = tuple(legs)
        self._current_m_s = current.velocity_m_s
        first = self._legs[0]
        self._first, self._state = 0, (
            math.radians(first.course_deg), 0.0, first.speed_kn * KNOT_M_S,
            math.radians(latitude_deg), math.radians(longitude_deg), 0.0, 0.0)
        self.sail: Callable[..., State] = sail
        self._rows: list[Reals] = []
        self._grid = np.zeros((9, 0))

    def read_speed(self, t_s: Reals) -> Reals:
        """Return the speed through the water, m/s."""
        return self._read_speed(t_s)[0]

    def read_velocity(self, t_s: Reals) -> tuple[Reals, Reals]:
        """Return the velocity over ground to the east and the north, m/s."""
        heading, speed = self.read_heading(t_s)[0], self._read_speed(t_s)[0]
        east, north = self._current_m_s
        return speed * np.sin(heading) + east, speed * np.cos(heading) + north

    def read_push(self, t_s: Reals) -> Push:
        """Return the acceleration; a steady current adds none."""
        speed, surge = self._read_speed(t_s)
        return Push(surge, speed * self.read_heading(t_s)[1])

    def read_position(self, t_s: Reals) -> tuple[Reals, Reals]:
        """Return latitude and longitude, degrees."""
        grid = self._reach(t_s)
        if not t_s.size:
            return t_s, t_s
        near = slice(int(float(t_s.min()) / STEP_S), int(float(t_s.max()) / STEP_S) + 2)
        at = np.arange(near.start, near.stop) * STEP_S
        latitude, longitude = (np.degrees(np.interp(t_s, at, row[near])) for row in grid[5:7])
        return latitude, longitude

    def read_way(self, t_s: Reals) -> tuple[Reals, Reals]:
        """Return the way through the water to the east and the north, metres."""
        grid = self._reach(t_s)
        heading, speed = grid[0], grid[3]
        return (interpolate_way(grid[7], speed * np.sin(heading), STEP_S, t_s),
                interpolate_way(grid[8], speed * np.cos(heading), STEP_S, t_s))

    def read_heading(self, t_s: Reals) -> tuple[Reals, Reals]:
        """Return the steered heading, rad, and the rate of turn, rad/s."""
        grid, step, u = self._place(t_s)
        decay, slope = u / self._helm.lag_s, grid[2][step]
        turn = grid[1][step] + slope * u * (1.0 - decay / 2.0 + decay**2 / 6.0)
        heading = grid[0][step] + u * (grid[1][step] + slope * u * (
            0.5 - decay / 6.0 + decay**2 / 24.0))
        return heading, turn

    def _read_speed(self, t: Reals) -> tuple[Reals, Reals]:
        """Read the speed and the acceleration along the ship axis."""
        grid, step, u = self._place(t)
        decay, slope = u / SPEED_LAG_S, grid[4][step]
        return (grid[3][step] + slope * u * (1.0 - decay / 2.0 + decay**2 / 6.0),
                slope * (1.0 - decay + decay**2 / 2.0))

    def _place(self, t: Reals) -> tuple[Reals, Integers, Reals]:
        """Return the course grid, the step of each instant, and the time since that step."""
        grid = self._reach(t)
        step = (t / STEP_S).astype(np.int64)
        return grid, step, t - step * STEP_S

    def _reach(self, t: Reals) -> Reals:
        """Return the course grid, extended as far as these instants."""
        if t.size:
            if float(t.min()) < 0.0:
                raise ValueError(f't_s = {float(t.min())!r}: must be at least 0')
            last = int(float(t.max()) / STEP_S) + 2
            if last >= self._grid.shape[1]:
                while last >= HORIZON_STEPS * len(self._rows):
                    self._rows.append(self._sail(HORIZON_STEPS))
                self._grid = np.concatenate(self._rows, axis=1)
        return self._grid

    def _sail(self, steps: int) -> Reals:
        """Steer for some more steps; rows: heading, r, r', v, v', position, way."""
        legs = zip(*((leg.t_s, math.radians(leg.course_deg), leg.speed_kn * KNOT_M_S)
                     for leg in self._legs))
        rows: Any = [[0.0] * 9 for _ in range(steps)]
        columns: list[Any] = [list(column) for column in legs]
        if self.sail is not sail:
            rows, columns = np.array(rows), [np.array(column) for column in columns]
        self._state = self.sail(
            self._first, self._state, *columns, self._helm, math.exp(-STEP_S / SPEED_LAG_S),
            *self._current_m_s, rows)
        self._first += steps
        return np.array(rows).T


def sail(first: int, state: State, begins_s: Sequence[float], courses_rad: Sequence[float],
         speeds_m_s: Sequence[float], helm: Helm, speed_decay: float,
         current_east_m_s: float, current_north_m_s: float, rows: list[list[float]]) -> State:
    """
    Steer for some steps; numba can compile this.

    Parameters
    ----------
    first
        Number of the first step.
    state : tuple of float
        Heading, rad, its rate, speed, m/s, latitude and longitude, rad, and the way to the east
        and the north, metres.
    begins_s, courses_rad, speeds_m_s
        The legs, from the first.
    helm
        How the ship answers its autopilot.
    speed_decay
        What a step leaves of a difference of the speed.
    current_east_m_s, current_north_m_s
        Velocity of the current.
    rows : list of lists, or ndarray, shape (steps, 9)
        Gets a row for each step; see `Steering`.

    Returns
    -------
    tuple of float
        The state after them.

    """
    heading, r, v, latitude, longitude, way_east, way_north = state
    turn, rudder, gain, lag, turn_decay = helm
    leg = 0
    north, east = v * math.cos(heading), v * math.sin(heading)
    for k in range(len(rows)):
        while leg + 1 < len(begins_s) and begins_s[leg + 1] <= (first + k) * STEP_S:
            leg += 1
        away = courses_rad[leg] - heading
        away -= 2.0 * math.pi * math.floor(away / (2.0 * math.pi) + 0.5)
        wanted = min(max(gain * away, -turn), turn)
        drive = min(max(wanted + RATE_GAIN * (wanted - r), -rudder), rudder)
        v_wanted = speeds_m_s[leg]
        row = rows[k]
        row[0], row[1], row[2] = heading, r, (drive - r) / lag
        row[3], row[4] = v, (v_wanted - v) / SPEED_LAG_S
        row[5], row[6], row[7], row[8] = latitude, longitude, way_east, way_north
        heading += drive * STEP_S + (r - drive) * lag * (1.0 - turn_decay)
        r = drive + (r - drive) * turn_decay
        v = v_wanted + (v - v_wanted) * speed_decay
        meridian, normal = radii(latitude)
        from_north, from_east = north, east
        north, east = v * math.cos(heading), v * math.sin(heading)
        to_east = 0.5 * STEP_S * (from_east + east)
        to_north = 0.5 * STEP_S * (from_north + north)
        way_east += to_east
        way_north += to_north
        latitude += (to_north + STEP_S * current_north_m_s) / meridian
        longitude += (to_east + STEP_S * current_east_m_s) / (normal * math.cos(latitude))
    return heading, r, v, latitude, longitude, way_east, way_north
