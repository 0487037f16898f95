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

"""What people see of several sensors."""

from __future__ import annotations

import pytest

from heading_intercompare.core.records import Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.messages.status_messages import ERROR, OK, Status
from heading_intercompare.web.bridge.bridge_records import Tone
from heading_intercompare.web.bridge.bridge_view import Bridge
from heading_intercompare.web.bridge.view_texts import sensor_words, vote_words

ROWS = 'gyro sigma_max_deg=0.3; ins sigma_max_deg=0.1; gnss sigma_max_deg=0.1'
FIGURES = [
    Status('gyro', OK, '', {'heading_deg': '45.04', 'last_deg': '45.04', 'age_s': '0.1',
                            'rate_hz': '10.0', 'stale': 'false'}),
    Status('ins', OK, '', {'last_deg': '46.0', 'age_s': '60.0', 'stale': 'true'}),
    Status('gyro - ins', OK, '', {'std_deg': '0.5', 'share': '1.6', 'mean_deg': '0.2'}),
    Status('gyro - gnss', OK, '', {'std_deg': '0.4', 'share': '1.3', 'mean_deg': '0.1'}),
    Status('ins - gnss', OK, '', {'std_deg': '0.05', 'share': '0.4', 'mean_deg': '-0.03'})]
VOTE = [Status('now', ERROR, 'gyro differs from ins and gnss', {'wrong': 'gyro'})]
VERDICT = [Status('verdict', ERROR, 'gyro NON-COMPLIANT', {'outcome': 'non_compliant',
                                                           'validity': 'holds'}),
           Status('gyro', ERROR, 'NON-COMPLIANT', {'outcome': 'non_compliant',
                                                   'validity': 'holds'})]


def bridge(rows):
    """Return a bridge that has heard all topics at 100 s."""
    made = Bridge(Settings(sensors=rows))
    for topic, statuses in (('figures', FIGURES), ('vote', VOTE), ('verdict', VERDICT)):
        made.take_sensors(topic, 5, statuses, 100.0)
    return made


def test_each_sensor_has_its_heading_its_figures_against_the_reference_and_its_outcome():
    view = bridge(ROWS + ' rs').view(100.5)
    gyro, ins, gnss = view.sensors.rows
    assert (gyro.now.heading_deg, gyro.now.age_s, gyro.against) == (45.04, 0.6, 'gnss')
    assert (gyro.mean_deg, gyro.std_deg, gyro.share, gyro.named) == (0.1, 0.4, 1.3, True)
    assert gyro.lamp.word == 'NON-COMPLIANT' and gyro.lamp.tone is Tone.BAD
    assert ins.now.stale and ins.now.heading_deg is None and ins.lamp.word == 'NONE YET'
    assert gnss.reference and gnss.now.age_s is None
    assert view.lamp.word == 'NON-COMPLIANT'


def test_without_a_reference_the_figures_are_those_against_the_nearest_sensor():
    _, ins, gnss = bridge(ROWS).view(100.5).sensors.rows
    assert (ins.against, ins.mean_deg) == ('gnss', -0.03)
    assert (gnss.against, gnss.mean_deg) == ('ins', 0.03), 'of gnss - ins'


def test_the_words_say_all_of_it():
    view = bridge(ROWS + ' rs').view(100.5)
    words = dict(sensor_words(view))
    assert words['gyro'].text == (
        '045.0°  age 0.6 s, 10.0 Hz; from gnss: mean +0.100°, sd 0.400° = 1.30 of what both norms '
        'explain; ✖ NON-COMPLIANT; the vote names it now')
    assert words['gyro'].tone is Tone.BAD
    assert words['ins'].text.startswith('– –     STALE: last 046.0°, 60 s ago')
    assert 'the reference' in words['gnss'].text
    assert vote_words(view) == ('now: gyro differs from ins and gnss', Tone.BAD)


def test_two_and_several_sensors_are_shown_by_the_same_rows():
    for view, names in ((bridge(ROWS + ' rs').view(100.5), ['gyro', 'ins', 'gnss']),
                        (Bridge(Settings()).view(1.0), ['ts', 'rs'])):
        assert [row.name for row in view.rows] == names
        assert all(row.title for row in view.rows)
        assert [trend.sensor for trend in view.trends] == names[:-1]


def test_each_tested_sensor_has_its_difference_and_its_trend():
    """The difference of 0.5 less an installation offset of 0.4 degrees."""
    made = Bridge(Settings(sensors='gyro sigma_max_deg=0.3 installation_offset_deg=0.4; '
                           'gnss sigma_max_deg=0.1 rs'), limits_deg={'gyro': 0.7})
    made.take_sensors('figures', 5, FIGURES, 100.0)
    made.take_pairs(Pairs.of([10 ** 9, 2 * 10 ** 9], [45.5, 45.5], [45.0, 45.0]), 100.0, 'gyro')
    gyro, gnss = made.view(100.5).rows
    assert gyro.difference_deg == pytest.approx(0.1) and gnss.difference_deg is None
    trend, = made.view(100.5).trends
    assert trend.limit_deg == 0.7 and trend.columns[-1].high_deg == pytest.approx(0.1)
    assert made.view(120.0).rows[0].difference_deg is None, 'it is stale'


def test_the_run_that_lacks_most_says_when_several_sensors_are_decided():
    made = bridge(ROWS + ' rs')
    for tested, needed_s in (('gyro', '60'), ('ins', '600')):
        made.take_run(5, [Status('run', OK, '', {'run': '1', 'n': '9', 'needed_s': needed_s})],
                      100.0, tested=tested)
    assert made.view(100.5).run.needed_s == 600.0


def test_figures_that_are_old_are_no_longer_values():
    view = bridge(ROWS).view(120.0)
    assert view.sensors.stale and not view.sensors.rows[0].named
    assert view.sensors.rows[0].now.heading_deg is None
    assert 'STALE' in vote_words(view).text


def test_two_sensors_have_no_panel():
    view = Bridge(Settings()).view(1.0)
    assert view.sensors is None and sensor_words(view) == [] and vote_words(view).text == ''
