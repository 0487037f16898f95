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

"""Settling time, settle point, rms of ten and repeatability: each error is seen by its test."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from sailed_trials import lie_alongside, START_NS

from heading_intercompare import analyze
from heading_intercompare.core.norm_tests.judged_test import (
    MET,
    NOT_MET,
    NOT_SAILED,
    OPEN,
    TestRisks,
)
from heading_intercompare.core.norm_tests.rms_of_ten import measure_rms_of_ten
from heading_intercompare.core.norm_tests.sets_of_ten import find_sets, SetOfTen
from heading_intercompare.core.norm_tests.settling import find_settling
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.consistency import check_consistency
from heading_intercompare.core.verdict.verdict_document import Verdict

KINDS = 'settling_time', 'settle_point', 'rms_of_ten', 'repeatability'
#: Twice the largest sigma here: the variance does not reject a settled sensor.
WIDE = {'sigma_max_deg': 1.0, 'sigma_ref_max_deg': 0.1,
        'tests': 'settling_time 6; settle_point 0.75; rms_of_ten 0.25; repeatability 0.25'}


def judge(trial=None, norms=None, **settings):
    return analyze(*lie_alongside(**(trial or {})), settings=Settings.of(
        **{**(norms or WIDE), 'stabilization_s': 'auto', **settings}))


def states(verdict):
    return {row.kind: row.state for row in verdict.campaign.norm_tests if row.kind in KINDS}


ALL_MET = dict.fromkeys(KINDS, MET)


@pytest.mark.parametrize('norms', [
    WIDE, {'preset': 'imo_a821', 'latitude_deg': 0.0, 'sigma_ref_max_deg': 0.1},
    {'preset': 'imo_a424', 'latitude_deg': 45.0, 'sigma_ref_max_deg': 0.1}])
def test_a_sound_gyrocompass_meets_every_test(norms):
    verdict = judge({}, norms)
    assert states(verdict) == ALL_MET
    assert verdict.outcome is not Outcome.NON_COMPLIANT


@pytest.mark.parametrize('trial, kind, value', [
    ({'points_deg': (1.3, 1.35, 1.25)}, 'settle_point', 1.35),
    ({'points_deg': (-1.3, -1.35, -1.25)}, 'settle_point', 1.35),
    ({'noise_deg': 0.5, 'hours': 18.0}, 'rms_of_ten', 0.5),
    ({'points_deg': (0.0, 0.6, -0.1)}, 'repeatability', 0.7)])
def test_an_error_alone_breaks_its_test_alone(trial, kind, value):
    verdict = judge(trial)
    assert [name for name, state in states(verdict).items() if state == NOT_MET] == [kind]
    row = next(row for row in verdict.campaign.norm_tests if row.kind == kind)
    assert row.value == pytest.approx(value, abs=0.15) and row.low > row.limit
    assert verdict.outcome is Outcome.NON_COMPLIANT


def test_a_slow_settling_breaks_the_settling_time_alone():
    """20 e^(-t/tau) falls by 0.7 deg an hour at t = tau ln(20 (1 - e^(-1 h/tau)) / 0.7)."""
    verdict = judge({'points_deg': (0.1,), 'hours': 9.0, 'tau_s': 12000.0, 'noise_deg': 0.01},
                    stabilization_s=0.0)
    first_h = 12000.0 / 3600.0 * math.log(20.0 * -math.expm1(-3600.0 / 12000.0) / 0.7)
    row = verdict.campaign.norm_tests[0]
    assert row.state == NOT_MET and row.low == pytest.approx(first_h, abs=0.1)
    assert row.value == row.high == row.low + 1.0
    assert set(states(verdict).values()) == {NOT_MET, NOT_SAILED}


def test_a_sensor_that_never_settles_breaks_the_settling_time():
    verdict = judge({'points_deg': (0.1,), 'tau_s': 40000.0, 'amplitude_deg': 18.0,
                     'noise_deg': 0.01}, stabilization_s=0.0)
    row = verdict.campaign.norm_tests[0]
    assert row.state == NOT_MET and row.record == 'not settled in 8.0 h'


@pytest.mark.parametrize('tau_s, state', [(7800.0, OPEN), (9000.0, OPEN), (4000.0, MET)])
def test_the_settling_time_lies_between_the_first_and_the_third_reading(tau_s, state):
    verdict = judge({'points_deg': (0.1,), 'hours': 9.0, 'tau_s': tau_s, 'noise_deg': 0.01},
                    stabilization_s=0.0)
    row = verdict.campaign.norm_tests[0]
    assert row.state == state and row.low <= row.limit
    assert (row.high <= row.limit) == (state == MET)


@pytest.mark.parametrize('settings', [{'stabilization_s': 1800.0}, {'every_h': 8.5}])
def test_a_start_that_is_left_out_is_no_start(settings):
    """Neither one that is cut off, nor the rest of a run that the clock cuts within it."""
    verdict = judge({'points_deg': (0.0, 0.6), 'hours': 12.0, 'tau_s': 4000.0}, **settings)
    starts = sum(run.norm_tests[-1].settle_point is not None for run in verdict.runs)
    rows = {row.kind: row.state for row in verdict.campaign.norm_tests}
    if 'every_h' in settings:
        assert len(verdict.runs) > 2 and starts <= 2
    else:
        assert starts == 0 and rows['settling_time'] == rows['repeatability'] == NOT_SAILED


def test_a_record_that_begins_settled_has_no_start():
    verdict = judge({'amplitude_deg': 0.3})
    assert states(verdict) == {'settling_time': NOT_SAILED, 'settle_point': MET,
                               'rms_of_ten': MET, 'repeatability': NOT_SAILED}
    assert verdict.campaign.norm_tests[0].record == 'settled from the first reading on, so it ' \
        'shows no start'
    assert all(row.manoeuvre for row in verdict.campaign.norm_tests if row.state == NOT_SAILED)


@pytest.mark.parametrize('trial, state', [
    ({'points_deg': (0.1, 0.15)}, NOT_SAILED), ({'points_deg': (0.0, 0.8)}, NOT_MET),
    ({'points_deg': (0.0, 0.8, 0.0), 'headings_deg': (73.6, 253.6)}, NOT_SAILED),
    ({'points_deg': (0.0, 0.8, 0.1, 0.7), 'headings_deg': (73.6, 253.6)}, NOT_SAILED),
    ({'points_deg': (0.0, 0.2, 0.1), 'noise_deg': 0.3}, OPEN)])
def test_two_starts_may_break_the_repeatability_and_three_on_one_heading_meet_it(trial, state):
    assert states(judge(trial))['repeatability'] == state


def test_the_limits_grow_with_the_secant_of_the_latitude():
    rows = judge({}, {'preset': 'imo_a821', 'latitude_deg': 60.0,
                      'sigma_ref_max_deg': 0.1}).campaign.norm_tests
    assert [row.limit for row in rows[:4]] == pytest.approx([6.0, 1.5, 0.5, 0.5])


def test_a_verdict_that_is_read_follows_from_its_starts():
    verdict = judge({'points_deg': (0.0, 0.6, -0.1)})
    again = Verdict.from_dict(json.loads(json.dumps(verdict.to_dict())))
    check_consistency(again)
    assert again.campaign.norm_tests == verdict.campaign.norm_tests


def minutes(*legs):
    """Return stamps, differences and headings, one a minute; each leg: minutes, x, heading."""
    x, rs = (np.concatenate([np.full(leg[0], float(leg[at])) for leg in legs]) for at in (1, 2))
    return START_NS + np.arange(x.size) * 60_000_000_000, x, rs


def test_three_readings_within_the_band_by_hand():
    """0.6 deg a half hour for 2 h, then steady: at 90 and 150 min within 0.7, at 60 within 1.2."""
    stamp_ns, _, _ = minutes((300, 0.0, 0.0))
    x = np.interp(np.arange(300.0), [0.0, 120.0], [2.4, 0.0])
    settling = find_settling(stamp_ns, x)
    assert settling.first_min == pytest.approx(85, abs=1)
    assert settling.third_min == settling.first_min + 60 and settling.span_min == 299
    assert find_settling(stamp_ns[:60], x[:60]) is None
    assert find_settling(stamp_ns[:0], x[:0]) is None
    assert find_settling(stamp_ns[:90], x[:90]).first_min is None


@pytest.mark.parametrize('legs, sets', [
    ([(180, 0.0, 70.0)], 0), ([(181, 0.0, 70.0)], 1), ([(380, 0.0, 70.0)], 1),
    ([(381, 0.0, 70.0)], 2), ([(381, 0.0, 359.0)], 2),
    ([(100, 0.0, 70.0), (281, 0.0, 90.0)], 1), ([(100, 0.0, 70.0), (281, 0.0, 78.0)], 2),
    ([(100, 0.0, 70.0), (100, 0.0, 160.0), (170, 0.0, 250.0)], 0)])
def test_sets_of_ten_by_hand(legs, sets):
    """The tenth reading comes after 180 min, the next set 20 min later; a turn ends a set."""
    assert len(find_sets(*minutes(*legs))) == sets


def test_a_silence_ends_a_set():
    stamp_ns, x, rs = minutes((300, 0.0, 70.0))
    there = np.ones(300, bool)
    there[97:105] = False
    assert len(find_sets(stamp_ns[there], x[there], rs[there])) == 1
    there[205:] = False
    assert find_sets(stamp_ns[there], x[there], rs[there]) == ()


def test_figures_of_a_set_by_hand():
    """Readings 0, 1 ... 9 hundredths: mean 0.045, variance 82.5 / 9 hundredths squared."""
    stamp_ns, _, rs = minutes((181, 0.0, 70.0))
    ten, = find_sets(stamp_ns, np.arange(181.0) / 2000.0, rs)
    assert ten.mean_deg == pytest.approx(0.045) and ten.heading_deg == 70.0
    assert ten.variance_deg2 == pytest.approx(82.5e-4 / 9.0)


@pytest.mark.parametrize('sets', [1, 4])
def test_the_risks_of_the_rms_are_those_stated(rng, sets):
    """A sensor at its limit: 2000 trials, within six standard errors; the RS has no part."""
    n, risks = 2000, TestRisks(met=0.05, not_met=0.02)
    tested = SimpleNamespace(risks=risks, reference_deg=lambda upper: 0.0)
    rejected = met = 0
    for readings in 0.25 * rng.standard_normal((n, sets, 10)):
        tested.sets_of_ten = [SetOfTen(0.0, float(ten.var(ddof=1)), 0.0) for ten in readings]
        measured = measure_rms_of_ten(tested, 0.25)
        rejected += measured.risk_not_met <= risks.not_met
        met += measured.high <= 0.25
        assert (measured.low > 0.25) == (measured.risk_not_met < risks.not_met)
    for share, risk in ((rejected / n, 0.02), (met / n, 0.05)):
        assert share == pytest.approx(risk, abs=6.0 * math.sqrt(risk * (1.0 - risk) / n))
