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

"""What sensors say of their readings, from topics beside the headings, for a node that judges."""

from __future__ import annotations

from itertools import product
import time
from typing import Protocol, Sequence

from rclpy.node import Node

from heading_intercompare.core.records import Quality
from heading_intercompare.core.settings import Settings
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.quality_messages import decode_quality
from heading_intercompare.nodes.interface.message_types import STATUS_TYPES
from heading_intercompare.nodes.interface.places import quality_topics
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.settings import Taking

from .intake import make_intake_beside

#: How often to look for publishers of a topic that has none.
_LOOK_S = 0.5


class QualityTaker(Protocol):
    """Takes what sensors say, as a `SensorsComparison` does."""

    def take_quality(self, name: str, quality: Quality, /) -> None:
        """Take what a sensor says of its readings."""


class QualityIntake:
    """
    Takes what sensors say of their readings and hands it on.

    Parameters
    ----------
    node, health
        As for `Intake`.
    taking
        How messages are taken.
    settings
        Names the sensors and their topics.
    takers
        Are given, in this order, the rows that have come.

    """

    def __init__(self, node: Node, health: Health, taking: Taking, settings: Settings,
                 takers: Sequence[QualityTaker]) -> None:
        self._intakes = [
            (sensors, make_intake_beside(node, health, topic, STATUS_TYPES, taking))
            for topic, sensors in quality_topics(node, settings).items()]
        self._takers = takers
        self._due_s = 0.0

    def pass_on(self) -> None:
        """Hand on what has come since the last call; before the pairs that came."""
        now_s = time.monotonic()
        look = now_s >= self._due_s
        if look:
            self._due_s = now_s + _LOOK_S
        for sensors, intake in self._intakes:
            if look or intake.type_name is not None:
                quality = intake.read_rows(_read)
                for name, taker in product(sensors, self._takers if len(quality) else ()):
                    taker.take_quality(name, quality)


def _read(_: str, messages: Sequence[bytes]) -> tuple[Quality, list[str]]:
    chunks, problems = [], []
    for data in messages:
        try:
            chunks.append(decode_quality(data))
        except MessageError as error:
            problems.append(str(error))
    return Quality.concatenate(chunks), problems
