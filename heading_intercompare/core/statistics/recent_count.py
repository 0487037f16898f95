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

"""How much a count grew lately, so that old trouble expires."""

from __future__ import annotations

from collections import deque


class RecentCount:
    """
    The growth of a count within a span of time.

    Parameters
    ----------
    span_s
        The span, seconds.

    Examples
    --------
    >>> count = RecentCount(10.0)
    >>> count.take(5, 0.0), count.take(7, 6.0), count.take(7, 11.0), count.take(7, 17.0)
    (5, 7, 2, 0)

    """

    def __init__(self, span_s: float) -> None:
        self._span_s = span_s
        self._total = 0
        self._grown: deque[tuple[float, int]] = deque()

    def take(self, total: int, now_s: float) -> int:
        """
        Take the count so far; return by how much it grew within the span.

        Parameters
        ----------
        total
            The count; a smaller one than before began again at 0.
        now_s
            A steady clock, seconds.

        """
        grown = total - self._total if total >= self._total else total
        self._total = total
        if grown:
            self._grown.append((now_s, grown))
        while self._grown and self._grown[0][0] <= now_s - self._span_s:
            self._grown.popleft()
        return sum(n for _, n in self._grown)
