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

"""The quick executor does all that the executor of rclpy does, and takes messages in batches."""

from __future__ import annotations

import math
import time

import pytest
from rclpy.executors import ExternalShutdownException
from rclpy.qos import QoSProfile
from std_msgs.msg import String
from std_srvs.srv import Trigger

from heading_intercompare.nodes.ros.batches import Arrivals, take_all
from heading_intercompare.nodes.ros.quick_executor import QuickExecutor
from heading_intercompare.nodes.ros.steady_timer import every


@pytest.fixture
def batches(ros):
    """Return a publisher, and a list that fills with the sizes of the batches taken."""
    taken = []

    def take():
        batch = take_all(subscription)
        if batch:
            taken.append(len(batch))
    # Its timer never comes: only the executor takes the messages.
    group = Arrivals(ros.plain, take, 3600.0)
    group._hold_off_s = 0.05
    subscription = ros.plain.create_subscription(String, 'words', lambda _: None, 100,
                                                 callback_group=group, raw=True)
    publisher = ros.plain.create_publisher(String, 'words', 100)
    ros.spin_until(lambda: publisher.get_subscription_count() == 1)
    return publisher, taken


def test_the_fixture_spins_with_it(ros):
    assert isinstance(ros.executor, QuickExecutor)


def test_messages_that_come_together_are_taken_together(ros, batches):
    publisher, taken = batches
    for _ in range(3):
        publisher.publish(String(data='x'))
    ros.spin_until(lambda: taken)
    assert taken == [3]


def test_a_message_is_taken_a_hold_off_after_it_came(ros, batches):
    publisher, taken = batches
    began_s = time.monotonic()
    publisher.publish(String(data='x'))
    ros.spin_until(lambda: taken)
    assert 0.05 <= time.monotonic() - began_s < 5.0


def test_a_node_whose_subscription_goes_before_its_batch_is_due_still_takes(ros):
    """Before, it never took anything again, and a synchronizer gave no pairs and did not end."""
    calls = []
    group = Arrivals(ros.plain, lambda: calls.append(group.due_s), 0.1)
    subscription = ros.plain.create_subscription(String, 'words', lambda _: None, 100,
                                                 callback_group=group, raw=True)
    publisher = ros.plain.create_publisher(String, 'words', 100)
    ros.spin_until(lambda: publisher.get_subscription_count() == 1)
    publisher.publish(String(data='x'))
    ros.spin_until(lambda: group.due_s < math.inf)
    ros.plain.destroy_subscription(subscription)
    calls.clear()
    ros.spin_until(lambda: len(calls) > 1)
    assert calls[:2] == [math.inf, math.inf]


def test_timers_keep_their_period_and_can_be_cancelled_in_their_callback(ros):
    calls = []

    def call():
        calls.append(time.monotonic())
        if len(calls) == 5:
            timer.cancel()
    timer = every(ros.plain, 0.02, call)
    last = every(ros.plain, 0.3, lambda: calls.append('end'))
    ros.spin_until(lambda: 'end' in calls)
    last.cancel()
    assert calls.index('end') == 5


def test_a_guard_condition_wakes_it_at_once(ros):
    calls = []
    guard = ros.plain.create_guard_condition(lambda: calls.append(time.monotonic()))
    ros.spin_until(lambda: not ros.executor._stale)
    guard.trigger()
    ros.spin_until(lambda: calls)
    assert len(calls) == 1


def test_services_and_bursts_of_single_messages_are_served(ros):
    heard = ros.listen(String, 'burst', QoSProfile(depth=1000))
    publisher = ros.plain.create_publisher(String, 'burst', QoSProfile(depth=1000))
    ros.plain.create_service(Trigger, 'ask', lambda _, response: response)
    client = ros.plain.create_client(Trigger, 'ask')
    ros.spin_until(lambda: publisher.get_subscription_count() and client.service_is_ready())
    for _ in range(500):
        publisher.publish(String(data='x'))
    asked = client.call_async(Trigger.Request())
    ros.spin_until(lambda: asked.done() and len(heard) == 500)


def test_what_is_destroyed_in_a_callback_is_gone_and_what_is_made_there_is_spun(ros):
    calls = []

    def change():
        timer.cancel()
        ros.plain.destroy_subscription(old)
        ros.plain.create_subscription(String, 'new', calls.append, 10)
        calls.append('changed')
    old = ros.plain.create_subscription(String, 'old', calls.append, 10)
    publishers = [ros.plain.create_publisher(String, name, 10) for name in ('old', 'new')]
    timer = every(ros.plain, 0.02, change)
    ros.spin_until(lambda: calls and publishers[1].get_subscription_count() == 1
                   and publishers[0].get_subscription_count() == 0)
    publishers[1].publish(String(data='x'))
    ros.spin_until(lambda: len(calls) == 2)


def test_an_error_in_a_callback_comes_out(ros):
    def fail():
        raise OSError('no space')
    every(ros.plain, 0.01, fail)
    with pytest.raises(OSError, match='no space'):
        ros.spin_until(lambda: False)


def test_a_context_that_is_shut_down_ends_it(ros):
    ros.executor.spin_once(0.0)
    ros.context.try_shutdown()
    with pytest.raises(ExternalShutdownException):
        ros.executor.spin_once(0.0)
