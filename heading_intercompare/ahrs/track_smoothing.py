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

"""A recorded voyage made smooth, so that rates and accelerations can be taken from it."""

from __future__ import annotations

from dataclasses import dataclass, field
import math

import numpy as np

from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.motion.smoothing import bridge_gaps, find_spikes, fit_smooth, Smooth
from heading_intercompare.core.motion.tangent_plane import steps_m
from heading_intercompare.core.records import Attitude, Headings, Integers, Motion, Reals

from .settings import TrackSettings
from .ship.earth import KNOT_M_S
from .ship.track_course import Track, TrackCourse

#: A sample is no spike unless it is further than this from its neighbours, by unit.
_LEAST = {'deg': 2.0, 'm/s': 1.0}
_MOST_SPIKES = 0.1
_SAMPLES_A_PERIOD = 4.0
_SHORTEST_S = 10.0


@dataclass(frozen=True, slots=True)
class TrackRecord:
    """
    What was recorded of a voyage.

    Attributes
    ----------
    headings
        Of the sensor whose heading counts as the true one.
    motion
        Positions and velocities; may be empty.
    attitude
        Roll and pitch; may be empty.

    """

    headings: Headings
    motion: Motion = field(default_factory=Motion.empty)
    attitude: Attitude = field(default_factory=Attitude.empty)


@dataclass(frozen=True, slots=True)
class Smoothed:
    """
    How the samples of one quantity were treated.

    Attributes
    ----------
    what, unit
        The quantity.
    n
        Samples used.
    repeated, spikes
        Samples left out: with the stamp of another, or far from their neighbours.
    gaps
        Steps that were bridged.
    longest_gap_s
        The longest of them.
    period_s
        An oscillation of this period was halved, faster ones were removed.
    removed
        Standard deviation of the samples about the smooth function.

    """

    what: str
    unit: str
    n: int
    repeated: int
    spikes: int
    gaps: int
    longest_gap_s: float
    period_s: float
    removed: float

    @property
    def words(self) -> str:
        """Return the account in one line."""
        lacking = ', '.join(text for n, text in (
            (self.repeated, f'{self.repeated} with the stamp of another'),
            (self.spikes, f'{self.spikes} outliers')) if n)
        gaps = (f'; {self.gaps} gaps bridged, the longest {self.longest_gap_s:.1f} s'
                if self.gaps else '')
        return (f'{self.what}: {self.n} samples'
                + (f', left out {lacking}' if lacking else '') + gaps
                + f'; smoothed over {self.period_s:.3g} s, which removed {self.removed:.2g} '
                f'{self.unit} rms')


@dataclass(frozen=True, slots=True)
class SmoothTrack:
    """A track, and an account of how it was made."""

    track: Track
    accounts: tuple[Smoothed, ...]
    remarks: tuple[str, ...] = ()

    @property
    def words(self) -> tuple[str, ...]:
        """Return what a reader should know, a line each."""
        return (*(account.words for account in self.accounts), *self.remarks)


def fit_track(record: TrackRecord, settings: TrackSettings) -> SmoothTrack:
    """
    Return the voyage as smooth functions of time.

    Parameters
    ----------
    record
        In any order; headings that are nan are left out.
    settings
        How to smooth, and where to begin.

    Raises
    ------
    SettingsError
        If the record is too short, has a gap that is too long, or is full of outliers.

    Notes
    -----
    The velocity is the recorded one, otherwise that between recorded positions, otherwise the
    speed set, along the heading. Outliers are samples further than six standard deviations, and
    further than 2 degrees or 1 m/s, from the median of the nine samples around them. Each
    quantity then becomes a quintic spline, see `core.motion.smoothing`.

    """
    headings = record.headings[np.isfinite(record.headings.heading_deg)]
    if not len(headings):
        raise SettingsError('track.file: has no heading')
    start_ns = int(headings.stamp_ns.min()) + round(settings.begin_s * 1e9)
    duration_s = (int(headings.stamp_ns.max()) - start_ns) / 1e9
    if duration_s < _SHORTEST_S:
        raise SettingsError(f'track.begin_s = {settings.begin_s!r}: leaves {duration_s:.1f} s of '
                            f'the headings; must leave at least {_SHORTEST_S:g} s')
    make = _Maker(start_ns, duration_s, settings.longest_gap_s)
    heading = make.smooth('heading', 'deg', headings.stamp_ns, headings.heading_deg,
                          settings.heading_smooth_s, turns=True)
    remarks: list[str] = []
    east, north = _find_velocity(make, record.motion, heading, settings, remarks)
    rolls: list[Smooth] = []
    if len(record.attitude):
        rows = record.attitude
        rolls = [_scale(make.smooth(what, 'deg', rows.stamp_ns, angle,
                                    settings.heading_smooth_s), math.pi / 180.0)
                 for what, angle in (('roll', rows.roll_deg), ('pitch', rows.pitch_deg))]
    fixes = make.within(record.motion.positions())
    first = (None if not len(fixes) else
             (float(fixes.latitude_deg[0]), float(fixes.longitude_deg[0])))
    track = Track(start_ns, duration_s, _scale(heading, math.pi / 180.0), east, north, first,
                  *rolls)
    if first is not None:
        remarks.append(_compare(TrackCourse(track, *first), fixes, start_ns))
    return SmoothTrack(track, tuple(make.accounts), tuple(remarks))


class _Maker:
    """Smooths the samples of one voyage, and keeps the accounts."""

    def __init__(self, start_ns: int, duration_s: float, longest_gap_s: float) -> None:
        self._start_ns, self._duration_s = start_ns, duration_s
        self._longest_gap_s = longest_gap_s
        self.accounts: list[Smoothed] = []

    @property
    def duration_s(self) -> float:
        """Length of the voyage, seconds."""
        return self._duration_s

    def within(self, rows: Motion) -> Motion:
        """Return the rows of the voyage in stamp order."""
        rows = rows.in_order()
        t_s = (rows.stamp_ns - self._start_ns) / 1e9
        return rows[(t_s >= 0.0) & (t_s <= self._duration_s)]

    def smooth(self, what: str, unit: str, stamp_ns: Integers, values: Reals, period_s: float,
               turns: bool = False) -> Smooth:
        """Return a smooth function of the seconds of the voyage."""
        order = np.argsort(stamp_ns, kind='stable')
        t_s, values = (stamp_ns[order] - self._start_ns) / 1e9, values[order]
        inside = (t_s >= 0.0) & (t_s <= self._duration_s)
        t_s, values = t_s[inside], values[inside]
        single = np.diff(t_s, prepend=-math.inf) > 0.0
        repeated = int(np.count_nonzero(~single))
        t_s, values = t_s[single], values[single]
        if turns:
            values = np.unwrap(values, period=360.0)
        spikes = find_spikes(values, _LEAST[unit])
        if spikes.sum() > _MOST_SPIKES * spikes.size:
            raise SettingsError(f'track: {int(spikes.sum())} of {spikes.size} samples of {what} '
                                f'are outliers; must be at most {_MOST_SPIKES:.0%}: give the '
                                'samples of one sensor')
        t_s, values = t_s[~spikes], values[~spikes]
        if turns:
            # A spike may have led to a wrong turn.
            values = np.unwrap(values, period=360.0)
        if t_s.size < 2:
            raise SettingsError(f'track: has {t_s.size} samples of {what} within the time of the '
                                'headings; must have at least 2')
        period_s = max(period_s, _SAMPLES_A_PERIOD * float(np.median(np.diff(t_s))))
        gaps = np.diff(np.concatenate(([0.0], t_s, [self._duration_s])))
        gaps = gaps[gaps > period_s]
        longest_s = float(gaps.max(initial=0.0))
        if longest_s > self._longest_gap_s:
            raise SettingsError(
                f'track.longest_gap_s = {self._longest_gap_s!r}: the record has no {what} for '
                f'{longest_s:.1f} s; begin after the gap with track.begin_s, or raise it')
        full_s, full = bridge_gaps(*_reach_ends(t_s, values, self._duration_s), period_s)
        smooth = fit_smooth(full_s, full, period_s)
        removed = float(np.std(values - smooth.read(t_s)))
        self.accounts.append(Smoothed(what=what, unit=unit, n=t_s.size, repeated=repeated,
                                      spikes=int(spikes.sum()), gaps=gaps.size,
                                      longest_gap_s=longest_s, period_s=period_s, removed=removed))
        return smooth


def _reach_ends(t_s: Reals, values: Reals, duration_s: float) -> tuple[Reals, Reals]:
    """Return the samples, with the first and the last repeated at the ends of the voyage."""
    before, after = int(t_s[0] > 0.0), int(t_s[-1] < duration_s)
    return (np.concatenate(([0.0][:before], t_s, [duration_s][:after])),
            np.concatenate((values[:1][:before], values, values[-1:][:after])))


def _find_velocity(make: _Maker, motion: Motion, heading: Smooth, settings: TrackSettings,
                   remarks: list[str]) -> tuple[Smooth, Smooth]:
    """Return the velocity over ground to the east and the north, and say where it is from."""
    period_s = settings.speed_smooth_s
    rows, fixes = make.within(motion.velocities()), make.within(motion.positions())
    if len(rows) > 1:
        stamps, east, north = rows.stamp_ns, rows.east_m_s, rows.north_m_s
    elif len(fixes) > 1:
        single = np.diff(fixes.stamp_ns, prepend=-1) > 0
        fixes = fixes[single]
        to = steps_m((fixes.latitude_deg[:-1], fixes.longitude_deg[:-1]),
                     (fixes.latitude_deg[1:], fixes.longitude_deg[1:]))
        steps_s = np.diff(fixes.stamp_ns) / 1e9
        stamps = fixes.stamp_ns[:-1] + np.diff(fixes.stamp_ns) // 2
        east, north = (way / steps_s for way in to)
        remarks.append('the velocity is that between the positions')
    else:
        speed_m_s = settings.speed_kn * KNOT_M_S
        t_s = np.arange(0.0, make.duration_s + 1.0)
        angle = np.radians(heading.read(t_s))
        remarks.append(f'no velocity and no positions: {settings.speed_kn:g} kn along the '
                       f'heading, smoothed over {period_s:g} s')
        return (fit_smooth(t_s, speed_m_s * np.sin(angle), period_s),
                fit_smooth(t_s, speed_m_s * np.cos(angle), period_s))
    return (make.smooth('velocity to the east', 'm/s', stamps, east, period_s),
            make.smooth('velocity to the north', 'm/s', stamps, north, period_s))


def _scale(function: Smooth, factor: float) -> Smooth:
    return Smooth(function.start_s, function.step_s, factor * function.pieces)


def _compare(course: TrackCourse, fixes: Motion, start_ns: int) -> str:
    """Return how far the integrated velocity leads away from the recorded positions."""
    position = course.read_position((fixes.stamp_ns - start_ns) / 1e9)
    away = steps_m(position, (fixes.latitude_deg, fixes.longitude_deg))
    farthest_m = float(np.max(np.hypot(*away)))
    return f'position: the integral of the velocity stays within {farthest_m:.0f} m of the fixes'
