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

"""The fixture of the nodes; without ROS this folder is skipped, not broken."""

from __future__ import annotations

from importlib.util import find_spec
import os

import pytest

collect_ignore_glob = [] if find_spec('rclpy') else ['*.py']


@pytest.fixture(params=['quick', 'rclpy'])
def either_executor(request, monkeypatch):
    """Run a test twice: all nodes have the one executor, then the other."""
    from heading_intercompare.nodes.spinning.executors import EXECUTOR

    monkeypatch.setenv(EXECUTOR, request.param)


@pytest.fixture
def ros():
    """Return the nodes of this test."""
    from nodes.ros_nodes import Ros

    assert os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] == 'OFF'
    made = Ros()
    yield made
    made.close()
