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
The former rule, frozen, only for comparison in the tables of docs/risk.md.

It computes the variance from octaves and from 16 to 31 blocks, and the effective degrees of
freedom from the scatter of block values and from the autocorrelation. A gate stays closed while
the slow part of the errors is not resolved. While it is closed, the rule makes no statement.
"""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.special import gammainccinv, gammaincinv, stdtrit

__all__ = ['former_rule', 'Judged']

NU_MIN, R1_MAX, SHARE_MAX = 15.0, 0.4, 0.05

_MOST_BLOCKS = 64
_SEGMENT = 1 << 17


@dataclass(frozen=True, slots=True)
class Judged:
    """Whether the gate is open, and the bounds, square degrees (given even if it is not)."""

    is_open: bool
    lower_deg2: float
    upper_deg2: float


def _join(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Join blocks in pairs; return means and inner octave variances, and the block left over."""
    m = rows.shape[1] // 2 * 2
    even, odd = rows[:, 0:m:2], rows[:, 1:m:2]
    result = np.empty((rows.shape[0] + 1, m // 2))
    np.add(even, odd, out=result[:-1])
    result[:-1] *= 0.5
    half = 0.5 * (odd[0] - even[0])
    np.multiply(half, half, out=result[-1])
    return result, rows[:, m:].copy()


def _variance(values: np.ndarray, lost: int = 1) -> float:
    centred = values - values.mean()
    return float(np.sum(centred * centred)) / (values.size - lost)


def _effective_size(x: np.ndarray) -> float:
    """Return n / tau_2 summed to the first lag W >= 10 max(tau_1, tau_2, 1), at most n/4."""
    e = x - x[0]
    e -= e.mean()
    limit = max(2, e.size // 4) - 1
    m = min(4096, limit)
    while True:
        r = _correlation(e, m)
        r[0] = 0.0
        tau_1 = 1.0 + 2.0 * np.cumsum(r)
        tau_2 = 1.0 + 2.0 * np.cumsum(r * r)
        wide = np.arange(m + 1) >= 10.0 * np.maximum(np.maximum(tau_1, tau_2), 1.0)
        found = np.flatnonzero(wide)
        if found.size or m == limit:
            return e.size / max(float(tau_2[found[0] if found.size else m]), 1.0)
        m = min(m * 8, limit)


def _correlation(e: np.ndarray, m: int) -> np.ndarray:
    power = float(np.dot(e, e))
    if power == 0.0:
        return np.zeros(m + 1)
    step = min(e.size, max(m, _SEGMENT))
    size = next_fast_len(step + m, real=True)
    spectrum = np.zeros(size // 2 + 1, dtype=np.complex128)
    for lo in range(0, e.size, step):
        left = rfft(e[lo:lo + step], size)
        np.conjugate(left, out=left)
        left *= rfft(e[lo:lo + step + m], size)
        spectrum += left
    return irfft(spectrum, size)[:m + 1] / power


def former_rule(x: np.ndarray, alpha: float, order: int = 0) -> Judged | None:
    """
    Judge one run by the former rule.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Differences in sample order, or their residuals about a polynomial.
    alpha : float
        Risk of each bound.
    order : int
        Order of that polynomial.

    Returns
    -------
    Judged or None
        None for fewer than 64 samples.

    """
    n = x.size
    if n < _MOST_BLOCKS:
        return None
    blocks, parts = (x - x[0])[np.newaxis], []
    while blocks.shape[1] >= _MOST_BLOCKS:
        blocks, left = _join(blocks)
        parts.append(left)
    level = len(parts)
    sums = [math.fsum(blocks[0]) * (1 << level)]
    sums += [float(b[0, 0]) * (1 << at) for at, b in enumerate(parts) if b.shape[1]]
    mean = math.fsum(sums) / n
    blocks16 = _join(blocks)[0]
    blocks8 = _join(blocks16)[0]

    octaves = np.zeros(level + 1)
    for at, held in ((level, blocks), *reversed(list(enumerate(parts)))):
        if held.shape[1]:
            octaves[:at] += held[1:].sum(axis=1) * 2.0 ** (at - np.arange(1, at + 1))
    octaves[level] = blocks16[-1].sum()
    pairs = n >> np.arange(1, level + 2)
    octaves /= pairs
    slow_dof = blocks16.shape[1] - 1 - order
    slow = _variance(blocks16[0], lost=1 + order)
    d_hat = float(octaves.sum()) + slow

    def scatter(held: np.ndarray) -> float:
        squares = held[1:].sum(axis=0) + (held[0] - mean) ** 2
        size = 1 << (held.shape[0] - 1)
        return _variance(squares / d_hat) * size / n if d_hat > 0.0 else 0.0

    largest = max(scatter(blocks8), scatter(blocks16), scatter(blocks))
    nu = min(2.0 / largest if largest > 0.0 else math.inf, _effective_size(x),
             float(n - 1 - order))
    c = blocks[0] - blocks[0].mean()
    power = float(np.sum(c * c))
    r1 = float(np.sum(c[:-1] * c[1:])) / power if power > 0.0 else 0.0
    share = power / (c.size - 1) / d_hat if d_hat > 0.0 else 0.0
    is_open = nu >= NU_MIN and not (r1 > R1_MAX and share > SHARE_MAX)
    variances, dof = np.append(octaves, slow), np.append(pairs, slow_dof)
    return Judged(is_open, *_bounds(d_hat, variances, dof, slow_dof, nu, alpha))


def _bounds(d_hat: float, variances: np.ndarray, dof: np.ndarray, slow_dof: int, nu: float,
            alpha: float) -> tuple[float, float]:
    """Return L and U: the wider of Graybill & Wang 1980 and Wilson & Hilferty 1931."""
    above = (dof / (2.0 * gammaincinv(0.5 * dof, alpha)) - 1.0) * variances
    below = (1.0 - dof / (2.0 * gammainccinv(0.5 * dof, alpha))) * variances
    h = 2.0 / (9.0 * nu)
    reach = float(stdtrit(slow_dof, alpha)) * math.sqrt(h)
    low, high = 1.0 - h - reach, 1.0 - h + reach
    lower = max(0.0, min(d_hat - math.sqrt(float(np.sum(below * below))),
                         d_hat / low ** 3 if low > 0.0 else 0.0))
    if d_hat > 0.0 and high <= 0.0:
        return lower, math.inf
    return lower, max(d_hat + math.sqrt(float(np.sum(above * above))),
                      d_hat / high ** 3 if d_hat > 0.0 else 0.0)
