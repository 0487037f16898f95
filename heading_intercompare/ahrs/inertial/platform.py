# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The gimballed platform with its instruments: turns commands into measurements, step by step."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from heading_intercompare.ahrs.ship.seaway import GRID_S
from heading_intercompare.ahrs.ship.ship_motion import ShipBlock

from . import loop
from .instruments import Instruments

__all__ = ['Platform', 'rows_of']

SERVO_1_S2 = 4.0
SERVO_RATE_1_S = 2.8


def rows_of(ship: ShipBlock, first: int, random: dict[str, np.ndarray]) -> np.ndarray:
    """
    Return the inputs of the platform over each control step, shape (n, 20).

    Parameters
    ----------
    ship : ShipBlock
        The ship over the minute.
    first : int
        Step of the minute at which the rows begin; the random errors give their number.
    random : dict of ndarray
        Errors, from `Instruments.take`.

    """
    n = random['log'].size
    start, stop = slice(first, first + n), slice(first + 1, first + n + 1)

    def mean(values: np.ndarray) -> np.ndarray:
        return 0.5 * (values[start] + values[stop])

    return np.column_stack((
        mean(ship.turn_north_rad_s), mean(ship.turn_east_rad_s), mean(ship.turn_down_rad_s),
        mean(ship.force_north_m_s2), mean(ship.force_east_m_s2), mean(ship.force_down_m_s2),
        ship.heading_rad[stop], ship.speed_m_s[stop], ship.latitude_rad[stop],
        mean(ship.roll_rate_rad_s), mean(ship.pitch_rate_rad_s), *(random[name] for name in (
            'drift_x', 'drift_y', 'drift_z', 'meter_x', 'meter_y', 'bias_x', 'bias_y', 'log',
            'gps'))))


class Platform:
    """
    The true state of the platform, and the readings of its instruments.

    Attributes
    ----------
    alpha_rad, beta_rad : float
        Tilts about x and y of the platform, right-handed.
    azimuth_rad : float
        Azimuth of x of the platform, clockwise from true north.
    angle_rad : float
        Angle of the rotation unit that carries the course gyro.
    force_x_m_s2, force_y_m_s2 : float
        Horizontal accelerometers, mean over the last step.
    rate_x_rad_s, rate_y_rad_s : float
        Course gyro as a rate meter, mean over the last step.
    pick_off_rad : float
        Angle from x of the platform to the ship's axis.
    speed_m_s, latitude_rad, roll_rate_rad_s, pitch_rate_rad_s : float
        Log, position and gimbal rates.
    satellite_rad : float
        Satellite heading.
    ux_rad_s, uy_rad_s, uz_rad_s : float
        Rates commanded for the last step.
    quantum_m_s, part_x_m_s, part_y_m_s : float
        Velocity step of the accelerometers, and the velocity not yet counted.

    Notes
    -----
    First order in the tilts, exact in azimuth. If the azimuth turns fast, the tilts turn with it:
    the rate about z of the platform, not that of the level frame, couples them.

    """

    def __init__(self, instruments: Instruments, step_m_s: float) -> None:
        self.instruments = instruments
        self.alpha_rad = self.beta_rad = self.azimuth_rad = 0.0
        self.angle_rad = self.angle_rate_rad_s = 0.0
        self.force_x_m_s2 = self.force_y_m_s2 = 0.0
        self.rate_x_rad_s = self.rate_y_rad_s = 0.0
        self.pick_off_rad = self.satellite_rad = 0.0
        self.speed_m_s = self.latitude_rad = 0.0
        self.roll_rate_rad_s = self.pitch_rate_rad_s = 0.0
        self.ux_rad_s = self.uy_rad_s = self.uz_rad_s = 0.0
        self.quantum_m_s = step_m_s
        self.part_x_m_s = self.part_y_m_s = 0.0
        self.stuck = False

    def turn_meter(self, angle_rad: float, rate_rad_s: float) -> None:
        """
        Move the servo of the rotation unit for one step towards the angle at its end.

        References
        ----------
        S (4): moment k (psi_g - psi_m) + k' (psi_g' - psi_m'), divided by the inertia of the unit.

        """
        moment = (SERVO_1_S2 * (angle_rad - GRID_S * rate_rad_s - self.angle_rad)
                  + SERVO_RATE_1_S * (rate_rad_s - self.angle_rate_rad_s))
        self.angle_rate_rad_s += GRID_S * moment
        self.angle_rad += GRID_S * self.angle_rate_rad_s

    def step(self, row: Sequence[float], ux: float, uy: float, uz: float) -> None:
        """Advance by one control step at the commanded rates, rad/s, and measure: `loop.step`."""
        loop.step(self, self.instruments, self.instruments.thermostat, row, ux, uy, uz)

    def rest(self, row: Sequence[float]) -> None:
        """Advance by one control step with the platform caged."""
        loop.show(self, self.instruments, self.instruments.thermostat, row)
