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

"""The state of a node on /diagnostics once per second, at once when worse; and a heartbeat."""

from __future__ import annotations

import re
import time
from types import MappingProxyType
from typing import Any, Callable, Mapping

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import qos_check_compatible, qos_policy_name_from_kind, QoSCompatibility

from heading_intercompare.core.alarms.alarm import Priority
from heading_intercompare.core.alarms.graph_watch import (
    Beat,
    BEAT_S,
    MISMATCH,
    TWO_PUBLISHERS,
    WITHIN_S,
)
from heading_intercompare.messages.heartbeat_messages import encode_beat, HEARTBEAT_TOPIC
from heading_intercompare.messages.status_messages import (
    encode_statuses,
    ERROR,
    OK,
    Status,
    WARN,
)
from heading_intercompare.nodes.interface.parameters import resolve_topic
from heading_intercompare.nodes.interface.qos import STATUS
from heading_intercompare.nodes.spinning.clocks import every

from .endpoints import is_named
from .rivals import Rivals

_NUMBER = re.compile(r'\d[\d.,:e+-]*')
#: Last words of the topics that one node publishes, and whose messages nobody else counts.
_SOLE_TOPICS = frozenset(('verdict', 'run', 'rolling', 'report', 'intermediate_report', 'figures',
                          'vote', 'ledger', 'lost'))
#: Foreign words in a message must neither fill the memory nor the log.
_MOST_KINDS = 50


class Health:
    """
    Reports the state of a node, part by part; a change of state is logged once.

    A change is another level, or trouble of a kind not logged since the part was last OK. The
    kind is the message without its numbers, clause by clause: a count that grows is not logged
    again.

    Parameters
    ----------
    node
        The node whose state it reports.
    priority
        Of the alarm when the node falls silent; None: it has no heartbeat, because another node
        of its process has one.
    keeper
        The node keeps the alarms about the graph.
    whole, sensor
        For what a node does for one sensor of several: the health of the node, which has the
        heartbeat of both, and the name of the sensor.

    Attributes
    ----------
    name : str
        What the node is called within its graph, after the name of the sensor if there is one.
        /diagnostics is that of all graphs, and has the namespace before it.
    owner : str
        Full name of the node, and when it was started, UTC ns.
    logger
        Logs for the node.
    tell
        Called with a line for each change of an alarm of the node, instead of the log.
    within_s, judging_s : float
        Time in which the next heartbeat comes; how much longer if the node judges, seconds.

    """

    def __init__(self, node: Node, *, priority: Priority | None = Priority.WARNING,
                 keeper: bool = False, whole: Health | None = None, sensor: str = '') -> None:
        self._node, self.name, self.logger = node, node.get_name(), node.get_logger()
        if sensor:
            self.name, self.logger = f'{sensor}/{self.name}', self.logger.get_child(sensor)
        self._full_name = f'{node.get_namespace().rstrip("/")}/{self.name}'.removeprefix('/')
        self.owner = f'/{self._full_name} {time.time_ns()}'
        self._whole, self._members = whole or self, [self]
        self.tell: Callable[[str], None] | None = None
        self._parts: dict[str, Status] = {}
        self._latched: dict[str, Status] = {}
        self._kinds: dict[str, set[str]] = {}
        self._refreshers: list[Callable[[], None]] = []
        self._ending = False
        self._publisher = node.create_publisher(DiagnosticArray, '/diagnostics', STATUS)
        self._priority, self._keeper = priority, keeper
        self.within_s, self.judging_s = WITHIN_S, 0.0
        self._troubles: dict[str, str] = {}
        self._mismatched: set[str] = set()
        self._rivals: dict[str, Rivals] = {}
        self._heart = None if priority is None or whole is not None else node.create_publisher(
            DiagnosticArray, HEARTBEAT_TOPIC, STATUS)
        if whole is None:
            every(node, BEAT_S, self._beat)
        else:
            whole._members.append(self)
        self.note('node', OK, 'running')

    def of_sensor(self, sensor: str) -> Health:
        """Return the health of what the node does for a sensor; its own for '', the only one."""
        return Health(self._node, whole=self, sensor=sensor) if sensor else self

    @property
    def ending(self) -> bool:
        """Whether the nodes of this process end."""
        return self._whole._ending

    def mute(self) -> None:
        """Log only errors from now on, and say so: at the end inputs disappear, as they should."""
        self._ending = True
        self._publish_beat()

    def add_refresher(self, refresh: Callable[[], None]) -> None:
        """Add a function to call every second before the parts are published."""
        self._refreshers.append(refresh)

    def note(self, part: str, level: int, message: str, *, latch: bool = False,
             log: bool = True, alarm: str = '',
             figures: Mapping[str, object] = MappingProxyType({}), **values: object) -> None:
        """
        Set the state of a part; publish at once if it is worse than before.

        Parameters
        ----------
        part
            The part: an input, a file.
        level
            `OK`, `WARN` or `ERROR`.
        message
            The state in words.
        latch
            Keep showing this state until `acknowledge`, unless it is OK or a worse one is
            latched already.
        log
            Log a change.
        alarm
            The alarm of the graph for this state, one of `TROUBLE_RULES`; '': none.
        figures
            Figures to show with it, by names that are not known here.
        **values
            More of them, shown before those.

        """
        before = self._parts.get(part)
        now = Status(f'{self._full_name}: {part}', level, message, {**values, **figures})
        self._parts[part] = now
        self._troubles[part] = alarm if level != OK else ''
        latched = self._latched.get(part)
        if latch and level != OK and (latched is None or level >= latched.level):
            self._latched[part] = now
        new = self._remember(part, level, message)
        changed = level != OK if before is None else before.level != level or new
        if log and changed and (level == ERROR or not self.ending):
            self._log(level, f'{part}: {message}')
        if level > (OK if before is None else before.level):
            self.publish()

    def _remember(self, part: str, level: int, message: str) -> bool:
        """Remember the kinds of trouble in a message; tell whether one of them is new."""
        if level == OK:
            self._kinds.pop(part, None)
            return False
        kinds = set(_NUMBER.sub('#', message).split('; '))
        former_kinds = self._kinds.setdefault(part, set())
        new = not kinds <= former_kinds
        if len(former_kinds) < _MOST_KINDS:
            former_kinds |= kinds
            return new
        return False

    def acknowledge(self) -> int:
        """Clear the latched states; return how many there were."""
        n = sum(len(member._latched) for member in self._members)
        for member in self._members:
            member._latched.clear()
            member.publish()
        return n

    def publish(self) -> None:
        """Publish the current state of all parts."""
        now_ns = self._node.get_clock().now().nanoseconds
        shown = {**self._parts, **self._latched}
        self._publisher.publish(encode_statuses(now_ns, shown.values(), self.owner))

    def _beat(self) -> None:
        for member in self._members:
            member._refresh()
        self._publish_beat()

    def _refresh(self) -> None:
        for topic in [topic for topic in self._mismatched if not self._is_mismatched(topic)]:
            self._mismatched.remove(topic)
            self.note(topic, OK, 'the QoS matches')
        if self._whole is self:
            self._look_for_rivals()
        for refresh in self._refreshers:
            refresh()
        self.publish()

    def _look_for_rivals(self) -> None:
        """Say who else publishes what this node alone must publish."""
        words, is_ghost = [], True
        for topic in {publisher.topic_name for publisher in self._node.publishers}:
            if topic.rpartition('/')[2] in _SOLE_TOPICS:
                rivals = self._rivals.setdefault(topic, Rivals(topic))
                infos = (self._node.get_publishers_info_by_topic(topic)
                         if self._node.count_publishers(topic) > 1 else ())
                sentence = rivals.look([*filter(is_named, infos)])
                words += [sentence] * bool(sentence)
                is_ghost = is_ghost and (rivals.is_ghost or not sentence)
        if words or 'rivals' in self._parts:
            self.note('rivals', (WARN if is_ghost else ERROR) if words else OK,
                      '; '.join(sorted(words)) or 'no other node publishes the topics of this one',
                      alarm='' if is_ghost else TWO_PUBLISHERS)

    def _publish_beat(self) -> None:
        if self._heart is None or self._priority is None:
            return
        troubles: dict[str, str] = {}
        for member in self._members:
            for part, alarm in member._troubles.items():
                if alarm:
                    words = member._parts[part].message
                    troubles[alarm] = f'{troubles[alarm]}; {words}' if alarm in troubles else words
        self._heart.publish(encode_beat(
            Beat(self.name, self._priority, self.within_s + self.judging_s, self._keeper,
                 self._ending, troubles),
            self._node.get_clock().now().nanoseconds, self.owner))

    def say_alarm(self, level: int, line: str) -> None:
        """Log a change of an alarm, or hand it to `tell`."""
        if self._whole.tell is not None:
            self._whole.tell(f'{self.name}: {line}')
        else:
            self._log(level, line)

    def _log(self, level: int, text: str) -> None:
        if level == ERROR:
            self.logger.error(text)
        elif level == WARN:
            self.logger.warning(text)
        else:
            self.logger.info(text)

    def _note_mismatch(self, topic: str, event: Any) -> None:
        policy = qos_policy_name_from_kind(event.last_policy_kind)
        self._mismatched.add(topic)
        self.note(topic, ERROR, f'QoS mismatch on {topic}: {policy}; no message gets through',
                  alarm=MISMATCH)

    def _is_mismatched(self, topic: str) -> bool:
        """Tell whether some publisher still offers less than a subscription needs."""
        name = resolve_topic(self._node, topic)
        return any(qos_check_compatible(publisher.qos_profile, subscription.qos_profile)[0]
                   == QoSCompatibility.ERROR
                   for publisher in self._node.get_publishers_info_by_topic(name)
                   for subscription in self._node.get_subscriptions_info_by_topic(name))

    def of_subscription(self, topic: str) -> SubscriptionEventCallbacks:
        """Return callbacks that report a QoS mismatch of a subscription."""
        return SubscriptionEventCallbacks(incompatible_qos=lambda e: self._note_mismatch(topic, e))

    def of_publisher(self, topic: str) -> PublisherEventCallbacks:
        """Return callbacks that report a QoS mismatch of a publisher."""
        return PublisherEventCallbacks(incompatible_qos=lambda e: self._note_mismatch(topic, e))
