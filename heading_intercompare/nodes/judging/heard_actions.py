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

"""What operators did while the nodes ran, for the verdict."""

from __future__ import annotations

import time

from rclpy.node import Node
from std_msgs.msg import String

from heading_intercompare.bags.rosbag2.provenance import ACTION_TOPIC, Notes
from heading_intercompare.core.verdict.verdict_document import OperatorNote
from heading_intercompare.messages.status_messages import decode_text
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.taking.raw_subscription import subscribe


class HeardActions:
    """
    The actions that all nodes of a graph have published.

    Attributes
    ----------
    notes : tuple of OperatorNote
        In the order in which they came; at most a thousand.

    """

    def __init__(self, node: Node, health: Health) -> None:
        self.notes: tuple[OperatorNote, ...] = ()
        self._bounded = Notes(lambda name, mapping: None)
        subscribe(node, String, ACTION_TOPIC, qos.ACTION, health, decode_text, self._take)

    def _take(self, text: str) -> None:
        self.notes += tuple(OperatorNote(note.stamp_ns, note.text)
                            for note in self._bounded.add(text, time.time_ns()))
