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

"""What is missing from a recording, and what its recorder says of its own losses."""

from __future__ import annotations

from collections import Counter
from typing import Callable, Mapping, NamedTuple, Sequence, TYPE_CHECKING

from heading_intercompare.bags.errors import decimal
from heading_intercompare.bags.rosbag2.provenance import read_continues
from heading_intercompare.bags.rosbag2.readable import Readable
from heading_intercompare.core.count_words import count_words
from heading_intercompare.core.pairing.ledger import LedgerKey
from heading_intercompare.core.pairing.names import count_unknown, Span
from heading_intercompare.core.records import Losses
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.ledger_messages import (
    decode_ledger,
    decode_losses,
    LedgerMessage,
    lost_topic,
)
from heading_intercompare.messages.status_messages import ERROR, OK, STATUS_TYPE, WARN

if TYPE_CHECKING:
    from .resilient_recording import Recording

BAG_PART, CHAIN_SHA256 = 'bag', 'chain_sha256'
"""The part of a recorder that says the state of its bag, and the figure with the newest hash."""


class PublishedHeadings:
    """
    Says which headings of each sensor the synchronizers took, by publisher and number.

    A recorder that missed the last headings cannot know it from their numbers. The synchronizer
    received them, and each of its ledgers says so. Publishers that go on when the synchronizer has
    ended send headings that nobody judges. A synchronizer that was started again takes headings
    that the one before it had taken: they are the same names, so each counts once.
    """

    def __init__(self) -> None:
        self._newest: dict[int, dict[str, tuple[Span, ...]]] = {}
        self._at_first: dict[str, tuple[Span, ...]] = {}
        self._followed: LedgerMessage | None = None

    def take(self, message: bytes) -> None:
        """Take a message of ``pairs/ledger``; a damaged one says nothing."""
        try:
            newest = decode_ledger(message)
        except MessageError:
            return
        self._newest[newest.started_ns] = spans = {
            stream: numbers.spans for stream, numbers in newest.numbers.items()}
        self._at_first = self._at_first or spans
        if newest.started_ns == max(self._newest):
            self._followed = newest

    def find_span(self, stream: str, publisher: str = '') -> tuple[int | None, int | None]:
        """
        Return the numbers of the first and the last heading that the newest synchronizer took.

        None for the first one before there is one, for the last one before its end. The first one
        is that of a publisher, if the synchronizer has heard it.
        """
        numbers = None if self._followed is None else self._followed.numbers.get(stream)
        if numbers is None or self._followed is None:
            return None, None
        first = next((span.first for span in numbers.spans
                      if publisher and span.publisher == publisher), numbers.first)
        return first or None, numbers.last or None if self._followed.final else None

    def count_missing(self, stream: str, heard: Sequence[Span]) -> tuple[int, int]:
        """
        Return how many headings of ``'ts'`` or ``'rs'`` were taken that a recorder did not hear.

        Parameters
        ----------
        stream
            The sensor.
        heard
            From which number to which one the recorder heard each publisher.

        Returns
        -------
        before, after : int
            Those before the first one heard of their publisher, or of publishers that were gone
            by then; and those after the last one heard.

        """
        judged = [span for spans in self._newest.values() for span in spans.get(stream, ())]
        publishers = {span.publisher for span in heard}
        gone = [span for span in self._at_first.get(stream, ())
                if span.publisher and span.publisher not in publishers]
        earlier = [Span(span.publisher, 1, span.first - 1) for span in heard] + gone
        to_the_last = [Span(span.publisher, 1, span.last) for span in heard]
        return (count_unknown(judged, heard) - count_unknown(judged, [*heard, *earlier]),
                count_unknown(judged, [*to_the_last, *gone]))


class BagLosses:
    """
    Collects the readings that a bag says were sent but that it does not hold.

    Parameters
    ----------
    reader
        The bag.
    sensors
        Names of the sensors, by topic as requested.
    count
        Called with the name of a sensor, the key of the ledger as of a TS, and the losses.
    goes_on
        The bag goes on with another one that is judged with it, which has what was sent before.

    """

    def __init__(self, reader: Readable, sensors: Mapping[str, str],
                 count: Callable[[str, LedgerKey, Losses], None], *,
                 goes_on: bool = False) -> None:
        self._reader, self._sensors, self._count = reader, sensors, count
        self._goes_on = goes_on
        self._by_numbers: Counter[str] = Counter()

    def take(self, topic: str, lost_as: str, losses: Losses) -> None:
        """Take what the numbers of a publisher say is missing of a topic, as one of `LOST_AS`."""
        key = LedgerKey.of_told('ts', lost_as)
        if key.lost == 'before_start' and (self._goes_on or read_continues(self._reader)):
            return
        if key.lost == 'on_the_way':
            self._by_numbers[topic] += int(losses.count.sum())
        self._count(self._sensors[topic], key, losses)

    def read_told(self) -> None:
        """
        Take what the drivers said beside their headings.

        Raises
        ------
        OSError, BagError
            If the bag cannot be read. An unreadable message is an oddity of it.

        """
        problems: list[str] = []
        sensors: dict[str, list[str]] = {}
        for topic, sensor in self._sensors.items():
            name = lost_topic(self._reader.resolve(topic))
            info = self._reader.topics.get(name)
            if info is not None and info.count and info.type_name == STATUS_TYPE:
                sensors.setdefault(name, []).append(sensor)
        for message in self._reader.messages(sensors) if sensors else ():
            try:
                losses_by_cause = decode_losses(message.data)
            except ValueError as error:
                problems.append(f'topic {message.topic}: {error}')
                continue
            for sensor in sensors[message.topic]:
                for lost_as, losses in losses_by_cause.items():
                    self._count(sensor, LedgerKey.of_told('ts', lost_as), losses)

        words = f'{count_words(len(problems), "message")} about losses cannot be read; the first: '
        if problems and words + problems[0] not in self._reader.oddities:
            self._reader.oddities.append(words + problems[0])

    def finish(self, newest_ns: int | None) -> None:
        """Take what the recorder missed after the last messages, given the newest stamp."""
        record = self._reader.metadata().get(RECORDING, {})
        for topic, sensor in self._sensors.items():
            name = self._reader.resolve(topic)
            n_missed = sum(decimal(record.get(f'{kind}.{name}', '')) or 0
                           for kind in ('lost_on_the_way', 'not_written'))
            rest = n_missed - self._by_numbers[topic]
            if rest > 0 and newest_ns is not None:
                # After all readings, so in no run.
                self._count(sensor, LedgerKey.of_lost('ts', 'on_the_way'),
                            Losses.of([newest_ns + 1], [0], [rest]))


RECORDING = 'recording'
"""The metadata record, written at the end of a recording."""


class Counts(NamedTuple):
    """
    Messages of a topic.

    Those received, lost before they arrived, not written, and judged before the first one came.
    """

    received: int
    lost_on_the_way: int
    not_written: int
    missed_at_first: int = 0


def loss_record(faults: int, absent: int, topics: Mapping[str, Counts]) -> dict[str, int]:
    """
    Return the record `RECORDING`.

    Parameters
    ----------
    faults
        How often writing stopped.
    absent
        Messages in files that somebody removed or moved.
    topics
        Counts by topic.

    """
    return {'faults': faults, 'absent': absent,
            **{f'{kind}.{topic}': count for topic, counts in topics.items()
               for kind, count in counts._asdict().items()}}


def _total(record: Mapping[str, object], kind: str) -> int:
    """Return the sum over all topics; a value that is not a number counts as 0."""
    return sum(decimal(str(value)) or 0 for key, value in record.items()
               if key.partition('.')[0] == kind)


def count_missing(record: Mapping[str, object]) -> int:
    """Return the number of messages received but missing from the bag."""
    return _total(record, 'not_written') + _total(record, 'absent')


def tell_missing(record: Mapping[str, object]) -> str:
    """Return, in words, the messages received but missing from the bag; '' if none."""
    parts = ((_total(record, 'not_written'), 'received but not written'),
             (_total(record, 'absent'), 'in files that were removed or moved'))
    return ', '.join(f'{count_words(count, "message")} {what}' for count, what in parts if count)


def tell_judged(record: Mapping[str, object]) -> str:
    """Return, in words, the messages that were judged live and are not in the bag; '' if none."""
    count = _total(record, 'missed_at_first')
    return (f'{count_words(count, "message")} judged live came before the first one of their '
            'publisher that the recorder heard, and count as lost here' if count else '')


def loss_words(record: Mapping[str, object]) -> str:
    """Return, in words, the messages missing from the bag, also messages that never arrived."""
    parts = ((_total(record, 'lost_on_the_way'), 'lost on the way'),
             (_total(record, 'missed_at_first'), 'judged before the first one came'))
    phrases = (f'{count_words(count, "message")} {what}' for count, what in parts if count)
    return ', '.join(filter(None, (tell_missing(record), *phrases)))


def bag_state(bag: Recording, path: str) -> tuple[int, str]:
    """Return the level and the words of the bag that is being recorded at a path."""
    gone = tell_missing({'not_written': sum(bag.lost.values()), 'absent': bag.absent})
    state = (bag.remark if bag.remark else f'recording to {path}' if not bag.faults else
             f'recording again after {count_words(bag.faults, "fault")}')
    level = ERROR if bag.fault else WARN if bag.remark or bag.faults or gone else OK
    return level, bag.fault or (f'{state}; {gone}' if gone else state)
