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

"""Each error alone is seen by its test and by no other; a sound sensor by none."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np
import pytest
from sailed_trials import sail

from heading_intercompare import analyze
from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.diagnostics.by_motion import BySector
from heading_intercompare.core.norm_tests.judged_test import (
    MET,
    NOT_MET,
    NOT_SAILED,
    OPEN,
    TestRisks,
)
from heading_intercompare.core.norm_tests.static_error import measure_static_error
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.records import Headings
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.consistency import check_consistency, ContradictionError
from heading_intercompare.core.verdict.verdict_document import Verdict

MSC = {'preset': 'imo_msc116', 'sigma_ref_max_deg': 0.1}
#: Six times sigma of any error here: the variance does not reject, so the test alone does.
WIDE = {'sigma_max_deg': 6.0, 'sigma_ref_max_deg': 0.1, 'tests': (
    'static_error 1.0; resolution 0.2; dynamic_error 1.5; fast_dynamic_error 0.5; '
    'follow_up 0.5 0-10; follow_up 1.5 10-20')}


def judge(errors, norms=None, **settings):
    return analyze(*sail(**errors), settings=Settings.of(**(norms or WIDE), **settings))


def states(verdict):
    rows = verdict.runs[0].norm_tests
    return {'fast_follow_up' if 'from 10 to 20 deg/s' in row.words else row.kind: row.state
            for row in rows}


SOUND = {'static_error': MET, 'resolution': MET, 'dynamic_error': MET, 'fast_dynamic_error': MET,
         'follow_up': MET, 'fast_follow_up': NOT_SAILED}


@pytest.mark.parametrize('norms', [MSC, WIDE])
@pytest.mark.parametrize('errors', [
    {}, {'lag_s': 0.02}, {'step_deg': 0.1}, {'static_deg': 0.7}, {'dynamic_deg': 0.25},
    {'noise_deg': 0.15}, {'turn_deg_s': 9.0}, {'seed': 2, 'rate_hz': 10.0}])
def test_a_sound_sensor_meets_every_test_that_was_sailed(errors, norms):
    verdict = judge(errors, norms)
    assert states(verdict) == SOUND
    assert verdict.outcome is Outcome.COMPLIANT
    assert '5 of 6 tests of the norm met; not sailed: follow-up error from 10' in verdict.headline


@pytest.mark.parametrize('errors,kind,value', [
    ({'lag_s': 0.3}, 'follow_up', 1.05), ({'lag_s': -0.3}, 'follow_up', 1.05),
    ({'step_deg': 0.5}, 'resolution', 0.25), ({'step_deg': 1.0}, 'resolution', 0.5),
    ({'static_deg': 1.5}, 'static_error', 1.5), ({'static_deg': -1.5}, 'static_error', 1.5),
    ({'dynamic_deg': 0.8}, 'fast_dynamic_error', 0.89),
    ({'dynamic_deg': 0.8, 'period_s': 20.0}, 'fast_dynamic_error', 0.89),
    ({'dynamic_deg': 2.5, 'period_s': 60.0}, 'dynamic_error', 2.5)])
def test_an_error_alone_breaks_its_test_alone(errors, kind, value):
    verdict = judge(errors)
    row, = (row for row in verdict.runs[0].norm_tests if row.state == NOT_MET)
    assert row.kind == kind and row.value == pytest.approx(value, rel=0.07)
    assert verdict.outcome is Outcome.NON_COMPLIANT
    assert verdict.runs[0].reason == f'test_not_met.{kind}'
    assert row.line in verdict.headline and row.clause in verdict.headline


@pytest.mark.parametrize('noise_deg', [0.3, 0.4])
def test_noise_is_no_dynamic_error(noise_deg):
    """95 % of it lie within 0.59 and 0.78 deg; no motion of the ship makes it."""
    verdict = judge({'noise_deg': noise_deg, 'rate_hz': 1.0})
    assert states(verdict)['fast_dynamic_error'] == OPEN
    assert verdict.outcome is Outcome.COMPLIANT


@pytest.mark.parametrize('period_s', [5.0, 8.0, 12.0, 25.0])
@pytest.mark.parametrize('noise_deg', [0.02, 0.2])
def test_a_swing_is_seen_beside_noise(noise_deg, period_s):
    verdict = judge({'noise_deg': noise_deg, 'dynamic_deg': 0.9, 'period_s': period_s})
    assert states(verdict)['fast_dynamic_error'] == NOT_MET


@pytest.mark.parametrize('errors', [
    {'dynamic_deg': 1.5, 'period_s': 60.0, 'noise_deg': 0.03},
    {'dynamic_deg': 0.5, 'noise_deg': 0.03}, {'step_deg': 0.4}, {'step_deg': 0.4, 'rate_hz': 1.0}])
def test_an_error_at_its_limit_breaks_no_test(errors):
    """The noise of the RS adds to the peaks of a swing, and a step is known to its rounding."""
    assert NOT_MET not in states(judge(errors)).values()


@pytest.mark.parametrize('period_s,state', [(20.0, NOT_MET), (40.0, MET), (60.0, MET)])
def test_a_slow_swing_may_be_larger(period_s, state):
    """0.8 deg are too much below 30 s, MSC.116(73) 4.3.2.3."""
    assert states(judge({'dynamic_deg': 0.8, 'period_s': period_s}))['fast_dynamic_error'] == state


def test_a_mounting_angle_or_a_clock_may_explain_what_is_not_met():
    """A certificate is refused, and the doubt is said; a stated mounting angle ends it."""
    for errors, words in (({'static_deg': 1.5}, 'unless the sensors are mounted 1.50 deg apart'),
                          ({'lag_s': 0.3}, 'unless the clocks of the sensors lie 0.30 s apart')):
        verdict = judge(errors)
        assert verdict.validity_effect == 'doubtful' and words in verdict.headline
    sure = judge({'static_deg': 1.5}, installation_offset_u_deg=0.05)
    assert sure.outcome is Outcome.NON_COMPLIANT and sure.validity_effect == 'holds'
    mounted = judge({'static_deg': 1.5}, installation_offset_deg=1.5,
                    installation_offset_u_deg=0.05)
    assert mounted.outcome is Outcome.COMPLIANT


@pytest.mark.parametrize('u_deg,state', [(0.05, MET), (0.3, OPEN)])
def test_the_mounting_angle_is_known_only_so_well(u_deg, state):
    assert states(judge({'static_deg': 0.8}, installation_offset_u_deg=u_deg))[
        'static_error'] == state


def test_a_deviation_on_one_heading_is_a_static_error():
    """The mean of the run is within the limit, that at 135 degrees is not."""
    ts, rs = sail()
    at = np.abs(wrap180(rs.heading_deg - 135.0)) < 20.0
    bent = Headings.of(ts.stamp_ns, (ts.heading_deg + np.where(at, 1.5, 0.1)) % 360.0)
    verdict = analyze(bent, rs, settings=Settings.of(**WIDE, installation_offset_u_deg=0.05))
    row = next(row for row in verdict.runs[0].norm_tests if row.kind == 'static_error')
    assert row.state == NOT_MET and row.value == pytest.approx(1.5, abs=0.05)
    assert '8 of 8 sectors; most at 135 deg' in row.record


@pytest.mark.parametrize('means_deg,half_deg,heading_deg,value', [
    ((1.3, 1.6, 0.1, 0.2), (0.02, 3.0, 0.02, 0.02), 0.0, 1.3),
    ((0.3, 0.6, 0.1, 0.2), (0.02, 0.02, 0.02, 0.02), 45.0, 0.6)])
def test_a_sure_error_is_not_hidden_by_a_larger_doubtful_one(means_deg, half_deg, heading_deg,
                                                              value):
    """1.30 +- 0.02 deg break the limit of 1 deg, whatever 1.6 +- 3 deg may be."""
    mean, half = np.array(means_deg), np.array(half_deg)
    sectors = BySector(heading_deg=(0.0, 45.0, 90.0, 135.0), n=(9,) * 4, duration_s=(9.0,) * 4,
                       mean_deg=means_deg, std_deg=(0.1,) * 4, low_deg=tuple(mean - half),
                       up_deg=tuple(mean + half))
    settings = Settings.of(**WIDE, installation_offset_u_deg=1e-6)
    tested = SimpleNamespace(
        by_motion=SimpleNamespace(sectors=sectors), settings=settings, is_mounting_stated=True,
        risks=TestRisks(0.05, 0.01))
    measured = measure_static_error(tested, 1.0)
    assert measured.value == value and f'most at {heading_deg:03.0f} deg' in measured.record
    assert (measured.risk_not_met <= 0.01) is (value > 1.0)


def test_a_static_error_on_one_heading_says_nothing_of_the_others():
    """It may break the norm there; it cannot meet it."""
    assert states(judge({'leg_s': 1e9}))['static_error'] == NOT_SAILED
    assert states(judge({'leg_s': 1e9, 'static_deg': 1.5}))['static_error'] == NOT_MET


@pytest.mark.parametrize('errors,kinds', [
    ({'yaw_deg': 0.2}, {'dynamic_error', 'fast_dynamic_error'}),
    ({'turn_deg_s': 0.5, 'yaw_deg': 0.0}, {'follow_up', 'dynamic_error', 'fast_dynamic_error'}),
    ({'rate_hz': 0.1, 'hours': 6.0, 'yaw_deg': 0.0},
     {'follow_up', 'dynamic_error', 'fast_dynamic_error'})])
def test_what_was_not_sailed_is_not_met(errors, kinds):
    """Neither in a calm sea, nor in slow turns, nor with one reading in ten seconds."""
    verdict = judge(errors)
    rows = {row.kind: row for row in verdict.runs[0].norm_tests if row.state == NOT_SAILED}
    assert set(rows) == kinds | {'follow_up'}
    assert all(row.manoeuvre for row in rows.values())


@pytest.mark.parametrize('step_deg,state', [(0.1, MET), (0.5, NOT_MET), (0.0, MET)])
def test_a_slow_reference_does_not_hide_the_step_of_the_sensor(step_deg, state):
    """The TS is interpolated to the stamps of the RS; its step is that of what it sent."""
    ts, rs = sail(rate_hz=10.0, hours=1.0, step_deg=step_deg)
    slow = Headings.of(rs.stamp_ns[3::10] + 30_000_000, rs.heading_deg[3::10])
    verdict = analyze(ts, slow, settings=Settings.of(**WIDE))
    row = next(row for row in verdict.runs[0].norm_tests if row.kind == 'resolution')
    assert row.state == state and row.value == pytest.approx(max(step_deg, 0.01) / 2.0)
    check_consistency(verdict)


def test_an_error_in_a_calm_sea_is_an_error():
    verdict = judge({'dynamic_deg': 0.8, 'yaw_deg': 0.2})
    assert states(verdict)['fast_dynamic_error'] == NOT_MET


@pytest.mark.parametrize('settings', [{'skew': 'apply'}, {'skew_s': 0.3}])
def test_a_skew_that_is_removed_removes_the_lag_with_it(settings):
    row = next(row for row in judge({'lag_s': 0.3}, **settings).runs[0].norm_tests
               if row.kind == 'follow_up')
    assert row.state == NOT_SAILED and 'judge with alignment.skew: report' in row.record


def test_a_notebook_shows_the_table_of_the_terminal():
    verdict = judge({'step_deg': 0.5})
    page = verdict._repr_html_()
    for row in verdict.campaign.norm_tests:
        assert f'<th>{row.words}</th>' in page and row.cells[1] in page


def test_a_norm_without_tests_has_no_table():
    verdict = judge({}, {'sigma_max_deg': 0.5, 'sigma_ref_max_deg': 0.1})
    assert verdict.runs[0].norm_tests is None and verdict.campaign.norm_tests is None
    assert 'norm_tests' not in verdict.to_dict()['runs'][0]


def test_limits_of_ones_own_replace_those_of_the_preset():
    verdict = judge({'step_deg': 0.1}, {**MSC, 'tests': 'resolution 0.02'})
    rows = {row.kind: row for row in verdict.runs[0].norm_tests}
    assert rows['resolution'].state == NOT_MET and rows['resolution'].clause == 'norms.tests'
    assert rows['static_error'].clause == 'MSC.116(73) 4.3.2.2'


@pytest.mark.parametrize('text,words', [
    ('static 1.0', "row 1: 'static 1.0': must be a test and its limit"),
    ('static_error 0', 'must be greater than 0'),
    ('static_error 1.0; static_error 2.0', 'row 2: .* an earlier row limits the same'),
    ('follow_up 0.5', 'needs the rates of turn'), ('follow_up 0.5 10-5', 'slowest rate must be'),
    ('resolution 0.2 0-10', 'only follow_up has rates'), ('speed_error 1.0', 'the tests are')])
def test_a_norm_that_cannot_be_read_is_refused(text, words):
    with pytest.raises(SettingsError, match=f'^norms.tests, .*{words}'):
        Settings.of(tests=text)


def test_a_limit_by_the_latitude_needs_it():
    with pytest.raises(SettingsError, match='norms.latitude_deg is missing'):
        judge({}, {**WIDE, 'tests': 'static_error 1.0 sec'})
    limits = [row.limit for row in judge({}, {**WIDE, 'tests': 'static_error 1.0 sec'},
                                         latitude_deg=60.0).runs[0].norm_tests]
    assert limits == pytest.approx([2.0])


@pytest.mark.parametrize('errors', [{}, {'lag_s': 0.3}, {'static_deg': 1.5}, {'step_deg': 0.5}])
def test_a_verdict_that_is_read_follows_from_its_tests(errors):
    verdict = Verdict.from_dict(json.loads(json.dumps(judge(errors).to_dict())))
    check_consistency(verdict)


@pytest.mark.parametrize('change', [
    {'state': MET}, {'high': 0.1, 'value': 0.1}, {'risk_not_met': 1.0}])
def test_a_table_that_was_changed_is_refused(change):
    document = judge({'step_deg': 0.5}).to_dict()
    row = next(row for row in document['runs'][0]['norm_tests'] if row['kind'] == 'resolution')
    row.update(change)
    with pytest.raises(ContradictionError):
        check_consistency(Verdict.from_dict(document))
