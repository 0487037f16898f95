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

"""Publishing of figures: mean and scatter with every batch, bounds and numbers each second."""

from __future__ import annotations

import math
import time
from typing import Any, Mapping

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from std_msgs.msg import Float64

from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.pairing.difference import subtract
from heading_intercompare.core.pipeline import Compliance
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.messages.status_messages import encode_figures, value_text
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.interface.parameters import follow
from heading_intercompare.nodes.spinning.clocks import stamp_or_now

#: Topics of std_msgs/Float64, and what each holds.
SCALARS = {
    'scalar/ts_heading_deg': 'TS heading of the newest pair, [0, 360)',
    'scalar/rs_heading_deg': 'RS heading of the newest pair, [0, 360)',
    'scalar/difference_deg': 'their difference, TS - RS, without the installation offset',
    'scalar/lag_s': 'RS stamp - TS stamp of the newest pair; 0 where one is interpolated',
    'scalar/mean_deg': 'mean difference in the rolling window',
    'scalar/std_deg': 'its standard deviation',
    'scalar/std_limit_deg': 'the standard deviation that the norms allow',
}


class Scalars:
    """
    Publishes the newest pair and the rolling figures as numbers.

    Parameters
    ----------
    node, place
        The node that publishes, and what its topics begin with.
    settings
        The installation offset and the seam of the differences.
    rate_hz
        Most messages per second and topic; 0: there are no such topics.

    """

    def __init__(self, node: Node, place: str, settings: Settings, rate_hz: float) -> None:
        self._settings, self._rate_hz, self._next_s = settings, rate_hz, 0.0
        self._publishers = {
            topic: node.create_publisher(Float64, f'{place}{topic}', qos.STATUS)
            for topic in SCALARS if rate_hz > 0}

    def publish(self, pairs: Pairs, figures: Mapping[str, Any]) -> None:
        """Publish the newest of these pairs and the figures, unless the last ones are too new."""
        now_s = time.monotonic()
        if not len(pairs) or not self._publishers or now_s < self._next_s:
            return
        self._next_s = now_s + 1.0 / self._rate_hz
        newest = pairs[-1:]
        differences = subtract(newest, self._settings.installation_offset_deg,
                               self._settings.wrap_center_deg)
        limit_deg2 = figures.get('limit_deg2')
        values = {
            'scalar/ts_heading_deg': wrap360(newest.ts_deg[0]),
            'scalar/rs_heading_deg': wrap360(newest.rs_deg[0]),
            'scalar/difference_deg': differences.x_deg[0] if len(differences) else None,
            'scalar/lag_s': newest.lag_ns[0] / 1e9,
            'scalar/mean_deg': figures.get('mean_deg'),
            'scalar/std_deg': figures.get('std_deg'),
            'scalar/std_limit_deg': None if limit_deg2 is None else math.sqrt(limit_deg2),
        }
        for topic, value in values.items():
            if value is not None and math.isfinite(value):
                self._publishers[topic].publish(Float64(data=float(value)))


# Figures follow each other no faster than this, however small the batches are.
_LEAST_S = 0.015


class Figures:
    """
    Publishes the figures of the rolling window and of the run in progress.

    Parameters
    ----------
    node, place
        As for `Scalars`.
    compliance
        Has the figures.
    scalars_hz
        As for `Scalars`.
    owner
        What the node is called in messages.

    """

    def __init__(self, node: Node, place: str, compliance: Compliance, scalars_hz: float,
                 owner: str) -> None:
        self._node, self._compliance, self._owner = node, compliance, owner
        follow(node, 'window_s', compliance.rolling.resize)
        self._scalars = Scalars(node, place, compliance.settings, scalars_hz)
        self._rolling, self._run = (
            node.create_publisher(DiagnosticArray, f'{place}compliance/{what}', qos.STATUS)
            for what in ('rolling', 'run'))
        self._bounds: dict[str, str] = {}
        self._limit_deg2: float | None = None
        self._newest_ns: int | None = None
        self._next_s = 0.0

    def publish(self, pairs: Pairs) -> None:
        """Publish the rolling figures if there are new pairs; the bounds are the last ones."""
        newest_ns, now_s = self._compliance.newest_ns, time.monotonic()
        if newest_ns == self._newest_ns or newest_ns is None or now_s < self._next_s:
            return
        self._newest_ns, self._next_s = newest_ns, now_s + _LEAST_S
        figures = self._compliance.rolling_moments()
        self._send(figures)
        self._scalars.publish(pairs, {**figures, 'limit_deg2': self._limit_deg2})

    def compute(self) -> Mapping[str, Any]:
        """Compute all figures and publish them; it takes some milliseconds. Return the rolling."""
        figures = self._compliance.rolling_figures()
        newest_ns = self._compliance.newest_ns
        self._limit_deg2 = figures.get('limit_deg2')
        # As texts, because they are sent with many batches.
        self._bounds = {key: value_text(value) for key, value in
                        {'bounds_newest_ns': newest_ns, **figures}.items() if value is not None}
        self._newest_ns = newest_ns
        self._send(figures)
        self._run.publish(encode_figures('run', self._compliance.run_figures(),
                                         stamp_or_now(self._node, newest_ns), self._owner))
        return figures

    def _send(self, figures: dict[str, Any]) -> None:
        self._rolling.publish(encode_figures('rolling', {**figures, **{
            key: value for key, value in self._bounds.items() if key not in figures}},
            stamp_or_now(self._node, self._compliance.newest_ns), self._owner))
