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

"""The step in which a sensor reports its heading, and the variance that rounding to it adds."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.angles import wrap180

LOOKED_AT = 100_000
"""Only the first headings of a record, up to this number, are examined for a step."""
_LEAST_STEP_DEG = 1e-7
_LEAST_STEPS = 20
_SHARE = 0.99
_STEPS_DEG = (1.0, 0.5, 0.25, 0.2, 0.1, 0.05, 0.04, 0.02, 0.01)
#: Sum of the phases in the step of a normal law whose standard deviation is 0.3 of it.
_SEEN = math.exp(-2.0 * (0.3 * math.pi) ** 2)
_PHASES = 1 << 14


@dataclass(frozen=True, slots=True)
class Resolution:
    """
    How finely a heading is reported.

    Attributes
    ----------
    n
        Readings examined: the first 100000 at most.
    step_deg
        Step of which the heading changes are multiples; None if there is no such step, or too
        few changes to tell.
    repeated_share
        Share of readings equal to the previous one; None for n < 2.

    """

    n: int
    step_deg: float | None
    repeated_share: float | None

    @property
    def variance_deg2(self) -> float:
        """Variance that rounding adds, square degrees; 0 if no step was found."""
        return 0.0 if self.step_deg is None else self.step_deg ** 2 / 12.0


def find_resolution(heading_deg: ArrayLike) -> Resolution:
    """
    Find the step in which a heading is reported.

    Parameters
    ----------
    heading_deg : array_like, shape (n,)
        Headings in stamp order, finite, degrees. The step need not be a decimal fraction: it may
        be 0.0001 rad.

    Returns
    -------
    Resolution

    Notes
    -----
    The smallest change is the candidate. It is kept if 99 % of all changes are multiples of it
    to within a twentieth of a step. Rounding adds step^2/12 to the variance if the standard
    deviation is at least half a step (Sheppard). That is reported, never subtracted.

    Examples
    --------
    >>> resolution = find_resolution([0.2 * (k % 3) for k in range(40)])
    >>> round(resolution.step_deg, 6), resolution.repeated_share
    (0.2, 0.0)

    """
    heading = np.asarray(heading_deg, dtype=np.float64)[:LOOKED_AT]
    if heading.size < 2:
        return Resolution(heading.size, None, None)
    changes = np.abs(wrap180(np.diff(heading)))
    moved = changes[changes > _LEAST_STEP_DEG]
    share = 1.0 - moved.size / changes.size
    return Resolution(heading.size, _common_step(moved), share)


def find_step_seen(heading_deg: ArrayLike) -> float:
    """
    Return the coarsest step whose rounding would show in the run, degrees; 0 if none would.

    Parameters
    ----------
    heading_deg : array_like, shape (n,)
        Headings of the other sensor, finite, degrees.

    Notes
    -----
    Rounding adds its step^2/12 to the variance only if the heading runs through the step. The
    phases of the heading in the step are then spread over all of it: their mean vector is short.
    The bound is that of a normal law whose standard deviation is 0.3 steps. Then 73 % of
    step^2/12 or more show in 95 of 100 runs.

    References
    ----------
    E.28 of ``docs/diagnostics.md``.

    Examples
    --------
    >>> find_step_seen([90.0, 90.3, 89.8, 90.1, 89.6]), find_step_seen([90.0, 90.0])
    (0.5, 0.0)

    """
    heading = np.asarray(heading_deg, dtype=np.float64)
    sample = heading[::max(1, heading.size // _PHASES)]
    for step_deg in _STEPS_DEG:
        if sample.size and abs(np.exp(2j * np.pi / step_deg * sample).mean()) <= _SEEN:
            return step_deg
    return 0.0


def _common_step(changes: np.ndarray) -> float | None:
    if changes.size < _LEAST_STEPS:
        return None
    step = float(changes.min())
    # Refine the candidate with its multiples, small ones first: its error grows with the
    # multiple.
    for most in (4.0, 64.0, np.inf):
        small = changes[changes <= most * step]
        multiple = np.rint(small / step)
        step = float(small @ multiple) / float(multiple @ multiple)
    off = np.abs(changes / step - np.rint(changes / step))
    return step if np.count_nonzero(off < 0.05) >= _SHARE * changes.size else None
