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

"""Which nodes publish a topic or subscribe to it, and the names of topics after remapping."""

from __future__ import annotations

from collections import Counter
from typing import Collection, Sequence

from rclpy.exceptions import InvalidNamespaceException
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.topic_endpoint_info import TopicEndpointInfo
from rclpy.validate_namespace import validate_namespace

from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.nodes.interface.parameters import resolve_topic

# Every node publishes these, with other types.
_TAKEN = ('/diagnostics', '/parameter_events', '/rosout')


def check_namespace(namespace: str) -> None:
    """Raise SettingsError if ROS allows no such namespace."""
    try:
        validate_namespace(namespace)
    except InvalidNamespaceException as error:
        why = str(error).removeprefix('Invalid namespace: ').partition(':')[0]
        raise SettingsError(f'namespace = {namespace!r}: {why}; must be like /ship1') from error


def published_names(node: Node, topics: Sequence[str],
                    remapped: Collection[str] = ()) -> list[str]:
    """
    Return the full names under which topics are published after remapping.

    Parameters
    ----------
    node
        The node that publishes the topics.
    topics
        Names before remapping.
    remapped
        Topics that the user renames.

    Raises
    ------
    SettingsError
        If a name is not a topic name, if two topics would have the same name, or if a topic to
        rename is not one of the topics or is given twice.

    """
    names = [resolve_topic(node, topic) for topic in topics]
    topics_by_name = {name: name for name in _TAKEN}
    for topic, name in zip(topics, names):
        if name in topics_by_name:
            raise SettingsError(f'topic {topic!r} would be published as {name}, which is already '
                                f'the name of {topics_by_name[name]!r}')
        topics_by_name[name] = topic
    renamed = [node.resolve_topic_name(topic, only_expand=True) for topic in remapped]
    published = [node.resolve_topic_name(topic, only_expand=True) for topic in topics]
    for topic, name in zip(remapped, renamed):
        if name not in published:
            raise SettingsError(f'remap {topic!r}: is not replayed; must be one of '
                                f'{", ".join(topics)}')
        if renamed.count(name) > 1:
            raise SettingsError(f'remap {topic!r}: is given {renamed.count(name)} times; must be '
                                'given once')
    return names


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
