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

"""The condition that the ship moves enough to show that the sensors work."""

from __future__ import annotations

from heading_intercompare.core.conditions.standstill import find_standstill
from heading_intercompare.core.validity.condition import (
    Condition,
    DOUBTFUL,
    Finding,
    HOLDS,
    NOT_TESTABLE,
)
from heading_intercompare.core.validity.examined import Examined


def _judge(e: Examined) -> Finding:
    standstill = find_standstill(e.columns.ts_deg, e.columns.rs_deg)
    if standstill.kind == 'not_testable':
        return STANDSTILL.find(NOT_TESTABLE, '', 'there are too few readings')
    ranges = (f'the headings range over {standstill.ts_range_deg:.3g} deg (TS) and '
              f'{standstill.rs_range_deg:.3g} deg (RS)')
    if standstill.kind == 'still':
        return STANDSTILL.find(DOUBTFUL, 'motion too small to tell', f'{ranges}: too '
                               'little to show whether the sensors work')
    return STANDSTILL.find(HOLDS, '', ranges)


STANDSTILL = Condition(
    name='standstill',
    holds='the ship moves enough to show that the sensors work',
    doubtful_when='both sensors hardly change, so nobody can see whether they work',
    judge=_judge)
