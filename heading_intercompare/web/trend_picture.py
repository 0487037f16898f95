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

"""The trend as a picture: SVG that takes its colours from the palette of the page."""

from __future__ import annotations

from heading_intercompare.web.bridge.bridge_records import TrendView

__all__ = ['draw_trend']

_WIDTH, _HEIGHT, _LEFT, _RIGHT, _TOP, _BOTTOM = 800, 180, 66, 8, 8, 22


def draw_trend(trend: TrendView) -> str:
    """
    Return the trend as SVG: the extremes per column, the limits dashed, zero as a line.

    The picture is wide enough for the data and the limits, so neither is ever cut off.
    """
    reach = [0.02] + [abs(value) for column in trend.columns
                      for value in (column.low_deg, column.high_deg)]
    limits: tuple[float, ...] = ()
    if trend.limit_deg is not None:
        limits = (trend.center_deg - trend.limit_deg, trend.center_deg + trend.limit_deg)
        reach += [abs(limit) for limit in limits]
    most = 1.1 * max(reach)

    def place(x_deg: float) -> float:
        return _TOP + (_HEIGHT - _TOP - _BOTTOM) * (most - x_deg) / (2.0 * most)

    right = _WIDTH - _RIGHT
    scale = (right - _LEFT) / trend.span_s
    parts = [f'<svg viewBox="0 0 {_WIDTH} {_HEIGHT}" width="100%" role="img" '
             'aria-label="difference TS - RS of the last 30 min">']
    for kind, values in (('zero', (0.0,)), ('limit', limits)):
        parts += [f'<line class="{kind}" x1="{_LEFT}" x2="{right}" y1="{place(value):.1f}" '
                  f'y2="{place(value):.1f}"/>' for value in values]
    parts += [f'<text class="mark" x="{_LEFT - 6}" y="{place(value) + 5:.1f}" text-anchor="end">'
              f'{f"{value:+.2f}" if value else "0"}°</text>' for value in (*limits, 0.0)]
    for minutes in range(0, round(trend.span_s / 60.0) + 1, 10):
        at = right - scale * 60.0 * minutes
        parts.append(f'<text class="mark" x="{at:.1f}" y="{_HEIGHT - 6}" text-anchor="'
                     f'{"end" if minutes == 0 else "middle"}">{-minutes} min</text>')
    columns = []
    for column in trend.columns:
        x, top, bottom = (right - scale * column.age_s, place(column.high_deg),
                          place(column.low_deg))
        columns.append(f'M{x - 0.8:.1f} {top - 0.8:.1f}h1.6V{bottom + 0.8:.1f}h-1.6z')
    parts.append(f'<path class="trace" d="{"".join(columns)}"/></svg>')
    return ''.join(parts)
