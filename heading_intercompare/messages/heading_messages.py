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

"""
Whole chunks of headings and pairs to messages and back.

A chunk of n messages is n rows of bytes, decoded as `byte_columns` does.
"""

from __future__ import annotations

from functools import partial
from typing import Sequence

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core import angles
from heading_intercompare.core.pairing.difference import subtract
from heading_intercompare.core.records import Attitude, Headings, Integers, Pairs

from .byte_columns import (
    align,
    BytesLike,
    check_size,
    decode_stamped,
    end_of_strings,
    gather,
    gather_reals,
    read_sound,
    read_stamps,
    refuse_messages,
    split_rows,
    stamped_rows,
)
from .errors import MessageError
from .quaternion_norms import check_norms
from .stamps import fits_message

IMU = 'sensor_msgs/msg/Imu'
PAIRS_TYPE = 'geometry_msgs/msg/TwistStamped'
_QUATERNION_STAMPED = 'geometry_msgs/msg/QuaternionStamped'
_ODOMETRY = 'nav_msgs/msg/Odometry'

#: Accepted types, each with the number of bytes between its strings and its quaternion.
ORIENTATION_TYPES = {
    IMU: 0,
    _QUATERNION_STAMPED: 0,
    'geometry_msgs/msg/PoseWithCovarianceStamped': 24,
    _ODOMETRY: 24,
}
AZIMUTH_TYPES = ('compass_interfaces/msg/Azimuth', 'compass_msgs/msg/Azimuth')
"""Accepted types of other packages: an angle that says its unit, its axes and its north."""

HEADING_TYPES = (*ORIENTATION_TYPES, *AZIMUTH_TYPES)
"""All accepted types."""

_UNKNOWN = -1.0
#: Orientation, angular velocity and linear acceleration, each with its covariance.
_IMU_REALS = 4 + 9 + 3 + 9 + 3 + 9
_SECOND_NS = 1_000_000_000


def encode_imu(headings: Headings, frame_id: str, *, sigma_deg: ArrayLike = 0.0,
               turn_rate_deg_s: ArrayLike | None = None) -> np.ndarray:
    """
    Return headings as sensor_msgs/msg/Imu messages.

    Parameters
    ----------
    headings
        n readings; nan marks those that the sensor reports as invalid.
    frame_id
        Frame of the header.
    sigma_deg : array_like, scalar or shape (n,)
        Standard deviation of the heading, degrees; 0 when unknown.
    turn_rate_deg_s : array_like, scalar or shape (n,), optional
        Rate of turn, degrees per second, positive to starboard; nan where unknown.

    Returns
    -------
    ndarray of uint8, shape (n, size)
        One CDR message per row. The axes are ENU: yaw = 90 - heading.
        `orientation_covariance[8]` is the variance in square radians; for an invalid heading
        `orientation_covariance[0]` is -1 and the quaternion zero. `angular_velocity.z` is minus
        the rate of turn, rad/s; `angular_velocity_covariance[0]` is -1 when that is unknown.
        `linear_acceleration_covariance[0]` is -1.

    Raises
    ------
    MessageError
        If a stamp is beyond the range of builtin_interfaces/Time.

    """
    reals = np.zeros((len(headings), _IMU_REALS), '<f8')
    valid = np.isfinite(headings.heading_deg)
    z, w = angles.quaternion_from_heading(np.where(valid, headings.heading_deg, 0.0))
    reals[:, 2], reals[:, 3] = z * valid, w * valid
    reals[:, 4] = np.where(valid, 0.0, _UNKNOWN)
    reals[:, 12] = np.where(valid, np.radians(sigma_deg) ** 2, 0.0)
    if turn_rate_deg_s is None:
        reals[:, 16] = _UNKNOWN
    else:
        turning = np.isfinite(turn_rate_deg_s)
        reals[:, 15] = np.where(turning, -np.radians(turn_rate_deg_s), 0.0)
        reals[:, 16] = np.where(turning, 0.0, _UNKNOWN)
    reals[:, 28] = _UNKNOWN
    return stamped_rows(IMU, headings.stamp_ns, frame_id, reals)


def imu_messages(headings: Headings, frame_id: str, *, sigma_deg: ArrayLike = 0.0,
                 turn_rate_deg_s: ArrayLike | None = None) -> list[bytes]:
    """
    Return the messages of `encode_imu` one by one, for publishing.

    Readings with a stamp before 1970 or beyond the range of a message are skipped.
    """
    fits = fits_message(headings.stamp_ns)
    if not fits.all():
        sigma_deg = np.broadcast_to(sigma_deg, fits.shape)[fits]
        if turn_rate_deg_s is not None:
            turn_rate_deg_s = np.broadcast_to(turn_rate_deg_s, fits.shape)[fits]
        headings = headings[fits]
    return split_rows(encode_imu(headings, frame_id, sigma_deg=sigma_deg,
                                 turn_rate_deg_s=turn_rate_deg_s))


def encode_pairs(pairs: Pairs, frame_id: str = '') -> np.ndarray:
    """
    Return pairs as geometry_msgs/msg/TwistStamped messages.

    Parameters
    ----------
    pairs
        n pairs.
    frame_id
        Frame of the header.

    Returns
    -------
    ndarray of uint8, shape (n, size)
        One CDR message per row, with the stamp of the pair. Linear: TS - RS wrapped, RS heading,
        TS heading, degrees. Angular: lag in seconds, variance factors of RS and TS.

    Raises
    ------
    MessageError
        If a stamp is beyond the range of builtin_interfaces/Time.

    """
    columns = (subtract(pairs).x_deg, pairs.rs_deg, pairs.ts_deg,
               pairs.lag_ns / _SECOND_NS, pairs.rs_variance_factor, pairs.ts_variance_factor)
    reals = np.empty((len(pairs), len(columns)), '<f8')
    for number, column in enumerate(columns):
        reals[:, number] = column
    return stamped_rows(PAIRS_TYPE, pairs.stamp_ns, frame_id, reals)


def pair_messages(pairs: Pairs, frame_id: str = '') -> list[bytes]:
    """Return the messages of `encode_pairs` one by one, for publishing."""
    return split_rows(encode_pairs(pairs, frame_id)) if len(pairs) else []


#: Azimuth, variance; degrees or radians, NED or ENU, and which north.
_AZIMUTH = np.dtype([('angle', '<f8'), ('variance', '<f8'), ('degrees', 'u1'), ('ned', 'u1'),
                     ('north', 'u1')])
_TRUE_NORTH = 1
_NORTHS = {0: 'a magnetic azimuth', 2: 'an azimuth from grid north'}
#: Longer lags do not fit an int64 of nanoseconds.
_MOST_LAG_S = 9e9

def decode_headings(type_name: str, convention: str, data: BytesLike, start: Integers,
                    stop: Integers) -> Headings:
    """
    Return the headings in the messages that a stretch of bytes holds.

    Parameters
    ----------
    type_name
        A key of `HEADING_TYPES`.
    convention : {'enu', 'ned'}
        World axes of the orientations; an azimuth says its own.
    data : bytes-like
        Any bytes that hold the messages.
    start, stop : ndarray of int64, shape (n,)
        First byte of each message, and the byte after its last.

    Returns
    -------
    Headings
        In the order of `start`. A heading is nan where the quaternion is zero or not finite, or
        where `orientation_covariance[0] = -1` of an Imu says that there is no orientation.

    Raises
    ------
    MessageError
        If a message is too short for its type, does not start as CDR, has an impossible stamp, a
        quaternion whose norm is not 1, or an azimuth that is not from true north; the offset is
        its place in `data`.

    """
    if type_name in AZIMUTH_TYPES:
        return decode_stamped(type_name, data, start, stop, partial(_azimuths, type_name))
    return decode_stamped(type_name, data, start, stop, partial(_headings, type_name, convention))


def _azimuths(type_name: str, data: BytesLike, start: Integers, size: Integers,
              header: np.ndarray) -> Headings:
    """Return the azimuths from true north in messages of one byte order."""
    sign, end = end_of_strings(header)
    at = align(end, 8) + 4
    check_size(type_name, start, size, at + _AZIMUTH.itemsize)
    rows = gather(data, _AZIMUTH.newbyteorder(sign), start + at)
    wrong = (rows['north'] != _TRUE_NORTH) | (rows['degrees'] > 1) | (rows['ned'] > 1)
    refuse_messages(type_name, start, wrong, lambda first: (
        f'has {_NORTHS.get(int(rows["north"][first]), "an azimuth of an unknown kind")}: a '
        'heading is from true north (reference 1), as compass_conversions makes it'))
    angle = rows['angle'].astype(float)
    angle = np.where(rows['degrees'] == 1, angle, np.degrees(angle))
    angle[~np.isfinite(angle)] = np.nan
    return Headings(read_stamps(header),
                    angles.wrap360(np.where(rows['ned'] == 1, angle, 90.0 - angle)))


def _headings(type_name: str, convention: str, data: BytesLike, start: Integers, size: Integers,
              header: np.ndarray) -> Headings:
    """Return the headings in messages of one byte order."""
    (x, y, z, w), has_orientation = _orientations(type_name, data, start, size, header)
    heading_deg = angles.heading_from_quaternion(x, y, z, w, convention)
    heading_deg[~has_orientation] = np.nan
    return Headings(read_stamps(header), heading_deg)


def _orientations(type_name: str, data: BytesLike, start: Integers, size: Integers,
                  header: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the quaternions, shape (4, n), and which of them the messages call known."""
    sign, end = end_of_strings(header)
    if type_name == _ODOMETRY:
        end = align(end, 4) + 4
        check_size(type_name, start, size, end + 4)
        end = end + gather(data, f'{sign}u4', start + end)
    at = align(end, 8) + 4 + ORIENTATION_TYPES[type_name]
    # x, y, z, w; for an Imu also the first covariance, which says if there is an orientation.
    columns = gather_reals(type_name, data, start, size, at, sign, 5 if type_name == IMU else 4)
    has_orientation = (columns[4] != _UNKNOWN if type_name == IMU
                       else np.ones(start.shape, dtype=bool))
    check_norms(type_name, start, columns[:4], has_orientation)
    return columns[:4], has_orientation


def decode_attitude(type_name: str, convention: str, data: BytesLike, start: Integers,
                    stop: Integers) -> Attitude:
    """Return roll and pitch in the messages of a stretch of bytes; see `decode_headings`."""
    return decode_stamped(type_name, data, start, stop, partial(_attitude, type_name, convention))


def _attitude(type_name: str, convention: str, data: BytesLike, start: Integers, size: Integers,
              header: np.ndarray) -> Attitude:
    """Return roll and pitch in messages of one byte order."""
    (x, y, z, w), has_orientation = _orientations(type_name, data, start, size, header)
    roll_deg, pitch_deg = (np.where(has_orientation, angle, np.nan) for angle in
                           angles.roll_pitch_from_quaternion(x, y, z, w, convention))
    return Attitude(read_stamps(header), roll_deg, pitch_deg)


def decode_pairs(data: BytesLike, start: Integers, stop: Integers) -> Pairs:
    """
    Return the pairs in the messages of `encode_pairs` that a stretch of bytes holds, to the bit.

    Parameters
    ----------
    data : bytes-like
        Any bytes that hold the messages.
    start, stop : ndarray of int64, shape (n,)
        First byte of each message, and the byte after its last.

    Returns
    -------
    Pairs
        In the order of `start`.

    Raises
    ------
    MessageError
        If a message is too short, does not start as CDR, or has an impossible lag; the offset is
        its place in `data`.

    """
    return decode_stamped(PAIRS_TYPE, data, start, stop, _pairs)


def _pairs(data: BytesLike, start: Integers, size: Integers, header: np.ndarray) -> Pairs:
    """Return the pairs in messages of one byte order."""
    sign, end = end_of_strings(header)
    _, rs_deg, ts_deg, lag_s, rs_factor, ts_factor = np.array(gather_reals(
        PAIRS_TYPE, data, start, size, align(end, 8) + 4, sign, 6), np.float64, order='C')
    endless = ~(np.abs(lag_s) < _MOST_LAG_S)
    if endless.any():
        first = int(np.argmax(endless))
        raise MessageError(f'{PAIRS_TYPE} message has an impossible lag of {lag_s[first]} s',
                           offset=int(start[first]))
    return Pairs(read_stamps(header), ts_deg, rs_deg, np.rint(lag_s * 1e9).astype(np.int64),
                 rs_factor, ts_factor, np.zeros(len(rs_deg), np.int64))


def read_attitude(type_name: str, convention: str,
                  messages: Sequence[bytes]) -> tuple[Attitude, list[str]]:
    """Return roll and pitch in single messages, and what is wrong with each unreadable one."""
    return read_sound(partial(decode_attitude, type_name, convention), messages, Attitude)


def read_pairs(messages: Sequence[bytes]) -> tuple[Pairs, list[str]]:
    """Return the pairs in single messages, and what is wrong with each unreadable one."""
    return read_sound(decode_pairs, messages, Pairs)
