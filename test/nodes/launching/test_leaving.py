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

"""A process is left, with a code, when a call does not return in time."""

from __future__ import annotations

import subprocess
import sys
import time

from deadlines import DEADLINE_S
import pytest

from heading_intercompare.nodes.launching.process import leave_if_hung

pytestmark = pytest.mark.process


def test_what_returns_in_time_goes_on():
    with leave_if_hung(1.0, 3):
        pass
    time.sleep(1.2)


def test_what_takes_longer_ends_the_process_with_a_code():
    code = ('import time; from heading_intercompare.nodes.launching.process import leave_if_hung\n'
            'with leave_if_hung(0.1, 3): time.sleep(600)')
    assert subprocess.run([sys.executable, '-c', code], timeout=DEADLINE_S).returncode == 3
