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

"""systemd hears that a process is ready, that it turns, and that it ends."""

from __future__ import annotations

from contextlib import ExitStack
import os
from pathlib import Path
import signal
import socket
import subprocess
import sys
import time

from deadlines import DEADLINE_S
from nodes.launch_files import make_environment
from nodes.processes import wait_for
from nodes.ros_nodes import EITHER_EXECUTOR
import pytest
from rclpy.node import Node
from ros_domain import DOMAIN

from heading_intercompare.nodes.launching.systemd_link import SystemdLink
from heading_intercompare.nodes.spinning.clocks import every
from heading_intercompare.nodes.spinning.executors import make_executor


class Systemd:
    """The socket of systemd, and what came through it."""

    def __init__(self, folder: Path) -> None:
        self.place = str(folder / 'notify')
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(self.place)
        self._socket.setblocking(False)

    def hear(self) -> list[str]:
        """Return the states that have come since the last call."""
        states = []
        while True:
            try:
                states.append(self._socket.recv(4096).decode())
            except BlockingIOError:
                return states

    def close(self) -> None:
        """Go away."""
        self._socket.close()


@pytest.fixture
def systemd(tmp_path):
    """Return a systemd that listens."""
    listener = Systemd(tmp_path)
    yield listener
    listener.close()


def test_without_systemd_nothing_is_said(ros):
    link, executor = SystemdLink({}), make_executor(ros.context)
    link.tell('READY=1')
    with link.watch(executor):
        assert executor.beat is None and link.period_s is None
    executor.shutdown()


def test_half_of_the_time_that_systemd_bears_lies_between_signs_of_life(systemd):
    given = {'NOTIFY_SOCKET': systemd.place, 'WATCHDOG_USEC': '3000000'}
    assert SystemdLink(given).period_s == 1.5
    assert SystemdLink({**given, 'WATCHDOG_PID': str(os.getpid())}).period_s == 1.5
    # A node that a watched program has started is not the one to be watched.
    assert SystemdLink({**given, 'WATCHDOG_PID': '1'}).period_s is None


def test_a_socket_in_the_abstract_namespace_is_reached():
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listener:
        listener.bind(f'\0heading_intercompare_{os.getpid()}')
        SystemdLink({'NOTIFY_SOCKET': f'@heading_intercompare_{os.getpid()}'}).tell('READY=1')
        assert listener.recv(64) == b'READY=1'


def test_a_systemd_that_is_gone_changes_nothing(systemd):
    systemd.close()
    SystemdLink({'NOTIFY_SOCKET': systemd.place}).tell('READY=1')


@EITHER_EXECUTOR
def test_the_signs_of_life_end_when_one_of_two_executors_hangs(ros, systemd):
    """The judge of `live` has its own thread: the others alone must not speak for it."""
    link = SystemdLink({'NOTIFY_SOCKET': systemd.place, 'WATCHDOG_USEC': '20000'})
    turning, hung = ros.executor, make_executor(ros.context)

    def turn(*executors):
        for _ in range(5):
            for executor in executors:
                executor.spin_once(0.0)
            time.sleep(0.012)
        return systemd.hear()
    with ExitStack() as stack:
        node = Node('judge', context=ros.context)
        stack.callback(node.destroy_node)
        stack.callback(hung.shutdown)
        hung.add_node(node)
        with link.watch(turning):
            with link.watch(hung):
                assert len(turn(turning, hung)) > 1
                turn(turning)
                assert turn(turning) == []
                assert turn(turning, hung)
            # One that is no longer spun is not waited for.
            assert turn(turning)
        assert turn(turning, hung) == []


@EITHER_EXECUTOR
def test_a_callback_that_hangs_ends_the_signs_of_life(ros, systemd):
    link = SystemdLink({'NOTIFY_SOCKET': systemd.place, 'WATCHDOG_USEC': '100000'})
    heard_after_hanging = []

    def hang():
        systemd.hear()
        time.sleep(0.5)
        heard_after_hanging.append(systemd.hear())
    timer = every(ros.plain, 0.01, hang)
    with link.watch(ros.executor):
        wait_for(lambda: ros.executor.spin_once(0.01) or heard_after_hanging)
    timer.cancel()
    assert heard_after_hanging[0] == []


@pytest.mark.process
def test_a_node_says_when_it_is_ready_that_it_turns_and_that_it_ends(systemd, tmp_path):
    environment = {**make_environment(DOMAIN), 'NOTIFY_SOCKET': systemd.place,
                   'WATCHDOG_USEC': '200000'}
    code = ('from heading_intercompare.nodes.synchronizer import main; raise SystemExit(main())')
    states = []
    with subprocess.Popen([sys.executable, '-c', code], env=environment, cwd=tmp_path) as process:
        try:
            wait_for(lambda: states.extend(systemd.hear()) or states.count('WATCHDOG=1') > 1)
            process.send_signal(signal.SIGINT)
            assert process.wait(DEADLINE_S) == 0
        finally:
            process.kill()
    states += systemd.hear()
    assert states.count('READY=1') == states.count('STOPPING=1') == 1
    assert states.index('READY=1') < states.index('STOPPING=1')
