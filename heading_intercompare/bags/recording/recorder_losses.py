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

"""What a recorder says about its own losses: the metadata record `recording`, and its words."""

from __future__ import annotations

from typing import Mapping, NamedTuple, TYPE_CHECKING

from heading_intercompare.bags.checked_text import decimal
from heading_intercompare.messages.status_messages import ERROR, OK, WARN

if TYPE_CHECKING:
    from .resilient_recording import Recording

__all__ = ['bag_state', 'count_words', 'Counts', 'loss_record', 'loss_words', 'RECORDING',
           'tell_missing']

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
    faults : int
        How often writing stopped.
    absent : int
        Messages in files that somebody removed or moved.
    topics : mapping of str to Counts
        Counts by topic.

    """
    return {'faults': faults, 'absent': absent,
            **{f'{kind}.{topic}': count for topic, counts in topics.items()
               for kind, count in counts._asdict().items()}}


def count_words(count: int, noun: str) -> str:
    """Return a number with its noun."""
    return f'{count} {noun}{"" if count == 1 else "s"}'


def _total(record: Mapping[str, object], kind: str) -> int:
    """Return the sum over all topics; a value that is not a number counts as 0."""
    return sum(decimal(str(value)) or 0 for key, value in record.items()
               if key.partition('.')[0] == kind)


def tell_missing(record: Mapping[str, object]) -> str:
    """Return, in words, the messages received but missing from the bag; '' if none."""
    parts = ((_total(record, 'not_written'), 'received but not written'),
             (_total(record, 'absent'), 'in files that were removed or moved'))
    return ', '.join(f'{count_words(count, "message")} {what}' for count, what in parts if count)


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
