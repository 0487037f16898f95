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

"""What the bridge is told of alerts, and what its commands do."""

from __future__ import annotations

import pytest

from heading_intercompare.core.alarms.alarm import AlarmState, Priority
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.drivers.alerts.alert_list import (
    AlertList,
    identifier_of,
    ReportedAlert,
)
from heading_intercompare.drivers.alerts.alert_sentences import AlertCommand
from heading_intercompare.drivers.alerts.alert_settings import AlertSettings

NS = 1_700_000_000_000_000_000
V, A, U, N = (AlarmState.UNACKNOWLEDGED, AlarmState.ACKNOWLEDGED, AlarmState.RECTIFIED,
              AlarmState.NORMAL)


def report(state, name='jump', node='compliance', priority=Priority.WARNING, raised_ns=NS):
    """Return an alarm in a state."""
    return ReportedAlert(node, name, state, priority, 'TS - RS jumped', raised_ns, raised_ns)


def make_list(**settings):
    """Return a list that has told its first list and heartbeat."""
    alerts = AlertList(AlertSettings(**settings))
    alerts.due(0.0, NS, is_well=True)
    return alerts


def told(messages):
    """Return state, revision and escalation of each alert that was told."""
    rows = [body.split(',') for message in messages for body in message]
    return [(row[7], int(row[11]), int(row[12])) for row in rows
            if row[0] == 'IIALF' and row[2] == '1']


def command(letter, identifier=10005, instance=1, manufacturer=''):
    """Return a command for the alert `jump`."""
    return AlertCommand(manufacturer, identifier, instance, letter)


def test_each_change_is_told_once_with_the_next_revision():
    """States of MSC.302: unacknowledged, acknowledged, normal; or rectified in between."""
    alerts = make_list()
    states = [N, V, V, A, A, N, N]
    assert [told(alerts.update([report(state)], 1.0, NS)) for state in states] == [
        [], [('V', 1, 0)], [], [('A', 2, 0)], [], [('N', 3, 0)], []]
    again = NS + 1
    assert [told(alerts.update([report(state, raised_ns=again)], 2.0, NS))
            for state in (V, U, N)] == [[('V', 4, 0)], [('U', 5, 0)], [('N', 6, 0)]]


def test_an_alarm_that_was_over_and_came_back_between_two_messages_is_told():
    alerts = make_list()
    alerts.update([report(V)], 1.0, NS)
    assert told(alerts.update([report(V, raised_ns=NS + 5)], 2.0, NS)) == [('V', 2, 0)]


def test_a_caution_is_active_or_normal_and_cannot_be_acknowledged():
    alerts = make_list()
    states = [told(alerts.update([report(state, priority=Priority.CAUTION)], 1.0, NS))
              for state in (V, A, U, N)]
    assert states == [[('A', 1, 0)], [], [('N', 2, 0)], []]
    answer = alerts.take_command(command('A'), 2.0, NS)
    assert answer.acknowledge is None and answer.messages[0][0].startswith('IIARC,')


def test_an_alert_that_the_newest_message_of_its_node_lacks_is_over():
    """A node reports all its alarms, or all that are active: both mean the same here."""
    alerts = make_list()
    alerts.update([report(V), report(V, 'rotated')], 1.0, NS)
    alerts.update([report(V, 'checksum', 'ts_driver')], 1.0, NS)
    messages = alerts.update([report(V, 'rotated')], 2.0, NS + 60 * 10 ** 9)
    assert told(messages) == [('N', 2, 0)] and 'JUMP' in messages[0][0]
    # When it ended is not known: it was over by now.
    assert messages[0][0].split(',')[4] == '221420.00'
    assert alerts.active == 2


def test_alerts_of_one_kind_have_an_identifier_and_instances():
    alerts = make_list()
    bodies = [alerts.update([report(V, 'checksum', node)], 1.0, NS)[0][0]
              for node in ('ts_driver', 'rs_driver')]
    assert [body.split(',')[9:11] for body in bodies] == [['10016', '1'], ['10016', '2']]


def test_identifiers_stay_the_same():
    """A bridge is set up with them: they must not change from version to version."""
    assert [identifier_of(name) for name in ('ts_frozen', 'jump', 'dropped')] == [
        10001, 10005, 10019]
    assert 20000 <= identifier_of('gyro2_wrong') == identifier_of('gyro2_wrong') < 920000


def test_the_list_and_the_heartbeat_come_in_time():
    alerts = AlertList(AlertSettings(list_period_s=30.0, heartbeat_s=60.0))
    sent = {at: [body for message in alerts.due(float(at), NS, is_well=at < 60)
                 for body in message] for at in range(0, 91, 10)}
    assert sent == {**dict.fromkeys(range(0, 91, 10), []),
                    0: ['IIALC,01,01,00,0', 'IIHBT,60.0,A,0'], 30: ['IIALC,01,01,01,0'],
                    60: ['IIALC,01,01,02,0', 'IIHBT,60.0,V,1'], 90: ['IIALC,01,01,03,0']}


def test_the_list_has_what_is_not_normal_with_its_newest_revision():
    alerts = make_list()
    alerts.update([report(V), report(V, 'rotated')], 1.0, NS)
    alerts.update([report(A), report(N, 'rotated')], 2.0, NS)
    assert alerts.due(30.0, NS, is_well=True)[0] == ('IIALC,01,01,01,1,,10005,1,2',)


def test_an_unacknowledged_warning_is_repeated_and_an_acknowledged_one_is_not():
    alerts = make_list(repeat_s=300.0, list_period_s=3600.0, heartbeat_s=999.0)
    alerts.update([report(V)], 1.0, NS)
    assert told(alerts.due(300.0, NS, is_well=True)) == []
    assert told(alerts.due(301.0, NS, is_well=True)) == [('V', 2, 1)]
    assert told(alerts.due(302.0, NS, is_well=True)) == []
    counters = [told(alerts.due(301.0 + 300 * k, NS, is_well=True))[0][2] for k in range(1, 10)]
    assert counters == [2, 3, 4, 5, 6, 7, 8, 9, 1]
    alerts.update([report(A)], 9000.0, NS)
    assert told(alerts.due(99_999.0, NS, is_well=True)) == []


def test_a_warning_is_silent_for_30_s():
    alerts = make_list(list_period_s=3600.0, heartbeat_s=999.0)
    alerts.update([report(V)], 1.0, NS)
    assert told(alerts.take_command(command('S'), 10.0, NS).messages) == [('S', 2, 0)]
    # Again: it is silent for longer, and nothing has changed.
    assert alerts.take_command(command('S'), 20.0, NS).messages == []
    assert told(alerts.update([report(V)], 25.0, NS)) == []
    assert told(alerts.due(49.9, NS, is_well=True)) == []
    assert told(alerts.due(50.0, NS, is_well=True)) == [('V', 3, 0)]
    alerts.take_command(command('S'), 60.0, NS)
    assert told(alerts.update([report(A)], 61.0, NS)) == [('A', 5, 0)]


@pytest.mark.parametrize('state', [V, U])
def test_a_command_acknowledges_what_is_not_acknowledged(state):
    alerts = make_list()
    alerts.update([report(V)], 1.0, NS)
    alerts.update([report(state)], 2.0, NS)
    assert alerts.take_command(command('A'), 3.0, NS) == ([], 'compliance: jump')
    assert alerts.take_command(command('A', instance=None), 3.0, NS).acknowledge
    assert alerts.counts == {'commands_done': 2}


@pytest.mark.parametrize('letter, state', [('A', A), ('A', N), ('S', A), ('S', U), ('O', V),
                                           ('X', V)])
def test_a_command_that_the_state_forbids_is_refused(letter, state):
    alerts = make_list()
    alerts.update([report(V)], 1.0, NS)
    alerts.update([report(state)], 2.0, NS)
    assert alerts.take_command(command(letter), 3.0, NS) == (
        [(f'IIARC,221320.00,,10005,1,{letter}',)], None)


def test_a_command_for_an_alert_that_never_was_is_refused_and_one_for_others_left_alone():
    alerts = make_list(manufacturer='XYZ')
    assert alerts.take_command(command('A', manufacturer='XYZ'), 1.0, NS).messages
    assert alerts.take_command(command('A'), 1.0, NS) == ([], None)
    assert alerts.take_command(command('A', 192, manufacturer='XYZ'), 1.0, NS) == ([], None)
    assert alerts.counts == {'commands_refused': 1, 'commands_of_others': 2}


def test_an_alert_is_told_again_on_request_without_a_new_revision():
    alerts = make_list()
    alerts.update([report(V)], 1.0, NS)
    assert told(alerts.take_command(command('Q'), 2.0, NS).messages) == [('V', 1, 0)]


def test_alerts_without_end_fill_no_memory():
    alerts = make_list()
    for number in range(400):
        alerts.update([report(V, 'jump', f'node{number}')], 1.0, NS)
    assert alerts.active == 250 and alerts.counts['alerts_beyond'] == 150
    alerts.update([report(N, 'jump', 'node7')], 1.0, NS)
    assert told(alerts.update([report(V, 'jump', 'new')], 1.0, NS)) == [('V', 1, 0)]


@pytest.mark.parametrize('settings, words', [
    ({'destination': 'file:x'}, 'destination = '), ({'destination': 'udp://:1'}, 'destination = '),
    ({'commands': 'serial:/dev/ttyS0'}, 'commands = '), ({'talker': 'ii'}, 'two capital letters'),
    ({'system': 'II1'}, 'two letters and four digits'),
    ({'manufacturer': 'ABCD'}, 'three capital letters'),
    ({'push_url': 'ftp://host/secret'}, 'push_url: must be http'),
    ({'push_url': 'http://'}, 'push_url: must be http'),
    ({'push_url': 'http://host:x/'}, 'push_url: must be http')])
def test_a_setting_that_is_wrong_is_named(settings, words):
    with pytest.raises(SettingsError, match=words):
        AlertSettings(**settings)


def test_a_destination_is_required():
    with pytest.raises(SettingsError, match='destination is required'):
        _ = AlertSettings().address
