# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The graphs of a report: the differences in a sketch, and the limits of its runs."""

from __future__ import annotations

import math
from typing import Iterator, Sequence

from matplotlib.axes import Axes
import numpy as np

from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.verdict.verdict_document import RunVerdict, Verdict

from .formatting import number
from .plots import ACCENT, draw, GREY, INK, SHADE
from .series_sketch import HEADING_BINS, SeriesSketch

__all__ = ['draw_graphs']

_Dash = tuple[int, tuple[float, ...]]

#: Dashes of lines.
_LIMIT: _Dash = (0, (9.0, 4.0))
_TIGHTENED: _Dash = (0, (2.0, 2.5))
_SIGMA: _Dash = (0, (9.0, 3.0, 2.0, 3.0))
_NORM: _Dash = (0, (16.0, 4.0))
_START: _Dash = (0, (1.0, 3.0))
_HISTOGRAM_BARS = 120
_LOST_AT_MOST = 0.02


def _runs_of(sketch: SeriesSketch, runs: Sequence[RunVerdict]) -> list[RunVerdict]:
    """Return the runs within the time of a sketch: those of its source, or all if it has none."""
    start_ns, newest_ns = sketch.time.start_ns, sketch.newest_ns
    if start_ns is None or newest_ns is None:
        return []
    inside = [r for r in runs if r.start_ns <= newest_ns and r.end_ns >= start_ns]
    return [r for r in inside if r.source == sketch.source] or inside


def draw_graphs(sketch: SeriesSketch, verdict: Verdict, name: str) -> Iterator[str]:
    """
    Yield the graphs of a sketch in SVG; none if the sketch has no difference.

    Parameters
    ----------
    sketch : SeriesSketch
    verdict : Verdict
        Gives the limits that are drawn, those of the runs in the sketch.
    name : str
        Prefix of the names of its graphs; no other sketch of the page has it.

    """
    start_ns = sketch.time.start_ns
    if not sketch.n or start_ns is None:
        return
    runs = _runs_of(sketch, verdict.runs)
    title = _title(runs)
    bands = [_Band(run, verdict.settings.variant) for run in runs]
    norm = verdict.settings.norms.total_error_max_deg
    yield _draw_time(sketch, start_ns, title, bands, verdict.settings.runs.gap_s, f'{name}-time')
    yield _draw_histogram(sketch, title, bands, f'{name}-size')
    yield _draw_heading(sketch, title, bands, norm, f'{name}-heading')


def _title(runs: Sequence[RunVerdict]) -> str:
    if not runs:
        return 'No run'
    if len(runs) == 1:
        return f'Run {runs[0].run}'
    between = 'and' if len(runs) == 2 else 'to'
    return f'Runs {runs[0].run} {between} {runs[-1].run}'


class _Band:
    """The limits of a run, as deviations from its centre."""

    def __init__(self, run: RunVerdict, variant: str) -> None:
        counts = run.count_criterion
        self.run = run
        self.center_deg = 0.0 if variant == 'A' else run.mean_deg or 0.0
        self.limit_deg = counts.limit_deg
        self.tightened_deg = counts.tightened_limit_deg
        self.sigma_deg = math.sqrt(run.variance_criterion.limit_deg2)

    def lines(self) -> list[tuple[float, _Dash, str | None]]:
        """Return level, dash and legend of each limit; one legend serves both sides."""
        return [(self.center_deg + sign * size, dash, words if sign > 0 else None)
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


def _draw_time(sketch: SeriesSketch, start_ns: int, title: str, bands: Sequence[_Band],
               gap_s: float, name: str) -> str:
    """Draw the differences against time: the extremes and the mean of each bin."""
    envelope, levels = sketch.time, list(_extremes(sketch))
    for band in bands:
        levels += [level for level, _, _ in band.lines()]
    at = np.flatnonzero(envelope.bins.n)
    width_s = envelope.width_ns / 1e9
    span_s = float(at[-1] + 1) * width_s
    unit_s, unit = next((s, u) for least, s, u in
                        ((10800.0, 3600.0, 'h'), (600.0, 60.0, 'min'), (0.0, 1.0, 's'))
                        if span_s >= least)
    time = (at + 0.5) * width_s / unit_s
    low, mean, up = (column[at] for column in (envelope.bins.low_deg, envelope.bins.mean_deg,
                                               envelope.bins.up_deg))
    cuts = np.flatnonzero(np.diff(at) * width_s > max(gap_s, 2.0 * width_s)) + 1
    alone = [part[0] for part in np.split(np.arange(len(at)), cuts) if len(part) == 1]

    def fill(axes: Axes) -> None:
        # The line and the band break where nothing was measured.
        t, least, middle, most = (np.insert(column, cuts, np.nan)
                                  for column in (time, low, mean, up))
        axes.fill_between(t, least, most, color=SHADE, linewidth=0.8,
                          label=f'range in each {number(width_s)} s')
        axes.plot(t, middle, color=ACCENT, linewidth=1.0,
                  label=f'mean in each {number(width_s)} s')
        axes.vlines(time[alone], low[alone], up[alone], color=SHADE, linewidth=2.0)
        axes.plot(time[alone], mean[alone], 'o', color=ACCENT, markersize=3.5, clip_on=False)
        for k, band in enumerate(bands):
            begin, end = (max(0.0, (stamp_ns - start_ns) / 1e9 / unit_s)
                          for stamp_ns in (band.run.start_ns, band.run.end_ns))
            end = max(end, begin + width_s / unit_s)
            for level, dash, words in band.lines():
                axes.plot([begin, end], [level, level], color=INK, linewidth=1.3,
                          linestyle=dash, label=None if k else words)
            if len(bands) > 1:
                axes.axvline(begin, color=GREY, linewidth=1.0, linestyle=_START,
                             label=None if k else 'start of a run')
        axes.set_xlim(0.0, span_s / unit_s)
        axes.set_ylim(*_pad(min(levels), max(levels)))

    return draw(fill, name=name, title=f'{title}: difference against time, n = {sketch.n}',
                x_label=f'time since {utc(start_ns)} UTC [{unit}]',
                y_label='difference TS - RS [deg]')


def _choose_axis(sketch: SeriesSketch, bands: Sequence[_Band]) -> tuple[float, float, int]:
    """Return the ends of the histogram's axis, and the number of differences beyond them."""
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


def _draw_histogram(sketch: SeriesSketch, title: str, bands: Sequence[_Band], name: str) -> str:
    """Draw the histogram of the differences."""
    histogram = sketch.histogram
    low, up, lost = _choose_axis(sketch, bands)
    joint = 1
    while (up - low) / (joint * histogram.width_deg) > _HISTOGRAM_BARS:
        joint *= 2
    width = joint * histogram.width_deg
    at = (histogram.first + np.arange(len(histogram.counts))) // joint
    counts = np.bincount(at - at[0], histogram.counts)
    edges = (at[0] + np.arange(len(counts) + 1)) * width
    beyond = f', {lost} beyond the axis' if lost else ''

    def fill(axes: Axes) -> None:
        axes.stairs(counts, edges, fill=True, color=SHADE)
        axes.stairs(counts, edges, color=ACCENT, linewidth=0.9)
        if len(bands) == 1:
            for level, dash, words in bands[0].lines():
                axes.axvline(level, color=INK, linewidth=1.3, linestyle=dash, label=words)
        elif bands:
            for pick, words in ((min, None), (max, 'outermost limits of GK (*) of the runs')):
                axes.axvline(pick(level for band in bands for level, _, _ in band.lines()),
                             color=INK, linewidth=1.3, linestyle=_LIMIT, label=words)
        axes.set_xlim(low, up)
        axes.set_ylim(0.0, 1.08 * float(counts.max()))

    return draw(fill, name=name,
                title=f'{title}: size of the differences, n = {sketch.n}{beyond}',
                x_label='difference TS - RS [deg]', y_label=f'number in {number(width, 3)} deg')


def _draw_heading(sketch: SeriesSketch, title: str, bands: Sequence[_Band],
                  norm_deg: float | None, name: str) -> str:
    """Draw mean and standard deviation against the RS heading."""
    bins, width = sketch.heading, 360.0 / HEADING_BINS
    at = np.flatnonzero(bins.n)
    x, mean = (at + 0.5) * width, bins.mean_deg[at]
    std = np.nan_to_num(bins.std_deg[at], nan=0.0)
    lines = [(norm_deg * sign, _NORM, 'norm of the total error' if sign > 0 else None)
             for sign in (1.0, -1.0)] if norm_deg is not None else []
    if bands:
        low = min(band.center_deg - band.sigma_deg for band in bands)
        up = max(band.center_deg + band.sigma_deg for band in bands)
        words = 'mean +/- root of the limit of GK (5)'
        lines += [(up, _SIGMA, words), (low, _SIGMA, None)]
    levels = [*(mean - std).tolist(), *(mean + std).tolist(), *(level for level, _, _ in lines)]

    def fill(axes: Axes) -> None:
        axes.vlines(x, mean - std, mean + std, color=GREY, linewidth=1.6,
                    label='+/- its standard deviation')
        axes.plot(x, mean, 'o', color=ACCENT, markersize=4.5,
                  label=f'mean in each {number(width)} deg')
        for level, dash, words in lines:
            axes.axhline(level, color=INK, linewidth=1.3, linestyle=dash, label=words)
        axes.set_xlim(0.0, 360.0)
        axes.set_xticks(range(0, 361, 45))
        axes.set_ylim(*_pad(min(levels), max(levels)))

    return draw(fill, name=name, title=f'{title}: difference against heading, n = {sketch.n}',
                x_label='RS heading [deg]', y_label='difference TS - RS [deg]')
