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

"""The standard deviation that the AHRS claims for its heading, from the errors of its class."""

from __future__ import annotations

from dataclasses import dataclass, field
import math

from heading_intercompare.ahrs.sensor_presets import ModelErrors
from heading_intercompare.ahrs.ship.earth import (
    EARTH_RATE_RAD_S,
    RAD_PER_DEG_H,
    RAD_PER_DEG_SQRT_H,
)

ALIGNMENT_PER_DRIFT = math.radians(1.75 / 60.0) / 0.008
"""An alignment with meter drifts of 0.008 deg/h is accurate to 1.75 arc minutes at the equator."""


def alignment_sigma(residual_deg_h: float, latitude_rad: float) -> float:
    """
    Return the standard deviation after an alignment in azimuth, radians.

    Parameters
    ----------
    residual_deg_h
        Drift left by the calibration, deg/h.
    latitude_rad
        Latitude, radians.

    """
    return ALIGNMENT_PER_DRIFT * residual_deg_h / math.cos(latitude_rad)


def slew_sigma(errors: ModelErrors, turned_rad: float) -> float:
    """Return what the scale error of the torquer leaves of a slew by an angle, radians."""
    return 1e-6 * errors.torquer_ppm * abs(turned_rad)


def output_sigma(errors: ModelErrors) -> float:
    """Return the part of the output: noise, flexure and pick-off harmonics, radians."""
    arcsec = math.hypot(errors.harmonic_arcsec, errors.harmonic2_arcsec) / math.sqrt(2.0)
    return math.radians(math.hypot(errors.output_deg, errors.flexure_deg, arcsec / 3600.0))


def gyrocompass_sigma(errors: ModelErrors, residual_deg_h: float, sigma_1_s: float, soak: float,
                      latitude_rad: float) -> float:
    """
    Return the standard deviation of a settled gyrocompass, radians.

    Parameters
    ----------
    errors
        Errors of the class.
    residual_deg_h
        Drift left by the calibration, deg/h.
    sigma_1_s
        Tuning, 1/s.
    soak
        Share of the power-on drift that remained when the gyros were calibrated.
    latitude_rad
        Latitude, radians.

    References
    ----------
    Root of the sum of squares of the east drifts over W cos(phi). Through the loop, the random
    walk N gives sqrt(3/8) N sqrt(sigma) / (W cos(phi)).

    """
    slow = math.hypot(residual_deg_h, errors.markov_deg_h, errors.soak_deg_h * soak)
    walk = errors.random_walk_deg_sqrt_h * RAD_PER_DEG_SQRT_H * math.sqrt(0.375 * sigma_1_s)
    return math.hypot(slow * RAD_PER_DEG_H, walk) / (EARTH_RATE_RAD_S * math.cos(latitude_rad))


def satellite_sigma(errors: ModelErrors, span_s: float) -> float:
    """
    Return the standard deviation of the Hann-weighted mean of a satellite heading, radians.

    Parameters
    ----------
    errors
        Size and correlation time of the errors of the satellite heading.
    span_s
        Length of the mean, seconds.

    Notes
    -----
    Coloured noise with the time tau has, over a long span T, the variance 2 tau / T; the weights
    raise it by 1.5. It never exceeds that of a single heading.

    """
    share = min(1.0, 1.5 * 2.0 * errors.gps_tau_s / span_s)
    return math.radians(errors.gps_deg) * math.sqrt(share)


@dataclass(slots=True)
class FreeAzimuth:
    """
    The standard deviation of a heading whose azimuth nothing corrects.

    Attributes
    ----------
    errors
        Errors of the class.
    start_rad
        Standard deviation when the azimuth became free, or when the course gyro was calibrated.
    span_s
        Time since then, seconds.

    Notes
    -----
    The drift that a calibration leaves is constant, and so are the coefficients of temperature and
    of thermal soak. Only the random walk grows with the root of the time.

    """

    errors: ModelErrors
    start_rad: float
    span_s: float = field(default=0.0, init=False)
    _residual_deg_h: float = field(default=math.nan, init=False)
    _heat_k_s: float = field(default=0.0, init=False)
    _soak_s: float = field(default=0.0, init=False)
    _level_rad: float = field(default=0.0, init=False)

    def add(self, span_s: float, residual_deg_h: float, heat_k: float, soak: float,
            level_rad_s: float = 0.0) -> float:
        """
        Add a span of time, and return the standard deviation after it, radians.

        Parameters
        ----------
        span_s
            Its length, seconds.
        residual_deg_h
            Drift of the course gyro left by its calibration, deg/h.
        heat_k, soak
            Change since that calibration of the temperature, kelvin, and of the share that is left
            of the power-on drift.
        level_rad_s
            Rate of the level frame about the vertical that is not known, rad/s.

        """
        if residual_deg_h != self._residual_deg_h:
            self.start_rad, self._residual_deg_h = self.sigma_rad, residual_deg_h
            self.span_s = self._heat_k_s = self._soak_s = self._level_rad = 0.0
        self.span_s += span_s
        self._level_rad += span_s * level_rad_s
        self._heat_k_s += span_s * heat_k
        self._soak_s += span_s * soak
        return self.sigma_rad

    @property
    def sigma_rad(self) -> float:
        """Return the standard deviation now, radians."""
        if not self.span_s:
            return self.start_rad
        e = self.errors
        return math.hypot(self.start_rad, self._level_rad, RAD_PER_DEG_H * math.hypot(
            self._residual_deg_h * self.span_s, e.temperature_deg_h_k * self._heat_k_s,
            e.soak_deg_h * self._soak_s),
            e.random_walk_deg_sqrt_h * RAD_PER_DEG_SQRT_H * math.sqrt(self.span_s))
