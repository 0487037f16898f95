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

"""The clocks of a node: timers on steady time, time in which it runs, stamps of what it says."""

from __future__ import annotations

import time
from typing import Callable

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.timer import Timer

#: A process that runs reads the clock more often than this.
_LONGEST_S = 1.0


def every(node: Node, period_s: float, callback: Callable[[], None]) -> Timer:
    """Return a timer of the node on the steady clock."""
    return node.create_timer(period_s, callback, clock=Clock(clock_type=ClockType.STEADY_TIME))


def stamp_or_now(node: Node, stamp_ns: int | None) -> int:
    """Return the stamp of data; before the first data the time of the node. Nanoseconds."""
    return node.get_clock().now().nanoseconds if stamp_ns is None else stamp_ns


class AwakeClock:
    """
    Counts the time in which this process runs, seconds.

    A process that was stopped, or starved, finds later what came in the meantime. Nothing that
    waits may be given up before it has been looked for.

    Parameters
    ----------
    since_s
        Goes on after this time, seconds.

    """

    def __init__(self, since_s: float = 0.0) -> None:
        self._read_s, self._awake_s = time.monotonic(), since_s

    def now_s(self) -> float:
        """Return the time so far; each step counts for at most a second."""
        now_s = time.monotonic()
        self._awake_s += min(now_s - self._read_s, _LONGEST_S)
        self._read_s = now_s
        return self._awake_s
