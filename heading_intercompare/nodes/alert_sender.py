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

"""The node `alert_sender`: the alarms of a graph to the bridge alert management of the ship."""

from __future__ import annotations

from functools import partial
import time
from typing import Any, Sequence

from std_msgs.msg import String

from heading_intercompare.core.alarms.alarm import AlarmState
from heading_intercompare.drivers.alerts.alert_line import AlertLine
from heading_intercompare.drivers.alerts.alert_list import AlertList, Message, ReportedAlert
from heading_intercompare.drivers.alerts.alert_push import AlertPush
from heading_intercompare.drivers.alerts.alert_sentences import AlertCommand, read_command
from heading_intercompare.drivers.alerts.alert_settings import AlertSettings
from heading_intercompare.drivers.sentences import Rejected
from heading_intercompare.messages.authors import sign_text
from heading_intercompare.messages.status_messages import (
    ALARMS_TOPIC,
    decode_statuses,
    encode_text,
    OK,
    Status,
    WARN,
)
from heading_intercompare.nodes.alarms.alarm_panel import ACKNOWLEDGE_TOPIC
from heading_intercompare.nodes.alarms.alarm_reports import read_reports
from heading_intercompare.nodes.interface.parameters import declare
from heading_intercompare.nodes.launching.process import run
from heading_intercompare.nodes.presence.graph_node import GraphNode
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.spinning.clocks import every
from heading_intercompare.nodes.taking.own_messages import OwnMessages
from heading_intercompare.nodes.taking.vouchers import owner_of

from .interface import qos
from .settings import TOLD

_TURN_S = 0.1
#: Who acknowledges by a command of the line.
_BRIDGE = 'bridge alert management'


class AlertSender(GraphNode):
    """Send the alerts of a graph as sentences, and do what the bridge commands."""

    done = False

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('alert_sender', **kwargs)
        _, settings = declare(self, TOLD, AlertSettings)
        self.ended = False
        self._alerts = AlertList(settings)
        self._line = (None if settings.destination is None and settings.push_url is not None
                      else AlertLine(settings))
        self._push = None if settings.push_url is None else AlertPush(settings)
        self.health = Health(self)
        # A publisher keeps its earlier messages for us: the newest of each node counts.
        self._reports: dict[str, list[ReportedAlert]] = {}
        self._newest: dict[str, dict[str, ReportedAlert]] = {}
        self._rejected = 0
        self._acknowledge = self.create_publisher(
            String, ACKNOWLEDGE_TOPIC, qos.ACKNOWLEDGE,
            event_callbacks=self.health.of_publisher(ACKNOWLEDGE_TOPIC))
        OwnMessages(self, self.health).subscribe(
            ALARMS_TOPIC, qos.STATE_IN, decode_statuses, self._hear, owner_of,
            act_in_doubt=partial(self._hear, in_doubt=True))
        every(self, _TURN_S, self._turn)
        self.health.add_refresher(self._note)

    def _hear(self, message: tuple[int, Sequence[Status]], in_doubt: bool = False) -> None:
        reports = read_reports(message[1])
        for node, alerts in reports.items():
            # What may be a copy that somebody else sends ends no alert.
            former = self._newest.get(node, {}) if in_doubt else {}
            self._newest[node] = former | {
                alert.name: alert for alert in alerts
                if alert.name not in former or alert.state is not AlarmState.NORMAL}
            self._reports[node] = [*self._newest[node].values()]

    def _turn(self) -> None:
        """Send what has changed and what is due, and do what was commanded."""
        reports = [alert for alerts in self._reports.values() for alert in alerts]
        self._reports = {}
        now_s, now_ns = time.monotonic(), time.time_ns()
        if self._push is not None:
            self._push.update(reports)
        if self._line is None:
            return
        self._send(self._line, self._alerts.update(reports, now_s, now_ns))
        self._send(self._line, self._alerts.due(
            now_s, now_ns, is_well=self.count_publishers(ALARMS_TOPIC) > 0))
        for text in self._line.read():
            try:
                command = read_command(text)
            except Rejected:
                self._rejected += 1
            else:
                if command is not None:
                    self._obey(self._line, command, now_s, now_ns)

    def _obey(self, line: AlertLine, command: AlertCommand, now_s: float,
              now_ns: int) -> None:
        """Do what a command says; refuse to acknowledge where no node would hear it."""
        answer = self._alerts.take_command(command, now_s, now_ns)
        self._send(line, answer.messages)
        if answer.acknowledge is None:
            return
        if self._acknowledge.get_subscription_count():
            self._acknowledge.publish(encode_text(sign_text(answer.acknowledge, _BRIDGE)))
        else:
            self._send(line, [self._alerts.refuse(command, now_ns)])

    def _send(self, line: AlertLine, messages: Sequence[Message]) -> None:
        if not messages:
            return
        try:
            line.send(messages)
        except OSError as error:
            self.health.note('line', WARN, f'nothing can be sent: {error.strerror or error}')
        else:
            self.health.note('line', OK, 'sentences are sent')

    def _note(self) -> None:
        """Show what is active, and where commands come from."""
        self.health.note('alerts', OK, f'{self._alerts.active} alerts are active',
                         figures=self._alerts.counts, commands_rejected=self._rejected or None)
        if self._line is not None:
            self.health.note('commands', OK, self._line.status)
        if self._push is not None:
            self.health.note('push', WARN if self._push.failing else OK,
                             self._push.status or 'nothing has changed yet',
                             figures=self._push.counts)

    def end(self) -> None:
        """Close the line."""
        self._close()
        self.ended = True

    def _close(self) -> None:
        for way in (self._line, self._push):
            if way is not None:
                way.close()

    def destroy_node(self) -> None:
        """Close the line, also where the node did not end."""
        self._close()
        super().destroy_node()


def main(args: Sequence[str] | None = None) -> int:
    """Run the node."""
    return run('alert_sender', AlertSender, args)
