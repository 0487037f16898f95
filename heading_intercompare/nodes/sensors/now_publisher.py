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

from functools import partial
import time
from typing import Any, Mapping

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from heading_intercompare.core.sensor_table import find_reference
from heading_intercompare.core.sensors.comparison import SensorsComparison
from heading_intercompare.core.sensors.sensors_now import (
    describe_now,
    PairNow,
    vote_now,
    vote_rules,
    vote_signs,
)
from heading_intercompare.core.sensors.vote import Vote
from heading_intercompare.core.settings import Settings
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.status_messages import decode_statuses
from heading_intercompare.nodes.alarms.alarm_panel import AlarmPanel
from heading_intercompare.nodes.ros import qos
from heading_intercompare.nodes.ros.health import Health
from heading_intercompare.nodes.ros.message_types import STATUS_TYPES
from heading_intercompare.nodes.ros.parameters import follow
from heading_intercompare.nodes.taking.intake import Intake
from heading_intercompare.web.figures.stream_watch import SensorView

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
    settings
        With `sensors`.
    comparison
        Has the pairs without the reference.
    stale_s
        Age after which the figures of a compliance node count no more, seconds.

    Attributes
    ----------
    panel : AlarmPanel
        An alarm for each sensor.

    """

    def __init__(self, node: Node, health: Health, settings: Settings,
                 comparison: SensorsComparison, stale_s: float) -> None:
        self._node, self._owner = node, health.owner
        self._comparison, self._stale_s = comparison, stale_s
        follow(node, 'stale_s', partial(setattr, self, '_stale_s'))
        self._mean_max_deg = settings.detectors.mean_max_deg
        self._names = [sensor.name for sensor in comparison.sensors]
        reference = find_reference(comparison.sensors)
        self._reference = '' if reference is None else reference.name
        # Rolling figures come with every batch of pairs, and only the newest are shown.
        self._rolling: dict[str, Intake] = {}
        self._told: dict[str, tuple[Mapping[str, Any], float]] = {}
        self._figures = node.create_publisher(DiagnosticArray, FIGURES_TOPIC, qos.STATE)
        self._vote = node.create_publisher(DiagnosticArray, VOTE_TOPIC, qos.STATE)
        self.panel = AlarmPanel(node, health, vote_rules(self._names))
        for name in self._names if self._reference else ():
            if name != self._reference:
                self._rolling[name] = Intake(node, f'{name}/compliance/rolling', STATUS_TYPES,
                                             qos.STATUS, health, needed=False, counted=False)

    def look(self, views: Mapping[str, SensorView], newest_ns: int | None,
             judged: Vote | None) -> Vote:
        """
        Publish figures and vote, and update the alarms; call it once a second.

        Parameters
        ----------
        views
            Each sensor as it reports.
        newest_ns
            The newest stamp.
        judged
            The vote on the judged runs, if there is one.

        """
        pairs = [*self._list_tested(), *self._list_others()]
        vote = vote_now(self._names, pairs)
        ns = self._node.get_clock().now().nanoseconds if newest_ns is None else newest_ns
        self._figures.publish(encode_sensors_figures(
            {name: _describe(view) for name, view in views.items()}, pairs, ns, self._owner))
        self._vote.publish(encode_vote(vote, judged, ns, self._owner))
        if newest_ns is not None:
            self.panel.update(vote_signs(self._names, vote, pairs), newest_ns)
        return vote

    def _list_tested(self) -> list[PairNow]:
        now_s, pairs = time.monotonic(), []
        for name, intake in self._rolling.items():
            for data, _ in intake.take()[-1:]:
                self._told[name] = _read(data), now_s
            values, came_s = self._told.get(name, ({}, now_s))
            pairs.append(describe_now((name, self._reference),
                                      values if now_s - came_s <= self._stale_s else {},
                                      self._mean_max_deg))
        return pairs

    def _list_others(self) -> list[PairNow]:
        return [describe_now(names, pair.compliance.rolling_figures(), self._mean_max_deg)
                for names, pair in self._comparison.others.items()]


def _read(data: bytes) -> Mapping[str, Any]:
    """Return the figures in a message; none if it is damaged."""
    try:
        return {key: value for status in decode_statuses(data)[1]
                for key, value in status.values.items()}
    except MessageError:
        return {}


def _describe(view: SensorView) -> dict[str, Any]:
    return {'heading_deg': view.heading_deg, 'last_deg': view.last_deg, 'age_s': view.age_s,
            'rate_hz': view.rate_hz, 'offset_s': view.offset_s, 'stale': view.stale,
            'flagged': view.flagged}
