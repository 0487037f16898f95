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

"""The end of warm-up: an exponential fitted to the differences, and an independent check."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.records import Integers, Reals

from .drift import average_blocks, bic_of, rounding_floor, select_order

_GRID = 400
_FINER = 41
_EXACT = 1e-10
_LEAST_SAMPLES = 64

CLEAR = 10.0
"""Margin of Schwarz's criterion by which the exponential must beat a constant."""


@dataclass(frozen=True, slots=True)
class WarmUp:
    """An exponential warm-up, x = level + amplitude exp(-(t - t_1)/tau)."""

    level_deg: float = figure('warm-up: final level')
    amplitude_deg: float = figure('warm-up: amplitude')
    tau_s: float = figure('warm-up: time constant', 'from a hundredth of the run to the run')
    tolerance_deg: float = figure('warm-up: remainder that is tolerated', 'a tenth of sigma_max')
    settle_s: float = figure('warm-up: time until then', 'after the first difference; 0 if the '
                             'amplitude is tolerated; meaningless unless `preferred`')
    preferred: bool = figure('an exponential describes the run better', 'clearly better than a '
                             'constant, and better than any polynomial up to order 3')
    span_s: float = figure('warm-up: length of the run')

    @property
    def stabilization_s(self) -> float:
        """Time to discard at the start, seconds; the whole run if it never settles."""
        return min(self.settle_s, self.span_s) if self.preferred else 0.0

    def explains(self, stamp_ns: Integers, mean_deg: Reals, sigma_deg: float) -> bool:
        """
        Tell whether differences before it settles lie around the exponential.

        A bad stretch at the start of a record also fits an exponential better than a constant.

        Parameters
        ----------
        stamp_ns : ndarray of int64, shape (n,)
            Stamps, the first one that of the run, nanoseconds.
        mean_deg : ndarray, shape (n,)
            Means of the differences there, degrees.
        sigma_deg
            Their largest rms distance from the exponential, degrees.

        """
        t_s = (stamp_ns - stamp_ns[0]) / 1e9
        settling = t_s < self.stabilization_s
        left_deg = (mean_deg - self.level_deg - self.amplitude_deg * np.exp(
            -t_s / self.tau_s))[settling]
        return bool(settling.any()) and float(np.mean(left_deg ** 2)) <= sigma_deg ** 2


def fit_warm_up(stamp_ns: ArrayLike, x_deg: ArrayLike, tolerance_deg: float) -> WarmUp | None:
    """
    Fit an exponential warm-up to the differences of a run.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps in increasing order, nanoseconds.
    x_deg : array_like, shape (n,)
        Differences, finite, degrees.
    tolerance_deg
        Value to which the exponential must fall, degrees, greater than 0; a tenth of sigma_max
        is usual.

    Returns
    -------
    WarmUp or None
        None for fewer than 64 samples.

    Raises
    ------
    ValueError
        If the tolerance is not greater than 0.

    Notes
    -----
    Variable projection (Golub & Pereyra 1973): for each time constant, linear least squares on 64
    to 127 block means gives the level and the amplitude. The amplitude is then corrected for the
    averaging within a block.

    References
    ----------
    GK asks that the stabilisation period be discarded, and leaves its end to the user. E.3 of
    ``docs/diagnostics.md``.

    """
    if not tolerance_deg > 0.0:
        raise ValueError(f'tolerance_deg = {tolerance_deg!r}: must be greater than 0')
    stamps, x = np.asarray(stamp_ns), np.asarray(x_deg, dtype=np.float64)
    span = (int(stamps[-1]) - int(stamps[0])) / 1e9 if x.size else 0.0
    if x.size < _LEAST_SAMPLES or not span > 0.0:
        return None
    t, z, size = average_blocks(stamps, x)
    mean = float(z.mean())
    y = z - mean

    def fit(log_tau: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        e = np.exp(-t / np.exp(log_tau)[:, np.newaxis])
        centre = e.mean(axis=1)
        e -= centre[:, np.newaxis]
        b = (e @ y) / np.sum(e * e, axis=1)
        left = y - b[:, np.newaxis] * e
        return np.sum(left * left, axis=1), b, mean - b * centre

    grid = np.linspace(math.log(span / 100.0), math.log(span), _GRID)
    squares = fit(grid)[0]
    best = int(np.argmin(squares))
    log_tau, least = float(grid[best]), float(squares[best])
    width = float(grid[1] - grid[0])
    # Finer and finer grids about the least: a minimiser of scipy takes longer to load.
    while width > _EXACT:
        finer = np.clip(log_tau + np.linspace(-width, width, _FINER), grid[0], grid[-1])
        squares = fit(finer)[0]
        best = int(np.argmin(squares))
        if squares[best] < least:
            log_tau, least = float(finer[best]), float(squares[best])
        width *= 2.0 / (_FINER - 1)
    rss, b, a = (float(v[0]) for v in fit(np.array([log_tau])))
    tau = math.exp(log_tau)
    step = span / (x.size - 1)
    k = (np.arange(size) - 0.5 * (size - 1)) * step
    amplitude = b / float(np.mean(np.exp(-k / tau)))
    settle = max(0.0, tau * math.log(abs(amplitude) / tolerance_deg)) \
        if abs(amplitude) > tolerance_deg else 0.0
    return WarmUp(level_deg=a, amplitude_deg=amplitude, tau_s=tau, tolerance_deg=tolerance_deg,
                  settle_s=settle, preferred=_is_preferred(stamps, x, rss, z.size), span_s=span)


def _is_preferred(stamps: np.ndarray, x: np.ndarray, rss: float, blocks: int) -> bool:
    floor = rounding_floor(x)
    mine = bic_of(rss, blocks, 4, floor)
    order = select_order(stamps, x)
    if order is None:
        return False
    others = [-math.inf if v is None else v for v in order.bic[:-1]]
    return mine < min(others) and mine + CLEAR < others[0]


def mser5(stamp_ns: ArrayLike, x_deg: ArrayLike) -> float | None:
    """
    Return the time after which the start of a run no longer disturbs its mean.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps in increasing order, nanoseconds.
    x_deg : array_like, shape (n,)
        Differences, finite, degrees.

    Returns
    -------
    float or None
        Seconds after the first stamp, at most half of the run; None for n < 20.

    Notes
    -----
    Works on means of 5 samples. It cuts off the number of means that minimises the variance of
    the mean of the rest; on a tie, the smaller number. It knows nothing about exponentials or
    norms, and a long correlation misleads it: it checks `fit_warm_up` and does not replace it.

    References
    ----------
    MSER-5, White 1997.

    """
    stamps, x = np.asarray(stamp_ns), np.asarray(x_deg, dtype=np.float64)
    k = x.size // 5
    if k < 4:
        return None
    z = x[:5 * k].reshape(k, 5).mean(axis=1)
    z -= z.mean()
    last = k // 2
    left = np.arange(k, k - last - 1, -1, dtype=np.float64)
    total = np.cumsum(z[::-1])[::-1][:last + 1]
    squares = np.cumsum((z * z)[::-1])[::-1][:last + 1]
    deviation = squares - total * total / left
    d = int(np.argmin(deviation / (left * left)))
    return (int(stamps[5 * d]) - int(stamps[0])) / 1e9
