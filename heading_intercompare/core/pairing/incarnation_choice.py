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

"""Which of several synchronizers is followed: one at a time, until it has ended or is silent."""

from __future__ import annotations

__all__ = ['IncarnationChoice']

#: A live synchronizer publishes its ledger every second.
_PATIENCE_S = 2.5
#: A node that looks less often than this was held up; what it has not heard may still wait.
_ASLEEP_S = 1.0
#: Incarnations remembered; more than two at once are rare.
_MOST = 16


class IncarnationChoice:
    """
    The incarnation of the synchronizer whose pairs and ledger count.

    Attributes
    ----------
    current : int or None
        When the synchronizer that is followed was started, UTC ns; None before the first.

    Notes
    -----
    A synchronizer that was killed stays in the graph of ROS for some 20 s. So only what a
    synchronizer says shows that it lives. The clock is the caller's.

    Examples
    --------
    >>> choice = IncarnationChoice()
    >>> choice.hear(1, 0.0)
    >>> choice.hear(2, 1.0)
    >>> choice.look(1.5), choice.look(2.4), choice.look(3.1)
    (1, 1, 2)

    """

    def __init__(self) -> None:
        self.current: int | None = None
        self._heard_s: dict[int, float] = {}
        self._ended: set[int] = set()
        self._past: set[int] = set()
        self._looked_s: float | None = None

    def hear(self, started_ns: int, now_s: float, final: bool = False) -> None:
        """Take note that a synchronizer said something, and whether it was its last word."""
        if self.current is None:
            self.current = started_ns
        if started_ns in self._past or started_ns in self._ended:
            return
        self._heard_s[started_ns] = now_s
        if final:
            self._ended.add(started_ns)
        while len(self._heard_s) > _MOST:
            oldest = min((candidate for candidate in self._heard_s if candidate != self.current),
                         key=self._heard_s.__getitem__)
            del self._heard_s[oldest]
            self._ended.discard(oldest)

    def follow(self, started_ns: int, now_s: float) -> None:
        """Follow a synchronizer, as an earlier process did."""
        if self.current is not None:
            self._past.add(self.current)
            self._heard_s.pop(self.current, None)
        self.current, self._heard_s[started_ns] = started_ns, now_s

    def look(self, now_s: float) -> int | None:
        """Return which synchronizer is followed now; it changes only if another one lives."""
        asleep_s = 0.0 if self._looked_s is None else now_s - self._looked_s
        self._looked_s = now_s
        if asleep_s > _ASLEEP_S:
            self._heard_s = {started_ns: heard_s + asleep_s
                             for started_ns, heard_s in self._heard_s.items()}
        others = self.list_others(now_s)
        if self.current is not None and others and (
                self.current in self._ended
                or now_s - self._heard_s[self.current] > _PATIENCE_S):
            self._past.add(self.current)
            del self._heard_s[self.current]
            self.current = others[0]
        return self.current

    def list_others(self, now_s: float) -> list[int]:
        """Return the other synchronizers that live, or that ended before they were followed."""
        return sorted(started_ns for started_ns, heard_s in self._heard_s.items()
                      if started_ns != self.current
                      and (started_ns in self._ended or now_s - heard_s <= _PATIENCE_S))
