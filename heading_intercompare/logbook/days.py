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

"""The runs of a sensor by day: the worst verdict, and figures of the runs that are not void."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
import math
from typing import Iterable, Sequence

import numpy as np

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.diagnostics.deviation import deviation_at
from heading_intercompare.core.outcome import Outcome, worst
from heading_intercompare.core.records import Reals
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.validity.condition import gravest

from .correction import HeadingCorrection, list_corrections
from .history import is_charted
from .run_row import RunRow
from .service_change import mean_variance

SECTORS = {'N': 0.0, 'NE': 45.0, 'E': 90.0, 'SE': 135.0, 'S': 180.0, 'SW': 225.0, 'W': 270.0,
           'NW': 315.0}
"""Names of eight headings, degrees."""


@dataclass(frozen=True, slots=True)
class DayMean:
    """A mean over the runs of a day, and its standard uncertainty, degrees."""

    mean_deg: float
    u_deg: float


@dataclass(frozen=True, slots=True)
class Day:
    """
    The runs that begin on a day, UTC.

    Attributes
    ----------
    date
        Such as ``2026-03-01``.
    runs, counted
        Number of runs, and of those that are not void and have all figures.
    outcome, effect
        The worst outcome, and the gravest effect of a condition.
    n
        Differences of the runs that count.
    mean
        Mean of TS - RS over the runs that count, the installation offset removed.
    sd_deg
        Largest standard deviation of a run that counts, degrees.
    add_to_ts
        The correction, to be added to the TS heading.
    add_to_ts_on : dict of str to DayMean
        The correction on each of `SECTORS`; empty without a fit that holds on every heading.

    """

    date: str
    runs: int
    counted: int
    outcome: Outcome
    effect: str
    n: int
    mean: DayMean | None
    sd_deg: float | None
    add_to_ts: DayMean | None
    add_to_ts_on: dict[str, DayMean]


def list_days(rows: Iterable[RunRow]) -> list[Day]:
    """Return the days with runs of one sensor and one set of settings, given in order of time."""
    return [_tell(date, [*day_rows])
            for date, day_rows in groupby(rows, lambda row: utc(row.start_ns)[:10])]


def _tell(date: str, rows: Sequence[RunRow]) -> Day:
    counted = [row for row in rows if is_charted(row)]
    corrections, _ = list_corrections(counted)
    return Day(
        date=date, runs=len(rows), counted=len(counted),
        outcome=worst(Outcome(row.outcome) for row in rows),
        effect=gravest(row.validity_effect for row in rows), n=sum(row.n for row in counted),
        mean=_average([row.mean_deg for row in counted], [row.mean_u_deg for row in counted]),
        sd_deg=max((row.sd_deg for row in counted if row.sd_deg is not None), default=None),
        add_to_ts=_average([correction.add_to_ts_deg for correction in corrections],
                           [correction.row.mean_u_deg for correction in corrections]),
        add_to_ts_on=_average_sectors(corrections))


def _average_sectors(corrections: Sequence[HeadingCorrection]) -> dict[str, DayMean]:
    """Return the mean correction on each heading, over the runs with a fit that holds there."""
    headings_deg = np.array([*SECTORS.values()])
    add_deg, u_deg = [], []
    for correction in corrections:
        fit = correction.row.heading_dependence
        if fit is not None:
            x_deg, run_u_deg = deviation_at(fit, headings_deg)
            add_deg.append(-x_deg - (correction.row.installation_offset_deg or 0.0))
            u_deg.append(run_u_deg)
    estimates = {}
    for at, name in enumerate(SECTORS):
        estimate = _average([column[at] for column in add_deg], [column[at] for column in u_deg])
        if estimate is not None:
            estimates[name] = estimate
    return estimates


def _average(means_deg: Sequence[float | None],
             us_deg: Sequence[float | None]) -> DayMean | None:
    """Return the mean over runs, each with the same weight; None without runs."""
    if not means_deg:
        return None
    mean_deg: Reals = np.array(means_deg, float)
    mean_deg = wrap180(mean_deg, mean_deg[0])
    return DayMean(float(wrap180(mean_deg.mean())),
                    math.sqrt(mean_variance(mean_deg, np.array(us_deg, float))))
