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

"""What a recording says of the quality of its headings: beside their topics, or within them."""

from __future__ import annotations

from functools import partial
from typing import Iterator

import numpy as np

from heading_intercompare.core.count_words import count_words
from heading_intercompare.core.records import Quality
from heading_intercompare.messages.byte_columns import decode_readable
from heading_intercompare.messages.heading_claims import find_claims
from heading_intercompare.messages.heading_places import HeadingPlace, LOG_TIME
from heading_intercompare.messages.quality_messages import decode_quality, quality_topic
from heading_intercompare.messages.status_messages import STATUS_TYPE

from .bag_reader import BagReader
from .readable import Readable
from .topic_names import locate_in

#: Readings without a claim after which no later one is expected.
_SILENT = 1_000


def find_quality_topic(bag: Readable, heading_topic: str) -> str | None:
    """Return the topic of a recording that says how good headings are; None if none does."""
    name = bag.find(heading_topic)
    topic = '' if name is None else quality_topic(name)
    info = bag.topics.get(topic)
    return None if info is None or info.type_name != STATUS_TYPE else topic


def read_quality(bag: Readable, heading_topic: str, problems: list[str]) -> Quality:
    """
    Read what a sensor says of its readings.

    A topic beside the headings holds all that it says. Without it the covariance of the headings
    is a claim, except in a bag of this program: its live nodes read none, and both verdicts agree.
    If it is no claim in the first messages, the others are not read.

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
    topic = find_quality_topic(bag, heading_topic)
    if topic is None:
        name = bag.find(heading_topic)
        if name is None or not has_claims(bag, heading_topic):
            return Quality.empty()
        return Quality.concatenate([rows.without_repeats() for rows in _decode_claims(
            bag, locate_in(name, heading_topic))]).without_repeats()
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


def has_claims(bag: Readable, heading_topic: str) -> bool:
    """Tell whether the covariance of headings is a claim, by the first messages of a topic."""
    n = 0
    for rows in _decode_claims(bag, locate_in(bag.resolve(heading_topic), heading_topic)):
        if np.isfinite(rows.stated_deg).any():
            return True
        n += len(rows)
        if n >= _SILENT:
            break
    return False


def _decode_claims(bag: Readable, place: HeadingPlace) -> Iterator[Quality]:
    """Yield what the covariances of headings claim, a row of each readable message."""
    claims = find_claims(bag.topics[place.topic].type_name, place.part)
    if claims is None or isinstance(bag, BagReader) and bag.is_ours():
        return
    for messages in bag.payloads(place.topic):
        rows, readable, _ = decode_readable(partial(claims.decode, messages.data),
                                            messages.start, messages.stop)
        if place.clock:
            time_ns = (messages.log_time_ns if place.clock == LOG_TIME
                       else messages.publish_time_ns)
            rows = Quality(time_ns[readable], rows.stated_deg, rows.flag)
        yield rows
