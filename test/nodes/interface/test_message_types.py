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

"""Message types of packages that may not be there."""

from __future__ import annotations

import sys
from types import ModuleType

from geometry_msgs.msg import PointStamped
import pytest
from sensor_msgs.msg import Imu

from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.messages.heading_messages import AZIMUTH_TYPES
from heading_intercompare.messages.heading_places import locate_headings
from heading_intercompare.messages.sentence_messages import SENTENCE, TOPIC_TYPES
from heading_intercompare.nodes.interface import message_types
from heading_intercompare.nodes.interface.message_types import (
    find_heading_type,
    find_optional_types,
    list_heading_types,
)


def test_azimuths_are_taken_where_their_package_is_installed(monkeypatch):
    package, module = ModuleType('compass_msgs'), ModuleType('compass_msgs.msg')
    module.Azimuth = type('Azimuth', (), {})
    monkeypatch.setitem(sys.modules, 'compass_msgs', package)
    monkeypatch.setitem(sys.modules, 'compass_msgs.msg', module)
    found = find_optional_types()
    assert found['compass_msgs/msg/Azimuth'] is module.Azimuth
    assert {*found} <= {*AZIMUTH_TYPES, SENTENCE}


def test_what_is_taken_live_is_read_from_bags():
    assert message_types.HEADING_TYPES.keys() | {*AZIMUTH_TYPES, SENTENCE} == {*TOPIC_TYPES}


def test_where_a_part_is_named_any_installed_type_is_taken():
    types = list_heading_types(locate_headings('gps.heading'))
    assert 'geometry_msgs/msg/PointStamped' in types and 'gyro/msg/Absent' not in types
    assert types['geometry_msgs/msg/PointStamped'] is PointStamped
    for absent in ('', 'gyro', '../msg/x', 'sys/msg/path'):
        assert absent not in types


def test_a_type_whose_package_is_not_installed_says_what_to_install(monkeypatch):
    monkeypatch.setattr(message_types, 'HEADING_TYPES', {'sensor_msgs/msg/Imu': Imu})
    assert find_heading_type('sensor_msgs/msg/Imu') is Imu
    with pytest.raises(SettingsError, match='need the package compass_msgs: install it, for '
                                            'instance ros-jazzy-compass-msgs'):
        find_heading_type('compass_msgs/msg/Azimuth')
