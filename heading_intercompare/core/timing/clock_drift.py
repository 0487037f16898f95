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

"""Whether the clocks of the two sensors drift apart, from the time skew of parts of a run."""

from __future__ import annotations

from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.records import Integers, Reals
from heading_intercompare.core.statistics.blocking import student_95

from .heading_track import Track
from .realignment import move_pairs
from .skew_instrument import common_tracks, HALF_SPAN_S, Instrument, Tracks
from .skew_search import coarsen, find_skew, REACH_S, scatter_deg

_BLOCK_S = 0.25
_MOST_PARTS, _FEWEST_PARTS = 16, 6
_LEAST_PART_S = 60.0
_MOST_SAMPLES = 4096
_LEAST_SAMPLES = 128
_FLOOR_S = 0.005
_RISK = 5e-4
_CLEAR = 0.25
_LEAST_STEP_S, _SURE = 0.1, 6.0
_LEAST_OF_LEVEL = 2
_LEAST_KEPT = 0.6
_MUCH, _BETTER = 4.0, 0.95


@dataclass(frozen=True, slots=True)
class SkewOfPart:
    """
    The time skew of a part of a run.

    Attributes
    ----------
    time_s
        Middle of the part, seconds after the first stamp.
    skew_s, u_s
        Skew and its standard uncertainty, seconds; positive if the TS data are older.
    rate_std_deg_s
        Standard deviation of the common rate of turn, degrees per second.

    """

    time_s: float
    skew_s: float
    u_s: float
    rate_std_deg_s: float


@dataclass(frozen=True, slots=True)
class ClockStep:
    """
    A sudden change of the skew.

    Attributes
    ----------
    time_s
        Time of the step, seconds after the first stamp.
    before_s, after_s
        Skew before and after the step, seconds.

    """

    time_s: float
    before_s: float
    after_s: float


@dataclass(frozen=True, slots=True)
class ClockDrift:
    """
    A line through the time skew of the parts of a run.

    Attributes
    ----------
    kind : {'steady', 'drifting', 'stepped', 'not_testable'}
        'drifting': the slope is not zero, at a risk of 0.05 %. 'stepped': the skew changes
        suddenly between parts in which it is constant. 'not_testable': the ship turned enough in
        fewer than six parts.
    parts
        The parts in which the ship turned enough, in time order.
    skew_s
        Skew of the line in the middle of the run, seconds.
    slope_s_per_h, u_s_per_h
        Slope and its standard uncertainty, which allows for scatter about the line.
    interval_s_per_h : pair of float or None
        95 % interval of the slope.
    variance_deg2
        Variance that the slope adds to the differences, beyond that of a constant skew, square
        degrees: slope^2 Var(time) Var(rate).
    steps
        The steps in time order.

    """

    kind: str
    parts: tuple[SkewOfPart, ...] = ()
    skew_s: float | None = None
    slope_s_per_h: float | None = None
    u_s_per_h: float | None = None
    interval_s_per_h: tuple[float, float] | None = None
    variance_deg2: float | None = None
    steps: tuple[ClockStep, ...] = ()

    def late_s(self, t_s: Reals) -> Reals:
        """Return the lateness of the TS at times after the first stamp, seconds."""
        if self.skew_s is not None and self.slope_s_per_h is not None and not self.steps:
            along_s: Reals = t_s - 0.5 * (t_s[0] + t_s[-1])
            return self.skew_s + self.slope_s_per_h / 3600.0 * along_s
        levels = np.array([self.steps[0].before_s, *(step.after_s for step in self.steps)])
        late_s: Reals = levels[np.searchsorted([step.time_s for step in self.steps], t_s,
                                               side='right')]
        return late_s


def estimate_clock_drift(stamp_ns: ArrayLike, x_deg: ArrayLike, rs_deg: ArrayLike, *,
                         range_s: float = 2.0, max_gap_s: float = 3.0,
                         near_s: float = 0.0, tracks: Tracks | None = None) -> ClockDrift:
    """
    Estimate how the time skew changes within a run.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps of the pairs in increasing order, nanoseconds.
    x_deg, rs_deg : array_like, shape (n,)
        Differences and RS headings, finite, degrees.
    range_s
        Preferred range of the skew, seconds: in the first part about `near_s`, in each other part
        about the line through the previous parts.
    max_gap_s
        Spans with a longer silence are left out, seconds.
    near_s
        The skew of the whole run, if known, seconds. The pairs are moved by one of more than a
        minute.
    tracks : pair of Track, optional
        `common_tracks` of the pairs as they are, if already known.

    Returns
    -------
    ClockDrift

    Notes
    -----
    Applies the instrumental estimate of E.8 to 6 to 16 parts of a minute or more, on averages
    over up to 0.25 s, at most 4096 of them in the middle of a part. The first part starts from
    `near_s`, each other part from the line through the previous ones. So a skew that grows beyond
    half a period of the swell is followed. A skew outside the range, up to 60 s, is accepted if
    the differences scatter clearly less there.

    The clock stepped if two or more parts share one skew, two or more share another that differs
    by more than 0.1 s and 6 standard uncertainties, and levels fit four times better than the
    line. The time of the step minimises the sum of squares between the two levels. The line is
    weighted by the uncertainties, each at least 5 ms, because interpolation moves the estimate by
    that much.

    References
    ----------
    E.22 of ``docs/diagnostics.md``.

    """
    stamps, x, rs = np.asarray(stamp_ns), np.asarray(x_deg), np.asarray(rs_deg)
    if abs(near_s) > REACH_S:
        moved = move_pairs(stamps, x, rs, near_s)
        drift = estimate_clock_drift(*moved, range_s=range_s, max_gap_s=max_gap_s)
        return _move_back(drift, near_s, stamps, moved[0])
    if x.size < _LEAST_SAMPLES or stamps[-1] == stamps[0]:
        return ClockDrift('not_testable')
    ts_track, rs_track = (coarsen(track, _BLOCK_S)
                          for track in tracks or common_tracks(stamps, x, rs))
    span = float(ts_track.t_s[-1] - ts_track.t_s[0])
    count = min(_MOST_PARTS, int(span / _LEAST_PART_S), len(ts_track) // _LEAST_SAMPLES)
    if count < _FEWEST_PARTS:
        return ClockDrift('not_testable')
    edges = np.searchsorted(ts_track.t_s, np.linspace(0.0, span, count + 1) + ts_track.t_s[0])
    parts: list[SkewOfPart] = []
    for lo, hi in zip(edges[:-1].tolist(), edges[1:].tolist()):
        if hi - lo < _LEAST_SAMPLES:
            continue
        middle = (lo + hi) // 2
        lo, hi = max(lo, middle - _MOST_SAMPLES // 2), min(hi, middle + _MOST_SAMPLES // 2)
        part = _cut(ts_track, lo, hi)
        skew = _skew_of(part, rs_track, _extrapolate(parts, float(part.t_s.mean()), near_s),
                        range_s,
                        max_gap_s)
        if skew is not None:
            parts.append(skew)
    if len(parts) < _FEWEST_PARTS:
        return ClockDrift('not_testable', tuple(parts))
    line = _line(parts, float(ts_track.t_s[0]) + 0.5 * span)
    steps = _steps(parts, ts_track, rs_track)
    return replace(line, kind='stepped', steps=steps) if steps else line


def _move_back(drift: ClockDrift, by_s: float, stamps: Integers, moved: Integers) -> ClockDrift:
    """Return the drift of moved pairs as that of the pairs themselves."""
    if not moved.size:
        return drift
    first_s = (int(moved[0]) - int(stamps[0])) / 1e9
    skew_s = None
    if drift.skew_s is not None and drift.slope_s_per_h is not None:
        # From the middle of the moved pairs to that of all.
        later_s = (int(stamps[0]) + int(stamps[-1]) - int(moved[0]) - int(moved[-1])) / 2e9
        skew_s = drift.skew_s + by_s + drift.slope_s_per_h / 3600.0 * later_s
    return replace(
        drift, skew_s=skew_s,
        parts=tuple(replace(part, time_s=part.time_s + first_s, skew_s=part.skew_s + by_s)
                    for part in drift.parts),
        steps=tuple(ClockStep(step.time_s + first_s, step.before_s + by_s, step.after_s + by_s)
                    for step in drift.steps))


def _cut(track: Track, lo: int, hi: int) -> Track:
    """Return a part of a track."""
    return Track.of(track.t_s[lo:hi], track.heading_deg[lo:hi])


def _extrapolate(parts: list[SkewOfPart], at_s: float, near_s: float) -> float:
    """Return the skew at a time, by the line through the last parts."""
    if not parts:
        return near_s
    if len(parts) == 1:
        return parts[0].skew_s
    last = parts[-4:]
    t = np.array([part.time_s for part in last])
    slope = np.polyfit(t - t[-1], [part.skew_s for part in last], 1)
    return float(np.polyval(slope, at_s - t[-1]))


def _skew_of(ts: Track, rs: Track, expected_s: float, range_s: float,
             max_gap_s: float) -> SkewOfPart | None:
    """Return the skew of a part; None if the ship turned too little or nothing converges."""
    instrument = Instrument(ts, rs, HALF_SPAN_S, max_gap_s)
    place = find_skew(instrument, expected_s, range_s)
    if place is None or place[1].u_s > _CLEAR * range_s:
        return None
    d, fit = place
    return SkewOfPart(float(fit.t_s.mean()), d, fit.u_s, fit.rate_std_deg_s)


def _steps(parts: list[SkewOfPart], ts: Track, rs: Track) -> tuple[ClockStep, ...]:
    """Return the sudden changes of the skew; none if a line describes it as well."""
    precise = _MUCH * float(np.median([part.u_s for part in parts]))
    groups: list[list[SkewOfPart]] = []
    for part in parts:
        if part.u_s > max(precise, _FLOOR_S):
            continue
        if groups and not _differ(groups[-1][-1], part):
            groups[-1].append(part)
        else:
            groups.append([part])
    # A part that contains the step shows neither skew, or an uncertain one.
    levels: list[list[SkewOfPart]] = []
    for group in groups:
        if len(group) < _LEAST_OF_LEVEL:
            continue
        if levels and not _differ(levels[-1][-1], group[0]):
            levels[-1] += group
        else:
            levels.append(group)
    on_levels = [part for level in levels for part in level]
    if len(levels) < 2 or len(on_levels) < _LEAST_KEPT * len(parts):
        return ()
    dof = len(on_levels) - len(levels)
    flat = sum(_misfit(level, 0) for level in levels) / dof
    if 4.0 * flat > _misfit(on_levels, 1) / (len(on_levels) - 2):
        return ()
    steps = [_step(before, after, ts, rs) for before, after in zip(levels, levels[1:])]
    # A skew off by a period of the swell fits nearly as well.
    if not all(_is_better(before, step.before_s, step.after_s, ts, rs)
               and _is_better(after, step.after_s, step.before_s, ts, rs)
               for step, before, after in zip(steps, levels, levels[1:])):
        return ()
    return tuple(steps)


def _is_better(level: list[SkewOfPart], skew_s: float, other_s: float, ts: Track,
               rs: Track) -> bool:
    """Tell whether a level scatters clearly less at its own skew than at another."""
    half = 0.5 * _LEAST_PART_S
    inside = (ts.t_s >= level[0].time_s - half) & (ts.t_s <= level[-1].time_s + half)
    t = ts.t_s[inside]
    scatter, other_scatter = (scatter_deg(t, ts.heading_deg[inside] - rs.at(t - d))
                              for d in (skew_s, other_s))
    return scatter < _BETTER * other_scatter


def _differ(first: SkewOfPart, second: SkewOfPart) -> bool:
    """Tell whether the skews of two parts surely differ, by more than a tenth of a second."""
    return abs(first.skew_s - second.skew_s) > max(_LEAST_STEP_S,
                                                   _SURE * math.hypot(first.u_s, second.u_s))


def _misfit(parts: list[SkewOfPart], order: int) -> float:
    """Return the weighted sum of squares of skews about their mean or line."""
    t = np.array([part.time_s for part in parts])
    d = np.array([part.skew_s for part in parts])
    root = 1.0 / np.maximum([part.u_s for part in parts], _FLOOR_S)
    fit = np.polyfit(t - t.mean(), d, order, w=root)
    return float(np.sum((root * (d - np.polyval(fit, t - t.mean()))) ** 2))


def _step(before: list[SkewOfPart], after: list[SkewOfPart], ts: Track, rs: Track) -> ClockStep:
    """Return a step, at the time that minimises the sum of squares of both levels."""
    levels = [float(np.median([part.skew_s for part in side])) for side in (before, after)]
    lo, hi = before[-1].time_s, after[0].time_s
    t = ts.t_s[(ts.t_s >= lo) & (ts.t_s <= hi)]
    at_s = 0.5 * (lo + hi)
    if t.size > 2:
        left, right = (_squares(t, level, ts, rs) for level in levels)
        total = np.concatenate(([0.0], np.cumsum(left))) + np.concatenate(
            (np.cumsum(right[::-1])[::-1], [0.0]))
        at_s = float(t[min(int(np.argmin(total)), t.size - 1)])
    return ClockStep(at_s, *levels)


def _squares(t_s: Reals, skew_s: float, ts: Track, rs: Track) -> Reals:
    """Return the squared differences about their median, with the RS read `skew_s` earlier."""
    x = ts.at(t_s) - rs.at(t_s - skew_s)
    squares: Reals = (x - np.median(ts.at(ts.t_s) - rs.at(ts.t_s - skew_s))) ** 2
    return squares


def _line(parts: list[SkewOfPart], middle_s: float) -> ClockDrift:
    """Return the weighted line through the skews; its level is that in the middle of the run."""
    t = np.array([part.time_s for part in parts]) / 3600.0
    d = np.array([part.skew_s for part in parts])
    u = np.array([part.u_s for part in parts])
    u = np.maximum(u, max(_FLOOR_S, float(np.median(u)) / 3.0))
    w = 1.0 / u ** 2
    t0 = float(w @ t / w.sum())
    power = float(w @ (t - t0) ** 2)
    slope = float(w @ ((t - t0) * d)) / power
    level = float(w @ d / w.sum())
    dof = d.size - 2
    scatter = float(w @ (d - level - slope * (t - t0)) ** 2) / dof
    u_slope = math.sqrt(max(1.0, scatter) / power)
    half = student_95(dof) * u_slope
    drifting = abs(slope) > -float(scipy.special.stdtrit(dof, 0.5 * _RISK)) * u_slope
    rate2 = float(np.mean([part.rate_std_deg_s ** 2 for part in parts]))
    return ClockDrift(kind='drifting' if drifting else 'steady', parts=tuple(parts),
                      skew_s=level + slope * (middle_s / 3600.0 - t0), slope_s_per_h=slope,
                      u_s_per_h=u_slope, interval_s_per_h=(slope - half, slope + half),
                      variance_deg2=slope ** 2 * float(np.var(t)) * rate2)
