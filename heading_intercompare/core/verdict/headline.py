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

"""The headline of a verdict, the one line that people read: outcome, doubts and coverage."""

from __future__ import annotations

from typing import Sequence

from heading_intercompare.core.decision.coverage import Coverage, span_words
from heading_intercompare.core.decision.sequential import find_rejection, LookVerdict
from heading_intercompare.core.norm_tests.judged_test import JudgedTest, NOT_MET, say_open
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.sensor_conditions.motion import MOTION
from heading_intercompare.core.validity.condition import DOUBTFUL, Finding, VOID

from .validity import CONDITIONS

OUTCOME_WORDS = {'compliant': 'COMPLIANT', 'indeterminate': 'INDETERMINATE',
                 'non_compliant': 'NON-COMPLIANT'}
"""Words for each outcome."""

REJECTION_SCOPE = 'rests on the RS meeting its norm; which of the two is wrong is not shown'
"""What a rejection does not show: the difference is that of two sensors."""


def say_outcome(outcome: str, effect: str) -> str:
    """
    Return an outcome in capitals, with the gravest effect of a condition if that casts doubt.

    Examples
    --------
    >>> say_outcome('non_compliant', 'holds'), say_outcome('indeterminate', 'void')
    ('NON-COMPLIANT', 'INDETERMINATE, VOID')

    """
    doubt = f', {effect.upper()}' if effect in (DOUBTFUL, VOID) else ''
    return f'{OUTCOME_WORDS[outcome]}{doubt}'


def compose_headline(outcome: Outcome, findings: Sequence[Finding], coverage: Coverage | None,
                     why: str = '', tests: Sequence[JudgedTest] = ()) -> str:
    """
    Compose the headline: outcome, findings that affect it, and the coverage or the reason.

    Parameters
    ----------
    outcome
        Of the run, or of all runs.
    findings
        Findings of a run, or of all runs with the run named in their words.
    coverage
        None if there is no run.
    why
        The reason of the outcome, in words.
    tests
        The tests of the norm: a certificate names those that it leaves open, a rejection those
        that are not met.

    Examples
    --------
    >>> from heading_intercompare.core.settings import Risk
    >>> from heading_intercompare.core.decision.coverage import coverage_of
    >>> line = compose_headline(Outcome.COMPLIANT, (), coverage_of(624.0, Risk()))
    >>> line.partition(';')[0]
    'COMPLIANT for errors that change within 31 s, and that come at least three times in the run'

    """
    text, complies = OUTCOME_WORDS[outcome.value], outcome is Outcome.COMPLIANT
    void = [f.words for f in findings if f.effect == VOID]
    doubts = [f.words for f in findings if f.effect == DOUBTFUL]
    open_tests = say_open(tests) if complies and not void else ''
    also = ''.join(f'; {words}' for words in (
        open_tests, *_list_also(findings, complies, bool(void))) if words)
    if complies and coverage is not None and not doubts:
        return f'{text} {coverage.words}{also}'
    if void:
        # One cause has many symptoms; the conditions are ordered by cause.
        text += f', VOID: {void[0]}'
    elif doubts:
        text += f', DOUBTFUL: {"; ".join(doubts)}'
        # Doubts stand in place of the reason.
        text += ''.join(f'; not met: {test.line}' for test in tests
                        if test.state == NOT_MET and test.line not in text)
    elif why and not complies:
        text += f': {why}'
    if complies and coverage is not None:
        text += f' ({coverage.words})'
    # The motion of the ship shows which one is wrong.
    if outcome is Outcome.NON_COMPLIANT and not any(
            f.condition == MOTION.name and f.effect == DOUBTFUL for f in findings):
        text += f' ({REJECTION_SCOPE})'
    return text + also


def _list_also(findings: Sequence[Finding], complies: bool, is_void: bool) -> list[str]:
    """Return what is said beside outcome and doubts: what is left out or narrows the scope."""
    # It is said whatever the outcome, unless it is among the doubts.
    also = [f.words for f in _list_also_said(findings, 'always')
            if is_void or f.effect != DOUBTFUL]
    if complies and not is_void:
        # The scope of a certificate, where it is narrower than others.
        also += [f.words for f in _list_also_said(findings, 'certificate')]
    return also


def _list_also_said(findings: Sequence[Finding], when: str) -> list[Finding]:
    names = {condition.name for condition in CONDITIONS if condition.also_said == when}
    return [finding for finding in findings if finding.condition in names and finding.words]


def add_looks(at_end: str, outcome: Outcome, reason: str,
              looks: Sequence[LookVerdict]) -> str:
    """
    Return the headline of a run with looks.

    Parameters
    ----------
    at_end
        The headline at the end of the run without looks, from `compose_headline`.
    outcome, reason
        Outcome and reason of the run, looks included.
    looks
        Those done, in the order of time.

    """
    look = find_rejection(looks)
    if reason == 'rejected_at_a_look' and look is not None:
        details = look.headline.removeprefix(OUTCOME_WORDS['non_compliant'])
        return (f'{OUTCOME_WORDS["non_compliant"]} at look {look.look} of {look.looks}, after '
                f'{span_words(look.span_s)}{details}; at the end {at_end}')
    accepted = [look for look in looks if look.outcome is Outcome.COMPLIANT]
    if accepted and outcome is not Outcome.COMPLIANT:
        return f'{at_end}; look {accepted[0].look} accepted, which is withdrawn'
    return at_end
