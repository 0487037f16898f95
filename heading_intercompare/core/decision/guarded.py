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

"""The decision with a stated risk: compares confidence bounds, not estimates, with limits."""

from __future__ import annotations

from dataclasses import dataclass
import math

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.settings import Risk
from heading_intercompare.core.statistics.cells import Cells
from heading_intercompare.core.statistics.confidence_bounds import (
    confidence,
    duration_factor,
    mean_confidence,
    rate_lower,
    rate_upper,
)
from heading_intercompare.core.statistics.variance_uncertainty import (
    estimate_spread,
    lower_bound,
    MEAN_DOF,
    Spread,
    upper_bound,
)

from .coverage import least_duration_s
from .criteria import Limits

_MOST_DEG = 180.0
"""The largest difference of two headings, degrees."""

REASONS = {
    'insufficient_data': 'fewer than 128 differences, or too unevenly spread in time',
    'lower_bound_above_rejection_limit':
        'the variance is above the rejection limit, at the stated risk',
    'insufficient_duration': 'shorter than a run must be to comply',
    'upper_bound_within_acceptance_limit':
        'the variance is within the acceptance limit, at the stated risk',
    'slow_errors_not_resolved':
        'the errors have a slow part that this record cannot measure',
    'drift_left_in':
        'the drift, which is not removed, may break the norm by itself',
    'reference_limited': 'only better knowledge of sigma_ref can decide, not more data',
    'data_limited': 'the bounds of the variance are too wide',
}
"""Reasons for the decision on the variance: code and words."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """
    The figures of one run that the decision uses.

    Attributes
    ----------
    n
        Number of differences.
    spread
        Their variance, and how well it is known; None for fewer than 128.
    mean_deg
        Mean difference, degrees; None for n = 0.
    offset_u_deg
        Standard uncertainty of the installation offset, degrees.
    span_s
        Time from the first to the last difference, seconds.
    n_plus, n_plus_plus
        Number of deviations above the limits of GK (*) and (**).
    drift_left_deg2
        Upper 95 % bound of the variance of the drift not removed, square degrees.

    """

    n: int
    spread: Spread | None
    mean_deg: float | None
    offset_u_deg: float
    span_s: float
    n_plus: int
    n_plus_plus: int
    drift_left_deg2: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Guarded:
    """
    The guarded decision on one run; the fields are the keys of the JSON, in its order.

    A missing figure is None (fewer than 128 differences); a figure without a bound is infinite.
    Angles are in degrees, variances in square degrees.
    """

    d_hat_deg2: float | None = figure(
        'variance, including the part that the removed mean absorbed', 'D, S.2', default=None)
    nu: float | None = figure('effective degrees of freedom of the variance', 'S.4, S.6',
                              default=None, row='effective size nu')
    f: float | None = figure('degrees of freedom of the slow part, f', 'S.4, S.6', default=None)
    corner_j: float | None = figure('corner of the spectrum of the squares, half-periods', 'S.5',
                                    default=None)
    r_slow: float | None = figure('ratio of the lowest half-periods to the middle ones',
                                  'of the power of the squares, S.8', default=None)
    slow_variance_deg2: float | None = figure('variance of the visible slow part', default=None)
    slow_allowance_deg2: float | None = figure('allowance for the slow part in U', default=None)
    stated_times: float | None = figure('length in slowest errors stated, if U rests on them',
                                        'S.17', absent='otherwise')
    upper_bound_deg2: float | None = figure(
        "upper bound U of the variance, at the consumer's risk", 'S.10, S.17', default=None)
    lower_bound_deg2: float | None = figure(
        "lower bound L of the variance, at the producer's risk", 'S.11', default=None)
    acceptance_limit_deg2: float = figure('acceptance limit A', row='  acceptance limit')
    rejection_limit_deg2: float = figure('rejection limit R', row='  rejection limit')
    sigma_ts_lower_deg: float | None = figure('TS standard deviation, bounds', default=None,
                                              up='sigma_ts_upper_deg', row='sigma of the TS')
    sigma_ts_upper_deg: float | None = figure('its upper bound', 'with the RS at its lower value; '
                                              'allows for interpolating the TS', default=None)
    confidence_compliant: float | None = figure('confidence that the variance is at most A',
                                                default=None)
    confidence_non_compliant: float | None = figure('confidence that the variance is above R',
                                                    default=None)
    conformance_probability: float | None = figure(
        'conformance probability', 'of the TS, with the RS uniform between its bounds',
        default=None)
    duration_factor: float | None = figure('length with which the run alone decides, times this '
                                           'one', 'null if no length does', default=None)
    hours_needed: float | None = figure('length with which the run alone decides', default=None,
                                        unit='h')
    m_low_needed: float | None = figure(
        'least `norms.m_low` with which the run would comply as it is', absent='if none would, if '
        'it complies, or if it is too short')
    bias_u_deg: float | None = figure('mean difference: standard uncertainty', default=None)
    bias_interval_deg: tuple[float, float] | None = figure('mean difference: 95 % interval',
                                                           default=None)
    bias_significant: bool | None = figure('mean difference significant', default=None)
    rate_plus: float | None = figure('rate beyond the limit, n+ / n', default=None)
    rate_plus_plus: float | None = figure('rate beyond the tightened limit, n++ / n', default=None)
    rate_plus_lower: float | None = figure('lower bound of the rate beyond the limit',
                                           default=None)
    rate_plus_plus_upper: float | None = figure(
        'upper bound of the rate beyond the tightened limit', default=None)
    count_outcome: Outcome = figure('outcome on the counts')
    outcome: Outcome = figure('outcome on the variance')
    reason: str = figure('why the outcome on the variance is as it is', 'see risk.md')


def gather_evidence(cells: Cells, *, n_plus: int, n_plus_plus: int, span_s: float,
                    mean_deg: float | None, offset_u_deg: float = 0.0, order: int = 0,
                    drift_left_deg2: float = 0.0, slowest_s: float | None = None) -> Evidence:
    """
    Gather the figures of a run that the decision uses.

    Parameters
    ----------
    cells
        Cells of the differences, or of their residuals about a polynomial.
    n_plus, n_plus_plus
        Number of deviations above the limits of GK (*) and (**).
    span_s
        Time from the first to the last difference, seconds.
    mean_deg
        Mean difference, degrees; None for n = 0.
    offset_u_deg
        Standard uncertainty of the installation offset, degrees.
    order
        Order of the polynomial to allow for; see `estimate_spread`.
    drift_left_deg2
        Upper 95 % bound of the variance of the drift not removed, square degrees.
    slowest_s
        Slowest error stated, seconds; None if none is stated.

    """
    spread = estimate_spread(cells, order, span_s / slowest_s if slowest_s else None)
    return Evidence(n=cells.n, spread=spread, mean_deg=mean_deg, offset_u_deg=offset_u_deg,
                    span_s=span_s, n_plus=n_plus, n_plus_plus=n_plus_plus,
                    drift_left_deg2=drift_left_deg2)


def bounded_deg2(bound_deg2: float, spread: Spread) -> float:
    """Return a bound of the variance; infinite beyond that of differences of 180 degrees."""
    most_deg2 = max(spread.above.d_deg2, _MOST_DEG ** 2)
    return bound_deg2 if bound_deg2 <= most_deg2 else math.inf


def variance_risk(risk: Risk) -> float:
    """Return the variance criterion's part of the producer's risk."""
    return risk.alpha_producer * (1.0 - risk.count_share)


def count_risk(risk: Risk) -> float:
    """Return the count criterion's part of the producer's risk."""
    return risk.alpha_producer * risk.count_share


def decide(evidence: Evidence, limits: Limits, risk: Risk) -> Guarded:
    """
    Decide on a run with stated risks.

    Parameters
    ----------
    evidence
        Evidence of one run, or of several together.
    limits
        Acceptance limit `tightened_limit_deg2` and rejection limit `rejection_limit_deg2`.
    risk
        For m runs divide `alpha_producer` by m, because any of them may reject.

    Returns
    -------
    Guarded

    Notes
    -----
    Variance and counts can both reject, so they share the producer's risk. Only the variance can
    certify, so it has all of the consumer's risk.

    References
    ----------
    S.10, S.11, S.14, S.17 and the table of ``docs/risk.md``; JCGM 106:2012, guarded acceptance and
    rejection.

    """
    spread = evidence.spread
    accept, reject = limits.tightened_limit_deg2, limits.rejection_limit_deg2
    if spread is None or evidence.mean_deg is None:
        return _refuse_to_decide(evidence, accept, reject)
    rates = evidence.n_plus / evidence.n, evidence.n_plus_plus / evidence.n
    producer = variance_risk(risk)
    upper = bounded_deg2(upper_bound(spread, risk.alpha_consumer), spread)
    lower = lower_bound(spread, producer)
    least_s = least_duration_s(risk)
    is_long = evidence.span_s >= least_s
    outcome, reason = decide_variance(spread, evidence.span_s, limits, risk,
                                      evidence.drift_left_deg2)
    low_deg, up_deg = (m * limits.sigma_ref_max_deg for m in (limits.m_low, limits.m_up))
    rate_low = rate_lower(spread.nu * rates[0], spread.nu, count_risk(risk))
    rate_up = rate_upper(spread.nu * rates[1], spread.nu, risk.alpha_consumer)
    factor = duration_factor(spread, accept, reject, risk.alpha_consumer, producer)
    if lower <= reject and evidence.span_s > 0.0:
        factor = max(factor, least_s / evidence.span_s)
    if reason == 'drift_left_in':
        # If everything stays as it is, a longer run drifts further.
        factor = math.inf
    bias_u_deg = math.sqrt(spread.mean_variance_deg2 + evidence.offset_u_deg ** 2)
    half_deg = min(_MOST_DEG, -float(scipy.special.stdtrit(MEAN_DOF, 0.025)) * bias_u_deg)
    low_bias_deg, up_bias_deg = evidence.mean_deg - half_deg, evidence.mean_deg + half_deg
    return Guarded(
        d_hat_deg2=spread.d_deg2, nu=spread.nu, f=spread.f, corner_j=spread.corner_j,
        r_slow=spread.r_slow, slow_variance_deg2=spread.slow_variance_deg2,
        slow_allowance_deg2=spread.slow_allowance_deg2,
        stated_times=None if spread.stated is None else spread.times,
        upper_bound_deg2=upper, lower_bound_deg2=lower,
        acceptance_limit_deg2=accept, rejection_limit_deg2=reject,
        sigma_ts_lower_deg=math.sqrt(max(0.0, lower - up_deg ** 2)),
        sigma_ts_upper_deg=math.sqrt(max(0.0, upper - low_deg ** 2)
                                     / limits.ts_variance_factor),
        confidence_compliant=confidence(spread, accept),
        confidence_non_compliant=1.0 - confidence(spread, reject),
        conformance_probability=mean_confidence(
            spread, math.sqrt(limits.ts_variance_factor) * limits.sigma_max_deg, low_deg, up_deg),
        duration_factor=factor, hours_needed=factor * evidence.span_s / 3600.0,
        m_low_needed=limits.m_low_for(upper) if is_long and lower <= reject else None,
        bias_u_deg=bias_u_deg, bias_interval_deg=(low_bias_deg, up_bias_deg),
        bias_significant=not low_bias_deg <= 0.0 <= up_bias_deg,
        rate_plus=rates[0], rate_plus_plus=rates[1],
        rate_plus_lower=rate_low, rate_plus_plus_upper=rate_up,
        count_outcome=_count_outcome(rate_low, rate_up, float(limits.allowed(1)), is_long),
        outcome=outcome, reason=reason)


def _refuse_to_decide(evidence: Evidence, accept_deg2: float, reject_deg2: float) -> Guarded:
    """Return the decision on too few differences: only the limits and the rates."""
    n = evidence.n
    return Guarded(
        acceptance_limit_deg2=accept_deg2, rejection_limit_deg2=reject_deg2,
        rate_plus=evidence.n_plus / n if n else None,
        rate_plus_plus=evidence.n_plus_plus / n if n else None,
        count_outcome=Outcome.INDETERMINATE, outcome=Outcome.INDETERMINATE,
        reason='insufficient_data')


def decide_variance(spread: Spread, span_s: float, limits: Limits, risk: Risk,
                    drift_left_deg2: float = 0.0) -> tuple[Outcome, str]:
    """
    Return the outcome of the variance and a key of `REASONS`.

    Parameters
    ----------
    spread
        The variance with its uncertainty.
    span_s
        Time from the first to the last difference, seconds.
    limits
        Limits of acceptance and rejection.
    risk
        Risks, and the least number of independent samples.
    drift_left_deg2
        Upper 95 % bound of the variance of the drift not removed, square degrees.

    Notes
    -----
    It applies the rows of the table of ``docs/risk.md`` in their order.

    """
    upper = upper_bound(spread, risk.alpha_consumer)
    lower = lower_bound(spread, variance_risk(risk))
    is_long = span_s >= least_duration_s(risk)
    accept, reject = limits.tightened_limit_deg2, limits.rejection_limit_deg2
    if lower > reject:
        return Outcome.NON_COMPLIANT, 'lower_bound_above_rejection_limit'
    if not is_long:
        return Outcome.INDETERMINATE, 'insufficient_duration'
    if upper <= accept:
        if spread.d_deg2 + drift_left_deg2 > accept:
            return Outcome.INDETERMINATE, 'drift_left_in'
        return Outcome.COMPLIANT, 'upper_bound_within_acceptance_limit'
    slow = spread.slow_allowance_deg2
    if upper - slow <= accept or spread.above.d_deg2 <= accept < spread.above.d_deg2 + slow:
        return Outcome.INDETERMINATE, 'slow_errors_not_resolved'
    if lower > accept and upper <= reject:
        return Outcome.INDETERMINATE, 'reference_limited'
    return Outcome.INDETERMINATE, 'data_limited'


def _count_outcome(low: float, up: float, allowed: float, is_long: bool) -> Outcome:
    if low > allowed:
        return Outcome.NON_COMPLIANT
    if up <= allowed and is_long:
        return Outcome.COMPLIANT
    return Outcome.INDETERMINATE
