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

"""What the conditions of a run are judged by: its pairs, then the account of its readings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Sequence

from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.decision.guarded import Guarded
from heading_intercompare.core.diagnostics.run_columns import RunColumns
from heading_intercompare.core.diagnostics.run_diagnostics import Diagnostics
from heading_intercompare.core.diagnostics.sensor_quality import QualityCheck
from heading_intercompare.core.motion.motion_check import MotionCheck
from heading_intercompare.core.norm_tests.judged_test import JudgedTest
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.pairing.ledger import LedgerSegment
from heading_intercompare.core.raw_streams.decimal_steps import find_decimal_step
from heading_intercompare.core.records import Reals
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.statistics.normality import Normality
from heading_intercompare.core.timing.realignment import realign

from .condition import Finding


@dataclass(frozen=True, slots=True)
class Examined:
    """
    A run at its end, as its pairs show it.

    Attributes
    ----------
    columns
        The analysed pairs, and what the detectors share.
    outcome
        Outcome of the run as it is, before any finding.
    guarded
        The decision, with the variance and its bounds.
    decide
        ``decide(stamp_ns, x_deg, rs_factor=1.0, **changes)`` returns the outcome of other
        differences under the same rule. `rs_factor` is the factor by which interpolation reduced
        the variance of the RS noise; `changes` are settings, such as another variant or model.
    motion
        The headings against the motion of the ship; None if it is unknown.
    quality
        What the sensors say of their readings; None if they say nothing.
    findings
        Findings on the conditions judged before.

    """

    columns: RunColumns
    diagnostics: Diagnostics
    settings: Settings
    outcome: Outcome
    guarded: Guarded
    decide: Callable[..., Outcome]
    motion: MotionCheck | None = None
    quality: QualityCheck | None = None
    findings: tuple[Finding, ...] = ()

    @property
    def limits(self) -> Limits:
        """Return the limits of the decision."""
        return self.columns.limits

    def decide_without_skew(self, late_s: float | Reals) -> Outcome:
        """
        Return the outcome with the RS read `late_s` earlier, which removes a skew.

        A compliant run stays compliant: a skew only adds to the variance.
        """
        if self.outcome is Outcome.COMPLIANT:
            return self.outcome
        c = self.columns
        return self.decide(*realign(c.stamp_ns, c.x_deg, c.rs_deg, late_s))


@dataclass(frozen=True, slots=True)
class RunAccount:
    """
    The fate of the readings of a run, and what else is known once its pairs are judged.

    Attributes
    ----------
    outcome
        Outcome of the run as it is, before any finding.
    lost_share
        Share of pairs missing in the gaps between pairs; None if unknown.
    interpolated
        The sensor that was interpolated, 'ts' or 'rs'; None for none or both.
    share, inside
        Ledger of the readings of the run, and of those between its first and last pair. None as
        long as unknown, as at a look.
    normality
        Holds the steps of both sensors as paired, and those whose rounding would show.
    tests
        The tests that the norm requires.

    """

    outcome: Outcome
    guarded: Guarded
    limits: Limits
    settings: Settings
    lost_share: float | None
    interpolated: str | None
    share: LedgerSegment | None = None
    inside: LedgerSegment | None = None
    normality: Normality | None = None
    tests: Sequence[JudgedTest] = ()

    def step_deg(self, stream: str) -> float | None:
        """Return the step in which ``'ts'`` or ``'rs'`` reports, degrees; None if unknown."""
        if self.inside is not None:
            return find_decimal_step(self.inside.changes(stream))
        return None if self.normality is None else getattr(self.normality, f'{stream}_step_deg')
