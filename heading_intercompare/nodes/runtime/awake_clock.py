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

"""A steady clock that stands still while this process does."""

from __future__ import annotations

import time

#: A process that runs reads the clock more often than this.
_LONGEST_S = 1.0


class AwakeClock:
    """
    Counts the time in which this process runs, seconds.

    A process that was stopped, or starved, finds later what came in the meantime. Nothing that
    waits may be given up before it has been looked for.
    """

    def __init__(self) -> None:
        self._read_s, self._awake_s = time.monotonic(), 0.0

    def now_s(self) -> float:
        """Return the time so far; each step counts for at most a second."""
        now_s = time.monotonic()
        self._awake_s += min(now_s - self._read_s, _LONGEST_S)
        self._read_s = now_s
        return self._awake_s
