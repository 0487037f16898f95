# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Headings and pairs as messages: nothing is lost on the way, and bags say the same."""

from __future__ import annotations

import math

from geometry_msgs.msg import PoseWithCovarianceStamped, QuaternionStamped, TwistStamped
from hypothesis import given, strategies as st
from nav_msgs.msg import Odometry
import numpy as np
import pytest
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import Imu

from heading_intercompare.bags.codec.heading_messages import (
    decode_headings,
    encode_imu,
    encode_pairs,
)
from heading_intercompare.core.angles import quaternion_from_heading
from heading_intercompare.core.records import Headings, Pairs
from heading_intercompare.nodes.ros.messages import (
    heading_messages,
    HEADING_TYPES,
    headings_from,
    pair_messages,
    pairs_from,
)

STAMPS = st.integers(0, 2 ** 31 * 10 ** 9 - 1)
DEGREES = st.floats(0.0, 360.0, exclude_max=True)
RATES = st.one_of(st.floats(-30.0, 30.0), st.just(math.nan))


def sent(message):
    """Return a message as it arrives."""
    return deserialize_message(serialize_message(message), type(message))


def decoded(type_name, convention, messages):
    """Return what the bag reader makes of the messages once they are recorded."""
    data = [serialize_message(m) for m in messages]
    ends = np.cumsum([0, *map(len, data)])
    return decode_headings(type_name, convention, b''.join(data), ends[:-1], ends[1:])


@given(st.lists(st.tuples(STAMPS, st.one_of(DEGREES, st.just(math.nan)),
                          st.floats(0.0, 10.0), RATES), max_size=5))
def test_a_published_heading_arrives_and_is_the_message_that_bags_write(rows):
    stamp_ns, heading_deg, sigma_deg, rate_deg_s = map(list, zip(*rows)) if rows else ([],) * 4
    headings = Headings.of(stamp_ns, heading_deg)
    messages = heading_messages(headings, 'ts_heading', sigma_deg, rate_deg_s)
    assert [sent(m) for m in messages] == messages
    written = encode_imu(headings, 'ts_heading', sigma_deg=np.array(sigma_deg),
                         turn_rate_deg_s=np.array(rate_deg_s))
    assert [deserialize_message(row.tobytes(), Imu) for row in written] == messages
    arrived = headings_from(messages, 'enu')
    assert arrived == decoded('sensor_msgs/msg/Imu', 'enu', messages)
    assert arrived.stamp_ns.tolist() == stamp_ns
    off_deg = (arrived.heading_deg - headings.heading_deg + 180.0) % 360.0 - 180.0
    assert np.array_equal(np.isnan(off_deg), np.isnan(headings.heading_deg))
    assert np.nanmax(np.abs(off_deg), initial=0.0) < 1e-12


def of_type(name, stamp_ns, quaternion):
    """Return a message of an accepted type."""
    message = HEADING_TYPES[name]()
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, 10 ** 9)
    if isinstance(message, Imu):
        q = message.orientation
    elif isinstance(message, QuaternionStamped):
        q = message.quaternion
    else:
        q = message.pose.pose.orientation
    q.x, q.y, q.z, q.w = quaternion
    return message


@pytest.mark.parametrize('convention', ['enu', 'ned'])
@pytest.mark.parametrize('name', HEADING_TYPES)
def test_each_accepted_type_gives_live_what_its_recording_gives(name, convention, rng):
    messages = [of_type(name, 10 ** 18 + i, rng.standard_normal(4).tolist()) for i in range(50)]
    messages.append(of_type(name, 10 ** 18 + 50, [0.0] * 4))
    live = headings_from(messages, convention)
    assert live == decoded(name, convention, messages)
    assert np.isfinite(live.heading_deg[:50]).all() and np.isnan(live.heading_deg[50])


@pytest.mark.parametrize('name', HEADING_TYPES)
def test_level_east_is_90_in_either_convention(name):
    east_enu = of_type(name, 1, [0.0, 0.0, 0.0, 1.0])
    east_ned = of_type(name, 1, [0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)])
    assert headings_from([east_enu], 'enu').heading_deg[0] == pytest.approx(90.0)
    assert headings_from([east_ned], 'ned').heading_deg[0] == pytest.approx(90.0)


def test_an_imu_that_has_no_orientation_is_invalid():
    message = of_type('sensor_msgs/msg/Imu', 1, [0.0, 0.0, 0.0, 1.0])
    message.orientation_covariance[0] = -1.0
    assert np.isnan(headings_from([message], 'enu').heading_deg).all()


def test_an_invalid_heading_is_published_as_one_without_orientation():
    message, = heading_messages(Headings.of([1], [math.nan]), 'ts_heading', [0.1], [2.0])
    assert message.orientation_covariance[0] == -1.0
    assert message.orientation.w == 0.0


def test_the_fields_of_a_heading_by_hand():
    """Heading 0 is yaw 90; sigma 1 deg is 3.0462e-4 rad2; 2 deg/s to starboard is negative."""
    message, = heading_messages(Headings.of([1_500_000_000], [0.0]), 'gyro', [1.0], [2.0])
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 500_000_000)
    assert message.header.frame_id == 'gyro'
    assert message.orientation.z == pytest.approx(math.sqrt(0.5))
    assert message.orientation.w == pytest.approx(math.sqrt(0.5))
    assert message.orientation_covariance[8] == pytest.approx(3.0462e-4, rel=1e-4)
    assert message.angular_velocity.z == pytest.approx(-0.0349066, rel=1e-5)
    assert message.angular_velocity_covariance[0] == 0.0
    assert message.linear_acceleration_covariance[0] == -1.0


def test_a_stamp_that_no_message_can_hold_is_left_out():
    headings = Headings.of([-1, 5, 2 ** 31 * 10 ** 9], [1.0, 2.0, 3.0])
    messages = heading_messages(headings, '')
    assert headings_from(messages, 'enu').stamp_ns.tolist() == [5]


def test_no_messages_give_the_empty_chunk():
    assert headings_from([], 'enu') == Headings.empty()
    assert heading_messages(Headings.empty(), '') == []
    assert pairs_from([]) == Pairs.empty()
    assert pair_messages(Pairs.empty()) == []


@given(st.lists(st.tuples(STAMPS, DEGREES, DEGREES, st.integers(-60 * 10 ** 9, 60 * 10 ** 9),
                          st.floats(0.5, 1.0), st.floats(0.5, 1.0)), max_size=5))
def test_published_pairs_arrive_to_the_bit_and_are_what_bags_write(rows):
    pairs = Pairs.of(*map(list, zip(*rows))) if rows else Pairs.empty()
    messages = pair_messages(pairs)
    assert pairs_from([sent(m) for m in messages]) == pairs
    assert [deserialize_message(row.tobytes(), TwistStamped)
            for row in encode_pairs(pairs)] == messages


def test_the_fields_of_a_pair_by_hand():
    message, = pair_messages(Pairs.of([3], [1.0], [359.5], [-250_000_000], [0.625], [0.75]))
    linear, angular = message.twist.linear, message.twist.angular
    assert (linear.x, linear.y, linear.z) == (1.5, 359.5, 1.0)
    assert (angular.x, angular.y, angular.z) == (-0.25, 0.625, 0.75)


def test_pairs_of_a_version_that_did_not_interpolate_the_ts_have_a_factor_of_1():
    message, = pair_messages(Pairs.of([3], [1.0], [359.5]))
    message.twist.angular.z = 0.0
    assert pairs_from([message]) == Pairs.of([3], [1.0], [359.5])


def test_numbers_of_numpy_do_not_reach_a_message_unconverted():
    z, w = quaternion_from_heading(np.float32([90.0]))
    message, = heading_messages(Headings(np.array([7]), np.array([90.0])), np.str_('f'),
                                np.float32([0.5]), np.float32([1.0]))
    assert sent(message) == message
    assert (message.orientation.z, message.orientation.w) == (z[0], w[0])
    assert sent(pair_messages(Pairs.of([1], [2.0], [3.0]))[0]).twist.linear.x == -1.0
    assert TwistStamped().twist.linear.x == 0.0


def test_the_types_are_those_of_their_names():
    assert HEADING_TYPES == {'sensor_msgs/msg/Imu': Imu,
                             'geometry_msgs/msg/QuaternionStamped': QuaternionStamped,
                             'geometry_msgs/msg/PoseWithCovarianceStamped':
                                 PoseWithCovarianceStamped,
                             'nav_msgs/msg/Odometry': Odometry}
