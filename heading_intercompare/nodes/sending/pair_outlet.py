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

"""Publishing of the pairs of a tested sensor, and of the ledger of all its readings."""

from __future__ import annotations

from typing import Mapping

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
from rclpy.node import Node

from heading_intercompare.core.pairing.incarnations import StreamNumbers
from heading_intercompare.core.pairing.pair_maker import PairMaker
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.sensors.pair_names import Names, TWO
from heading_intercompare.messages.heading_messages import pair_messages
from heading_intercompare.messages.ledger_messages import encode_ledger
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.presence.endpoints import count_subscribed
from heading_intercompare.nodes.presence.health import Health

from .publishing import await_acknowledgement, Backlog

# A subscriber of the pairs that hangs holds up the others no longer than this.
_PATIENCE_S = 10.0


class PairOutlet:
    """
    Publishes pairs and ledger.

    Parameters
    ----------
    node, health
        The node that pairs, and its state.
    topic
        Of the pairs; that of the ledger is beside it.
    names
        The sensors.
    maker
        Pairs their readings.
    started_ns
        When the trial began, UTC ns: it names the pairs.

    """

    def __init__(self, node: Node, health: Health, topic: str, names: Names, maker: PairMaker,
                 started_ns: int) -> None:
        self._node, self._names, self._maker = node, names, maker
        self._started_ns, self._owner = started_ns, health.owner
        self._pairs = node.create_publisher(TwistStamped, topic, qos.PAIRS,
                                            event_callbacks=health.of_publisher(topic))
        self._ledger = node.create_publisher(DiagnosticArray, f'{topic}/ledger', qos.LEDGER)
        self._waiting = Backlog(self._pairs, health, patience_s=_PATIENCE_S)

    def add(self, pairs: Pairs) -> None:
        """Add pairs to those that are to be published."""
        for part in pairs.in_segments():
            segment = int(part.segment[0])
            self._waiting.add(pair_messages(part, f'{self._started_ns}/{segment}' if segment
                                            else str(self._started_ns)))

    def publish(self) -> None:
        """Publish the pairs for which their subscribers have room."""
        self._waiting.publish()

    @property
    def n_waiting(self) -> int:
        """Return how many pairs are still to be published."""
        return len(self._waiting)

    def publish_ledger(self, numbers: Mapping[str, StreamNumbers], *, final: bool) -> None:
        """Publish the ledger, given the numbers of the readings so far by sensor."""
        self._ledger.publish(encode_ledger(
            self._maker.pairer.ledger, final, self._started_ns,
            {stream: numbers[name] for stream, name in zip(TWO, self._names)}, self._owner))

    def is_heard(self, subscribers: int) -> bool:
        """Tell whether the pairs have this number of subscribers."""
        return count_subscribed(self._node, self._pairs) >= subscribers

    def close(self) -> None:
        """Wait until all has been received."""
        await_acknowledgement([self._pairs, self._ledger])
