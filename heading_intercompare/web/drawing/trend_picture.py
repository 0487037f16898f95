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

"""The trend of the differences as a picture, with the limits where the norm puts them."""

from __future__ import annotations

from html import escape
from typing import Callable, NamedTuple, Sequence

from heading_intercompare.core.utc_text import utc
from heading_intercompare.web.bridge.bridge_records import TrendView
from heading_intercompare.web.figures.trend import TrendColumn

from .markers import DASHES

#: A fault of this size in limits goes beyond the picture, so that what is sound stays readable.
_MOST_LIMITS = 3.0
_LEAST_DEG = 0.02
#: Steps of the clock below the picture, seconds.
_CLOCK_STEPS_S = (60, 120, 300, 600, 1200, 3600, 7200, 14400)
_TICKS = 6
_WIDTH, _HEIGHT = 1000.0, 100.0

#: From degrees or seconds to a place in the picture.
_Scale = Callable[[float], float]


class Stretch(NamedTuple):
    """What part of the trends is shown: its length, seconds, and its ends as shares of that."""

    span_s: float = 1800.0
    from_share: float = 0.0
    to_share: float = 1.0


HALF_AN_HOUR = Stretch()
"""What is shown first."""


def list_columns(trend: TrendView, span_s: float) -> tuple[TrendColumn, ...]:
    """Return the columns of a trend over a length, seconds."""
    return next((columns for longer_s, columns in trend.longer if longer_s == span_s),
                trend.columns)


def draw_trend(trends: Sequence[TrendView], stretch: Stretch = HALF_AN_HOUR,
               named: Sequence[str] = (), numbers: Sequence[int] = ()) -> str:
    """
    Return the trends as HTML: a band for the limits, and for each tested sensor its extremes.

    Parameters
    ----------
    trends
        One per tested sensor. Several are drawn about the centre of each, with the widest limits.
    stretch
        What is shown.
    named
        Sensors that the vote names; their lines are thick.
    numbers
        Which one of all sensors each trend is about, for colour and dash.

    Notes
    -----
    The picture is about the centre of the limits. It holds all differences up to three limits; of
    larger ones an edge says how far they go.

    """
    first = trends[0] if trends else TrendView()
    width_s = stretch.span_s * (stretch.to_share - stretch.from_share)
    left_s = stretch.span_s * (1.0 - stretch.from_share)
    shown = [[column for column in list_columns(trend, stretch.span_s)
              if left_s - width_s <= column.age_s <= left_s] for trend in trends]
    several = len(trends) > 1
    values = [value - trend.center_deg for trend, columns in zip(trends, shown)
              for column in columns for value in (column.low_deg, column.high_deg)]
    most = max([_LEAST_DEG, *map(abs, values)])
    limit_deg = max((trend.limit_deg or 0.0 for trend in trends), default=0.0)
    center_deg = 0.0 if several else first.center_deg
    if limit_deg:
        most = max(1.25 * limit_deg, min(most, _MOST_LIMITS * limit_deg))
    most *= 1.08

    def place(off_deg: float) -> float:
        share = max(-1.0, min(1.0, off_deg / most))
        return _HEIGHT * 0.5 * (1.0 - share)

    def across(age_s: float) -> float:
        return _WIDTH * (left_s - age_s) / width_s

    parts, labels = [], []
    if limit_deg:
        low, high = place(-limit_deg), place(limit_deg)
        parts.append(f'<rect class="band" x="0" width="{_WIDTH:g}" y="{high:.2f}" '
                     f'height="{low - high:.2f}"/>')
        labels += [_label(place(off), center_deg + off) for off in (-limit_deg, limit_deg)]
    parts.append(f'<line class="zero" x1="0" x2="{_WIDTH:g}" y1="50" y2="50"/>')
    labels.append(_label(50.0, center_deg))
    for from_age_s, to_age_s in first.doubtful:
        left, right = across(min(from_age_s, left_s)), across(max(to_age_s, left_s - width_s))
        if right > left:
            parts.append(f'<rect class="doubtful" x="{left:.1f}" width="{right - left:.1f}" '
                         f'y="0" height="{_HEIGHT:g}"/>')
    for number, (trend, columns) in enumerate(zip(trends, shown)):
        which = numbers[number] if number < len(numbers) else number
        classes = f'trace s{which}{" thick" if trend.sensor in named else ""}'
        off = [column._replace(low_deg=column.low_deg - trend.center_deg,
                               high_deg=column.high_deg - trend.center_deg)
               for column in columns]
        dash = 'none' if trend.sensor in named else DASHES[which % len(DASHES)]
        parts.append(_draw_line(off, place, across, classes, dash)
                     if several else _draw_extremes(off, place, across, classes))
    beyond = max(values, key=abs, default=0.0)
    if abs(beyond) > most:
        labels.append(f'<span class="edge {"top" if beyond > 0.0 else "bottom"}">'
                      f'to {center_deg + beyond:+.1f}°</span>')
    words = (f'difference from the reference over {stretch.span_s / 3600.0:g} h' if values else
             'no differences yet')
    return (f'<div class="picture"><svg viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}" '
            f'preserveAspectRatio="none" role="img" aria-label="{escape(words)}">'
            f'{"".join(parts)}</svg>{"".join(labels)}'
            f'{_draw_clock(first.newest_ns, left_s, width_s)}</div>')


def _label(y: float, value: float) -> str:
    return f'<span class="degrees" style="top:{y:.2f}%">{value:+.2f}°</span>'


def _draw_extremes(columns: Sequence[TrendColumn], place: _Scale, across: _Scale,
                   classes: str) -> str:
    """Return the least and greatest difference of each column as a bar."""
    path = []
    for column in columns:
        x, top, bottom = across(column.age_s), place(column.high_deg), place(column.low_deg)
        path.append(f'M{x - 0.9:.1f} {top - 0.6:.2f}h1.8V{bottom + 0.6:.2f}h-1.8z')
    return f'<path class="{classes}" d="{"".join(path)}"/>'


def _draw_line(columns: Sequence[TrendColumn], place: _Scale, across: _Scale, classes: str,
               dash: str) -> str:
    """Return the middle of each column as a line, which a gap breaks."""
    path: list[str] = []
    before_s: float | None = None
    step_s = min((b.age_s - a.age_s for a, b in zip(columns[1:], columns)), default=0.0)
    for column in columns:
        y = place(0.5 * (column.low_deg + column.high_deg))
        near = before_s is not None and before_s - column.age_s < 3.5 * step_s
        path.append(f'{"L" if near else "M"}{across(column.age_s):.1f} {y:.2f}')
        before_s = column.age_s
    return f'<path class="{classes} line" stroke-dasharray="{dash}" d="{"".join(path)}"/>'


def _draw_clock(newest_ns: int | None, left_s: float, width_s: float) -> str:
    """Return the times of day below the picture."""
    if newest_ns is None:
        return ''
    step_s = next((step for step in _CLOCK_STEPS_S if width_s / step <= _TICKS),
                  _CLOCK_STEPS_S[-1])
    begin_s = newest_ns / 1e9 - left_s
    first = int(begin_s // step_s) + 1
    times = []
    for tick in range(first, int((begin_s + width_s) // step_s) + 1):
        share = (tick * step_s - begin_s) / width_s
        if 0.03 < share < 0.97:
            times.append(f'<span class="time" style="left:{100.0 * share:.2f}%">'
                         f'{utc(tick * step_s * 10 ** 9)[11:16]}</span>')
    return ''.join(times)
