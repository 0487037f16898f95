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

"""The condition that the interpolated sensor is fast enough for the motion."""

from __future__ import annotations

from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.timing.interpolation_error import (
    estimate_interpolation_error,
    InterpolationError,
)
from heading_intercompare.core.validity.condition import (
    Condition,
    Finding,
    HOLDS,
    NOT_TESTABLE,
    VOID,
)
from heading_intercompare.core.validity.examined import RunAccount

#: A smaller share of the limit A matters to no open run.
_MATTERS = 0.1
#: The line certifies nothing if it lacks motion of a larger share of A.
_LINE_SHARE = 0.02
#: Motion is resolved if its period has this number of steps or more.
_FASTEST_STEPS = 3.3


def _settle(finding: Finding | None, account: RunAccount) -> Finding:
    """Judge what interpolation adds; before the account is known, nothing shows it."""
    error = InterpolationError('none' if account.interpolated is None else 'not_testable')
    if account.inside is not None:
        limits = account.limits
        estimated = estimate_interpolation_error(
            account.inside.counts,
            limits.sigma_max_deg if account.interpolated == 'ts' else limits.sigma_ref_max_deg,
            is_line=account.settings.pairing.kernel == 'line')
        error = error if estimated.kind == 'none' else estimated
    return judge_interpolation(error, account)


def judge_interpolation(error: InterpolationError, account: RunAccount) -> Finding:
    """
    Judge whether interpolation, not the TS, decides.

    Parameters
    ----------
    error
        What interpolation adds to the variance.
    account
        Uses the outcome, the bounds L and U of the variance, and the limits A and R.

    Notes
    -----
    With b the variance added and b_u its upper bound, a rejection is void unless L > R + b_u. An
    open run is void if U - b_u <= A < D, and b > 0.1 A or the motion is not resolved. A
    certificate stands, for interpolation by a kernel only adds. The line also takes motion from
    both sensors, and so hides errors of the TS.

    """
    if error.kind == 'none':
        return INTERPOLATION.find(HOLDS, '', 'no reading is interpolated')
    if error.kind == 'not_testable' or error.step_s is None:
        return INTERPOLATION.find(NOT_TESTABLE, '', 'these pairs do not show how much '
                                  'interpolation adds')
    limits, guarded = account.limits, account.guarded
    least, most = limits.tightened_limit_deg2, limits.rejection_limit_deg2
    evidence = (f'interpolated between readings {error.step_s:.3g} s apart, '
                f'{_describe_addition(error)}')
    if account.outcome is Outcome.COMPLIANT:
        if error.is_line and (error.line_deg2 is None or error.line_deg2 > _LINE_SHARE * least):
            return INTERPOLATION.find(
                VOID, 'the line between two readings hides motion', f'{evidence}; it takes motion '
                'from both sensors, and so may hide errors of the TS, which pairing.kernel '
                'band_limited does not')
        scope = '' if error.is_resolved else ('not how the TS follows motion faster than '
                                              f'{_FASTEST_STEPS * error.step_s:.2g} s')
        return INTERPOLATION.find(HOLDS, scope, evidence)
    low, high = guarded.lower_bound_deg2, guarded.upper_bound_deg2
    decides = not error.is_resolved or error.variance_deg2 is None or (
        error.variance_deg2 > _MATTERS * least)
    if account.outcome is Outcome.INDETERMINATE:
        # Where the variance itself passes, more data decide, whatever interpolation adds.
        decides = (decides and high is not None and high - error.upper_deg2 <= least < high
                   and (guarded.d_hat_deg2 or 0.0) > least)
    elif low is not None and low > most:
        decides = low <= most + error.upper_deg2
    if decides:
        return INTERPOLATION.find(VOID, 'the slower sensor is too slow for the motion',
                                  f'{evidence}: without this the outcome might differ')
    return INTERPOLATION.find(HOLDS, '', f'{evidence}; the outcome is the same without this')


def _describe_addition(error: InterpolationError) -> str:
    if not error.is_resolved:
        return 'which come too seldom to show the motion between them'
    if error.variance_deg2:
        return (f'which adds {error.variance_deg2:.2g} deg2 to the variance, at most '
                f'{error.upper_deg2:.2g} deg2')
    return 'which no motion of a ship outruns'


INTERPOLATION = Condition(
    name='interpolation',
    holds='the slower sensor is fast enough for the motion',
    void='void: the slower sensor is too slow for the motion, and that decides the outcome',
    void_when='the slower sensor is too slow for the motion, and without the interpolation error '
              'the outcome might differ; or `pairing.kernel` is `line`, the run would comply, and '
              'the line lacks motion of more than a fiftieth of the limit',
    void_why='the difference comes from the method, or the method hides it',
    settle=_settle, also_said='certificate', is_permanent=True)
