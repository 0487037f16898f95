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

"""The differences by heading: a row for each sector of 45 degrees, centred on N, NE, E..."""

from __future__ import annotations

import math

from heading_intercompare.core.statistics.blocking import student_95
from heading_intercompare.report.figures.drawing import Subject
from heading_intercompare.report.formatting import ABSENT, bounds, rounded
from heading_intercompare.report.series_sketch import HEADING_BINS

from .tables import Table

_SECTORS = ('N', 'NE', 'E', 'SE', 'S', 'SW', 'W', 'NW')
_WIDTH_DEG = 360.0 / len(_SECTORS)
_LEAST_WORTH = 5.0
_HEAD = ('heading of the RS [deg]', 'differences', 'mean TS - RS [deg]', '95 % interval [deg]',
         'standard deviation [deg]')


def tabulate_sectors(about: Subject) -> Table:
    """
    Return the table of a record.

    Parameters
    ----------
    about
        The record with its runs. The interval of a mean allows for the correlation in time that
        the runs show. It is a dash if the differences of a sector are worth fewer than five
        independent ones, or an unknown number.

    """
    size = HEADING_BINS // len(_SECTORS)
    sectors = about.sketch.heading.join(size, first=-size // 2)
    share = _worth_of_one(about)
    rows = []
    for at, name in enumerate(_SECTORS):
        n, mean_deg = int(sectors.n[at]), float(sectors.mean_deg[at])
        std_deg = float(sectors.std_deg[at])
        half_deg = _half_width(std_deg, None if share is None else n * share)
        ends = (None, None) if half_deg is None else (mean_deg - half_deg, mean_deg + half_deg)
        rows.append([f'{name}: {(at - 0.5) * _WIDTH_DEG % 360.0:g} to {(at + 0.5) * _WIDTH_DEG:g}',
                     str(n), rounded(mean_deg, half_deg) if n else ABSENT, bounds(*ends),
                     rounded(std_deg, 0.1 * std_deg)])
    return Table(_HEAD, rows)


def _worth_of_one(about: Subject) -> float | None:
    """Return how many independent differences one is worth for the mean; None if unknown."""
    correlations = [run.correlation for run in about.runs]
    if not correlations or not all(times.closed and times.n for times in correlations):
        return None
    return min(1.0, *(times.n_effective_mean / times.n for times in correlations))


def _half_width(std_deg: float, worth: float | None) -> float | None:
    """Return half of the 95 % interval of a mean; None without one."""
    if worth is None or worth < _LEAST_WORTH or not math.isfinite(std_deg):
        return None
    return student_95(worth - 1.0) * std_deg / math.sqrt(worth)
