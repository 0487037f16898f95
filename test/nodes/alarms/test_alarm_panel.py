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

"""The alarms of a node: one message and one line for each change, and their acknowledgement."""

from __future__ import annotations

import time

from diagnostic_msgs.msg import DiagnosticArray
import pytest
from rclpy.node import Node
from std_msgs.msg import String

from heading_intercompare.core.alarms.alarm import Priority, Rule, Sign
from heading_intercompare.messages.status_messages import ERROR, OK, WARN
from heading_intercompare.nodes.alarms.alarm_panel import AlarmPanel
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.presence.health import Health

S_NS = 10 ** 9
RULES = Rule('jump', clear_s=0.0), Rule('burst', Priority.CAUTION, 0.0)


class Shown:
    """A panel, and what others hear of it."""

    def __init__(self, ros):
        self.ros = ros
        node = ros.add(Node, 'watcher')
        self.health = Health(node)
        self.panel = AlarmPanel(node, self.health, RULES)
        # A late subscriber, too, hears how the alarms stand.
        self.heard = ros.listen(DiagnosticArray, 'compliance/alarms', qos.STATE_IN)
        ros.spin_until(lambda: self.heard)

    def see(self, at_s, jump=None, burst=None):
        """Show signs to the panel."""
        self.panel.update({'jump': Sign(jump, 'TS - RS jumped', {'size_deg': 5.0}),
                           'burst': Sign(burst, 'a burst')}, at_s * S_NS)

    def says(self, name, state, level):
        """Wait until the last message says this of an alarm; return its values."""
        def last():
            status = next(s for s in self.heard[-1].status if s.name == f'watcher: {name}')
            return status.level[0], {pair.key: pair.value for pair in status.values}
        self.ros.spin_until(lambda: (last()[0], last()[1]['state']) == (level, state))
        return last()[1]


@pytest.fixture
def shown(ros):
    """Return a panel and what others hear."""
    return Shown(ros)


def test_each_state_has_its_level_and_each_change_one_message(shown):
    shown.says('jump', 'normal', OK)
    shown.see(1, jump=True, burst=True)
    values = shown.says('jump', 'active_unacknowledged', ERROR)
    assert (values['priority'], values['raised_ns'], values['times'], values['size_deg']) == (
        'warning', str(S_NS), '1', '5.0')
    assert shown.says('burst', 'active_unacknowledged', WARN)['priority'] == 'caution'
    assert shown.panel.acknowledge('jump') == 1
    shown.says('jump', 'active_acknowledged', WARN)
    shown.see(3, jump=False, burst=False)
    shown.says('jump', 'normal', OK)
    shown.says('burst', 'rectified_unacknowledged', WARN)
    for at_s in range(4, 20):
        shown.see(at_s, jump=False)
    shown.see(20, burst=True)
    shown.says('burst', 'active_unacknowledged', WARN)
    assert len(shown.heard) == 5


def test_a_late_subscriber_gets_one_message_of_each_node_with_all_its_alarms(ros):
    """Each publisher keeps its newest message alone, and several publish on the topic."""
    panels = {}
    for name in ('first', 'second'):
        node = ros.add(Node, name)
        panels[name] = AlarmPanel(node, Health(node), RULES)
        panels[name].update({'jump': Sign(True, 'TS - RS jumped')}, S_NS)
        panels[name].update({'burst': Sign(True, 'a burst')}, 2 * S_NS)
    heard = ros.listen(DiagnosticArray, 'compliance/alarms', qos.STATE_IN)
    ros.spin_until(lambda: len(heard) >= 2)
    ros.spin_until(lambda: ros.executor.spin_once(0.2) is None)
    assert sorted([(s.name, s.level[0]) for s in message.status] for message in heard) == [
        [(f'{name}: jump', ERROR), (f'{name}: burst', WARN)] for name in panels]
    for message in heard:
        node = message.status[0].name.partition(':')[0]
        assert message.header.stamp.sec == 2
        assert all(s.hardware_id.startswith(f'/{node} ') for s in message.status)


@pytest.mark.parametrize('text, jump, burst', [
    ('jump', True, False), (' watcher: jump\n', True, False), ('all', True, True),
    ('watcher: all', True, True), ('jump [by J. Smith]', True, False),
    ('watcher: all [by Mate: 2/O]', True, True), ('other: jump', False, False),
    ('', False, False)])
def test_a_message_acknowledges_the_alarm_that_it_names(shown, text, jump, burst):
    shown.see(1, jump=True, burst=True)
    publisher = shown.ros.plain.create_publisher(String, 'compliance/acknowledge', qos.ACKNOWLEDGE)
    shown.ros.spin_until(lambda: publisher.get_subscription_count() == 1)
    publisher.publish(String(data=text))
    publisher.publish(String(data='no such alarm'))
    done = {True: 'active_acknowledged', False: 'active_unacknowledged'}

    def states():
        return [str(shown.panel[name].state) for name in ('jump', 'burst')]
    shown.ros.spin_until(lambda: states() == [done[jump], done[burst]])
    over_s = time.monotonic() + 0.3
    shown.ros.spin_until(lambda: time.monotonic() > over_s)
    assert states() == [done[jump], done[burst]]


@pytest.mark.parametrize('text, names, author', [
    ('all [by J. Smith]', ['jump', 'burst'], 'J. Smith'), ('jump', ['jump'], 'unknown operator')])
def test_an_acknowledgement_is_an_action_of_its_operator(shown, text, names, author):
    shown.see(1, jump=True, burst=True)
    heard = shown.ros.listen(String, 'operator/action', qos.ACTION)
    publisher = shown.ros.plain.create_publisher(String, 'compliance/acknowledge', qos.ACKNOWLEDGE)
    shown.ros.spin_until(lambda: publisher.get_subscription_count() == 1)
    # The second one finds nothing to acknowledge, and is no action.
    publisher.publish(String(data=text))
    publisher.publish(String(data=text))
    shown.ros.spin_until(lambda: len(heard) == len(names))
    shown.ros.spin_until(lambda: shown.ros.executor.spin_once(0.2) is None)
    assert [message.data.partition(' ')[2] for message in heard] == [
        f'watcher: alarm acknowledged: {name} [by {author}]' for name in names]


def test_a_change_is_logged_once_or_told_instead(shown, capfd):
    for at_s in range(5):
        shown.see(at_s, jump=True)
    assert capfd.readouterr().err.count('alarm raised: jump: TS - RS jumped') == 1
    told = []
    shown.health.tell = told.append
    shown.see(6, jump=False)
    shown.see(7, jump=False)
    assert told == ['watcher: alarm cleared, not acknowledged: jump: TS - RS jumped']
    assert 'alarm' not in capfd.readouterr().err


def test_a_muted_panel_raises_nothing(shown):
    shown.health.mute()
    shown.see(1, jump=True)
    assert not shown.panel['jump'].state.active


def test_the_health_of_the_node_names_the_alarms_that_stand(ros, shown):
    states = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    shown.see(1, jump=True)
    ros.spin_until(lambda: any(
        (s.name, s.level[0], s.message) == (
            'watcher: alarms', ERROR, 'jump: TS - RS jumped (active, not acknowledged)')
        for m in states for s in m.status))
