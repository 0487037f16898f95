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
Readings of a TCP or serial stream that have no time of receipt of their own.

Bytes of a stream wait in the kernel, unstamped, while the program does not read. Then several
readings come at once, and the time at which they are read is not the time at which they came.
"""

from __future__ import annotations

from collections import deque
from statistics import median

from .sentences import Name

#: Steps and latencies remembered, and how many of them are needed.
_REMEMBERED, _NEEDED = 31, 3
#: A stamp may be late by this many usual steps.
_LATE_STEPS = 2.0


class BurstFinder:
    """
    Tells which readings of a stream have no stamp of their own.

    A reading has none if another one of its kind and talker began in the same read, or if its
    bytes may have waited for more than two usual steps of its kind.
    """

    def __init__(self) -> None:
        self._last_ns: dict[Name, int] = {}
        self._steps_ns: dict[Name, deque[int]] = {}
        self._latencies_ns: dict[Name, deque[int]] = {}

    def find(self, name: Name, received_ns: int, in_read: int, late_s: float) -> bool:
        """
        Tell whether a reading belongs to a burst.

        Parameters
        ----------
        name
            Kind and talker of the reading.
        received_ns
            Time of the read in which its first byte came, nanoseconds.
        in_read
            Readings of this name that began in that read, itself among them.
        late_s
            Longest time for which its bytes may have waited to be read, seconds.

        """
        last_ns = self._last_ns.get(name)
        self._last_ns[name] = received_ns
        if in_read > 1 or received_ns == last_ns:
            return True
        steps_ns = self._steps_ns.setdefault(name, deque(maxlen=_REMEMBERED))
        enough_steps = len(steps_ns) >= _NEEDED
        if enough_steps and late_s * 1e9 > _LATE_STEPS * median(steps_ns):
            return True
        if last_ns is not None and received_ns > last_ns:
            steps_ns.append(received_ns - last_ns)
        return False

    def learn_latency(self, name: Name, received_ns: int, valid_ns: int) -> None:
        """Note how long after its time of validity a reading with a stamp of its own came."""
        latencies_ns = self._latencies_ns.setdefault(name, deque(maxlen=_REMEMBERED))
        latencies_ns.append(received_ns - valid_ns)

    def receipt_ns(self, name: Name, valid_ns: int) -> int | None:
        """Return when a reading valid at some time usually comes; None while that is unknown."""
        latencies_ns = self._latencies_ns.get(name, ())
        return valid_ns + int(median(latencies_ns)) if len(latencies_ns) >= _NEEDED else None
