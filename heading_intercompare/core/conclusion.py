# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The outcome of a run: what variance, counts, norms, findings and looks say together."""

from __future__ import annotations

from typing import Sequence

from .guarded import Guarded, REASONS
from .outcome import Outcome
from .printed import Printed
from .sequential import LookVerdict
from .validity import DOUBTFUL, Finding, VOID, VOID_REASONS

__all__ = ['ALL_REASONS', 'conclude', 'with_findings', 'with_looks']

ALL_REASONS = {
    **REASONS,
    'count_lower_bound_above_allowed': 'too many extreme differences, at the stated risk',
    'total_error_not_within_norm': 'the total error is not shown to be within its norm',
    'outliers_decide': 'a few outlying readings decide; without them the outcome would differ',
    'rejected_at_a_look': 'a look at the run in progress rejected, and that stays',
    **VOID_REASONS,
}
"""Why the outcome of a run is what it is: code and words."""


def conclude(guarded: Guarded, printed: Printed) -> tuple[Outcome, str]:
    """Return the outcome that variance, counts and total error give a run, and its reason."""
    if guarded.outcome is Outcome.NON_COMPLIANT:
        return guarded.outcome, guarded.reason
    if guarded.count_outcome is Outcome.NON_COMPLIANT:
        return Outcome.NON_COMPLIANT, 'count_lower_bound_above_allowed'
    if (guarded.outcome is Outcome.COMPLIANT
            and printed.total.outcome not in (None, Outcome.COMPLIANT)):
        return Outcome.INDETERMINATE, 'total_error_not_within_norm'
    return guarded.outcome, guarded.reason


def with_findings(outcome: Outcome, reason: str,
                  findings: Sequence[Finding]) -> tuple[Outcome, str]:
    """
    Return outcome and reason as the findings leave them.

    A void comparison says nothing of the TS, whatever its variance. Where outliers decide, an
    outcome that is open says so.
    """
    for finding in findings:
        if finding.effect == VOID:
            return Outcome.INDETERMINATE, f'void.{finding.condition}'
    if outcome is Outcome.INDETERMINATE and any(
            f.condition == 'outliers' and f.effect == DOUBTFUL for f in findings):
        return outcome, 'outliers_decide'
    return outcome, reason


def with_looks(outcome: Outcome, reason: str,
               looks: Sequence[LookVerdict]) -> tuple[Outcome, str]:
    """
    Return outcome and reason at the end of a run that was looked at.

    The worse of what any look decided and what the end says: a rejection at a look stays, an
    acceptance does not outlast data that speak against it.
    """
    if outcome is not Outcome.NON_COMPLIANT and any(
            look.outcome is Outcome.NON_COMPLIANT for look in looks):
        return Outcome.NON_COMPLIANT, 'rejected_at_a_look'
    return outcome, reason
