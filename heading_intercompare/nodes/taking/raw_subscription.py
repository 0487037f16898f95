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

"""Subscriptions to single messages: read the bytes and act on them, or reject and count them."""

from __future__ import annotations

from typing import Callable, TypeVar

from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.status_messages import WARN
from heading_intercompare.nodes.presence.health import Health

_Read = TypeVar('_Read')


def subscribe(node: Node, kind: type, topic: str, profile: QoSProfile, health: Health,
              read: Callable[[bytes], _Read], act: Callable[[_Read], None]) -> Subscription:
    """
    Subscribe to a topic; read each message and act on it, or count it as rejected; return it.

    Parameters
    ----------
    node
        The node that subscribes.
    kind
        Type of the messages.
    topic
        Relative or absolute name.
    profile
        Quality of service of the subscription.
    health
        Shows rejected messages and QoS mismatches.
    read
        Decodes the bytes of a message, or raises MessageError.
    act
        Called with the decoded message.

    """
    refused = 0

    def take(data: bytes) -> None:
        nonlocal refused
        try:
            message = read(data)
        except MessageError as error:
            refused += 1
            health.note(topic, WARN, f'{refused} messages refused: {error}', latch=True)
        else:
            act(message)
    return node.create_subscription(kind, topic, take, profile, raw=True,
                                    event_callbacks=health.of_subscription(topic))
