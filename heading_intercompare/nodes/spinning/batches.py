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

An executor takes none of these messages. It wakes at the first one, or not at all, and a timer of
the node takes all that have arrived. This costs a third of one callback per message, as measured
by `benchmarks/executors.py`.
"""

from __future__ import annotations

from typing import Any, Callable, Mapping

from rclpy.callback_groups import CallbackGroup
from rclpy.node import Node
from rclpy.subscription import Subscription

from heading_intercompare.nodes.spinning.clocks import every

_PERIOD_S = 0.1
#: Fewer messages in a batch are not worth the taking, and more than these need not wait longer.
_FEW, _ENOUGH = 3, 6
_LONGEST_S = 0.2


class Unwatched(CallbackGroup):
    """Leaves the messages of its subscriptions to `take_all`; the executor wakes for none."""

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
    Wakes the executor at the first message, and takes all that have arrived a little later.

    Where few come, such as two topics at 10 Hz, it waits longer, up to 0.2 s: to take, pair and
    judge one message costs about as much as ten.

    Parameters
    ----------
    node
        Has the subscriptions in this group.
    take
        Takes all messages of these subscriptions; also called ten times a second without any.
        Returns how many it took, or None if they are to be taken as soon as ever.
    hold_off_s
        How long to wait for further messages after the first one at least, seconds.

    Attributes
    ----------
    gathering : bool
        A message has arrived since the last call of `take`.

    """

    def __init__(self, node: Node, take: Callable[[], int | None], hold_off_s: float) -> None:
        super().__init__()
        self._take, self._hold_off_s, self._least_s = take, hold_off_s, hold_off_s
        self._pause_s = max(hold_off_s, _PERIOD_S)
        self.gathering = False
        self._timer = every(node, self._pause_s, self._end_batch)

    def can_execute(self, entity: Any) -> bool:
        """Tell the executor whether to wake for a message: for the first one of a batch."""
        return not self.gathering

    def beginning_execution(self, entity: Any) -> bool:
        """Begin a batch; return False, so the executor leaves the message where it is."""
        if not self.gathering:
            self.gathering = True
            self._wait(self._hold_off_s)
        return False

    def _wait(self, seconds: float) -> None:
        self._timer.timer_period_ns = round(1e9 * seconds)
        self._timer.reset()

    def _end_batch(self) -> None:
        gathered, self.gathering = self.gathering, False
        if gathered:
            self._wait(self._pause_s)
        n = self._take()
        if gathered and n is not None:
            if n < _FEW:
                self._hold_off_s = min(2.0 * self._hold_off_s, max(_LONGEST_S, self._least_s))
            elif n >= _ENOUGH:
                self._hold_off_s = max(0.5 * self._hold_off_s, self._least_s)


def take_all(subscription: Subscription) -> list[tuple[Any, Mapping[str, int]]]:
    """Return the messages that have arrived, raw or not, each with its info."""
    messages = []
    with subscription.handle:
        while (message := subscription.handle.take_message(subscription.msg_type,
                                                           subscription.raw)) is not None:
            messages.append(message)
    return messages
