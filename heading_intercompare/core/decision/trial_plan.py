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

"""
How long to measure: the probability of each outcome before a trial, by simulation.

Simulated records go through the decision of a run, or of several runs together. The errors are
normal. A share of the TS variance belongs to the slowest error stated, whose correlation falls
exponentially. The rest, and the errors of the RS, are white.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
import math
from typing import Callable, Iterable, Sequence, TypeAlias, TypeVar

import numpy as np

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.records import Reals
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.statistics.cells import Cells
from heading_intercompare.core.statistics.variance_uncertainty import (
    estimate_spread,
    LEAST_TIMES,
)

from .campaign import conclude_sensor, judge_together, LEAST_TIMES_OF_MEANS
from .coverage import least_duration_s, slowest_error_s
from .criteria import Limits
from .guarded import decide_variance, Evidence

LEVELS = (0.5, 0.7, 0.85)
"""Standard deviations of the TS for which chances are given, as shares of its norm."""

_TIMES = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0)
"""Durations that are tried, in least durations."""

_RUNS = (5, 10, 20)
"""Numbers of short runs that are tried."""

_MOST = 4096
"""Most differences of a simulated record; a faster sensor is simulated at a lower rate."""


@dataclass(frozen=True, slots=True)
class Chance:
    """
    Probabilities of the outcomes of one run, or of several together; they add up to 1.

    Attributes
    ----------
    level
        Standard deviation of the TS as a share of its norm.
    duration_s
        Length of a run, seconds.
    compliant, non_compliant, indeterminate
        The probabilities.
    runs
        Number of runs; several are judged by `campaign.rule: sensor`.

    """

    level: float
    duration_s: float
    compliant: float
    non_compliant: float
    indeterminate: float
    runs: int = 1


@dataclass(frozen=True, slots=True)
class TrialPlan:
    """
    How long to measure.

    Attributes
    ----------
    least_s
        Least length of a run that may comply, seconds.
    slowest_error_s
        Slowest error stated, seconds.
    sigma_ref_deg
        Standard deviation of the simulated RS, degrees.
    trials
        Simulated records for each probability; its standard error is at most 0.5 / sqrt(trials).
    wanted
        Probability of certifying that is aimed at.
    advised_s
        For each of `LEVELS` the shortest single run tried that reaches `wanted`; None if none
        does.
    short_s
        Length of one of several short runs, seconds.
    advised_runs
        For each of `LEVELS` the fewest short runs tried that reach `wanted`; None if none do.
    chances
        Several runs by number, then single runs by duration; then by level.

    """

    least_s: float
    slowest_error_s: float
    sigma_ref_deg: float
    trials: int
    wanted: float
    advised_s: tuple[float | None, ...]
    short_s: float
    advised_runs: tuple[int | None, ...]
    chances: tuple[Chance, ...]

    def __repr__(self) -> str:
        """Return the least length of a run, and the number of chances."""
        return f'<TrialPlan: a run of {self.least_s:g} s at least, {len(self.chances)} chances>'


def plan_trial(settings: Settings, rng: np.random.Generator, *, rate_hz: float = 1.0,
               slow_share: float = 1.0, wanted: float = 0.8, trials: int = 100,
               times: Sequence[float] = _TIMES,
               progress: Callable[[str], None] = lambda text: None) -> TrialPlan:
    """
    Return the probabilities of the outcomes for several short runs, and for single runs.

    Parameters
    ----------
    settings
        Must hold the norms and the slowest error, by `risk.slowest_error_s` or
        `risk.sensor_class`.
    rng
        Source of the random numbers.
    rate_hz
        Pairs per second.
    slow_share
        Share of the TS variance that belongs to the slowest error, from 0 to 1.
    wanted
        Probability of certifying that is aimed at. No longer runs are tried once all of `LEVELS`
        reach it.
    trials
        Simulated records for each probability.
    times
        Durations to try, in least durations, rising.
    progress
        Called with the progress in words.

    Returns
    -------
    TrialPlan

    Raises
    ------
    SettingsError
        If a norm or the slowest error is missing.
    ValueError
        If `rate_hz` is not above 0, or a share or probability is outside 0 to 1.

    Notes
    -----
    Only the variance decides, without looks. The RS is at the upper bound of what is known of it,
    where certifying is hardest. Short runs have ten times the slowest error where their means
    count (variant B), otherwise twenty times. They lie far apart.

    Examples
    --------
    >>> settings = Settings.of(sigma_max_deg=0.2, sigma_ref_max_deg=0.1, slowest_error_s=60.0)
    >>> plan_trial(settings, np.random.default_rng(1), trials=2, times=[1.0])
    <TrialPlan: a run of 1200 s at least, 12 chances>

    """
    slowest = slowest_error_s(settings.risk)
    if not slowest:
        raise SettingsError('risk.slowest_error_s is missing: how long to measure follows from '
                            'the slowest error; state it, or risk.sensor_class')
    if not 0.0 < rate_hz < math.inf:
        raise ValueError(f'rate_hz = {rate_hz!r}: must be greater than 0')
    for name, share in (('slow_share', slow_share), ('wanted', wanted)):
        if not 0.0 <= share <= 1.0:
            raise ValueError(f'{name} = {share!r}: must be from 0 to 1')
    trial = _SimulatedTrial(settings=settings, limits=Limits.of(settings.norms, settings.model),
                            slowest_s=slowest, rate_hz=rate_hz, slow_share=slow_share,
                            trials=trials, rng=rng)
    least_s = least_duration_s(settings.risk)
    short_s = (LEAST_TIMES_OF_MEANS if settings.variant == 'B' else LEAST_TIMES) * slowest
    steps = len(_RUNS) + len(times)
    chances: list[Chance] = []
    advised_runs: list[int | None] = [None] * len(LEVELS)
    records: _Records = [[[] for _ in range(trials)] for _ in LEVELS]
    for done, runs in enumerate(_RUNS):
        progress(f'{done} of {steps} plans')
        chances_together = trial.extend(records, runs, short_s)
        chances += chances_together
        _advise(advised_runs, chances_together, wanted, runs)
        if None not in advised_runs:
            break
    advised_s: list[float | None] = [None] * len(LEVELS)
    for done, duration_s in enumerate((factor * least_s for factor in times), start=len(_RUNS)):
        progress(f'{done} of {steps} plans')
        chances_alone = trial.simulate_run(duration_s)
        chances += chances_alone
        _advise(advised_s, chances_alone, wanted, duration_s)
        if None not in advised_s:
            break
    return TrialPlan(
        least_s=least_s, slowest_error_s=slowest, sigma_ref_deg=trial.sigma_ref_deg, trials=trials,
        wanted=wanted, advised_s=tuple(advised_s), short_s=short_s,
        advised_runs=tuple(advised_runs), chances=tuple(chances))


#: The runs of each trial, by level.
_Records: TypeAlias = 'list[list[list[Evidence]]]'
_Length = TypeVar('_Length', int, float)


def _advise(advised: list[_Length | None], chances: Sequence[Chance], wanted: float,
            length: _Length) -> None:
    """Note this length where it is the first that certifies with the probability wanted."""
    for place, chance in enumerate(chances):
        if advised[place] is None and chance.compliant >= wanted:
            advised[place] = length


@dataclass(frozen=True, slots=True)
class _SimulatedTrial:
    """Simulated records of the trial to plan, and how often they give each outcome."""

    settings: Settings
    limits: Limits
    slowest_s: float
    rate_hz: float
    slow_share: float
    trials: int
    rng: np.random.Generator

    @property
    def sigma_ref_deg(self) -> float:
        return self.limits.m_up * self.limits.sigma_ref_max_deg

    def extend(self, records: _Records, n: int, short_s: float) -> list[Chance]:
        """Simulate up to n short runs of each record; return their chances at each level."""
        chances = []
        for level, trials in zip(LEVELS, records):
            for runs in trials:
                runs += [self._simulate(short_s, level) for _ in range(n - len(runs))]
            chances.append(self._count(level, short_s, map(self._conclude, trials), n))
        return chances

    def simulate_run(self, duration_s: float) -> list[Chance]:
        """Return the chances of a single run at each level."""
        return [self._count(level, duration_s, [
            self._decide(self._simulate(duration_s, level)) for _ in range(self.trials)])
            for level in LEVELS]

    def _simulate(self, duration_s: float, level: float) -> Evidence:
        x_deg, _ = simulate_differences(
            self.rng, duration_s, self.rate_hz, self.sigma_ref_deg, self.slowest_s,
            level * self.limits.sigma_max_deg, self.slow_share)
        spread = estimate_spread(Cells.of(x_deg), times=duration_s / self.slowest_s)
        return Evidence(n=len(x_deg), spread=spread, mean_deg=float(x_deg.mean()),
                        offset_u_deg=0.0, span_s=duration_s, n_plus=0, n_plus_plus=0)

    def _decide(self, evidence: Evidence) -> Outcome:
        if evidence.spread is None:
            return Outcome.INDETERMINATE
        return decide_variance(evidence.spread, evidence.span_s, self.limits,
                               self.settings.risk)[0]

    def _conclude(self, runs: Sequence[Evidence]) -> Outcome:
        limits, risk = [self.limits] * len(runs), self.settings.risk
        together = judge_together(runs, limits, risk, self.settings.variant)
        return conclude_sensor(together, limits, True, risk)[0]

    def _count(self, level: float, duration_s: float, outcomes: Iterable[Outcome],
               runs: int = 1) -> Chance:
        counts = Counter(outcomes)
        share = {outcome: counts[outcome] / self.trials for outcome in Outcome}
        return Chance(level, duration_s, share[Outcome.COMPLIANT], share[Outcome.NON_COMPLIANT],
                      share[Outcome.INDETERMINATE], runs)


def simulate_differences(rng: np.random.Generator, duration_s: float, rate_hz: float,
                         sigma_ref_deg: float, slowest_s: float, sigma_deg: float,
                         slow_share: float) -> tuple[Reals, float]:
    """
    Return the differences of a simulated run and their step.

    Parameters
    ----------
    rng
        Source of the noise.
    duration_s, rate_hz
        Length of the run, seconds, and pairs per second.
    sigma_ref_deg, sigma_deg
        Standard deviations of RS and TS, degrees.
    slowest_s
        Time in which the correlation of the slow error falls to 1/e, seconds.
    slow_share
        Its share of the TS variance.

    Returns
    -------
    x_deg : ndarray, shape (n,)
        At most 4096 differences, degrees.
    step_s : float
        Seconds between them.

    """
    n = max(1, min(_MOST, math.floor(duration_s * rate_hz) + 1))
    step_s = duration_s / n
    phi = math.exp(-step_s / slowest_s)
    white = rng.standard_normal(n)
    start = rng.standard_normal()
    slow, _ = scipy.signal.lfilter([math.sqrt(1.0 - phi * phi)], [1.0, -phi], white,
                                   zi=[phi * start])
    rest = rng.standard_normal(n) * math.hypot(sigma_deg * math.sqrt(1.0 - slow_share),
                                               sigma_ref_deg)
    x_deg: Reals = sigma_deg * math.sqrt(slow_share) * slow + rest
    return x_deg, step_s
