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

"""
How well the variance of correlated differences is known, from the spectrum of their squares.

The squares of the deviations are a signal whose mean is the variance. Its power at the lowest
frequencies of the record says how far that mean may be off. The frequency at which the power falls
off says how many independent fluctuations of the errors the record holds. If the slowest error is
stated beforehand, that number is known, and the upper bound lies closer.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
import math
from typing import Sequence

import numpy as np

from heading_intercompare.core import lazy_scipy as scipy

from .cells import Cells, CellValues

MEAN_DOF = 8
"""Degrees of freedom of the variance of the mean: the number of low frequencies averaged. S.1."""

LEAST_TIMES = 20.0
"""Least length of a record in correlation times; in shorter records the risks do not hold."""

STUDENT_DOF = 12
"""Degrees of freedom of the standard error of the variance of one run. S.7."""

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

# If the slowest error is stated.
_FEWEST_MODES, _MOST_MODES = 8, 128
_TIMES_PER_MODE = 3.0
_WIDER, _WIDER_PER_TAIL, _POOLED_PER_TAIL = 1.1, 0.7, 0.5
_CONTRADICTS = 3.0


@dataclass(frozen=True, slots=True)
class Above:
    """
    What an upper bound is made of: d + widening x(f) s + allowance; S.10, S.17, S.18.

    Attributes
    ----------
    d_deg2, s_deg2
        The variance and its standard error, square degrees.
    f
        Degrees of freedom of the slow part.
    student_dof
        Degrees of freedom of `s_deg2`.
    widening
        Factor for what the figures do not show.
    allowance_deg2
        Allowance for a slow part that the record shows but cannot measure, square degrees.

    """

    d_deg2: float
    s_deg2: float
    f: float
    student_dof: float
    widening: float = 1.0
    allowance_deg2: float = 0.0


@dataclass(frozen=True, slots=True)
class Spread:
    """
    The variance of the differences of one run, or of several, and how well it is known.

    Attributes
    ----------
    n, order
        Number of differences; order of the polynomial removed (0: the mean).
    d_deg2
        Variance D, with the part that mean and polynomial absorbed added back; square degrees.
        S.2.
    mean_variance_deg2
        Variance v of the mean, square degrees. S.1.
    s_deg2
        Standard error s of `d_deg2`, square degrees. S.4.
    nu
        Effective degrees of freedom, 2 (D / s)^2; n - 1 - order where D is 0.
    f
        Degrees of freedom of the slow part, at most `nu`. S.6.
    corner_j
        Frequency where the power of the squares falls off, in half-periods per record; infinite
        if it does not. S.5.
    low_deg2, middle_deg2
        Mean variance of the four lowest half-periods, and of the 13th to 28th. S.8.
    student_dof
        Degrees of freedom of `s_deg2`: 12 per run.
    kurtosis
        Mean fourth power of the deviations over the square of their mean square.
    times
        Length of the record, or of the shortest of several, in slowest errors stated; None if
        none is stated.
    stated
        The upper bound that rests on the statement; None if it is that of the record alone.

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
    student_dof: int = STUDENT_DOF
    kurtosis: float = _NORMAL_KURTOSIS
    times: float | None = None
    stated: Above | None = None

    @property
    def above(self) -> Above:
        """Return what the upper bound is made of; S.10, S.17, S.18."""
        if self.stated is not None:
            return self.stated
        return Above(self.d_deg2, self.s_deg2, self.f, self.student_dof,
                     allowance_deg2=self._visible_allowance_deg2)

    @property
    def absorbed_deg2(self) -> float:
        """Return the part of D that mean and polynomial have absorbed, square degrees; S.2."""
        return self.mean_variance_deg2 if self.order == 0 else (1 + self.order) * self.low_deg2

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
        """Return the allowance of the upper bound for the slow part, square degrees. S.9, S.17."""
        return self.above.allowance_deg2

    @property
    def _visible_allowance_deg2(self) -> float:
        """Return G, which assumes nothing of the errors, square degrees; S.9."""
        slow = self.slow_variance_deg2
        if slow == 0.0:
            return 0.0
        return min(_MOST_ALLOWANCE, self.r_slow ** 2 / _ALLOWANCE_GROWTH) * slow


def estimate_spread(cells: Cells | CellValues, order: int = 0,
                    times: float | None = None) -> Spread | None:
    """
    Return the variance of a run and how well it is known.

    Parameters
    ----------
    cells
        Cells of the differences, or of their residuals about a polynomial.
    order
        Order of that polynomial; 0 for none, because the mean is removed here. If the data chose
        the order, the highest order that could have been chosen.
    times
        Length of the record in slowest errors stated; None if none is stated. From 20 on the
        upper bound rests on the statement.

    Returns
    -------
    Spread or None
        None for fewer than 128 differences or cells.

    References
    ----------
    S.1 to S.6, S.8, S.17 of ``docs/risk.md``. Cosine estimates of a long-run variance: Lazarus,
    Lewis, Stock & Watson 2018.

    Examples
    --------
    >>> spread = estimate_spread(Cells.of([1.0, -1.0] * 500))
    >>> round(spread.d_deg2, 3), round(spread.nu, 6)
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
        return Spread(n=n, order=order, d_deg2=0.0, mean_variance_deg2=v, s_deg2=0.0, nu=free,
                      f=free, corner_j=math.inf, low_deg2=low, middle_deg2=middle)
    # Relative to D, because the squares of small variances underflow to 0.
    swallowed = 6.0 * (lost * v / d) ** 2 / record.occupied

    def squared(relative: float) -> float:
        return (1.0 + _FEW / n) * max(relative, 2.0 / n)

    relative = squared(w / k / d / d + swallowed)
    s, nu = d * math.sqrt(relative), 2.0 / relative
    corner, slow = _corner(c)
    heavy = max(1.0, record.kurtosis / _NORMAL_KURTOSIS)
    f = min(nu, slow * record.occupied / heavy ** 2)
    spread = Spread(n=n, order=order, d_deg2=d, mean_variance_deg2=v, s_deg2=s, nu=nu, f=f,
                    corner_j=corner, low_deg2=low, middle_deg2=middle, kurtosis=record.kurtosis,
                    times=times)
    if times is None or times < LEAST_TIMES:
        return spread
    # A gap shows nothing of the errors, so it does not count.
    seen = times * record.occupied
    modes = min(_MOST_MODES, k // 4, max(_FEWEST_MODES, int(seen / _TIMES_PER_MODE)))
    # No errors as fast as stated have a larger variance of D; what exceeds it is noise of C.
    largest = (max(record.kurtosis, _NORMAL_KURTOSIS) - 1.0) / seen
    relative = squared(min(float(c[:modes].mean()) / k / d / d + swallowed, largest))
    f = min(2.0 / relative, max(_PER_CORNER * seen / heavy ** 2, 0.5 * f))
    return replace(spread, stated=Above(
        d, d * math.sqrt(relative), f, modes, _WIDER * (1.0 + _WIDER_PER_TAIL * math.log(heavy)),
        _allowance_deg2(spread, _flat_ratio(times, order))))


def _flat_ratio(times: float, order: int = 0) -> float:
    """Return R0, the ratio of S.8 in a record of AR(1) errors of this many correlation times."""
    low, middle = ((order + j) * math.pi / times for j in (2.5, 20.5))
    return (1.0 + middle ** 2) / (1.0 + low ** 2)


def _allowance_deg2(spread: Spread, flat_ratio: float) -> float:
    """Return the allowance of S.9 if the record contradicts the statement, otherwise 0."""
    return spread._visible_allowance_deg2 if spread.r_slow > _CONTRADICTS * flat_ratio else 0.0


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


def excess(f: float, alpha: float, student_dof: float = STUDENT_DOF) -> float:
    """
    Return the distance of the upper bound from the variance, in standard errors.

    Parameters
    ----------
    f
        Degrees of freedom of the slow part, greater than 0.
    alpha
        Risk that the variance exceeds the bound; up to 0.5.
    student_dof
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


def upper_bound(spread: Spread, alpha: float) -> float:
    """
    Return the upper confidence bound of the variance.

    Parameters
    ----------
    spread
        The variance with its uncertainty.
    alpha
        Risk that the variance exceeds the bound; up to 0.5.

    Returns
    -------
    float
        Square degrees; infinite if the data set no bound, 0 if all residuals are 0.

    References
    ----------
    S.10, S.17, S.18 of ``docs/risk.md``.

    """
    if spread.d_deg2 == 0.0:
        return 0.0
    above = spread.above
    return (above.d_deg2 + above.allowance_deg2
            + above.widening * excess(above.f, alpha, above.student_dof) * above.s_deg2)


def lower_bound(spread: Spread, alpha: float) -> float:
    """Return the lower confidence bound of the variance, square degrees; S.11."""
    cv = spread.cv * math.sqrt(1.0 + 1.0 / spread.f)
    return spread.d_deg2 * math.exp(float(scipy.special.stdtrit(spread.student_dof, alpha)) * cv)


def pool(runs: Sequence[Spread], *, by_statement: bool = False) -> Spread:
    """
    Return the common variance of several runs, and how well they know it together.

    Parameters
    ----------
    runs
        One or more runs, independent of each other.
    by_statement
        Whether the upper bound may rest on the slowest error stated: each run must be at least
        20 times as long.

    References
    ----------
    S.12, S.18 of ``docs/risk.md``: the cumulants of independent runs add up.

    """
    if len(runs) == 1:
        return runs[0]
    n = sum(r.n for r in runs)
    weights = [r.n / n for r in runs]

    def mean(values: Sequence[float]) -> float:
        return math.fsum(w * value for w, value in zip(weights, values))

    d = mean([r.d_deg2 for r in runs])
    s = math.hypot(*(w * r.s_deg2 for w, r in zip(weights, runs)))
    nu, f = _pool_freedom(runs, weights, d, s)
    times = [r.times for r in runs if r.times is not None]
    pooled = Spread(
        n=n, order=max(r.order for r in runs), d_deg2=d,
        mean_variance_deg2=math.fsum(w * w * r.mean_variance_deg2 for w, r in zip(weights, runs)),
        s_deg2=s, nu=nu, f=f, corner_j=min(r.corner_j for r in runs),
        low_deg2=mean([r.low_deg2 for r in runs]), middle_deg2=mean([r.middle_deg2 for r in runs]),
        student_dof=sum(r.student_dof for r in runs), kurtosis=mean([r.kurtosis for r in runs]),
        times=min(times) if len(times) == len(runs) else None)
    if not by_statement or pooled.times is None:
        return pooled
    return replace(pooled, stated=_state_pooled(pooled, runs, times, weights))


def _pool_freedom(runs: Sequence[Spread], weights: Sequence[float], d_deg2: float, s_deg2: float,
                  ) -> tuple[float, float]:
    """Return nu and f of the common variance: its second and third cumulants add up."""
    free = math.fsum(r.n - 1 - r.order for r in runs)
    if s_deg2 <= 0.0:
        return free, free
    skewness = math.fsum((w * r.s_deg2 / s_deg2) ** 3 * math.sqrt(8.0 / r.f)
                         for w, r in zip(weights, runs))
    return 2.0 * (d_deg2 / s_deg2) ** 2, 8.0 / skewness ** 2 if skewness > 0.0 else free


def _state_pooled(pooled: Spread, runs: Sequence[Spread], times: Sequence[float],
                  weights: Sequence[float]) -> Above:
    """Return the upper bound of several runs as it rests on the slowest error stated; S.18."""
    # What mean and polynomial absorb is low where the errors are not flat over the lowest modes.
    bent_deg2 = math.fsum(w * (r.d_deg2 + (_bend(t, r.order) - 1.0) * r.absorbed_deg2)
                          for w, r, t in zip(weights, runs, times))
    ratio = math.fsum(w * _flat_ratio(t, r.order) for w, r, t in zip(weights, runs, times))
    heavy = max(1.0, pooled.kurtosis / _NORMAL_KURTOSIS)
    return Above(bent_deg2, pooled.s_deg2, pooled.f, pooled.student_dof,
                 1.0 + _POOLED_PER_TAIL * math.log(heavy), _allowance_deg2(pooled, ratio))


def _bend(times: float, order: int) -> float:
    """Return c, the power at frequency 0 over that of the modes which S.2 uses, for AR(1)."""
    modes = range(1, 1 + MEAN_DOF) if order == 0 else range(order + 1, order + 1 + _LOW_MODES)
    return len(modes) / math.fsum(1.0 / (1.0 + (j * math.pi / times) ** 2) for j in modes)


def between_runs(runs: Sequence[Spread], means_deg: Sequence[float], alpha: float) -> float:
    """
    Return an upper bound of the variance, with the slow part taken from the means of the runs.

    Parameters
    ----------
    runs
        At least 2 runs, many correlation times of the slow part apart.
    means_deg
        Their mean differences, degrees, assumed to share one expected value.
    alpha
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


def scatter_of_runs(runs: Sequence[Spread], means_deg: Sequence[float], alpha: float) -> float:
    """
    Return an upper bound of the variance from the scatter of the runs, whatever their spectra.

    Parameters
    ----------
    runs
        At least 2 runs, many correlation times of the slow part apart.
    means_deg
        Their mean differences, degrees, assumed to share one expected value.
    alpha
        Risk that the variance exceeds the bound; up to 0.5.

    Returns
    -------
    float
        Square degrees.

    References
    ----------
    S.19 of ``docs/risk.md``.

    """
    m, n = len(runs), sum(r.n for r in runs)
    weights = [r.n / n for r in runs]
    centre = math.fsum(w * mean for w, mean in zip(weights, means_deg))
    plain = math.fsum(means_deg) / m
    between = math.fsum((mean - plain) ** 2 for mean in means_deg) / (m - 1)
    squares = [r.d_deg2 - r.mean_variance_deg2 + (mean - centre) ** 2
               for r, mean in zip(runs, means_deg)]
    q = math.fsum(w * square for w, square in zip(weights, squares))
    scatter = math.sqrt(m / (m - 1) * math.fsum(
        (w * (square - q)) ** 2 for w, square in zip(weights, squares)))
    q += between * math.fsum(w * w for w in weights)
    if not scatter > 0.0:
        return q
    return q + excess(min(2.0 * (q / scatter) ** 2, pool(runs).f), alpha, m - 1) * scatter
