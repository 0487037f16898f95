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

"""
The parts of the AHRS that a procedure of its modes reads and changes.

A procedure is a generator. It yields the rates to command over the next control step, or a law to
apply over several, or None or an excitation while the platform is caged, and returns the mode that
follows. When it resumes after a yield, the computer has taken the measurements of those steps.
"""

from __future__ import annotations

from typing import Collection, Generator, NamedTuple, Protocol, Sequence

from heading_intercompare.ahrs.inertial.computer import Computer
from heading_intercompare.ahrs.inertial.instruments import Instruments
from heading_intercompare.ahrs.inertial.loop import Rates
from heading_intercompare.ahrs.inertial.platform import Platform
from heading_intercompare.ahrs.sensor_presets import ModelErrors
from heading_intercompare.ahrs.settings import Ahrs
from heading_intercompare.ahrs.ship.seaway import GRID_S

from .claims import FreeAzimuth
from .fixes import Fixes
from .modes import Mode, Validity
from .power_on import Excitation

FAILURES = {'fail_post': 'post', 'fail_thermostat': 'thermostat', 'fail_gyro': 'gyro',
            'fail_accelerometer': 'accelerometer', 'fail_gimbal': 'gimbal',
            'fail_servo': 'servo'}
"""Events that are failures, and the parts that fail."""


class Steady(NamedTuple):
    """A law of `loop`, and the number of control steps over which nothing else is to be done."""

    law: int
    steps: int


Procedure = Generator[Rates | Steady | Excitation | None, None, Mode]

class Machine(Protocol):
    """The part of the AHRS that a procedure may read and change."""

    settings: Ahrs
    errors: ModelErrors
    instruments: Instruments
    platform: Platform
    computer: Computer
    failures: set[str]
    forced: bool
    operation: Mode
    validity: Validity
    sigma_rad: float
    soak: float
    calibrated_deg_h: float
    calibrated_k: float
    course_deg_h: float
    course_k: float
    course_soak: float
    turned_rad: float
    azimuth_found: bool
    fixes: Fixes | None

    @property
    def residual_deg_h(self) -> float:
        """Levelling gyro drift left by the calibration, and by the temperature since."""

    @property
    def unknown_m_s(self) -> float:
        """Speed that a lost log showed last; 0 with a log."""

    def claim(self, free: FreeAzimuth, span_s: float, *, own_velocity: bool = False) -> None:
        """Claim what is left of the azimuth after a span in which nothing corrected it."""

    def calibrate_course(self, left_deg_h: float) -> None:
        """Note that the course gyro is calibrated here and now, and what that leaves."""

    def say(self, message: str) -> None:
        """Report an event."""

    def flag(self, name: str) -> None:
        """Continue in a degraded state, for the reason named."""

    def fail(self, cause: str) -> Mode:
        """Report a fault and return the mode FAULT."""


def steps(span_s: float) -> int:
    """Return the number of control steps in a span, seconds."""
    return round(span_s / GRID_S)


SECOND = steps(1.0)


def find_obstacle_to_failure(kind: str, failures: Collection[str],
                             waiting: Sequence[str]) -> str:
    """
    Return why a failure or the repair would change nothing; empty if it would.

    Parameters
    ----------
    kind
        A key of `FAILURES`, or 'repair'.
    failures
        The parts that have failed.
    waiting
        The events that are about to happen before.

    Examples
    --------
    >>> find_obstacle_to_failure('repair', [], ['fail_gyro'])
    ''
    >>> find_obstacle_to_failure('fail_gyro', ['gyro'], [])
    'it has failed already'

    """
    failed = set(failures)
    for event in waiting:
        if event == 'repair':
            failed.clear()
        elif event in FAILURES:
            failed.add(FAILURES[event])
    soon = 'it is about to happen'
    if kind == 'repair':
        return '' if failed else soon if failures or 'repair' in waiting else 'nothing has failed'
    if FAILURES[kind] not in failed:
        return ''
    return soon if kind in waiting else 'it has failed already'
