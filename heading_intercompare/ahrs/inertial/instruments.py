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

"""Errors of gyros, accelerometers, log and satellite heading over time."""

from __future__ import annotations

import math

import numpy as np

from heading_intercompare.ahrs.plans import parse_fixed
from heading_intercompare.ahrs.random_noise import Markov, open_stream
from heading_intercompare.ahrs.sensor_presets import ModelErrors
from heading_intercompare.ahrs.settings import Ahrs
from heading_intercompare.ahrs.ship.earth import RAD_PER_DEG_H, RAD_PER_DEG_SQRT_H, UG_M_S2
from heading_intercompare.ahrs.ship.seaway import GRID_S
from heading_intercompare.core.records import Reals

_GYROS = ('drift_x', 'drift_y', 'drift_z', 'meter_x', 'meter_y')
"""Gyro channels: the gyro vertical about x and y, the course gyro about z, and the two axes of the
course gyro as a meter."""

_ACCELEROMETERS = ('bias_x', 'bias_y', 'bias_z')


class Thermostat:
    """
    Temperature of the instruments.

    References
    ----------
    T = T_set + (T_env - T_set) exp(-t / 200 s), from 20 to 60 degrees Celsius.

    """

    SET_C = 60.0
    ROOM_C = 20.0
    LAG_S = 200.0
    READY_K = 0.5

    def __init__(self, warm: bool) -> None:
        self.away_k = 0.0 if warm else self.ROOM_C - self.SET_C
        self.broken = False
        self.cold_k = self.ROOM_C - self.SET_C
        self.decay = math.exp(-GRID_S / self.LAG_S)

    @property
    def ready(self) -> bool:
        """Whether the temperature is near its set point."""
        return abs(self.away_k) < self.READY_K


class Instruments:
    """
    The errors of all instruments of one AHRS.

    Parameters
    ----------
    errors
        Sizes of the errors.
    settings
        Uses fixed errors, initial state and `noise`.
    seed
        Seed of the simulation.
    role
        'ts' or 'rs'; names the random numbers.

    Attributes
    ----------
    coloured : dict of str to Markov
        The coloured noises by name.

    Notes
    -----
    Random numbers are drawn for whole spans of control steps, one stream per error, so that they
    depend neither on the rate of the readings nor on the chunks.

    """

    def __init__(self, errors: ModelErrors, settings: Ahrs, seed: int, role: str) -> None:
        self._errors = errors
        self._noise = 1.0 if settings.noise else 0.0
        self._fixed = parse_fixed(settings.fixed)
        self._seed, self._role = seed, role
        self._turn_ons = self._stream('turn_on')
        self._aligned = settings.initial_state == 'aligned'
        self.thermostat = Thermostat(warm=settings.initial_state != 'cold')
        self.soak = (1.0 if settings.initial_state == 'cold'
                     else math.exp(-settings.powered_s / errors.soak_tau_s))
        self.soak_decay = math.exp(-GRID_S / errors.soak_tau_s)
        draw = (self._stream('constants').standard_normal(14) * self._noise).tolist()
        heat = errors.temperature_deg_h_k * RAD_PER_DEG_H
        self.gyro_heat = [heat * n for n in draw[0:5]]
        self.gyro_soak = [errors.soak_deg_h * RAD_PER_DEG_H * n for n in draw[5:10]]
        self.torquer = [1e-6 * errors.torquer_ppm * n for n in draw[10:13]]
        self.log_scale = errors.log_scale * draw[13]
        bias = (self._stream('bias').standard_normal(4) * self._noise).tolist()
        vertical = (self._stream('bias_z').standard_normal(2) * self._noise).tolist()
        self.bias = [UG_M_S2 * self._fixed.get(name, errors.accelerometer_bias_ug * n)
                     for name, n in zip(_ACCELEROMETERS, [*bias[:2], vertical[0]])]
        self.bias_heat = [UG_M_S2 * errors.accelerometer_temperature_ug_k * n
                          for n in [*bias[2:], vertical[1]]]
        self.spin_axis = (math.radians(errors.spin_axis_arcsec / 3600.0) * self._noise)
        gyro = errors.markov_deg_h * RAD_PER_DEG_H
        force = errors.accelerometer_markov_ug * UG_M_S2
        self.coloured = {
            **{name: self._markov(name, gyro, errors.markov_tau_s) for name in _GYROS},
            **{name: self._markov(name, force, errors.accelerometer_markov_tau_s)
               for name in _ACCELEROMETERS},
            'log': self._markov('log', errors.log_markov_m_s, errors.log_markov_tau_s),
            'gps': self._markov('gps', math.radians(errors.gps_deg), errors.gps_tau_s),
            'flexure': self._markov('flexure', math.radians(errors.flexure_deg),
                                    errors.flexure_tau_s)}
        root = math.sqrt(GRID_S)
        walk = errors.random_walk_deg_sqrt_h * RAD_PER_DEG_SQRT_H / root
        shake = errors.accelerometer_white_ug * UG_M_S2 / root
        self._white = {name: (walk * self._noise, self._stream(f'{name}.white'))
                       for name in _GYROS}
        self._white.update({name: (shake * self._noise, self._stream(f'{name}.white'))
                            for name in _ACCELEROMETERS})
        self.gyro_bias = [0.0] * 5
        self.power_on()

    def power_on(self) -> None:
        """Draw the drifts of a new turn-on."""
        errors = self._errors
        sizes = ([errors.residual_xy_deg_h] * 2 + [errors.residual_z_deg_h]
                 + [errors.turn_on_deg_h] * 2) if self._aligned else [errors.turn_on_deg_h] * 5
        drawn = (self._turn_ons.standard_normal(5) * self._noise).tolist()
        self.gyro_bias = [RAD_PER_DEG_H * self._fixed.get(name, size * n)
                          for name, size, n in zip(_GYROS, sizes, drawn)]
        self._aligned = False

    def take(self, n: int) -> dict[str, Reals]:
        """
        Return the random errors of the next n control steps.

        Returns
        -------
        dict of ndarray, shape (n,)
            Gyro channels in rad/s, accelerometers in m/s^2 (coloured and white, as the mean over
            a step), 'log' in m/s, 'gps' and 'flexure' in rad.

        """
        errors = {name: markov.take(n) for name, markov in self.coloured.items()}
        for name, (size, rng) in self._white.items():
            errors[name] = errors[name] + size * rng.standard_normal(n)
        return errors

    def _stream(self, name: str) -> np.random.Generator:
        return open_stream(self._seed, f'{self._role}.ahrs.{name}')

    def _markov(self, name: str, sigma: float, tau_s: float) -> Markov:
        return Markov(sigma * self._noise, tau_s, GRID_S, self._stream(f'{name}.markov'))
