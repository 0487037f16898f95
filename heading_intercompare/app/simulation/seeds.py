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

"""One trial with many seeds: the spread of its figures, and the coverage of the analysis."""

from __future__ import annotations

from collections import Counter
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace
from functools import partial
import math
from typing import Callable, Iterator, Sequence, TypeVar

import numpy as np

from heading_intercompare.ahrs.settings import Scenario
from heading_intercompare.ahrs.ship.track_course import Track
from heading_intercompare.ahrs.simulator import Simulation
from heading_intercompare.app.campaign import complete_tasks, count_cores, open_pool
from heading_intercompare.core.records import Reals
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.statistics.confidence_bounds import share_interval

from .simulated_record import simulate_record

_Result = TypeVar('_Result')

_TWO_SIGMA = 2.0
#: Shorter trials in all are simulated here: starting processes would take longer.
_WORTH_S = 36_000.0


@dataclass(frozen=True, slots=True)
class SeedResult:
    """
    The trial with one seed: what the analysis found, and what was true.

    Attributes
    ----------
    outcome
        Of the verdict.
    mean_deg, std_deg
        Mean and standard deviation of the differences TS - RS of the first run; nan without one.
    interval_deg
        The 95 % interval that the analysis states for the mean; nan without one.
    true_mean_deg, true_std_deg
        Mean and standard deviation of the errors of the TS against the true heading.
    covered
        Share of the readings of the TS whose error is at most twice the standard deviation that
        it claims; nan without claims.

    """

    seed: int
    outcome: str
    mean_deg: float
    std_deg: float
    interval_deg: tuple[float, float]
    true_mean_deg: float
    true_std_deg: float
    covered: float


@dataclass(frozen=True, slots=True)
class Repeated:
    """The results of all seeds."""

    results: tuple[SeedResult, ...]

    @property
    def words(self) -> Iterator[str]:
        """Yield a line per figure, over the seeds that have it."""
        n = len(self.results)
        counts = Counter(result.outcome for result in self.results)
        yield f'outcomes of {n} seeds: ' + ', '.join(
            f'{outcome} {count}' for outcome, count in sorted(counts.items()))
        for name, words in (
                ('true_mean_deg', 'mean error of the TS'),
                ('true_std_deg', 'standard deviation of its error'),
                ('mean_deg', 'mean difference TS - RS'),
                ('std_deg', 'standard deviation of the difference')):
            values = self.values(name)
            if values.size:
                yield (f'{words}: mean {np.mean(values):+.4f} deg, spread {_spread(values):.4f} '
                       f'deg, {values.min():+.4f} to {values.max():+.4f} deg')
        within, judged = self.coverage
        if judged:
            low, high = share_interval(within, judged)
            yield (f'the 95 % interval of the mean difference holds the mean of the other seeds '
                   f'in {within} of {judged} seeds: {within / judged:.0%} '
                   f'({low:.0%} to {high:.0%})')
        covered = self.values('covered')
        if covered.size:
            yield (f'errors of the TS within twice its claim: {np.mean(covered):.1%} of the '
                   f'readings, {covered.min():.1%} to {covered.max():.1%} by seed')

    @property
    def table(self) -> dict[str, Reals]:
        """Return the figures that are drawn, a column each; nan where a seed has none."""
        rows = [(result.seed, result.true_mean_deg, result.mean_deg, *result.interval_deg)
                for result in self.results]
        return dict(zip(('seed', 'true_mean_deg', 'mean_deg', 'low_deg', 'high_deg'),
                        np.array(rows, np.float64).T))

    def values(self, name: str) -> Reals:
        """Return a figure of every seed that has it."""
        values = np.array([getattr(result, name) for result in self.results], np.float64)
        return values[np.isfinite(values)]

    @property
    def coverage(self) -> tuple[int, int]:
        """
        Return the seeds whose interval holds the mean, and the seeds that have an interval.

        The mean is that of the other seeds. Its own uncertainty widens the interval.
        """
        sound = [result for result in self.results if all(map(math.isfinite, result.interval_deg))]
        if len(sound) < 3:
            return 0, 0
        means = np.array([result.mean_deg for result in sound])
        within = 0
        for k, result in enumerate(sound):
            others = np.delete(means, k)
            low, high = result.interval_deg
            half = math.hypot(0.5 * (high - low), _TWO_SIGMA * _spread(others)
                              / math.sqrt(others.size))
            within += abs(result.mean_deg - float(others.mean())) <= half
        return within, len(sound)


def _spread(values: Reals) -> float:
    """Return the standard deviation; 0 for a single value."""
    return float(np.std(values, ddof=1)) if values.size > 1 else 0.0


def repeat_trial(scenario: Scenario, seeds: Sequence[int], settings: Settings, *,
                 track: Track | None = None, jobs: int | None = None,
                 progress: Callable[[str], None] = lambda text: None) -> Repeated:
    """
    Simulate and judge a trial with many seeds.

    Parameters
    ----------
    scenario
        The trial; its own seed is not used.
    seeds
        A trial is made for each.
    settings
        With the norms.
    track
        The voyage that the ship repeats.
    jobs
        As for `run_seeds`.
    progress
        Called with the progress in words.

    Raises
    ------
    SettingsError
        If a norm is missing.

    """
    judge_seed = partial(_judge_seed, scenario, settings, track)
    return Repeated(tuple(run_seeds(judge_seed, seeds, scenario.duration_s, jobs, progress)))


def run_seeds(task: Callable[[int], _Result], seeds: Sequence[int], duration_s: float,
              jobs: int | None, progress: Callable[[str], None]) -> list[_Result]:
    """
    Return the result of each seed of a trial, in their order.

    Parameters
    ----------
    task
        Simulates the trial with a seed; a function of a module, or a partial one.
    seeds
        The seeds.
    duration_s
        Length of the trial, seconds.
    jobs
        Processes; by default one per core, or none if the trials are short.
    progress
        Called with the progress in words.

    Raises
    ------
    ValueError
        If a process died.

    """
    if jobs is None:
        jobs = count_cores() if len(seeds) * duration_s >= _WORTH_S else 1
    jobs = min(jobs, len(seeds))
    if jobs < 2:
        results = []
        for done, seed in enumerate(seeds):
            progress(f'{done} of {len(seeds)} done')
            results.append(task(seed))
        return results
    with open_pool(jobs) as pool:
        futures = complete_tasks(pool, [partial(task, seed) for seed in seeds],
                                 [f'seed {seed}' for seed in seeds], progress)
    try:
        return [future.result() for future in futures]
    except BrokenProcessPool as error:
        raise ValueError(f'--jobs {jobs}: a process that simulated died (out of memory?); use '
                         'fewer') from error


def _judge_seed(scenario: Scenario, settings: Settings, track: Track | None,
                seed: int) -> SeedResult:
    """Simulate and judge the trial with a seed."""
    record = simulate_record(Simulation(replace(scenario, seed=seed), track=track))
    verdict = record.judge(settings)
    error_deg, claim_deg = record.error_deg['ts'], record.readings['ts'].sigma_deg
    valid = np.isfinite(error_deg)
    error_deg, claim_deg = error_deg[valid], claim_deg[valid]
    claimed = np.isfinite(claim_deg) & (claim_deg > 0.0)
    run = verdict.runs[0] if verdict.runs else None
    mean_deg = math.nan if run is None or run.mean_deg is None else run.mean_deg
    std_deg = math.nan if run is None or run.std_deg is None else run.std_deg
    interval = None if run is None else run.guarded.bias_interval_deg
    return SeedResult(
        seed=seed, outcome=verdict.outcome.value, mean_deg=mean_deg,
        std_deg=std_deg, interval_deg=interval or (math.nan, math.nan),
        true_mean_deg=float(error_deg.mean()) if error_deg.size else math.nan,
        true_std_deg=record.true_std_deg('ts'),
        covered=float(np.mean(np.abs(error_deg[claimed]) <= _TWO_SIGMA * claim_deg[claimed]))
        if claimed.any() else math.nan)
