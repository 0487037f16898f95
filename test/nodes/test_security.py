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

"""Security: policies that allow what the nodes do and nothing else, a start without keys."""

from __future__ import annotations

from functools import partial
import importlib.util
import os
from pathlib import Path
import subprocess
import sys
from xml.etree import ElementTree

from deadlines import DEADLINE_S
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
from nodes.lines import free_port
from nodes.ros_nodes import NoPage
import pytest
from sensor_msgs.msg import Imu
from std_msgs.msg import String

from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.motion_topics import motion_topics
from heading_intercompare.core.pairing.ledger import Ledger, LedgerKey, LedgerSegment
from heading_intercompare.core.settings import MotionRule
from heading_intercompare.messages.ledger_messages import encode_ledger
from heading_intercompare.messages.motion.motion_messages import PUBLISHED_TYPES
from heading_intercompare.nodes.alert_sender import AlertSender
from heading_intercompare.nodes.compliance import Compliance
from heading_intercompare.nodes.dashboard import Dashboard
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.interface.message_types import MOTION_TYPES
from heading_intercompare.nodes.interface.parameters import make_overrides
from heading_intercompare.nodes.motion_driver import MotionDriver
from heading_intercompare.nodes.nmea_driver import NmeaDriver
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.recorder import Recorder
from heading_intercompare.nodes.replayer import Replayer
from heading_intercompare.nodes.sensor_simulator import SensorSimulator
from heading_intercompare.nodes.synchronizer import Synchronizer
from heading_intercompare.nodes.watcher import Watcher

ROOT = Path(__file__).resolve().parents[2]
POLICY = ElementTree.parse(ROOT / 'security' / 'heading_intercompare.policy.xml').getroot()
NODES = ('ts_driver', 'rs_driver', 'motion_driver', 'synchronizer', 'compliance',
         'recorder', 'dashboard', 'watcher', 'alert_sender')
#: Made by rclpy only with `use_sim_time`; while a node looks for another of its name.
EXEMPT = {'/clock', '/diagnostics'}


def full(name, node):
    """Return the full name of an expression in a policy."""
    return name.replace('~', f'/{node}') if name[0] == '~' else f'/{name.lstrip("/")}'


def allowed(profile):
    """Return the topics published and subscribed, the services and calls of a profile."""
    found = {'publish': set(), 'subscribe': set(), 'reply': set(), 'request': set()}
    for group in profile:
        for what, value in group.attrib.items():
            assert value == 'ALLOW'
            found[what] |= {full(one.text, profile.get('node')) for one in group}
    return found


def profiles(enclave):
    """Return the profiles of an enclave by node."""
    found = POLICY.find(f'enclaves/enclave[@path="/heading_intercompare/{enclave}"]')
    return {one.get('node'): one for one in found.findall('profiles/profile')}


def made(node):
    """Return the topics published and subscribed, the services and calls of a node."""
    name = node.get_name()

    def names(rows):
        return {topic for topic, _ in rows}
    return {'publish': names(node.get_publisher_names_and_types_by_node(name, '/')),
            'subscribe': names(node.get_subscriber_names_and_types_by_node(name, '/')),
            'reply': names(node.get_service_names_and_types_by_node(name, '/')),
            'request': names(node.get_client_names_and_types_by_node(name, '/'))}


def publish_motion(ros):
    """Publish the motion of the ship, so that nodes subscribe to it."""
    for what, topic in motion_topics(MotionRule()).items():
        kind = MOTION_TYPES[what][PUBLISHED_TYPES[what]]
        ros.plain.create_publisher(kind, topic, qos.HEADINGS_OUT)


def check(ros, node):
    """Wait until a node has made all that its policy allows; fail if it makes anything else."""
    policy = allowed(profiles(node.get_name())[node.get_name()])
    ros.spin_until(lambda: all(policy[what] - EXEMPT <= made(node)[what] for what in policy))
    for what, names in made(node).items():
        assert names - policy[what] == set(), what


def test_each_node_of_the_graph_does_what_its_policy_allows_and_nothing_else(
        ros, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for topic, kind, profile in (('truth/heading', Imu, qos.HEADINGS_OUT),
                                 ('operator/note', String, qos.NOTE)):
        ros.plain.create_publisher(kind, topic, profile)
    publish_motion(ros)
    nodes = [ros.ours(Compliance), ros.ours(Recorder, output=str(tmp_path / 'bag')),
             ros.ours(Synchronizer, subscribers=0)]
    nodes += [ros.ours(NmeaDriver, name=f'{role}_driver', source=f'udp://127.0.0.1:{free_port()}',
                       topic=f'{role}/heading') for role in ('ts', 'rs')]
    nodes.append(ros.ours(MotionDriver, source=f'udp://127.0.0.1:{free_port()}'))
    for node in nodes[-3:]:
        for what in motion_topics(MotionRule()):
            node._motion._sender.open(what)
    for node in nodes:
        check(ros, node)


def test_the_simulator_does_what_its_policy_allows_and_nothing_else(ros):
    check(ros, ros.ours(SensorSimulator, subscribers=50))


ROWS = 'a topic=ts/heading sigma_max_deg=1; b sigma_max_deg=1; c sigma_max_deg=1 {}'
TOPICS = {'a': 'ts/heading', 'b': 'b/heading', 'c': 'c/heading'}


@pytest.mark.parametrize('reference', ['c', None])
def test_the_nodes_of_each_sensor_do_what_the_filled_policy_allows_and_nothing_else(
        ros, tmp_path, reference):
    spec = importlib.util.spec_from_file_location(
        'make_keystore', ROOT / 'security' / 'make_keystore.py')
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    text = script.add_sensors(script.POLICY.read_text(), '/', TOPICS, reference)
    found = {(one.get('ns'), one.get('node')): one
             for one in ElementTree.fromstring(text).iter('profile')}
    rows = ROWS.format('rs' if reference else '')
    for topic in ('truth/heading', *TOPICS.values()):
        ros.plain.create_publisher(Imu, topic, qos.HEADINGS_OUT)
        if topic != 'truth/heading':
            ros.plain.create_publisher(DiagnosticArray, f'{topic}/lost', qos.LOST)
    ros.plain.create_publisher(String, 'operator/note', qos.NOTE)
    publish_motion(ros)
    judge = ros.add(partial(Compliance, True), parameter_overrides=make_overrides(
        {'sensors': rows}))
    nodes = [judge, *(ros.add(make, parameter_overrides=make_overrides({'sensors': rows, **more}))
                      for make, more in ((partial(Synchronizer, judge), {'subscribers': 0}),
                                         (Recorder, {'output': str(tmp_path / 'bag')}),
                                         (Watcher, {})))]
    nodes[-1].open()
    # A compliance node apart hears the pairs of its sensor, one that pairs hears none.
    exempt = EXEMPT | {f'/{name}/pairs{end}' for name in 'ab' for end in ('', '/ledger')}

    def place(topic, ns):
        return topic if topic[0] == '/' else f'{ns.rstrip("/")}/{topic}'
    for node in nodes:
        ns = node.get_namespace()
        policy = {what: {place(one.text.replace('~', node.get_name()), ns)
                         for group in found[ns, node.get_name()] if what in group.attrib
                         for one in group} for what in ('publish', 'subscribe', 'reply')}

        def there(node=node):
            return {what: {topic for topic, _ in ask(node.get_name(), node.get_namespace())}
                    for what, ask in (('publish', node.get_publisher_names_and_types_by_node),
                                      ('subscribe', node.get_subscriber_names_and_types_by_node),
                                      ('reply', node.get_service_names_and_types_by_node))}
        unused = exempt if node is judge else EXEMPT
        if node.get_name() == 'synchronizer':
            unused = unused | {'/compliance/marker'}
            if reference is None:
                # It looks after no pairs.
                unused |= {'/compliance/alarms', '/compliance/acknowledge'}
        ros.spin_until(lambda policy=policy, there=there, unused=unused: all(
            policy[what] - unused <= there()[what] for what in policy))
        for what, names in there().items():
            assert names - policy[what] == set(), (ns, node.get_name(), what)


def test_the_dashboard_does_what_its_policy_allows_and_nothing_else(ros, monkeypatch):
    monkeypatch.setattr('heading_intercompare.nodes.dashboard.PageServer', NoPage)
    for role in ('ts', 'rs'):
        ros.plain.create_publisher(Imu, f'{role}/heading', qos.HEADINGS_OUT)
    ros.plain.create_publisher(TwistStamped, 'pairs', qos.PAIRS)
    ledgers = ros.plain.create_publisher(DiagnosticArray, 'pairs/ledger', qos.LEDGER)
    dashboard = ros.ours(Dashboard)
    ros.spin_until(ledgers.get_subscription_count)
    ledgers.publish(encode_ledger(Ledger.from_segments(
        [LedgerSegment(None, {LedgerKey.PAIRED: 1})], 1), owner=Health(ros.plain).owner))
    check(ros, dashboard)


def test_the_sender_of_alerts_does_what_its_policy_allows_and_nothing_else(ros):
    check(ros, ros.ours(AlertSender, destination='udp://127.0.0.1:9'))


def test_the_watcher_does_what_its_policy_allows_also_beside_a_recorder(ros):
    for role in ('ts', 'rs'):
        ros.plain.create_publisher(Imu, f'{role}/heading', qos.HEADINGS_OUT)
    ros.plain.create_publisher(TwistStamped, 'pairs', qos.PAIRS)
    watcher = ros.ours(Watcher)
    watcher.open()
    check(ros, watcher)
    assert allowed(profiles('recorder')['watcher']) == allowed(profiles('watcher')['watcher'])


def test_the_replayer_does_what_its_policy_allows_and_nothing_else(ros, tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.metadata('heading_intercompare', {})
        for topic in ('/ts/heading', '/rs/heading'):
            bag.add_topic(topic, 'sensor_msgs/msg/Imu')
            bag.write(topic, bytes(324), 5)
            bag.add_topic(f'{topic}/quality', 'diagnostic_msgs/msg/DiagnosticArray')
        for what, topic in motion_topics(MotionRule()).items():
            bag.add_topic(topic, PUBLISHED_TYPES[what])
        bag.add_topic('/compliance/marker', 'diagnostic_msgs/msg/DiagnosticArray')
    check(ros, ros.ours(Replayer, bag=str(tmp_path / 'bag'), subscribers=50))


@pytest.mark.parametrize('enclave, names', [
    ('live', NODES), ('intercompare', ('synchronizer', 'compliance'))])
def test_the_enclave_of_several_nodes_is_their_sum(enclave, names):
    together = profiles(enclave)
    assert set(together) == set(names)
    for name in names:
        assert allowed(together[name]) == allowed(profiles(name)[name])


def test_the_policy_has_the_form_of_sros2():
    """As its schema says: these elements, these attributes, in this order."""
    assert (POLICY.tag, POLICY.attrib) == ('policy', {'version': '0.2.0'})
    assert [one.tag for one in POLICY] == ['enclaves']
    for enclave in POLICY[0]:
        assert (enclave.tag, set(enclave.attrib)) == ('enclave', {'path'})
        assert [one.tag for one in enclave] == ['profiles']
        for profile in enclave[0]:
            assert (profile.tag, set(profile.attrib)) == ('profile', {'ns', 'node'})
            for group in profile:
                one, attributes = {'topics': ('topic', {'publish', 'subscribe'}),
                                   'services': ('service', {'reply', 'request'})}[group.tag]
                assert set(group.attrib) <= attributes and len(group)
                assert {each.tag for each in group} == {one}


def test_no_node_but_the_drivers_may_publish_headings():
    """A compromised recorder cannot invent readings."""
    for name in ('synchronizer', 'compliance', 'recorder', 'operator_note', 'dashboard',
                 'watcher', 'alert_sender'):
        may = allowed(profiles(name)[name])
        assert not may['publish'] & {'/ts/heading', '/rs/heading', '/clock'}
    for name in set(NODES) - {'synchronizer'}:
        assert '/pairs' not in allowed(profiles(name)[name])['publish']


@pytest.mark.process
@pytest.mark.parametrize('program', [
    ['-c', 'import sys; from heading_intercompare.nodes.synchronizer import main; '
     'sys.exit(main())'],
    ['-m', 'heading_intercompare', 'live', '--quiet', '--set', 'norms.sigma_max_deg=0.2', '--set',
     'norms.sigma_ref_max_deg=0.1', '-o', 'bag'],
    ['-m', 'heading_intercompare', 'note', 'rough sea']])
@pytest.mark.parametrize('keystore', ['absent', 'unset', 'empty'])
def test_a_start_without_keys_fails_closed_in_one_line(program, keystore, tmp_path):
    environment = {**os.environ, 'ROS_SECURITY_ENABLE': 'true', 'PYTHONPATH': str(ROOT),
                   'ROS_SECURITY_STRATEGY': 'Enforce'}
    environment.pop('ROS_SECURITY_KEYSTORE', None)
    if keystore != 'unset':
        environment['ROS_SECURITY_KEYSTORE'] = str(tmp_path / keystore)
    if keystore == 'empty':
        (tmp_path / 'empty' / 'enclaves').mkdir(parents=True)
    done = subprocess.run([sys.executable, *program], env=environment, cwd=tmp_path, text=True,
                          capture_output=True, timeout=DEADLINE_S, check=False)
    errors = [line for line in done.stderr.splitlines() if 'error: ' in line]
    assert done.returncode == 2 and len(errors) == 1
    assert 'security' in errors[0].lower() and 'Traceback' not in done.stderr
    assert not (tmp_path / 'bag').exists()


@pytest.mark.process
def test_without_ros2_the_script_says_what_to_install(tmp_path):
    done = subprocess.run([sys.executable, ROOT / 'security' / 'make_keystore.py', tmp_path / 'k'],
                          env={**os.environ, 'PATH': str(tmp_path)}, text=True,
                          capture_output=True, timeout=DEADLINE_S, check=False)
    assert done.returncode == 2
    assert done.stderr.count('\n') == 1 and 'ros-jazzy-sros2' in done.stderr


@pytest.mark.process
def test_the_script_fills_in_namespace_and_topics(tmp_path):
    """With a stand-in for ros2 that writes down its arguments."""
    stand_in = tmp_path / 'ros2'
    stand_in.write_text(f'#!/bin/sh\necho "$@" >> {tmp_path}/said\nmkdir -p "$3" || true\n')
    stand_in.chmod(0o755)
    subprocess.run([sys.executable, ROOT / 'security' / 'make_keystore.py', tmp_path / 'k',
                    '--namespace', '/ship1', '--ts', '/gyro/imu'], timeout=DEADLINE_S, check=True,
                   env={**os.environ, 'PATH': f'{tmp_path}:{os.environ["PATH"]}'})
    said = (tmp_path / 'said').read_text().splitlines()
    assert [words.split()[1] for words in said] == ['create_keystore', 'generate_artifacts']
    policy = (tmp_path / 'k' / 'heading_intercompare.policy.xml').read_text()
    assert 'ns="/ship1"' in policy and 'ns="/"' not in policy
    for end in ('lost', 'quality'):
        assert f'<topic>/gyro/imu/{end}</topic>' in policy
    assert '<topic>ts/heading' not in policy
