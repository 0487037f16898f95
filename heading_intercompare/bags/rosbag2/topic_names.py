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

"""
Which topic of a recording is meant.

A graph in a namespace publishes `/ship1/ts/heading` under the name `ts/heading` of its settings.
The recorder keeps its namespace in the bag, so the same settings read the bag. For a bag of
another recorder the setting `bag_namespace` names it.
"""

from __future__ import annotations

from typing import Collection, Mapping, Protocol

from heading_intercompare.messages.heading_places import HeadingPlace, locate_headings

from .provenance import NAMESPACE, RECORD

_MOST_NAMED = 20


class _Typed(Protocol):
    """What is known of a topic."""

    @property
    def type_name(self) -> str:
        """Return its message type."""


def clean_namespace(name: str) -> str:
    """Return a namespace with a leading slash and none at its end; '' for the root."""
    return f'/{name.strip().strip("/")}'.rstrip('/')


def read_namespace(metadata: Mapping[str, Mapping[str, str]]) -> str:
    """
    Return the namespace of the graph that a bag is of; '' for the root.

    Parameters
    ----------
    metadata
        The metadata records of the bag, by name.

    """
    return clean_namespace(metadata.get(RECORD, {}).get(NAMESPACE, ''))


def find_topic(present: Collection[str], topic: str, namespace: str = '') -> str | None:
    """
    Return the name that a topic has in a recording; None if it is not there.

    Parameters
    ----------
    present
        The topics of the recording, with or without a leading slash.
    topic
        Its name in the settings: absolute with a leading slash, or within the namespace; what to
        take from its messages may follow (`locate_headings`).
    namespace
        '' or a name with a leading slash.

    Examples
    --------
    >>> find_topic(['/ship1/ts/heading', '/gyro'], 'ts/heading', '/ship1')
    '/ship1/ts/heading'
    >>> find_topic(['/ship1/ts/heading', '/gyro'], 'gyro')
    '/gyro'

    """
    for name in dict.fromkeys((topic, locate_headings(topic).topic)):
        full = name if name.startswith('/') else f'{namespace}/{name}'
        for in_bag in (full, full.removeprefix('/')):
            if in_bag in present:
                return in_bag
    return None


def locate_in(name: str, topic: str, unit: str = 'auto') -> HeadingPlace:
    """
    Return where the headings of a topic are in a recording.

    Parameters
    ----------
    name
        The name that the topic has there, from `find_topic`.
    topic
        Its name in the settings.
    unit
        As for `locate_headings`.

    Examples
    --------
    >>> locate_in('/gps/attitude', 'gps/attitude.heading').part
    'heading'
    >>> locate_in('vessel.heading', 'vessel.heading').part
    ''

    """
    place = locate_headings(topic, unit)
    # Other programs may give names with dots.
    is_whole = f'/{name}'.endswith(f'/{topic.lstrip("/")}')
    return HeadingPlace(name, '') if is_whole else place._replace(topic=name)


def find_elsewhere(present: Collection[str], topic: str, namespace: str = '') -> list[str]:
    """Return the topics that would be meant in other namespaces; see `find_topic`."""
    resolved_name = find_topic(present, topic, namespace)
    return [name for name in sorted(present) if name != resolved_name and not topic.startswith('/')
            and f'/{name}'.endswith(f'/{topic}')]


def list_topics(topics: Mapping[str, _Typed], topic: str, namespace: str = '') -> str:
    """
    Return in words that a recording lacks a topic, and which ones it has.

    Parameters
    ----------
    topics : mapping of str to object with `type_name`
        The topics of the recording.
    topic
        The one that it lacks.
    namespace
        '' or a name with a leading slash.

    """
    # A single word may mean anything, such as the headings of each sensor.
    near = find_elsewhere(topics, topic, namespace) if '/' in topic else []
    ways = [f'{name} (bag_namespace={name.removesuffix(topic).rstrip("/") or "/"})'
            for name in near[:_MOST_NAMED]]
    named = [f'{name} ({info.type_name})' for name, info in sorted(topics.items())]
    more = len(named) - _MOST_NAMED
    present = ', '.join(named[:_MOST_NAMED]) + (f' and {more} more' if more > 0 else '')
    place = f' in {namespace}' if namespace and not topic.startswith('/') else ''
    return (f'has no topic {topic!r}{place}' + (f', but {" or ".join(ways)}' if ways else '')
            + f'; it has {present or "no topics"}')
