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

"""The systemd units and the Dockerfile: what they start says so, and ends with its verdict."""

from __future__ import annotations

import os
from pathlib import Path
import re
import shlex
import shutil
import signal
import socket
import subprocess
import sys

from deadlines import DEADLINE_S
from nodes.launch_files import make_environment
from nodes.lines import free_port
from nodes.processes import wait_for
from nodes.ros_nodes import NORMS
import pytest
from ros_domain import DOMAIN
import yaml

from heading_intercompare.nodes.launching.process import _END_S, _HUNG_S

ROOT = Path(__file__).resolve().parents[2]
UNITS = sorted((ROOT / 'systemd').glob('*.service'))


def read_unit(path: Path) -> dict[str, str]:
    """Return the settings of a unit."""
    text = path.read_text('utf-8').replace('\\\n', '')
    return dict(re.findall(r'^(\w+)=(.*)$', text, re.MULTILINE))


def command_of(unit: dict[str, str]) -> list[str]:
    """Return the words of `ExecStart` as systemd makes them."""
    return [word.replace('$$', '$') for word in shlex.split(unit['ExecStart'])]


def test_systemd_finds_no_mistake_in_the_units():
    if shutil.which('systemd-analyze') is None:
        pytest.skip('systemd-analyze is not installed')
    done = subprocess.run(['systemd-analyze', 'verify', *map(str, UNITS)], text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=DEADLINE_S)
    assert (done.returncode, done.stdout) == (0, '')


@pytest.mark.parametrize('path', UNITS, ids=lambda path: path.stem)
def test_a_unit_ends_as_ctrl_c_does_and_starts_again(path):
    unit = read_unit(path)
    assert (unit['KillSignal'], unit['Restart']) == ('SIGINT', 'always')
    # Judging, what each node may take to end, and a middleware that hangs.
    assert int(unit['TimeoutStopSec']) > 2 * _END_S + 2 * _HUNG_S
    assert unit['EnvironmentFile'] == '/etc/heading-intercompare/environment'
    names = set(re.findall(r'\$(HEADING_\w+)', command_of(unit)[-1]))
    assert names <= set(re.findall(r'^(\w+)=', (ROOT / 'systemd' / 'environment').read_text(),
                                   re.MULTILINE))


@pytest.mark.process
def test_what_the_unit_starts_says_that_it_is_ready_and_ends_with_a_verdict(tmp_path):
    """It writes its verdict only if the signal reaches it, and not only the shell before it."""
    config, place = tmp_path / 'my.yaml', str(tmp_path / 'notify')
    config.write_text(yaml.dump({'/**': {'ros__parameters': NORMS}, **{
        f'{role}_driver': {'ros__parameters': {'source': f'udp://127.0.0.1:{free_port()}'}}
        for role in ('ts', 'rs')}}))
    sourced = tmp_path / 'setup.bash'
    sourced.write_text(f'export PATH={shlex.quote(str(Path(sys.executable).parent))}:$PATH\n')
    environment = {**make_environment(DOMAIN, 'UDPv4'), 'NOTIFY_SOCKET': place,
                   'WATCHDOG_USEC': '2000000', 'HEADING_SETUP': str(sourced),
                   'HEADING_CONFIG': str(config),
                   'HEADING_OPTIONS': f'--json {tmp_path / "verdict.json"}'}
    command = command_of(read_unit(ROOT / 'systemd' / 'heading-intercompare.service'))
    senders = set()
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as systemd:
        systemd.bind(place)
        systemd.setsockopt(socket.SOL_SOCKET, socket.SO_PASSCRED, 1)
        systemd.setblocking(False)

        def is_watched():
            try:
                data, ancillary, *_ = systemd.recvmsg(4096, socket.CMSG_SPACE(12))
            except BlockingIOError:
                return False
            senders.add(int.from_bytes(ancillary[0][2][:4], sys.byteorder))
            states.append(data.decode())
            return states.count('WATCHDOG=1') > 2 and 'READY=1' in states
        states: list[str] = []
        with subprocess.Popen(command, env=environment, cwd=tmp_path) as process:
            try:
                wait_for(is_watched)
                process.send_signal(signal.SIGINT)
                assert process.wait(DEADLINE_S) == 0
            finally:
                process.kill()
    assert senders == {process.pid}
    assert 'INDETERMINATE' in (tmp_path / 'verdict.json').read_text().upper()


def test_a_container_that_is_stopped_ends_as_ctrl_c_does():
    """Its first process was a shell, which passed no signal on: there was no final verdict."""
    text = (ROOT / 'Dockerfile').read_text('utf-8')
    assert re.search(r'^STOPSIGNAL SIGINT$', text, re.MULTILINE)
    command = text.partition('\nCMD ')[2].replace('\\\n', '')
    assert command.rstrip().endswith('&& exec ros2 launch heading_intercompare demo.launch.py '
                                     '--noninteractive')


@pytest.mark.process
def test_the_last_command_of_the_container_is_the_process_that_gets_the_signal(tmp_path):
    command = (ROOT / 'Dockerfile').read_text('utf-8').partition('\nCMD ')[2].replace('\\\n', '')
    for script in ('.venv/bin/activate', 'install/setup.bash'):
        (tmp_path / script).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / script).touch()
    (tmp_path / 'ros2').write_text('#!/bin/sh\necho $$\n')
    (tmp_path / 'ros2').chmod(0o755)
    with subprocess.Popen(['/bin/bash', '-c', command.strip()], cwd=tmp_path, text=True,
                          stdout=subprocess.PIPE,
                          env={**os.environ, 'PATH': f'{tmp_path}:/usr/bin:/bin'}) as process:
        assert int(process.communicate(timeout=DEADLINE_S)[0]) == process.pid
