# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Whole chunks of heading messages at once.

A chunk of n messages is n rows of bytes. Decoding gathers each field of all messages with one
numpy call, wherever the messages lie and however long their frame names are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core import angles
from heading_intercompare.core.records import Headings, Pairs

from .blocks import gathered, joined
from .cdr import encode
from .errors import BagError

__all__ = ['HEADING_TYPES', 'IMU', 'PAIRS_TYPE', 'RawHeadings', 'decode_headings', 'encode_imu',
           'encode_pairs', 'raw_headings']

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
    return rows, 4 + _aligned(12 + len(frame_id.encode()) + 1, 8)


def _put(rows: np.ndarray, at: int, column: np.ndarray) -> None:
    rows[:, at:at + column.itemsize] = column.reshape(-1, 1).view(np.uint8)


def _put_reals(rows: np.ndarray, at: int, values: ArrayLike) -> None:
    _put(rows, at, np.broadcast_to(values, len(rows)).astype('<f8'))


def _aligned(position, size: int):
    return position + -position % size


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
        One CDR message a row, stamped with the TS. Linear: TS - RS wrapped, RS heading, TS
        heading, degrees; angular: lag in seconds, variance factor, 0.

    Raises
    ------
    BagError
        If a stamp is beyond the range of builtin_interfaces/Time.

    """
    rows, at = _rows(PAIRS_TYPE, pairs.stamp_ns, frame_id)
    columns = (angles.wrap180(pairs.ts_deg - pairs.rs_deg), pairs.rs_deg, pairs.ts_deg,
               pairs.lag_ns / _SECOND_NS, pairs.rs_variance_factor)
    for number, column in enumerate(columns):
        _put_reals(rows, at + 8 * number, column)
    return rows


_HEADER = np.dtype([('order', 'u1', 4), ('sec', '<i4'), ('nanosec', '<u4'), ('length', '<u4')])
_QUATERNION = np.dtype([(name, '<f8') for name in 'xyzw'])
#: The quaternion of an Imu and the first covariance, which says whether there is one.
_IMU_ORIENTATION = np.dtype([(name, '<f8') for name in ('x', 'y', 'z', 'w', 'covariance')])


@dataclass(frozen=True, slots=True, eq=False)
class RawHeadings:
    """
    What makes a heading of each of n messages of one type, as it is in the messages.

    Attributes
    ----------
    header : ndarray, shape (n,)
        Fields sec, nanosec.
    orientation : ndarray, shape (n,)
        Fields x, y, z, w; of an Imu also covariance.

    """

    header: np.ndarray
    orientation: np.ndarray

    def __getitem__(self, which: np.ndarray) -> 'RawHeadings':
        return RawHeadings(self.header[which], self.orientation[which])

    @classmethod
    def concatenate(cls, parts: Sequence['RawHeadings']) -> 'RawHeadings':
        """Return the messages of at least one part in a row."""
        if len(parts) == 1:
            return parts[0]
        return cls(joined([p.header for p in parts]), joined([p.orientation for p in parts]))

    def headings(self, convention: str) -> Headings:
        """Return the headings under a convention of the world axes, 'enu' or 'ned'."""
        q = self.orientation
        heading_deg = angles.heading_from_quaternion(q['x'], q['y'], q['z'], q['w'], convention)
        if 'covariance' in q.dtype.names:
            heading_deg[q['covariance'] == _UNKNOWN] = np.nan
        stamp_ns = self.header['sec'].astype(np.int64) * _SECOND_NS + self.header['nanosec']
        return Headings(stamp_ns, heading_deg)


def _check_size(type_name: str, start: np.ndarray, stop: np.ndarray, end: np.ndarray) -> None:
    """Refuse messages that stop before the byte at which their fields end."""
    short = end > stop
    if short.any():
        first = int(np.argmax(short))
        raise BagError(f'{type_name} message of {stop[first] - start[first]} bytes is too short',
                       offset=int(start[first]))


def raw_headings(type_name: str, data: bytes, start: np.ndarray, stop: np.ndarray) -> RawHeadings:
    """
    Return what makes the headings in a stretch of bytes that holds messages.

    Parameters
    ----------
    type_name : str
        A key of `HEADING_TYPES`.
    data : bytes
        Any bytes that hold the messages.
    start, stop : ndarray of int64, shape (n,)
        First byte of each message and the byte behind its last.

    Raises
    ------
    BagError
        If a message is too short for its type or does not start as CDR; the offset is that in
        `data`.

    """
    _check_size(type_name, start, stop, start + _HEADER.itemsize)
    header = gathered(data, _HEADER, start)
    order = header['order'][:, 1]
    big = order == 0
    strange = (order > 1) | (header['order'][:, 0] != 0)
    if strange.any():
        raise BagError(f'{type_name} message does not start as CDR',
                       offset=int(start[np.argmax(strange)]))
    if not big.any():
        return _raw(type_name, data, start, stop, header)
    parts = [_raw(type_name, data, start[which], stop[which], header[which].view(
        _HEADER.newbyteorder(sign))) for which, sign in ((~big, '<'), (big, '>'))]
    whole = RawHeadings.concatenate([RawHeadings(p.header.astype(_HEADER), p.orientation.astype(
        p.orientation.dtype.newbyteorder('<'))) for p in parts])
    return whole[np.argsort(np.concatenate([np.flatnonzero(~big), np.flatnonzero(big)]))]


def _raw(type_name: str, data: bytes, start: np.ndarray, stop: np.ndarray,
         header: np.ndarray) -> RawHeadings:
    """Return the same of messages of one byte order, that of their headers."""
    order = header.dtype['length'].byteorder
    order = '>' if order == '>' else '<'
    end = header['length'].astype(np.int64) + (_HEADER.itemsize - 4)
    if type_name == _ODOMETRY:
        end = _aligned(end, 4) + 4
        _check_size(type_name, start, stop, start + 4 + end)
        end += gathered(data, f'{order}u4', start + end)
    at = start + (_aligned(end, 8) + 4 + HEADING_TYPES[type_name])
    kind = (_IMU_ORIENTATION if type_name == IMU else _QUATERNION).newbyteorder(order)
    _check_size(type_name, start, stop, at + kind.itemsize)
    return RawHeadings(header, gathered(data, kind, at))


def decode_headings(type_name: str, convention: str, data: bytes, start: np.ndarray,
                    stop: np.ndarray) -> Headings:
    """
    Return the headings in a stretch of bytes that holds messages.

    Parameters
    ----------
    type_name, data, start, stop
        As for `raw_headings`.
    convention : {'enu', 'ned'}
        World axes of the orientations.

    Returns
    -------
    Headings
        In the order of `start`; nan where the quaternion is zero or not finite, or where an Imu
        says by `orientation_covariance[0] = -1` that it has no orientation.

    Raises
    ------
    BagError
        As `raw_headings`.

    """
    return raw_headings(type_name, data, start, stop).headings(convention)
