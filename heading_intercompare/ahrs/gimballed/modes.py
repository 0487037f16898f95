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

"""Modes of the AHRS, the quality of its heading, and its status reports."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


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
    t_s
        Instant, seconds since the start.
    mode, validity
        Names of `Mode` and `Validity`.
    mode_s, progress
        Time in this mode, seconds; its share of the least time that the mode takes, at most 1.
    tests
        Built-in tests and their results, 'pending', 'passed' or 'failed'.
    message
        The latest event; empty if there is none.
    flags
        Empty, or 'DEGRADED' and its reasons: 'FINE_LIMIT', 'FORCED_ON', 'NOT_CALIBRATED',
        'NO_SPEED'.
    faults
        Causes of the mode FAULT.
    sigma_deg
        Standard deviation claimed for the heading; nan without a heading.
    temperature_c
        Temperature of the instruments.
    drifts_deg_h
        Estimates: gyro vertical x and y, course gyro, meter x and y.
    biases_ug
        Estimates: accelerometers x, y and z.
    currents_a
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
