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

"""The condition that a test of the norm that is not met has no other explanation."""

from __future__ import annotations

from heading_intercompare.core.norm_tests.judged_test import MET, NOT_MET, NOT_SAILED
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.validity.condition import Condition, DOUBTFUL, Finding, HOLDS
from heading_intercompare.core.validity.examined import RunAccount


def _settle(finding: Finding | None, account: RunAccount) -> Finding | None:
    tests = account.tests
    if not tests:
        return None
    count = {state: sum(test.state == state for test in tests)
             for state in (MET, NOT_MET, NOT_SAILED)}
    evidence = (f'{len(tests)} tests: {count[MET]} met, {count[NOT_MET]} not met, '
                f'{count[NOT_SAILED]} not sailed')
    broken = [test for test in tests if test.state == NOT_MET]
    if not broken or account.outcome is Outcome.NON_COMPLIANT or not all(
            test.unless for test in broken):
        return NORM_TESTS.find(HOLDS, '', evidence)
    words = f'{broken[0].line}, unless {broken[0].unless}'
    return NORM_TESTS.find(DOUBTFUL, words, f'{evidence}; {words}')


NORM_TESTS = Condition(
    name='norm_tests',
    holds='no mounting angle or clock offset explains a test of the norm that is not met',
    doubtful_when='a test of the norm is not met, and an angle between the sensors that is not '
                  'stated, or clocks that differ, would show the same',
    settle=_settle)
