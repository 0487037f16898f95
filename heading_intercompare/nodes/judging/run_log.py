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

"""Writing of judged runs to the logbook, which never ends or holds up a trial."""

from __future__ import annotations

import time
from typing import Iterable

from heading_intercompare.core.verdict.verdict_document import RunVerdict, Verdict
from heading_intercompare.logbook.logbook_file import Logbook, LogbookBusy, LogbookError
from heading_intercompare.logbook.run_row import make_rows, RunKey, RunRow
from heading_intercompare.messages.status_messages import OK, WARN
from heading_intercompare.nodes.ros.health import Health
from heading_intercompare.nodes.settings import ComplianceNode

# A callback may wait this long for another process that writes, the end of the node longer.
_PATIENCE_S, _LAST_PATIENCE_S = 0.1, 2.0
_RETRY_S = 5.0
# Rows that wait for a disk; a year of watches.
_MOST_WAITING = 2500


class RunLog:
    """
    Writes the runs of a compliance node to its logbook; rows that fail wait and are tried again.

    Parameters
    ----------
    own
        Settings `logbook`, `ship` and `bag`; without `logbook` nothing is written.
    health
        Shows a logbook that cannot be written as a latched warning.

    """

    def __init__(self, own: ComplianceNode, health: Health) -> None:
        self._own, self._health = own, health
        self._waiting: dict[RunKey, RunRow] = {}
        self._written: dict[RunKey, RunRow] = {}
        self._retry_at_s = 0.0

    def take(self, verdict: Verdict, earlier: Iterable[RunVerdict]) -> None:
        """Take the runs of a verdict and those that it does not cover any more; write changes."""
        if self._own.logbook is None:
            return
        rows = {row.key: row for row in make_rows(
            verdict, ship=self._own.ship or '', earlier=earlier,
            find_bag=lambda source: self._own.bag)}
        for key, row in rows.items():
            if self._written.get(key) != row:
                self._waiting[key] = row
        while len(self._waiting) > _MOST_WAITING:
            del self._waiting[next(iter(self._waiting))]
        self._written = {key: row for key, row in self._written.items() if key in rows}
        self._retry_at_s = 0.0
        self.retry()

    def retry(self, last: bool = False) -> None:
        """Write the rows that wait, if it is time; `last` tries at once and harder."""
        if not self._waiting or (time.monotonic() < self._retry_at_s and not last):
            return
        book = Logbook(self._own.logbook or '', _LAST_PATIENCE_S if last else _PATIENCE_S)
        try:
            book.write([*self._waiting.values()])
        except LogbookBusy as error:
            self._fail(str(error), latch=last)
        except LogbookError as error:
            self._fail(str(error), latch=True)
        else:
            self._written |= self._waiting
            self._waiting.clear()
            self._health.note('logbook', OK, f'written to {book.path}')

    def _fail(self, why: str, *, latch: bool) -> None:
        self._retry_at_s = time.monotonic() + _RETRY_S
        self._health.note('logbook', WARN, f'{why}; {len(self._waiting)} runs wait', latch=latch)
