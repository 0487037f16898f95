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

"""
Rules for every test: the libraries it needs besides the package, its deadline, its worker.

Tests whose library is not installed are skipped; if CI is set, that is an error.
"""

from __future__ import annotations

from importlib.util import find_spec
import os
from pathlib import Path
import signal

# Before numpy is loaded: the last bits of a sum depend on the number of threads, and two workers
# of pytest-xdist with one thread per core would wait for each other.
for name in ('OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS', 'MKL_NUM_THREADS'):
    os.environ.setdefault(name, '1')
# Seconds for one test, read by pytest-timeout: a test that hangs fails with every thread's stack.
os.environ.setdefault('PYTEST_TIMEOUT', '600')

# A process started in the background or with `nohup` ignores these signals, and so would every
# process that a test starts.
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)

import pytest  # noqa: E402

try:
    from hypothesis import HealthCheck, settings as hypothesis_settings
except ImportError:
    pass
else:
    # A slow machine is not a fault of the code; an endless test meets its own deadline.
    hypothesis_settings.register_profile(
        'quick', max_examples=100, derandomize=True, deadline=None,
        suppress_health_check=[HealthCheck.too_slow])
    hypothesis_settings.register_profile(
        'release', hypothesis_settings.get_profile('quick'), max_examples=3000, derandomize=False)
    hypothesis_settings.load_profile(os.environ.get('HYPOTHESIS_PROFILE', 'quick'))

OPTIONAL = ('rclpy', 'serial', 'hypothesis', 'rosbags', 'pyarrow', 'mcap_ros2', 'pybag',
            'isal', 'numba', 'distributed', 'threadpoolctl', 'jinja2', 'matplotlib',
            'rich', 'argcomplete', 'ephem')
MISSING = [name for name in OPTIONAL if find_spec(name) is None]

# The examples in the docstrings of nodes can only be collected with ROS. The scripts among the
# test data are not collected: they need the sources of their time.
collect_ignore = ['test/data']
collect_ignore_glob = ['heading_intercompare/nodes/*.py'] if 'rclpy' in MISSING else []
if {'distributed', 'threadpoolctl'} & {*MISSING}:
    collect_ignore_glob.append('heading_intercompare/app/cluster.py')
if {'jinja2', 'matplotlib'} & {*MISSING}:
    collect_ignore_glob += [f'heading_intercompare/report/{name}.py'
                            for name in ('html', 'pdf', 'figures/style')]
if 'rosbags' in MISSING:
    collect_ignore_glob.append('heading_intercompare/readers/rosbag_recording.py')
if find_spec('weasyprint') is None:
    collect_ignore_glob.append('heading_intercompare/report/pdf.py')
try:
    # It may be there, and refuse the numpy of Ubuntu 24.04.
    import pyarrow  # noqa: F401
except ImportError:
    collect_ignore_glob.append('heading_intercompare/readers/parquet.py')
if 'ephem' in MISSING:
    collect_ignore_glob.append('heading_intercompare/app/observations/sun.py')
if find_spec('nicegui') is None:
    collect_ignore_glob += [f'heading_intercompare/web/{name}.py' for name in ('page', 'server')]


def pytest_configure():
    """Reject an incomplete environment where every test must run."""
    if MISSING and os.environ.get('CI', '').lower() not in ('', '0', 'false'):
        raise pytest.UsageError(f'CI is set and {", ".join(MISSING)} is not installed: '
                                'the tests that need it would be skipped')


_NODES = 'test/nodes'
#: Modules whose graphs mostly wait for the clock; they run beside those of the others.
_LONG = {f'{_NODES}/test_{name}.py' for name in (
    'alarms_on_the_graph', 'launch', 'months', 'real_logs_over_udp', 'soak', 'soak_with_faults')}


def _group(path: str) -> str:
    """Return the group of tests that share a worker: tests of nodes in two groups, or a module."""
    if path in _LONG:
        return f'{_NODES}, long'
    return _NODES if path.startswith(f'{_NODES}/') else path


def _path(item: pytest.Item) -> str:
    return Path(item.path).relative_to(Path(__file__).parent).as_posix()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Mark the tests that run nodes, before `-m` selects, and begin with them."""
    for item in items:
        if _group(_path(item)).startswith(_NODES):
            item.add_marker('ros')
    # The longest groups begin first, so that no worker is still busy with them at the end.
    items.sort(key=lambda item: not _group(_path(item)).startswith(_NODES))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """
    Give each group of tests to one worker.

    The groups are found from the names of the tests. pytest 9.2 does not know the names that
    pytest-xdist 3.8 makes of its own groups, and spreads the tests of nodes over all workers.
    """
    if config.getvalue('dist') != 'loadgroup':
        return None
    from xdist.scheduler import LoadScopeScheduling

    class ByGroup(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            return _group(nodeid.partition('::')[0])

    return ByGroup(config, log)


_begun = False


def pytest_runtest_setup(item):
    """Let a worker that does not begin with the tests of nodes yield to those that do."""
    global _begun
    if not _begun and 'PYTEST_XDIST_WORKER' in os.environ and not _group(_path(item)).startswith(
            _NODES):
        os.nice(10)
    _begun = True


def pytest_report_header():
    """Name the missing libraries whose tests are skipped."""
    if MISSING:
        return f'not installed, tests that need it are skipped: {", ".join(MISSING)}'
    return 'with ROS'
