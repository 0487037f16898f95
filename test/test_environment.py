# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The tests set their own environment: what the user's graph needs does not disturb them."""

from __future__ import annotations

import os
from pathlib import Path
import subprocess
import sys

import pytest

pytest.importorskip('rclpy')

ROOT = Path(__file__).resolve().parent.parent
#: As on a ship where ROS runs: another domain, others' peers, words of the log in another form.
FOREIGN = {
    'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET', 'ROS_DOMAIN_ID': '7', 'ROS_LOCALHOST_ONLY': '1',
    'ROS_STATIC_PEERS': '127.0.0.1', 'FASTDDS_BUILTIN_TRANSPORTS': 'LARGE_DATA',
    'FASTRTPS_DEFAULT_PROFILES_FILE': '/nowhere.xml', 'ROS_DISCOVERY_SERVER': '127.0.0.1:11811',
    'RCUTILS_CONSOLE_OUTPUT_FORMAT': '{message}', 'RCUTILS_COLORIZED_OUTPUT': '1',
    'ROS_NAMESPACE': '/mine', 'CI': '', 'PYTEST_XDIST_WORKER': 'gw0'}


@pytest.mark.process
@pytest.mark.slow
def test_tests_of_nodes_pass_in_the_environment_of_a_user():
    """Those of the node that hears the whole graph."""
    done = subprocess.run(
        [sys.executable, '-m', 'pytest', '-q', '-p', 'no:cacheprovider', '-p', 'no:xdist',
         'test/nodes/test_watcher.py'], cwd=ROOT,
        env={**os.environ, **FOREIGN}, capture_output=True, text=True, timeout=500.0)
    assert done.returncode == 0, done.stdout[-4000:]
