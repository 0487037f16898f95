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

"""The alarms of the node `compliance`: the detectors of the verdict on the newest data."""

from __future__ import annotations

from rclpy.node import Node

from heading_intercompare.core.alarms.comparison_watch import COMPARISON_RULES, ComparisonWatch
from heading_intercompare.core.alarms.motion_watch import MOTION_RULES, MotionWatch
from heading_intercompare.core.records import Motion, Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.nodes.interface.parameters import follow
from heading_intercompare.nodes.presence.health import Health

from .alarm_panel import AlarmPanel


class ComparisonAlarms:
    """
    Watches the pairs of a tested sensor with the reference, and the motion of the ship.

    Parameters
    ----------
    settings
        Must hold the norms.

    Attributes
    ----------
    panel : AlarmPanel
        The alarms.

    """

    def __init__(self, node: Node, health: Health, settings: Settings) -> None:
        self._watch, self._motion = ComparisonWatch(settings), MotionWatch(settings)
        follow(node, 'window_s', self._watch.resize)
        self.panel = AlarmPanel(node, health, (*COMPARISON_RULES, *MOTION_RULES))

    def take(self, pairs: Pairs) -> None:
        """Take pairs in stamp order."""
        if not self.panel.muted:
            self._watch.update(pairs)
            self._motion.update(pairs)

    def take_motion(self, motion: Motion) -> None:
        """Take motion of the ship."""
        if not self.panel.muted:
            self._motion.take_motion(motion)

    def look(self) -> None:
        """Look for conditions in the newest pairs; call it once a second."""
        if not self.panel.muted and self._watch.newest_ns is not None:
            self.panel.update({**self._watch.look(), **self._motion.look()},
                              self._watch.newest_ns)

    def start_run(self) -> None:
        """Take the present level of the differences as the usual one."""
        self._watch.accept_level()
