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

"""Whether a row of a logbook follows from its own figures."""

from __future__ import annotations

import math
from typing import Iterator

from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.validity.condition import gravest, VOID
from heading_intercompare.core.verdict.conclusion import outcome_of_reason
from heading_intercompare.core.verdict.headline import OUTCOME_WORDS

from .run_row import RunRow

#: What a look rejected stands, whatever the figures at the end of the run.
_AT_A_LOOK = 'rejected_at_a_look'
_ABOVE, _WITHIN = 'lower_bound_above_rejection_limit', 'upper_bound_within_acceptance_limit'
_REL = 1e-9


def find_contradiction(row: RunRow) -> str:
    """Return in words the first cell that contradicts the other cells of its row; '' for none."""
    return next(_list_contradictions(row), '')


def _list_contradictions(row: RunRow) -> Iterator[str]:
    outcome = outcome_of_reason(row.reason)
    if outcome is not None and row.outcome != outcome.value:
        yield f'outcome is {row.outcome}, but its reason {row.reason} gives {outcome.value}'
    try:
        word = OUTCOME_WORDS[Outcome(row.outcome).value]
    except ValueError:
        yield f'outcome is {row.outcome!r:.70}, which is none'
        return
    if not row.headline.startswith(word):
        yield f'headline is {row.headline!r:.70}, but its outcome gives {word}'
    if row.end_ns < row.start_ns:
        yield 'end_ns lies before start_ns'
    yield from _check_bounds(row)
    if row.reason != _AT_A_LOOK:
        yield from _check_conditions(row)


def _check_bounds(row: RunRow) -> Iterator[str]:
    """Yield what contradicts the bounds of the variance and their limits."""
    lower, upper = row.lower_bound_deg2, row.upper_bound_deg2
    rejects = lower is not None and lower > row.rejection_limit_deg2
    accepts = upper is not None and upper <= row.acceptance_limit_deg2
    if row.reason == _WITHIN and not accepts:
        yield 'outcome is compliant, but its upper_bound_deg2 exceeds its acceptance_limit_deg2'
    if (row.reason == _ABOVE) is not rejects and not (
            rejects and (row.reason == _AT_A_LOOK or row.reason.startswith(f'{VOID}.'))):
        yield (f'reason is {row.reason}, but its lower_bound_deg2 '
               f'{"exceeds" if rejects else "does not exceed"} its rejection_limit_deg2')
    if lower is not None and upper is not None and lower > upper * (1.0 + _REL):
        yield 'lower_bound_deg2 exceeds upper_bound_deg2'
    if row.sd_deg is not None and row.n > 1 and upper is not None:
        # Up to five degrees of freedom go to the mean and a polynomial.
        least_deg = math.sqrt(max(0.0, row.n - 5) / row.n) * row.sd_deg
        if least_deg ** 2 > upper * (1.0 + _REL):
            yield 'sd_deg is larger than its upper_bound_deg2 allows'


def _check_conditions(row: RunRow) -> Iterator[str]:
    """Yield what contradicts the conditions that do not hold."""
    effects = [condition.partition('=')[::2] for condition in row.conditions.split(',')
               if condition]
    try:
        effect = gravest(effect for _, effect in effects)
    except KeyError:
        yield f'conditions are {row.conditions!r:.70}, which have no such effect'
        return
    if row.validity_effect != effect:
        yield f'validity_effect is {row.validity_effect}, but its conditions give {effect}'
    void = next((name for name, effect in effects if effect == VOID), None)
    reason = None if void is None else f'{VOID}.{void}'
    if (reason or row.reason.startswith(f'{VOID}.')) and row.reason != reason:
        yield f'reason is {row.reason}, but its conditions give {reason or "no void run"}'
