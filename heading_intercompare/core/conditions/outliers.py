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

"""Isolated differences far from all others, one by one, and their share of the variance."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.records import Reals
from heading_intercompare.core.statistics.moments import Moments
from heading_intercompare.core.statistics.resolution import find_resolution

_LOOKED_AT = 200_000
_LEAST = 30
_QUANTILE = 0.9
_SURPLUS = 5.0
_GRAIN = 3.0
_BESIDE = 15
_FEW = 3
_PIECE = 4096
_NAMED = 10


@dataclass(frozen=True, slots=True)
class Outlier:
    """
    One isolated excursion of the difference.

    Attributes
    ----------
    index, n
        Index of its farthest difference, and number of consecutive differences in it.
    stamp_ns
        Stamp of the farthest difference, nanoseconds.
    size_deg
        Signed distance of that from the median of the differences on both sides, degrees.

    """

    index: int
    n: int
    stamp_ns: int
    size_deg: float


@dataclass(frozen=True, slots=True, eq=False)
class Outliers:
    """
    Isolated differences far from all others.

    Attributes
    ----------
    kind : {'none', 'found', 'not_testable'}
        'not_testable': fewer than 30 differences.
    index : ndarray of int64, shape (k,)
        Indices of the outliers, increasing.
    count
        Number of isolated excursions that they form.
    largest
        The ten largest excursions, the largest first.
    threshold_deg
        Distance beyond which a difference is an outlier, degrees.
    variance_deg2, variance_without_deg2
        Variance of all differences, and without the outliers; square degrees.
    share
        Share of the outliers in the sum of squares about the mean; 0 if there are none.
    excursions
        Number of longer excursions: not isolated, and not in `index`.

    """

    kind: str
    index: np.ndarray
    count: int = 0
    largest: tuple[Outlier, ...] = ()
    threshold_deg: float | None = None
    variance_deg2: float | None = None
    variance_without_deg2: float | None = None
    share: float = 0.0
    excursions: int = 0


def find_outliers(stamp_ns: ArrayLike, x_deg: ArrayLike, *, longest_s: float = 3.0,
                  step_deg: float | None = None) -> Outliers:
    """
    Find isolated differences far from all others.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps in increasing order, nanoseconds.
    x_deg : array_like, shape (n,)
        Differences, or their residuals about a drift, finite, degrees; not wrapped again.
    longest_s
        Longest excursion that counts as isolated, seconds: one bad reading of an interpolated RS
        disturbs all pairs of two brackets. Up to three differences in a row always count.
    step_deg
        Step in which the coarser sensor reports, degrees. By default found from x, which needs
        20 changes.

    Returns
    -------
    Outliers

    Notes
    -----
    The distance from the median is assumed to have an exponential tail, as in Laplace's law, with
    the observed 90 % quantile q. The threshold is q (1 + (ln(n/10) + 5)/ln 10), which n distances
    of that law exceed with a probability of e^-5, but at least three steps. A difference beyond
    it is an outlier if it is also that far from the median of the 30 differences on both sides of
    its excursion; this excludes slow excursions. For 12000 normal errors the threshold is 10
    standard deviations. Up to a tenth of the differences may be outliers without moving it much.

    References
    ----------
    E.19 of ``docs/diagnostics.md``.

    Examples
    --------
    >>> x = [0.1 * (k % 5) for k in range(100)]
    >>> x[40] = 40.0
    >>> outliers = find_outliers(range(100), x)
    >>> outliers.index.tolist(), round(outliers.largest[0].size_deg, 6)
    ([40], 39.8)

    """
    stamps, x = np.asarray(stamp_ns), np.asarray(x_deg, dtype=np.float64)
    none = np.empty(0, np.int64)
    if x.size < _LEAST:
        return Outliers('not_testable', none)
    centre, outer = _quantile(x)
    slope = outer / -math.log(1.0 - _QUANTILE)
    beyond = slope * (math.log((1.0 - _QUANTILE) * x.size) + _SURPLUS)
    if step_deg is None:
        step_deg = find_resolution(x).step_deg or 0.0
    threshold = max(outer + beyond, _GRAIN * step_deg)
    moments = Moments.of(x)
    variance = moments.m2_deg2 / (x.size - 1)
    least = max(outer + 0.5 * beyond, 0.5 * threshold)
    far = none
    if max(moments.max_deg - centre, centre - moments.min_deg) > least:
        far = np.flatnonzero(np.abs(x - centre) > least)
    outliers, which, excursions = _find_isolated(stamps, x, centre, far, threshold, longest_s)
    if not outliers:
        return Outliers(kind='none', index=none, count=0, largest=(), threshold_deg=threshold,
                        variance_deg2=variance, variance_without_deg2=variance, share=0.0,
                        excursions=excursions)
    rest = np.delete(x, which)
    without = float(np.var(rest, ddof=1)) if rest.size > 1 else None
    share = 1.0 - (without or 0.0) * max(0, rest.size - 1) / (variance * (x.size - 1))
    outliers.sort(key=lambda outlier: -abs(outlier.size_deg))
    return Outliers(kind='found', index=which, count=len(outliers),
                    largest=tuple(outliers[:_NAMED]), threshold_deg=threshold,
                    variance_deg2=variance, variance_without_deg2=without,
                    share=min(1.0, max(0.0, share)), excursions=excursions)


def _quantile(x: np.ndarray) -> tuple[float, float]:
    """Return the median, and the 90 % quantile of the distance from it."""
    sample = x[::max(1, x.size // _LOOKED_AT)]
    centre = float(np.median(sample))
    return centre, float(np.quantile(np.abs(sample - centre), _QUANTILE))


def _find_isolated(stamps: np.ndarray, x: np.ndarray, centre: float, far: np.ndarray,
                   threshold: float, longest_s: float) -> tuple[list[Outlier], np.ndarray, int]:
    """Return the isolated excursions, their indices, and the number of other excursions."""
    if not far.size:
        return [], far, 0
    begins = np.flatnonzero(np.diff(far, prepend=-2) > 1)
    ends = np.append(begins[1:], far.size) - 1
    peak = np.maximum.reduceat(np.abs(x[far] - centre), begins)
    high = peak > threshold
    begins, ends = begins[high], ends[high]
    first, last = far[begins], far[ends]
    short = ((stamps[last] - stamps[first]) / 1e9 <= longest_s) | (last - first < _FEW)
    excursions = int(np.count_nonzero(~short))
    first, last = first[short], last[short]
    outliers, which = [], []
    for lo in range(0, first.size, _PIECE):
        a, b = first[lo:lo + _PIECE], last[lo:lo + _PIECE]
        level = _level(x, a, b, centre)
        for number, (start, end) in enumerate(zip(a.tolist(), b.tolist())):
            off = x[start:end + 1] - level[number]
            at = int(np.argmax(np.abs(off)))
            if abs(off[at]) > threshold:
                outliers.append(Outlier(start + at, end + 1 - start, int(stamps[start + at]),
                                        float(off[at])))
                which.append(np.arange(start, end + 1))
            else:
                excursions += 1
    return outliers, np.concatenate(which) if which else far[:0], excursions


def _level(x: np.ndarray, first: np.ndarray, last: np.ndarray, centre: float) -> np.ndarray:
    """Return the median of the differences on both sides of each excursion."""
    steps = np.arange(1, _BESIDE + 1)
    at = np.concatenate((first[:, np.newaxis] - steps, last[:, np.newaxis] + steps), axis=1)
    inside = (at >= 0) & (at < x.size)
    beside = np.where(inside, x[np.clip(at, 0, x.size - 1)], np.nan)
    empty = ~inside.any(axis=1)
    beside[empty, 0] = centre
    level: Reals = np.nanmedian(beside, axis=1)
    return level
