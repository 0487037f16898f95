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
The cost of starting: CPU time and memory of each executable, next to a peer of its kind.

A command runs to its end; its peer is `python -c 'import numpy'`. A node is measured one second
after others see it: then its topics are open, and it waits for a sensor, a subscriber or a
message. Its peer is an rclpy node with one publisher of sensor_msgs/Imu. The large node has as
many publishers, subscriptions, services, timers and parameters as `compliance`. The table shows
the least CPU time, user and system, and the least peak of resident memory over several rounds.
The ratio to the peer is the median over the rounds, in each of which both ran under much the same
load. An extra first round compiles and is not counted.

Promises: at most twice the CPU time of the peer for `--version`, 1.8 times for a driver, 2.6 times
for `compliance`; docs/graph_design.md says why not less. The exit code is 1 if one is broken.

    python benchmarks/start_up.py
    python benchmarks/start_up.py --rounds 3 --only driver
"""

from __future__ import annotations

import argparse
from itertools import count
import os
from pathlib import Path
import re
from statistics import median
import subprocess
import sys
from tempfile import TemporaryDirectory
from time import monotonic, sleep
from typing import NamedTuple

import rclpy
from rclpy.node import Node

ROOT = Path(__file__).resolve().parent.parent
TICKS_HZ = os.sysconf('SC_CLK_TCK')
NUMBERS = count()

#: How long to leave a node alone once it is seen, and the longest wait until it is seen.
ALONE_S, LONGEST_S = 1.0, 60.0

PLAIN_NODE = """
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import Imu
rclpy.init()
node = Node('plain_node')
publisher = node.create_publisher(Imu, 'heading', 10)
rclpy.spin(node)
"""

LARGE_NODE = """
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import ParameterDescriptor
import rclpy
from rclpy.node import Node
from std_msgs.msg import Float64, String
from std_srvs.srv import Trigger
rclpy.init()
node = Node('large_node')
for kind, n_out, n_in in (DiagnosticArray, 7, 3), (Float64, 7, 0), (String, 3, 1):
    for number in range(n_out):
        node.create_publisher(kind, f'{kind.__name__}_out_{number}', 10)
    for number in range(n_in):
        node.create_subscription(kind, f'{kind.__name__}_in_{number}', print, 10)
for number in range(4):
    node.create_service(Trigger, f'service_{number}', print)
    node.create_timer(1.0, int)
for number in range(110):
    node.declare_parameter(f'group.name_{number}', 1.0, ParameterDescriptor(
        description='norm of the standard deviation [deg]', read_only=True, dynamic_typing=True))
rclpy.spin(node)
"""


class Cost(NamedTuple):
    """CPU time and peak of resident memory of one start."""

    cpu_s: float
    memory_mb: float


class Program(NamedTuple):
    """
    One row of the table.

    Attributes
    ----------
    words
        Arguments of Python.
    peer
        The row to compare it with.
    most
        The promised ratio of CPU times.
    node
        It is a node, which does not end by itself.

    """

    words: tuple[str, ...]
    peer: str | None = None
    most: float = float('inf')
    node: bool = False


def command(*words: str, most: float = float('inf')) -> Program:
    """Return a command of the command line."""
    return Program(('-m', 'heading_intercompare', *words), 'import numpy', most)


def node(name: str, *parameters: str, most: float = float('inf')) -> Program:
    """Return a node with some parameters, as its executable runs it."""
    given = [word for parameter in parameters for word in ('-p', parameter)]
    return Program(('-c', f'from heading_intercompare.node_executables import {name}; {name}()',
                    '--ros-args', *given), 'plain node', most, True)


NORMS = 'norms.sigma_max_deg:=0.3', 'norms.sigma_ref_max_deg:=0.1'
SETTINGS = tuple(f'--set={norm.replace(":=", "=")}' for norm in NORMS)

PROGRAMS = {
    'import numpy': Program(('-c', 'import numpy')),
    'import heading_intercompare': Program(('-c', 'import heading_intercompare'), 'import numpy'),
    '--version': command('--version', most=2.0),
    'analyze --help': command('analyze', '--help'),
    'analyze, 10 min at 10 Hz': command('analyze', 'pairs.csv', *SETTINGS),
    'plain node': Program(('-c', PLAIN_NODE, '--ros-args'), node=True),
    'large node': Program(('-c', LARGE_NODE, '--ros-args'), 'plain node', node=True),
    'nmea_driver': node('nmea_driver', 'source:=udp://127.0.0.1:10110', 'topic:=ts/heading',
                        most=1.8),
    'synchronizer': node('synchronizer', *NORMS),
    'compliance': node('compliance', *NORMS, most=2.6),
    'recorder': node('recorder', *NORMS),
    'replayer': node('replayer', 'bag:=bag'),
    'sensor_simulator': node('sensor_simulator'),
}


def peak_mb(process: subprocess.Popen) -> float:
    """Return the peak memory of a process, MB; 0 if it has ended."""
    status = Path(f'/proc/{process.pid}/status').read_text('utf-8')
    return int([*status.partition('VmHWM:')[2].split(), '0'][0]) / 1024.0


def look(process: subprocess.Popen) -> Cost:
    """Return the cost of a process so far."""
    times = Path(f'/proc/{process.pid}/stat').read_text('utf-8').rpartition(') ')[2].split()
    return Cost((int(times[11]) + int(times[12])) / TICKS_HZ, peak_mb(process))


def settle(process: subprocess.Popen, name: str, watcher: Node) -> Cost:
    """Wait until a node is there, return its cost, and end it."""
    deadline = monotonic() + LONGEST_S
    while name not in watcher.get_node_names():
        if process.poll() is not None or monotonic() > deadline:
            process.kill()
            raise SystemExit(f'{process.args}: ended, or was not seen in time')
        sleep(0.02)
    sleep(ALONE_S)
    cost = look(process)
    process.kill()
    process.wait()
    return cost


def finish(process: subprocess.Popen) -> Cost:
    """Return the cost of a process that ends by itself."""
    # `ru_maxrss` of a child includes the memory this process had when it started the child.
    memory_mb, pid = 0.0, 0
    while not pid:
        memory_mb = max(memory_mb, peak_mb(process))
        sleep(0.002)
        pid, _, usage = os.wait4(process.pid, os.WNOHANG)
    process.returncode = 0
    return Cost(usage.ru_utime + usage.ru_stime, memory_mb)


def start(program: Program, folder: str, watcher: Node) -> Cost:
    """Start a program and return the cost; a node gets a new name each time."""
    name = f'start_up_{os.getpid()}_{next(NUMBERS)}'
    path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get('PYTHONPATH')])])
    process = subprocess.Popen(
        [sys.executable, *program.words, *(['-r', f'__node:={name}'] if program.node else [])],
        cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        env={**os.environ, 'PYTHONPATH': path, 'PYTHONPYCACHEPREFIX': f'{folder}/compiled',
             'PYTHONDONTWRITEBYTECODE': '', 'ROS_LOG_DIR': folder})
    return settle(process, name, watcher) if program.node else finish(process)


def prepare(folder: str, watcher: Node) -> None:
    """Write the inputs of the programs: a simulated trial as a bag, and its pairs as csv."""
    text = (ROOT / 'config' / 'scenarios' / 'demo.yaml').read_text('utf-8')
    Path(folder, 'trial.yaml').write_text(
        re.sub('^duration_s: .*$', 'duration_s: 600', text, flags=re.MULTILINE), 'utf-8')
    for words in (('simulate', '--scenario', 'trial.yaml', '-o', 'bag', '--seed', '1'),
                  ('analyze', 'bag', *SETTINGS, '--csv', 'pairs.csv')):
        start(command(*words), folder, watcher)


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n\n')[0])
    parser.add_argument('--rounds', type=int, default=5)
    parser.add_argument('--only', default='', help='a part of the name')
    arguments = parser.parse_args()
    rows = {name: program for name, program in PROGRAMS.items()
            if arguments.only in name}
    rows = {name: PROGRAMS[name] for name in PROGRAMS
            if name in rows or name in {row.peer for row in rows.values()}}
    costs: dict[str, list[Cost]] = {name: [] for name in rows}
    os.environ.setdefault('ROS_DOMAIN_ID', '71')
    rclpy.init()
    watcher = rclpy.create_node('start_up')
    with TemporaryDirectory() as folder:
        prepare(folder, watcher)
        for turn in range(arguments.rounds + 1):
            for name, program in rows.items():
                cost = start(program, folder, watcher)
                if turn:
                    costs[name].append(cost)
    least = {name: Cost(*map(min, zip(*found))) for name, found in costs.items()}
    broken = False
    print('| | CPU | × peer | memory | × peer |\n|---|---|---|---|---|')
    for name, program in rows.items():
        mine, peer = least[name], least[program.peer or name]
        times = median(cost.cpu_s / its_peer.cpu_s for cost, its_peer
                       in zip(costs[name], costs[program.peer or name]))
        word = ' **broken**' if times > program.most else ''
        broken = broken or bool(word)
        print(f'| {name} | {mine.cpu_s:.2f} s | {times:.2f}{word} | {mine.memory_mb:.0f} MB '
              f'| {mine.memory_mb / peer.memory_mb:.2f} |')
    return int(broken)


if __name__ == '__main__':
    sys.exit(main())
