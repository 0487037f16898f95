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

"""Other publishers of a topic that one node must publish, as the graph lists them."""

from __future__ import annotations

import time
from typing import Sequence

from rclpy.topic_endpoint_info import TopicEndpointInfo

from .endpoints import name_node

#: A publisher that was killed stays visible for its lease of 20 s.
_LEASE_S = 30.0


class Rivals:
    """
    Says which nodes publish a topic besides the one that must.

    Parameters
    ----------
    topic
        What the topic is called in words.

    Attributes
    ----------
    since_s
        When several publishers were first seen, by a steady clock; None while there is one.
    is_ghost
        All publishers have one name, and the old one may be dead.

    """

    def __init__(self, topic: str) -> None:
        self._topic = topic
        self.since_s: float | None = None
        self.is_ghost = False

    def look(self, infos: Sequence[TopicEndpointInfo]) -> str:
        """Return that there are several publishers in words, given all; '' if there are not."""
        self.is_ghost = False
        if len(infos) < 2:
            self.since_s = None
            return ''
        names, now_s = sorted(str(info.node_name) for info in infos), time.monotonic()
        self.since_s = now_s if self.since_s is None else self.since_s
        self.is_ghost = len({*map(name_node, infos)}) == 1 and now_s - self.since_s <= _LEASE_S
        if self.is_ghost:
            return (f'{len(infos)} publishers on {self._topic}, all {names[0]}: after a restart '
                    'the old one may be dead and disappears within 20 s')
        return f'{len(infos)} publishers on {self._topic} instead of one: {", ".join(names)}'
