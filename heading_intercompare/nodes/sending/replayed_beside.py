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

"""What a recording holds and lacks beside headings: motion, quality, marks, losses."""

from __future__ import annotations

from typing import Mapping

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rclpy.publisher import Publisher

from heading_intercompare.bags.rosbag2.bag_reader import BagMessage, BagReader
from heading_intercompare.bags.rosbag2.motion_topics import find_motion_topics, motion_topics
from heading_intercompare.bags.rosbag2.provenance import read_continues
from heading_intercompare.bags.rosbag2.publisher_starts import KnownStarts, read_starts
from heading_intercompare.bags.rosbag2.quality_topics import find_quality_topic
from heading_intercompare.bags.rosbag2.sequence_gaps import Numbering
from heading_intercompare.core.settings import MotionRule
from heading_intercompare.messages.ledger_messages import encode_losses, lost_topic
from heading_intercompare.messages.quality_messages import quality_topic
from heading_intercompare.messages.stamps import header_stamp_ns
from heading_intercompare.messages.status_messages import MARKER_TOPIC
from heading_intercompare.messages.transform_messages import TRANSFORMS
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.interface.message_types import MOTION_TYPES
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.sending.loss_publisher import LossPublisher


def publish_marks(reader: BagReader, publisher: Publisher) -> int:
    """Publish all marks of a recording; return their number."""
    topic = reader.find(MARKER_TOPIC)
    marks = [] if topic is None else [message.data for message in reader.messages([topic])]
    for mark in marks:
        publisher.publish(mark)
    return len(marks)


class ReplayedMotion:
    """
    Publishes the motion in a recording.

    Parameters
    ----------
    reader
        The bag.
    rule
        Names the topics. Without `compare` nothing is published.

    Attributes
    ----------
    topics : list of str
        Names of the topics in the settings, of those that the bag has.
    in_bag : list of str
        Their names in the bag.
    publishers
        By the names in the bag.

    Raises
    ------
    BagError
        As in `find_motion_topics`.

    """

    def __init__(self, reader: BagReader, rule: MotionRule) -> None:
        topics = find_motion_topics(reader, rule) if rule.compare else {}
        self._told = {name: contents[0] for name, contents in topics.items()}
        self.in_bag, named = [*topics], motion_topics(rule)
        self.topics = [named[what] for what, _ in self._told.values()]
        self.publishers: dict[str, Publisher] = {}

    def open(self, node: Node, health: Health) -> None:
        """Make the publishers."""
        for topic, (name, (what, kind)) in zip(self.topics, self._told.items()):
            self.publishers[name] = node.create_publisher(
                MOTION_TYPES[what][kind], topic, qos.HEADINGS_OUT,
                event_callbacks=health.of_publisher(topic))

    def take(self, message: BagMessage) -> bool:
        """Tell whether a message of the bag is of the motion, and publish it if so."""
        return _publish(self.publishers, message)


class ReplayedQuality:
    """
    Publishes what the sensors of a recording say of their readings.

    Parameters
    ----------
    node, health
        The node that publishes the headings, and its state.
    reader
        The bag.
    names
        Full name under which a topic of headings of the bag is published.

    Attributes
    ----------
    publishers
        By the names in the bag, of the topics that it has.

    """

    def __init__(self, node: Node, health: Health, reader: BagReader,
                 names: Mapping[str, str]) -> None:
        self.publishers = {in_bag: node.create_publisher(
            DiagnosticArray, quality_topic(name), qos.HEADINGS_OUT,
            event_callbacks=health.of_publisher(quality_topic(name)))
            for topic, name in names.items()
            if (in_bag := find_quality_topic(reader, topic)) is not None}

    def take(self, message: BagMessage) -> bool:
        """Tell whether a message of the bag says this, and publish it if so."""
        return _publish(self.publishers, message)


def _publish(publishers: Mapping[str, Publisher], message: BagMessage) -> bool:
    """Publish a message of the bag if one of the publishers is for its topic; tell whether."""
    publisher = publishers.get(message.topic)
    if publisher is None:
        return False
    publisher.publish(message.data)
    return True


class ReplayedLosses:
    """
    Publishes what a recording lacks, beside its headings, so that a replay counts it too.

    Parameters
    ----------
    node
        The node that publishes the headings.
    reader
        The bag.
    names
        Full name under which a topic of the bag is published.
    whole
        The replay begins with the bag, so what was sent before its first heading counts.

    Attributes
    ----------
    topics : list of str
        Topics of the bag to replay: the headings, and what the drivers said.

    """

    def __init__(self, node: Node, reader: BagReader, names: Mapping[str, str], *,
                 whole: bool) -> None:
        self._publishers = {topic: LossPublisher(node, name) for topic, name in names.items()}
        self._told = {lost: self._publishers[topic] for topic in names
                      if (lost := lost_topic(topic)) in reader.topics}
        self.topics = [*names, *self._told]
        self._keeps_numbers = reader.keeps_numbers()
        starts = read_starts(reader) if self._keeps_numbers else {}
        self._starts = {topic: KnownStarts(starts.get(topic, ())) for topic in names}
        self._round = 0
        self._whole = whole and not read_continues(reader)
        self._taken: dict[str, list[tuple[int, int]]] = {}
        self._numbering: dict[str, Numbering] = {}

    def take(self, message: BagMessage, round_: int) -> bool:
        """Take the next message of the bag; tell whether it is one of losses, and publish that."""
        if message.topic in self._told:
            self._told[message.topic].publish(message.data)
            return True
        if self._keeps_numbers and message.type_name != TRANSFORMS:
            if round_ != self._round:
                self.publish()
                self._round = round_
                self._numbering = {topic: Numbering() for topic in self._publishers}
            self._taken.setdefault(message.topic, []).append(
                (message.sequence, header_stamp_ns(message.data)))
        return False

    def publish(self) -> None:
        """Publish the gaps among the numbers of the headings taken since the last call."""
        headings, self._taken = self._taken, {}
        for topic, rows in headings.items():
            losses = self._starts[topic].find_gaps(self._numbering[topic], *zip(*rows))
            losses_by_cause = {'lost.on_the_way': losses}
            if self._whole and self._round == 1:
                losses_by_cause['lost.before_start'] = self._numbering[topic].take_before()
            if any(map(len, losses_by_cause.values())):
                self._publishers[topic].publish(encode_losses(losses_by_cause))
