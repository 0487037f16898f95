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
How long to measure with the sensors of a scenario: chances of each outcome by simulated trials.

Each seed gives one record. It is cut at growing lengths, and each cut is judged as a recording is.
So the chances of two lengths differ by the lengths alone.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from functools import partial
import math
from typing import Callable, Iterable, Sequence

from heading_intercompare.ahrs.plans import parse_legs
from heading_intercompare.ahrs.settings import Scenario
from heading_intercompare.ahrs.ship.track_course import Track
from heading_intercompare.ahrs.simulator import Simulation
from heading_intercompare.core.decision.coverage import least_duration_s
from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.decision.trial_plan import Chance
from heading_intercompare.core.norm_tests.judged_test import JudgedTest, STATES
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.validity.condition import is_doubtful
from heading_intercompare.core.verdict.verdict_document import Verdict

from .seeds import run_seeds
from .simulated_record import simulate_record

SHARES = (0.125, 0.25, 0.375, 0.5, 0.75, 1.0)
"""Lengths that are tried, as shares of the longest."""

#: The trial goes on for this long after a length, so that the pairs span all of it.
_MARGIN_S = 5.0


@dataclass(frozen=True, slots=True)
class TrueDeviation:
    """
    The standard deviation of the errors of a simulated sensor against its norm; keys of the JSON.

    Attributes
    ----------
    norm_deg
        Norm of the standard deviation, degrees.
    std_deg
        Root mean square of the standard deviations of all seeds, degrees; None without a reading.
    range_deg
        The least and the largest of them, degrees; None without a reading.

    """

    norm_deg: float
    std_deg: float | None
    range_deg: tuple[float, float] | None

    @classmethod
    def of(cls, norm_deg: float, stds_deg: Iterable[float]) -> 'TrueDeviation':
        """Return it from the standard deviation of each seed; nan is a seed without a reading."""
        valid_deg = [std_deg for std_deg in stds_deg if math.isfinite(std_deg)]
        if not valid_deg:
            return cls(norm_deg, None, None)
        return cls(norm_deg, math.hypot(*valid_deg) / math.sqrt(len(valid_deg)),
                   (min(valid_deg), max(valid_deg)))

    @property
    def words(self) -> str:
        """Return what it says."""
        if self.std_deg is None or self.range_deg is None:
            return 'no reading'
        low_deg, up_deg = self.range_deg
        share = f'{self.std_deg / self.norm_deg:.2f} of its norm of ' if self.norm_deg else 'norm '
        return (f'true standard deviation {self.std_deg:.4f} deg ({low_deg:.4f} to {up_deg:.4f} '
                f'by seed), {share}{self.norm_deg:g} deg')


@dataclass(frozen=True, slots=True)
class ScenarioPlan:
    """
    How long to measure with the sensors of a scenario; keys of the JSON.

    Attributes
    ----------
    least_s
        Least length of a run that may comply, seconds.
    seeds
        The seeds, one for each trial.
    probability
        Probability of certifying that is aimed at.
    ts, rs
        What the sensors are in truth.
    advised_s
        The shortest length tried that reaches `probability`, seconds; None if none does.
    reasons
        How many of the longest trials have each outcome and reason, the most frequent first.
    chances
        The chances by length.
    tests
        For each test that the norm requires, the number of the longest trials in which it is met,
        not met, open, or not sailed.

    """

    least_s: float
    seeds: tuple[int, ...]
    probability: float
    ts: TrueDeviation
    rs: TrueDeviation
    advised_s: float | None
    reasons: dict[str, int]
    chances: tuple[Chance, ...]
    tests: dict[str, dict[str, int]]


@dataclass(frozen=True, slots=True)
class _SeedTrial:
    """The trial with one seed: outcome by length, the longest, true deviations."""

    outcomes: tuple[Outcome, ...]
    reason: str
    tests: tuple[JudgedTest, ...]
    ts_std_deg: float
    rs_std_deg: float


def plan_scenario(scenario: Scenario, settings: Settings, *, trials: int = 20,
                  probability: float = 0.8, track: Track | None = None, jobs: int | None = None,
                  progress: Callable[[str], None] = lambda text: None) -> ScenarioPlan:
    """
    Return the chances of each outcome by the length of a trial with the sensors of a scenario.

    Parameters
    ----------
    scenario
        The trial of the longest length. Its sensors `ts` and `rs` are compared.
    settings
        With the norms.
    trials
        Number of seeds, from that of the scenario on.
    probability
        Probability of certifying that is aimed at.
    track
        The voyage that the ship repeats; no length exceeds it.
    jobs
        As for `run_seeds`.
    progress
        Called with the progress in words.

    Raises
    ------
    SettingsError
        If a norm is missing.
    ValueError
        If there is no trial, the probability is outside 0 to 1, or a process died.

    """
    if trials < 1:
        raise ValueError(f'trials = {trials!r}: must be at least 1')
    if not 0.0 <= probability <= 1.0:
        raise ValueError(f'probability = {probability!r}: must be from 0 to 1')
    limits = Limits.of(settings.norms, settings.model)
    longer = replace(scenario, duration_s=scenario.duration_s + _MARGIN_S, others='')
    longest_s = Simulation(longer, track=track).scenario.duration_s - _MARGIN_S
    lengths_s = [share * longest_s for share in SHARES]
    seeds = range(scenario.seed, scenario.seed + trials)
    results = run_seeds(partial(_try_seed, longer, settings, track, lengths_s), seeds,
                        longest_s, jobs, progress)
    chances = tuple(Chance.of(outcomes, None, length_s) for length_s, outcomes in zip(
        lengths_s, zip(*(result.outcomes for result in results))))
    return ScenarioPlan(
        least_s=least_duration_s(settings.risk), seeds=tuple(seeds),
        probability=probability,
        ts=TrueDeviation.of(limits.sigma_max_deg, [result.ts_std_deg for result in results]),
        rs=TrueDeviation.of(limits.sigma_ref_max_deg, [result.rs_std_deg for result in results]),
        advised_s=next((chance.duration_s for chance in chances
                        if chance.compliant >= probability), None),
        reasons=dict(Counter(result.reason for result in results).most_common()),
        chances=chances, tests=_count_states(result.tests for result in results))


def _try_seed(scenario: Scenario, settings: Settings, track: Track | None,
              lengths_s: Sequence[float], seed: int) -> _SeedTrial:
    """Simulate the trial with a seed, and judge what it has measured at each length."""
    record = simulate_record(Simulation(replace(scenario, seed=seed), track=track))
    verdicts = [record.judge(settings, length_s + _MARGIN_S / 2.0) for length_s in lengths_s]
    return _SeedTrial(tuple(verdict.outcome for verdict in verdicts), _explain(verdicts[-1]),
                      tuple(verdicts[-1].campaign.norm_tests or ()),
                      record.true_std_deg('ts'), record.true_std_deg('rs'))


def _count_states(tables: Iterable[Sequence[JudgedTest]]) -> dict[str, dict[str, int]]:
    """Return how often each test has each state."""
    counts: dict[str, dict[str, int]] = {}
    for table in tables:
        for test in table:
            states = counts.setdefault(test.words, dict.fromkeys(STATES, 0))
            states[test.state] += 1
    return counts


def _explain(verdict: Verdict) -> str:
    """Return outcome and reason of a verdict."""
    reason = verdict.runs[0].reason if len(verdict.runs) == 1 else verdict.campaign.reason
    doubt = ', doubtful' if is_doubtful(verdict.outcome, verdict.validity_effect) else ''
    return f'{verdict.outcome.words}{doubt}: {reason}'


def lengthen(scenario: Scenario, duration_s: float) -> Scenario:
    """
    Return a scenario of another length, whose legs are sailed again if it is longer.

    Raises
    ------
    SettingsError
        If the length is outside the range of the setting `duration_s`.

    Examples
    --------
    >>> longer = lengthen(Scenario(duration_s=600.0, legs='0 10 8; 300 50 8'), 1000.0)
    >>> longer.duration_s, longer.legs
    (1000.0, '0.0 10.0 8.0; 300.0 50.0 8.0; 600.0 10.0 8.0; 900.0 50.0 8.0')

    """
    longer = replace(scenario, duration_s=duration_s)
    legs = [leg for leg in parse_legs(scenario.legs) if leg.t_s < scenario.duration_s]
    rounds = math.ceil(duration_s / scenario.duration_s)
    sailed = [replace(leg, t_s=leg.t_s + at * scenario.duration_s)
              for at in range(rounds) for leg in legs]
    return replace(longer, legs='; '.join(
        f'{leg.t_s!r} {leg.course_deg!r} {leg.speed_kn!r}' for leg in sailed
        if leg.t_s < duration_s))
