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

"""Whether the headings of a run contradict the motion of the ship, and what is wrong if so."""

from __future__ import annotations

from dataclasses import dataclass, replace
import math
from typing import Mapping, NamedTuple, Sequence

import numpy as np

from heading_intercompare.core.angles import wrap180, wrap360
from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.records import Integers, Motion, MOTION_COLUMNS, Reals
from heading_intercompare.core.settings import MotionRule

from .course_legs import (
    CourseLegs,
    find_legs,
    largest_arc_deg,
    LEAST_VELOCITIES,
    MOST_LEGS,
)
from .turn_rate import compare_turns, TurnRate

LEAST_AGAINST_S = 90.0
"""A heading contradicts the course only if it does so for at least this time, seconds."""

TURNED_DEG = 30.0
"""From this angle between two legs on, a frozen or mirrored heading shows; degrees."""

STILL_DEG = 2.0
"""A heading that changes by less than this between such legs is frozen; degrees."""

ASTERN_DEG = 15.0
"""Two headings that agree within this, and point against the course, mean a ship going astern."""

_SCALED_ALIKE = 0.2
_SURE, _DOUBT, _NONE = 2, 1, 0
_PATTERNS = ('frozen', 'mirrored')
_FAULTY = ('against', 'scaled', 'astray')


class WrongLeg(NamedTuple):
    """A straight leg on which a heading points off the course: its ends, and by how much."""

    start_ns: int
    end_ns: int
    off_deg: float


_KINDS = {'agrees': 'nothing contradicts', 'doubt': 'may be wrong', 'contradicts': 'wrong',
          'not_testable': 'not testable'}
_SENSORS = {'ts': 'TS', 'rs': 'RS', 'both': 'TS and RS'}
_COURSE_KINDS = {
    'agrees': 'nothing contradicts', 'off': 'points off the course',
    'mirrored': 'turns against the course', 'frozen': 'stays while the course changes',
    'astray': 'does not follow', 'not_testable': 'not testable'}


@dataclass(frozen=True, slots=True)
class SensorMotion:
    """One heading against the motion of the ship; keys of the JSON."""

    kind: str = figure('against the course', choices=_COURSE_KINDS, default='not_testable')
    off_deg: float | None = figure('mean angle off the course', 'heading − course over the legs; '
                                   'heading + course if mirrored', default=None)
    largest_deg: float | None = figure('largest angle off the course of a leg', default=None)
    against_s: float = figure('time of the legs with an angle beyond the bound', default=0.0)
    turns: TurnRate | None = figure('heading against the rate of turn', absent='if there is none')


@dataclass(frozen=True, slots=True)
class MotionCheck:
    """The headings of a run against the motion of the ship; keys of the JSON."""

    kind: str = figure('conclusion', choices=_KINDS)
    whose: str = figure('sensor that is wrong', 'empty for none', choices=_SENSORS)
    n_positions: int = figure('positions in the run')
    n_velocities: int = figure('velocities in the run')
    n_rates: int = figure('rates of turn in the run')
    n_legs: int = figure('straight legs')
    legs_s: float = figure('their time')
    astern_s: float = figure('part of it on which the ship seems to go astern')
    least_bound_deg: float | None = figure('least angle off the course that shows')
    ts: SensorMotion = figure('heading of the TS against the motion', prefix='TS: ')
    rs: SensorMotion = figure('heading of the RS against the motion', prefix='RS: ')
    legs: CourseLegs = figure('longest 64 legs in order of time', 'lists of equal length')

    def find_wrong_legs(self, sensor: str) -> list[WrongLeg]:
        """Return the legs in which ``'ts'`` or ``'rs'`` alone points off the course."""
        legs = self.legs
        wrong, sound = (legs.ts_deg, legs.rs_deg) if sensor == 'ts' else (legs.rs_deg, legs.ts_deg)
        return [WrongLeg(start_ns, start_ns + round(duration_s * 1e9), off_deg)
                for start_ns, duration_s, bound_deg, off_deg, other_deg in zip(
                    legs.start_ns, legs.duration_s, legs.bound_deg, wrong, sound)
                if abs(off_deg) > bound_deg >= abs(other_deg)]


def check_motion(motion: Mapping[str, Motion], stamp_ns: Integers, ts_deg: Reals, rs_deg: Reals,
                 rule: MotionRule) -> MotionCheck:
    """
    Compare both headings of a run with the motion of the ship.

    Parameters
    ----------
    motion
        By what it tells, in any order; rows outside the pairs do not count.
    stamp_ns : ndarray of int64, shape (n,)
        Stamps of the pairs in increasing order, nanoseconds; n >= 0.
    ts_deg, rs_deg : ndarray, shape (n,)
        Headings, finite, the installation offset removed from the TS; degrees.
    rule
        What counts as underway, and the limits of the check.

    Returns
    -------
    MotionCheck

    Notes
    -----
    Leeway and current turn the course off the heading by amounts that nobody knows. So the
    check sees gross errors only, and agreement proves nothing.

    """
    positions, velocities, rates = (
        _within(motion.get(what, Motion.empty()), stamp_ns) for what in MOTION_COLUMNS)
    legs = find_legs(velocities if len(velocities) >= LEAST_VELOCITIES else positions,
                     stamp_ns, ts_deg, rs_deg, rule)
    turns = [compare_turns(rates, stamp_ns, heading) if len(rates) else None
             for heading in (ts_deg, rs_deg)]
    ahead = np.zeros(len(legs), bool)
    ts, rs = _against_courses(legs, ahead, turns)
    astern, is_unsure = _find_astern(legs), False
    if astern.any():
        with_astern = _against_courses(legs, astern, turns)
        explains = all(sensor.kind in ('agrees', 'not_testable') for sensor in with_astern)
        if not {ts.kind, rs.kind}.isdisjoint(_PATTERNS) and not (explains and _follow(turns)):
            # A mirrored heading also points astern on some legs, but hardly on all others ahead.
            astern, is_unsure = ahead, explains
        else:
            ts, rs = with_astern
    duration = np.asarray(legs.duration_s, np.float64)
    longest = np.sort(np.argsort(-duration, kind='stable')[:MOST_LEGS])
    check = MotionCheck(
        kind='not_testable', whose='', n_positions=len(positions),
        n_velocities=len(velocities), n_rates=len(rates), n_legs=len(legs),
        legs_s=float(duration.sum()), astern_s=float(duration[astern].sum()),
        least_bound_deg=min(legs.bound_deg, default=None), ts=ts, rs=rs,
        legs=legs.pick(longest.tolist()))
    return _conclude(check, _tested_s(legs, astern), largest_arc_deg(legs.course_deg), is_unsure)


def _within(motion: Motion, stamp_ns: Integers) -> Motion:
    """Return the rows from the first to the last pair, in stamp order."""
    rows = motion.in_order()
    return rows[slice(*np.searchsorted(rows.stamp_ns, (stamp_ns[0], stamp_ns[-1] + 1)).tolist()
                      if len(stamp_ns) else (0, 0))]


def _follow(turns: Sequence[TurnRate | None]) -> bool:
    """Tell whether all headings turn with the rate of turn, so that none can be mirrored."""
    return all(turn is not None and turn.kind == 'follows' for turn in turns)


def _find_astern(legs: CourseLegs) -> np.ndarray:
    """Tell of each leg whether the ship seems to go astern, although mostly it goes ahead."""
    ts, rs = (np.asarray(column, np.float64) for column in (legs.ts_deg, legs.rs_deg))
    bound, duration = (np.asarray(column, np.float64) for column in (legs.bound_deg,
                                                                     legs.duration_s))
    back = ((np.abs(wrap180(ts - 180.0)) <= bound) & (np.abs(wrap180(rs - 180.0)) <= bound)
            & (np.abs(wrap180(ts - rs)) <= ASTERN_DEG)
            & (np.abs(ts) > bound) & (np.abs(rs) > bound))
    return back if duration[back].sum() < 0.5 * duration.sum() else np.zeros(len(legs), bool)


def _against_courses(legs: CourseLegs, astern: np.ndarray,
                     turns: Sequence[TurnRate | None]) -> tuple[SensorMotion, SensorMotion]:
    return (_against_course(legs, np.asarray(legs.ts_deg, np.float64), astern, turns[0]),
            _against_course(legs, np.asarray(legs.rs_deg, np.float64), astern, turns[1]))


def _against_course(legs: CourseLegs, off: Reals, astern: np.ndarray,
                    turns: TurnRate | None) -> SensorMotion:
    """Judge one heading by its angles off the course, leg by leg."""
    bound, duration = (np.asarray(column, np.float64)[~astern]
                       for column in (legs.bound_deg, legs.duration_s))
    course = np.asarray(legs.course_deg, np.float64)[~astern]
    off = off[~astern]
    shows = bound < 180.0
    if not shows.any():
        return SensorMotion(turns=turns)
    bound, duration, course, off = (column[shows] for column in (bound, duration, course, off))
    wrong = np.abs(off) > bound
    against_s = float(duration[wrong].sum())
    mean = _mean_deg(off, duration)
    largest = float(off[np.argmax(np.abs(off))])
    heading = wrap360(course + off)
    kind = 'agrees'
    if wrong.any():
        spread = np.abs(wrap180(off - mean))
        total = wrap180(course + heading)
        sum_deg = _mean_deg(total, duration)
        turned = largest_arc_deg(course.tolist())
        if turned >= TURNED_DEG and largest_arc_deg(heading.tolist()) <= STILL_DEG:
            kind = 'frozen'
        elif turned >= TURNED_DEG and bool(
                np.all(np.abs(wrap180(total - sum_deg)) <= bound)) and bool(
                np.any(spread > bound)):
            kind, mean = 'mirrored', sum_deg
        elif bool(np.all(spread <= bound)):
            kind = 'off'
        else:
            kind = 'astray'
    return SensorMotion(kind, mean, largest, against_s, turns)


def _mean_deg(angle_deg: Reals, weight: Reals) -> float:
    """Return the weighted mean direction, degrees."""
    angle = np.radians(angle_deg)
    return math.degrees(math.atan2(float(weight @ np.sin(angle)), float(weight @ np.cos(angle))))


def _tested_s(legs: CourseLegs, astern: np.ndarray) -> float:
    """Return the time of the legs that can show an error, seconds."""
    bound, duration = (np.asarray(column, np.float64) for column in (legs.bound_deg,
                                                                     legs.duration_s))
    return float(duration[(bound < 180.0) & ~astern].sum())


def _conclude(check: MotionCheck, tested_s: float, arc_deg: float,
              is_unsure: bool) -> MotionCheck:
    """Return the check with its conclusion; if unsure, a ship going astern explains it, too."""
    sensors = {'ts': check.ts, 'rs': check.rs}
    grades = {name: min(_grade_course(sensor, tested_s), _DOUBT if is_unsure else _SURE)
              for name, sensor in sensors.items()}
    for name, grade in _grade_turns(sensors, arc_deg).items():
        grades[name] = max(grades[name], grade)
    worst = max(grades.values())
    if worst == _NONE:
        tested = any(sensor.kind != 'not_testable' or (
            sensor.turns is not None and sensor.turns.kind != 'not_testable')
            for sensor in sensors.values())
        return replace(check, kind='agrees' if tested else 'not_testable')
    whose = [name for name, grade in grades.items() if grade == worst]
    return replace(check, kind='contradicts' if worst == _SURE else 'doubt',
                   whose=whose[0] if len(whose) == 1 else 'both')


def _grade_course(sensor: SensorMotion, tested_s: float) -> int:
    if sensor.against_s < LEAST_AGAINST_S:
        return _NONE
    if sensor.kind in _PATTERNS:
        # All legs fit, also those on which such a heading happens to lie near the course.
        return _SURE
    return _SURE if sensor.against_s >= 0.5 * tested_s else _DOUBT


def _grade_turns(sensors: Mapping[str, SensorMotion], arc_deg: float) -> dict[str, int]:
    """Grade the turns; a rate of turn that neither sensor follows may itself be wrong."""
    turns = {name: sensor.turns for name, sensor in sensors.items() if sensor.turns is not None}
    wrong = [name for name, turn in turns.items() if turn.kind in _FAULTY]
    if any(turn.kind == 'follows' for turn in turns.values()):
        return dict.fromkeys(wrong, _SURE)
    if len(wrong) == 2 and is_scaled_alike(*turns.values()):
        return {}
    # One that follows the course through a turn is sound.
    return {name: _DOUBT for name in wrong
            if sensors[name].kind != 'agrees' or arc_deg < TURNED_DEG}


def is_scaled_alike(ts: TurnRate, rs: TurnRate) -> bool:
    """Tell whether both headings turn with the rate by one factor, as if of other units."""
    if not ts.kind == rs.kind == 'scaled' or ts.slope is None or rs.slope is None:
        return False
    return abs(ts.slope - rs.slope) <= _SCALED_ALIKE * max(ts.slope, rs.slope)
