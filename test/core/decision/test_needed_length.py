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

"""An open verdict says how long to measure, or why no length helps."""

from __future__ import annotations

from dataclasses import replace
import math

import pytest

from heading_intercompare.core.decision.campaign import Together
from heading_intercompare.core.decision.coverage import Coverage
from heading_intercompare.core.decision.guarded import Guarded
from heading_intercompare.core.decision.needed_length import (
    describe_need,
    describe_need_together,
)
from heading_intercompare.core.outcome import Outcome

COVERED = Coverage(3600.0, 180.0, None, 600.0)


def guarded(**figures):
    """Return a decision on a run of an hour whose limits are 1 and 1.25."""
    return Guarded(**{'acceptance_limit_deg2': 1.0, 'rejection_limit_deg2': 1.25,
                      'd_hat_deg2': 0.5, 'count_outcome': Outcome.INDETERMINATE,
                      'outcome': Outcome.INDETERMINATE, 'reason': '', **figures})


def need(reason, covered=COVERED, n=3600, left=None, drifts=None, **figures):
    return describe_need(reason, guarded(**figures), covered, n=n, drift_left_deg2=left,
                         drifts=drifts)


@pytest.mark.parametrize('hours, words', [
    (0.1, 'measure 10 min (0.17 h) in all if the errors stay as they are'),
    (1.5, 'measure 90 min (1.50 h) in all if the errors stay as they are'),
    (12.34, 'measure 12.4 h in all if the errors stay as they are'),
    (20_000.0, 'measure 2.3 years in all, which is not practicable, if the errors stay as they '
     'are')])
def test_wide_bounds_need_the_length_of_the_decision(hours, words):
    """A length is rounded up, so that it suffices, and is at least the least of a run."""
    assert need('data_limited', hours_needed=hours) == words


@pytest.mark.parametrize('hours', [None, math.inf])
def test_no_length_decides_between_the_limits(hours):
    told = need('data_limited', hours_needed=hours, d_hat_deg2=1.1)
    assert told.startswith('no length decides') and 'sigma_ref' in told


def test_a_short_run_needs_the_least_length():
    short = replace(COVERED, span_s=60.0, least_duration_s=46_000.0)
    assert need('insufficient_duration', short, hours_needed=46_000.0 / 3600.0) == \
        'measure 12.8 h in all'
    assert need('insufficient_duration', short, hours_needed=20.0) == \
        'measure 12.8 h in all, or 20.0 h in all if the errors stay as they are'
    assert need('insufficient_duration', short, hours_needed=math.inf).startswith(
        'measure 12.8 h in all, but no length decides')


def test_a_slow_part_is_covered_by_a_run_twenty_times_as_long():
    """It shows in the record, so it is no slower than the record."""
    assert need('slow_errors_not_resolved', hours_needed=None) == \
        'measure 20.0 h in all, or at least five runs'
    assert need('slow_errors_not_resolved', hours_needed=3.0) == \
        'measure 3.0 h in all, or at least five runs'


def test_too_few_differences_need_their_number_and_the_least_length():
    few = replace(COVERED, span_s=19.0)
    assert need('insufficient_data', few, n=20) == \
        'measure 10 min (0.17 h) in all, with at least 128 differences'
    slow = replace(COVERED, span_s=3600.0)
    assert need('insufficient_data', slow, n=11) == \
        'measure 12.8 h in all, with at least 128 differences'
    assert 'spread evenly' in need('insufficient_data', n=200)
    assert need('insufficient_data', replace(few, span_s=0.0, least_duration_s=0.0), n=1) == \
        'measure at least 128 differences'


def test_a_drift_that_is_real_grows_and_one_that_is_not_becomes_known():
    """Room 0.5, bound 1.5: three times the length, if the bound is uncertainty alone."""
    assert need('drift_left_in', left=1.5, drifts=False).startswith('measure 3.0 h in all, or ')
    for told in (need('drift_left_in', left=1.5, drifts=True), need('drift_left_in', left=1.5),
                 need('drift_left_in', left=1.5, drifts=False, d_hat_deg2=1.0)):
        assert told.startswith('no length helps') and 'drift_order' in told


@pytest.mark.parametrize('reason', ['reference_limited', 'total_error_not_within_norm',
                                    'void.clocks', 'outliers_decide'])
def test_where_no_length_helps_the_words_say_so(reason):
    told = need(reason)
    assert 'no length' in told or 'no longer record' in told or 'only if they do not' in told
    assert 'in all' not in told


@pytest.mark.parametrize('reason', ['upper_bound_within_acceptance_limit', 'rejected_at_a_look',
                                    'a reason of later'])
def test_a_run_that_is_decided_needs_nothing(reason):
    assert need(reason) == ''


def together(**figures):
    return Together(**{
        'runs': 4, 'n': 4000, 'span_s': 14_400.0, 'apart_s': 1e4, 'd_hat_deg2': 0.5, 'nu': 100.0,
        'f': 10.0, 'slow_allowance_deg2': 0.0, 'pooled_upper_bound_deg2': 1.5,
        'between_upper_bound_deg2': None, 'upper_bound_deg2': 1.5, 'lower_bound_deg2': 0.3,
        'acceptance_limit_deg2': 1.0, 'rejection_limit_deg2': 1.25, 'rate_plus_lower': 0.0,
        **figures})


def test_runs_together_need_a_total_length():
    """U is 1 above D and the room is 0.5: four times the length. Above R by logarithms."""
    assert describe_need_together('data_limited', together(), COVERED) == \
        'measure 16.0 h in all if the errors stay as they are'
    above = together(d_hat_deg2=1.25 ** 2, lower_bound_deg2=1.0)
    assert describe_need_together('data_limited', above, COVERED) == \
        'measure 16.0 h in all if the errors stay as they are'
    assert describe_need_together('data_limited', together(d_hat_deg2=1.1), COVERED).startswith(
        'no length decides')
    assert describe_need_together('insufficient_duration', together(), COVERED) == \
        'measure 10 min (0.17 h) in all'
    assert describe_need_together('slow_errors_not_resolved', together(), COVERED) == \
        'measure 80.0 h in all, or at least five runs'
    assert describe_need_together('reference_limited', together(), None) == 'no length helps'
    assert describe_need_together('data_limited', None, None) == ''
    assert describe_need_together('a_run_void', together(), COVERED) == ''
