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

"""The correction of the heading that a run gives: what to add to the TS to agree with the RS."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Iterable

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.statistics.blocking import student_95
from heading_intercompare.core.validity.condition import VOID

from .history import is_charted
from .run_row import RunRow


@dataclass(frozen=True, slots=True)
class HeadingCorrection:
    """
    The correction that a run gives: RS - TS as measured, with the installation offset in it.

    Attributes
    ----------
    row
        The run.
    add_to_ts_deg
        To be added to the TS heading: minus the mean of TS - RS, within [-180, 180), degrees.
    low_deg, high_deg
        Its 95 % interval, degrees.
    coefficients_deg, u_deg
        A to E of the correction on each heading psi of the RS, to be added, too: A + B sin(psi)
        + C cos(psi) + D sin(2 psi) + E cos(2 psi); and their standard uncertainties. None unless
        a fit holds on every heading.

    """

    row: RunRow
    add_to_ts_deg: float
    low_deg: float
    high_deg: float
    coefficients_deg: tuple[float, ...] | None
    u_deg: tuple[float, ...] | None


def list_corrections(rows: Iterable[RunRow]) -> tuple[list[HeadingCorrection], dict[str, int]]:
    """
    Return the corrections of runs in their order, and how many runs give none, by the reason.

    A void run says nothing about the TS, so it gives none. Nor does a run without a mean and its
    uncertainty, nor a row of an old logbook, which lacks the installation offset.
    """
    corrections: list[HeadingCorrection] = []
    left_out: dict[str, int] = {}
    for row in rows:
        correction = _correct(row)
        if isinstance(correction, str):
            left_out[correction] = left_out.get(correction, 0) + 1
        else:
            corrections.append(correction)
    return corrections, left_out


def _correct(row: RunRow) -> HeadingCorrection | str:
    """Return the correction by a run, or why it gives none."""
    if row.validity_effect == VOID:
        return 'void'
    if not is_charted(row) or row.mean_u_deg is None or row.nu is None:
        return 'without a mean and its uncertainty'
    if row.measured_mean_deg is None or row.installation_offset_deg is None:
        return 'without the installation offset, from an old logbook'
    add_deg = float(wrap180(-row.measured_mean_deg))
    reach = student_95(row.nu) * row.mean_u_deg
    coefficients = u_deg = None
    fit = row.heading_dependence
    if fit is not None and fit.coefficients_deg is not None and fit.covariance_deg2 is not None:
        a, *waves = fit.coefficients_deg
        coefficients = (float(wrap180(-(a + row.installation_offset_deg))), *(-w for w in waves))
        u_deg = tuple(math.sqrt(max(line[at], 0.0)) for at, line in enumerate(fit.covariance_deg2))
    return HeadingCorrection(
        row=row, add_to_ts_deg=add_deg, low_deg=add_deg - reach, high_deg=add_deg + reach,
        coefficients_deg=coefficients, u_deg=u_deg)
