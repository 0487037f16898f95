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
The running graph next to its peers: CPU, losses, latency, start-up, memory.

    python benchmarks/live.py                                     # 2 topics x 10, 100, 1000 Hz
    python benchmarks/live.py --rates 1000 --seconds 600 --only graph live --rounds 1
    python benchmarks/live.py --judging                           # does the judge hold up others?
    python benchmarks/live.py --day                               # memory over 24 h of stamps
    PYTHONPATH=filters/src python benchmarks/live.py              # with message_filters

One process stands for the sensors, and its CPU is not counted. For the peers it publishes two
topics of sensor_msgs/Imu, for the graphs it sends sentences (HDT) by UDP. The candidates take them
in turn:

* plain: an rclpy node with two subscriptions and a SingleThreadedExecutor, which only counts;
* message_filters: the same with an ApproximateTimeSynchronizer, if that package can be found;
* graph: two drivers, synchronizer, compliance and recorder, a process each, as the launch file
  runs them;
* live: the same nodes in one process, as the command `live` runs them;
* graph-rclpy, live-rclpy: the same with the executor of rclpy, if you ask for them by --only.

With --without-drivers the graphs take topics, too, as from drivers of other packages.

No wheel has message_filters. Its Python part needs only rclpy, so a checkout is enough:

    git clone -b jazzy https://github.com/ros2/message_filters filters

CPU is the share of one core, user and system, of all threads. The table shows the least of all
rounds. Below it are the ratios to each peer in the same round, the median of all rounds. Latency
is the time from the stamp of the later reading of a pair, which is published at that time, to the
publication of the first `compliance/rolling` that covers the pair. For the peers it is the time to
the callback. Lost are readings without an entry in the ledger of the last report, and messages
missing in the bag.
"""

from __future__ import annotations

import argparse
from contextlib import suppress
from functools import reduce
from importlib.util import find_spec
import itertools
import json
import operator
import os
from pathlib import Path
import signal
import socket
from statistics import median
import subprocess
import sys
from tempfile import TemporaryDirectory, TemporaryFile
import threading
import time
from typing import Any, Callable, Iterator, Mapping, NoReturn, Sequence

import numpy as np

from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.core.pipeline import Compliance
from heading_intercompare.core.records import Headings, Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.messages.heading_messages import imu_messages
from heading_intercompare.messages.stamps import header_stamp_ns
from heading_intercompare.nodes.spinning.executors import EXECUTOR

HERE = str(Path(__file__).resolve())
TOPICS = ('ts/heading', 'rs/heading')
NORMS = {'norms.sigma_max_deg': 0.2, 'norms.sigma_ref_max_deg': 0.1}
#: Of every publisher and subscription; that of the nodes.
DEPTH = 5000
TICK_S = 1.0 / os.sysconf('SC_CLK_TCK')
#: The run is judged from the first reading on.
SETTINGS = {**NORMS, 'runs.stabilization_s': 0.0, 'pairing.method': 'interpolate'}
FIRST_WAIT_S, LONGEST_WAIT_S = 3.0, 60.0
NODES = ('intercompare', 'recorder')
PEERS, OURS = ('plain', 'message_filters'), ('graph', 'live')
#: Ends the name of a graph that has the executor of rclpy.
STOCK = '-rclpy'
STOCK_OURS = tuple(name + STOCK for name in OURS)
CANDIDATES = PEERS + OURS + STOCK_OURS


def publish(rate_hz: float, seconds: float, subscribers: int, faster: float,
            ports: Sequence[int] = ()) -> None:
    """
    Send the readings of two sensors once they are heard; print when, and when it is over.

    They go to topics, or as sentences to the ports of drivers.
    """
    import rclpy
    from sensor_msgs.msg import Imu
    rclpy.init()
    node = rclpy.create_node('benchmark_publisher')
    publishers = [] if ports else [node.create_publisher(Imu, topic, DEPTH) for topic in TOPICS]
    line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def is_heard(topic: str) -> bool:
        return node.count_publishers(topic) > 0 and node.count_subscribers(topic) >= subscribers

    deadline_s = time.monotonic() + LONGEST_WAIT_S
    while not all(map(is_heard, TOPICS)):
        if time.monotonic() > deadline_s:
            raise SystemExit('no subscriber')
        time.sleep(0.02)
    print(time.time(), flush=True)
    rng, n = np.random.default_rng(1), round(rate_hz * seconds)
    period_ns = round(1e9 / rate_hz)
    began_ns, began_s = time.time_ns(), time.monotonic()
    stamps: list[list[int]] = [[], []]
    if faster:
        pour(publishers, began_ns, period_ns, n, rng)
    for i in range(0 if faster else n):
        for late in range(len(TOPICS)):
            # The RS speaks a third of a period after the TS.
            due_s = began_s + (i + late / 3) / rate_hz
            time.sleep(max(0.0, due_s - time.monotonic()))
            stamps[late].append(time.time_ns())
            heading_deg = 90.0 + rng.normal(0.0, 0.1)
            if ports:
                line.sendto(make_sentence(heading_deg), ('127.0.0.1', ports[late]))
            else:
                reading = Headings.of(stamps[late][-1:], [heading_deg])
                publishers[late].publish(imu_messages(reading, 'gyro')[0])
    np.save('sent.npy', stamps)
    print(2 * n, flush=True)
    for publisher in publishers:
        publisher.wait_for_all_acked(rclpy.duration.Duration(seconds=20))
    sys.stdin.readline()
    rclpy.try_shutdown()


def make_sentence(heading_deg: float) -> bytes:
    """Return a heading as a sentence."""
    body = f'HEHDT,{heading_deg:.3f},T'
    return f'${body}*{reduce(operator.xor, body.encode()):02X}\r\n'.encode()


def pour(publishers: Sequence[Any], began_ns: int, period_ns: int, n: int,
         rng: np.random.Generator) -> None:
    """Publish n readings of each sensor as fast as the subscribers acknowledge them."""
    from rclpy.duration import Duration
    for lo in range(0, n, 500):
        at = began_ns + period_ns * np.arange(lo, min(lo + 500, n), dtype=np.int64)
        for late, publisher in enumerate(publishers):
            stamps = at + late * period_ns // 3
            for message in imu_messages(
                    Headings.of(stamps, 90.0 + rng.normal(0.0, 0.1, len(at))), 'gyro'):
                publisher.publish(message)
        for publisher in publishers:
            publisher.wait_for_all_acked(Duration(seconds=60))


def listen(name: str, subscribe: Callable[[Any], None], found: Callable[[], Any]) -> None:
    """Make a node, let it subscribe, and spin until SIGINT; then print what it found."""
    import rclpy
    from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
    rclpy.init()
    node = rclpy.create_node(name)
    subscribe(node)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    print(json.dumps(found()), flush=True)


def peer(kind: str) -> None:
    """Subscribe as a plain node or with message_filters; print latencies at SIGINT."""
    from sensor_msgs.msg import Imu
    late_s: list[float] = []

    def take(*messages: Any) -> None:
        newest = max(m.header.stamp.sec * 10 ** 9 + m.header.stamp.nanosec for m in messages)
        late_s.append((time.time_ns() - newest) / 1e9)

    def subscribe(node: Any) -> None:
        if kind == 'message_filters':
            import message_filters
            inputs = [message_filters.Subscriber(node, Imu, topic, qos_profile=DEPTH)
                      for topic in TOPICS]
            joined = message_filters.ApproximateTimeSynchronizer(inputs, 100, 0.1)
            joined.registerCallback(take)
        else:
            for topic in TOPICS:
                node.create_subscription(Imu, topic, take, DEPTH)

    def found() -> dict[str, float]:
        p50_s, p99_s = np.quantile(late_s, (0.5, 0.99)) if late_s else [float('nan')] * 2
        return {'taken': len(late_s), 'p50_s': p50_s, 'p99_s': p99_s}
    listen('benchmark_peer', subscribe, found)


def watch() -> None:
    """Note the figures as they are published, at the time of publication; print at SIGINT."""
    from diagnostic_msgs.msg import DiagnosticArray
    heard: list[tuple[int, int]] = []

    def take(data: bytes, info: Mapping[str, int]) -> None:
        heard.append((info['source_timestamp'], header_stamp_ns(data)))
    listen('benchmark_watch', lambda node: node.create_subscription(
        DiagnosticArray, 'compliance/rolling', take, DEPTH, raw=True), lambda: heard)


class Process:
    """A process of this benchmark."""

    def __init__(self, words: Sequence[str], folder: Path, domain: int,
                 executor: str = 'quick') -> None:
        # It runs in another folder, so relative entries would be lost.
        given = os.environ.get('PYTHONPATH', '').split(os.pathsep)
        path = os.pathsep.join(os.path.abspath(entry) for entry in given if entry)
        environment = {**os.environ, 'PYTHONPATH': path, 'ROS_DOMAIN_ID': str(domain),
                       'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', EXECUTOR: executor}
        self.began_s = time.time()
        self.process = subprocess.Popen(
            [sys.executable, *words], env=environment, cwd=folder, text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=(errors := TemporaryFile('w+')))
        self._words, self._errors = ' '.join(words[:2]), errors

    def _read(self, file: str, key: str) -> str:
        """Return what follows a key in a file about the process; end if the process is gone."""
        text = ''
        if self.process.poll() is None:
            with suppress(OSError):
                text = Path(f'/proc/{self.process.pid}/{file}').read_text('utf-8')
        if key not in text:
            self._complain()
        return text.rpartition(key)[2]

    def _complain(self) -> NoReturn:
        """End the benchmark: say which process is gone, and what it said last."""
        code = self.process.wait(LONGEST_WAIT_S)
        self._errors.seek(0)
        last = (self._errors.read().strip() or 'it said nothing').rpartition('\n')[2]
        raise SystemExit(f'the process {self._words} ended with exit code {code} before it was '
                         f'measured: {last}')

    def cpu_s(self) -> float:
        """Return the CPU time so far, of all threads, user and system."""
        times = self._read('stat', ') ').split()
        return TICK_S * (int(times[11]) + int(times[12]))

    def memory_mb(self) -> float:
        """Return the resident memory now."""
        return int(self._read('status', 'VmRSS:').split()[0]) / 1024.0

    def say(self) -> str:
        """Return the next line that it prints; end if it is gone."""
        assert self.process.stdout is not None
        return self.process.stdout.readline() or self._complain()

    def interrupt(self) -> str:
        """Interrupt it and return what it prints."""
        self.process.send_signal(signal.SIGINT)
        return self.process.communicate(timeout=60.0)[0]


def node_words(executable: str, settings: dict[str, Any], name: str = '') -> list[str]:
    """Return the arguments of Python for a node, which may have another name."""
    words = [word for key, value in settings.items() for word in ('-p', f'{key}:={value}')]
    code = f'from heading_intercompare.node_executables import {executable}; {executable}()'
    # The nodes of `intercompare` keep their names.
    named = ['-r', f'__node:={name or executable}'] if executable != 'intercompare' else []
    return ['-c', code, '--ros-args', *named, *words]


def free_port() -> int:
    """Return a port of UDP that nobody uses."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind(('127.0.0.1', 0))
        return int(line.getsockname()[1])


def start(candidate: str, folder: Path, domain: int,
          ports: Sequence[int] = ()) -> dict[str, Process]:
    """Start a candidate, with drivers on these ports; return its processes by name."""
    drivers = {f'{topic[:2]}_driver': {'source': f'udp://127.0.0.1:{port}', 'sentence': 'HDT'}
               for topic, port in zip(TOPICS, ports)}
    executor = STOCK[1:] if candidate.endswith(STOCK) else 'quick'
    kind = candidate.removesuffix(STOCK)
    if kind == 'graph':
        own = {'recorder': {'output': str(folder / 'bag')},
               'intercompare': {'compliance:report_dir': 'out'}}
        heard = {'subscribers': 2}
        return {**{name: Process(node_words('nmea_driver', {
            **driver, **heard, 'topic': topic}, name), folder, domain, executor)
            for topic, (name, driver) in zip(TOPICS, drivers.items())},
                **{name: Process(node_words(name, {**SETTINGS, **own[name]}), folder, domain,
                                    executor)
                   for name in NODES}}
    if kind == 'live':
        settings = [word for key, value in SETTINGS.items() for word in
                    ('--set', f'{key}={value}')]
        # A parameter file is YAML, and so is JSON.
        (folder / 'config.yaml').write_text(json.dumps(
            {name: {'ros__parameters': driver} for name, driver in drivers.items()}), 'utf-8')
        sources = (['--config', 'config.yaml'] if drivers
                   else ['--ts', TOPICS[0], '--rs', TOPICS[1]])
        words = ['-m', 'heading_intercompare', 'live', *sources,
                 *settings, '-o', 'bag', '--quiet', '--json', 'verdict.json']
        return {'live': Process(words, folder, domain, executor)}
    return {candidate: Process([HERE, '--peer', candidate], folder, domain)}


def read_losses(folder: Path, sent: int) -> dict[str, Any]:
    """Return what the last report and the bag lack of the readings sent."""
    found = sorted((folder / 'out').glob('*.json')) or [folder / 'verdict.json']
    with open(found[-1], encoding='utf-8') as file:
        verdict = json.load(file)
    runs = [run['pairing'] for run in verdict['runs']]
    received = sum(run['ts_received'] + run['rs_received'] for run in runs)
    topics = BagReader(folder / 'bag').topics
    recorded = sum(topics[f'/{topic}'].count for topic in TOPICS)
    pairs = topics['/pairs'].count
    return {'lost': sent - received, 'missing in the bag': sent - recorded,
            'paired': sum(run['paired'] for run in runs), 'pairs in the bag': pairs,
            'ledger_complete': verdict['ledger_complete']}


def latencies(heard: Sequence[tuple[int, int]], since_ns: int, until_ns: int,
              folder: Path) -> tuple[float, float]:
    """Return median and 99 % quantile of the time from the later reading of a pair to figures."""
    published, newest = np.array(heard, np.int64).T
    ts_ns, rs_ns = np.load(folder / 'sent.npy')
    inside = (since_ns < ts_ns) & (ts_ns < until_ns)
    at = np.searchsorted(newest, ts_ns[inside])
    late_s = (published[np.minimum(at, len(newest) - 1)] - rs_ns[inside]) / 1e9
    return float(np.quantile(late_s, 0.5)), float(np.quantile(late_s, 0.99))


def measure(candidate: str, rate_hz: float, seconds: float, drivers: bool) -> dict[str, Any]:
    """Run a candidate with a publisher, a graph with `drivers` too; return its figures."""
    domain = 1 + (os.getpid() * 7 + int(time.time())) % 100
    with TemporaryDirectory(prefix='live') as name:
        folder = Path(name)
        ours = candidate not in PEERS
        ports = [free_port(), free_port()] if ours and drivers else []
        parts = start(candidate, folder, domain, ports)
        watcher = Process([HERE, '--watch'], folder, domain) if ours else None
        source = Process([HERE, '--publish', f'--rate={rate_hz}',
                          f'--seconds={seconds + FIRST_WAIT_S}',
                          f'--subscribers={2 if ours else 1}',
                          '--ports', *map(str, ports)], folder, domain)
        there_s = float(source.say())
        ready_s = there_s - next(iter(parts.values())).began_s
        time.sleep(FIRST_WAIT_S)
        before = {part: process.cpu_s() for part, process in parts.items()}
        since = time.time_ns(), time.monotonic()
        time.sleep(max(0.1, seconds - 1.0))
        span_s = time.monotonic() - since[1]
        cpu = {part: (process.cpu_s() - before[part]) / span_s
               for part, process in parts.items()}
        until_ns = time.time_ns()
        memory = {part: process.memory_mb() for part, process in parts.items()}
        sent = int(source.say())
        time.sleep(0.5)
        said = {}
        source.process.communicate('\n', timeout=60.0)
        for process in parts.values():
            process.process.send_signal(signal.SIGINT)
        for part, process in parts.items():
            said[part] = process.process.communicate(timeout=60.0)[0]
        row = {'cpu': cpu, 'memory': memory, 'ready_s': ready_s}
        if watcher is not None:
            heard = json.loads(watcher.interrupt())
            p50_s, p99_s = latencies(heard, since[0], until_ns, folder)
            return {**row, 'p50_s': p50_s, 'p99_s': p99_s, **read_losses(folder, sent)}
        figures = json.loads(said[candidate])
        # message_filters calls back once per pair, which takes two readings.
        taken = figures['taken'] * (2 if candidate == 'message_filters' else 1)
        return {**row, **figures, 'lost': sent - taken}


def describe(candidate: str, row: Mapping[str, Any]) -> str:
    """Return the line of the table for a candidate."""
    parts = '  '.join(f'{name} {cpu:.1%}' for name, cpu in row['cpu'].items())
    memory = sum(row['memory'].values())
    return (f'{candidate:16s} {sum(row["cpu"].values()):7.1%} '
            f'{1e3 * row["p50_s"]:7.1f} ms '
            f'{1e3 * row["p99_s"]:7.1f} ms {row["lost"]:>6} {row.get("missing in the bag", ""):>6}'
            f' {memory:6.0f} MB {row["ready_s"]:6.1f} s   {parts}')


def describe_ratios(ours: str, peer: str,
                    rows: Mapping[str, Sequence[Mapping[str, Any]]]) -> str:
    """Return CPU and latencies of a graph as ratios to a peer: in one round, then the median."""
    rounds = [(one['p50_s'] / other['p50_s'], one['p99_s'] / other['p99_s'],
               sum(one['cpu'].values()) / sum(other['cpu'].values()))
              for one, other in zip(rows[ours], rows[peer])]
    p50, p99, cpu = (median(column) for column in zip(*rounds))
    least, most = min(ratios[2] for ratios in rounds), max(ratios[2] for ratios in rounds)
    return (f'{ours} / {peer}: CPU {cpu:.2f} ({least:.2f} to {most:.2f}), p50 {p50:.1f}, '
            f'p99 {p99:.1f}')


def compare(arguments: argparse.Namespace) -> None:
    """Measure the candidates in turn, round by round, and print a table for each rate."""
    candidates = [name for name in CANDIDATES if name in arguments.only]
    if 'message_filters' in candidates and not has_message_filters():
        candidates.remove('message_filters')
        print('message_filters is not there, so that peer is skipped. To have it, put '
              'filters/src on PYTHONPATH after\n'
              'git clone -b jazzy https://github.com/ros2/message_filters filters')
    for rate_hz in arguments.rates:
        print(f'\n2 topics x {rate_hz:g} Hz for {arguments.seconds:g} s, the least of '
              f'{arguments.rounds} rounds; what stands for the sensors is not counted\n'
              f'{"":16s} {"CPU":>7s} {"p50":>10s} {"p99":>10s} {"lost":>6s} '
              f'{"bag":>6s} {"memory":>9s} {"ready":>8s}', flush=True)
        rows: dict[str, list[dict[str, Any]]] = {name: [] for name in candidates}
        for _ in range(arguments.rounds):
            for name in candidates:
                rows[name].append(measure(name, rate_hz, arguments.seconds,
                                          not arguments.without_drivers))
        for name in candidates:
            least = {figure: min(row[figure] for row in rows[name])
                     for figure in ('p50_s', 'p99_s', 'ready_s')}
            print(describe(name, {
                **min(rows[name], key=lambda row: sum(row['cpu'].values())), **least,
                'lost': max(row['lost'] for row in rows[name])}), flush=True)
        for ours, other in [*itertools.product(OURS + STOCK_OURS, PEERS), *zip(OURS, STOCK_OURS)]:
            if ours in rows and other in rows:
                print(describe_ratios(ours, other, rows), flush=True)


def has_message_filters() -> bool:
    """Tell whether the peer of that name can run."""
    spec = find_spec('message_filters')
    # A bare folder of that name, such as a checkout of it, counts as a package without a file.
    return spec is not None and spec.origin is not None


def rows_of_memory(rate_hz: float, hours: float) -> Iterator[tuple[float, dict[str, float]]]:
    """Yield the share of a day that was fed faster than real time, and the memory by then."""
    domain = 1 + (os.getpid() * 7 + int(time.time())) % 100
    with TemporaryDirectory(prefix='live') as name:
        folder = Path(name)
        parts = start('graph', folder, domain)
        source = Process([HERE, '--publish', f'--rate={rate_hz}', '--subscribers=2',
                          f'--seconds={3600 * hours}', '--faster=1'], folder, domain)
        began_s = float(source.say())
        done = False
        over = threading.Event()
        threading.Thread(target=lambda: (source.say(), over.set()), daemon=True).start()
        while not done:
            done = over.wait(5.0)
            yield (time.time() - began_s, {part: process.memory_mb()
                                           for part, process in parts.items()})
        source.process.communicate('\n', timeout=60.0)
        for process in parts.values():
            process.process.send_signal(signal.SIGINT)
        for process in parts.values():
            process.process.communicate(timeout=300.0)


def day(arguments: argparse.Namespace) -> None:
    """Print the memory of each node while a day of stamps passes."""
    print(f'{arguments.hours:g} h of stamps at 2 x {arguments.day_rate:g} Hz, as fast as the '
          'graph takes them: resident memory, MB')
    print(f'{"after":>8s} ' + ' '.join(f'{name:>13s}' for name in NODES))
    for span_s, memory in rows_of_memory(arguments.day_rate, arguments.hours):
        print(f'{span_s:6.0f} s ' + ' '.join(f'{memory[name]:13.0f}' for name in NODES),
              flush=True)


def lateness_ms(over: threading.Event) -> np.ndarray:
    """Wake every 5 ms as a thread that reads a source does; return how late it was, ms."""
    late = []
    while not over.is_set():
        due_s = time.monotonic() + 0.005
        time.sleep(0.005)
        late.append(1e3 * (time.monotonic() - due_s))
    return np.array(late)


def judging(arguments: argparse.Namespace) -> None:
    """Print how late a thread wakes while another one judges a long run, and without."""
    rng, n = np.random.default_rng(1), round(3600 * arguments.hours * arguments.day_rate)
    compliance = Compliance(Settings.from_mapping(NORMS))
    stamps = 10 ** 18 + round(1e9 / arguments.day_rate) * np.arange(n)
    for lo in range(0, n, 100000):
        part = stamps[lo:lo + 100000]
        rs_deg = 90.0 + 5.0 * np.sin(part / 3e10)
        compliance.update(Pairs.of(part, rs_deg + rng.normal(0.0, 0.1, len(part)), rs_deg))
    print(f'a run of {arguments.hours:g} h at {arguments.day_rate:g} Hz: how late a thread wakes '
          'that shares the process\n'
          f'{"":10s} {"span":>8s} {"median":>9s} {"p99":>9s} {"most":>9s}')
    for name, work in (('idle', lambda: time.sleep(3.0)), ('judging', compliance.finish)):
        over, began_s = threading.Event(), time.monotonic()
        worker = threading.Thread(target=lambda work=work, over=over: (work(), over.set()))
        worker.start()
        late = lateness_ms(over)
        print(f'{name:10s} {time.monotonic() - began_s:6.1f} s {np.median(late):6.1f} ms '
              f'{np.quantile(late, 0.99):6.1f} ms {late.max():6.1f} ms', flush=True)


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description=__doc__.partition('\n\n')[0].strip())
    parser.add_argument('--rates', type=float, nargs='+', default=[10.0, 100.0, 1000.0],
                        help='messages per second and topic')
    parser.add_argument('--seconds', type=float, default=15.0, help='length of a measurement')
    parser.add_argument('--rounds', type=int, default=3, help='goes of each candidate')
    parser.add_argument('--only', nargs='+', choices=CANDIDATES, default=PEERS + OURS,
                        help='candidates to measure')
    parser.add_argument('--day', action='store_true', help='memory over many hours of stamps')
    parser.add_argument('--judging', action='store_true', help='threads beside the judge')
    parser.add_argument('--hours', type=float, default=24.0, help='hours of stamps')
    parser.add_argument('--day-rate', type=float, default=10.0, help='rate of the stamps')
    parser.add_argument('--without-drivers', action='store_true',
                        help='graphs take topics of another package')
    parser.add_argument('--ports', type=int, nargs='*', default=[], help=argparse.SUPPRESS)
    parser.add_argument('--publish', action='store_true', help=argparse.SUPPRESS)
    parser.add_argument('--rate', type=float, default=100.0, help=argparse.SUPPRESS)
    parser.add_argument('--subscribers', type=int, default=1, help=argparse.SUPPRESS)
    parser.add_argument('--faster', type=float, default=0.0, help=argparse.SUPPRESS)
    parser.add_argument('--peer', default='', help=argparse.SUPPRESS)
    parser.add_argument('--watch', action='store_true', help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.publish:
        publish(given.rate, given.seconds, given.subscribers, given.faster, given.ports)
    elif given.peer:
        peer(given.peer)
    elif given.watch:
        watch()
    elif given.judging:
        judging(given)
    elif given.day:
        day(given)
    else:
        compare(given)
