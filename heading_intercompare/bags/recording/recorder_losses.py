# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""What a recorder says of its own losses: the metadata record `recording`, and words for it."""

from __future__ import annotations

from typing import Mapping, NamedTuple

from heading_intercompare.bags.checked_text import decimal

__all__ = ['count_words', 'Counts', 'loss_record', 'loss_words', 'RECORDING', 'tell_missing']

RECORDING = 'recording'
"""The metadata record, written at the end of a recording."""


class Counts(NamedTuple):
    """Messages of a topic: those that came, and those that are not in the bag."""

    received: int
    lost_on_the_way: int
    not_written: int


def loss_record(faults: int, absent: int, topics: Mapping[str, Counts]) -> dict[str, int]:
    """
    Return the record `RECORDING`.

    Parameters
    ----------
    faults : int
        How often writing stopped.
    absent : int
        Messages in files that somebody took away.
    topics : mapping of str to Counts
        By topic.

    """
    return {'faults': faults, 'absent': absent,
            **{f'{kind}.{topic}': count for topic, counts in topics.items()
               for kind, count in counts._asdict().items()}}


def count_words(count: int, noun: str) -> str:
    """Return a number with its noun."""
    return f'{count} {noun}{"" if count == 1 else "s"}'


def _total(record: Mapping[str, object], kind: str) -> int:
    """Return the sum over all topics; what is no number, in a record of others, is nothing."""
    return sum(decimal(str(value)) or 0 for key, value in record.items()
               if key.partition('.')[0] == kind)


def tell_missing(record: Mapping[str, object]) -> str:
    """Say which messages a recorder received that are not in the bag; '' if none."""
    parts = ((_total(record, 'not_written'), 'received but not written'),
             (_total(record, 'absent'), 'in files that were taken away'))
    return ', '.join(f'{count_words(count, "message")} {what}' for count, what in parts if count)


def loss_words(record: Mapping[str, object]) -> str:
    """Say which messages are not in the bag, those lost before they came among them."""
    on_the_way = _total(record, 'lost_on_the_way')
    said = f'{count_words(on_the_way, "message")} lost on the way' if on_the_way else ''
    return ', '.join(filter(None, (tell_missing(record), said)))
