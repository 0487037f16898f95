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

"""The words for what observations say."""

from __future__ import annotations

from core.observations.make_corrections import corrections
import numpy as np
import pytest

from heading_intercompare.core.observations.systematic_error import judge_corrections
from heading_intercompare.core.observations.wording import explain_outcome, explain_scatter
from heading_intercompare.core.settings import Settings

NORM = Settings.of(systematic_max_deg=0.75, sigma_max_deg=0.05)


@pytest.mark.parametrize('x, common, begins, says', [
    ([], 0.0, 'INDETERMINATE', 'no observation'),
    ([0.1, 0.2, 0.1], 0.0, 'COMPLIANT', 'within the norm of 0.750 deg'),
    ([1.5, 1.6, 1.5], 0.0, 'NON-COMPLIANT', 'above the norm of 0.750 deg'),
    ([170.0, 170.1], 0.0, 'INDETERMINATE', 'the wrong way round'),
    (0.6 + np.tile([-0.01, 0.01], 20), 0.3, 'INDETERMINATE', 'a better survey'),
    ([0.3, 0.7, 0.3, 0.7], 0.0, 'INDETERMINATE', 'such observations would show compliance'),
    ([0.1, 0.1, 0.1, 0.1, 0.12, 3.0], 0.0, 'INDETERMINATE', 'marked ?')])
def test_each_reason_has_its_words(x, common, begins, says):
    line = explain_outcome(judge_corrections(corrections(x), NORM, common_u_deg=common))
    assert line.startswith(f'{begins}: ') and says in line and '\n' not in line
    assert 'None' not in line


def test_without_a_norm_it_says_which_to_give():
    found = judge_corrections(corrections([0.1, 0.2]), Settings(), common_u_deg=0.0)
    assert 'norms.systematic_max_deg' in explain_outcome(found)


def test_a_standard_deviation_is_never_certified():
    few = judge_corrections(corrections([0.1, 0.2, 0.1]), NORM, common_u_deg=0.0)
    assert explain_scatter(few).startswith('cannot decide: the standard deviation')
    assert 'above its norm of 0.050 deg' in explain_scatter(few)
    many = judge_corrections(corrections(np.tile([-0.01, 0.01], 15)), NORM, common_u_deg=0.0)
    assert explain_scatter(many).startswith('cannot decide') and 'above' not in (
        explain_scatter(many))
    assert explain_scatter(judge_corrections(corrections([0.1]), NORM, common_u_deg=0.0)) == ''
