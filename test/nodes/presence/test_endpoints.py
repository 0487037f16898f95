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

"""Nodes that publish and subscribe are counted by their names."""

from __future__ import annotations

from types import SimpleNamespace

from rclpy.node import Node
from std_msgs.msg import String

from heading_intercompare.nodes.presence.endpoints import count_subscribed, is_named, name_node


def test_a_node_with_two_subscriptions_counts_once(ros):
    publisher = ros.plain.create_publisher(String, 'words', 10)
    one, other = ros.add(Node, 'one'), ros.add(Node, 'other')
    for node in (one, one, other):
        node.create_subscription(String, 'words', lambda _: None, 10)
    ros.spin_until(lambda: publisher.get_subscription_count() == 3)
    assert count_subscribed(ros.plain, publisher) == 2
    assert {*map(name_node, ros.plain.get_subscriptions_info_by_topic('/words'))} == {
        '/one', '/other'}


def test_nodes_without_a_name_yet_may_be_several():
    found = [SimpleNamespace(node_namespace='', node_name='_NODE_NAME_UNKNOWN_')] * 2
    node = SimpleNamespace(get_subscriptions_info_by_topic=lambda topic: found)
    publisher = SimpleNamespace(topic_name='/words', get_subscription_count=lambda: 2)
    assert count_subscribed(node, publisher) == 2
    assert not is_named(found[0])
