# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Nanoseconds to message stamps and back."""

from __future__ import annotations

from builtin_interfaces.msg import Time
from rosgraph_msgs.msg import Clock

__all__ = ['clock_message', 'stamp_ns', 'TIME_LIMIT_NS', 'time_message']

TIME_LIMIT_NS = 2 ** 31 * 1_000_000_000
"""No stamp of a ROS message reaches this (January 2038)."""


def stamp_ns(time: Time) -> int:
    """Return a message stamp in nanoseconds."""
    return int(time.sec) * 1_000_000_000 + int(time.nanosec)


def time_message(ns: int) -> Time:
    """Return a stamp, 0 <= ns < `TIME_LIMIT_NS`, as a message."""
    return Time(sec=int(ns // 1_000_000_000), nanosec=int(ns % 1_000_000_000))


def clock_message(ns: int) -> Clock:
    """Return a time as rosgraph_msgs/Clock."""
    return Clock(clock=time_message(ns))
