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

"""What a synchronizer that was killed had taken, as the compliance node tells its successor."""

from __future__ import annotations

import math
import time
from typing import Mapping

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from heading_intercompare.core.pairing.ledger import LedgerKey
from heading_intercompare.messages.ledger_messages import decode_ledger, LedgerMessage
from heading_intercompare.nodes.ros import qos
from heading_intercompare.nodes.ros.endpoints import is_named
from heading_intercompare.nodes.ros.health import Health
from heading_intercompare.nodes.ros.transports import DISCOVERY_S, is_alone

from .intake import Intake
from .raw_subscription import subscribe

LEDGER_TAKEN_TOPIC = 'compliance/ledger_taken'

# Of its publishers some may be found later than others, by two lost packets.
_FOUND_S = 2 * DISCOVERY_S


class Predecessor:
    """
    Lets a synchronizer go on where the one before it was killed.

    Parameters
    ----------
    node
        The synchronizer.
    health
        Shows messages that cannot be read.
    intakes
        The headings, by sensor; not open yet.
    started_ns
        When this synchronizer was started, UTC ns.
    pairs
        Full name of the topic that the compliance node subscribes to.

    Notes
    -----
    DDS finds the subscriptions of a node and its publishers on different ways. Where a packet is
    lost, the publishers come 3 s later. Until then a compliance node is among the subscribers of
    the pairs, but without a name, or with a name and without all of its publishers.

    """

    def __init__(self, node: Node, health: Health, intakes: Mapping[str, Intake],
                 started_ns: int, pairs: str) -> None:
        self._node, self._intakes, self._started_ns = node, intakes, started_ns
        self._pairs, self._found_s = pairs, 0.0 if is_alone() else _FOUND_S
        self._told = False
        self._asked_s = math.inf
        subscribe(node, DiagnosticArray, LEDGER_TAKEN_TOPIC, qos.LEDGER_TAKEN, health,
                  decode_ledger, self._take)

    def is_known(self) -> bool:
        """Tell whether the compliance node has said what it knows, or there is none."""
        if self._told:
            return True
        now_s = time.monotonic()
        subscriptions = self._node.get_subscriptions_info_by_topic(self._pairs)
        self._asked_s = (min(self._asked_s, now_s) if all(map(is_named, subscriptions))
                         else math.inf)
        return (now_s > self._asked_s + self._found_s
                and not self._node.count_publishers(LEDGER_TAKEN_TOPIC))

    def _take(self, newest: LedgerMessage) -> None:
        """Take what is known so far; the last ledger may come late."""
        self._told = True
        if newest.final or newest.started_ns == self._started_ns:
            return
        for stream, numbers in newest.numbers.items():
            if not self._intakes[stream].open:
                # What waited for a partner is taken again.
                waited = newest.ledger.total.counts.get(LedgerKey.of_pending(stream), 0)
                self._intakes[stream].resume_after(numbers.last_publisher, numbers.last - waited)
