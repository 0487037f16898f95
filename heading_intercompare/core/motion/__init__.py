# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
The motion of the ship against its headings: course over ground and rate of turn.

It names gross errors that the difference of two headings cannot show. It never certifies.
"""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'antennas': ('BaselineHeadings', 'find_baseline_headings'),
    'course_legs': ('CourseLegs', 'find_legs'),
    'motion_check': ('check_motion', 'MotionCheck', 'SensorMotion'),
    'motion_record': ('find_newest', 'leave_out_known', 'MotionRecord', 'RunMotion'),
    'motion_words': ('describe_motion', 'explain_motion'),
    'smoothing': ('Smooth', 'smooth'),
    'tangent_plane': ('radii_m', 'steps_m'),
    'turn_rate': ('compare_turns', 'TurnRate'),
})
if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .antennas import (
        BaselineHeadings as BaselineHeadings,
        find_baseline_headings as find_baseline_headings,
    )
    from .course_legs import CourseLegs as CourseLegs, find_legs as find_legs
    from .motion_check import (
        check_motion as check_motion,
        MotionCheck as MotionCheck,
        SensorMotion as SensorMotion,
    )
    from .motion_record import (
        find_newest as find_newest,
        leave_out_known as leave_out_known,
        MotionRecord as MotionRecord,
        RunMotion as RunMotion,
    )
    from .motion_words import describe_motion as describe_motion, explain_motion as explain_motion
    from .smoothing import Smooth as Smooth, smooth as smooth
    from .tangent_plane import radii_m as radii_m, steps_m as steps_m
    from .turn_rate import compare_turns as compare_turns, TurnRate as TurnRate
