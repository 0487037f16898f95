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

"""The gimballed platform with its instruments: turns commands into measurements, step by step."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from heading_intercompare.ahrs.ship.seaway import GRID_S
from heading_intercompare.ahrs.ship.ship_motion import ShipBlock
from heading_intercompare.core.records import Reals

from . import loop
from .instruments import Instruments

FRICTION = 5e-5
"""Share of the rates of the gimbals with which their friction drags the platform along: what the
feed-forward leaves, k - k_fr in S (2), (7)."""

SERVO_1_S2 = 4.0
SERVO_RATE_1_S = 2.8
MOTOR_1_S = 2.5


def rows_of(ship: ShipBlock, random: dict[str, Reals]) -> Reals:
    """
    Return the inputs of the platform over each control step, shape (n, 22).

    Parameters
    ----------
    ship
        The ship over the minute, from its start; the random errors give the number of steps.
    random : dict of ndarray
        Errors, from `Instruments.take`.

    Notes
    -----
    Columns 9, 10 and 20 are the rates with which the friction of the gimbals drags the platform
    along, about north, east and down. The roll gimbal turns about the ship's axis.

    """
    n = random['log'].size
    start, stop = slice(0, n), slice(1, n + 1)

    def mean(values: Reals) -> Reals:
        return 0.5 * (values[start] + values[stop])

    bow_rad = mean(ship.heading_rad)
    c, s = FRICTION * np.cos(bow_rad), FRICTION * np.sin(bow_rad)
    roll, pitch = mean(ship.roll_rate_rad_s), mean(ship.pitch_rate_rad_s)
    yaw = (FRICTION / GRID_S) * (ship.heading_rad[stop] - ship.heading_rad[start])
    return np.column_stack((
        mean(ship.turn_north_rad_s), mean(ship.turn_east_rad_s), mean(ship.turn_down_rad_s),
        mean(ship.force_north_m_s2), mean(ship.force_east_m_s2), mean(ship.force_down_m_s2),
        ship.heading_rad[stop], ship.speed_m_s[stop], ship.latitude_rad[stop],
        roll * c - pitch * s, roll * s + pitch * c, *(random[name] for name in (
            'drift_x', 'drift_y', 'drift_z', 'meter_x', 'meter_y', 'bias_x', 'bias_y', 'log',
            'gps')), yaw, random['bias_z']))


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
    drive_rad_s : float
        Rate at which the azimuth motor turns the platform, as the course gyro reads it.
    force_x_m_s2, force_y_m_s2 : float
        Horizontal accelerometers, mean over the last step.
    force_z_m_s2 : float
        Vertical accelerometer, mean over the last step that was not part of a longer run.
    rate_x_rad_s, rate_y_rad_s : float
        Course gyro as a rate meter, mean over the last step.
    caged_rad_s : tuple of float
        What the gyro vertical about x and y, the course gyro, and its two axes as a meter read
        while the platform was caged.
    pick_off_rad : float
        Angle from x of the platform to the ship's axis.
    slip_x_rad_s, slip_y_rad_s, slip_z_rad_s : float
        Changes of the signals of the gyro vertical and of the course gyro over the last step, per
        second: how fast the platform has left its gyros.
    speed_m_s, latitude_rad : float
        Log and position.
    satellite_rad : float
        Satellite heading.
    ux_rad_s, uy_rad_s, uz_rad_s : float
        Rates commanded for the last step.
    quantum_m_s, part_x_m_s, part_y_m_s, part_z_m_s : float
        Velocity step of the accelerometers, and the velocity not yet counted.
    stuck, spinning, jammed : bool
        Whether the accelerometers stick, the gyro vertical spins, the motors of the rotation unit
        and of the azimuth gimbal stand still.

    Notes
    -----
    First order in the tilts, exact in azimuth. If the azimuth turns fast, the tilts turn with it:
    the rate about z of the platform, not that of the level frame, couples them.

    """

    def __init__(self, instruments: Instruments, step_m_s: float) -> None:
        self.instruments = instruments
        self.alpha_rad = self.beta_rad = self.azimuth_rad = 0.0
        self.angle_rad = self.angle_rate_rad_s = 0.0
        self.drive_rad_s = self._seen_rad = 0.0
        self.force_x_m_s2 = self.force_y_m_s2 = self.force_z_m_s2 = 0.0
        self.rate_x_rad_s = self.rate_y_rad_s = 0.0
        self.pick_off_rad = self.satellite_rad = 0.0
        self.speed_m_s = self.latitude_rad = 0.0
        self.slip_x_rad_s = self.slip_y_rad_s = self.slip_z_rad_s = 0.0
        self.ux_rad_s = self.uy_rad_s = self.uz_rad_s = 0.0
        self.quantum_m_s = step_m_s
        self.part_x_m_s = self.part_y_m_s = self.part_z_m_s = 0.0
        self.caged_rad_s = (0.0,) * 5
        self.stuck = self.jammed = False
        self.spinning = True

    def turn_meter(self, angle_rad: float, rate_rad_s: float) -> None:
        """
        Move the servo of the rotation unit for one step towards the angle at its end.

        References
        ----------
        S (4): moment k (psi_g - psi_m) + k' (psi_g' - psi_m'), divided by the inertia of the unit.

        """
        if self.jammed:
            self.angle_rate_rad_s = 0.0
            return
        moment = (SERVO_1_S2 * (angle_rad - GRID_S * rate_rad_s - self.angle_rad)
                  + SERVO_RATE_1_S * (rate_rad_s - self.angle_rate_rad_s))
        self.angle_rate_rad_s += GRID_S * moment
        self.angle_rad += GRID_S * self.angle_rate_rad_s

    def step(self, row: Sequence[float], ux: float, uy: float, uz: float) -> None:
        """Advance by one control step at the commanded rates, rad/s, and measure: `loop.step`."""
        loop.step(self, self.instruments, self.instruments.thermostat, row, ux, uy, uz)
        self._weigh(row, 0.0)

    def rest(self, row: Sequence[float]) -> None:
        """Advance by one control step with the platform caged."""
        loop.show(self, self.instruments, self.instruments.thermostat, row)

    def excite(self, row: Sequence[float], rate_rad_s: float, push_m_s2: float) -> None:
        """
        Advance by one control step with the platform caged, and excite the instruments.

        Parameters
        ----------
        row
            Inputs of the step, see `rows_of`.
        rate_rad_s
            Rate that the torquers of all gyros feign.
        push_m_s2
            Acceleration that the coils of all accelerometers feign.

        Notes
        -----
        The caged platform turns with the ship. A gyro without spin reads nothing, a stuck
        accelerometer what it read before.

        """
        parts = self.instruments
        warm, soak = parts.thermostat.away_k, parts.soak
        drift = [noise + bias + heat * warm + still * soak for noise, bias, heat, still in zip(
            row[11:16], parts.gyro_bias, parts.gyro_heat, parts.gyro_soak)]
        c, s = math.cos(self.azimuth_rad), math.sin(self.azimuth_rad)
        north, east, z = (level + gimbal / FRICTION for level, gimbal in zip(
            row[0:3], (row[9], row[10], row[20])))
        x, y = north * c + east * s, east * c - north * s
        scale_x, scale_y, scale_z = parts.torquer
        spin = 1.0 if self.spinning else 0.0
        cos_unit, sin_unit = math.cos(self.angle_rad), math.sin(self.angle_rad)
        self.caged_rad_s = (
            spin * (x + drift[0] + rate_rad_s * (1.0 + scale_x)),
            spin * (y + drift[1] + rate_rad_s * (1.0 + scale_y)),
            z + drift[2] + rate_rad_s * (1.0 + scale_z),
            x * cos_unit + y * sin_unit + drift[3] + rate_rad_s,
            y * cos_unit - x * sin_unit + drift[4] + rate_rad_s)
        if not self.stuck:
            bias_x, bias_y, _ = parts.bias
            heat_x, heat_y, _ = parts.bias_heat
            self.force_x_m_s2 = (row[3] * c + row[4] * s - self.beta_rad * row[5] + bias_x
                                 + heat_x * warm + row[16] + push_m_s2)
            self.force_y_m_s2 = (row[4] * c - row[3] * s + self.alpha_rad * row[5] + bias_y
                                 + heat_y * warm + row[17] + push_m_s2)
        self._weigh(row, push_m_s2)
        self.rest(row)

    def brake(self) -> None:
        """Stop the azimuth motor, so that the course gyro alone holds the azimuth."""
        self.drive_rad_s, self._seen_rad = 0.0, self.pick_off_rad

    def drive(self, rate_rad_s: float) -> float:
        """
        Return the rate of the azimuth motor over the next step, on its way to the one asked for.

        References
        ----------
        S (10): the current follows psi_g' - psi_m', with psi_m' by differences of the pick-off,
        so the rate is relative to the ship.

        """
        seen_rad_s = (self._seen_rad - self.pick_off_rad) / GRID_S
        self._seen_rad = self.pick_off_rad
        self.drive_rad_s = (0.0 if self.jammed else self.drive_rad_s
                            + GRID_S * MOTOR_1_S * (rate_rad_s - seen_rad_s))
        return self.drive_rad_s

    def _weigh(self, row: Sequence[float], push_m_s2: float) -> None:
        """Read the vertical accelerometer, unless it sticks."""
        if self.stuck:
            return
        parts = self.instruments
        c, s = math.cos(self.azimuth_rad), math.sin(self.azimuth_rad)
        force = (row[5] + self.beta_rad * (row[3] * c + row[4] * s)
                 - self.alpha_rad * (row[4] * c - row[3] * s) + parts.bias[2]
                 + parts.bias_heat[2] * parts.thermostat.away_k + row[21] + push_m_s2)
        if self.quantum_m_s > 0.0:
            velocity = self.part_z_m_s + GRID_S * force
            counts = math.floor(velocity / self.quantum_m_s + 0.5)
            self.part_z_m_s = velocity - counts * self.quantum_m_s
            force = counts * self.quantum_m_s / GRID_S
        self.force_z_m_s2 = force
