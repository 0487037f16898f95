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

"""A plan says which tests the trial can decide, and what each one that it cannot needs."""

from __future__ import annotations

import pytest

from heading_intercompare.core.norm_tests.planned_tests import plan_tests
from heading_intercompare.core.settings import Settings


def plan(rate_hz=1.0, **settings):
    usual = {'preset': 'imo_msc116', 'sigma_ref_max_deg': 0.1}
    return {test.words: test for test in plan_tests(Settings.of(**{**usual, **settings}), rate_hz)}


STATIC, DYNAMIC, FAST, FOLLOW_UP = (
    'static error', 'amplitude of the dynamic error',
    'amplitude of the dynamic error of periods below 30 s', 'follow-up error up to 10 deg/s')


def test_a_good_trial_can_decide_every_test_and_says_what_to_sail():
    tests = plan()
    assert [test.obstacle for test in tests.values()] == [''] * 6
    assert all(test.manoeuvre and test.least_s > 0.0 for test in tests.values())
    assert tests[FOLLOW_UP].manoeuvre.endswith('1 deg/s or more')


@pytest.mark.parametrize('changes,words,obstacle', [
    ({'rate_hz': 0.1}, FAST, 'pairs come every 10 s, not every 5 s'),
    ({'sigma_ref_max_deg': 0.2}, FAST, 'needs an RS of 0.18 deg'),
    ({'sigma_ref_max_deg': 0.6}, DYNAMIC, 'needs an RS of 0.55 deg'),
    ({'installation_offset_u_deg': 0.3}, STATIC, 'the mounting angle is known to 0.3 deg; it '
     'needs 0.18 deg'),
    ({'skew': 'apply'}, FOLLOW_UP, 'alignment removes a skew')])
def test_what_a_trial_cannot_decide_needs_something(changes, words, obstacle):
    """0.5 sqrt(1 - 0.7^2) / 1.96 = 0.182; 0.3 / 1.645 = 0.182."""
    tests = plan(**changes)
    assert tests[words].obstacle.startswith(obstacle)


def test_an_rs_that_is_known_serves_although_it_is_coarse():
    assert plan(sigma_ref_max_deg=0.2, sigma_ref_deg=0.2)[FAST].obstacle == ''


def test_a_type_test_is_none_of_a_record():
    tests = plan(preset='imo_a821', latitude_deg=60.0)
    assert tests['residual speed error'].obstacle == 'a record of headings does not decide it'
    assert tests['settle-point error'].limit == pytest.approx(1.5)


def test_a_norm_without_tests_plans_none():
    assert plan(preset=None, sigma_max_deg=0.2) == {}
