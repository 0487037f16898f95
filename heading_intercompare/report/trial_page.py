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

"""The page of a simulated trial: one HTML file with its figures, without script or network."""

from __future__ import annotations

from html import escape
from typing import Iterable, Mapping, Sequence

from heading_intercompare.core.records import Reals

from .figures.drawing import Drawing, SVG_STYLE
from .figures.style import to_svg
from .figures.trial_figures import draw_seeds, draw_trace
from .sketching.track import Trace

_STYLE = f"""
body {{ font-family: Helvetica, Arial, sans-serif; margin: 2em auto; max-width: 190mm; }}
{SVG_STYLE}
"""


def compose_trial_page(title: str, lines: Iterable[str], traces: Sequence[Trace] = (),
                       seeds: Mapping[str, Sequence[float] | Reals] | None = None,
                       chances: Drawing | None = None) -> str:
    """
    Return the page of a simulated trial.

    Parameters
    ----------
    title
        Title of the trial.
    lines
        What the command says of the trial.
    traces
        What each sensor showed.
    seeds : mapping of str to array_like of float, optional
        Columns `seed`, `true_mean_deg`, `mean_deg`, `low_deg` and `high_deg` of a repeated trial.
    chances
        The figure of a plan.

    """
    paragraphs = ''.join(f'<p>{escape(line)}</p>\n' for line in lines)
    charts = ''.join(
        f'<h2>{escape(trace.name)}</h2>\n{"".join(draw_trace(trace, number))}\n'
        for number, trace in enumerate(traces))
    if seeds is not None:
        charts += f'<h2>Seeds</h2>\n{draw_seeds(seeds)}\n'
    if chances is not None:
        charts += f'{to_svg(chances, chances.name)}\n<p>{escape(chances.caption)}</p>\n'
    return ('<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            '<meta name="generator" content="heading-intercompare"/>\n'
            f'<title>{escape(title)}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n'
            f'<h1>{escape(title)}</h1>\n{paragraphs}{charts}</body>\n</html>\n')
