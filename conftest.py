# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""What the tests need beside the package: skipped without it, but never where CI is set."""

from __future__ import annotations

from importlib.util import find_spec
import os

import pytest

OPTIONAL = ('rclpy', 'serial', 'hypothesis', 'rosbags', 'mcap_ros2', 'pybag',
            'isal', 'distributed', 'threadpoolctl')
MISSING = [name for name in OPTIONAL if find_spec(name) is None]

# The examples in the docstrings of nodes can only be collected with ROS.
collect_ignore_glob = ['heading_intercompare/nodes/*.py'] if 'rclpy' in MISSING else []
if {'distributed', 'threadpoolctl'} & {*MISSING}:
    collect_ignore_glob.append('heading_intercompare/app/cluster.py')


def pytest_configure():
    """Refuse to run a part of the tests where all of them are asked for."""
    if MISSING and os.environ.get('CI', '').lower() not in ('', '0', 'false'):
        raise pytest.UsageError(f'CI is set and {", ".join(MISSING)} is not installed: '
                                'the tests that need it would be skipped')


def pytest_report_header():
    """Say what is left out."""
    if MISSING:
        return f'not installed, tests that need it are skipped: {", ".join(MISSING)}'
    return 'with ROS'
