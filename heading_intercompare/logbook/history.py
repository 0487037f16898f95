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

"""The history of a sensor: its runs in the order of time, with charts of mean and scatter."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Iterable, Sequence

import numpy as np

from heading_intercompare.core.count_words import count_words
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.validity.condition import VOID

from .control_chart import Chart, make_chart
from .run_row import RunKey, RunRow


@dataclass(frozen=True, slots=True)
class Trend:
    """
    What a chart says about one figure, the mean or the standard deviation.

    Attributes
    ----------
    figure : {'mean', 'sd'}
    center_deg
        Center of the baseline, degrees.
    correlation
        Correlation from run to run that the chart allows for.
    watched
        Number of runs after the baseline.
    first_outside_ns, newest_outside_ns
        Start of the first and of the newest run outside its limits.
    outside
        Number of runs outside their limits.
    differs_since_ns, noticed_ns
        Start of the first run of a lasting change, and of the run that showed it.
    false_alarm_probability
        Probability that an unchanged sensor shows a lasting change by now.

    """

    figure: str
    center_deg: float
    correlation: float
    watched: int
    first_outside_ns: int | None
    newest_outside_ns: int | None
    outside: int
    differs_since_ns: int | None
    noticed_ns: int | None
    false_alarm_probability: float

    @property
    def words(self) -> str:
        """Return what the chart says, in a sentence."""
        name = {'mean': 'mean', 'sd': 'standard deviation'}[self.figure]
        sentence = f'the {name} was {self.center_deg:.4f} deg in the baseline'
        if self.first_outside_ns is not None:
            more = f', {self.outside} of {self.watched} runs are outside' \
                if self.outside > 1 else ''
            sentence += f'; it left its limits at {utc(self.first_outside_ns)[:16]} UTC{more}'
        if self.differs_since_ns is not None:
            sentence += (f'; it differs since {utc(self.differs_since_ns)[:16]} UTC, as the run '
                         f'of {utc(self.noticed_ns)[:16]} UTC showed (chance of a false alarm by '
                         f'now {100.0 * self.false_alarm_probability:.2g} %)')
        elif self.first_outside_ns is None:
            sentence += ' and has stayed within its limits'
        return sentence


@dataclass(frozen=True, slots=True)
class Point:
    """
    One run of a history, with the limits of its charts; None where it has none.

    Attributes
    ----------
    mean_low_deg, mean_high_deg, sd_low_deg, sd_high_deg
        Limits of the mean and of the standard deviation, degrees.
    outside
        The figures, 'mean' and 'sd', that are outside.

    """

    row: RunRow
    mean_low_deg: float | None = None
    mean_high_deg: float | None = None
    sd_low_deg: float | None = None
    sd_high_deg: float | None = None
    outside: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class History:
    """
    The runs of one ship with one set of settings.

    Attributes
    ----------
    points
        In the order of time.
    trends
        Of the mean and of the standard deviation; empty without charts.
    baseline
        Number of runs of the baseline.
    why_no_chart
        Why there are no charts.

    """

    ship: str
    settings_sha256: str
    points: tuple[Point, ...]
    trends: tuple[Trend, ...]
    baseline: int
    why_no_chart: str | None

    def list_since(self, since_ns: int | None) -> list[Point]:
        """Return the points of runs that ended at this stamp or later; None: all of them."""
        return [p for p in self.points if since_ns is None or p.row.end_ns >= since_ns]

    @property
    def differs(self) -> bool:
        """Whether a chart shows a lasting change."""
        return any(trend.differs_since_ns is not None for trend in self.trends)


def tell_histories(rows: Iterable[RunRow], *, baseline: int = 20,
                   runs_between: float = 370.0) -> list[History]:
    """
    Return the history of each ship and its settings, those that end last at the end.

    Parameters
    ----------
    rows
        Rows of any logbooks. Of rows about the same run the last counts.
    baseline
        Number of runs to learn from.
    runs_between
        False alarms: one in this number of runs.

    Notes
    -----
    Void runs say nothing about the sensor, so the charts leave them out. The chart of the standard
    deviation is one of its logarithm, whose standard uncertainty is 1 / sqrt(2 nu). Other settings
    may give other figures for the same readings, so they make a history of their own.

    """
    groups: dict[tuple[str, str], dict[RunKey, RunRow]] = {}
    for row in rows:
        groups.setdefault((row.ship, row.settings_sha256), {})[row.key] = row
    histories = [_tell(ship, settings,
                       sorted(group.values(), key=lambda r: (r.start_ns, r.end_ns)),
                       baseline, runs_between)
                 for (ship, settings), group in groups.items()]
    return sorted(histories, key=lambda history: (history.points[-1].row.end_ns, history.ship))


def is_charted(row: RunRow) -> bool:
    """Tell whether a run has all figures of the charts, and is not void."""
    return (row.validity_effect != VOID and row.mean_deg is not None
            and row.mean_u_deg is not None and bool(row.sd_deg) and bool(row.nu))


def _tell(ship: str, settings: str, rows: Sequence[RunRow], baseline: int,
          runs_between: float) -> History:
    charted = [row for row in rows if is_charted(row)]
    ahead = len(charted) - baseline
    if ahead < 1:
        why = f'{count_words(len(charted), "run")} with figures; charts need more than the ' \
            f'{baseline} of the baseline'
        return History(ship, settings, tuple(Point(row) for row in rows), (), baseline, why)
    chance = 1.0 - (1.0 - 1.0 / runs_between) ** ahead
    column = {name: np.array([getattr(row, name) for row in charted], float)
              for name in ('mean_deg', 'mean_u_deg', 'sd_deg', 'nu')}
    mean = make_chart(column['mean_deg'], column['mean_u_deg'], baseline=baseline,
                      runs_between=runs_between)
    sd = make_chart(np.log(column['sd_deg']), 1.0 / np.sqrt(2.0 * column['nu']),
                    baseline=baseline, runs_between=runs_between)
    limits = {row.key: Point(
        row, float(mean.low[at]), float(mean.high[at]), math.exp(sd.low[at]),
        math.exp(min(sd.high[at], 700.0)),
        tuple(name for name, chart in (('mean', mean), ('sd', sd)) if chart.outside[at]))
        for at, row in enumerate(charted)}
    trends = (_describe('mean', mean, mean.center, charted, chance),
              _describe('sd', sd, math.exp(sd.center), charted, chance))
    return History(ship, settings, tuple(limits.get(row.key, Point(row)) for row in rows), trends,
                   baseline, None)


def _describe(figure: str, chart: Chart, center_deg: float, rows: Sequence[RunRow],
              chance: float) -> Trend:
    out = np.flatnonzero(chart.outside).tolist()
    return Trend(
        figure=figure, center_deg=center_deg, correlation=chart.correlation,
        watched=len(rows) - chart.baseline,
        first_outside_ns=rows[out[0]].start_ns if out else None,
        newest_outside_ns=rows[out[-1]].start_ns if out else None, outside=len(out),
        differs_since_ns=None if chart.since is None else rows[chart.since].start_ns,
        noticed_ns=None if chart.noticed is None else rows[chart.noticed].start_ns,
        false_alarm_probability=chance)
