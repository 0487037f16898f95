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

"""Headings, pairs and statuses as rclpy sends and receives them: the peer reads what we write."""

from __future__ import annotations

import math

from message_rows import read_headings
import numpy as np
import pytest

rclpy = pytest.importorskip('rclpy', reason='rclpy is not installed')

from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402
from geometry_msgs.msg import (  # noqa: E402
    PoseWithCovarianceStamped,
    QuaternionStamped,
    TwistStamped,
)
from hypothesis import given, strategies as st  # noqa: E402
from nav_msgs.msg import Odometry  # noqa: E402
from rclpy.serialization import deserialize_message, serialize_message  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402
from sensor_msgs.msg import Imu  # noqa: E402
from std_msgs.msg import String  # noqa: E402

from heading_intercompare.core.angles import (  # noqa: E402
    heading_from_quaternion,
    quaternion_from_heading,
)
from heading_intercompare.core.records import Headings, Pairs  # noqa: E402
from heading_intercompare.messages.heading_messages import (  # noqa: E402
    imu_messages,
    ORIENTATION_TYPES,
    pair_messages,
    read_pairs,
)
from heading_intercompare.messages.stamps import encode_clock  # noqa: E402
from heading_intercompare.messages.status_messages import (  # noqa: E402  # noqa: E402
    decode_statuses,
    decode_text,
    encode_statuses,
    encode_text,
    ERROR,
    Status,
    WARN,
)

KINDS = {'sensor_msgs/msg/Imu': Imu, 'geometry_msgs/msg/QuaternionStamped': QuaternionStamped,
         'geometry_msgs/msg/PoseWithCovarianceStamped': PoseWithCovarianceStamped,
         'nav_msgs/msg/Odometry': Odometry}
STAMPS = st.integers(0, 2 ** 31 * 10 ** 9 - 1)
DEGREES = st.floats(0.0, 360.0, exclude_max=True)
RATES = st.one_of(st.floats(-30.0, 30.0), st.just(math.nan))


def stamp_ns(message):
    """Return the stamp of a message."""
    return message.header.stamp.sec * 10 ** 9 + message.header.stamp.nanosec


def orientation(message):
    """Return the quaternion of a message."""
    if isinstance(message, Imu):
        return message.orientation
    return (message.quaternion if isinstance(message, QuaternionStamped)
            else message.pose.pose.orientation)


def of_type(name, ns, quaternion, frame=''):
    """Return a message of an accepted type."""
    message = KINDS[name]()
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(ns, 10 ** 9)
    message.header.frame_id = frame
    if name == 'nav_msgs/msg/Odometry':
        message.child_frame_id = frame[::-1] + 'x'
    q = orientation(message)
    q.x, q.y, q.z, q.w = quaternion
    return message


def one_by_one(messages, convention):
    """Return headings of message objects, each on its own."""
    heading_deg = []
    for message in messages:
        q = orientation(message)
        found, = heading_from_quaternion([q.x], [q.y], [q.z], [q.w], convention)
        absent = isinstance(message, Imu) and message.orientation_covariance[0] == -1.0
        heading_deg.append(math.nan if absent else found)
    return Headings.as_sent([stamp_ns(message) for message in messages], heading_deg)


def test_every_type_of_headings_is_tried():
    assert KINDS.keys() == ORIENTATION_TYPES.keys()


@pytest.mark.parametrize('convention', ['enu', 'ned'])
@pytest.mark.parametrize('name', KINDS)
def test_what_rclpy_sends_is_read_as_its_objects_say(name, convention, rng):
    rotations = rng.standard_normal((50, 4))
    rotations /= np.linalg.norm(rotations, axis=1, keepdims=True)
    messages = [of_type(name, 10 ** 18 + i, rotation, 'gyro' * (i % 5))
                for i, rotation in enumerate(rotations.tolist())]
    messages.append(of_type(name, 10 ** 18 + 50, [0.0] * 4))
    headings, refused = read_headings(name, convention, [serialize_message(m) for m in messages])
    assert refused == []
    assert headings == one_by_one(messages, convention)
    assert np.isfinite(headings.heading_deg[:50]).all() and np.isnan(headings.heading_deg[50])


@pytest.mark.parametrize('name', KINDS)
def test_level_east_is_90_in_either_convention(name):
    east = {'enu': [0.0, 0.0, 0.0, 1.0], 'ned': [0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)]}
    for convention, quaternion in east.items():
        message = serialize_message(of_type(name, 1, quaternion))
        headings, _ = read_headings(name, convention, [message])
        assert headings.heading_deg[0] == pytest.approx(90.0)


def test_an_imu_that_has_no_orientation_is_invalid():
    message = of_type('sensor_msgs/msg/Imu', 1, [0.0, 0.0, 0.0, 1.0])
    message.orientation_covariance[0] = -1.0
    headings, _ = read_headings('sensor_msgs/msg/Imu', 'enu', [serialize_message(message)])
    assert np.isnan(headings.heading_deg).all()


@given(st.lists(st.tuples(STAMPS, st.one_of(DEGREES, st.just(math.nan)),
                          st.floats(0.0, 10.0), RATES), max_size=5))
def test_rclpy_receives_the_headings_that_were_sent(rows):
    stamps, heading_deg, sigma_deg, rate_deg_s = map(list, zip(*rows)) if rows else ([],) * 4
    sent = imu_messages(Headings.as_sent(stamps, heading_deg), 'ts_heading', sigma_deg=sigma_deg,
                        turn_rate_deg_s=rate_deg_s)
    z, w = quaternion_from_heading(heading_deg)
    assert len(sent) == len(rows)
    for i, data in enumerate(sent):
        message = deserialize_message(data, Imu)
        known, turning = math.isfinite(heading_deg[i]), math.isfinite(rate_deg_s[i])
        assert (stamp_ns(message), message.header.frame_id) == (stamps[i], 'ts_heading')
        assert (message.orientation.x, message.orientation.y) == (0.0, 0.0)
        assert message.orientation.z == (z[i] if known else 0.0)
        assert message.orientation.w == (w[i] if known else 0.0)
        assert message.orientation_covariance.tolist() == [0.0 if known else -1.0] + [0.0] * 7 + [
            math.radians(sigma_deg[i]) * math.radians(sigma_deg[i]) if known else 0.0]
        assert message.angular_velocity.z == (-math.radians(rate_deg_s[i]) if turning else 0.0)
        assert message.angular_velocity_covariance[0] == (0.0 if turning else -1.0)
        assert message.linear_acceleration_covariance[0] == -1.0


def test_the_fields_of_a_heading_by_hand():
    """Heading 0 is yaw 90; sigma 1 deg is 3.0462e-4 rad2; 2 deg/s to starboard is negative."""
    data, = imu_messages(Headings.as_sent([1_500_000_000], [0.0]), 'gyro', sigma_deg=[1.0],
                         turn_rate_deg_s=[2.0])
    message = deserialize_message(data, Imu)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 500_000_000)
    assert message.header.frame_id == 'gyro'
    assert message.orientation.z == pytest.approx(math.sqrt(0.5))
    assert message.orientation.w == pytest.approx(math.sqrt(0.5))
    assert message.orientation_covariance[8] == pytest.approx(3.0462e-4, rel=1e-4)
    assert message.angular_velocity.z == pytest.approx(-0.0349066, rel=1e-5)
    assert message.angular_velocity_covariance[0] == 0.0
    assert message.linear_acceleration_covariance[0] == -1.0


@given(st.lists(st.tuples(STAMPS, DEGREES, DEGREES, st.integers(-60 * 10 ** 9, 60 * 10 ** 9),
                          st.floats(0.5, 1.0), st.floats(0.5, 1.0)), max_size=5))
def test_pairs_that_pass_through_rclpy_arrive_to_the_bit(rows):
    pairs = Pairs.of(*map(list, zip(*rows))) if rows else Pairs.empty()
    objects = [deserialize_message(data, TwistStamped) for data in pair_messages(pairs)]
    assert read_pairs([serialize_message(message) for message in objects]) == (pairs, [])


def test_the_fields_of_a_pair_by_hand():
    data, = pair_messages(Pairs.of([3], [1.0], [359.5], [-250_000_000], [0.625], [0.75]))
    message = deserialize_message(data, TwistStamped)
    linear, angular = message.twist.linear, message.twist.angular
    assert stamp_ns(message) == 3
    assert (linear.x, linear.y, linear.z) == (1.5, 359.5, 1.0)
    assert (angular.x, angular.y, angular.z) == (-0.25, 0.625, 0.75)


def test_statuses_pass_through_rclpy():
    statuses = [Status('ts/heading', WARN, 'silent, 54° N', {'age_s': '3.5', 'type': ''}),
                Status('', ERROR, '', {})]
    message = deserialize_message(encode_statuses(7_000_000_001, statuses), DiagnosticArray)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (7, 1)
    assert [one.level for one in message.status] == [b'\1', b'\2']
    assert message.status[0].message == 'silent, 54° N'
    assert [(v.key, v.value) for v in message.status[0].values] == [('age_s', '3.5'),
                                                                    ('type', '')]
    assert decode_statuses(serialize_message(message)) == (7_000_000_001, statuses)


@pytest.mark.parametrize('text', ['', 'wind 7, Länge 54°', 'x' * 100_000])
def test_texts_pass_through_rclpy(text):
    message = deserialize_message(encode_text(text), String)
    assert message.data == text
    assert decode_text(serialize_message(message)) == text


def test_a_clock_is_received_by_rclpy():
    clock = deserialize_message(encode_clock(1_700_000_000_123_456_789), Clock).clock
    assert (clock.sec, clock.nanosec) == (1_700_000_000, 123_456_789)
