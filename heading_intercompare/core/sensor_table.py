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

"""The heading sensors of a ship as a person lists them: a row per sensor."""

from __future__ import annotations

from dataclasses import dataclass, replace
import shlex
from typing import Any, Collection, Iterable

from heading_intercompare.core.units.full_turns import ANGLE_UNITS

from .declared_settings import (
    Checked,
    list_settings,
    read_rows,
    setting,
    SettingsError,
)

SENSOR_CLASS_NAMES = ('gyrocompass', 'ins', 'ins_aided', 'gnss_compass')
"""The classes of sensors; each has a slowest error, see `core/decision/coverage`."""

_FEWEST = 2
_WORDS = {'rs': ('role', 'rs'), 'ts': ('role', 'ts')}


@dataclass(frozen=True, slots=True)
class Sensor(Checked):
    """One heading sensor of the ship: a row of the setting `sensors`."""

    name: str = setting('', 'name of the sensor, the first word of its row')
    role: str = setting('ts', "'ts': is tested; 'rs': is the reference of all others",
                        choices=('ts', 'rs'))
    topic: str = setting('', 'topic of its headings; without one NAME/heading')
    convention: str = setting('enu', 'world axes of its orientation', choices=('enu', 'ned'))
    unit: str = setting('auto', 'unit of its headings in a file of numbers, as ts_unit',
                        choices=('auto', *ANGLE_UNITS))
    sigma_max_deg: float | None = setting(
        None, 'norm of its standard deviation [deg]; without one that of norms', 0.0)
    sensor_class: str | None = setting(
        None, 'its class; without one that of risk', choices=SENSOR_CLASS_NAMES)
    slowest_error_s: float | None = setting(
        None, 'its slowest error [s]; without one that of its class', 0.0)
    installation_offset_deg: float = setting(
        0.0, 'angle of its axis to that of the ship [deg]', -360.0, 360.0)
    installation_offset_u_deg: float = setting(
        0.0, 'standard uncertainty of that angle [deg]', 0.0, 180.0)
    sentence: str = setting('', 'kind of its sentence in a log; without one the first present')
    own_sentence: str = setting('', 'its sentence in one line, if no kind is that of its maker')
    talker: str = setting('', 'its talker in a log; without one the first present')
    instrument: str = setting('', 'word of its lines in a log of several instruments')
    maker: str = setting('', 'maker, for the protocol')
    type: str = setting('', 'type, for the protocol')
    serial: str = setting('', 'serial number, for the protocol')
    evidence: str = setting('', 'certificate or service log of its calibration, for the protocol')
    calibration_date: str | None = setting(
        None, 'date of its last calibration or service, for the protocol', is_date=True)
    calibration_months: int | None = setting(
        None, 'interval of its calibration, for the protocol [months]', 1, 600)

    def __post_init__(self) -> None:
        """Check the ranges."""
        Checked.__post_init__(self)
        if self.sigma_max_deg == 0.0:
            raise SettingsError('sigma_max_deg = 0.0: must be greater than 0')

    @property
    def is_reference(self) -> bool:
        """Whether the sensor is the reference of all others."""
        return self.role == 'rs'

    @property
    def heading_topic(self) -> str:
        """Topic of its headings."""
        return self.topic or f'{self.name}/heading'


def read_sensors(text: str | None) -> tuple[Sensor, ...]:
    """
    Return the sensors of a table.

    Parameters
    ----------
    text
        A row per sensor, separated by line ends or ``;``: its name, then ``setting=value`` of
        `Sensor` in any order, and the word ``rs`` for the reference of all others. Values with
        spaces stand in quotes; ``#`` begins a comment.

    Returns
    -------
    tuple of Sensor
        In their order; empty for None and for an empty text.

    Raises
    ------
    ValueError
        If a row is wrong, a name or topic comes twice, there is a single sensor, or two are the
        reference; the message names the row.

    Examples
    --------
    >>> for sensor in read_sensors('gyro sigma_max_deg=0.5; gnss topic=gnss/imu rs'):
    ...     print(sensor.name, sensor.role, sensor.heading_topic)
    gyro ts gyro/heading
    gnss rs gnss/imu

    """
    sensors: list[Sensor] = []
    for name, row in read_rows(text, Sensor, _WORDS):
        if row.name:
            raise ValueError(f'{name}: name = {row.name!r}: the first word of the row is the '
                             'name')
        sensor: Sensor = replace(row, name=name)
        _check_new(sensor, sensors)
        sensors.append(sensor)
    if sensors and len(sensors) < _FEWEST:
        raise ValueError(f'has one sensor, {sensors[0].name}; it takes at least two')
    return tuple(sensors)


def write_sensors(sensors: Iterable[Sensor]) -> str:
    """
    Return the table of sensors; `read_sensors` reads it back.

    Examples
    --------
    >>> write_sensors(read_sensors('gyro sigma_max_deg=0.5; gnss topic=gnss/imu maker="A B" rs'))
    "gyro sigma_max_deg=0.5; gnss role=rs topic=gnss/imu maker='A B'"

    """
    default = Sensor()
    return '; '.join(' '.join([sensor.name, *(
        f'{rule.name}={shlex.quote(str(value))}' for rule in list_settings(Sensor)
        if rule.name != 'name'
        and (value := getattr(sensor, rule.name)) != getattr(default, rule.name))])
        for sensor in sensors)


def _check_new(sensor: Sensor, before: list[Sensor]) -> None:
    for earlier in before:
        if earlier.heading_topic.lstrip('/') == sensor.heading_topic.lstrip('/'):
            raise ValueError(f'{sensor.name} has the topic {sensor.heading_topic} '
                             f'of {earlier.name}')
        if earlier.is_reference and sensor.is_reference:
            raise ValueError(f'{earlier.name} and {sensor.name} are both the reference; '
                             'there is one or none')


def find_reference(sensors: tuple[Sensor, ...]) -> Sensor | None:
    """Return the reference of all others; None if there is none."""
    return next((sensor for sensor in sensors if sensor.is_reference), None)


def list_tested(sensors: tuple[Sensor, ...]) -> tuple[Sensor, ...]:
    """Return the sensors that are compared with a reference; empty without one."""
    reference = find_reference(sensors)
    if reference is None:
        return ()
    return tuple(sensor for sensor in sensors if sensor is not reference)


def find_tested(sensors: tuple[Sensor, ...], name: str) -> tuple[Sensor, Sensor]:
    """Return a tested sensor by its name, and the reference; SettingsError if it is not tested."""
    reference, tested = find_reference(sensors), list_tested(sensors)
    if reference is None:
        raise SettingsError(f'sensor = {name!r}: no row of sensors has the word rs')
    for sensor in tested:
        if sensor.name == name:
            return sensor, reference
    raise SettingsError(f'sensor = {name!r}: must be one of '
                        f'{", ".join(sensor.name for sensor in tested)}')


def simulated_topics(table: str | None, others: Collection[str], ts_topic: str,
                     rs_topic: str) -> dict[str, str]:
    """
    Return the topics of the sensors that a simulated trial calls ts and rs.

    Parameters
    ----------
    table
        The setting `sensors`. If it has two sensors that the trial does not name, these are meant:
        the tested one, and the reference or the second one.
    others
        Names of the sensors of the trial.
    ts_topic, rs_topic
        What to return otherwise.

    """
    free = sorted((sensor for sensor in read_sensors(table) if sensor.name not in others),
                  key=lambda sensor: sensor.is_reference)
    topics = [sensor.heading_topic for sensor in free] if len(free) == 2 else [ts_topic, rs_topic]
    return dict(zip(('ts', 'rs'), topics))


def describe_driver(sensor: Sensor) -> dict[str, Any]:
    """Return the settings of a driver that the row of a sensor gives."""
    return {name: value for name in ('sentence', 'own_sentence', 'talker', 'instrument')
            if (value := getattr(sensor, name))}
