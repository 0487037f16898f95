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
The alerts of a graph as a source of bridge alert management tells them, and the commands of it.

States and priorities are those of IMO MSC.302(87): a caution is active or normal and is not
acknowledged there, a warning that nobody acknowledges is repeated, and silence lasts 30 s.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
import math
from typing import Iterable, NamedTuple
import zlib

from heading_intercompare.core.alarms.alarm import AlarmState, Priority

from .alert_sentences import (
    AlertCommand,
    AlertEntry,
    write_alc,
    write_alf,
    write_arc,
    write_hbt,
)
from .alert_settings import AlertSettings

_SILENCE_S = 30.0
#: Most alerts that are remembered; ALC has room for no more.
_MOST = 250
_LETTERS = {AlarmState.UNACKNOWLEDGED: 'V', AlarmState.ACKNOWLEDGED: 'A',
            AlarmState.RECTIFIED: 'U', AlarmState.NORMAL: 'N'}

#: Alarms in the order of their identifiers: only append to it, for bridges know the numbers.
_NAMES = ('ts_frozen', 'rs_frozen', 'rotated', 'mirrored', 'jump', 'outliers', 'same_source',
          'clock_step', 'mean_difference', 'reference', 'resolution', 'repeated_readings',
          'motion', 'ts_silent', 'rs_silent', 'checksum', 'second_talker', 'burst', 'dropped',
          'not_recorded', 'not_written', 'two_publishers', 'mismatch', 'lost_on_the_way',
          'overload', 'second_sender')
_FIRST = 10001
_IDENTIFIERS = {name: _FIRST + number for number, name in enumerate(_NAMES)}
#: Those of other alarms are made from their names.
_FIRST_OTHER, _N_OTHERS = 20000, 900000

#: The sentences of one message.
Message = tuple[str, ...]


def identifier_of(name: str) -> int:
    """
    Return the identifier of a kind of alarm, which stays the same.

    Examples
    --------
    >>> identifier_of('ts_frozen'), identifier_of('gyro2_wrong')
    (10001, 65503)

    """
    return _IDENTIFIERS.get(name, _FIRST_OTHER + zlib.crc32(name.encode()) % _N_OTHERS)


@dataclass(frozen=True, slots=True)
class ReportedAlert:
    """
    An alarm as its node reports it.

    Attributes
    ----------
    node, name
        The node that watches, and what it calls the alarm.
    words
        The condition.
    raised_ns, changed_ns
        When it was last raised, and when its state last changed, nanoseconds; None if never.

    """

    node: str
    name: str
    state: AlarmState
    priority: Priority
    words: str = ''
    raised_ns: int | None = None
    changed_ns: int | None = None


def name_alerts(alerts: Iterable[ReportedAlert], former: Iterable[ReportedAlert],
                ) -> dict[str, ReportedAlert]:
    """
    Return the alerts of a message by name, and those of its nodes that it lacks as normal.

    Parameters
    ----------
    alerts
        All alerts of one or more nodes.
    former
        Those that were reported before.

    """
    reported = {f'{alert.node}: {alert.name}': alert for alert in alerts}
    nodes = {alert.node for alert in reported.values()}
    over = {f'{alert.node}: {alert.name}': replace(
        alert, state=AlarmState.NORMAL, changed_ns=None)
        for alert in former if alert.node in nodes}
    return {**over, **reported}


class Answer(NamedTuple):
    """
    What follows from a command.

    Attributes
    ----------
    messages
        What to send.
    acknowledge
        Name of the alarm to acknowledge, with its node; None: none.

    """

    messages: list[Message]
    acknowledge: str | None = None


@dataclass(slots=True)
class _Row:
    """What is known of an alert, and what was told of it."""

    alert: ReportedAlert
    identifier: int
    instance: int
    revision: int = 0
    escalation: int = 0
    sent_letter: str = 'N'
    changed_ns: int = 0
    silent_until_s: float = -math.inf
    repeat_at_s: float = math.inf

    def letter(self, now_s: float) -> str:
        """Return its state as ALF writes it."""
        state = self.alert.state
        if self.alert.priority is Priority.CAUTION:
            return 'A' if state.active else 'N'
        if state is AlarmState.UNACKNOWLEDGED and now_s < self.silent_until_s:
            return 'S'
        return _LETTERS[state]

    def entry(self) -> AlertEntry:
        """Return what is told of it."""
        alert = self.alert
        words = '' if self.sent_letter == 'N' else f'{alert.node}: {alert.words}'
        return AlertEntry(
            self.identifier, self.instance, self.revision, self.escalation,
            'C' if alert.priority is Priority.CAUTION else 'W', self.sent_letter, self.changed_ns,
            alert.name.replace('_', ' ').upper(), words)


class AlertList:
    """
    Tells the alerts of a graph to the bridge: each change, a list, repetitions and a heartbeat.

    Parameters
    ----------
    settings
        Talker, manufacturer and periods.

    Attributes
    ----------
    counts
        Commands by outcome, and alerts beyond the 250 that are remembered.

    """

    def __init__(self, settings: AlertSettings) -> None:
        self._settings = settings
        self._manufacturer = settings.manufacturer or ''
        self._rows: dict[str, _Row] = {}
        self._alf = self._alc = self._hbt = 0
        self._list_at_s = self._beat_at_s = -math.inf
        self.counts: Counter[str] = Counter()

    @property
    def active(self) -> int:
        """Return how many alerts are not normal."""
        return sum(row.sent_letter != 'N' for row in self._rows.values())

    def update(self, alerts: Iterable[ReportedAlert], now_s: float, now_ns: int,
               ) -> list[Message]:
        """
        Take a message of a node, and return what to send.

        Parameters
        ----------
        alerts
            All alerts of one or more nodes: one of theirs that is missing is over.
        now_s, now_ns
            The time now: of a steady clock in seconds, and UTC in nanoseconds.

        """
        messages = []
        reported = name_alerts(alerts, [row.alert for row in self._rows.values()])
        for name, alert in reported.items():
            row = self._rows.get(name) or self._add(name, alert)
            if row is None:
                continue
            was_raised = alert.state.active and alert.raised_ns != row.alert.raised_ns
            row.alert = alert
            letter = row.letter(now_s)
            if was_raised or (letter not in 'VS' and row.sent_letter != letter):
                row.silent_until_s = -math.inf
                letter = row.letter(now_s)
            if letter != row.sent_letter or (was_raised and letter != 'N'):
                row.escalation = 0
                row.repeat_at_s = now_s + self._settings.repeat_s if letter == 'V' else math.inf
                changed_ns = now_ns if alert.changed_ns is None else alert.changed_ns
                messages.append(self._tell(row, letter, changed_ns))
        return messages

    def due(self, now_s: float, now_ns: int, *, is_well: bool) -> list[Message]:
        """
        Return what is due: the end of a silence, a repetition, the list, the heartbeat.

        Parameters
        ----------
        now_s, now_ns
            As for `update`.
        is_well
            Whether the alarms of the graph are heard, for the heartbeat.

        """
        messages, settings = [], self._settings
        for row in self._rows.values():
            letter = row.letter(now_s)
            if letter != row.sent_letter:
                row.repeat_at_s = now_s + settings.repeat_s
                messages.append(self._tell(row, letter, now_ns))
            elif letter == 'V' and now_s >= row.repeat_at_s:
                row.repeat_at_s = now_s + settings.repeat_s
                row.escalation = row.escalation % 9 + 1
                messages.append(self._tell(row, letter, now_ns))
        if now_s >= self._list_at_s:
            self._list_at_s = now_s + settings.list_period_s
            active = [row.entry() for row in self._rows.values() if row.sent_letter != 'N']
            messages.append(write_alc(settings.talker, self._manufacturer, self._alc, active))
            self._alc = (self._alc + 1) % 100
        if now_s >= self._beat_at_s:
            self._beat_at_s = now_s + settings.heartbeat_s
            messages.append(write_hbt(settings.talker, settings.heartbeat_s, self._hbt,
                                      is_well=is_well))
            self._hbt = (self._hbt + 1) % 10
        return messages

    def take_command(self, command: AlertCommand, now_s: float, now_ns: int) -> Answer:
        """
        Return what follows from a command; one for an alert of other equipment is left alone.

        Acknowledged and silenced can be a warning that is active or rectified and not
        acknowledged. Responsibility is not transferred.
        """
        kinds = {*_IDENTIFIERS.values(), *(row.identifier for row in self._rows.values())}
        if command.manufacturer != self._manufacturer or command.identifier not in kinds:
            self.counts['commands_of_others'] += 1
            return Answer([])
        rows = [(name, row) for name, row in self._rows.items()
                if row.identifier == command.identifier
                and command.instance in (None, row.instance)]
        if len(rows) == 1:
            (name, row), = rows
            if command.letter == 'Q':
                self.counts['commands_done'] += 1
                return Answer([self._write(row)])
            if command.letter == 'A' and row.sent_letter in 'VSU':
                self.counts['commands_done'] += 1
                return Answer([], name)
            if command.letter == 'S' and row.sent_letter in 'VS':
                self.counts['commands_done'] += 1
                row.silent_until_s = now_s + _SILENCE_S
                return Answer([self._tell(row, 'S', now_ns)] if row.sent_letter == 'V' else [])
        return Answer([self.refuse(command, now_ns)])

    def refuse(self, command: AlertCommand, now_ns: int) -> Message:
        """Return the message that refuses a command."""
        self.counts['commands_refused'] += 1
        return write_arc(self._settings.talker, command, now_ns)

    def _add(self, name: str, alert: ReportedAlert) -> _Row | None:
        """Return a new row for an alert that is not normal; None if there is nothing to tell."""
        if alert.state is AlarmState.NORMAL:
            return None
        if len(self._rows) >= _MOST:
            normal = next((key for key, row in self._rows.items() if row.sent_letter == 'N'), None)
            if normal is None:
                self.counts['alerts_beyond'] += 1
                return None
            del self._rows[normal]
        identifier = identifier_of(alert.name)
        used = {row.instance for row in self._rows.values() if row.identifier == identifier}
        instance = next(number for number in range(1, _MOST + 2) if number not in used)
        self._rows[name] = row = _Row(ReportedAlert(
            alert.node, alert.name, AlarmState.NORMAL, alert.priority), identifier, instance)
        return row

    def _tell(self, row: _Row, letter: str, changed_ns: int) -> Message:
        """Note a change, and return the message that tells it."""
        row.sent_letter, row.changed_ns = letter, changed_ns
        row.revision = row.revision % 99 + 1
        return self._write(row)

    def _write(self, row: _Row) -> Message:
        sequence, self._alf = self._alf, (self._alf + 1) % 10
        return write_alf(self._settings.talker, self._manufacturer, sequence, row.entry())
