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
    _in_all,
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


def test_a_slow_part_needs_several_runs_or_lengths_with_their_measured_chances():
    """Level 0.5 and 0.9; R = 7, 20 and 40; from ``docs/risk.md``."""
    several = ('five or more runs like this one, further apart than 10 min, with '
               'campaign.rule=sensor, or measure ')
    assert need('slow_errors_not_resolved', d_hat_deg2=0.25, r_slow=7.0) == several + (
        '2.0 h in all (certifies 67 of 100 such runs), or 4.0 h in all (certifies 78 of 100 such '
        'runs)')
    assert need('slow_errors_not_resolved', d_hat_deg2=0.5, r_slow=20.0) == several + (
        '4.0 h in all (certifies 54 of 100 such runs), or 8.0 h in all (certifies 72 of 100 such '
        'runs)')
    assert need('slow_errors_not_resolved', d_hat_deg2=0.81, r_slow=40.0) == several + (
        '8.0 h in all (certifies 51 of 100 such runs)')


def test_a_statement_that_the_record_contradicts_is_to_be_mended():
    stated = replace(COVERED, stated_s=100.0)
    told = need('slow_errors_not_resolved', stated, r_slow=20.0, stated_times=36.0)
    assert told.startswith('the errors are slower than the stated 100 s: state what is true')


def test_short_runs_come_before_a_long_one_if_the_slowest_error_is_stated():
    short = Coverage(3600.0, 180.0, 2300.0, 46_000.0)
    assert need('insufficient_duration', short, hours_needed=46_000.0 / 3600.0) == \
        'ten runs of 6.4 h, further apart than 38 min, with campaign.rule=sensor, or measure ' \
        '12.8 h in all'


@pytest.mark.parametrize('reason', ['slow_errors_not_resolved', 'data_limited',
                                    'reference_limited'])
def test_what_the_same_record_lacks_is_said_first(reason):
    told = describe_need(reason, guarded(m_low_needed=0.731, r_slow=7.0, hours_needed=2.0),
                         COVERED, n=3600, drift_left_deg2=None, drifts=None, warm_up_s=1200.0)
    assert told.startswith(
        'a warm-up of 20 min was found: runs.stabilization_s=auto leaves it out; this record '
        'certifies if the RS is known to have at least 0.74 of its norm (norms.m_low); ')


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
        'measure 1 more run like these, further apart than 10 min'
    assert describe_need_together('slow_errors_not_resolved', together(runs=6), COVERED) == \
        'measure 8.0 h in all, or runs further apart than 10 min (variant B)'
    assert describe_need_together('reference_limited', together(), None) == 'no length helps'
    assert describe_need_together('data_limited', None, None) == ''
    assert describe_need_together('a_run_void', together(), COVERED) == ''


@pytest.mark.parametrize('span_s, words', [
    (60.0, '60 s (0.02 h) in all'), (60.5, '61 s (0.02 h) in all'),
    (600.0, '10 min (0.17 h) in all'), (601.0, '11 min (0.17 h) in all'),
    (7200.0, '2.0 h in all'), (7201.0, '2.1 h in all')])
def test_a_length_in_words_suffices_and_a_whole_one_is_itself(span_s, words):
    assert _in_all(span_s) == words
