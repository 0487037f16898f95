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

"""The topic beside the headings that says what their sensor says of them."""

from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
from rclpy.node import Node

from heading_intercompare.core.records import Integers, Quality, Reals
from heading_intercompare.messages.quality_messages import quality_messages, quality_topic
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.presence.health import Health


class QualityPublisher:
    """
    Publishes what a sensor says of its readings.

    Parameters
    ----------
    node, health
        The node that publishes the headings, and its state.
    heading_topic
        Full name of the topic of the headings.

    Attributes
    ----------
    publisher : Publisher

    """

    def __init__(self, node: Node, health: Health, heading_topic: str) -> None:
        topic = quality_topic(heading_topic)
        self.publisher = node.create_publisher(DiagnosticArray, topic, qos.HEADINGS_OUT,
                                               event_callbacks=health.of_publisher(topic))
        self._waiting = self._rows = Quality.empty()

    def take(self, quality: Quality) -> None:
        """Take rows; they wait for `publish`, and for the claims of their readings."""
        if len(quality):
            self._waiting, self._rows = self._waiting + quality, self._rows + quality

    def publish(self) -> None:
        """Publish the rows that wait; call it before their readings are published."""
        waiting, self._waiting = self._waiting, Quality.empty()
        for message in quality_messages(waiting):
            self.publisher.publish(message)

    def claims_deg(self, stamp_ns: Integers) -> Reals:
        """
        Return the standard deviation that the sensor claims for its next readings.

        Parameters
        ----------
        stamp_ns : ndarray of int64, shape (n,)
            Stamps of the readings, n >= 1; in the next call they are later.

        Returns
        -------
        ndarray, shape (n,)
            Degrees; 0 without a claim.

        """
        rows = self._rows
        _, stated_deg = rows.match(stamp_ns)
        is_past = rows.stamp_ns <= stamp_ns[-1]
        # The newest of these may be what holds for the next reading.
        past = rows[is_past]
        self._rows = past[max(0, len(past) - 1):] + rows[~is_past]
        return np.nan_to_num(stated_deg)
