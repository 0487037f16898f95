# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""A ship that an autopilot steers along a course plan."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Sequence

import numpy as np

from heading_intercompare.core.records import Reals

from .course import Current, interpolate_way, NO_CURRENT, Push
from .earth import KNOT_M_S, radii

__all__ = ['Leg', 'Steering']

STEP_S = 0.5
HORIZON_STEPS = 7200
NOMOTO_S = 20.0
RUDDER_GAIN_1_S = 0.08
RUDDER_RAD = math.radians(25.0)
TURN_RAD_S = math.radians(2.0)
COURSE_GAIN_1_S = 0.02
RATE_GAIN = 1.5
SPEED_LAG_S = 90.0


@dataclass(frozen=True, slots=True)
class Leg:
    """From `t_s` on, the autopilot steers `course_deg` at `speed_kn` through the water."""

    t_s: float
    course_deg: float
    speed_kn: float


class Steering:
    """
    The motion of a ship along a course plan, as a pure function of time: a `course.Course`.

    Only a cache is kept between calls.

    Parameters
    ----------
    legs : sequence of Leg
        Course plan; the first leg starts at 0 and sets the initial heading and speed.
    latitude_deg, longitude_deg : float
        Initial position, degrees.
    current : Current, optional
        Carries the ship along; the plan is one of headings and of speeds through the water.

    References
    ----------
    First-order steering T r' + r = K delta (Nomoto 1957) under a rate-limited autopilot that moves
    the rudder every 0.5 s. Between these steps the exponentials are evaluated by power series,
    because sums and products give the same bits in arrays of any length. Dead reckoning by
    trapezoids on the same grid.

    """

    def __init__(self, legs: Sequence[Leg], latitude_deg: float, longitude_deg: float = 0.0,
                 current: Current = NO_CURRENT) -> None:
        self._legs = tuple(legs)
        self._current_m_s = current.velocity_m_s
        first = self._legs[0]
        self._state = (0, math.radians(first.course_deg), 0.0, first.speed_kn * KNOT_M_S,
                       math.radians(latitude_deg), math.radians(longitude_deg), 0.0, 0.0)
        self._rows: list[np.ndarray] = []
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
        at = np.arange(grid.shape[1]) * STEP_S
        return np.degrees(np.interp(t_s, at, grid[5])), np.degrees(np.interp(t_s, at, grid[6]))

    def read_way(self, t_s: Reals) -> tuple[Reals, Reals]:
        """Return the way through the water to the east and the north, metres."""
        grid = self._reach(t_s)
        heading, speed = grid[0], grid[3]
        return (interpolate_way(grid[7], speed * np.sin(heading), STEP_S, t_s),
                interpolate_way(grid[8], speed * np.cos(heading), STEP_S, t_s))

    def read_heading(self, t_s: Reals) -> tuple[Reals, Reals]:
        """Return the steered heading, rad, and the rate of turn, rad/s."""
        grid, step, u = self._place(t_s)
        decay, slope = u / NOMOTO_S, grid[2][step]
        turn = grid[1][step] + slope * u * (1.0 - decay / 2.0 + decay**2 / 6.0)
        heading = grid[0][step] + u * (grid[1][step] + slope * u * (
            0.5 - decay / 6.0 + decay**2 / 24.0))
        return heading, turn

    def _read_speed(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Read the speed and the acceleration along the ship axis."""
        grid, step, u = self._place(t)
        decay, slope = u / SPEED_LAG_S, grid[4][step]
        return (grid[3][step] + slope * u * (1.0 - decay / 2.0 + decay**2 / 6.0),
                slope * (1.0 - decay + decay**2 / 2.0))

    def _place(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the course grid, the step of each instant, and the time since that step."""
        grid = self._reach(t)
        step = (t / STEP_S).astype(np.int64)
        return grid, step, t - step * STEP_S

    def _reach(self, t: np.ndarray) -> np.ndarray:
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

    def _sail(self, steps: int) -> np.ndarray:
        """Steer for some more steps; rows: heading, r, r', v, v', position, way."""
        start, heading, r, v, latitude, longitude, way_east, way_north = self._state
        current_east, current_north = self._current_m_s
        turn_decay, speed_decay = math.exp(-STEP_S / NOMOTO_S), math.exp(-STEP_S / SPEED_LAG_S)
        rudder = RUDDER_GAIN_1_S * RUDDER_RAD
        leg, later = self._legs[0], list(self._legs[1:])
        rows = []
        for k in range(start, start + steps):
            while later and later[0].t_s <= k * STEP_S:
                leg = later.pop(0)
            away = math.radians(leg.course_deg) - heading
            away -= 2.0 * math.pi * math.floor(away / (2.0 * math.pi) + 0.5)
            wanted = min(max(COURSE_GAIN_1_S * away, -TURN_RAD_S), TURN_RAD_S)
            drive = min(max(wanted + RATE_GAIN * (wanted - r), -rudder), rudder)
            v_wanted = leg.speed_kn * KNOT_M_S
            rows.append((heading, r, (drive - r) / NOMOTO_S, v, (v_wanted - v) / SPEED_LAG_S,
                         latitude, longitude, way_east, way_north))
            north, east = v * math.cos(heading), v * math.sin(heading)
            heading += drive * STEP_S + (r - drive) * NOMOTO_S * (1.0 - turn_decay)
            r = drive + (r - drive) * turn_decay
            v = v_wanted + (v - v_wanted) * speed_decay
            meridian, normal = radii(latitude)
            to_east = 0.5 * STEP_S * (east + v * math.sin(heading))
            to_north = 0.5 * STEP_S * (north + v * math.cos(heading))
            way_east += to_east
            way_north += to_north
            latitude += (to_north + STEP_S * current_north) / meridian
            longitude += (to_east + STEP_S * current_east) / (normal * math.cos(latitude))
        self._state = (start + steps, heading, r, v, latitude, longitude, way_east, way_north)
        return np.array(rows).T
