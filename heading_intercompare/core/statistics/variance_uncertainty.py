# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
How well the variance of correlated differences is known, from the spectrum of their squares.

The squares of the deviations are a signal whose mean is the variance. Its power at the lowest
frequencies of the record says how far that mean may be off. The frequency at which the power falls
off says how many independent fluctuations of the errors the record holds.
"""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Sequence

import numpy as np
import scipy

from .cells import Cells, CellValues

__all__ = ['between_runs', 'estimate_spread', 'excess', 'lower_bound', 'MEAN_DOF', 'pool',
           'Spread', 'upper_bound']

MEAN_DOF = 8
"""Degrees of freedom of the variance of the mean: the number of low frequencies averaged. S.1."""

_STUDENT_DOF = 12
_BANDS = (6, 12, 24)
_PLATEAU = 16
_LOW_MODES = 4
_MIDDLE = 12, 28
_WINDOWS = 64, 128
_LEAST_CORNER = 8.0
_PER_CORNER = 0.45
_FEW = 30.0
_NORMAL_KURTOSIS = 3.0
# 1 / chi-square quantile of one degree of freedom at 0.05.
_MOST_ALLOWANCE = 254.3
_ALLOWANCE_GROWTH = 8.0
_MANY = 1e8


@dataclass(frozen=True, slots=True)
class Spread:
    """
    The variance of the differences of one run, or of several, and how well it is known.

    Attributes
    ----------
    n, order : int
        Number of differences; order of the polynomial removed (0: the mean).
    d_deg2 : float
        Variance D, with the part that mean and polynomial absorbed added back; square degrees.
        S.2.
    mean_variance_deg2 : float
        Variance v of the mean, square degrees. S.1.
    s_deg2 : float
        Standard error s of `d_deg2`, square degrees. S.4.
    nu : float
        Effective degrees of freedom, 2 (D / s)^2; n - 1 - order where D is 0.
    f : float
        Degrees of freedom of the slow part, at most `nu`. S.6.
    corner_j : float
        Frequency where the power of the squares falls off, in half-periods per record; infinite
        if it does not. S.5.
    low_deg2, middle_deg2 : float
        Mean variance of the four lowest half-periods, and of the 13th to 28th. S.8.
    student_dof : int
        Degrees of freedom of `s_deg2`: 12 per run.

    """

    n: int
    order: int
    d_deg2: float
    mean_variance_deg2: float
    s_deg2: float
    nu: float
    f: float
    corner_j: float
    low_deg2: float
    middle_deg2: float
    student_dof: int = _STUDENT_DOF

    @property
    def cv(self) -> float:
        """Relative standard error s / D; 0 where D is 0."""
        return self.s_deg2 / self.d_deg2 if self.d_deg2 > 0.0 else 0.0

    @property
    def r_slow(self) -> float:
        """Power of the lowest half-periods over that of the middle ones; may be inf. S.8."""
        if self.middle_deg2 > 0.0:
            return self.low_deg2 / self.middle_deg2
        return math.inf if self.low_deg2 > 0.0 else 0.0

    @property
    def slow_variance_deg2(self) -> float:
        """Variance V_s of the visible slow part, square degrees. S.8."""
        return _LOW_MODES * max(0.0, self.low_deg2 - self.middle_deg2)

    @property
    def slow_allowance_deg2(self) -> float:
        """Return the allowance G of the upper bound for the slow part, square degrees. S.9."""
        slow = self.slow_variance_deg2
        if slow == 0.0:
            return 0.0
        return min(_MOST_ALLOWANCE, self.r_slow ** 2 / _ALLOWANCE_GROWTH) * slow


def estimate_spread(cells: Cells | CellValues, order: int = 0) -> Spread | None:
    """
    Return the variance of a run and how well it is known.

    Parameters
    ----------
    cells : Cells or CellValues
        Cells of the differences, or of their residuals about a polynomial.
    order : int
        Order of that polynomial; 0 for none, because the mean is removed here. If the data chose
        the order, the highest order that could have been chosen.

    Returns
    -------
    Spread or None
        None for fewer than 128 differences or cells.

    References
    ----------
    S.1 to S.6, S.8 of ``docs/risk.md``. Cosine estimates of a long-run variance: Lazarus, Lewis,
    Stock & Watson 2018.

    Examples
    --------
    >>> found = estimate_spread(Cells.of([1.0, -1.0] * 500))
    >>> round(found.d_deg2, 3), round(found.nu, 6)
    (1.0, 970.873786)

    """
    record = cells.values() if isinstance(cells, Cells) else cells
    if record is None:
        return None
    n, q, k = record.n, record.mean_square_deg2, record.b_deg.size
    a = _power(record.b_deg, record.rounding_deg ** 2)
    c = _power(record.y_deg2)
    lost = 1 + order
    v = float(a[order:order + MEAN_DOF].mean()) / k
    low = float(a[order:order + _LOW_MODES].mean()) / k
    middle = float(a[order + _MIDDLE[0]:order + _MIDDLE[1]].mean()) / k
    d = q + (v if order == 0 else lost * low)
    w = max(float(c[:band].mean()) for band in _BANDS)
    if not d > 0.0:
        free = float(n - lost)
        return Spread(n, order, 0.0, v, 0.0, free, free, math.inf, low, middle)
    # Relative to D, because the squares of small variances underflow to 0.
    relative = (1.0 + _FEW / n) * max(
        w / k / d / d + 6.0 * (lost * v / d) ** 2 / record.occupied, 2.0 / n)
    s, nu = d * math.sqrt(relative), 2.0 / relative
    corner, slow = _corner(c)
    heavy = max(1.0, record.kurtosis / _NORMAL_KURTOSIS)
    return Spread(n, order, d, v, s, nu, min(nu, slow * record.occupied / heavy ** 2), corner, low,
                  middle)


def _power(values: np.ndarray, floor: float = 0.0) -> np.ndarray:
    """Return the power at 1, 2, ... half-periods; below the floor times K it is rounding: 0."""
    power = scipy.fft.dct(values, type=2, norm='ortho')[1:] ** 2
    return np.where(power < floor * values.size, 0.0, power)


def _corner(c: np.ndarray) -> tuple[float, float]:
    """Return J, the corner of the spectrum of the squares, and 0.45 J / h: least over windows."""
    plateau = float(c[:_PLATEAU].mean())
    corner = least = math.inf
    for w in {*(w for w in _WINDOWS if w <= c.size), c.size}:
        floor = min(plateau, float(c[3 * w // 4:w].mean()))
        area = float(c[:w].sum()) - w * floor
        if area > 0.0 and plateau > floor:
            j = max(_LEAST_CORNER, 2.0 / math.pi * area / (plateau - floor))
            corner = min(corner, j)
            least = min(least, _PER_CORNER * j * plateau / (plateau - floor))
    return corner, least


def excess(f: float, alpha: float, student_dof: int = _STUDENT_DOF) -> float:
    """
    Return the distance of the upper bound from the variance, in standard errors.

    Parameters
    ----------
    f : float
        Degrees of freedom of the slow part, greater than 0.
    alpha : float
        Risk that the variance exceeds the bound; up to 0.5.
    student_dof : int
        Degrees of freedom of the standard error.

    Returns
    -------
    float
        At least Student's quantile, which it equals for infinite f; infinite if the data set no
        bound.

    References
    ----------
    S.7 of ``docs/risk.md``; Graybill & Wang 1980 for one poorly known component.

    Examples
    --------
    >>> [round(excess(f, 0.05), 1) for f in (1e12, 100.0, 20.0, 4.0)]
    [1.8, 2.2, 3.0, 8.0]

    """
    t = -float(scipy.special.stdtrit(student_dof, alpha))
    if f > _MANY:
        return t + math.sqrt(8.0 / f) * (2.0 * t * t + 1.0) / 6.0
    quantile = 2.0 * float(scipy.special.gammaincinv(0.5 * f, float(scipy.special.ndtr(-t))))
    return math.sqrt(0.5 * f) * (f / quantile - 1.0) if quantile > 0.0 else math.inf


def upper_bound(found: Spread, alpha: float) -> float:
    """
    Return the upper confidence bound of the variance.

    Parameters
    ----------
    found : Spread
        The variance with its uncertainty.
    alpha : float
        Risk that the variance exceeds the bound; up to 0.5.

    Returns
    -------
    float
        Square degrees; infinite if the data set no bound, 0 if all residuals are 0.

    References
    ----------
    S.10 of ``docs/risk.md``.

    """
    if found.d_deg2 == 0.0:
        return 0.0
    return (found.d_deg2 + excess(found.f, alpha, found.student_dof) * found.s_deg2
            + found.slow_allowance_deg2)


def lower_bound(found: Spread, alpha: float) -> float:
    """Return the lower confidence bound of the variance, square degrees; S.11."""
    cv = found.cv * math.sqrt(1.0 + 1.0 / found.f)
    return found.d_deg2 * math.exp(float(scipy.special.stdtrit(found.student_dof, alpha)) * cv)


def pool(runs: Sequence[Spread]) -> Spread:
    """
    Return the common variance of several runs, and how well they know it together.

    Parameters
    ----------
    runs : sequence of Spread
        One or more runs, independent of each other.

    References
    ----------
    S.12 of ``docs/risk.md``: the cumulants of independent runs add up.

    """
    n = sum(r.n for r in runs)
    weights = [r.n / n for r in runs]

    def mean(values: Sequence[float]) -> float:
        return math.fsum(w * value for w, value in zip(weights, values))

    d = mean([r.d_deg2 for r in runs])
    s = math.hypot(*(w * r.s_deg2 for w, r in zip(weights, runs)))
    skewness = math.fsum((w * r.s_deg2 / s) ** 3 * math.sqrt(8.0 / r.f)
                         for w, r in zip(weights, runs)) if s > 0.0 else 0.0
    free = math.fsum(r.n - 1 - r.order for r in runs)
    return Spread(
        n, max(r.order for r in runs), d,
        math.fsum(w * w * r.mean_variance_deg2 for w, r in zip(weights, runs)), s,
        2.0 * (d / s) ** 2 if s > 0.0 else free,
        8.0 / skewness ** 2 if skewness > 0.0 else free,
        min(r.corner_j for r in runs), mean([r.low_deg2 for r in runs]),
        mean([r.middle_deg2 for r in runs]), sum(r.student_dof for r in runs))


def between_runs(runs: Sequence[Spread], means_deg: Sequence[float], alpha: float) -> float:
    """
    Return an upper bound of the variance, with the slow part taken from the means of the runs.

    Parameters
    ----------
    runs : sequence of Spread
        At least 2 runs, many correlation times of the slow part apart.
    means_deg : sequence of float
        Their mean differences, degrees, assumed to share one expected value.
    alpha : float
        Risk that the variance exceeds the bound; up to 0.5.

    Returns
    -------
    float
        Square degrees. The scatter of two means says next to nothing, that of five or more much.

    References
    ----------
    S.13 of ``docs/risk.md``; Graybill & Wang 1980.

    """
    m = len(runs)
    together = pool(runs)
    centre = math.fsum(means_deg) / m
    between = math.fsum((mean - centre) ** 2 for mean in means_deg) / (m - 1)
    quantile = 2.0 * float(scipy.special.gammaincinv(0.5 * (m - 1), alpha))
    inside = math.fsum(r.n * r.mean_variance_deg2 for r in runs) / together.n
    within = excess(together.f, alpha, together.student_dof) * together.s_deg2 \
        if together.s_deg2 > 0.0 else 0.0
    return (together.d_deg2 - inside + between
            + math.hypot(within, ((m - 1) / quantile - 1.0) * between))
