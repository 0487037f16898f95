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

"""The motion of the ship from its three topics, for a node that judges."""

from __future__ import annotations

from functools import partial
import time
from typing import Mapping, Protocol, Sequence

from rclpy.node import Node

from heading_intercompare.bags.rosbag2.motion_topics import motion_topics
from heading_intercompare.core.motion.motion_record import leave_out_known
from heading_intercompare.core.records import Motion
from heading_intercompare.core.settings import MotionRule
from heading_intercompare.messages.motion.motion_messages import read_motion
from heading_intercompare.nodes.interface.message_types import MOTION_TYPES
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.settings import Taking

from .intake import make_intake_beside

# How often to look for publishers of a topic that has none.
_LOOK_S = 0.5


class MotionTaker(Protocol):
    """Takes motion, as a `Compliance` does."""

    def take_motion(self, motion: Motion) -> None:
        """Take motion of the ship."""


class MotionIntake:
    """
    Takes the motion of the ship and hands it on.

    Parameters
    ----------
    node, health
        As for `Intake`.
    taking
        Settings.
    rule
        Names the topics. Without `compare` nothing is taken.
    takers
        Are given, in this order, the rows that have come.
    known_ns
        The newest stamps that an earlier process took, as of `find_newest`.

    """

    def __init__(self, node: Node, health: Health, taking: Taking, rule: MotionRule,
                 takers: Sequence[MotionTaker],
                 known_ns: Mapping[str, int] | None = None) -> None:
        self._intakes = {what: make_intake_beside(node, health, topic, MOTION_TYPES[what], taking)
                         for what, topic in motion_topics(rule).items() if rule.compare}
        self._takers, self._known_ns = takers, dict(known_ns or {})
        self._due_s = 0.0

    def pass_on(self) -> None:
        """Hand on the motion that has come since the last call; before the pairs that came."""
        now_s = time.monotonic()
        look = now_s >= self._due_s
        if look:
            self._due_s = now_s + _LOOK_S
        chunks = [intake.read_rows(partial(_read, what)) for what, intake in self._intakes.items()
                  if look or intake.type_name is not None]
        if any(map(len, chunks)):
            rows = leave_out_known(Motion.concatenate(chunks), self._known_ns)
            for taker in self._takers:
                taker.take_motion(rows)


def _read(what: str, type_name: str, messages: Sequence[bytes]) -> tuple[Motion, list[str]]:
    return read_motion(type_name, what, messages)
