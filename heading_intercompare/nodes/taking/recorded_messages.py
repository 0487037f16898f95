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

"""The messages that a recorder writes: none that nobody vouches for beside those of the graph."""

from __future__ import annotations

import time
from typing import Sequence

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from heading_intercompare.bags.recording.part_states import DIAGNOSTICS_TOPIC
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.status_messages import decode_statuses, Status
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.presence.health import Health

from .raw_subscription import subscribe
from .reception import Message
from .vouchers import HOLD_S, MOST_HELD, owner_of, say_strange, Strangers, Vouchers


class RecordedMessages:
    """
    Sifts the messages that a recorder writes: of those that nobody vouches for none follows ours.

    Parameters
    ----------
    node
        The node that records.
    health
        Shows whose messages were left out.

    Notes
    -----
    A message waits until its node says its state, or the nodes end. If no node does, it is
    written all the same, unless a node of the graph has published the topic: then it is left out,
    and counted.

    """

    def __init__(self, node: Node, health: Health) -> None:
        self._vouchers, self._health = Vouchers(), health
        self._held: dict[str, list[tuple[float, str, Message]]] = {}
        self._own_topics: set[str] = set()
        self._strangers: dict[str, Strangers] = {}
        subscribe(node, DiagnosticArray, DIAGNOSTICS_TOPIC, qos.HEADINGS_UNRELIABLE, health,
                  decode_statuses, self._hear)
        health.add_refresher(self._look)

    def _hear(self, message: tuple[int, Sequence[Status]]) -> None:
        self._vouchers.hear(message[1], time.monotonic())

    def sift(self, topic: str, messages: Sequence[Message]) -> tuple[list[Message], int]:
        """Return the messages to write now, and how many are left out for good."""
        now_s, may_wait, n_left_out = time.monotonic(), not self._health.ending, 0
        taken: list[Message] = []
        waiting: list[tuple[float, str, Message]] = []
        rows = [*self._held.get(topic, ()),
                *((now_s, _read_owner(message[0]), message) for message in messages)]
        self._own_topics |= {topic} if any(
            self._vouchers.vouch(owner) for _, owner, _ in rows) else set()
        for since_s, owner, message in rows:
            if self._vouchers.vouch(owner):
                taken.append(message)
            elif may_wait and now_s < since_s + HOLD_S and len(waiting) < MOST_HELD:
                waiting.append((since_s, owner, message))
            elif topic not in self._own_topics:
                taken.append(message)
            else:
                n_left_out += 1
                self._strangers.setdefault(topic, Strangers()).add(owner, now_s)
        self._held[topic] = waiting
        return taken, n_left_out

    def _look(self) -> None:
        now_s = time.monotonic()
        for topic, strangers in self._strangers.items():
            say_strange(self._health, topic, [*filter(None, [strangers.describe(topic, now_s)])])


def _read_owner(data: bytes) -> str:
    """Return the node that a message names; '' if it is damaged."""
    try:
        return owner_of(decode_statuses(data))
    except MessageError:
        return ''
