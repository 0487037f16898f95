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

"""Straight legs, by hand and against a simulated voyage."""

from __future__ import annotations

import math

from core.motion.sailing import sail, START_NS
import numpy as np
import pytest

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.motion.course_legs import (
    CourseLegs,
    find_legs,
    find_nearest,
    largest_arc_deg,
)
from heading_intercompare.core.records import Motion
from heading_intercompare.core.settings import MotionRule

S = 10 ** 9
RULE = MotionRule()


def straight(course_deg, speed_kn, seconds=180, start_s=0.0):
    """Return courses once a second."""
    stamps = START_NS + np.rint((start_s + np.arange(seconds)) * 1e9).astype(np.int64)
    return Motion.of_courses(stamps, np.full(seconds, course_deg), np.full(seconds, speed_kn))


def legs_of(motion, off_deg=2.0, rule=RULE):
    """Return the legs of a motion, with a TS off the course and an RS on it."""
    course = motion.course_deg
    return find_legs(motion, motion.stamp_ns, course + off_deg, course, rule)


def test_a_straight_leg_by_hand():
    """At 6 kn a current of 3 kn explains asin(1/2) = 30 deg, and the leeway 10 more."""
    legs = legs_of(straight(350.0, 6.0))
    assert len(legs) == 1 and legs.start_ns == (START_NS,) and legs.duration_s == (179.0,)
    assert (legs.course_deg, legs.speed_kn, legs.bound_deg, legs.ts_deg, legs.rs_deg) == tuple(
        (pytest.approx(each),) for each in (350.0, 6.0, 40.0, 2.0, 0.0))


@pytest.mark.parametrize('speed, bound', [(3.0, 180.0), (3.5, 10.0 + math.degrees(
    math.asin(3.0 / 3.5))), (12.0, 10.0 + math.degrees(math.asin(0.25)))])
def test_a_slow_ship_may_point_anywhere(speed, bound):
    assert legs_of(straight(10.0, speed)).bound_deg == (pytest.approx(bound),)


def test_below_the_least_speed_the_course_says_nothing():
    assert legs_of(straight(10.0, 2.9)) == CourseLegs()


def test_without_current_and_leeway_the_bound_is_zero():
    rule = MotionRule(current_max_kn=0.0, leeway_max_deg=0.0)
    assert legs_of(straight(10.0, 8.0), rule=rule).bound_deg == (0.0,)


def test_the_bound_is_that_of_the_slowest_minute():
    motion = straight(10.0, 12.0, 120) + straight(10.0, 5.0, 60, 120.0)
    legs = legs_of(motion)
    assert legs.speed_kn == (pytest.approx(5.0),) and legs.duration_s == (179.0,)


def test_a_turn_is_no_leg_and_parts_two():
    stamps = START_NS + np.arange(420) * S
    course = np.interp(np.arange(420), [180, 240], [80.0, 170.0])
    motion = Motion.of_courses(stamps, course, np.full(420, 10.0))
    legs = legs_of(motion)
    assert legs.course_deg == (pytest.approx(80.0), pytest.approx(170.0))
    assert legs.duration_s == (179.0, 179.0)


def test_a_silence_parts_two_legs():
    legs = legs_of(straight(80.0, 10.0, 120) + straight(80.0, 10.0, 120, 300.0))
    assert legs.duration_s == (119.0, 119.0)


def test_a_ship_that_bends_slowly_makes_several_legs():
    stamps = START_NS + np.arange(1200) * S
    motion = Motion.of_courses(stamps, np.arange(1200) * 0.05, np.full(1200, 10.0))
    assert len(legs_of(motion)) == 5


def test_courses_without_headings_nearby_do_not_count():
    motion = straight(80.0, 10.0, 240)
    stamps = motion.stamp_ns[:120]
    legs = find_legs(motion, stamps, np.full(120, 80.0), np.full(120, 80.0), RULE)
    assert legs.duration_s == (119.0,)


def test_the_median_is_that_on_the_circle():
    motion = straight(0.0, 10.0)
    off = np.where(np.arange(180) % 3 == 0, -179.0, 179.0)
    legs = find_legs(motion, motion.stamp_ns, off, off, RULE)
    assert legs.ts_deg == (pytest.approx(179.0),)


@pytest.mark.parametrize('seed', range(3))
def test_positions_alone_give_the_same_legs(seed):
    """Over 10 s a noise of 1.4 m turns a way of 50 m by 2 deg; the median by far less."""
    voyage = sail(seed)
    heading = voyage.heading_deg
    by_course = find_legs(voyage.courses, voyage.stamp_ns, heading, heading, RULE)
    by_position = find_legs(voyage.positions, voyage.stamp_ns, heading, heading, RULE)
    assert sum(by_course.duration_s) > 1500.0 and sum(by_position.duration_s) > 1500.0
    for start, ts_deg in zip(by_position.start_ns, by_position.ts_deg):
        at = min(range(len(by_course)), key=lambda k: abs(by_course.start_ns[k] - start))
        assert abs(float(wrap180(ts_deg - by_course.ts_deg[at]))) < 2.0


def test_nearest_stamps():
    found = find_nearest(np.array([10, 20, 30]) * S, np.array([6, 7, 14, 15, 16, 33, 34]) * S)
    assert found.tolist() == [-1, 0, -1, -1, -1, 2, -1]
    assert find_nearest(np.array([10]) * S, np.array([9, 12, 14]) * S).tolist() == [0, 0, -1]
    assert find_nearest(np.array([], np.int64), np.array([9]) * S).tolist() == [-1]


def test_the_largest_arc_crosses_north():
    assert largest_arc_deg([350.0, 20.0, 5.0]) == 30.0
    assert largest_arc_deg([7.0]) == 0.0
