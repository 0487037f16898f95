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

from heading_intercompare.core.declared_settings import SettingsError

TRUTH_TYPES = {'sensor_msgs/msg/Imu': Imu}


def find_azimuth_types() -> dict[str, type]:
    """Return the types of azimuths whose packages are installed, by name."""
    azimuth_types: dict[str, type] = {}
    try:
        from compass_interfaces.msg import Azimuth
        azimuth_types['compass_interfaces/msg/Azimuth'] = Azimuth
    except ImportError:
        pass
    try:
        from compass_msgs.msg import Azimuth as EarlierAzimuth
        azimuth_types['compass_msgs/msg/Azimuth'] = EarlierAzimuth
    except ImportError:
        pass
    return azimuth_types


HEADING_TYPES: dict[str, type] = {
    **TRUTH_TYPES,
    'geometry_msgs/msg/QuaternionStamped': QuaternionStamped,
    'geometry_msgs/msg/PoseWithCovarianceStamped': PoseWithCovarianceStamped,
    'nav_msgs/msg/Odometry': Odometry,
    **find_azimuth_types(),
}
"""The types that headings can have here."""


def find_heading_type(name: str) -> type:
    """Return the type of headings with a name; SettingsError if its package is not installed."""
    try:
        return HEADING_TYPES[name]
    except KeyError:
        package = name.partition('/')[0]
        raise SettingsError(f'messages of the type {name} need the package {package}: install it, '
                            f'for instance ros-jazzy-{package.replace("_", "-")}') from None


_VELOCITY_TYPES = {'geometry_msgs/msg/TwistStamped': TwistStamped,
                   'geometry_msgs/msg/TwistWithCovarianceStamped': TwistWithCovarianceStamped}

MOTION_TYPES = {'fix': {'sensor_msgs/msg/NavSatFix': NavSatFix}, 'velocity': _VELOCITY_TYPES,
                'rate': {**_VELOCITY_TYPES, 'sensor_msgs/msg/Imu': Imu}}
"""The types that the motion of the ship can have, by what it tells."""

PAIRS_TYPES = {'geometry_msgs/msg/TwistStamped': TwistStamped}

STATUS_TYPES = {'diagnostic_msgs/msg/DiagnosticArray': DiagnosticArray}

TEXT_TYPES = {'std_msgs/msg/String': String}
