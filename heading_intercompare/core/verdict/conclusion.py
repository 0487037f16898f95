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

"""The outcome of a run, from variance, counts, norms, findings and looks together."""

from __future__ import annotations

import math
from typing import Sequence, TYPE_CHECKING

from heading_intercompare.core.decision.campaign import CAMPAIGN_REASONS
from heading_intercompare.core.decision.criteria import Printed
from heading_intercompare.core.decision.guarded import Guarded, REASONS
from heading_intercompare.core.decision.needed_length import describe_need, describe_need_together
from heading_intercompare.core.decision.sequential import find_rejection, LookVerdict
from heading_intercompare.core.norm_tests.judged_test import (
    find_not_met,
    JudgedTest,
    say_not_met,
)
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.record_conditions.deciding_outliers import OUTLIERS
from heading_intercompare.core.required_tests import KINDS
from heading_intercompare.core.validity.condition import (
    DOUBTFUL,
    Finding,
    gravest,
    VOID,
    worst_effect,
)

from .validity import PERMANENT, VOID_REASONS

if TYPE_CHECKING:
    from heading_intercompare.core.decision.coverage import Coverage

    from .verdict_document import Campaign, RunVerdict


ALL_REASONS = {
    **REASONS,
    'count_lower_bound_above_allowed': 'too many extreme differences, at the stated risk',
    'total_error_not_within_norm': 'the total error is not shown to be within its norm',
    'outliers_decide': 'a few outlying readings decide; without them the outcome would differ',
    'rejected_at_a_look': 'a look at the run in progress rejected, and a rejection stands',
    **{f'test_not_met.{name}': f'a test of the norm is not met: the {kind.words}'
       for name, kind in KINDS.items()},
    **VOID_REASONS,
}
"""Reasons for the outcome of a run: code and words."""


_REJECTS = ('lower_bound_above_rejection_limit', 'count_lower_bound_above_allowed',
            'rejected_at_a_look')
_TEST = 'test_not_met.'
_ACCEPTS = 'upper_bound_within_acceptance_limit'


def outcome_of_reason(reason: str) -> Outcome | None:
    """
    Return the only outcome of a run that a reason gives; None for a reason of another version.

    Examples
    --------
    >>> outcome_of_reason('void.clocks').value, outcome_of_reason('reason of 2040')
    ('indeterminate', None)

    """
    if reason not in ALL_REASONS:
        return None
    if reason == _ACCEPTS:
        return Outcome.COMPLIANT
    if reason in _REJECTS or reason.startswith(_TEST):
        return Outcome.NON_COMPLIANT
    return Outcome.INDETERMINATE


def conclude(guarded: Guarded, printed: Printed) -> tuple[Outcome, str]:
    """Return the outcome from variance, counts and total error, and its reason."""
    if guarded.outcome is Outcome.NON_COMPLIANT:
        return guarded.outcome, guarded.reason
    if guarded.count_outcome is Outcome.NON_COMPLIANT:
        return Outcome.NON_COMPLIANT, 'count_lower_bound_above_allowed'
    if (guarded.outcome is Outcome.COMPLIANT
            and printed.total.outcome not in (None, Outcome.COMPLIANT)):
        return Outcome.INDETERMINATE, 'total_error_not_within_norm'
    return guarded.outcome, guarded.reason


def with_tests(outcome: Outcome, reason: str,
               tests: Sequence[JudgedTest]) -> tuple[Outcome, str]:
    """
    Return outcome and reason after the tests of the norm.

    A test that is not met rejects; a variance that is rejected stays the reason.
    """
    broken = find_not_met(tests)
    if broken is None or outcome is Outcome.NON_COMPLIANT:
        return outcome, reason
    return Outcome.NON_COMPLIANT, f'{_TEST}{broken.kind}'


def with_findings(outcome: Outcome, reason: str,
                  findings: Sequence[Finding]) -> tuple[Outcome, str]:
    """
    Return outcome and reason after the findings.

    A void comparison says nothing about the TS, whatever its variance. If outliers decide, the
    reason of an indeterminate outcome says so.
    """
    for finding in findings:
        if finding.effect == VOID:
            return Outcome.INDETERMINATE, f'void.{finding.condition}'
    if outcome is Outcome.INDETERMINATE and any(
            f.condition == OUTLIERS.name and f.effect == DOUBTFUL for f in findings):
        return outcome, 'outliers_decide'
    return outcome, reason


def with_looks(outcome: Outcome, reason: str,
               looks: Sequence[LookVerdict]) -> tuple[Outcome, str]:
    """
    Return outcome and reason at the end of a run with looks.

    The worse of the looks and the end counts: a rejection at a look stands, an acceptance does
    not outlast later data against it. But a permanent reason that makes the comparison void also
    made it void at the look, even if it did not show yet.
    """
    if reason in PERMANENT:
        return outcome, reason
    if outcome is not Outcome.NON_COMPLIANT and find_rejection(looks) is not None:
        return Outcome.NON_COMPLIANT, 'rejected_at_a_look'
    return outcome, reason


def effect_with_looks(findings: Sequence[Finding], reason: str,
                      looks: Sequence[LookVerdict]) -> str:
    """Return the most serious effect, including that at the look that decided."""
    at_end, decided = worst_effect(findings), find_rejection(looks)
    if reason != 'rejected_at_a_look' or decided is None:
        return at_end
    return gravest((at_end, decided.validity_effect))


def explain(run: RunVerdict, reason: str | None = None) -> str:
    """
    Return why the outcome of a run is as it is, and what would decide it.

    Parameters
    ----------
    run
        The judged run.
    reason
        A reason to explain instead of that of the run.

    Returns
    -------
    str
        The reason in words. If the run is open, also the length of a run that would decide, or
        why no length does. A reason that is unknown, perhaps from a later version, as it is.

    """
    reason = run.reason if reason is None else reason
    words = ALL_REASONS.get(reason, reason)
    not_met = say_not_met(run.norm_tests or ())
    if not_met and outcome_of_reason(reason) is Outcome.NON_COMPLIANT:
        words = f'tests of the norm not met: {not_met}' if reason.startswith(_TEST) else (
            f'{words}; tests of the norm not met: {not_met}')
    line = run.drift.line
    interval = None if line is None else line.interval_deg_per_h
    need = describe_need(
        reason, run.guarded, run.coverage, n=run.n, drift_left_deg2=run.drift.left_deg2,
        drifts=None if interval is None else not interval[0] <= 0.0 <= interval[1],
        warm_up_s=0.0 if run.drift.warm_up is None else run.drift.warm_up.stabilization_s)
    return f'{words}; {need}' if need else words


def campaign_words(campaign: Campaign, runs: Sequence[RunVerdict],
                   coverage: Coverage | None) -> str:
    """
    Return why the outcome of several runs is as it is, and what would decide it.

    Parameters
    ----------
    campaign
        Outcome of all runs.
    runs
        The one that caused the outcome is named; of several open ones that which needs longest.
    coverage
        Coverage of the runs together; None if there is no run.

    """
    words = CAMPAIGN_REASONS.get(campaign.reason, campaign.reason)
    if campaign.reason == 'a_test_not_met':
        return f'{words}: {say_not_met(campaign.norm_tests or ())}'
    if campaign.rule == 'sensor':
        need = describe_need_together(campaign.reason, campaign.sensor, coverage)
        return f'{words}; {need}' if need else words
    blamed = {'a_run_indeterminate': Outcome.INDETERMINATE,
              'a_run_non_compliant': Outcome.NON_COMPLIANT}.get(campaign.reason)
    causes = [run for run in runs if run.outcome is blamed]
    if not causes:
        return words
    cause = max(causes, key=_hours_needed)
    return f'{words} (run {cause.run}: {explain(cause)})'


def _hours_needed(run: RunVerdict) -> float:
    hours = run.guarded.hours_needed
    return math.inf if hours is None else hours
