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

"""Messages are taken in batches, losses counted, publishers watched."""

from __future__ import annotations

import time

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import QuaternionStamped
from message_rows import read_headings
from nodes.rclpy_objects import heading_messages
from nodes.ros_nodes import EITHER_EXECUTOR
import pytest
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import Imu
from std_msgs.msg import String

from heading_intercompare.bags.recording.cut_bag import LastMessages
from heading_intercompare.core.records import Headings, Losses
from heading_intercompare.messages.heading_messages import IMU, imu_messages
from heading_intercompare.messages.heading_places import HeadingPlace
from heading_intercompare.messages.status_messages import ERROR, OK, WARN
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.interface.message_types import HEADING_TYPES
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.spinning.batches import take_all
from heading_intercompare.nodes.taking import intake as intake_module, reception
from heading_intercompare.nodes.taking.intake import Intake


def intake_of(ros, profile=qos.HEADINGS_IN, types=HEADING_TYPES, **kwargs):
    """Return the intake of the topic `h`, and the states it shows."""
    heard = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    node = ros.add(Node, 'taker')
    return Intake(node, 'h', types, profile, Health(node), **kwargs), heard


def publisher_to(ros, intake, kind=Imu, profile=qos.HEADINGS_OUT):
    """Return a publisher of `h` that the intake has subscribed to."""
    publisher = ros.plain.create_publisher(kind, 'h', profile)
    ros.spin_until(lambda: intake.take() == [] and publisher.get_subscription_count() == 1)
    return publisher


def take(ros, intake, n):
    """Return the next n messages."""
    taken = []
    ros.spin_until(lambda: taken.extend(m for m, _ in intake.take()) or len(taken) >= n)
    return taken


def headings(lo, hi):
    """Return messages stamped lo to hi - 1 seconds."""
    return heading_messages(Headings.as_sent([i * 10 ** 9 for i in range(lo, hi)],
                                        [1.0] * (hi - lo)), 'h')


def seconds(messages, type_name=IMU):
    """Return the stamps of messages, whole seconds."""
    headings, refused = read_headings(type_name, 'enu', messages)
    assert refused == []
    return (headings.stamp_ns // 10 ** 9).tolist()


def state(heard, words):
    """Return the last level and message that contain words; None if there is none."""
    found = [(s.level[0], s.message) for m in heard for s in m.status if words in s.message]
    return found[-1] if found else None


def test_a_batch_is_taken_in_order_and_nothing_is_lost(ros):
    intake, _ = intake_of(ros)
    publisher = publisher_to(ros, intake)
    for message in headings(0, 500):
        publisher.publish(message)
    taken = take(ros, intake, 500)
    assert seconds(taken) == list(range(500))
    assert (intake.received, intake.lost, intake.last_sequence) == (500, 0, 500)


def test_the_first_message_of_a_publisher_that_waits_is_not_lost_by_best_effort(ros):
    intake, _ = intake_of(ros)
    publisher = publisher_to(ros, intake)
    publisher.publish(headings(7, 8)[0])
    assert seconds(take(ros, intake, 1)) == [7]
    assert intake.last_sequence == 1


def test_messages_that_were_overwritten_are_counted_as_lost(ros):
    intake, heard = intake_of(ros, QoSProfile(
        depth=10, reliability=ReliabilityPolicy.BEST_EFFORT))
    publisher = publisher_to(ros, intake)
    publisher.publish(headings(0, 1)[0])
    take(ros, intake, 1)
    for message in headings(1, 101):
        publisher.publish(message)
    taken = take(ros, intake, 10)
    assert seconds(taken) == list(range(91, 101))
    assert intake.lost == 90
    ros.spin_until(lambda: state(heard, '90 messages lost on the way'))


@EITHER_EXECUTOR
def test_the_executor_does_not_wake_for_a_message(ros):
    intake, _ = intake_of(ros)
    publisher = publisher_to(ros, intake)
    before = intake.received
    for message in headings(0, 20):
        publisher.publish(message)
    for _ in range(30):
        ros.executor.spin_once(0.005)
    assert intake.received == before
    assert len(take(ros, intake, 20)) == 20


def test_the_type_of_the_publisher_decides(ros):
    intake, _ = intake_of(ros)
    publisher = publisher_to(ros, intake, QuaternionStamped)
    publisher.publish(QuaternionStamped())
    assert seconds(take(ros, intake, 1), 'geometry_msgs/msg/QuaternionStamped') == [0]
    assert intake.type_name == 'geometry_msgs/msg/QuaternionStamped'


def test_a_type_that_is_no_heading_is_named_with_those_that_are(ros):
    intake, heard = intake_of(ros)
    ros.plain.create_publisher(String, 'h', 10)
    ros.spin_until(lambda: state(heard, 'has the type'))
    _, words = state(heard, 'has the type')
    assert words.startswith('h has the type std_msgs/msg/String; must be sensor_msgs/msg/Imu or')
    assert intake.take() == []


def test_a_second_publisher_is_an_error(ros):
    intake, heard = intake_of(ros)
    publisher_to(ros, intake)
    ros.add(Node, 'rival').create_publisher(Imu, 'h', qos.HEADINGS_OUT)
    ros.spin_until(lambda: state(heard, '2 publishers'))
    assert state(heard, '2 publishers')[1] == (
        '2 publishers on h instead of one: rival, test_node')


def test_after_a_restart_the_old_publisher_may_be_dead(ros):
    """Two of one name: a warning, until the lease of a dead one must be over."""
    intake, heard = intake_of(ros)
    publisher_to(ros, intake)
    publisher_to(ros, intake)
    ros.spin_until(lambda: state(heard, '2 publishers'))
    level, words = state(heard, '2 publishers')
    assert level == WARN and words == (
        '2 publishers on h, all test_node: after a restart the old one may be dead and disappears '
        'within 20 s')
    intake._rivals.since_s -= 31.0
    ros.spin_until(lambda: state(heard, 'instead of one: test_node, test_node'))
    assert state(heard, 'instead of one')[0] == ERROR


def test_losses_are_a_part_of_their_own_and_expire_but_the_total_stays(ros):
    intake, heard = intake_of(ros, QoSProfile(
        depth=10, reliability=ReliabilityPolicy.BEST_EFFORT), lost_shown_s=2.5)
    publisher = publisher_to(ros, intake)
    publisher.publish(headings(0, 1)[0])
    take(ros, intake, 1)
    for message in headings(1, 101):
        publisher.publish(message)
    take(ros, intake, 10)
    intake.refuse(['too short'])

    def parts():
        return {s.name.partition(': ')[2]: s for s in heard[-1].status}
    ros.spin_until(lambda: heard and 'h lost' in parts() and parts()['h lost'].level[0] == WARN)
    assert parts()['h lost'].message == (
        '90 messages lost on the way; 1 messages refused: too short')
    assert parts()['h'].level[0] == OK
    ros.spin_until(lambda: parts()['h lost'].level[0] == OK)
    values = {pair.key: pair.value for pair in parts()['h lost'].values}
    assert values == {'lost': '90', 'refused': '1'}


def test_several_publishers_may_be_allowed(ros):
    intake, _ = intake_of(ros, sole=False)
    publisher_to(ros, intake)
    ros.add(Node, 'rival').create_publisher(Imu, 'h', qos.HEADINGS_OUT)
    ros.spin_until(lambda: intake.look() == '' and intake.publishers == 2)
    assert intake.lost == 0


def test_publishers_that_count_by_themselves_have_lost_nothing(ros):
    intake, _ = intake_of(ros, sole=False)
    one, other = publisher_to(ros, intake), publisher_to(ros, intake)
    for _ in range(20):
        one.publish(Imu())
    for _ in range(20):
        other.publish(Imu())
        one.publish(Imu())
    ros.spin_until(lambda: intake.take() is not None and intake.received == 60)
    assert intake.lost == 0


def test_a_qos_mismatch_is_an_error(ros):
    intake, heard = intake_of(ros, qos.PAIRS_TAKEN)
    ros.plain.create_publisher(Imu, 'h', qos.HEADINGS_UNRELIABLE)
    ros.spin_until(lambda: state(heard, 'QoS mismatch'))
    assert 'test_node' in state(heard, 'QoS mismatch')[1]
    assert intake.received == 0


def reliability(ros):
    """Return the reliabilities of the subscriptions to `h`."""
    infos = ros.plain.get_subscriptions_info_by_topic('h')
    return [info.qos_profile.reliability for info in infos]


def test_a_reliable_publisher_loses_nothing_to_a_taker_that_is_late(ros):
    """3000 messages wait to be taken: a subscription that keeps the last 1000 loses 2000."""
    intake, _ = intake_of(ros, unreliable=qos.HEADINGS_UNRELIABLE)
    publisher = publisher_to(ros, intake)
    assert reliability(ros) == [ReliabilityPolicy.RELIABLE]
    for message in headings(0, 3000):
        publisher.publish(message)
    assert seconds(take(ros, intake, 3000)) == list(range(3000))
    assert intake.lost == 0


def test_a_best_effort_publisher_is_heard_from_its_first_message(ros):
    intake, _ = intake_of(ros, unreliable=qos.HEADINGS_UNRELIABLE)
    publisher = publisher_to(ros, intake, profile=qos.HEADINGS_UNRELIABLE)
    assert reliability(ros) == [ReliabilityPolicy.BEST_EFFORT] and intake.resubscribed == 0
    publisher.publish(headings(7, 8)[0])
    assert seconds(take(ros, intake, 1)) == [7]


def test_a_best_effort_publisher_that_joins_is_heard_beside_a_reliable_one(ros):
    intake, heard = intake_of(ros, unreliable=qos.HEADINGS_UNRELIABLE, sole=False)
    one = publisher_to(ros, intake)
    one.publish(headings(1, 2)[0])
    ros.spin_until(lambda: intake.type_name is not None)
    other = ros.plain.create_publisher(Imu, 'h', qos.HEADINGS_UNRELIABLE)
    ros.spin_until(lambda: intake.look() == '' and other.get_subscription_count() == 1)
    assert reliability(ros) == [ReliabilityPolicy.BEST_EFFORT] and intake.resubscribed == 1
    for publisher, at in ((one, 2), (other, 3)):
        publisher.publish(headings(at, at + 1)[0])
    # What waited in the old subscription is not lost.
    assert sorted(seconds(take(ros, intake, 3))) == [1, 2, 3]
    ros.spin_until(lambda: any(value.key == 'resubscribed' and value.value == '1'
                               for m in heard for s in m.status for value in s.values))


def test_when_all_publishers_are_gone_the_next_reliable_one_is_heard_reliably(ros):
    intake, _ = intake_of(ros, unreliable=qos.HEADINGS_UNRELIABLE)
    ros.plain.destroy_publisher(publisher_to(ros, intake, profile=qos.HEADINGS_UNRELIABLE))
    ros.spin_until(lambda: intake.look() == '' and not intake.publishers)
    publisher_to(ros, intake)
    assert reliability(ros) == [ReliabilityPolicy.RELIABLE] and intake.resubscribed == 0


def durability(ros):
    """Return the durabilities of the subscriptions to `h`."""
    return [info.qos_profile.durability for info in ros.plain.get_subscriptions_info_by_topic('h')]


def test_after_the_first_message_the_intake_also_hears_what_was_sent_while_it_was_cut_off(ros):
    """Old messages do not come, and those of a publisher that keeps none are heard, too."""
    intake, _ = intake_of(ros, kept=qos.HEADINGS_KEPT, sole=False)
    publisher = ros.plain.create_publisher(Imu, 'h', qos.HEADINGS_OUT)
    for message in headings(0, 50):
        publisher.publish(message)
    ros.spin_until(lambda: intake.take() == [] and publisher.get_subscription_count() == 1)
    publisher.publish(headings(50, 51)[0])
    assert seconds(take(ros, intake, 1)) == [50]
    ros.spin_until(lambda: intake.look() == '' and intake.take() == []
                   and durability(ros) == [DurabilityPolicy.TRANSIENT_LOCAL])
    assert (intake.received, intake.lost, intake.resubscribed) == (1, 0, 0)
    volatile = ros.plain.create_publisher(Imu, 'h', QoSProfile(depth=5000))
    ros.spin_until(lambda: intake.look() == '' and volatile.get_subscription_count() == 1)
    assert intake.resubscribed == 1
    volatile.publish(headings(51, 52)[0])
    assert seconds(take(ros, intake, 1)) == [51]


def test_messages_that_are_missing_are_fetched_with_a_new_subscription(ros):
    """Fast DDS does not always send again what a process missed that it had given up."""
    intake, _ = intake_of(ros, kept=qos.HEADINGS_KEPT)
    publisher = publisher_to(ros, intake)
    for n in (0, 10):
        for message in headings(n, n + 10):
            publisher.publish(message)
        if n == 0:
            take(ros, intake, 10)
    ros.spin_until(lambda: len(take_all(intake._reception._current)) > 0
                   or intake._reception._current is None)
    publisher.publish(headings(20, 21)[0])
    taken = []
    ros.spin_until(lambda: taken.extend(m for m, _ in intake.take()) or (
        taken and intake.received == 21))
    assert intake.lost == 0


@pytest.mark.parametrize('stopped, looks_first', [(True, False), (True, True), (False, False)],
                         ids=['this process', 'this process, which looks', 'the publisher'])
@pytest.mark.parametrize('profile', [qos.HEADINGS_OUT, QoSProfile(depth=5000)],
                         ids=['kept', 'not kept'])
def test_an_intake_cut_off_before_the_first_message_begins_where_it_subscribed(
        ros, monkeypatch, stopped, looks_first, profile):
    """383 pairs were lost: a synchronizer publishes the first ones all at once."""
    intake, _ = intake_of(ros, kept=qos.HEADINGS_KEPT)
    publisher = ros.plain.create_publisher(Imu, 'h', profile)
    for message in headings(0, 20):
        publisher.publish(message)
    ros.spin_until(lambda: intake.take() == [] and publisher.get_subscription_count() == 1)
    for message in headings(20, 50):
        publisher.publish(message)
    # What the middleware does not send again to those it had given up.
    lost = []
    ros.spin_until(lambda: lost.extend(take_all(intake._reception._current)) or len(lost) == 30)
    publisher.publish(headings(50, 51)[0])
    ros.spin_until(publisher.wait_for_all_acked)
    if stopped:
        intake._renewal._looked_s = time.monotonic() - 10.0
        if looks_first:
            # Which timer is the first when a stopped process goes on is a matter of chance.
            intake._note()
    else:
        with monkeypatch.context() as patch:
            patch.setattr(intake._node, 'count_publishers', lambda name: 0)
            assert intake.look() == '' and not intake._reception.there
    came = seconds(take(ros, intake, 31 if profile is qos.HEADINGS_OUT else 1))
    assert came == ([*range(20, 51)] if profile is qos.HEADINGS_OUT else [50])
    publisher.publish(headings(51, 52)[0])
    assert seconds(take(ros, intake, 1)) == [51] and intake.lost == 0


def test_an_intake_cut_off_hears_a_publisher_whose_clock_is_slow(ros, monkeypatch):
    """What it sends is no message of the past for ever."""
    monkeypatch.setattr(reception, '_KEPT_NS', 0)
    intake, _ = intake_of(ros, kept=qos.HEADINGS_KEPT)
    publisher = publisher_to(ros, intake)
    intake._opened_ns += 3600 * 10 ** 9
    intake._part()
    ros.spin_until(lambda: intake.take() == [] and publisher.get_subscription_count() == 1)
    publisher.publish(headings(7, 8)[0])
    assert seconds(take(ros, intake, 1)) == [7]


@pytest.mark.parametrize('last, first, lost', [(30, 31, 0), (0, 1, 0)],
                         ids=['after the last one', 'of a bag without any'])
def test_an_intake_goes_on_after_what_an_earlier_process_recorded(ros, last, first, lost):
    intake, _ = intake_of(ros, kept=qos.HEADINGS_KEPT, place=HeadingPlace('ts/heading', ''))
    publisher = ros.plain.create_publisher(Imu, 'h', qos.HEADINGS_OUT)
    for message in headings(1, 51):
        publisher.publish(message)
    ros.spin_until(lambda: ros.plain.count_publishers('h') == 1)
    info, = ros.plain.get_publishers_info_by_topic('h')
    gid = bytes(info.endpoint_gid).hex()
    names = tuple((number, time.time_ns()) for number in range(1, last + 1))
    intake.go_on_after(LastMessages(names, 0, gid if last else ''))
    ros.spin_until(lambda: intake.look() == '' and publisher.get_subscription_count() == 1)
    for message in headings(51, 61):
        publisher.publish(message)
    assert seconds(take(ros, intake, 61 - first)) == [*range(first, 61)]
    assert (intake.lost, intake.before) == (0, 0)
    assert intake.numbers.spans == ((gid, 1, 60),)
    # So the two bags are known to be those of one publisher.
    assert intake.take_starts() == [(gid, first, first * 10 ** 9)]


def test_what_the_publisher_no_longer_holds_is_missing_after_the_last_one(ros):
    intake, _ = intake_of(ros, kept=qos.HEADINGS_KEPT, place=HeadingPlace('ts/heading', ''))
    publisher = ros.plain.create_publisher(Imu, 'h', QoSProfile(
        depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL))
    for message in headings(1, 51):
        publisher.publish(message)
    ros.spin_until(lambda: ros.plain.count_publishers('h') == 1)
    info, = ros.plain.get_publishers_info_by_topic('h')
    intake.go_on_after(LastMessages(((30, 30),), 0, bytes(info.endpoint_gid).hex()))
    assert seconds(take(ros, intake, 10)) == [*range(41, 51)]
    assert intake.take_losses() == Losses.of([41 * 10 ** 9], [0], [10])


def test_a_publisher_that_restarts_owns_what_it_sent_before_it_was_heard(ros):
    """Its first number rises: without the graph, 20 were missing of the one before."""
    intake, _ = intake_of(ros, place=HeadingPlace('ts/heading', ''))
    first = publisher_to(ros, intake, profile=QoSProfile(depth=50))
    for message in headings(1, 6):
        first.publish(message)
    take(ros, intake, 5)
    ros.plain.destroy_publisher(first)
    ros.spin_until(lambda: not ros.plain.count_publishers('h'))
    intake._reception.close()
    second = ros.plain.create_publisher(Imu, 'h', QoSProfile(depth=50))
    for message in headings(6, 31):
        second.publish(message)
    ros.spin_until(lambda: intake.take() == [] and second.get_subscription_count() == 1)
    for message in headings(31, 33):
        second.publish(message)
    assert seconds(take(ros, intake, 2)) == [31, 32]
    losses = intake.take_losses()
    assert (losses.stamp_ns // 10 ** 9, losses.since_ns // 10 ** 9, losses.count) == (31, 5, 25)
    names = [span.publisher for span in intake.numbers.spans]
    assert [span[1:] for span in intake.numbers.spans] == [(1, 5), (26, 27)]
    assert len({*names}) == 2 and all(names)
    assert [start[0] for start in intake.take_starts()] == names


def test_silence_is_a_warning(ros):
    intake, heard = intake_of(ros, stale_s=0.2)
    publisher = publisher_to(ros, intake)
    publisher.publish(headings(0, 1)[0])
    take(ros, intake, 1)
    ros.spin_until(lambda: state(heard, 'silent for more than 0.2 s'))


def test_a_topic_that_was_never_heard_is_not_called_silent(ros):
    """It was 'silent for more than 3 s', as if something had come before."""
    intake, heard = intake_of(ros, stale_s=0.2)
    publisher_to(ros, intake)
    words = 'waiting for the first message of h, which has a publisher'
    ros.spin_until(lambda: state(heard, words))
    assert state(heard, words)[0] == WARN
    shown = [s for m in heard for s in m.status if s.name == 'taker: h']
    assert not any('silent' in s.message for s in shown)
    assert not any(pair.key == 'age_s' for s in shown for pair in s.values)


def test_a_missing_publisher_is_a_warning(ros):
    _, heard = intake_of(ros)
    ros.spin_until(lambda: state(heard, 'no publisher on h'))
    assert state(heard, 'no publisher on h')[0] == WARN


def test_a_publisher_that_ends_is_missed_only_if_the_graph_does_not_end_too(ros, monkeypatch):
    """A player ends, and a launch file ends the others: there was a warning at every end."""
    monkeypatch.setattr(intake_module, '_GONE_S', 2.5)
    intake, heard = intake_of(ros)
    publisher = publisher_to(ros, intake)
    ros.spin_until(lambda: intake.publishers)
    ros.plain.destroy_publisher(publisher)
    ros.spin_until(lambda: state(heard, 'no publisher on h'))
    ros.spin_until(lambda: state(heard, 'no publisher on h')[0] == WARN)
    levels = [s.level[0] for m in heard for s in m.status if s.message == 'no publisher on h']
    assert levels[:2] == [OK, OK] and levels == sorted(levels)


def test_an_input_that_was_never_heard_is_only_missed_after_a_while(ros):
    _, heard = intake_of(ros, stale_s=0.2, first_wait_s=1.5)
    ros.spin_until(lambda: state(heard, 'no publisher on h'))
    shown = [(s.level[0], s.message) for m in heard for s in m.status if s.name == 'taker: h']
    assert shown[0] == (OK, 'waiting for the first message of h')
    assert shown[-1] == (WARN, 'no publisher on h')


def test_a_publisher_that_begins_anew_has_lost_nothing(ros):
    intake, _ = intake_of(ros)
    publisher = publisher_to(ros, intake)
    for message in headings(0, 5):
        publisher.publish(message)
    take(ros, intake, 5)
    ros.plain.destroy_publisher(publisher)
    publisher = publisher_to(ros, intake)
    for message in headings(5, 8):
        publisher.publish(message)
    take(ros, intake, 3)
    assert (intake.received, intake.lost, intake.last_sequence) == (8, 0, 3)


def test_an_intake_that_is_not_open_takes_nothing(ros):
    intake, _ = intake_of(ros)
    intake.open = False
    publisher = ros.plain.create_publisher(Imu, 'h', qos.HEADINGS_OUT)
    ros.spin_until(lambda: intake.look() == '' and intake.publishers == 1)
    assert publisher.get_subscription_count() == 0
    intake.open = True
    ros.spin_until(lambda: intake.take() == [] and publisher.get_subscription_count() == 1)


def test_messages_come_as_they_were_serialized(ros):
    intake, _ = intake_of(ros)
    publisher = publisher_to(ros, intake)
    message, = imu_messages(Headings.as_sent([7 * 10 ** 9], [1.0]), 'h')
    publisher.publish(message)
    assert take(ros, intake, 1) == [message]


def test_messages_that_could_not_be_read_are_counted_with_the_last_reason(ros):
    intake, heard = intake_of(ros)
    publisher_to(ros, intake)
    intake.refuse([])
    intake.refuse(['too short', 'no CDR'])
    ros.spin_until(lambda: state(heard, 'refused'))
    assert intake.refused == 2
    assert state(heard, 'refused') == (WARN, '2 messages refused: no CDR')


def grown_up(intake):
    """Let an intake be there for so long that it has seen who was there before it."""
    intake._begun_s -= 60.0
    return intake


def count_before(intake):
    """Return how many messages the intake says it did not hear at the start."""
    return int(intake.take_before().count.sum())


def test_a_player_that_waits_for_nobody_is_heard_from_its_first_message(ros):
    """`ros2 bag play` at 20 times lost 22 s: it sends before its subscriptions are made."""
    intake, _ = intake_of(ros, unreliable=qos.HEADINGS_UNRELIABLE, kept=qos.HEADINGS_KEPT)
    grown_up(intake)
    publisher = ros.plain.create_publisher(Imu, 'h', qos.HEADINGS_OUT)
    for message in headings(0, 220):
        publisher.publish(message)
    assert seconds(take(ros, intake, 220)) == [*range(220)]
    assert (intake.lost, count_before(intake), intake.resubscribed) == (0, 0, 0)


@pytest.mark.parametrize('old, profile', [(True, qos.HEADINGS_OUT), (False, QoSProfile(depth=50)),
                                          (False, qos.HEADINGS_UNRELIABLE)],
                         ids=['there before', 'keeps none', 'best effort'])
def test_what_was_sent_too_early_is_counted(ros, old, profile):
    intake, heard = intake_of(ros, unreliable=qos.HEADINGS_UNRELIABLE, kept=qos.HEADINGS_KEPT)
    if not old:
        grown_up(intake)
    publisher = ros.plain.create_publisher(Imu, 'h', profile)
    for message in headings(0, 220):
        publisher.publish(message)
    ros.spin_until(lambda: intake.take() == [] and publisher.get_subscription_count() == 1)
    publisher.publish(headings(220, 221)[0])
    assert seconds(take(ros, intake, 1)) == [220]
    assert (intake.lost, count_before(intake), count_before(intake)) == (0, 220, 0)
    ros.spin_until(lambda: any(value.key == 'before_start' and value.value == '220'
                               for m in heard for s in m.status for value in s.values))


@pytest.mark.parametrize('profile', [qos.HEADINGS_OUT, QoSProfile(depth=5000),
                                     qos.HEADINGS_UNRELIABLE],
                         ids=['kept', 'not kept', 'best effort'])
def test_where_the_type_is_known_the_subscription_waits_for_any_publisher(ros, profile):
    intake, _ = intake_of(ros, unreliable=qos.HEADINGS_UNRELIABLE, kept=qos.HEADINGS_KEPT,
                          known_type=IMU)
    grown_up(intake)
    assert intake.take() == [] and reliability(ros) == [ReliabilityPolicy.BEST_EFFORT]
    publisher = ros.plain.create_publisher(Imu, 'h', profile)
    # Within one process the two know each other by then.
    ros.spin_until(publisher.get_subscription_count)
    for message in headings(0, 100):
        publisher.publish(message)
    assert seconds(take(ros, intake, 100)) == [*range(100)]
    for message in headings(100, 120):
        publisher.publish(message)
    assert seconds(take(ros, intake, 20)) == [*range(100, 120)]
    # One as good as the publisher has taken over.
    ros.spin_until(lambda: intake.look() == '' and intake.take() == []
                   and reliability(ros) == [profile.reliability])
    assert (intake.lost, count_before(intake)) == (0, 0)


def test_where_the_type_is_known_a_second_best_effort_player_is_waited_for_too(ros):
    intake, _ = intake_of(ros, unreliable=qos.HEADINGS_UNRELIABLE, kept=qos.HEADINGS_KEPT,
                          known_type=IMU)
    grown_up(intake).take()
    for first in (0, 100):
        publisher = ros.plain.create_publisher(Imu, 'h', qos.HEADINGS_UNRELIABLE)
        ros.spin_until(publisher.get_subscription_count)
        for message in headings(first, first + 50):
            publisher.publish(message)
        assert seconds(take(ros, intake, 50)) == [*range(first, first + 50)]
        ros.plain.destroy_publisher(publisher)
        ros.spin_until(lambda: intake.look() == '' and not intake.publishers)
    assert reliability(ros) == [ReliabilityPolicy.BEST_EFFORT]


def test_a_publisher_of_another_type_than_the_known_one_is_named(ros):
    intake, heard = intake_of(ros, unreliable=qos.HEADINGS_UNRELIABLE, known_type=IMU)
    ros.add(Node, 'other').create_publisher(QuaternionStamped, 'h', qos.HEADINGS_OUT)
    ros.spin_until(lambda: state(heard, 'has the type'))
    assert state(heard, 'has the type') == (
        ERROR, 'h has the type geometry_msgs/msg/QuaternionStamped; must be sensor_msgs/msg/Imu')
