# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Message types of packages that may not be there."""

from __future__ import annotations

import sys
from types import ModuleType

import pytest
from sensor_msgs.msg import Imu

from heading_intercompare.core.settings import SettingsError
from heading_intercompare.messages.heading_messages import AZIMUTH_TYPES, HEADING_TYPES as KNOWN
from heading_intercompare.nodes.ros import message_types
from heading_intercompare.nodes.ros.message_types import find_azimuth_types, find_heading_type


def test_azimuths_are_taken_where_their_package_is_installed(monkeypatch):
    package, module = ModuleType('compass_msgs'), ModuleType('compass_msgs.msg')
    module.Azimuth = type('Azimuth', (), {})
    monkeypatch.setitem(sys.modules, 'compass_msgs', package)
    monkeypatch.setitem(sys.modules, 'compass_msgs.msg', module)
    found = find_azimuth_types()
    assert found['compass_msgs/msg/Azimuth'] is module.Azimuth and {*found} <= {*AZIMUTH_TYPES}


def test_what_is_taken_live_is_read_from_bags():
    assert message_types.HEADING_TYPES.keys() | {*AZIMUTH_TYPES} == {*KNOWN}


def test_a_type_whose_package_is_not_installed_says_what_to_install(monkeypatch):
    monkeypatch.setattr(message_types, 'HEADING_TYPES', {'sensor_msgs/msg/Imu': Imu})
    assert find_heading_type('sensor_msgs/msg/Imu') is Imu
    with pytest.raises(SettingsError, match='need the package compass_msgs: install it, for '
                                            'instance ros-jazzy-compass-msgs'):
        find_heading_type('compass_msgs/msg/Azimuth')
