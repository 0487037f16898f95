# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The motion of the ship, steered along a course plan and moved by the sea: the true heading."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Sequence

import numpy as np

from heading_intercompare.core.angles import wrap360

from .earth import EARTH_RATE_RAD_S, gravity, KNOT_M_S, radii
from .seaway import BLOCK_S, BLOCK_STEPS, CHANNELS, GRID_S, Seaway

__all__ = ['Leg', 'ShipBlock', 'ShipTruth']

STEP_S = 0.5
HORIZON_STEPS = 7200
NOMOTO_S = 20.0
RUDDER_GAIN_1_S = 0.08
RUDDER_RAD = math.radians(25.0)
TURN_RAD_S = math.radians(2.0)
COURSE_GAIN_1_S = 0.02
RATE_GAIN = 1.5
SPEED_LAG_S = 90.0
SENSOR_HEIGHT_M = 10.0


@dataclass(frozen=True, slots=True)
class Leg:
    """From `t_s` on, the autopilot steers `course_deg` at `speed_kn`."""

    t_s: float
    course_deg: float
    speed_kn: float


@dataclass(frozen=True, slots=True)
class ShipBlock:
    """
    The motion that the AHRS senses over one block of the grid, both ends included.

    All attributes are ndarrays of shape (601,), in rad, m and s: heading (continuous, not
    wrapped) and its rate; speed along the ship axis; velocity; latitude; roll and pitch with
    their rates; rate of the level frame and specific force along north, east and down.
    """

    heading_rad: np.ndarray
    heading_rate_rad_s: np.ndarray
    speed_m_s: np.ndarray
    north_m_s: np.ndarray
    east_m_s: np.ndarray
    latitude_rad: np.ndarray
    roll_rad: np.ndarray
    roll_rate_rad_s: np.ndarray
    pitch_rad: np.ndarray
    pitch_rate_rad_s: np.ndarray
    turn_north_rad_s: np.ndarray
    turn_east_rad_s: np.ndarray
    turn_down_rad_s: np.ndarray
    force_north_m_s2: np.ndarray
    force_east_m_s2: np.ndarray
    force_down_m_s2: np.ndarray


class ShipTruth:
    """
    Motion of the ship as a pure function of time.

    Two objects with the same arguments describe the same ship to the bit, whatever calls are made
    and in whatever order. Only a cache is kept between calls.

    Parameters
    ----------
    legs : sequence of Leg
        Course plan; the first leg starts at 0 and sets the initial heading and speed.
    latitude_deg, longitude_deg : float
        Initial position, degrees.
    seaway : str
        A name of `seaway.SEAWAYS`.
    seed : int
        Seed of the simulation.

    References
    ----------
    First-order steering T r' + r = K delta (Nomoto 1957) under a rate-limited autopilot that moves
    the rudder every 0.5 s. Between these steps the exponentials are evaluated by power series,
    because sums and products give the same bits in arrays of any length. Dead reckoning by
    trapezoids on the same grid.

    """

    def __init__(self, legs: Sequence[Leg], latitude_deg: float, longitude_deg: float = 0.0,
                 seaway: str = 'calm', seed: int = 0) -> None:
        self._legs = tuple(legs)
        self._sea = Seaway(seaway, seed)
        first = self._legs[0]
        self._state = (0, math.radians(first.course_deg), 0.0, first.speed_kn * KNOT_M_S,
                       math.radians(latitude_deg), math.radians(longitude_deg))
        self._rows: list[np.ndarray] = []
        self._grid = np.zeros((7, 0))
        self._block: tuple[int, ShipBlock] | None = None

    def heading_deg(self, t_s: np.ndarray) -> np.ndarray:
        """Return the true heading at any instants, shape (n,), degrees in [0, 360)."""
        return wrap360(np.degrees(self.heading_rad(t_s)))

    def heading_rad(self, t_s: np.ndarray) -> np.ndarray:
        """Return the true heading as a continuous angle, shape (n,), radians."""
        t = np.asarray(t_s, dtype=np.float64)
        return self._read_steering(t)[0] + self._sea.read('yaw', t)

    def heading_rate_rad_s(self, t_s: np.ndarray) -> np.ndarray:
        """Return the rate of turn to starboard, shape (n,), rad/s."""
        t = np.asarray(t_s, dtype=np.float64)
        return self._read_steering(t)[1] + self._sea.read('yaw', t, 1)

    def speed_m_s(self, t_s: np.ndarray) -> np.ndarray:
        """Return the speed along the ship axis, shape (n,), m/s."""
        return self._read_speed(np.asarray(t_s, dtype=np.float64))[0]

    def position_deg(self, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return latitude and longitude, each of shape (n,), degrees."""
        t = np.asarray(t_s, dtype=np.float64)
        grid = self._reach(t)
        at = np.arange(grid.shape[1]) * STEP_S
        return np.degrees(np.interp(t, at, grid[5])), np.degrees(np.interp(t, at, grid[6]))

    def velocity_m_s(self, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the velocity of the ship as steered to the east and north, shape (n,), m/s."""
        t = np.asarray(t_s, dtype=np.float64)
        steered, speed = self._read_steering(t)[0], self._read_speed(t)[0]
        return speed * np.sin(steered), speed * np.cos(steered)

    def roll_pitch_rad(self, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return roll (starboard down) and pitch (bow up), each of shape (n,), radians."""
        t = np.asarray(t_s, dtype=np.float64)
        return self._sea.read('roll', t), self._sea.read('pitch', t)

    def block(self, index: int) -> ShipBlock:
        """Return the ship on the grid of the control loop, over the minute number `index`."""
        if self._block is None or self._block[0] != index:
            self._block = index, self._tabulate(index)
        return self._block[1]

    def _tabulate(self, index: int) -> ShipBlock:
        t = index * BLOCK_S + GRID_S * np.arange(BLOCK_STEPS + 1)
        steered, turn = self._read_steering(t)
        speed, surge = self._read_speed(t)
        latitude = np.radians(self.position_deg(t)[0])
        north, east = speed * np.cos(steered), speed * np.sin(steered)
        sea = dict(zip(CHANNELS, self._sea.block(index)))
        # One latitude per block suffices for radii and gravity: at 15 knots a block is a quarter
        # of a mile.
        middle = float(latitude[BLOCK_STEPS // 2])
        meridian, normal = radii(middle)
        turning = 2.0 * EARTH_RATE_RAD_S * math.sin(middle) + east * math.tan(middle) / normal
        ahead = surge + sea['surge'][2] - SENSOR_HEIGHT_M * sea['pitch'][2]
        aside = speed * turn + sea['sway'][2] + SENSOR_HEIGHT_M * sea['roll'][2]
        return ShipBlock(
            heading_rad=steered + sea['yaw'][0],
            heading_rate_rad_s=turn + sea['yaw'][1],
            speed_m_s=speed,
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

    def _read_steering(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Read the steered heading and the rate of turn."""
        grid, step, u = self._place(t)
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
        """Steer for some more steps; rows: heading, r, r', v, v', latitude, longitude."""
        start, heading, r, v, latitude, longitude = self._state
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
                         latitude, longitude))
            north, east = v * math.cos(heading), v * math.sin(heading)
            heading += drive * STEP_S + (r - drive) * NOMOTO_S * (1.0 - turn_decay)
            r = drive + (r - drive) * turn_decay
            v = v_wanted + (v - v_wanted) * speed_decay
            meridian, normal = radii(latitude)
            latitude += 0.5 * STEP_S * (north + v * math.cos(heading)) / meridian
            longitude += (0.5 * STEP_S * (east + v * math.sin(heading))
                          / (normal * math.cos(latitude)))
        self._state = start + steps, heading, r, v, latitude, longitude
        return np.array(rows).T
