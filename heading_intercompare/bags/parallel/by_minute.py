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

"""Messages of a bag grouped by minute: work is done in large pieces, and memory stays bounded."""

from __future__ import annotations

from typing import Iterator, Sequence

import numpy as np

from heading_intercompare.core.records import Headings, Integers

from .decoding import Found

_MINUTE_NS = 60_000_000_000


def _take_rising(readings: Found) -> tuple[Integers, Integers | None]:
    """
    Return log times in rising order and the rows they belong to; None for the rows as they are.

    Each topic stays in file order: where the clock of the recorder went back, the readings keep
    the latest time seen before.
    """
    times_ns = readings.log_time_ns
    if (times_ns[1:] >= times_ns[:-1]).all():
        return times_ns, None
    latest_ns = times_ns.copy()
    for place in np.unique(readings.place):
        mine = np.flatnonzero(readings.place == place)
        latest_ns[mine] = np.maximum.accumulate(times_ns[mine])
    rows = np.argsort(latest_ns, kind='stable')
    return latest_ns[rows], rows


def _minutes(by_kind: Sequence[Found], first_ns: int) -> Iterator[list[slice | Integers]]:
    """Yield the rows of each kind, minute by minute from the first time; skip empty minutes."""
    times_ns, rows = zip(*map(_take_rising, by_kind))
    done = [0] * len(by_kind)
    while left := [int(of[lo]) for of, lo in zip(times_ns, done) if lo < len(of)]:
        end = min(left) + _MINUTE_NS - (min(left) - first_ns) % _MINUTE_NS
        until = [int(np.searchsorted(of, end)) for of in times_ns]
        yield [slice(lo, hi) if of is None else of[lo:hi]
               for of, lo, hi in zip(rows, done, until)]
        done = until


class Window:
    """
    Collects headings until they span a minute of log time.

    Parameters
    ----------
    count
        Number of topics; a topic is identified by its index.

    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._clear()

    def _clear(self) -> None:
        self._parts: list[tuple[np.ndarray, Headings]] = []
        self._first, self._last = 2**63, -1

    def add(self, by_kind: Sequence[Found]) -> Iterator[list[Headings]]:
        """Take the headings of a block, by kind; yield full minutes, each with all topics."""
        by_kind = [readings for readings in by_kind if len(readings.place)]
        if not by_kind:
            return
        first = min(int(readings.log_time_ns.min()) for readings in by_kind)
        last = max(int(readings.log_time_ns.max()) for readings in by_kind)
        if max(last, self._last) - min(first, self._first) > _MINUTE_NS:
            yield from self.rest()
        if last - first <= _MINUTE_NS:
            self._first, self._last = min(first, self._first), max(last, self._last)
            self._parts += [(readings.place, readings.headings) for readings in by_kind]
            return
        for rows in _minutes(by_kind, first):
            yield self._split_by_topic([(readings.place[which], readings.headings[which])
                                        for readings, which in zip(by_kind, rows)])

    def rest(self) -> Iterator[list[Headings]]:
        """Yield the headings collected so far, if any."""
        if self._parts:
            yield self._split_by_topic(self._parts)
        self._clear()

    def _split_by_topic(self, parts: Sequence[tuple[np.ndarray, Headings]]) -> list[Headings]:
        places = np.concatenate([place for place, _ in parts])
        headings = Headings.concatenate([part for _, part in parts])
        return [headings[np.flatnonzero(places == place)] for place in range(self._count)]
