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

"""A condition of a valid comparison: declared once, with its words, its judge and its effect."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Iterable, TYPE_CHECKING

from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.outcome import Outcome

if TYPE_CHECKING:
    from .examined import Examined, RunAccount


HOLDS, NOT_TESTABLE, DOUBTFUL, VOID = 'holds', 'not_testable', 'doubtful', 'void'

_RANK = {HOLDS: 0, NOT_TESTABLE: 0, DOUBTFUL: 1, VOID: 2}


@dataclass(frozen=True, slots=True)
class Finding:
    """The finding on one condition; keys of the JSON."""

    condition: str = figure('name of the condition', 'a void run has the reason `void.NAME`')
    effect: str = figure(
        'effect of the finding', '`holds`; `doubtful`: the outcome stands and the headline doubts '
        'it; `void`: the run says nothing about the TS; `not_testable`: these data cannot show it')
    words: str = figure('finding in a few words, for a headline')
    evidence: str = figure('figures in a sentence')


def worst_effect(findings: Iterable[Finding]) -> str:
    """Return the most serious effect of findings: 'holds', 'doubtful' or 'void'."""
    return gravest(f.effect for f in findings)


def gravest(effects: Iterable[str]) -> str:
    """Return the most serious of effects: 'holds', 'doubtful' or 'void'."""
    worst = max((_RANK[effect] for effect in effects), default=0)
    return (HOLDS, DOUBTFUL, VOID)[worst]


def is_doubtful(outcome: Outcome, effect: str | None) -> bool:
    """Tell whether a decision is in doubt; no decision, no doubt."""
    return outcome is not Outcome.INDETERMINATE and effect == DOUBTFUL


@dataclass(frozen=True, slots=True, kw_only=True)
class Condition:
    """
    What must hold of a run for its comparison to say something about the TS.

    Headline, JSON, schema, tables, protocol, page, live alarms and ``docs/refusals.md`` take their
    words from here.

    Attributes
    ----------
    name
        Name in the JSON; the reason of a void run is ``void.<name>``.
    holds
        What is true if the condition holds, in words.
    void
        Why a run is void by it, in words; empty if it never makes a run void.
    void_when, void_why, doubtful_when
        Rows of ``docs/refusals.md``: when it makes a run void and why, and when doubtful. Empty
        if never.
    judge
        Returns the finding on the pairs of a run, or None if the run has none on this condition;
        None if the condition is judged elsewhere.
    settle
        Returns the finding once the account of the readings is known, given that of `judge`.
    also_said : {'', 'always', 'certificate'}
        When its words stand in a headline although it does not bind: whatever the outcome, or in
        that of a certificate, whose scope it narrows.
    is_permanent
        Whether a run that is void by it was so at each look, even if that did not show yet: the
        set-up of the sensors makes it void.
    weighs_others
        Whether it is judged after all others, by their findings too.
    watched_by
        Names of the live alarms that show it by detectors of their own. Without any, a condition
        that `judge` can find void has a live alarm of its own name.

    """

    name: str
    holds: str
    void: str = ''
    void_when: str = ''
    void_why: str = ''
    doubtful_when: str = ''
    judge: 'Callable[[Examined], Finding | None] | None' = None
    settle: 'Callable[[Finding | None, RunAccount], Finding | None] | None' = None
    also_said: str = ''
    is_permanent: bool = False
    weighs_others: bool = False
    watched_by: tuple[str, ...] = ()

    @property
    def is_alarm(self) -> bool:
        """Whether it has a live alarm of its own name."""
        return bool(self.void) and self.judge is not None and not self.watched_by

    def find(self, effect: str, words: str, evidence: str) -> Finding:
        """Return a finding on this condition."""
        return Finding(self.name, effect, words, evidence)
