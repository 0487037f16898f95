# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Subscriptions to single messages: bytes are read, acted on, or refused and counted."""

from __future__ import annotations

from typing import Callable, TypeVar

from rclpy.node import Node
from rclpy.qos import QoSProfile

from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.status_messages import WARN

from .health import Health

__all__ = ['subscribe']

_Read = TypeVar('_Read')


def subscribe(node: Node, kind: type, topic: str, profile: QoSProfile, health: Health,
              read: Callable[[bytes], _Read], act: Callable[[_Read], None]) -> None:
    """
    Have messages read and acted on; those that cannot be read are counted in the health.

    Parameters
    ----------
    node : Node
        Who takes them.
    kind : type
        Of the messages.
    topic : str
        Relative or absolute name.
    profile : QoSProfile
        Of the subscription.
    health : Health
        Where a refusal or a QoS mismatch is shown.
    read : callable
        Makes something of the bytes of a message, or raises MessageError.
    act : callable
        Given what was read.

    """
    refused = 0

    def take(data: bytes) -> None:
        nonlocal refused
        try:
            found = read(data)
        except MessageError as error:
            refused += 1
            health.note(topic, WARN, f'{refused} messages refused: {error}', latch=True)
        else:
            act(found)
    node.create_subscription(kind, topic, take, profile, raw=True,
                             event_callbacks=health.of_subscription(topic))
