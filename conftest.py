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
        'quick', max_examples=60, derandomize=True, deadline=None,
        suppress_health_check=[HealthCheck.too_slow])
    # Other versions of the libraries fail on any example, or on none.
    hypothesis_settings.register_profile(
        'pins', hypothesis_settings.get_profile('quick'), max_examples=10)
    hypothesis_settings.register_profile(
        'release', hypothesis_settings.get_profile('quick'), max_examples=3000, derandomize=False)
    hypothesis_settings.load_profile(os.environ.get('HYPOTHESIS_PROFILE', 'quick'))

OPTIONAL = ('rclpy', 'serial', 'hypothesis', 'rosbags', 'pyarrow', 'mcap_ros2', 'pybag',
            'isal', 'numba', 'distributed', 'threadpoolctl', 'jinja2', 'matplotlib',
            'rich', 'argcomplete', 'ephem', 'segno', 'xmlschema', 'dcc')
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
    collect_ignore_glob += [f'heading_intercompare/{name}.py'
                            for name in ('readers/parquet', 'app/history_parquet')]
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
#: Graphs at the same time: more of them starve each other on two cores.
_GRAPHS = 2
#: The modules that take longest begin first, so that no worker is still busy with one at the end.
_LONG = tuple(f'test/{name}.py' for name in (
    'nodes/test_graph_processes', 'app/test_cluster', 'bags/recording/test_reading_journal',
    'core/pairing/test_pairer', 'test_howtos', 'test_packaging'))


def _runs_nodes(path: str) -> bool:
    return path.startswith(f'{_NODES}/')


def _path(item: pytest.Item) -> str:
    return Path(item.path).relative_to(Path(__file__).parent).as_posix()


def _order(item: pytest.Item) -> tuple[bool, bool]:
    path = _path(item)
    return not _runs_nodes(path), path not in _LONG


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Mark the tests that run nodes, before `-m` selects, and begin with them."""
    for item in items:
        if _runs_nodes(_path(item)):
            item.add_marker('ros')
    items.sort(key=_order)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """
    Give the tests module by module, and those of nodes to two workers at most.

    The groups of pytest-xdist could not say this, and its version 3.8 loses them with pytest 9.2.
    """
    if config.getvalue('dist') != 'loadscope':
        return None
    from xdist.scheduler import LoadScopeScheduling

    def _number(worker):
        return int(worker.gateway.id.removeprefix('gw'))

    class ByModule(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            return nodeid.partition('::')[0]

        def _next_for(self, worker):
            """Return the module that a worker begins next; None if it has nothing left to do."""
            others = (path for path in self.workqueue if not _runs_nodes(path))
            may_run_nodes = worker in sorted(self.nodes, key=_number)[:_GRAPHS]
            return next(iter(self.workqueue) if may_run_nodes else others, None)

        def _assign_work_unit(self, node):
            if (path := self._next_for(node)) is None:
                node.shutdown()
            else:
                self.workqueue.move_to_end(path, last=False)
                super()._assign_work_unit(node)

    return ByModule(config, log)


_begun = False


def pytest_runtest_setup(item):
    """Let a worker that does not begin with the tests of nodes yield to those that do."""
    global _begun
    if not _begun and 'PYTEST_XDIST_WORKER' in os.environ and not _runs_nodes(_path(item)):
        os.nice(10)
    _begun = True


def pytest_report_header():
    """Name the missing libraries whose tests are skipped."""
    if MISSING:
        return f'not installed, tests that need it are skipped: {", ".join(MISSING)}'
    return 'with ROS'
