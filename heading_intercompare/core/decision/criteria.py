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

"""The decision rules of GK as printed: variance (5), counts (6), total error (7)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
import math
from typing import Callable

from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.outcome import Outcome, worst
from heading_intercompare.core.settings import Norms, Settings

from .error_models import coverage_factor, ts_factor
from .norm_presets import sigma_max_deg

_PRINTED_P = 0.997

_MOST_DEG = 180.0
"""The largest difference of two headings, degrees."""


def _printed_k(norms: Norms) -> float | None:
    """Return K of a normal law as the paper prints it, 3 for P = 0.997; None for any other P."""
    if isinstance(norms.k_rule, float):
        return None
    return 3.0 if norms.k_rule == 'three' or norms.probability == _PRINTED_P else None


def variance_limits(sigma_max_deg: float, sigma_ref_max_deg: float,
                    m: float) -> tuple[float, float]:
    """
    Return the limits of the variance criterion.

    Parameters
    ----------
    sigma_max_deg
        Norm of the TS standard deviation, degrees.
    sigma_ref_max_deg
        Norm of the RS standard deviation, degrees.
    m
        Lower bound of sigma_ref / sigma_ref_max, in [0, 1].

    Returns
    -------
    tightened_deg2, limit_deg2 : float
        A variance up to the first proves compliance, one above the second non-compliance;
        between them lies the dead zone. Square degrees.

    Raises
    ------
    ValueError
        If `m` is outside [0, 1].

    References
    ----------
    GK (5), GK (5').

    Examples
    --------
    >>> [round(limit, 6) for limit in variance_limits(0.3, 0.4, m=0.5)]
    [0.13, 0.25]

    """
    if not 0.0 <= m <= 1.0:
        raise ValueError(f'm = {m!r}: must be from 0 to 1')
    return (sigma_max_deg ** 2 + (m * sigma_ref_max_deg) ** 2,
            sigma_max_deg ** 2 + sigma_ref_max_deg ** 2)


def _require(name: str, value: float | None) -> float:
    """Return a norm that every verdict needs; raise SettingsError if it is missing."""
    if value is None:
        raise SettingsError(f'norms.{name} is missing: a verdict needs it, e.g. norms.{name}=0.2')
    return value


def require_norms(norms: Norms, model: str) -> tuple[float, float]:
    """
    Return the norms that every verdict needs; SettingsError if one is missing.

    Returns
    -------
    sigma_max_deg, sigma_ref_max_deg : float
        Of the TS and of the RS, degrees.

    """
    return (_require('sigma_max_deg', sigma_max_deg(norms, model)),
            _require('sigma_ref_max_deg', norms.sigma_ref_max_deg))


@dataclass(frozen=True, slots=True)
class Limits:
    """
    All limits of the criteria, computed once from the norms.

    Attributes
    ----------
    m_low, m_up
        Bounds of M = sigma_ref / sigma_ref_max; `m_low` already includes the square root of the
        factor by which interpolation reduces the noise variance of the RS.
    ts_variance_factor
        Factor by which interpolation reduces the white-noise variance of the TS; applies where a
        small variance is to prove compliance.
    rs_variance_factor
        The same for the RS, already in `m_low`.
    limit_deg2, tightened_limit_deg2
        GK (5), (5').
    k, k_tightened
        Coverage factors of GK (*) and (**).
    k_printed
        Both as the paper prints them; None where it prints no number.

    """

    sigma_max_deg: float
    sigma_ref_max_deg: float
    m_low: float
    m_up: float
    probability: float
    limit_deg2: float
    tightened_limit_deg2: float
    k: float
    k_tightened: float
    ts_variance_factor: float = 1.0
    rs_variance_factor: float = 1.0
    k_printed: float | None = None

    @property
    def as_printed(self) -> 'Limits':
        """Return the limits with the coverage factors as the paper prints them."""
        if self.k_printed is None:
            return self
        return replace(self, k=self.k_printed, k_tightened=self.k_printed)

    def m_low_for(self, variance_deg2: float) -> float | None:
        """
        Return the least lower bound of M with which a variance would be within the limit.

        Returns
        -------
        float or None
            None if it is within the limit now, or would not be even at the upper bound of M.

        """
        needed_deg2 = variance_deg2 - self.ts_variance_factor * self.sigma_max_deg ** 2
        ref_deg2 = self.rs_variance_factor * self.sigma_ref_max_deg ** 2
        if variance_deg2 <= self.tightened_limit_deg2 or needed_deg2 > self.m_up ** 2 * ref_deg2:
            return None
        return math.sqrt(needed_deg2 / ref_deg2) if ref_deg2 > 0.0 else None

    def with_rs_factor(self, factor: float) -> 'Limits':
        """Return the limits after interpolation reduced the RS noise variance once more."""
        lost = (1.0 - factor) * (self.m_low * self.sigma_ref_max_deg) ** 2
        return replace(self, m_low=self.m_low * math.sqrt(factor),
                       rs_variance_factor=self.rs_variance_factor * factor,
                       tightened_limit_deg2=self.tightened_limit_deg2 - lost)

    def with_model(self, model: str) -> 'Limits':
        """Return the limits with the count limits of another model of the distributions."""
        ratio = self.sigma_ref_max_deg / self.sigma_max_deg
        reduced = self.m_low * ratio / math.sqrt(self.ts_variance_factor)
        return replace(self, k=coverage_factor(model, ratio, self.probability),
                       k_tightened=coverage_factor(model, reduced, self.probability))

    @property
    def count_limit_deg(self) -> float:
        """Return the limit of GK (*), degrees."""
        return self.k * math.sqrt(self.limit_deg2)

    @property
    def tightened_count_limit_deg(self) -> float:
        """Return the limit of GK (**), degrees."""
        return self.k_tightened * math.sqrt(self.tightened_limit_deg2)

    @property
    def rejection_limit_deg2(self) -> float:
        """Return the limit of the guarded rejection, with the upper bound of M; square degrees."""
        return self.sigma_max_deg ** 2 + (self.m_up * self.sigma_ref_max_deg) ** 2

    def allowed(self, n: int) -> Fraction:
        """Return n (1 - P) exactly, from the shortest decimal form of P."""
        return n * (1 - Fraction(repr(self.probability)))

    @classmethod
    def of(cls, norms: Norms, model: str = 'NN', rs_variance_factor: float = 1.0,
           ts_variance_factor: float = 1.0) -> 'Limits':
        """
        Return the limits that follow from the norms.

        Parameters
        ----------
        norms
            Must hold `sigma_max_deg` or a preset, and `sigma_ref_max_deg`.
        model : {'NN', 'UN', 'NU', 'UU'}
            Error distributions of TS and RS.
        rs_variance_factor, ts_variance_factor
            Mean of the factors of white noise over the pairs; 1 where that sensor is not
            interpolated.

        Raises
        ------
        SettingsError
            If a norm is missing.

        Notes
        -----
        Interpolation reduces the variance of white errors by the factor, that of slower errors by
        less. The share of white errors is unknown, so a TS at its norm may show anything from the
        factor times its variance to the full variance. Acceptance assumes the first, rejection
        the second. The same holds for the RS.

        References
        ----------
        GK (5), (5'), (*), (**).

        """
        sigma_max, sigma_ref_max = require_norms(norms, model)
        low, up = norms.m_low, norms.m_up
        if norms.sigma_ref_deg is not None and sigma_ref_max > 0.0:
            low = up = norms.sigma_ref_deg / sigma_ref_max
        low *= math.sqrt(rs_variance_factor)
        ratio = sigma_ref_max / sigma_max
        shrunk = math.sqrt(ts_variance_factor)
        limit = variance_limits(sigma_max, sigma_ref_max, low)[1]
        tightened = variance_limits(shrunk * sigma_max, sigma_ref_max, low)[0]
        rule = norms.k_rule
        if isinstance(rule, float):
            k = k_tightened = rule
        elif rule == 'three' and model == 'NN':
            k = k_tightened = 3.0
        else:
            k = coverage_factor(model, ratio, norms.probability)
            k_tightened = coverage_factor(model, low * ratio / shrunk, norms.probability)
        return cls(
            sigma_max_deg=sigma_max, sigma_ref_max_deg=sigma_ref_max, m_low=low, m_up=up,
            probability=norms.probability, limit_deg2=limit, tightened_limit_deg2=tightened, k=k,
            k_tightened=k_tightened, ts_variance_factor=ts_variance_factor,
            rs_variance_factor=rs_variance_factor,
            k_printed=_printed_k(norms) if model == 'NN' else None)


@dataclass(frozen=True, slots=True)
class VarianceCriterion:
    """The result of GK (5) for one run."""

    limit_deg2: float = figure('GK (5): variance limit')
    tightened_limit_deg2: float = figure("GK (5'): tightened variance limit")
    ratio: float | None = figure(
        "GK (5''): ratio", 'the RS standard deviation in its norms at which the TS would just '
        'meet its own; null for a variance below sigma_max²')
    dead_zone_width: float = figure('GK (5): width of the dead zone', '1 − M')
    outcome: Outcome = figure('GK (5): outcome', row='GK (5) variance')


def apply_variance_criterion(variance_deg2: float | None, limits: Limits) -> VarianceCriterion:
    """
    Compare the variance of the differences with its limits.

    Parameters
    ----------
    variance_deg2
        GK (4), square degrees; None (too few differences) is indeterminate.
    limits
        Of the variance.

    References
    ----------
    GK (5), (5'), (5'').

    """
    ratio = None
    if variance_deg2 is None:
        outcome = Outcome.INDETERMINATE
    else:
        if variance_deg2 > limits.limit_deg2:
            outcome = Outcome.NON_COMPLIANT
        elif variance_deg2 <= limits.tightened_limit_deg2:
            outcome = Outcome.COMPLIANT
        else:
            outcome = Outcome.INDETERMINATE
        excess = variance_deg2 - limits.sigma_max_deg ** 2
        if excess >= 0.0 and limits.sigma_ref_max_deg > 0.0:
            ratio = math.sqrt(excess) / limits.sigma_ref_max_deg
    return VarianceCriterion(limits.limit_deg2, limits.tightened_limit_deg2, ratio,
                             1.0 - limits.m_low, outcome)


@dataclass(frozen=True, slots=True)
class CountCriterion:
    """The result of GK (6) for one run."""

    k: float = figure('GK (*): coverage factor')
    k_tightened: float = figure('GK (**): coverage factor')
    limit_deg: float = figure('GK (*): limit of a deviation')
    tightened_limit_deg: float = figure('GK (**): tightened limit')
    n_plus: int = figure('GK (6): n+ beyond the limit')
    n_plus_plus: int = figure('GK (6): n++ beyond the tightened limit')
    allowed: float = figure('GK (6): allowed, n (1 - P)')
    dead_zone_width: float | None = figure('GK (6): width of the dead zone', 'null for n = 0')
    outcome: Outcome = figure('GK (6): outcome', row='GK (6) counts')


def apply_count_criterion(n: int, n_plus: int, n_plus_plus: int, limits: Limits) -> CountCriterion:
    """
    Compare the counts of extreme deviations with the number allowed.

    Parameters
    ----------
    n
        Number of differences.
    n_plus, n_plus_plus
        Number of deviations above `limits.count_limit_deg` and above
        `limits.tightened_count_limit_deg`.
    limits
        With the share of deviations allowed.

    Notes
    -----
    n (1 - P) is compared exactly, as a fraction: in binary, 10 (1 - 0.9) is less than 1.

    Fewer than two differences are indeterminate, as for the variance: a single difference equals
    its own mean, whatever the TS. For n < 1 / (1 - P) no deviation at all is allowed, and a run
    without any meets (6') as printed. That certifies no rate.

    References
    ----------
    GK (6), (6'), (6'').

    """
    allowed = limits.allowed(n)
    if n < 2:
        outcome = Outcome.INDETERMINATE
    elif n_plus > allowed:
        outcome = Outcome.NON_COMPLIANT
    elif n_plus_plus <= allowed:
        outcome = Outcome.COMPLIANT
    else:
        outcome = Outcome.INDETERMINATE
    width = float((n_plus_plus - n_plus) / allowed) if n else None
    return CountCriterion(
        k=limits.k, k_tightened=limits.k_tightened, limit_deg=limits.count_limit_deg,
        tightened_limit_deg=limits.tightened_count_limit_deg, n_plus=n_plus,
        n_plus_plus=n_plus_plus, allowed=float(allowed), dead_zone_width=width, outcome=outcome)


@dataclass(frozen=True, slots=True)
class TotalError:
    """Confidence limits of the total TS error of one run, GK (7)."""

    k: float | None = figure('GK (7): coverage factor', default=None)
    sigma_ts_low_deg: float | None = figure('GK (7): TS standard deviation, RS at its upper .. '
                                            'lower bound', default=None, up='sigma_ts_up_deg')
    sigma_ts_up_deg: float | None = figure('its upper end', default=None)
    low_deg: float | None = figure('GK (7): total TS error, wide', default=None, up='up_deg',
                                   row='total TS error')
    up_deg: float | None = figure('its upper limit', default=None)
    low_narrow_deg: float | None = figure('GK (7): total TS error, narrow', default=None,
                                          up='up_narrow_deg')
    up_narrow_deg: float | None = figure('its upper limit', default=None)
    outcome: Outcome | None = figure('GK (7): outcome', 'null without its norm', default=None)


def estimate_total_error(mean_deg: float | None, variance_deg2: float | None, limits: Limits,
                         norms: Norms, model: str = 'NN') -> TotalError:
    """
    Return the confidence limits of the total TS error.

    Parameters
    ----------
    mean_deg, variance_deg2
        Mean and variance of the differences; None for too few of them.
    limits
        With the least and the largest variance of the RS.
    norms
        Uses `probability`, `k_rule`, `k_total_rule` and `total_error_max_deg`.
    model : {'NN', 'UN', 'NU', 'UU'}
        Laws of the errors of TS and RS, GK (2) to (2c).

    Notes
    -----
    A variance of the differences below that of the RS gives a TS standard deviation of 0. The
    wide limits assume that the errors of an interpolated TS were larger by the root of its
    factor. K follows the rule of the guarded counts, for this norm binds: a number is used as
    given, and 'three' is 3 if the distribution that K belongs to is normal.

    References
    ----------
    GK (7), whose root is GK (3) solved for the TS.

    """
    norm = norms.total_error_max_deg
    if mean_deg is None or variance_deg2 is None:
        outcome = None if norm is None else Outcome.INDETERMINATE
        return TotalError(outcome=outcome)

    def sigma_and_k(m: float, ts_variance_factor: float) -> tuple[float, float]:
        ref = m * limits.sigma_ref_max_deg
        sigma = math.sqrt(max(0.0, variance_deg2 - ref ** 2) / ts_variance_factor)
        rule = norms.k_rule
        if isinstance(rule, float):
            return sigma, rule
        if rule == 'three' and (model == 'NN' or norms.k_total_rule == 'ts' and model[0] == 'N'):
            return sigma, 3.0
        if norms.k_total_rule == 'ts':
            return sigma, ts_factor(model, norms.probability)
        ratio = ref / sigma if sigma > 0.0 else math.inf
        return sigma, coverage_factor(model, ratio, norms.probability)

    sigma_up, k = sigma_and_k(limits.m_low, limits.ts_variance_factor)
    sigma_low, k_narrow = sigma_and_k(limits.m_up, 1.0)
    wide, narrow = min(_MOST_DEG, k * sigma_up), min(_MOST_DEG, k_narrow * sigma_low)
    outcome = None
    if norm is not None:
        if abs(mean_deg) + wide <= norm:
            outcome = Outcome.COMPLIANT
        elif abs(mean_deg) + narrow > norm:
            outcome = Outcome.NON_COMPLIANT
        else:
            outcome = Outcome.INDETERMINATE
    return TotalError(k=k, sigma_ts_low_deg=sigma_low, sigma_ts_up_deg=sigma_up,
                      low_deg=mean_deg - wide, up_deg=mean_deg + wide,
                      low_narrow_deg=mean_deg - narrow, up_narrow_deg=mean_deg + narrow,
                      outcome=outcome)


@dataclass(frozen=True, slots=True)
class Printed:
    """
    Findings of the criteria as printed.

    Attributes
    ----------
    outcome
        The worst of the three; the total error counts only if it has a norm.

    """

    variance: VarianceCriterion
    counts: CountCriterion
    total: TotalError
    outcome: Outcome


def apply_gk(n: int, mean_deg: float | None, variance_deg2: float | None,
             count: Callable[[float], int], limits: Limits, settings: Settings) -> Printed:
    """
    Apply the criteria of GK.

    Parameters
    ----------
    n
        Number of differences.
    mean_deg, variance_deg2
        Their mean and variance; None for too few differences.
    count
        ``count(limit_deg)`` returns the number of deviations above a limit.
    limits
        Of variance and counts.
    settings
        Uses norms and model.

    References
    ----------
    GK (5), (6), (7).

    """
    variance = apply_variance_criterion(variance_deg2, limits)
    printed = limits.as_printed
    counts = apply_count_criterion(n, count(printed.count_limit_deg),
                                   count(printed.tightened_count_limit_deg), printed)
    total = estimate_total_error(mean_deg, variance_deg2, limits, settings.norms, settings.model)
    outcomes = [variance.outcome, counts.outcome]
    if total.outcome is not None:
        outcomes.append(total.outcome)
    together = Outcome.INDETERMINATE if variance_deg2 is None else worst(outcomes)
    return Printed(variance, counts, total, together)
