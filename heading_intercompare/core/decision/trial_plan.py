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
exponentially. The rest, and the errors of the RS, are white. All lengths, all levels and all
changes of the trial share the same random numbers, so that they differ by what they are.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
import math
from typing import Callable, Iterable, Iterator, Sequence, TypeAlias

import numpy as np

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.records import Reals
from heading_intercompare.core.settings import Norms, Settings
from heading_intercompare.core.statistics.cells import Cells
from heading_intercompare.core.statistics.confidence_bounds import share_interval
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

OUTCOMES = (Outcome.COMPLIANT, Outcome.NON_COMPLIANT, Outcome.INDETERMINATE)
"""The outcomes in the order of their chances."""

REMEDY_LEVEL = 0.7
"""The level for which changes of the trial are tried; one of `LEVELS`."""

_KNOWN_WELL = 0.9
_FASTER = 10.0

_TIMES = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0)
"""Durations that are tried, in least durations."""

_RUNS = (5, 7, 10, 14, 20)
"""Numbers of short runs that are tried."""

_MOST = 4096
"""Most differences within the least duration; a faster sensor is simulated at a lower rate."""


@dataclass(frozen=True, slots=True)
class Chance:
    """
    Probabilities of the outcomes of one run, or of several together; they add up to 1.

    Attributes
    ----------
    level
        Standard deviation of the TS as a share of its norm; None for the TS of a scenario.
    duration_s
        Length of a run, seconds.
    compliant, non_compliant, indeterminate
        The probabilities.
    runs
        Number of runs; several are judged by `campaign.rule: sensor`.
    intervals
        Their 95 % intervals, in this order.

    """

    level: float | None
    duration_s: float
    compliant: float
    non_compliant: float
    indeterminate: float
    runs: int
    intervals: tuple[tuple[float, float], ...]

    @classmethod
    def of(cls, outcomes: Iterable[Outcome], level: float | None, duration_s: float,
           runs: int = 1) -> 'Chance':
        """Return the shares of the outcomes of simulated trials."""
        counts = Counter(outcomes)
        trials = counts.total()
        compliant, non_compliant, indeterminate = (
            counts[outcome] / trials for outcome in OUTCOMES)
        return cls(level, duration_s, compliant, non_compliant, indeterminate, runs,
                   tuple(share_interval(counts[outcome], trials) for outcome in OUTCOMES))

    @property
    def total_s(self) -> float:
        """Return the time measured in all, seconds."""
        return self.runs * self.duration_s

    @property
    def shares(self) -> tuple[float, float, float]:
        """Return the probabilities, in the order of `OUTCOMES`."""
        return self.compliant, self.non_compliant, self.indeterminate


@dataclass(frozen=True, slots=True)
class Remedy:
    """
    A change of the trial that shortens it; keys of the JSON.

    Attributes
    ----------
    change
        The setting or option with its value.
    words
        What it asks of the user.
    total_s
        Time measured in all that then certifies a TS at `REMEDY_LEVEL`, seconds.

    """

    change: str
    words: str
    total_s: float


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
    total_s
        Least time measured in all that reaches `wanted` at `REMEDY_LEVEL`, seconds; None if none
        does.
    remedies
        Changes that make it shorter, the best first.
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
    total_s: float | None
    remedies: tuple[Remedy, ...]
    chances: tuple[Chance, ...]

    def __repr__(self) -> str:
        """Return the least length of a run, and the number of chances."""
        return f'<TrialPlan: a run of {self.least_s:g} s at least, {len(self.chances)} chances>'


def plan_trial(settings: Settings, rng: np.random.Generator, *, rate_hz: float = 1.0,
               slow_share: float = 1.0, wanted: float = 0.8, trials: int = 200,
               times: Sequence[float] = _TIMES, runs: Sequence[int] = _RUNS,
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
        Simulated records for each probability, at least 1.
    times
        Durations to try, in least durations, rising.
    runs
        Numbers of short runs to try, rising; none are tried if it is empty.
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
        If `rate_hz` is not above 0, there is no trial, or a share or probability is outside 0 to
        1.

    Notes
    -----
    Only the variance decides, without looks. The RS is at the upper bound of what is known of it,
    where certifying is hardest. Short runs have ten times the slowest error where their means
    count (variant B), otherwise twenty times. They lie far apart.

    Examples
    --------
    >>> settings = Settings.of(sigma_max_deg=0.2, sigma_ref_max_deg=0.1, slowest_error_s=60.0)
    >>> plan_trial(settings, np.random.default_rng(1), trials=2, times=[1.0])
    <TrialPlan: a run of 1200 s at least, 18 chances>

    """
    if not slowest_error_s(settings.risk):
        raise SettingsError('risk.slowest_error_s is missing: how long to measure follows from '
                            'the slowest error; state it, or risk.sensor_class')
    if not 0.0 < rate_hz < math.inf:
        raise ValueError(f'rate_hz = {rate_hz!r}: must be greater than 0')
    if trials < 1:
        raise ValueError(f'trials = {trials!r}: must be at least 1')
    for name, share in (('slow_share', slow_share), ('wanted', wanted)):
        if not 0.0 <= share <= 1.0:
            raise ValueError(f'{name} = {share!r}: must be from 0 to 1')
    trial = _SimulatedTrial(settings, rate_hz, slow_share,
                            tuple(rng.integers(1 << 63, size=trials).tolist()))
    short_runs = [(number, trial.short_s) for number in runs]
    single_runs = [(1, factor * trial.least_s) for factor in times]
    several, advised_runs = _search(trial, short_runs, wanted, progress)
    single, advised_s = _search(trial, single_runs, wanted, progress)
    place = LEVELS.index(REMEDY_LEVEL)
    total_s = min((chance.total_s for chance in (advised_runs[place], advised_s[place])
                   if chance is not None), default=None)
    return TrialPlan(
        least_s=trial.least_s, slowest_error_s=trial.slowest_s,
        sigma_ref_deg=trial.sigma_ref_deg, trials=trials, wanted=wanted,
        advised_s=tuple(None if chance is None else chance.duration_s for chance in advised_s),
        short_s=trial.short_s,
        advised_runs=tuple(None if chance is None else chance.runs for chance in advised_runs),
        total_s=total_s,
        remedies=_find_remedies(trial, (*short_runs, *single_runs), wanted, total_s, progress),
        chances=(*several, *single))


#: Number of runs, and the length of each in seconds.
_Length: TypeAlias = 'tuple[int, float]'


def _search(trial: '_SimulatedTrial', lengths: Iterable[_Length], wanted: float,
            progress: Callable[[str], None] = lambda text: None,
            ) -> tuple[list[Chance], list[Chance | None]]:
    """Try rising lengths until each level reaches the probability; return the first that do."""
    chances: list[Chance] = []
    advised: list[Chance | None] = [None] * len(trial.levels)
    for runs, duration_s in lengths:
        progress(f'{runs} x {duration_s:.0f} s')
        level_chances = trial.simulate(runs, duration_s)
        chances += level_chances
        for place, chance in enumerate(level_chances):
            if advised[place] is None and chance.compliant >= wanted:
                advised[place] = chance
        if None not in advised:
            break
    return chances, advised


def _find_remedies(trial: '_SimulatedTrial', lengths: Sequence[_Length], wanted: float,
                   total_s: float | None,
                   progress: Callable[[str], None]) -> tuple[Remedy, ...]:
    """Try what a user can change; return what certifies in less time, the best first."""
    remedies = []
    shorter = sorted((length for length in lengths
                      if total_s is None or length[0] * length[1] < total_s),
                     key=lambda length: length[0] * length[1])
    for change, words, changed in _list_changes(trial):
        progress(change)
        [first] = _search(changed, shorter, wanted)[1]
        if first is not None:
            remedies.append(Remedy(change, words, first.total_s))
    return tuple(sorted(remedies, key=lambda remedy: remedy.total_s))


def _list_changes(trial: '_SimulatedTrial') -> 'Iterator[tuple[str, str, _SimulatedTrial]]':
    """Yield what a user can change: the words, and the trial with it at `REMEDY_LEVEL`."""
    settings, norms = trial.settings, trial.settings.norms

    def judge_by(changed_norms: Norms, rate_hz: float = trial.rate_hz) -> _SimulatedTrial:
        return _SimulatedTrial(replace(settings, norms=changed_norms), rate_hz, trial.slow_share,
                               trial.seeds, (REMEDY_LEVEL,))

    if norms.sigma_ref_deg is None and norms.m_low < _KNOWN_WELL <= norms.m_up:
        yield (f'norms.m_low={_KNOWN_WELL:g}',
               f'the RS is known to have at least {_KNOWN_WELL:g} of its norm',
               judge_by(replace(norms, m_low=_KNOWN_WELL)))
    if norms.sigma_ref_max_deg:
        half_deg = 0.5 * norms.sigma_ref_max_deg
        actual_deg = None if norms.sigma_ref_deg is None else 0.5 * norms.sigma_ref_deg
        yield (f'norms.sigma_ref_max_deg={half_deg:g}'
               + ('' if actual_deg is None else f', norms.sigma_ref_deg={actual_deg:g}'),
               'an RS twice as good',
               judge_by(replace(norms, sigma_ref_max_deg=half_deg, sigma_ref_deg=actual_deg)))
    if trial.rate_hz * trial.least_s < _MOST:
        yield (f'--rate {_FASTER * trial.rate_hz:g}', 'pairs ten times as often',
               judge_by(norms, _FASTER * trial.rate_hz))


class SimulatedErrors:
    """
    The errors of one simulated run, of unit variance, which goes on as long as it is asked.

    Parameters
    ----------
    seed
        Its errors are the same for the same seed, in whatever pieces they are drawn.
    step_s
        Seconds between differences.
    slowest_s
        Time in which the correlation of the slow error falls to 1/e, seconds.

    """

    def __init__(self, seed: Sequence[int], step_s: float, slowest_s: float) -> None:
        self._rng = np.random.default_rng(seed)
        self._phi = math.exp(-step_s / slowest_s)
        self._last = float(self._rng.standard_normal())

    def draw(self, n: int) -> tuple[Reals, Reals]:
        """Return the next n values of the slow error, and of the white ones."""
        steps, white = self._rng.standard_normal((n, 2)).T
        slow, state = scipy.signal.lfilter([math.sqrt(1.0 - self._phi * self._phi)],
                                           [1.0, -self._phi], steps, zi=[self._phi * self._last])
        self._last = float(state[0]) / self._phi if n and self._phi > 0.0 else self._last
        return slow, white


class _GrowingRun:
    """One simulated run at each level, which grows."""

    def __init__(self, trial: '_SimulatedTrial', seed: Sequence[int], step_s: float) -> None:
        self._trial, self._step_s, self._n = trial, step_s, 0
        self._errors = SimulatedErrors(seed, step_s, trial.slowest_s)
        self._cells = [Cells() for _ in trial.levels]

    def grow(self, duration_s: float) -> list[Evidence]:
        """Let it last until this duration, not before the last one; return it by level."""
        n = math.floor(duration_s / self._step_s * (1.0 + 1e-12)) + 1
        slow, white = self._errors.draw(n - self._n)
        self._n = n
        for cells, (slow_deg, white_deg) in zip(self._cells, self._trial.sizes_deg):
            cells.update(slow_deg * slow + white_deg * white)
        return [self._gather(cells, duration_s) for cells in self._cells]

    def _gather(self, cells: Cells, duration_s: float) -> Evidence:
        figures = cells.values()
        spread = None if figures is None else estimate_spread(
            figures, times=duration_s / self._trial.slowest_s)
        return Evidence(n=self._n, spread=spread,
                        mean_deg=None if figures is None else figures.mean_deg,
                        offset_u_deg=0.0, span_s=duration_s, n_plus=0, n_plus_plus=0)


class _SimulatedTrial:
    """
    Simulated records of the trial to plan, and how often they give each outcome.

    Parameters
    ----------
    seeds
        One for each simulated trial.
    levels
        Standard deviations of the TS as shares of its norm.

    """

    def __init__(self, settings: Settings, rate_hz: float, slow_share: float,
                 seeds: tuple[int, ...], levels: tuple[float, ...] = LEVELS) -> None:
        self.settings, self.rate_hz, self.slow_share = settings, rate_hz, slow_share
        self.seeds, self.levels = seeds, levels
        self.slowest_s = slowest_error_s(settings.risk) or 0.0
        self.least_s = least_duration_s(settings.risk)
        self.short_s = self.slowest_s * (
            LEAST_TIMES_OF_MEANS if settings.variant == 'B' else LEAST_TIMES)
        self._limits = Limits.of(settings.norms, settings.model)
        self.sigma_ref_deg = self._limits.m_up * self._limits.sigma_ref_max_deg
        sigmas_deg = [level * self._limits.sigma_max_deg for level in levels]
        self.sizes_deg = [(sigma_deg * math.sqrt(slow_share),
                           math.hypot(sigma_deg * math.sqrt(1.0 - slow_share),
                                      self.sigma_ref_deg)) for sigma_deg in sigmas_deg]
        self._single = [self._begin(seed, 0, self.least_s) for seed in seeds]
        self._several: list[list[list[Evidence]]] = [[] for _ in seeds]

    def simulate(self, runs: int, duration_s: float) -> list[Chance]:
        """Return the chances at each level; a single run must not be shorter than the last."""
        if runs == 1:
            outcomes = [[self._decide(evidence) for evidence in run.grow(duration_s)]
                        for run in self._single]
        else:
            for seed, evidences in zip(self.seeds, self._several):
                evidences += [self._begin(seed, number, duration_s).grow(duration_s)
                              for number in range(len(evidences) + 1, runs + 1)]
            outcomes = [[self._conclude(at_level) for at_level in zip(*evidences[:runs])]
                        for evidences in self._several]
        return [Chance.of(at_level, level, duration_s, runs)
                for level, at_level in zip(self.levels, zip(*outcomes))]

    def _begin(self, seed: int, number: int, span_s: float) -> _GrowingRun:
        return _GrowingRun(self, (seed, number), max(1.0 / self.rate_hz, span_s / _MOST))

    def _decide(self, evidence: Evidence) -> Outcome:
        if evidence.spread is None:
            return Outcome.INDETERMINATE
        return decide_variance(evidence.spread, evidence.span_s, self._limits,
                               self.settings.risk)[0]

    def _conclude(self, runs: Sequence[Evidence]) -> Outcome:
        limits, risk = [self._limits] * len(runs), self.settings.risk
        together = judge_together(runs, limits, risk, self.settings.variant)
        return conclude_sensor(together, limits, True, risk)[0]
