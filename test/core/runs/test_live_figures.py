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

"""Live figures: equal to the final ones, and without a verdict."""

from __future__ import annotations

import json

import numpy as np
import pytest

from heading_intercompare import Compliance, Pairs, Settings

S = 10 ** 9
NORMS = {'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1}


def compliance(**names):
    return Compliance(Settings.from_mapping({**NORMS, **names}))


@pytest.fixture
def pairs(rng):
    stamps = np.arange(1, 2001) * S // 2
    rs = np.mod(300.0 + stamps / S / 20.0, 360.0)
    return Pairs.of(stamps, np.mod(rs + 0.1 * rng.standard_normal(2000), 360.0), rs)


def test_the_bounds_of_the_moment_are_those_of_the_end_to_the_bit(pairs):
    live, end = compliance(), compliance()
    for lo in range(0, 2000, 37):
        live.update(pairs[lo:lo + 37])
    end.update(pairs)
    now = live.run_figures()
    end.finish()
    guarded = end.verdict().runs[0].guarded
    for key in ('nu', 'f', 'slow_allowance_deg2', 'lower_bound_deg2', 'upper_bound_deg2',
                'acceptance_limit_deg2', 'rejection_limit_deg2', 'bias_u_deg'):
        assert now[key] == getattr(guarded, key), key


def test_no_figure_can_be_read_as_a_verdict(pairs):
    live = compliance()
    live.update(pairs)
    for figures in (live.run_figures(), live.rolling_figures()):
        text = json.dumps(figures).lower()
        assert 'complian' not in text and 'outcome' not in text and 'indeterminate' not in text


@pytest.mark.parametrize('names, expected', [
    ({}, None), ({'drift_order': 1}, 'drift'), ({'drift_order': 'auto'}, 'drift'),
    ({'drift_order': 2, 'runs.stabilization_s': 'auto'}, 'drift stabilization')])
def test_what_is_taken_out_at_the_end_only_is_named(pairs, names, expected):
    live = compliance(**names)
    live.update(pairs)
    assert live.run_figures()['not_yet_removed'] == expected


def test_what_a_run_lacks_is_the_length_that_its_end_would_ask_for(pairs):
    """The judgement at the end says how long the run must be; what it has is subtracted."""
    live, end = compliance(), compliance()
    live.update(pairs[:400])
    end.update(pairs[:400])
    end.finish()
    now, guarded = live.run_figures(), end.verdict().runs[0].guarded
    assert now['span_s'] == pytest.approx(199.5)
    assert now['needed_s'] == pytest.approx(guarded.hours_needed * 3600.0 - 199.5)
    assert now['needed_s'] > 60.0


def test_with_a_plan_the_next_look_has_a_time_and_more_data_are_needed(pairs):
    """Planned 1000 s, least 200 s: looks at 250 s and 500 s; the last one is the end itself."""
    planned = {'sequential.plan_s': 1000.0, 'risk.min_duration_s': 200.0}
    plain, live = compliance(**{'risk.min_duration_s': 200.0}), compliance(**planned)
    found = []
    for lo in range(0, 2000, 400):
        plain.update(pairs[lo:lo + 400])
        live.update(pairs[lo:lo + 400])
        found.append(live.run_figures()['next_look_ns'])
        assert live.run_figures()['needed_s'] >= plain.run_figures()['needed_s']
    first_ns = int(pairs.stamp_ns[0])
    assert found == [first_ns + 250 * S, first_ns + 500 * S, None, None, None]
    assert plain.run_figures()['next_look_ns'] is None


@pytest.mark.parametrize('settling_s, times_s', [
    (0.0, [200.0, 200.0, 800.0]), (100.0, [300.0, 300.0, 500.0])])
def test_the_first_open_look_is_known_as_soon_as_the_run_has_a_pair(pairs, settling_s, times_s):
    """Its span counts from the end of the stabilisation period, also while that lasts."""
    live = compliance(**{'sequential.plan_s': 'open', 'risk.min_duration_s': 200.0,
                         'runs.stabilization_s': settling_s})
    assert 'next_look_ns' not in live.run_figures()
    first_ns, following = int(pairs.stamp_ns[0]), []
    for lo, hi in ((0, 1), (1, 150), (150, 1000)):
        live.update(pairs[lo:hi])
        following.append(live.run_figures()['next_look_ns'] - first_ns)
    assert following == [round(time_s * S) for time_s in times_s]


def test_where_the_clock_cuts_runs_their_end_is_known(pairs):
    plain, cut = compliance(), compliance(**{'runs.every_h': 1.0})
    for live in (plain, cut):
        live.update(pairs[:400])
    newest_ns = int(pairs.stamp_ns[399])
    ends_ns = cut.run_figures()['ends_ns']
    assert 0 < ends_ns - newest_ns <= 3600 * S and ends_ns % (3600 * S) == 0
    assert plain.run_figures()['ends_ns'] is None


def test_a_run_that_lacks_nothing_needs_no_more_time(pairs):
    live = compliance(**{'risk.min_duration_s': 200.0})
    live.update(pairs)
    assert live.run_figures()['needed_s'] == 0.0


def test_too_few_differences_say_nothing_about_what_is_needed(pairs):
    live = compliance()
    live.update(pairs[:50])
    assert live.run_figures()['needed_s'] is None
