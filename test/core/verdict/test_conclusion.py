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

"""The outcome from variance, counts, norms, findings and looks."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest

from heading_intercompare.core.decision.coverage import coverage_of
from heading_intercompare.core.decision.sequential import find_standing, LookVerdict
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.settings import Risk
from heading_intercompare.core.validity.condition import DOUBTFUL, Finding, HOLDS, VOID
from heading_intercompare.core.verdict.conclusion import (
    ALL_REASONS,
    conclude,
    effect_with_looks,
    with_findings,
    with_looks,
)
from heading_intercompare.core.verdict.headline import (
    add_looks,
    compose_headline,
    REJECTION_SCOPE,
)

C, I, N = Outcome.COMPLIANT, Outcome.INDETERMINATE, Outcome.NON_COMPLIANT


def of(variance, counts=C, total=None):
    guarded = SimpleNamespace(outcome=variance, count_outcome=counts, reason='by_variance')
    return conclude(guarded, SimpleNamespace(total=SimpleNamespace(outcome=total)))


@pytest.mark.parametrize('given, expected', [
    ((N, N, N), (N, 'by_variance')), ((C, N, C), (N, 'count_lower_bound_above_allowed')),
    ((I, N, C), (N, 'count_lower_bound_above_allowed')), ((C, I, None), (C, 'by_variance')),
    ((C, C, C), (C, 'by_variance')), ((C, C, I), (I, 'total_error_not_within_norm')),
    ((C, C, N), (I, 'total_error_not_within_norm')), ((I, C, N), (I, 'by_variance'))])
def test_variance_then_counts_then_total_error(given, expected):
    assert of(*given) == expected


def test_a_void_finding_opens_whatever_the_variance_says():
    void = Finding('frozen', VOID, 'the TS froze', '')
    for outcome in (C, I, N):
        assert with_findings(outcome, 'x', [void]) == (I, 'void.frozen')


def test_a_doubtful_finding_leaves_the_outcome():
    doubt = Finding('outliers', DOUBTFUL, '1 isolated outlier decides', '')
    assert with_findings(C, 'x', [doubt]) == (C, 'x')
    assert with_findings(N, 'x', [doubt]) == (N, 'x')
    assert with_findings(I, 'slow_errors_not_resolved', [doubt]) == (I, 'outliers_decide')
    other = Finding('clocks', DOUBTFUL, 'a skew', '')
    assert with_findings(I, 'data_limited', [other]) == (I, 'data_limited')


def look(number, outcome):
    return LookVerdict(number, 4, 100.0 * number, outcome, 'x')


@pytest.mark.parametrize('looks, end, expected', [
    ((), C, C), ((C,), C, C), ((C,), I, I), ((C,), N, N), ((I,), C, C), ((C, I), C, C),
    ((N,), C, N), ((N,), I, N), ((C, N), C, N), ((N, C), C, N), ((I, I), I, I)])
def test_the_worse_of_a_decision_at_a_look_and_the_end(looks, end, expected):
    looks = [look(k, outcome) for k, outcome in enumerate(looks, 1)]
    outcome, reason = with_looks(end, 'at_the_end', looks)
    assert outcome is expected
    assert reason == ('rejected_at_a_look' if expected is N and end is not N else 'at_the_end')


@pytest.mark.parametrize('looks, expected', [
    ((), None), ((I,), None), ((I, I), None), ((C,), (C, 'x')), ((I, C), (C, 'x')),
    ((C, I), (I, 'not_confirmed')), ((C, I, C), (C, 'x')), ((C, N), (N, 'x')),
    ((N, C), (N, 'x')), ((N, I), (N, 'x'))])
def test_what_looks_leave_standing(looks, expected):
    found = find_standing([look(k, outcome) for k, outcome in enumerate(looks, 1)])
    assert expected == (None if found is None else (found.outcome, found.reason))


def test_what_makes_the_whole_comparison_void_made_a_look_void_too():
    looks = [look(1, N)]
    assert with_looks(I, 'void.convention', looks) == (I, 'void.convention')
    assert with_looks(I, 'void.frozen', looks) == (N, 'rejected_at_a_look')
    void = [Finding('frozen', VOID, 'the TS froze', '')]
    assert effect_with_looks(void, 'rejected_at_a_look', looks) == VOID
    doubted = [replace(looks[0], validity_effect=DOUBTFUL)]
    assert effect_with_looks((), 'rejected_at_a_look', doubted) == DOUBTFUL
    assert effect_with_looks((), 'data_limited', doubted) == HOLDS


@pytest.mark.parametrize('outcome, reason, said, line', [
    (C, 'x', (C, I), 'END'),
    (I, 'x', (I, C, C), 'END; look 2 accepted, which is withdrawn'),
    (N, 'x', (C,), 'END; look 1 accepted, which is withdrawn'),
    (N, 'rejected_at_a_look', (I, N),
     'NON-COMPLIANT at look 2 of 4, after 10 min, DOUBTFUL: it; at the end END')])
def test_the_headline_of_a_run_that_was_looked_at(outcome, reason, said, line):
    looks = [LookVerdict(k, 4, 300.0 * k, each, 'x', DOUBTFUL, 'NON-COMPLIANT, DOUBTFUL: it')
             for k, each in enumerate(said, 1)]
    assert add_looks('END', outcome, reason, looks) == line


def test_the_headline_says_why_there_is_no_certificate():
    covered = coverage_of(624.0, Risk())
    assert compose_headline(I, (), covered, 'all is said') == 'INDETERMINATE: all is said'
    doubt = [Finding('x', DOUBTFUL, 'it', '')]
    assert compose_headline(I, doubt, covered, 'why') == 'INDETERMINATE, DOUBTFUL: it'
    assert compose_headline(C, (), covered, 'why').startswith('COMPLIANT for errors')


def test_every_reason_has_words():
    assert all(words and code == code.lower() for code, words in ALL_REASONS.items())
    assert {'rejected_at_a_look', 'outliers_decide', 'drift_left_in',
            'slow_errors_not_resolved'} < set(ALL_REASONS)


@pytest.mark.parametrize('outcome, effects, words', [
    (C, (), 'COMPLIANT for errors that change within 31 s, and that come at least three times '
     'in the run; slower errors are not covered'),
    (N, (), f'NON-COMPLIANT ({REJECTION_SCOPE})'), (I, (), 'INDETERMINATE'),
    (C, (DOUBTFUL,), 'COMPLIANT, DOUBTFUL: it 0 (for errors that change within 31 s, and that '
     'come at least three times in the run; slower errors are not covered)'),
    (N, (DOUBTFUL, DOUBTFUL), f'NON-COMPLIANT, DOUBTFUL: it 0; it 1 ({REJECTION_SCOPE})'),
    (I, (HOLDS, VOID, VOID, DOUBTFUL), 'INDETERMINATE, VOID: it 1')])
def test_the_headline_by_hand(outcome, effects, words):
    findings = [Finding('x', effect, f'it {k}', '') for k, effect in enumerate(effects)]
    assert compose_headline(outcome, findings, coverage_of(624.0, Risk())) == words
