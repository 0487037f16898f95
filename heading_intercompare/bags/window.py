# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Messages of a bag gathered into minutes, so that little is done often and memory is bounded."""

from __future__ import annotations

from typing import Iterator, Sequence

import numpy as np

from heading_intercompare.core.records import Headings

__all__ = ['Window']

_MINUTE_NS = 60_000_000_000


class Window:
    """
    Collects messages until they span a minute of log time.

    Parameters
    ----------
    count : int
        Number of topics; a topic is known by its place among them.

    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._clear()

    def _clear(self) -> None:
        self._parts: list[tuple[np.ndarray, Headings]] = []
        self._first, self._last = 2**63, -1

    def add(self, log_time_ns: np.ndarray,
            found: Sequence[tuple[np.ndarray | slice, np.ndarray, Headings]]
            ) -> Iterator[list[Headings]]:
        """
        Take a block; yield minutes, each with all topics in their order.

        Parameters
        ----------
        log_time_ns : ndarray of int64, shape (n,)
            Of the messages of the block.
        found : sequence
            Some of them at a time, each topic always in the same place of the sequence: which
            they are, of which topic each is, and its heading.

        """
        if not len(log_time_ns):
            return
        first, last = int(log_time_ns.min()), int(log_time_ns.max())
        if max(last, self._last) - min(first, self._first) > _MINUTE_NS:
            yield from self.rest()
        if last - first <= _MINUTE_NS:
            self._first, self._last = min(first, self._first), max(last, self._last)
            self._parts += [(place, headings) for _, place, headings in found]
            return
        minutes = (log_time_ns - first) // _MINUTE_NS
        found = [(minutes[which], place, headings) for which, place, headings in found]
        if (minutes[1:] >= minutes[:-1]).all():
            present = minutes[np.append(True, minutes[1:] != minutes[:-1])]
            for minute in present:
                rows = [slice(*np.searchsorted(of, (minute, minute + 1))) for of, _, _ in found]
                yield self._rows_of(found, rows)
        else:
            for minute in np.unique(minutes):
                yield self._rows_of(found, [of == minute for of, _, _ in found])

    def _rows_of(self, found: Sequence[tuple[np.ndarray, np.ndarray, Headings]],
                 rows: Sequence[np.ndarray | slice]) -> list[Headings]:
        return self._by_topic([(place[row], headings[row])
                               for row, (_, place, headings) in zip(rows, found)])

    def rest(self) -> Iterator[list[Headings]]:
        """Yield what has been collected, unless it is nothing."""
        if self._parts:
            yield self._by_topic(self._parts)
        self._clear()

    def _by_topic(self, parts: Sequence[tuple[np.ndarray, Headings]]) -> list[Headings]:
        places = np.concatenate([place for place, _ in parts])
        headings = Headings.concatenate([part for _, part in parts])
        return [headings[np.flatnonzero(places == place)] for place in range(self._count)]
