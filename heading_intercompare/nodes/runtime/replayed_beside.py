# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""What a recording holds beside headings, published as it is: the motion of the ship, marks."""

from __future__ import annotations

from rclpy.node import Node
from rclpy.publisher import Publisher

from heading_intercompare.bags.rosbag2.bag_reader import BagMessage, BagReader
from heading_intercompare.bags.rosbag2.motion_topics import find_motion_topics, motion_topics
from heading_intercompare.core.settings import MotionRule
from heading_intercompare.messages.marks import MARKER_TOPIC
from heading_intercompare.nodes.ros import qos
from heading_intercompare.nodes.ros.message_types import MOTION_TYPES

from .health import Health

__all__ = ['publish_marks', 'ReplayedMotion']


def publish_marks(reader: BagReader, publisher: Publisher) -> int:
    """Publish all marks of a recording; return their number."""
    topics = [name for name in reader.topics if name.lstrip('/') == MARKER_TOPIC]
    marks = [message.data for message in reader.messages(topics)] if topics else []
    for mark in marks:
        publisher.publish(mark)
    return len(marks)


class ReplayedMotion:
    """
    Publishes the motion in a recording.

    Parameters
    ----------
    reader : BagReader
        The bag.
    rule : MotionRule
        Names the topics. Without `compare` nothing is published.

    Attributes
    ----------
    topics : list of str
        Names of the topics in the settings, of those that the bag has.
    in_bag : list of str
        Their names in the bag.
    publishers : dict of str to Publisher
        By the names in the bag.

    Raises
    ------
    BagError
        As in `find_motion_topics`.

    """

    def __init__(self, reader: BagReader, rule: MotionRule) -> None:
        found = find_motion_topics(reader, rule) if rule.compare else {}
        self._told = {name: told[0] for name, told in found.items()}
        self.in_bag, named = [*found], motion_topics(rule)
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
        publisher = self.publishers.get(message.topic)
        if publisher is None:
            return False
        publisher.publish(message.data)
        return True
