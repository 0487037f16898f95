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

"""The alarms of a node on a topic, on /diagnostics and in the log; and their acknowledgement."""

from __future__ import annotations

from typing import Iterable, Mapping

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from std_msgs.msg import String

from heading_intercompare.core.alarms.alarm import (
    Alarm,
    AlarmState,
    AlarmTable,
    Priority,
    Rule,
    Sign,
)
from heading_intercompare.messages.authors import split_author
from heading_intercompare.messages.status_messages import (
    ALARMS_TOPIC,
    decode_text,
    encode_statuses,
    ERROR,
    OK,
    Status,
    WARN,
)
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.presence.action_publisher import ActionPublisher
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.spinning.clocks import stamp_or_now
from heading_intercompare.nodes.taking.raw_subscription import subscribe

ACKNOWLEDGE_TOPIC = 'compliance/acknowledge'

ALL = 'all'
"""What the topic says to acknowledge all alarms."""

_SAID = {AlarmState.UNACKNOWLEDGED: 'alarm raised', AlarmState.ACKNOWLEDGED: 'alarm acknowledged',
         AlarmState.RECTIFIED: 'alarm cleared, not acknowledged',
         AlarmState.NORMAL: 'alarm over'}


def alarm_level(alarm: Alarm) -> int:
    """Return the level of an alarm: ERROR while a warning is active and not acknowledged."""
    if alarm.state is AlarmState.NORMAL:
        return OK
    grave = (alarm.state is AlarmState.UNACKNOWLEDGED
             and alarm.rule.priority is Priority.WARNING)
    return ERROR if grave else WARN


class AlarmPanel:
    """
    Shows the alarms of a node, and lets them be acknowledged.

    Parameters
    ----------
    node
        The node that watches.
    health
        Shows the alarms on /diagnostics, in the part `alarms`.
    rules
        The alarms.

    """

    def __init__(self, node: Node, health: Health, rules: Iterable[Rule]) -> None:
        self._node, self._health = node, health
        self._table = AlarmTable(rules)
        self._now_ns: int | None = None
        self._publisher = node.create_publisher(
            DiagnosticArray, ALARMS_TOPIC, qos.STATE,
            event_callbacks=health.of_publisher(ALARMS_TOPIC))
        subscribe(node, String, ACKNOWLEDGE_TOPIC, qos.ACKNOWLEDGE, health, decode_text,
                  self._hear)
        self._actions = ActionPublisher(node, health)
        self._show(publish=True)

    def add(self, rules: Iterable[Rule]) -> None:
        """Add alarms; they are published with the others."""
        self._table.add(rules)
        self._show(publish=True)

    @property
    def muted(self) -> bool:
        """Whether signs have no effect: at the end streams fall silent, as they should."""
        return self._health.ending

    def __getitem__(self, name: str) -> Alarm:
        return self._table[name]

    def update(self, signs: Mapping[str, Sign], now_ns: int) -> None:
        """Take what the detectors say at a time, nanoseconds; publish and log what changes."""
        if not self.muted:
            self._now_ns = now_ns
            self._note(self._table.update(signs, now_ns))

    def acknowledge(self, name: str | None = None) -> int:
        """Acknowledge one alarm, or all; return how many there were."""
        return len(self._acknowledge(name))

    def _acknowledge(self, name: str | None) -> list[Alarm]:
        changed = self._table.acknowledge(name, stamp_or_now(self._node, self._now_ns))
        self._note(changed)
        return changed

    def _hear(self, text: str) -> None:
        """Acknowledge the alarm that a message names: `jump`, `compliance: jump`, or `all`."""
        words, operator = split_author(text)
        node, colon, name = words.strip().rpartition(':')
        if not colon or node.strip() == self._health.name:
            changed = self._acknowledge(None if name.strip() == ALL else name.strip())
            for alarm in changed:
                self._actions.publish(f'alarm acknowledged: {alarm.rule.name}', operator)

    def _note(self, changed: Iterable[Alarm]) -> None:
        changed = list(changed)
        for alarm in changed:
            self._say(alarm)
        self._show(publish=bool(changed))

    def _say(self, alarm: Alarm) -> None:
        level = alarm_level(alarm) if alarm.state is AlarmState.UNACKNOWLEDGED else OK
        self._health.say_alarm(
            level, f'{_SAID[alarm.state]}: {alarm.rule.name}: {alarm.words}')

    def _show(self, publish: bool) -> None:
        statuses = [self._describe(alarm) for alarm in self._table.alarms]
        if publish and statuses:
            self._publisher.publish(encode_statuses(
                stamp_or_now(self._node, self._now_ns), statuses, self._health.owner))
        raised = [a for a in self._table.alarms if a.state is not AlarmState.NORMAL]
        self._health.note(
            'alarms', max((status.level for status in statuses), default=OK),
            '; '.join(f'{a.rule.name}: {a.words} ({_in_words(a)})' for a in raised) or 'no alarm',
            log=False, figures={a.rule.name: a.state for a in self._table.alarms})

    def _describe(self, alarm: Alarm) -> Status:
        values = {'state': alarm.state, 'priority': alarm.rule.priority, 'times': alarm.times,
                  'raised_ns': alarm.raised_ns, 'acknowledged_ns': alarm.acknowledged_ns,
                  'cleared_ns': alarm.cleared_ns}
        words = 'no alarm' if alarm.state is AlarmState.NORMAL else alarm.words
        return Status(f'{self._health.name}: {alarm.rule.name}', alarm_level(alarm), words,
                      {**values, **alarm.values})


def _in_words(alarm: Alarm) -> str:
    return str(alarm.state).replace('_', ', ').replace('unacknowledged', 'not acknowledged')
