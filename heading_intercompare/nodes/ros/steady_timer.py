# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Timers that keep running when simulated time stands still."""

from __future__ import annotations

from typing import Callable

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.timer import Timer

__all__ = ['every']


def every(node: Node, period_s: float, callback: Callable[[], None]) -> Timer:
    """Return a timer of the node on the steady clock."""
    return node.create_timer(period_s, callback, clock=Clock(clock_type=ClockType.STEADY_TIME))
