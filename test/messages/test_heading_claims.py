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

"""The standard deviations that messages claim for their headings."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.records import Headings
from heading_intercompare.messages.byte_columns import join_messages
from heading_intercompare.messages.cdr import encode
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.heading_claims import find_claims
from heading_intercompare.messages.heading_messages import (
    AZIMUTH_TYPES,
    encode_imu,
    HEADING_TYPES,
    IMU,
)

HEADER = {'stamp': {'sec': 1_500_000_000, 'nanosec': 7}, 'frame_id': 'gyro'}
POSE, ODOMETRY = 'geometry_msgs/msg/PoseWithCovarianceStamped', 'nav_msgs/msg/Odometry'
QUATERNION = 'geometry_msgs/msg/QuaternionStamped'


def imu(variance, first=0.0):
    return encode(IMU, {'header': HEADER,
                        'orientation_covariance': [first, *[7.0] * 7, variance]})


def with_pose(type_name, variance, **fields):
    return encode(type_name, {'header': HEADER, **fields,
                              'pose': {'covariance': [-1.0, *[7.0] * 34, variance]}})


def azimuth(type_name, variance, unit):
    return encode(type_name, {'header': HEADER, 'variance': variance, 'unit': unit})


def claims(type_name, *messages, part=''):
    rows = find_claims(type_name, part).decode(*join_messages(messages))
    assert rows.stamp_ns.tolist() == [1_500_000_000_000_000_007] * len(messages)
    assert not rows.flag.any()
    return rows.stated_deg.tolist()


@pytest.mark.parametrize('type_name, message, part', [
    (IMU, imu(0.01), 'orientation'),
    (POSE, with_pose(POSE, 0.01), 'pose.pose.orientation'),
    (ODOMETRY, with_pose(ODOMETRY, 0.01, child_frame_id='base_link'), 'pose.pose.orientation'),
    *((kind, azimuth(kind, 0.01, 0), 'azimuth') for kind in AZIMUTH_TYPES)])
def test_the_variance_about_the_vertical_is_the_claim(type_name, message, part):
    """Of the whole message, and of the field of the heading; no other field has this variance."""
    assert claims(type_name, message) == claims(type_name, message, part=part) == [5.73]
    assert find_claims(type_name, 'twist.twist.angular.z') is None


@pytest.mark.parametrize('kind', AZIMUTH_TYPES)
def test_an_azimuth_claims_in_the_unit_of_each_message(kind):
    assert claims(kind, azimuth(kind, 0.25, 1), azimuth(kind, 0.25, 0)) == [0.5, 28.6]


def test_types_without_a_variance_claim_nothing():
    without = {kind for kind in (*HEADING_TYPES, 'geometry_msgs/msg/PoseStamped')
               if find_claims(kind, '') is None}
    assert without == {QUATERNION, 'geometry_msgs/msg/PoseStamped'}


@pytest.mark.parametrize('variance', [
    0.0, -0.0, -1.0, np.nan, np.inf, -np.inf, 1e6, 99999.0, 1e308, 9.88, 5e-324])
def test_what_no_angle_has_is_no_claim(variance):
    """Zero is unknown, and constants of drivers that know none exceed half a turn."""
    assert np.isnan(claims(IMU, imu(variance), imu(0.01))).tolist() == [True, False]


def test_half_a_turn_is_the_largest_claim():
    assert claims(IMU, imu(np.pi ** 2)) == [180.0]


def test_an_imu_without_orientation_claims_nothing():
    assert np.isnan(claims(IMU, imu(0.01, first=-1.0), imu(0.01))).tolist() == [True, False]


@pytest.mark.parametrize('sigma_deg, claim_deg', [
    (0.02, 0.02), (0.4, 0.4), (0.123456, 0.123), (99.96, 100.0), (0.09996, 0.1), (1e-7, 1e-7)])
def test_a_claim_has_three_figures(sigma_deg, claim_deg):
    """A filter differs in the last digits of each message, which says nothing new."""
    row = encode_imu(Headings.of([0], [90.0]), 'x', sigma_deg=sigma_deg)[0].tobytes()
    assert find_claims(IMU, '').decode(*join_messages([row])).stated_deg.tolist() == [
        pytest.approx(claim_deg, rel=1e-12)]


def test_a_message_that_is_too_short_is_refused():
    with pytest.raises(MessageError, match='too short'):
        claims(IMU, imu(0.01)[:60])


LONG_NAME = {**HEADER, 'frame_id': 'gyrocompass'}


@pytest.mark.parametrize('middle, is_alike', [
    (imu(0.01), True), (imu(0.02), False), (imu(0.01, first=-1.0), False),
    (encode(IMU, {'header': LONG_NAME, 'orientation_covariance': [0.0, *[7.0] * 7, 0.01]}), False),
    (b'\0\0' + imu(0.01)[2:], False)])
def test_claims_are_alike_if_no_message_differs_in_what_tells_its_claim(middle, is_alike):
    """Where they are, the claims of the first and of the last say all."""
    messages = join_messages([imu(0.01), middle, imu(0.01), imu(0.01)])
    assert find_claims(IMU, '').are_alike(*messages) is is_alike


def test_too_short_messages_are_not_alike():
    assert not find_claims(IMU, '').are_alike(*join_messages([imu(0.01)[:60]] * 4))
