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
A player of bags that waits for nobody, as `ros2 bag play`: a process that knows only rclpy.

    python plain_player.py await PAIRS_SUBSCRIBERS
    python plain_player.py play BAG RATE kept|volatile|best_effort TOPIC...
    python plain_player.py send AT_ONCE COUNT RATE_HZ KIND SUBSCRIBERS TOPIC...

The first form ends when a synchronizer runs that has done with looking who is there. The third
one sends headings with the time of day at once, as a sensor does, and COUNT more once it has its
subscribers; it prints how many it has sent. If AT_ONCE is not 0, it sends so many at once, and
then waits for the subscribers.
"""

from __future__ import annotations

import sys
import time

import rclpy
from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.core.records import Headings
from heading_intercompare.messages.heading_messages import IMU, imu_messages
from heading_intercompare.messages.ledger_messages import decode_ledger
from heading_intercompare.nodes.interface.message_types import HEADING_TYPES, STATUS_TYPES

QOS = {'kept': QoSProfile(depth=5000, durability=DurabilityPolicy.TRANSIENT_LOCAL),
       'volatile': QoSProfile(depth=5000),
       'best_effort': QoSProfile(depth=5000, reliability=ReliabilityPolicy.BEST_EFFORT)}
AGE_NS = 4_000_000_000


def play(node, bag, rate, kind, *topics):
    """Publish the messages of some topics at once, and then at their times."""
    reader = BagReader(bag)
    publishers = {topic: node.create_publisher(
        HEADING_TYPES[reader.topics[topic].type_name], topic, QOS[kind]) for topic in topics}
    began_s, first_ns = time.monotonic(), reader.start_ns
    for message in reader.messages(list(topics)):
        due_s = began_s + (message.log_time_ns - first_ns) / 1e9 / float(rate)
        time.sleep(max(0.0, due_s - time.monotonic()))
        publishers[message.topic].publish(message.data)
    # As with --wait-for-all-acked: the end is to arrive, whatever else the machine does.
    for publisher in publishers.values():
        publisher.wait_for_all_acked(Duration(seconds=150))


def send(node, at_once, count, rate_hz, kind, subscribers, *topics):
    """Publish headings of each topic, the first ones before anybody listens."""
    publishers = [node.create_publisher(HEADING_TYPES[IMU], topic, QOS[kind]) for topic in topics]
    began_s, number, end = time.monotonic(), 0, None
    while number != end:
        if not 0 < number < int(at_once):
            time.sleep(max(0.0, began_s + number / float(rate_hz) - time.monotonic()))
        message, = imu_messages(Headings.as_sent([time.time_ns()], [90.0 + number % 7 / 10]), 'x')
        for publisher in publishers:
            publisher.publish(message)
        number += 1
        while end is None and number >= int(at_once):
            if min(publisher.get_subscription_count()
                   for publisher in publishers) >= int(subscribers):
                end, began_s = number + int(count), time.monotonic() - number / float(rate_hz)
            elif not int(at_once):
                break
            else:
                time.sleep(0.01)
    print(number)
    for publisher in publishers:
        publisher.wait_for_all_acked(Duration(seconds=150))
    # Nobody acknowledges what is best effort.
    time.sleep(0.5)


def await_graph(node, subscribers):
    """Wait until a synchronizer is old enough and its pairs have their subscribers."""
    told = []
    node.create_subscription(STATUS_TYPES['diagnostic_msgs/msg/DiagnosticArray'], 'pairs/ledger',
                             told.append, 10, raw=True)
    while not (told and time.time_ns() - decode_ledger(told[-1]).started_ns > AGE_NS
               and node.count_subscribers('pairs') >= int(subscribers)):
        rclpy.spin_once(node, timeout_sec=0.1)


if __name__ == '__main__':
    rclpy.init()
    {'play': play, 'send': send, 'await': await_graph}[sys.argv[1]](
        rclpy.create_node('plain_player'), *sys.argv[2:])
