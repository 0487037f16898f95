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

"""Parsers of text settings that hold a list or an instant: courses, faults, events, errors."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timezone
import math
import re

from heading_intercompare.ahrs.ship.steering import Leg
from heading_intercompare.core.declared_settings import SettingsError

from .faults import Fault, FAULTS

EVENTS = {
    'gyrocompass': 'command: seek the meridian',
    'gyro_azimuth': 'command: hold the azimuth',
    'reset': 'command: start again after a fault',
    'force_on': 'command: continue although the thermostat is not ready',
    'log_lost': 'the log stops giving speed',
    'log_found': 'the log gives speed again',
    'gps_lost': 'the satellite heading is lost',
    'gps_found': 'the satellite heading is back',
    'power_dip': 'the power fails for a moment: restart, still warm',
    'fail_post': 'the self-test fails',
    'fail_thermostat': 'the heater fails',
    'fail_gyro': 'a gyro loses its spin',
    'fail_accelerometer': 'an accelerometer sticks',
    'fail_gimbal': 'a gimbal reaches its stop',
    'fail_servo': 'the motors of rotation unit and azimuth gimbal stand still',
    'repair': 'all injected failures end',
}
"""Events that can happen to a running gimballed AHRS."""

FIXED = ('drift_x', 'drift_y', 'drift_z', 'meter_x', 'meter_y', 'bias_x', 'bias_y',
         'bias_z')
"""Errors that can be fixed instead of random: gyro drifts and meter biases in deg/h, accelerometer
biases in micro-g."""


@dataclass(frozen=True, slots=True)
class Event:
    """One event at `t_s`."""

    t_s: float
    kind: str


@dataclass(frozen=True, slots=True)
class RunUp:
    """A start at `t_s`, after which a sensor settles at `error_deg` off its offset."""

    t_s: float
    error_deg: float


def _entries(name: str, text: str) -> list[tuple[str, list[str]]]:
    """Split 'a b c; d e f' into entries, each with its words."""
    parts = [part.strip() for part in re.split(r'[;\n]', text)]
    return [(f'{name} entry {i} {part!r}', part.split())
            for i, part in enumerate(filter(None, parts), 1)]


def _number(where: str, word: str, meaning: str, lo: float = -math.inf) -> float:
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or value < lo:
        least = '' if lo == -math.inf else f' of at least {lo:g}'
        raise SettingsError(f'{where}: {meaning} {word!r} must be a number{least}')
    return value


def parse_legs(text: str, name: str = 'legs') -> tuple[Leg, ...]:
    """
    Return the course plan written as 't_s course_deg speed_kn; ...'.

    Raises
    ------
    SettingsError
        Names the wrong entry. Each must hold three numbers; the first starts at 0 s, and times
        increase.

    Examples
    --------
    >>> parse_legs('0 45 12; 600 90 12')[1]
    Leg(t_s=600.0, course_deg=90.0, speed_kn=12.0)

    """
    legs: list[Leg] = []
    for where, words in _entries(name, text):
        if len(words) != 3:
            raise SettingsError(f"{where}: must be 't_s course_deg speed_kn'")
        leg = Leg(_number(where, words[0], 'time', 0.0), _number(where, words[1], 'course'),
                  _number(where, words[2], 'speed'))
        if legs and leg.t_s <= legs[-1].t_s:
            raise SettingsError(f'{where}: its time must exceed that of the entry before')
        legs.append(leg)
    if not legs or legs[0].t_s != 0.0:
        raise SettingsError(f'{name} = {text!r}: the first entry must start at 0 s')
    return tuple(legs)


def parse_faults(text: str, name: str = 'faults') -> tuple[Fault, ...]:
    """
    Return the faults written as 't_s kind [value [duration_s]]; ...'.

    Raises
    ------
    SettingsError
        Names the wrong entry and the allowed kinds.

    Examples
    --------
    >>> parse_faults('60 freeze 0 30; 600 mirrored')[0]
    Fault(t_s=60.0, kind='freeze', value=0.0, duration_s=30.0)

    """
    faults = []
    for where, words in _entries(name, text):
        if not 2 <= len(words) <= 4:
            raise SettingsError(f"{where}: must be 't_s kind [value [duration_s]]'")
        if words[1] not in FAULTS:
            raise SettingsError(f"{where}: kind {words[1]!r} must be {' or '.join(FAULTS)}")
        value = (_number(where, words[2], 'value') if len(words) > 2 else FAULTS[words[1]][1])
        duration = (_number(where, words[3], 'duration', 0.0) if len(words) > 3 else math.inf)
        faults.append(Fault(_number(where, words[0], 'time', 0.0), words[1], value, duration))
    return tuple(faults)


def parse_starts(text: str, name: str = 'starts') -> tuple[RunUp, ...]:
    """
    Return the starts written as 't_s error_deg; ...', after one at 0 s without an error.

    Raises
    ------
    SettingsError
        Names the wrong entry. Each must hold two numbers, and times increase.

    Examples
    --------
    >>> parse_starts('43200 0.3')
    (RunUp(t_s=0.0, error_deg=0.0), RunUp(t_s=43200.0, error_deg=0.3))

    """
    starts = [RunUp(0.0, 0.0)]
    for where, words in _entries(name, text):
        if len(words) != 2:
            raise SettingsError(f"{where}: must be 't_s error_deg'")
        start = RunUp(_number(where, words[0], 'time', 0.0), _number(where, words[1], 'error'))
        if start.t_s <= starts[-1].t_s:
            raise SettingsError(f'{where}: its time must exceed that of the start before')
        starts.append(start)
    return tuple(starts)


def parse_utc(text: str, name: str = 'start_utc') -> int:
    """
    Return an ISO 8601 instant as integer nanoseconds; UTC unless it names a zone.

    Examples
    --------
    >>> parse_utc('2026-01-01T00:00:00Z')
    1767225600000000000

    """
    try:
        instant = datetime.fromisoformat(re.sub('[zZ]$', '+00:00', text))
    except ValueError:
        raise SettingsError(
            f"{name} = {text!r}: must be a UTC instant such as '2026-01-01T00:00:00Z'") from None
    if instant.tzinfo is None:
        instant = instant.replace(tzinfo=timezone.utc)
    since = instant - datetime(1970, 1, 1, tzinfo=timezone.utc)
    return (since.days * 86400 + since.seconds) * 10**9 + since.microseconds * 1000


def parse_events(text: str, name: str = 'events') -> tuple[Event, ...]:
    """
    Return the events written as 't_s kind; ...', in time order.

    Raises
    ------
    SettingsError
        Names the wrong entry and the allowed kinds.

    Examples
    --------
    >>> parse_events('7200 gyro_azimuth')
    (Event(t_s=7200.0, kind='gyro_azimuth'),)

    """
    events = []
    for where, words in _entries(name, text):
        if len(words) != 2:
            raise SettingsError(f"{where}: must be 't_s kind'")
        if words[1] not in EVENTS:
            raise SettingsError(f"{where}: kind {words[1]!r} must be {' or '.join(EVENTS)}")
        events.append(Event(_number(where, words[0], 'time', 0.0), words[1]))
    return tuple(sorted(events, key=lambda event: event.t_s))


def parse_deviation(text: str, name: str = 'deviation') -> tuple[float, ...]:
    """
    Return the coefficients written as 'B C D E'; all zero for an empty text.

    Raises
    ------
    SettingsError
        If there are more or fewer than four numbers.

    Examples
    --------
    >>> parse_deviation('0.3 -0.2 0 0.1')
    (0.3, -0.2, 0.0, 0.1)

    """
    words = text.split()
    if words and len(words) != 4:
        raise SettingsError(f"{name} = {text!r}: must be four numbers 'B C D E', degrees")
    return tuple(_number(f'{name} = {text!r}', word, 'coefficient')
                 for word in words) or (0.0, 0.0, 0.0, 0.0)


def parse_fixed(text: str, name: str = 'fixed') -> dict[str, float]:
    """
    Return the fixed errors written as 'name value; ...'.

    Raises
    ------
    SettingsError
        Names the wrong entry and the allowed names.

    Examples
    --------
    >>> parse_fixed('drift_y 0.01; bias_x 50')
    {'drift_y': 0.01, 'bias_x': 50.0}

    """
    fixed = {}
    for where, words in _entries(name, text):
        if len(words) != 2:
            raise SettingsError(f"{where}: must be 'name value'")
        if words[0] not in FIXED:
            raise SettingsError(f"{where}: name {words[0]!r} must be {' or '.join(FIXED)}")
        fixed[words[0]] = _number(where, words[1], 'value')
    return fixed
