# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The decision with a stated risk: confidence bounds, not estimates, against the limits."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import gammainccinv, stdtrit

from .bounds import (
    confidence,
    lower_bound,
    mean_confidence,
    nu_needed,
    rate_lower,
    rate_upper,
    upper_bound,
)
from .criteria import Limits
from .dyadic import Components, Dyadic
from .noise import correlation_times, CorrelationTimes
from .outcome import Outcome
from .settings import Risk

__all__ = ['decide', 'Evidence', 'evidence_of', 'Guarded', 'REASONS']

REASONS = {
    'insufficient_data': 'fewer than 64 differences',
    'unresolved_but_far_above_rejection_limit':
        'the errors change slowly, but lie far above the rejection limit',
    'insufficient_effective_data':
        'the errors change too slowly for this record: measure longer',
    'lower_bound_above_rejection_limit':
        'the variance is above the rejection limit, at the stated risk',
    'insufficient_duration': 'shorter than risk.min_duration_s',
    'upper_bound_within_acceptance_limit':
        'the variance is within the acceptance limit, at the stated risk',
    'reference_limited': 'only better knowledge of sigma_ref can decide, not more data',
    'data_limited': 'more data can decide',
}
"""Why the decision on the variance is what it is: code and words."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """
    All that the decision takes from the data of one run.

    Attributes
    ----------
    n : int
        Number of differences.
    components : Components or None
        Of their variance; None for fewer than 64.
    nu_acf : float or None
        Effective degrees of freedom by the autocorrelation; None if not used.
    mean_deg : float or None
        Mean difference, degrees; None for n = 0.
    offset_u_deg : float
        Standard uncertainty of the installation offset, degrees.
    span_s : float
        Time from the first to the last difference, seconds.
    n_plus, n_plus_plus : int
        How many deviations exceed the limits of GK (*) and (**).

    """

    n: int
    components: Components | None
    nu_acf: float | None
    mean_deg: float | None
    offset_u_deg: float
    span_s: float
    n_plus: int
    n_plus_plus: int


@dataclass(frozen=True, slots=True)
class Guarded:
    """
    The guarded decision on one run; the fields are the keys of the JSON, in its order.

    None where there is no figure (fewer than 64 differences); infinite where a figure has no
    bound. Angles in degrees, variances in square degrees. All confidences hold only if
    `resolved`.

    Attributes
    ----------
    d_hat_deg2 : float or None
        Variance with what the removed mean has swallowed. G.3.
    nu, nu_batch, nu_acf, nu_components : float or None
        Effective degrees of freedom: those used, and the estimates. G.4, G.6, G.7.
    resolved : bool or None
        Whether the record is long enough to see the slow part of the errors. G.5.
    r1_blocks, slow_share : float or None
        What `resolved` follows from.
    upper_bound_deg2, lower_bound_deg2 : float or None
        Bounds U at the consumer's and L at the producer's risk. G.10.
    acceptance_limit_deg2, rejection_limit_deg2 : float
        The limits A and R that they are compared with.
    sigma_ts_lower_deg, sigma_ts_upper_deg : float or None
        Bounds of the TS standard deviation, the RS at its upper and at its lower value.
    confidence_compliant, confidence_non_compliant : float or None
        That the variance is at most A; that it is above R.
    conformance_probability : float or None
        That the TS meets its norm, the RS uniform between its bounds. E.10.
    nu_needed, duration_factor : float or None
        Degrees of freedom that would decide if the variance stays; how many times longer the
        run would have to be. G.12.
    bias_u_deg, bias_interval_deg, bias_significant : float, pair of float, bool or None
        Standard uncertainty of the mean, its 95 % interval, whether that excludes 0.
    rate_plus, rate_plus_plus : float or None
        Rates of extreme deviations; None for n = 0.
    rate_plus_lower, rate_plus_plus_upper : float or None
        Their bounds. G.14.
    count_outcome, outcome : Outcome
        On the counts; on the variance.
    reason : str
        A key of `REASONS`.

    """

    d_hat_deg2: float | None
    nu: float | None
    nu_batch: float | None
    nu_acf: float | None
    nu_components: float | None
    resolved: bool | None
    r1_blocks: float | None
    slow_share: float | None
    upper_bound_deg2: float | None
    lower_bound_deg2: float | None
    acceptance_limit_deg2: float
    rejection_limit_deg2: float
    sigma_ts_lower_deg: float | None
    sigma_ts_upper_deg: float | None
    confidence_compliant: float | None
    confidence_non_compliant: float | None
    conformance_probability: float | None
    nu_needed: float | None
    duration_factor: float | None
    bias_u_deg: float | None
    bias_interval_deg: tuple[float, float] | None
    bias_significant: bool | None
    rate_plus: float | None
    rate_plus_plus: float | None
    rate_plus_lower: float | None
    rate_plus_plus_upper: float | None
    count_outcome: Outcome
    outcome: Outcome
    reason: str


def evidence_of(x: ArrayLike | Dyadic, *, n_plus: int, n_plus_plus: int, span_s: float,
                method: str = 'dyadic+acf', offset_u_deg: float = 0.0, order: int = 0,
                mean_deg: float | None = None,
                times: CorrelationTimes | None = None) -> Evidence:
    """
    Return what a run says.

    Parameters
    ----------
    x : array_like, shape (n,), or Dyadic
        Differences in sample order, finite, degrees; or their residuals about a polynomial; or,
        for the method 'dyadic', summaries of them.
    n_plus, n_plus_plus : int
        How many deviations exceed the limits of GK (*) and (**).
    span_s : float
        Time from the first to the last difference, seconds.
    method : {'dyadic+acf', 'dyadic'}
        Whether the autocorrelation is used too, which takes all samples at once.
    offset_u_deg : float
        Standard uncertainty of the installation offset, degrees.
    order : int
        Order of the polynomial whose residuals `x` are; 0 for none.
    mean_deg : float, optional
        Mean difference; default that of `x`. Needed where `x` are residuals.
    times : CorrelationTimes, optional
        `correlation_times` of `x`, if known already.

    Raises
    ------
    ValueError
        If the autocorrelation is asked of summaries.

    """
    if isinstance(x, Dyadic):
        if method != 'dyadic':
            raise ValueError(f"method = {method!r}: summaries allow 'dyadic' only")
        blocks = x
    else:
        x = np.asarray(x, dtype=np.float64).reshape(-1)
        blocks = Dyadic.of(x)
    components = blocks.components(order)
    nu_acf = None
    if components and method == 'dyadic+acf':
        nu_acf = (times or correlation_times(x)).effective_size
    return Evidence(blocks.n, components, nu_acf, blocks.mean if mean_deg is None else mean_deg,
                    offset_u_deg, span_s, n_plus, n_plus_plus)


def decide(evidence: Evidence, limits: Limits, risk: Risk) -> Guarded:
    """
    Decide on a run with stated risks.

    Parameters
    ----------
    evidence : Evidence
        Of one run.
    limits : Limits
        Acceptance limit `tightened_limit_deg2` and rejection limit `rejection_limit_deg2`.
    risk : Risk
        Risks and gates. Among m runs divide `alpha_producer` by m: any of them may reject.

    Returns
    -------
    Guarded

    Notes
    -----
    While the slow part of the errors is not resolved or `nu` is below `risk.nu_min`, neither
    variance nor counts accept, and only the variance may reject, if it is far above its limit.

    References
    ----------
    G.5, G.7, G.11 and the table of ``docs/risk.md``; JCGM 106:2012, guarded acceptance and
    rejection.

    """
    c = evidence.components
    accept, reject = limits.tightened_limit_deg2, limits.rejection_limit_deg2
    rates = _rates(evidence)
    if c is None:
        unknown = Outcome.INDETERMINATE
        return Guarded(*(None,) * 10, accept, reject, *(None,) * 10, *rates, None, None,
                       unknown, unknown, 'insufficient_data')
    nu = min(c.nu_batch, math.inf if evidence.nu_acf is None else evidence.nu_acf,
             float(c.n - 1 - c.order))
    resolved = not (c.r1_blocks > risk.r1_max and c.slow_share > risk.share_max)
    is_open = resolved and nu >= risk.nu_min
    upper = upper_bound(c, nu, risk.alpha_consumer)
    lower = lower_bound(c, nu, risk.alpha_producer)
    outcome, reason = _variance_outcome(c, lower, upper, accept, reject, is_open,
                                        evidence.span_s, risk)
    trials = min(nu, c.nu_components)
    needed = nu_needed(c.d_hat_deg2, accept, reject, risk.alpha_consumer, risk.alpha_producer)
    low_deg, up_deg = (m * limits.sigma_ref_max_deg for m in (limits.m_low, limits.m_up))
    rate_low = rate_lower(trials * rates[0], trials, risk.alpha_producer)
    rate_up = rate_upper(trials * rates[1], trials, risk.alpha_consumer)
    return Guarded(
        d_hat_deg2=c.d_hat_deg2, nu=nu, nu_batch=c.nu_batch, nu_acf=evidence.nu_acf,
        nu_components=c.nu_components, resolved=resolved, r1_blocks=c.r1_blocks,
        slow_share=c.slow_share, upper_bound_deg2=upper, lower_bound_deg2=lower,
        acceptance_limit_deg2=accept, rejection_limit_deg2=reject,
        sigma_ts_lower_deg=math.sqrt(max(0.0, lower - up_deg ** 2)),
        sigma_ts_upper_deg=math.sqrt(max(0.0, upper - low_deg ** 2)),
        confidence_compliant=confidence(c, nu, accept),
        confidence_non_compliant=1.0 - confidence(c, nu, reject),
        conformance_probability=mean_confidence(c, nu, limits.sigma_max_deg, low_deg, up_deg),
        nu_needed=needed, duration_factor=needed / trials,
        **_bias(evidence, c),
        rate_plus=rates[0], rate_plus_plus=rates[1],
        rate_plus_lower=rate_low, rate_plus_plus_upper=rate_up,
        count_outcome=_count_outcome(rate_low, rate_up, float(limits.allowed(1)), is_open,
                                     evidence.span_s >= risk.min_duration_s),
        outcome=outcome, reason=reason)


def _rates(evidence: Evidence) -> tuple[float | None, float | None]:
    if not evidence.n:
        return None, None
    return evidence.n_plus / evidence.n, evidence.n_plus_plus / evidence.n


def _variance_outcome(c: Components, lower: float, upper: float, accept: float, reject: float,
                      is_open: bool, span_s: float, risk: Risk) -> tuple[Outcome, str]:
    """Apply the rows of the table of ``docs/risk.md`` in their order."""
    if not is_open:
        # chi-square of one degree of freedom: as if all variance were one slow component.
        least = c.d_hat_deg2 / (2.0 * float(gammainccinv(0.5, risk.alpha_producer)))
        if least > reject:
            return Outcome.NON_COMPLIANT, 'unresolved_but_far_above_rejection_limit'
        return Outcome.INDETERMINATE, 'insufficient_effective_data'
    if lower > reject:
        return Outcome.NON_COMPLIANT, 'lower_bound_above_rejection_limit'
    if span_s < risk.min_duration_s:
        return Outcome.INDETERMINATE, 'insufficient_duration'
    if upper <= accept:
        return Outcome.COMPLIANT, 'upper_bound_within_acceptance_limit'
    if lower > accept and upper <= reject:
        return Outcome.INDETERMINATE, 'reference_limited'
    return Outcome.INDETERMINATE, 'data_limited'


def _bias(evidence: Evidence, c: Components) -> dict[str, float | tuple[float, float] | bool]:
    u = math.sqrt(c.mean_variance_deg2 + evidence.offset_u_deg ** 2)
    half = -float(stdtrit(c.slow_dof, 0.025)) * u
    low, up = evidence.mean_deg - half, evidence.mean_deg + half
    return {'bias_u_deg': u, 'bias_interval_deg': (low, up),
            'bias_significant': not low <= 0.0 <= up}


def _count_outcome(low: float, up: float, allowed: float, is_open: bool,
                   is_long: bool) -> Outcome:
    if not is_open:
        return Outcome.INDETERMINATE
    if low > allowed:
        return Outcome.NON_COMPLIANT
    if up <= allowed and is_long:
        return Outcome.COMPLIANT
    return Outcome.INDETERMINATE
