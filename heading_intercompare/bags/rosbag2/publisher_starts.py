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

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.bags.errors import decimal
from heading_intercompare.core.records import Losses

from .readable import Readable
from .sequence_gaps import Numbering

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


class KnownStarts:
    """The starts of publishers on a topic, by the first message of each."""

    def __init__(self, starts: Iterable[PublisherStart] = ()) -> None:
        self._publishers: dict[tuple[int, int], str] = {}
        self._stamps = np.empty(0, np.int64)
        self.add(starts)

    def add(self, starts: Iterable[PublisherStart]) -> None:
        """Add further starts."""
        self._publishers |= {(start.number % 2**32, start.stamp_ns): start.publisher
                             for start in starts}
        self._stamps = np.array([stamp_ns for _, stamp_ns in self._publishers], np.int64)

    def find_gaps(self, numbering: Numbering, numbers: ArrayLike, stamp_ns: ArrayLike) -> Losses:
        """Let a numbering take the next numbers and stamps; return the gaps."""
        begins = np.flatnonzero(np.isin(np.asarray(stamp_ns), self._stamps)).tolist()
        return numbering.take(numbers, stamp_ns, self._find_new, begins)

    def _find_new(self, number: int, stamp_ns: int) -> str | None:
        return self._publishers.get((number, stamp_ns))
