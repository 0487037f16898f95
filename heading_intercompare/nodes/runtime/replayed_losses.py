# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""What a recording lacks, published beside its headings."""

from __future__ import annotations

from typing import Mapping

from rclpy.node import Node

from heading_intercompare.bags.rosbag2.bag_reader import BagMessage, BagReader
from heading_intercompare.bags.rosbag2.sequence_gaps import Numbering
from heading_intercompare.messages.ledger_messages import encode_losses, lost_topic
from heading_intercompare.messages.stamps import header_stamp_ns

from .loss_publisher import LossPublisher

__all__ = ['ReplayedLosses']


class ReplayedLosses:
    """
    Publishes what a recording lacks, beside its headings, so that a replay counts it too.

    Parameters
    ----------
    node : Node
        The node that publishes the headings.
    reader : BagReader
        The bag.
    names : mapping of str to str
        Full name under which a topic of the bag is published.

    Attributes
    ----------
    topics : list of str
        Topics of the bag to replay: the headings, and what the drivers said.

    """

    def __init__(self, node: Node, reader: BagReader, names: Mapping[str, str]) -> None:
        self._publishers = {topic: LossPublisher(node, name) for topic, name in names.items()}
        self._told = {lost: self._publishers[topic] for topic in names
                      if (lost := lost_topic(topic)) in reader.topics}
        self.topics = [*names, *self._told]
        self._keeps_numbers = reader.keeps_numbers()
        self._round = 0
        self._taken: dict[str, list[tuple[int, int]]] = {}
        self._numbering: dict[str, Numbering] = {}

    def take(self, message: BagMessage, round_: int) -> bool:
        """Take the next message of the bag; tell whether it is one of losses, and publish that."""
        if message.topic in self._told:
            self._told[message.topic].publish(message.data)
            return True
        if self._keeps_numbers:
            if round_ != self._round:
                self.publish()
                self._round = round_
                self._numbering = {topic: Numbering() for topic in self._publishers}
            self._taken.setdefault(message.topic, []).append(
                (message.sequence, header_stamp_ns(message.data)))
        return False

    def publish(self) -> None:
        """Publish the gaps among the numbers of the headings taken since the last call."""
        taken, self._taken = self._taken, {}
        for topic, rows in taken.items():
            losses = self._numbering[topic].take(*zip(*rows))
            if len(losses):
                self._publishers[topic].publish(encode_losses({'lost.on_the_way': losses}))
