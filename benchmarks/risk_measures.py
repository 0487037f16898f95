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

"""Measure the risks of the decision on one row of a table; see `decision_risk`."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Iterator

from error_processes import Errors, polynomial, without_drift
import numpy as np
from risk_rows import AUTO, Row

from heading_intercompare.core.statistics.cells import Cells
from heading_intercompare.core.statistics.drift import remove_polynomial, select_order
from heading_intercompare.core.statistics.variance_uncertainty import (
    estimate_spread,
    lower_bound,
    upper_bound,
)

SIGMAS = (0.5, 0.7, 0.85)
"""True standard deviations, as shares of the limit, for which acceptance is counted."""

LEAST_RUNS = ((20_000, 5000), (100_000, 1000), (math.inf, 400))
LARGEST_RATE = 0.06

COLUMNS = ('errors', 'n', 'runs', 'rule hi', 'rule lo', 'median L / U',
           'accepts 0.5 / 0.7 / 0.85')

STATED_COLUMNS = ('errors', 'n', 'runs', 'stated: hi', 'lo', 'median L / U',
                  'accepts 0.5 / 0.7 / 0.85', 'not stated: hi', 'accepts')

_SAMPLES_AT_ONCE = 4_000_000


@dataclass(frozen=True, slots=True)
class Result:
    """The cells of a row of a table, and whether it fails."""

    cells: tuple[str, ...]
    is_failed: bool = False

    @property
    def markdown(self) -> str:
        """Return the row in Markdown."""
        return f'| {" | ".join(self.cells)} |'


@dataclass(slots=True)
class Bounds:
    """Bounds of many runs whose true variance is 1."""

    lower: np.ndarray
    upper: np.ndarray

    @classmethod
    def of(cls, pairs: list[tuple[float, float]]) -> 'Bounds':
        """Return bounds from pairs (L, U)."""
        both = np.array(pairs).reshape(-1, 2)
        return cls(both[:, 0], both[:, 1])

    @property
    def hi(self) -> np.ndarray:
        """Which runs are wrongly accepted at the limit."""
        return self.upper < 1.0

    @property
    def lo(self) -> np.ndarray:
        """Which runs are wrongly rejected at the limit."""
        return self.lower > 1.0

    @property
    def medians(self) -> str:
        """Return the median L / U."""
        return f'{np.median(self.lower):.3g} / {np.median(self.upper):.3g}'

    @property
    def accepts(self) -> str:
        """Return the accepted shares of sensors that are better than the limit."""
        return ' / '.join(f'{np.mean(s * s * self.upper <= 1.0):.2f}' for s in SIGMAS)


def runs_for(n: int, wanted: int | None) -> int:
    """Return how many runs of n samples to simulate."""
    return wanted or next(runs for most, runs in LEAST_RUNS if n <= most)


def fails(wrong: np.ndarray, alpha: float) -> bool:
    """Tell whether a rate is significantly above its nominal value, or too large in any case."""
    share = float(np.mean(wrong))
    error = math.sqrt(share * (1.0 - share) / wrong.size)
    return share - 2.0 * error > alpha or share > LARGEST_RATE / 0.05 * alpha


def rate(wrong: np.ndarray, alpha: float, is_judged: bool = True) -> str:
    """Return a rate with its standard error, marked if it fails."""
    share = float(np.mean(wrong))
    error = math.sqrt(share * (1.0 - share) / wrong.size)
    mark = ' **fails**' if is_judged and fails(wrong, alpha) else ''
    return f'{share:.4f} ± {error:.4f}{mark}'


def batches(errors: Errors, n: int, count: int,
            rng: np.random.Generator) -> Iterator[np.ndarray]:
    """Yield arrays of runs, many at once."""
    at_once = max(1, _SAMPLES_AT_ONCE // n)
    while count > 0:
        yield errors(rng, min(count, at_once), n)
        count -= at_once


def runs_of(row: Row, count: int, rng: np.random.Generator,
            ) -> Iterator[tuple[np.ndarray, np.ndarray | None, int]]:
    """Yield, run by run, residuals, stamps, and the order given to the rule."""
    every = None
    if row.rate_hz:
        step_ns = round(1e9 / row.rate_hz)
        every = np.arange(row.n, dtype=np.int64) * step_ns
    for many in batches(row.errors, row.n, count, rng):
        if row.drift:
            many += 3.0 * polynomial(row.n, row.drift)
        if row.order > 0 and row.sampling is None:
            many = without_drift(many, row.order)
        for x in many:
            stamps = every
            if row.sampling is not None:
                at = row.sampling(rng, row.n)
                x, stamps = x[at], every[at]
            order = row.order
            if order == AUTO:
                x = remove_polynomial(stamps, x, select_order(stamps, x).order).residual_deg
                order = 3
            elif order > 0 and row.sampling is not None:
                x = remove_polynomial(stamps, x, order).residual_deg
            yield x, stamps, order


def bounds_of(x: np.ndarray, stamps: np.ndarray | None, order: int, alpha: float,
              times: float | None = None) -> tuple[float, float]:
    """Return L and U of one run; 0 and infinity if the rule makes no statement."""
    figures = estimate_spread(Cells.of(x) if stamps is None else Cells.of(x, stamps), order,
                              times)
    if figures is None:
        return 0.0, math.inf
    return lower_bound(figures, alpha), upper_bound(figures, alpha)


def measure_row(row: Row, rng: np.random.Generator, wanted: int | None, alpha: float) -> Result:
    """Return a row of a table of single runs."""
    now: list[tuple[float, float]] = []
    unstated: list[tuple[float, float]] = []
    for x, stamps, order in runs_of(row, runs_for(row.n, wanted), rng):
        # Times count data, a statement counts the whole span.
        times = row.times / row.stated * row.n / x.size if row.stated else None
        now.append(bounds_of(x, stamps, order, alpha, times))
        if row.stated:
            unstated.append(bounds_of(x, stamps, order, alpha))
    bounds = Bounds.of(now)
    beside: tuple[str, ...] = ()
    if unstated:
        b = Bounds.of(unstated)
        beside = rate(b.hi, alpha, False), b.accepts
    sides = (bounds.hi, bounds.lo)
    return Result((row.name if row.is_judged else f'({row.name})', str(row.n), str(len(now)),
                   *(rate(side, alpha, row.is_judged) for side in sides), bounds.medians,
                   bounds.accepts, *beside),
                  row.is_judged and any(fails(side, alpha) for side in sides))
