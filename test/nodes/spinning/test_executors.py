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

"""Either executor turns the nodes: single messages, services, and messages in batches."""

from __future__ import annotations

import threading
import time

from deadlines import DEADLINE_S
from nodes.ros_nodes import EITHER_EXECUTOR
import pytest
from rclpy.executors import ExternalShutdownException
from rclpy.qos import QoSProfile
from std_msgs.msg import String
from std_srvs.srv import Trigger

from heading_intercompare.nodes.spinning.batches import Arrivals, take_all
from heading_intercompare.nodes.spinning.clocks import every
from heading_intercompare.nodes.spinning.executors import (
    EXECUTOR,
    make_executor,
    QuickExecutor,
    StockExecutor,
)

pytestmark = EITHER_EXECUTOR

_HOLD_OFF_S = 0.05


@pytest.fixture
def batches(ros):
    """Return a publisher, and a list that fills with the sizes of the batches taken."""
    taken = []

    def take():
        batch = take_all(subscription)
        if batch:
            taken.append(len(batch))
    group = Arrivals(ros.plain, take, _HOLD_OFF_S)
    # Without a message nothing is taken for an hour.
    group._pause_s = 3600.0
    group._wait(3600.0)
    subscription = ros.plain.create_subscription(String, 'words', lambda _: None, 100,
                                                 callback_group=group, raw=True)
    publisher = ros.plain.create_publisher(String, 'words', 100)
    ros.spin_until(lambda: publisher.get_subscription_count() == 1)
    return publisher, taken


@pytest.mark.parametrize('kind, expected', [
    ('', QuickExecutor), ('quick', QuickExecutor), ('rclpy', StockExecutor)])
def test_the_environment_names_the_executor(ros, monkeypatch, kind, expected):
    monkeypatch.delenv(EXECUTOR)
    if kind:
        monkeypatch.setenv(EXECUTOR, kind)
    executor = make_executor(ros.context)
    executor.shutdown()
    assert type(executor) is expected


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
    assert time.monotonic() - began_s >= _HOLD_OFF_S


def test_batches_follow_each_other_as_long_as_messages_come(ros, batches):
    """Each message after a batch begins the next one; between two there is a hold-off."""
    publisher, taken = batches
    for n_batches in range(1, 6):
        publisher.publish(String(data='x'))
        publisher.publish(String(data='x'))
        ros.spin_until(lambda n_batches=n_batches: sum(taken) == 2 * n_batches)
    assert 5 <= len(taken) <= 10


@pytest.mark.parametrize('n_taken, hold_off_s', [(0, 0.2), (2, 0.2), (4, 0.01), (None, 0.01)])
def test_where_few_messages_come_it_gathers_longer(ros, n_taken, hold_off_s):
    """A batch of one message costs as much as one of ten; a batch that is large enough waits."""
    n_batches = 0

    def take():
        nonlocal n_batches
        n_batches += 1
        return n_taken

    def gather(n):
        until = n_batches + n
        while n_batches < until:
            group.beginning_execution(None)
            ros.spin_until(lambda before=n_batches: n_batches > before)
    group = Arrivals(ros.plain, take, 0.01)
    gather(7)
    assert group._hold_off_s == hold_off_s
    began_s = time.monotonic()
    gather(1)
    assert time.monotonic() - began_s >= 0.99 * hold_off_s
    n_taken = 10
    gather(7)
    assert group._hold_off_s == 0.01


def test_it_rests_while_a_batch_gathers_and_after_it(ros):
    """A message that waits to be taken keeps nothing awake, and one batch is taken once."""
    calls = []

    def take():
        take_all(subscription)
        calls.append('taken')
    group = Arrivals(ros.plain, take, 0.5)
    group._pause_s = 3600.0
    group._wait(3600.0)
    subscription = ros.plain.create_subscription(String, 'words', lambda _: None, 100,
                                                 callback_group=group, raw=True)
    publisher = ros.plain.create_publisher(String, 'words', 100)
    ros.spin_until(lambda: publisher.get_subscription_count() == 1)
    publisher.publish(String(data='x'))
    ros.spin_until(lambda: group.gathering)
    n_turns = 0
    while not calls:
        ros.executor.spin_once(DEADLINE_S)
        n_turns += 1
    # The quick one looks for what is rare 10 times a second.
    assert n_turns < 40
    every(ros.plain, 1.5, lambda: calls.append('end'))
    ros.spin_until(lambda: 'end' in calls)
    assert calls == ['taken', 'end']


def test_without_messages_a_batch_is_taken_all_the_same(ros):
    """The synchronizer gives up readings, and ends, by the clock."""
    calls = []
    Arrivals(ros.plain, lambda: calls.append(0), 0.001)
    ros.spin_until(lambda: len(calls) == 3)


def test_a_node_whose_subscription_goes_before_its_batch_is_due_still_takes(ros):
    """Before, it never took anything again, and a synchronizer gave no pairs and did not end."""
    calls = []
    group = Arrivals(ros.plain, lambda: calls.append('taken'), 0.1)
    subscription = ros.plain.create_subscription(String, 'words', lambda _: None, 100,
                                                 callback_group=group, raw=True)
    publisher = ros.plain.create_publisher(String, 'words', 100)
    ros.spin_until(lambda: publisher.get_subscription_count() == 1)
    publisher.publish(String(data='x'))
    ros.spin_until(lambda: group.gathering)
    ros.plain.destroy_subscription(subscription)
    calls.clear()
    ros.spin_until(lambda: len(calls) > 1)
    assert not group.gathering


def test_timers_keep_their_period_and_can_be_cancelled_in_their_callback(ros):
    calls = []

    def call():
        calls.append(time.monotonic())
        if len(calls) == 5:
            timer.cancel()
    timer = every(ros.plain, 0.02, call)
    ros.spin_until(lambda: len(calls) == 5)
    last = every(ros.plain, 0.3, lambda: calls.append('end'))
    ros.spin_until(lambda: 'end' in calls)
    last.cancel()
    assert calls.index('end') == 5


def test_a_guard_condition_wakes_it_from_another_thread(ros):
    calls = []
    guard = ros.plain.create_guard_condition(lambda: calls.append(time.monotonic()))
    began_s = time.monotonic()
    threading.Timer(0.1, guard.trigger).start()
    while not calls:
        ros.executor.spin_once(DEADLINE_S)
    assert 0.1 <= calls[0] - began_s < DEADLINE_S / 2.0


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
