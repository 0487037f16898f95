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

"""The uncertainty budget adds up, and each uncertainty has two significant digits."""

from __future__ import annotations

from dataclasses import replace

import pytest

from heading_intercompare.report.contents.uncertainty_budget import budget_of


def rows_of(run, settings):
    return {row[0]: row for row in budget_of(run, settings).rows}


def test_the_sources_add_up_by_squares(made):
    """0.03² + 0.04² = 0.05²."""
    verdict = made(1, installation_offset_u_deg=0.03)[0]
    run = verdict.runs[0]
    run = replace(run, guarded=replace(run.guarded, bias_u_deg=0.05))
    rows = rows_of(run, verdict.settings)
    assert [rows[name][3] for name in ('sampling', 'installation angle', 'together')] == \
        ['0.040', '0.030', '0.050']
    assert rows['expanded uncertainty'][3] == '0.10'


def test_without_an_uncertainty_there_is_no_expanded_one(made):
    verdict = made(1, n=20)[0]
    assert rows_of(verdict.runs[0], verdict.settings)['expanded uncertainty'][3] == '-'


def test_timing_times_the_rate_of_turn_is_a_variance(made):
    """(0.4² + 0.3²) s² times (2 deg/s)² = 1 deg²."""
    verdict = made(1)[0]
    run = verdict.runs[0]
    run = replace(run, skew=replace(run.skew, estimate=replace(
        run.skew.estimate, skew_s=0.4, u_s=0.3, rate_std_deg_s=2.0)))
    assert rows_of(run, verdict.settings)['timing'][4] == '1.0'
    none = replace(run, skew=replace(run.skew, estimate=replace(
        run.skew.estimate, skew_s=None, u_s=None)))
    assert rows_of(none, verdict.settings)['timing'][1:] == [
        'latency and clock offset of the stamps are not known', 'A', '-', '-']


@pytest.mark.parametrize('given, words, variance', [
    ({}, 'from 0 to 0.1 deg', '0 to 0.01'),
    ({'norms__m_low': 0.5}, 'from 0.05 to 0.1 deg', '0.0025 to 0.01'),
    ({'norms__sigma_ref_deg': 0.05}, 'known, 0.05 deg', '0.0025')])
def test_the_reference_has_a_range_or_is_known(made, given, words, variance):
    verdict = made(1, **given)[0]
    row = rows_of(verdict.runs[0], verdict.settings)['reference sensor, sigma_ref']
    assert (row[1], row[4]) == (words, variance)


def test_the_bounds_of_a_run_that_is_too_short_or_void_are_not_claimed(made):
    verdict = made(1)[0]
    run = verdict.runs[0]
    assert run.reason == 'insufficient_duration'
    assert 'at least' in rows_of(run, verdict.settings)['sampling'][4]
    void = replace(run, validity_effect='void')
    assert rows_of(void, verdict.settings)['sampling'][4] == 'the variance is not bounded'
    few = made(1, n=20)[0]
    assert rows_of(few.runs[0], few.settings)['together'][3] == '-'
