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

"""The condition of an AHRS in words: progress of its mode, results of its built-in tests."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Collection

from heading_intercompare.ahrs.inertial.instruments import Thermostat
from heading_intercompare.ahrs.settings import Ahrs

from .alignment import COARSE_S, count_pairs, METER_TURN_RAD_S
from .modes import AhrsStatus, Mode, Validity
from .power_on import TEST_S

SELF_TESTS = {
    'post': Mode.POST,
    'thermostat': Mode.THERMOSTAT_WAIT,
    'gyro': Mode.POST,
    'accelerometer': Mode.POST,
    'servo': Mode.POST,
    'gimbal': Mode.THERMOSTAT_WAIT,
    'levelling': Mode.COARSE_LEVELLING,
    'alignment': Mode.AZIMUTH_ALIGNMENT,
}
"""The built-in tests; each has passed once the AHRS is beyond this mode."""

SLEW_S = 2.0
"""The shortest slew, seconds."""

_PENDING, _PASSED, _FAILED = 'pending', 'passed', 'failed'


@dataclass(frozen=True, slots=True)
class Condition:
    """
    The condition of an AHRS, for a diagnostics display.

    Attributes
    ----------
    level
        'ok' in operation with a valid heading; 'error' after a fault; otherwise 'warn'.
    words
        Mode, validity, flags and faults in words.
    figures
        Figures by name, which includes the unit; unknown ones are left out.

    """

    level: str
    words: str
    figures: dict[str, str | int | float]


def progress(mode: Mode, mode_s: float, validity: Validity, away_k: float,
             settings: Ahrs) -> float:
    """
    Return the progress of a mode, as a share of the least time that it takes.

    Parameters
    ----------
    mode
        Gyrocompass is complete when its heading is valid, gyro azimuth at once; but a heading that
        was settling when its azimuth became free settles no more.
    mode_s
        Time in this mode, seconds.
    validity
        Quality of the heading.
    away_k
        Temperature of the instruments minus its set point, kelvin.
    settings
        Gives the lengths of the procedures.

    Returns
    -------
    float
        From 0 to 1; stays at 1 if the mode takes longer; 0 in the mode FAULT.

    """
    if mode is Mode.FAULT:
        return 0.0
    if mode is Mode.THERMOSTAT_WAIT:
        cold_k = Thermostat.SET_C - Thermostat.ROOM_C
        left = (math.log(max(abs(away_k), Thermostat.READY_K) / Thermostat.READY_K)
                / math.log(cold_k / Thermostat.READY_K))
        return min(max(1.0 - left, 0.0), 1.0)
    if mode is Mode.GYRO_AZIMUTH or mode is Mode.GYROCOMPASS and validity is Validity.VALID:
        return 0.0 if validity is Validity.SETTLING else 1.0
    whole_s = {
        Mode.POST: TEST_S,
        Mode.COARSE_LEVELLING: COARSE_S,
        Mode.GYRO_CALIBRATION: settings.hold_s + count_pairs(settings) * (
            4.0 * math.pi / METER_TURN_RAD_S),
        Mode.AZIMUTH_ALIGNMENT: (SLEW_S if settings.start == 'mutual'
                                 else settings.alignment_s),
        Mode.FINE_LEVELLING: settings.fine_s,
        Mode.GYROCOMPASS: 3.0 / settings.sigma_1_s,
    }[mode]
    return min(mode_s / whole_s, 1.0)


def self_tests(reached: Mode, faults: Collection[str]) -> dict[str, str]:
    """
    Return the result of each built-in test.

    Parameters
    ----------
    reached
        The last mode before a fault, or the current one.
    faults
        Causes of the mode FAULT.

    Examples
    --------
    >>> self_tests(Mode.COARSE_LEVELLING, ['gyro'])['gyro']
    'failed'
    >>> self_tests(Mode.COARSE_LEVELLING, [])['alignment']
    'pending'

    """
    return {name: _FAILED if name in faults else _PASSED if reached > last else _PENDING
            for name, last in SELF_TESTS.items()}


def _level(status: AhrsStatus) -> str:
    if status.mode == Mode.FAULT.name:
        return 'error'
    return 'ok' if status.validity == Validity.VALID.name and not status.flags else 'warn'


def describe_condition(status: AhrsStatus) -> Condition:
    """Return a status in words and figures."""
    words = status.mode.lower().replace('_', ' ')
    if status.faults:
        words += ': ' + ', '.join(status.faults)
    elif status.validity == Validity.NONE.name:
        words += f', no heading yet, {status.progress:.0%}'
    else:
        words += f', heading {status.validity.lower()}'
        if status.validity != Validity.VALID.name:
            words += f', {status.progress:.0%}'
    if status.flags:
        words += ', ' + ' '.join(flag.lower().replace('_', ' ') for flag in status.flags)
    drifts = zip(('drift_x', 'drift_y', 'drift_z', 'meter_x', 'meter_y'), status.drifts_deg_h)
    figures: dict[str, str | int | float] = {
        'mode': status.mode, 'mode_time_s': status.mode_s, 'mode_progress': status.progress,
        'validity': status.validity, 'event': status.message, 'flags': ' '.join(status.flags),
        **{f'test_{name}': result for name, result in status.tests},
        'sigma_deg': status.sigma_deg, 'temperature_c': status.temperature_c,
        **{f'{name}_deg_h': value for name, value in drifts},
        **{f'bias_{axis}_ug': value for axis, value in zip('xyz', status.biases_ug)},
        **{f'current_{axis}_a': value for axis, value in zip('xyz', status.currents_a)}}
    return Condition(_level(status), words, {
        name: value for name, value in figures.items()
        if value != '' and not (isinstance(value, float) and math.isnan(value))})
