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

"""
The conditions of a comparison in the order of cause, and their findings on a run.

A condition counts by what it could change, not by its significance: in twelve hours everything is
significant.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Sequence

from heading_intercompare.core.record_conditions.assumptions import ASSUMPTIONS
from heading_intercompare.core.record_conditions.clocks import CLOCKS
from heading_intercompare.core.record_conditions.deciding_outliers import OUTLIERS
from heading_intercompare.core.record_conditions.drift_removed import DRIFT_REMOVED
from heading_intercompare.core.record_conditions.interpolation import INTERPOLATION
from heading_intercompare.core.record_conditions.left_out import LEFT_OUT
from heading_intercompare.core.record_conditions.losses import LOSSES
from heading_intercompare.core.record_conditions.mean_over_runs import MEAN_OVER_RUNS
from heading_intercompare.core.record_conditions.norm_tests import NORM_TESTS
from heading_intercompare.core.record_conditions.reduced_quality import REDUCED_QUALITY
from heading_intercompare.core.record_conditions.repeated_readings import REPEATED_READINGS
from heading_intercompare.core.sensor_conditions.convention import CONVENTION
from heading_intercompare.core.sensor_conditions.enough_motion import STANDSTILL
from heading_intercompare.core.sensor_conditions.enough_resolution import RESOLUTION
from heading_intercompare.core.sensor_conditions.frozen import FROZEN
from heading_intercompare.core.sensor_conditions.mean_difference import MEAN_DIFFERENCE
from heading_intercompare.core.sensor_conditions.motion import MOTION
from heading_intercompare.core.sensor_conditions.parting import PARTING
from heading_intercompare.core.sensor_conditions.reference import REFERENCE
from heading_intercompare.core.sensor_conditions.same_source import SAME_SOURCE
from heading_intercompare.core.validity.condition import Finding
from heading_intercompare.core.validity.examined import Examined, RunAccount

CONDITIONS = (SAME_SOURCE, CLOCKS, FROZEN, MOTION, CONVENTION, MEAN_DIFFERENCE, PARTING,
              REFERENCE, RESOLUTION, STANDSTILL, OUTLIERS, REDUCED_QUALITY, INTERPOLATION,
              REPEATED_READINGS, DRIFT_REMOVED, ASSUMPTIONS, LOSSES, MEAN_OVER_RUNS, LEFT_OUT,
              NORM_TESTS)
"""
All conditions, causes before their consequences; the first that makes a run void is its reason.

A run has a finding on `motion` only if the motion of the ship is known, on `reduced_quality` only
if a sensor says something of its readings, on `drift_removed` only if a drift is removed, and on
`norm_tests` only if the norm requires tests. The findings on `mean_over_runs` and `left_out` are
those of all runs.
"""

CONDITION_WORDS = {condition.name: condition.holds for condition in CONDITIONS}
"""What is true if a condition holds, by its name."""

VOID_REASONS = {f'void.{condition.name}': condition.void for condition in CONDITIONS
                if condition.void}
"""Reasons why a run is void: code and words."""

PERMANENT = frozenset(f'void.{condition.name}' for condition in CONDITIONS
                      if condition.is_permanent)
"""Reasons that make a run void from its beginning: the set-up of the sensors."""


def examine(examined: Examined) -> tuple[Finding, ...]:
    """Return the findings on the pairs of a run, in the order of `CONDITIONS`."""
    findings: dict[str, Finding] = {}
    for condition in sorted(CONDITIONS, key=lambda condition: condition.weighs_others):
        if condition.judge is not None:
            finding = condition.judge(replace(examined, findings=tuple(findings.values())))
            if finding is not None:
                findings[condition.name] = finding
    return tuple(findings[name] for name in CONDITION_WORDS if name in findings)


def settle(findings: Sequence[Finding], account: RunAccount) -> tuple[Finding, ...]:
    """Return the findings on a run once the account of its readings is known."""
    by_name = {finding.condition: finding for finding in findings}
    for condition in CONDITIONS:
        if condition.settle is not None:
            finding = condition.settle(by_name.get(condition.name), account)
            if finding is not None:
                by_name[condition.name] = finding
    return tuple(by_name[name] for name in CONDITION_WORDS if name in by_name)
