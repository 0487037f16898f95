# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Taking messages in batches.

The executor does not wake for these messages; a timer of the node takes those that have arrived.
This costs a third of one callback per message, as measured by `benchmarks/executors.py`.
"""

from __future__ import annotations

from typing import Any, Mapping

from rclpy.callback_groups import CallbackGroup
from rclpy.subscription import Subscription

__all__ = ['take_all', 'Unwatched']


class Unwatched(CallbackGroup):
    """Keeps its subscriptions out of the wait set: the executor does not wake for a message."""

    def can_execute(self, entity: Any) -> bool:
        """Return False: the executor never takes messages from these subscriptions."""
        return False

    def beginning_execution(self, entity: Any) -> bool:
        """Return False, like `can_execute`."""
        return False

    def ending_execution(self, entity: Any) -> None:
        """Do nothing: no execution ever begins."""


def take_all(subscription: Subscription) -> list[tuple[Any, Mapping[str, int]]]:
    """Return the messages that have arrived, raw or not, each with its info."""
    taken = []
    with subscription.handle:
        while (one := subscription.handle.take_message(subscription.msg_type,
                                                       subscription.raw)) is not None:
            taken.append(one)
    return taken
