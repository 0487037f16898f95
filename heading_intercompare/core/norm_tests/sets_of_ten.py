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

"""Sets of ten readings, one every 20 min, on one heading after the TS has settled."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Sequence

import numpy as np

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.records import Integers, Reals

from .settling import find_settling, MINUTE_NS

READINGS = 10
"""Readings of a set."""

ONE_HEADING_DEG = 10.0
"""Largest difference of two headings that count as one, degrees."""

_APART_NS = 20 * MINUTE_NS


@dataclass(frozen=True, slots=True)
class SetOfTen:
    """
    Mean and variance of ten differences, about that mean, and the heading.

    The mean is the settle-point error of the set.
    """

    mean_deg: float
    variance_deg2: float
    heading_deg: float


def find_sets(stamp_ns: Integers, x_deg: Reals, rs_deg: Reals) -> tuple[SetOfTen, ...]:
    """
    Return the sets of a run, one after the other; none before the TS has settled.

    A turn or a silence ends a set that is not complete.

    References
    ----------
    A.821(19) 4.1.2; draft of ISO 22090-1, 3.11.

    """
    settling = find_settling(stamp_ns, x_deg)
    if settling is None or settling.first_min is None or settling.third_min is None:
        return ()
    # Differences that begin settled had settled earlier.
    due_ns = int(stamp_ns[0]) + (settling.third_min * MINUTE_NS if settling.first_min else 0)
    sets: list[SetOfTen] = []
    readings: list[int] = []
    while (at := int(np.searchsorted(stamp_ns, due_ns))) < stamp_ns.size:
        late_ns = int(stamp_ns[at]) - due_ns
        if readings and (late_ns > MINUTE_NS or not is_one_heading(
                rs_deg[at], rs_deg[readings[0]])):
            readings = []
        readings.append(at)
        due_ns = int(stamp_ns[readings[0]]) + _APART_NS * len(readings)
        if len(readings) == READINGS:
            ten = x_deg[readings]
            sets.append(SetOfTen(float(ten.mean()), float(ten.var(ddof=1)),
                                 float(rs_deg[readings[0]])))
            readings = []
    return tuple(sets)


def is_one_heading(heading_deg: float, other_deg: float) -> bool:
    """Tell whether two headings count as one."""
    return abs(float(wrap180(heading_deg - other_deg))) <= ONE_HEADING_DEG


def pool_variances(variances_deg2: Sequence[float]) -> tuple[float, float]:
    """Return the variance within sets, square degrees, and its degrees of freedom."""
    sets = len(variances_deg2)
    return math.fsum(variances_deg2) / sets, float((READINGS - 1) * sets)
