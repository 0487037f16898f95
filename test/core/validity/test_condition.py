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

"""Effects of findings: the gravest counts, and no doubt without a decision."""

from __future__ import annotations

import pytest

from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.validity.condition import (
    Condition,
    DOUBTFUL,
    Finding,
    gravest,
    HOLDS,
    is_doubtful,
    NOT_TESTABLE,
    VOID,
    worst_effect,
)


@pytest.mark.parametrize('effects, worst', [
    ((), HOLDS), ((NOT_TESTABLE,), HOLDS), ((HOLDS, DOUBTFUL), DOUBTFUL),
    ((VOID, DOUBTFUL, HOLDS), VOID)])
def test_the_gravest_effect_counts(effects, worst):
    condition = Condition(name='clocks', holds='the clocks agree')
    findings = [condition.find(effect, 'words', 'evidence') for effect in effects]
    assert worst_effect(findings) == gravest(effects) == worst


def test_a_condition_gives_findings_of_its_name():
    condition = Condition(name='clocks', holds='the clocks agree')
    assert condition.find(HOLDS, '', 'the skew is 0') == Finding(
        'clocks', 'holds', '', 'the skew is 0')


@pytest.mark.parametrize('outcome', list(Outcome))
def test_an_open_outcome_is_not_in_doubt(outcome):
    assert is_doubtful(outcome, DOUBTFUL) == (outcome is not Outcome.INDETERMINATE)
    assert not is_doubtful(outcome, VOID)
