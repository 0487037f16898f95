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

"""Whose messages come: the publishers of a topic, as the graph lists them."""

from __future__ import annotations

import time
from typing import Callable, Collection, Iterable, Sequence

from heading_intercompare.bags.rosbag2.publisher_starts import PublisherStart

#: The graph is looked at once a second, and a batch waits for up to 0.2 s.
_LATE_NS = 2_000_000_000


class PublisherNames:
    """
    Tells which publisher a message is the first of.

    A message does not name its publisher. A number that does not follow the last one belongs to
    a publisher that came to the list of the graph after the last message of the others, if there
    is one. It is listed before its first message arrives. One that ends leaves the list at once; a
    dead one stays for 20 s. A publisher that is listed for longer and was never heard does not own
    the number.

    Parameters
    ----------
    list_gids
        Returns the publishers that the graph lists now.

    Attributes
    ----------
    starts : list of PublisherStart
        The starts found since the list was emptied.

    """

    def __init__(self, list_gids: Callable[[], Sequence[str]]) -> None:
        self._list_gids = list_gids
        self._listed_ns: dict[str, int] = {}
        self._heard: set[str] = set()
        self._before_ns: int | None = None
        self._fresh, self._alone = False, ''
        self.starts: list[PublisherStart] = []

    def go_on(self, publishers: Iterable[str]) -> None:
        """Go on after messages of publishers that an earlier process has heard."""
        self._heard.update(publishers)
        self._before_ns = 0

    def look(self, gids: Collection[str], now_ns: int | None = None) -> None:
        """Note who is listed."""
        ns = time.time_ns() if now_ns is None else now_ns
        self._listed_ns = {gid: self._listed_ns.get(gid, ns) for gid in gids}

    def begin(self, received_ns: int | None) -> None:
        """Begin a batch of messages, given when the one before it was received."""
        self._fresh = False
        if received_ns is not None:
            self._before_ns = received_ns

    def are_all_new(self) -> bool:
        """Tell whether all that are listed now came after the last message, none of them heard."""
        self.look(self._list_gids())
        self._fresh = True
        return bool(self._heard and self._listed_ns) and all(map(self._is_new, self._listed_ns))

    def _is_new(self, gid: str) -> bool:
        return gid not in self._heard and (
            self._before_ns is None or self._listed_ns[gid] > self._before_ns - _LATE_NS)

    def find_new(self, number: int, stamp_ns: int) -> str | None:
        """Return whose first message this is, '' if unknown, None if nobody's; note the start."""
        if not self._fresh:
            self.look(self._list_gids())
            self._fresh = True
        first = self._before_ns is None
        fresh = [*filter(self._is_new, self._listed_ns)]
        if not fresh and not first:
            return None
        name = fresh[0] if len(fresh) == 1 else ''
        self._heard.update(filter(None, [name]))
        # Those that could be the one and were not are no news the next time.
        self._listed_ns = dict.fromkeys(self._listed_ns, -_LATE_NS)
        self._before_ns = self._before_ns or 0
        self.starts.append(PublisherStart(name, number, stamp_ns))
        return name

    def find_alone(self, received: bool) -> str:
        """
        Return the only publisher listed, if it published since it was alone; '' otherwise.

        Call it at each look, and say whether a message came since the last one.
        """
        gids = [*self._listed_ns]
        alone = gids[0] if len(gids) == 1 else ''
        name = alone if received and alone == self._alone and alone not in self._heard else ''
        self._alone = alone
        if name:
            self._heard.add(name)
            self.starts.append(PublisherStart(name, 0, 0))
        return name
