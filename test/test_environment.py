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

"""The tests set their own environment: what the user's graph needs does not disturb them."""

from __future__ import annotations

import os
from pathlib import Path
import re
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


PLUGIN = """
import importlib.util

def pytest_pycollect_makemodule(module_path, parent):
    if module_path.name.startswith('test_'):
        spec = importlib.util.spec_from_file_location(module_path.stem, module_path)
        spec.loader.exec_module(importlib.util.module_from_spec(spec))
"""


@pytest.mark.process
@pytest.mark.slow
@pytest.mark.endurance
def test_the_tests_can_be_loaded_one_by_one_from_their_files(tmp_path):
    """As launch_testing does where it is installed: by then a file belongs to no package."""
    (tmp_path / 'loads_by_path.py').write_text(PLUGIN, 'utf-8')
    done = subprocess.run(
        [sys.executable, '-m', 'pytest', '-q', '-p', 'no:cacheprovider', '-p', 'no:xdist', '-p',
         'loads_by_path', '--collect-only', 'test/nodes', 'test/bags', 'test/core/motion',
         'test/logbook', 'test/drivers'], cwd=ROOT,
        env={**os.environ, 'PYTHONPATH': os.pathsep.join(
            [str(tmp_path), os.environ.get('PYTHONPATH', '')])},
        capture_output=True, text=True, timeout=500.0)
    assert done.returncode == 0, done.stdout[-4000:]


@pytest.mark.slow
@pytest.mark.process
def test_two_workers_at_most_run_the_tests_of_nodes():
    """Spread over all, they wait for processors, and each other, until deadlines pass."""
    found = subprocess.run(
        [sys.executable, '-m', 'pytest', '--numprocesses', '3', '--dist', 'loadscope',
         '--no-loadscope-reorder', '-v', '-p', 'no:cacheprovider',
         'test/nodes/interface/test_places.py', 'test/nodes/taking/test_renewal.py',
         'test/nodes/taking/test_reception.py', 'test/core/test_angles.py'], cwd=ROOT,
        capture_output=True, text=True, timeout=300.0,
        env={name: value for name, value in os.environ.items()
             if not name.startswith('PYTEST_XDIST')})
    assert found.returncode == 0, found.stdout
    workers = {}
    for worker, module in re.findall(r'^\[(gw\d)\].*PASSED test/([^:]*)::', found.stdout,
                                     re.MULTILINE):
        workers.setdefault(module, set()).add(worker)
    assert workers.pop('core/test_angles.py') == {'gw2'}
    assert len(workers) == 3 and set.union(*workers.values()) == {'gw0', 'gw1'}
    assert all(len(those) == 1 for those in workers.values())
