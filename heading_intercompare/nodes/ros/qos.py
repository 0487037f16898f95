# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Quality of service of every topic, the same as in the table of the documentation."""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

__all__ = ['CLOCK', 'HEADINGS_IN', 'HEADINGS_OUT', 'LEDGER', 'MARKER', 'NOTE', 'PAIRS', 'REPORT',
           'STATUS', 'VERDICT']


def _keep_last(depth: int) -> QoSProfile:
    """Return a reliable profile whose last messages also reach late subscribers."""
    return QoSProfile(depth=depth, durability=DurabilityPolicy.TRANSIENT_LOCAL)


HEADINGS_OUT = QoSProfile(depth=1000)
# Best effort accepts every publisher and holds up none; losses are counted.
HEADINGS_IN = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
PAIRS = QoSProfile(depth=1000)
LEDGER = QoSProfile(depth=10)
STATUS = QoSProfile(depth=10)
MARKER = _keep_last(100)
# Any reliable publisher will do, including `ros2 topic pub`.
NOTE = QoSProfile(depth=10)
VERDICT = _keep_last(10)
REPORT = _keep_last(10)
# Best effort, as rosbag2 publishes it; a reliable subscription would receive nothing.
CLOCK = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
