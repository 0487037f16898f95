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

"""
Which figures of a run hold beside its outcome; a protocol shows no others.

The decision on the variance gives confidences, bounds and a length whatever becomes of the run. A
run may be void, too short for its upper bound, or decided by something else. Then such a figure
would speak for another outcome than the headline.
"""

from __future__ import annotations

from heading_intercompare.core.diagnostics.assumptions import NOT_TESTABLE
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.validity.condition import VOID
from heading_intercompare.core.verdict.verdict_document import RunVerdict, Verdict

#: The record is too short for the upper bound, or a drift may widen it.
_UPPER_BOUND_FAILS = ('insufficient_data', 'insufficient_duration', 'drift_left_in')
_MORE_DATA = ('insufficient_duration', 'slow_errors_not_resolved', 'data_limited')


def is_sound(run: RunVerdict) -> bool:
    """Tell whether the comparison says anything about the TS."""
    return run.validity_effect != VOID


def upper_bound_holds(run: RunVerdict) -> bool:
    """Tell whether the record is long enough for the risk of its upper bounds to hold."""
    return is_sound(run) and run.guarded.reason not in _UPPER_BOUND_FAILS


def worth_of(run: RunVerdict) -> float | None:
    """
    Return how many independent differences a run is worth for the variance.

    None without such a number, or if assumption (a) cannot tell it: errors that are slow for the
    length of the run may make it smaller.
    """
    is_unknown = any(assumption.id == 'a' and assumption.state == NOT_TESTABLE
                     for assumption in run.assumptions)
    return None if is_unknown else run.guarded.nu


def find_worst(verdict: Verdict) -> RunVerdict | None:
    """Return the run with the largest variance; None if no run has one."""
    return next((run for run in verdict.runs
                 if run.run == verdict.campaign.worst_variance_run), None)


def confidence_holds(run: RunVerdict) -> bool:
    """Tell whether the variance decides the run, so that its confidences are those of the run."""
    return (upper_bound_holds(run) and run.outcome is run.guarded.outcome
            and run.reason == run.guarded.reason)


def probability_holds(run: RunVerdict) -> bool:
    """
    Tell whether the conformance probability may stand beside the outcome.

    It takes every sigma_ref within its bounds as equally likely, which the decision does not. So
    it can be large although the run is open.
    """
    return confidence_holds(run) and run.outcome is not Outcome.INDETERMINATE


def length_holds(run: RunVerdict) -> bool:
    """Tell whether a longer run would decide, so that the length for it says something."""
    factor = run.guarded.duration_factor
    return (is_sound(run) and run.outcome is Outcome.INDETERMINATE
            and run.reason == run.guarded.reason and run.reason in _MORE_DATA
            and factor is not None and factor > 1.0)
