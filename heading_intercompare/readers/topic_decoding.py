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

"""The messages of a topic in a recording to headings, where they are read one by one."""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from itertools import islice
from typing import Callable, Iterator, Mapping, NamedTuple, Sequence

import numpy as np

from heading_intercompare.bags.rosbag2.topic_names import locate_in
from heading_intercompare.core.records import Headings, Integers
from heading_intercompare.drivers.sentence_topic import choose_by_name, SentenceTopic
from heading_intercompare.messages.byte_columns import (
    decode_readable,
    FieldColumn,
    join_messages,
)
from heading_intercompare.messages.fields import Definitions
from heading_intercompare.messages.heading_fields import list_candidates
from heading_intercompare.messages.heading_parts import find_part
from heading_intercompare.messages.heading_places import HeadingPlace, LOG_TIME, PUBLISH_TIME
from heading_intercompare.messages.sentence_messages import TOPIC_TYPES
from heading_intercompare.messages.transform_messages import TRANSFORM_TYPES

#: Messages decoded at once.
_MESSAGES = 4_000
#: Fields that a refusal names.
_MOST_NAMED = 5
#: No stamp is later.
_MOST_NS = 2**63


class Logged(NamedTuple):
    """A message as it is stored: log time in ns, number, data, publish time (0: unknown)."""

    log_time_ns: int
    sequence: int
    data: bytes
    publish_time_ns: int = 0


class TopicDecoder:
    """
    Turns the messages of a topic into headings.

    An unreadable message is an invalid reading at its log time, which is all that is known of it.

    Parameters
    ----------
    type_name
        The type of the messages.
    place
        What to take from them.
    convention
        World axes of orientations.
    definitions
        The fields of the type, where the place names one.
    unstamped_clock
        As for `find_part`.

    Attributes
    ----------
    stamp_ns
        Stamps of the messages decoded last; the log time of an unreadable one.

    Raises
    ------
    MessageError
        If the messages have no such field.
    SettingsError
        If there is no such sentence.

    """

    def __init__(self, type_name: str, place: HeadingPlace, convention: str,
                 definitions: Definitions | None = None, unstamped_clock: str = LOG_TIME) -> None:
        self._part = find_part(type_name, definitions or {}, place, convention, unstamped_clock)
        self._sentences = (None if self._part.sentence is None else
                           SentenceTopic(choose_by_name(self._part.sentence)))
        self.stamp_ns: Integers = np.empty(0, np.int64)
        self._unreadable, self._problem = 0, ''
        self._timeless = 0

    def decode(self, messages: Sequence[Logged], *, last: bool = False) -> Headings:
        """Return the headings of messages; `last` says that none follow."""
        headings = self._decode_messages(messages) if messages else Headings.empty()
        return headings + self._sentences.flush() if last and self._sentences else headings

    def _decode_messages(self, messages: Sequence[Logged]) -> Headings:
        data, starts, stops = join_messages([message.data for message in messages])
        column, readable, problem = decode_readable(
            partial(self._part.decode, data), starts, stops)
        self._unreadable += int((~readable).sum())
        self._problem = self._problem or problem
        self.stamp_ns, has_time = self._read_clock(messages)
        column, readable = column[has_time[readable]], readable & has_time
        if self._part.clock or self._part.transforms:
            column = FieldColumn(self.stamp_ns[readable], column.values)
        self.stamp_ns[readable] = column.stamp_ns
        if self._sentences is None and self._part.transforms is None:
            heading_deg = np.full(len(messages), np.nan)
            heading_deg[readable] = column.values
            return Headings(self.stamp_ns, heading_deg)
        return self._take_between(column, readable)

    def _read_clock(self, messages: Sequence[Logged]) -> tuple[Integers, np.ndarray]:
        """Return the times of messages by the clock, log times at first, and which are known."""
        log_time_ns = np.array([message.log_time_ns for message in messages], np.int64)
        if self._part.clock != PUBLISH_TIME:
            return log_time_ns, np.ones(len(messages), bool)
        has_time = np.array([0 < message.publish_time_ns < _MOST_NS for message in messages])
        publish_time_ns = [message.publish_time_ns if is_known else message.log_time_ns
                           for message, is_known in zip(messages, has_time.tolist())]
        self._timeless += int((~has_time).sum())
        return np.array(publish_time_ns, np.int64), has_time

    def _take_between(self, column: FieldColumn, readable: np.ndarray) -> Headings:
        """Return the headings in messages of any number, with the unreadable between them."""
        chunks, at = [], 0
        ends = np.cumsum(readable)
        for row in np.flatnonzero(~readable).tolist():
            until = int(ends[row])
            chunks.append(self._take(column[at:until]))
            chunks.append(Headings(self.stamp_ns[row:row + 1], np.array([np.nan])))
            at = until
        chunks.append(self._take(column[at:]))
        return Headings.concatenate(chunks)

    def _take(self, column: FieldColumn) -> Headings:
        if self._sentences is None:
            return Headings.concatenate(column.values)
        return self._sentences.take(column.stamp_ns, column.values)

    @property
    def unreadable(self) -> tuple[int, str]:
        """Return the number of unreadable messages, and what is wrong with the first one."""
        return self._unreadable, self._problem

    @property
    def absence(self) -> str:
        """Return in words that none of the messages had what was asked for; '' if one had."""
        return self._part.absence

    @property
    def remark(self) -> str:
        """Return which sentence was taken and what was not, or what was assumed, in words."""
        remarks = [self._part.assumption] if self._part.assumption else []
        if self._sentences is not None:
            not_taken = ', '.join(f'{n} {reason}' for reason, n in self._sentences.counts.items()
                                  if n)
            remarks.append(f'headings of {self._sentences.sentence or "no sentence"}; not taken: '
                           f'{not_taken or "nothing"}')
        if self._part.clock:
            remarks.append(self._part.remark_on_stamps)
        if self._timeless:
            remarks.append(f'{self._timeless} messages have no publish time and count as invalid '
                           'readings')
        return '; '.join(remarks)


class TopicKey(NamedTuple):
    """How a topic is read: its name in the recording, what to take from it, and convention."""

    place: HeadingPlace
    convention: str

    @property
    def name(self) -> str:
        """Return the name of the topic in the recording."""
        return self.place.topic


def list_keys(resolve: Callable[[str], str], conventions: Mapping[str, str],
              unit_of: Callable[[str], str]) -> dict[str, TopicKey]:
    """
    Return how each topic is read, by its name as requested.

    Parameters
    ----------
    resolve
        Returns the name in the recording of a topic as requested.
    conventions
        World axes of the orientations, by topic.
    unit_of
        Returns the unit that is stated for the headings of a topic, 'auto' if none.

    """
    return {asked: TopicKey(locate_in(resolve(asked), asked, unit_of(asked)), convention)
            for asked, convention in conventions.items()}


def find_absence(decoders: Mapping[TopicKey, TopicDecoder]) -> str:
    """Return in words that a topic never had what was asked for; '' if all had."""
    return next((f'topic {key.name}: {decoder.absence}' for key, decoder in decoders.items()
                 if decoder.absence), '')


def explain_type(name: str, type_name: str,
                 read_definitions: Callable[[str], Definitions]) -> str:
    """Return in words that the messages of a topic are no headings, and what to name."""
    parts = ['map:base_link']
    if type_name not in TRANSFORM_TYPES:
        definitions: Definitions = {}
        with suppress(ValueError):
            definitions = read_definitions(name)
        parts = list_candidates(type_name, definitions)
    examples = ' or '.join(f'{name}.{part}' for part in parts[:_MOST_NAMED])
    hint = ('name two frames, parent and child, as in' if type_name in TRANSFORM_TYPES else
            'name a field:' if examples else 'of any other type name a field, as in')
    return (f'topic {name} is {type_name or "without a schema"}; a heading is '
            f'{", ".join(TOPIC_TYPES)}; {hint} {examples or f"{name}.heading"}')


def read_topics(messages: Iterator[tuple[str, Logged]], keys: Mapping[str, TopicKey],
                decoders: Mapping[TopicKey, TopicDecoder], oddities: list[str],
                note: Callable[[TopicKey, Sequence[Logged]], None] = lambda key, messages: None,
                ) -> Iterator[dict[str, Headings]]:
    """
    Yield the headings in messages, chunk by chunk, by topic as requested.

    Parameters
    ----------
    messages
        Names of topics and their messages.
    keys
        How each requested topic is read.
    decoders
        What decodes the messages of each; the recording of a topic is decoded once.
    oddities
        Gets, at the end, what could not be read and which sentences were taken.
    note
        Called with the messages that a topic was decoded from.

    """
    waiting: dict[str, list[Logged]] = {key.name: [] for key in decoders}
    more = True
    while more:
        batch = list(islice(messages, _MESSAGES))
        more = len(batch) == _MESSAGES
        for name, message in batch:
            waiting[name].append(message)
        headings = {}
        for key, decoder in decoders.items():
            headings[key] = decoder.decode(waiting[key.name], last=not more)
            note(key, waiting[key.name])
        for logged in waiting.values():
            logged.clear()
        yield {asked: headings[key] for asked, key in keys.items()}
    unreadable = [decoder.unreadable for decoder in decoders.values()]
    if count := sum(n for n, _ in unreadable):
        problem = next(problem for _, problem in unreadable if problem)
        oddities.append(f'{count} messages cannot be read and count as invalid readings; '
                        f'the first: {problem}')
    oddities += [f'{asked}: {decoders[key].remark}' for asked, key in keys.items()
                 if decoders[key].remark]
