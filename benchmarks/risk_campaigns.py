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

"""Measure several runs together, several looks at one run, and lengths; see `decision_risk`."""

from __future__ import annotations

from dataclasses import dataclass, replace
import math
from typing import Callable, Sequence

from error_processes import (
    ar1,
    as_laplace,
    as_student5,
    Errors,
    narrow_band,
    sea_state,
    white,
)
import numpy as np
from risk_measures import batches, Bounds, fails, rate, Result, runs_for, SIGMAS
from risk_rows import band, half, JUDGED_FROM

from heading_intercompare.core.decision.campaign import conclude_sensor, judge_together
from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.decision.guarded import Evidence
from heading_intercompare.core.decision.sequential import Looks
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.settings import Norms, Risk, Settings
from heading_intercompare.core.statistics.cells import Cells
from heading_intercompare.core.statistics.confidence_bounds import share_interval
from heading_intercompare.core.statistics.variance_uncertainty import (
    between_runs,
    estimate_spread,
    lower_bound,
    pool,
    scatter_of_runs,
    Spread,
    upper_bound,
)


@dataclass(frozen=True, slots=True)
class Campaign:
    """A row of these tables: its name, and the function that measures it."""

    name: str
    measure: Callable[[np.random.Generator, int | None, float], Result]


def _accepts(upper: np.ndarray) -> str:
    return ' / '.join(f'{np.mean(s * s * upper <= 1.0):.2f}' for s in SIGMAS)


def _campaigns(lengths: tuple[int, ...], errors: Errors, count: int, rng: np.random.Generator,
               alpha: float) -> tuple[np.ndarray, ...]:
    """Return for each campaign: largest U, largest L at alpha / m, pooled L and U, U by S.13."""
    m, rows = len(lengths), []
    runs = [(x for many in batches(errors, n, count, child) for x in many)
            for n, child in zip(lengths, rng.spawn(m))]
    for together in zip(*runs):
        figures = [estimate_spread(Cells.of(x)) for x in together]
        pooled = pool(figures)
        rows.append((max(upper_bound(f, alpha) for f in figures),
                     max(lower_bound(f, alpha / m) for f in figures),
                     lower_bound(pooled, alpha), upper_bound(pooled, alpha),
                     between_runs(figures, np.array([x.mean() for x in together]), alpha)))
    return tuple(np.array(rows).T)


def _several_runs(name: str, lengths: tuple[int, ...], errors: Errors) -> Campaign:
    def measure(rng: np.random.Generator, wanted: int | None, alpha: float) -> Result:
        every_u, every_l, low, up, between = _campaigns(
            lengths, errors, runs_for(max(lengths), wanted), rng, alpha)
        wrong = (every_u < 1.0, every_l > 1.0, up < 1.0, low > 1.0, between < 1.0)
        cells = [rate(w, alpha) for w in wrong]
        return Result((name, str(len(lengths)), str(up.size), ' / '.join(cells[:2]),
                       _accepts(every_u), ' / '.join(cells[2:4]), _accepts(up), cells[4],
                       _accepts(between)), any(fails(w, alpha) for w in wrong))
    return Campaign(name, measure)


def _slow_between(times: float, m: int) -> Campaign:
    name = f'{times:g}, {m} runs'

    def measure(rng: np.random.Generator, wanted: int | None, alpha: float) -> Result:
        count = runs_for(3000, wanted)
        every_u, _, _, up, between = _campaigns((3000,) * m, half(ar1(3000.0 / times)), count,
                                                rng, alpha)
        quiet = _campaigns((3000,) * m, white, max(1, count // 10), rng, alpha)[4]
        return Result((name, str(up.size), rate(every_u < 1.0, alpha, False),
                       rate(up < 1.0, alpha, False), rate(between < 1.0, alpha),
                       f'{np.median(between):.3g}', f'{np.median(quiet):.3f}'),
                      fails(between < 1.0, alpha))
    return Campaign(name, measure)


def table_runs() -> list[Campaign]:
    """Return the rows of several runs of one sensor."""
    return [_several_runs(name, lengths, errors) for name, lengths, errors in (
        ('white, n = 600', (600,) * 4, white),
        ('AR(1), 50', (1000,) * 4, ar1(20.0)),
        ('AR(1), 20', (600,) * 8, ar1(30.0)),
        ('AR(1), 20 / 40 / 80', (600, 1200, 2400), ar1(30.0)),
        ('0.5 white + 0.5 AR(1), 20', (600,) * 2, half(ar1(30.0))),
        ('0.5 white + 0.5 AR(1), 20, four', (600,) * 4, half(ar1(30.0))),
        ('0.5 white + 0.5 narrow band, 20', (1200,) * 4, half(band(60.0))),
        ('Student-5 AR(1), 100', (2000,) * 4, as_student5(ar1(20.0))),
        ('Laplace AR(1), 50', (1000,) * 4, as_laplace(ar1(20.0))),
        ('sea state of sd 0.7, white, 20', (1200,) * 4, sea_state(0.7, 60.0, white)))]


def table_means() -> list[Campaign]:
    """Return the rows of a slow component that no single run shows."""
    return [_slow_between(times, m) for times in (3.0, 1.0, 0.1, 0.01) for m in (2, 3, 5, 8)]


#: Step of the looks: so long that even the first look is at a run of at least the least length.
STEP_NS = 10_000_000_000


def _looks(name: str, samples: int, errors: Errors, count_of_looks: int,
           first: int) -> Campaign:
    """Return a row of looks; at the first look the run has `first` correlation times."""
    times = first << (count_of_looks - 1)
    name = f'{name}; {count_of_looks} looks'

    def measure(rng: np.random.Generator, wanted: int | None, alpha: float) -> Result:
        n = samples * times
        stamps = np.arange(n + 1, dtype=np.int64) * STEP_NS
        plan = Looks(n * STEP_NS / 1e9, count_of_looks,
                     Risk(alpha_consumer=alpha, alpha_producer=alpha))
        looks = plan.cuts(0, stamps)
        rows = []
        for many in batches(errors, n + 1, runs_for(n, wanted), rng):
            for x in many:
                for size, look in looks:
                    f = estimate_spread(Cells.of(x[:size]))
                    rows.append((lower_bound(f, look.risk.alpha_producer),
                                 upper_bound(f, look.risk.alpha_consumer),
                                 lower_bound(f, alpha), upper_bound(f, alpha)))
        low, up, low_all, up_all = np.array(rows).reshape(-1, len(looks), 4).transpose(2, 0, 1)
        ever = [np.any(up < 1.0, axis=1), np.any(low > 1.0, axis=1)]
        alone = [np.any(up_all < 1.0, axis=1), np.any(low_all > 1.0, axis=1)]
        return Result((name, str(len(up)), *(rate(e, alpha) for e in ever),
                       ' / '.join(f'{np.mean(e):.3f}' for e in alone),
                       *_when(up, [size / n for size, _ in looks])),
                      any(fails(e, alpha) for e in ever))
    return Campaign(name, measure)


def _when(upper: np.ndarray, shares: list[float]) -> tuple[str, str]:
    """Return the median share of the plan at which good sensors are accepted, and how many are."""
    at, by_end = [], []
    for s in SIGMAS:
        accepted = s * s * upper <= 1.0
        is_any = accepted.any(axis=1)
        when = np.where(is_any, np.array(shares)[accepted.argmax(axis=1)], math.inf)
        at.append('-' if math.isinf(np.median(when)) else f'{np.median(when):.3f}')
        by_end.append(f'{is_any.mean():.2f}')
    return ' / '.join(at), ' / '.join(by_end)


def table_looks() -> list[Campaign]:
    """Return the rows of looks at a plan of 640 correlation times."""
    processes = (('white', 20, white), ('AR(1)', 20, ar1(20.0)),
                 ('0.5 white + 0.5 AR(1)', 20, half(ar1(20.0))), ('narrow band', 30, band(30.0)),
                 ('0.5 white + 0.5 narrow band', 30, half(band(30.0))),
                 ('Laplace AR(1)', 20, as_laplace(ar1(20.0))),
                 ('Student-5 AR(1)', 20, as_student5(ar1(20.0))),
                 ('sea state of sd 0.7, white', 20, sea_state(0.7, 20.0, white)))
    return [_looks(name, samples, errors, looks, first) for name, samples, errors in processes
            for looks, first in ((7, 10), (4, 80))]


#: Ends of a run with open looks, in least lengths: four an octave, so every fourth is at a look.
ENDS = tuple(2.0 ** (k / 4.0) for k in range(25))
#: True standard deviations of which the time until a decision is told.
OPEN_SIGMAS = (0.5, 0.7, 0.8, 0.9)


def _follow(x: np.ndarray, sizes: list[int], plan: Looks, alpha: float,
            least_s: float) -> list[tuple[float, ...]]:
    """Return for each end L and U at the full risks, at those of an end and at those of a look."""
    cells, rows, at = Cells(), [], 0
    for size, times in zip(sizes, ENDS):
        cells.update(x[at:size], np.arange(at, size, dtype=np.int64))
        at = size
        f = estimate_spread(cells)
        share = plan.risk_at_the_end(times * least_s * (1.0 + 1e-9)).alpha_consumer
        rows.append(tuple(bound(f, a) for a in (alpha, share, plan.plan[0].risk.alpha_consumer)
                          for bound in (lower_bound, upper_bound)))
    return rows


def _open(name: str, samples: int, errors: Errors) -> Campaign:
    """Return a row of open looks; the least length is 20 correlation times."""
    def measure(rng: np.random.Generator, wanted: int | None, alpha: float) -> Result:
        plan = Looks('open', 7, Risk(alpha_consumer=alpha, alpha_producer=alpha))
        least_s = plan.plan[0].span_ns / 1e9
        sizes = [round(20 * samples * times) for times in ENDS]
        rows = [_follow(x, sizes, plan, alpha, least_s)
                for many in batches(errors, sizes[-1], runs_for(sizes[-1] // 2, wanted), rng)
                for x in many]
        low_one, up_one, low_end, up_end, low, up = np.array(rows).transpose(2, 0, 1)
        wrong = [_decide_wrongly(looks, ends) for looks, ends in (
            (up < 1.0, up_end < 1.0), (low > 1.0, low_end > 1.0))]
        return Result((name, str(len(up)), *(rate(of_ends.T[of_ends.mean(axis=0).argmax()], alpha)
                                             for of_ends in wrong),
                       f'{np.mean((up_end < 1.0).any(axis=1)):.3f} / '
                       f'{np.mean((low_end > 1.0).any(axis=1)):.3f}',
                       *(_wait(s, up_one, up_end, up) for s in OPEN_SIGMAS)),
                      any(fails(of_end, alpha) for of_ends in wrong for of_end in of_ends.T))
    return Campaign(name, measure)


def _decide_wrongly(looks: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Return which runs are wrong at a look before each end, or at that end."""
    at_look = (np.arange(len(ENDS)) % 4 == 0) & (np.arange(len(ENDS)) < len(ENDS) - 1)
    return np.logical_or.accumulate(looks & at_look, axis=1) | ends


def _wait(sigma: float, *uppers: np.ndarray) -> str:
    """Return the lengths until 80 % are accepted: one decision, end of open looks, by a look."""
    one, end, look = (sigma * sigma * upper <= 1.0 for upper in uppers)
    seen = np.logical_or.accumulate(look[:, :-1:4], axis=1)
    return ' / '.join([_length(one.mean(axis=0), ENDS), _length(end.mean(axis=0), ENDS),
                       _first(seen.mean(axis=0), ENDS[:-1:4])])


def _first(share: np.ndarray, lengths: tuple[float, ...]) -> str:
    """Return the first length at which a share is at least 0.8."""
    reached = np.flatnonzero(share >= 0.8)
    return f'{lengths[reached[0]]:g}' if reached.size else f'> {lengths[-1]:g}'


def table_open() -> list[Campaign]:
    """Return the rows of looks at a run whose end is not planned."""
    return [_open(name, samples, errors) for name, samples, errors in (
        ('white', 10, white), ('AR(1)', 10, ar1(10.0)),
        ('0.5 white + 0.5 AR(1)', 10, half(ar1(10.0))),
        ('narrow band', 20, band(20.0)),
        ('Laplace AR(1)', 10, as_laplace(ar1(10.0))),
        ('Student-5 AR(1)', 10, as_student5(ar1(10.0))),
        ('sea state of sd 0.7, white', 10, sea_state(0.7, 10.0, white)))]


LENGTHS = tuple(round(7 * 2.0 ** (k / 2.0)) for k in range(15))
TARGETS = (0.5, 0.7, 0.85, 1.2, 1.5)


def _power(name: str, samples: int, errors: Errors) -> Campaign:
    """Return a row of the lengths, in correlation times, from which 80 % of runs are decided."""
    def measure(rng: np.random.Generator, wanted: int | None, alpha: float) -> Result:
        lengths = [t for t in LENGTHS if t * samples <= 20_000]
        shares = np.empty((2, len(TARGETS), len(lengths)))
        for k, times in enumerate(lengths):
            now, d = [], []
            n = times * samples
            for many in batches(errors, n, runs_for(n, wanted), rng):
                for x in many:
                    f = estimate_spread(Cells.of(x))
                    now.append((lower_bound(f, alpha), upper_bound(f, alpha)))
                    d.append(f.d_deg2)
            d = np.array(d)
            known = Bounds(d / np.quantile(d, 1.0 - alpha), d / np.quantile(d, alpha))
            for i, bounds in enumerate((Bounds.of(now), known)):
                shares[i, :, k] = [np.mean(s * s * bounds.upper <= 1.0 if s < 1.0
                                           else s * s * bounds.lower > 1.0) for s in TARGETS]
        return Result((name, *(' / '.join(_length(share[j], lengths) for share in shares)
                               for j in range(len(TARGETS)))))
    return Campaign(name, measure)


def _length(share: np.ndarray, lengths: Sequence[float]) -> str:
    """Return the length from which a share is at least 0.8, interpolated in its logarithm."""
    below = np.flatnonzero(share < 0.8)
    if not below.size:
        return f'<= {lengths[0]:g}'
    k = int(below[-1])
    if k == len(lengths) - 1:
        return f'> {lengths[-1]:g}'
    part = (0.8 - share[k]) / (share[k + 1] - share[k])
    return f'{lengths[k] * (lengths[k + 1] / lengths[k]) ** part:.{0 if lengths[0] > 1 else 1}f}'


def table_b() -> list[Campaign]:
    """Return the rows of the lengths needed."""
    return [_power('AR(1)', 20, ar1(20.0)), _power('narrow band', 60, band(60.0)),
            _power('0.5 white + 0.5 AR(1)', 20, half(ar1(20.0))),
            _power('0.5 white + 0.5 narrow band', 60, half(band(60.0)))]


STATED_LENGTHS = tuple(round(20 * 2.0 ** (k / 2.0)) for k in range(10))


def _stated_power(name: str, samples: int, errors: Errors) -> Campaign:
    """Return a row of the lengths needed: rule that knows D, not stated, stated."""
    def measure(rng: np.random.Generator, wanted: int | None, alpha: float) -> Result:
        shares = np.empty((3, len(SIGMAS), len(STATED_LENGTHS)))
        for k, times in enumerate(STATED_LENGTHS):
            found, n = [], times * samples
            for many in batches(errors, n, runs_for(n, wanted), rng):
                for x in many:
                    cells = Cells.of(x)
                    f = estimate_spread(cells)
                    found.append((f.d_deg2, upper_bound(f, alpha),
                                  upper_bound(estimate_spread(cells, 0, times), alpha)))
            d, alone, stated = np.array(found).T
            for i, upper in enumerate((d / np.quantile(d, alpha), alone, stated)):
                shares[i, :, k] = [np.mean(s * s * upper <= 1.0) for s in SIGMAS]
        return Result((name, *(' / '.join(_length(shares[i, j], STATED_LENGTHS)
                                          for i in range(3)) for j in range(len(SIGMAS)))))
    return Campaign(name, measure)


def _stated_processes(samples: float) -> dict[str, Errors]:
    """Return processes with one correlation time of this many samples."""
    return {'AR(1)': ar1(samples), 'narrow band': band(samples),
            'damped swing': narrow_band(samples, 2.2 * samples),
            '0.5 white + 0.5 AR(1)': half(ar1(samples)),
            '0.5 white + 0.5 narrow band': half(band(samples)),
            'Laplace AR(1)': as_laplace(ar1(samples)),
            'Student-5 AR(1)': as_student5(ar1(samples)),
            'sea state of sd 0.7, white': sea_state(0.7, samples, white)}


def table_stated_lengths() -> list[Campaign]:
    """Return the rows of the lengths needed if the slowest error is stated."""
    return [_stated_power(name, 30, errors) for name, errors in _stated_processes(30.0).items()]


def _stated_runs(name: str, times: tuple[float, ...], samples: int, errors: Errors) -> Campaign:
    name = f'{name}; {len(times)} of {"/".join(f"{t:g}" for t in dict.fromkeys(times))}'

    def measure(rng: np.random.Generator, wanted: int | None, alpha: float) -> Result:
        lengths = [round(t * samples) for t in times]
        count = runs_for(sum(lengths), wanted)
        runs = [(x for many in batches(errors, n, count, child) for x in many)
                for n, child in zip(lengths, rng.spawn(len(times)))]
        rows = []
        for together in zip(*runs):
            f = [estimate_spread(Cells.of(x), 0, t) for x, t in zip(together, times)]
            means = [float(x.mean()) for x in together]
            between = between_runs(f, means, alpha)
            rows.append((upper_bound(pool(f), alpha),
                         upper_bound(pool(f, by_statement=True), alpha), between,
                         max(between, scatter_of_runs(f, means, alpha))))
        upper = np.array(rows).T
        is_pooled = min(times) >= JUDGED_FROM
        judged = (False, is_pooled, False, min(times) >= 10.0)
        cells = []
        for u, is_judged in zip(upper, judged):
            cells += [rate(u < 1.0, alpha, is_judged), _accepts(u)]
        return Result((name, str(count), *cells),
                      any(is_judged and fails(u < 1.0, alpha)
                          for u, is_judged in zip(upper, judged)))
    return Campaign(name, measure)


def table_stated_runs() -> list[Campaign]:
    """Return the rows of several runs if the slowest error is stated."""
    kinds = ((20.0,) * 5, (20.0,) * 10, (20.0,) * 30, (10.0,) * 5, (10.0,) * 10, (10.0,) * 20,
             (20.0, 40.0) * 3, (8.0,) * 10, (6.0,) * 10, (4.5,) * 10, (3.0,) * 10, (1.0,) * 10,
             (0.1,) * 10)
    rows = []
    for name in ('AR(1)', 'narrow band', '0.5 white + 0.5 AR(1)', 'Student-5 AR(1)',
                 'sea state of sd 0.7, white'):
        for times in kinds:
            # At least 600 samples in a run.
            samples = max(30, round(600 / min(times)))
            rows.append(_stated_runs(name, times, samples,
                                     _stated_processes(float(samples))[name]))
    return rows


LONGER = (2, 4, 8)
RATIOS_SEEN = ((0.0, 12.0), (12.0, 30.0), (30.0, math.inf))
LEVELS_SEEN = ((0.0, 0.6), (0.6, 0.8), (0.8, 1.0))
TRUE_LEVELS = (0.4, 0.5, 0.6, 0.7, 0.8)


def _longer(low_r: float, high_r: float) -> Campaign:
    """
    Return a row of runs that a slow part leaves open, when they go on.

    They hold 3 to 30 correlation times of four processes. Those with a ratio R in these bounds
    are sorted by the standard deviation that they show, over the root of the limit.
    """
    name = f'R from {low_r:g} to {high_r:g}'

    def measure(rng: np.random.Generator, wanted: int | None, alpha: float) -> Result:
        certified: list[list[tuple[bool, ...]]] = [[] for _ in LEVELS_SEEN]
        for times in (3, 5, 10, 20, 30):
            n = 60 * times
            for process in ('AR(1)', '0.5 white + 0.5 AR(1)', 'Laplace AR(1)', 'damped swing'):
                errors = _stated_processes(60.0)[process]
                for many in batches(errors, LONGER[-1] * n, runs_for(n, wanted), rng):
                    for x in many:
                        first = estimate_spread(Cells.of(x[:n]))
                        if first is not None and low_r <= first.r_slow < high_r:
                            _go_on(x, first, alpha, certified)
        cells = []
        for found in certified:
            shares = np.mean(found, axis=0) if found else np.full(len(LONGER), math.nan)
            cells.append(f'{len(found)}: ' + ' / '.join(f'{s:.2f}' for s in shares))
        return Result((name, *cells))
    return Campaign(name, measure)


def _go_on(x: np.ndarray, first: Spread, alpha: float,
           certified: list[list[tuple[bool, ...]]]) -> None:
    """Add which multiples of an open run are certified, by the level that it shows."""
    n, d, slow = first.n, first.d_deg2, first.slow_allowance_deg2
    upper = upper_bound(first, alpha)
    later = [upper_bound(estimate_spread(Cells.of(x[:r * n])), alpha) for r in LONGER]
    for level in TRUE_LEVELS:
        limit = 1.0 / level ** 2
        if upper <= limit or not (upper - slow <= limit or d <= limit < d + slow):
            continue
        for (low, high), found in zip(LEVELS_SEEN, certified):
            if low <= math.sqrt(d / limit) < high:
                found.append(tuple(u <= limit for u in later))


def table_longer() -> list[Campaign]:
    """Return the rows of runs that a slow part leaves open, when they go on."""
    return [_longer(*ratios) for ratios in RATIOS_SEEN]


MONTH_DAYS, MONTH_STEP_S = 30, 20.0
MONTH_SIGMAS = (0.5, 0.7, 1.0, 1.2)
MONTH_HOURS = (1, 4, 12, 23)


def _month(name: str, slowest_h: float, errors: Errors, hours: int) -> Campaign:
    """
    Return a row of the verdict on the daily runs of a month, as ``history --certify`` gives it.

    The errors go on between the runs, with a standard deviation of 1, the norm. Days are left out
    where the night between two runs is not longer than the slowest error. The risk of a false
    rejection is promised for runs of 20 times that error.
    """
    slowest_s, length = slowest_h * 3600.0, round(hours * 3600.0 / MONTH_STEP_S)
    day = round(86_400.0 / MONTH_STEP_S)
    starts = [*range(0, MONTH_DAYS * day, day if (24 - hours) > slowest_h else 2 * day)]
    risks = Settings.from_mapping({'risk.slowest_error_s': slowest_s}).risk
    limits = Limits.of(Norms(sigma_max_deg=1.0, sigma_ref_max_deg=1e-6))

    def judge(x: np.ndarray, risk: Risk) -> tuple[bool, ...]:
        runs = [_gather_run(x[start:start + length], slowest_s) for start in starts]
        outcomes = []
        for sigma in MONTH_SIGMAS:
            scaled = [_scale_run(run, sigma) for run in runs]
            together = judge_together(scaled, [limits] * len(runs), risk, 'B',
                                      (starts[1] - starts[0] - length) * MONTH_STEP_S)
            outcomes.append(conclude_sensor(together, [limits] * len(runs), True, risk)[0])
        return tuple(outcome is wanted for wanted in (Outcome.COMPLIANT, Outcome.NON_COMPLIANT)
                     for outcome in outcomes)

    def measure(rng: np.random.Generator, wanted: int | None, alpha: float) -> Result:
        n = MONTH_DAYS * day
        risk = replace(risks, alpha_consumer=alpha, alpha_producer=alpha)
        shares = np.array([judge(x, risk) for many in batches(errors, n, runs_for(n, wanted), rng)
                           for x in many]).T
        certified, rejected = (of_outcome[MONTH_SIGMAS.index(1.0)]
                               for of_outcome in np.split(shares, 2))
        return Result((f'{name}, {hours} h', str(len(starts)), str(shares.shape[1]),
                       *map(_interval, shares)), fails(certified, alpha) or (
                           hours >= JUDGED_FROM * slowest_h and fails(rejected, alpha)))
    return Campaign(f'{name}, {hours} h', measure)


def _gather_run(x_deg: np.ndarray, slowest_s: float) -> Evidence:
    """Return what a run shows, as the judge gathers it."""
    span_s = len(x_deg) * MONTH_STEP_S
    spread = estimate_spread(Cells.of(x_deg), 0, span_s / slowest_s)
    return Evidence(n=len(x_deg), spread=spread, mean_deg=float(x_deg.mean()), offset_u_deg=0.0,
                    span_s=span_s, n_plus=0, n_plus_plus=0)


def _scale_run(run: Evidence, sigma: float) -> Evidence:
    """Return the same run with errors larger by a factor."""
    spread, square = run.spread, sigma * sigma
    stated = spread.stated and replace(
        spread.stated, d_deg2=spread.stated.d_deg2 * square,
        s_deg2=spread.stated.s_deg2 * square,
        allowance_deg2=spread.stated.allowance_deg2 * square)
    return replace(run, mean_deg=run.mean_deg * sigma, spread=replace(
        spread, stated=stated, **{name: getattr(spread, name) * square for name in (
            'd_deg2', 'mean_variance_deg2', 's_deg2', 'low_deg2', 'middle_deg2')}))


def _interval(flags: np.ndarray) -> str:
    """Return a rate with its interval of 95 %, Clopper and Pearson."""
    low, high = share_interval(int(flags.sum()), flags.size)
    return f'{flags.mean():.2f} ({low:.2f} to {high:.2f})'


def table_month() -> list[Campaign]:
    """Return the rows of a gyrocompass that is judged by a month of daily runs."""
    minutes_38, hours_3, hours_12 = (h * 3600.0 / MONTH_STEP_S for h in (2300 / 3600, 3.0, 12.0))
    return [_month(name, slowest_h, errors, hours) for name, slowest_h, errors in (
        ('AR(1), 38 min', 2300 / 3600, ar1(minutes_38)),
        ('0.5 white + 0.5 AR(1), 38 min', 2300 / 3600, half(ar1(minutes_38))),
        ('damped swing, 38 min', 2300 / 3600, narrow_band(minutes_38, 2.2 * minutes_38)),
        ('AR(1), 3 h', 3.0, ar1(hours_3)),
        ('0.5 white + 0.5 AR(1), 12 h', 12.0, half(ar1(hours_12)))) for hours in MONTH_HOURS]


CAMPAIGNS = {
    'month': (table_month, ('errors; runs of', 'runs', 'months', *(
        f'{word} at {sigma:g}' for word in ('certified', 'rejected')
        for sigma in MONTH_SIGMAS))),
    'longer': (table_longer, ('R of the open run', *(
        f'seen at {low:g}-{high:g}: runs: certified at 2 / 4 / 8 times the length'
        for low, high in LEVELS_SEEN))),
    'runs': (table_runs, ('errors of each run', 'm', 'campaigns', 'every run: hi / lo',
                          'accepts', 'pooled: hi / lo', 'accepts', 'with the means: hi',
                          'accepts')),
    'means': (table_means, ('correlation times of the slow half in a run', 'campaigns',
                            'every run: hi', 'pooled: hi', 'with the means: hi',
                            'median U with the means', 'the same, white alone')),
    'looks': (table_looks, ('errors', 'runs', 'ever accepted', 'ever rejected',
                            'risk not shared', 'accepted at (share of plan)',
                            'accepted by the end')),
    'open': (table_open, ('errors', 'runs', 'ever accepted', 'ever rejected',
                          'end chosen by the data: accepted / rejected',
                          *(f'accept {s:g}: one decision / end / look' for s in OPEN_SIGMAS))),
    'stated_lengths': (table_stated_lengths, (
        'errors', *(f'accept {s:g}: known / not stated / stated' for s in SIGMAS))),
    'stated_runs': (table_stated_runs, (
        'errors; runs of lengths', 'campaigns', 'S.12: hi', 'accepts', 'S.18: hi', 'accepts',
        'S.13: hi', 'accepts', 'S.13 and S.19: hi', 'accepts')),
    'B': (table_b, ('errors', *(f'{"accept" if s < 1.0 else "reject"} {s:g}: '
                                'rule / known' for s in TARGETS)))}
"""Tables of several runs, looks or lengths: rows and heads of columns."""
