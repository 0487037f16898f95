# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The uncertainty budget of a mean correction: what averages out, and what does not."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np

from heading_intercompare.core.records import Integers

from .corrections import Corrections

__all__ = ['Budget', 'Component', 'make_budget']

#: More instants than this are thinned before their correlation is summed.
_MOST_INSTANTS = 1000


@dataclass(frozen=True, slots=True)
class Component:
    """
    One row of an uncertainty budget.

    Attributes
    ----------
    name : {'observations', 'common', 'clock', 'rounding', 'installation', 'slow_errors'}
    u_deg : float
        Standard uncertainty that it adds to the mean, degrees.
    nu : float or None
        Degrees of freedom; None for a stated uncertainty, which counts as known.
    words : str
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
    components : tuple of Component
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
    corrections : Corrections
        At least two.
    common_u_deg : float
        Standard uncertainty of the error that all observations share, such as that of a survey,
        degrees.
    clock_u_s : float
        Standard uncertainty of the offset between the clocks of observer and log, seconds.
    offset_u_deg : float
        That of the installation angle, degrees.
    slow : tuple of float, optional
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
