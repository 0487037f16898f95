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

"""Columns that grow for hours, in pages that a live node can move out of memory."""

from __future__ import annotations

from typing import Any, Callable

import numpy as np

from heading_intercompare.core.records import Headings

#: Returns a stored page, shape (n,), read-only.
Page = Callable[[], np.ndarray]
#: Stores a full page, shape (n,), and returns a function that reads it back.
Keep = Callable[[np.ndarray], Page]

_PAGE = 65536
_GROWTH = 4
#: Number of smallest, and of largest, values of each page that stay in memory.
_TAIL = _PAGE // 64


class Column:
    """
    A column that grows by chunks.

    Parameters
    ----------
    dtype
        Type of the values.
    keep
        Stores full pages. Without it there are no pages and all values stay in memory. The
        capacity grows fourfold, so n values cost at most n/3 copies in all; the operating system
        gives memory only to what is filled.
    on_page
        Called with each full page.

    Attributes
    ----------
    first, last : scalar or None
        The oldest and the newest value; None while the column is empty.

    """

    def __init__(self, dtype: type, keep: Keep | None = None,
                 on_page: Callable[[np.ndarray], None] = lambda page: None) -> None:
        self._keep = keep
        self._on_page = on_page
        self._pages: list[Page] = []
        self._open: np.ndarray = np.empty(1024 if keep is None else _PAGE, dtype)
        self._n_open = 0
        self.first: Any = None
        self.last: Any = None

    def __len__(self) -> int:
        return len(self._pages) * _PAGE + self._n_open

    def append(self, chunk: np.ndarray) -> None:
        """Append a chunk."""
        if not len(chunk):
            return
        if self.first is None:
            self.first = chunk[0]
        self.last = chunk[-1]
        if self._keep is None:
            if not self._n_open and chunk.base is None and len(chunk) >= len(self._open):
                # The first chunk is whole columns of a log: a full column needs no copy of it.
                self._open, self._n_open = chunk, len(chunk)
                return
            self._reserve(len(chunk))
        lo = 0
        while lo < len(chunk):
            piece = chunk[lo:lo + len(self._open) - self._n_open]
            self._open[self._n_open:self._n_open + len(piece)] = piece
            self._n_open += len(piece)
            lo += len(piece)
            if self._keep is not None and self._n_open == _PAGE:
                self._turn(self._keep)

    def _reserve(self, size: int) -> None:
        """Make room for more values."""
        need = self._n_open + size
        if need > len(self._open):
            grown = np.empty(max(need, _GROWTH * len(self._open)), self._open.dtype)
            grown[:self._n_open] = self.newest
            self._open = grown

    def _turn(self, keep: Keep) -> None:
        """Store the full page and begin the next."""
        page, self._open, self._n_open = self._open, np.empty(_PAGE, self._open.dtype), 0
        self._on_page(page)
        self._pages.append(keep(page))

    @property
    def newest(self) -> np.ndarray:
        """Return the values not yet on a full page: read-only, valid until the next append."""
        view = self._open[:self._n_open]
        view.flags.writeable = False
        return view

    def page(self, number: int) -> np.ndarray:
        """Return a full page, shape (65536,), read-only; the first has number 0."""
        return self._pages[number]()

    @property
    def values(self) -> np.ndarray:
        """Return the values so far, shape (n,), read-only and valid until the next append."""
        if not self._pages:
            return self.newest
        whole = np.empty(len(self), self._open.dtype)
        for number, page in enumerate(self._pages):
            whole[number * _PAGE:(number + 1) * _PAGE] = page()
        whole[len(self._pages) * _PAGE:] = self.newest
        whole.flags.writeable = False
        return whole


class GrowingHeadings:
    """
    Readings that grow by chunks and stay in memory, 16 bytes each.

    Chunks in a list would take as much, and twice that once they are joined.
    """

    def __init__(self) -> None:
        self._stamp_ns, self._heading_deg = Column(np.int64), Column(np.float64)

    def append(self, headings: Headings) -> None:
        """Append a chunk."""
        self._stamp_ns.append(headings.stamp_ns)
        self._heading_deg.append(headings.heading_deg)

    @property
    def headings(self) -> Headings:
        """Return the readings so far, valid until the next append."""
        return Headings(self._stamp_ns.values, self._heading_deg.values)


class Tails:
    """
    The smallest and largest values of the pages of a column, to count those beyond a limit.

    Notes
    -----
    Takes 16 kB per page of 512 kB. If the tails do not reach in to the limit, the whole page is
    read, so a count is always exact.

    """

    def __init__(self) -> None:
        self._tails: list[np.ndarray] = []

    def take(self, page: np.ndarray) -> None:
        """Take the next full page."""
        parted = np.partition(page, (_TAIL, len(page) - _TAIL - 1))
        self._tails.append(np.concatenate([parted[:_TAIL + 1], parted[-_TAIL - 1:]]))

    def count_outside(self, column: Column, center: float, limit: float) -> int:
        """Count the values on full pages that are farther than the limit from the centre."""
        n = 0
        for number, tails in enumerate(self._tails):
            outside = np.abs(tails - center) > limit
            # All values between the innermost two of the tails are no farther away.
            if outside[_TAIL] or outside[_TAIL + 1]:
                outside = np.abs(column.page(number) - center) > limit
            n += int(np.count_nonzero(outside))
        return n
