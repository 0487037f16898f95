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

"""Nodes as processes, as the launch files start them, and conditions with a deadline."""

from __future__ import annotations

from pathlib import Path
import signal
import subprocess
import sys
import time

from deadlines import DEADLINE_S
from nodes.launch_files import make_environment
from ros_domain import DOMAIN


class Processes:
    """Processes of one graph; whatever happens, none is left running."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.running: dict[str, subprocess.Popen] = {}

    def start(self, node) -> None:
        """Start a node as `ros2 launch` would."""
        code = (f'from heading_intercompare.node_executables import {node.executable} as main; '
                'raise SystemExit(main())')
        name = node.file or node.label
        with open(self.folder / f'{name}.log', 'wb') as said:
            # Background children inherit an ignored SIGINT; the node sets its own handler.
            self.running[name] = subprocess.Popen(
                [sys.executable, '-c', code, *node.arguments(self.folder)],
                env=make_environment(DOMAIN, node.transports), cwd=self.folder, stdout=said,
                stderr=said)

    def signal(self, number: int) -> None:
        """Send a signal to all that are running, at once."""
        for process in self.running.values():
            if process.poll() is None:
                process.send_signal(number)

    def wait(self, *names: str) -> None:
        """Wait until processes have ended, each with exit code 0."""
        deadline_s = time.monotonic() + DEADLINE_S
        for name in names:
            code = self.running[name].wait(max(0.1, deadline_s - time.monotonic()))
            said = (self.folder / f'{name}.log').read_text()
            assert code == 0, f'{name} ended with {code}: {said}'
            assert 'Traceback' not in said

    def reap(self) -> None:
        """Kill what is left, and print what all have said: pytest shows it if a test failed."""
        self.signal(signal.SIGKILL)
        for name, process in self.running.items():
            process.wait()
            said = self.folder / f'{name}.log'
            if said.exists():
                print(f'== {name}', said.read_text(errors='replace'), sep='\n')


def wait_for(condition):
    """Wait until a condition holds, else fail."""
    deadline_s = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < deadline_s, 'the condition did not come true in time'
        time.sleep(0.05)
