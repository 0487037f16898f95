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

"""The last messages in a bag whose recorder was cut off: what the next recorder goes on after."""

from __future__ import annotations

from typing import Mapping, NamedTuple, TYPE_CHECKING

from heading_intercompare.bags.rosbag2.publisher_starts import read_starts

if TYPE_CHECKING:
    # Most nodes read no bag, and need nothing that reads one.
    from heading_intercompare.bags.rosbag2.bag_reader import BagReader

#: More than two publishers of one topic differ in what they have published.
_LAST_NS = 10_000_000_000


class LastMessages(NamedTuple):
    """
    The last messages of a topic, by the numbers and times of their publishers.

    Attributes
    ----------
    names
        Number and time of publication of each of the last ones, in the order of the bag.
    since_ns
        Before this time the bag was not looked at, and nothing is missing; 0 if the bag has none.
    publisher
        Who published the newest one; '' if unknown.

    """

    names: tuple[tuple[int, int], ...] = ()
    since_ns: int = 0
    publisher: str = ''

    def holds(self, number: int, sent_ns: int) -> bool:
        """Tell whether the bag has a message, or one that its publisher sent later."""
        return bool(self.names) and number <= self.names[-1][0] and sent_ns <= self.names[-1][1]


def read_last(reader: BagReader) -> Mapping[str, LastMessages]:
    """
    Return the last messages in a bag, by the full name of their topic.

    Raises
    ------
    OSError, BagError
        If the bag cannot be read.

    """
    since_ns = (reader.end_ns or 0) - _LAST_NS
    names: dict[str, list[tuple[int, int]]] = {
        topic: [] for topic, info in reader.topics.items() if info.count}
    for message in reader.messages(names, since_ns) if names else ():
        if message.sequence:
            names[message.topic].append((message.sequence, message.publish_time_ns))
    publishers = {topic: start.publisher for topic, starts in read_starts(reader).items()
                  for start in starts if start.publisher}
    return {topic: LastMessages(tuple(last), since_ns, publishers.get(topic, ''))
            for topic, last in names.items()}
