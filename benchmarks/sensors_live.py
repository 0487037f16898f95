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
The graph of four sensors next to three graphs of two: CPU of each.

    python benchmarks/sensors_live.py                 # 4 topics x 100 Hz
    python benchmarks/sensors_live.py --rate 10 --rounds 3

One process publishes the headings of four sensors. It stands for the drivers, and its CPU is not
counted. The candidates take them in turn:

* four: `live` with the setting `sensors`, one process, which also compares the three pairs without
  the reference;
* three: three processes `live`, each with one tested sensor and the reference.

CPU is the share of one core, user and system, of all threads. The ratio is that of one round; the
last line has the median of all rounds.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path
import signal
from statistics import median
import sys
from tempfile import TemporaryDirectory
import time
from typing import Sequence

from live import FIRST_WAIT_S, LONGEST_WAIT_S, Process
import numpy as np

from heading_intercompare.core.records import Headings
from heading_intercompare.messages.heading_messages import imu_messages

HERE = str(Path(__file__).resolve())
NAMES = 'a', 'b', 'c', 'd'
#: What hears a tested sensor, and what hears the reference.
SUBSCRIBERS = {'four': (2, 2), 'three': (2, 6)}
COMMON = {'pairing.method': 'interpolate'}
ROWS = '; '.join(f'{name} sigma_max_deg=0.2 topic=/{name}/heading' for name in NAMES) + ' rs'


def publish(rate_hz: float, seconds: float, wanted: Sequence[int]) -> None:
    """Publish all topics once they have their subscriptions; print when."""
    import rclpy
    from sensor_msgs.msg import Imu
    rclpy.init()
    node = rclpy.create_node('benchmark_publisher')
    publishers = [node.create_publisher(Imu, f'/{name}/heading', 5000) for name in NAMES]
    deadline_s = time.monotonic() + LONGEST_WAIT_S
    while any(publisher.get_subscription_count() < wanted[name == NAMES[-1]]
              for name, publisher in zip(NAMES, publishers)):
        if time.monotonic() > deadline_s:
            raise SystemExit('no subscriber')
        time.sleep(0.02)
    print('there', flush=True)
    rng, began_s = np.random.default_rng(1), time.monotonic()
    for i in range(round(rate_hz * seconds)):
        for late, publisher in enumerate(publishers):
            due_s = began_s + (i + late / len(NAMES)) / rate_hz
            time.sleep(max(0.0, due_s - time.monotonic()))
            one = Headings.of([time.time_ns()], [90.0 + rng.normal(0.0, 0.1)])
            publisher.publish(imu_messages(one, 'gyro')[0])
    rclpy.try_shutdown()


def start(candidate: str, folder: Path, domain: int) -> list[Process]:
    """Start the processes of a candidate."""
    def live(name: str, *given: str, **settings: str) -> Process:
        words = [word for key, value in {**COMMON, **settings}.items()
                 for word in ('--set', f'{key}={value}')]
        return Process(['-m', 'heading_intercompare', 'live', *given, *words, '-o', name,
                        '--quiet'], folder, domain)
    if candidate == 'four':
        return [live('four', **{'sensors': ROWS})]
    norms = {'norms.sigma_max_deg': '0.2', 'norms.sigma_ref_max_deg': '0.2'}
    return [live(name, '--namespace', f'/of_{name}', '--ts', f'/{name}/heading', '--rs',
                 f'/{NAMES[-1]}/heading', **norms) for name in NAMES[:-1]]


def measure(candidate: str, rate_hz: float, seconds: float) -> float:
    """Return the CPU of all processes of a candidate, as a share of one core."""
    domain = 1 + (os.getpid() * 7 + int(time.time())) % 100
    with TemporaryDirectory(prefix='sensors') as name:
        parts = start(candidate, Path(name), domain)
        tested, reference = SUBSCRIBERS[candidate]
        source = Process([HERE, '--publish', f'--rate={rate_hz}', '--seconds',
                          str(seconds + FIRST_WAIT_S), '--subscribers', str(tested),
                          str(reference)], Path(name), domain)
        if not source.say():
            raise SystemExit('the publisher found no subscribers')
        time.sleep(FIRST_WAIT_S)
        before_s, since_s = sum(part.cpu_s() for part in parts), time.monotonic()
        time.sleep(max(0.1, seconds - 1.0))
        used_s = sum(part.cpu_s() for part in parts) - before_s
        share = used_s / (time.monotonic() - since_s)
        source.process.communicate(timeout=60.0)
        for part in parts:
            part.process.send_signal(signal.SIGINT)
        for part in parts:
            part.process.communicate(timeout=120.0)
        return share


def main() -> int:
    """Measure both candidates in turn, round by round."""
    parser = argparse.ArgumentParser(description=__doc__.strip().partition('\n')[0])
    parser.add_argument('--rate', type=float, default=100.0, help='readings per second')
    parser.add_argument('--seconds', type=float, default=30.0)
    parser.add_argument('--rounds', type=int, default=3)
    parser.add_argument('--publish', action='store_true', help=argparse.SUPPRESS)
    parser.add_argument('--subscribers', type=int, nargs=2, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.publish:
        publish(given.rate, given.seconds, given.subscribers)
        return 0
    print(f'4 topics x {given.rate:g} Hz for {given.seconds:g} s; the publisher is not counted')
    ratios = []
    for at in range(given.rounds):
        # Each goes first in turn.
        order = ('four', 'three') if at % 2 == 0 else ('three', 'four')
        cpu = {candidate: measure(candidate, given.rate, given.seconds) for candidate in order}
        ratios.append(cpu['four'] / cpu['three'])
        print(f'round {at + 1}: four sensors {cpu["four"]:.1%}, three times two sensors '
              f'{cpu["three"]:.1%} of a core; ratio {ratios[-1]:.2f}', flush=True)
    print(f'four / three: CPU {median(ratios):.2f}')
    return 0


if __name__ == '__main__':
    sys.exit(main())
