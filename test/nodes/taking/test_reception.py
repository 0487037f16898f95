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

"""A subscription takes over from another one, and each message comes once."""

from __future__ import annotations

import time

import pytest
from std_msgs.msg import String

from heading_intercompare.bags.recording.cut_bag import LastMessages
from heading_intercompare.messages.status_messages import decode_text, encode_text
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.spinning.batches import take_all, Unwatched
from heading_intercompare.nodes.taking.reception import Reception


class Line:
    """A publisher, a reception of its topic, and what came."""

    def __init__(self, ros):
        self.ros, self.sent, self.taken = ros, 0, []
        self.publisher = ros.plain.create_publisher(String, 's', qos.HEADINGS_OUT)
        self.reception = Reception(ros.plain, 's', Unwatched())

    def send(self, n):
        """Publish the next n numbers."""
        for _ in range(n):
            self.sent += 1
            self.publisher.publish(encode_text(str(self.sent)))

    def take(self):
        """Take what has come."""
        self.taken += [int(decode_text(data)) for data, _ in self.reception.take()]

    def take_until(self, condition):
        """Take what comes until a condition holds."""
        self.ros.spin_until(lambda: (self.take(), condition())[1])

    def open(self, profile=qos.HEADINGS_IN):
        """Subscribe, and wait for the publisher."""
        self.reception.open(String, profile)
        self.ros.spin_until(lambda: self.publisher.get_subscription_count() == 1)


def test_a_whole_reception_takes_what_was_sent_before_the_first_message_that_came():
    """What a publisher keeps may come after what it sends now."""
    def message(number):
        return b'', {'publication_sequence_number': number, 'source_timestamp': number,
                     'received_timestamp': 0}
    kept, whole = (Reception(None, 's', None, whole=whole) for whole in (False, True))
    for one, numbers in ((kept, [3, 4]), (whole, [3, 4, 1, 2])):
        taken = one._once([message(3), message(4)]) + one._once(
            [message(1), message(2), message(3)])
        assert [info['publication_sequence_number'] for _, info in taken] == numbers


def test_what_an_earlier_process_recorded_is_not_taken_again():
    """The publisher holds 41 to 60; 55 is the last one in the bag, which was read from 45 on."""
    def message(number, sent_ns=0, received_ns=0):
        return b'', {'publication_sequence_number': number,
                     'source_timestamp': sent_ns or 10 * number, 'received_timestamp': received_ns}

    def take(*messages):
        return [info['publication_sequence_number'] for _, info in reception._once(messages)]
    reception = Reception(None, 's', None)
    reception.go_on(LastMessages(tuple((n, 10 * n) for n in range(45, 56)), 450))
    reception._kept_until_ns = 1000
    assert take(*map(message, range(41, 61))) == [*range(56, 61)]
    # Another publisher: what it sent before the bag ended, but after it was last looked at.
    assert take(message(300, 440), message(301, 455), message(1, 700)) == [301, 1]
    # Its clock is slow: what comes late is new.
    assert take(message(302, 100, 900)) == [] and take(message(302, 100, 1100)) == [302]


@pytest.fixture
def line(ros):
    """Return a line."""
    return Line(ros)


def test_the_one_that_takes_over_leaves_out_what_came_before_the_first(line):
    line.send(100)
    line.open()
    line.send(20)
    line.take_until(lambda: len(line.taken) == 20)
    line.reception.hand_over(qos.HEADINGS_KEPT)
    line.take_until(lambda: line.publisher.get_subscription_count() == 1)
    line.send(30)
    line.take_until(lambda: len(line.taken) == 50)
    assert line.taken == [*range(101, 151)] and line.reception.newest == 150


def test_while_one_takes_over_nothing_comes_twice_and_nothing_is_lost(line):
    line.send(10)
    line.open()
    line.send(200)
    line.take_until(lambda: line.taken)
    line.reception.hand_over(qos.HEADINGS_KEPT)
    for _ in range(40):
        line.send(50)
        line.take()
    line.take_until(lambda: len(line.taken) == 2200)
    assert line.taken == [*range(11, 2211)]
    line.take_until(lambda: line.publisher.get_subscription_count() == 1)


def test_a_later_publisher_is_heard_from_its_first_message(line):
    """Its numbers begin with 1 again, and are not those that came before."""
    line.open()
    line.send(50)
    line.take_until(lambda: len(line.taken) == 50)
    line.reception.hand_over(qos.HEADINGS_KEPT)
    line.take_until(lambda: line.publisher.get_subscription_count() == 1)
    line.ros.plain.destroy_publisher(line.publisher)
    line.publisher = line.ros.plain.create_publisher(String, 's', qos.HEADINGS_OUT)
    line.send(60)
    line.take_until(lambda: len(line.taken) == 110)
    assert line.taken == [*range(1, 111)]


def test_what_a_closed_one_held_is_not_lost(line):
    line.open()
    line.send(10)
    line.ros.spin_until(lambda: line.publisher.wait_for_all_acked())
    line.reception.close()
    assert not line.reception.there
    line.take_until(lambda: len(line.taken) == 10)


def test_a_second_hand_over_replaces_one_that_is_not_done(line):
    line.open()
    line.reception.hand_over(qos.HEADINGS_KEPT)
    line.reception.hand_over(qos.HEADINGS_KEPT)
    line.send(10)
    line.take_until(lambda: line.publisher.get_subscription_count() == 1
                    and len(line.taken) == 10)
    assert line.taken == [*range(1, 11)]


@pytest.mark.parametrize('lost', [range(31, 41), range(41, 51)], ids=['amid others', 'the last'])
def test_one_made_again_brings_what_the_first_one_did_not(line, lost):
    """As when DDS has given up this process for a time, and does not send again."""
    line.send(10)
    line.open()
    line.send(20)
    line.take_until(lambda: len(line.taken) == 20)
    line.reception.hand_over(qos.HEADINGS_KEPT)
    line.take_until(lambda: line.publisher.get_subscription_count() == 1)
    if lost[0] > 31:
        line.send(10)
        line.take_until(lambda: len(line.taken) == 30)
    line.send(10)
    stolen = []
    line.ros.spin_until(lambda: stolen.extend(take_all(line.reception._current))
                        or len(stolen) == 10)
    if lost[0] == 31:
        line.send(10)
        line.take_until(lambda: len(line.taken) == 30)
    line.reception.hand_over(qos.HEADINGS_KEPT)
    line.take_until(lambda: len(line.taken) == 40)
    assert sorted(line.taken) == [*range(11, 51)] and line.taken[-10:] == [*lost]


def test_what_was_set_aside_is_used_where_the_next_one_does_not_bring_it(line):
    """The next one begins with what was sent after it; what it missed came before."""
    line.send(20)
    line.open()
    since_ns = time.time_ns()
    line.send(30)
    line.ros.spin_until(lambda: line.publisher.wait_for_all_acked())
    line.reception.set_aside()
    line.reception.open(String, qos.HEADINGS_KEPT, since_ns=since_ns)
    stolen = []
    line.ros.spin_until(lambda: stolen.extend(take_all(line.reception._current))
                        or len(stolen) == 50)
    line.send(5)
    line.take_until(lambda: len(line.taken) == 35)
    line.reception.hand_over(qos.HEADINGS_KEPT)
    line.take_until(lambda: line.publisher.get_subscription_count() == 1)
    assert line.taken == [*range(21, 56)]


def test_what_was_set_aside_is_used_where_its_publisher_has_ended(line):
    """Before, a node that had stood still took no message of a source that ended meanwhile."""
    line.open()
    since_ns = time.time_ns()
    line.send(30)
    line.ros.spin_until(lambda: line.publisher.wait_for_all_acked())
    line.reception.set_aside()
    line.ros.plain.destroy_publisher(line.publisher)
    line.reception.open(String, qos.HEADINGS_KEPT, since_ns=since_ns)
    line.take()
    assert line.taken == []
    line.reception.bring_back()
    line.take()
    assert line.taken == [*range(1, 31)]


def test_what_was_set_aside_comes_once_where_the_next_one_brings_it(line):
    line.open()
    since_ns = time.time_ns()
    line.send(30)
    line.ros.spin_until(lambda: line.publisher.wait_for_all_acked())
    line.reception.set_aside()
    line.reception.open(String, qos.HEADINGS_KEPT, since_ns=since_ns)
    line.take_until(lambda: len(line.taken) == 30)
    line.reception.bring_back()
    line.send(1)
    line.take_until(lambda: len(line.taken) > 30)
    assert line.taken == [*range(1, 32)]
