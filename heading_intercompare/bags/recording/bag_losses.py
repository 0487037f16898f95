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

"""What is missing from a recording, gap by gap: as numbers, drivers and the recorder tell it."""

from __future__ import annotations

from collections import Counter
from typing import Callable, Mapping

from heading_intercompare.bags.checked_text import decimal
from heading_intercompare.bags.rosbag2.provenance import read_continues
from heading_intercompare.bags.rosbag2.readable import Readable
from heading_intercompare.core.pairing.ledger_keys import LedgerKey
from heading_intercompare.core.records import Losses
from heading_intercompare.messages.ledger_messages import decode_losses, lost_topic
from heading_intercompare.messages.status_messages import STATUS_TYPE

from .recorder_losses import RECORDING

__all__ = ['BagLosses']


class BagLosses:
    """
    Collects the readings that a bag says were sent but that it does not hold.

    Parameters
    ----------
    reader : Readable
        The bag.
    sensors : mapping of str to str
        Names of the sensors, by topic as requested.
    count : callable
        Called with the name of a sensor, the key of the ledger as of a TS, and the losses.
    goes_on : bool
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

        words = f'{len(problems)} messages about losses cannot be read; the first: '
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
