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
Distributions of the difference TS - RS, and their coverage factors K(P).

A model is named by two letters, TS then RS: N normal, U uniform. Everything here refers to the
difference divided by its standard deviation, so all models have variance 1.
"""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Callable

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.records import Reals
from heading_intercompare.core.statistics.quadrature import gauss_legendre
from heading_intercompare.core.statistics.root_finding import find_root

_SQRT3 = math.sqrt(3.0)
_NEGLIGIBLE = 1e-150


@dataclass(frozen=True, slots=True)
class ErrorModel:
    """
    One pair of error distributions.

    Attributes
    ----------
    description
        The distributions in words.
    factor : callable (ts, rs, p) -> float
        Two-sided quantile; `ts` and `rs` are the standard deviations of the two parts, whose
        squares add to 1.
    tail : callable (ts, rs, k) -> ndarray
        Probability of an absolute value above k, for k >= 0.
    density : callable (ts, rs, z) -> ndarray
        Probability density at z.
    ts_factor : callable (p) -> float
        Two-sided quantile of the TS error alone, in its own standard deviations.

    """

    description: str
    factor: Callable[[float, float, float], float]
    tail: Callable[[float, float, np.ndarray], np.ndarray]
    density: Callable[[float, float, np.ndarray], np.ndarray]
    ts_factor: Callable[[float], float]


def _normal_factor(p: float) -> float:
    return float(-scipy.special.ndtri(0.5 * (1.0 - p)))


def _uniform_factor(p: float) -> float:
    return p * _SQRT3


def _phi(z: Reals) -> Reals:
    density: Reals = np.exp(-0.5 * z * z) / math.sqrt(2.0 * math.pi)
    return density


def _partial_expectation(z: Reals) -> Reals:
    """Return H(z) = phi(z) - z Q(z) without cancellation for negative z."""
    y = np.minimum(np.abs(z), 1e3)
    h = _phi(y) * (1.0 - y * math.sqrt(0.5 * math.pi) * scipy.special.erfcx(y / math.sqrt(2.0)))
    result: Reals = np.maximum(-z, 0.0) + h
    return result


def _mixed_tail(normal: float, uniform: float, k: Reals) -> Reals:
    """Return the tail of a normal plus a uniform part of these standard deviations; K.2."""
    w = _SQRT3 * uniform
    if normal < _NEGLIGIBLE:
        return np.maximum(0.0, 1.0 - k / w)
    h, z = w / normal, k / normal
    if h < 2.0:
        nodes, weights = gauss_legendre(40)
        mean: Reals = scipy.special.ndtr(-(z[..., np.newaxis] + h * nodes)) @ weights
        return mean
    return (_partial_expectation(z - h) - _partial_expectation(z + h)) / h


def _mixed_density(normal: float, uniform: float, z: np.ndarray) -> np.ndarray:
    w, z = _SQRT3 * uniform, np.abs(z)
    if normal < _NEGLIGIBLE:
        return np.where(z <= w, 0.5 / w, 0.0)
    if w < 1e-6 * normal:
        return _phi(z / normal) / normal
    low, high = scipy.special.ndtr(-(z + w) / normal), scipy.special.ndtr(-(z - w) / normal)
    density: Reals = (high - low) / (2.0 * w)
    return density


def _mixed_factor(normal: float, uniform: float, p: float) -> float:
    if normal < _NEGLIGIBLE:
        return _uniform_factor(p)
    if uniform < _NEGLIGIBLE:
        return _normal_factor(p)

    def excess(k: float) -> float:
        return float(_mixed_tail(normal, uniform, np.asarray(k))) / (1.0 - p) - 1.0

    return find_root(excess, 0.0, _SQRT3 * uniform + 40.0 * normal, tolerance=1e-15)


def _half_widths(ts: float, rs: float) -> tuple[float, float]:
    return _SQRT3 * max(ts, rs), _SQRT3 * min(ts, rs)


def _trapezoid_factor(ts: float, rs: float, p: float) -> float:
    """Return the factor by K.1: on the flank or on the plateau of the trapezoid."""
    w1, w2 = _half_widths(ts, rs)
    if (1.0 - p) * w1 <= w2:
        return w1 + w2 - 2.0 * math.sqrt((1.0 - p) * w1 * w2)
    return p * w1


def _trapezoid_tail(ts: float, rs: float, k: np.ndarray) -> np.ndarray:
    w1, w2 = _half_widths(ts, rs)
    plateau = 1.0 - k / w1
    if w2 < _NEGLIGIBLE:
        return np.maximum(0.0, plateau)
    flank = np.maximum(0.0, w1 + w2 - k)
    return np.where(k <= w1 - w2, plateau, flank * (flank / w2) / (4.0 * w1))


def _trapezoid_density(ts: float, rs: float, z: np.ndarray) -> np.ndarray:
    w1, w2 = _half_widths(ts, rs)
    z = np.abs(z)
    if w2 < _NEGLIGIBLE:
        return np.where(z <= w1, 0.5 / w1, 0.0)
    flank = np.maximum(0.0, w1 + w2 - z)
    return np.where(z <= w1 - w2, 0.5 / w1, flank / w2 / (4.0 * w1))


ERROR_MODELS: dict[str, ErrorModel] = {
    'NN': ErrorModel('TS normal, RS normal',
                     lambda ts, rs, p: _normal_factor(p),
                     lambda ts, rs, k: 2.0 * scipy.special.ndtr(-k),
                     lambda ts, rs, z: _phi(z),
                     _normal_factor),
    'UN': ErrorModel('TS uniform, RS normal',
                     lambda ts, rs, p: _mixed_factor(rs, ts, p),
                     lambda ts, rs, k: _mixed_tail(rs, ts, k),
                     lambda ts, rs, z: _mixed_density(rs, ts, z),
                     _uniform_factor),
    'NU': ErrorModel('TS normal, RS uniform',
                     lambda ts, rs, p: _mixed_factor(ts, rs, p),
                     lambda ts, rs, k: _mixed_tail(ts, rs, k),
                     lambda ts, rs, z: _mixed_density(ts, rs, z),
                     _normal_factor),
    'UU': ErrorModel('TS uniform, RS uniform',
                     _trapezoid_factor, _trapezoid_tail, _trapezoid_density, _uniform_factor),
}
"""The models by name: TS letter, RS letter."""


def _model(name: str) -> ErrorModel:
    if name not in ERROR_MODELS:
        raise ValueError(f'model = {name!r}: must be one of {", ".join(ERROR_MODELS)}')
    return ERROR_MODELS[name]


def _parts(ratio: float) -> tuple[float, float]:
    """Return the standard deviations of the TS and RS parts when their squares add to 1."""
    if not ratio >= 0.0:
        raise ValueError(f'ratio = {ratio!r}: must be at least 0')
    if math.isinf(ratio):
        return 0.0, 1.0
    total = math.hypot(1.0, ratio)
    return 1.0 / total, ratio / total


def _probability(p: float) -> float:
    if not 0.0 < p < 1.0:
        raise ValueError(f'p = {p!r}: must be between 0 and 1')
    return p


def coverage_factor(model: str, ratio: float, p: float) -> float:
    """
    Return K(P): the difference is within K standard deviations with probability P.

    Parameters
    ----------
    model : {'NN', 'UN', 'NU', 'UU'}
        Distributions of the TS and the RS error.
    ratio
        sigma_ref / sigma, RS over TS; 0 to infinity, both included.
    p
        Confidence probability P, between 0 and 1.

    Returns
    -------
    float
        Two-sided quantile of (x - a) / sqrt(sigma^2 + sigma_ref^2); dimensionless.

    Raises
    ------
    ValueError
        If a parameter is outside its range.

    Notes
    -----
    Normal: -Phi^-1((1 - P) / 2). Two uniform parts: the trapezoid in closed form. Normal and
    uniform: root of the tail, which is a difference of partial expectations of the normal
    distribution or, where those would cancel, a Gauss-Legendre sum. Relative error below 1e-13.

    References
    ----------
    GK (2)-(2d) for the models, GK (*), (**) for the use; K.1 (two uniform parts) and K.2 (normal
    and uniform) of ``docs/equations.md``.

    Examples
    --------
    >>> round(coverage_factor('NN', 0.5, 0.997), 9)
    2.967737925
    >>> round(coverage_factor('UU', 1.0, 0.95), 9)
    1.901767185

    """
    ts, rs = _parts(ratio)
    return _model(model).factor(ts, rs, _probability(p))


def ts_factor(model: str, p: float) -> float:
    """
    Return K(P) of the TS error alone, in its own standard deviations.

    Parameters
    ----------
    model : {'NN', 'UN', 'NU', 'UU'}
        Distributions of the TS and the RS error; the first letter counts.
    p
        Confidence probability P, between 0 and 1.

    Returns
    -------
    float
        The normal quantile, or P sqrt(3) for a uniform TS error.

    References
    ----------
    GK (7), whose root is already the TS standard deviation.

    Examples
    --------
    >>> round(ts_factor('UN', 0.997), 6)
    1.726855

    """
    return _model(model).ts_factor(_probability(p))


def tail(model: str, ratio: float, k: ArrayLike) -> np.ndarray:
    """
    Return the probability that a difference deviates by more than k standard deviations.

    Parameters
    ----------
    model, ratio
        As for `coverage_factor`.
    k : array_like, shape (n,) or scalar
        Limit in standard deviations of the difference, at least 0.

    Returns
    -------
    ndarray, shape of `k`
        ``P(|x - a| > k sqrt(sigma^2 + sigma_ref^2))``, with good relative accuracy far into the
        tail.

    """
    ts, rs = _parts(ratio)
    return np.asarray(_model(model).tail(ts, rs, np.abs(np.asarray(k, dtype=np.float64))))


def density(model: str, ratio: float, z: ArrayLike) -> np.ndarray:
    """
    Return the probability density of the normalised difference.

    Parameters
    ----------
    model, ratio
        As for `coverage_factor`.
    z : array_like, shape (n,) or scalar
        (x - a) / sqrt(sigma^2 + sigma_ref^2).

    Returns
    -------
    ndarray, shape of `z`
        Density per standard deviation; divide by the standard deviation for density per degree.

    """
    ts, rs = _parts(ratio)
    return np.asarray(_model(model).density(ts, rs, np.asarray(z, dtype=np.float64)))
