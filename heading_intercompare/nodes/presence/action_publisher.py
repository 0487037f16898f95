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

"""What operators did with a node: to its log, to the recorder and to the verdict."""

from __future__ import annotations

import time

from rclpy.node import Node
from std_msgs.msg import String

from heading_intercompare.bags.rosbag2.provenance import ACTION_TOPIC, time_text
from heading_intercompare.messages.authors import sign_text
from heading_intercompare.messages.status_messages import encode_text
from heading_intercompare.nodes.interface import qos

from .health import Health


class ActionPublisher:
    """
    Publishes each action of an operator as a note with its time and author, and logs it.

    Parameters
    ----------
    node, health
        The node, and its state.

    """

    def __init__(self, node: Node, health: Health) -> None:
        self._health = health
        self._publisher = node.create_publisher(String, ACTION_TOPIC, qos.ACTION)

    def publish(self, words: str, operator: str = '', *, warn: bool = False) -> None:
        """Say in words what an operator did; an empty name is that of an unknown one."""
        text, logger = sign_text(words, operator), self._health.logger
        if warn:
            logger.warning(text)
        else:
            logger.info(text)
        self._publisher.publish(encode_text(
            f'{time_text(time.time_ns())} {self._health.name}: {text}'))
