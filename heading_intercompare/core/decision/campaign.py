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

"""The verdict on several runs: every run must comply, or all of them together."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Sequence

from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.outcome import Outcome, worst
from heading_intercompare.core.settings import Risk
from heading_intercompare.core.statistics.confidence_bounds import rate_lower
from heading_intercompare.core.statistics.variance_uncertainty import (
    between_runs,
    LEAST_TIMES,
    lower_bound,
    pool,
    scatter_of_runs,
    upper_bound,
)

from .coverage import least_apart_s, least_duration_s, least_together_s
from .criteria import Limits
from .guarded import bounded_deg2, count_risk, Evidence, variance_risk

LEAST_RUNS = 5
"""Fewest runs whose means can bound errors slower than a run."""

LEAST_TIMES_OF_MEANS = 10.0
"""Least length of such runs in slowest errors; in shorter ones heavy tails need half the risk."""

CAMPAIGN_REASONS = {
    'no_run': 'there is no run',
    'every_run_compliant': 'every run complies',
    'a_run_non_compliant': "a run is rejected at its share of the producer's risk",
    'no_run_rejected_at_its_share':
        "a run is rejected on its own, but not at its share of the producer's risk",
    'a_test_not_met': 'a test of the norm is not met',
    'an_input_not_judged': 'not every input could be judged',
    'a_run_void': 'a run is void, so it says nothing about the sensor',
    'a_run_indeterminate': 'not every run complies, and none is rejected',
    'a_run_repeated': 'runs hold the same readings, which show the sensor only once',
    'insufficient_data': 'no run has 128 differences',
    'lower_bound_above_rejection_limit':
        'the common variance of the runs is above the rejection limit, at the stated risk',
    'count_lower_bound_above_allowed': 'too many extreme differences, at the stated risk',
    'insufficient_duration': 'the runs together are shorter than a run must be to comply',
    'upper_bound_within_acceptance_limit':
        'the common variance of the runs is within the acceptance limit, at the stated risk',
    'total_error_not_within_norm': 'the total error of a run is not shown to be within its norm',
    'slow_errors_not_resolved':
        'the errors have a slow part that these runs cannot measure',
    'reference_limited': 'only better knowledge of sigma_ref can decide, not more data',
    'data_limited': 'the bounds of the common variance are too wide',
}
"""Reasons for the outcome of a campaign: code and words."""


@dataclass(frozen=True, slots=True)
class Together:
    """The common variance of the differences of all runs; keys of the JSON."""

    runs: int = figure('runs with 128 differences or more')
    n: int = figure('their differences')
    span_s: float = figure('their total duration')
    apart_s: float = figure('shortest time between two of them', 'null for one run')
    d_hat_deg2: float = figure('mean variance, weighted', 'by the number of differences, S.12')
    nu: float = figure('effective degrees of freedom of the variance', 'S.12')
    f: float = figure('degrees of freedom of the slow part', 'S.12')
    slow_allowance_deg2: float = figure('allowance for a visible slow part')
    pooled_upper_bound_deg2: float = figure('upper bound from within the runs', 'S.12, S.18')
    between_upper_bound_deg2: float | None = figure(
        'upper bound from the means of the runs', 'S.13; null in variants A and C, for fewer than '
        'five runs, and for runs too close to each other')
    upper_bound_deg2: float = figure('upper bound U in force', 'of the rule `sensor`: the larger '
                                     'of those from means and scatter')
    lower_bound_deg2: float = figure('lower bound L')
    acceptance_limit_deg2: float = figure('acceptance limit A')
    rejection_limit_deg2: float = figure('rejection limit R')
    rate_plus_lower: float = figure('lower bound of the rate beyond the limit', 'S.14')
    scatter_upper_bound_deg2: float | None = figure('upper bound from the scatter of the runs',
                                                    'S.19', absent='where that from the means is '
                                                    'null')
    stated_times: float | None = figure(
        'shortest run in slowest errors stated, if U rests on them', 'S.18', absent='otherwise')


def judge_together(runs: Sequence[Evidence], limits: Sequence[Limits], risk: Risk, variant: str,
                   apart_s: float = math.inf) -> Together | None:
    """
    Bound the common variance of the runs.

    Parameters
    ----------
    runs
        What each run shows.
    limits
        Limits of each run; acceptance limits differ if interpolation reduced the noise
        differently.
    risk
        Not shared among runs: they are judged once, together.
    variant : {'A', 'B', 'C'}
        Variant of GK Table I. Only in B is the mean a constant, estimated by the means of runs.
    apart_s
        Shortest time between two runs, seconds. The means of runs count only if this exceeds the
        slowest error stated, or 600 s if none is stated; otherwise they are not independent.

    Returns
    -------
    Together or None
        None if no run has 128 differences.

    Notes
    -----
    The means of runs shorter than ten times the slowest error stated have half the risk.

    References
    ----------
    S.12, S.13, S.18, S.19 of ``docs/risk.md``.

    """
    with_spread = [(e, lim) for e, lim in zip(runs, limits) if e.spread is not None]
    if not with_spread:
        return None
    spreads = [e.spread for e in runs if e.spread is not None]
    means_deg = [e.mean_deg for e, _ in with_spread if e.mean_deg is not None]
    are_many, alpha = len(with_spread) >= LEAST_RUNS, risk.alpha_consumer
    pooled = pool(spreads, by_statement=variant != 'B' and are_many and all(
        spread.times is not None and spread.times >= LEAST_TIMES for spread in spreads))
    upper = pooled_upper = bounded_deg2(upper_bound(pooled, alpha), pooled)
    between = scatter = None
    if variant == 'B' and are_many and apart_s > least_apart_s(risk):
        if any(s.times is not None and s.times < LEAST_TIMES_OF_MEANS for s in spreads):
            alpha *= 0.5
        between = bounded_deg2(between_runs(spreads, means_deg, alpha), pooled)
        scatter = bounded_deg2(scatter_of_runs(spreads, means_deg, alpha), pooled)
        upper = max(between, scatter)
    n_plus = sum(e.n_plus for e, _ in with_spread)
    return Together(
        runs=len(with_spread), n=pooled.n, span_s=math.fsum(e.span_s for e, _ in with_spread),
        apart_s=apart_s, d_hat_deg2=pooled.d_deg2, nu=pooled.nu, f=pooled.f,
        slow_allowance_deg2=pooled.slow_allowance_deg2, pooled_upper_bound_deg2=pooled_upper,
        between_upper_bound_deg2=between, upper_bound_deg2=upper,
        lower_bound_deg2=lower_bound(pooled, variance_risk(risk)),
        acceptance_limit_deg2=math.fsum(e.n * lim.tightened_limit_deg2
                                        for e, lim in with_spread) / pooled.n,
        rejection_limit_deg2=with_spread[0][1].rejection_limit_deg2,
        rate_plus_lower=rate_lower(pooled.nu * n_plus / pooled.n, pooled.nu, count_risk(risk)),
        scatter_upper_bound_deg2=scatter,
        stated_times=None if pooled.stated is None else pooled.times)


def conclude_every_run(alone: Sequence[Outcome],
                       among: Sequence[Outcome]) -> tuple[Outcome, str]:
    """
    Return the outcome of a campaign in which every run must comply, and its reason.

    Parameters
    ----------
    alone, among
        Outcome of each run on its own, and with the producer's risk shared among the runs.

    References
    ----------
    Intersection-union test, Berger 1982; GK, several runs: the worst one decides.

    """
    outcome = worst(among)
    if not among:
        return outcome, 'no_run'
    if outcome is Outcome.COMPLIANT:
        return outcome, 'every_run_compliant'
    if outcome is Outcome.NON_COMPLIANT:
        return outcome, 'a_run_non_compliant'
    if Outcome.NON_COMPLIANT in alone:
        return outcome, 'no_run_rejected_at_its_share'
    return outcome, 'a_run_indeterminate'


def conclude_sensor(together: Together | None, limits: Sequence[Limits], totals_met: bool,
                    risk: Risk) -> tuple[Outcome, str]:
    """
    Return the outcome of a campaign that judges the sensor by all runs, and its reason.

    Parameters
    ----------
    together
        Of `judge_together`; None if the runs cannot be judged together.
    limits
        Limits of the runs.
    totals_met
        Whether the total error of every run is within its norm, or has no norm.
    risk
        With the rule of campaigns.

    Notes
    -----
    No single run can reject; the bounds of all runs together can, at the full risk.

    """
    if not limits:
        return Outcome.INDETERMINATE, 'no_run'
    if together is None:
        return Outcome.INDETERMINATE, 'insufficient_data'
    accept, reject = together.acceptance_limit_deg2, together.rejection_limit_deg2
    if together.lower_bound_deg2 > reject:
        return Outcome.NON_COMPLIANT, 'lower_bound_above_rejection_limit'
    if together.rate_plus_lower > float(limits[0].allowed(1)):
        return Outcome.NON_COMPLIANT, 'count_lower_bound_above_allowed'
    by_means = together.between_upper_bound_deg2 is not None
    if together.span_s < (least_together_s(risk) if by_means else least_duration_s(risk)):
        return Outcome.INDETERMINATE, 'insufficient_duration'
    if together.upper_bound_deg2 <= accept:
        if totals_met:
            return Outcome.COMPLIANT, 'upper_bound_within_acceptance_limit'
        return Outcome.INDETERMINATE, 'total_error_not_within_norm'
    if not by_means and (together.upper_bound_deg2 - together.slow_allowance_deg2 <= accept
                         or together.d_hat_deg2 <= accept
                         < together.d_hat_deg2 + together.slow_allowance_deg2):
        return Outcome.INDETERMINATE, 'slow_errors_not_resolved'
    if together.lower_bound_deg2 > accept and together.upper_bound_deg2 <= reject:
        return Outcome.INDETERMINATE, 'reference_limited'
    return Outcome.INDETERMINATE, 'data_limited'
