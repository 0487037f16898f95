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

"""The run that the tests of a norm are judged on."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
import math

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.diagnostics.by_motion import ByMotion
from heading_intercompare.core.diagnostics.run_columns import RunColumns
from heading_intercompare.core.runs.run_series import RunSeries
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.statistics.blocking import student_quantile

from .judged_test import TestRisks
from .sets_of_ten import find_sets, SetOfTen

NORMAL_QUANTILE = 1.959963984540054
"""Reach of 95 % of normal errors, in their standard deviations."""

NO_SETS = 'no ten readings every 20 min on one heading after settling'


@dataclass(frozen=True)
class TestedRun:
    """
    A run as its tests see it.

    Attributes
    ----------
    columns
        The analysed pairs, and what the detectors share.
    mean_deg, mean_u_deg
        Mean difference, and its standard uncertainty with that of the installation angle,
        degrees; None if unknown.
    mean_nu
        Degrees of freedom of that uncertainty.
    by_motion
        The differences by heading and by rate of turn; None for fewer than 64.
    risks
        Of each test.
    run
        With the readings that an automatic stabilisation period leaves out.

    """

    __test__ = False

    columns: RunColumns
    mean_deg: float | None
    mean_u_deg: float | None
    mean_nu: float
    by_motion: ByMotion | None
    risks: TestRisks
    run: RunSeries

    @cached_property
    def sets_of_ten(self) -> tuple[SetOfTen, ...]:
        """Return sets of ten readings, one every 20 min."""
        columns = self.columns
        return find_sets(columns.stamp_ns, columns.x_deg, columns.rs_deg)

    @property
    def settings(self) -> Settings:
        """Return the settings that the run is judged by."""
        return self.columns.settings

    @property
    def is_mounting_stated(self) -> bool:
        """Whether the angle between the sensors is known: stated, or its mean known as zero."""
        settings = self.settings
        return (settings.variant == 'A' or settings.installation_offset_deg != 0.0
                or settings.installation_offset_u_deg > 0.0)

    def reference_deg(self, upper: bool) -> float:
        """Return the most, or the least, standard deviation of the RS, degrees."""
        limits = self.columns.limits
        return (limits.m_up if upper else limits.m_low) * limits.sigma_ref_max_deg


def reach(alpha: float, nu: float) -> float:
    """Return the quantile of Student's distribution beyond which the probability is alpha."""
    return -student_quantile(alpha, nu)


def exceeding(t: float, nu: float) -> float:
    """Return the probability that Student's variable exceeds t."""
    return float(scipy.special.ndtr(-t) if math.isinf(nu) else scipy.special.stdtr(nu, -t))
