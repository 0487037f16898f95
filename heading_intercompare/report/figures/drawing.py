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

"""What a figure shows before it is drawn, or why it is left out; and the record it is about."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Any, Callable, Sequence

import numpy as np

from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.decision.error_models import density, tail
from heading_intercompare.core.records import Integers, Reals
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.utc_text import DAY_NS
from heading_intercompare.core.validity.condition import VOID
from heading_intercompare.core.verdict.verdict_document import RunVerdict, Verdict
from heading_intercompare.report.series_sketch import SeriesSketch

SVG_STYLE = """svg { width: 100%; height: auto; cursor: zoom-in }
@media screen { svg:focus { width: 250%; cursor: zoom-out } }"""
"""Style sheet of a page with figures: the figure with the focus is enlarged."""


#: Looks of lines. Each kind also has a dash or a width of its own, so that it needs no colour.
#: Orange is that of Okabe and Ito. All differ in lightness, and for the colour-blind.
SERIES: dict[str, Any] = {'color': '#1b4f8a', 'linewidth': 1.0}
MEAN: dict[str, Any] = {'color': '#000000', 'linewidth': 0.9, 'linestyle': (0, (1.0, 1.2))}
RANGE: dict[str, Any] = {'color': '#c3d3e6', 'linewidth': 0.8}
LIMIT: dict[str, Any] = {'color': '#000000', 'linewidth': 1.2, 'linestyle': (0, (9.0, 4.0))}
TIGHTENED: dict[str, Any] = {'color': '#000000', 'linewidth': 1.2, 'linestyle': (0, (2.0, 2.5))}
SIGMA: dict[str, Any] = {'color': '#000000', 'linewidth': 1.2,
                         'linestyle': (0, (9.0, 3.0, 2.0, 3.0))}
UNIT: dict[str, Any] = {'color': '#d55e00', 'linewidth': 1.4, 'linestyle': (0, (6.0, 2.0))}
TAKEN_OUT: dict[str, Any] = {'facecolor': 'none', 'edgecolor': '#767676', 'hatch': '////',
                             'linewidth': 0.0}
#: A mean has moved if it differs by more than this share of the usual scatter from the start.
_MOVED = 0.5
_FIRST_PART = 0.25

START: dict[str, Any] = {'color': '#767676', 'linewidth': 1.0, 'linestyle': (0, (1.0, 3.0))}


@dataclass(frozen=True, slots=True)
class Drawing:
    """
    A figure that can be drawn.

    Attributes
    ----------
    name
        Its name among the figures of a record, such as 'histogram'.
    title
        Says what, of which run, and of how many values; a screen reader reads it aloud.
    caption
        How to read it, in a sentence.
    x_label, y_label
        With the units.
    fill
        Draws into given axes of matplotlib. Everything it labels gets a legend below them.
    is_time
        Whether the x axis is time: days since 1970, from `days`.
    height_mm
        Height without the legend; the width is that of the text on A4.

    """

    name: str
    title: str
    caption: str
    x_label: str
    y_label: str
    fill: Callable[[Any], object]
    is_time: bool = False
    height_mm: float = 70.0


@dataclass(frozen=True, slots=True)
class LeftOut:
    """A figure that cannot be drawn: its name, its title, and why."""

    name: str
    title: str
    reason: str


def days(stamp_ns: Integers | int) -> Reals:
    """Return stamps as days since 1970, the unit of a time axis; to a microsecond."""
    stamp = np.asarray(stamp_ns, np.int64)
    return stamp // DAY_NS + (stamp % DAY_NS) / DAY_NS


def pad(low: float, up: float) -> tuple[float, float]:
    """Return the ends of an axis that shows a range with a margin."""
    margin = 0.06 * (up - low) or max(abs(low), 1.0) * 1e-3
    return low - margin, up + margin


def fit_axis(low: float, up: float, scale: tuple[float, float]) -> tuple[float, float, str]:
    """
    Return the ends of an axis, and in words how far the values go that it leaves out.

    Parameters
    ----------
    low, up
        The least and the largest value, degrees.
    scale
        The values that a figure must show, such as its limits. The axis reaches one width of
        these beyond them, so a few wild values do not flatten all others.

    Examples
    --------
    >>> fit_axis(-0.2, 90.0, (-1.0, 1.0))
    (-1.24, 3.0, 'beyond the axis: as far as 90 deg')

    """
    least, most = scale
    width = most - least or max(abs(most), 1.0)
    near, far = least - width, most + width
    shown_low, shown_up = max(min(low, least), near), min(max(up, most), far)
    padded_low, padded_up = pad(shown_low, shown_up)
    lost = [value for value in (low, up) if not near <= value <= far]
    axis_low = near if low < near else padded_low
    axis_up = far if up > far else padded_up
    words = ' and '.join(f'{value:.3g}' for value in lost)
    return axis_low, axis_up, f'beyond the axis: as far as {words} deg' if lost else ''


def _find_early(sketch: SeriesSketch, run: RunVerdict) -> float | None:
    """Return the median of the first quarter of a run, degrees; None without a difference."""
    envelope = sketch.time
    if envelope.start_ns is None:
        return None
    middle_ns = (envelope.start_ns + np.arange(len(envelope.bins.n)) * envelope.width_ns
                 + envelope.width_ns // 2)
    end_ns = run.start_ns + round(_FIRST_PART * (run.end_ns - run.start_ns))
    early = (middle_ns >= run.start_ns) & (middle_ns <= end_ns) & (envelope.bins.n > 0)
    return float(np.median(envelope.bins.mean_deg[early])) if early.any() else None


def add_remark(caption: str, remark: str) -> str:
    """Return a caption with a remark as its last sentence; without one, as it is."""
    return f'{caption} {remark[0].upper()}{remark[1:]}.' if remark else caption


class Band:
    """
    The limits of a run, as differences about its centre; degrees.

    GK counts about the mean. A fault can move the mean, and the limits with it. Then they stand
    where they stood before the fault: about the median of the first quarter of the run. About the
    stated installation angle they stand if the sensors point too far apart to be mounted parallel.
    """

    def __init__(self, run: RunVerdict, settings: Settings,
                 early_deg: float | None = None) -> None:
        counts = run.count_criterion
        self.run = run
        self.center_deg, self.moved = _find_center(run, settings, early_deg)
        self.limit_deg = counts.limit_deg
        self.tightened_deg = counts.tightened_limit_deg
        self.sigma_deg = math.sqrt(run.variance_criterion.limit_deg2)

    def lines(self) -> list[tuple[float, dict[str, Any], str | None]]:
        """Return level, look and legend of each limit; one legend serves both sides."""
        return [(self.center_deg + sign * size, look, words if sign > 0 else None)
                for size, look, words in (
                    (self.limit_deg, LIMIT, 'limit of GK (*), n+ beyond it'),
                    (self.tightened_deg, TIGHTENED,
                     'tightened limit of GK (**), n++ beyond it'))
                for sign in (1.0, -1.0)]


def _find_center(run: RunVerdict, settings: Settings,
                 early_deg: float | None) -> tuple[float, str]:
    """Return the centre of the limits, and about what they stand if not about the mean."""
    mean_deg = run.mean_deg
    if settings.variant == 'A' or mean_deg is None:
        return 0.0, ''
    if abs(mean_deg) > settings.detectors.mean_max_deg:
        return 0.0, 'the installation angle as set, from which its mean is too far away'
    usual_deg = math.sqrt(run.variance_criterion.limit_deg2)
    if early_deg is not None and abs(mean_deg - early_deg) > _MOVED * usual_deg:
        return early_deg, 'the median of its first quarter, because its mean moved later'
    return mean_deg, ''


@dataclass(frozen=True, slots=True)
class Subject:
    """
    A record and its judgement.

    Attributes
    ----------
    sketch
        Holds at least one difference.
    start_ns
        Stamp of the first difference.
    runs
        Those of the record.
    bands
        Their limits.

    """

    sketch: SeriesSketch
    start_ns: int
    settings: Settings
    runs: Sequence[RunVerdict]
    bands: Sequence[Band]

    @classmethod
    def of(cls, sketch: SeriesSketch, verdict: Verdict) -> 'Subject | None':
        """Join a sketch with its runs in a verdict; None if the sketch has no difference."""
        start_ns, newest_ns = sketch.time.start_ns, sketch.newest_ns
        if not sketch.n or start_ns is None or newest_ns is None:
            return None
        inside = [r for r in verdict.runs if r.start_ns <= newest_ns and r.end_ns >= start_ns
                  and (r.clock_segment or 0) == sketch.segment]
        runs = [r for r in inside if r.source == sketch.source] or inside
        return cls(sketch, start_ns, verdict.settings, runs,
                   [Band(run, verdict.settings, _find_early(sketch, run)) for run in runs])

    def title(self, what: str, n: int | None = None) -> str:
        """Return the title of a figure: the runs, what it shows, and of how many values."""
        runs = self.runs
        who = 'No run' if not runs else f'Run {runs[0].run}'
        if len(runs) > 1:
            who = f'Runs {runs[0].run} {"and" if len(runs) == 2 else "to"} {runs[-1].run}'
        return f'{who}: {what}, n = {self.sketch.n if n is None else n}'

    @property
    def counted_runs(self) -> Sequence[RunVerdict]:
        """Return the runs that are not void; all of them if every run is."""
        return [run for run in self.runs if run.validity_effect != VOID] or self.runs

    @property
    def void_words(self) -> str:
        """Return a sentence on the void runs beside others; empty without any."""
        n = len(self.runs) - len(self.counted_runs)
        words = 'The void run has' if n == 1 else f'The {n} void runs have'
        return f' {words} no line here, but the points hold all differences.' if n else ''

    @property
    def step_s(self) -> float | None:
        """Return the usual time from difference to difference, seconds; None if unknown."""
        return next((r.correlation.stamps.typical_s for r in self.runs
                     if r.correlation.stamps.typical_s), None)

    def scale(self, levels_deg: Sequence[float] = ()) -> tuple[float, float]:
        """Return what an axis must show: nine tenths of the differences, and some levels."""
        low, up = self.sketch.histogram.quantiles_deg(0.05, 0.95)
        return min([low, *levels_deg]), max([up, *levels_deg])

    def limits_deg(self) -> list[float]:
        """Return the levels of all limits, degrees."""
        return [level for band in self.bands for level, _, _ in band.lines()]

    @property
    def moved(self) -> str:
        """Return a sentence on the limits that do not stand about the mean of their run."""
        bands = [band for band in self.bands if band.moved]
        if not bands:
            return ''
        more = f' (and {len(bands) - 1} more)' if len(bands) > 1 else ''
        return (f' The limits of run {bands[0].run.run}{more} stand about '
                f'{bands[0].moved}.')

    def extremes(self) -> tuple[float, float]:
        """Return the least and the largest difference, degrees."""
        bins = self.sketch.time.bins
        return float(bins.low_deg.min()), float(bins.up_deg.max())

    def _parts(self) -> list[tuple[float, float, float]]:
        """Return share, mean and standard deviation of each run that has them."""
        moments = [(float(r.n), r.mean_deg, r.std_deg) for r in self.runs
                   if r.n and r.mean_deg is not None and r.std_deg]
        whole = sum(n for n, _, _ in moments)
        return [(n / whole, mean, std) for n, mean, std in moments]

    def _ratio(self) -> float:
        limits = Limits.of(self.settings.norms, self.settings.model)
        return limits.m_up * limits.sigma_ref_max_deg / limits.sigma_max_deg

    def model_density(self, x_deg: Reals) -> Reals | None:
        """Return the density of the error model with the moments of the runs, per degree."""
        parts, ratio = self._parts(), self._ratio()
        if not parts:
            return None
        density_per_deg: Reals = np.sum([
            share / std * density(self.settings.model, ratio, (x_deg - mean) / std)
            for share, mean, std in parts], axis=0)
        return density_per_deg

    def model_share(self, x_deg: Reals) -> Reals | None:
        """Return the share of the differences that the model puts below each value."""
        parts, ratio = self._parts(), self._ratio()
        if not parts:
            return None
        total = np.zeros(len(x_deg))
        for share, mean, std in parts:
            z = (x_deg - mean) / std
            half = 0.5 * tail(self.settings.model, ratio, z)
            total += share * np.where(z < 0.0, half, 1.0 - half)
        return total
