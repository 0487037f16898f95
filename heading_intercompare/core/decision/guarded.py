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

from dataclasses import dataclass, field
import math

import scipy

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

__all__ = ['bounded_deg2', 'count_risk', 'decide', 'decide_variance', 'Evidence',
           'gather_evidence', 'Guarded', 'REASONS', 'variance_risk']

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
    n : int
        Number of differences.
    spread : Spread or None
        Their variance, and how well it is known; None for fewer than 128.
    mean_deg : float or None
        Mean difference, degrees; None for n = 0.
    offset_u_deg : float
        Standard uncertainty of the installation offset, degrees.
    span_s : float
        Time from the first to the last difference, seconds.
    n_plus, n_plus_plus : int
        Number of deviations above the limits of GK (*) and (**).
    drift_left_deg2 : float
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

    Attributes
    ----------
    d_hat_deg2 : float or None
        Variance D, with the part that the removed mean absorbed added back. S.2.
    nu, f : float or None
        Effective degrees of freedom of the variance, and of its slow part. S.4, S.6.
    corner_j : float or None
        Frequency at which the power of the squares falls off, in half-periods per record. S.5.
    r_slow, slow_variance_deg2, slow_allowance_deg2 : float or None
        Excess power of the lowest half-periods, the variance in it, and the allowance of the
        upper bound for it. S.8, S.9.
    stated_times : float or None
        Length of the run in slowest errors stated, if the upper bound rests on the statement
        (S.17); otherwise None.
    upper_bound_deg2, lower_bound_deg2 : float or None
        Bounds U at the consumer's and L at the producer's risk. S.10, S.17; S.11.
    acceptance_limit_deg2, rejection_limit_deg2 : float
        The limits A and R that they are compared with.
    sigma_ts_lower_deg, sigma_ts_upper_deg : float or None
        Bounds of the TS standard deviation, with the RS at its upper and at its lower value. The
        upper one allows for the reduction by interpolating the TS.
    confidence_compliant, confidence_non_compliant : float or None
        Confidence that the variance is at most A; that it is above R.
    conformance_probability : float or None
        Probability that the TS meets its norm, with the RS uniform between its bounds. E.10.
    duration_factor, hours_needed : float or None
        Factor by which the run must grow to decide, other things being equal, and the length that
        gives.
    m_low_needed : float or None
        Least `norms.m_low` with which a run that is long enough would comply as it is; None if
        none would, or if it complies.
    bias_u_deg, bias_interval_deg, bias_significant : float, pair of float, bool or None
        Standard uncertainty of the mean, its 95 % interval, and whether that excludes 0.
    rate_plus, rate_plus_plus : float or None
        Rates of extreme deviations; None for n = 0.
    rate_plus_lower, rate_plus_plus_upper : float or None
        Their bounds. S.14.
    count_outcome, outcome : Outcome
        Outcome of the counts, and of the variance.
    reason : str
        A key of `REASONS`.

    """

    d_hat_deg2: float | None = None
    nu: float | None = None
    f: float | None = None
    corner_j: float | None = None
    r_slow: float | None = None
    slow_variance_deg2: float | None = None
    slow_allowance_deg2: float | None = None
    stated_times: float | None = field(default=None, metadata={'left_out': True})
    upper_bound_deg2: float | None = None
    lower_bound_deg2: float | None = None
    acceptance_limit_deg2: float
    rejection_limit_deg2: float
    sigma_ts_lower_deg: float | None = None
    sigma_ts_upper_deg: float | None = None
    confidence_compliant: float | None = None
    confidence_non_compliant: float | None = None
    conformance_probability: float | None = None
    duration_factor: float | None = None
    hours_needed: float | None = None
    m_low_needed: float | None = field(default=None, metadata={'left_out': True})
    bias_u_deg: float | None = None
    bias_interval_deg: tuple[float, float] | None = None
    bias_significant: bool | None = None
    rate_plus: float | None = None
    rate_plus_plus: float | None = None
    rate_plus_lower: float | None = None
    rate_plus_plus_upper: float | None = None
    count_outcome: Outcome
    outcome: Outcome
    reason: str


def gather_evidence(cells: Cells, *, n_plus: int, n_plus_plus: int, span_s: float,
                    mean_deg: float | None, offset_u_deg: float = 0.0, order: int = 0,
                    drift_left_deg2: float = 0.0, slowest_s: float | None = None) -> Evidence:
    """
    Gather the figures of a run that the decision uses.

    Parameters
    ----------
    cells : Cells
        Cells of the differences, or of their residuals about a polynomial.
    n_plus, n_plus_plus : int
        Number of deviations above the limits of GK (*) and (**).
    span_s : float
        Time from the first to the last difference, seconds.
    mean_deg : float or None
        Mean difference, degrees; None for n = 0.
    offset_u_deg : float
        Standard uncertainty of the installation offset, degrees.
    order : int
        Order of the polynomial to allow for; see `estimate_spread`.
    drift_left_deg2 : float
        Upper 95 % bound of the variance of the drift not removed, square degrees.
    slowest_s : float or None
        Slowest error stated, seconds; None if none is stated.

    """
    spread = estimate_spread(cells, order, span_s / slowest_s if slowest_s else None)
    return Evidence(cells.n, spread, mean_deg, offset_u_deg, span_s, n_plus, n_plus_plus,
                    drift_left_deg2)


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
    evidence : Evidence
        Evidence of one run, or of several together.
    limits : Limits
        Acceptance limit `tightened_limit_deg2` and rejection limit `rejection_limit_deg2`.
    risk : Risk
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
    spread : Spread
        The variance with its uncertainty.
    span_s : float
        Time from the first to the last difference, seconds.
    limits : Limits
        Limits of acceptance and rejection.
    risk : Risk
        Risks, and the least number of independent samples.
    drift_left_deg2 : float
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
