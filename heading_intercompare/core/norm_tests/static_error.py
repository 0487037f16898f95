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

"""The static error: the mean difference on steady headings, on the worst of them."""

from __future__ import annotations

from dataclasses import replace
import math

from heading_intercompare.core.diagnostics.by_motion import BySector

from .judged_test import Measurement
from .tested_run import exceeding, NORMAL_QUANTILE, reach, TestedRun

LEAST_HEADINGS = 4
"""Sectors of 45 degrees that a static error must have been measured on, ISO 22090-2."""


def measure_static_error(tested: TestedRun, limit: float) -> Measurement:
    """
    Return the size of the mean difference in the sector of headings that speaks most against it.

    Notes
    -----
    The sectors hold steady headings alone. A sensor meets the test if every sector does, on at
    least four. The risk of a false rejection is shared among the sectors. The figure is that of
    the sector most surely above the limit; where none is above, of the largest difference.

    References
    ----------
    MSC.116(73) 3.6 and 4.3.2.2; ISO 22090-2.

    """
    means = [] if tested.by_motion is None else _list_means(tested.by_motion.sectors)
    if len(means) < LEAST_HEADINGS:
        return _measure_run(tested, limit, f'{len(means)} of 8 sectors of headings')
    offset_u = tested.settings.installation_offset_u_deg
    measured = [measure_mean(tested, mean, math.hypot(u, offset_u), math.inf, limit,
                             f'{len(means)} of 8 sectors; most at {heading:03.0f} deg',
                             len(means)) for heading, mean, u in means]
    worst = min(measured, key=lambda sector: (sector.risk_not_met or 0.0, -(sector.value or 0.0)))
    return replace(worst, high=max(sector.high or 0.0 for sector in measured))


def _list_means(sectors: BySector) -> list[tuple[float, float, float]]:
    """Return heading, mean difference and its standard uncertainty where that is known."""
    return [(heading, mean, 0.5 * (up - low) / NORMAL_QUANTILE)
            for heading, mean, low, up in zip(sectors.heading_deg, sectors.mean_deg,
                                              sectors.low_deg, sectors.up_deg)
            if mean is not None and low is not None and up is not None]


def _measure_run(tested: TestedRun, limit: float, record: str) -> Measurement:
    """Return the size of the mean difference of a run, which may break a test but not meet it."""
    if tested.mean_deg is None or tested.mean_u_deg is None:
        return Measurement(record=record)
    return replace(measure_mean(tested, tested.mean_deg, tested.mean_u_deg, tested.mean_nu, limit,
                                record), sailed=False)


def measure_mean(tested: TestedRun, mean_deg: float, u_deg: float, nu: float, limit: float,
                 record: str, means: int = 1) -> Measurement:
    """
    Return what one of several mean differences shows of a systematic error.

    The error may exceed its limit on either side, so half of the risk of a false rejection
    belongs to each.
    """
    size, risks = abs(mean_deg), tested.risks
    risk = 2.0 * means * exceeding((size - limit) / u_deg, nu) if u_deg > 0.0 else float(
        size <= limit)
    unless = '' if tested.is_mounting_stated else (
        f'the sensors are mounted {mean_deg:.2f} deg apart: state installation_offset_deg and '
        'installation_offset_u_deg')
    return Measurement(
        size, max(0.0, size - reach(0.5 * risks.not_met / means, nu) * u_deg),
        size + reach(risks.met, nu) * u_deg, min(1.0, risk), True,
        record if u_deg == 0.0 else f'{record}, u = {u_deg:.2g} deg', unless)
