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

"""The condition that the TS reports finely enough for its norm, or that its rounding shows."""

from __future__ import annotations

import numpy as np

from heading_intercompare.core.conditions.standstill import find_coarse_resolution
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.validity.condition import (
    Condition,
    Finding,
    HOLDS,
    NOT_TESTABLE,
    VOID,
)
from heading_intercompare.core.validity.examined import Examined, RunAccount

_FEW_VALUES, _LOOKED_AT = 3, 100_000


def _judge(e: Examined) -> Finding:
    """Judge a TS of one or two values by their decimals; any other by its changes, later."""
    ts_deg = np.round(e.columns.ts_deg[:_LOOKED_AT], 7)
    step_deg = find_coarse_resolution(ts_deg) if np.unique(ts_deg).size < _FEW_VALUES else None
    if step_deg is None:
        return RESOLUTION.find(NOT_TESTABLE, '', 'no step of the TS is known')
    return _weigh(e, step_deg, 0.0)


def _settle(finding: Finding | None, account: RunAccount) -> Finding | None:
    """Judge the TS by the changes of value that it sent."""
    step_deg, normality = account.step_deg('ts'), account.normality
    if finding is None or finding.effect == VOID:
        return finding
    if step_deg is not None and normality is not None:
        return _weigh(account, step_deg, normality.ts_step_seen_deg)
    if account.inside is not None and account.inside.changes('ts'):
        return RESOLUTION.find(HOLDS, '', 'the TS reports in steps finer than 0.01 deg')
    return finding


def _weigh(run: Examined | RunAccount, step_deg: float, seen_deg: float) -> Finding:
    """Judge a step by the outcome with the variance that rounding to it adds."""
    rounding_deg2, upper_deg2 = step_deg ** 2 / 12.0, run.guarded.upper_bound_deg2
    evidence = (f'the TS reports in steps of {step_deg:g} deg, which are {rounding_deg2:.2g} deg2 '
                'of variance')
    if step_deg <= seen_deg:
        return RESOLUTION.find(HOLDS, '', f'{evidence}, and the motion shows that')
    evidence += ', which the motion does not show'
    least_deg2 = run.limits.tightened_limit_deg2
    breaks = rounding_deg2 > run.limits.sigma_max_deg ** 2
    if run.outcome is Outcome.COMPLIANT and upper_deg2 is not None and (
            upper_deg2 + rounding_deg2 > least_deg2) or (
            run.outcome is Outcome.INDETERMINATE and breaks):
        return RESOLUTION.find(
            VOID, f'the TS reports in steps of {step_deg:g} deg, and the ship moves too little to '
            'show what they add', f'{evidence}; with it the variance may reach '
            f'{(upper_deg2 or 0.0) + rounding_deg2:.2g} deg2, above the acceptance limit of '
            f'{least_deg2:.2g} deg2')
    return RESOLUTION.find(HOLDS, '', f'{evidence}; with it the outcome is the same')


RESOLUTION = Condition(
    name='resolution',
    holds='the steps of the TS are fine enough, or show in the differences',
    void='void: the TS reports in steps so coarse that they decide, and the motion does not show '
         'them',
    void_when='the ship moves by less than 0.3 of the step in which the TS reports, as on a '
              'steady course, so that rounding hardly shows, and with the variance of rounding, '
              'step²/12, the run would not comply',
    void_why='on another course the error of rounding is another one, up to half a step',
    judge=_judge, settle=_settle)
