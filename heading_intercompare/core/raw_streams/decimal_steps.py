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

"""The step in which a sensor reports, from the decimals of its changes of value."""

from __future__ import annotations

from typing import Mapping

import numpy as np

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.records import Headings, Integers

DECIMAL_STEPS = (100, 50, 25, 20, 10, 5, 4, 2, 1)
"""Steps that are told apart, hundredths of a degree, coarsest first: the divisors of a degree."""

_UNIT_DEG, _OFF, _CHANGED_DEG = 0.01, 0.01, 1e-6
_WHOLE = 100
_STEP_OF = np.gcd(np.arange(_WHOLE), _WHOLE).astype(np.uint8)
_LEAST_CHANGES, _MOST_FINER = 3, 0.01


class StepCount:
    """Sort the changes of value of a stream by the coarsest step of which they are multiples."""

    def __init__(self) -> None:
        self._last_deg: float | None = None

    def take(self, headings: Headings) -> dict[int, Integers]:
        """
        Take readings; return the stamps of those whose value changed.

        Returns
        -------
        dict of int to ndarray of int64
            By step, hundredths of a degree; 0 for changes that are multiples of none.

        """
        if not len(headings):
            return {}
        heading = headings.heading_deg
        first = heading[0] if self._last_deg is None else self._last_deg
        change = np.abs(wrap180(np.diff(heading, prepend=first)))
        self._last_deg = float(heading[-1])
        at = np.flatnonzero(change > _CHANGED_DEG)
        units = change[at] / _UNIT_DEG
        whole = np.rint(units)
        step = np.where(np.abs(units - whole) <= _OFF,
                        _STEP_OF[whole.astype(np.int64) % _WHOLE], np.uint8(0))
        stamp_ns = headings.stamp_ns if at.size == len(headings) else headings.stamp_ns[at]
        return {key: stamp_ns[step == key]
                for key in np.flatnonzero(np.bincount(step)).tolist()}


def find_decimal_step(changes: Mapping[int, int]) -> float | None:
    """
    Return the step in which a sensor reports.

    Parameters
    ----------
    changes
        Changes of value by the coarsest step of which they are multiples, from `StepCount`.

    Returns
    -------
    float or None
        The coarsest of `DECIMAL_STEPS` of which 99 % of all changes are multiples, degrees. None
        for fewer than three changes, and for a finer step.

    References
    ----------
    E.28 of ``docs/diagnostics.md``.

    Examples
    --------
    >>> find_decimal_step({100: 40}), find_decimal_step({100: 4, 20: 5, 10: 40})
    (1.0, 0.1)

    """
    n = sum(changes.values())
    if n < _LEAST_CHANGES:
        return None
    for step in DECIMAL_STEPS:
        fits = sum(count for key, count in changes.items() if key and key % step == 0)
        if n - fits <= _MOST_FINER * n:
            return step * _UNIT_DEG
    return None
