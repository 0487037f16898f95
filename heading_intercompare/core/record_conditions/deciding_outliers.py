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

"""The condition that no single reading decides the outcome."""

from __future__ import annotations

import numpy as np

from heading_intercompare.core.conditions.outliers import find_outliers
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.validity.condition import (
    Condition,
    DOUBTFUL,
    Finding,
    HOLDS,
    NOT_TESTABLE,
)
from heading_intercompare.core.validity.examined import Examined

LONGEST_BURST_S = 60.0
"""Longest excursion of the difference that counts as an outlier, not a slow error; seconds."""
_MOST_NAMED = 3


def _judge(e: Examined) -> Finding:
    c = e.columns
    outliers = find_outliers(c.stamp_ns, c.series_deg, longest_s=LONGEST_BURST_S,
                             step_deg=max(step.step_deg or 0.0 for step in c.steps))
    if outliers.kind == 'not_testable':
        return OUTLIERS.find(NOT_TESTABLE, '', 'there are too few differences')
    if outliers.kind == 'none':
        return OUTLIERS.find(HOLDS, '', 'no isolated difference stands out')
    largest = ', '.join(f'{outlier.size_deg:+.3g} deg at {utc(outlier.stamp_ns)} UTC'
                        for outlier in outliers.largest[:_MOST_NAMED])
    count = f'{outliers.count} isolated outlier{"s" if outliers.count != 1 else ""}'
    evidence = f'{count}, {100.0 * outliers.share:.3g} % of the variance: {largest}'
    without = e.decide(np.delete(c.stamp_ns, outliers.index), np.delete(c.x_deg, outliers.index))
    if without is e.outcome:
        return OUTLIERS.find(HOLDS, '', f'{evidence}; the outcome is the same without them')
    return OUTLIERS.find(DOUBTFUL, f'{count} decide{"s" if outliers.count == 1 else ""}',
                         f'{evidence}; without them the outcome is {without.words}')


OUTLIERS = Condition(
    name='outliers',
    holds='no single reading decides',
    doubtful_when='without them the outcome would differ',
    judge=_judge, watched_by=('outliers',))
