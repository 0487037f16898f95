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

"""A node that does not start beside another live one that publishes the same topics."""

from __future__ import annotations

import time
from typing import Sequence

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rclpy.subscription import Subscription

from heading_intercompare.core.alarms.graph_watch import TWO_PUBLISHERS
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.utc_text import utc
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.status_messages import decode_statuses, ERROR, OK
from heading_intercompare.nodes.interface.parameters import resolve_topic
from heading_intercompare.nodes.interface.qos import DIAGNOSTICS_IN
from heading_intercompare.nodes.presence.endpoints import name_node
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.presence.transports import DISCOVERY_S, is_alone
from heading_intercompare.nodes.spinning.clocks import every

#: A node that hears another one gives way for this long after its start.
_STARTING_S = 8.0
#: A live node says its state on /diagnostics every second.
_PATIENCE_S = 3.2
_LOOK_S = 0.1


class SoleNode:
    """
    Looks for other nodes that publish the topics of this one.

    Parameters
    ----------
    node
        The node that starts.
    topics
        Topics that only one node may publish.
    health
        Names this node and its start on /diagnostics, and shows another one that lives.

    Notes
    -----
    DDS lists a publisher that was killed for some 20 s, so being listed proves nothing. A live
    node of this package says its state every second. While another publisher is listed, this node
    listens for it. If it hears it while it starts, it raises SettingsError; later it shows an
    error. Of two that start at once, the later one gives way.

    """

    def __init__(self, node: Node, topics: Sequence[str], health: Health) -> None:
        self._node, self._health = node, health
        self._topics = [resolve_topic(node, topic) for topic in topics]
        self._own = node.get_fully_qualified_name()
        self._began_s = time.monotonic()
        # Within one process, nodes know each other at once. Otherwise the first headings of a
        # driver would reach nobody, or mix with those of another one.
        self._clear_s = self._began_s + (0.0 if is_alone() else DISCOVERY_S)
        self._others: dict[str, str] = {}
        self._subscription: Subscription | None = None
        self._heard_s = -_PATIENCE_S
        self._timer = every(node, _LOOK_S, self._look)
        health.add_refresher(self._look)
        self._look()

    @property
    def clear(self) -> bool:
        """Whether this node may publish: nobody else is there, or it has kept silent."""
        return time.monotonic() >= self._clear_s

    def _look(self) -> None:
        """Look who else publishes; listen while there is somebody."""
        now_s = time.monotonic()
        if now_s > self._began_s + _STARTING_S:
            self._timer.cancel()
        self._others = {}
        for topic in self._topics:
            if self._node.count_publishers(topic) > 1:
                names = [name_node(info)
                         for info in self._node.get_publishers_info_by_topic(topic)]
                if self._own in names:
                    names.remove(self._own)
                self._others |= dict.fromkeys(names, topic)
        if self._others and self._subscription is None:
            if now_s < self._began_s + _STARTING_S:
                self._clear_s = max(self._clear_s, now_s + _PATIENCE_S)
            self._subscription = self._node.create_subscription(
                DiagnosticArray, '/diagnostics', self._hear, DIAGNOSTICS_IN, raw=True)
        elif not self._others and self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None
        if 0.0 < now_s - self._heard_s - _PATIENCE_S < 2.0:
            self._health.note('graph', OK, 'no other node publishes these topics')

    def _hear(self, data: bytes) -> None:
        """Take what a node says of itself."""
        try:
            _, statuses = decode_statuses(data)
        except MessageError:
            return
        owner = statuses[0].owner if statuses else ''
        name, _, started = owner.rpartition(' ')
        if owner == self._health.owner or name not in self._others or not started.isdecimal():
            return
        rival = (f'{name}, started at {utc(int(started))} UTC, also publishes '
                 f'{self._others[name]}')
        if time.monotonic() < self._began_s + _STARTING_S and self._gives_way(int(started)):
            # The graph that was there first misses nobody.
            self._health.mute()
            raise SettingsError(f'{rival}: end it, or start this graph in a namespace of its own, '
                                'namespace:=/NAME (live: --namespace /NAME)')
        self._heard_s = time.monotonic()
        self._health.note('graph', ERROR, f'{rival}: end one of the two', alarm=TWO_PUBLISHERS)

    def _gives_way(self, started_ns: int) -> bool:
        """Tell whether the other one was there first; clocks of two computers may differ."""
        later_s = (started_ns - int(self._health.owner.rpartition(' ')[2])) / 1e9
        return not 0.0 < later_s < _STARTING_S
