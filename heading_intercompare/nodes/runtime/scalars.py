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

"""The newest figures as single numbers, for displays that plot a topic each."""

from __future__ import annotations

import math
import time
from typing import Any, Mapping

from rclpy.node import Node
from std_msgs.msg import Float64

from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.pairing.difference import subtract
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.nodes.ros import qos

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
    node
        The node that publishes.
    settings
        The installation offset and the seam of the differences.
    rate_hz
        Most messages per second and topic; 0: there are no such topics.

    """

    def __init__(self, node: Node, settings: Settings, rate_hz: float) -> None:
        self._settings, self._rate_hz, self._next_s = settings, rate_hz, 0.0
        self._publishers = {topic: node.create_publisher(Float64, topic, qos.STATUS)
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
