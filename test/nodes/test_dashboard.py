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

"""The node that serves the live page; the server itself is tested in web."""

from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticArray
from nodes.ros_nodes import NoPage
import numpy as np
import pytest
from rclpy.node import Node
from sensor_msgs.msg import Imu
from std_msgs.msg import String

from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.pairing.ledger import Ledger, LedgerKey, LedgerSegment
from heading_intercompare.core.records import Headings
from heading_intercompare.messages.heading_messages import imu_messages
from heading_intercompare.messages.ledger_messages import encode_ledger
from heading_intercompare.messages.status_messages import encode_statuses, Status, WARN
from heading_intercompare.nodes.compliance import Compliance
from heading_intercompare.nodes.dashboard import Dashboard
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.synchronizer import Synchronizer
from heading_intercompare.web.controls import DELAY_S
from heading_intercompare.web.tokens import VARIABLE

T0_NS = 1_700_000_000_000_000_000


@pytest.fixture(autouse=True)
def no_page(monkeypatch):
    monkeypatch.setattr('heading_intercompare.nodes.dashboard.PageServer', NoPage)


@pytest.fixture
def dashboard(ros):
    return ros.ours(Dashboard, stale_s=30.0)


def see(dashboard):
    """Return what a browser would be shown now."""
    return dashboard.page.controls.look()[0]


def do(ros, dashboard, what, text='', operator='J. Smith'):
    """Act as the page would; return the answer."""
    answer = dashboard.page.controls.act(what, text, operator)
    ros.spin_until(answer.done)
    return answer.result()


@pytest.fixture
def graph(ros, dashboard):
    """Return the graph with 40 s of headings, seen by the dashboard."""
    sensors = [ros.plain.create_publisher(Imu, f'{role}/heading', qos.HEADINGS_OUT)
               for role in ('ts', 'rs')]
    ros.ours(Compliance, name='compliance', risk__min_duration_s=10.0)
    ros.ours(Synchronizer, name='synchronizer', pairing__method='interpolate')
    ros.spin_until(lambda: all(s.get_subscription_count() == 1 for s in sensors))
    stamps = T0_NS + np.arange(400) * 10 ** 8
    for part in (stamps[:200], stamps[200:]):
        for sensor, heading_deg in zip(sensors, (20.5, 20.0)):
            for message in imu_messages(Headings.of(part, np.full(200, heading_deg)), 'x'):
                sensor.publish(message)
        # The dashboard hears headings and pairs once the ledger counts some.
        ros.spin_until(lambda: all(s.get_subscription_count() == 2 for s in sensors)
                       and ros.plain.count_subscribers('pairs') == 2)
    ros.spin_until(lambda: see(dashboard).run.n > 300 and see(dashboard).paired)
    return dashboard


def test_the_page_sees_headings_pairs_figures_nodes_and_no_verdict(ros, graph):
    ros.spin_until(lambda: len(see(graph).nodes) == 3 and see(graph).window.n > 300)
    view = see(graph)
    assert view.ts.heading_deg == pytest.approx(20.5)
    assert view.rs.heading_deg == pytest.approx(20.0)
    assert view.difference_deg == pytest.approx(0.5)
    assert {node.name for node in view.nodes} == {'compliance', 'dashboard', 'synchronizer'}
    assert view.window.mean_deg == pytest.approx(0.5)
    assert view.lamp.word == 'NONE YET' and view.run.number == 1
    assert view.trend.limit_deg > 0.2 and len(view.trend.columns) >= 6
    ros.spin_until(lambda: graph.page.controls.look()[1] < 1.0)


def test_the_page_is_no_subscriber_that_a_log_would_wait_for(ros, dashboard):
    sensor = ros.plain.create_publisher(Imu, 'ts/heading', qos.HEADINGS_OUT)
    ledgers = ros.plain.create_publisher(DiagnosticArray, 'pairs/ledger', qos.LEDGER)
    ros.spin_until(lambda: ledgers.get_subscription_count())
    owner = Health(ros.plain).owner
    ledgers.publish(encode_ledger(Ledger(), owner=owner))
    ros.spin_until(lambda: see(dashboard).paired == 0)
    assert sensor.get_subscription_count() == 0
    ledgers.publish(encode_ledger(Ledger.from_segments(
        [LedgerSegment(None, {LedgerKey.TS_PENDING: 1})], T0_NS), owner=owner))
    ros.spin_until(lambda: sensor.get_subscription_count() == 1)


def do_now(ros, dashboard, what, operator='J. Smith'):
    """Begin or end a run as the page would, without the wait; return the answer."""
    assert f'{what} run waits until ' in do(ros, dashboard, what, operator=operator)
    return do(ros, dashboard, 'now', what, operator='Mate')


def test_a_run_is_stopped_and_started_from_the_page(ros, graph):
    assert do_now(ros, graph, 'stop').startswith('stop after the pair of')
    ros.spin_until(lambda: see(graph).lamp.given_ns is not None and see(graph).run.number == 0)
    assert see(graph).lamp.what == 'end of run 1' and see(graph).lamp.word != 'NONE YET'
    marks = ros.listen(DiagnosticArray, 'compliance/marker', qos.MARKER)
    actions = ros.listen(String, 'operator/action', qos.ACTION)
    assert do_now(ros, graph, 'start', operator='').startswith('start after the pair of')
    ros.spin_until(lambda: len(marks) == 2 and len(actions) == 4)
    hastened = [action.data for action in actions if ' dashboard: did now: ' in action.data]
    assert len(hastened) == 2 and all(text.endswith(' run [by Mate]') for text in hastened)
    of_marks = [action for action in actions if ' compliance: ' in action.data]
    for mark, action, kind, name in zip(marks, of_marks, ('stop', 'start'),
                                        ('J. Smith', 'unknown operator')):
        assert mark.status[0].message == kind
        assert {pair.key: pair.value for pair in mark.status[0].values} == {'operator': name}
        assert f' compliance: {kind} after the pair of ' in action.data
        assert action.data.endswith(f' [by {name}]')


@pytest.fixture
def clock(graph):
    """Return the time of the wait, a list of one number that a test sets."""
    now_s = [100.0]
    graph.page.controls.delay.clock_s = lambda: now_s[0]
    return now_s


def test_a_run_is_started_when_the_minute_is_over_whether_or_not_a_browser_is_there(
        ros, graph, clock):
    marks = ros.listen(DiagnosticArray, 'compliance/marker', qos.MARKER)
    do(ros, graph, 'start')
    clock[0] += DELAY_S - 1e-3
    assert do(ros, graph, 'acknowledge').endswith('alerts acknowledged')
    assert not marks and graph.page.controls.delay.waiting is not None
    clock[0] += 1e-3
    ros.spin_until(lambda: marks)
    assert marks[0].status[0].values[0].value == 'J. Smith'
    delay = graph.page.controls.delay
    ros.spin_until(lambda: delay.outcome.startswith('start run: start after the pair of'))
    assert delay.waiting is None


def test_anybody_can_undo_an_action_that_waits_and_the_bag_says_who_did(ros, graph, clock):
    actions = ros.listen(String, 'operator/action', qos.ACTION)
    marks = ros.listen(DiagnosticArray, 'compliance/marker', qos.MARKER)
    do(ros, graph, 'start')
    assert do(ros, graph, 'stop', operator='Mate').startswith('start run waits already')
    assert 'no longer waits' in do(ros, graph, 'undo', 'stop', operator='Mate')
    assert do(ros, graph, 'undo', 'start', operator='Mate') == 'undid: start run'
    ros.spin_until(lambda: actions)
    assert actions[0].data.endswith(' dashboard: undid: start run [by Mate]')
    clock[0] += 2.0 * DELAY_S
    for what in ('undo', 'now'):
        assert 'no longer waits' in do(ros, graph, what, 'start')
    assert not marks and len(actions) == 1
    assert graph.page.controls.delay.outcome == 'undid: start run [by Mate]'


def test_the_end_of_the_page_says_that_the_waiting_action_was_not_done(ros, graph, clock):
    actions = ros.listen(String, 'operator/action', qos.ACTION)
    do(ros, graph, 'stop')
    graph.drop_action()
    ros.end(graph)
    ros.spin_until(lambda: actions)
    assert [action.data.partition(' dashboard: ')[2] for action in actions] == [
        'not done, because the page ended: stop run [by J. Smith]']


def test_an_action_is_not_done_and_says_so_if_the_compliance_node_is_gone(ros, dashboard):
    actions = ros.listen(String, 'operator/action', qos.ACTION)
    delay = dashboard.page.controls.delay
    now_s = [100.0]
    delay.clock_s = lambda: now_s[0]
    delay.begin('start', 'J. Smith')
    now_s[0] += DELAY_S
    ros.spin_until(lambda: actions)
    assert actions[0].data.endswith(' dashboard: not done, because the compliance node does not '
                                    'answer: start run [by J. Smith]')
    assert delay.outcome == ('start run: the compliance node does not answer: is it running?')


def test_all_alarms_are_acknowledged_by_the_service_of_compliance(ros, graph):
    assert do(ros, graph, 'acknowledge').endswith('alerts acknowledged')


def test_one_alarm_is_acknowledged_by_its_name(ros, dashboard):
    heard = ros.listen(String, 'compliance/acknowledge', qos.ACKNOWLEDGE)
    node = ros.add(Node, 'compliance')
    alarms = node.create_publisher(DiagnosticArray, 'compliance/alarms', qos.STATE)
    alarms.publish(encode_statuses(T0_NS, [Status('compliance: jump', WARN, 'jumped', {
        'state': 'active_unacknowledged', 'priority': 'warning'})], Health(node).owner))
    ros.spin_until(lambda: see(dashboard).alarms)
    ros.spin_until(lambda: dashboard.count_subscribers('compliance/acknowledge'))
    name = see(dashboard).alarms[0].name
    assert do(ros, dashboard, 'acknowledge', name) == f'{name}: acknowledged'
    ros.spin_until(lambda: heard)
    assert heard[0].data == 'compliance: jump [by J. Smith]'


def test_a_note_goes_to_the_recorder_and_without_one_the_page_says_so(ros, dashboard):
    assert do(ros, dashboard, 'note', 'rough sea') == 'no recorder listens: no note kept'
    heard = ros.listen(String, 'operator/note', qos.NOTE)
    ros.spin_until(lambda: dashboard.count_subscribers('operator/note'))
    assert do(ros, dashboard, 'note', 'rough sea') == 'the note was sent to the recorder'
    ros.spin_until(lambda: heard)
    assert heard[0].data == 'rough sea [by J. Smith]'


@pytest.mark.parametrize('what', ['start', 'stop', 'acknowledge'])
def test_without_the_compliance_node_an_action_says_so(ros, dashboard, what):
    assert do(ros, dashboard, what) == 'the compliance node does not answer: is it running?'


def test_the_address_is_printed_and_a_token_only_if_it_was_made(ros, capfd, monkeypatch):
    monkeypatch.setenv(VARIABLE, 'choose-your-own')
    ros.ours(Dashboard)
    assert capfd.readouterr().out == 'page: http://127.0.0.1:1/\n'
    monkeypatch.setattr(NoPage, 'token_made', 'made-here')
    ros.ours(Dashboard, name='other', host='0.0.0.0')
    assert capfd.readouterr().out == 'page: http://127.0.0.1:1/ token: made-here\n'


@pytest.mark.parametrize('by_file', [True, False])
def test_no_parameter_holds_a_token(ros, tmp_path, monkeypatch, by_file):
    """Whoever is in the ROS domain can get every parameter."""
    file = tmp_path / 'tokens'
    file.touch(0o600)
    file.write_text('Mate choose-your-own\n')
    if not by_file:
        monkeypatch.setenv(VARIABLE, 'choose-your-own')
    dashboard = ros.ours(Dashboard, **({'token_file': str(file)} if by_file else {}))
    assert [named.token for named in dashboard.page.kwargs['tokens']] == ['choose-your-own']
    parameters = dashboard.get_parameters_by_prefix('')
    assert not [name for name, parameter in parameters.items()
                if 'choose-your-own' in str(parameter.value)]


def test_a_token_as_a_parameter_is_refused_and_not_repeated(ros):
    with pytest.raises(SettingsError, match='^token: this setting was removed: ') as refused:
        ros.ours(Dashboard, token='choose-your-own')
    assert 'choose-your-own' not in str(refused.value)


def test_the_end_closes_the_page(ros, dashboard):
    ros.end(dashboard)
    assert dashboard.page.closed


def test_norms_are_needed_for_the_limits(ros):
    with pytest.raises(SettingsError, match='sigma_max_deg is missing'):
        ros.add(Dashboard)
