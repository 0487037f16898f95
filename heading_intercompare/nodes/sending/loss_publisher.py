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

"""The topic beside the headings that says which readings their source lost or rejected."""

from __future__ import annotations

from collections import Counter
from typing import Mapping

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from heading_intercompare.core.records import Headings, Losses
from heading_intercompare.messages.ledger_messages import encode_losses, lost_topic
from heading_intercompare.nodes.interface import qos


class LossPublisher:
    """
    Publishes what was lost before the headings of a topic.

    Parameters
    ----------
    node
        The node that publishes the headings.
    heading_topic
        Full name of the topic of the headings.

    """

    def __init__(self, node: Node, heading_topic: str) -> None:
        self._publisher = node.create_publisher(DiagnosticArray, lost_topic(heading_topic),
                                                qos.LOST)
        self._told: Counter[str] = Counter()
        self._counts: Counter[str] = Counter()
        self._newest_ns = 0

    def count(self, counts: Mapping[str, int], headings: Headings) -> None:
        """
        Publish what was lost before some headings.

        Parameters
        ----------
        counts
            How many readings were lost so far, by one of `LOST_AS`.
        headings
            The next headings; without any, the losses wait.

        """
        self._counts = Counter(counts)
        if len(headings):
            self._tell(int(headings.stamp_ns[0]))
            self._newest_ns = int(headings.stamp_ns[-1])

    def end(self) -> None:
        """Publish what was lost after the last heading."""
        if self._newest_ns:
            self._tell(self._newest_ns)

    def _tell(self, stamp_ns: int) -> None:
        new = {lost_as: Losses.of([stamp_ns], [self._newest_ns], [count])
               for lost_as, n in self._counts.items() if (count := n - self._told[lost_as])}
        self._told = self._counts
        if new:
            self.publish(encode_losses(new))

    def publish(self, message: bytes) -> None:
        """Publish a message of `encode_losses`."""
        self._publisher.publish(message)
