# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Whether the clocks of the two sensors drift apart: the time skew of parts of a run."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import stdtrit

from .alignment import common_tracks, Fit, Instrument, LEAST_STRENGTH
from .blocks import student_95
from .records import Headings
from .track import Track

__all__ = ['clock_drift', 'ClockDrift', 'SkewOfPart']

_HALF_SPAN_S = 0.5
_BLOCK_S = 0.25
_MOST_PARTS, _FEWEST_PARTS = 16, 6
_LEAST_PART_S = 60.0
_MOST_SAMPLES = 4096
_LEAST_SAMPLES = 128
_STEPS = 20
_STARTS = 9
_SETTLED_S = 1e-4
_FLOOR_S = 0.005
_RISK = 5e-4
_CLEAR = 0.25


@dataclass(frozen=True, slots=True)
class SkewOfPart:
    """
    The time skew of a part of a run.

    Attributes
    ----------
    time_s : float
        Middle of the part, seconds after the first stamp.
    skew_s, u_s : float
        Skew and its standard uncertainty, seconds; positive if the TS data are older.
    rate_std_deg_s : float
        Standard deviation of the common rate of turn, degrees a second.

    """

    time_s: float
    skew_s: float
    u_s: float
    rate_std_deg_s: float


@dataclass(frozen=True, slots=True)
class ClockDrift:
    """
    A line through the time skew of the parts of a run.

    Attributes
    ----------
    kind : {'steady', 'drifting', 'not_testable'}
        'drifting': the slope is not zero, at a risk of 0.05 %. 'not_testable': fewer than six
        parts in which the ship turned enough.
    parts : tuple of SkewOfPart
        Those in which it did, in order of time.
    skew_s : float or None
        Of the line, in the middle of the run, seconds.
    slope_s_per_h, u_s_per_h : float or None
        Slope and its standard uncertainty, which allows for scatter about the line.
    interval_s_per_h : pair of float or None
        95 % interval of the slope.
    variance_deg2 : float or None
        What the slope adds to the variance of the differences, beside a constant skew, square
        degrees: slope^2 Var(time) Var(rate).

    """

    kind: str
    parts: tuple[SkewOfPart, ...] = ()
    skew_s: float | None = None
    slope_s_per_h: float | None = None
    u_s_per_h: float | None = None
    interval_s_per_h: tuple[float, float] | None = None
    variance_deg2: float | None = None


def clock_drift(stamp_ns: ArrayLike, x_deg: ArrayLike, rs_deg: ArrayLike, *,
                range_s: float = 2.0, max_gap_s: float = 3.0) -> ClockDrift:
    """
    Estimate how the time skew changes within a run.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps of the pairs in increasing order, nanoseconds.
    x_deg, rs_deg : array_like, shape (n,)
        Differences and RS headings, finite, degrees.
    range_s : float
        Largest skew looked for in the first part, and largest change from one part to the next
        beyond the line through those before, seconds.
    max_gap_s : float
        Spans that hold a longer silence are left out, seconds.

    Returns
    -------
    ClockDrift

    Notes
    -----
    The instrumental estimate of E.8 in 6 to 16 parts of a minute or more, on averages over up
    to 0.25 s, of at most 4096 of them in the middle of a part. The first part takes, of nine
    starts within the range, the one that leaves the least scatter; each other starts from the
    line through the parts before: a skew that grows beyond half a period of the swell is followed.
    The line is weighted by the uncertainties, none taken for less than 5 ms, since interpolation
    moves the estimate by as much.

    References
    ----------
    E.22 of ``docs/diagnostics.md``.

    """
    stamps, x, rs = np.asarray(stamp_ns), np.asarray(x_deg), np.asarray(rs_deg)
    if x.size < _LEAST_SAMPLES or stamps[-1] == stamps[0]:
        return ClockDrift('not_testable')
    ts_track, rs_track = common_tracks(stamps, x, rs, _BLOCK_S)
    span = float(ts_track.t_s[-1] - ts_track.t_s[0])
    count = min(_MOST_PARTS, int(span / _LEAST_PART_S), len(ts_track) // _LEAST_SAMPLES)
    if count < _FEWEST_PARTS:
        return ClockDrift('not_testable')
    edges = np.searchsorted(ts_track.t_s, np.linspace(0.0, span, count + 1) + ts_track.t_s[0])
    found: list[SkewOfPart] = []
    for lo, hi in zip(edges[:-1].tolist(), edges[1:].tolist()):
        if hi - lo < _LEAST_SAMPLES:
            continue
        middle = (lo + hi) // 2
        lo, hi = max(lo, middle - _MOST_SAMPLES // 2), min(hi, middle + _MOST_SAMPLES // 2)
        part = _cut(ts_track, lo, hi)
        one = _skew_of(part, rs_track, _expected(found, float(part.t_s.mean())), range_s,
                       max_gap_s)
        if one is not None:
            found.append(one)
    if len(found) < _FEWEST_PARTS:
        return ClockDrift('not_testable', tuple(found))
    return _line(found, float(ts_track.t_s[0]) + 0.5 * span)


def _cut(track: Track, lo: int, hi: int) -> Track:
    """Return a part of a track."""
    part = Track(Headings.empty())
    part.t_s, part.heading_deg = track.t_s[lo:hi], track.heading_deg[lo:hi]
    return part


def _expected(found: list[SkewOfPart], at_s: float) -> float | None:
    """Return the skew that the line through the last parts gives at a time; None without any."""
    if not found:
        return None
    if len(found) == 1:
        return found[0].skew_s
    last = found[-4:]
    t = np.array([one.time_s for one in last])
    slope = np.polyfit(t - t[-1], [one.skew_s for one in last], 1)
    return float(np.polyval(slope, at_s - t[-1]))


def _skew_of(ts: Track, rs: Track, expected_s: float | None, range_s: float,
             max_gap_s: float) -> SkewOfPart | None:
    """Return the skew of a part; None if the ship did not turn enough or nothing settles."""
    instrument = Instrument(ts, rs, _HALF_SPAN_S, max_gap_s)
    starts = [expected_s] if expected_s is not None else np.linspace(-range_s, range_s, _STARTS)
    # In a swell the estimate settles from within a quarter of a period, and elsewhere too.
    settled = [one for start in starts
               if (one := _settle(instrument, float(start), range_s)) is not None]
    if not settled:
        return None
    d, found = min(settled, key=lambda one: float(one[1].x.std()))
    if found.u_s > _CLEAR * range_s:
        return None
    return SkewOfPart(float(found.t_s.mean()), d, found.u_s, found.rate_std_deg_s)


def _settle(instrument: Instrument, start_s: float, range_s: float) -> tuple[float, Fit] | None:
    """Return the skew at which nothing is left, from a start; None if there is none near it."""
    d = start_s
    for _ in range(_STEPS):
        found = instrument(d)
        if found is None or not found.strength >= LEAST_STRENGTH or abs(d - start_s) > range_s:
            return None
        if abs(found.step_s) < _SETTLED_S:
            return d + found.step_s, found
        d += found.step_s
    return None


def _line(found: list[SkewOfPart], middle_s: float) -> ClockDrift:
    """Return the weighted line through the skews; its level is in the middle of the run."""
    t = np.array([one.time_s for one in found]) / 3600.0
    d = np.array([one.skew_s for one in found])
    u = np.array([one.u_s for one in found])
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
    drifting = abs(slope) > -float(stdtrit(dof, 0.5 * _RISK)) * u_slope
    rate2 = float(np.mean([one.rate_std_deg_s ** 2 for one in found]))
    return ClockDrift('drifting' if drifting else 'steady', tuple(found),
                      level + slope * (middle_s / 3600.0 - t0), slope, u_slope,
                      (slope - half, slope + half), slope ** 2 * float(np.var(t)) * rate2)
