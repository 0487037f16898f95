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

"""The motion of the ship in bags, also in those of other programs."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.motion_topics import motion_topics, read_bag_motion
from heading_intercompare.core.records import Motion
from heading_intercompare.core.settings import MotionRule
from heading_intercompare.messages.cdr import encode
from heading_intercompare.messages.motion.motion_messages import encode_motion, MOTION_TYPES

S = 10 ** 9
STAMPS = 10 ** 18 + np.arange(100) * S
TWIST = 'geometry_msgs/msg/TwistStamped'
PARTS = {'fix': Motion.of_positions(STAMPS, np.linspace(50.0, 51.0, 100), np.full(100, 8.0)),
         'velocity': Motion.of_velocities(STAMPS, np.linspace(-1.0, 1.0, 100), np.full(100, 5.0)),
         'rate': Motion.of_rates(STAMPS, np.linspace(-1.0, 1.0, 100))}


@pytest.fixture
def bag(tmp_path):
    """Return a function that writes a bag with some topics of the motion, and opens it."""
    def write(**topics):
        with BagWriter(tmp_path / 'bag') as writer:
            writer.add_topic('ts/heading', 'sensor_msgs/msg/Imu')
            writer.write('ts/heading', encode('sensor_msgs/msg/Imu', {}), int(STAMPS[0]))
            for what, topic in topics.items():
                writer.add_topic(topic, MOTION_TYPES[what][0])
                writer.write_rows([Rows(topic, encode_motion(PARTS[what], what, 'gps'), STAMPS,
                                        STAMPS, np.arange(100))])
        return BagReader(tmp_path / 'bag')
    return write


def test_a_bag_gives_its_motion_back(bag):
    found = read_bag_motion(bag(**motion_topics(MotionRule())), MotionRule())
    assert found.topics == {'fix': '/ship/fix', 'velocity': '/ship/velocity',
                            'rate': '/ship/rate_of_turn'}
    assert found.rows.positions() == PARTS['fix']
    assert found.rows.velocities() == PARTS['velocity']
    assert found.rows.rates().rate_deg_s == pytest.approx(PARTS['rate'].rate_deg_s, rel=1e-14)


def test_a_bag_without_motion_has_none(bag):
    found = read_bag_motion(bag(), MotionRule())
    assert (len(found.rows), found.topics, found.unreadable) == (0, {}, 0)


def test_topics_of_other_programs_are_named_by_settings(bag):
    """One topic may tell both the velocity and the rate of turn."""
    rule = MotionRule(fix_topic='/gps/fix', velocity_topic='gps/vel', rate_topic='gps/vel')
    found = read_bag_motion(bag(fix='/gps/fix', velocity='/gps/vel'), rule)
    assert len(found.rows) == 300 and found.topics['rate'] == '/gps/vel'


def test_a_topic_that_was_asked_for_must_be_there(bag):
    with pytest.raises(BagError, match="has no topic '/gps/fix'"):
        read_bag_motion(bag(fix='ship/fix'), MotionRule(fix_topic='/gps/fix'))


def test_a_topic_of_another_type_is_refused_in_one_line(bag):
    with pytest.raises(BagError) as error:
        read_bag_motion(bag(velocity='ship/fix'), MotionRule())
    assert str(error.value).endswith(
        f'topic /ship/fix is {TWIST}; the positions of a ship are sensor_msgs/msg/NavSatFix; name '
        'another topic with motion.fix_topic')


def test_messages_that_cannot_be_read_are_counted(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic('ship/velocity', TWIST)
        for k, data in enumerate((encode(TWIST, {}), b'\0\1\0\0short', encode(TWIST, {}))):
            writer.write('ship/velocity', data, int(STAMPS[k]))
    found = read_bag_motion(BagReader(tmp_path / 'bag'), MotionRule())
    assert (len(found.rows), found.unreadable) == (2, 1)


def test_the_motion_of_another_graph_is_left_out_and_named(bag):
    """It was left out without a word."""
    reader = bag(fix='/ship1/ship/fix', rate='/ship1/ship/rate_of_turn')
    assert not read_bag_motion(reader, MotionRule()).topics
    assert reader.oddities == ['the motion of another graph (/ship1/ship/fix, '
                               '/ship1/ship/rate_of_turn) does not count; bag_namespace names '
                               'another']
    again = BagReader(reader.path, '/ship1')
    assert read_bag_motion(again, MotionRule()).topics.keys() == {'fix', 'rate'}
    assert again.oddities == []
