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

"""The motion of the ship as it comes to a node: from the first message, of any accepted type."""

from __future__ import annotations

import numpy as np
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Imu, NavSatFix

from heading_intercompare.core.records import Motion
from heading_intercompare.core.settings import MotionRule
from heading_intercompare.messages.motion.motion_messages import split_motion
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.settings import Taking
from heading_intercompare.nodes.taking.motion_intake import MotionIntake

S = 10 ** 9


class Taker:
    """Keeps what it is given."""

    def __init__(self):
        self.rows = Motion.empty()

    def take_motion(self, motion):
        self.rows += motion


def make(ros, rule=None, **kwargs):
    taker = Taker()
    intake = MotionIntake(ros.plain, Health(ros.plain), Taking(), rule or MotionRule(),
                          (taker,), **kwargs)
    return intake, taker


def until(ros, intake, condition):
    ros.spin_until(lambda: (intake.pass_on(), condition())[1])


def fixes(n):
    return Motion.of_positions(np.arange(1, n + 1) * S, np.full(n, 50.0), np.full(n, 5.0))


def test_what_was_sent_before_the_node_was_there_comes_too(ros):
    publisher = ros.plain.create_publisher(NavSatFix, 'ship/fix', qos.HEADINGS_OUT)
    for message in split_motion(fixes(50), 'fix', 'ship'):
        publisher.publish(message)
    intake, taker = make(ros)
    until(ros, intake, lambda: len(taker.rows) == 50)
    assert taker.rows.latitude_deg.tolist() == [50.0] * 50


def test_what_an_earlier_process_took_is_left_out(ros):
    publisher = ros.plain.create_publisher(NavSatFix, 'ship/fix', qos.HEADINGS_OUT)
    for message in split_motion(fixes(50), 'fix', 'ship'):
        publisher.publish(message)
    intake, taker = make(ros, known_ns={'fix': 40 * S})
    until(ros, intake, lambda: len(taker.rows) == 10)
    assert taker.rows.stamp_ns[0] == 41 * S


def test_a_best_effort_publisher_of_another_type_is_heard(ros):
    publisher = ros.plain.create_publisher(
        Imu, 'gyro/imu', QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT))
    intake, taker = make(ros, MotionRule(rate_topic='gyro/imu'))
    until(ros, intake, lambda: publisher.get_subscription_count() == 1)
    message = Imu()
    message.header.stamp.sec = 7
    message.angular_velocity.z = -0.1
    publisher.publish(serialize_message(message))
    until(ros, intake, lambda: len(taker.rows) == 1)
    assert taker.rows.rate_deg_s.tolist() == [np.degrees(0.1)]


def test_without_the_comparison_nothing_is_subscribed(ros):
    publisher = ros.plain.create_publisher(NavSatFix, 'ship/fix', qos.HEADINGS_OUT)
    intake, taker = make(ros, MotionRule(compare=False))
    for message in split_motion(fixes(5), 'fix', 'ship'):
        publisher.publish(message)
    for _ in range(5):
        intake.pass_on()
        ros.executor.spin_once(0.02)
    assert publisher.get_subscription_count() == 0 and not len(taker.rows)


def test_messages_that_cannot_be_read_are_counted(ros):
    publisher = ros.plain.create_publisher(NavSatFix, 'ship/fix', qos.HEADINGS_OUT)
    publisher.publish(split_motion(fixes(1), 'fix', 'ship')[0][:30])
    intake, _ = make(ros)
    until(ros, intake, lambda: intake._intakes['fix'].refused == 1)
