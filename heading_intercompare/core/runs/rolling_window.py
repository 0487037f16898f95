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
The rolling window, moved in panes of a 64th of its length.

A closed pane never changes, and the window adds up its panes on request. Figures that nobody
requests, as when a recording is analysed, are not computed. Nothing is ever subtracted, so
rounding errors do not build up over a long watch.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from heading_intercompare.core.records import Differences
from heading_intercompare.core.statistics.cells import Cells
from heading_intercompare.core.statistics.moments import Moments

_PANES = 64


@dataclass(frozen=True)
class _Pane:
    key: int
    stamp_ns: np.ndarray
    x_deg: np.ndarray

    @classmethod
    def of(cls, key: int, chunks: list[Differences]) -> '_Pane':
        joined = Differences.concatenate(chunks)
        return cls(key, joined.stamp_ns, joined.x_deg)

    @cached_property
    def moments(self) -> Moments:
        return Moments.of(self.x_deg)

    @cached_property
    def x_sorted_deg(self) -> np.ndarray:
        return np.sort(self.x_deg)


class Rolling:
    """
    Statistics of the latest differences.

    Parameters
    ----------
    window_s
        Length of the window, seconds of stamp time.

    Notes
    -----
    A request sums at most 65 panes and closes the newest one, whatever the length of the window.

    """

    def __init__(self, window_s: float) -> None:
        self._begin(window_s)

    def clear(self) -> None:
        """Forget all differences."""
        self._begin(self._pane_ns * _PANES / 1e9)

    def _begin(self, window_s: float) -> None:
        self._pane_ns = max(1, round(window_s * 1e9 / _PANES))
        self._panes: deque[_Pane] = deque()
        self._open: list[Differences] = []
        self._open_key = 0
        self._newest_ns = 0
        # Not yet put into panes: nobody may ever ask.
        self._waiting: deque[Differences] = deque()
        self._closed: Moments | None = None

    def resize(self, window_s: float) -> None:
        """Change the length, seconds; what the window holds stays, as far as it is not too old."""
        held = [*(Differences(pane.stamp_ns, pane.x_deg) for pane in self._panes), *self._open,
                *self._waiting]
        self._begin(window_s)
        for differences in held:
            self.update(differences)

    def update(self, differences: Differences) -> None:
        """Take differences in stamp order; values that are not finite are skipped."""
        keep = np.isfinite(differences.x_deg)
        if not keep.all():
            differences = differences[keep]
        if not len(differences):
            return
        self._newest_ns = int(differences.stamp_ns[-1])
        self._waiting.append(differences)
        oldest = self._newest_ns // self._pane_ns - _PANES
        while int(self._waiting[0].stamp_ns[-1]) // self._pane_ns <= oldest:
            self._waiting.popleft()

    def _fill_panes(self) -> None:
        """Put the waiting differences into panes."""
        while self._waiting:
            differences = self._waiting.popleft()
            stamps = differences.stamp_ns
            hi = 0
            while hi < len(stamps):
                lo, key = hi, int(stamps[hi]) // self._pane_ns
                hi = int(np.searchsorted(stamps, (key + 1) * self._pane_ns))
                if key != self._open_key:
                    self._close()
                    self._open_key = key
                self._open.append(differences[lo:hi])
        while self._panes and self._panes[0].key <= self._open_key - _PANES:
            self._panes.popleft()
            self._closed = None

    def _close(self) -> None:
        if self._open:
            self._panes.append(_Pane.of(self._open_key, self._open))
            self._open = []
            self._closed = None

    def _list_panes(self) -> list[_Pane]:
        self._fill_panes()
        if len(self._open) > 1:
            self._open = [Differences.concatenate(self._open)]
        newest = [_Pane.of(self._open_key, self._open)] if self._open else []
        return [*self._panes, *newest]

    @property
    def start_ns(self) -> int | None:
        """First stamp in the window; None if it is empty."""
        self._fill_panes()
        if not (self._panes or self._open):
            return None
        first = self._panes[0] if self._panes else self._open[0]
        return int(first.stamp_ns[0])

    def cells(self) -> Cells:
        """Return the differences in the window, summed over cells."""
        cells = Cells()
        for pane in self._list_panes():
            cells.update(pane.x_deg, pane.stamp_ns)
        return cells

    @property
    def span_s(self) -> float:
        """Time from the first to the last difference in the window, seconds."""
        panes = self._list_panes()
        return (self._newest_ns - int(panes[0].stamp_ns[0])) / 1e9 if panes else 0.0

    def moments(self) -> Moments:
        """Return the moments of the differences in the window."""
        self._fill_panes()
        if self._closed is None:
            self._closed = sum((p.moments for p in self._panes), Moments())
        return sum((p.moments for p in self._list_panes()[len(self._panes):]), self._closed)

    def count_outside(self, center_deg: float, limit_deg: float) -> int:
        """Count the differences farther than the limit from the centre."""
        n = 0
        for pane in self._list_panes():
            x = pane.x_sorted_deg
            n += int(np.searchsorted(x, center_deg - limit_deg, side='left'))
            n += len(x) - int(np.searchsorted(x, center_deg + limit_deg, side='right'))
        return n
