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

"""Whose messages are those of the graph: the nodes that say their state vouch for theirs."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Sequence

from heading_intercompare.core.alarms.graph_watch import TWO_PUBLISHERS
from heading_intercompare.core.count_words import count_words
from heading_intercompare.messages.status_messages import ERROR, OK, Status
from heading_intercompare.nodes.presence.health import Health

HOLD_S = 10.0
"""A message waits this long, seconds, for its node to say its state."""

MOST_HELD = 50
"""Messages that wait, at most."""

#: A live node says its state every second; one that is silent for longer may be replaced.
_PATIENCE_S = 3.2
#: How long strange messages are shown.
_SHOWN_S = 10.0
#: Names in messages of others must not fill the memory.
_MOST_NODES = 100


class Vouchers:
    """
    Knows which nodes say their state on /diagnostics, and since when each one runs.

    A message of this package names its owner: the node, and when it was started. An owner is
    vouched for once the node of that name says so itself. Of two with one name the first one
    counts, until it falls silent.
    """

    def __init__(self) -> None:
        self._starts: dict[str, tuple[str, float]] = {}

    @property
    def nodes(self) -> set[str]:
        """Return the full names of the nodes heard so far."""
        return {*self._starts}

    def hear(self, statuses: Sequence[Status], now_s: float) -> None:
        """Take a message of /diagnostics at a time of a steady clock, seconds."""
        for status in statuses:
            name, _, start = status.owner.partition(' ')
            if not start or name != f'/{status.name.partition(": ")[0]}':
                continue
            former, heard_s = self._starts.get(name, (start, now_s))
            if (former == start or now_s > heard_s + _PATIENCE_S) and (
                    name in self._starts or len(self._starts) < _MOST_NODES):
                self._starts[name] = start, now_s

    def vouch(self, owner: str) -> bool:
        """Tell whether the node that a message names said its state."""
        name, _, start = owner.partition(' ')
        return bool(start) and self._starts.get(name, ('', 0.0))[0] == start


def owner_of(message: tuple[int, Sequence[Status]]) -> str:
    """Return the node that all statuses of a message name; '' if they name none, or several."""
    owners = {status.owner for status in message[1]}
    return owners.pop() if len(owners) == 1 else ''


@dataclass(slots=True)
class Strangers:
    """The messages of a topic that no node of the graph has sent: how many, whose, and when."""

    n: int = 0
    owner: str = ''
    last_s: float = -math.inf

    def add(self, owner: str, now_s: float) -> None:
        """Count a message."""
        self.n, self.owner, self.last_s = self.n + 1, owner, now_s

    def describe(self, topic: str, now_s: float) -> str:
        """Return them in words; '' if none came lately."""
        if now_s > self.last_s + _SHOWN_S:
            return ''
        name = self.owner.partition(' ')[0][:40] or 'a node without a name'
        return (f'{count_words(self.n, "message")} on {topic} not taken: {name} says no state on '
                '/diagnostics')


def say_strange(health: Health, topic: str, words: Sequence[str]) -> None:
    """Show what is wrong with the messages of a topic, in words; none if nothing is."""
    health.note(f'{topic} of others', ERROR if words else OK,
                '; '.join(words) or 'no other node publishes it', alarm=TWO_PUBLISHERS)
