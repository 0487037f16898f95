# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""One-sided confidence bounds of a variance and of a rate, and what more data would give."""

from __future__ import annotations

import math
from typing import Callable

import numpy as np
from scipy.optimize import brentq
from scipy.special import betaincinv, gammainccinv, gammaincinv, ndtri, stdtrit

from .dyadic import Components

__all__ = ['confidence', 'LEAST_RISK', 'lower_bound', 'mean_confidence', 'nu_needed',
           'rate_lower', 'rate_upper', 'upper_bound']

LEAST_RISK = 1e-6
"""Confidences are given from this to one minus this."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(20)


def upper_bound(components: Components, nu: float, alpha: float) -> float:
    """
    Return the upper confidence bound of the variance.

    Parameters
    ----------
    components : Components
        Of the differences of one run.
    nu : float
        Effective degrees of freedom, greater than 0.
    alpha : float
        Risk that the variance exceeds the bound; up to 0.5.

    Returns
    -------
    float
        Square degrees; infinite if the data bound nothing, 0 if all residuals are 0.

    Notes
    -----
    The larger of two bounds: of a sum of independent components, and of one variance with `nu`
    degrees of freedom, which are themselves estimated and hence take the Student quantile.

    References
    ----------
    Graybill & Wang 1980, Wilson & Hilferty 1931; G.8 to G.10 of ``docs/risk.md``.

    """
    d_hat = components.d_hat_deg2
    f = components.dof
    excess = (f / (2.0 * gammaincinv(0.5 * f, alpha)) - 1.0) * components.variances_deg2
    by_components = d_hat + math.sqrt(float(np.sum(excess * excess)))
    h = 2.0 / (9.0 * nu)
    root = 1.0 - h + float(stdtrit(components.slow_dof, alpha)) * math.sqrt(h)
    if d_hat > 0.0 and root <= 0.0:
        return math.inf
    return max(by_components, d_hat / root ** 3 if d_hat > 0.0 else 0.0)


def lower_bound(components: Components, nu: float, alpha: float) -> float:
    """
    Return the lower confidence bound of the variance.

    Parameters
    ----------
    components, nu
        As for `upper_bound`.
    alpha : float
        Risk that the variance is below the bound; up to 0.5.

    Returns
    -------
    float
        Square degrees, at least 0.

    References
    ----------
    Graybill & Wang 1980, Wilson & Hilferty 1931; G.8 to G.10 of ``docs/risk.md``.

    """
    d_hat = components.d_hat_deg2
    f = components.dof
    excess = (1.0 - f / (2.0 * gammainccinv(0.5 * f, alpha))) * components.variances_deg2
    by_components = d_hat - math.sqrt(float(np.sum(excess * excess)))
    h = 2.0 / (9.0 * nu)
    root = 1.0 - h - float(stdtrit(components.slow_dof, alpha)) * math.sqrt(h)
    by_nu = d_hat / root ** 3 if root > 0.0 else 0.0
    return max(0.0, min(by_components, by_nu))


def confidence(components: Components, nu: float, limit_deg2: float) -> float:
    """
    Return the confidence that the variance is at most a limit.

    Parameters
    ----------
    components, nu
        As for `upper_bound`.
    limit_deg2 : float
        The limit, square degrees, greater than 0.

    Returns
    -------
    float
        1 - alpha if the upper bound at alpha is the limit, alpha if the lower bound at alpha
        is, 0.5 between the two bounds at 0.5; from 1e-6 to 1 - 1e-6.

    """
    def upper(alpha: float) -> float:
        return limit_deg2 / upper_bound(components, nu, alpha) - 1.0

    def lower(alpha: float) -> float:
        return lower_bound(components, nu, alpha) / limit_deg2 - 1.0

    if components.d_hat_deg2 == 0.0:
        return 1.0 - LEAST_RISK
    if upper(0.5) >= 0.0:
        return 1.0 - _risk_where_zero(upper)
    if lower(0.5) >= 0.0:
        return _risk_where_zero(lower)
    return 0.5


def _risk_where_zero(f: Callable[[float], float]) -> float:
    """Return the risk at which a function that rises to f(0.5) >= 0 is zero."""
    low = math.log(LEAST_RISK)
    if f(LEAST_RISK) >= 0.0:
        return LEAST_RISK
    return math.exp(brentq(lambda t: f(math.exp(t)), low, math.log(0.5), xtol=1e-13))


def mean_confidence(components: Components, nu: float, sigma_deg: float, low_deg: float,
                    up_deg: float) -> float:
    """
    Return the confidence that the TS meets its norm when the RS is known within an interval.

    Parameters
    ----------
    components, nu
        As for `upper_bound`.
    sigma_deg : float
        Norm of the TS, degrees.
    low_deg, up_deg : float
        Interval of the RS standard deviation, taken as uniform in it; degrees.

    Returns
    -------
    float
        Mean of `confidence` over the interval, by 20 Gauss-Legendre points.

    References
    ----------
    JCGM 106:2012, conformance probability; E.10 of ``docs/risk.md``.

    """
    middle, half = 0.5 * (up_deg + low_deg), 0.5 * (up_deg - low_deg)
    if half == 0.0:
        return confidence(components, nu, sigma_deg ** 2 + middle ** 2)
    values = [confidence(components, nu, sigma_deg ** 2 + (middle + half * t) ** 2)
              for t in _NODES]
    return 0.5 * float(np.dot(_WEIGHTS, values))


def nu_needed(d_hat_deg2: float, accept_deg2: float, reject_deg2: float,
              alpha_consumer: float, alpha_producer: float) -> float:
    """
    Return how many effective degrees of freedom would decide if the variance stays as it is.

    Parameters
    ----------
    d_hat_deg2 : float
        Estimated variance, square degrees.
    accept_deg2, reject_deg2 : float
        Acceptance and rejection limit, square degrees.
    alpha_consumer, alpha_producer : float
        Risks, up to 0.5.

    Returns
    -------
    float
        Infinite from limit to limit, where no amount of data decides; 0 if any amount would.

    References
    ----------
    Wilson & Hilferty 1931 solved for the degrees of freedom; G.12 of ``docs/risk.md``.

    """
    if d_hat_deg2 < accept_deg2:
        z = -float(ndtri(alpha_consumer))
        gap = 1.0 - (d_hat_deg2 / accept_deg2) ** (1.0 / 3.0)
        # 2 gap / (z + ...) is (-z + ...) / 2 without cancellation.
        root_h = 2.0 * gap / (z + math.sqrt(z * z + 4.0 * gap))
    elif d_hat_deg2 > reject_deg2:
        z = -float(ndtri(alpha_producer))
        gap = (d_hat_deg2 / reject_deg2) ** (1.0 / 3.0) - 1.0
        if z * z < 4.0 * gap:
            return 0.0
        root_h = 2.0 * gap / (z + math.sqrt(z * z - 4.0 * gap)) if gap > 0.0 else 0.0
    else:
        return math.inf
    return 2.0 / (9.0 * root_h * root_h) if root_h * root_h > 0.0 else math.inf


def rate_lower(k: float, trials: float, alpha: float) -> float:
    """
    Return the lower confidence bound of a rate.

    Parameters
    ----------
    k, trials : float
        Events among effective trials, 0 <= k <= trials; need not be integers.
    alpha : float
        Risk that the rate is below the bound.

    References
    ----------
    Clopper & Pearson 1934 with real arguments; G.14 of ``docs/risk.md``.

    """
    return float(betaincinv(k, trials - k + 1.0, alpha)) if k > 0.0 else 0.0


def rate_upper(k: float, trials: float, alpha: float) -> float:
    """Return the upper confidence bound of a rate, G.14; see `rate_lower`."""
    return float(betaincinv(k + 1.0, trials - k, 1.0 - alpha)) if k < trials else 1.0
