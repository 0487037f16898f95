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

"""Publishing no faster than subscribers take."""

from __future__ import annotations

import time

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
import pytest
from rclpy.node import Node
from sensor_msgs.msg import Imu

from heading_intercompare.core.records import Headings
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.sending import publishing
from heading_intercompare.nodes.sending.publishing import (
    Audience,
    Backlog,
    FlowControl,
    HeadingQueue,
)
from heading_intercompare.nodes.spinning.batches import take_all, Unwatched


def flow_of(ros, **kwargs):
    """Return a flow of the topic `h`, a function that publishes n messages, its subscription."""
    node = ros.add(Node, 'sender')
    publisher = node.create_publisher(Imu, 'h', qos.HEADINGS_OUT)
    taker = ros.plain.create_subscription(Imu, 'h', lambda _: None, qos.HEADINGS_IN, raw=True,
                                          callback_group=Unwatched())
    ros.spin_until(lambda: publisher.get_subscription_count() == 1)
    flow = FlowControl([publisher], Health(node), **kwargs)

    def publish(n):
        for _ in range(n):
            publisher.publish(Imu())
        flow.spend(n)
    return flow, publish, taker


def test_there_is_room_while_subscribers_acknowledge(ros):
    flow, publish, taker = flow_of(ros, window=500)
    taken = []
    for _ in range(4):
        publish(500)
        ros.spin_until(flow.has_room)
    ros.spin_until(lambda: taken.extend(take_all(taker)) or len(taken) == 2000)
    assert [info['publication_sequence_number'] for _, info in taken] == list(range(1, 2001))


class NowAndThen:
    """A publisher whose messages are all acknowledged only every so many times it is asked."""

    def __init__(self, every=8):
        self.asked, self._every = 0, every

    def wait_for_all_acked(self, timeout):
        """Tell at once whether all is acknowledged."""
        self.asked += 1
        return self.asked % self._every == 0


def pass_a_tick(monkeypatch, now_s):
    """Let the clock of the flow show a time."""
    monkeypatch.setattr(publishing.time, 'monotonic', lambda: now_s)


def test_a_steady_stream_is_not_stopped_to_learn_that_it_came(ros, monkeypatch):
    """DDS hears from its readers while messages go out, and then only every three seconds."""
    flow = FlowControl([NowAndThen()], Health(ros.plain), window=2000)
    for tick in range(1000):
        pass_a_tick(monkeypatch, 0.02 * tick)
        assert flow.has_room()
        flow.spend(20)


def test_a_fast_replay_asks_a_few_times_a_tick_and_not_for_each_message(ros, monkeypatch):
    """A question costs more than a message; at 2000 Hz it took most of the CPU of a replay."""
    publisher = NowAndThen(every=100)
    flow = FlowControl([publisher], Health(ros.plain), window=2000)
    for message in range(10_000):
        pass_a_tick(monkeypatch, message / 2000.0)
        assert flow.has_room()
        flow.spend(1)
    assert 500 < publisher.asked <= 1000


class Unacknowledged:
    """A publisher whose subscribers acknowledge nothing until they are told to."""

    acknowledged = False

    def wait_for_all_acked(self, timeout):
        """Tell at once whether all is acknowledged."""
        assert timeout.nanoseconds == 0, 'a node must not wait here'
        return self.acknowledged


def test_without_acknowledgement_there_is_no_room_until_it_comes(ros):
    heard = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    publisher = Unacknowledged()
    flow = FlowControl([publisher], Health(ros.add(Node, 'sender')), window=10)
    for _ in range(10):
        assert flow.has_room()
        flow.spend(1)
    assert not flow.has_room()
    ros.spin_until(lambda: not flow.has_room() and any(
        '10 messages are not acknowledged' in s.message for m in heard for s in m.status))
    publisher.acknowledged = True
    assert flow.has_room()
    ros.spin_until(lambda: any('subscribers keep up' in s.message for m in heard
                               for s in m.status))


def test_patience_ends(ros):
    flow = FlowControl([Unacknowledged()], Health(ros.plain), window=1, patience_s=0.2)
    flow.spend(1)
    assert not flow.has_room()
    ros.spin_until(flow.has_room)


def test_a_subscriber_whose_connection_broke_does_not_stop_a_log_for_ever(ros, monkeypatch):
    heard = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    flow = FlowControl([Unacknowledged()], Health(ros.add(Node, 'sender')), window=1)
    flow.spend(1)
    assert not flow.has_room()
    now_s = time.monotonic()
    monkeypatch.setattr(publishing.time, 'monotonic', lambda: now_s + 31.0)
    assert flow.has_room()
    monkeypatch.undo()
    ros.spin_until(lambda: any('going on without subscribers' in s.message for m in heard
                               for s in m.status))


def test_without_a_publisher_there_is_always_room(ros):
    flow = FlowControl([], Health(ros.plain), window=1)
    flow.spend(5)
    assert flow.has_room()


class Acknowledged(NowAndThen):
    """A publisher whose messages are acknowledged at once, as in one process."""

    def __init__(self):
        super().__init__(every=1)
        self.n_published = 0

    def publish(self, message):
        """Count a message."""
        self.n_published += 1


def test_messages_do_not_pile_up_if_their_turn_comes_seldom(ros, monkeypatch):
    """On a busy computer 1500 pairs came in a turn of 0.3 s, and 200 went out: 173 029 waited."""
    publisher = Acknowledged()
    backlog = Backlog(publisher, Health(ros.plain))
    for turn in range(10):
        pass_a_tick(monkeypatch, 0.3 * turn)
        backlog.add([b''] * 1500)
        before = publisher.n_published
        backlog.publish()
        assert publisher.n_published - before <= 2000
    assert len(backlog) == 0


def test_a_burst_goes_out_no_faster_than_a_recorder_takes_it(ros, monkeypatch):
    """60 000 pairs once `auto` has chosen; a subscription holds 5000 and is emptied in 0.2 s."""
    publisher = Acknowledged()
    backlog = Backlog(publisher, Health(ros.plain))
    backlog.add([b''] * 60_000)
    for turn in range(11):
        pass_a_tick(monkeypatch, 0.02 * turn)
        backlog.publish()
    assert 1000 <= publisher.n_published <= 2500


def test_headings_that_nobody_can_publish_in_time_are_counted_and_not_kept():
    queue = HeadingQueue(most=500)
    kept = [len(queue.add(Headings.as_sent([*range(1, 301)], [1.0] * 300))) for _ in range(3)]
    assert kept == [300, 200, 0] and queue.overrun == 400 and len(queue) == 500
    pieces = []
    while queue:
        pieces.append(len(queue.popleft()))
    assert sum(pieces) == 500 and max(pieces) <= 200


@pytest.fixture
def stage(ros):
    """Return an audience of one, its publisher, and a function that makes the subscription."""
    node = ros.add(Node, 'sender')
    publisher = node.create_publisher(Imu, 'h', qos.HEADINGS_OUT)
    audience = Audience(node, [publisher], 1, Health(node))

    def subscribe():
        return ros.plain.create_subscription(Imu, 'h', lambda _: None, qos.HEADINGS_IN, raw=True,
                                             callback_group=Unwatched())
    return audience, publisher, subscribe


def test_a_source_ends_at_once_if_its_subscribers_have_all_of_it(ros, stage):
    audience, publisher, subscribe = stage
    subscribe()
    ros.spin_until(audience.is_there)
    publisher.publish(Imu())
    assert audience.has_heard([publisher])


def test_a_source_that_nobody_has_heard_waits_for_nobody_at_its_end(stage):
    audience, publisher, _ = stage
    assert audience.has_heard([publisher])


def cut_off(ros, stage):
    """Let a subscriber come and go; return the stage."""
    audience, publisher, subscribe = stage
    taker = subscribe()
    ros.spin_until(audience.is_there)
    ros.plain.destroy_subscription(taker)
    ros.spin_until(lambda: publisher.get_subscription_count() == 0)
    return stage


def test_a_source_stays_for_a_subscriber_that_is_cut_off(ros, stage, monkeypatch):
    """Before, it ended, and what it had published was gone with it."""
    audience, publisher, _ = cut_off(ros, stage)
    began_s = time.monotonic()
    shown = {}
    monkeypatch.setattr(audience._health, 'note', lambda part, level, words: shown.update(
        {part: words}))
    for passed_s in (0.0, 20.0, 40.0):
        pass_a_tick(monkeypatch, began_s + passed_s)
        assert not audience.has_heard([publisher])
    assert shown == {'audience': 'at the end: waiting for a subscriber of /h'}
    pass_a_tick(monkeypatch, began_s + 46.0)
    assert audience.has_heard([publisher])


def test_a_subscriber_that_is_back_gets_time_to_take_what_it_has_missed(ros, stage, monkeypatch):
    audience, publisher, subscribe = cut_off(ros, stage)
    assert not audience.has_heard([publisher])
    subscribe()
    ros.spin_until(lambda: publisher.get_subscription_count() == 1)
    back_s = time.monotonic()
    for passed_s, done in ((0.0, False), (9.0, False), (10.1, True)):
        pass_a_tick(monkeypatch, back_s + passed_s)
        assert audience.has_heard([publisher]) is done


def audience_of(ros, **kwargs):
    """Return an audience of the topic `h`, and its node."""
    node = ros.add(Node, 'sender')
    publisher = node.create_publisher(Imu, 'h', qos.HEADINGS_OUT)
    return Audience(node, [publisher], 1, Health(node), **kwargs)


def hear(node, topic='h'):
    """Let a node hear a topic."""
    node.create_subscription(Imu, topic, lambda _: None, qos.HEADINGS_IN)


def test_a_recorder_does_not_stand_in_for_the_synchronizer(ros):
    """A replay beside a recorder lost 17 s: the first subscriber was not the one that judges."""
    audience = audience_of(ros, judged={'h': ['pairs']})
    judge = ros.add(Node, 'synchronizer')
    judge.create_publisher(TwistStamped, 'pairs', qos.PAIRS)
    hear(ros.add(Node, 'recorder'))
    ros.spin_until(lambda: not audience.is_there() and audience.waiting == (
        'waiting for /synchronizer to subscribe to /h'))
    hear(judge)
    ros.spin_until(audience.is_there)
    assert audience.waiting == ''


def test_where_nobody_judges_any_subscriber_will_do(ros):
    audience = audience_of(ros, judged={'h': ['pairs']})
    hear(ros.add(Node, 'recorder'))
    ros.spin_until(audience.is_there)


def test_a_recorder_that_is_there_first_is_given_time_for_its_synchronizer(ros):
    """A replay beside a graph that was just started began with the recorder: 4050 were missed."""
    audience = audience_of(ros, judged={'h': ['pairs']})
    recorder = ros.add(Node, 'recorder')
    Health(recorder)
    hear(recorder)
    ros.spin_until(lambda: audience.waiting == 'waiting for a node that judges /h'
                   or audience.is_there())
    assert not audience.is_there()
    judge = ros.add(Node, 'synchronizer')
    judge.create_publisher(TwistStamped, 'pairs', qos.PAIRS)
    ros.spin_until(lambda: not audience.is_there() and 'synchronizer' in audience.waiting)
    hear(judge)
    ros.spin_until(audience.is_there)


def test_a_recorder_alone_is_played_to_after_a_while(ros, monkeypatch):
    audience = audience_of(ros, judged={'h': ['pairs']})
    recorder = ros.add(Node, 'recorder')
    Health(recorder)
    hear(recorder)
    ros.spin_until(lambda: 'judges' in audience.waiting or audience.is_there())
    assert not audience.is_there()
    now_s = time.monotonic()
    monkeypatch.setattr(publishing.time, 'monotonic', lambda: now_s + 6.0)
    assert audience.is_there() and audience.waiting == ''


def test_one_that_judges_other_topics_is_not_waited_for_without_end(ros, monkeypatch):
    audience = audience_of(ros, judged={'h': ['pairs']})
    ros.add(Node, 'synchronizer').create_publisher(TwistStamped, 'pairs', qos.PAIRS)
    hear(ros.add(Node, 'recorder'))
    ros.spin_until(lambda: 'synchronizer' in audience.waiting or audience.is_there())
    assert not audience.is_there()
    now_s = time.monotonic()
    monkeypatch.setattr(publishing.time, 'monotonic', lambda: now_s + 16.0)
    assert audience.is_there()


@pytest.mark.parametrize('judge', [True, False])
def test_one_that_judges_gets_its_time_once_there_is_a_subscriber(ros, judge):
    """On a loaded machine it came after 29 s: a replay went on without it, and 6 were lost."""
    audience = audience_of(ros, judged={'h': ['pairs']})
    ros.spin_until(lambda: not audience.is_there() and 'a subscriber' in audience.waiting)
    audience._began_s -= 29.0
    audience._missing_s = audience._began_s
    assert not audience.is_there()
    recorder = ros.add(Node, 'recorder')
    Health(recorder)
    if judge:
        ros.add(Node, 'synchronizer').create_publisher(TwistStamped, 'pairs', qos.PAIRS)
    hear(recorder)
    words = 'waiting for /synchronizer' if judge else 'waiting for a node that judges'
    ros.spin_until(lambda: audience.is_there() or words in audience.waiting)
    assert not audience.is_there()


def test_a_patience_ends_the_wait_for_any_subscriber(ros):
    heard = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    audience = audience_of(ros, patience_s=0.3)
    assert not audience.is_there()
    ros.spin_until(audience.is_there)
    ros.spin_until(lambda: any('going on without; waiting for a subscriber of /h' in s.message
                               for m in heard for s in m.status))
