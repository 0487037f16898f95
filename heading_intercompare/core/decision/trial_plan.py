# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
How long to measure: the probability of each outcome before a trial, by simulation.

Simulated records go through the decision of a run. The errors are normal. A share of the TS
variance belongs to the slowest error stated, whose correlation falls exponentially. The rest, and
the errors of the RS, are white.
"""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Callable, Sequence

import numpy as np
import scipy

from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.records import Reals
from heading_intercompare.core.settings import Settings, SettingsError
from heading_intercompare.core.statistics.cells import Cells
from heading_intercompare.core.statistics.variance_uncertainty import estimate_spread

from .coverage import least_duration_s, slowest_error_s
from .criteria import Limits
from .guarded import decide_variance

__all__ = ['Chance', 'LEVELS', 'plan_trial', 'simulate_differences', 'TrialPlan']

LEVELS = (0.5, 0.7, 0.85)
"""Standard deviations of the TS for which chances are given, as shares of its norm."""

_TIMES = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0)
"""Durations that are tried, in least durations."""

_MOST = 4096
"""Most differences of a simulated record; a faster sensor is simulated at a lower rate."""


@dataclass(frozen=True, slots=True)
class Chance:
    """
    Probabilities of the outcomes of one run; they add up to 1.

    Attributes
    ----------
    level : float
        Standard deviation of the TS as a share of its norm.
    duration_s : float
        Length of the run, seconds.
    compliant, non_compliant, indeterminate : float
        The probabilities.

    """

    level: float
    duration_s: float
    compliant: float
    non_compliant: float
    indeterminate: float


@dataclass(frozen=True, slots=True)
class TrialPlan:
    """
    How long to measure.

    Attributes
    ----------
    least_s : float
        Least length of a run that may comply, seconds.
    slowest_error_s : float
        Slowest error stated, seconds.
    sigma_ref_deg : float
        Standard deviation of the simulated RS, degrees.
    trials : int
        Simulated records for each probability; its standard error is at most 0.5 / sqrt(trials).
    wanted : float
        Probability of certifying that is aimed at.
    advised_s : tuple of float or None
        For each of `LEVELS` the shortest duration tried that reaches `wanted`; None if none does.
    chances : tuple of Chance
        By duration, then by level.

    """

    least_s: float
    slowest_error_s: float
    sigma_ref_deg: float
    trials: int
    wanted: float
    advised_s: tuple[float | None, ...]
    chances: tuple[Chance, ...]


def plan_trial(settings: Settings, rng: np.random.Generator, *, rate_hz: float = 1.0,
               slow_share: float = 1.0, wanted: float = 0.8, trials: int = 100,
               times: Sequence[float] = _TIMES,
               progress: Callable[[str], None] = lambda text: None) -> TrialPlan:
    """
    Return the probabilities of the outcomes for runs of several lengths.

    Parameters
    ----------
    settings : Settings
        Must hold the norms and the slowest error, by `risk.slowest_error_s` or
        `risk.sensor_class`.
    rng : Generator
        Source of the random numbers.
    rate_hz : float
        Pairs per second.
    slow_share : float
        Share of the TS variance that belongs to the slowest error, from 0 to 1.
    wanted : float
        Probability of certifying that is aimed at. No longer runs are tried once all of `LEVELS`
        reach it.
    trials : int
        Simulated records for each probability.
    times : sequence of float
        Durations to try, in least durations, rising.
    progress : callable
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
    Only the variance decides, in one run without looks. The RS is at the upper bound of what is
    known of it, where certifying is hardest.

    """
    limits = Limits.of(settings.norms, settings.model)
    slowest = slowest_error_s(settings.risk)
    if not slowest:
        raise SettingsError('risk.slowest_error_s is missing: how long to measure follows from '
                            'the slowest error; state it, or risk.sensor_class')
    if not 0.0 < rate_hz < math.inf:
        raise ValueError(f'rate_hz = {rate_hz!r}: must be greater than 0')
    for name, share in (('slow_share', slow_share), ('wanted', wanted)):
        if not 0.0 <= share <= 1.0:
            raise ValueError(f'{name} = {share!r}: must be from 0 to 1')
    sigma_ref_deg = limits.m_up * limits.sigma_ref_max_deg
    least_s = least_duration_s(settings.risk)
    chances: list[Chance] = []
    advised: list[float | None] = [None] * len(LEVELS)
    for done, factor in enumerate(times):
        duration_s = factor * least_s
        progress(f'{done} of {len(times)} durations')
        for place, level in enumerate(LEVELS):
            found = dict.fromkeys(Outcome, 0)
            for _ in range(trials):
                x_deg, _ = simulate_differences(
                    rng, duration_s, rate_hz, sigma_ref_deg, slowest,
                    level * limits.sigma_max_deg, slow_share)
                spread = estimate_spread(Cells.of(x_deg))
                outcome = (Outcome.INDETERMINATE if spread is None else decide_variance(
                    spread, duration_s, limits, settings.risk)[0])
                found[outcome] += 1
            chances.append(Chance(level, duration_s, *(
                found[outcome] / trials for outcome in (
                    Outcome.COMPLIANT, Outcome.NON_COMPLIANT, Outcome.INDETERMINATE))))
            if advised[place] is None and chances[-1].compliant >= wanted:
                advised[place] = duration_s
        if None not in advised:
            break
    return TrialPlan(least_s, slowest, sigma_ref_deg, trials, wanted, tuple(advised),
                     tuple(chances))


def simulate_differences(rng: np.random.Generator, duration_s: float, rate_hz: float,
                         sigma_ref_deg: float, slowest_s: float, sigma_deg: float,
                         slow_share: float) -> tuple[Reals, float]:
    """
    Return the differences of a simulated run and their step.

    Parameters
    ----------
    rng : Generator
        Source of the noise.
    duration_s, rate_hz : float
        Length of the run, seconds, and pairs per second.
    sigma_ref_deg, sigma_deg : float
        Standard deviations of RS and TS, degrees.
    slowest_s : float
        Time in which the correlation of the slow error falls to 1/e, seconds.
    slow_share : float
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
