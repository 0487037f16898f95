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

"""The figures of the correlation in time: autocorrelation, spectrum and Allan deviation."""

from __future__ import annotations

import math
from typing import Any, Iterator

import numpy as np

from heading_intercompare.core.records import Reals
from heading_intercompare.core.statistics.autocorrelation import allan_dof
from heading_intercompare.core.statistics.confidence_bounds import interval_factors
from heading_intercompare.report.sketching.spectra import JOINED, LAGS, Level, SEGMENT

from .drawing import Drawing, LeftOut, LIMIT, RANGE, SERIES, Subject, UNIT

_PER_OCTAVE = 8
_LAGS_DRAWN = 200
#: Neighbouring lines of a spectrum with Hann's window that count as one.
_HANN = 1.5
_FEW = 'fewer than 64 differences follow each other'
_MARKERS = 'osD^v'


def _levels(about: Subject) -> list[Level]:
    return [] if about.sketch.spectra is None else about.sketch.spectra.levels()


def draw_autocorrelation(about: Subject) -> Iterator[Drawing | LeftOut]:
    """Yield the autocorrelation over the logarithm of the lag."""
    levels, step_s = _levels(about), about.step_s
    title = about.title('autocorrelation')
    if not levels or step_s is None or levels[0].covariance_deg2[0] <= 0.0:
        yield LeftOut('autocorrelation', title, _FEW)
        return
    whole = levels[0].covariance_deg2[0]
    lags, r = np.zeros(0), np.zeros(0)
    for k, level in enumerate(levels):
        at = np.arange(1 if k == 0 else LAGS // JOINED + 1, len(level.covariance_deg2))
        # As many lags to the octave as a figure can show.
        drawn_lags = np.unique(np.rint(np.geomspace(at[0], at[-1], _LAGS_DRAWN)).astype(np.int64)
                               ) if len(at) > 1 else at
        lags = np.concatenate((lags, drawn_lags * float(level.joined) * step_s))
        r = np.concatenate((r, level.covariance_deg2[drawn_lags] / whole))
    n_eff = min((run.correlation.n_effective_variance for run in about.runs), default=0.0)
    bound = 1.96 / math.sqrt(n_eff) if n_eff > 4.0 else None
    taus = [tau for run in about.runs if (tau := run.correlation.tau_1_s)]

    means = (f' Beyond {LAGS * step_s:.3g} s it is that of means over {JOINED}, {JOINED ** 2} and '
             'more values.' if len(levels) > 1 else '')

    def fill(axes: Any) -> None:
        if bound is not None:
            axes.axhspan(-bound, bound, color=RANGE['color'], label='95 % of what chance gives '
                         'at long lags')
        axes.axhline(0.0, color='#000000', linewidth=0.7)
        axes.plot(lags, r, **SERIES, label='autocorrelation')
        for k, tau in enumerate(taus):
            axes.axvline(tau, **UNIT, label=None if k else 'correlation time of the mean')
        axes.set_xscale('log')
        axes.set_ylim(min(-0.3, 1.1 * float(r.min())), 1.05)

    yield Drawing(
        name='autocorrelation', title=title,
        caption='The longer the line stays above the band, the fewer '
            'independent values the record holds, and the longer it must be.' + means,
        x_label='lag [s]', y_label='autocorrelation', fill=fill)


def _join(level: Level, lowest: float, highest: float) -> tuple[Reals, Reals, Reals]:
    """Return frequency, spectrum and degrees of freedom in parts of an octave; per sample."""
    at = np.arange(1, (level.length + 1) // 2)
    at = at[(at >= lowest * level.length) & (at <= highest * level.length)]
    if not len(at):
        return np.zeros(0), np.zeros(0), np.zeros(0)
    octave = np.floor(np.log2(at) * _PER_OCTAVE).astype(np.int64)
    octave -= octave[0]
    count = np.bincount(octave)
    with_any = count > 0
    power = np.bincount(octave, level.power_deg2[at])[with_any] / count[with_any]
    f = np.exp(np.bincount(octave, np.log(at / level.length))[with_any] / count[with_any])
    dof = 2.0 * level.segments * np.maximum(1.0, count[with_any] / _HANN)
    return f, power, dof


def draw_spectrum(about: Subject) -> Iterator[Drawing | LeftOut]:
    """Yield the power spectral density of the differences."""
    levels, step_s = _levels(about), about.step_s
    title = about.title('power spectral density')
    if not levels or step_s is None or levels[0].covariance_deg2[0] <= 0.0:
        yield LeftOut('spectrum', title, _FEW)
        return
    parts = []
    for k, level in enumerate(levels):
        # Means over eight are sound up to an eighth of their rate; there the level before takes
        # over.
        lowest = 1.0 / SEGMENT if k + 1 == len(levels) else 1.0 / JOINED ** 2
        f, power, dof = _join(level, max(lowest, 2.0 / level.length),
                              0.5 if k == 0 else 1.0 / JOINED)
        rate_hz = 1.0 / (step_s * level.joined)
        parts.append((f * rate_hz, power / rate_hz, dof))
    f, power, dof = (np.concatenate(columns) for columns in zip(*parts))
    order = np.argsort(f)
    f, power, dof = f[order], power[order], dof[order]
    low, up = interval_factors(dof)

    def fill(axes: Any) -> None:
        axes.fill_between(f, power * low, power * up, **RANGE, label='interval of 95 %')
        axes.plot(f, power, **SERIES, label='density')
        axes.set_xscale('log')
        axes.set_yscale('log')

    yield Drawing(
        name='spectrum', title=title, caption=(
            'A level line is white noise, a rise to the left a slow '
            'error, and a peak a motion of the ship that the sensors do not share.'),
        x_label='frequency [Hz]', y_label='density [deg^2/Hz]', fill=fill)


def draw_allan_deviation(about: Subject) -> Iterator[Drawing | LeftOut]:
    """Yield the Allan deviation of each run, with its bounds."""
    runs = [run for run in about.runs if len(run.allan.m) > 1
            and any(d > 0.0 for d in run.allan.deviation_deg)]
    title = about.title('Allan deviation', sum(run.n for run in runs))
    if not runs:
        yield LeftOut('allan', title, 'no run has enough differences')
        return

    def fill(axes: Any) -> None:
        for k, run in enumerate(runs):
            tau = np.array(run.allan.tau_s)
            deviation = np.array(run.allan.deviation_deg)
            low, up = interval_factors(allan_dof(np.array(run.allan.m), np.array(run.allan.terms)))
            axes.fill_between(tau, deviation * np.sqrt(low), deviation * np.sqrt(up), **RANGE,
                              alpha=1.0 if len(runs) == 1 else 0.4,
                              label=None if k else 'interval of 95 % for white errors')
            axes.plot(tau, deviation, **SERIES, marker=_MARKERS[k % len(_MARKERS)], markersize=3.0,
                      label=f'run {run.run}' if k < len(_MARKERS) else None)
        first = runs[0].allan
        tau = np.array(first.tau_s)
        axes.plot(tau, first.deviation_deg[0] * np.sqrt(tau[0] / tau), **LIMIT,
                  label='white noise, falls with the root')
        axes.set_xscale('log')
        axes.set_yscale('log')

    yield Drawing(
        name='allan', title=title, caption=(
            'Averaging helps as long as the line falls with the dashed one; '
            'where it levels off or rises, slow errors take over.'), x_label='averaging time [s]',
        y_label='Allan deviation [deg]', fill=fill)
