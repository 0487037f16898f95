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

"""How the difference depends on the heading: deviation coefficients."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Iterator

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.angles import unwrap_deg, wrap360
from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.records import Reals
from heading_intercompare.core.statistics.autocorrelation import sokal_times
from heading_intercompare.core.statistics.blocking import block_means, block_size

_WORST_CONDITION = 1e4
"""Largest condition number with coefficients; headings all round the compass give 2."""

_WIDEST_ARC_DEG = 120.0
"""Widest arc without a heading that a fit bridges."""

_TERMS = 5
#: Samples processed at once. They fit into the cache, and BLAS computes their products in one
#: thread: on a busy machine, several threads would wait for each other.
_PIECE = 1 << 13
_LEAST_SAMPLES = 64
_TURNS = 4.0
_OUTLAST = 0.03
_WIDER = 60.0
_LOOKED_AT = 1 << 14
_CELLS = 1 << 16

#: Errors outlast the turns if the ship makes fewer than four full turns, and they change too
#: slowly to be told from a dependence on the heading.
_REASONS = {'insufficient_data': 'too few differences', 'headings_too_narrow': 'too few headings',
            'errors_outlast_the_turns': 'the errors outlast the turns'}


@dataclass(frozen=True, slots=True)
class HeadingDependence:
    """x = A + B sin(psi) + C cos(psi) + D sin(2 psi) + E cos(2 psi); keys of the JSON."""

    n: int = figure('differences')
    reason: str = figure('why it could not be fitted', 'empty if it could', choices=_REASONS)
    empty_arc_deg: float | None = figure('largest arc without a heading', 'of the RS')
    condition: float | None = figure('condition number of the fit', 'above 10⁴ it is rejected; '
                                     'null for fewer than 64 differences')
    coefficients_deg: tuple[float, ...] | None = figure(
        'A to E, with their standard uncertainties', 'B and C are semicircular, D and E '
        'quadrantal; null with a `reason`, as all that follow', default=None, u='u_deg')
    u_deg: tuple[float, ...] | None = figure('standard uncertainties of A to E', default=None)
    covariance_deg2: tuple[tuple[float, ...], ...] | None = figure(
        'covariance of the coefficients, five rows', default=None)
    amplitude_deg: float | None = figure('largest departure from A', default=None)
    f: float | None = figure('F statistic of B to E being zero', default=None)
    p: float | None = figure('its probability', default=None)
    residual_std_deg: float | None = figure('standard deviation about the fit', default=None)


def largest_empty_arc(heading_deg: ArrayLike) -> float | None:
    """
    Return the largest arc without a heading.

    Parameters
    ----------
    heading_deg : array_like, shape (n,)
        Degrees, finite, in any order.

    Returns
    -------
    float or None
        Degrees; 360 if all headings are equal, None for n = 0.

    Examples
    --------
    >>> largest_empty_arc([350.0, 10.0, 100.0])
    250.0

    """
    heading = wrap360(heading_deg)
    if not heading.size:
        return None
    return _sort_all(heading) if heading.size < _CELLS else _sort_beside_arcs(heading)


def _sort_all(heading: np.ndarray) -> float:
    """Return the largest gap between neighbouring headings."""
    heading = np.sort(heading)
    over_north = float(heading[0]) + 360.0 - float(heading[-1])
    return max(over_north, float(np.diff(heading).max(initial=0.0)))


def _sort_beside_arcs(heading: np.ndarray) -> float:
    """Return the same, but sort only the headings that the largest gap may lie between."""
    cell = (heading * (_CELLS / 360.0)).astype(np.int64)
    np.minimum(cell, _CELLS - 1, out=cell)
    full = np.zeros(_CELLS, bool)
    full[cell] = True
    where = np.flatnonzero(full)
    after = np.zeros(_CELLS, np.int64)
    after[where] = np.roll(where, -1)
    empty = np.diff(where, append=where[0] + _CELLS) - 1
    # A gap is longer than its empty cells, by at most the two cells that it begins and ends in.
    most = int(empty.max())
    if most < 2:
        return _sort_all(heading)
    begins = where[empty >= most - 2]
    full[:] = False
    full[begins] = full[after[begins]] = True
    heading = np.sort(heading[full[cell]])
    cell = np.minimum((heading * (_CELLS / 360.0)).astype(np.int64), _CELLS - 1)
    beside = (cell[1:] == cell[:-1]) | (cell[1:] == after[cell[:-1]])
    gap = float(np.diff(heading)[beside].max(initial=0.0))
    if after[cell[-1]] == cell[0]:
        gap = max(gap, float(heading[0]) + 360.0 - float(heading[-1]))
    return gap


def _basis(heading_deg: np.ndarray) -> np.ndarray:
    """Return the five terms, one row each."""
    psi = np.radians(heading_deg)
    terms = np.empty((_TERMS, psi.size))
    terms[0] = 1.0
    sine, cosine = np.sin(psi, out=terms[1]), np.cos(psi, out=terms[2])
    terms[3] = 2.0 * sine * cosine
    terms[4] = (cosine - sine) * (cosine + sine)
    return terms


def _pieces(n: int) -> Iterator[slice]:
    for lo in range(0, n, _PIECE):
        yield slice(lo, min(n, lo + _PIECE))


def fit_deviation(x_deg: ArrayLike, rs_deg: ArrayLike, *, averaged: int = 1,
                  within_deg2: float = 0.0) -> HeadingDependence:
    """
    Fit the deviation coefficients of a run.

    Parameters
    ----------
    x_deg, rs_deg : array_like, shape (n,)
        Differences and headings of the RS, in sample order, finite, degrees.
    averaged
        Number of samples that each of these averages.
    within_deg2
        Mean square of those samples about their averages, square degrees.

    Returns
    -------
    HeadingDependence
        Without coefficients for fewer than 64 samples, or if the headings cover too narrow an
        arc to tell the five terms apart.

    Notes
    -----
    The covariance is G^-1 S G^-1, with S from the scatter of the block means of each term times
    the residual, so it stays valid for correlated errors. The fit takes five of the 16 to 31
    degrees of freedom of the blocks, one for each term; the joint test allows for this
    (Hotelling).

    If the ship made fewer than four full turns, the terms are as slow as the blocks, and the
    scatter of the block means is too small. The covariance is then multiplied by
    1 + 60 r max(1, 2.5 / k), where k is the number of turns and r the correlation time of the
    residuals over the length of the run. This gives intervals of 90 to 99 % (measured, AR(1) over
    20 to 200 correlation times). Above r = 0.03 k, at most 0.06, there are no coefficients.

    References
    ----------
    The coefficients A to E of the compass adjuster; E.7 of ``docs/diagnostics.md``.

    """
    x, psi = np.asarray(x_deg, dtype=np.float64), np.asarray(rs_deg, dtype=np.float64)
    n = x.size
    arc = largest_empty_arc(psi)
    if n < _LEAST_SAMPLES:
        return HeadingDependence(n=averaged * n, reason='insufficient_data', empty_arc_deg=arc,
                                 condition=None)
    size = block_size(n, 16)
    first = float(x[0])
    gram, right = np.zeros((_TERMS, _TERMS)), np.zeros(_TERMS)
    for part in _pieces(n):
        basis = _basis(psi[part])
        gram += basis @ basis.T
        right += basis @ (x[part] - first)
    condition = float(np.linalg.cond(gram / n))
    if not condition <= _WORST_CONDITION:
        return HeadingDependence(n=averaged * n, reason='headings_too_narrow', empty_arc_deg=arc,
                                 condition=condition if math.isfinite(condition) else None)
    beta = np.linalg.solve(gram, right)
    ends = unwrap_deg(psi)[::max(1, block_size(n, _LEAST_SAMPLES))]
    turns = float(np.abs(np.diff(ends)).sum()) / 360.0
    left = np.empty(n if turns < _TURNS else 0)
    sums, rss = [], 0.0
    # Both are powers of two: a block holds whole pieces, or a piece holds whole blocks.
    unit = min(size, _PIECE)
    for part in _pieces(n):
        basis = _basis(psi[part])
        residual = x[part] - first - beta @ basis
        rss += float(residual @ residual)
        if left.size:
            left[part] = residual
        whole = residual.size // unit
        basis *= residual
        sums.append(basis[:, :whole * unit].reshape(_TERMS, whole, unit).sum(axis=2))
    units = np.concatenate(sums, axis=1)
    whole = units.shape[1] // (size // unit)
    means = units[:, :whole * (size // unit)].reshape(_TERMS, whole, -1).sum(axis=2).T / size
    dof = means.shape[0] - _TERMS
    inverse = np.linalg.inv(gram)
    scatter = np.cov(means, rowvar=False) * ((means.shape[0] - 1) / dof)
    widening = _widening(left, turns)
    if widening is None:
        return HeadingDependence(n=averaged * n, reason='errors_outlast_the_turns',
                                 empty_arc_deg=arc, condition=condition)
    covariance = widening * (inverse @ (n * size * scatter) @ inverse)
    covariance = 0.5 * (covariance + covariance.T)
    f, p = _joint(beta[1:], covariance[1:, 1:], dof)
    around = beta[1:] @ _basis(np.arange(0.0, 360.0, 0.5))[1:]
    beta[0] += first
    rss = averaged * (rss + n * within_deg2)
    return HeadingDependence(
        n=averaged * n, reason='', empty_arc_deg=arc, condition=condition,
        coefficients_deg=tuple(beta.tolist()),
        u_deg=tuple(np.sqrt(np.maximum(np.diag(covariance), 0.0)).tolist()),
        covariance_deg2=tuple(tuple(row) for row in covariance.tolist()),
        amplitude_deg=float(np.abs(around).max()), f=f, p=p,
        residual_std_deg=math.sqrt(rss / (averaged * n - _TERMS)))


def holds_all_round(dependence: HeadingDependence) -> bool:
    """Tell whether the fit holds on every heading: at most 120 deg of the compass are empty."""
    return (dependence.coefficients_deg is not None
            and (dependence.empty_arc_deg or 0.0) <= _WIDEST_ARC_DEG)


def deviation_at(dependence: HeadingDependence, heading_deg: ArrayLike) -> tuple[Reals, Reals]:
    """
    Return what the fit gives at some headings: the rows of a deviation card.

    Parameters
    ----------
    dependence
        The fitted harmonics.
    heading_deg : array_like, shape (n,)
        Degrees.

    Returns
    -------
    x_deg, u_deg : ndarray, shape (n,)
        Fitted TS - RS and its standard uncertainty, degrees; nan without coefficients.

    """
    psi = np.ravel(np.asarray(heading_deg, dtype=np.float64))
    if dependence.coefficients_deg is None or dependence.covariance_deg2 is None:
        return np.full(psi.size, np.nan), np.full(psi.size, np.nan)
    basis, covariance = _basis(psi), np.array(dependence.covariance_deg2)
    variance = np.einsum('in,ij,jn->n', basis, covariance, basis)
    return np.array(dependence.coefficients_deg) @ basis, np.sqrt(np.maximum(variance, 0.0))


def _widening(residual: np.ndarray, turns: float) -> float | None:
    """Return the factor by which few turns make the covariance too small; None if too large."""
    if turns >= _TURNS:
        return 1.0
    every = max(1, residual.size // _LOOKED_AT)
    if every > 1:
        residual = block_means(residual, every)
    ratio = sokal_times(residual).tau_1 / residual.size
    if ratio > _OUTLAST * min(2.0, turns):
        return None
    return float(1.0 + _WIDER * max(1.0, 2.5 / turns) * ratio)


def _joint(beta: np.ndarray, covariance: np.ndarray,
           dof: int) -> tuple[float | None, float | None]:
    """Return F and p of all coefficients being zero; None if the residuals are only rounding."""
    scale = np.sqrt(np.diag(covariance))
    if not (scale > 1e-13 * (1.0 + np.abs(beta))).all():
        return None, None
    standard = covariance / np.outer(scale, scale)
    z = beta / scale
    q = beta.size
    square = float(z @ np.linalg.lstsq(standard, z, rcond=None)[0])
    f = square * (dof - q + 1) / (dof * q)
    return f, float(scipy.special.fdtrc(q, dof - q + 1, f))
