# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Line graphics in SVG: axes with ticks, lines, bars and bands, readable in black and white."""

from __future__ import annotations

import math
from typing import Iterable, Sequence

from .markup import element, join, Markup, text

__all__ = ['nice_step', 'Plot', 'ticks']

_LEFT, _RIGHT, _TOP, _BOTTOM = 76.0, 16.0, 34.0, 50.0
#: Of a line.
_WIDTH = 1.4
_FONT = 'Helvetica, Arial, sans-serif'


def nice_step(span: float, at_most: int) -> float:
    """
    Return the step 1, 2 or 5 times a power of ten that cuts a span into few parts.

    Examples
    --------
    >>> nice_step(0.7, 8), nice_step(7200.0, 8)
    (0.1, 1000.0)

    """
    raw = span / at_most
    power = 10.0 ** math.floor(math.log10(raw))
    return next(f * power for f in (1.0, 2.0, 5.0, 10.0, 20.0) if f * power >= raw * (1 - 1e-9))


def ticks(low: float, up: float, at_most: int = 8,
          step: float | None = None) -> list[tuple[float, str]]:
    """
    Return the places of ticks between two ends, and their labels.

    Parameters
    ----------
    low, up : float
        Ends of the axis, low < up.
    at_most : int
        About so many parts.
    step : float, optional
        Distance of ticks; chosen if not given.

    """
    step = step or nice_step(up - low, at_most)
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    first, last = math.ceil(low / step - 1e-9), math.floor(up / step + 1e-9)
    return [(k * step, f'{k * step + 0.0:.{decimals}f}')
            for k in range(first, last + 1)]


class Plot:
    """
    One graph, filled by its methods and read by `svg`.

    Parameters
    ----------
    x_range, y_range : (float, float)
        Ends of the axes, low < up, finite.
    title, x_label, y_label : str
        The labels carry the units.
    size : (float, float)
        Width and height, pixels.
    x_step : float, optional
        Distance of the ticks of the x axis.

    """

    def __init__(self, x_range: tuple[float, float], y_range: tuple[float, float], *, title: str,
                 x_label: str, y_label: str, size: tuple[float, float] = (760.0, 300.0),
                 x_step: float | None = None) -> None:
        for name, (low, up) in (('x_range', x_range), ('y_range', y_range)):
            if not (math.isfinite(low) and math.isfinite(up) and low < up):
                raise ValueError(f'{name} = {(low, up)!r}: must be two finite ends, low < up')
        self._x, self._y, self._size, self._title = x_range, y_range, size, title
        self._labels, self._x_step = (x_label, y_label), x_step
        self._marks: list[Markup] = []
        self._legend: list[tuple[Markup, str]] = []

    def _at(self, x: float, y: float) -> tuple[float, float]:
        """Return the pixel of a point; what lies beyond the axes is held at one frame's width."""
        width, height = self._size
        u = (x - self._x[0]) / (self._x[1] - self._x[0])
        v = (y - self._y[0]) / (self._y[1] - self._y[0])
        u, v = min(max(u, -1.0), 2.0), min(max(v, -1.0), 2.0)
        return (_LEFT + u * (width - _LEFT - _RIGHT),
                height - _BOTTOM - v * (height - _TOP - _BOTTOM))

    def _path(self, points: Iterable[tuple[float, float]]) -> str:
        return ' '.join(f'{x:.2f},{y:.2f}' for x, y in (self._at(*p) for p in points))

    def line(self, points: Sequence[tuple[float, float]], *, legend: str = '',
             width: float = _WIDTH, dash: str | None = None, color: str = 'black') -> None:
        """Draw a line through points."""
        style = {'stroke': color, 'stroke_width': width, 'stroke_dasharray': dash, 'fill': 'none'}
        if len(points):
            self._marks.append(element('polyline', points=self._path(points), **style))
        if legend:
            self._legend.append((element('line', x1=0, y1=0, x2=26, y2=0, **style), legend))

    def horizontal(self, y: float, x_ends: tuple[float, float] | None = None, *,
                   legend: str = '', width: float = _WIDTH, dash: str | None = None) -> None:
        """Draw a level line, across the graph or between two ends."""
        low, up = x_ends or self._x
        self.line([(low, y), (up, y)], legend=legend, width=width, dash=dash)

    def vertical(self, x: float, *, legend: str = '', width: float = _WIDTH,
                 dash: str | None = None) -> None:
        """Draw an upright line across the graph."""
        self.line([(x, self._y[0]), (x, self._y[1])], legend=legend, width=width, dash=dash)

    def bars(self, bars: Iterable[tuple[float, float, float, float]], *, legend: str = '',
             color: str = '#bbbbbb', stroke: str = 'none') -> None:
        """Draw boxes, each given as x low, x up, y low, y up."""
        for x_low, x_up, y_low, y_up in bars:
            left, bottom = self._at(x_low, y_low)
            right, top = self._at(x_up, y_up)
            self._marks.append(element(
                'rect', x=f'{left:.2f}', y=f'{top:.2f}', width=f'{max(right - left, 0.6):.2f}',
                height=f'{max(bottom - top, 0.6):.2f}', fill=color, stroke=stroke,
                stroke_width=0.6))
        if legend:
            self._legend.append((element('rect', x=0, y=-5, width=26, height=10, fill=color,
                                         stroke=stroke), legend))

    def band(self, low: Sequence[tuple[float, float]], up: Sequence[tuple[float, float]], *,
             legend: str = '', color: str = '#bbbbbb') -> None:
        """Fill what lies between two lines over the same places."""
        if len(low):
            self._marks.append(element(
                'polygon', points=self._path([*low, *reversed(up)]), fill=color, stroke=color,
                stroke_width=0.8))
        if legend:
            self._legend.append((element('rect', x=0, y=-5, width=26, height=10, fill=color),
                                 legend))

    def dots(self, points: Iterable[tuple[float, float]], *, legend: str = '') -> None:
        """Draw points."""
        for x, y in (self._at(*p) for p in points):
            self._marks.append(element('circle', cx=f'{x:.2f}', cy=f'{y:.2f}', r=2.6))
        if legend:
            self._legend.append((element('circle', cx=13, cy=0, r=2.6), legend))

    def _axes(self) -> list[Markup]:
        left, bottom = self._at(self._x[0], self._y[0])
        right, top = self._at(self._x[1], self._y[1])
        parts = []
        for x, label in ticks(*self._x, step=self._x_step):
            px = f'{self._at(x, self._y[0])[0]:.2f}'
            parts.append(element('line', x1=px, x2=px, y1=bottom, y2=bottom + 5, stroke='black'))
            parts.append(element('text', label, x=px, y=bottom + 18, text_anchor='middle'))
        for y, label in ticks(*self._y, at_most=6):
            py = self._at(self._x[0], y)[1]
            parts.append(element('line', x1=left - 5, x2=left, y1=f'{py:.2f}', y2=f'{py:.2f}',
                                 stroke='black'))
            parts.append(element('line', x1=left, x2=right, y1=f'{py:.2f}', y2=f'{py:.2f}',
                                 stroke='#dddddd', stroke_width=0.6))
            parts.append(element('text', label, x=left - 8, y=f'{py + 4:.2f}', text_anchor='end'))
        middle_x, middle_y = (left + right) / 2, (top + bottom) / 2
        x_label, y_label = self._labels
        parts.append(element('text', x_label, x=middle_x, y=bottom + 38, text_anchor='middle'))
        parts.append(element('text', y_label, x=18, y=middle_y, text_anchor='middle',
                             transform=f'rotate(-90 18 {middle_y})'))
        parts.append(element('text', self._title, x=left, y=18, font_weight='bold',
                             font_size=13))
        return parts

    def svg(self) -> Markup:
        """Return the graph as an `svg` element, complete with its namespace."""
        width, height = self._size
        left, bottom = self._at(self._x[0], self._y[0])
        right, top = self._at(self._x[1], self._y[1])
        frame = {'x': left, 'y': top, 'width': right - left, 'height': bottom - top}
        inner = element('svg', *self._marks, x=left, y=top, width=right - left,
                        height=bottom - top, overflow='hidden',
                        viewBox=f'{left} {top} {right - left} {bottom - top}') \
            if self._marks else text('')
        rows = (len(self._legend) + 1) // 2
        keys = []
        for at, (key, words) in enumerate(self._legend):
            x, y = left + (at % 2) * (right - left) / 2, height + 10 + 18 * (at // 2)
            keys.append(element('g', key, element('text', words, x=34, y=4),
                                transform=f'translate({x:.1f} {y:.1f})'))
        total = height + 18 * rows + 6
        return element(
            'svg', element('title', self._title),
            element('rect', width=width, height=total, fill='white'),
            join(self._axes()), inner,
            element('rect', **frame, fill='none', stroke='black'), join(keys),
            xmlns='http://www.w3.org/2000/svg', role='img', width=width, height=total,
            viewBox=f'0 0 {width} {total}', font_family=_FONT, font_size=12, fill='black')
