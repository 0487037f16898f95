# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Chunks of messages at once are the single messages, to the bit."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.bags.codec.cdr import decode, encode
from heading_intercompare.bags.codec.heading_messages import (
    decode_headings,
    encode_imu,
    encode_pairs,
    HEADING_TYPES,
    IMU,
    PAIRS_TYPE,
)
from heading_intercompare.bags.errors import BagError
from heading_intercompare.core.angles import (
    heading_from_quaternion,
    quaternion_from_heading,
    wrap180,
)
from heading_intercompare.core.records import Headings, Pairs

hypothesis = pytest.importorskip('hypothesis')
st = hypothesis.strategies

STAMP_NS = 1_406_851_200_183_000_000


def joined(messages: list[bytes]) -> tuple[bytes, np.ndarray, np.ndarray]:
    """Return messages one behind the other, and where each is."""
    size = np.array([len(m) for m in messages], np.int64)
    return b''.join(messages), np.cumsum(size) - size, np.cumsum(size)


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


def one_by_one(type_name: str, convention: str, messages: list[bytes]) -> Headings:
    """Return the headings by the decoder of single messages."""
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
    return Headings.of(stamps, values)


COMPONENT = st.floats(-2.0, 2.0) | st.sampled_from([0.0, np.nan, np.inf, 1e200])


@pytest.mark.parametrize('type_name', HEADING_TYPES)
@hypothesis.given(st.data())
def test_many_messages_at_once_are_the_single_ones_to_the_bit(type_name, data):
    rows = data.draw(st.lists(st.tuples(
        st.text('ab/ü', max_size=12), st.integers(0, 2**31 * 10**9 - 1),
        st.tuples(*[COMPONENT] * 4), st.sampled_from([0.0, -1.0, 1e-4])), max_size=12))
    convention = data.draw(st.sampled_from(['enu', 'ned']))
    messages = [encode(type_name, message(type_name, *row)) for row in rows]
    assert decode_headings(type_name, convention, *joined(messages)) == one_by_one(
        type_name, convention, messages)


@pytest.mark.parametrize('type_name', HEADING_TYPES)
def test_equal_messages_are_the_single_ones_to_the_bit(type_name, rng):
    quaternions = rng.normal(size=(500, 4)).tolist()
    messages = [encode(type_name, message(type_name, 'gyro', STAMP_NS + i, q))
                for i, q in enumerate(quaternions)]
    assert decode_headings(type_name, 'enu', *joined(messages)) == one_by_one(
        type_name, 'enu', messages)


@pytest.mark.parametrize('type_name', HEADING_TYPES)
def test_both_byte_orders_may_be_mixed(type_name, rng):
    typesys = pytest.importorskip('rosbags.typesys')
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    messages = [encode(type_name, message(type_name, 'gyro' * (i % 3), STAMP_NS + i, tuple(q)))
                for i, q in enumerate(rng.normal(size=(20, 4)).tolist())]
    expected = one_by_one(type_name, 'enu', messages)
    for i in range(0, 20, 3):
        theirs = store.deserialize_cdr(messages[i], type_name)
        messages[i] = bytes(store.serialize_cdr(theirs, type_name, little_endian=False))
    assert decode_headings(type_name, 'enu', *joined(messages)) == expected


@pytest.mark.parametrize('type_name', HEADING_TYPES)
def test_a_message_that_is_too_short_is_refused_with_its_place(type_name):
    whole = encode(type_name, message(type_name, 'gyro', STAMP_NS, (0.0, 0.0, 0.0, 1.0)))
    needed = 4 + 8 + 4 + 8
    for size in (0, 3, needed - 8, needed, needed + 16):
        with pytest.raises(BagError, match=f'{size} bytes is too short') as caught:
            decode_headings(type_name, 'enu', *joined([whole, whole[:size], whole]))
        assert caught.value.offset == len(whole)


def test_a_frame_name_that_claims_to_be_endless_is_refused():
    data = bytearray(encode(IMU, {}))
    data[12:16] = b'\xff' * 4
    with pytest.raises(BagError, match='too short'):
        decode_headings(IMU, 'enu', *joined([bytes(data)]))


def test_bytes_that_are_not_cdr_are_refused():
    whole = encode(IMU, {})
    with pytest.raises(BagError, match='does not start as CDR'):
        decode_headings(IMU, 'enu', *joined([whole, b'\x0a\x00' + whole[2:]]))


def test_no_messages_give_no_headings():
    none = np.empty(0, np.int64)
    assert decode_headings(IMU, 'enu', b'', none, none) == Headings.empty()


def imu_chunk(rng) -> Headings:
    heading_deg = np.concatenate((rng.uniform(0.0, 360.0, 50), [0.0, 90.0, 270.0, np.nan]))
    return Headings.of(STAMP_NS + np.arange(54) * 10_000_000, heading_deg)


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
    back = decode_headings(IMU, 'enu', *joined([row.tobytes() for row in rows]))
    assert np.array_equal(back.stamp_ns, chunk.stamp_ns)
    assert np.isnan(back.heading_deg[-1])
    assert np.abs(wrap180(back.heading_deg - chunk.heading_deg)[:-1]).max() < 1e-12


def test_reading_and_writing_again_changes_nothing(rng):
    rows = encode_imu(imu_chunk(rng), 'ts')
    once = decode_headings(IMU, 'enu', *joined([row.tobytes() for row in rows]))
    again = encode_imu(once, 'ts')
    twice = decode_headings(IMU, 'enu', *joined([row.tobytes() for row in again]))
    assert np.nanmax(np.abs(wrap180(twice.heading_deg - once.heading_deg))) < 1e-12


def test_no_headings_give_no_messages():
    assert encode_imu(Headings.empty(), 'ts').shape == (0, len(encode(IMU, {'header': {
        'frame_id': 'ts'}})))


@pytest.mark.parametrize('stamp_ns', [2**31 * 10**9, -2**31 * 10**9 - 1])
def test_a_stamp_beyond_the_range_of_ros_is_refused(stamp_ns):
    with pytest.raises(BagError, match=str(stamp_ns)):
        encode_imu(Headings.of([STAMP_NS, stamp_ns], [1.0, 2.0]), 'ts')


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
