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

"""What a node says about itself on /diagnostics."""

from __future__ import annotations

import time

from deadlines import Stopwatch
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

from heading_intercompare.messages.status_messages import ERROR, OK, WARN
from heading_intercompare.nodes.interface.qos import STATUS
from heading_intercompare.nodes.presence.health import Health


def health_of(ros):
    """Return the health of a new node and the messages it publishes."""
    heard = ros.listen(DiagnosticArray, '/diagnostics', STATUS)
    health = Health(ros.add(Node, 'ill_node'))
    health.publish()
    ros.spin_until(lambda: heard)
    heard.clear()
    return health, heard


def states(message):
    """Return level and message by name."""
    return {s.name: (s.level[0], s.message) for s in message.status}


def test_a_node_is_heard_once_a_second(ros):
    _, heard = health_of(ros)
    began_s, watch = time.monotonic(), Stopwatch()
    ros.spin_until(lambda: len(heard) >= 2)
    assert time.monotonic() - began_s > 1.0 and watch.passed_s < 9.0
    assert states(heard[0]) == {'ill_node: node': (OK, 'running')}


def test_the_nodes_of_two_graphs_have_two_names(ros):
    """Both were `compliance: node`: a monitor of the ship showed one of them."""
    heard = ros.listen(DiagnosticArray, '/diagnostics', STATUS)
    nodes = [ros.add(Node, 'compliance', namespace=f'/ship{n}') for n in (1, 2)]
    assert [Health(node).name for node in nodes] == ['compliance', 'compliance']
    ros.spin_until(lambda: {s.name for m in heard for s in m.status} == {
        'ship1/compliance: node', 'ship2/compliance: node'})
    assert {s.hardware_id.partition(' ')[0] for m in heard for s in m.status} == {
        '/ship1/compliance', '/ship2/compliance'}


def test_a_worse_state_is_published_at_once_and_a_better_one_with_the_next_beat(ros):
    health, heard = health_of(ros)
    health.note('input', WARN, 'silent', age_s=3.5)
    watch = Stopwatch()
    ros.spin_until(lambda: heard)
    assert watch.passed_s < 0.95
    assert states(heard[0])['ill_node: input'] == (WARN, 'silent')
    assert [(v.key, v.value) for v in heard[0].status[1].values] == [('age_s', '3.5')]
    watch = Stopwatch()
    health.note('input', ERROR, 'wrong type')
    # A beat with the state before it may be on its way.
    ros.spin_until(lambda: states(heard[-1])['ill_node: input'] == (ERROR, 'wrong type'))
    assert watch.passed_s < 0.95
    health.note('input', OK, 'receiving')
    ros.spin_until(lambda: states(heard[-1])['ill_node: input'] == (OK, 'receiving'))


def test_a_latched_state_stays_until_it_is_acknowledged(ros):
    health, heard = health_of(ros)
    health.note('verdict', ERROR, 'non_compliant', latch=True)
    health.note('verdict', OK, 'compliant', latch=True)
    health.publish()
    ros.spin_until(lambda: len(heard) >= 2)
    assert states(heard[-1])['ill_node: verdict'] == (ERROR, 'non_compliant')
    assert health.acknowledge() == 1
    ros.spin_until(lambda: states(heard[-1])['ill_node: verdict'] == (OK, 'compliant'))
    assert health.acknowledge() == 0


def test_a_latched_state_gives_way_to_a_graver_one_only(ros):
    health, heard = health_of(ros)
    for level, message in ((WARN, 'indeterminate'), (ERROR, 'non_compliant'),
                           (WARN, 'indeterminate again')):
        health.note('verdict', level, message, latch=True)
    health.publish()
    ros.spin_until(lambda: heard)
    ros.spin_until(lambda: states(heard[-1])['ill_node: verdict'] == (ERROR, 'non_compliant'))
    assert health.acknowledge() == 1
    ros.spin_until(
        lambda: states(heard[-1])['ill_node: verdict'] == (WARN, 'indeterminate again'))


def test_each_new_kind_of_trouble_is_logged_once_and_counts_that_grow_are_not(ros, capfd):
    health, _ = health_of(ros)
    capfd.readouterr()
    for n in range(1, 200):
        health.note('input', WARN, f'{n} messages lost on the way')
    for n in range(1, 200):
        health.note('input', WARN, f'{n} messages lost on the way; {n} refused: too short')
        health.note('input', WARN, f'{n} refused: too short')
    lines = [line.partition('input: ')[2] for line in capfd.readouterr().err.splitlines()]
    assert lines == ['1 messages lost on the way',
                     '1 messages lost on the way; 1 refused: too short']
    health.note('input', OK, 'receiving')
    health.note('input', WARN, '7 messages lost on the way')
    assert capfd.readouterr().err.count('\n') == 2


def test_kinds_without_end_neither_fill_the_log_nor_the_memory(ros, capfd):
    health, _ = health_of(ros)
    capfd.readouterr()
    for n in range(5000):
        health.note('input', WARN, 'x' * (n % 3000))
    assert capfd.readouterr().err.count('input: ') <= 51
    assert sum(map(len, health._kinds.values())) <= 51


def test_parts_are_refreshed_before_each_beat(ros):
    health, heard = health_of(ros)
    count = iter(range(100))
    health.add_refresher(lambda: health.note('count', OK, str(next(count))))
    ros.spin_until(lambda: heard and 'ill_node: count' in states(heard[-1]))


def test_a_qos_mismatch_of_a_reliable_subscription_is_an_error(ros):
    health, heard = health_of(ros)
    node = ros.nodes[-1]
    node.create_subscription(String, 'words', lambda message: None, STATUS,
                             event_callbacks=health.of_subscription('words'))
    ros.plain.create_publisher(String, 'words', QoSProfile(
        depth=1, reliability=ReliabilityPolicy.BEST_EFFORT))
    ros.spin_until(lambda: any('ill_node: words' in states(m) for m in heard))
    level, words = states(heard[-1])['ill_node: words']
    assert level == ERROR and 'QoS mismatch' in words and 'RELIABILITY' in words
