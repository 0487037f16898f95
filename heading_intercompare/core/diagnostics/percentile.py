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

"""The distance from the mean within which 95 % of the differences lie, with its bounds."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.declared_figures import figure

SHARE = 0.95
"""Share of the differences within the limit."""

_Z95 = 1.959963984540054
_LEAST = 20


@dataclass(frozen=True, slots=True)
class Percentile:
    """A limit that a share of the differences keeps; keys of the JSON."""

    share: float = figure('share of the differences within the limit', '0.95')
    limit_deg: float = figure('limit that 95 % of the differences keep, about their mean',
                              'in variant A about zero')
    lower_deg: float = figure('its lower .. upper bound at 95 % confidence', 'the lower one, by '
                              'order statistics and the effective number', up='upper_deg')
    upper_deg: float | None = figure('upper bound at 95 % confidence', 'null beyond the record')


def estimate_percentile(x_deg: ArrayLike, center_deg: float,
                        n_effective: float) -> Percentile | None:
    """
    Return the limit of 95 % of the differences, whatever their distribution.

    Parameters
    ----------
    x_deg : array_like, shape (n,)
        Differences, or their residuals about a drift; finite, degrees.
    center_deg
        The centre that distances count from, degrees: 0 in variant A, otherwise the mean.
    n_effective
        Number of independent differences that they are worth.

    Returns
    -------
    Percentile or None
        None for fewer than 20 independent differences.

    Notes
    -----
    The share of the differences within the true limit is that of a binomial distribution of
    `n_effective` trials. So the bounds are the quantiles at 0.95 - u and 0.95 + u with
    u = 1.96 sqrt(0.95 0.05 / n_effective), by the normal approximation.

    References
    ----------
    Order statistics as distribution-free bounds of a quantile: Hahn & Meeker 1991, section 5.2.

    Examples
    --------
    >>> limit = estimate_percentile(np.arange(-100.0, 101.0), 0.0, 201.0)
    >>> round(limit.limit_deg, 1), round(limit.lower_deg, 1), round(limit.upper_deg, 1)
    (95.0, 92.0, 98.0)

    """
    x = np.asarray(x_deg, dtype=np.float64)
    if not x.size or n_effective < _LEAST:
        return None
    u = _Z95 * math.sqrt(SHARE * (1.0 - SHARE) / n_effective)
    shares = [SHARE, SHARE - u, min(1.0, SHARE + u)]
    distance = x - center_deg
    limit, lower, upper = np.quantile(np.abs(distance, out=distance), shares,
                                      overwrite_input=True).tolist()
    return Percentile(SHARE, limit, lower, None if SHARE + u >= 1.0 else upper)
