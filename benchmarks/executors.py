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
The cost of taking messages: executors and ways of taking, side by side.

    python benchmarks/executors.py [--rate 100] [--seconds 10] [--only WORD]

One process publishes two topics of sensor_msgs/Imu. Another process, with the candidate to
measure, takes them and converts them to headings. The table shows the CPU time of the second as a
share of one core, the latency from the call of `publish` to the heading, and the messages lost
according to `publication_sequence_number`. The nodes use the best candidate: see
`nodes/spinning/batches.py`.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time

import rclpy
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import Imu

from heading_intercompare.core.angles import heading_from_quaternion
from heading_intercompare.core.records import Headings
from heading_intercompare.messages.heading_messages import IMU, read_headings
from heading_intercompare.nodes.spinning.batches import take_all, Unwatched

TOPICS = ('ts/heading', 'rs/heading')
START_S = 3.0
QOS = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)


def publish(rate_hz: float, seconds: float) -> None:
    """Publish both topics once both are matched; stamps are the steady clock."""
    rclpy.init()
    node = rclpy.create_node('benchmark_publisher')
    publishers = [node.create_publisher(Imu, t, QoSProfile(depth=1000)) for t in TOPICS]
    deadline = time.monotonic() + 30.0
    while any(p.get_subscription_count() < 1 for p in publishers):
        if time.monotonic() > deadline:
            raise SystemExit('no subscriber')
        time.sleep(0.05)
    time.sleep(START_S)
    message = Imu()
    message.header.frame_id = 'gyro'
    message.orientation.w = 1.0
    began = time.monotonic()
    for i in range(int(rate_hz * seconds)):
        due = began + i / rate_hz
        time.sleep(max(0.0, due - time.monotonic()))
        for publisher in publishers:
            now_ns = time.monotonic_ns()
            message.header.stamp.sec = now_ns // 1_000_000_000
            message.header.stamp.nanosec = now_ns % 1_000_000_000
            publisher.publish(message)
    for publisher in publishers:
        publisher.wait_for_all_acked(rclpy.duration.Duration(seconds=5))
    # Best effort is not acknowledged: messages under way are lost when this process ends.
    time.sleep(1.0)
    rclpy.try_shutdown()


def headings_of_objects(messages: list[Imu]) -> Headings:
    """Return the headings of message objects."""
    quaternions = [(m.orientation.x, m.orientation.y, m.orientation.z, m.orientation.w)
                   for m in messages]
    return Headings.of([m.header.stamp.sec * 1_000_000_000 + m.header.stamp.nanosec
                        for m in messages], heading_from_quaternion(*zip(*quaternions), 'enu'))


class Count:
    """Latencies and losses of the messages taken."""

    def __init__(self, raw: bool) -> None:
        self.raw = raw
        self.latency_s: list[float] = []
        self.last: dict[str, int] = {}
        self.lost = 0

    def take(self, topic: str, taken: list[tuple]) -> None:
        """Convert messages to headings; count latencies and losses."""
        if not taken:
            return
        messages = [message for message, _ in taken]
        if self.raw:
            headings, _ = read_headings(IMU, 'enu', messages)
        else:
            headings = headings_of_objects(messages)
        now_ns = time.monotonic_ns()
        self.latency_s += [(now_ns - ns) / 1e9 for ns in headings.stamp_ns.tolist()]
        for _, info in taken:
            number = info['publication_sequence_number']
            self.lost += number - self.last.get(topic, number - 1) - 1
            self.last[topic] = number


def callbacks(executor_name: str, raw: bool):
    """Return the set-up in which the executor calls back for each message."""
    def prepare(node, count):
        executor = {'single': SingleThreadedExecutor, 'multi': MultiThreadedExecutor,
                    'events': EventsExecutor}[executor_name]()
        # EventsExecutor cannot call back with two arguments: only the total shows its losses.
        for topic in TOPICS:
            def one(message, topic=topic):
                count.take(topic, [(message, {'publication_sequence_number':
                                              count.last.get(topic, 0) + 1})])

            def two(message, info, topic=topic):
                count.take(topic, [(message, info)])
            if executor_name == 'events':
                node.create_subscription(Imu, topic, lambda m, f=one: f(m), QOS, raw=raw)
            else:
                node.create_subscription(Imu, topic, lambda m, i, f=two: f(m, i), QOS, raw=raw)
        executor.add_node(node)
        return lambda: executor.spin_once(0.2)
    return prepare


def drains(executor_name: str, raw: bool, rate_hz: float):
    """Return the set-up in which a timer takes all there is; the executor sees no message."""
    def prepare(node, count):
        executor = {'single': SingleThreadedExecutor, 'events': EventsExecutor}[executor_name]()
        owner = node
        if executor_name == 'events':
            # It knows no callback groups: a second node, not given to it, keeps them from it.
            owner = count.owner = rclpy.create_node('benchmark_second')
        group = Unwatched()
        subscriptions = [owner.create_subscription(Imu, topic, lambda m: None, QOS, raw=raw,
                                                   callback_group=group) for topic in TOPICS]

        def drain():
            for topic, subscription in zip(TOPICS, subscriptions):
                count.take(topic, take_all(subscription))
        node.create_timer(1.0 / rate_hz, drain)
        executor.add_node(node)
        return lambda: executor.spin_once(0.2)
    return prepare


def loop(raw: bool, rate_hz: float):
    """Return the set-up of a loop that sleeps and drains, spinning five times a second."""
    def prepare(node, count):
        executor = SingleThreadedExecutor()
        group = Unwatched()
        subscriptions = [node.create_subscription(Imu, topic, lambda m: None, QOS, raw=raw,
                                                  callback_group=group) for topic in TOPICS]
        executor.add_node(node)

        def turn():
            for _ in range(round(rate_hz / 5)):
                time.sleep(1.0 / rate_hz)
                for topic, subscription in zip(TOPICS, subscriptions):
                    count.take(topic, take_all(subscription))
            executor.spin_once(0.0)
        return turn
    return prepare


CANDIDATES = {
    'single-threaded executor, callbacks': (callbacks('single', False), False),
    'single-threaded executor, callbacks, raw': (callbacks('single', True), True),
    'multi-threaded executor, callbacks': (callbacks('multi', False), False),
    'events executor, callbacks': (callbacks('events', False), False),
    'events executor, callbacks, raw': (callbacks('events', True), True),
    'single-threaded executor, drained at 20 Hz': (drains('single', False, 20.0), False),
    'single-threaded executor, drained at 20 Hz, raw': (drains('single', True, 20.0), True),
    'single-threaded executor, drained at 100 Hz': (drains('single', False, 100.0), False),
    'events executor, drained at 20 Hz': (drains('events', False, 20.0), False),
    'events executor, drained at 20 Hz, raw': (drains('events', True, 20.0), True),
    'no executor: a loop drains at 20 Hz': (loop(False, 20.0), False),
}


def measure(name: str, rate_hz: float, seconds: float) -> None:
    """Take the messages as the candidate does; print the figures as JSON."""
    prepare, raw = CANDIDATES[name]
    rclpy.init()
    node = rclpy.create_node('benchmark_subscriber')
    count = Count(raw)
    turn = prepare(node, count)
    expected = 2 * int(rate_hz * seconds)
    deadline = time.monotonic() + seconds + START_S + 30.0
    while not count.latency_s and time.monotonic() < deadline:
        turn()
    count.latency_s.clear()
    expected -= sum(count.last.values())
    began, cpu_began = time.monotonic(), time.process_time()
    while len(count.latency_s) + count.lost < expected and time.monotonic() < deadline:
        turn()
    span, cpu = time.monotonic() - began, time.process_time() - cpu_began
    latency = sorted(count.latency_s)
    print(json.dumps({'cpu': cpu / span, 'n': len(latency), 'span': span,
                      'lost': expected - len(latency),
                      'median': latency[len(latency) // 2],
                      'p99': latency[int(0.99 * len(latency))]}), flush=True)
    os._exit(0)


def compare(arguments: argparse.Namespace) -> None:
    """Run a publisher and a subscriber for each candidate and print the table."""
    environment = {**os.environ, 'ROS_DOMAIN_ID': str(1 + os.getpid() % 100),
                   'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
    figures = [f'--rate={arguments.rate}', f'--seconds={arguments.seconds}']

    def start(*words):
        return subprocess.Popen([sys.executable, __file__, *figures, *words], env=environment,
                                stdout=subprocess.PIPE, text=True)
    print(f'2 topics x {arguments.rate:g} Hz for {arguments.seconds:g} s, across processes\n')
    print(f'{"":50s} {"CPU":>6s} {"median":>9s} {"p99":>9s} {"lost":>6s}')
    for name in CANDIDATES:
        if arguments.only and arguments.only not in name:
            continue
        subscriber = start('--measure', name)
        publisher = start('--publish')
        out, _ = subscriber.communicate(timeout=arguments.seconds + 60.0)
        publisher.communicate(timeout=60.0)
        row = json.loads(out)
        print(f'{name:50s} {row["cpu"]:6.1%} {1e3 * row["median"]:6.1f} ms '
              f'{1e3 * row["p99"]:6.1f} ms {row["lost"]:>6}', flush=True)


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description=__doc__.partition('\n\n')[0].strip())
    parser.add_argument('--rate', type=float, default=100.0, help='messages per second and topic')
    parser.add_argument('--seconds', type=float, default=10.0, help='length of a measurement')
    parser.add_argument('--only', default='', help='only candidates with this word')
    parser.add_argument('--publish', action='store_true', help=argparse.SUPPRESS)
    parser.add_argument('--measure', default='', help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.publish:
        publish(given.rate, given.seconds)
    elif given.measure:
        measure(given.measure, given.rate, given.seconds)
    else:
        compare(given)
