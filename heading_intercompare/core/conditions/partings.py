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

"""Stretches in which two sensors that otherwise agree point far apart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.records import Integers, Reals

LEAST_S = 60.0
"""Shortest stretch, seconds; a shorter excursion is an outlier."""

LEAST_NORMS = 10.0
"""The sensors part if they differ by more than this multiple of what both norms explain, ..."""

LEAST_SPREADS = 8.0
"""... and by more than this multiple of their usual spread."""

_BLOCKS = 1 << 13
#: Differences looked at at once.
_PIECE = 1 << 15
_MAD_TO_SIGMA = 1.4826
_MOST_SHARE = 0.5
#: Shorter returns to the usual difference do not end a stretch, seconds.
_RETURN_S = 10.0


@dataclass(frozen=True, slots=True)
class Parting:
    """
    A stretch in which the sensors point apart.

    Attributes
    ----------
    start_ns, end_ns
        Stamps of its first and of its last pair, nanoseconds.
    size_deg
        Median distance of its differences from the usual one, with sign, degrees.

    """

    start_ns: int
    end_ns: int
    size_deg: float

    @property
    def lasted_s(self) -> float:
        """Length of the stretch, seconds."""
        return (self.end_ns - self.start_ns) / 1e9


def find_partings(stamp_ns: ArrayLike, x_deg: ArrayLike, sigma_deg: float) -> list[Parting]:
    """
    Look for stretches in which two sensors point far apart.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps in increasing order, nanoseconds.
    x_deg : array_like, shape (n,)
        Differences, finite, degrees.
    sigma_deg
        Standard deviation of the differences that the norms of both explain, degrees.

    Returns
    -------
    list of Parting
        In the order of time; empty if the sensors are apart for most of the time, for then
        nobody can say what is usual.

    Examples
    --------
    >>> stamps = np.arange(600) * 10 ** 9
    >>> x = np.where((stamps >= 200 * 10 ** 9) & (stamps < 350 * 10 ** 9), 38.0, 0.0)
    >>> [(p.start_ns // 10 ** 9, p.end_ns // 10 ** 9, p.size_deg)
    ...  for p in find_partings(stamps, x, 0.2)]
    [(200, 349, 38.0)]

    """
    stamps, x = np.asarray(stamp_ns, np.int64), np.asarray(x_deg, np.float64)
    if x.size < 2:
        return []
    thin = x[::max(1, x.size // _BLOCKS)]
    usual_deg = float(np.median(thin))
    spread_deg = _MAD_TO_SIGMA * float(np.median(np.abs(thin - usual_deg)))
    limit_deg = max(LEAST_NORMS * sigma_deg, LEAST_SPREADS * spread_deg)
    far = np.concatenate([
        lo + np.flatnonzero(np.abs(x[lo:lo + _PIECE] - usual_deg) > limit_deg)
        for lo in range(0, x.size, _PIECE)])
    if not far.size or far.size / x.size > _MOST_SHARE:
        return []
    return [Parting(int(stamps[lo]), int(stamps[hi]), float(np.median(x[lo:hi + 1])) - usual_deg)
            for lo, hi in _join(far, stamps)]


def _join(far: Integers, stamps: Integers) -> list[tuple[int, int]]:
    """Return first and last index of the long stretches, over short returns."""
    at = stamps[far]
    ends = np.flatnonzero(np.diff(at) > round(_RETURN_S * 1e9))
    first, last = far[np.r_[0, ends + 1]], far[np.r_[ends, far.size - 1]]
    long = stamps[last] - stamps[first] >= round(LEAST_S * 1e9)
    # Outliers in a row are no stretch: most of its differences are far.
    most = np.array([np.count_nonzero((far >= lo) & (far <= hi)) > _MOST_SHARE * (hi - lo + 1)
                     for lo, hi in zip(first, last)], bool)
    keep = long & most
    return list(zip(first[keep].tolist(), last[keep].tolist()))


def cut_spans(stamp_ns: Integers, values: Reals,
              spans_ns: Sequence[tuple[int, int]]) -> tuple[Integers, Reals]:
    """Return the samples outside some closed spans of time, stamps in increasing order."""
    if not spans_ns:
        return stamp_ns, values
    outside = np.ones(stamp_ns.shape, bool)
    for start_ns, end_ns in spans_ns:
        outside[slice(*np.searchsorted(stamp_ns, (start_ns, end_ns + 1)))] = False
    return stamp_ns[outside], values[outside]
