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

"""The alarms of a graph as alerts in plain words, each with what follows from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterable, Mapping, NamedTuple, Sequence

from .bridge_records import AlarmView, AlertView
from .view_texts import real

PRIORITIES = ('alarm', 'warning', 'caution')
"""Priorities of alerts after IMO MSC.302(87), the gravest first."""

_DAY_S = 86400.0


class _Kind(NamedTuple):
    """
    What an alarm means.

    Attributes
    ----------
    words
        With the place of the sensor's title and of the alarm's values.
    state
        The state of the sensor in a word; '' if the alarm is about no sensor.
    causes
        Alarms about the same sensor, or of the same node, that explain it.

    """

    words: str
    state: str = ''
    causes: tuple[str, ...] = ()


_FAULTS = ('driver_silent', 'silent', 'frozen')
_KINDS: Mapping[str, _Kind] = {
    'frozen': _Kind('{sensor} frozen', 'frozen', ('driver_silent',)),
    'silent': _Kind('{sensor} silent', 'silent', ('driver_silent',)),
    'wrong': _Kind('{sensor} differs from the others', 'differs', (
        *_FAULTS, 'rotated', 'mirrored', 'jump', 'clock_step', 'mean_difference')),
    'rotated': _Kind('{sensor} turned by 90° or 180°', 'turned', _FAULTS),
    'mirrored': _Kind('{sensor} turns the wrong way', 'mirrored', _FAULTS),
    'jump': _Kind('{sensor} differs by {size_deg}° from before', 'jumped', (
        *_FAULTS, 'rotated', 'mirrored')),
    'outliers': _Kind('Single readings stand out by up to {size_deg}°', '', (
        *_FAULTS, 'rotated', 'mirrored', 'jump')),
    'same_source': _Kind('{sensor} shows the readings of the reference', 'a copy'),
    'clock_step': _Kind('A clock stepped by {step_s} s', 'clock', ('driver_silent',)),
    'mean_difference': _Kind('{sensor} differs by more than an installation explains', 'differs',
                             ('rotated', 'mirrored', 'jump')),
    'reference': _Kind('The reference is not accurate enough'),
    'resolution': _Kind('The readings are too coarse'),
    'repeated_readings': _Kind('Readings come twice'),
    'motion': _Kind("A heading contradicts the ship's motion", '', (
        *_FAULTS, 'rotated', 'mirrored', 'jump')),
    'overload': _Kind('The computer cannot keep up', '', ('driver_silent',)),
    'not_recorded': _Kind('Disk full or gone: nothing is recorded', '', ('recorder_silent',)),
    'not_written': _Kind('The journal, a report or the logbook cannot be written', '',
                         ('not_recorded',)),
    'two_publishers': _Kind('Two programs send the same data'),
    'mismatch': _Kind('A program cannot be heard by another one'),
    'lost_on_the_way': _Kind('Messages were lost', '', ('overload',)),
    'checksum': _Kind('{sensor}: sentences come damaged', 'damaged'),
    'second_talker': _Kind('{sensor}: a second talker is on the line', 'doubtful'),
    'second_sender': _Kind('{sensor}: a second sender is on the network', 'doubtful'),
    'burst': _Kind('{sensor}: readings come in bursts', 'doubtful'),
    'dropped': _Kind('{sensor}: datagrams are dropped', 'doubtful'),
    'driver_silent': _Kind('{sensor}: its driver has stopped', 'no driver'),
    'recorder_silent': _Kind('The recorder has stopped: nothing is recorded'),
    'compliance_silent': _Kind('Judging has stopped: no verdict will come'),
    'synchronizer_silent': _Kind('Pairing has stopped: no comparison'),
    'dashboard_silent': _Kind('Another display has stopped'),
    'motion_driver_silent': _Kind("The ship's motion is not read any more"),
    'alert_sender_silent': _Kind('Alerts do not reach the bridge any more'),
}


@dataclass(frozen=True, slots=True)
class _PlacedAlarm:
    """An alarm with its kind, and the sensor that it is about."""

    alarm: AlarmView
    kind: str
    sensor: str
    node: str

    def explains(self, consequence: '_PlacedAlarm') -> bool:
        """Tell whether another alarm follows from this one."""
        if (self.kind, self.sensor) == (consequence.kind, consequence.sensor):
            # Two nodes see one trouble.
            return self.alarm.name < consequence.alarm.name
        kind = _KINDS.get(consequence.kind)
        if kind is None or not self.alarm.active or self.kind not in kind.causes:
            return False
        return '' in (self.sensor, consequence.sensor) or self.sensor == consequence.sensor


class AlertList:
    """
    Says alarms in plain words.

    Parameters
    ----------
    titles
        What each sensor is called, by its name in the settings: 'ts' and 'rs' for two.
    reference
        Name of the reference; '' if there is none.

    """

    def __init__(self, titles: Mapping[str, str], reference: str) -> None:
        self._titles, self._reference = titles, reference

    def list_alerts(self, alarms: Iterable[AlarmView], now_ns: int | None) -> tuple[
            AlertView, ...]:
        """
        Return the alerts, the gravest first; those that are acknowledged or over come last.

        Parameters
        ----------
        alarms
            Those that are not normal.
        now_ns
            The present in the time of the data, nanoseconds; None if not known.

        """
        placed = [self._place(alarm) for alarm in alarms]
        causes = {alarm.alarm.name: self._find_cause(alarm, placed) for alarm in placed}
        alerts = [self._describe(cause, [alarm for alarm in placed
                                         if causes[alarm.alarm.name] is cause], now_ns)
                  for cause in placed if causes[cause.alarm.name] is None]
        return tuple(sorted(alerts, key=lambda alert: (
            alert.acknowledged, not alert.active, _rank(alert.priority), alert.words)))

    @staticmethod
    def _find_cause(alarm: _PlacedAlarm, placed: Sequence[_PlacedAlarm]) -> _PlacedAlarm | None:
        """Return the root from which an alarm follows; None if it stands by itself."""
        seen, cause = {alarm.alarm.name}, None
        while True:
            last = alarm if cause is None else cause
            above = next((other for other in placed if other.alarm.name not in seen
                          and other.explains(last)), None)
            if above is None:
                return cause
            seen.add(above.alarm.name)
            cause = above

    def _place(self, alarm: AlarmView) -> _PlacedAlarm:
        """Return an alarm with its sensor: `ts_frozen`, `gyro_wrong`, `gyro/compliance: jump`."""
        node, _, name = alarm.name.rpartition(': ')
        place, _, node = node.rpartition('/')
        for sensor in sorted(self._titles, key=len, reverse=True):
            kind = name.removeprefix(f'{sensor}_')
            if kind != name and kind in _KINDS:
                return _PlacedAlarm(alarm, kind, sensor, node)
        # The two of a comparison in a place of its own are that sensor and the reference.
        for role in ('ts', 'rs'):
            kind = name.removeprefix(f'{role}_')
            if place and kind != name:
                return _PlacedAlarm(alarm, kind, place if role == 'ts' else self._reference, node)
        if name in _KINDS:
            driver = node.removesuffix('_driver')
            return _PlacedAlarm(alarm, name, place or (driver if driver in self._titles else
                                                 self._tested(_KINDS[name])), node)
        return _PlacedAlarm(alarm, name, place, node)

    def _tested(self, kind: _Kind) -> str:
        """Return the tested sensor of two, if an alarm is about a sensor."""
        return 'ts' if '{sensor}' in kind.words and 'ts' in self._titles else ''

    def _describe(self, cause: _PlacedAlarm, consequences: Sequence[_PlacedAlarm],
                  now_ns: int | None) -> AlertView:
        alarm, kind = cause.alarm, _KINDS.get(cause.kind)
        family = [cause, *consequences]
        words = self._say(cause)
        age_s = None if now_ns is None or alarm.raised_ns is None else (
            (now_ns - alarm.raised_ns) / 1e9)
        return AlertView(
            priority=min((member.alarm.priority for member in family), key=_rank), words=words,
            details=alarm.words, sensor=cause.sensor, state='' if kind is None else kind.state,
            alarms=tuple(member.alarm.name for member in family if not member.alarm.acknowledged),
            since_ns=alarm.raised_ns,
            age_s=age_s if age_s is not None and 0.0 <= age_s < 400.0 * _DAY_S else None,
            active=any(member.alarm.active for member in family),
            acknowledged=all(member.alarm.acknowledged for member in family),
            consequences=tuple(dict.fromkeys(
                said for member in consequences if (said := self._say(member)) != words)))

    def _say(self, placed: _PlacedAlarm) -> str:
        """Return an alarm in plain words; one of another program says its own."""
        kind = _KINDS.get(placed.kind)
        if kind is None:
            return placed.alarm.words or placed.kind.replace('_', ' ')
        title = self._titles.get(placed.sensor, placed.sensor or 'A sensor')
        try:
            return kind.words.format_map({'sensor': title, **_round(placed.alarm.values)})
        except KeyError:
            return placed.alarm.words


def state_of(sensor: str, alerts: Iterable[AlertView]) -> AlertView | None:
    """Return the gravest active alert about a sensor; None if there is none."""
    return next((alert for alert in sorted(alerts, key=lambda alert: _rank(alert.priority))
                 if alert.active and alert.sensor == sensor and alert.state), None)


def _rank(priority: str) -> int:
    return PRIORITIES.index(priority) if priority in PRIORITIES else len(PRIORITIES)


def _round(values: Mapping[str, str]) -> dict[str, str]:
    """Return figures as people read them: signed, in about three digits."""
    figures = {}
    for name, text in values.items():
        value = real(text)
        figures[name] = text if value is None else (
            f'{value:+.0f}' if abs(value) >= 100.0 else f'{value:+.3g}')
    return figures
