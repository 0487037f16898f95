# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Environment and fixtures of all tests; set before any message type is imported."""

from __future__ import annotations

import os
from pathlib import Path
import tempfile

import numpy as np
import pytest

os.environ['ROS_PYTHON_CHECK_FIELDS'] = '1'
os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'OFF')
os.environ.setdefault('ROS_LOG_DIR', tempfile.mkdtemp(prefix='heading_intercompare_log_'))

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture
def rng():
    """Return a seeded generator; a test with it gives the same result every time."""
    return np.random.default_rng(20160716)


@pytest.fixture(scope='session')
def shared_data():
    """Return the folder of real ship logs beside the checkout, or skip."""
    folder = ROOT.parent / 'shared' / 'data'
    if not folder.is_dir():
        pytest.skip('the real ship logs (shared/data beside the checkout) are not here')
    return folder
