# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Messages of one topic, taken in batches, losses counted, publishers watched."""

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
        Who takes them.
    topic : str
        Relative or absolute name.
    types : mapping of str to type
        Message types taken, by name; that of the publisher decides.
    qos : QoSProfile
        Of the subscription.
    health : Health
        Where the state of this input is shown.
    stale_s : float, optional
        Silence after which the state is a warning.
    sole : bool
        More than one publisher is an error.
    needed : bool
        To have no publisher is a warning.

    Attributes
    ----------
    full_name : str
        The topic as the graph knows it.
    type_name : str or None
        Type taken; None while there is no subscription.
    received, last_sequence : int
        Messages taken, number of the newest at its publisher.
    refused : int
        Messages that could not be read.
    publishers : int
        Publishers seen at the last `look`.
    open : bool
        Subscribe when a publisher is seen; what comes before is not taken.

    Notes
    -----
    The subscription is made when a publisher is seen, whose type is taken from then on. It knows
    that publisher before the publisher knows it, so that a publisher which waits for its
    subscription loses no message, not even to a best-effort one.

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
        health.before_beat(self._note)

    def take(self) -> list[tuple[bytes, Mapping[str, int]]]:
        """Return what has come since the last call, each message with its info."""
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
        """Count messages that could not be read, each with what is wrong with it."""
        if problems:
            self.refused += len(problems)
            self._why_refused = problems[-1]

    @property
    def lost(self) -> int:
        """Messages lost on the way, by the numbers of their publishers."""
        return self._numbering.missing

    def look(self) -> str:
        """Look at the publishers, subscribe to their type; return what is wrong, or nothing."""
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
            return (f'{self._topic} has the type {", ".join(strange)}; taken is '
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
        """State how this input is."""
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
