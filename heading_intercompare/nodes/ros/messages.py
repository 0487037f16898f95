# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Headings and pairs to messages and back; `status_messages` does the same for diagnostics.

rclpy does not check the types of message fields: a numpy number, or an int in a field of reals,
is published as garbage. Hence every field is given its type here, and set nowhere else.
"""

from __future__ import annotations

import math
from typing import Any, Sequence

from geometry_msgs.msg import PoseWithCovarianceStamped, QuaternionStamped, TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu

from heading_intercompare.core.angles import heading_from_quaternion, quaternion_from_heading
from heading_intercompare.core.pairing.difference import subtract
from heading_intercompare.core.records import Headings, Pairs

from .message_stamps import stamp_ns, TIME_LIMIT_NS, time_message

__all__ = ['heading_messages', 'HEADING_TYPES', 'headings_from', 'pair_messages', 'pairs_from',
           'PAIRS_TYPES']

HEADING_TYPES = {
    'sensor_msgs/msg/Imu': Imu,
    'geometry_msgs/msg/QuaternionStamped': QuaternionStamped,
    'geometry_msgs/msg/PoseWithCovarianceStamped': PoseWithCovarianceStamped,
    'nav_msgs/msg/Odometry': Odometry,
}
"""The message types that headings are taken from, by name."""

PAIRS_TYPES = {'geometry_msgs/msg/TwistStamped': TwistStamped}
"""The message type of pairs, by name."""

_UNKNOWN = -1.0


def _orientation(message: Any) -> tuple[float, float, float, float]:
    """Return x, y, z, w; all nan where an Imu says that it has no orientation."""
    if isinstance(message, Imu):
        if message.orientation_covariance[0] == _UNKNOWN:
            return (math.nan,) * 4
        q = message.orientation
    elif isinstance(message, QuaternionStamped):
        q = message.quaternion
    else:
        q = message.pose.pose.orientation
    return q.x, q.y, q.z, q.w


def headings_from(messages: Sequence[Any], convention: str) -> Headings:
    """
    Return the headings of messages of one of `HEADING_TYPES`.

    Parameters
    ----------
    messages : sequence of message
        n >= 0, in the order in which they came.
    convention : {'enu', 'ned'}
        World axes of the orientations.

    Returns
    -------
    Headings
        To the bit what `bags.heading_messages.decode_headings` makes of the recorded messages;
        nan where there is no orientation.

    """
    if not messages:
        return Headings.empty()
    x, y, z, w = zip(*(_orientation(message) for message in messages))
    return Headings.of([stamp_ns(message.header.stamp) for message in messages],
                       heading_from_quaternion(x, y, z, w, convention))


def heading_messages(headings: Headings, frame_id: str, sigma_deg: Sequence[float] | None = None,
                     rate_deg_s: Sequence[float] | None = None) -> list[Imu]:
    """
    Return headings as sensor_msgs/Imu, ENU; `bags.heading_messages.encode_imu` writes the same.

    Parameters
    ----------
    headings : Headings
        n readings, nan where the sensor calls itself invalid.
    frame_id : str
        Frame of the header.
    sigma_deg : sequence of float, length n, optional
        Standard deviations, degrees; 0 when unknown.
    rate_deg_s : sequence of float, length n, optional
        Rates of turn, degrees per second, positive to starboard; nan where unknown.

    Returns
    -------
    list of Imu
        In order; a reading whose stamp no message can hold is left out.

    """
    n = len(headings)
    z, w = quaternion_from_heading(headings.heading_deg)
    columns = (headings.stamp_ns.tolist(), z.tolist(), w.tolist(),
               [0.0] * n if sigma_deg is None else map(float, sigma_deg),
               [math.nan] * n if rate_deg_s is None else map(float, rate_deg_s))
    return [_imu(ns, frame_id, *row) for ns, *row in zip(*columns) if 0 <= ns < TIME_LIMIT_NS]


def _imu(ns: int, frame_id: str, z: float, w: float, sigma_deg: float,
         rate_deg_s: float) -> Imu:
    message = Imu()
    message.header.stamp = time_message(ns)
    message.header.frame_id = str(frame_id)
    valid = math.isfinite(z)
    message.orientation.z = float(z) if valid else 0.0
    message.orientation.w = float(w) if valid else 0.0
    message.orientation_covariance[0] = 0.0 if valid else _UNKNOWN
    message.orientation_covariance[8] = float(math.radians(sigma_deg) ** 2) if valid else 0.0
    turning = math.isfinite(rate_deg_s)
    message.angular_velocity.z = float(-math.radians(rate_deg_s)) if turning else 0.0
    message.angular_velocity_covariance[0] = 0.0 if turning else _UNKNOWN
    message.linear_acceleration_covariance[0] = _UNKNOWN
    return message


def pair_messages(pairs: Pairs) -> list[TwistStamped]:
    """Return pairs as geometry_msgs/TwistStamped, as `bags.heading_messages.encode_pairs` does."""
    rows = zip(pairs.stamp_ns.tolist(), subtract(pairs).x_deg.tolist(), pairs.rs_deg.tolist(),
               pairs.ts_deg.tolist(), pairs.lag_ns.tolist(), pairs.rs_variance_factor.tolist(),
               pairs.ts_variance_factor.tolist())
    messages = []
    for ns, x_deg, rs_deg, ts_deg, lag_ns, rs_factor, ts_factor in rows:
        message = TwistStamped()
        message.header.stamp = time_message(ns)
        linear, angular = message.twist.linear, message.twist.angular
        linear.x, linear.y, linear.z = float(x_deg), float(rs_deg), float(ts_deg)
        angular.x, angular.y, angular.z = float(lag_ns / 1e9), float(rs_factor), float(ts_factor)
        messages.append(message)
    return messages


def pairs_from(messages: Sequence[TwistStamped]) -> Pairs:
    """
    Return the pairs of messages made by `pair_messages`, to the bit; n >= 0.

    Earlier versions left the factor of the TS at 0, as they did not interpolate it: that is 1.
    """
    twists = [message.twist for message in messages]
    return Pairs.of([stamp_ns(message.header.stamp) for message in messages],
                    [t.linear.z for t in twists], [t.linear.y for t in twists],
                    [round(t.angular.x * 1e9) for t in twists], [t.angular.y for t in twists],
                    [t.angular.z or 1.0 for t in twists])
