# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The alarms of a driver: damaged sentences, a second talker, bursts, dropped datagrams."""

from __future__ import annotations

import time
from typing import Mapping

from rclpy.node import Node

from heading_intercompare.core.alarms.sentence_watch import SENTENCE_RULES, SentenceWatch
from heading_intercompare.nodes.runtime.health import Health

from .alarm_panel import AlarmPanel

__all__ = ['SentenceAlarms']


class SentenceAlarms:
    """
    Watches the counts of a driver.

    Parameters
    ----------
    node : Node
    health : Health
    talker : str or None
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
