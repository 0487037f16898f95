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

"""What the next recorder knows of the bag of one that was cut off."""

from __future__ import annotations

import pytest

from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.recording.cut_bag import LastMessages, read_last
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.publisher_starts import PublisherRecords, PublisherStart
from heading_intercompare.messages.heading_messages import IMU

S = 1_000_000_000


@pytest.fixture
def bag(tmp_path):
    """Return a bag of 30 s at 10 Hz of the TS, of an RS that fell silent early, and no pairs."""
    with BagWriter(tmp_path / 'bag') as writer:
        records = PublisherRecords(writer.metadata)
        records.add('/ts/heading', [PublisherStart('aa', 1, 5), PublisherStart('bb', 3, 7)])
        records.add('/ts/heading', [PublisherStart('', 40, 9)])
        for topic, n in (('/ts/heading', 300), ('/rs/heading', 50), ('/pairs', 0)):
            writer.add_topic(topic, IMU)
            for number in range(1, n + 1):
                sent_ns = 100 * S + number * S // 10
                writer.write(topic, b'\0' * 400, sent_ns + 1000, sent_ns, number)
    return tmp_path / 'bag'


def test_the_last_messages_of_each_topic_and_its_publisher_are_known(bag):
    last = read_last(BagReader(bag))
    assert last.keys() == {'/ts/heading', '/rs/heading'}
    ts, rs = last['/ts/heading'], last['/rs/heading']
    assert ts.names == tuple((number, 100 * S + number * S // 10) for number in range(200, 301))
    assert (ts.since_ns, ts.publisher) == (120 * S + 1000, 'bb')
    assert rs == LastMessages((), 120 * S + 1000, '')


@pytest.mark.parametrize('number, sent_s, there', [
    (300, 130.0, True), (250, 125.0, True), (301, 130.1, False),
    # Another publisher, which began again; and the same one, whose clock was set back.
    (1, 130.2, False), (301, 90.0, False)])
def test_what_was_sent_after_the_last_message_is_not_in_the_bag(bag, number, sent_s, there):
    assert read_last(BagReader(bag))['/ts/heading'].holds(number, round(sent_s * S)) == there


def test_a_bag_without_the_topic_holds_nothing_of_it():
    assert not LastMessages().holds(1, 1)
