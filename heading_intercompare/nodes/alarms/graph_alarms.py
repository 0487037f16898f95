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

"""The alarms about the graph itself, from the heartbeats of its nodes."""

from __future__ import annotations

from contextlib import suppress

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from heading_intercompare.core.alarms.graph_watch import GraphWatch, TROUBLE_RULES
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.heartbeat_messages import decode_beat, HEARTBEAT_TOPIC
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.spinning.batches import take_all, Unwatched
from heading_intercompare.nodes.spinning.clocks import AwakeClock

from .alarm_panel import AlarmPanel


class GraphAlarms:
    """
    Raises what is wrong with a graph on the panel of a node, at the time of day.

    Parameters
    ----------
    panel
        Gets the alarms.
    keepers_only
        As for `GraphWatch`.

    Attributes
    ----------
    panel : AlarmPanel

    """

    def __init__(self, node: Node, health: Health, panel: AlarmPanel, *,
                 keepers_only: bool = False) -> None:
        self._watch = GraphWatch(health.name, keepers_only=keepers_only)
        self.panel, self._awake, self._clock = panel, AwakeClock(), node.get_clock()
        if not keepers_only:
            panel.add(TROUBLE_RULES)
        # Taken once a second: to wake for each one would cost more than all else here.
        self._heard = node.create_subscription(
            DiagnosticArray, HEARTBEAT_TOPIC, lambda message: None, qos.DIAGNOSTICS_IN, raw=True,
            callback_group=Unwatched(), event_callbacks=health.of_subscription(HEARTBEAT_TOPIC))
        health.add_refresher(self._look)

    def _look(self) -> None:
        # While this node stands still, it hears nobody, and no time passes.
        now_s = self._awake.now_s()
        rules = []
        for data, _ in take_all(self._heard):
            # Others may publish what they like; who says nothing readable is not heard.
            with suppress(MessageError):
                rules.append(self._watch.take(decode_beat(data), now_s))
        if newcomers := [rule for rule in rules if rule is not None]:
            self.panel.add(newcomers)
        signs = {name: sign for name, sign in self._watch.look(now_s).items()
                 if sign.active or self.panel[name].state.active}
        if signs:
            self.panel.update(signs, self._clock.now().nanoseconds)
