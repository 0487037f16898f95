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

"""A synchronizer opens its inputs once it knows what one before it had taken, or that none was."""

from __future__ import annotations

from types import SimpleNamespace

from diagnostic_msgs.msg import DiagnosticArray
import pytest
from rclpy.node import Node

from heading_intercompare.core.pairing.incarnations import StreamNumbers
from heading_intercompare.core.pairing.ledger import Ledger, LedgerSegment
from heading_intercompare.messages.ledger_messages import encode_ledger
from heading_intercompare.nodes.ros import qos
from heading_intercompare.nodes.ros.health import Health
from heading_intercompare.nodes.taking import predecessor
from heading_intercompare.nodes.taking.predecessor import LEDGER_TAKEN_TOPIC, Predecessor


class Streams(dict):
    """Intakes that note with which number they begin."""

    def __init__(self):
        super().__init__({name: SimpleNamespace(open=False, resume_after=self._note(name))
                          for name in ('ts', 'rs')})
        self.after = {}

    def _note(self, name):
        return lambda publisher, number: self.after.update({name: (publisher, number)})


@pytest.fixture
def found(monkeypatch):
    """Return what a node finds of others, and the clock; both can be set."""
    found = SimpleNamespace(subscribers=['compliance'], publishers=0, now_s=100.0)
    monkeypatch.setattr(predecessor, 'is_alone', lambda: False)
    monkeypatch.setattr(predecessor.time, 'monotonic', lambda: found.now_s)
    return found


def made(ros, found):
    """Return a predecessor that finds what `found` says."""
    node = ros.add(Node, 'synchronizer')
    one = Predecessor(node, Health(node), Streams(), 2, '/pairs')
    one._node = SimpleNamespace(
        count_publishers=lambda topic: found.publishers,
        get_subscriptions_info_by_topic=lambda topic: [
            SimpleNamespace(node_name=name) for name in found.subscribers])
    return one


def test_a_graph_without_compliance_is_known_after_discovery(ros, found):
    one = made(ros, found)
    assert not one.is_known()
    found.now_s += predecessor._FOUND_S
    assert not one.is_known()
    found.now_s += 0.01
    assert one.is_known()


def test_a_subscriber_whose_publishers_are_not_found_yet_is_waited_for(ros, found):
    """Its packet was lost: 2 s later the inputs were opened, and 185 readings never came."""
    one = made(ros, found)
    found.subscribers.append('_NODE_NAME_UNKNOWN_')
    for _ in range(8):
        assert not one.is_known()
        found.now_s += 1.0
    found.subscribers.pop()
    assert not one.is_known()
    found.now_s += predecessor._FOUND_S + 0.01
    assert one.is_known()


def test_a_compliance_node_is_waited_for_until_it_has_spoken(ros, found):
    one = made(ros, found)
    found.publishers = 1
    one.is_known()
    found.now_s += 2 * predecessor._FOUND_S
    assert not one.is_known()


def test_what_the_one_before_had_taken_says_where_to_begin(ros, found):
    one = made(ros, found)
    streams = one._intakes
    publisher = ros.plain.create_publisher(DiagnosticArray, LEDGER_TAKEN_TOPIC, qos.LEDGER_TAKEN)
    # Two TS readings waited for a partner: the synchronizer takes those again.
    ledger = Ledger.from_segments([LedgerSegment(None, {'ts_pending': 2})], 1000)
    publisher.publish(encode_ledger(ledger, False, 1, {
        'ts': StreamNumbers('aa', 1, 'aa', 294), 'rs': StreamNumbers('bb', 1, 'bb', 305)}))
    ros.spin_until(one.is_known)
    assert streams.after == {'ts': ('aa', 292), 'rs': ('bb', 305)}
