# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Verdicts to diagnostic messages and to the report; apart, for only one node has any."""

from __future__ import annotations

import json
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import String

from heading_intercompare.core.decision.sequential import LookVerdict
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.verdict.validity import DOUBTFUL, VOID
from heading_intercompare.core.verdict.verdict_document import make_plain, RunVerdict, Verdict

from .status_messages import ERROR, OK, status, status_array, WARN

__all__ = ['OUTCOME_LEVELS', 'report_message', 'verdict_level', 'verdict_message']

OUTCOME_LEVELS = {Outcome.COMPLIANT: OK, Outcome.INDETERMINATE: WARN,
                  Outcome.NON_COMPLIANT: ERROR}


def _run_values(run: RunVerdict) -> dict[str, Any]:
    names = ('start_ns', 'end_ns', 'duration_s', 'n', 'mean_deg', 'std_deg', 'variance_deg2',
             'max_abs_deg', 'outcome', 'reason', 'paper_outcome')
    findings = {f'validity.{found.condition}': found.effect for found in run.validity}
    return {**{name: getattr(run, name) for name in names}, 'nu': run.guarded.nu,
            'headline': run.headline, 'validity': run.validity_effect, **findings}


def verdict_level(outcome: Outcome, effect: str) -> bytes:
    """Return the level of a verdict: OK only for a certificate that nothing puts in doubt."""
    level = OUTCOME_LEVELS[outcome]
    return WARN if level == OK and effect in (DOUBTFUL, VOID) else level


def verdict_message(verdict: Verdict, ns: int,
                    early: LookVerdict | None = None) -> DiagnosticArray:
    """Return a verdict: the conclusion, each run with its reason, a look at the one going on."""
    whole = status('verdict', verdict_level(verdict.outcome, verdict.validity_effect),
                   verdict.headline,
                   {'outcome': verdict.outcome, 'paper_outcome': verdict.paper_outcome,
                    'validity': verdict.validity_effect, 'runs': len(verdict.runs)})
    runs = [status(f'run {run.run}', verdict_level(run.outcome, run.validity_effect),
                   run.reason, _run_values(run))
            for run in verdict.runs]
    looks = [] if early is None else [status('run in progress', OUTCOME_LEVELS[early.outcome],
                                             early.reason, make_plain(early))]
    return status_array(ns, [whole, *runs, *looks])


def report_message(verdict: Verdict) -> String:
    """Return the verdict as JSON, the text that `analyze --json` writes."""
    return String(data=json.dumps(verdict.to_dict(), indent=1, ensure_ascii=False,
                                  allow_nan=False) + '\n')
