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

"""Whether the nodes of a graph are alive, and what they say is wrong with the graph itself."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Mapping

import numpy as np

from .alarm import Priority, Rule, Sign

NOT_RECORDED, NOT_WRITTEN, TWO_PUBLISHERS, MISMATCH, LOST_ON_THE_WAY = (
    'not_recorded', 'not_written', 'two_publishers', 'mismatch', 'lost_on_the_way')

TROUBLE_RULES = (
    Rule(NOT_RECORDED, Priority.CAUTION), Rule(NOT_WRITTEN, Priority.CAUTION),
    Rule(TWO_PUBLISHERS), Rule(MISMATCH), Rule(LOST_ON_THE_WAY, Priority.CAUTION))
"""The alarms for what nodes say is wrong with the graph."""

BEAT_S = 1.0
"""From one heartbeat of a node to the next, seconds."""

WITHIN_S = 5.0
"""A node whose next heartbeat does not come within this time, seconds, is silent."""

ONE_PROCESS_S = 60.0
"""The same where all nodes share a process: none dies alone, and its loops wait for each other."""

# Names of others must not fill the memory.
_MOST = 50
# Intervals between heartbeats from which the load of the computer is known.
_KEPT, _LEAST = 64, 8
# Four times what judging took for each pair of a run of 12 h at 100 Hz.
_JUDGING_S = 1e-5


def estimate_judging_s(n: int) -> float:
    """Return how long a node that judges n pairs may not be heard, seconds."""
    return _JUDGING_S * n


@dataclass(frozen=True, slots=True)
class Beat:
    """
    A heartbeat: what a node says of itself once a second.

    Attributes
    ----------
    name
        The node.
    priority
        Of the alarm when the node falls silent.
    within_s
        Time in which the next one comes, seconds; longer where much has to be judged at once.
    keeper
        This node keeps the alarms of the graph.
    ending
        The node ends in order.
    troubles
        What is wrong, in words, by the name of one of `TROUBLE_RULES`.

    """

    name: str
    priority: Priority = Priority.WARNING
    within_s: float = WITHIN_S
    keeper: bool = False
    ending: bool = False
    troubles: Mapping[str, str] = field(default_factory=dict)


class GraphWatch:
    """
    Watches the heartbeats of a graph.

    Parameters
    ----------
    name
        The node that watches; it is not watched.
    keepers_only
        Watch only the nodes that keep the alarms, and not their troubles.

    Notes
    -----
    A node that was never heard is not missed, nor is one that ended in order. On a busy computer
    all heartbeats are late, so the time allowed grows with the median of their intervals.

    """

    def __init__(self, name: str, *, keepers_only: bool = False) -> None:
        self._name, self._keepers_only = name, keepers_only
        self._beats: dict[str, tuple[Beat, float]] = {}
        self._intervals: deque[float] = deque(maxlen=_KEPT)

    def take(self, beat: Beat, now_s: float) -> Rule | None:
        """Take a heartbeat at a time of a steady clock; return the alarm of a node that is new."""
        if self._keepers_only and not beat.keeper:
            return None
        newcomer = beat.name not in self._beats
        if newcomer and len(self._beats) >= _MOST:
            return None
        if not newcomer:
            former, heard_s = self._beats[beat.name]
            if not former.ending and now_s - heard_s <= former.within_s:
                self._intervals.append(now_s - heard_s)
        self._beats[beat.name] = beat, now_s
        return _silence_rule(beat) if newcomer and beat.name != self._name else None

    @property
    def load(self) -> float:
        """Return how much later than usual heartbeats come, at least 1."""
        if len(self._intervals) < _LEAST:
            return 1.0
        return max(1.0, float(np.median(self._intervals)) / BEAT_S)

    def look(self, now_s: float) -> dict[str, Sign]:
        """Return the signs at a time of a steady clock, seconds."""
        signs, load = {}, self.load
        troubles: dict[str, list[str]] = {rule.name: [] for rule in TROUBLE_RULES}
        for name, (beat, heard_s) in self._beats.items():
            allowed_s = beat.within_s * load
            silent = not beat.ending and now_s - heard_s > allowed_s
            if name != self._name:
                signs[_silence_rule(beat).name] = Sign(
                    silent, f'{name} has not been heard for more than {allowed_s:.3g} s: it '
                    'hangs, was killed or cannot be reached', {'heard_s': now_s - heard_s})
            for kind, words in beat.troubles.items() if not silent and not beat.ending else ():
                troubles[kind].append(f'{name}: {words}')
        if not self._keepers_only:
            signs |= {kind: Sign(bool(words), '; '.join(words))
                      for kind, words in troubles.items()}
        return signs


def _silence_rule(beat: Beat) -> Rule:
    return Rule(f'{beat.name}_silent', beat.priority, clear_s=2.0)
