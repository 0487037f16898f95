# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The messages of one topic: take them in batches, count losses, watch publishers."""

from __future__ import annotations

import time
from typing import Mapping, Sequence

from rclpy.node import Node
from rclpy.qos import qos_check_compatible, QoSCompatibility, QoSProfile
from rclpy.subscription import Subscription

from heading_intercompare.bags.rosbag2.sequence_gaps import Numbering
from heading_intercompare.messages.status_messages import ERROR, OK, WARN
from heading_intercompare.nodes.ros.batches import take_all, Unwatched
from heading_intercompare.nodes.ros.parameters import resolve_topic

from .health import Health

__all__ = ['Intake']


class Intake:
    """
    The messages of one topic, as bytes.

    Parameters
    ----------
    node : Node
        The node that takes the messages.
    topic : str
        Relative or absolute name.
    types : mapping of str to type
        Accepted message types, by name; the publisher's decides.
    qos : QoSProfile
        Quality of service of the subscription.
    health : Health
        Shows the state of this input.
    stale_s : float, optional
        Silence after which the state is a warning, seconds.
    sole : bool
        More than one publisher is an error.
    needed : bool
        A missing publisher is a warning.

    Attributes
    ----------
    full_name : str
        Full name of the topic in the graph.
    type_name : str or None
        Type of the subscription; None while there is none.
    received, last_sequence : int
        Number of messages taken; number that the publisher gave the newest.
    refused : int
        Messages that could not be read.
    publishers : int
        Publishers seen at the last `look`.
    open : bool
        Subscribe when a publisher is seen. While this is False, no subscription is made.

    Notes
    -----
    The subscription is made when a publisher is seen, with the type of that publisher. So it knows
    the publisher before the publisher knows it. A publisher that waits for its subscription then
    loses no message, even if the subscription is best effort.

    """

    def __init__(self, node: Node, topic: str, types: Mapping[str, type], qos: QoSProfile,
                 health: Health, *, stale_s: float | None = None, sole: bool = True,
                 needed: bool = True) -> None:
        self._node, self._topic, self._types, self._qos = node, topic, types, qos
        self._health, self._stale_s, self._sole, self._needed = health, stale_s, sole, needed
        self.full_name = resolve_topic(node, topic)
        self._subscription: Subscription | None = None
        self._group = Unwatched()
        self._newest_s = time.monotonic()
        self._beat_s, self._beat_n, self._latency_s = self._newest_s, 0, 0.0
        self.type_name: str | None = None
        self.open = True
        self.received = self.last_sequence = self.refused = self.publishers = 0
        self._why_refused = ''
        self._numbering = Numbering()
        health.add_refresher(self._note)

    def take(self) -> list[tuple[bytes, Mapping[str, int]]]:
        """Return the messages since the last call, each with its info."""
        if self._subscription is None:
            self.look()
            if self._subscription is None:
                return []
        taken = take_all(self._subscription)
        if taken:
            numbers = [info['publication_sequence_number'] for _, info in taken]
            self._numbering.take(numbers)
            self.last_sequence = numbers[-1]
            self.received += len(taken)
            info = taken[-1][1]
            self._newest_s = time.monotonic()
            self._latency_s = (info['received_timestamp'] - info['source_timestamp']) / 1e9
        return taken

    def refuse(self, problems: Sequence[str]) -> None:
        """Count messages that could not be read, given what is wrong with each."""
        if problems:
            self.refused += len(problems)
            self._why_refused = problems[-1]

    @property
    def lost(self) -> int:
        """Messages lost on the way, by their publishers' sequence numbers."""
        return self._numbering.missing

    def look(self) -> str:
        """Look for publishers and subscribe to their type; return what is wrong, '' if nothing."""
        self.publishers = self._node.count_publishers(self.full_name)
        if not self.publishers:
            return ''
        infos = self._node.get_publishers_info_by_topic(self.full_name)
        found = {info.topic_type for info in infos}
        good = [name for name in self._types if name in found]
        if self.open and good and self._subscription is None:
            self._subscribe(good[0])
        strange = sorted(found - {self.type_name} - set(() if self.type_name else good))
        if strange:
            return (f'{self._topic} has the type {", ".join(strange)}; must be '
                    f'{self.type_name or " or ".join(self._types)}')
        for info in infos:
            verdict, reason = qos_check_compatible(info.qos_profile, self._qos)
            if verdict == QoSCompatibility.ERROR:
                return f'QoS mismatch on {self._topic} with {info.node_name}: {reason}'
        if self._sole and len(infos) > 1:
            names = ', '.join(sorted(info.node_name for info in infos))
            return f'{len(infos)} publishers on {self._topic} instead of one: {names}'
        return ''

    def _subscribe(self, type_name: str) -> None:
        self._subscription = self._node.create_subscription(
            self._types[type_name], self._topic, lambda message: None, self._qos,
            callback_group=self._group, raw=True)
        self.type_name = type_name

    def _note(self) -> None:
        """Report the state of this input."""
        now_s = time.monotonic()
        wrong, age_s = self.look(), now_s - self._newest_s
        level, words = (ERROR, wrong) if wrong else (OK, 'receiving')
        if not wrong and not self.publishers:
            level, words = WARN if self._needed else OK, f'no publisher on {self._topic}'
        elif not wrong and self._stale_s is not None and age_s > self._stale_s:
            level, words = WARN, f'silent for more than {self._stale_s:g} s'
        elif not wrong and (self.lost or self.refused):
            level, words = WARN, '; '.join(filter(None, [
                self.lost and f'{self.lost} messages lost on the way',
                self.refused and f'{self.refused} messages refused: {self._why_refused}']))
        rate_hz = (self.received - self._beat_n) / max(now_s - self._beat_s, 1e-3)
        self._beat_s, self._beat_n = now_s, self.received
        self._health.note(self._topic, level, words, type=self.type_name,
                          publishers=self.publishers, received=self.received, lost=self.lost,
                          refused=self.refused or None, rate_hz=rate_hz, age_s=age_s,
                          latency_s=self._latency_s)
