# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""SVG graphs from matplotlib, in one style; they are reproducible and can share a page."""

from __future__ import annotations

from contextlib import contextmanager
from io import BytesIO
import re
from typing import Any, Callable, Iterator
from xml.etree import ElementTree

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

__all__ = ['ACCENT', 'draw', 'GREY', 'INK', 'SHADE']

#: Colours of lines and of shaded areas; they also differ in lightness.
INK, ACCENT, GREY, SHADE = '#000000', '#1b4f8a', '#767676', '#c3d3e6'

#: Width of a graph and margins around the axes, inches.
_WIDTH, _LEFT, _RIGHT, _TOP, _BOTTOM = 9.6, 0.85, 0.24, 0.42, 0.62
_LEGEND_ROW = 0.24
#: Settings of matplotlib.
_LOOK: dict[Any, object] = {
    'svg.fonttype': 'none', 'axes.unicode_minus': False, 'axes.formatter.useoffset': False,
    'font.family': 'sans-serif', 'font.sans-serif': ['DejaVu Sans'], 'font.size': 9.5,
    'axes.titlesize': 11.5, 'axes.titleweight': 'bold', 'axes.titlelocation': 'left',
    'axes.titlepad': 10.0, 'axes.labelpad': 6.0, 'axes.linewidth': 0.8,
    'axes.edgecolor': '#444444', 'axes.spines.top': False, 'axes.spines.right': False,
    'axes.grid': True, 'axes.axisbelow': True, 'grid.color': '#e2e2e2', 'grid.linewidth': 0.7,
    'xtick.color': '#444444', 'ytick.color': '#444444', 'xtick.labelcolor': INK,
    'ytick.labelcolor': INK, 'lines.solid_capstyle': 'butt', 'legend.frameon': False,
    'legend.handlelength': 4.0, 'legend.columnspacing': 3.0, 'legend.borderpad': 0.2,
}
_SVG, _XLINK = 'http://www.w3.org/2000/svg', 'http://www.w3.org/1999/xlink'
#: The font in which matplotlib measures text, which a browser may lack, and the font of the page.
_FONT = re.compile(r"'DejaVu Sans'(, *[^;]*)?")
_PAGE_FONT = 'Helvetica, Arial, sans-serif'
_LONG = re.compile(r'-?\d+\.\d{3,}')


@contextmanager
def _our_look() -> Iterator[None]:
    """Use our style whatever the user has set for plots, then restore the user's settings."""
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(_LOOK)
        yield


def draw(fill: Callable[[Axes], object], *, name: str, title: str, x_label: str, y_label: str,
         height: float = 3.6) -> str:
    """
    Return one graph as an `svg` element, complete with its namespaces.

    Parameters
    ----------
    fill : callable
        Draws into the given axes; everything it labels gets a legend below them.
    name : str
        Letters and digits, unique on the page. Every id begins with it.
    title, x_label, y_label : str
        The labels carry the units. A screen reader reads the title aloud.
    height : float
        Height without the legend, inches.

    """
    with _our_look():
        matplotlib.rcParams['svg.hashsalt'] = name
        figure = Figure()
        FigureCanvasSVG(figure)
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set_title(title)
        axes.set_xlabel(x_label)
        axes.set_ylabel(y_label)
        fill(axes)
        handles, labels = axes.get_legend_handles_labels()
        total = height + _LEGEND_ROW * ((len(labels) + 1) // 2)
        figure.set_size_inches(_WIDTH, total)
        axes.set_position((_LEFT / _WIDTH, 1.0 - (height - _BOTTOM) / total,
                           1.0 - (_LEFT + _RIGHT) / _WIDTH, (height - _TOP - _BOTTOM) / total))
        if labels:
            figure.legend(handles, labels, loc='lower left', ncol=2, borderaxespad=0.0,
                          bbox_to_anchor=(_LEFT / _WIDTH, 0.04 / total))
        written = BytesIO()
        figure.savefig(written, format='svg')
    return _tidy(written.getvalue(), name, title)


def _tidy(written: bytes, name: str, title: str) -> str:
    """Return the SVG of matplotlib as part of a page: with a title and unique ids, undated."""
    root = ElementTree.fromstring(written)
    for parent in [*root.iter()]:
        for child in [*parent]:
            if child.tag in (f'{{{_SVG}}}metadata', f'{{{_SVG}}}style'):
                parent.remove(child)
    for element in root.iter():
        element.tag = element.tag.partition('}')[2]
        given = {key.replace(f'{{{_XLINK}}}', 'xlink:'): value
                 for key, value in element.attrib.items()}
        element.attrib.clear()
        element.attrib.update({key: _tidy_value(key, value, name)
                               for key, value in given.items()})
    titled = ElementTree.Element('title', {'id': f'{name}-title'})
    titled.text = title
    root.insert(0, titled)
    root.attrib |= {'xmlns': _SVG, 'xmlns:xlink': _XLINK, 'role': 'img',
                    'aria-labelledby': f'{name}-title',
                    # Replaces the removed style sheet, which would apply to the whole page.
                    'style': 'stroke-linejoin: round; stroke-linecap: butt'}
    return ElementTree.tostring(root, 'unicode')


def _tidy_value(key: str, value: str, name: str) -> str:
    """Return the value of an attribute with ids prefixed and numbers rounded to 0.01 points."""
    if key == 'id':
        return f'{name}-{value}'
    if key == 'xlink:href':
        return value.replace('#', f'#{name}-')
    if key in ('d', 'x', 'y', 'transform'):
        return _LONG.sub(lambda match: f'{float(match[0]):.2f}', value)
    return _FONT.sub(_PAGE_FONT, value).replace('url(#', f'url(#{name}-')
