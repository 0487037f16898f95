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

"""When a TS settles: three readings, half an hour apart, within a band."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from heading_intercompare.core.records import Integers, Reals

SETTLED_BAND_DEG = 0.7
"""A compass has settled if three readings in a row lie within this band, degrees."""

APART_MIN = 30
"""Minutes from one of these readings to the next."""

MINUTE_NS = 60_000_000_000


@dataclass(frozen=True, slots=True)
class Settling:
    """
    When the differences of a run settle.

    Attributes
    ----------
    first_min, third_min
        Minutes from the first difference to the first and the third of the three readings that
        lie within the band; None if none do.
    span_min
        Minutes to the last difference.

    """

    first_min: int | None
    third_min: int | None
    span_min: int


def find_settling(stamp_ns: Integers, x_deg: Reals) -> Settling | None:
    """
    Find the first three readings, 30 min apart, within 0.7 deg; None for less than an hour.

    A reading is the mean of a minute. It is read as a difference, so the ship may turn.

    References
    ----------
    Draft of ISO 22090-1, 3.10: settled, and its note on the settling time.

    """
    if not x_deg.size:
        return None
    minute = (stamp_ns - stamp_ns[0]) // MINUTE_NS
    last = int(minute[-1])
    if last < 2 * APART_MIN:
        return None
    n = np.bincount(minute)
    reading = np.full(n.size, np.nan)
    np.divide(np.bincount(minute, x_deg), n, out=reading, where=n > 0)
    three = np.stack([reading[:-2 * APART_MIN], reading[APART_MIN:-APART_MIN],
                      reading[2 * APART_MIN:]])
    settled = np.flatnonzero(three.max(axis=0) - three.min(axis=0) <= SETTLED_BAND_DEG)
    if not settled.size:
        return Settling(None, None, last)
    first = int(settled[0])
    return Settling(first, first + 2 * APART_MIN, last)
