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

"""The alarms of a driver: damaged sentences, a second talker or sender, bursts, drops."""

from __future__ import annotations

import time
from typing import Mapping

from rclpy.node import Node

from heading_intercompare.core.alarms.sentence_watch import (
    LATE_REPEATS,
    SENDER_CHANGES,
    SENTENCE_RULES,
    SentenceWatch,
)
from heading_intercompare.drivers.nmea import NmeaDecoder
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.nodes.presence.health import Health

from .alarm_panel import AlarmPanel


class SentenceAlarms:
    """
    Watches the counts of a driver.

    Parameters
    ----------
    settings
        The talker and the instrument that the user chose.

    Attributes
    ----------
    panel : AlarmPanel
        The alarms.

    """

    def __init__(self, node: Node, health: Health, settings: DriverSettings) -> None:
        self._watch = SentenceWatch(settings.talker, settings.takes_several)
        self.panel = AlarmPanel(node, health, SENTENCE_RULES)

    def look(self, counts: Mapping[str, int], headings: int, decoder: NmeaDecoder) -> None:
        """Look at the counts of source and decoder; call it once a second."""
        counts = {**counts, SENDER_CHANGES: decoder.senders.n_changes,
                  LATE_REPEATS: decoder.numbers.n_late}
        self.panel.update(self._watch.look(counts, headings, time.monotonic(),
                                           decoder.senders.names), time.time_ns())
