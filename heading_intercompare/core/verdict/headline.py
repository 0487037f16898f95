# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The one line that people read of a verdict: outcome, doubts, and what it covers."""

from __future__ import annotations

from typing import Sequence

from heading_intercompare.core.decision.coverage import Coverage, span_words
from heading_intercompare.core.decision.sequential import find_rejection, LookVerdict
from heading_intercompare.core.outcome import Outcome

from .validity import DOUBTFUL, Finding, VOID

__all__ = ['add_looks', 'compose_headline', 'OUTCOME_WORDS']

OUTCOME_WORDS = {'compliant': 'COMPLIANT', 'indeterminate': 'INDETERMINATE',
                 'non_compliant': 'NON-COMPLIANT'}
"""By outcome."""


def compose_headline(outcome: Outcome, findings: Sequence[Finding], coverage: Coverage | None,
                     why: str = '') -> str:
    """
    Return outcome, findings that bind it, and what a certificate covers or why there is none.

    Parameters
    ----------
    outcome : Outcome
    findings : sequence of Finding
        Of a run, or of all runs with the run in their words.
    coverage : Coverage or None
        None where there is no run.
    why : str
        The reason of the outcome, in words.

    Examples
    --------
    >>> from heading_intercompare.core.settings import Risk
    >>> from heading_intercompare.core.decision.coverage import coverage_of
    >>> compose_headline(Outcome.COMPLIANT, (), coverage_of(624.0, Risk()))
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
    elif why and outcome is not Outcome.COMPLIANT:
        text += f': {why}'
    if outcome is Outcome.COMPLIANT and coverage is not None:
        text += f' ({coverage.words})'
    return text


def add_looks(at_end: str, outcome: Outcome, reason: str,
              looks: Sequence[LookVerdict]) -> str:
    """
    Return the headline of a run that was looked at.

    Parameters
    ----------
    at_end : str
        What the end of the run says by itself, `compose_headline`.
    outcome, reason
        Of the run, looks included.
    looks : sequence of LookVerdict

    """
    look = find_rejection(looks)
    if reason == 'rejected_at_a_look' and look is not None:
        said = look.headline.removeprefix(OUTCOME_WORDS['non_compliant'])
        return (f'{OUTCOME_WORDS["non_compliant"]} at look {look.look} of {look.looks}, after '
                f'{span_words(look.span_s)}{said}; at the end {at_end}')
    accepted = [look for look in looks if look.outcome is Outcome.COMPLIANT]
    if accepted and outcome is not Outcome.COMPLIANT:
        return f'{at_end}; look {accepted[0].look} accepted, which is withdrawn'
    return at_end
