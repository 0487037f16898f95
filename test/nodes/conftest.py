# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The fixture of the nodes; without ROS this folder is skipped, not broken."""

from __future__ import annotations

from importlib.util import find_spec
import os

import pytest

collect_ignore_glob = [] if find_spec('rclpy') else ['*.py']


@pytest.fixture
def ros():
    """Return the nodes of this test."""
    from nodes.ros_nodes import Ros

    assert os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] == 'OFF'
    made = Ros()
    yield made
    made.close()
