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

"""
Taking messages in batches.

An executor of rclpy does not wake for these messages; a timer of the node takes those that have
arrived. This costs a third of one callback per message, as measured by `benchmarks/executors.py`.
A `QuickExecutor` takes them sooner: it wakes at the first message and waits a little for others.
"""

from __future__ import annotations

import math
import time
from typing import Any, Callable, Mapping

from rclpy.callback_groups import CallbackGroup
from rclpy.node import Node
from rclpy.subscription import Subscription

from .steady_timer import every

_PERIOD_S = 0.1


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


class Arrivals(Unwatched):
    """
    Says to a `QuickExecutor` what to do when a message arrives; to others it is `Unwatched`.

    Parameters
    ----------
    node
        Has the subscriptions in this group.
    take
        Takes all messages of these subscriptions; also called ten times a second without any.
    hold_off_s
        How long to wait for further messages after the first one, seconds.

    Attributes
    ----------
    due_s : float
        When to take them, by the steady clock; infinite while none has arrived.

    """

    def __init__(self, node: Node, take: Callable[[], None], hold_off_s: float) -> None:
        super().__init__()
        self.take, self._hold_off_s = take, hold_off_s
        self.due_s = math.inf
        every(node, max(hold_off_s, _PERIOD_S), self._tick)

    def note(self, now_s: float) -> None:
        """Note that the first message of a batch has arrived."""
        self.due_s = now_s + self._hold_off_s

    def _tick(self) -> None:
        # The executor forgets a batch whose subscription is gone before it is due.
        if self.due_s == math.inf or self.due_s <= time.monotonic():
            self.due_s = math.inf
            self.take()


def take_all(subscription: Subscription) -> list[tuple[Any, Mapping[str, int]]]:
    """Return the messages that have arrived, raw or not, each with its info."""
    messages = []
    with subscription.handle:
        while (message := subscription.handle.take_message(subscription.msg_type,
                                                           subscription.raw)) is not None:
            messages.append(message)
    return messages
