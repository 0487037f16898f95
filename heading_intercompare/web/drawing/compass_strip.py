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

"""A strip of the compass with a marker for each sensor."""

from __future__ import annotations

from html import escape
import math
from typing import Sequence

from heading_intercompare.core.angles import circular_mean, wrap180
from heading_intercompare.web.bridge.sensors_panel import SensorRow
from heading_intercompare.web.bridge.view_texts import compass_words

from .markers import draw_marker

#: Half the width of the strip and the step of its ticks, degrees; the first that holds all.
_SCALES = ((15.0, 1), (30.0, 2), (60.0, 5), (120.0, 10), (180.0, 15))
#: Share of the half width that the markers may take.
_ROOM = 0.8
#: Names nearer to each other than this share of the width stand on different lines.
_CLEAR = 0.13


def draw_strip(rows: Sequence[SensorRow]) -> str:
    """
    Return the strip as HTML, about the mean heading of the sensors that report.

    Positions are shares of the width, so figures keep their size on every screen. The reference
    stands below the scale, the tested sensors above it. A stale sensor keeps its last place,
    crossed.
    """
    places = [(number, row, heading_deg) for number, row in enumerate(rows)
              if (heading_deg := row.now.last_deg if row.now.heading_deg is None else
                  row.now.heading_deg) is not None]
    if not places:
        return '<p class="strip-empty">no heading is heard yet</p>'
    live = [heading_deg for _, row, heading_deg in places if row.now.heading_deg is not None]
    center_deg = circular_mean(live or [places[0][2]])[0]
    if not math.isfinite(center_deg):
        center_deg = places[0][2]
    reach = max((abs(float(wrap180(heading_deg - center_deg))) for heading_deg in live),
                default=0.0)
    half, step = next(((half, step) for half, step in _SCALES if reach <= _ROOM * half),
                      _SCALES[-1])
    label = ', '.join(f'{row.title} {compass_words(heading_deg)}'
                      f'{" (stale)" if row.now.heading_deg is None else ""}'
                      for _, row, heading_deg in places)
    return (f'<div class="strip" role="img" aria-label="{escape(label)}">'
            f'{_draw_scale(center_deg, half, step)}{_draw_places(places, center_deg, half)}</div>')


def _draw_scale(center_deg: float, half: float, step: int) -> str:
    first, last = math.ceil((center_deg - half) / step), math.floor((center_deg + half) / step)
    parts = []
    for tick in range(first, last + 1):
        at = 50.0 + 50.0 * (tick * step - center_deg) / half
        text = f'<b>{tick * step % 360:03d}</b>' if tick % 5 == 0 else ''
        parts.append(f'<i class="tick{" long" if text else ""}" style="left:{at:.2f}%">{text}</i>')
    return ''.join(parts)


def _draw_places(places: Sequence[tuple[int, SensorRow, float]], center_deg: float,
                 half: float) -> str:
    parts: list[str] = []
    lanes: dict[bool, list[float]] = {True: [], False: []}
    for number, row, heading_deg in sorted(places, key=lambda place: float(
            wrap180(place[2] - center_deg))):
        off = max(-half, min(half, float(wrap180(heading_deg - center_deg))))
        at = 50.0 + 50.0 * off / half
        ends = lanes[row.reference]
        lane = next((lane for lane, end in enumerate(ends) if at - end > 100.0 * _CLEAR),
                    len(ends))
        ends[lane:lane + 1] = [at]
        crossed = row.named or row.now.heading_deg is None
        side = 'below' if row.reference else 'above'
        parts.append(
            f'<span class="place {side} lane{min(lane, 2)}{" left" if at > 85.0 else ""}" '
            f'style="left:{at:.2f}%">{draw_marker(number, row.reference, crossed)}'
            f'<em>{escape(row.title)}</em></span>')
    return ''.join(parts)
