# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Message types of rclpy by name, to create topics with; the messages pass as bytes."""

from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import (
    PoseWithCovarianceStamped,
    QuaternionStamped,
    TwistStamped,
    TwistWithCovarianceStamped,
)
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu, NavSatFix
from std_msgs.msg import String

__all__ = ['HEADING_TYPES', 'MOTION_TYPES', 'PAIRS_TYPES', 'STATUS_TYPES', 'TEXT_TYPES',
           'TRUTH_TYPES']

TRUTH_TYPES = {'sensor_msgs/msg/Imu': Imu}

HEADING_TYPES = {
    **TRUTH_TYPES,
    'geometry_msgs/msg/QuaternionStamped': QuaternionStamped,
    'geometry_msgs/msg/PoseWithCovarianceStamped': PoseWithCovarianceStamped,
    'nav_msgs/msg/Odometry': Odometry,
}
"""The types that headings can have."""

_VELOCITY_TYPES = {'geometry_msgs/msg/TwistStamped': TwistStamped,
                   'geometry_msgs/msg/TwistWithCovarianceStamped': TwistWithCovarianceStamped}

MOTION_TYPES = {'fix': {'sensor_msgs/msg/NavSatFix': NavSatFix}, 'velocity': _VELOCITY_TYPES,
                'rate': {**_VELOCITY_TYPES, 'sensor_msgs/msg/Imu': Imu}}
"""The types that the motion of the ship can have, by what it tells."""

PAIRS_TYPES = {'geometry_msgs/msg/TwistStamped': TwistStamped}

STATUS_TYPES = {'diagnostic_msgs/msg/DiagnosticArray': DiagnosticArray}

TEXT_TYPES = {'std_msgs/msg/String': String}
