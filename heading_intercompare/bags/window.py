# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Messages of a bag gathered into minutes, so that little is done often and memory is bounded."""

from __future__ import annotations

from typing import Iterator, Mapping

import numpy as np

from heading_intercompare.core.records import Headings

from .heading_messages import RawHeadings

__all__ = ['Window']

_CHUNK_NS = 60_000_000_000


class Window:
    """Collects messages until they span a minute of log time, and makes headings of them."""

    def __init__(self, conventions: Mapping[str, str]) -> None:
        self._conventions = conventions
        self._clear()

    def _clear(self) -> None:
        self._parts: dict[str, list[RawHeadings]] = {name: [] for name in self._conventions}
        self._first, self._last = 2**63, -1

    def add(self, log_time_ns: np.ndarray, columns: Mapping[str, tuple[np.ndarray, RawHeadings]]
            ) -> Iterator[dict[str, Headings]]:
        """Take a block: its log times, and by topic which messages and what; yield minutes."""
        if not len(log_time_ns):
            return
        first, last = int(log_time_ns.min()), int(log_time_ns.max())
        if max(last, self._last) - min(first, self._first) > _CHUNK_NS:
            yield from self.rest()
        if last - first <= _CHUNK_NS:
            self._first, self._last = min(first, self._first), max(last, self._last)
            for name, (_, raw) in columns.items():
                self._parts[name].append(raw)
            return
        minutes = (log_time_ns - first) // _CHUNK_NS
        for minute in np.unique(minutes):
            yield self._headings({name: raw[minutes[which] == minute]
                                  for name, (which, raw) in columns.items()})

    def rest(self) -> Iterator[dict[str, Headings]]:
        """Yield what has been collected, unless it is nothing."""
        if self._last >= 0:
            yield self._headings({name: RawHeadings.concatenate(parts)
                                  for name, parts in self._parts.items()})
        self._clear()

    def _headings(self, raw: Mapping[str, RawHeadings]) -> dict[str, Headings]:
        return {name: raw[name].headings(convention)
                for name, convention in self._conventions.items()}
