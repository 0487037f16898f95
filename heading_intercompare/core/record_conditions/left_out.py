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

"""The condition that nothing that is left out of the runs makes the verdict better."""

from __future__ import annotations

from heading_intercompare.core.decision.taken_out import TakenOut
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.validity.condition import (
    Condition,
    DOUBTFUL,
    Finding,
    HOLDS,
    NOT_TESTABLE,
)

NAMED_SHARE = 0.01
"""From this share on, the headline says what is left out even if it does not decide."""

LEFT_OUT = Condition(
    name='left_out',
    holds='nothing that is left out of the runs decides',
    doubtful_when='marks, a table of runs, the stabilisation period, the least duration or '
                  'exclusions leave out pairs, and all pairs of the record together give another '
                  'outcome; a warm-up that the data show does not count, nor the time in which '
                  'a sensor of its class settles. The headline gives the share and the outcome as '
                  'recorded', also_said='always')


def judge_left_out(outcome: Outcome, left_out: TakenOut, by_hand: bool) -> Finding:
    """
    Judge the verdict as set beside the verdict as recorded.

    Parameters
    ----------
    outcome
        As set.
    left_out
        What was left out, with the outcome as recorded.
    by_hand
        Whether a person took something out, which the headline always says.

    Returns
    -------
    Finding
        An open outcome is not in doubt, and a broken norm stays broken in a record that is open.

    """
    if left_out.as_recorded is None:
        return LEFT_OUT.find(NOT_TESTABLE, '', f'{left_out.n} pairs are left out; the outcome as '
                             'recorded is unknown')
    recorded = left_out.as_recorded.outcome
    reasons = ', '.join(dict.fromkeys(s.reason for s in left_out.stretches if s.n))
    share = f'{_percent(left_out.share)} % of the pairs are left out ({reasons})'
    evidence = f'{left_out.n} pairs, {share}; as recorded {recorded.words}'
    decides = recorded is not outcome and outcome is not Outcome.INDETERMINATE and not (
        outcome is Outcome.NON_COMPLIANT and recorded is Outcome.INDETERMINATE)
    if decides:
        return LEFT_OUT.find(DOUBTFUL, f'{share}, as recorded {recorded.words}', evidence)
    is_said = by_hand or left_out.share >= NAMED_SHARE
    return LEFT_OUT.find(HOLDS, f'{share}, as recorded {recorded.words}' if is_said else '',
                         evidence)


def _percent(share: float) -> str:
    """Return a share in percent with two digits, and 100 for all that rounds to it."""
    return '100' if share >= 0.995 else f'{100.0 * share:.2g}'
