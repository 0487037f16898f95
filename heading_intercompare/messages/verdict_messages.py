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

"""Verdicts as diagnostic messages."""

from __future__ import annotations

from typing import Any

from heading_intercompare.core.decision.sequential import LookVerdict
from heading_intercompare.core.norm_tests.judged_test import (
    MET,
    NOT_MET,
    NOT_SAILED,
    OPEN,
    STATES,
)
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.typed_reader import make_plain
from heading_intercompare.core.validity.condition import DOUBTFUL, VOID
from heading_intercompare.core.verdict.verdict_document import RunVerdict, Verdict

from .status_messages import encode_statuses, ERROR, OK, Status, WARN

OUTCOME_LEVELS = {Outcome.COMPLIANT: OK, Outcome.INDETERMINATE: WARN,
                  Outcome.NON_COMPLIANT: ERROR}

TEST = 'test: '
"""What the name of the status of a test of the norm begins with."""

_TEST_LEVELS = {MET: OK, OPEN: WARN, NOT_SAILED: WARN, NOT_MET: ERROR}

NO_VERDICT = 'no run has ended'
"""What a verdict says before the first one."""


def _run_values(run: RunVerdict) -> dict[str, Any]:
    names = ('start_ns', 'end_ns', 'duration_s', 'n', 'mean_deg', 'std_deg', 'variance_deg2',
             'max_abs_deg', 'outcome', 'reason', 'paper_outcome')
    findings = {f'validity.{finding.condition}': finding.effect for finding in run.validity}
    return {**{name: getattr(run, name) for name in names}, 'nu': run.guarded.nu,
            'headline': run.headline, 'validity': run.validity_effect, **findings}


def verdict_level(outcome: Outcome, effect: str) -> int:
    """Return the level of a verdict: OK only if it is compliant, and neither void nor doubtful."""
    level = OUTCOME_LEVELS[outcome]
    return WARN if level == OK and effect in (DOUBTFUL, VOID) else level


def encode_no_verdict(ns: int, owner: str = '') -> bytes:
    """Return what a node publishes before the first run has ended."""
    return encode_statuses(ns, [Status('verdict', WARN, NO_VERDICT, {'runs': 0})], owner)


def encode_verdict(verdict: Verdict, ns: int, early: LookVerdict | None = None,
                   owner: str = '') -> bytes:
    """Return a verdict: conclusion, runs, tests of the norm, a look at the run in progress."""
    whole = Status('verdict', verdict_level(verdict.outcome, verdict.validity_effect),
                   verdict.headline,
                   {'outcome': verdict.outcome, 'paper_outcome': verdict.paper_outcome,
                    'validity': verdict.validity_effect, 'runs': len(verdict.runs)})
    runs = [Status(f'run {run.run}', verdict_level(run.outcome, run.validity_effect),
                   run.reason, _run_values(run))
            for run in verdict.runs]
    tests = [Status(f'{TEST}{test.words}', _TEST_LEVELS[test.state], ', '.join(
        (STATES[test.state], *test.cells[1:])), {
            'state': test.state, 'value': test.value, 'low': test.low, 'high': test.high,
            'limit': test.limit, 'unit': test.unit, 'clause': test.source, 'notes': test.notes})
             for test in verdict.campaign.norm_tests or ()]
    looks = [] if early is None else [Status('run in progress', OUTCOME_LEVELS[early.outcome],
                                             early.reason, make_plain(early))]
    return encode_statuses(ns, [whole, *runs, *tests, *looks], owner)
