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
Memory, CPU and journal of synchronizer and compliance over a month of daily runs.

Both nodes run in this process and take headings with the stamps of a month, as fast as they can.
"""

from __future__ import annotations

import argparse
import gc
import os
from pathlib import Path
import tempfile
import time
from typing import Iterator, NamedTuple

import numpy as np

os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'OFF')

import rclpy  # noqa: E402
from rclpy.context import Context  # noqa: E402
from rclpy.executors import SingleThreadedExecutor  # noqa: E402
from rclpy.node import Node  # noqa: E402
from rclpy.signals import SignalHandlerOptions  # noqa: E402
from sensor_msgs.msg import Imu  # noqa: E402

from heading_intercompare.core.records import Headings  # noqa: E402
from heading_intercompare.messages.heading_messages import imu_messages  # noqa: E402
from heading_intercompare.nodes.compliance import Compliance  # noqa: E402
from heading_intercompare.nodes.interface import qos  # noqa: E402
from heading_intercompare.nodes.interface.parameters import make_overrides  # noqa: E402
from heading_intercompare.nodes.synchronizer import Synchronizer  # noqa: E402

S = 1_000_000_000
DAY_S = 86_400
T0_NS = 20_000 * DAY_S * S
AT_ONCE = 500


class Day(NamedTuple):
    """What both nodes take after a day: megabytes, CPU seconds of the day, runs judged."""

    day: int
    rss_mb: float
    journal_mb: float
    cpu_s: float
    runs: int


def rss_mb() -> float:
    """Return the resident memory of this process."""
    gc.collect()
    pages = int(Path('/proc/self/statm').read_text().split()[1])
    return pages * os.sysconf('SC_PAGESIZE') / 1e6


def run(days: int, step_s: float, folder: str) -> Iterator[Day]:
    """Yield the state after each day."""
    rng = np.random.default_rng(1)
    settings = {'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1,
                'runs.cut_at_utc': '00:00', 'runs.keep': 3, 'runs.gap_s': 20.0 * step_s,
                'pairing.method': 'nearest', 'window_s': 3600.0}
    context = Context()
    rclpy.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
    executor = SingleThreadedExecutor(context=context)
    plain = Node('sensors', context=context)
    judging = {**settings, 'report_dir': folder, 'logbook': f'{folder}/book.sqlite'}
    compliance = Compliance(True, context=context, parameter_overrides=make_overrides(judging))
    synchronizer = Synchronizer(compliance, context=context, parameter_overrides=make_overrides(
        {**settings, 'subscribers': 0}))
    nodes = [synchronizer, compliance]
    for node in (plain, *nodes):
        executor.add_node(node)
    sensors = [plain.create_publisher(Imu, f'{role}/heading', qos.HEADINGS_OUT)
               for role in ('ts', 'rs')]
    while not all(sensor.get_subscription_count() for sensor in sensors):
        executor.spin_once(0.05)
    per_day = round(DAY_S / step_s)
    for day in range(days):
        began_s = time.process_time()
        t = day * DAY_S + np.arange(per_day) * step_s
        stamps = T0_NS + np.round(t * 1e9).astype(np.int64)
        true = 350.0 + 20.0 * np.sin(t / 300.0)
        chunks = [Headings.of(stamps, (true + rng.normal(0.0, sigma, per_day)) % 360.0)
                  for sigma in (0.2, 0.05)]
        for lo in range(0, per_day, AT_ONCE):
            for sensor, chunk in zip(sensors, chunks):
                for message in imu_messages(chunk[lo:lo + AT_ONCE], 'x'):
                    sensor.publish(message)
            taken = day * per_day + min(lo + AT_ONCE, per_day)
            intakes = synchronizer._headings.intakes.values()
            while min(intake.received for intake in intakes) < taken:
                executor.spin_once(0.05)
        while compliance.n_pairs < synchronizer._makers['ts', 'rs'].pairer.ledger.paired:
            executor.spin_once(0.05)
        journal = Path(folder, 'compliance.journal')
        yield Day(day + 1, rss_mb(), journal.stat().st_size / 1e6,
                  time.process_time() - began_s,
                  compliance.comparison.tested['ts'].compliance.finished_runs)
    executor.shutdown()
    for node in (plain, *nodes):
        node.destroy_node()
    context.try_shutdown()


def main() -> None:
    """Print a row per day."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--days', type=int, default=30)
    parser.add_argument('--step-s', type=float, default=5.0, help='time between two readings')
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        print('day   rss [MB]   journal [MB]   cpu [s]   runs')
        for row in run(given.days, given.step_s, folder):
            print(f'{row.day:3d}   {row.rss_mb:8.1f}   {row.journal_mb:12.2f}   {row.cpu_s:7.1f}'
                  f'   {row.runs:4d}', flush=True)


if __name__ == '__main__':
    main()
