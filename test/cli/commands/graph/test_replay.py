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

"""The command `replay` says for whom it waits, and what it does then."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

from deadlines import DEADLINE_S
import numpy as np
import pytest
from ros_domain import take_domain
from trials import write_headings

from heading_intercompare import Headings

pytest.importorskip('rclpy')

S = 1_000_000_000


@pytest.mark.slow
@pytest.mark.process
@pytest.mark.parametrize('options, then', [([], 'replaying'), (['--start-paused'], 'paused')])
def test_without_a_terminal_lines_say_for_whom_a_replay_waits(tmp_path, options, then):
    stamps = 1_400_000_000 * S + np.arange(100) * S // 10
    write_headings(tmp_path / 'bag', dict.fromkeys(
        ('ts/heading', 'rs/heading'), Headings.of(stamps, np.full(100, 90.0))))
    wanted = ('bag: waiting for a subscriber of /ts/heading and /rs/heading; then '
              f'{then} at 0.000 s of 9.900 s')
    said = tmp_path / 'said'
    with open(said, 'wb') as file, subprocess.Popen(
            [sys.executable, '-m', 'heading_intercompare', 'replay', str(tmp_path / 'bag'),
             *options], stderr=file,
            env={**os.environ, 'ROS_DOMAIN_ID': str(take_domain())}) as process:
        try:
            deadline_s = time.monotonic() + DEADLINE_S
            while wanted not in said.read_text():
                assert time.monotonic() < deadline_s and process.poll() is None, said.read_text()
                os.sched_yield()
            process.send_signal(signal.SIGINT)
            assert process.wait(DEADLINE_S) == 0
        finally:
            process.kill()
    assert said.read_text().splitlines()[0].startswith('bag: ')
    assert 'WARN' not in said.read_text()
