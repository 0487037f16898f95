#!/usr/bin/env python3
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
"""Readings that several runs hold count once, in the verdict and in the pooled figures."""

from __future__ import annotations

import numpy as np
import pytest
from trials import find_finding

from heading_intercompare import analyze, Headings, Settings
from heading_intercompare.core.verdict import runs_together
from heading_intercompare.core.verdict.runs_together import shortest_apart_s

T0_NS = 1_700_000_000_000_000_000
DAY_S = 86400.0


def trial(rng, span_s=1500.0, ts_deg=0.1):
    """Return times and headings of two sensors at 1 Hz on a ship that turns to and fro."""
    t_s = np.arange(span_s)
    course = 40.0 + 30.0 * np.sin(t_s / 90.0)
    return (t_s, course + ts_deg * rng.standard_normal(t_s.size),
            course + 0.05 * rng.standard_normal(t_s.size))


def judge(trials, rule='sensor'):
    """Return the verdict on trials (times, TS, RS)."""
    settings = Settings.from_mapping({'norms': {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1},
                                      'campaign': {'rule': rule}})
    headings = [[Headings.of(T0_NS + np.rint(t_s * 1e9).astype(np.int64), each % 360.0)
                 for t_s, each in ((t_s, ts), (t_s, rs))] for t_s, ts, rs in trials]
    return analyze([ts for ts, _ in headings], [rs for _, rs in headings], settings)


def test_two_recorders_on_one_trial_that_is_too_short_are_one_trial(rng):
    t_s, ts, rs = trial(rng, 400.0)
    other = t_s[5:] + 0.137, np.round(ts[5:], 2), np.round(rs[5:], 2) + 0.1
    found = judge([(t_s, ts, rs), other])
    assert (found.outcome.value, found.campaign.reason) == ('indeterminate', 'a_run_repeated')
    assert find_finding(found.campaign, 'repeated_readings').words == (
        'runs 1 and 2 hold the same readings, which count once')
    assert (found.campaign.sensor.runs, found.campaign.sensor.n) == (1, 400)
    assert found.campaign.sensor.span_s == pytest.approx(399.0)


@pytest.mark.parametrize('rule', ['sensor', 'every_run'])
def test_one_record_under_five_dates_counts_once_under_either_rule(rule, rng):
    one = trial(rng)
    found = judge([(one[0] + k * (DAY_S + 0.3), *one[1:]) for k in range(5)], rule)
    assert found.outcome.value == ('indeterminate' if rule == 'sensor' else 'compliant')
    assert find_finding(found.campaign, 'repeated_readings').effect == 'doubtful'
    assert found.validity_effect == 'doubtful'
    shared = found.campaign.sensor
    assert (shared.runs, shared.n, shared.between_upper_bound_deg2) == (1, 1500, None)
    assert found.campaign.homogeneity.m == 1


def test_records_that_overlap_are_found(rng):
    t_s, ts, rs = trial(rng, 2100.0)
    found = judge([tuple(each[k * 120:k * 120 + 1200] for each in (t_s, ts, rs))
                   for k in range(5)])
    assert found.campaign.reason == 'a_run_repeated' and found.campaign.sensor.n == 1200


@pytest.mark.parametrize('rule', ['sensor', 'every_run'])
def test_independent_runs_of_one_ship_all_count(rule, rng):
    """Also those of ships that sail at one time."""
    found = judge([(each[0] + (k // 2) * DAY_S, *each[1:])
                   for k, each in enumerate(trial(rng) for _ in range(6))], rule)
    assert find_finding(found.campaign, 'repeated_readings') is None
    assert (found.outcome.value, found.campaign.sensor.n) == ('compliant', 9000)


def test_readings_given_twice_do_not_hide_a_rejection(rng):
    bad = trial(rng, ts_deg=0.4)
    found = judge([bad, (bad[0] + DAY_S, *bad[1:])])
    assert found.outcome.value == 'non_compliant'


def test_a_block_that_was_pasted_makes_a_run_void(rng):
    t_s, ts, rs = trial(rng)
    for column in (ts, rs):
        column[900:1300] = column[100:500]
    run, = judge([(t_s, ts, rs)]).runs
    assert (run.outcome.value, run.reason) == ('indeterminate', 'void.repeated_readings')
    assert 'come again at 2023-11-14 22:28' in run.headline


def test_a_sound_run_says_that_no_stretch_comes_twice(rng):
    run, = judge([trial(rng)]).runs
    held = find_finding(run, 'repeated_readings')
    assert (held.effect, held.evidence) == ('holds', 'no stretch of some minutes comes twice')


def test_runs_are_apart_by_the_shortest_pause(rng):
    runs = judge([trial(rng), (trial(rng)[0] + 2000.0, *trial(rng)[1:])]).runs
    assert shortest_apart_s(runs) == pytest.approx(501.0)
    assert shortest_apart_s(runs[:1]) == np.inf


def test_each_pair_of_runs_is_compared_once_for_a_verdict(rng, monkeypatch):
    """Of more than 91 runs each pair was compared five times."""
    compared = []
    monkeypatch.setattr(runs_together, 'find_shared',
                        lambda late, early: compared.append((late, early)))
    judge([trial(rng, 400.0) for _ in range(4)])
    assert len(compared) == len({*compared}) == 6
