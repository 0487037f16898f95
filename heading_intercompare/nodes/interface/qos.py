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

"""Quality of service of every topic, the same as in the table of the documentation."""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy


def _keep_last(depth: int) -> QoSProfile:
    """Return a reliable profile whose last messages also reach late subscribers."""
    return QoSProfile(depth=depth, durability=DurabilityPolicy.TRANSIENT_LOCAL)


#: Fast DDS keeps no more; where a profile asks for more, a full subscription stops for ever.
_MOST = 5000

# Kept for subscribers that a cut network keeps away: 50 s at 100 Hz.
HEADINGS_OUT = _keep_last(_MOST)
# A first subscription, which begins with the newest heading, and the one that takes over.
HEADINGS_IN = QoSProfile(depth=_MOST)
HEADINGS_KEPT = _keep_last(_MOST)
# For publishers that do not send again what is lost.
HEADINGS_UNRELIABLE = QoSProfile(depth=_MOST, reliability=ReliabilityPolicy.BEST_EFFORT)
# A compliance node that was killed gets again what it missed.
PAIRS = _keep_last(_MOST)
PAIRS_TAKEN = QoSProfile(depth=_MOST)
LEDGER = QoSProfile(depth=10)
LOST = QoSProfile(depth=1000)
STATUS = QoSProfile(depth=10)
# All nodes of a ship may say their state within one batch.
DIAGNOSTICS_IN = QoSProfile(depth=1000)
MARKER = _keep_last(100)
# Any reliable publisher will do, including `ros2 topic pub`.
NOTE = QoSProfile(depth=10)
ACTION = _keep_last(100)
# Verdicts, alarms and the state of several sensors: the newest message holds all there is to know,
# so a late subscriber gets that alone. A subscription keeps one from each of many publishers.
STATE = _keep_last(1)
STATE_IN = _keep_last(100)
ACKNOWLEDGE = QoSProfile(depth=10)
REPORT = _keep_last(10)
# Best effort, as rosbag2 publishes it; a reliable subscription would receive nothing.
CLOCK = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
