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


"""The norms and the method as the protocol lists them."""

import pytest

from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.all_runs import join
from heading_intercompare.report.contents.decision_rule import describe_norms, state_conformity


@pytest.mark.parametrize('rule, words', [
    ({}, 'if the assumptions hold.'),
    ({'plan_s': 3600.0}, 'The risks are shared among 7 looks of a run planned for 3600 s.'),
    ({'plan_s': 'open', 'slowest_error_s': 60.0}, 'Half of the risks is shared among 6 looks at '
     'the run in progress, at 1200 s and at doubling times; the end of the run has what they '
     'left.')])
def test_the_protocol_says_how_looks_share_the_risks(rule, words):
    verdict = join([], Settings.of(sigma_max_deg=0.2, sigma_ref_max_deg=0.1, **rule))
    assert dict(state_conformity(verdict))["consumer's risk [1]"].endswith(words)


def test_what_nobody_stated_is_said_to_be_the_default():
    told = dict(describe_norms(Settings.of(sigma_max_deg=0.2, sigma_ref_max_deg=0.1, m_low=0.5)))
    assert told['confidence probability P [1]'] == '0.997, default'
    assert told['variant of GK Table I'].endswith(', default')
    assert not told['bounds of M = sigma_ref / sigma_ref_max, as set [1]'].endswith('default')
