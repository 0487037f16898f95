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
Memory of the graph in one process while a long trial passes, faster than real time.

    python benchmarks/memory_of_a_trial.py                        # both trials: 1 h
    python benchmarks/memory_of_a_trial.py --only day --hours 6

The trials are a day at 2 x 10 Hz in runs that the clock cuts, and an hour at 2 x 1000 Hz in one
run. The graph is that of `live` and `demo`: simulator, synchronizer, compliance and recorder, with
bag, journal and reports. Its peer is a plain rclpy node in a process of its own, which hears the
same two topics at the same time and keeps nothing. The simulator sends the next readings once the
last ones are paired, so the trial passes as fast as the graph takes it. The peer may miss some.

Memory is what is resident, at the time of the stamps. It counts as warm after a quarter of the
trial. Growth is the slope of a line through the samples after that, per hour of stamps. A pair is
lost if a reading of the TS has none, but for the first one, which comes before the RS.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
import os
from pathlib import Path
import resource
import sys
from tempfile import TemporaryDirectory
import time
from typing import Any, Mapping, NamedTuple

from live import listen, LONGEST_WAIT_S, Process, read_losses, TOPICS
import numpy as np

from heading_intercompare.app.scenarios import read_scenario
from heading_intercompare.cli.commands.graph.demo import NORMS

HERE = str(Path(__file__).resolve())
PROCESSES = 'graph', 'plain'
#: Samples of a trial, and the share of it after which memory counts as warm.
SAMPLES, WARM = 96, 0.25
#: The most readings of a sensor that were sent and are not paired. A subscription holds 5000, and
#: the first second of a stream is held.
AHEAD = 2000
#: Pairs flow from the first reading on.
RULE = {**NORMS, 'pairing.method': 'interpolate'}


class TrialPlan(NamedTuple):
    """A trial: readings per second of each sensor, its length, and what its rule adds."""

    rate_hz: float
    hours: float
    rule: Mapping[str, Any]


class TrialMemory(NamedTuple):
    """
    What a trial took.

    Attributes
    ----------
    samples : ndarray, shape (n, 3)
        Hours of stamps, and the megabytes of the graph and of the plain node by then.
    heard, n_sent
        Number of messages that the plain node heard, and of readings of each sensor.
    lost
        Number of those that are missing, by what they are.

    """

    samples: np.ndarray
    peak_mb: float
    took_s: float
    heard: int
    n_sent: int
    n_pairs: int
    lost: Mapping[str, int]


TRIALS = {'day': TrialPlan(10.0, 24.0, {'runs.every_h': 2.0}), 'hour': TrialPlan(1000.0, 1.0, {})}


def run_graph(plan: TrialPlan) -> None:
    """Run the graph in this folder; print its pairs, and last its peak in MB and what was sent."""
    from heading_intercompare.nodes.graph import intercompare, Source
    from heading_intercompare.nodes.sensor_simulator import SensorSimulator
    n_pairs, moved_s, sent_s = 0, time.monotonic(), 0.0

    class PacedSimulator(SensorSimulator):
        """Waits for the pairs: in one process the middleware acknowledges what is not taken."""

        def _tick(self) -> None:
            nonlocal sent_s
            # Pairs that are lost do not come.
            if (sent_s * plan.rate_hz < n_pairs + AHEAD
                    or time.monotonic() > moved_s + LONGEST_WAIT_S):
                super()._tick()
                sent_s = 0.0 if self._trial is None else self._trial.now_s

    def take(n: int) -> None:
        nonlocal n_pairs, moved_s
        if n > n_pairs:
            n_pairs, moved_s = n, time.monotonic()
        print(n, flush=True)
    scenario = read_scenario('demo').scenario
    ts, rs = (replace(sensor, rate_hz=plan.rate_hz, phase_s=phase / plan.rate_hz)
              for sensor, phase in ((scenario.ts, 0.0), (scenario.rs, 0.3)))
    trial = replace(scenario, duration_s=3600.0 * plan.hours, ts=ts, rs=rs)
    settings = {**trial.to_mapping(), 'speed': 0.0, 'stamps': 'scenario', 'max_rate_hz': 1e4}
    intercompare([Source(PacedSimulator, 'sensor_simulator', settings)], {**RULE, **plan.rule},
                 output='bag', report_dir='out', progress=take)
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    print('peak', peak_mb, round(sent_s * plan.rate_hz), flush=True)


def run_peer() -> None:
    """Hear both topics and keep nothing; print at SIGINT how many messages came."""
    from sensor_msgs.msg import Imu
    counts = dict.fromkeys(TOPICS, 0)

    def subscribe(node: Any) -> None:
        for topic in TOPICS:
            def take(_: Imu, topic: str = topic) -> None:
                counts[topic] += 1
            node.create_subscription(Imu, topic, take, 5000)
    listen('benchmark_peer', subscribe, lambda: sum(counts.values()))


def measure(name: str, plan: TrialPlan, domain: int) -> TrialMemory:
    """Run graph and peer in a ROS domain; print and return their memory, and what was lost."""
    next_h = 0.0
    samples: list[tuple[float, float, float]] = []
    with TemporaryDirectory(prefix='memory', dir='/var/tmp') as folder:
        began_s = time.monotonic()
        graph, peer = (Process([HERE, f'--run={process}', f'--only={name}',
                                f'--hours={plan.hours}'], Path(folder), domain)
                       for process in PROCESSES)
        while not (line := graph.say()).startswith('peak'):
            if (now_h := int(line) / plan.rate_hz / 3600.0) > next_h:
                next_h = now_h + plan.hours / SAMPLES
                samples.append((now_h, graph.memory_mb(), peer.memory_mb()))
                print('{:8.3f} h {:8.1f} MB {:8.1f} MB'.format(*samples[-1]), flush=True)
        took_s = time.monotonic() - began_s
        graph.process.communicate(timeout=LONGEST_WAIT_S)
        heard = int(peer.interrupt())
        # A graph that a signal ends has not sent all.
        n = int(line.split()[2])
        losses = read_losses(Path(folder), 2 * n)
    paired = losses['paired']
    return TrialMemory(np.array(samples), float(line.split()[1]), took_s, heard, n, paired, {
        'pairs': n - 1 - paired, 'readings': losses['lost'],
        'readings in the bag': losses['missing in the bag'],
        'pairs in the bag': paired - losses['pairs in the bag']})


def describe(name: str, plan: TrialPlan, memory: TrialMemory) -> str:
    """Return the table of a trial."""
    hours, *columns = memory.samples.T
    warm, middle = np.searchsorted(hours, (WARM * hours[-1], 0.5 * hours[-1]))
    lines = [
        f'{name}: {hours[-1]:.2f} h at 2 x {plan.rate_hz:g} Hz in {memory.took_s:.0f} s; '
        f'{memory.n_pairs} pairs; the plain node heard {memory.heard} of {2 * memory.n_sent}; '
        f'peak of the graph {memory.peak_mb:.0f} MB',
        'lost: ' + ', '.join(f'{count} {what}' for what, count in memory.lost.items()),
        f'{"":8s}{"warm":>10s}{"middle":>10s}{"end":>10s}{"growth":>15s}{"end / warm":>12s}']
    for process, memory_mb in zip(PROCESSES, columns):
        slope = np.polyfit(hours[warm:], memory_mb[warm:], 1)[0]
        lines.append(f'{process:8s}{memory_mb[warm]:7.1f} MB{memory_mb[middle]:7.1f} MB'
                     f'{memory_mb[-1]:7.1f} MB{slope:10.3f} MB/h'
                     f'{memory_mb[-1] / memory_mb[warm]:12.3f}')
    return '\n'.join(lines)


def main() -> int:
    """Measure the trials."""
    parser = argparse.ArgumentParser(description=__doc__.strip().partition('\n')[0])
    parser.add_argument('--only', choices=TRIALS, help='the trial to measure (default: both)')
    parser.add_argument('--hours', type=float, help='hours of stamps (default: the whole trial)')
    parser.add_argument('--run', choices=PROCESSES, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    for name in [arguments.only] if arguments.only else TRIALS:
        plan = TRIALS[name]._replace(**{'hours': arguments.hours} if arguments.hours else {})
        if arguments.run == 'graph':
            run_graph(plan)
        elif arguments.run:
            run_peer()
        else:
            domain = 1 + (os.getpid() * 7 + int(time.time())) % 100
            print(f'\n{describe(name, plan, measure(name, plan, domain))}', flush=True)
    return 0


if __name__ == '__main__':
    sys.exit(main())
