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

"""Which nodes publish a topic, and which have subscribed to it."""

from __future__ import annotations

from collections import Counter

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.topic_endpoint_info import TopicEndpointInfo

# What the middleware calls a node of which it knows subscriptions only, not its publishers.
_UNKNOWN = '_NODE_NAME_UNKNOWN_'


def is_named(info: TopicEndpointInfo) -> bool:
    """Tell whether the node of a publisher or subscription is known."""
    return str(info.node_name) != _UNKNOWN


def name_node(info: TopicEndpointInfo) -> str:
    """Return the full name of the node of a publisher or subscription."""
    return f'{info.node_namespace.rstrip("/")}/{info.node_name}'


def count_subscribed(node: Node, publisher: Publisher) -> int:
    """
    Return how many nodes a publisher reaches.

    A node that replaces its subscription has two for a while. It is one node all the same: where
    two are awaited, the other one may not be there yet.
    """
    counts = Counter(name_node(info) for info in
                     node.get_subscriptions_info_by_topic(publisher.topic_name) if is_named(info))
    n_subscriptions: int = publisher.get_subscription_count()
    return n_subscriptions - sum(n - 1 for n in counts.values())
