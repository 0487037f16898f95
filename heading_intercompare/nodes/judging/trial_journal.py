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

"""The journal of a node that judges: opened where wanted, and never the end of a trial."""

from __future__ import annotations

import os
from pathlib import Path
import time
from typing import Iterator, Mapping

from rclpy.node import Node

from heading_intercompare.core.alarms.graph_watch import NOT_WRITTEN
from heading_intercompare.core.pairing.pair_maker import PairMaker
from heading_intercompare.core.pipeline import Compliance
from heading_intercompare.core.records import Motion, Pairs, Quality
from heading_intercompare.core.runs.growing_columns import Keep
from heading_intercompare.core.sensors.pair_names import Names, TWO
from heading_intercompare.core.settings import Settings
from heading_intercompare.journal.journal_reading import Kept, Numbers
from heading_intercompare.journal.reading_batches import Batch
from heading_intercompare.journal.run_journal import RunJournal
from heading_intercompare.journal.spool import Spool
from heading_intercompare.messages.ledger_messages import LedgerMessage
from heading_intercompare.messages.status_messages import OK, WARN
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.settings import ComplianceNode

_NONE = '-'


class TrialJournal:
    """
    Keeps the run in progress of a judgement; without a file it does nothing.

    Parameters
    ----------
    node
        The node; its full name is that of the file.
    settings
        Of the trial.
    judges : mapping of (str, str) to Compliance
        Judges of the pairs of each two sensors, by their names; they go on from the journal.
    own
        Settings `journal`, `report_dir`, `resume_within_s` and `bag`.
    health
        Shows a journal that cannot be written, or was set aside.
    makers
        Make the pairs of each two, if this process does; they go on from the journal, too.

    Attributes
    ----------
    began_ns : int
        When the trial began, UTC ns.
    kept : Kept
        What the journal of an earlier process says besides the pairs.
    resumed : bool
        This node goes on with the trial of that process.

    """

    def __init__(self, node: Node, settings: Settings, judges: Mapping[Names, Compliance],
                 own: ComplianceNode, health: Health,
                 makers: list[PairMaker] | None = None) -> None:
        self._health, self.began_ns = health, time.time_ns()
        self._journal: RunJournal | None = None
        self.kept, self._fault, self.resumed = Kept(), '', False
        path = _find_path(own, node.get_fully_qualified_name())
        if path is None:
            return
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._journal = RunJournal(path, settings, judges, within_s=own.resume_within_s,
                                       now_ns=self.began_ns, bag=own.bag, makers=makers)
        except BlockingIOError:
            self._warn(f'another process keeps its run in {path}')
            return
        except OSError as error:
            self._warn(f'{error.filename or path}: {error.strerror}')
            return
        self.kept, self.began_ns = self._journal.kept, self._journal.began_ns
        if self._journal.set_aside:
            health.note('journal', WARN, self._journal.set_aside, latch=True)
        else:
            health.note('journal', OK, f'kept in {path}')
        self.resumed = bool(self._journal.resumed)
        if self.resumed:
            node.get_logger().warning(f'journal: {self._journal.resumed}')

    def _warn(self, why: str) -> None:
        self._health.note('journal', WARN, f'the run in progress is not kept: {why}', latch=True,
                          alarm=NOT_WRITTEN)

    def add(self, pairs: Pairs, numbers: Numbers | None = None, names: Names = TWO) -> None:
        """Keep pairs, before they are judged; see `RunJournal.add`."""
        if self._journal is not None:
            self._journal.add(pairs, numbers, names)

    def add_batch(self, batch: Batch, clear: bool) -> None:
        """Keep readings, before they are paired; `clear` as for `tick`."""
        if self._journal is not None:
            self._journal.add_batch(batch)
            if clear:
                self._journal.flush(time.monotonic())

    def take_motion(self, motion: Motion) -> None:
        """Keep motion of the ship, before it is judged."""
        if self._journal is not None:
            self._journal.add_motion(motion)

    def take_quality(self, sensor: str, quality: Quality) -> None:
        """Keep what a sensor says of its readings, before they are judged."""
        if self._journal is not None:
            self._journal.add_quality(sensor, quality)

    def mark(self, kind: str, stamp_ns: int) -> None:
        """Keep a mark, before it takes effect."""
        if self._journal is not None:
            self._journal.mark(kind, stamp_ns)

    def book(self, ledger: LedgerMessage) -> None:
        """Keep the newest ledger of a synchronizer."""
        if self._journal is not None:
            self._journal.book(ledger)

    def tick(self, clear: bool) -> None:
        """Write what is due, once it is `clear` that this node does not give way to another."""
        if self._journal is None or not clear:
            return
        self._journal.tick(time.monotonic())
        if self._journal.fault != self._fault:
            self._fault = self._journal.fault
            if self._fault:
                self._warn(self._fault)
            else:
                self._health.note('journal', OK, 'kept again')

    def describe_dropped(self) -> Iterator[str]:
        """Yield, in a plain sentence, how much an earlier process could not keep."""
        if self.kept.dropped:
            yield (f'{self.kept.dropped} records of the run in progress could not be kept before '
                   'this node was started again')

    def close(self) -> None:
        """Remove the journal: the trial is over, and its report is out."""
        if self._journal is not None:
            self._journal.close(over=True)
            self._journal = None


def open_spool(health: Health) -> Keep:
    """Return a store for the pages of a run; what cannot be stored is shown, and stays."""
    return Spool(lambda why: health.note(
        'run', WARN, f'the run in progress stays in memory: {why}', latch=True)).keep


def _find_path(own: ComplianceNode, name: str) -> Path | None:
    """Return the file of the journal; None if none is wanted."""
    if own.journal == _NONE or (own.journal is None and own.report_dir is None):
        return None
    file = name.strip('/').replace('/', '.')
    path = own.journal or os.path.join(own.report_dir or '', f'{file}.journal')
    return Path(os.path.abspath(path))
