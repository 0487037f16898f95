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

"""Whether a sensor differs after a service: its runs before against its runs after."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Sequence

import numpy as np

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.records import Reals

from .control_chart import estimate_correlation, LEAST_BASELINE
from .history import is_charted
from .run_row import RunRow


@dataclass(frozen=True, slots=True)
class ServiceChange:
    """
    The change of one figure at a service; keys of the JSON.

    Attributes
    ----------
    figure : {'mean', 'sd'}
    before, after
        Number of runs that end before the service, and that start at it or later.
    left_out
        Number of runs over the service, void, or without figures.
    change
        Of the mean: after minus before, degrees. Of the standard deviation: after over before.
        None, like all that follows, if either side has no run.
    low, high
        Interval of the change at `confidence`.
    p
        Probability of a change at least this large if nothing changed.
    differs
        Whether the interval leaves out no change.
    confidence
        Probability of the interval.
    correlation
        Correlation from run to run that is allowed for; None with fewer than 8 runs, which count
        as independent.
    one_run
        Whether a side has a single run, so that its scatter from run to run is unknown.

    """

    figure: str
    before: int
    after: int
    left_out: int
    change: float | None = None
    low: float | None = None
    high: float | None = None
    p: float | None = None
    differs: bool | None = None
    confidence: float = 0.95
    correlation: float | None = None
    one_run: bool = False

    @property
    def words(self) -> str:
        """Return what the runs say, in a sentence."""
        name = {'mean': 'mean', 'sd': 'standard deviation'}[self.figure]
        runs = f'{self.before} runs before and {self.after} after'
        if self.change is None or self.low is None or self.high is None:
            return f'cannot decide: the {name}; {runs} the service'
        level = f'{100.0 * self.confidence:g} %'
        if self.figure == 'mean':
            sentence = (f'the mean changed by {self.change:+.4f} deg ({level}: {self.low:+.4f} to '
                        f'{self.high:+.4f} deg; {runs})')
        else:
            sentence = (f'the standard deviation changed by the factor {self.change:.3f} '
                        f'({level}: {self.low:.3f} to {self.high:.3f}; {runs})')
        sentence += ': it differs' if self.differs else ': no change is shown'
        if self.one_run:
            sentence += ('; a side has one run, so a change that comes with every run looks like '
                         'one of the service')
        elif self.correlation is None:
            sentence += '; the runs count as independent'
        return sentence


def compare_service(rows: Sequence[RunRow], at_ns: int, *,
                    confidence: float = 0.95) -> tuple[ServiceChange, ...]:
    """
    Compare the runs of one sensor before and after a service.

    Parameters
    ----------
    rows
        Runs of one ship with one set of settings, in the order of time.
    at_ns
        Instant of the service, UTC nanoseconds.
    confidence
        Probability of the intervals.

    Returns
    -------
    tuple of ServiceChange
        The change of the mean and that of the standard deviation.

    Notes
    -----
    Each run gives a mean and the logarithm of its standard deviation, with standard uncertainties
    u and 1 / sqrt(2 nu) that allow for correlation within the run. The mean over the m runs of a
    side has the variance s^2 / m from their scatter, or sum(u^2) / m^2 if that is larger. Both
    are multiplied by (1 + r) / (1 - r), where r is a cautious correlation from run to run. The
    interval is that of Welch: Student with the effective degrees of freedom of both sides.

    References
    ----------
    Welch 1947; JCGM 100:2008, G.4; `estimate_correlation` for r.

    """
    sides = [[row for row in rows if row.end_ns < at_ns and is_charted(row)],
             [row for row in rows if row.start_ns >= at_ns and is_charted(row)]]
    counts = len(sides[0]), len(sides[1])
    left_out = len(rows) - sum(counts)
    changes = []
    for figure in ('mean', 'sd'):
        if not all(counts):
            changes.append(ServiceChange(figure, *counts, left_out, confidence=confidence))
            continue
        columns = [_columns(figure, side) for side in sides]
        changes.append(_compare(figure, columns, counts, left_out, confidence))
    return tuple(changes)


def _columns(figure: str, rows: Sequence[RunRow]) -> tuple[Reals, Reals]:
    """Return the figures of runs and their standard uncertainties."""
    if figure == 'mean':
        return (np.array([row.mean_deg for row in rows], float),
                np.array([row.mean_u_deg for row in rows], float))
    return (np.log(np.array([row.sd_deg for row in rows], float)),
            1.0 / np.sqrt(2.0 * np.array([row.nu for row in rows], float)))


def _compare(figure: str, columns: Sequence[tuple[Reals, Reals]], counts: tuple[int, int],
             left_out: int, confidence: float) -> ServiceChange:
    correlation = None
    if sum(counts) >= LEAST_BASELINE and min(counts) > 1:
        correlation = estimate_correlation(np.concatenate(
            [(x - x.mean()) / max(float(np.std(x, ddof=1)), 1e-12) for x, _ in columns]))
    factor = 1.0 if correlation is None else (1.0 + correlation) / (1.0 - correlation)
    parts = [(factor * mean_variance(x, u), float(x.size - 1)) for x, u in columns]
    change = float(columns[1][0].mean() - columns[0][0].mean())
    variance = math.fsum(part for part, _ in parts)
    rest = math.fsum(part ** 2 / nu for part, nu in parts if nu)
    nu = variance ** 2 / rest if rest > 0.0 else 1e9
    u = math.sqrt(variance)
    reach = float(scipy.special.stdtrit(nu, 0.5 + 0.5 * confidence)) * u
    p = 2.0 * float(scipy.special.stdtr(nu, -abs(change) / u)) if u > 0.0 else float(change == 0.0)
    low, high = change - reach, change + reach
    differs = not low <= 0.0 <= high
    if figure == 'sd':
        change, low, high = (math.exp(min(max(x, -700.0), 700.0)) for x in (change, low, high))
    return ServiceChange(
        figure=figure, before=counts[0], after=counts[1], left_out=left_out, change=change,
        low=low, high=high, p=p, differs=differs, confidence=confidence, correlation=correlation,
        one_run=min(counts) == 1)


def mean_variance(x: Reals, u: Reals) -> float:
    """Return the variance of the mean: from the scatter, or as stated if that is larger."""
    stated = float((u ** 2).sum()) / x.size ** 2
    return stated if x.size < 2 else max(stated, float(np.var(x, ddof=1)) / x.size)
