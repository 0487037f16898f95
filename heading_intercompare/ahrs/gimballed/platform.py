# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The gimballed platform with its instruments: turns commands into measurements, step by step."""

from __future__ import annotations

import math

import numpy as np

from heading_intercompare.ahrs.ship.seaway import GRID_S
from heading_intercompare.ahrs.ship.ship_motion import ShipBlock

from .instruments import Instruments

__all__ = ['Platform', 'rows_of']

PICK_OFF_RAD = 2.0 * math.pi / 2**20
SERVO_1_S2 = 4.0
SERVO_RATE_1_S = 2.8


def rows_of(ship: ShipBlock, first: int, random: dict[str, np.ndarray]) -> list[tuple]:
    """
    Return the inputs of the platform over each control step, as rows of plain floats.

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

    def mean(values: np.ndarray) -> list[float]:
        return (0.5 * (values[start] + values[stop])).tolist()

    return list(zip(
        mean(ship.turn_north_rad_s), mean(ship.turn_east_rad_s), mean(ship.turn_down_rad_s),
        mean(ship.force_north_m_s2), mean(ship.force_east_m_s2), mean(ship.force_down_m_s2),
        ship.heading_rad[stop].tolist(), ship.speed_m_s[stop].tolist(),
        ship.latitude_rad[stop].tolist(), mean(ship.roll_rate_rad_s),
        mean(ship.pitch_rate_rad_s),
        *(random[name].tolist() for name in (
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
        self._step_m_s = step_m_s
        self._part_x = self._part_y = 0.0
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

    def step(self, row: tuple, ux: float, uy: float, uz: float) -> None:
        """
        Advance by one control step at the commanded rates, and measure.

        Parameters
        ----------
        row : tuple
            From `rows_of`.
        ux, uy, uz : float
            Commanded rates of the platform, rad/s.

        References
        ----------
        Equations of motion and accelerometers as in docs/ahrs.md, section Platform.

        """
        (north, east, down, force_north, force_east, force_down, heading, speed, latitude,
         roll_rate, pitch_rate, ex, ey, ez, mx, my, bx, by, log, gps) = row
        parts = self.instruments
        warm, soak = parts.thermostat.away_k, parts.soak
        bias, heat, soaking = parts.gyro_bias, parts.gyro_heat, parts.gyro_soak
        tx, ty, tz = parts.torquer
        px = ux + tx * ux + ex + bias[0] + heat[0] * warm + soaking[0] * soak
        py = uy + ty * uy + ey + bias[1] + heat[1] * warm + soaking[1] * soak
        pz = uz + ez + bias[2] + heat[2] * warm + soaking[2] * soak
        alpha, beta, azimuth = self.alpha_rad, self.beta_rad, self.azimuth_rad
        turn = GRID_S * pz
        if -1e-3 < turn < 1e-3:
            pz += tz * uz
            c, s = math.cos(azimuth), math.sin(azimuth)
            wx, wy = north * c + east * s, east * c - north * s
            self.alpha_rad = alpha + GRID_S * (px - wx + beta * pz)
            self.beta_rad = beta + GRID_S * (py - wy - alpha * pz)
        else:
            # The pick-off measures a slew, so the scale error of the torquer does not matter.
            c, s = math.cos(azimuth + 0.5 * turn), math.sin(azimuth + 0.5 * turn)
            wx, wy = north * c + east * s, east * c - north * s
            half_c, half_s = math.cos(0.5 * turn), math.sin(0.5 * turn)
            middle_alpha = alpha * half_c + beta * half_s + GRID_S * (px - wx)
            middle_beta = beta * half_c - alpha * half_s + GRID_S * (py - wy)
            self.alpha_rad = middle_alpha * half_c + middle_beta * half_s
            self.beta_rad = middle_beta * half_c - middle_alpha * half_s
        self.azimuth_rad = azimuth + GRID_S * (pz - down + alpha * wy - beta * wx)

        fx = (force_north * c + force_east * s
              - 0.5 * (beta + self.beta_rad) * force_down
              + parts.bias[0] + parts.bias_heat[0] * warm + bx)
        fy = (force_east * c - force_north * s
              + 0.5 * (alpha + self.alpha_rad) * force_down
              + parts.bias[1] + parts.bias_heat[1] * warm + by)
        quantum = self._step_m_s
        if quantum:
            self._part_x += GRID_S * fx
            self._part_y += GRID_S * fy
            counts_x = math.floor(self._part_x / quantum + 0.5)
            counts_y = math.floor(self._part_y / quantum + 0.5)
            self._part_x -= counts_x * quantum
            self._part_y -= counts_y * quantum
            fx, fy = counts_x * quantum / GRID_S, counts_y * quantum / GRID_S
        if not self.stuck:
            self.force_x_m_s2, self.force_y_m_s2 = fx, fy

        mx += bias[3] + heat[3] * warm + soaking[3] * soak
        my += bias[4] + heat[4] * warm + soaking[4] * soak
        c, s = math.cos(self.angle_rad), math.sin(self.angle_rad)
        self.rate_x_rad_s = px * c + py * s + mx + parts.spin_axis * self.angle_rate_rad_s
        self.rate_y_rad_s = py * c - px * s + my
        self._show(heading, speed, latitude, log, gps)
        self.roll_rate_rad_s, self.pitch_rate_rad_s = roll_rate, pitch_rate

    def rest(self, row: tuple) -> None:
        """Advance by one control step with the platform caged."""
        self._show(row[6], row[7], row[8], row[18], row[19])

    def _show(self, heading: float, speed: float, latitude: float, log: float,
              gps: float) -> None:
        """Update the measurements relative to the ship, and advance the instruments."""
        self.pick_off_rad = PICK_OFF_RAD * math.floor(
            (heading - self.azimuth_rad) / PICK_OFF_RAD + 0.5)
        self.speed_m_s = speed * (1.0 + self.instruments.log_scale) + log
        self.latitude_rad = latitude
        self.satellite_rad = heading + gps
        self.instruments.step()
