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

"""The headings of several sensors to their comparison, and how each sensor reports now."""

from __future__ import annotations

import time

from rclpy.node import Node

from heading_intercompare.core.pairing.ledger import LedgerKey
from heading_intercompare.core.records import Headings, Losses
from heading_intercompare.core.sensors.comparison import SensorsComparison
from heading_intercompare.nodes.ros.health import Health
from heading_intercompare.nodes.ros.parameters import follow
from heading_intercompare.nodes.settings import HeadingTypes, Taking
from heading_intercompare.nodes.taking.headings_intake import HeadingsIntake
from heading_intercompare.web.figures.stream_watch import SensorView, StreamWatch


class SensorsIntake:
    """
    Takes the headings of several sensors, and tells the comparison what was lost.

    Parameters
    ----------
    node, health, taking
        As for `Intake`.

    Attributes
    ----------
    heard : HeadingsIntake
        The headings by sensor.
    newest_ns
        The newest stamp of any sensor; None before the first reading.

    """

    def __init__(self, node: Node, health: Health, taking: Taking, types: HeadingTypes,
                 comparison: SensorsComparison) -> None:
        self._comparison = comparison
        streams = {sensor.name: (
            sensor.heading_topic, sensor.convention,
            types.rs_message_type if sensor.is_reference else types.ts_message_type)
            for sensor in comparison.sensors}
        self.heard = HeadingsIntake(node, health, taking, streams, self._lose)
        self._watches = {name: StreamWatch(taking.stale_s) for name in streams}
        for watch in self._watches.values():
            follow(node, 'stale_s', watch.allow)
        self.newest_ns: int | None = None

    def take(self, *, last: bool = False) -> dict[str, Headings]:
        """Return the readings since the last call, by sensor; `last` says that none follow."""
        headings = self.heard.take(last=last)
        for name, readings in headings.items():
            if len(readings):
                self._watches[name].take(readings, self.heard.received_ns[name], time.monotonic())
                self.newest_ns = max(self.newest_ns or 0, int(readings.stamp_ns[-1]))
        return headings

    def _lose(self, name: str, lost_as: str, losses: Losses) -> None:
        self._comparison.lose(name, LedgerKey.of_told('ts', lost_as), losses)

    def view(self) -> dict[str, SensorView]:
        """Return each sensor as it reports now."""
        now_s = time.monotonic()
        return {name: watch.view(now_s) for name, watch in self._watches.items()}
