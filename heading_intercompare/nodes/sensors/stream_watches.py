# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""How each of several sensors reports now, and the newest stamp of any."""

from __future__ import annotations

import time
from typing import Iterable, Mapping

from heading_intercompare.core.records import Headings
from heading_intercompare.web.figures.stream_watch import SensorView, StreamWatch

__all__ = ['StreamWatches']


class StreamWatches:
    """
    Watches the headings of several sensors.

    Parameters
    ----------
    names : iterable of str
        The sensors.
    stale_s : float
        Age after which a reading is stale, seconds.

    Attributes
    ----------
    newest_ns : int or None
        The newest stamp of any sensor; None before the first reading.

    """

    def __init__(self, names: Iterable[str], stale_s: float) -> None:
        self._watches = {name: StreamWatch(stale_s) for name in names}
        self.newest_ns: int | None = None

    def take(self, headings: Mapping[str, Headings], received_ns: Mapping[str, int]) -> None:
        """Take new readings, and when the newest of each sensor arrived, UTC ns."""
        for name, some in headings.items():
            if len(some):
                self._watches[name].take(some, received_ns[name], time.monotonic())
                self.newest_ns = max(self.newest_ns or 0, int(some.stamp_ns[-1]))

    def view(self) -> dict[str, SensorView]:
        """Return each sensor as it reports now."""
        now_s = time.monotonic()
        return {name: watch.view(now_s) for name, watch in self._watches.items()}
