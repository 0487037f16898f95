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

"""The condition that the slower sensor is fast enough for the motion."""

from __future__ import annotations

import numpy as np

from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.timing.interpolation_error import estimate_interpolation_error
from heading_intercompare.core.validity.condition import (
    Condition,
    Finding,
    HOLDS,
    NOT_TESTABLE,
    VOID,
)
from heading_intercompare.core.validity.examined import Examined

__all__ = ['INTERPOLATION']


def _judge(e: Examined) -> Finding:
    c = e.columns
    both = (c.ts_deg, c.rs_deg) if c.interpolates_ts else (c.rs_deg, c.ts_deg)
    error = estimate_interpolation_error(
        c.stamp_ns, *both, np.ones(c.n) if c.factor is None else c.factor)
    if error.kind == 'none':
        return INTERPOLATION.find(HOLDS, '', 'no reading is interpolated')
    if error.kind == 'not_testable' or error.upper_deg2 is None:
        return INTERPOLATION.find(NOT_TESTABLE, '', 'these pairs do not show how much '
                                  'interpolation adds')
    evidence = (f'interpolation adds {error.variance_deg2:.2g} deg2 to the variance, at most '
                f'{error.upper_deg2:.2g} deg2')
    if error.folded:
        evidence += '; the motion is so fast that the readings hardly show it'
    if _would_decide(e, error.upper_deg2, error.folded):
        return INTERPOLATION.find(VOID, 'the slower sensor is too slow for the motion',
                                  f'{evidence}: without this the outcome might differ')
    return INTERPOLATION.find(HOLDS, '', f'{evidence}; the outcome is the same without this')


def _would_decide(e: Examined, added_deg2: float, folded: bool) -> bool:
    """Tell whether the outcome might differ without the variance that interpolation adds."""
    d_hat_deg2, lower_deg2, upper_deg2 = (
        e.guarded.d_hat_deg2, e.guarded.lower_bound_deg2, e.guarded.upper_bound_deg2)
    if (lower_deg2 is None or upper_deg2 is None or not d_hat_deg2
            or e.outcome is Outcome.COMPLIANT):
        return False
    share = 0.0 if folded else max(0.0, 1.0 - added_deg2 / d_hat_deg2)
    if e.outcome is Outcome.NON_COMPLIANT:
        return share * lower_deg2 <= e.limits.rejection_limit_deg2 < lower_deg2
    return not folded and (share * upper_deg2 <= e.limits.tightened_limit_deg2 < upper_deg2)


INTERPOLATION = Condition(
    name='interpolation',
    holds='the slower sensor is fast enough for the motion',
    void='void: the slower sensor is too slow for the motion, and that decides the outcome',
    void_when='the slower sensor is too slow for the motion, and without the interpolation error '
              'the outcome would differ',
    void_why='the difference comes from the method',
    judge=_judge, is_permanent=True)
