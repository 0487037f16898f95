# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Whole chunks of heading messages at once.

A chunk of n messages is n rows of bytes. Decoding gathers each field of all messages with one
numpy call, wherever the messages lie and however long their frame names are.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.message_blocks import gather
from heading_intercompare.core import angles
from heading_intercompare.core.records import Headings, Pairs

from .cdr import encode

__all__ = ['decode_headings', 'encode_imu', 'encode_pairs', 'HEADING_TYPES', 'IMU', 'PAIRS_TYPE']

IMU = 'sensor_msgs/msg/Imu'
PAIRS_TYPE = 'geometry_msgs/msg/TwistStamped'
_QUATERNION_STAMPED = 'geometry_msgs/msg/QuaternionStamped'
_ODOMETRY = 'nav_msgs/msg/Odometry'

#: Bytes between the strings of each accepted type and its quaternion.
HEADING_TYPES = {
    IMU: 0,
    _QUATERNION_STAMPED: 0,
    'geometry_msgs/msg/PoseWithCovarianceStamped': 24,
    _ODOMETRY: 24,
}

_UNKNOWN = -1.0
_SECOND_NS = 1_000_000_000


def _rows(type_name: str, stamp_ns: np.ndarray, frame_id: str) -> tuple[np.ndarray, int]:
    """Return messages that are zero but for their headers, and where the next doubles start."""
    message = encode(type_name, {'header': {'frame_id': frame_id}})
    rows = np.tile(np.frombuffer(message, np.uint8), (len(stamp_ns), 1))
    sec, nanosec = np.divmod(stamp_ns, _SECOND_NS)
    beyond = np.flatnonzero((sec < -2**31) | (sec >= 2**31))
    if beyond.size:
        raise BagError(f'stamp {stamp_ns[beyond[0]]} ns does not fit a ROS message, which ends '
                       'in January 2038')
    _put(rows, 4, sec.astype('<i4'))
    _put(rows, 8, nanosec.astype('<u4'))
    return rows, 4 + _align(12 + len(frame_id.encode()) + 1, 8)


def _put(rows: np.ndarray, at: int, column: np.ndarray) -> None:
    rows[:, at:at + column.itemsize] = column.reshape(-1, 1).view(np.uint8)


def _put_reals(rows: np.ndarray, at: int, values: ArrayLike) -> None:
    _put(rows, at, np.broadcast_to(values, len(rows)).astype('<f8'))


def _align(position, size: int):
    """Return the next place that a power of two divides."""
    return (position + (size - 1)) & -size


def encode_imu(headings: Headings, frame_id: str, *, sigma_deg: ArrayLike = 0.0,
               turn_rate_deg_s: ArrayLike | None = None) -> np.ndarray:
    """
    Return headings as sensor_msgs/msg/Imu messages.

    Parameters
    ----------
    headings : Headings
        n readings; nan marks those that the sensor calls invalid.
    frame_id : str
        Frame of the header.
    sigma_deg : array_like, scalar or shape (n,)
        Standard deviation of the heading, degrees; 0 when unknown.
    turn_rate_deg_s : array_like, scalar or shape (n,), optional
        Rate of turn, degrees a second, positive to starboard; nan where unknown.

    Returns
    -------
    ndarray of uint8, shape (n, size)
        One CDR message a row. ENU: yaw = 90 - heading; `orientation_covariance[8]` in square
        radians, its `[0]` -1 and the quaternion zero for an invalid heading;
        `angular_velocity.z` minus the rate of turn, rad/s, its covariance `[0]` -1 when unknown;
        linear acceleration covariance `[0]` -1.

    Raises
    ------
    BagError
        If a stamp is beyond the range of builtin_interfaces/Time.

    """
    rows, at = _rows(IMU, headings.stamp_ns, frame_id)
    invalid = ~np.isfinite(headings.heading_deg)
    z, w = angles.quaternion_from_heading(np.where(invalid, 0.0, headings.heading_deg))
    variance_rad2 = np.radians(sigma_deg) ** 2
    _put_reals(rows, at + 16, np.where(invalid, 0.0, z))
    _put_reals(rows, at + 24, np.where(invalid, 0.0, w))
    _put_reals(rows, at + 32, np.where(invalid, _UNKNOWN, 0.0))
    _put_reals(rows, at + 96, np.where(invalid, 0.0, variance_rad2))
    rate_rad_s = -np.radians(np.nan if turn_rate_deg_s is None else turn_rate_deg_s)
    unknown = ~np.isfinite(rate_rad_s)
    _put_reals(rows, at + 120, np.where(unknown, 0.0, rate_rad_s))
    _put_reals(rows, at + 128, np.where(unknown, _UNKNOWN, 0.0))
    _put_reals(rows, at + 224, _UNKNOWN)
    return rows


def encode_pairs(pairs: Pairs, frame_id: str = '') -> np.ndarray:
    """
    Return pairs as geometry_msgs/msg/TwistStamped messages.

    Parameters
    ----------
    pairs : Pairs
        n pairs.
    frame_id : str
        Frame of the header.

    Returns
    -------
    ndarray of uint8, shape (n, size)
        One CDR message a row, with the stamp of the pair. Linear: TS - RS wrapped, RS heading,
        TS heading, degrees; angular: lag in seconds, variance factors of RS and TS.

    Raises
    ------
    BagError
        If a stamp is beyond the range of builtin_interfaces/Time.

    """
    rows, at = _rows(PAIRS_TYPE, pairs.stamp_ns, frame_id)
    columns = (angles.wrap180(pairs.ts_deg - pairs.rs_deg), pairs.rs_deg, pairs.ts_deg,
               pairs.lag_ns / _SECOND_NS, pairs.rs_variance_factor, pairs.ts_variance_factor)
    for number, column in enumerate(columns):
        _put_reals(rows, at + 8 * number, column)
    return rows


_HEADER = np.dtype([('order', '<u2'), ('options', '<u2'), ('sec', '<i4'), ('nanosec', '<u4'),
                    ('length', '<u4')])
#: The byte order in a header: 0, 0 for big-endian and 0, 1 for little-endian, read as `order`.
_BIG, _LITTLE = 0x0000, 0x0100
#: Of a quaternion x, y, z, w; of an Imu also the first covariance: whether there is one.
_QUATERNION, _IMU_ORIENTATION = np.dtype(('<f8', 4)), np.dtype(('<f8', 5))


def _check_size(type_name: str, start: np.ndarray, size: np.ndarray, least: ArrayLike) -> None:
    """Refuse messages that are shorter than the bytes of their fields."""
    short = size < least
    if short.any():
        first = int(np.argmax(short))
        raise BagError(f'{type_name} message of {size[first]} bytes is too short',
                       offset=int(start[first]))


def decode_headings(type_name: str, convention: str, data: bytes, start: np.ndarray,
                    stop: np.ndarray) -> Headings:
    """
    Return the headings in a stretch of bytes that holds messages.

    Parameters
    ----------
    type_name : str
        A key of `HEADING_TYPES`.
    convention : {'enu', 'ned'}
        World axes of the orientations.
    data : bytes
        Any bytes that hold the messages.
    start, stop : ndarray of int64, shape (n,)
        First byte of each message and the byte behind its last.

    Returns
    -------
    Headings
        In the order of `start`; nan where the quaternion is zero or not finite, or where an Imu
        says by `orientation_covariance[0] = -1` that it has no orientation.

    Raises
    ------
    BagError
        If a message is too short for its type or does not start as CDR; the offset is that in
        `data`.

    """
    size = stop - start
    _check_size(type_name, start, size, _HEADER.itemsize)
    header = gather(data, _HEADER, start)
    little = header['order'] == _LITTLE
    if little.all():
        return _decode_one_order(type_name, convention, data, start, size, header)
    strange = ~little & (header['order'] != _BIG)
    if strange.any():
        raise BagError(f'{type_name} message does not start as CDR',
                       offset=int(start[np.argmax(strange)]))
    whole = Headings(np.empty(len(start), np.int64), np.empty(len(start)))
    for which, sign in ((little, '<'), (~little, '>')):
        part = _decode_one_order(type_name, convention, data, start[which], size[which],
                                 header[which].view(_HEADER.newbyteorder(sign)))
        whole.stamp_ns[which], whole.heading_deg[which] = part.stamp_ns, part.heading_deg
    return whole


def _decode_one_order(type_name: str, convention: str, data: bytes, start: np.ndarray,
                      size: np.ndarray,
                      header: np.ndarray) -> Headings:
    """Return the same of messages of one byte order, that of their headers."""
    sign = '>' if header.dtype['length'].byteorder == '>' else '<'
    length = header['length'].astype(np.int64)
    if length.size and (length == length[0]).all():
        length = length[0]
    end = length + (_HEADER.itemsize - 4)
    if type_name == _ODOMETRY:
        end = _align(end, 4) + 4
        _check_size(type_name, start, size, end + 4)
        end = end + gather(data, f'{sign}u4', start + end)
    at = _align(end, 8) + 4 + HEADING_TYPES[type_name]
    kind = (_IMU_ORIENTATION if type_name == IMU else _QUATERNION).newbyteorder(sign)
    _check_size(type_name, start, size, at + kind.itemsize)
    x, y, z, w, *covariance = gather(data, kind, start + at).T
    heading_deg = angles.heading_from_quaternion(x, y, z, w, convention)
    if covariance:
        heading_deg[covariance[0] == _UNKNOWN] = np.nan
    stamp_ns = header['sec'].astype(np.int64) * _SECOND_NS
    stamp_ns += header['nanosec']
    return Headings(stamp_ns, heading_deg)
