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

"""Which tests of a norm a planned trial can decide, and what to sail for each."""

from __future__ import annotations

from dataclasses import dataclass
import math

from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.decision.norm_presets import list_required
from heading_intercompare.core.required_tests import KINDS, RequiredTest, SYSTEMATIC
from heading_intercompare.core.settings import Settings

from .dynamic_error import SLOWEST_STEP_S
from .tested_run import NORMAL_QUANTILE, reach

#: The trial is to show that a TS at this share of each limit meets it.
_LEVEL = 0.7


@dataclass(frozen=True, slots=True)
class PlannedTest:
    """
    A test of the norm in a planned trial; keys of the JSON.

    Attributes
    ----------
    words, clause, limit, unit
        As for a judged test.
    manoeuvre
        What to sail or to wait for.
    least_s
        How long that takes at least, seconds.
    obstacle
        Why this trial cannot decide it, and what would; empty if it can.

    """

    words: str
    clause: str
    limit: float
    unit: str
    manoeuvre: str
    least_s: float
    obstacle: str


def plan_tests(settings: Settings, rate_hz: float) -> tuple[PlannedTest, ...]:
    """
    Return the tests that the norm requires, for a TS at 0.7 of each limit.

    Parameters
    ----------
    settings
        Norms, and how well the RS and the mounting angle are known.
    rate_hz
        Pairs per second.

    """
    return tuple(PlannedTest(
        test.words, test.clause, test.limit_at(settings.norms.latitude_deg),
        KINDS[test.kind].unit, test.manoeuvre, KINDS[test.kind].least_s,
        _find_obstacle(test, settings, rate_hz)) for test in list_required(settings.norms))


def _find_obstacle(test: RequiredTest, settings: Settings, rate_hz: float) -> str:
    limit = test.limit_at(settings.norms.latitude_deg)
    if not KINDS[test.kind].is_judged:
        return 'a record of headings does not decide it'
    if test.kind == 'fast_dynamic_error' and rate_hz * SLOWEST_STEP_S < 1.0:
        return f'pairs come every {1.0 / rate_hz:g} s, not every {SLOWEST_STEP_S:g} s'
    if test.kind in ('dynamic_error', 'fast_dynamic_error'):
        return _find_coarse_reference(limit, settings)
    if test.kind == 'follow_up' and (
            settings.alignment.skew == 'apply' or settings.alignment.skew_s):
        return 'alignment removes a skew, and the lag with it'
    if test.kind in SYSTEMATIC:
        room_deg = (1.0 - _LEVEL) * limit
        factor = reach(settings.risk.alpha_consumer, math.inf)
        u_deg = settings.installation_offset_u_deg
        if factor * u_deg > room_deg:
            return (f'the mounting angle is known to {u_deg:g} deg; it needs '
                    f'{room_deg / factor:.2g} deg')
    return ''


def _find_coarse_reference(limit_deg: float, settings: Settings) -> str:
    """Say which RS the amplitude of the dynamic error needs; empty if this one serves."""
    limits = Limits.of(settings.norms, settings.model)
    spread = limits.m_up ** 2 - limits.m_low ** 2
    most_deg2 = (1.0 - _LEVEL ** 2) * limit_deg ** 2
    unknown_deg2 = spread * (NORMAL_QUANTILE * limits.sigma_ref_max_deg) ** 2
    if unknown_deg2 <= most_deg2:
        return ''
    needed_deg = (most_deg2 / spread) ** 0.5 / NORMAL_QUANTILE
    return (f'needs an RS of {needed_deg:.2g} deg, or a known one '
            f'(norms.sigma_ref_deg); this has {limits.sigma_ref_max_deg:g} deg')
