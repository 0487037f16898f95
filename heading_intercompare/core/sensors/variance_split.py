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

"""The variances of the pairs split among three or more sensors: the three-cornered hat."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Sequence

import numpy as np

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.declared_figures import figure

_FEWEST = 3
_LEVEL = 0.95
_STUDENT_DOF = 12


@dataclass(frozen=True, slots=True)
class PairVariance:
    """
    The variance of the differences of two sensors, as the split needs it.

    Attributes
    ----------
    first, second
        The sensors, numbered from 0.
    variance_deg2, u_deg2
        The variance and its standard uncertainty, square degrees.
    first_factor, second_factor
        Factor by which interpolation reduced the white noise of each.

    """

    first: int
    second: int
    variance_deg2: float
    u_deg2: float
    first_factor: float = 1.0
    second_factor: float = 1.0


@dataclass(frozen=True, slots=True)
class SensorVariance:
    """The variance of the errors of one sensor; keys of the JSON."""

    variance_deg2: float = figure('variance of the errors of the sensor', 'a negative one stays: '
                                  'the errors are correlated, or the record is too short')
    interval_deg2: tuple[float, float] = figure('interval of at least 95 %')
    std_deg: float | None = figure('standard deviation', 'null if the variance is negative')

    @property
    def is_negative(self) -> bool:
        """Whether the whole interval is negative, which only correlated errors explain."""
        return self.interval_deg2[1] < 0.0


def split_variances(n: int, pairs: Sequence[PairVariance]) -> tuple[SensorVariance, ...] | None:
    """
    Split the variances of pairs among their sensors.

    Parameters
    ----------
    n
        Number of sensors.
    pairs
        The pairs that have a variance.

    Returns
    -------
    tuple of SensorVariance, or None
        None for fewer than three sensors, or if the pairs do not determine all variances.

    Notes
    -----
    Least squares of D_ij = f_i s_i^2 + f_j s_j^2, weighted by the uncertainties. Interpolation
    reduces white noise by the factor f and leaves slow errors as they are. So the split is made
    twice, with the factors and with 1; the result lies between, and the interval covers both. The
    uncertainties of the pairs add up linearly, because pairs that share a sensor are correlated:
    the interval is wide rather than wrong.

    `core.diagnostics.three_cornered_hat` splits readings at common stamps without weights. Here
    each pair has stamps, losses and an interpolation of its own, so common stamps would leave out
    what a verdict counts.

    It holds only if the errors of the sensors are uncorrelated. Two gyrocompasses have the same
    error of speed and latitude, which no split sees.

    References
    ----------
    Gray & Allan 1974; E.12 of ``docs/diagnostics.md``.

    Examples
    --------
    >>> split = split_variances(3, [PairVariance(0, 1, 5.0, 0.0), PairVariance(0, 2, 10.0, 0.0),
    ...                             PairVariance(1, 2, 13.0, 0.0)])
    >>> [round(variance.variance_deg2, 6) for variance in split]
    [1.0, 4.0, 9.0]

    """
    if n < _FEWEST or not pairs:
        return None
    half = float(scipy.special.stdtrit(_STUDENT_DOF, 0.5 + 0.5 * _LEVEL))
    variances = np.array([pair.variance_deg2 for pair in pairs])
    uncertainties = np.array([pair.u_deg2 for pair in pairs])
    weights = 1.0 / uncertainties if uncertainties.all() else np.ones(len(pairs))
    splits = []
    for reduced in (True, False):
        design = np.zeros((len(pairs), n))
        for row, pair in enumerate(pairs):
            design[row, pair.first] = pair.first_factor if reduced else 1.0
            design[row, pair.second] = pair.second_factor if reduced else 1.0
        if np.linalg.matrix_rank(design) < n:
            return None
        solve = np.linalg.pinv(weights[:, None] * design) * weights
        estimate, margin = solve @ variances, half * np.abs(solve) @ uncertainties
        splits.append((estimate, estimate - margin, estimate + margin))
    middle = 0.5 * (splits[0][0] + splits[1][0])
    low, high = np.minimum(splits[0][1], splits[1][1]), np.maximum(splits[0][2], splits[1][2])
    return tuple(SensorVariance(v, (lo, hi), math.sqrt(v) if v >= 0.0 else None)
                 for v, lo, hi in zip(middle.tolist(), low.tolist(), high.tolist()))
