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

"""Alarms as alerts in plain words, with what follows from them."""

from __future__ import annotations

import pytest

from heading_intercompare.core.alarms.comparison_watch import COMPARISON_RULES
from heading_intercompare.core.alarms.graph_watch import TROUBLE_RULES
from heading_intercompare.core.alarms.motion_watch import MOTION_RULES
from heading_intercompare.core.alarms.sentence_watch import SENTENCE_RULES
from heading_intercompare.core.alarms.stream_watch import STREAM_RULES
from heading_intercompare.web.bridge.alert_list import AlertList, state_of
from heading_intercompare.web.bridge.bridge_records import AlarmView

T0 = 1_700_000_000 * 10 ** 9
TWO = AlertList({'ts': 'Tested sensor', 'rs': 'Reference'}, 'rs')
FOUR = AlertList({name: name for name in ('gyro1', 'gyro2', 'ins', 'gnss')}, 'gnss')
RULES = [(node, rule) for node, rules in (
    ('compliance', (*COMPARISON_RULES, *TROUBLE_RULES, *MOTION_RULES)),
    ('synchronizer', STREAM_RULES), ('ts_driver', SENTENCE_RULES)) for rule in rules]


def alarm(name, priority='warning', state='active_unacknowledged', **values):
    return AlarmView(name, priority, state, f'words of {name}', T0, {
        'size_deg': '1.234', 'step_s': '3600.04', **values})


def words(alerts, *alarms, now_ns=None):
    return [alert.words for alert in alerts.list_alerts(alarms, now_ns)]


@pytest.mark.parametrize('node, rule', RULES, ids=[rule.name for _, rule in RULES])
def test_every_alarm_of_the_graph_has_plain_words(node, rule):
    alert, = TWO.list_alerts([alarm(f'{node}: {rule.name}', str(rule.priority))], None)
    assert alert.words != alert.details and '_' not in alert.words
    for word in ('ts', 'rs', 'TS', 'RS', 'node', 'topic', 'compliance', 'synchronizer'):
        assert word not in alert.words.split()
    assert '{' not in alert.words


@pytest.mark.parametrize('node', ['recorder', 'compliance', 'synchronizer', 'ts_driver',
                                  'rs_driver', 'motion_driver', 'dashboard', 'alert_sender'])
def test_a_node_that_has_stopped_is_said_in_plain_words(node):
    alert, = TWO.list_alerts([alarm(f'compliance: {node}_silent')], None)
    assert '_' not in alert.words and 'words of' not in alert.words


@pytest.mark.parametrize('alerts, name, said, sensor', [
    (TWO, 'compliance: ts_frozen', 'Tested sensor frozen', 'ts'),
    (TWO, 'compliance: rs_frozen', 'Reference frozen', 'rs'),
    (TWO, 'rs_driver: checksum', 'Reference: sentences come damaged', 'rs'),
    (TWO, 'compliance: jump', 'Tested sensor differs by +1.23° from before', 'ts'),
    (TWO, 'synchronizer: clock_step', 'A clock stepped by +3600 s', ''),
    (FOUR, 'compliance: gyro2_wrong', 'gyro2 differs from the others', 'gyro2'),
    (FOUR, 'gyro1/compliance: jump', 'gyro1 differs by +1.23° from before', 'gyro1'),
    (FOUR, 'gyro1/compliance: ts_frozen', 'gyro1 frozen', 'gyro1'),
    (FOUR, 'gyro1/synchronizer: rs_silent', 'gnss silent', 'gnss'),
    (FOUR, 'compliance: gyro1_driver_silent', 'gyro1: its driver has stopped', 'gyro1'),
    (FOUR, 'ins_driver: checksum', 'ins: sentences come damaged', 'ins')])
def test_an_alert_names_the_sensor(alerts, name, said, sensor):
    alert, = alerts.list_alerts([alarm(name)], None)
    assert (alert.words, alert.sensor) == (said, sensor)


def test_an_alarm_of_another_program_says_its_own_words():
    assert words(TWO, alarm('pump: hot')) == ['words of pump: hot']


@pytest.mark.parametrize('cause, consequences', [
    ('compliance: ts_driver_silent', ['synchronizer: ts_silent']),
    ('compliance: rotated', ['compliance: jump', 'compliance: outliers']),
    ('compliance: recorder_silent', ['compliance: not_recorded']),
    ('compliance: clock_step', ['synchronizer: clock_step'])])
def test_consequences_stand_under_their_cause(cause, consequences):
    alert, = TWO.list_alerts(map(alarm, [*consequences, cause]), None)
    assert set(alert.alarms) == {cause, *consequences}


def test_a_chain_has_one_cause_and_one_entry():
    alert, = FOUR.list_alerts(map(alarm, [
        'compliance: gyro1_wrong', 'gyro1/compliance: ts_frozen', 'gyro1/compliance: jump',
        'compliance: gyro1_driver_silent', 'gyro1/synchronizer: ts_silent']), None)
    assert alert.words == 'gyro1: its driver has stopped' and len(alert.alarms) == 5
    assert 'gyro1 frozen' in alert.consequences


def test_the_reference_that_is_silent_for_three_comparisons_is_one_alert():
    alert, = FOUR.list_alerts([alarm(f'{name}/synchronizer: rs_silent')
                               for name in ('gyro1', 'gyro2', 'ins')], None)
    assert alert.words == 'gnss silent' and len(alert.alarms) == 3 and not alert.consequences


def test_a_fault_of_one_sensor_explains_nothing_of_another():
    assert len(words(FOUR, alarm('gyro1/compliance: ts_frozen'),
                     alarm('compliance: gyro2_wrong'))) == 2
    assert len(words(TWO, alarm('compliance: rs_driver_silent'),
                     alarm('synchronizer: ts_silent'))) == 2


def test_a_cause_that_is_over_explains_nothing_that_goes_on():
    alarms = [alarm('compliance: ts_driver_silent', state='rectified_unacknowledged'),
              alarm('synchronizer: ts_silent')]
    assert words(TWO, *alarms) == ['Tested sensor silent', 'Tested sensor: its driver has stopped']


def test_the_gravest_unacknowledged_alert_comes_first():
    alarms = [alarm('compliance: lost_on_the_way', 'caution'),
              alarm('compliance: ts_frozen', state='active_acknowledged'),
              alarm('compliance: rs_frozen'), alarm('x: fire', 'alarm')]
    assert words(TWO, *alarms) == ['words of x: fire', 'Reference frozen', 'Messages were lost',
                                   'Tested sensor frozen']


def test_what_was_acknowledged_is_not_acknowledged_again():
    alarms = [alarm('compliance: rotated', state='active_acknowledged'), alarm('compliance: jump')]
    alert, = TWO.list_alerts(alarms, None)
    assert alert.alarms == ('compliance: jump',) and not alert.acknowledged


@pytest.mark.parametrize('now_ns, age_s', [
    (None, None), (T0 + 12 * 10 ** 9, 12.0), (T0 - 10 ** 9, None), (T0 + 10 ** 18, None)])
def test_the_age_is_that_in_the_time_of_the_data(now_ns, age_s):
    alert, = TWO.list_alerts([alarm('compliance: jump')], now_ns)
    assert alert.age_s == age_s


def test_the_state_of_a_sensor_is_that_of_its_gravest_active_alert():
    alerts = TWO.list_alerts([alarm('compliance: ts_frozen'), alarm('ts_driver: checksum',
                                                                    'caution')], None)
    assert state_of('ts', alerts).state == 'frozen' and state_of('rs', alerts) is None
