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
The rule of docs/risk.md implemented once more: plain and slow, sharing no code with the product.

It streams and merges nothing and uses no fast transform, only sums over samples and a matrix of
cosines. A test compares the product with it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
import math

import numpy as np
from scipy.stats import chi2, norm, t as student


@dataclass(frozen=True, slots=True)
class Plain:
    """Figures of one run or of several, named as in the product's `Spread`."""

    n: int
    d_deg2: float
    s_deg2: float
    f: float
    nu: float
    corner_j: float
    r_slow: float
    slow_variance_deg2: float
    slow_allowance_deg2: float
    mean_variance_deg2: float
    low_deg2: float
    middle_deg2: float
    student_dof: int = 12
    k4: float = 3.0
    order: int = 0
    occupied: float = 1.0
    cells: int = 0
    c2: np.ndarray | None = None


def _places(n: int, stamp_ns: np.ndarray | None) -> list[int]:
    """Return the index of each difference in the record, counted in usual steps."""
    if stamp_ns is None:
        return list(range(n))
    stamps = [int(stamp) for stamp in stamp_ns]
    usual = int(np.median(np.diff(stamps[:128])))
    places, regular_ns, regular_place = [0], stamps[0], 0
    for before, stamp in zip(stamps, stamps[1:]):
        if 0.5 * usual <= stamp - before <= 1.5 * usual:
            regular_ns, regular_place = stamp, places[-1] + 1
        places.append(regular_place + math.floor((stamp - regular_ns) / usual + 0.5))
    return places


def _cells(e: np.ndarray, stamp_ns: np.ndarray | None, q: float,
           ) -> tuple[np.ndarray, np.ndarray, float] | None:
    """Return b and y of each complete cell, the share in use; None for fewer than 128."""
    places = _places(e.size, stamp_ns)
    size = 1
    while (places[-1] + 1) // size > 1023:
        size *= 2
    count = (places[-1] + 1) // size
    if count < 128:
        return None
    ends = np.searchsorted(places, size * np.arange(count + 1))
    b, y = np.empty(count), np.empty(count)
    for k in range(count):
        part = e[ends[k]:ends[k + 1]]
        b[k] = count * np.sum(part) / ends[-1]
        y[k] = count * (np.sum(part ** 2) - part.size * q) / ends[-1] + q
    return b, y, float(np.mean(np.diff(ends) > 0))


@lru_cache(maxsize=4)
def _cosines(count: int) -> np.ndarray:
    """Return the cosines j = 1..m of the DCT-II in rows, orthonormal."""
    j, k = np.arange(1, count)[:, np.newaxis], np.arange(1, count + 1)
    return math.sqrt(2.0 / count) * np.cos(math.pi * j * (k - 0.5) / count)


def spread(x: np.ndarray, order: int = 0, stamp_ns: np.ndarray | None = None) -> Plain | None:
    """Return the figures of one run; None for fewer than 128 samples or cells. S.1 to S.9."""
    n, p = x.size, order
    if n < 128:
        return None
    e = x - np.mean(x)
    q = float(np.mean(e ** 2))
    cells = _cells(e, stamp_ns, q)
    if cells is None:
        return None
    b, y, occupied = cells
    count, m = b.size, b.size - 1
    k4 = n * float(np.sum(e ** 4)) / float(np.sum(e ** 2)) ** 2 if q > 0.0 else 3.0
    a2, c2 = (_cosines(count) @ b) ** 2, (_cosines(count) @ y) ** 2

    def a(i: int, j: int) -> float:
        value = float(np.mean(a2[i - 1:j]))
        return value if value >= (1e-13 * float(np.max(np.abs(x)))) ** 2 * count else 0.0

    def c(i: int, j: int) -> float:
        return float(np.mean(c2[i - 1:j]))

    v = a(p + 1, p + 8) / count
    d = q + v if p == 0 else q + (1 + p) * a(p + 1, p + 4) / count
    if d == 0.0:
        nu = float(n - 1 - p)
        return Plain(n, 0.0, 0.0, nu, nu, math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    s2 = max(max(c(1, 6), c(1, 12), c(1, 24)) / count + 6.0 * (1 + p) ** 2 * v ** 2 / occupied,
             2.0 * d ** 2 / n)
    s2 *= 1.0 + 30.0 / n
    nu = 2.0 * d ** 2 / s2
    g = max(1.0, k4 / 3.0)
    f, corner = nu, math.inf
    for w in (64, 128, m):
        if w > m:
            continue
        plateau = c(1, 16)
        floor = min(plateau, c(3 * w // 4 + 1, w))
        area = float(np.sum(c2[:w])) - w * floor
        if area > 0.0 and plateau > floor:
            j = max(8.0, 2.0 / math.pi * area / (plateau - floor))
            corner = min(corner, j)
            f = min(f, 0.45 * occupied * j / ((plateau - floor) / plateau * g ** 2))
    low, mid = a(p + 1, p + 4) / count, a(p + 13, p + 28) / count
    return Plain(n, d, math.sqrt(s2), f, nu, corner, *_slow(low, mid), v, low, mid, k4=k4, order=p,
                 occupied=occupied, cells=count, c2=c2)


def _slow(low: float, mid: float) -> tuple[float, float, float]:
    """Return R, V_s and G. S.8, S.9."""
    r = 0.0 if low == 0.0 else low / mid if mid > 0.0 else math.inf
    v_s = 4.0 * max(0.0, low - mid)
    return r, v_s, min(254.3, r ** 2 / 8.0) * v_s


def _x(f: float, alpha: float, dof_t: int) -> float:
    """Return the distance of the upper bound from D, in units of s. S.7."""
    t = float(student.ppf(1.0 - alpha, dof_t))
    if f > 1e8:
        return t + math.sqrt(8.0 / f) * (2.0 * t * t + 1.0) / 6.0
    quantile = float(chi2.ppf(norm.cdf(-t), f))
    return math.sqrt(f / 2.0) * (f / quantile - 1.0) if quantile > 0.0 else math.inf


def upper_bound(figures: Plain, alpha: float) -> float:
    """Return U. S.10."""
    if figures.d_deg2 == 0.0:
        return 0.0
    return (figures.d_deg2 + _x(figures.f, alpha, figures.student_dof) * figures.s_deg2
            + figures.slow_allowance_deg2)


def lower_bound(figures: Plain, alpha: float) -> float:
    """Return L. S.11."""
    if figures.d_deg2 == 0.0:
        return 0.0
    t = float(student.ppf(1.0 - alpha, figures.student_dof))
    return figures.d_deg2 * math.exp(
        -t * figures.s_deg2 / figures.d_deg2 * math.sqrt(1.0 + 1.0 / figures.f))


def pool(runs: list[Plain]) -> Plain:
    """Return the figures of several runs with one variance. S.12."""
    w = np.array([r.n for r in runs], dtype=float)
    w /= w.sum()

    def mean(name: str) -> float:
        return float(sum(w[i] * getattr(r, name) for i, r in enumerate(runs)))

    d = mean('d_deg2')
    s = math.sqrt(sum((w[i] * r.s_deg2) ** 2 for i, r in enumerate(runs)))
    gamma = sum((w[i] * r.s_deg2) ** 3 * math.sqrt(8.0 / r.f)
                for i, r in enumerate(runs)) / s ** 3
    low, mid = mean('low_deg2'), mean('middle_deg2')
    return Plain(sum(r.n for r in runs), d, s, 8.0 / gamma ** 2, 2.0 * (d / s) ** 2,
                 math.nan, *_slow(low, mid), mean('mean_variance_deg2'), low, mid,
                 12 * len(runs))


def between_runs(runs: list[Plain], means_deg: np.ndarray, alpha: float) -> float:
    """Return U with the variance of the means taken from their scatter between runs. S.13."""
    all_runs, m = pool(runs), len(runs)
    between = float(np.var(means_deg, ddof=1))
    d = all_runs.d_deg2 - all_runs.mean_variance_deg2 + between
    factor = (m - 1) / float(chi2.ppf(alpha, m - 1)) - 1.0
    return d + math.hypot(_x(all_runs.f, alpha, 12 * m) * all_runs.s_deg2, factor * between)


def _contradicted(figures: Plain, flat: float) -> float:
    """Return G where R is above three times that of the stated errors, otherwise 0."""
    return figures.slow_allowance_deg2 if figures.r_slow > 3.0 * flat else 0.0


def _flat(times: float, p: int) -> float:
    """Return R0."""
    return ((1.0 + ((20.5 + p) * math.pi / times) ** 2)
            / (1.0 + ((2.5 + p) * math.pi / times) ** 2))


def stated_bound(figures: Plain, times: float, alpha: float) -> float:
    """Return U of one run whose length in slowest errors is stated. S.17."""
    n, p, d, k4 = figures.n, figures.order, figures.d_deg2, figures.k4
    if figures.c2 is None:
        return d  # all errors are equal
    seen, g = times * figures.occupied, max(1.0, k4 / 3.0)
    modes = min(128, figures.cells // 4, max(8, math.floor(seen / 3.0)))
    w = float(np.mean(figures.c2[:modes])) / figures.cells
    v = figures.mean_variance_deg2
    s2 = max(min(w + 6.0 * (1 + p) ** 2 * v ** 2 / figures.occupied,
                 d ** 2 * (max(k4, 3.0) - 1.0) / seen), 2.0 * d ** 2 / n) * (1.0 + 30.0 / n)
    f = min(2.0 * d ** 2 / s2, max(0.45 * seen / g ** 2, figures.f / 2.0))
    return (d + 1.1 * (1.0 + 0.7 * math.log(g)) * _x(f, alpha, modes) * math.sqrt(s2)
            + _contradicted(figures, _flat(times, p)))


def stated_bound_of_runs(runs: list[Plain], times: list[float], alpha: float) -> float:
    """Return U of several runs whose lengths in slowest errors are stated. S.18."""
    together = pool(runs)
    w = np.array([r.n for r in runs], dtype=float) / together.n
    d = 0.0
    for r, t, share in zip(runs, times, w):
        p = r.order
        first, last = (1, 8) if p == 0 else (p + 1, p + 4)
        bent = (last - first + 1) / sum(1.0 / (1.0 + (j * math.pi / t) ** 2)
                                        for j in range(first, last + 1))
        swallowed = r.mean_variance_deg2 if p == 0 else (1 + p) * r.low_deg2
        d += share * (r.d_deg2 - swallowed + bent * swallowed)
    g = max(1.0, sum(share * r.k4 for r, share in zip(runs, w)) / 3.0)
    flat = sum(share * _flat(t, r.order) for r, t, share in zip(runs, times, w))
    return (d + (1.0 + 0.5 * math.log(g)) * _x(together.f, alpha, together.student_dof)
            * together.s_deg2 + _contradicted(together, flat))


def scatter_of_runs(runs: list[Plain], means_deg: np.ndarray, alpha: float) -> float:
    """Return U from the scatter of the runs. S.19."""
    m = len(runs)
    w = np.array([r.n for r in runs], dtype=float)
    w /= w.sum()
    means = np.asarray(means_deg, dtype=float)
    squares = np.array([r.d_deg2 - r.mean_variance_deg2 for r in runs]) + (
        means - np.sum(w * means)) ** 2
    middle = float(np.sum(w * squares))
    s = math.sqrt(m / (m - 1) * float(np.sum((w * (squares - middle)) ** 2)))
    q = middle + float(np.var(means, ddof=1)) * float(np.sum(w ** 2))
    return q + _x(min(2.0 * q ** 2 / s ** 2, pool(runs).f), alpha, m - 1) * s
