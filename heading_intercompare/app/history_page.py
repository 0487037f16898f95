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
from typing import Any, Sequence

import numpy as np

from heading_intercompare.core.count_words import count_words
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.utc_text import DAY_NS, utc
from heading_intercompare.core.validity.condition import VOID
from heading_intercompare.core.verdict.headline import say_outcome
from heading_intercompare.logbook.days import Day, DayMean, list_days, SECTORS
from heading_intercompare.logbook.history import History, Point
from heading_intercompare.replaced_file import replace_file
from heading_intercompare.report.figures.drawing import SVG_STYLE
from heading_intercompare.report.formatting import number, with_uncertainty

#: Histories with figures on a page.
_MOST_DRAWN = 20
_MARKERS, _DASHES = 'osv^D', ('-', '--', ':', '-.')
_NAMES = {'mean': 'mean difference', 'sd': 'standard deviation'}
#: The rows of the strip of days from the bottom, with their marks.
_LEVELS: dict[str, dict[str, Any]] = {
    Outcome.COMPLIANT.value: {'marker': 's'},
    Outcome.INDETERMINATE.value: {'marker': 's', 'markerfacecolor': 'none'},
    VOID: {'marker': 'x'}, Outcome.NON_COMPLIANT.value: {'marker': 'D'}}
_DAYS_WORDS = (
    '<p>A void run is in no figure of its day. Mean and correction are means over the other runs '
    'of the day, with their standard uncertainties. Corrected heading = TS heading + correction. '
    'The headings N to NW are those of the RS.</p>\n')
_HEAD = f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Heading sensors over time</title>
<style>body {{ font: 16px/1.5 Helvetica, Arial, sans-serif; max-width: 60em; margin: 2em auto;
padding: 0 1em }}
{SVG_STYLE}
.days {{ overflow-x: auto; font-size: 80% }}
table {{ border-collapse: collapse }} th, td {{ border: 1px solid #c8ccd2; padding: .2em .5em;
text-align: left; white-space: nowrap }}</style></head><body>
<h1>Heading sensors over time</h1>
"""


def write_page(histories: Sequence[History], path: str, since_ns: int | None = None) -> None:
    """
    Write the charts of mean and standard deviation, with their limits, and the days with runs.

    A ship with several sensors also has a picture of all of them. Of several histories a table
    lists all, the worst first, and the worst 20 have figures.

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
    if len(histories) > 1:
        parts.append(_list_histories(histories))
    for at, (ship, sensors) in enumerate(_group(histories).items()):
        parts.append(f'<h2>{escape(ship)}: {len(sensors)} sensors</h2>\n')
        parts += [_draw_together(sensors, figure, f's{at}{figure}', since_ns) + '\n'
                  for figure in _NAMES]
    for at, history in enumerate(histories[:_MOST_DRAWN]):
        parts.append(f'<h2 id="h{at}">{escape(history.name)}</h2>\n')
        sentences = [trend.words for trend in history.trends] or [
            f'No charts: {history.why_no_chart}']
        parts += [f'<p>{escape(words[0].upper() + words[1:])}.</p>\n' for words in sentences]
        points = history.list_since(since_ns)
        days = list_days(point.row for point in points)
        parts.append(_draw_days(days, f'h{at}days') + '\n')
        parts += [_draw(points, figure, f'h{at}{figure}') + '\n' for figure in _NAMES]
        parts.append(_tabulate_days(days))
    replace_file(path, ''.join(parts) + '</body></html>\n')


def _list_histories(histories: Sequence[History]) -> str:
    """Return a row for each history, with a link to its figures."""
    rows = []
    for at, history in enumerate(histories):
        newest, name = history.points[-1].row, escape(history.name)
        linked = f'<a href="#h{at}">{name}</a>' if at < _MOST_DRAWN else name
        words = (say_outcome(newest.outcome, newest.validity_effect), *history.state)
        rows.append(f'<tr><td>{linked}</td><td>{len(history.points)}</td>'
                    f'<td>{utc(newest.end_ns)[:16]}</td><td>{escape("; ".join(words))}</td></tr>')
    return ('<div class="days"><table>\n<tr><th>ship</th><th>runs</th><th>newest, UTC</th>'
            '<th>state</th></tr>\n' + '\n'.join(rows) + '\n</table></div>\n'
            + f'<p>The worst {_MOST_DRAWN} have figures; history --ship NAME --html draws another '
            'one.</p>\n' * (len(histories) > _MOST_DRAWN))


def _draw_days(days: Sequence[Day], name: str) -> str:
    """Return the strip of days as SVG: the worst verdict of each."""
    from heading_intercompare.report.figures.style import draw, INK

    first = np.datetime64(days[0].date, 'D') if days else np.datetime64(0, 'D')

    def fill(axes: Any) -> None:
        for height, (level, mark) in enumerate(_LEVELS.items()):
            at = [(np.datetime64(day.date, 'D') - first).astype(int) for day in days
                  if _level(day) == level]
            axes.plot(at, [height] * len(at), color=INK, linestyle='none', markersize=4.0,
                      label=f'{_say(level)}: {len(at)}', **mark)
        axes.set_yticks([])
        axes.set_ylim(-0.5, len(_LEVELS) - 0.5)

    title = f'Worst verdict of each day, {count_words(len(days), "day")}'
    return draw(fill, name=name, title=title,
                x_label=f'days since {first} UTC', y_label='', height_mm=40.0)


def _level(day: Day) -> str:
    """Return where a day stands on the strip; a rejected sensor stands above a void run."""
    return VOID if day.effect == VOID and day.outcome is not Outcome.NON_COMPLIANT \
        else day.outcome.value


def _say(outcome: str) -> str:
    return outcome.replace('_', '-')


def _tabulate_days(days: Sequence[Day]) -> str:
    """Return the days as a table of HTML."""
    heads = ['day, UTC', 'runs', 'not void', 'worst verdict', 'n', 'mean TS - RS [deg]',
             'largest sd [deg]', 'add to TS [deg]', *(f'on {sector}' for sector in SECTORS)]
    rows = [[day.date, str(day.runs), str(day.counted),
             say_outcome(day.outcome, day.effect), str(day.n), _show(day.mean),
             number(day.sd_deg), _show(day.add_to_ts),
             *(_show(day.add_to_ts_on.get(sector)) for sector in SECTORS)] for day in days]
    lines = [f'<tr>{"".join(f"<th>{escape(head)}</th>" for head in heads)}</tr>',
             *(f'<tr>{"".join(f"<td>{escape(cell)}</td>" for cell in row)}</tr>' for row in rows)]
    return _DAYS_WORDS + '<div class="days"><table>\n' + '\n'.join(lines) + '\n</table></div>\n'


def _show(estimate: DayMean | None) -> str:
    return '-' if estimate is None else with_uncertainty(estimate.mean_deg, estimate.u_deg)


def _group(histories: Sequence[History]) -> dict[str, list[History]]:
    """Return the histories of ships with several sensors, called SHIP/SENSOR, by the ship."""
    by_ship: dict[str, list[History]] = {}
    for history in histories:
        ship, has_name, _ = history.ship.rpartition('/')
        if has_name:
            by_ship.setdefault(ship, []).append(history)
    return {ship: ship_histories for ship, ship_histories in by_ship.items()
            if len({history.ship for history in ship_histories}) > 1}


def _list_drawn(points: Sequence[Point], figure: str) -> list[Point]:
    """Return the points of runs that have a figure and are not void."""
    return [p for p in points if getattr(p.row, f'{figure}_deg') is not None
            and p.row.validity_effect != VOID]


def _draw_together(histories: Sequence[History], figure: str, name: str,
                   since_ns: int | None) -> str:
    """Return one figure of all sensors of a ship as SVG."""
    from heading_intercompare.report.figures.style import draw, GREY, INK

    runs = [(history, _list_drawn(history.list_since(since_ns), figure)) for history in histories]
    start_ns = min((p.row.start_ns for _, points in runs for p in points), default=0)

    def fill(axes: Any) -> None:
        for at, (history, points) in enumerate(runs):
            # Legible in black and white: each sensor has a mark and a dash of its own.
            axes.plot([(p.row.start_ns - start_ns) / DAY_NS for p in points],
                      [getattr(p.row, f'{figure}_deg') for p in points],
                      color=(INK, GREY)[at // len(_MARKERS) % 2], linewidth=0.8,
                      marker=_MARKERS[at % len(_MARKERS)], markersize=4.0,
                      linestyle=_DASHES[at % len(_DASHES)],
                      label=f'{history.ship.rpartition("/")[2]}, settings '
                            f'{history.settings_sha256[:8]}')

    n = sum(len(points) for _, points in runs)
    title = f'{_NAMES[figure].capitalize()} of each sensor, {count_words(n, "run")}'
    return draw(fill, name=name, title=title,
                x_label=f'days since {utc(start_ns)[:16]} UTC', y_label=f'{_NAMES[figure]} [deg]')


def _draw(points: Sequence[Point], figure: str, name: str) -> str:
    """Return the chart of one figure as SVG."""
    # Only now: matplotlib is optional and takes long to load.
    from heading_intercompare.report.figures.style import ACCENT, draw, GREY, INK

    drawn = _list_drawn(points, figure)
    start_ns = drawn[0].row.start_ns if drawn else 0

    def fill(axes: Any) -> None:
        at = [(p.row.start_ns - start_ns) / DAY_NS for p in drawn]
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

    title = f'{_NAMES[figure].capitalize()}, {count_words(len(drawn), "run")}'
    return draw(fill, name=name, title=title,
                x_label=f'days since {utc(start_ns)[:16]} UTC',
                y_label=f'{_NAMES[figure]} [deg]')
