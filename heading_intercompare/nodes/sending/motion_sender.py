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

"""The motion of the ship to its topics, each with one publisher at a time."""

from __future__ import annotations

import time
from typing import Mapping

from rclpy.node import Node
from rclpy.publisher import Publisher

from heading_intercompare.bags.rosbag2.motion_topics import motion_topics
from heading_intercompare.core.records import Motion
from heading_intercompare.core.settings import MotionRule
from heading_intercompare.messages.motion.motion_messages import PUBLISHED_TYPES, split_motion
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.interface.message_types import MOTION_TYPES
from heading_intercompare.nodes.interface.parameters import resolve_topic
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.sending.publishing import Backlog

_FRAME = 'ship'
#: Rows that wait until it is known that nobody else publishes them.
_MOST_HELD = 50_000


class MotionSender:
    """
    Publishes what nobody else publishes of the motion of the ship.

    Parameters
    ----------
    rule
        Names the topics. Without `compare` nothing is published.
    after_s
        How long to wait, from the first row that tells a thing, for another node to publish it.
    is_first
        Make all publishers at once, even where another node has one.

    Attributes
    ----------
    published : dict of str to int
        Messages by what they tell, 'fix', 'velocity', 'rate'; with those that wait.
    left_out : int
        Rows that another node publishes, and those without a stamp that a message can hold.

    Notes
    -----
    Two sensors may send the same positions. So a publisher is made only once rows have come and
    no other node has one, and rows that another node publishes are left out. If that node ends,
    this one takes over.

    """

    def __init__(self, node: Node, health: Health, rule: MotionRule, *, after_s: float = 0.0,
                 is_first: bool = False) -> None:
        self._node, self._health, self._after_s = node, health, after_s
        self._topics = motion_topics(rule) if rule.compare else {}
        self._publishers: dict[str, Publisher] = {}
        self._backlogs: dict[str, Backlog] = {}
        self._held: dict[str, Motion] = {}
        self._since_s: dict[str, float] = {}
        self.published = dict.fromkeys(self._topics, 0)
        self.left_out = 0
        for what in self._topics if is_first else ():
            self.open(what)

    @property
    def publishers(self) -> list[Publisher]:
        """Return the publishers made so far."""
        return [*self._publishers.values()]

    def open(self, what: str) -> None:
        """Make the publisher of one thing, even where another node has one."""
        topic = self._topics[what]
        self._publishers[what] = self._node.create_publisher(
            MOTION_TYPES[what][PUBLISHED_TYPES[what]], topic, qos.HEADINGS_OUT,
            event_callbacks=self._health.of_publisher(topic))
        self._backlogs[what] = Backlog(self._publishers[what], self._health)

    def take(self, motion: Motion) -> None:
        """Publish rows, or hold them until it is known that nobody else publishes them."""
        if not (len(motion) and self._topics):
            return
        for what, rows in motion.split().items():
            if what in self._publishers:
                self._add(what, rows)
                self._backlogs[what].publish()
            elif len(rows):
                self._since_s.setdefault(what, time.monotonic())
                held = self._held.get(what, Motion.empty()) + rows
                self.left_out += max(0, len(held) - _MOST_HELD)
                self._held[what] = held[-_MOST_HELD:]

    def look(self, ending: bool = False) -> bool:
        """
        Publish what waits, unless another node does; call it often, and at the end.

        Returns
        -------
        bool
            Whether messages wait for subscribers that are slow.

        """
        now_s = time.monotonic()
        for what in [*self._held]:
            if self._find_others(what):
                self.left_out += len(self._held.pop(what))
            elif ending or now_s >= self._since_s[what] + self._after_s:
                self.open(what)
                self._add(what, self._held.pop(what))
        for backlog in self._backlogs.values():
            backlog.publish()
        return any(map(len, self._backlogs.values()))

    def describe(self) -> Mapping[str, object]:
        """Return what was published, for /diagnostics."""
        return {**{f'{what}_published': n for what, n in self.published.items() if n},
                'left_out': self.left_out or None}

    def _find_others(self, what: str) -> bool:
        """Tell whether another node publishes this; one of the same name is a former self."""
        topic = resolve_topic(self._node, self._topics[what])
        if not self._node.count_publishers(topic):
            return False
        own_name = self._node.get_name(), self._node.get_namespace()
        return any((info.node_name, info.node_namespace) != own_name
                   for info in self._node.get_publishers_info_by_topic(topic))

    def _add(self, what: str, rows: Motion) -> None:
        messages = split_motion(rows, what, _FRAME)
        self._backlogs[what].add(messages)
        self.published[what] += len(messages)
        self.left_out += len(rows) - len(messages)
