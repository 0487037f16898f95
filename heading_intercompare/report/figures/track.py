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

"""The figure of the track: where the ship was in each run, its straight legs, and outliers."""

from __future__ import annotations

import math
from typing import Any, Iterator

import numpy as np

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.records import Motion, Reals
from heading_intercompare.core.verdict.verdict_document import RunVerdict
from heading_intercompare.report.formatting import number

from .drawing import days, Drawing, LeftOut, Subject
from .over_time import find_far, Times

_M_PER_DEG = 111_195.0
#: Lines of the runs, in turn; they differ without colour.
_LINES: tuple[dict[str, Any], ...] = (
    {'color': '#1b4f8a', 'linestyle': '-'}, {'color': '#000000', 'linestyle': (0, (5.0, 2.0))},
    {'color': '#d55e00', 'linestyle': (0, (1.5, 1.5))},
    {'color': '#444444', 'linestyle': (0, (6.0, 2.0, 1.5, 2.0))})
_LEG: dict[str, Any] = {'color': '#c3d3e6', 'linewidth': 6.0, 'solid_capstyle': 'round'}
_ELSEWHERE: dict[str, Any] = {'color': '#767676', 'linewidth': 0.7, 'linestyle': (0, (1.0, 2.5))}
_BAR_SHARE = 0.25
_LEAST = 2


def _round_length(most_m: float) -> float:
    """Return the largest of 1, 2 and 5 times a power of ten that is not above a length."""
    power = 10.0 ** math.floor(math.log10(most_m))
    return power * max(k for k in (1.0, 2.0, 5.0) if k * power <= most_m * (1.0 + 1e-9))


def _length_words(length_m: float) -> str:
    return f'{number(length_m / 1000.0)} km' if length_m >= 1000.0 else f'{number(length_m)} m'


class _Plane:
    """Positions as metres east and north of the first one."""

    def __init__(self, rows: Motion) -> None:
        self._latitude, self._longitude = (float(column[0]) for column in (rows.latitude_deg,
                                                                           rows.longitude_deg))
        self.stamp_ns = rows.stamp_ns
        across = np.cos(np.radians(0.5 * (rows.latitude_deg.min() + rows.latitude_deg.max())))
        self.east = wrap180(rows.longitude_deg - self._longitude) * _M_PER_DEG * across
        self.north = (rows.latitude_deg - self._latitude) * _M_PER_DEG

    @property
    def origin(self) -> str:
        """Return the first position in words."""
        return (f'{abs(self._latitude):.4f} {"N" if self._latitude >= 0.0 else "S"}, '
                f'{abs(self._longitude):.4f} {"E" if self._longitude >= 0.0 else "W"}')

    def between(self, start_ns: int, end_ns: int) -> tuple[Reals, Reals]:
        """Return the positions of a span of time."""
        lo, hi = np.searchsorted(self.stamp_ns, [start_ns, end_ns + 1])
        return self.east[lo:hi], self.north[lo:hi]

    def at(self, t_days: Reals) -> tuple[Reals, Reals]:
        """Return the positions at some times, days since 1970."""
        track_days = days(self.stamp_ns)
        inside = (t_days >= track_days[0]) & (t_days <= track_days[-1])
        return (np.interp(t_days[inside], track_days, self.east),
                np.interp(t_days[inside], track_days, self.north))


def _legs_of(run: RunVerdict) -> Iterator[tuple[int, int]]:
    """Yield start and end of the straight legs of a run, nanoseconds."""
    if run.motion is not None:
        for start_ns, duration_s in zip(run.motion.legs.start_ns, run.motion.legs.duration_s):
            yield start_ns, start_ns + round(duration_s * 1e9)


def draw_track(about: Subject) -> Iterator[Drawing | LeftOut]:
    """Yield the figure of the track, north up and of one scale in both directions."""
    track = about.sketch.track
    title = about.title('track', track.n)
    if not about.settings.motion.compare:
        yield LeftOut('track', title, 'motion.compare is false, so no positions are read')
        return
    if len(track.positions) < _LEAST:
        yield LeftOut('track', title, 'the record has no positions')
        return
    plane = _Plane(track.positions)
    far_days, _ = find_far(about, Times(about))
    outliers = plane.at(np.unique(far_days))
    span = max(float(np.ptp(plane.east)), float(np.ptp(plane.north)), 1.0)
    unit_m, unit = (1000.0, 'km') if span >= 2000.0 else (1.0, 'm')

    def fill(axes: Any) -> None:
        axes.plot(plane.east / unit_m, plane.north / unit_m, **_ELSEWHERE, label='outside runs')
        legs = [plane.between(*leg) for run in about.runs for leg in _legs_of(run)]
        for k, (east, north) in enumerate(legs):
            axes.plot(east / unit_m, north / unit_m, **_LEG,
                      label=None if k else 'straight legs, where heading and course compare')
        for k, run in enumerate(about.runs):
            east, north = plane.between(run.start_ns, run.end_ns)
            if not len(east):
                continue
            axes.plot(east / unit_m, north / unit_m, **_LINES[k % len(_LINES)], linewidth=1.4,
                      label=f'run {run.run}' if k < 2 * len(_LINES) else None)
            axes.annotate(str(run.run), (east[0] / unit_m, north[0] / unit_m), fontsize=7.5,
                          xytext=(4.0, 4.0), textcoords='offset points')
        for at, look, words in ((0, 'o', 'first position'), (-1, 's', 'last position')):
            axes.plot(plane.east[at] / unit_m, plane.north[at] / unit_m, look, color='#000000',
                      markersize=5.0, markerfacecolor='#ffffff', label=words)
        if len(outliers[0]):
            axes.plot(outliers[0] / unit_m, outliers[1] / unit_m, 'x', color='#d55e00',
                      markersize=6.0, markeredgewidth=1.4, label='outlying differences')
        axes.set_aspect('equal', adjustable='datalim')
        _add_scale(axes, _round_length(_BAR_SHARE * span), unit_m)

    yield Drawing(
        name='track', title=title, caption=(
            'North is up, and both directions have one scale. On a broad '
            'band the ship went straight, so its headings are compared with its course; a '
            'cross is where a difference lies far out. Crosses that crowd at one place or '
            'in turns tell of a cause there.'), x_label=f'east of {plane.origin} [{unit}]',
        y_label=f'north of it [{unit}]', fill=fill, height_mm=120.0)


def _add_scale(axes: Any, length_m: float, unit_m: float) -> None:
    """Draw a bar of a round length and an arrow to the north into the lower left corner."""
    from_corner = axes.get_xaxis_transform()
    low, _ = axes.get_xlim()
    start = low + 0.02 * length_m / unit_m
    axes.plot([start, start + length_m / unit_m], [0.04, 0.04], color='#000000', linewidth=2.5,
              solid_capstyle='butt', transform=from_corner)
    axes.text(start, 0.055, _length_words(length_m), fontsize=7.5, transform=from_corner)
    axes.annotate('N', (0.97, 0.97), (0.97, 0.87), xycoords='axes fraction', fontsize=9.0,
                  ha='center', arrowprops={'arrowstyle': '-|>', 'color': '#000000'})
