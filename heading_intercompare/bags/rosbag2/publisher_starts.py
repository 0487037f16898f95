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

"""
Where the publishers of the headings in a bag begin, as its recorder saw them in the graph.

A message does not say who published it, so each change is a metadata record of its own.
"""

from __future__ import annotations

from typing import Callable, Iterable, Mapping, NamedTuple

from heading_intercompare.bags.errors import decimal

from .readable import Readable

_PUBLISHER = 'publisher.'
#: More than this are restarts without an end; those that follow are told by their numbers alone.
_MOST = 1000


class PublisherStart(NamedTuple):
    """
    The first message of a publisher that a subscriber heard.

    Attributes
    ----------
    publisher
        Its identity in the graph; '' if several were listed that could be the one.
    number, stamp_ns
        Number and stamp of that message.

    """

    publisher: str
    number: int
    stamp_ns: int


class PublisherRecords:
    """
    Writes the starts of publishers into a bag, each at once: a recorder may be killed.

    Parameters
    ----------
    metadata
        Writes a metadata record, given its name and a mapping.

    """

    def __init__(self, metadata: Callable[[str, Mapping[str, object]], object]) -> None:
        self._metadata, self._count = metadata, 0

    def add(self, topic: str, starts: Iterable[PublisherStart]) -> None:
        """Write the next starts on a topic."""
        for start in starts:
            self._count += 1
            if self._count <= _MOST:
                self._metadata(f'{_PUBLISHER}{self._count}', {'topic': topic, **start._asdict()})


def read_starts(bag: Readable) -> dict[str, list[PublisherStart]]:
    """Return the starts of publishers in a bag, by the full name of their topic, in order."""
    records = {int(name[len(_PUBLISHER):]): entries for name, entries in bag.metadata().items()
               if name.startswith(_PUBLISHER) and name[len(_PUBLISHER):].isdecimal()}
    starts: dict[str, list[PublisherStart]] = {}
    for _, entries in sorted(records.items()):
        number, stamp_ns = (decimal(entries.get(key, ''), 19) for key in ('number', 'stamp_ns'))
        if number is not None and stamp_ns is not None:
            starts.setdefault(entries.get('topic', ''), []).append(
                PublisherStart(entries.get('publisher', ''), number, stamp_ns))
    return starts


def make_finder(starts: Iterable[PublisherStart]) -> Callable[[int, int], str | None]:
    """Return who begins with the message of a number and a stamp, for `Numbering.take`."""
    by_message = {(start.number % 2**32, start.stamp_ns): start.publisher for start in starts}
    return lambda number, stamp_ns: by_message.get((number, stamp_ns))
