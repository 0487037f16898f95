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
Arithmetic on the circle, and the one conversion between headings and quaternions.

No other module subtracts two headings. Live nodes and bag readers call the same functions, so a
recorded quaternion gives the live heading to the bit.
"""

from __future__ import annotations

from typing import Iterator

import numpy as np
from numpy.typing import ArrayLike

from .records import Reals

#: Angles processed at once: intermediate results stay in the cache.
_PIECE = 32768


def _are_within(angle: np.ndarray, lowest: float, below: float) -> bool:
    """Tell whether there are any angles, and all angles lie in the half-open range."""
    return angle.size > 0 and bool(angle.min() >= lowest) and bool(angle.max() < below)


def _remainder(angle: np.ndarray) -> np.ndarray:
    """Remove whole turns and keep the sign of the angle; nan if it is not finite."""
    if _are_within(angle, -359.0, 360.0):
        return angle
    rest: Reals = np.fmod(np.where(np.isfinite(angle), angle, np.nan), 360.0)
    return rest


def wrap180(angle_deg: ArrayLike, center_deg: float = 0.0) -> np.ndarray:
    """
    Reduce angles to [center - 180, center + 180).

    Parameters
    ----------
    angle_deg : array_like, shape (n,) or scalar
        Angles, degrees. nan and infinity give nan.
    center_deg
        Middle of the range, degrees.

    Returns
    -------
    ndarray, shape of `angle_deg`
        The reduced angles. Exactly +180 above the centre becomes -180. The remainder and the one
        addition of 360 are exact, so 359 - 1 gives -2 and no rounding is added.

    References
    ----------
    GK (1): the wrap of the difference.

    Examples
    --------
    >>> wrap180([359.0 - 1.0, 180.0, -180.0]).tolist()
    [-2.0, -180.0, -180.0]

    """
    angle = np.asarray(angle_deg, dtype=np.float64) - center_deg
    if _are_within(angle, -180.0, 180.0):
        angle += center_deg
        return angle
    d = _remainder(angle)
    d = np.where(d >= 180.0, d - 360.0, d)
    d = np.where(d < -180.0, d + 360.0, d)
    return d + center_deg


def wrap360(angle_deg: ArrayLike) -> np.ndarray:
    """
    Reduce angles to [0, 360).

    Parameters
    ----------
    angle_deg : array_like, shape (n,) or scalar
        Angles, degrees. nan and infinity give nan.

    Returns
    -------
    ndarray, shape of `angle_deg`
        The reduced angles; a tiny negative angle that rounds to 360 becomes 0.

    Examples
    --------
    >>> wrap360([-10.0, 360.0, 725.0, -1e-20]).tolist()
    [350.0, 0.0, 5.0, 0.0]

    """
    angle = np.asarray(angle_deg, dtype=np.float64)
    if _are_within(angle, 0.0, 360.0):
        return angle + 0.0
    d = _remainder(angle)
    d = np.where(d < 0.0, d + 360.0, d)
    return np.where(d >= 360.0, 0.0, d) + 0.0


def headings_from_signed(heading_deg: ArrayLike) -> np.ndarray:
    """
    Return headings that count from -180 as headings from 0.

    Parameters
    ----------
    heading_deg : array_like, shape (n,)
        Headings as a file has them, degrees.

    Returns
    -------
    ndarray, shape (n,)
        The same, plus 360 from -180 to below 0; nan where they are not finite.

    Examples
    --------
    >>> headings_from_signed([-10.0, 350.0, 400.0, float('inf')]).tolist()
    [350.0, 350.0, 400.0, nan]

    """
    heading = np.asarray(heading_deg, dtype=np.float64)
    finite = np.where(np.isfinite(heading), heading, np.nan)
    return np.where((finite >= -180.0) & (finite < 0.0), wrap360(finite), finite)


def unwrap_deg(heading_deg: ArrayLike) -> np.ndarray:
    """
    Return the headings as a continuous angle: each plus whole turns, so that no step is a half.

    Parameters
    ----------
    heading_deg : array_like, shape (n,)
        Headings in stamp order, degrees, finite.

    Returns
    -------
    ndarray, shape (n,)
        Degrees, no longer confined to [0, 360). Empty for n = 0.

    Examples
    --------
    >>> unwrap_deg([350.0, 10.0, 350.0]).tolist()
    [350.0, 370.0, 350.0]

    """
    heading = np.asarray(heading_deg, dtype=np.float64)
    unwrapped: Reals = np.empty(heading.shape)
    lo = 0
    for piece in unwrap_pieces(heading):
        unwrapped[lo:lo + piece.size] = piece
        lo += piece.size
    return unwrapped


def unwrap_pieces(heading_deg: Reals) -> Iterator[Reals]:
    """
    Yield what `unwrap_deg` returns, some ten thousand headings at a time.

    Examples
    --------
    >>> [piece.tolist() for piece in unwrap_pieces(np.array([350.0, 10.0]))]
    [[350.0, 370.0]]

    """
    turned_deg = 0.0
    for lo in range(0, heading_deg.size, _PIECE):
        piece = heading_deg[lo:lo + _PIECE]
        steps = np.diff(piece, prepend=heading_deg[max(lo - 1, 0)])
        turns_deg: Reals | float = turned_deg
        if not _are_within(steps, -180.0, 180.0):
            # Whole turns are exact, so nothing adds up.
            turns_deg = turned_deg + np.cumsum(360.0 * np.rint((wrap180(steps) - steps) / 360.0))
            turned_deg = float(turns_deg[-1])
        yield piece + turns_deg


def circular_mean(angle_deg: ArrayLike) -> tuple[float, float]:
    """
    Return the mean direction and the length of the mean resultant.

    Parameters
    ----------
    angle_deg : array_like, shape (n,) or scalar
        Angles, degrees, finite.

    Returns
    -------
    mean_deg : float
        Direction in [-180, 180); nan for n = 0 or a resultant of zero length.
    resultant_length : float
        In [0, 1]; 1 when all angles agree, nan for n = 0.

    Examples
    --------
    >>> mean_deg, length = circular_mean([350.0, 10.0])
    >>> round(abs(mean_deg), 9), round(length, 6)
    (0.0, 0.984808)

    """
    angle = np.ravel(np.asarray(angle_deg, dtype=np.float64))
    if angle.size == 0:
        return float('nan'), float('nan')
    c = s = 0.0
    for lo in range(0, angle.size, _PIECE):
        piece = np.radians(angle[lo:lo + _PIECE])
        c += float(np.cos(piece).sum())
        s += float(np.sin(piece).sum())
    c, s = c / angle.size, s / angle.size
    length = min(1.0, float(np.hypot(c, s)))
    if length == 0.0:
        return float('nan'), 0.0
    return float(wrap180(np.degrees(np.arctan2(s, c)))), length


def heading_from_quaternion(x: ArrayLike, y: ArrayLike, z: ArrayLike, w: ArrayLike,
                            convention: str = 'enu') -> np.ndarray:
    """
    Return the heading of an orientation.

    Parameters
    ----------
    x, y, z, w : array_like, shape (n,)
        The quaternion from body to world; it need not be normalised.
    convention : {'enu', 'ned'}
        'enu' (REP-103): world axes east, north, up, heading = 90 - yaw.
        'ned': world axes north, east, down, heading = yaw.

    Returns
    -------
    ndarray, shape (n,)
        Headings in [0, 360), degrees; nan where the quaternion is zero or not finite.

    Raises
    ------
    ValueError
        If the convention is unknown.

    Examples
    --------
    >>> heading_from_quaternion([0.0], [0.0], [0.0], [1.0]).tolist()
    [90.0]

    """
    x, y, z, w = (np.asarray(q, dtype=np.float64) for q in (x, y, z, w))
    with np.errstate(over='ignore', invalid='ignore'):
        z2, w2, wz = z * z, w * w, w * z
        if x.any() or y.any():
            x2, y2 = x * x, y * y
            norm2 = x2 + y2 + z2 + w2
            yaw = np.arctan2(2.0 * (wz + x * y), w2 + x2 - y2 - z2)
        else:
            norm2 = z2 + w2
            yaw = np.arctan2(2.0 * wz, w2 - z2)
    if not (norm2.size and norm2.min() > 0.0 and norm2.max() < np.inf):
        yaw = np.where(np.isfinite(norm2) & (norm2 > 0.0), yaw, np.nan)
    yaw_deg = np.degrees(yaw)
    if convention == 'enu':
        return wrap360(90.0 - yaw_deg)
    if convention == 'ned':
        return wrap360(yaw_deg)
    raise ValueError(f"convention = {convention!r}: use 'enu' or 'ned'")


def roll_pitch_from_quaternion(x: ArrayLike, y: ArrayLike, z: ArrayLike, w: ArrayLike,
                               convention: str = 'enu') -> tuple[np.ndarray, np.ndarray]:
    """
    Return roll and pitch of an orientation.

    Parameters
    ----------
    x, y, z, w, convention
        As for `heading_from_quaternion`. The axes of the body are forward, port, up with 'enu'
        (REP-103), and forward, starboard, down with 'ned'.

    Returns
    -------
    roll_deg, pitch_deg : ndarray, shape (n,)
        Starboard down in (-180, 180], and bow up in [-90, 90], degrees; nan where the quaternion
        is zero or not finite.

    Examples
    --------
    >>> half = np.radians(5.0) / 2.0
    >>> roll, pitch = roll_pitch_from_quaternion(0.0, np.sin(half), 0.0, np.cos(half))
    >>> round(float(roll), 9), round(float(pitch), 9)
    (0.0, -5.0)

    """
    x, y, z, w = (np.asarray(q, dtype=np.float64) for q in (x, y, z, w))
    with np.errstate(over='ignore', invalid='ignore', divide='ignore'):
        norm2 = x * x + y * y + z * z + w * w
        roll = np.arctan2(2.0 * (w * x + y * z), w * w - x * x - y * y + z * z)
        pitch = np.arcsin(np.clip(2.0 * (w * y - z * x) / norm2, -1.0, 1.0))
    is_rotation = np.isfinite(norm2) & (norm2 > 0.0)
    bow_up = -1.0 if convention == 'enu' else 1.0
    return (np.degrees(np.where(is_rotation, roll, np.nan)),
            bow_up * np.degrees(np.where(is_rotation, pitch, np.nan)))


def quaternion_from_heading(heading_deg: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """
    Return z and w of the level ENU quaternion of a heading; x and y are zero.

    Parameters
    ----------
    heading_deg : array_like, shape (n,)
        Headings, degrees clockwise from true north.

    Returns
    -------
    z, w : ndarray, shape (n,)
        Components of the rotation by yaw = 90 - heading about the upward axis.

    Examples
    --------
    >>> z, w = quaternion_from_heading([90.0])
    >>> z.tolist(), w.tolist()
    ([0.0], [1.0])

    """
    half = np.radians(wrap180(90.0 - np.asarray(heading_deg, dtype=np.float64))) / 2.0
    return np.sin(half), np.cos(half)
