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

"""Messages of the nodes of a graph, and those that somebody else sends under their names."""

from __future__ import annotations

from functools import partial
import time

from diagnostic_msgs.msg import DiagnosticArray
import pytest
from rclpy.node import Node

from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.messages.status_messages import (
    decode_statuses,
    encode_statuses,
    ERROR,
    OK,
    Status,
    WARN,
)
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.recorder import Recorder
from heading_intercompare.nodes.taking import own_messages, recorded_messages
from heading_intercompare.nodes.taking.vouchers import owner_of, Vouchers
from heading_intercompare.nodes.watcher import Watcher

T0_NS = 1_700_000_000_000_000_000
ALARM = Status('compliance: jump', WARN, 'jumped', {
    'state': 'active_unacknowledged', 'priority': 'warning'})
OVER = Status('compliance: jump', OK, 'no alarm', {'state': 'normal', 'priority': 'warning'})
VERDICT = 'compliance/verdict'


def of_owner(owner, name='compliance'):
    return [Status(f'{name}: node', OK, '', owner=owner)]


@pytest.mark.parametrize('heard, owner, vouched', [
    ([('/compliance 5', 'compliance', 0.0)], '/compliance 5', True),
    ([('/compliance 5', 'compliance', 0.0)], '/compliance 6', False),
    ([('/compliance 5', 'compliance', 0.0)], '', False),
    ([('/compliance', 'compliance', 0.0)], '/compliance', False),
    ([('/compliance 5', 'other', 0.0)], '/compliance 5', False),
    ([('/ship1/compliance 5', 'ship1/compliance', 0.0)], '/ship1/compliance 5', True),
    # The first one counts until it falls silent.
    ([('/compliance 5', 'compliance', 0.0), ('/compliance 6', 'compliance', 1.0)],
     '/compliance 6', False),
    ([('/compliance 5', 'compliance', 0.0), ('/compliance 6', 'compliance', 4.0)],
     '/compliance 6', True)])
def test_a_node_vouches_for_what_it_sent_since_its_start(heard, owner, vouched):
    vouchers = Vouchers()
    for stated, name, now_s in heard:
        vouchers.hear(of_owner(stated, name), now_s)
    assert vouchers.vouch(owner) is vouched


def test_names_without_end_take_no_memory():
    vouchers = Vouchers()
    for n in range(1000):
        vouchers.hear(of_owner(f'/n{n} 5', f'n{n}'), 0.0)
    assert len(vouchers.nodes) == 100


def test_a_message_of_several_owners_has_none():
    assert owner_of((0, [Status('a', OK, '', owner='/a 1'), Status('b', OK, '')])) == ''


class Judge:
    """A node called compliance with a verdict and alarms, as it publishes them."""

    def __init__(self, ros):
        self.node = ros.add(Node, 'compliance')
        self.health = Health(self.node)
        self.publishers = {topic: self.node.create_publisher(DiagnosticArray, topic, qos.STATE)
                           for topic in (VERDICT, 'compliance/alarms')}

    def say(self, topic, *statuses):
        self.publishers[topic].publish(encode_statuses(T0_NS, statuses, self.health.owner))


def verdict(word):
    return Status('campaign', OK, word, {'outcome': word})


@pytest.fixture
def judge(ros):
    return Judge(ros)


@pytest.fixture
def watcher(ros, judge):
    """Return a watcher that has heard the state of the judge."""
    node = ros.add(Watcher)
    ros.spin_until(lambda: 'compliance' in {seen.name for seen in node.view().nodes})
    return node


def forge(ros, topic, *statuses, owner=''):
    """Publish statuses from a node of nobody, until they must have come; return what ends it."""
    forger = ros.add(Node, 'forger')
    publisher = forger.create_publisher(DiagnosticArray, topic, qos.STATE)
    ros.spin_until(publisher.get_subscription_count)
    publisher.publish(encode_statuses(T0_NS, statuses, owner))
    end_s = time.monotonic() + 0.5
    ros.spin_until(lambda: time.monotonic() > end_s)
    return partial(forger.destroy_publisher, publisher)


def shown_verdict(watcher):
    """Return the words of the verdict that is shown."""
    return [status.message for status in watcher._graph._bridge._verdict.statuses]


def shown_alarms(watcher):
    return [alarm.name for alarm in watcher.view().alarms]


@pytest.mark.parametrize('name_owner', [
    lambda judge: '', lambda judge: '/compliance 5', lambda judge: '/forger 5'])
def test_a_forged_verdict_is_not_shown(ros, judge, watcher, monkeypatch, name_owner):
    monkeypatch.setattr(own_messages, 'HOLD_S', 0.5)
    judge.say(VERDICT, verdict('indeterminate'))
    ros.spin_until(lambda: shown_verdict(watcher) == ['indeterminate'])
    forge(ros, VERDICT, verdict('compliant'), owner=name_owner(judge))
    part = watcher.health._parts
    ros.spin_until(lambda: 'not taken' in part.get(f'{VERDICT} of others', ALARM).message)
    assert part[f'{VERDICT} of others'].level == ERROR
    assert shown_verdict(watcher) == ['indeterminate']


def test_a_copy_under_the_name_of_the_judge_changes_nothing_and_its_end_shows_the_true_one(
        ros, judge, watcher):
    """Nothing tells the two apart, so the value stays, and the trouble is named."""
    judge.say(VERDICT, verdict('indeterminate'))
    ros.spin_until(lambda: shown_verdict(watcher) == ['indeterminate'])
    end = forge(ros, VERDICT, verdict('compliant'), owner=judge.health.owner)
    ros.spin_until(lambda: 'forger' in watcher.health._parts.get(
        f'{VERDICT} of others', ALARM).message)
    assert shown_verdict(watcher) == ['indeterminate']
    judge.say(VERDICT, verdict('non_compliant'))
    end()
    ros.spin_until(lambda: shown_verdict(watcher) == ['non_compliant'])
    ros.spin_until(lambda: watcher.health._parts[f'{VERDICT} of others'].level == OK)


@pytest.mark.parametrize('is_copy', [False, True])
def test_forged_alarms_wipe_none(ros, judge, watcher, is_copy):
    judge.say('compliance/alarms', ALARM)
    ros.spin_until(lambda: shown_alarms(watcher) == ['compliance: jump'])
    end = forge(ros, 'compliance/alarms', OVER, owner=judge.health.owner * is_copy)
    assert shown_alarms(watcher) == ['compliance: jump']
    # The node itself still ends it, at the latest when the other one is gone.
    judge.say('compliance/alarms', OVER)
    end()
    ros.spin_until(lambda: shown_alarms(watcher) == [])


def test_a_verdict_that_comes_before_its_node_has_said_its_state_is_shown_then(ros, judge):
    judge.say(VERDICT, verdict('compliant'))
    watcher = ros.add(Watcher)
    ros.spin_until(lambda: shown_verdict(watcher) == ['compliant'])


def test_the_publisher_itself_says_who_else_publishes(ros, judge):
    """So the alarm of the graph is raised without a page."""
    ros.add(Node, 'forger').create_publisher(DiagnosticArray, VERDICT, qos.STATE)
    ros.spin_until(lambda: 'rivals' in judge.health._parts)
    part = judge.health._parts['rivals']
    assert part.level == ERROR and part.message == (
        f'2 publishers on /{VERDICT} instead of one: compliance, forger')
    assert judge.health._troubles['rivals'] == 'two_publishers'


@pytest.mark.parametrize('topic', ['compliance/alarms', 'operator/note', 'compliance/marker'])
def test_what_several_nodes_publish_is_no_trouble(ros, judge, topic):
    judge.node.create_publisher(DiagnosticArray, topic, qos.STATE)
    ros.add(Node, 'other').create_publisher(DiagnosticArray, topic, qos.STATE)
    end_s = time.monotonic() + 2.5
    ros.spin_until(lambda: time.monotonic() > end_s)
    assert 'rivals' not in judge.health._parts


@pytest.fixture
def recorder(ros, tmp_path):
    return ros.ours(Recorder, output=str(tmp_path / 'bag'), end_wait_s=2.0)


def recorded(recorder, topic):
    """Return the words of the messages in the bag, in their order."""
    return [decode_statuses(message.data)[1][0].message
            for message in BagReader(recorder.path).messages([f'/{topic}'])]


@pytest.mark.parametrize('topic', [VERDICT, 'compliance/alarms'])
def test_the_recorder_keeps_what_a_node_of_the_graph_sent_and_leaves_out_the_rest(
        ros, judge, recorder, monkeypatch, topic):
    monkeypatch.setattr(recorded_messages, 'HOLD_S', 3.0)
    ros.spin_until(judge.publishers[topic].get_subscription_count)
    judge.say(topic, verdict('indeterminate'))
    ros.spin_until(lambda: recorder._topics[topic].intake.received)
    forge(ros, topic, verdict('compliant'))
    ros.spin_until(lambda: 'not taken' in recorder.health._parts.get(
        f'/{topic} of others', ALARM).message)
    judge.say(topic, verdict('non_compliant'))
    ros.spin_until(lambda: recorder._topics[topic].intake.received == 2)
    ros.end(recorder)
    assert recorded(recorder, topic) == ['indeterminate', 'non_compliant']


def test_without_a_node_of_the_graph_the_recorder_keeps_what_comes(ros, recorder):
    forge(ros, VERDICT, verdict('compliant'))
    ros.spin_until(lambda: recorder._topics[VERDICT].intake.received)
    ros.end(recorder)
    assert recorded(recorder, VERDICT) == ['compliant']
