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

"""Environment and fixtures of all tests; set before any message type is imported."""

from __future__ import annotations

import os
from pathlib import Path
import tempfile

import numpy as np
import pytest

from heading_intercompare.core.pipeline import Intercomparison
from heading_intercompare.core.records import Headings
from heading_intercompare.core.settings import Settings

# Whatever the user's own graph needs would reach into it, or out of the tests.
for name in ('ROS_DOMAIN_ID', 'ROS_LOCALHOST_ONLY', 'ROS_STATIC_PEERS', 'ROS_DISCOVERY_SERVER',
             'ROS_SUPER_CLIENT', 'ROS_NAMESPACE', 'ROS_SECURITY_ENABLE', 'ROS_SECURITY_STRATEGY',
             'ROS_SECURITY_KEYSTORE', 'ROS_SECURITY_ENCLAVE_OVERRIDE', 'RMW_IMPLEMENTATION',
             'RMW_FASTRTPS_USE_QOS_FROM_XML', 'FASTRTPS_DEFAULT_PROFILES_FILE',
             'FASTDDS_DEFAULT_PROFILES_FILE', 'FASTDDS_BUILTIN_TRANSPORTS',
             'RCUTILS_CONSOLE_OUTPUT_FORMAT', 'RCUTILS_LOGGING_USE_STDOUT',
             'RCUTILS_COLORIZED_OUTPUT', 'RCUTILS_LOGGING_BUFFERED_STREAM'):
    os.environ.pop(name, None)
os.environ |= {'ROS_PYTHON_CHECK_FIELDS': '1', 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'OFF'}
if 'ROS_LOG_DIR' not in os.environ:
    _logs = tempfile.TemporaryDirectory(
        prefix='heading_intercompare_log_', ignore_cleanup_errors=True)
    os.environ['ROS_LOG_DIR'] = _logs.name
# Each session simulates the designs of its charts itself.
_cache = tempfile.TemporaryDirectory(
    prefix='heading_intercompare_cache_', ignore_cleanup_errors=True)
os.environ['XDG_CACHE_HOME'] = _cache.name

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture
def rng():
    """Return a seeded generator; a test with it gives the same result every time."""
    return np.random.default_rng(20160716)


@pytest.fixture
def verdict_of_two_runs():
    """Return the verdict on 200 s and 201 s of pairs, 200 s apart, from second 10**9 + 1 on."""
    stamps = np.concatenate((np.arange(1, 201), np.arange(400, 601))) * 10 ** 9 + 10 ** 18
    comparison = Intercomparison(Settings.from_mapping(
        {'norms': {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1}}))
    comparison.update(ts=Headings.of(stamps, 90.0 + 0.1 * np.sin(np.arange(401) * 2.0)),
                      rs=Headings.of(stamps, np.full(401, 90.0)))
    comparison.finish()
    return comparison.verdict()


@pytest.fixture(scope='session')
def shared_data():
    """Return the folder of real ship logs beside the checkout, or skip."""
    folder = ROOT.parent / 'shared' / 'data'
    if not folder.is_dir():
        pytest.skip('the real ship logs (shared/data beside the checkout) are not here')
    return folder
