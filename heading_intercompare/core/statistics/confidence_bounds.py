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

"""Confidence that a variance meets a limit, bounds of a rate, and the record length needed."""

from __future__ import annotations

import math
from typing import Callable

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.records import Reals

from .quadrature import gauss_legendre
from .root_finding import find_root
from .variance_uncertainty import excess, lower_bound, Spread, upper_bound

LEAST_RISK = 1e-6
"""Confidences are clipped to the range from this to one minus this."""

_LONGEST = 1e12
_TAIL = 0.025


def confidence(spread: Spread, limit_deg2: float) -> float:
    """
    Return the confidence that the variance is at most a limit.

    Parameters
    ----------
    spread
        Spread of one run, or of several together.
    limit_deg2
        The limit, square degrees, greater than 0.

    Returns
    -------
    float
        1 - alpha if the upper bound at alpha equals the limit; alpha if the lower bound at alpha
        does; 0.5 between the two bounds at 0.5. From 1e-6 to 1 - 1e-6.

    """
    def upper(alpha: float) -> float:
        return limit_deg2 / upper_bound(spread, alpha) - 1.0

    def lower(alpha: float) -> float:
        return lower_bound(spread, alpha) / limit_deg2 - 1.0

    if spread.d_deg2 == 0.0:
        return 1.0 - LEAST_RISK
    if upper(0.5) >= 0.0:
        return 1.0 - _risk_where_zero(upper)
    if lower(0.5) >= 0.0:
        return _risk_where_zero(lower)
    return 0.5


def _risk_where_zero(f: Callable[[float], float]) -> float:
    """Return the risk where a rising function with f(0.5) >= 0 crosses zero."""
    low = math.log(LEAST_RISK)
    if f(LEAST_RISK) >= 0.0:
        return LEAST_RISK
    return math.exp(find_root(lambda t: f(math.exp(t)), low, math.log(0.5), tolerance=1e-13))


def mean_confidence(spread: Spread, sigma_deg: float, low_deg: float,
                    up_deg: float) -> float:
    """
    Return the confidence that the TS meets its norm, with the RS known within an interval.

    Parameters
    ----------
    spread
        Spread of one run, or of several together.
    sigma_deg
        Norm of the TS, degrees.
    low_deg, up_deg
        Interval of the RS standard deviation, degrees; assumed uniform within it.

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
        return confidence(spread, sigma_deg ** 2 + middle ** 2)
    nodes, weights = gauss_legendre(20)
    values = [confidence(spread, sigma_deg ** 2 + (middle + half * t) ** 2) for t in nodes]
    return 0.5 * float(np.dot(weights, values))


def duration_factor(spread: Spread, accept_deg2: float, reject_deg2: float,
                    alpha_consumer: float, alpha_producer: float) -> float:
    """
    Return the factor by which the record must grow to decide, other things being equal.

    Parameters
    ----------
    spread
        The variance with its uncertainty.
    accept_deg2, reject_deg2
        Acceptance and rejection limits, square degrees.
    alpha_consumer, alpha_producer
        Risks, up to 0.5.

    Returns
    -------
    float
        1 if the record decides already. Infinite if no length would: between the limits, and
        where the visible slow part fills the room below the acceptance limit.

    Notes
    -----
    As the record grows, the standard error falls with the root of its length, and the degrees of
    freedom of the slow part grow with its length. The allowance for the slow part stays.

    References
    ----------
    S.15 of ``docs/risk.md``.

    """
    d, s = spread.d_deg2, spread.s_deg2
    if d > reject_deg2:
        t = -float(scipy.special.stdtrit(spread.student_dof, alpha_producer))
        a = (t * spread.cv / math.log(d / reject_deg2)) ** 2
        # The root of r^2 = a (r + 1 / f), from exp(-t cv sqrt((1 + 1 / (r f)) / r)).
        return max(1.0, 0.5 * (a + math.sqrt(a * a + 4.0 * a / spread.f)))
    room = accept_deg2 - d - spread.slow_allowance_deg2
    if s == 0.0:
        return 1.0 if room >= 0.0 else math.inf
    if not room > 0.0:
        return math.inf

    def missing(log_r: float) -> float:
        r = math.exp(log_r)
        return excess(r * spread.f, alpha_consumer, spread.student_dof) * s / math.sqrt(r) - room

    if missing(0.0) <= 0.0:
        return 1.0
    longest = math.log(_LONGEST)
    if not missing(longest) < 0.0:
        return math.inf
    return math.exp(find_root(missing, 0.0, longest))


def rate_lower(k: float, trials: float, alpha: float) -> float:
    """
    Return the lower confidence bound of a rate.

    Parameters
    ----------
    k, trials
        Number of events and of effective trials, 0 <= k <= trials; need not be integers.
    alpha
        Risk that the rate is below the bound.

    References
    ----------
    Clopper & Pearson 1934, extended to real arguments; S.14 of ``docs/risk.md``.

    """
    return float(scipy.special.betaincinv(k, trials - k + 1.0, alpha)) if k > 0.0 else 0.0


def rate_upper(k: float, trials: float, alpha: float) -> float:
    """Return the upper confidence bound of a rate, S.14; see `rate_lower`."""
    return float(scipy.special.betaincinv(k + 1.0, trials - k, 1.0 - alpha)) if k < trials else 1.0


def share_interval(k: int, trials: int) -> tuple[float, float]:
    """
    Return the 95 % interval of a probability, from k events in independent trials.

    References
    ----------
    Clopper & Pearson 1934.

    Examples
    --------
    >>> [round(bound, 3) for bound in share_interval(16, 20)]
    [0.563, 0.943]

    """
    return rate_lower(k, trials, _TAIL), rate_upper(k, trials, _TAIL)


def interval_factors(dof: ArrayLike, probability: float = 0.95) -> tuple[Reals, Reals]:
    """
    Return the factors from an estimated power to the ends of its confidence interval.

    Parameters
    ----------
    dof : array_like, shape (n,) or scalar
        Degrees of freedom of the estimate, greater than 0.
    probability
        Of the two-sided interval.

    Returns
    -------
    low, up : ndarray, shape of `dof`
        dof / chi2 at both tails: for a variance, a spectrum, or the square of an Allan deviation.

    References
    ----------
    NIST SP 1065 (Riley 2008), section 5.3.

    Examples
    --------
    >>> [round(float(factor), 4) for factor in interval_factors(10.0)]
    [0.4882, 3.0798]

    """
    dof = np.asarray(dof, np.float64)
    risk = 0.5 * (1.0 - probability)
    low: Reals = dof / scipy.special.chdtri(dof, risk)
    up: Reals = dof / scipy.special.chdtri(dof, 1.0 - risk)
    return low, up
