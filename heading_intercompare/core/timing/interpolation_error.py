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

"""The variance that interpolation adds to the differences, from how far its kernels part."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Mapping

from heading_intercompare.core.pairing.ledger import APART_DEG2, LedgerKey

_BRIDGED = {8: LedgerKey.BRIDGED_8, 6: LedgerKey.BRIDGED_6, 4: LedgerKey.BRIDGED_4,
            2: LedgerKey.BRIDGED_2}
#: Up to the first step any motion is resolved, above the second one none, seconds.
_ALWAYS_S, _NEVER_S = 0.5, 2.2
#: Resolved motion: the kernels converge so fast, or they agree to this share of the norm squared.
_SIX_TO_FOUR, _FOUR_TO_TWO, _SHARE_OF_NORM = 0.06, 0.08, 0.0066
_BOUND = 2.0


@dataclass(frozen=True, slots=True)
class InterpolationError:
    """
    What interpolation adds to the variance of the differences.

    Attributes
    ----------
    kind : {'none', 'estimated', 'not_testable'}
        'none': no reading is interpolated. 'not_testable': the account of the pairs does not say
        how they were interpolated.
    variance_deg2
        The variance added, square degrees; None if nothing was compared.
    is_resolved
        Whether the readings come fast enough to show the motion between them.
    step_s
        Usual step of the sensor interpolated, seconds.
    readings : mapping of int to int
        Number of pairs by the number of readings used.
    line_deg2
        The variance that the straight line adds or would add, square degrees.
    is_line
        Whether that line was used.

    """

    kind: str
    variance_deg2: float | None = None
    is_resolved: bool = False
    step_s: float | None = None
    readings: Mapping[int, int] | None = None
    line_deg2: float | None = None
    is_line: bool = False

    @property
    def upper_deg2(self) -> float:
        """Upper bound of the variance added, square degrees; infinite if it is not resolved."""
        if self.kind == 'none':
            return 0.0
        if not self.is_resolved or self.variance_deg2 is None:
            return math.inf
        return _BOUND * self.variance_deg2


def estimate_interpolation_error(counts: Mapping[LedgerKey, int], norm_deg: float, *,
                                 is_line: bool = False) -> InterpolationError:
    """
    Estimate what interpolation adds to the variance of the differences of a run.

    Parameters
    ----------
    counts
        Share of the run in the ledger.
    norm_deg
        Norm of the standard deviation of the sensor interpolated, degrees.
    is_line
        Whether the straight line was used, not the kernels compared with it.

    Notes
    -----
    Let b6, b4 and b2 be the mean squared distances of the values by six, four and two readings
    from that by eight. The error of eight readings is below b6, that of six and eight is taken as
    b6, that of four as b4.

    Motion is resolved if the usual step h is at most 0.5 s; or if h is at most 2.2 s and the
    kernels converge: b6 <= 0.06 b4, or b4 <= 0.08 b2, or b6 <= 0.0066 norm^2. Motion faster than
    that looks slow to readings so seldom.

    References
    ----------
    E.21 of ``docs/diagnostics.md``.

    Examples
    --------
    >>> counts = {LedgerKey.PAIRED: 10, LedgerKey.BRIDGED_8: 10, LedgerKey.COMPARED: 10,
    ...           LedgerKey.STEP: 10 * 10 ** 6, LedgerKey.APART_6: 10 * 10 ** 4,
    ...           LedgerKey.APART_4: 10 * 10 ** 6, LedgerKey.APART_2: 10 * 10 ** 7}
    >>> error = estimate_interpolation_error(counts, 0.1)
    >>> error.is_resolved, round(error.variance_deg2, 9), error.step_s
    (True, 1e-05, 1.0)

    """
    readings = {n: counts[key] for n, key in _BRIDGED.items() if counts.get(key)}
    n_bridged, paired = sum(readings.values()), counts.get(LedgerKey.PAIRED, 0)
    if not n_bridged or not paired:
        return InterpolationError(kind='none', variance_deg2=0.0, is_resolved=True,
                                  readings=readings)
    step_s = counts.get(LedgerKey.STEP, 0) / 1e6 / n_bridged
    compared = counts.get(LedgerKey.COMPARED, 0)
    if not compared:
        # A fast sensor needs no comparison.
        is_fast = step_s <= _ALWAYS_S
        return InterpolationError(kind='estimated', variance_deg2=0.0 if is_fast else None,
                                  is_resolved=is_fast, step_s=step_s, readings=readings,
                                  is_line=is_line)
    six, four, two = (counts.get(key, 0) * APART_DEG2 / compared for key in
                      (LedgerKey.APART_6, LedgerKey.APART_4, LedgerKey.APART_2))
    by = {8: six, 6: six, 4: four, 2: two}
    added = sum(n * by[size] for size, n in readings.items()) / paired
    is_resolved = step_s <= _ALWAYS_S or (step_s <= _NEVER_S and (
        six <= _SIX_TO_FOUR * four or four <= _FOUR_TO_TWO * two
        or six <= _SHARE_OF_NORM * norm_deg ** 2))
    return InterpolationError(kind='estimated', variance_deg2=added, is_resolved=is_resolved,
                              step_s=step_s, readings=readings,
                              line_deg2=two * n_bridged / paired, is_line=is_line)
