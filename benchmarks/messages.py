#!/usr/bin/env python3
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
The cost of messages: as bytes in columns, as rclpy objects, and on the whole live path.

    python benchmarks/messages.py
    python benchmarks/messages.py --only live --rate 1000 --rate 10 --tree ../former_checkout

The first table shows the time per message, in chunks of several sizes, from the bytes that rclpy
takes to headings or pairs, and from those to the bytes that it publishes. Next to it is the time
with message objects and a loop, as in an ordinary rclpy node. Both give the same results to the
bit.

The second table shows the CPU time of the nodes synchronizer and compliance, in one process that
takes two topics of sensor_msgs/Imu from another: per heading, and as a share of one core. With
`--tree` the nodes of another checkout are measured in turn with these. Run nothing else meanwhile.
"""

from __future__ import annotations

import argparse
import json
import math
import os
from pathlib import Path
import subprocess
import sys
import time
from typing import Any, Callable, Sequence

from geometry_msgs.msg import TwistStamped
import numpy as np
import rclpy
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import Imu

ROOT = Path(__file__).resolve().parent.parent
TOPICS = ('ts/heading', 'rs/heading')
SECOND_NS = 1_000_000_000
START_NS = 1_700_000_000 * SECOND_NS
NORMS = {'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1}
QUIET_S = 2.0
REPEATS = 5


def set_stamp(message: Any, ns: int) -> None:
    """Give a message object its stamp."""
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(ns, SECOND_NS)


def objects_of_headings(headings: Any, frame_id: str) -> list[bytes]:
    """Return headings as bytes, through message objects."""
    from heading_intercompare.core.angles import quaternion_from_heading
    z, w = quaternion_from_heading(headings.heading_deg)
    sent = []
    for ns, z_, w_ in zip(headings.stamp_ns.tolist(), z.tolist(), w.tolist()):
        message = Imu()
        set_stamp(message, ns)
        message.header.frame_id = frame_id
        valid = math.isfinite(z_)
        message.orientation.z = z_ if valid else 0.0
        message.orientation.w = w_ if valid else 0.0
        message.orientation_covariance[0] = 0.0 if valid else -1.0
        message.angular_velocity_covariance[0] = -1.0
        message.linear_acceleration_covariance[0] = -1.0
        sent.append(serialize_message(message))
    return sent


def headings_of_objects(messages: Sequence[bytes]) -> Any:
    """Return headings from bytes, through message objects."""
    from heading_intercompare.core.angles import heading_from_quaternion
    from heading_intercompare.core.records import Headings
    stamps, rows = [], []
    for data in messages:
        message = deserialize_message(data, Imu)
        stamps.append(message.header.stamp.sec * SECOND_NS + message.header.stamp.nanosec)
        q = message.orientation
        known = message.orientation_covariance[0] != -1.0
        rows.append((q.x, q.y, q.z, q.w) if known else (math.nan,) * 4)
    return Headings.of(stamps, heading_from_quaternion(*zip(*rows), 'enu'))


def objects_of_pairs(pairs: Any) -> list[bytes]:
    """Return pairs as bytes, through message objects."""
    from heading_intercompare.core.pairing.difference import subtract
    sent = []
    for ns, *row in zip(*(column.tolist() for column in (
            pairs.stamp_ns, subtract(pairs).x_deg, pairs.rs_deg, pairs.ts_deg, pairs.lag_ns,
            pairs.rs_variance_factor, pairs.ts_variance_factor))):
        message = TwistStamped()
        set_stamp(message, ns)
        linear, angular = message.twist.linear, message.twist.angular
        linear.x, linear.y, linear.z = row[:3]
        angular.x, angular.y, angular.z = row[3] / 1e9, row[4], row[5]
        sent.append(serialize_message(message))
    return sent


def pairs_of_objects(messages: Sequence[bytes]) -> Any:
    """Return pairs from bytes, through message objects."""
    from heading_intercompare.core.records import Pairs
    stamps, rows = [], []
    for data in messages:
        message = deserialize_message(data, TwistStamped)
        stamps.append(message.header.stamp.sec * SECOND_NS + message.header.stamp.nanosec)
        linear, angular = message.twist.linear, message.twist.angular
        rows.append((linear.z, linear.y, round(angular.x * 1e9), angular.y, angular.z or 1.0))
    return Pairs.of(stamps, *map(list, zip(*rows)))


def measure_time(work: Callable[[Any], Any], chunks: Sequence[Any], count: int) -> float:
    """Return the CPU time per message, microseconds: the least of several rounds."""
    least = math.inf
    for _ in range(REPEATS):
        began = time.process_time()
        for chunk in chunks:
            work(chunk)
        least = min(least, time.process_time() - began)
    return 1e6 * least / count


def compare_codecs(count: int, sizes: Sequence[int]) -> None:
    """Print the time per message both ways, for chunks of several sizes."""
    from heading_intercompare.core.records import Headings, Pairs
    from heading_intercompare.messages.heading_messages import (
        IMU,
        imu_messages,
        pair_messages,
        read_headings,
        read_pairs,
    )
    rng = np.random.default_rng(1)
    stamps = START_NS + np.arange(count) * SECOND_NS // 10
    headings = Headings.of(stamps, rng.uniform(0.0, 360.0, count))
    pairs = Pairs.of(stamps, *rng.uniform(0.0, 360.0, (2, count)), np.arange(count),
                     *rng.uniform(0.5, 1.0, (2, count)))
    imus, twists = imu_messages(headings, 'ts_heading'), pair_messages(pairs)
    arrived = headings_of_objects(imus)
    assert read_headings(IMU, 'enu', imus) == (arrived, [])
    assert pairs_of_objects(twists) == pairs == read_pairs(twists)[0]
    assert [deserialize_message(m, Imu) for m in objects_of_headings(headings, 'ts_heading')] == [
        deserialize_message(m, Imu) for m in imus]
    rows = (('headings in', imus, headings_of_objects, lambda m: read_headings(IMU, 'enu', m)),
            ('headings out', headings, lambda h: objects_of_headings(h, 'ts_heading'),
             lambda h: imu_messages(h, 'ts_heading')),
            ('pairs in', twists, pairs_of_objects, read_pairs),
            ('pairs out', pairs, objects_of_pairs, pair_messages))
    print(f'CPU time per message, us; {count} messages\n')
    print(f'{"":14s}{"chunk":>8s}{"objects":>10s}{"columns":>10s}{"times":>8s}')
    for name, data, by_objects, by_columns in rows:
        for size in sizes:
            n = min(count, 400 * size)
            chunks = [data[lo:lo + size] for lo in range(0, n, size)]
            theirs, ours = (measure_time(work, chunks, n) for work in (by_objects, by_columns))
            print(f'{name:14s}{size:8d}{theirs:10.2f}{ours:10.2f}{theirs / ours:8.1f}')


def run_nodes(count: int) -> None:
    """Take headings and judge them until nothing more comes; print what that took."""
    from heading_intercompare.nodes.compliance import Compliance
    from heading_intercompare.nodes.interface.parameters import make_overrides
    from heading_intercompare.nodes.synchronizer import Synchronizer
    rclpy.init()
    settings = make_overrides({**NORMS, 'pairing.method': 'interpolate'})
    nodes = [make(parameter_overrides=settings) for make in (Compliance, Synchronizer)]
    executor = SingleThreadedExecutor()
    for node in nodes:
        executor.add_node(node)
    taken = [*nodes[1]._headings.intakes.values()]
    while not any(intake.received for intake in taken):
        executor.spin_once(0.05)
    cpu_s, began_s = time.process_time(), time.monotonic()
    newest_s, before = began_s, -1
    while time.monotonic() < newest_s + QUIET_S:
        executor.spin_once(0.05)
        if nodes[0].n_pairs != before:
            newest_s, before = time.monotonic(), nodes[0].n_pairs
            cpu, span = time.process_time() - cpu_s, newest_s - began_s
    received = sum(intake.received for intake in taken)
    print(json.dumps({'cpu_s': cpu, 'span_s': span, 'headings': received,
                      'lost': count - received, 'pairs': nodes[0].n_pairs}), flush=True)
    os._exit(0)


def publish(rate_hz: float, count: int) -> None:
    """Publish headings of both sensors from a single message object."""
    rclpy.init()
    node = rclpy.create_node('benchmark_publisher')
    publishers = [node.create_publisher(Imu, t, QoSProfile(depth=1000)) for t in TOPICS]
    message = Imu()
    message.header.frame_id = 'gyro'
    sent = []
    for i in range(count // 2):
        set_stamp(message, START_NS + i * SECOND_NS // 10)
        angle = math.radians(90.0 - 0.05 * i) / 2.0
        message.orientation.z, message.orientation.w = math.sin(angle), math.cos(angle)
        sent.append(serialize_message(message))
    while any(p.get_subscription_count() < 1 for p in publishers):
        time.sleep(0.05)
    time.sleep(3.0)
    began = time.monotonic()
    for i, data in enumerate(sent):
        time.sleep(max(0.0, began + i / rate_hz - time.monotonic()))
        for publisher in publishers:
            publisher.publish(data)
    for publisher in publishers:
        publisher.wait_for_all_acked(Duration(seconds=5))
    time.sleep(2.0 * QUIET_S)
    rclpy.try_shutdown()


def measure_live(tree: Path, rate_hz: float, count: int) -> dict[str, float]:
    """Return the figures of the nodes of a checkout."""
    environment = {**os.environ, 'PYTHONPATH': f'{tree}{os.pathsep}'
                   + os.environ.get('PYTHONPATH', ''),
                   'ROS_DOMAIN_ID': str(1 + os.getpid() % 100),
                   'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
    words = [f'--rate={rate_hz}', f'--count={count}']

    def start(role: str) -> subprocess.Popen:
        return subprocess.Popen([sys.executable, __file__, role, *words], env=environment,
                                stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    nodes, publisher = start('--nodes'), start('--publish')
    out, _ = nodes.communicate(timeout=count / rate_hz + 120.0)
    publisher.communicate(timeout=60.0)
    return json.loads(out.strip().splitlines()[-1])


def compare_live(trees: Sequence[Path], rates_hz: Sequence[float], count: int,
                 seconds: float) -> None:
    """Print the figures of the nodes of each checkout, in turn, at each rate."""
    print('synchronizer and compliance; CPU\n')
    print(f'{"rate, Hz":>9s}{"headings":>10s}{"us each":>9s}{"share":>8s}{"lost":>6s}{"pairs":>8s}'
          '  checkout')
    for rate_hz in rates_hz:
        n = min(count, int(2 * rate_hz * seconds))
        for tree in trees:
            row = measure_live(tree, rate_hz, n)
            print(f'{rate_hz:9g}{row["headings"]:10d}{1e6 * row["cpu_s"] / row["headings"]:9.1f}'
                  f'{row["cpu_s"] / row["span_s"]:8.1%}{row["lost"]:6d}{row["pairs"]:8d}  {tree}',
                  flush=True)


def main() -> None:
    """Print the requested tables."""
    parser = argparse.ArgumentParser(description=__doc__.partition('\n\n')[0].strip())
    parser.add_argument('--only', choices=('codec', 'live'), help='measure only this')
    parser.add_argument('--count', type=int, default=20_000, help='messages')
    parser.add_argument('--chunk', type=int, action='append', help='messages in a chunk')
    parser.add_argument('--rate', type=float, action='append',
                        help='headings per second and topic')
    parser.add_argument('--seconds', type=float, default=20.0, help='longest live measurement')
    parser.add_argument('--tree', type=Path, action='append', default=[],
                        help='another checkout whose nodes to measure too')
    parser.add_argument('--nodes', action='store_true', help=argparse.SUPPRESS)
    parser.add_argument('--publish', action='store_true', help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.nodes:
        run_nodes(given.count)
    elif given.publish:
        publish(given.rate[0], given.count)
    if given.only != 'live' and not (given.nodes or given.publish):
        compare_codecs(given.count, given.chunk or (1, 5, 50, 1000))
    if given.only != 'codec' and not (given.nodes or given.publish):
        compare_live([*given.tree, ROOT], given.rate or (1000.0, 10.0), given.count,
                     given.seconds)


if __name__ == '__main__':
    main()
