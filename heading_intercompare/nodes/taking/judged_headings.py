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

"""The headings that belong to a verdict: from the first to the last one that was judged."""

from __future__ import annotations

from collections import defaultdict
from typing import Mapping, Sequence

from heading_intercompare.bags.rosbag2.publisher_starts import KnownStarts, PublisherStart
from heading_intercompare.bags.rosbag2.sequence_gaps import Numbering
from heading_intercompare.nodes.presence.transports import DISCOVERY_S, is_alone

from .reception import Message, number_of
from .recorded_topics import Recorded

# A synchronizer that starts together with the recorder is found within the first, also where a
# packet was lost. It tells what it took a second after its pairs have their subscribers, for which
# it waits less than the second.
_COMES_S, _BEGINS_S = DISCOVERY_S + 2.0, 15.0
# Nodes of one process find each other at once.
_COMES_ALONE_S = 1.0


class JudgedHeadings:
    """
    Keeps headings until it is known whether the synchronizer took them.

    The sensors of other packages send before a graph begins and after it has ended. What they send
    then is in no verdict, so it is not in the bag, whose verdict is that of the graph. In between
    nothing is kept back.

    Parameters
    ----------
    topics
        All topics of the recorder.
    resumed
        Who published the last headings of a topic in a bag before. What this one sends goes on
        with them, and was judged.

    Attributes
    ----------
    counts : dict of str to (int, Numbering)
        How many headings of a topic are to be recorded, and their numbers: what is missing among
        headings that nobody has judged is no loss of the bag.

    """

    def __init__(self, topics: Mapping[str, Recorded],
                 resumed: Mapping[str, str] | None = None) -> None:
        self._topics = topics
        self._comes_s = _COMES_ALONE_S if is_alone() else _COMES_S
        self._since_s: dict[str, float] = {}
        self._begun = {topic for topic, recorded in topics.items() if not recorded.spans}
        self._resumed = resumed or {}
        self._held: dict[str, list[Message]] = {}
        self._starts: dict[str, KnownStarts] = defaultdict(KnownStarts)
        self.counts = {topic: (0, Numbering.go_on(recorded.intake.numbers.spans[-1:]))
                       for topic, recorded in topics.items() if recorded.is_heading}

    def take(self, topic: str, messages: Sequence[Message], now_s: float,
             ending: bool) -> list[Message]:
        """
        Take the next headings of a topic; messages of a topic without headings pass.

        Parameters
        ----------
        topic
            Name of the topic.
        messages
            The messages in the order in which they came.
        now_s
            Steady time, seconds.
        ending
            The graph ends: headings are kept until `release`.

        Returns
        -------
        list of Message
            What is to be recorded now.

        """
        if not self._topics[topic].is_heading:
            return [*messages]
        return self._count(topic, self._choose(topic, messages, now_s, ending))

    def note_starts(self, topic: str, starts: Sequence[PublisherStart]) -> None:
        """Note which of the next headings are the first ones of their publishers."""
        self._starts[topic].add(starts)

    def _count(self, topic: str, headings: list[Message]) -> list[Message]:
        """Count headings that are to be recorded."""
        if not headings:
            return headings
        n, numbering = self.counts[topic]
        self.counts[topic] = n + len(headings), numbering
        intake = self._topics[topic].intake
        if intake.counted:
            self._starts[topic].find_gaps(
                numbering, [number_of(message) for message in headings],
                intake.read_stamps(headings))
        return headings

    def _choose(self, topic: str, messages: Sequence[Message], now_s: float,
                ending: bool) -> list[Message]:
        held = self._held.setdefault(topic, [])
        held += messages
        if ending or not held:
            return []
        if topic not in self._begun and not self._goes_on(topic):
            first = self._topics[topic].first_judged
            since_s = self._since_s.setdefault(topic, now_s)
            graph = any(recorded.intake.publishers for recorded in self._topics.values()
                        if recorded.is_ledger)
            if first is None and now_s < since_s + (_BEGINS_S if graph else self._comes_s):
                return []
            self._begun.add(topic)
            self._held[topic] = []
            return self._keep(held, first or 0, None)
        self._held[topic] = []
        return held

    def _goes_on(self, topic: str) -> bool:
        """Tell whether the publisher is the last one in a bag before."""
        publisher = self._resumed.get(topic)
        if publisher and self._topics[topic].intake.numbers.last_publisher == publisher:
            self._begun.add(topic)
        return topic in self._begun

    def release(self) -> list[tuple[str, Message]]:
        """Return the headings kept at the end, with their topics, up to the last one judged."""
        headings = []
        for topic, held in self._held.items():
            recorded = self._topics[topic]
            first = 0 if topic in self._begun else recorded.first_judged or 0
            headings += [(topic, message) for message in self._count(
                topic, self._keep(held, first, recorded.last_judged))]
        self._held = {}
        return headings

    @staticmethod
    def _keep(messages: Sequence[Message], first: int, last: int | None) -> list[Message]:
        return [message for message in messages if first <= number_of(message) and (
            last is None or number_of(message) <= last)]

    def may_come(self) -> bool:
        """Tell whether a heading that was judged is still under way."""
        return any(recorded.intake.last_sequence < (recorded.last_judged or 0)
                   for recorded in self._topics.values())
