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

"""The figures of the size of the differences: histogram, and quantiles against the model."""

from __future__ import annotations

from typing import Any, Iterator

import numpy as np

from heading_intercompare.report.formatting import number

from .drawing import add_remark, Drawing, fit_axis, LeftOut, LIMIT, RANGE, SERIES, Subject, UNIT

_BARS = 120
_FINE = 4001
_POINTS = 400
_LEAST = 30


def _count_beyond(about: Subject, low: float, up: float) -> int:
    """Return the number of differences beyond the ends of an axis."""
    histogram = about.sketch.histogram
    edges = histogram.edges_deg()
    return int(histogram.counts[(edges[1:] <= low) | (edges[:-1] >= up)].sum())


def draw_histogram(about: Subject) -> Iterator[Drawing | LeftOut]:
    """Yield the histogram of the differences, with the density of the model."""
    histogram = about.sketch.histogram
    low, up, far = fit_axis(*about.extremes(), about.scale(about.limits_deg()))
    joint = 1
    while (up - low) / (joint * histogram.width_deg) > _BARS:
        joint *= 2
    width = joint * histogram.width_deg
    at = (histogram.first + np.arange(len(histogram.counts))) // joint
    counts = np.bincount(at - at[0], histogram.counts)
    edges = (at[0] + np.arange(len(counts) + 1)) * width
    fine = np.linspace(low, up, 401)
    model = about.model_density(fine)
    beyond = f', {_count_beyond(about, low, up)} beyond the axis' if far else ''
    bands = about.bands

    def fill(axes: Any) -> None:
        axes.stairs(counts, edges, fill=True, color=RANGE['color'])
        axes.stairs(counts, edges, color=SERIES['color'], linewidth=0.8)
        top = float(counts.max())
        if model is not None:
            expected = model * width * about.sketch.n
            top = max(top, float(expected.max()))
            axes.plot(fine, expected, **UNIT, label=f'model {about.settings.model} with the mean '
                      'and variance of the run')
        if len(bands) == 1:
            for level, look, words in bands[0].lines():
                axes.axvline(level, **look, label=words)
        elif bands:
            for pick, words in ((min, None), (max, 'outermost limits of GK (*) of the runs')):
                axes.axvline(pick(level for band in bands for level, _, _ in band.lines()),
                             **LIMIT, label=words)
        axes.set_xlim(low, up)
        axes.set_ylim(0.0, 1.08 * top)

    yield Drawing(
        name='histogram', title=about.title('size of the differences') + beyond,
        caption=add_remark(
            'The bars should follow the line of the model; bars beyond the dashed limits '
            'are the counts of GK (6).' + about.moved, far), x_label='difference TS - RS [deg]',
        y_label=f'number in {number(width, 3)} deg', fill=fill)


def draw_quantiles(about: Subject) -> Iterator[Drawing | LeftOut]:
    """Yield the quantiles of the differences against those of the model."""
    title, n = about.title('quantiles against the model'), about.sketch.n
    low, up = about.extremes()
    if n < _LEAST or not up > low:
        yield LeftOut('quantiles', title, f'it needs {_LEAST} differences that are not all equal')
        return
    margin = 0.5 * (up - low)
    fine = np.linspace(low - margin, up + margin, _FINE)
    share = about.model_share(fine)
    if share is None:
        yield LeftOut('quantiles', title, 'no run has a mean and a variance')
        return
    histogram = about.sketch.histogram
    filled = np.flatnonzero(histogram.counts)
    counts, edges = histogram.counts[filled], histogram.edges_deg()
    # The middle of each bin stands for the middle of its values.
    observed_share = (np.cumsum(counts) - 0.5 * counts) / n
    size = 0.5 * (edges[filled] + edges[filled + 1])
    rising = np.flatnonzero(np.diff(share, prepend=-1.0) > 0.0)
    expected = np.interp(observed_share, share[rising], fine[rising])
    # The ends show every bin, the middle a few.
    rank = np.arange(len(observed_share))
    keep = (rank < _POINTS // 4) | (rank >= len(rank) - _POINTS // 4) | (
        rank % max(1, len(rank) * 2 // _POINTS) == 0)
    both = np.concatenate((expected, size))
    lowest, highest, beyond = fit_axis(float(both.min()), float(both.max()), about.scale())

    def fill(axes: Any) -> None:
        axes.plot([lowest, highest], [lowest, highest], **LIMIT, label='the model')
        axes.plot(expected[keep], size[keep], 'o', color=SERIES['color'], markersize=2.6,
                  label='the differences')
        axes.set_xlim(lowest, highest)
        axes.set_ylim(lowest, highest)

    yield Drawing(
        name='quantiles', title=title, caption=add_remark(
            'Points on the dashed line follow the model; ends that turn '
            'away from it upwards on the right and downwards on the left are heavy tails.',
            beyond),
        x_label=f'quantile of the model {about.settings.model} [deg]',
        y_label='quantile of the differences [deg]', fill=fill)
