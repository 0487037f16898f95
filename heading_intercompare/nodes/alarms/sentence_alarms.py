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

"""The alarms of a driver: damaged sentences, a second talker, bursts, dropped datagrams."""

from __future__ import annotations

import time
from typing import Mapping

from rclpy.node import Node

from heading_intercompare.core.alarms.sentence_watch import SENTENCE_RULES, SentenceWatch
from heading_intercompare.nodes.presence.health import Health

from .alarm_panel import AlarmPanel


class SentenceAlarms:
    """
    Watches the counts of a driver.

    Parameters
    ----------
    talker
        The talker that the user chose.

    Attributes
    ----------
    panel : AlarmPanel
        The alarms.

    """

    def __init__(self, node: Node, health: Health, talker: str | None) -> None:
        self._watch = SentenceWatch(talker)
        self.panel = AlarmPanel(node, health, SENTENCE_RULES)

    def look(self, counts: Mapping[str, int], headings: int) -> None:
        """Look at the counts of source and decoder; call it once a second."""
        self.panel.update(self._watch.look(counts, headings, time.monotonic()), time.time_ns())
