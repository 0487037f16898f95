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

"""Publishing of all pairs in the rolling window, of the vote on them, and its alarms."""

from __future__ import annotations

import time
from typing import Any, Mapping

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from heading_intercompare.core.records import Headings
from heading_intercompare.core.sensors.comparison import SensorsComparison
from heading_intercompare.core.sensors.pair_names import Names
from heading_intercompare.core.sensors.sensors_now import (
    describe_now,
    vote_now,
    vote_rules,
    vote_signs,
)
from heading_intercompare.core.sensors.vote import Vote
from heading_intercompare.nodes.alarms.alarm_panel import AlarmPanel
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.interface.parameters import follow
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.spinning.clocks import stamp_or_now
from heading_intercompare.web.figures.stream_watch import SensorView, StreamWatch

from .sensors_messages import (
    encode_sensors_figures,
    encode_vote,
    FIGURES_TOPIC,
    VOTE_TOPIC,
)


class NowPublisher:
    """
    Publishes what the rolling window says of all pairs, and raises the alarm of the vote.

    Parameters
    ----------
    node, health
        The node, and its state.
    comparison
        Has the pairs.
    mean_max_deg
        Largest mean difference that an installation explains, degrees.
    stale_s
        Silence after which a sensor is called silent, seconds.

    Attributes
    ----------
    panel : AlarmPanel
        An alarm for each sensor.

    """

    def __init__(self, node: Node, health: Health, comparison: SensorsComparison,
                 mean_max_deg: float, stale_s: float) -> None:
        self._node, self._owner = node, health.owner
        self._comparison, self._mean_max_deg = comparison, mean_max_deg
        self._watches = {sensor.name: StreamWatch(stale_s) for sensor in comparison.sensors}
        for watch in self._watches.values():
            follow(node, 'stale_s', watch.allow)
        self._figures = node.create_publisher(DiagnosticArray, FIGURES_TOPIC, qos.STATE)
        self._vote = node.create_publisher(DiagnosticArray, VOTE_TOPIC, qos.STATE)
        self.panel = AlarmPanel(node, health, vote_rules(self._watches))

    def take(self, headings: Mapping[str, Headings], received_ns: Mapping[str, int]) -> None:
        """Take readings by sensor, and when the newest message of each came, UTC ns."""
        for name, readings in headings.items():
            if len(readings):
                self._watches[name].take(readings, received_ns[name], time.monotonic())

    def look(self, rolling: Mapping[Names, Mapping[str, Any]], newest_ns: int | None,
             judged: Vote | None) -> None:
        """
        Publish figures and vote, and update the alarms; call it once a second.

        Parameters
        ----------
        rolling
            The rolling figures of the tested sensors with the reference.
        newest_ns
            The newest stamp.
        judged
            The vote on the judged runs, if there is one.

        """
        pairs = [describe_now(names, rolling.get(names) or pair.compliance.rolling_figures(),
                              self._mean_max_deg)
                 for names, pair in self._comparison.pairs.items()]
        vote = vote_now([*self._watches], pairs)
        ns = stamp_or_now(self._node, newest_ns)
        self._figures.publish(encode_sensors_figures(
            {name: _describe(view) for name, view in self.view().items()}, pairs, ns,
            self._owner))
        self._vote.publish(encode_vote(vote, judged, ns, self._owner))
        if newest_ns is not None:
            self.panel.update(vote_signs(self._watches, vote, pairs), newest_ns)

    def view(self) -> dict[str, SensorView]:
        """Return each sensor as it reports now."""
        now_s = time.monotonic()
        return {name: watch.view(now_s) for name, watch in self._watches.items()}


def _describe(view: SensorView) -> dict[str, Any]:
    return {'heading_deg': view.heading_deg, 'last_deg': view.last_deg, 'age_s': view.age_s,
            'rate_hz': view.rate_hz, 'offset_s': view.offset_s, 'stale': view.stale,
            'flagged': view.flagged}
