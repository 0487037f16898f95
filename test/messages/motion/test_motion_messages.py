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

"""The motion of the ship in messages, against the encoder of single messages and rosbags."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.core.records import Motion
from heading_intercompare.messages.byte_columns import join_messages, split_rows
from heading_intercompare.messages.cdr import decode, encode
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.motion.motion_messages import (
    decode_motion,
    encode_motion,
    FIX,
    MOTION_TYPES,
    read_motion,
)

TWIST = 'geometry_msgs/msg/TwistStamped'
S = 1_000_000_000
STAMPS = np.arange(1, 6) * S + 1_400_000_000 * S
HEADER = {'stamp': {'sec': 7, 'nanosec': 5}, 'frame_id': 'gps'}


def motion(what):
    """Return five rows that tell one thing."""
    values = np.linspace(-0.5, 0.7, 5)
    if what == 'fix':
        return Motion.of_positions(STAMPS, 50.0 + values, 10.0 * values)
    if what == 'velocity':
        return Motion.of_velocities(STAMPS, values, 5.0 - values)
    return Motion.of_rates(STAMPS, values)


@pytest.mark.parametrize('what', ['fix', 'velocity'])
@pytest.mark.parametrize('frame', ['', 'g', 'gps', 'gps_link'])
def test_positions_and_velocities_come_back_to_the_bit(what, frame):
    messages = split_rows(encode_motion(motion(what), what, frame))
    assert decode_motion(MOTION_TYPES[what][0], what, *join_messages(messages)) == motion(what)


def test_a_turn_to_starboard_is_negative_about_the_axis_that_points_up():
    rows = split_rows(encode_motion(Motion.of_rates(STAMPS[:1], [3.0]), 'rate', 'ship'))
    assert decode(TWIST, rows[0])['twist']['angular']['z'] == pytest.approx(-math.radians(3.0))
    back = decode_motion(TWIST, 'rate', *join_messages(rows))
    assert back.rate_deg_s == pytest.approx([3.0], rel=1e-15)


def test_ten_knots_to_the_east_are_in_x():
    rows = split_rows(encode_motion(Motion.of_courses(STAMPS[:1], [90.0], [10.0]), 'velocity', ''))
    linear = decode(TWIST, rows[0])['twist']['linear']
    assert (linear['x'], linear['y'], linear['z']) == pytest.approx((5.14444, 0.0, 0.0), abs=1e-4)


def test_a_fix_says_that_it_is_one_and_knows_no_altitude():
    fix = decode(FIX, split_rows(encode_motion(motion('fix')[:1], 'fix', 'gps'))[0])
    assert fix['status'] == {'status': 0, 'service': 0}
    assert (fix['latitude'], fix['longitude']) == (49.5, -5.0)
    assert math.isnan(fix['altitude']) and fix['position_covariance_type'] == 0


@pytest.mark.parametrize('frame', ['', 'g', 'gp', 'gps', 'gps_1', 'gps_link'])
@pytest.mark.parametrize('status, there', [(-2, False), (-1, False), (0, True), (2, True)])
def test_a_message_without_a_fix_has_no_position(frame, status, there):
    data = encode(FIX, {'header': {**HEADER, 'frame_id': frame}, 'latitude': 54.0,
                        'longitude': -10.0, 'status': {'status': status, 'service': 513}})
    found = decode_motion(FIX, 'fix', *join_messages([data]))
    assert len(found.positions()) == there
    assert not there or (found.latitude_deg[0], found.longitude_deg[0]) == (54.0, -10.0)


def test_an_imu_without_angular_velocity_tells_no_rate():
    kind = 'sensor_msgs/msg/Imu'
    sound = {'header': HEADER, 'angular_velocity': {'x': 0.0, 'y': 0.0, 'z': -math.radians(2.0)}}
    none = {**sound, 'angular_velocity_covariance': [-1.0] + [0.0] * 8}
    found = decode_motion(kind, 'rate', *join_messages([encode(kind, one)
                                                        for one in (sound, none)]))
    assert found.rate_deg_s[0] == pytest.approx(2.0) and math.isnan(found.rate_deg_s[1])


@pytest.mark.parametrize('what', MOTION_TYPES)
def test_big_endian_messages_of_rosbags_are_read(what):
    typesys = pytest.importorskip('rosbags.typesys')
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    for kind in MOTION_TYPES[what]:
        twist = {'linear': {'x': 1.5, 'y': -2.5, 'z': 0.0}, 'angular': {'z': 0.25}}
        given = {'header': HEADER, 'latitude': 54.5, 'longitude': 9.25,
                 'status': {'status': 0, 'service': 1}, 'twist': twist,
                 'angular_velocity': {'z': 0.25}}
        if kind.endswith('TwistWithCovarianceStamped'):
            given['twist'] = {'twist': twist}
        fields = {'NavSatFix': ('header', 'latitude', 'longitude', 'status'),
                  'Imu': ('header', 'angular_velocity')}.get(kind.rpartition('/')[2],
                                                             ('header', 'twist'))
        small = encode(kind, {name: given[name] for name in fields})
        large = bytes(store.serialize_cdr(store.deserialize_cdr(small, kind), kind,
                                          little_endian=False))
        one, other = (decode_motion(kind, what, *join_messages([data]))
                      for data in (small, large))
        assert one == other and int(one.stamp_ns[0]) == 7 * S + 5
        expected = {'fix': (54.5, 9.25), 'velocity': (1.5, -2.5),
                    'rate': (pytest.approx(-math.degrees(0.25)),)}[what]
        columns = {'fix': ('latitude_deg', 'longitude_deg'), 'velocity': ('east_m_s', 'north_m_s'),
                   'rate': ('rate_deg_s',)}[what]
        assert tuple(float(getattr(one, name)[0]) for name in columns) == expected


@pytest.mark.parametrize('what', MOTION_TYPES)
def test_a_message_that_is_too_short_is_refused(what):
    whole = split_rows(encode_motion(motion(what), what, 'gps'))
    kind = MOTION_TYPES[what][0]
    with pytest.raises(MessageError, match='too short'):
        decode_motion(kind, what, *join_messages([whole[0][:30]]))
    found, refused = read_motion(kind, what, [whole[0], whole[1][:40], whole[2]])
    assert len(found) == 2 and len(refused) == 1


def test_no_message_is_no_motion():
    assert read_motion(FIX, 'fix', []) == (Motion.empty(), [])
