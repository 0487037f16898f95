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

"""Correlation in time: autocorrelation, correlation times, effective size, Allan deviation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.records import Reals

from .moments import sum_products

_SEGMENT = 1 << 17
#: Length of a segment over the largest lag (the samples beside its ends are transformed twice),
#: and of averages over the distance of their starts.
_LONG = 4
_PIECE = 1 << 13
_SOKAL_LAGS = 5000
_GROWTH = 8
_MANY_TERMS = 1 << 17
_WINDOW = 10.0


def autocorrelate(x: ArrayLike, max_lag: int) -> np.ndarray:
    """
    Return the autocorrelation of a series about its mean.

    Parameters
    ----------
    x : array_like, shape (n,)
        Samples at equal steps; gaps go unnoticed.
    max_lag
        Largest lag, in samples; lags of n and above are left out.

    Returns
    -------
    ndarray, shape (min(max_lag, n - 1) + 1,)
        r_k = sum (x_i - m)(x_{i+k} - m) / sum (x_i - m)^2, the biased form; r_0 = 1. Zero at all
        other lags if the samples are equal; empty for n = 0.

    Raises
    ------
    ValueError
        If `max_lag` is negative.

    Notes
    -----
    Transforms segments not much longer than `max_lag`, so the memory does not grow with n: some
    100 MB for a million lags.

    """
    if max_lag < 0:
        raise ValueError(f'max_lag = {max_lag!r}: must be at least 0')
    e = _centre(x)
    return _correlation(e, min(max_lag, e.size - 1)) if e.size else np.empty(0)


def _centre(x: ArrayLike) -> np.ndarray:
    """Return the samples minus their mean; exactly zero if all are equal."""
    x = np.asarray(x, dtype=np.float64).reshape(-1)
    if not x.size:
        return x
    e: Reals = x - x[0]
    e -= e.mean()
    return e


def _correlation(e: np.ndarray, m: int) -> np.ndarray:
    """Return r_0 to r_m of centred samples; m < n."""
    power = sum_products(e, e)
    if power == 0.0:
        return np.concatenate(([1.0], np.zeros(m)))
    step = min(e.size, max(_LONG * m, _SEGMENT))
    r = _within_segments(e, m, step)
    if step < e.size and m:
        r[1:] += _cross_boundaries(e, m, range(step, e.size, step))
    r /= power
    r[0] = 1.0
    return r


def _within_segments(e: np.ndarray, m: int, step: int) -> np.ndarray:
    """Return the sums of products, at lags 0 to m, of samples of the same segment."""
    size = scipy.fft.next_fast_len(step + m, real=True)
    spectrum = np.zeros(size // 2 + 1)
    for lo in range(0, e.size, step):
        squares = scipy.fft.rfft(e[lo:lo + step], size).view(np.float64)
        squares *= squares
        spectrum += squares[::2]
        spectrum += squares[1::2]
        del squares
    sums: Reals = scipy.fft.irfft(spectrum, size)
    # Not a view, which would keep all of them.
    return sums[:m + 1].copy()


def _cross_boundaries(e: np.ndarray, m: int, boundaries: range) -> np.ndarray:
    """Return the sums of products, at lags 1 to m, of samples on both sides of a boundary."""
    size = scipy.fft.next_fast_len(2 * m, real=True)
    spectrum = np.zeros(size // 2 + 1, dtype=np.complex128)
    for at in boundaries:
        before = scipy.fft.rfft(e[at - m:at], size)
        np.conjugate(before, out=before)
        before *= scipy.fft.rfft(e[at:at + m], size)
        spectrum += before
    sums: Reals = scipy.fft.irfft(spectrum, size)
    # The samples of both sides lie m further apart than their indices.
    return np.concatenate((sums[size - m + 1:], sums[:1]))


@dataclass(frozen=True, slots=True)
class CorrelationTimes:
    """
    Integrated correlation of a series.

    Attributes
    ----------
    n
        Number of samples.
    window
        Largest lag summed.
    tau_1, tau_2
        1 + 2 sum r_k and 1 + 2 sum r_k^2, in samples. n / tau_1 uncorrelated samples would give
        an equally good mean, n / tau_2 (normal errors) an equally good variance.

    """

    n: int
    window: int
    tau_1: float
    tau_2: float

    @property
    def effective_size(self) -> float:
        """Return how many independent normal samples give an equally good variance, E.23."""
        return self.n / max(self.tau_2, 1.0)


class _Lags:
    """The autocorrelation of a series, computed as far as it is needed."""

    def __init__(self, x: ArrayLike) -> None:
        self._e = _centre(x)
        self.n = self._e.size
        self._r = np.ones(1)

    def up_to(self, m: int) -> np.ndarray:
        """Return r_0 to r_m; m < n."""
        if m >= self._r.size:
            self._r = _correlation(self._e, m)
        return self._r[:m + 1]

    def sum_up_to_window(self, limit: int,
                         closed: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray],
                         ) -> CorrelationTimes:
        """Sum up to the first lag where `closed` is true, at most to a lag."""
        limit = min(limit, self.n - 1)
        if limit < 1:
            return CorrelationTimes(self.n, 0, 1.0, 1.0)
        m = min(_SOKAL_LAGS, limit)
        while True:
            r = self.up_to(m).copy()
            r[0] = 0.0
            tau_1 = 1.0 + 2.0 * np.cumsum(r)
            tau_2 = 1.0 + 2.0 * np.cumsum(r * r)
            closing_lags = np.flatnonzero(closed(np.arange(m + 1), tau_1, tau_2))
            if closing_lags.size or m == limit:
                window = int(closing_lags[0]) if closing_lags.size else m
                return CorrelationTimes(self.n, window, float(tau_1[window]),
                                        float(tau_2[window]))
            # Squares only add up: the window is at least ten times what they sum to so far.
            m = min(max(m * _GROWTH, round(_LONG * _WINDOW * tau_2[-1])), limit)


def estimate_correlation_times(x: ArrayLike) -> CorrelationTimes:
    """
    Return correlation times with the wide window that an estimate of the variance needs.

    Parameters
    ----------
    x : array_like, shape (n,)
        Residuals in sample order.

    Returns
    -------
    CorrelationTimes
        Sums up to the first lag W >= 10 max(tau_1, tau_2, 1), at most to n/4. Both are 1 without
        correlation, and for n < 2.

    References
    ----------
    Sokal 1997, with a window twice as wide: a narrow one misses a slow component below white
    noise. E.23 of ``docs/diagnostics.md``.

    """
    return _sum_widely(_Lags(x))


def _sum_widely(lags: _Lags) -> CorrelationTimes:
    return lags.sum_up_to_window(
        max(2, lags.n // 4) - 1,
        lambda w, tau_1, tau_2: w >= _WINDOW * np.maximum(np.maximum(tau_1, tau_2), 1.0))


def effective_size(x: ArrayLike) -> float:
    """
    Return the number of independent normal samples that give an equally good variance.

    Parameters
    ----------
    x : array_like, shape (n,)
        Residuals in sample order.

    Returns
    -------
    float
        n / max(tau_2, 1); 0 for n = 0.

    References
    ----------
    Bayley & Hammersley 1946; E.23 of ``docs/diagnostics.md``.

    """
    return estimate_correlation_times(x).effective_size


def sokal_times(x: ArrayLike, limit: int = _SOKAL_LAGS) -> CorrelationTimes:
    """
    Return correlation times with the window W >= 5 tau_1.

    Parameters
    ----------
    x : array_like, shape (n,)
        Samples at equal steps; gaps go unnoticed.
    limit
        Largest lag; the sum stops there at the latest.

    References
    ----------
    Sokal 1997.

    """
    return _sum_narrowly(_Lags(x), limit)


def _sum_narrowly(lags: _Lags, limit: int) -> CorrelationTimes:
    return lags.sum_up_to_window(limit, lambda w, tau_1, tau_2: (w >= 1) & (w >= 5.0 * tau_1))


@dataclass(frozen=True, slots=True)
class SeriesCorrelation:
    """
    The correlation of one series, for all who ask.

    Attributes
    ----------
    r1
        Autocorrelation at a lag of one sample; None for n < 2.
    wide, narrow
        `estimate_correlation_times` and `sokal_times`.

    """

    r1: float | None
    wide: CorrelationTimes
    narrow: CorrelationTimes

    @classmethod
    def of(cls, x: ArrayLike) -> 'SeriesCorrelation':
        """Measure a series, shape (n,), at equal steps; gaps go unnoticed."""
        lags = _Lags(x)
        narrow = _sum_narrowly(lags, _SOKAL_LAGS)
        r1 = float(lags.up_to(1)[1]) if lags.n > 1 else None
        return cls(r1, _sum_widely(lags), narrow)


def geyer_time(x: ArrayLike) -> float:
    """
    Return the correlation time, summed while pairs of neighbouring lags stay positive.

    Parameters
    ----------
    x : array_like, shape (n,)
        Samples at equal steps; gaps go unnoticed.

    Returns
    -------
    float
        -1 + 2 sum (r_2m + r_2m+1) up to the first pair that is not positive, in samples;
        1 for n < 2.

    References
    ----------
    Geyer 1992 (Statistical Science 7, 473): initial positive sequence.

    """
    e = _centre(x)
    if e.size < 2:
        return 1.0
    m = min(_SOKAL_LAGS - 1, e.size - 1)
    while True:
        r = _correlation(e, m)
        pairs = r[:r.size // 2 * 2].reshape(-1, 2).sum(axis=1)
        negative = np.flatnonzero(pairs <= 0.0)
        if negative.size or m == e.size - 1:
            count = int(negative[0]) if negative.size else pairs.size
            return -1.0 + 2.0 * float(pairs[:count].sum())
        m = min((m + 1) * _GROWTH - 1, e.size - 1)


@dataclass(frozen=True, slots=True)
class AllanDeviation:
    """
    Allan deviation at several averaging times.

    Attributes
    ----------
    m : ndarray of int, shape (k,)
        Samples per average.
    tau_s : ndarray, shape (k,)
        Averaging time, seconds.
    deviation : ndarray, shape (k,)
        Root of half the mean squared difference of consecutive averages, in the unit of x.
    terms : ndarray of int, shape (k,)
        Number of all such squared differences.

    """

    m: np.ndarray
    tau_s: np.ndarray
    deviation: np.ndarray
    terms: np.ndarray


def _mean_square_step(sums: np.ndarray, lag: int) -> float:
    """Return the mean squared second difference, in pieces that stay in the cache."""
    total, count = 0.0, sums.size - 2 * lag
    steps = np.empty(_PIECE)
    for lo in range(0, count, _PIECE):
        hi = min(lo + _PIECE, count)
        middle = sums[lo + lag:hi + lag]
        step = np.subtract(sums[lo + 2 * lag:hi + 2 * lag], middle, out=steps[:hi - lo])
        step -= middle
        step += sums[lo:hi]
        total += float(step @ step)
    return total / count


def _starts_apart(lag: int, terms: int) -> int:
    """Return how far apart averages may start: they overlap by 3/4 or more, and enough remain."""
    every = 1
    while (lag % (2 * every) == 0 and lag >= 2 * every * _LONG
           and terms >= 2 * every * _MANY_TERMS):
        every *= 2
    return every


def compute_allan_deviation(x: ArrayLike, rate_hz: float, tau_s: ArrayLike | None = None, *,
                            m: ArrayLike | None = None,
                            overlapping: bool = True) -> AllanDeviation:
    """
    Return the Allan deviation of rate-like data.

    Parameters
    ----------
    x : array_like, shape (n,)
        Samples at equal steps, finite; gaps go unnoticed.
    rate_hz
        Samples per second.
    tau_s : array_like, optional
        Averaging times, seconds, rounded to whole samples; default 1, 2, 4, ... samples.
    m : array_like of int, optional
        Averaging times in samples, instead of `tau_s`.
    overlapping
        Start an average at every sample, which scatters less, or take consecutive averages only.

    Returns
    -------
    AllanDeviation
        Only at averaging times from 1 to n/2 samples, ascending, without duplicates.

    Notes
    -----
    In a record of more than 262144 samples, averages over 8, 16, 32, ... samples start at every
    2nd, 4th, 8th, ... sample as long as at least 131072 differences remain: they still overlap by
    three quarters, which leaves hardly more scatter.

    Raises
    ------
    ValueError
        If the rate is not positive.

    References
    ----------
    NIST SP 1065 (Riley 2008), ADEV and overlapping ADEV; Allan 1966. E.13 of
    ``docs/diagnostics.md``.

    """
    if not 0.0 < rate_hz < np.inf:
        raise ValueError(f'rate_hz = {rate_hz!r}: must be a number greater than 0')
    x = np.asarray(x, dtype=np.float64).reshape(-1)
    if m is None:
        m = (1 << np.arange(max(0, x.size.bit_length() - 1)) if tau_s is None
             else np.rint(np.asarray(tau_s, dtype=np.float64) * rate_hz))
    m = np.unique(np.asarray(m).reshape(-1).astype(np.int64))
    m = m[(m >= 1) & (m <= x.size // 2)]
    sums = np.zeros(x.size + 1)
    if x.size:
        sums[1:] = x
        sums[1:] -= x[0]
        sums[1:] -= sums[1:].mean()
    np.cumsum(sums, out=sums)
    terms = x.size + 1 - 2 * m if overlapping else x.size // m - 1
    squares = []
    for span, count in zip(m.tolist(), terms.tolist()):
        every = _starts_apart(span, count) if overlapping else span
        squares.append(_mean_square_step(sums[::every], span // every))
    return AllanDeviation(m, m / rate_hz, np.sqrt(0.5 * np.array(squares)) / m, terms)


def allan_dof(m: ArrayLike, terms: ArrayLike) -> np.ndarray:
    """
    Return the degrees of freedom of overlapping Allan variances of white errors.

    Parameters
    ----------
    m : array_like of int, shape (k,)
        Samples per average.
    terms : array_like of int, shape (k,)
        Number of squared differences, at least 1.

    Returns
    -------
    ndarray, shape (k,)
        At least 1. Errors that change slowly have fewer.

    References
    ----------
    NIST SP 1065 (Riley 2008), table 5, white frequency noise; with the number of phases n + 1.

    """
    m = np.asarray(m, np.float64)
    phases = np.asarray(terms) + 2.0 * m
    dof: Reals = (3.0 * (phases - 1.0) / (2.0 * m) - 2.0 * (phases - 2.0) / phases) * (
        4.0 * m ** 2 / (4.0 * m ** 2 + 5.0))
    return np.maximum(dof, 1.0)
