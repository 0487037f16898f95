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

"""Several streams of headings are heard, with what was lost of each."""

from __future__ import annotations

import time

from diagnostic_msgs.msg import DiagnosticArray
from nodes.rclpy_objects import heading_messages
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import Imu

from heading_intercompare.core.records import Headings, Losses
from heading_intercompare.messages.ledger_messages import encode_losses, lost_topic
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.settings import Taking
from heading_intercompare.nodes.taking.headings_intake import HeadingsIntake


class Streams:
    """Two publishers, an intake of both, and what it said was lost."""

    def __init__(self, ros):
        self.ros, self.lost = ros, []
        self.node = ros.add(Node, 'taker')
        self.intake = HeadingsIntake(
            self.node, Health(self.node), Taking(),
            {'one': ('a', 'enu', None), 'two': ('b', 'enu', None)},
            lambda name, lost_as, losses: self.lost.append(
                (name, lost_as, int(losses.count.sum()))))
        self.publishers = {name: ros.plain.create_publisher(Imu, topic, qos.HEADINGS_OUT)
                           for name, topic in (('one', 'a'), ('two', 'b'))}
        ros.spin_until(lambda: not any(map(len, self.intake.take().values())) and all(
            one.get_subscription_count() for one in self.publishers.values()))

    def send(self, name, n):
        """Publish a reading a second of one stream."""
        stamps = [(1_700_000_000 + at) * 10 ** 9 for at in range(n)]
        for message in heading_messages(Headings.of(stamps, [90.0] * n), 'x'):
            self.publishers[name].publish(message)
        self.ros.spin_until(lambda: self.publishers[name].wait_for_all_acked())

    def take(self, wanted, **how):
        """Take until so many readings of each stream have come."""
        found = dict.fromkeys(wanted, 0)

        def took():
            for name, some in self.intake.take(**how).items():
                found[name] += len(some)
            return found == wanted
        self.ros.spin_until(took)


def test_each_stream_has_its_readings_and_numbers(ros):
    streams = Streams(ros)
    streams.send('one', 30)
    streams.send('two', 20)
    streams.take({'one': 30, 'two': 20})
    assert [(n.first, n.last) for n in streams.intake.numbers.values()] == [(1, 30), (1, 20)]
    assert sorted(streams.intake.received_ns) == ['one', 'two']
    assert streams.intake.count_publishers() == 2


def test_what_a_driver_tells_of_its_losses_is_passed_on_by_stream(ros):
    streams = Streams(ros)
    told = ros.plain.create_publisher(
        DiagnosticArray, lost_topic(streams.intake.intakes['two'].full_name), qos.LOST)
    ros.spin_until(lambda: told.get_subscription_count())
    told.publish(deserialize_message(encode_losses({'lost.at_source': Losses.of([5], [3], [7])}),
                                     DiagnosticArray))
    ros.spin_until(lambda: ('two', 'lost.at_source', 7) in streams.lost)
    assert {name for name, _, n in streams.lost if n} == {'two'}


def test_a_node_that_stood_still_takes_what_a_source_sent_that_has_ended(ros):
    """Before, it waited for the source to send it again, and took none of 30 readings."""
    streams = Streams(ros)
    streams.send('one', 30)
    for intake in streams.intake.intakes.values():
        intake._renewal._looked_s = time.monotonic() - 10.0
    ros.plain.destroy_publisher(streams.publishers['one'])
    assert not len(streams.intake.take()['one'])
    streams.take({'one': 30, 'two': 0}, last=True)
