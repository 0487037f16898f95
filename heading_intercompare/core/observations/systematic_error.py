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

"""The systematic error of a TS from observations: estimate, uncertainty, guarded decision."""

from __future__ import annotations

from dataclasses import dataclass, replace
import math
from typing import Any

import numpy as np

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.decision.coverage import slowest_error_s
from heading_intercompare.core.decision.norm_presets import sigma_max_deg, systematic_max_deg
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.records import Integers, Reals
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.statistics.blocking import student_quantile

from .corrections import Corrections

#: More instants than this are thinned before their correlation is summed.
_MOST_INSTANTS = 1000


@dataclass(frozen=True, slots=True)
class Component:
    """
    One row of an uncertainty budget.

    Attributes
    ----------
    name : {'observations', 'common', 'clock', 'rounding', 'installation', 'slow_errors'}
    u_deg
        Standard uncertainty that it adds to the mean, degrees.
    nu
        Degrees of freedom; None for a stated uncertainty, which counts as known.
    words
        Where it comes from.

    """

    name: str
    u_deg: float
    nu: float | None
    words: str


@dataclass(frozen=True, slots=True)
class Budget:
    """
    The components of the uncertainty of a mean correction.

    Attributes
    ----------
    components
        Those above zero; the first is that of the observations.

    """

    components: tuple[Component, ...]

    @property
    def u_deg(self) -> float:
        """Return the combined standard uncertainty, degrees. JCGM 100:2008 (10)."""
        return math.sqrt(math.fsum(c.u_deg ** 2 for c in self.components))

    @property
    def u_shared_deg(self) -> float:
        """Return the part that more observations do not reduce, degrees."""
        return math.sqrt(math.fsum(c.u_deg ** 2 for c in self.components[1:]))

    @property
    def nu(self) -> float:
        """Effective degrees of freedom, JCGM 100:2008 (G.2b); infinite if all are stated."""
        rest = math.fsum(c.u_deg ** 4 / c.nu for c in self.components if c.nu)
        return self.u_deg ** 4 / rest if rest > 0.0 else math.inf


def make_budget(corrections: Corrections, *, common_u_deg: float, clock_u_s: float = 0.0,
                offset_u_deg: float = 0.0,
                slow: tuple[float, float] | None = None) -> Budget:
    """
    Return the budget of the mean of corrections.

    Parameters
    ----------
    corrections
        At least two.
    common_u_deg
        Standard uncertainty of the error that all observations share, such as that of a survey,
        degrees.
    clock_u_s
        Standard uncertainty of the offset between the clocks of observer and log, seconds.
    offset_u_deg
        That of the installation angle, degrees.
    slow
        Norm of the standard deviation of the TS, degrees, and the time in which the correlation
        of its slowest error falls to 1/e, seconds.

    Returns
    -------
    Budget

    Notes
    -----
    The scatter of the observations says how far their independent errors reach, with n - 1
    degrees of freedom. Stated uncertainties can only widen it. Rounding counts as shared:
    alongside the TS shows one figure all the time. Slow errors add what a TS at its norm would:
    sigma^2 times the mean of exp(-abs(t_i - t_j) / tau) over all pairs of instants.

    References
    ----------
    JCGM 100:2008, 4.2, 4.3, 5.1 and G.4.

    """
    n = len(corrections)
    scatter = float(np.std(corrections.c_minus_o_deg, ddof=1)) / math.sqrt(n)
    stated = math.sqrt(float((corrections.u_deg ** 2).sum())) / n
    words = (f'scatter of {n} observations' if scatter >= stated else
             f'stated for {n} observations; their scatter is smaller')
    shared = [
        Component('common', common_u_deg, None, 'stated for all observations together'),
        Component('clock', abs(float(corrections.rate_deg_s.mean())) * clock_u_s, None,
                  'clock of the observer, times the mean rate of turn'),
        Component('rounding', (corrections.step_deg or 0.0) / math.sqrt(12.0), None,
                  f'TS in steps of {corrections.step_deg or 0.0:g} deg'),
        Component('installation', offset_u_deg, None, 'stated for the installation angle')]
    if slow is not None:
        sigma_deg, tau_s = slow
        shared.append(Component(
            'slow_errors', sigma_deg * math.sqrt(_mean_correlation(corrections.stamp_ns, tau_s)),
            None, f'TS errors of {sigma_deg:.3g} deg that last {tau_s / 60.0:.3g} min'))
    return Budget((Component('observations', max(scatter, stated), n - 1.0, words),
                   *(c for c in shared if c.u_deg > 0.0)))


def _mean_correlation(stamp_ns: Integers, tau_s: float) -> float:
    """Return the variance of the mean of AR(1) errors at these instants, in that of one."""
    t_s = np.sort(stamp_ns - stamp_ns.min())[::max(1, stamp_ns.size // _MOST_INSTANTS)] / 1e9
    return float(np.exp(-np.abs(t_s[:, None] - t_s) / tau_s).mean())


_COVERAGE = 0.95
_QUESTIONABLE = 0.01
_LEAST_TO_QUESTION = 4
_MOST_NEEDED = 1000


@dataclass(frozen=True, slots=True)
class SystematicError:
    """
    What observations say about the systematic error of a TS; keys of the JSON.

    Attributes
    ----------
    n
        Number of corrections.
    reason
        'bound_within_norm', 'bound_above_norm'; or why it is open: 'no_norm',
        'insufficient_data', 'void.mean_difference', 'outliers_decide', 'reference_limited',
        'data_limited'.
    correction_deg
        Mean of C - O, to be added to the TS reading; the systematic error is its negative.
        Degrees, None for n = 0.
    std_deg
        Standard deviation of C - O, degrees. This and all that follows is None for n < 2.
    u_deg, nu
        Combined standard uncertainty of the mean, degrees, and its effective degrees of freedom;
        `nu` is None if infinite.
    k, expanded_u_deg
        Factor of Student for 95 %, and the expanded uncertainty, degrees.
    components
        The budget.
    norm_deg
        Norm of the systematic error, degrees.
    low_deg, high_deg
        Bounds of the size of the systematic error: compliant if `high_deg` is within the norm,
        non-compliant if `low_deg` is above it.
    n_needed
        Number of such observations that would decide for compliance; None if more do not help,
        or none are needed.
    questionable
        Places of corrections that lie too far from the others (Grubbs, 1 %).
    std_low_deg, std_high_deg
        Bounds of the standard deviation, each at its risk; degrees. The errors of the
        observations are in it.
    std_norm_deg
        Norm of the TS standard deviation, degrees.

    """

    n: int
    outcome: Outcome
    reason: str
    correction_deg: float | None = None
    std_deg: float | None = None
    u_deg: float | None = None
    nu: float | None = None
    k: float | None = None
    expanded_u_deg: float | None = None
    components: tuple[Component, ...] = ()
    norm_deg: float | None = None
    low_deg: float | None = None
    high_deg: float | None = None
    n_needed: int | None = None
    questionable: tuple[int, ...] = ()
    std_low_deg: float | None = None
    std_high_deg: float | None = None
    std_norm_deg: float | None = None


def _reach(p: float, own_u_deg: Any, shared_u_deg: float, nu: Any) -> Any:
    """Return how far the mean may be off at a probability: each part by its own quantile."""
    return np.hypot(scipy.special.stdtrit(nu, p) * own_u_deg,
                    scipy.special.ndtri(p) * shared_u_deg)


def judge_corrections(corrections: Corrections, settings: Settings, *, common_u_deg: float,
                      clock_u_s: float = 0.0) -> SystematicError:
    """
    Judge the systematic error of the TS.

    Parameters
    ----------
    corrections
        Any number.
    settings
        Norms and risks, the installation offset, the slowest error of the TS.
    common_u_deg, clock_u_s
        See `make_budget`.

    Returns
    -------
    SystematicError

    Raises
    ------
    SettingsError
        If the preset is unknown, or needs a latitude that is not given.

    Notes
    -----
    Let m be the mean correction, u_A the uncertainty from the n observations, u_B that of what
    they share, and N the norm. The bound reaches r(p) = sqrt(t(p; n - 1)^2 u_A^2 + z(p)^2 u_B^2)
    beyond m, with the quantiles t of Student and z of the normal distribution. The TS complies if
    abs(m) + r(1 - alpha_consumer) <= N. It breaks the norm if
    abs(m) - r(1 - alpha_producer / 2) > N.
    That risk is halved because an error may exceed the norm on either side. A TS at its norm is
    certified with at most the probability alpha_consumer. With the effective degrees of freedom
    of Welch and Satterthwaite two observations certify it in 8 % of trials instead of 5 %, so
    those serve the expanded uncertainty only. `docs/risk.md` has the rates of a simulation.

    References
    ----------
    JCGM 106:2012, 8.3: guarded acceptance and rejection. JCGM 100:2008: budget and Student's t.
    Zou & Donner 2008: bounds of a sum from the bounds of its parts. Grubbs 1969: the largest
    deviation of a sample.

    """
    norm, sigma = systematic_max_deg(settings.norms), sigma_max_deg(settings.norms, settings.model)
    error = _judge(corrections, settings, norm, sigma, common_u_deg, clock_u_s)
    if not error.questionable:
        return error
    keep = np.ones(len(corrections), bool)
    keep[list(error.questionable)] = False
    rest = replace(corrections, **{name: getattr(corrections, name)[keep] for name in (
        'row', 'stamp_ns', 'true_deg', 'ts_deg', 'c_minus_o_deg', 'rate_deg_s', 'u_deg')})
    without = _judge(rest, settings, norm, sigma, common_u_deg, clock_u_s)
    if without.outcome is error.outcome:
        return error
    return replace(error, outcome=Outcome.INDETERMINATE, reason='outliers_decide', n_needed=None)


def _judge(corrections: Corrections, settings: Settings, norm: float | None,
           sigma: float | None, common_u_deg: float, clock_u_s: float) -> SystematicError:
    n, x = len(corrections), corrections.c_minus_o_deg
    mean = float(wrap180(x.mean())) if n else None
    if mean is None or n < 2:
        return SystematicError(n=n, outcome=Outcome.INDETERMINATE, reason='insufficient_data',
                               correction_deg=mean, norm_deg=norm, std_norm_deg=sigma)
    risk, slowest = settings.risk, slowest_error_s(settings.risk)
    budget = make_budget(
        corrections, common_u_deg=common_u_deg, clock_u_s=clock_u_s,
        offset_u_deg=settings.installation_offset_u_deg,
        slow=None if slowest is None or sigma is None else (sigma, slowest))
    u, nu, std = budget.u_deg, budget.nu, float(np.std(x, ddof=1))
    k = student_quantile(0.5 + 0.5 * _COVERAGE, nu)
    parts = budget.components[0].u_deg, budget.u_shared_deg, n - 1.0
    high = abs(mean) + float(_reach(1.0 - risk.alpha_consumer, *parts))
    low = max(0.0, abs(mean) - float(_reach(1.0 - 0.5 * risk.alpha_producer, *parts)))
    n_needed = None
    if norm is None:
        outcome, reason = Outcome.INDETERMINATE, 'no_norm'
    elif abs(mean) > settings.detectors.mean_max_deg:
        outcome, reason = Outcome.INDETERMINATE, 'void.mean_difference'
    elif high <= norm:
        outcome, reason = Outcome.COMPLIANT, 'bound_within_norm'
    elif low > norm:
        outcome, reason = Outcome.NON_COMPLIANT, 'bound_above_norm'
    else:
        outcome = Outcome.INDETERMINATE
        n_needed = _count_needed(abs(mean), std, budget, norm, risk.alpha_consumer, n)
        z = float(scipy.special.ndtri(1.0 - risk.alpha_consumer))
        shared = z * budget.u_shared_deg
        reason = ('reference_limited' if abs(mean) - shared <= norm < abs(mean) + shared
                  else 'data_limited')
    return SystematicError(
        n=n, outcome=outcome, reason=reason, correction_deg=mean, std_deg=std, u_deg=u,
        nu=None if math.isinf(nu) else nu, k=k, expanded_u_deg=k * u,
        components=budget.components, norm_deg=norm, low_deg=low, high_deg=high,
        n_needed=n_needed, questionable=_find_questionable(x, std),
        std_low_deg=std * math.sqrt((n - 1) / scipy.special.chdtri(n - 1, risk.alpha_producer)),
        std_high_deg=std * math.sqrt(
            (n - 1) / scipy.special.chdtri(n - 1, 1.0 - risk.alpha_consumer)),
        std_norm_deg=sigma)


def _count_needed(mean: float, std: float, budget: Budget, norm: float, alpha: float,
                  n: int) -> int | None:
    """Return how many observations with this mean and scatter would comply; None if none do."""
    single_u_deg = max(std, budget.components[0].u_deg * math.sqrt(n))
    many = np.arange(n + 1, _MOST_NEEDED + 1)
    reach = _reach(1.0 - alpha, single_u_deg / np.sqrt(many), budget.u_shared_deg, many - 1.0)
    enough = np.flatnonzero(mean + reach <= norm)
    return int(many[enough[0]]) if enough.size else None


def _find_questionable(x: Reals, std: float) -> tuple[int, ...]:
    """Return the places of values beyond the limit of Grubbs."""
    n = x.size
    if n < _LEAST_TO_QUESTION or not std > 0.0:
        return ()
    t = student_quantile(1.0 - _QUESTIONABLE / (2.0 * n), n - 2.0)
    limit = (n - 1) / math.sqrt(n) * math.sqrt(t * t / (n - 2 + t * t))
    far = np.flatnonzero(np.abs(x - x.mean()) > limit * std)
    return tuple(far.tolist())
