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

"""The alarms of a graph reach a bridge that checks sentences, and its commands the graph."""

from __future__ import annotations

from itertools import count
import signal
import socket
import subprocess
import sys
import time

from checksums import with_checksum
from deadlines import DEADLINE_S
from diagnostic_msgs.msg import DiagnosticArray
from nodes.launch_files import make_environment
from nodes.lines import free_port, sentence
from nodes.processes import wait_for
from nodes.ros_nodes import NORMS
from office import Office
import pytest
from rclpy.node import Node
from ros_domain import DOMAIN
from std_msgs.msg import String
import yaml

from heading_intercompare.core.alarms.alarm import AlarmState, Priority, Rule, Sign
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.messages.status_messages import encode_statuses, OK, Status
from heading_intercompare.nodes.alarms.alarm_panel import AlarmPanel
from heading_intercompare.nodes.alert_sender import AlertSender
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.presence.health import Health

S_NS = 10 ** 9


class Bridge:
    """Alert management that takes only sentences of the right form, by UDP."""

    def __init__(self, spin):
        self._spin = spin
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(('127.0.0.1', 0))
        self._socket.setblocking(False)
        self.command_port = free_port()
        self.told = []
        self.settings = {
            'destination': f'udp://127.0.0.1:{self._socket.getsockname()[1]}',
            'commands': f'udp://127.0.0.1:{self.command_port}'}

    def _hear(self):
        while True:
            try:
                line = self._socket.recv(2048).decode('ascii')
            except BlockingIOError:
                return
            body = line[1:].partition('*')[0]
            assert line == f'{with_checksum(body)}\r\n' and len(line) <= 82, line
            fields = body.split(',')
            n = {'ALF': 14, 'ARC': 6, 'HBT': 4}.get(fields[0][2:])
            if fields[0] == 'IIALC':
                n = 5 + 4 * int(fields[4])
            assert n == len(fields), line
            self.told.append(fields)

    def wait(self, *start, at=0):
        """Wait for a sentence with these fields from the one `at`; return all its fields."""
        def found():
            self._hear()
            return [fields for fields in self.told
                    if tuple(fields[at:at + len(start)]) == start]
        self._spin(found)
        return found()[-1]

    def states(self, title):
        """Return the states that were told of an alert."""
        return [fields[7] for fields in self.told
                if fields[0] == 'IIALF' and fields[2] == '1' and fields[13] == title]

    def wait_for_state(self, title, state):
        """Wait until this was told of an alert last; return its identifier and instance."""
        self._spin(lambda: self._hear() or self.states(title)[-1:] == [state])
        told = next(fields for fields in reversed(self.told) if fields[-1] == title)
        return told[9:11]

    def command(self, letter, identifier, instance='1'):
        """Send a command."""
        body = f'BMACN,101500.00,,{identifier},{instance},{letter},C'
        self._socket.sendto(f'{with_checksum(body)}\r\n'.encode(),
                            ('127.0.0.1', self.command_port))

    def close(self):
        """Go away."""
        self._socket.close()


@pytest.fixture
def bridge(ros):
    """Return a bridge."""
    made = Bridge(ros.spin_until)
    yield made
    made.close()


@pytest.fixture
def panel(ros):
    """Return the alarms of a node."""
    node = ros.add(Node, 'compliance')
    return AlarmPanel(node, Health(node), (Rule('jump', clear_s=0.0),
                                           Rule('burst', Priority.CAUTION, 0.0)))


def see(panel, at_s, **signs):
    """Show signs to the panel."""
    panel.update({name: Sign(active, f'{name} is here') for name, active in signs.items()},
                 at_s * S_NS)


def test_an_alert_is_told_acknowledged_by_the_bridge_and_over(ros, bridge, panel):
    sender = ros.ours(AlertSender, **bridge.settings)
    bridge.wait('IIHBT', '30.0', 'A')
    see(panel, 3600, jump=True)
    identifier, instance = bridge.wait_for_state('JUMP', 'V')
    assert (identifier, instance) == ('10005', '1')
    assert bridge.wait('compliance: jump is here', at=13)[:3] == ['IIALF', '2', '2']
    assert bridge.wait('JUMP', at=13)[4:7] == ['010000.00', 'B', 'W']
    actions = ros.listen(String, 'operator/action', qos.ACTION)
    bridge.command('A', identifier)
    bridge.wait_for_state('JUMP', 'A')
    assert panel['jump'].state is AlarmState.ACKNOWLEDGED
    ros.spin_until(lambda: actions)
    assert actions[0].data.endswith(
        'alarm acknowledged: jump [by bridge alert management]')
    see(panel, 3700, jump=False)
    bridge.wait_for_state('JUMP', 'N')
    assert bridge.states('JUMP') == ['V', 'A', 'N']
    ros.end(sender)


@pytest.mark.parametrize('is_copy', [False, True])
def test_an_alert_is_not_ended_by_a_message_of_somebody_else(ros, bridge, panel, is_copy):
    ros.ours(AlertSender, **bridge.settings)
    see(panel, 3600, jump=True)
    bridge.wait_for_state('JUMP', 'V')
    forger = ros.add(Node, 'forger').create_publisher(
        DiagnosticArray, 'compliance/alarms', qos.STATE)
    ros.spin_until(forger.get_subscription_count)
    forger.publish(encode_statuses(0, [Status('compliance: jump', OK, 'no alarm', {
        'state': 'normal', 'priority': 'warning'})], panel._health.owner * is_copy))
    end_s = time.monotonic() + 1.0
    ros.spin_until(lambda: time.monotonic() > end_s)
    see(panel, 3700, burst=True)
    bridge.wait_for_state('BURST', 'A')
    assert bridge.states('JUMP') == ['V']


def test_a_command_that_cannot_be_done_is_refused(ros, bridge, panel):
    ros.ours(AlertSender, **bridge.settings)
    see(panel, 1, burst=True)
    identifier, _ = bridge.wait_for_state('BURST', 'A')
    bridge.command('A', identifier)
    assert bridge.wait('IIARC')[3:] == [identifier, '1', 'A']
    assert panel['burst'].state is AlarmState.UNACKNOWLEDGED
    bridge.command('O', identifier)
    bridge.wait('O', at=5)
    bridge.command('Q', identifier)
    ros.spin_until(lambda: bridge._hear() or bridge.states('BURST') == ['A', 'A'])


def test_a_sender_that_starts_late_tells_how_the_alerts_stand_and_not_how_they_came(
        ros, bridge, panel):
    for at_s in range(10, 50, 10):
        see(panel, at_s, jump=True)
        see(panel, at_s + 5, jump=False)
        panel.acknowledge()
    see(panel, 100, jump=True)
    ros.ours(AlertSender, **bridge.settings, list_period_s=1.0)
    bridge.wait('IIALC', '01', '01')
    bridge.wait('1', '', '10005', '1', '1', at=4)
    assert bridge.states('JUMP') == ['V']


def test_without_a_graph_the_heartbeat_is_not_well_and_commands_are_refused(ros, bridge):
    ros.ours(AlertSender, **bridge.settings)
    bridge.wait('IIHBT', '30.0', 'V')
    bridge.command('A', '10005')
    bridge.wait('IIARC')


def test_a_line_that_cannot_send_is_named_and_ends_nothing(ros, panel):
    with socket.create_server(('127.0.0.1', 0)) as server:
        place = f'tcp://127.0.0.1:{server.getsockname()[1]}'
        sender = ros.ours(AlertSender, destination=place)
        ros.spin_until(lambda: 'line' in sender.health._parts)
        see(panel, 1, jump=True)
        with server.accept()[0] as bridge:
            ros.spin_until(lambda: sender.health._parts['line'].message == 'sentences are sent')
            assert bridge.recv(4096).startswith(b'$II')
    ros.end(sender)
    assert sender.ended


def test_changes_are_posted_also_without_a_bridge(ros, panel):
    pytest.importorskip('httpx')
    office = Office(200)
    sender = ros.ours(AlertSender, push_url=office.url)
    see(panel, 1, jump=True)
    ros.spin_until(lambda: office.posted)
    assert office.posted[0]['alert'] == 'compliance: jump'
    ros.spin_until(lambda: 'push' in sender.health._parts
                   and sender.health._parts['push'].values.get('sent') == 1)
    ros.end(sender)
    office.close()


@pytest.mark.parametrize('values, words', [
    ({}, 'destination is required'), ({'destination': 'udp://x'}, 'destination = '),
    ({'destination': 'serial:no/such/device'}, 'no/such/device')])
def test_a_mistake_is_one_line(ros, values, words):
    with pytest.raises((SettingsError, OSError), match=words):
        ros.ours(AlertSender, **values)


@pytest.mark.process
def test_a_sensor_of_live_that_falls_silent_is_an_alert_on_the_bridge(tmp_path):
    """The whole way: sentences in, alarm, sentences out, acknowledged by the bridge."""
    ports = {role: free_port() for role in ('ts', 'rs')}
    bridge = Bridge(wait_for)
    config = tmp_path / 'my.yaml'
    config.write_text(yaml.dump({
        '/**': {'ros__parameters': NORMS}, 'alert_sender': {'ros__parameters': bridge.settings},
        **{f'{role}_driver': {'ros__parameters': {'source': f'udp://127.0.0.1:{port}'}}
           for role, port in ports.items()}}))
    command = [sys.executable, '-m', 'heading_intercompare', 'live', '--quiet', '--config',
               str(config)]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ship, subprocess.Popen(
            command, env=make_environment(DOMAIN, 'UDPv4'), cwd=tmp_path) as live:
        def sail(*roles):
            for role in roles:
                ship.sendto(sentence('90.0').encode(), ('127.0.0.1', ports[role]))
            bridge._hear()
            return False
        try:
            wait_for(lambda: sail('ts', 'rs') or (tmp_path / 'heading.journal').exists())
            sent = count()
            wait_for(lambda: sail('ts', 'rs') or next(sent) == 100)
            wait_for(lambda: sail('rs') or bridge.states('TS SILENT') == ['V'])
            told = bridge.wait('TS SILENT', at=13)
            bridge.command('A', *told[9:11])
            wait_for(lambda: sail('rs') or bridge.states('TS SILENT') == ['V', 'A'])
            wait_for(lambda: sail('rs', 'ts') or bridge.states('TS SILENT') == ['V', 'A', 'N'])
            live.send_signal(signal.SIGINT)
            assert live.wait(DEADLINE_S) == 0
        finally:
            live.kill()
            bridge.close()
