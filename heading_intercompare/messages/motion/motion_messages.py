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
Chunks of motion to messages and back.

The axes are those of ROS: x to the east, y to the north, z up. So a turn to starboard is negative
about z, and a velocity over ground has its eastern part in x.
"""

from __future__ import annotations

from functools import partial
from typing import Sequence

import numpy as np

from heading_intercompare.core.records import Integers, Motion
from heading_intercompare.messages.byte_columns import (
    align,
    BytesLike,
    check_size,
    decode_stamped,
    end_of_strings,
    gather,
    gather_reals,
    read_sound,
    read_stamps,
    split_rows,
    stamped_rows,
)
from heading_intercompare.messages.stamps import fits_message

FIX = 'sensor_msgs/msg/NavSatFix'
VELOCITY = 'geometry_msgs/msg/TwistStamped'
_WITH_COVARIANCE = 'geometry_msgs/msg/TwistWithCovarianceStamped'
_IMU = 'sensor_msgs/msg/Imu'

FIX_TYPES = (FIX,)
VELOCITY_TYPES = (VELOCITY, _WITH_COVARIANCE)
RATE_TYPES = (VELOCITY, _WITH_COVARIANCE, _IMU)

MOTION_TYPES = {'fix': FIX_TYPES, 'velocity': VELOCITY_TYPES, 'rate': RATE_TYPES}
"""The types that are read, by what they tell."""

PUBLISHED_TYPES = {'fix': FIX, 'velocity': VELOCITY, 'rate': VELOCITY}
"""The types of `encode_motion`."""

_UNKNOWN = -1.0
#: Latitude, longitude, altitude and covariance of a fix, and the byte with its kind.
_FIX_REALS, _FIX_REST = 12, 1
#: Orientation with covariance before the angular velocity of an Imu, and one covariance after it.
_IMU_BEFORE = 8 * 13


def encode_motion(motion: Motion, what: str, frame_id: str) -> np.ndarray:
    """
    Return the rows of a motion that tell one thing, as messages.

    Parameters
    ----------
    motion
        All rows must tell it: see `Motion.positions`, `Motion.velocities` and `Motion.rates`.
    what : {'fix', 'velocity', 'rate'}
        A NavSatFix with a fix, without altitude; or a TwistStamped with the velocity over ground
        in `linear`, m/s, or with minus the rate of turn in `angular.z`, rad/s.
    frame_id
        Frame of the header.

    Returns
    -------
    ndarray of uint8, shape (n, size)
        One CDR message per row.

    Raises
    ------
    MessageError
        If a stamp is beyond the range of builtin_interfaces/Time.

    """
    if what == 'fix':
        fixes = np.zeros((len(motion), _FIX_REALS), '<f8')
        fixes[:, 0], fixes[:, 1] = motion.latitude_deg, motion.longitude_deg
        fixes[:, 2] = np.nan
        # A status of 0 is a fix.
        return stamped_rows(FIX, motion.stamp_ns, frame_id, fixes, _FIX_REST)
    reals = np.zeros((len(motion), 6), '<f8')
    if what == 'velocity':
        reals[:, 0], reals[:, 1] = motion.east_m_s, motion.north_m_s
    else:
        reals[:, 5] = -np.radians(motion.rate_deg_s)
    return stamped_rows(VELOCITY, motion.stamp_ns, frame_id, reals)


def split_motion(motion: Motion, what: str, frame_id: str) -> list[bytes]:
    """
    Return the messages of `encode_motion` one by one, for publishing.

    Rows with a stamp before 1970 or beyond the range of a message are skipped.
    """
    rows = motion[fits_message(motion.stamp_ns)]
    return split_rows(encode_motion(rows, what, frame_id)) if len(rows) else []


def decode_motion(type_name: str, what: str, data: BytesLike, start: Integers,
                  stop: Integers) -> Motion:
    """
    Return the motion in the messages that a stretch of bytes holds.

    Parameters
    ----------
    type_name
        One of `MOTION_TYPES` for `what`.
    what : {'fix', 'velocity', 'rate'}
        What is taken from the messages.
    data : bytes-like
        Any bytes that hold the messages.
    start, stop : ndarray of int64, shape (n,)
        First byte of each message, and the byte after its last.

    Returns
    -------
    Motion
        In the order of `start`; nan where a NavSatFix has no fix, and where an Imu has no angular
        velocity.

    Raises
    ------
    MessageError
        If a message is too short for its type or does not start as CDR.

    """
    return decode_stamped(type_name, data, start, stop, partial(_motion, type_name, what))


def _motion(type_name: str, what: str, data: BytesLike, start: Integers, size: Integers,
            header: np.ndarray) -> Motion:
    """Return the motion in messages of one byte order."""
    sign, end = end_of_strings(header)
    stamps = read_stamps(header)

    def columns(at: Integers | int, n: int) -> np.ndarray:
        return np.array(gather_reals(type_name, data, start, size, at, sign, n), np.float64,
                        order='C')
    if what == 'fix':
        # Fields are aligned from the end of the first four bytes.
        check_size(type_name, start, size, end + 5)
        status = gather(data, 'i1', start + end + 4)
        at = align(align(end + 1, 2) + 2, 8) + 4
        latitude, longitude = columns(at, 2)
        latitude[status < 0] = np.nan
        return Motion.of_positions(stamps, latitude, longitude)
    at = align(end, 8) + 4
    if type_name == _IMU:
        _, _, about_up, covariance = columns(at + _IMU_BEFORE, 4)
        about_up[covariance == _UNKNOWN] = np.nan
    else:
        east, north, _, _, _, about_up = columns(at, 6)
        if what == 'velocity':
            return Motion.of_velocities(stamps, east, north)
    return Motion.of_rates(stamps, -np.degrees(about_up))


def read_motion(type_name: str, what: str,
                messages: Sequence[bytes]) -> tuple[Motion, list[str]]:
    """Return the rows of single messages that tell one thing, and what is wrong with others."""
    if not messages:
        return Motion.empty(), []
    rows, refused = read_sound(partial(decode_motion, type_name, what), messages, Motion)
    return rows.select(what), refused
