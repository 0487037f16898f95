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

"""The drift of the differences: polynomial fits, the choice of their order, and the slope."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Iterator

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.records import Reals

from .autocorrelation import sokal_times
from .blocking import Averages, block_means, block_size, student_95
from .cells import Cells
from .moments import Moments, sum_products
from .variance_uncertainty import estimate_spread, MEAN_DOF, Spread

_HIGHEST_ORDER = 3
"""Highest order of a polynomial that may be removed."""

#: Rows per product, few enough that BLAS stays in one thread, as in `deviation`.
_PIECE = 1 << 13
_LEAST_BLOCKS = 64


@dataclass(frozen=True, slots=True, eq=False)
class Polynomial:
    """
    A polynomial in time, and the differences without it.

    Attributes
    ----------
    order
        Its order; lower than requested if there are fewer than order + 2 samples.
    coefficients_deg
        Coefficients of the Legendre polynomials P_0 to P_order of
        u = (2t - t_1 - t_n)/(t_n - t_1), degrees; that of P_0 is close to the mean. Empty for
        n = 0.
    residual_deg : ndarray, shape (n,)
        Differences minus the polynomial, degrees.

    """

    order: int
    coefficients_deg: tuple[float, ...]
    residual_deg: np.ndarray


def _pieces(n: int) -> Iterator[slice]:
    for lo in range(0, n, _PIECE):
        yield slice(lo, lo + _PIECE)


def _bases(stamp_ns: np.ndarray, order: int) -> Iterator[tuple[slice, np.ndarray]]:
    """Yield pieces of a record, and the polynomials of its time scaled to [-1, 1] there."""
    span = int(stamp_ns[-1]) - int(stamp_ns[0])
    for piece in _pieces(stamp_ns.size):
        u: Reals = (stamp_ns[piece] - stamp_ns[0]).astype(np.float64)
        yield piece, _legendre(2.0 * u / span - 1.0 if span else u, order)


def _legendre(u: np.ndarray, order: int) -> np.ndarray:
    """Return the Legendre polynomials of orders 0 to `order`, one row each."""
    rows = np.ones((order + 1, u.size))
    if order:
        rows[1] = u
    for k in range(2, order + 1):
        np.multiply(u, rows[k - 1], out=rows[k])
        rows[k] *= (2 * k - 1) / k
        rows[k] -= (k - 1) / k * rows[k - 2]
    return rows


def remove_polynomial(stamp_ns: ArrayLike, x_deg: ArrayLike, order: int) -> Polynomial:
    """
    Subtract the best-fitting polynomial from differences.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps in increasing order, nanoseconds.
    x_deg : array_like, shape (n,)
        Differences, finite, degrees.
    order
        From 0 (the mean) to 3.

    Returns
    -------
    Polynomial
        Least squares at the actual stamps.

    Raises
    ------
    ValueError
        If the order is not from 0 to 3.

    References
    ----------
    GK models x as drift plus a stationary process; this form of the drift is E.2 of
    ``docs/diagnostics.md``.

    Examples
    --------
    >>> fit = remove_polynomial([0, 1, 2, 3], [1.0, 2.0, 3.0, 4.0], 1)
    >>> [round(c, 9) for c in fit.coefficients_deg]
    [2.5, 1.5]

    """
    if not 0 <= order <= _HIGHEST_ORDER:
        raise ValueError(f'order = {order!r}: must be from 0 to {_HIGHEST_ORDER}')
    stamps, x = np.asarray(stamp_ns), np.asarray(x_deg, dtype=np.float64)
    if not x.size:
        return Polynomial(0, (), x.copy())
    order = max(0, min(order, x.size - 2))
    first = float(x[0])
    residual = x - first
    gram, right = np.zeros((order + 1, order + 1)), np.zeros(order + 1)
    for piece, basis in _bases(stamps, order):
        gram += basis @ basis.T
        right += basis @ residual[piece]
    coefficients = np.linalg.lstsq(gram, right, rcond=None)[0]
    right = np.zeros(order + 1)
    for piece, basis in _bases(stamps, order):
        part = residual[piece]
        part -= coefficients @ basis
        right += basis @ part
    # A second pass removes the rounding error of the normal equations.
    correction = np.linalg.lstsq(gram, right, rcond=None)[0]
    for piece, basis in _bases(stamps, order):
        residual[piece] -= correction @ basis
    coefficients += correction
    coefficients[0] += first
    return Polynomial(order, tuple(coefficients.tolist()), residual)


@dataclass(frozen=True, slots=True)
class Order:
    """The polynomial order that the drift of a run needs."""

    order: int = figure('order of the polynomial that the differences call for',
                        "0 to 3, by Schwarz's criterion on block means")
    bic: tuple[float | None, ...] = figure("Schwarz's criterion of orders 0 to 4",
                                           'null if a fit leaves no residual')
    blocks: int = figure('block means that the order is chosen by', '64 to 127')
    beyond: bool = figure('a higher order would fit better still', 'order 4')


def bic_of(rss: float, blocks: int, parameters: int, floor: float) -> float:
    """Return Schwarz's criterion; minus infinity if the residuals are only rounding errors."""
    if rss <= floor:
        return -math.inf
    return blocks * math.log(rss / blocks) + parameters * math.log(blocks)


def rounding_floor(values: np.ndarray) -> float:
    """Return the residual sum of squares that rounding alone would leave."""
    largest = max(-float(values.min()), float(values.max()))
    return values.size * (1e-13 * (1.0 + largest)) ** 2


def average_blocks(stamp_ns: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
    """Return times (s after the first stamp), values and size of 64 to 127 block means."""
    size = block_size(x.size, _LEAST_BLOCKS)
    # One block after the other, so that the times of a long run stay in the cache.
    blocks = stamp_ns[:x.size // size * size].reshape(-1, size)
    t_s = np.array([float(((block - stamp_ns[0]) / 1e9).mean()) for block in blocks])
    return t_s, block_means(x, size), size


def select_order(stamp_ns: ArrayLike, x_deg: ArrayLike) -> Order | None:
    """
    Choose the polynomial order that the drift of a run needs.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps in increasing order, nanoseconds.
    x_deg : array_like, shape (n,)
        Differences, finite, degrees.

    Returns
    -------
    Order or None
        None for fewer than 64 samples.

    Notes
    -----
    Fits the means of 64 to 127 blocks, whose residuals are nearly white; on raw correlated
    samples the criterion overfits. It still mistakes a correlation longer than about a hundredth
    of the run for drift.

    References
    ----------
    Schwarz 1978: B ln(RSS/B) + (p + 2) ln B; E.2 of ``docs/diagnostics.md``.

    """
    stamps, x = np.asarray(stamp_ns), np.asarray(x_deg, dtype=np.float64)
    if x.size < _LEAST_BLOCKS or stamps[-1] == stamps[0]:
        return None
    t, z, _ = average_blocks(stamps, x)
    z = z - z.mean()
    u = 2.0 * (t - t[0]) / (t[-1] - t[0]) - 1.0
    basis = np.polynomial.legendre.legvander(u, _HIGHEST_ORDER + 1)
    floor = rounding_floor(x)
    values = []
    for p in range(_HIGHEST_ORDER + 2):
        part = basis[:, :p + 1]
        left = z - part @ np.linalg.lstsq(part, z, rcond=None)[0]
        values.append(bic_of(float(left @ left), z.size, p + 2, floor))
    order = int(np.argmin(values[:_HIGHEST_ORDER + 1]))
    return Order(order, tuple(v if math.isfinite(v) else None for v in values), z.size,
                 values[-1] < values[order])


@dataclass(frozen=True, slots=True)
class Detrended:
    """
    Differences minus a polynomial in time.

    Attributes
    ----------
    averages
        The differences, which a long record averages over short blocks.
    polynomial
        The polynomial that fits the averages, and the residuals.
    found
        Spread of the differences about the polynomial; None for fewer than 128.

    """

    averages: Averages
    polynomial: Polynomial
    found: Spread | None

    @classmethod
    def of(cls, averages: Averages, order: int) -> 'Detrended':
        """Subtract a polynomial from differences, as `remove_polynomial` does."""
        fit = remove_polynomial(averages.stamp_ns, averages.x_deg, order)
        values = averages.with_noise(Cells.of(fit.residual_deg, averages.stamp_ns).values())
        return cls(averages, fit, None if values is None else estimate_spread(values, fit.order))

    @property
    def rss_deg2(self) -> float:
        """Sum of the squared residuals of all differences, square degrees."""
        residual, size = self.polynomial.residual_deg, self.averages.size
        return (size * sum_products(residual, residual)
                + self.averages.n * self.averages.within_deg2)


def drift_left_deg2(rest: Detrended) -> float | None:
    """
    Return an upper bound of the variance that a drift adds if it is not removed.

    Parameters
    ----------
    rest
        Differences minus the polynomial that describes the drift, of order 1 or higher.

    Returns
    -------
    float or None
        One-sided 95 % bound, square degrees; None for fewer than 128 differences.

    Notes
    -----
    The term of order k has the variance c_k^2 / (2k + 1), where c_k is its Legendre coefficient.
    Without a drift, the errors alone make that as large as the variance v of the mean, S.1. The
    bound is (r + t sqrt(v))^2, with the variance r^2 of all terms and Student's t.

    References
    ----------
    S.16 of ``docs/risk.md``.

    """
    fit, spread = rest.polynomial, rest.found
    if spread is None:
        return None
    r = math.sqrt(math.fsum(c * c / (2 * k + 1) for k, c in enumerate(fit.coefficients_deg)
                            if k > 0))
    t = -float(scipy.special.stdtrit(MEAN_DOF, 0.05))
    return (r + t * math.sqrt(spread.mean_variance_deg2)) ** 2


@dataclass(frozen=True, slots=True)
class Slope:
    """A straight line through the differences."""

    slope_deg_per_h: float = figure('slope, with its standard uncertainty', u='u_deg_per_h')
    intercept_deg: float = figure('value of the line at the first difference')
    u_naive_deg_per_h: float | None = figure(
        'uncertainty of the slope if the errors were uncorrelated', 'null for n < 3')
    u_deg_per_h: float | None = figure('standard uncertainty of the slope', 'from the power of '
                                       'the residuals at the lowest half-periods')
    interval_deg_per_h: tuple[float, float] | None = figure('95 % interval of the slope')
    tau_samples: float = figure('correlation time about the line', unit='readings')
    residual_std_deg: float | None = figure('standard deviation about the line')


def fit_slope(stamp_ns: ArrayLike, x_deg: ArrayLike,
              line: Detrended | None = None) -> Slope | None:
    """
    Return the slope of the differences and how well it is known.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps in increasing order, nanoseconds.
    x_deg : array_like, shape (n,)
        Differences, finite, degrees.
    line
        The differences minus a polynomial of order 1, if already known.

    Returns
    -------
    Slope or None
        None for n < 2.

    Notes
    -----
    A long record is averaged over the blocks of `Averages`.

    References
    ----------
    Ordinary least squares. The variance of the slope is 12 v over the square of the span, with
    the variance v of the mean by S.1. Correlation time with the window of Sokal 1997.

    """
    averages = Averages.of(stamp_ns, x_deg) if line is None else line.averages
    stamps, x, n = averages.stamp_ns, averages.x_deg, averages.n
    if n < 2 or stamps[-1] == stamps[0]:
        return None
    span_h = float((stamps[-1] - stamps[0]) / 3.6e12)
    if n < 3:
        b = float(x[1] - x[0]) / span_h
        return Slope(slope_deg_per_h=b, intercept_deg=float(x[0]), u_naive_deg_per_h=None,
                     u_deg_per_h=None, interval_deg_per_h=None, tau_samples=1.0,
                     residual_std_deg=None)
    line = Detrended.of(averages, 1) if line is None else line
    level, tilt = line.polynomial.coefficients_deg
    b = 2.0 * tilt / span_h
    residual, rss = line.polynomial.residual_deg, line.rss_deg2
    tau = sokal_times(residual).tau_1
    if averages.size > 1 and rss > 0.0:
        # The variance of the mean is the same: v tau / n.
        tau *= averages.size ** 2 * sum_products(residual, residual) / rss
    times_h = (Moments.of((stamps[piece] - stamps[0]) / 3.6e12) for piece in _pieces(x.size))
    moved = sum(times_h, start=Moments())
    naive = math.sqrt(rss / (n - 2) / (averages.size * moved.m2_deg2))
    u, dof = naive * math.sqrt(max(1.0, tau)), n - 2
    if line.found is not None:
        u, dof = math.sqrt(12.0 * line.found.mean_variance_deg2) / span_h, MEAN_DOF
    half = student_95(dof) * u
    return Slope(slope_deg_per_h=b, intercept_deg=level - tilt, u_naive_deg_per_h=naive,
                 u_deg_per_h=u, interval_deg_per_h=(b - half, b + half), tau_samples=tau,
                 residual_std_deg=math.sqrt(rss / (n - 1)))
