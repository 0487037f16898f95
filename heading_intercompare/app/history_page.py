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

"""A page with the charts of histories, in one HTML file."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Any, Sequence

from heading_intercompare.core.utc_text import utc
from heading_intercompare.logbook.history import History, Point

_DAY_NS = 86_400_000_000_000
_MARKERS, _DASHES = 'osv^D', ('-', '--', ':', '-.')
_NAMES = {'mean': 'mean difference', 'sd': 'standard deviation'}
_HEAD = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Heading sensors over time</title>
<style>body { font: 16px/1.5 Helvetica, Arial, sans-serif; max-width: 60em; margin: 2em auto;
padding: 0 1em } svg { width: 100%; height: auto }</style></head><body>
<h1>Heading sensors over time</h1>
"""


def write_page(histories: Sequence[History], path: str, since_ns: int | None = None) -> None:
    """
    Write the charts of mean and standard deviation, with their limits.

    A ship with several sensors also has a picture of all of them.

    Parameters
    ----------
    histories
        A chart each, in their order.
    path
        The file.
    since_ns
        Draw only the runs that end at or after this stamp.

    Raises
    ------
    OSError
        If the file cannot be written.
    ModuleNotFoundError
        If matplotlib is not installed.

    """
    parts = [_HEAD]
    for number, (ship, sensors) in enumerate(_group(histories).items()):
        parts.append(f'<h2>{escape(ship)}: {len(sensors)} sensors</h2>\n')
        parts += [_draw_together(sensors, figure, f's{number}{figure}', since_ns) + '\n'
                  for figure in _NAMES]
    for number, history in enumerate(histories):
        parts.append(f'<h2>{escape(history.ship or "(no ship)")}, settings '
                     f'{history.settings_sha256[:8]}</h2>\n')
        sentences = [trend.words for trend in history.trends] or [
            f'No charts: {history.why_no_chart}']
        parts += [f'<p>{escape(words[0].upper() + words[1:])}.</p>\n' for words in sentences]
        points = history.list_since(since_ns)
        parts += [_draw(points, figure, f'h{number}{figure}') + '\n' for figure in _NAMES]
    Path(path).write_text(''.join(parts) + '</body></html>\n', 'utf-8')


def _group(histories: Sequence[History]) -> dict[str, list[History]]:
    """Return the histories of ships with several sensors, called SHIP/SENSOR, by the ship."""
    by_ship: dict[str, list[History]] = {}
    for history in histories:
        ship, has_name, _ = history.ship.rpartition('/')
        if has_name:
            by_ship.setdefault(ship, []).append(history)
    return {ship: ship_histories for ship, ship_histories in by_ship.items()
            if len({history.ship for history in ship_histories}) > 1}


def _draw_together(histories: Sequence[History], figure: str, name: str,
                   since_ns: int | None) -> str:
    """Return one figure of all sensors of a ship as SVG."""
    from heading_intercompare.report.figures.style import draw, GREY, INK

    runs = [(history, [p for p in history.list_since(since_ns)
                       if getattr(p.row, f'{figure}_deg') is not None]) for history in histories]
    start_ns = min((p.row.start_ns for _, points in runs for p in points), default=0)

    def fill(axes: Any) -> None:
        for at, (history, points) in enumerate(runs):
            # Legible in black and white: each sensor has a mark and a dash of its own.
            axes.plot([(p.row.start_ns - start_ns) / _DAY_NS for p in points],
                      [getattr(p.row, f'{figure}_deg') for p in points],
                      color=(INK, GREY)[at // len(_MARKERS) % 2], linewidth=0.8,
                      marker=_MARKERS[at % len(_MARKERS)], markersize=4.0,
                      linestyle=_DASHES[at % len(_DASHES)],
                      label=f'{history.ship.rpartition("/")[2]}, settings '
                            f'{history.settings_sha256[:8]}')

    n = sum(len(points) for _, points in runs)
    return draw(fill, name=name, title=f'{_NAMES[figure].capitalize()} of each sensor, {n} runs',
                x_label=f'days since {utc(start_ns)[:16]} UTC', y_label=f'{_NAMES[figure]} [deg]')


def _draw(points: Sequence[Point], figure: str, name: str) -> str:
    """Return the chart of one figure as SVG."""
    # Only now: matplotlib is optional and takes long to load.
    from heading_intercompare.report.figures.style import ACCENT, draw, GREY, INK

    drawn = [p for p in points if getattr(p.row, f'{figure}_deg') is not None]
    start_ns = drawn[0].row.start_ns if drawn else 0

    def fill(axes: Any) -> None:
        at = [(p.row.start_ns - start_ns) / _DAY_NS for p in drawn]
        axes.plot(at, [getattr(p.row, f'{figure}_deg') for p in drawn], color=ACCENT, marker='.',
                  linewidth=0.8, label='runs')
        limited = [(day, p) for day, p in zip(at, drawn) if p.mean_low_deg is not None]
        for side in ('low', 'high'):
            axes.plot([day for day, _ in limited],
                      [getattr(p, f'{figure}_{side}_deg') for _, p in limited], color=GREY,
                      linestyle='--', linewidth=1.0, label='limits' if side == 'low' else None)
        outside = [(day, p) for day, p in limited if figure in p.outside]
        if outside:
            axes.plot([day for day, _ in outside],
                      [getattr(p.row, f'{figure}_deg') for _, p in outside], color=INK,
                      linestyle='none', marker='x', markersize=8.0, label='outside the limits')

    return draw(fill, name=name, title=f'{_NAMES[figure].capitalize()}, {len(drawn)} runs',
                x_label=f'days since {utc(start_ns)[:16]} UTC',
                y_label=f'{_NAMES[figure]} [deg]')
