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

"""The figures against what the difference may depend on: heading, rate of turn, time skew."""

from __future__ import annotations

from typing import Any, Iterator, Sequence

import numpy as np

from heading_intercompare.core.diagnostics.by_motion import ByRate, BySector
from heading_intercompare.core.records import Reals
from heading_intercompare.report.formatting import number
from heading_intercompare.report.series_sketch import HEADING_BINS

from .drawing import add_remark, Drawing, fit_axis, LeftOut, SERIES, SIGMA, START, Subject, UNIT

_NORM: dict[str, Any] = {'color': '#000000', 'linewidth': 1.2, 'linestyle': (0, (16.0, 4.0))}
_LEAST_IN_BIN = 5
#: Bins of the heading that a bar of the figure joins: 10 degrees.
_JOINED = 4
_LEAST_BINS = 4
#: The means between these shares are on the axis.
_MIDDLE = (0.05, 0.95)
_BARS: dict[str, Any] = {'color': '#767676', 'linewidth': 1.4}
_Y_LABEL = 'difference TS - RS [deg]'
_INTERVALS: dict[str, Any] = {'color': '#000000', 'fmt': 'D', 'markersize': 4.5,
                              'markerfacecolor': 'none', 'capsize': 3.0, 'linewidth': 1.2}


def _harmonics(coefficients: tuple[float, ...], heading_deg: Reals) -> Reals:
    """Return A + B sin + C cos + D sin 2 + E cos 2 of headings."""
    psi = np.radians(heading_deg)
    a, b, c, d, e = coefficients
    deviation_deg: Reals = (a + b * np.sin(psi) + c * np.cos(psi) + d * np.sin(2.0 * psi)
                            + e * np.cos(2.0 * psi))
    return deviation_deg


def _draw_intervals(axes: Any, at: Sequence[float], means: BySector | ByRate, label: str) -> None:
    """Draw the means of a run that have an interval; without any nothing."""
    rows = [(x, mean, low, up) for x, mean, low, up in zip(
        at, means.mean_deg, means.low_deg, means.up_deg) if None not in (mean, low, up)]
    if rows:
        x, mean, low, up = np.array(rows, np.float64).T
        axes.errorbar(x, mean, (mean - low, up - mean), **_INTERVALS, label=label)


def draw_against_heading(about: Subject) -> Iterator[Drawing | LeftOut]:
    """Yield the figure of mean and standard deviation against the RS heading, with harmonics."""
    width = 360.0 / HEADING_BINS * _JOINED
    bins = about.sketch.heading.join(_JOINED)
    at = np.flatnonzero(bins.n)
    x, mean = (at + 0.5) * width, bins.mean_deg[at]
    std = np.nan_to_num(bins.std_deg[at], nan=0.0)
    norm_deg = about.settings.norms.total_error_max_deg
    lines = [(norm_deg * sign, _NORM, 'norm of the total error' if sign > 0 else None)
             for sign in (1.0, -1.0)] if norm_deg is not None else []
    runs = about.counted_runs
    counted = {run.run for run in runs}
    bands = [band for band in about.bands if band.run.run in counted]
    if bands:
        low = min(band.center_deg - band.sigma_deg for band in bands)
        up = max(band.center_deg + band.sigma_deg for band in bands)
        lines += [(up, SIGMA, 'mean +/- root of the limit of GK (5)'), (low, SIGMA, None)]
    blocks = [run.by_motion for run in runs if run.by_motion is not None]
    fits = [fit for run in runs
            if (fit := run.heading_dependence.coefficients_deg) is not None]
    why_not = sorted({run.heading_dependence.reason.replace('_', ' ') for run in runs
                      if run.heading_dependence.coefficients_deg is None})
    levels = [*(mean - std).tolist(), *(mean + std).tolist(), *(level for level, _, _ in lines)]
    axis_low, axis_up, beyond = fit_axis(min(levels), max(levels), about.scale(
        [*(level for level, _, _ in lines), *np.quantile(mean, _MIDDLE).tolist()]))

    def fill(axes: Any) -> None:
        axes.vlines(x, mean - std, mean + std, **_BARS, label='+/- its standard deviation')
        axes.plot(x, mean, 'o', color=SERIES['color'], markersize=4.0,
                  label=f'mean in each {number(width)} deg')
        for k, block in enumerate(blocks):
            _draw_intervals(axes, block.sectors.heading_deg, block.sectors,
                            '' if k else 'steady headings: mean, 95 % interval')
        everywhere = np.arange(0.0, 360.5, 1.0)
        for k, fit in enumerate(fits):
            axes.plot(everywhere, _harmonics(fit, everywhere), **UNIT,
                      label=None if k else 'harmonics A to E of each run' if len(fits) > 1
                      else 'harmonics A to E')
        for level, look, words in lines:
            axes.axhline(level, **look, label=words)
        axes.set_xlim(0.0, 360.0)
        axes.set_xticks(range(0, 361, 45))
        axes.set_ylim(axis_low, axis_up)

    more = f' No harmonics: {" and ".join(why_not)}.' if why_not and not fits else ''
    yield Drawing(
        name='heading', title=about.title('difference against heading'),
        caption=add_remark(
            'A wave of the means about their average is a deviation: one wave a turn is an error '
            'that turns with the ship, two waves a quadrantal one.' + more + about.void_words,
            beyond),
        x_label='RS heading [deg]', y_label=_Y_LABEL, fill=fill)


def draw_against_rate(about: Subject) -> Iterator[Drawing | LeftOut]:
    """Yield the figure of the differences against the rate of turn."""
    turning = about.sketch.turning
    bins, rate = turning.bins, turning.rate_deg_s
    n = int(bins.n.sum())
    at = np.flatnonzero(bins.n >= min(_LEAST_IN_BIN, max(1, n // 50)))
    title = about.title('difference against rate of turn', n)
    if len(at) < _LEAST_BINS:
        yield LeftOut('rate', title, 'the record has no rate of turn: too few seconds that follow '
                      'each other, or a ship that does not turn')
        return
    mean = bins.mean_deg[at]
    std = np.nan_to_num(bins.std_deg[at], nan=0.0)
    axis_low, axis_up, beyond = fit_axis(
        float((mean - std).min()), float((mean + std).max()),
        about.scale(np.quantile(mean, _MIDDLE).tolist()))
    blocks = [run.by_motion.turns for run in about.counted_runs if run.by_motion is not None]
    slopes = [(skew_s, run.mean_deg or 0.0) for run in about.counted_runs
              if (skew_s := run.skew.estimate.skew_s) is not None]

    def fill(axes: Any) -> None:
        axes.vlines(rate[at], mean - std, mean + std, **_BARS, label='+/- standard deviation')
        axes.plot(rate[at], mean, 'o', color=SERIES['color'], markersize=3.5,
                  label=f'mean in each {number(turning.width_deg_s, 3)} deg/s')
        for k, turns in enumerate(blocks):
            _draw_intervals(axes, turns.rate_deg_s, turns,
                            '' if k else 'bands of the verdict: mean, 95 % interval')
        ends = rate[at[[0, -1]]]
        for k, (skew_s, mean_deg) in enumerate(slopes):
            words = ('latency or clock offset '
                     + (f'of {skew_s:.3f} s' if len(slopes) == 1 else 'of each run'))
            axes.plot(ends, mean_deg - skew_s * ends, **UNIT, label=None if k else words)
        axes.set_ylim(axis_low, axis_up)

    yield Drawing(
        name='rate', title=title,
        caption=add_remark('A line that falls or rises through the points is a latency: '
            'its slope in degrees for each degree per second is minus the age of the TS '
            'data in seconds.' + (' The rate of turn is that of a sensor of its own, which '
                                  'may be late itself.' if turning.measured else '')
            + about.void_words, beyond),
        x_label='rate of turn as reported [deg/s]' if turning.measured else
            'rate of turn of the RS, over 2 s [deg/s]', y_label=_Y_LABEL, fill=fill)


def draw_skew_scan(about: Subject) -> Iterator[Drawing | LeftOut]:
    """Yield the figure of the scatter at each skew that could be removed."""
    shifts = about.sketch.shifts
    scans = [run.skew.scan for run in about.runs if run.skew.scan is not None]
    n = sum(scan.n for scan in scans) if scans else 0 if shifts is None else shifts.n
    title = about.title('scatter against the latency or clock offset removed', n)
    if scans:
        curves = [(np.array(scan.curve_s), np.array(scan.curve_std_deg)) for scan in scans]
    elif shifts is not None and shifts.n > 1:
        curves = [(shifts.latency_s, shifts.std_deg)]
    else:
        yield LeftOut('skew_scan', title, 'the record is too short, or its readings too far '
                      'apart, to shift one sensor against the other')
        return
    ends = np.array([(std_deg.min(), std_deg.max()) for _, std_deg in curves])
    axis_low, axis_up, beyond = fit_axis(
        float(ends.min()), float(ends.max()), (float(ends[:, 0].min()),
                                               float(np.median(ends[:, 1]))))
    estimates = [(run.skew.estimate.skew_s, run.skew.estimate.interval_s) for run in about.runs
                 if run.skew.estimate.skew_s is not None]

    def fill(axes: Any) -> None:
        for k, (shift_s, std_deg) in enumerate(curves):
            axes.plot(shift_s, std_deg, **SERIES, marker='.', markersize=4.0,
                      label=None if k else 'standard deviation')
        for k, (skew_s, interval_s) in enumerate(estimates):
            axes.axvline(skew_s, **UNIT, label=None if k else 'as the verdict estimates')
            if interval_s is not None:
                axes.axvspan(*interval_s, color='#c3d3e6', zorder=0,
                             label=None if k else 'its interval of 95 %')
        axes.axvline(0.0, **START, label='as the stamps say')
        axes.set_ylim(axis_low, axis_up)

    yield Drawing(
        name='skew_scan', title=title, caption=add_remark(
            'The lowest point is the latency or clock offset at which both sensors '
            'agree best; a flat curve means that the ship turned too little to tell. '
            'Interpolation '
            'averages noise and lowers the curve between readings.', beyond),
        x_label='age of the TS data assumed [s]', y_label='standard deviation [deg]', fill=fill,
        height_mm=60.0)
