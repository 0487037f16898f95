# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Modes of the AHRS, the quality of its heading, and its status reports."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

__all__ = ['AhrsStatus', 'Mode', 'Validity']


class Mode(IntEnum):
    """Modes of S, figure 1, in the order of a cold start."""

    POST = 1
    THERMOSTAT_WAIT = 2
    COARSE_LEVELLING = 3
    GYRO_CALIBRATION = 4
    AZIMUTH_ALIGNMENT = 5
    FINE_LEVELLING = 6
    GYROCOMPASS = 7
    GYRO_AZIMUTH = 8
    FAULT = 9


class Validity(IntEnum):
    """Quality of the heading; only VALID readings belong in an intercomparison."""

    NONE = 0
    PROVISIONAL = 1
    SETTLING = 2
    VALID = 3


@dataclass(frozen=True, slots=True)
class AhrsStatus:
    """
    Status report of the AHRS, made once a second and at each change.

    Attributes
    ----------
    t_s : float
        Instant, seconds since the start.
    mode, validity : str
        Names of `Mode` and `Validity`.
    mode_s, progress : float
        Time in this mode, seconds; its share of the least time that the mode takes, at most 1.
    tests : tuple of (str, str)
        Built-in tests and their results, 'pending', 'passed' or 'failed'.
    message : str
        The latest event; empty if there is none.
    flags : tuple of str
        Empty, or 'DEGRADED' and its reasons: 'FINE_LIMIT', 'FORCED_ON', 'NOT_CALIBRATED',
        'NO_SPEED'.
    faults : tuple of str
        Causes of the mode FAULT.
    sigma_deg : float
        Standard deviation claimed for the heading; nan without a heading.
    temperature_c : float
        Temperature of the instruments.
    drifts_deg_h : tuple of float
        Estimates: gyro vertical x and y, course gyro, meter x and y.
    biases_ug : tuple of float
        Estimates: accelerometers x, y and z.
    currents_a : tuple of float
        Currents of the torque motors x, y, z.

    """

    t_s: float
    mode: str
    mode_s: float
    progress: float
    validity: str
    tests: tuple[tuple[str, str], ...]
    message: str
    flags: tuple[str, ...]
    faults: tuple[str, ...]
    sigma_deg: float
    temperature_c: float
    drifts_deg_h: tuple[float, ...]
    biases_ug: tuple[float, ...]
    currents_a: tuple[float, ...]
