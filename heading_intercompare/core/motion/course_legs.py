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

"""Straight legs of a run, and how far each heading points off the course over ground there."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Sequence

import numpy as np

from heading_intercompare.core.angles import circular_mean, wrap180
from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.records import Integers, KNOT_M_S, Motion, Reals
from heading_intercompare.core.settings import MotionRule

from .tangent_plane import steps_m

WINDOW_S = 60.0
"""A leg is made of windows of this length, seconds."""

LARGEST_BEND_DEG = 5.0
"""The courses of the halves of a straight window differ by at most this, degrees."""

LARGEST_TURN_DEG = 10.0
"""The courses of the windows of a leg differ from its first one by at most this, degrees."""

MOST_LEGS = 64
"""The longest legs that a verdict lists."""

LEAST_VELOCITIES = 4
"""With fewer velocities, those between positions are used; a window has no fewer, either."""

_LEAST_SHARE = 0.5
_FARTHEST_S = 3.0
_ROUNDING_KN = 1e-6
_STEP_NS = 10 ** 10
_SECOND_NS = 10 ** 9


@dataclass(frozen=True, slots=True)
class CourseLegs:
    """The straight legs of a run in order of time; keys of the JSON, lists of equal length."""

    start_ns: tuple[int, ...] = figure('first course of the leg', default=())
    duration_s: tuple[float, ...] = figure('leg', 'its duration', default=())
    course_deg: tuple[float, ...] = figure('course', 'mean over ground', default=())
    speed_kn: tuple[float, ...] = figure('speed', 'over ground, of the slowest minute', default=())
    bound_deg: tuple[float, ...] = figure('bound', 'the angle off the course that leeway and '
                                          'current explain; 180 for any', default=())
    ts_deg: tuple[float, ...] = figure('TS - course', 'median', default=())
    rs_deg: tuple[float, ...] = figure('RS - course', 'median', default=())

    def __len__(self) -> int:
        return len(self.start_ns)

    def pick(self, which: Sequence[int]) -> 'CourseLegs':
        """Return some of the legs."""
        return CourseLegs(*[tuple(getattr(self, name)[at] for at in which)
                            for name in self.__slots__])


def find_legs(motion: Motion, stamp_ns: Integers, ts_deg: Reals, rs_deg: Reals,
              rule: MotionRule) -> CourseLegs:
    """
    Find the straight legs of a run on which the ship is underway.

    Parameters
    ----------
    motion
        Rows in stamp order, within the run.
    stamp_ns : ndarray of int64, shape (n,)
        Stamps of the pairs in increasing order, nanoseconds.
    ts_deg, rs_deg : ndarray, shape (n,)
        Headings of both sensors, the installation offset removed from the TS; degrees.
    rule
        Least speed, strongest current, largest leeway.

    Returns
    -------
    CourseLegs

    Notes
    -----
    The velocities are cut into windows of a minute. The mean velocity of a window is faster than
    `least_speed_kn`, and the courses of its halves differ by at most 5 deg. Windows without a gap
    whose courses lie within 10 deg of the first one's are a leg. Without velocities, those between
    positions 10 s apart are used.

    With the current c and the speed v over ground, the course turns off the heading by at most
    arcsin(c / v), whatever the direction of the current, plus the leeway. A course of the motion
    is compared with the pair nearest to it, at most 3 s away.

    """
    courses = motion.velocities()
    if len(courses) < LEAST_VELOCITIES:
        courses = _between_positions(motion.positions())
    at = find_nearest(stamp_ns, courses.stamp_ns)
    near = at >= 0
    if not near.all():
        courses, at = courses[near], at[near]
    legs = _join_windows(_find_windows(courses, rule), courses)
    rows = []
    for lo, hi, speed in legs:
        leg, pairs = courses[lo:hi], at[lo:hi]
        course = leg.course_deg
        start, stop = int(leg.stamp_ns[0]), int(leg.stamp_ns[-1])
        rows.append((start, (stop - start) / _SECOND_NS, _course_of(leg) % 360.0, speed,
                     _bound_deg(speed, rule), _median_deg(ts_deg[pairs] - course),
                     _median_deg(rs_deg[pairs] - course)))
    return CourseLegs(*zip(*rows)) if rows else CourseLegs()


def _between_positions(rows: Motion) -> Motion:
    """Return the velocities between positions about 10 s apart, stamped in the middle."""
    if len(rows) < 2:
        return Motion.empty()
    cell = rows.stamp_ns // _STEP_NS
    rows = rows[np.flatnonzero(np.diff(cell, prepend=cell[0] - 1))]
    step_s = np.diff(rows.stamp_ns) / _SECOND_NS
    east, north = steps_m((rows.latitude_deg[:-1], rows.longitude_deg[:-1]),
                          (rows.latitude_deg[1:], rows.longitude_deg[1:]))
    good = (step_s > 0.0) & (step_s < 3.0 * _STEP_NS / _SECOND_NS)
    middle = rows.stamp_ns[:-1] + np.diff(rows.stamp_ns) // 2
    step_s = np.where(good, step_s, 1.0)
    return Motion.of_velocities(middle, east / step_s, north / step_s)[good]


def find_nearest(stamp_ns: Integers, wanted_ns: Integers,
                 farthest_s: float = _FARTHEST_S) -> Integers:
    """Return the index of the stamp nearest to each wanted one; -1 if none is near enough."""
    if not len(stamp_ns):
        return np.full(len(wanted_ns), -1)
    after = np.searchsorted(stamp_ns, wanted_ns).clip(1, max(len(stamp_ns) - 1, 1))
    after = np.minimum(after, len(stamp_ns) - 1)
    before = np.maximum(after - 1, 0)
    nearer = np.abs(stamp_ns[before] - wanted_ns) <= np.abs(stamp_ns[after] - wanted_ns)
    at = np.where(nearer, before, after)
    return np.where(np.abs(stamp_ns[at] - wanted_ns) <= farthest_s * _SECOND_NS, at, -1)


def _find_windows(courses: Motion, rule: MotionRule) -> list[tuple[int, int, float, float]]:
    """Return begin, end, course in degrees and speed in knots of the straight windows."""
    if not len(courses):
        return []
    number = (courses.stamp_ns - courses.stamp_ns[0]) // round(WINDOW_S * _SECOND_NS)
    edges = [*np.flatnonzero(np.diff(number, prepend=-1)).tolist(), len(courses)]
    windows = []
    for lo, hi in zip(edges[:-1], edges[1:]):
        part = courses[lo:hi]
        half = len(part) // 2
        if len(part) < LEAST_VELOCITIES or (int(part.stamp_ns[-1]) - int(part.stamp_ns[0])
                                          < _LEAST_SHARE * WINDOW_S * _SECOND_NS):
            continue
        speed = float(np.hypot(part.east_m_s.mean(), part.north_m_s.mean())) / KNOT_M_S
        bend = wrap180(_course_of(part[half:]) - _course_of(part[:half]))
        if speed >= rule.least_speed_kn - _ROUNDING_KN and abs(float(bend)) <= LARGEST_BEND_DEG:
            windows.append((lo, hi, _course_of(part), speed))
    return windows


def _join_windows(windows: Sequence[tuple[int, int, float, float]],
                  courses: Motion) -> list[tuple[int, int, float]]:
    """Return begin, end and slowest speed of the legs that windows of about one course make."""
    legs: list[tuple[int, int, float]] = []
    first_deg = 0.0
    longest_ns = round(WINDOW_S * _SECOND_NS)
    for lo, hi, course, speed in windows:
        if (legs and legs[-1][1] == lo and abs(float(wrap180(course - first_deg)))
                <= LARGEST_TURN_DEG
                and courses.stamp_ns[lo] - courses.stamp_ns[lo - 1] <= longest_ns):
            legs[-1] = legs[-1][0], hi, min(legs[-1][2], speed)
        else:
            legs.append((lo, hi, speed))
            first_deg = course
    return legs


def _course_of(rows: Motion) -> float:
    """Return the direction of the mean velocity, degrees."""
    return math.degrees(math.atan2(float(rows.east_m_s.mean()), float(rows.north_m_s.mean())))


def _bound_deg(speed_kn: float, rule: MotionRule) -> float:
    """Return how far current and leeway may turn the course off the heading, degrees."""
    if speed_kn <= rule.current_max_kn + _ROUNDING_KN:
        return 180.0
    drift = math.degrees(math.asin(rule.current_max_kn / speed_kn))
    return min(180.0, drift + rule.leeway_max_deg)


def _median_deg(angle_deg: Reals) -> float:
    """Return the median on the circle: about the mean direction, degrees."""
    centre, _ = circular_mean(angle_deg)
    if not math.isfinite(centre):
        centre = 0.0
    return float(wrap180(centre + np.median(wrap180(angle_deg - centre))))


def largest_arc_deg(course_deg: Sequence[float]) -> float:
    """Return the largest angle between two of some courses, degrees; 0 for fewer than two."""
    course = np.asarray(course_deg, np.float64)
    if course.size < 2:
        return 0.0
    return float(np.abs(wrap180(course[:, None] - course[None, :])).max())
