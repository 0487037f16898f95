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

"""Whole chunks of messages equal the single messages, to the bit."""

from __future__ import annotations

import math
import struct

from message_rows import read_headings
import numpy as np
import pytest

from heading_intercompare.core.angles import (
    heading_from_quaternion,
    quaternion_from_heading,
    wrap180,
)
from heading_intercompare.core.records import Headings, Pairs
from heading_intercompare.messages.byte_columns import join_messages
from heading_intercompare.messages.cdr import decode, encode
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.heading_messages import (
    AZIMUTH_TYPES,
    decode_headings,
    decode_pairs,
    encode_imu,
    encode_pairs,
    IMU,
    imu_messages,
    ORIENTATION_TYPES,
    pair_messages,
    PAIRS_TYPE,
    read_pairs,
)

hypothesis = pytest.importorskip('hypothesis')
st = hypothesis.strategies

STAMP_NS = 1_406_851_200_183_000_000


def message(type_name: str, frame: str, stamp_ns: int, q: tuple, covariance: float = 0.0) -> dict:
    """Return a message of an accepted type."""
    stamp = {'sec': stamp_ns // 10**9, 'nanosec': stamp_ns % 10**9}
    orientation = dict(zip('xyzw', q))
    header = {'stamp': stamp, 'frame_id': frame}
    if type_name == IMU:
        return {'header': header, 'orientation': orientation,
                'orientation_covariance': [covariance] + [0.0] * 8}
    if type_name.endswith('QuaternionStamped'):
        return {'header': header, 'quaternion': orientation}
    pose = {'pose': {'position': {'x': 9.0, 'y': 8.0, 'z': 7.0}, 'orientation': orientation}}
    if type_name.endswith('Odometry'):
        return {'header': header, 'child_frame_id': frame[::2], 'pose': pose}
    return {'header': header, 'pose': pose}


def normalise(q: tuple) -> tuple:
    """Return a quaternion of norm 1; unchanged if it is zero or not finite."""
    norm = math.hypot(*q)
    return tuple(value / norm for value in q) if 0.0 < norm < math.inf else q


def rotations(rng: np.random.Generator, n: int) -> list[tuple]:
    """Return quaternions of norm 1."""
    return [normalise(tuple(q)) for q in rng.normal(size=(n, 4)).tolist()]


def one_by_one(type_name: str, convention: str, messages: list[bytes]) -> Headings:
    """Return the headings from the decoder of single messages."""
    stamps, values = [], []
    for data in messages:
        fields = decode(type_name, data)
        stamps.append(fields['header']['stamp']['sec'] * 10**9
                      + fields['header']['stamp']['nanosec'])
        q = fields.get('orientation') or fields.get('quaternion') or (
            fields['pose']['pose']['orientation'])
        heading_deg = heading_from_quaternion([q['x']], [q['y']], [q['z']], [q['w']], convention)
        if fields.get('orientation_covariance', [0.0])[0] == -1.0:
            heading_deg = [np.nan]
        values.append(heading_deg[0])
    return Headings.as_sent(stamps, values)


COMPONENT = st.floats(-2.0, 2.0, allow_subnormal=False) | st.sampled_from(
    [0.0, np.nan, np.inf, 1e200])


@pytest.mark.slow
@pytest.mark.parametrize('type_name', ORIENTATION_TYPES)
@hypothesis.given(st.data())
def test_many_messages_at_once_are_the_single_ones_to_the_bit(type_name, data):
    rows = data.draw(st.lists(st.tuples(
        st.text('ab/ü', max_size=12), st.integers(0, 2**31 * 10**9 - 1),
        st.tuples(*[COMPONENT] * 4).map(normalise), st.sampled_from([0.0, -1.0, 1e-4])),
        max_size=12))
    convention = data.draw(st.sampled_from(['enu', 'ned']))
    messages = [encode(type_name, message(type_name, *row)) for row in rows]
    assert decode_headings(type_name, convention, *join_messages(messages)) == one_by_one(
        type_name, convention, messages)


@pytest.mark.parametrize('type_name', ORIENTATION_TYPES)
def test_equal_messages_are_the_single_ones_to_the_bit(type_name, rng):
    quaternions = rotations(rng, 500)
    messages = [encode(type_name, message(type_name, 'gyro', STAMP_NS + i, q))
                for i, q in enumerate(quaternions)]
    assert decode_headings(type_name, 'enu', *join_messages(messages)) == one_by_one(
        type_name, 'enu', messages)


@pytest.mark.parametrize('type_name', ORIENTATION_TYPES)
def test_both_byte_orders_may_be_mixed(type_name, rng):
    typesys = pytest.importorskip('rosbags.typesys')
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    messages = [encode(type_name, message(type_name, 'gyro' * (i % 3), STAMP_NS + i, tuple(q)))
                for i, q in enumerate(rotations(rng, 20))]
    expected = one_by_one(type_name, 'enu', messages)
    for i in range(0, 20, 3):
        theirs = store.deserialize_cdr(messages[i], type_name)
        messages[i] = bytes(store.serialize_cdr(theirs, type_name, little_endian=False))
    assert decode_headings(type_name, 'enu', *join_messages(messages)) == expected


@pytest.mark.parametrize('type_name', ORIENTATION_TYPES)
def test_a_message_that_is_too_short_is_refused_with_its_place(type_name):
    whole = encode(type_name, message(type_name, 'gyro', STAMP_NS, (0.0, 0.0, 0.0, 1.0)))
    needed = 4 + 8 + 4 + 8
    for size in (0, 3, needed - 8, needed, needed + 16):
        with pytest.raises(MessageError, match=f'{size} bytes is too short') as caught:
            decode_headings(type_name, 'enu', *join_messages([whole, whole[:size], whole]))
        assert caught.value.offset == len(whole)


def test_a_frame_name_that_claims_to_be_endless_is_refused():
    data = bytearray(encode(IMU, {}))
    data[12:16] = b'\xff' * 4
    with pytest.raises(MessageError, match='too short'):
        decode_headings(IMU, 'enu', *join_messages([bytes(data)]))


def test_bytes_that_are_not_cdr_are_refused():
    whole = encode(IMU, {})
    with pytest.raises(MessageError, match='does not start as CDR'):
        decode_headings(IMU, 'enu', *join_messages([whole, b'\x0a\x00' + whole[2:]]))


def test_no_messages_give_no_headings():
    none = np.empty(0, np.int64)
    assert decode_headings(IMU, 'enu', b'', none, none) == Headings.empty()


def imu_chunk(rng) -> Headings:
    heading_deg = np.concatenate((rng.uniform(0.0, 360.0, 50), [0.0, 90.0, 270.0, np.nan]))
    return Headings.as_sent(STAMP_NS + np.arange(54) * 10_000_000, heading_deg)


@pytest.mark.parametrize('frame', ['', 'ts', 'antenna', 'Bücke'])
def test_imu_rows_are_single_messages_to_the_bit(rng, frame):
    chunk = imu_chunk(rng)
    rate_deg_s = rng.normal(size=54)
    rate_deg_s[5] = np.nan
    rows = encode_imu(chunk, frame, sigma_deg=0.1, turn_rate_deg_s=rate_deg_s)
    z, w = quaternion_from_heading(chunk.heading_deg)
    for i, row in enumerate(rows):
        known = i != 53
        turning = i != 5
        assert row.tobytes() == encode(IMU, {
            'header': {'stamp': {'sec': int(chunk.stamp_ns[i]) // 10**9,
                                 'nanosec': int(chunk.stamp_ns[i]) % 10**9}, 'frame_id': frame},
            'orientation': {'z': z[i] if known else 0.0, 'w': w[i] if known else 0.0},
            'orientation_covariance': [0.0 if known else -1.0] + [0.0] * 7
            + [np.radians(0.1) ** 2 if known else 0.0],
            'angular_velocity': {'z': -np.radians(rate_deg_s[i]) if turning else 0.0},
            'angular_velocity_covariance': [0.0 if turning else -1.0] + [0.0] * 8,
            'linear_acceleration_covariance': [-1.0] + [0.0] * 8})


def test_a_rate_of_turn_that_is_not_given_is_unknown(rng):
    fields = decode(IMU, encode_imu(imu_chunk(rng), 'ts')[0].tobytes())
    assert fields['angular_velocity_covariance'][0] == -1.0
    assert fields['angular_velocity']['z'] == 0.0


def test_headings_come_back_from_imu_messages(rng):
    chunk = imu_chunk(rng)
    rows = encode_imu(chunk, 'ts')
    back = decode_headings(IMU, 'enu', *join_messages([row.tobytes() for row in rows]))
    assert np.array_equal(back.stamp_ns, chunk.stamp_ns)
    assert np.isnan(back.heading_deg[-1])
    assert np.abs(wrap180(back.heading_deg - chunk.heading_deg)[:-1]).max() < 1e-12


def test_reading_and_writing_again_changes_nothing(rng):
    rows = encode_imu(imu_chunk(rng), 'ts')
    once = decode_headings(IMU, 'enu', *join_messages([row.tobytes() for row in rows]))
    again = encode_imu(once, 'ts')
    twice = decode_headings(IMU, 'enu', *join_messages([row.tobytes() for row in again]))
    assert np.nanmax(np.abs(wrap180(twice.heading_deg - once.heading_deg))) < 1e-12


def test_no_headings_give_no_messages():
    assert encode_imu(Headings.empty(), 'ts').shape == (0, len(encode(IMU, {'header': {
        'frame_id': 'ts'}})))


@pytest.mark.parametrize('stamp_ns', [2**31 * 10**9, -2**31 * 10**9 - 1])
def test_a_stamp_beyond_the_range_of_ros_is_refused(stamp_ns):
    with pytest.raises(MessageError, match=str(stamp_ns)):
        encode_imu(Headings.as_sent([STAMP_NS, stamp_ns], [1.0, 2.0]), 'ts')


def test_pairs_are_twists_to_the_bit():
    pairs = Pairs.of([STAMP_NS, STAMP_NS + 1], [359.5, 10.0], [0.25, 9.0], [0, -3_000_000],
                     [0.5, 1.0], [1.0, 0.75])
    for i, row in enumerate(encode_pairs(pairs, 'ship')):
        assert row.tobytes() == encode(PAIRS_TYPE, {
            'header': {'stamp': {'sec': 1406851200, 'nanosec': 183_000_000 + i},
                       'frame_id': 'ship'},
            'twist': {'linear': {'x': [-0.75, 1.0][i], 'y': [0.25, 9.0][i], 'z': [359.5, 10.0][i]},
                      'angular': {'x': [0.0, -0.003][i], 'y': [0.5, 1.0][i],
                                  'z': [1.0, 0.75][i]}}})


def pair_rows(rng, n=20):
    """Return pairs of which no two are alike."""
    return Pairs.of(STAMP_NS + np.arange(n), *rng.uniform(0.0, 360.0, (2, n)),
                    rng.integers(-10**9, 10**9, n), *rng.uniform(0.5, 1.0, (2, n)))


def test_pairs_come_back_to_the_bit(rng):
    pairs = pair_rows(rng)
    assert decode_pairs(*join_messages(pair_messages(pairs))) == pairs


def big_endian(messages: list[bytes], type_name: str) -> list[bytes]:
    """Return messages as a computer with the other byte order sends them."""
    typesys = pytest.importorskip('rosbags.typesys')
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    return [bytes(store.serialize_cdr(store.deserialize_cdr(data, type_name), type_name,
                                      little_endian=False)) for data in messages]


@pytest.mark.parametrize('every', [1, 3])
def test_pairs_of_either_byte_order_may_be_mixed(rng, every):
    pairs = pair_rows(rng)
    messages = pair_messages(pairs)
    messages[::every] = big_endian(messages[::every], PAIRS_TYPE)
    assert decode_pairs(*join_messages(messages)) == pairs


@pytest.mark.parametrize('lag_s', [np.nan, np.inf, -1e10])
def test_a_pair_whose_lag_is_no_time_is_refused(lag_s):
    sound = pair_messages(Pairs.of([3], [1.0], [359.5]))[0]
    data = encode(PAIRS_TYPE, {'twist': {'angular': {'x': lag_s}}})
    pairs, refused = read_pairs([sound, data])
    assert len(pairs) == 1
    assert refused == [f'{PAIRS_TYPE} message has an impossible lag of {lag_s} s']


#: What a message may start with instead of CDR, and which way of serializing that is.
FOREIGN = {b'\x00\x02': 'PL_CDR, big-endian', b'\x00\x03': 'PL_CDR, little-endian',
           b'\x00\x06': 'XCDR2, big-endian', b'\x00\x07': 'XCDR2, little-endian',
           b'\x00\x09': 'delimited XCDR2', b'\x00\x0b': 'PL_XCDR2',
           b'\x00\x11': 'XCDR2 of earlier versions', b'\x01\x00': 'none', b'\xff\xff': 'none'}


@pytest.mark.parametrize('start', FOREIGN, ids=FOREIGN.values())
@pytest.mark.parametrize('type_name', ORIENTATION_TYPES)
def test_messages_that_are_serialized_otherwise_are_refused_and_the_others_read(
        type_name, start, rng):
    messages = [encode(type_name, message(type_name, 'gyro', STAMP_NS + i, tuple(q)))
                for i, q in enumerate(rotations(rng, 5))]
    expected, _ = read_headings(type_name, 'enu', [messages[i] for i in (0, 2, 4)])
    for i in (1, 3):
        messages[i] = start + messages[i][2:]
    headings, refused = read_headings(type_name, 'enu', messages)
    assert headings == expected
    assert refused == [f'{type_name} message does not start as CDR'] * 2


@pytest.mark.parametrize('start', FOREIGN, ids=FOREIGN.values())
def test_pairs_that_are_serialized_otherwise_are_refused_and_the_others_read(start, rng):
    pairs = pair_rows(rng, 5)
    messages = pair_messages(pairs)
    messages[2] = start + messages[2][2:]
    found, refused = read_pairs(messages)
    assert found == pairs[np.array([0, 1, 3, 4])]
    assert refused == [f'{PAIRS_TYPE} message does not start as CDR']


@pytest.mark.parametrize('type_name', ORIENTATION_TYPES)
def test_a_chunk_of_big_endian_messages_is_read(type_name, rng):
    messages = [encode(type_name, message(type_name, 'gyro', STAMP_NS + i, tuple(q)))
                for i, q in enumerate(rotations(rng, 5))]
    assert read_headings(type_name, 'ned', big_endian(messages, type_name)) == (
        one_by_one(type_name, 'ned', messages), [])


def test_a_message_that_is_cut_is_refused_and_the_others_read(rng):
    pairs = pair_rows(rng, 3)
    messages = pair_messages(pairs)
    messages[0], messages[2] = messages[0][:-1], b''
    found, refused = read_pairs(messages)
    assert found == pairs[1:2]
    assert [words.split(' of ')[1] for words in refused] == ['67 bytes is too short',
                                                            '0 bytes is too short']


def test_no_message_makes_no_chunk_of_any_type():
    assert read_headings(IMU, 'enu', []) == (Headings.empty(), [])
    assert read_pairs([]) == (Pairs.empty(), [])
    assert imu_messages(Headings.empty(), 'ts') == []
    assert pair_messages(Pairs.empty()) == []


def test_single_messages_are_the_rows_of_a_chunk(rng):
    chunk = imu_chunk(rng)
    assert imu_messages(chunk, 'ts', sigma_deg=0.1, turn_rate_deg_s=2.0) == [
        row.tobytes() for row in encode_imu(chunk, 'ts', sigma_deg=0.1, turn_rate_deg_s=2.0)]


def test_a_reading_whose_stamp_no_message_can_hold_is_left_out_with_what_it_claims():
    headings = Headings.as_sent([-1, 5, 2**31 * 10**9], [1.0, 2.0, 3.0])
    assert imu_messages(headings, 'ts', sigma_deg=[0.1, 0.2, 0.3]) == imu_messages(
        headings[1:2], 'ts', sigma_deg=0.2)


def azimuth(angle: float, unit: int = 1, orientation: int = 1, reference: int = 1) -> dict:
    """Return the fields of an azimuth: by default degrees from true north, clockwise."""
    return {'header': {'stamp': {'sec': 1_400_000_000, 'nanosec': 5}, 'frame_id': 'compass'},
            'azimuth': angle, 'variance': 0.1, 'unit': unit, 'orientation': orientation,
            'reference': reference}


def in_big_endian(fields: dict) -> bytes:
    """Return a message of an azimuth in the other byte order."""
    stamp = fields['header']['stamp']
    return bytes(4) + struct.pack(
        '>iII8s4xddBBB', stamp['sec'], stamp['nanosec'], 8, b'compass', fields['azimuth'],
        fields['variance'], fields['unit'], fields['orientation'], fields['reference'])


@pytest.mark.parametrize('type_name', AZIMUTH_TYPES)
@pytest.mark.parametrize('fields, heading_deg', [
    (azimuth(30.0), 30.0), (azimuth(-30.0), 330.0), (azimuth(np.pi / 2, unit=0), 90.0),
    (azimuth(30.0, orientation=0), 60.0), (azimuth(np.pi, unit=0, orientation=0), 270.0),
    (azimuth(np.nan), np.nan)])
def test_an_azimuth_is_read_as_it_says(type_name, fields, heading_deg):
    messages = [encode(type_name, fields)] * 3
    for convention in ('enu', 'ned'):
        for sent in (messages, [in_big_endian(fields)] * 3):
            found, refused = read_headings(type_name, convention, sent)
            assert refused == [] and found.stamp_ns.tolist() == [1_400_000_000_000_000_005] * 3
            assert found.heading_deg == pytest.approx([heading_deg] * 3, nan_ok=True)


@pytest.mark.parametrize('fields, what', [
    (azimuth(1.0, reference=0), 'a magnetic azimuth'),
    (azimuth(1.0, reference=2), 'an azimuth from grid north'),
    (azimuth(1.0, reference=7), 'an azimuth of an unknown kind'),
    (azimuth(1.0, unit=2), 'an azimuth of an unknown kind'),
    (azimuth(1.0, orientation=9), 'an azimuth of an unknown kind')])
def test_an_azimuth_that_is_no_heading_is_refused_and_the_others_read(fields, what):
    type_name = AZIMUTH_TYPES[0]
    sent = [encode(type_name, one) for one in (azimuth(5.0), fields, azimuth(6.0))]
    found, refused = read_headings(type_name, 'enu', sent)
    assert found.heading_deg.tolist() == [5.0, 6.0]
    assert [what in words for words in refused] == [True]
    with pytest.raises(MessageError, match='is too short'):
        decode_headings(type_name, 'enu', *join_messages([sent[0][:-1]]))


@pytest.mark.parametrize('type_name', ORIENTATION_TYPES)
@pytest.mark.parametrize('factor, is_read', [
    (1.0, True), (1.004, True), (0.996, True), (1.006, False), (0.5, False), (2.0, False),
    (1e-9, False)])
def test_a_quaternion_off_its_norm_is_refused_and_the_others_read(type_name, factor, is_read,
                                                                  rng):
    """By hand: 1.004² differs from 1 by 0.008, 1.006² by 0.012; tf2 takes less than 0.01."""
    rows = rotations(rng, 3)
    rows[1] = tuple(factor * value for value in rows[1])
    messages = [encode(type_name, message(type_name, 'gyro', STAMP_NS, q)) for q in rows]
    headings, refused = read_headings(type_name, 'enu', messages)
    assert len(headings) == 2 + is_read
    assert all(f'has a quaternion of norm {factor:.3g}: must be 1' in words for words in refused)


@pytest.mark.parametrize('q', [(0.0,) * 4, (np.nan, 0.0, 0.0, 1.0), (np.inf, 0.0, 0.0, 1.0)])
@pytest.mark.parametrize('type_name', ORIENTATION_TYPES)
def test_a_quaternion_that_is_no_rotation_is_an_invalid_reading_at_its_stamp(type_name, q):
    messages = [encode(type_name, message(type_name, 'gyro', STAMP_NS, q))]
    headings, refused = read_headings(type_name, 'enu', messages)
    assert headings.stamp_ns.tolist() == [STAMP_NS] and np.isnan(headings.heading_deg).all()
    assert refused == []


def test_an_imu_without_orientation_may_have_any_quaternion():
    messages = [encode(IMU, message(IMU, 'gyro', STAMP_NS, (0.5, 0.0, 0.0, 0.0), -1.0))]
    headings, refused = read_headings(IMU, 'enu', messages)
    assert np.isnan(headings.heading_deg).all() and refused == []


@pytest.mark.parametrize('type_name', ORIENTATION_TYPES)
@pytest.mark.parametrize('order', '<>')
@pytest.mark.parametrize('nanosec, is_read', [(999_999_999, True), (10**9, False),
                                              (2**32 - 1, False)])
def test_a_stamp_with_a_second_of_nanoseconds_is_refused(type_name, order, nanosec, is_read):
    data = bytearray(encode(type_name, message(type_name, '', STAMP_NS, (0.0, 0.0, 0.0, 1.0))))
    data[8:12] = struct.pack('<I', nanosec)
    if order == '>':
        store = pytest.importorskip('rosbags.typesys')
        types = store.get_typestore(store.Stores.ROS2_JAZZY)
        data = types.serialize_cdr(types.deserialize_cdr(bytes(data), type_name), type_name,
                                   little_endian=False)
    headings, refused = read_headings(type_name, 'enu', [bytes(data)])
    assert len(headings) == is_read
    assert is_read or f'a stamp with {nanosec} nanoseconds: must be below' in refused[0]
