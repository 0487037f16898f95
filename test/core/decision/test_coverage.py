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

"""The coverage of a verdict: least durations by hand, and their words."""

from __future__ import annotations

import pytest

from heading_intercompare.core.decision.coverage import (
    coverage_of,
    least_duration_s,
    least_duration_words,
    SEA_STATE_S,
    SENSOR_CLASSES,
    slowest_error_s,
    span_words,
)
from heading_intercompare.core.declared_settings import list_settings, SettingsError
from heading_intercompare.core.settings import Risk, Settings


def test_a_twentieth_of_the_record_is_covered():
    found = coverage_of(624.0, Risk())
    assert (found.span_s, found.longest_s, found.stated_s, found.least_duration_s) == (
        624.0, 31.2, None, 600.0)
    assert found.words == ('for errors that change within 31 s, and that come at least three '
                           'times in the run; slower errors are not covered')


def test_a_statement_takes_the_place_of_the_default():
    assert least_duration_s(Risk(slowest_error_s=2.0)) == 40.0
    assert coverage_of(100.0, Risk(slowest_error_s=2.0)).words == \
        'for errors that change within 5 s, and that come at least three times in the run; ' \
        'the slowest stated is 2 s'


@pytest.mark.parametrize('given, least', [
    ({}, 600.0), ({'min_duration_s': 0.0}, 0.0), ({'min_duration_s': 7200.0}, 7200.0),
    ({'slowest_error_s': 100.0}, 2000.0), ({'slowest_error_s': 100.0, 'min_duration_s': 60.0},
                                           2000.0),
    ({'slowest_error_s': 100.0, 'min_duration_s': 3000.0}, 3000.0),
    ({'sensor_class': 'gyrocompass'}, 46_000.0),
    ({'sensor_class': 'gyrocompass', 'slowest_error_s': 60.0}, 1200.0)])
def test_the_least_duration_is_the_longest_that_is_asked_for(given, least):
    assert least_duration_s(Risk(**given)) == least


def test_the_classes_are_the_choices_of_the_setting():
    rule = next(r for r in list_settings(Settings) if r.name == 'risk.sensor_class')
    assert rule.choices == tuple(SENSOR_CLASSES)
    with pytest.raises(SettingsError, match="sensor_class = 'sextant'"):
        Risk(sensor_class='sextant')


@pytest.mark.parametrize('name', SENSOR_CLASSES)
def test_every_class_says_where_its_figure_comes_from_and_what_trial_follows(name):
    found = SENSOR_CLASSES[name]
    assert slowest_error_s(Risk(sensor_class=name)) == found.slowest_s
    assert found.source and found.trial
    feasible = found.least_s <= 24 * 3600.0
    assert feasible or 'no single run' in found.trial


def test_the_swing_of_a_gyrocompass_by_hand():
    """84.4 min / 2 / ln 3 = 38.41 min = 2305 s, rounded to 2300."""
    by_hand_s = 84.4 * 30.0 / 1.0986
    assert SENSOR_CLASSES['gyrocompass'].slowest_s == pytest.approx(by_hand_s, rel=0.005)


def test_no_class_is_faster_than_the_changes_of_the_sea_state():
    """Multipath changes in 5 min, but the sea state, and the size of the errors, in 30."""
    assert SENSOR_CLASSES['gnss_compass'].error_s == 300.0
    assert SENSOR_CLASSES['gnss_compass'].slowest_s == SEA_STATE_S
    assert min(one.slowest_s for one in SENSOR_CLASSES.values()) == SEA_STATE_S


@pytest.mark.parametrize('risk, words', [
    (Risk(), 'a run must last 10 min to comply; its slowest error is not stated '
     '(risk.slowest_error_s)'),
    (Risk(slowest_error_s=60.0, min_duration_s=3600.0),
     'a run must last 60 min to comply (risk.min_duration_s)'),
    (Risk(sensor_class='gnss_compass'),
     'a run must last 10.0 h to comply: 20 times its slowest error, 30 min')])
def test_the_length_is_said_before_the_trial(risk, words):
    assert least_duration_words(risk) == words


@pytest.mark.parametrize('span_s, words', [
    (5.25, '5.25 s'), (99.6, '100 s'), (120.0, '2 min'), (7199.0, '120 min'), (7200.0, '2.0 h')])
def test_spans_read_as_people_say_them(span_s, words):
    assert span_words(span_s) == words


def test_means_of_runs_stand_in_for_slow_errors():
    found = coverage_of(9000.0, Risk(), apart_s=3600.0)
    assert (found.longest_s, found.least_duration_s, found.by_run_means) == (3600.0, 600.0, True)
    assert found.words == \
        'for errors that change within 60 min, and that come at least three times in the run, ' \
        'or from run to run; slower errors are not covered'
    stated = coverage_of(9000.0, Risk(sensor_class='gyrocompass', min_duration_s=7200.0),
                         apart_s=3600.0)
    assert stated.least_duration_s == 7200.0
    assert stated.words.endswith('from run to run; the slowest stated is 38 min')
