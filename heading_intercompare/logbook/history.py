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
from typing import Callable, Iterable, Sequence

import numpy as np

from heading_intercompare.core.count_words import count_words
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.records import Reals
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.validity.condition import VOID

from .control_chart import Chart, make_chart, round_to_two_digits
from .run_row import RunKey, RunRow

_NAMES = {'mean': 'mean', 'sd': 'standard deviation'}

#: Chance of a false lasting change in any of the charts that are listed together.
FALSE_ALARM = 0.05
#: At least this many runs between false alarms of a chart.
LEAST_RUNS_BETWEEN = 370.0


@dataclass(frozen=True, slots=True)
class EndedChange:
    """A change that has ended: the starts of its first and last run."""

    since_ns: int
    until_ns: int


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
        Start of the first run of a lasting change, and of the run that showed it; None if there is
        none, or if it has ended.
    shift_deg
        Median of the runs since then, minus the center before, degrees.
    ended
        Changes that have ended.
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
    shift_deg: float | None
    ended: tuple[EndedChange, ...]
    false_alarm_probability: float

    @property
    def words(self) -> str:
        """Return what the chart says, in a sentence."""
        sentence = f'the {_NAMES[self.figure]} was {self.center_deg:.4f} deg in the baseline'
        if self.first_outside_ns is not None:
            more = f', {self.outside} of {self.watched} runs are outside' \
                if self.outside > 1 else ''
            sentence += f'; it left its limits at {utc(self.first_outside_ns)[:16]} UTC{more}'
        if self.ended:
            newest = self.ended[-1]
            more = f', the newest of {count_words(len(self.ended), "change")} that ended' \
                if len(self.ended) > 1 else ''
            sentence += (f'; it differed from {utc(newest.since_ns)[:16]} to '
                         f'{utc(newest.until_ns)[:16]} UTC{more}')
        if self.differs_since_ns is not None:
            sentence += (f'; it differs since {utc(self.differs_since_ns)[:16]} UTC by '
                         f'{self.shift_deg:+.4f} deg, as the run '
                         f'of {utc(self.noticed_ns)[:16]} UTC showed (chance of a false alarm by '
                         f'now {100.0 * self.false_alarm_probability:.2g} %)')
        elif self.first_outside_ns is None and not self.ended:
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
    runs_between
        False alarms of a chart: one in this number of runs.
    why_no_chart
        Why there are no charts.

    """

    ship: str
    settings_sha256: str
    points: tuple[Point, ...]
    trends: tuple[Trend, ...]
    baseline: int
    runs_between: float
    why_no_chart: str | None

    def list_since(self, since_ns: int | None) -> list[Point]:
        """Return the points of runs that ended at this stamp or later; None: all of them."""
        return [p for p in self.points if since_ns is None or p.row.end_ns >= since_ns]

    @property
    def name(self) -> str:
        """Return the ship, and the beginning of the hash of its settings."""
        return f'{self.ship or "(no ship)"}, settings {self.settings_sha256[:8]}'

    @property
    def state(self) -> list[str]:
        """Return what the charts say of now, in words; empty for a sensor within its limits."""
        words = [f'{_NAMES[trend.figure]} differs since {utc(trend.differs_since_ns)[:16]} UTC by '
                 f'{trend.shift_deg:+.4f} deg' for trend in self.trends
                 if trend.differs_since_ns is not None]
        newest = self.points[-1]
        if self.why_no_chart is not None:
            words.append('no charts yet')
        elif newest.outside:
            words.append(f'{" and ".join(newest.outside)} outside the limits')
        return words

    @property
    def concern(self) -> int:
        """How urgent it is: 0 for a sensor that differs now, 3 for one without a fault."""
        newest = self.points[-1]
        if self.differs:
            return 0
        if newest.row.outcome == Outcome.NON_COMPLIANT.value:
            return 1
        return 2 if newest.outside or self.why_no_chart is not None else 3

    @property
    def differs(self) -> bool:
        """Whether a chart shows a lasting change."""
        return any(trend.differs_since_ns is not None for trend in self.trends)


def tell_histories(rows: Iterable[RunRow], *, baseline: int = 20,
                   runs_between: float | None = None) -> list[History]:
    """
    Return the history of each ship and its settings, the worst first.

    Parameters
    ----------
    rows
        Rows of any logbooks. Of rows about the same run the last counts.
    baseline
        Number of runs to learn from.
    runs_between
        False alarms: one in this number of runs of a chart; by default one in 370, or fewer, so
        that the chance of a false lasting change in any of the charts is at most 5 %.

    Notes
    -----
    With n runs watched in all charts together, one in N with (1 - 1/N)^n = 0.95. So the length in
    control grows with the number of ships and of their runs. n is rounded up to two digits, so
    that a new run seldom asks for other charts.

    The worst first: those that differ now, then those whose newest run is non-compliant, outside
    its limits or not charted, then the others; within these those that end last.

    Void runs say nothing about the sensor, so the charts leave them out. The chart of the standard
    deviation is one of its logarithm, whose standard uncertainty is 1 / sqrt(2 nu). Other settings
    may give other figures for the same readings, so they make a history of their own.

    """
    groups: dict[tuple[str, str], dict[RunKey, RunRow]] = {}
    for row in rows:
        groups.setdefault((row.ship, row.settings_sha256), {})[row.key] = row
    in_order = {key: sorted(group.values(), key=lambda r: (r.start_ns, r.end_ns))
                for key, group in groups.items()}
    if runs_between is None:
        watched = sum(2 * max(0, sum(map(is_charted, group)) - baseline)
                      for group in in_order.values())
        runs_between = max(LEAST_RUNS_BETWEEN, _find_runs_between(
            round_to_two_digits(watched, math.ceil)))
    histories = [_tell(ship, settings, group, baseline, runs_between)
                 for (ship, settings), group in in_order.items()]
    return sorted(histories, key=lambda history: (
        history.concern, -history.points[-1].row.end_ns, history.ship))


def _find_runs_between(watched: int) -> float:
    """Return N with (1 - 1/N)^n = 0.95."""
    return -1.0 / math.expm1(math.log1p(-FALSE_ALARM) / watched) if watched else 0.0


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
        return History(ship, settings, tuple(Point(row) for row in rows), (), baseline,
                       runs_between, why)
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
    trends = (_describe('mean', mean, column['mean_deg'], charted, chance, float),
              _describe('sd', sd, np.log(column['sd_deg']), charted, chance, math.exp))
    return History(ship, settings, tuple(limits.get(row.key, Point(row)) for row in rows), trends,
                   baseline, runs_between, None)


def _describe(figure: str, chart: Chart, x: Reals, rows: Sequence[RunRow], chance: float,
              to_deg: Callable[[float], float]) -> Trend:
    out = np.flatnonzero(chart.outside).tolist()
    lasting = chart.lasting
    shift_deg = None
    if lasting is not None:
        before = (chart.low[lasting.since] + chart.high[lasting.since]) / 2.0
        shift_deg = to_deg(float(np.median(x[lasting.since:]))) - to_deg(float(before))
    return Trend(
        figure=figure, center_deg=to_deg(chart.center), correlation=chart.correlation,
        watched=len(rows) - chart.baseline,
        first_outside_ns=rows[out[0]].start_ns if out else None,
        newest_outside_ns=rows[out[-1]].start_ns if out else None, outside=len(out),
        differs_since_ns=None if lasting is None else rows[lasting.since].start_ns,
        noticed_ns=None if lasting is None else rows[lasting.noticed].start_ns,
        shift_deg=shift_deg,
        ended=tuple(EndedChange(rows[change.since].start_ns, rows[change.until].start_ns)
                    for change in chart.changes if change.until is not None),
        false_alarm_probability=chance)
