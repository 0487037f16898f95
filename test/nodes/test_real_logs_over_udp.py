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
The whole graph as processes, fed with real logs over UDP at fifty times their speed.

Datagrams are those of IEC 61162-450, the time of the log in their TAG blocks, milliseconds.
"""

from __future__ import annotations

from datetime import datetime, timezone
from pathlib import Path
import signal
import socket
import subprocess
import sys
import time

from checksums import checksum_of
from deadlines import DEADLINE_S
from nodes.launch_files import make_environment
from nodes.lines import free_port
import pytest
from ros_domain import DOMAIN

from heading_intercompare.cli import main
from heading_intercompare.core.verdict.compare_verdicts import find_differences
from heading_intercompare.report.json import parse, read

pytestmark = pytest.mark.process

pytest.importorskip('rclpy')

SPEED = 50.0
NORMS = ['norms.sigma_max_deg:=0.2', 'norms.sigma_ref_max_deg:=0.1', 'norms.m_low:=0.9']
SHIPS = {
    'nbp': ({'ts': 'nbp1406/NBP1406_gyr1-2014-08-01', 'rs': 'nbp1406/NBP1406_s330-2014-08-01'},
            '%Y-%m-%dT%H:%M:%S.%fZ', 625),
    'lmg': ({'ts': 'lmg1903/LMG1903_lgyr.d085', 'rs': 'lmg1903/LMG1903_lsep.d085'},
            '%y+%j:%H:%M:%S.%f', 999)}


def checksum(text: bytes) -> bytes:
    return b'%02X' % checksum_of(text.decode())


def datagrams(log: Path, form: str) -> list[tuple[float, bytes]]:
    """Return the lines of a log as datagrams, with their times in seconds."""
    rows = []
    for number, line in enumerate(log.read_bytes().splitlines()):
        stamp, _, sentence = line.partition(b' ')
        moment = datetime.strptime(stamp.decode(), form)
        ms = round(moment.replace(tzinfo=timezone.utc).timestamp() * 1000)
        tag = b's:GY0001,n:%d,c:%d' % (number % 1000, ms)
        rows.append((ms / 1000, b'UdPbC\0\\' + tag + b'*' + checksum(tag) + b'\\' + sentence
                     + b'\r\n'))
    return rows


class Graph:
    """Processes of nodes in their own domain."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.environment = {**make_environment(DOMAIN, 'UDPv4'),
                            'PYTHONPATH': str(Path(__file__).resolve().parents[2])}
        self.processes: dict[str, subprocess.Popen] = {}

    def start(self, node: str, *parameters: str, name: str = '') -> None:
        code = (f'import sys; from heading_intercompare.nodes.{node} import main; '
                'sys.exit(main(sys.argv))')
        words = [word for p in (*NORMS, *parameters) for word in ('-p', p)]
        name = name or node
        log = (self.folder / f'{name}.log').open('wb')
        self.processes[name] = subprocess.Popen(
            [sys.executable, '-c', code, '--ros-args', '-r', f'__node:={name}', *words],
            env=self.environment, cwd=self.folder, stdout=log, stderr=log)

    def log_of(self, name: str) -> str:
        return (self.folder / f'{name}.log').read_text()

    def stop(self) -> dict[str, int]:
        """Send SIGINT to all, as Ctrl-C does, and return the exit codes."""
        for process in self.processes.values():
            process.send_signal(signal.SIGINT)
        return {name: process.wait(DEADLINE_S) for name, process in self.processes.items()}

    def kill(self) -> None:
        for process in self.processes.values():
            if process.poll() is None:
                process.kill()
                process.wait()


def wait_until(condition, what: str) -> None:
    deadline = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < deadline, f'not in {DEADLINE_S} s: {what}'
        time.sleep(0.05)


def bound(port: int) -> bool:
    """Tell whether a socket listens on a UDP port."""
    rows = Path('/proc/net/udp').read_text().splitlines()[1:]
    return any(row.split()[1].endswith(f':{port:04X}') for row in rows)


@pytest.mark.slow
@pytest.mark.parametrize('ship', [
    'nbp', pytest.param('lmg', marks=pytest.mark.endurance)])
def test_logs_over_udp_give_the_verdict_of_their_import(ship, shared_data, tmp_path, capsys):
    logs, form, n = SHIPS[ship]
    ports = {role: free_port() for role in logs}
    graph = Graph(tmp_path)
    try:
        graph.start('compliance', 'report_dir:=reports')
        graph.start('recorder', 'output:=bag')
        graph.start('synchronizer', 'subscribers:=2')
        for role, port in ports.items():
            graph.start('nmea_driver', f'source:="udp://127.0.0.1:{port}"',
                        f'topic:={role}/heading', 'stamp_format:=tag', name=f'{role}_driver')
        wait_until(lambda: all(bound(port) for port in ports.values()), 'drivers listen')
        # A live line has no audience to wait for: the graph must be up before the first datagram.
        wait_until(lambda: heard(graph), 'headings have subscriptions')
        send({role: datagrams(shared_data / log, form) for role, log in logs.items()}, ports)
        codes = graph.stop()
    finally:
        graph.kill()
    assert set(codes.values()) == {0}, {name: graph.log_of(name) for name in codes}
    (report,) = (tmp_path / 'reports').glob('verdict_*.json')
    live = read(report)
    imported = tmp_path / 'imported'
    assert main(['import-nmea', '--ts', str(shared_data / logs['ts']), '--rs',
                 str(shared_data / logs['rs']), '-o', str(imported)]) == 0
    norms = [word for p in NORMS for word in ('--set', p.replace(':=', '='))]
    for bag in (imported, tmp_path / 'bag'):
        capsys.readouterr()
        assert main(['analyze', str(bag), *norms, '--json', '-']) == 0
        offline = parse(capsys.readouterr().out)
        assert sum(run.n for run in offline.runs) == n
        assert [run.motion.kind for run in offline.runs] == ['agrees']
        assert list(find_differences(live, offline)) == []


def heard(graph: Graph) -> bool:
    """Tell whether every process listens to the others, by asking the graph of ROS."""
    code = ('import rclpy, sys\n'
            'rclpy.init(); node = rclpy.create_node("probe")\n'
            'end = node.get_clock().now().nanoseconds + 4e9\n'
            'want = {"/ts/heading": 2, "/rs/heading": 2, "/pairs": 2, "/pairs/ledger": 2}\n'
            'ok = False\n'
            'while not ok and node.get_clock().now().nanoseconds < end:\n'
            '    rclpy.spin_once(node, timeout_sec=0.1)\n'
            '    ok = all(node.count_subscribers(t) >= n for t, n in want.items())\n'
            'sys.exit(not ok)\n')
    return subprocess.run([sys.executable, '-c', code], env=graph.environment,
                          stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 0


def send(streams: dict[str, list[tuple[float, bytes]]], ports: dict[str, int]) -> None:
    """Send the datagrams of all streams at their times, faster by SPEED."""
    rows = sorted((t, role, data) for role, stream in streams.items() for t, data in stream)
    begin_s = time.monotonic()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for t, role, data in rows:
            wait_s = begin_s + (t - rows[0][0]) / SPEED - time.monotonic()
            if wait_s > 0.0:
                time.sleep(wait_s)
            sender.sendto(data, ('127.0.0.1', ports[role]))
