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

"""What a recording says of the quality of its headings, on topics beside theirs."""

from __future__ import annotations

from heading_intercompare.core.count_words import count_words
from heading_intercompare.core.records import Quality
from heading_intercompare.messages.quality_messages import decode_quality, quality_topic
from heading_intercompare.messages.status_messages import STATUS_TYPE

from .readable import Readable


def read_quality(bag: Readable, heading_topic: str, problems: list[str]) -> Quality:
    """
    Read what a sensor says of its readings.

    Parameters
    ----------
    bag
        The recording.
    heading_topic
        The topic of the headings of the sensor.
    problems
        Gets the number of messages that cannot be read, in words.

    Returns
    -------
    Quality
        Empty if the recording says nothing.

    """
    name = bag.find(heading_topic)
    topic = '' if name is None else quality_topic(name)
    info = bag.topics.get(topic)
    if info is None or info.type_name != STATUS_TYPE:
        return Quality.empty()
    chunks, unreadable = [], 0
    for message in bag.messages([topic]):
        try:
            chunks.append(decode_quality(message.data))
        except ValueError:
            unreadable += 1
    if unreadable:
        problems.append(f'{count_words(unreadable, "message")} about the quality of readings '
                        f'cannot be read (topic {topic})')
    return Quality.concatenate(chunks)
