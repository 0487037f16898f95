# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The standard deviation that the AHRS claims for its heading, from the errors of its class."""

from __future__ import annotations

import math

from heading_intercompare.ahrs.settings import Errors
from heading_intercompare.ahrs.ship.earth import (
    EARTH_RATE_RAD_S,
    RAD_PER_DEG_H,
    RAD_PER_DEG_SQRT_H,
)

__all__ = ['alignment_sigma', 'azimuth_sigma', 'gyrocompass_sigma', 'output_sigma',
           'satellite_sigma', 'slew_sigma']

ALIGNMENT_PER_DRIFT = math.radians(1.75 / 60.0) / 0.008
"""An alignment with meter drifts of 0.008 deg/h is accurate to 1.75 arc minutes at the equator."""


def alignment_sigma(residual_deg_h: float, latitude_rad: float) -> float:
    """
    Return the standard deviation after an alignment in azimuth, radians.

    Parameters
    ----------
    residual_deg_h : float
        Drift left by the calibration, deg/h.
    latitude_rad : float
        Latitude, radians.

    """
    return ALIGNMENT_PER_DRIFT * residual_deg_h / math.cos(latitude_rad)


def slew_sigma(errors: Errors, turned_rad: float) -> float:
    """Return what the scale error of the torquer leaves of a slew by an angle, radians."""
    return 1e-6 * errors.torquer_ppm * abs(turned_rad)


def output_sigma(errors: Errors) -> float:
    """Return the part of the output: noise, flexure and pick-off harmonics, radians."""
    arcsec = math.hypot(errors.harmonic_arcsec, errors.harmonic2_arcsec) / math.sqrt(2.0)
    return math.radians(math.hypot(errors.output_deg, errors.flexure_deg, arcsec / 3600.0))


def gyrocompass_sigma(errors: Errors, residual_deg_h: float, sigma_1_s: float, soak: float,
                      latitude_rad: float) -> float:
    """
    Return the standard deviation of a settled gyrocompass, radians.

    Parameters
    ----------
    errors : Errors
        Errors of the class.
    residual_deg_h : float
        Drift left by the calibration, deg/h.
    sigma_1_s : float
        Tuning, 1/s.
    soak : float
        Share of the power-on drift that remained when the gyros were calibrated.
    latitude_rad : float
        Latitude, radians.

    References
    ----------
    Root of the sum of squares of the east drifts over W cos(phi). Through the loop, the random
    walk N gives sqrt(3/8) N sqrt(sigma) / (W cos(phi)).

    """
    slow = math.hypot(residual_deg_h, errors.markov_deg_h, errors.soak_deg_h * soak)
    walk = errors.random_walk_deg_sqrt_h * RAD_PER_DEG_SQRT_H * math.sqrt(0.375 * sigma_1_s)
    return math.hypot(slow * RAD_PER_DEG_H, walk) / (EARTH_RATE_RAD_S * math.cos(latitude_rad))


def satellite_sigma(errors: Errors, span_s: float) -> float:
    """
    Return the standard deviation of the Hann-weighted mean of a satellite heading, radians.

    Parameters
    ----------
    errors : Errors
        Size and correlation time of the errors of the satellite heading.
    span_s : float
        Length of the mean, seconds.

    Notes
    -----
    Coloured noise with the time tau has, over a long span T, the variance 2 tau / T; the weights
    raise it by 1.5. It never exceeds that of a single heading.

    """
    share = min(1.0, 1.5 * 2.0 * errors.gps_tau_s / span_s)
    return math.radians(errors.gps_deg) * math.sqrt(share)


def azimuth_sigma(errors: Errors, residual_deg_h: float, start_rad: float,
                  span_s: float) -> float:
    """
    Return the standard deviation of a free azimuth, radians.

    Parameters
    ----------
    errors : Errors
        Errors of the class.
    residual_deg_h : float
        Drift of the course gyro left by its calibration, deg/h.
    start_rad : float
        Standard deviation when the azimuth became free.
    span_s : float
        Time since then, seconds.

    """
    return math.hypot(start_rad, residual_deg_h * RAD_PER_DEG_H * span_s,
                      errors.random_walk_deg_sqrt_h * RAD_PER_DEG_SQRT_H * math.sqrt(span_s))
