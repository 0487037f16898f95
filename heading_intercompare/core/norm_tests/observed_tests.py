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

"""The tests of a norm that observations of the true heading decide."""

from __future__ import annotations

from heading_intercompare.core.decision.norm_presets import list_required
from heading_intercompare.core.observations.systematic_error import SystematicError
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.required_tests import SYSTEMATIC
from heading_intercompare.core.settings import Settings

from .judged_test import judge_measurement, JudgedTest, Measurement, TestRisks


def judge_observed(error: SystematicError, settings: Settings) -> tuple[JudgedTest, ...]:
    """
    Return the tests of the systematic error that a norm requires: settle point or static error.

    Parameters
    ----------
    error
        What the observations say of it; its outcome is the result of the test.
    settings
        With the norm.

    """
    size = None if error.correction_deg is None else abs(error.correction_deg)
    is_broken = error.outcome is Outcome.NON_COMPLIANT
    measured = Measurement(size, error.low_deg, error.high_deg, 0.0 if is_broken else 1.0,
                           error.reason not in ('insufficient_data', 'void.mean_difference',
                                                'outliers_decide'),
                           f'{error.n} observations')
    risks = TestRisks.of(settings.risk, 1)
    return tuple(judge_measurement(test, test.limit_at(settings.norms.latitude_deg), measured,
                                   risks)
                 for test in list_required(settings.norms) if test.kind in SYSTEMATIC)
