# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""A page with the charts of histories, in one HTML file."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Any, Sequence

from heading_intercompare.core.utc_text import utc
from heading_intercompare.logbook.history import History, Point

__all__ = ['write_page']

_DAY_NS = 86_400_000_000_000
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

    Parameters
    ----------
    histories : sequence of History
    path : str
        The file.
    since_ns : int, optional
        Draw only the runs that end at or after this stamp.

    Raises
    ------
    OSError
        If the file cannot be written.
    ModuleNotFoundError
        If matplotlib is not installed.

    """
    parts = [_HEAD]
    for number, history in enumerate(histories):
        parts.append(f'<h2>{escape(history.ship or "(no ship)")}, settings '
                     f'{history.settings_sha256[:8]}</h2>\n')
        said = [trend.words for trend in history.trends] or [f'No charts: {history.why_no_chart}']
        parts += [f'<p>{escape(words[0].upper() + words[1:])}.</p>\n' for words in said]
        points = history.list_since(since_ns)
        parts += [_draw(points, figure, f'h{number}{figure}') + '\n' for figure in _NAMES]
    Path(path).write_text(''.join(parts) + '</body></html>\n', 'utf-8')


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
