# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""What a synchronizer that was killed had taken, as the compliance node tells its successor."""

from __future__ import annotations

from typing import Mapping

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from heading_intercompare.core.pairing.ledger import LedgerKey
from heading_intercompare.messages.ledger_messages import decode_ledger, LedgerMessage
from heading_intercompare.nodes.ros import qos
from heading_intercompare.nodes.runtime.health import Health

from .intake import Intake
from .raw_subscription import subscribe

__all__ = ['LEDGER_TAKEN_TOPIC', 'Predecessor']

LEDGER_TAKEN_TOPIC = 'compliance/ledger_taken'


class Predecessor:
    """
    Lets a synchronizer go on where the one before it was killed.

    Parameters
    ----------
    node : Node
        The synchronizer.
    health : Health
        Shows messages that cannot be read.
    intakes : mapping of str to Intake
        The headings, by sensor.

    """

    def __init__(self, node: Node, health: Health, intakes: Mapping[str, Intake]) -> None:
        self._node, self._intakes, self._told = node, intakes, False
        subscribe(node, DiagnosticArray, LEDGER_TAKEN_TOPIC, qos.LEDGER_TAKEN, health,
                  decode_ledger, self._take)

    @property
    def is_known(self) -> bool:
        """Whether the compliance node has said what it knows, or there is none."""
        return self._told or not self._node.count_publishers(LEDGER_TAKEN_TOPIC)

    def _take(self, newest: LedgerMessage) -> None:
        """Take the first message; later ones are about this synchronizer."""
        if self._told:
            return
        self._told = True
        if not newest.final:
            for stream, numbers in newest.numbers.items():
                # What waited for a partner is taken again.
                waited = newest.ledger.total.counts.get(LedgerKey.of_pending(stream), 0)
                self._intakes[stream].resume_after(numbers.last_publisher, numbers.last - waited)
