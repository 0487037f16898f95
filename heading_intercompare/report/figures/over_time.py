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

"""The figures against time: both headings, the differences, and the variance as it grew."""

from __future__ import annotations

import math
from typing import Any, Iterator

import numpy as np

from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.records import Integers, Reals
from heading_intercompare.core.statistics.confidence_bounds import interval_factors
from heading_intercompare.core.time_rules.exclusions import find_excluded, read_exclusions
from heading_intercompare.core.verdict.verdict_document import RunVerdict
from heading_intercompare.report.formatting import number

from .drawing import (
    days,
    Drawing,
    fit_axis,
    LeftOut,
    LIMIT,
    RANGE,
    SERIES,
    START,
    Subject,
    TAKEN_OUT,
    TIGHTENED,
)

_UTC = 'time UTC'
#: At most one in this many records of normal differences shows a mark of an outlier.
_RARE = 20.0
#: Degrees of freedom from which on the growing variance decides on the scale of its figure.
_LEAST_NU = 8.0
_LEAST_SHARE = 1e-6
_MARKS = {'compliant': 'o', 'non_compliant': 'X', 'indeterminate': 'D'}
_LOOKS = 'looks: circle compliant, cross not, diamond undecided'


class Times:
    """The bins of time of a sketch that hold differences, and where lines break."""

    def __init__(self, about: Subject) -> None:
        envelope = about.sketch.time
        self.at = np.flatnonzero(envelope.bins.n)
        self.width_s = envelope.width_ns / 1e9
        middle = about.start_ns + self.at * envelope.width_ns + envelope.width_ns // 2
        self.days = days(np.minimum(middle, about.sketch.newest_ns or about.start_ns))
        gap_s = max(about.settings.runs.gap_s, 2.0 * self.width_s)
        self.cuts = np.flatnonzero(np.diff(self.at) * self.width_s > gap_s) + 1

    def broken(self, column: Reals) -> Reals:
        """Return a column with nan where a line must break."""
        return np.insert(column, self.cuts, np.nan)

    @property
    def alone(self) -> Integers:
        """Bins without neighbours, to which no line leads."""
        parts = np.split(np.arange(len(self.at)), self.cuts)
        return np.array([part[0] for part in parts if len(part) == 1], np.int64)


def _span(axes: Any, about: Subject) -> None:
    """Let the axis of time run over the whole record, and mark where runs start."""
    first, last = days(about.start_ns), days(about.sketch.newest_ns or about.start_ns)
    axes.set_xlim(first, max(last, first + 1e-5))
    shown = [exclusion for exclusion in read_exclusions(about.settings.exclusions)
             if exclusion.start_ns <= (about.sketch.newest_ns or 0)
             and exclusion.end_ns > about.start_ns]
    for k, exclusion in enumerate(shown):
        axes.axvspan(days(exclusion.start_ns), days(exclusion.end_ns), **TAKEN_OUT,
                     label=None if k else 'taken out by hand')
    if len(about.runs) > 1:
        for k, run in enumerate(about.runs):
            axes.axvline(days(run.start_ns), **START, label=None if k else 'start of a run')


def draw_headings(about: Subject) -> Iterator[Drawing | LeftOut]:
    """Yield the figure of both headings against time."""
    times, sketch = Times(about), about.sketch
    bins = sketch.rs_time.bins
    line, low, up = (column[times.at] for column in (bins.mean_deg, bins.low_deg, bins.up_deg))
    rs = wrap360(line)
    ts = wrap360(line + sketch.time.bins.mean_deg[times.at] + sketch.offset_deg)

    def fill(axes: Any) -> None:
        # A turn through north is no line across the figure.
        t = times.broken(times.days)
        turn = np.floor(low.min() / 360.0)
        while turn * 360.0 <= up.max():
            axes.fill_between(t, times.broken(low) - 360.0 * turn,
                              times.broken(up) - 360.0 * turn, **RANGE,
                              label=None if turn > np.floor(low.min() / 360.0) else
                              f'range of the RS in each {number(times.width_s)} s')
            turn += 1.0
        for heading, look, words in (
                (rs, {**SERIES, 'linewidth': 2.6, 'alpha': 0.55}, 'RS'),
                (ts, {'color': '#000000', 'linewidth': 0.9, 'linestyle': (0, (3.0, 1.5))}, 'TS')):
            jumps = np.flatnonzero(np.abs(np.diff(heading)) > 180.0) + 1
            cuts = np.union1d(jumps, times.cuts)
            axes.plot(np.insert(times.days, cuts, np.nan), np.insert(heading, cuts, np.nan),
                      **look, label=f'{words}, mean in each {number(times.width_s)} s')
            axes.plot(times.days[times.alone], heading[times.alone], 'o', color=look['color'],
                      markersize=3.0)
        axes.set_ylim(0.0, 360.0)
        axes.set_yticks(range(0, 361, 90))
        _span(axes, about)

    yield Drawing(
        name='headings', title=about.title('both headings'), caption=(
            'Both lines must lie on each other; '
            'the figures below show the small difference between them.'), x_label=_UTC,
        y_label='heading [deg]', fill=fill, is_time=True, height_mm=60.0)


def find_far(about: Subject, times: Times) -> tuple[Reals, Reals]:
    """Return times and values of the extremes farther out than n normal values reach."""
    bins = about.sketch.time.bins
    low, middle, up = about.sketch.histogram.quantiles_deg(0.05, 0.5, 0.95)
    # Half the width of nine tenths is 1.645 standard deviations, whatever a few outliers do.
    sigma = 0.5 * (up - low) / 1.645
    reach = sigma * math.sqrt(2.0 * math.log(_RARE * max(2, about.sketch.n)))
    values = np.concatenate((bins.low_deg[times.at], bins.up_deg[times.at]))
    far = np.abs(values - middle) > reach
    return np.tile(times.days, 2)[far], values[far]


def draw_differences(about: Subject) -> Iterator[Drawing | LeftOut]:
    """Yield the figure of the differences against time, with limits, runs and outliers."""
    times = Times(about)
    axis_low, axis_up, beyond = fit_axis(*about.extremes(), about.scale(about.limits_deg()))
    bins = about.sketch.time.bins
    low, mean, up = (column[times.at] for column in (bins.low_deg, bins.mean_deg, bins.up_deg))
    far_days, far = find_far(about, times)

    def fill(axes: Any) -> None:
        axes.fill_between(times.broken(times.days), times.broken(low), times.broken(up), **RANGE,
                          label=f'range in each {number(times.width_s)} s')
        axes.plot(times.broken(times.days), times.broken(mean), **SERIES,
                  label=f'mean in each {number(times.width_s)} s')
        alone = times.alone
        axes.vlines(times.days[alone], low[alone], up[alone], color=RANGE['color'], linewidth=2.0)
        axes.plot(times.days[alone], mean[alone], 'o', color=SERIES['color'], markersize=3.0,
                  clip_on=False)
        for k, band in enumerate(about.bands):
            for level, look, words in band.lines():
                axes.plot(days(np.array([band.run.start_ns, band.run.end_ns])), [level, level],
                          **look, label=None if k else words)
        if len(far):
            axes.plot(far_days, far, 'x', color='#d55e00', markersize=5.0, markeredgewidth=1.2,
                      label=f'outliers, in {len(far)} ranges')
        outside = (low < axis_low, up > axis_up)
        for level, at, sign in zip((axis_low, axis_up), outside, 'v^'):
            if at.any():
                axes.plot(times.days[at], np.full(np.count_nonzero(at), level), sign,
                          color='#d55e00', markersize=6.0, markeredgecolor='#000000',
                          clip_on=False, label=beyond if at is outside[-1] or not outside[-1].any()
                          else None)
        axes.set_ylim(axis_low, axis_up)
        _span(axes, about)

    yield Drawing(
        name='differences', title=about.title('difference against time'), caption=(
            'The differences must stay between the dashed limits, without drift or steps; a '
            'cross marks a value farther out than this many normal values reach.'
            + about.moved), x_label=_UTC,
        y_label='difference TS - RS [deg]', fill=fill, is_time=True)


def _grow(about: Subject, run: RunVerdict) -> tuple[Integers, Integers, Reals]:
    """Return stamp, number and variance after each bin of time of a run."""
    envelope = about.sketch.time
    bins, width_ns = envelope.bins, envelope.width_ns
    end_ns = about.start_ns + (np.arange(len(bins.n)) + 1) * width_ns
    # The stabilisation period is no part of the run that is judged.
    in_run = (end_ns - width_ns >= run.end_ns - _analysed_ns(run)) & (
        end_ns - width_ns <= run.end_ns) & (bins.n > 0)
    in_run &= find_excluded(end_ns - width_ns // 2, read_exclusions(about.settings.exclusions)) < 0
    n, mean, m2 = bins.n[in_run], bins.mean_deg[in_run], bins.m2_deg2[in_run]
    if not len(n):
        return end_ns[:0], n, mean
    reference = mean[0]
    total, shifted = np.cumsum(n), np.cumsum(n * (mean - reference))
    squares = np.cumsum(m2 + n * (mean - reference) ** 2) - shifted ** 2 / total
    return (np.minimum(end_ns[in_run], run.end_ns), total,
            squares / np.maximum(total - 1, 1))


def _analysed_ns(run: RunVerdict) -> int:
    """Return the length of the part of a run that is analysed."""
    share = run.n / max(1, run.n + run.n_stabilization)
    return round((run.end_ns - run.start_ns) * share)


def _draw_limits(axes: Any, run: RunVerdict, ends: Any, is_first: bool) -> Iterator[float]:
    """Draw the limits of a run from end to end, and yield them."""
    variances = run.variance_criterion
    for level, line, words in (
            (variances.limit_deg2, LIMIT, 'limit of GK (5)'),
            (variances.tightened_limit_deg2, TIGHTENED, "tightened limit of GK (5')")):
        axes.plot(ends, [level, level], **line, label=words if is_first else None)
        yield level


def draw_running_variance(about: Subject) -> Iterator[Drawing | LeftOut]:
    """Yield the figure of the variance from the start of each run on, with bounds and looks."""
    title = about.title('variance as the run went on', sum(r.n for r in about.runs))
    grown = [(run, *_grow(about, run)) for run in about.runs]
    grown = [curve for curve in grown if len(curve[2]) > 2 and curve[0].guarded.nu
             and curve[3][-1] > 0.0]
    if not grown:
        yield LeftOut('running_variance', title, 'no run has enough differences for bounds')
        return
    if about.settings.drift_order != 0:
        yield LeftOut('running_variance', title, 'the verdict removes a drift, which is known '
                      'only at the end of a run')
        return

    def fill(axes: Any) -> None:
        levels: list[float] = []
        for k, (run, stamps, n, variance) in enumerate(grown):
            t = days(stamps)
            # Early bounds are those of fewer, equally correlated differences.
            nu = np.maximum((run.guarded.nu or 1.0) * n / n[-1], 1.0)
            low, up = interval_factors(nu, 0.9)
            bounded = nu > _LEAST_NU
            levels.extend((variance * low)[bounded].tolist() + (variance * up)[bounded].tolist())
            axes.fill_between(t[bounded], (variance * low)[bounded], (variance * up)[bounded],
                              **RANGE, label=None if k else 'interval of 90 % at that time')
            axes.plot(t, variance, **SERIES, label=None if k else 'variance so far')
            bounds = [b for b in (run.guarded.lower_bound_deg2, run.guarded.upper_bound_deg2)
                      if b is not None and math.isfinite(b) and b > 0.0]
            axes.plot([t[-1]] * len(bounds), bounds, '_', color='#000000', markersize=12.0,
                      markeredgewidth=1.6, clip_on=False,
                      label=None if k else 'bounds of the verdict')
            first_ns = run.end_ns - _analysed_ns(run)
            for j, look in enumerate(run.looks):
                at_ns = first_ns + round(look.span_s * 1e9)
                axes.plot(days(at_ns), np.interp(days(at_ns), t, variance), _MARKS[look.outcome],
                          color='#d55e00', markersize=6.0, markeredgecolor='#000000',
                          label=None if k or j else _LOOKS)
            levels += [*_draw_limits(axes, run, t[[0, -1]], is_first=not k), *bounds]
        axes.set_yscale('log')
        shown = [level for level in levels if level > _LEAST_SHARE * max(levels)]
        axes.set_ylim(0.8 * min(shown), 1.25 * max(shown))
        _span(axes, about)

    yield Drawing(
        name='running_variance', title=title, caption=(
            'The run complies when the whole interval has '
            'come to lie below the limit, and fails when it lies above; the bounds of the '
            'verdict also allow for slow errors.'), x_label=_UTC, y_label='variance [deg^2]',
        fill=fill, is_time=True)
