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

"""Figures of a simulated trial: headings, errors, claims and modes, which only it can know."""

from __future__ import annotations

from typing import Any, Mapping, Sequence

import numpy as np

from heading_intercompare.core.records import Reals
from heading_intercompare.report.sketching.track import Trace

from .drawing import MEAN, RANGE, SERIES, SIGMA
from .style import draw

_GREYS = ('#f2f2f2', '#dcdcdc')
_HEIGHT_MM = 60.0
_TRUE: dict[str, Any] = {'color': '#c3d3e6', 'linewidth': 4.0}


def draw_trace(trace: Trace, number: int) -> tuple[str, str]:
    """
    Return two charts of a sensor as `svg` elements: its heading, and its error.

    Parameters
    ----------
    trace
        What it showed.
    number
        Number of the sensor on the page.

    """
    def fill_heading(axes: Any) -> None:
        """Draw the true heading, the readings, and the modes as bands with their names."""
        for points, look, label in ((trace.true_deg, _TRUE, 'true heading'),
                                    (trace.heading_deg, SERIES, 'reading')):
            axes.plot(trace.t_h, _break_turns(points), label=label, **look)
        axes.set_ylim(0.0, 360.0)
        axes.set_yticks(range(0, 361, 90))
        _mark_modes(axes, trace)

    def fill_error(axes: Any) -> None:
        """Draw the range of the errors, and twice the claimed standard deviation about zero."""
        axes.fill_between(trace.t_h, trace.low_deg, trace.high_deg, color=SERIES['color'],
                          linewidth=0.8, label='reading minus true heading, range of a column')
        for sign in (1.0, -1.0):
            axes.plot(trace.t_h, sign * 2.0 * trace.sigma_deg, **SIGMA,
                      label='twice the claimed standard deviation' if sign > 0.0 else None)
        axes.axhline(0.0, zorder=1, **RANGE)
        _mark_modes(axes, trace, named=False)

    return (draw(fill_heading, name=f'heading{number}',
                 title=f'{trace.name}: heading, {trace.n} readings', x_label='time [h]',
                 y_label='heading [deg]', height_mm=_HEIGHT_MM),
            draw(fill_error, name=f'error{number}', title=f'{trace.name}: error',
                 x_label='time [h]', y_label='error [deg]', height_mm=_HEIGHT_MM))


def draw_seeds(columns: Mapping[str, Sequence[float] | Reals]) -> str:
    """
    Return a chart of the means of a trial with many seeds, as an `svg` element.

    Parameters
    ----------
    columns : mapping of str to array_like of float
        `seed`, `true_mean_deg`, `mean_deg`, `low_deg` and `high_deg`, one value a seed.

    """
    def fill(axes: Any) -> None:
        """Draw the mean differences with their intervals, and the true mean errors."""
        axes.vlines(columns['seed'], columns['low_deg'], columns['high_deg'], **SERIES,
                    label='95 % interval of the mean difference')
        axes.plot(columns['seed'], columns['mean_deg'], 'o', markersize=3.0, color='#1b4f8a',
                  label='mean difference TS - RS')
        axes.plot(columns['seed'], columns['true_mean_deg'], 'x', markersize=4.0, color='#000000',
                  label='mean error of the TS')
        axes.axhline(float(np.nanmean(columns['mean_deg'])), **MEAN,
                     label='mean difference over the seeds')
    return draw(fill, name='seeds', title=f'Means of {len(columns["seed"])} seeds',
                x_label='seed', y_label='mean [deg]', height_mm=_HEIGHT_MM)


def _break_turns(heading_deg: Reals) -> Reals:
    """Return headings with a break where they pass through north."""
    broken = heading_deg.copy()
    with np.errstate(invalid='ignore'):
        broken[1:][np.abs(np.diff(heading_deg)) > 180.0] = np.nan
    return broken


def _mark_modes(axes: Any, trace: Trace, named: bool = True) -> None:
    """Shade the modes in turn, and write the name of each long one at its beginning."""
    if not trace.modes:
        return
    ends = [*(begin for begin, _ in trace.modes[1:]), float(trace.t_h[-1])]
    for number, ((begin, name), end) in enumerate(zip(trace.modes, ends)):
        axes.axvspan(begin, end, color=_GREYS[number % 2], zorder=0)
        if named and end - begin > 0.03 * float(trace.t_h[-1]):
            axes.text(begin, 0.98, f' {name}', transform=axes.get_xaxis_transform(), va='top',
                      fontsize=5.5, color='#444444')
