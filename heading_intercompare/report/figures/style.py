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

"""The style of all figures: SVG for a page, figures for a notebook; only here is matplotlib."""

from __future__ import annotations

from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
import re
from typing import Any, Callable, Iterator, Sequence
from xml.etree import ElementTree

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
import matplotlib.dates
from matplotlib.figure import Figure

from heading_intercompare.replaced_file import ReplacedFile

from .drawing import Drawing

#: Colours of single charts; they also differ in lightness.
INK, ACCENT, GREY, SHADE = '#000000', '#1b4f8a', '#767676', '#c3d3e6'

#: Sizes in millimetres: a figure fits between the margins of an A4 page.
_WIDTH, _LEFT, _RIGHT, _TOP, _BOTTOM = 170.0, 19.0, 4.0, 9.0, 12.5
_LEGEND_ROW = 4.6
_MM_PER_INCH = 25.4
#: Settings of matplotlib.
_LOOK: dict[Any, object] = {
    'svg.fonttype': 'none', 'axes.unicode_minus': False, 'axes.formatter.useoffset': False,
    'font.family': 'sans-serif', 'font.sans-serif': ['DejaVu Sans'], 'font.size': 8.0,
    'axes.titlesize': 9.0, 'axes.titleweight': 'bold', 'axes.titlelocation': 'left',
    'axes.titlepad': 8.0, 'axes.labelpad': 4.0, 'axes.linewidth': 0.7,
    'axes.edgecolor': '#444444', 'axes.spines.top': False, 'axes.spines.right': False,
    'axes.grid': True, 'axes.axisbelow': True, 'grid.color': '#e2e2e2', 'grid.linewidth': 0.6,
    'xtick.color': '#444444', 'ytick.color': '#444444', 'xtick.labelcolor': INK,
    'ytick.labelcolor': INK, 'lines.solid_capstyle': 'butt', 'legend.frameon': False,
    'legend.handlelength': 4.0, 'legend.columnspacing': 3.0, 'legend.borderpad': 0.2,
    'legend.fontsize': 7.5,
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


def _set_time_axis(axes: Axes) -> None:
    """Label the x axis, whose values are days since 1970, with dates and times UTC."""
    # matplotlib declares no types for its dates.
    dates: Any = matplotlib.dates
    locator = dates.AutoDateLocator(tz='UTC', minticks=4, maxticks=9)
    axes.xaxis.set_major_locator(locator)
    axes.xaxis.set_major_formatter(dates.ConciseDateFormatter(locator, tz='UTC'))


class _Shown(Figure):
    """A figure that a notebook shows without pyplot."""

    def _repr_svg_(self) -> str:
        with _our_look():
            written = BytesIO()
            self.savefig(written, format='svg')
        return written.getvalue().decode('utf-8')


def _lay_out(*drawings: Drawing) -> Figure:
    """Return a figure with the drawings one below the other, each with its legend."""
    figure = _Shown()
    blocks = []
    for drawing in drawings:
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set_title(drawing.title)
        axes.set_xlabel(drawing.x_label)
        axes.set_ylabel(drawing.y_label)
        if drawing.is_time:
            _set_time_axis(axes)
        drawing.fill(axes)
        handles, labels = axes.get_legend_handles_labels()
        columns = min(2, max(1, len(labels)))
        blocks.append((drawing, axes, handles, labels, columns,
                       drawing.height_mm + _LEGEND_ROW * -(-len(labels) // columns)))
    total = sum(height_mm for *_, height_mm in blocks)
    figure.set_size_inches(_WIDTH / _MM_PER_INCH, total / _MM_PER_INCH)
    top = 1.0
    for drawing, axes, handles, labels, columns, height_mm in blocks:
        axes.set_position((_LEFT / _WIDTH, top - (drawing.height_mm - _BOTTOM) / total,
                           1.0 - (_LEFT + _RIGHT) / _WIDTH,
                           (drawing.height_mm - _TOP - _BOTTOM) / total))
        top -= height_mm / total
        if labels:
            figure.legend(handles, labels, loc='lower left', ncol=columns, borderaxespad=0.0,
                          bbox_to_anchor=(_LEFT / _WIDTH, top + 1.0 / total))
    return figure


def save(drawings: Sequence[Drawing], path: str | Path) -> None:
    """
    Write drawings one below the other into a file; its suffix is its form: .png, .pdf or .svg.

    Raises
    ------
    OSError
        If it cannot be written.

    """
    with _our_look():
        figure = _lay_out(*drawings)
        FigureCanvasAgg(figure)
        with ReplacedFile(path) as file:
            figure.savefig(file, format=Path(path).suffix[1:].lower(), dpi=150.0)


def to_figure(drawing: Drawing) -> Figure:
    """Return a drawing as a figure of matplotlib, which a notebook shows."""
    with _our_look():
        figure = _lay_out(drawing)
        FigureCanvasAgg(figure)
        figure.set_dpi(120.0)
    return figure


def to_svg(drawing: Drawing, name: str) -> str:
    """
    Return a drawing as an `svg` element, complete with its namespaces.

    Parameters
    ----------
    drawing
        As drawn by matplotlib.
    name
        Letters and digits, unique on the page. Every id begins with it. The same drawing with the
        same name gives the same bytes.

    """
    with _our_look():
        matplotlib.rcParams['svg.hashsalt'] = name
        figure = _lay_out(drawing)
        FigureCanvasSVG(figure)
        written = BytesIO()
        figure.savefig(written, format='svg')
    return _tidy(written.getvalue(), name, drawing.title)


def draw(fill: Callable[[Axes], object], *, name: str, title: str, x_label: str, y_label: str,
         height_mm: float = 70.0) -> str:
    """
    Return one chart as an `svg` element; see `to_svg`.

    Parameters
    ----------
    fill
        Draws into the given axes; everything it labels gets a legend below them.
    name, title, x_label, y_label, height_mm
        As for `to_svg` and `Drawing`.

    """
    return to_svg(Drawing(name=name, title=title, caption='', x_label=x_label, y_label=y_label,
                          fill=fill, height_mm=height_mm), name)


def _tidy(written: bytes, name: str, title: str) -> str:
    """Return the SVG of matplotlib as part of a page: with a title and unique ids, undated."""
    root = ElementTree.fromstring(written)
    for parent in [*root.iter()]:
        for child in [*parent]:
            if child.tag in (f'{{{_SVG}}}metadata', f'{{{_SVG}}}style'):
                parent.remove(child)
    for element in root.iter():
        element.tag = element.tag.partition('}')[2]
        attributes = {key.replace(f'{{{_XLINK}}}', 'xlink:'): value
                      for key, value in element.attrib.items()}
        element.attrib.clear()
        element.attrib.update({key: _tidy_value(key, value, name)
                               for key, value in attributes.items()})
    titled = ElementTree.Element('title', {'id': f'{name}-title'})
    titled.text = title
    root.insert(0, titled)
    root.attrib |= {'xmlns': _SVG, 'xmlns:xlink': _XLINK, 'role': 'img',
                    'aria-labelledby': f'{name}-title',
                    # A click, or the Tab key, gives it the focus: `SVG_STYLE` then enlarges it.
                    'tabindex': '0',
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
