# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The graphs of a report: sketches and the limits that their runs are held against."""

from __future__ import annotations

import math
from typing import Iterator, Sequence

import numpy as np

from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.verdict.verdict_document import RunVerdict, Verdict

from .formatting import number
from .markup import Markup
from .series_sketch import HEADING_BINS, SeriesSketch
from .svg import Plot

__all__ = ['draw_graphs']

_LIMIT, _TIGHTENED, _SIGMA, _NORM = '9 4', '2 3', '9 3 2 3', '14 4'
_HISTOGRAM_BARS = 120
_LOST_AT_MOST = 0.02


def _runs_of(sketch: SeriesSketch, runs: Sequence[RunVerdict]) -> list[RunVerdict]:
    """Return the runs that lie in a sketch: of its source, else of any, by their time."""
    start_ns, newest_ns = sketch.time.start_ns, sketch.newest_ns
    if start_ns is None or newest_ns is None:
        return []
    inside = [r for r in runs if r.start_ns <= newest_ns and r.end_ns >= start_ns]
    return [r for r in inside if r.source == sketch.source] or inside


def draw_graphs(sketch: SeriesSketch, verdict: Verdict) -> Iterator[Markup]:
    """
    Yield the graphs of a sketch; none without a difference.

    Parameters
    ----------
    sketch : SeriesSketch
    verdict : Verdict
        The limits of the runs in the sketch are drawn.

    """
    start_ns = sketch.time.start_ns
    if not sketch.n or start_ns is None:
        return
    runs = _runs_of(sketch, verdict.runs)
    name = _name(runs)
    bands = [_Band(run, verdict.settings.variant) for run in runs]
    norm = verdict.settings.norms.total_error_max_deg
    yield _time(sketch, start_ns, name, bands, verdict.settings.runs.gap_s)
    yield _draw_histogram(sketch, name, bands)
    yield _heading(sketch, name, bands, norm)


def _name(runs: Sequence[RunVerdict]) -> str:
    if not runs:
        return 'No run'
    if len(runs) == 1:
        return f'Run {runs[0].run}'
    between = 'and' if len(runs) == 2 else 'to'
    return f'Runs {runs[0].run} {between} {runs[-1].run}'


class _Band:
    """What a run is held against: deviations from its centre."""

    def __init__(self, run: RunVerdict, variant: str) -> None:
        counts = run.count_criterion
        self.run = run
        self.center_deg = 0.0 if variant == 'A' else run.mean_deg or 0.0
        self.limit_deg = counts.limit_deg
        self.tightened_deg = counts.tightened_limit_deg
        self.sigma_deg = math.sqrt(run.variance_criterion.limit_deg2)

    def lines(self) -> list[tuple[float, str, str]]:
        """Return level, dash and legend of the limits; the legend once for both sides."""
        return [(self.center_deg + sign * size, dash, words if sign > 0 else '')
                for size, dash, words in (
                    (self.limit_deg, _LIMIT, 'limit of GK (*), n+ beyond it'),
                    (self.tightened_deg, _TIGHTENED,
                     'tightened limit of GK (**), n++ beyond it'))
                for sign in (1.0, -1.0)]


def _pad(low: float, up: float) -> tuple[float, float]:
    pad = 0.06 * (up - low) or max(abs(low), 1.0) * 1e-3
    return low - pad, up + pad


def _extremes(sketch: SeriesSketch) -> tuple[float, float]:
    return float(sketch.time.bins.low_deg.min()), float(sketch.time.bins.up_deg.max())


def _time(sketch: SeriesSketch, start_ns: int, name: str, bands: Sequence[_Band],
          gap_s: float) -> Markup:
    """Draw the differences against time: extremes and mean of each bin."""
    envelope, levels = sketch.time, list(_extremes(sketch))
    for band in bands:
        levels += [level for level, _, _ in band.lines()]
    at = np.flatnonzero(envelope.bins.n)
    width_s = envelope.width_ns / 1e9
    span_s = float(at[-1] + 1) * width_s
    unit_s, unit = next((s, u) for least, s, u in
                        ((10800.0, 3600.0, 'h'), (600.0, 60.0, 'min'), (0.0, 1.0, 's'))
                        if span_s >= least)
    plot = Plot((0.0, span_s / unit_s), _pad(min(levels), max(levels)),
                title=f'{name}: difference against time, n = {sketch.n}',
                x_label=f'time since {utc(start_ns)} UTC [{unit}]',
                y_label='difference TS - RS [deg]')
    time = (at + 0.5) * width_s / unit_s
    cuts = np.flatnonzero(np.diff(at) * width_s > max(gap_s, 2.0 * width_s)) + 1
    low, mean, up = (column[at] for column in (envelope.bins.low_deg, envelope.bins.mean_deg,
                                               envelope.bins.up_deg))
    for k, part in enumerate(np.split(np.arange(len(at)), cuts)):
        t, first = time[part].tolist(), not k
        plot.band(list(zip(t, low[part].tolist())), list(zip(t, up[part].tolist())),
                  legend=f'least to largest in {number(width_s)} s' if first else '')
        plot.line(list(zip(t, mean[part].tolist())), width=0.9,
                  legend='mean of the same' if first else '')
        if len(part) == 1:
            plot.dots([(t[0], float(mean[part[0]]))])
    for k, band in enumerate(bands):
        ends = [max(0.0, (stamp_ns - start_ns) / 1e9 / unit_s)
                for stamp_ns in (band.run.start_ns, band.run.end_ns)]
        for level, dash, words in band.lines():
            plot.horizontal(level, (ends[0], max(ends[1], ends[0] + width_s / unit_s)),
                            dash=dash, legend=words if not k else '')
        if len(bands) > 1:
            plot.vertical(ends[0], width=0.8, dash='1 3',
                          legend='start of a run' if not k else '')
    return plot.svg()


def _choose_axis(sketch: SeriesSketch, bands: Sequence[_Band]) -> tuple[float, float, int]:
    """Return the ends of the histogram's axis, and how many differences lie beyond."""
    low, up = _extremes(sketch)
    limits = [level for band in bands for level, _, _ in band.lines()]
    if limits:
        least, most = min(limits), max(limits)
        near, far = least - (most - least), most + (most - least)
        if low < near or up > far:
            edges = sketch.histogram.edges_deg()
            lost = int(sketch.histogram.counts[(edges[:-1] < near) | (edges[1:] > far)].sum())
            if lost <= _LOST_AT_MOST * sketch.n:
                return near, far, lost
        low, up = min(low, least), max(up, most)
    return (*_pad(low, up), 0)


def _draw_histogram(sketch: SeriesSketch, name: str, bands: Sequence[_Band]) -> Markup:
    """Draw how many differences have which size."""
    histogram = sketch.histogram
    low, up, lost = _choose_axis(sketch, bands)
    joint = 1
    while (up - low) / (joint * histogram.width_deg) > _HISTOGRAM_BARS:
        joint *= 2
    width = joint * histogram.width_deg
    at = (histogram.first + np.arange(len(histogram.counts))) // joint
    counts = np.bincount(at - at[0], histogram.counts)
    beyond = f', {lost} beyond the axis' if lost else ''
    plot = Plot((low, up), (0.0, 1.08 * float(counts.max())),
                title=f'{name}: size of the differences, n = {sketch.n}{beyond}',
                x_label='difference TS - RS [deg]', y_label=f'number in {number(width, 3)} deg')
    plot.bars([((at[0] + k) * width, (at[0] + k + 1) * width, 0.0, float(n))
               for k, n in enumerate(counts.tolist()) if n and low <= (at[0] + k + 1) * width
               and (at[0] + k) * width <= up], stroke='#555555')
    if len(bands) == 1:
        for level, dash, words in bands[0].lines():
            plot.vertical(level, dash=dash, legend=words)
    elif bands:
        for pick, words in ((min, ''), (max, 'outermost limits of GK (*) of the runs')):
            plot.vertical(pick(level for band in bands for level, _, _ in band.lines()),
                          dash=_LIMIT, legend=words)
    return plot.svg()


def _heading(sketch: SeriesSketch, name: str, bands: Sequence[_Band],
             norm_deg: float | None) -> Markup:
    """Draw mean and standard deviation against the RS heading."""
    bins, width = sketch.heading, 360.0 / HEADING_BINS
    at = np.flatnonzero(bins.n)
    x, mean = (at + 0.5) * width, bins.mean_deg[at]
    std = np.nan_to_num(bins.std_deg[at], nan=0.0)
    lines = [(norm_deg * sign, _NORM, 'norm of the total error' if sign > 0 else '')
             for sign in (1.0, -1.0)] if norm_deg is not None else []
    if bands:
        low = min(band.center_deg - band.sigma_deg for band in bands)
        up = max(band.center_deg + band.sigma_deg for band in bands)
        words = 'mean +/- root of the limit of GK (5)'
        lines += [(up, _SIGMA, words), (low, _SIGMA, '')]
    levels = [*(mean - std).tolist(), *(mean + std).tolist(), *(level for level, _, _ in lines)]
    plot = Plot((0.0, 360.0), _pad(min(levels), max(levels)), x_step=45.0,
                title=f'{name}: difference against heading, n = {sketch.n}',
                x_label='RS heading [deg]', y_label='difference TS - RS [deg]')
    for k, (place, m, s) in enumerate(zip(x.tolist(), mean.tolist(), std.tolist())):
        plot.line([(place, m - s), (place, m + s)], width=1.2,
                  legend='+/- its standard deviation' if not k else '')
    plot.dots(list(zip(x.tolist(), mean.tolist())), legend=f'mean in {number(width)} deg')
    for level, dash, words in lines:
        plot.horizontal(level, dash=dash, legend=words)
    return plot.svg()
