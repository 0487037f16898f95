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

"""Lines of plain text on standard error: now and then, and when something changes."""

from __future__ import annotations

import sys
import time

#: A line at least this often, and not more often than that.
_EVERY_S, _AT_MOST_S = 10.0, 1.0


class StatusLines:
    """Writes a line every 10 s, and at once when the state changes, at most one a second."""

    def __init__(self) -> None:
        self._state: object = None
        self._next_s = self._soonest_s = 0.0

    def is_due(self, state: object) -> bool:
        """Tell whether to write a line about a state, and assume that it is written."""
        now_s = time.monotonic()
        if now_s < self._soonest_s or state == self._state and now_s < self._next_s:
            return False
        self._state = state
        self._next_s, self._soonest_s = now_s + _EVERY_S, now_s + _AT_MOST_S
        return True

    @staticmethod
    def write(text: str) -> None:
        """Write a line."""
        sys.stderr.write(f'{text}\n')
        sys.stderr.flush()
