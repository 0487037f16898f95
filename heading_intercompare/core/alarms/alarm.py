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

"""Alarms and their states after IMO MSC.302(87): raised, acknowledged, rectified."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any, Iterable, Mapping


class Priority(str, Enum):
    """
    How grave an alarm is.

    `WARNING`: the comparison means nothing while it lasts. `CAUTION`: some readings are bad, or
    not all is kept.
    """

    WARNING = 'warning'
    CAUTION = 'caution'

    def __str__(self) -> str:
        return self.value


class AlarmState(str, Enum):
    """The states of an alarm; responsibility is not transferred here."""

    NORMAL = 'normal'
    UNACKNOWLEDGED = 'active_unacknowledged'
    ACKNOWLEDGED = 'active_acknowledged'
    RECTIFIED = 'rectified_unacknowledged'

    def __str__(self) -> str:
        return self.value

    @property
    def active(self) -> bool:
        """Whether the condition still holds."""
        return self in (AlarmState.UNACKNOWLEDGED, AlarmState.ACKNOWLEDGED)


@dataclass(frozen=True, slots=True)
class Rule:
    """
    What an alarm is called, and how long its condition must be gone before it clears.

    Attributes
    ----------
    name
        Name of the alarm.
    clear_s
        The condition must be gone for this time before the alarm clears, seconds.

    """

    name: str
    priority: Priority = Priority.WARNING
    clear_s: float = 3.0


@dataclass(frozen=True, slots=True)
class Sign:
    """
    What a detector says about the condition of an alarm.

    Attributes
    ----------
    active
        True: the condition holds. False: it does not. None: the data cannot tell now, so the
        alarm stays as it is.
    words
        The condition in words, if it holds.
    values
        Figures to show with it.

    """

    active: bool | None
    words: str = ''
    values: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Alarm:
    """
    The state of one alarm.

    Attributes
    ----------
    words
        The condition in words, as last seen.
    values
        Figures of that condition.
    times
        How often it was raised.
    raised_ns, cleared_ns, acknowledged_ns
        When it was last raised, cleared and acknowledged, nanoseconds.

    Examples
    --------
    >>> alarm = Alarm(Rule('jump', clear_s=2.0)).see(Sign(True, 'TS - RS jumped'), 0)
    >>> alarm = alarm.see(Sign(False), 10 ** 9).see(Sign(False), 4 * 10 ** 9)
    >>> str(alarm.state), str(alarm.acknowledge(5 * 10 ** 9).state)
    ('rectified_unacknowledged', 'normal')

    """

    rule: Rule
    state: AlarmState = AlarmState.NORMAL
    words: str = ''
    values: Mapping[str, Any] = field(default_factory=dict)
    times: int = 0
    raised_ns: int | None = None
    cleared_ns: int | None = None
    acknowledged_ns: int | None = None
    _gone_ns: int | None = None

    def see(self, sign: Sign, now_ns: int) -> 'Alarm':
        """
        Return the alarm after a look at its condition.

        Parameters
        ----------
        sign
            What the detector says.
        now_ns
            Time of the look, nanoseconds; should not decrease from look to look.

        """
        if sign.active is None:
            return self
        if sign.active:
            seen = replace(self, words=sign.words, values=sign.values, _gone_ns=None)
            if self.state.active:
                return seen
            return replace(seen, state=AlarmState.UNACKNOWLEDGED, times=self.times + 1,
                           raised_ns=now_ns, cleared_ns=None, acknowledged_ns=None)
        if not self.state.active:
            return self
        gone_ns = now_ns if self._gone_ns is None else min(self._gone_ns, now_ns)
        if now_ns - gone_ns < round(self.rule.clear_s * 1e9):
            return replace(self, _gone_ns=gone_ns)
        unseen = self.state is AlarmState.UNACKNOWLEDGED
        return replace(self, state=AlarmState.RECTIFIED if unseen else AlarmState.NORMAL,
                       cleared_ns=now_ns, _gone_ns=None)

    def acknowledge(self, now_ns: int) -> 'Alarm':
        """Return the alarm after somebody has acknowledged it; the same if nothing is open."""
        if self.state is AlarmState.UNACKNOWLEDGED:
            return replace(self, state=AlarmState.ACKNOWLEDGED, acknowledged_ns=now_ns)
        if self.state is AlarmState.RECTIFIED:
            return replace(self, state=AlarmState.NORMAL, acknowledged_ns=now_ns)
        return self


class AlarmTable:
    """
    Alarms by name.

    Parameters
    ----------
    rules
        One for each alarm.

    """

    def __init__(self, rules: Iterable[Rule]) -> None:
        self._alarms: dict[str, Alarm] = {}
        # Alarms about data have the times of its stamps, others that of day.
        self._seen_ns: dict[str, int] = {}
        self.add(rules)

    def add(self, rules: Iterable[Rule]) -> None:
        """Add alarms; one that is there stays as it is."""
        self._alarms = {**{rule.name: Alarm(rule) for rule in rules}, **self._alarms}

    def __len__(self) -> int:
        return len(self._alarms)

    @property
    def alarms(self) -> tuple[Alarm, ...]:
        """All alarms, in the order of their rules."""
        return tuple(self._alarms.values())

    def __getitem__(self, name: str) -> Alarm:
        return self._alarms[name]

    def update(self, signs: Mapping[str, Sign], now_ns: int) -> list[Alarm]:
        """
        Take what the detectors say at a time; alarms without a sign stay as they are.

        Returns
        -------
        list of Alarm
            Those whose state changed.

        """
        self._seen_ns |= dict.fromkeys(signs, now_ns)
        return self._change({name: self._alarms[name].see(sign, now_ns)
                             for name, sign in signs.items()})

    def acknowledge(self, name: str | None, now_ns: int) -> list[Alarm]:
        """
        Acknowledge one alarm by its name, or all; return those whose state changed.

        The time is that of the last look at an alarm; `now_ns` for one that nobody looked at.
        """
        return self._change({key: alarm.acknowledge(self._seen_ns.get(key, now_ns))
                             for key, alarm in self._alarms.items() if name in (None, key)})

    def _change(self, new: Mapping[str, Alarm]) -> list[Alarm]:
        changed = [alarm for name, alarm in new.items()
                   if alarm.state is not self._alarms[name].state]
        self._alarms.update(new)
        return changed
