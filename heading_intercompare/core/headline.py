# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The one line that people read of a verdict: outcome, doubts, and what it covers."""

from __future__ import annotations

from typing import Sequence

from .coverage import Coverage
from .outcome import Outcome
from .validity import DOUBTFUL, Finding, VOID

__all__ = ['headline', 'OUTCOME_WORDS']

OUTCOME_WORDS = {'compliant': 'COMPLIANT', 'indeterminate': 'INDETERMINATE',
                 'non_compliant': 'NON-COMPLIANT'}
"""By outcome."""


def headline(outcome: Outcome, findings: Sequence[Finding], coverage: Coverage | None) -> str:
    """
    Return outcome, findings that bind it, and what a certificate covers.

    Parameters
    ----------
    outcome : Outcome
    findings : sequence of Finding
        Of a run, or of all runs with the run in their words.
    coverage : Coverage or None
        None where there is no run.

    Examples
    --------
    >>> from heading_intercompare.core.settings import Risk
    >>> from heading_intercompare.core.coverage import coverage_of
    >>> headline(Outcome.COMPLIANT, (), coverage_of(624.0, Risk()))
    'COMPLIANT for errors that change within 31 s; slower errors are not covered'

    """
    text = OUTCOME_WORDS[outcome.value]
    void = [f.words for f in findings if f.effect == VOID]
    doubts = [f.words for f in findings if f.effect == DOUBTFUL]
    if outcome is Outcome.COMPLIANT and coverage is not None and not doubts:
        return f'{text} {coverage.words}'
    if void:
        # One cause has many symptoms; the conditions stand in the order of causes.
        text += f', VOID: {void[0]}'
    elif doubts:
        text += f', DOUBTFUL: {"; ".join(doubts)}'
    if outcome is Outcome.COMPLIANT and coverage is not None:
        text += f' ({coverage.words})'
    return text
