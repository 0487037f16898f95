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

"""All figures of a record in their order, or as SVG for a page."""

from __future__ import annotations

from typing import Callable, Iterator, NamedTuple

from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.report.series_sketch import SeriesSketch

from .correlation import draw_allan_deviation, draw_autocorrelation, draw_spectrum
from .dependence import draw_against_heading, draw_against_rate, draw_skew_scan
from .distribution import draw_histogram, draw_quantiles
from .drawing import Drawing, LeftOut, Subject
from .over_time import draw_differences, draw_headings, draw_running_variance
from .track import draw_track

_FAMILIES: dict[str, Callable[[Subject], Iterator[Drawing | LeftOut]]] = {
    'headings': draw_headings, 'differences': draw_differences,
    'running_variance': draw_running_variance, 'heading': draw_against_heading,
    'rate': draw_against_rate, 'skew_scan': draw_skew_scan, 'histogram': draw_histogram,
    'quantiles': draw_quantiles, 'autocorrelation': draw_autocorrelation,
    'spectrum': draw_spectrum, 'allan': draw_allan_deviation, 'track': draw_track,
}

NAMES = (*_FAMILIES,)
"""Names of the figures, in their order."""


class Drawn(NamedTuple):
    """
    A figure of a page.

    Attributes
    ----------
    id
        Unique on the page.
    title, caption
        The caption says how to read the figure or, if it is left out, why.
    svg
        Empty if the figure is left out.

    """

    id: str
    title: str
    caption: str
    svg: str


def collect(sketch: SeriesSketch, verdict: Verdict, name: str | None = None,
            ) -> Iterator[Drawing | LeftOut]:
    """
    Yield the figures of a record; none if it has no difference.

    Parameters
    ----------
    sketch
        The record in as many points as a page can show.
    verdict
        Gives the runs and their limits.
    name
        One of `NAMES`; default all.

    """
    about = Subject.of(sketch, verdict)
    if about is None:
        return
    for family_name, family in _FAMILIES.items():
        if name in (None, family_name):
            yield from family(about)


def draw_figures(sketch: SeriesSketch, verdict: Verdict, prefix: str,
                 progress: Callable[[int], None] = lambda done: None) -> list[Drawn]:
    """
    Return the figures of a record as SVG, in their order; none if it has no difference.

    Parameters
    ----------
    sketch, verdict
        As for `collect`.
    prefix
        Letters and digits with which the ids begin; each record of the page has its own prefix.
    progress
        Called after each figure with how many of `NAMES` are done.

    """
    # Only now: matplotlib is optional and takes long to load.
    from .style import to_svg
    drawn = []
    for drawing in collect(sketch, verdict):
        name = f'{prefix}-{drawing.name}'
        drawn.append(Drawn(name, drawing.title, f'Left out: {drawing.reason}.', '')
                     if isinstance(drawing, LeftOut) else
                     Drawn(name, drawing.title, drawing.caption, to_svg(drawing, name)))
        progress(NAMES.index(drawing.name) + 1)
    return drawn
