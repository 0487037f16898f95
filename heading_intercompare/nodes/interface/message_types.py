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

from functools import lru_cache
from importlib import import_module
from typing import Any, Iterable, Mapping

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
from heading_intercompare.messages.heading_messages import AZIMUTH_TYPES
from heading_intercompare.messages.heading_places import HeadingPlace
from heading_intercompare.messages.sentence_messages import SENTENCE

TRUTH_TYPES = {'sensor_msgs/msg/Imu': Imu}


def _load_type(name: str) -> type | None:
    """Return a message type by its name; None if its package is not installed."""
    package, _, kind = name.partition('/msg/')
    if not package.isidentifier():
        return None
    try:
        return getattr(import_module(f'{package}.msg'), kind, None)
    except ImportError:
        return None


def find_optional_types() -> dict[str, type]:
    """Return the types of headings from other packages that are installed, by name."""
    return {name: message_type for name in (*AZIMUTH_TYPES, SENTENCE)
            if (message_type := _load_type(name)) is not None}


HEADING_TYPES: dict[str, type] = {
    **TRUTH_TYPES,
    'geometry_msgs/msg/QuaternionStamped': QuaternionStamped,
    'geometry_msgs/msg/PoseWithCovarianceStamped': PoseWithCovarianceStamped,
    'nav_msgs/msg/Odometry': Odometry,
    **find_optional_types(),
}
"""The types that headings can have here."""


def find_heading_type(name: str, types: Mapping[str, type] | None = None) -> type:
    """Return one of the types of headings; SettingsError if its package is not installed."""
    types = HEADING_TYPES if types is None else types
    if name not in types:
        raise SettingsError(need_package(name))
    return types[name]


def need_package(name: str) -> str:
    """Return in words which package the messages of a type need."""
    package = name.partition('/')[0]
    return (f'messages of the type {name} need the package {package}: install it, for instance '
            f'ros-jazzy-{package.replace("_", "-")}')


class InstalledTypes(dict[str, type]):
    """All message types whose packages are installed; holds those that were asked for."""

    def __contains__(self, name: object) -> bool:
        """Tell whether a type is installed."""
        if not super().__contains__(name) and isinstance(name, str):
            message_type = _load_type(name)
            if message_type is not None:
                self[name] = message_type
        return super().__contains__(name)


def list_heading_types(place: HeadingPlace) -> dict[str, type]:
    """Return the types that messages with headings can have; any where a part is named."""
    return InstalledTypes() if place.part else HEADING_TYPES


@lru_cache(maxsize=None)
def begins_with_header(message_type: Any) -> bool:
    """Tell whether the messages of a type begin with a header, whose stamp they have."""
    return [*message_type.get_fields_and_field_types().values()][:1] == ['std_msgs/Header']


def explain_absence(names: Iterable[str], types: Mapping[str, type]) -> str:
    """Return in words which package some types need that are not among others; '' for none."""
    could_be = [name for name in sorted(names) if isinstance(types, InstalledTypes)
                or types is HEADING_TYPES and name in (*AZIMUTH_TYPES, SENTENCE)]
    return need_package(could_be[0]) if could_be else ''


_VELOCITY_TYPES = {'geometry_msgs/msg/TwistStamped': TwistStamped,
                   'geometry_msgs/msg/TwistWithCovarianceStamped': TwistWithCovarianceStamped}

MOTION_TYPES = {'fix': {'sensor_msgs/msg/NavSatFix': NavSatFix}, 'velocity': _VELOCITY_TYPES,
                'rate': {**_VELOCITY_TYPES, 'sensor_msgs/msg/Imu': Imu}}
"""The types that the motion of the ship can have, by what it tells."""

PAIRS_TYPES = {'geometry_msgs/msg/TwistStamped': TwistStamped}

STATUS_TYPES = {'diagnostic_msgs/msg/DiagnosticArray': DiagnosticArray}

TEXT_TYPES = {'std_msgs/msg/String': String}
