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

"""What one sentence or message tells of the motion of the ship, if a ship can move so."""

from __future__ import annotations

import math
from typing import NamedTuple

from heading_intercompare.core.records import FASTEST_M_S, FASTEST_TURN_DEG_S

#: Angles are rounded, so a full turn may be a little more.
_TURN_RAD = 6.2832
_STEEPEST_DEG = 90.0


class MovedRow(NamedTuple):
    """
    What a sentence or message tells.

    Attributes
    ----------
    what
        'fix', 'velocity', 'rate' or 'attitude'.
    values
        Its columns: see `MOTION_COLUMNS`; roll and pitch, degrees.

    """

    what: str
    values: tuple[float, ...]


def make_position(latitude_deg: float, longitude_deg: float) -> MovedRow | None:
    """Return a position; None if it is none on Earth."""
    on_earth = abs(latitude_deg) <= 90.0 and abs(longitude_deg) <= 180.0
    return MovedRow('fix', (latitude_deg, longitude_deg)) if on_earth else None


def make_velocity(course_rad: float, speed_m_s: float) -> MovedRow | None:
    """Return the velocity over ground; None if no ship has such a course and speed."""
    if not (0.0 <= course_rad <= _TURN_RAD and 0.0 <= speed_m_s <= FASTEST_M_S):
        return None
    return MovedRow('velocity', (speed_m_s * math.sin(course_rad),
                                 speed_m_s * math.cos(course_rad)))


def make_rate(rate_deg_s: float) -> MovedRow | None:
    """Return the rate of turn to starboard; None if no ship turns so fast."""
    return MovedRow('rate', (rate_deg_s,)) if abs(rate_deg_s) <= FASTEST_TURN_DEG_S else None


def make_attitude(roll_deg: float, pitch_deg: float) -> MovedRow | None:
    """Return roll (starboard down) and pitch (bow up); None if they are too steep."""
    is_possible = max(abs(roll_deg), abs(pitch_deg)) <= _STEEPEST_DEG
    return MovedRow('attitude', (roll_deg, pitch_deg)) if is_possible else None
