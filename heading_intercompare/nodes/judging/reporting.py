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

"""Publishing of verdicts and reports: at each change, once the ledger covers all pairs."""

from __future__ import annotations

from dataclasses import replace
import os
import time
from typing import Iterable, Iterator

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.duration import Duration
from rclpy.node import Node
from std_msgs.msg import String

from heading_intercompare.core.alarms.graph_watch import NOT_WRITTEN
from heading_intercompare.core.count_words import count_words
from heading_intercompare.core.decision.sequential import LookVerdict
from heading_intercompare.core.pipeline import Compliance
from heading_intercompare.core.verdict.verdict_document import RunVerdict, Verdict
from heading_intercompare.logbook.logbook_file import Logbook, LogbookBusy, LogbookError
from heading_intercompare.logbook.run_row import make_rows, RunKey, RunRow
from heading_intercompare.messages.status_messages import encode_text, OK, WARN
from heading_intercompare.messages.verdict_messages import (
    encode_no_verdict,
    encode_verdict,
    NO_VERDICT,
    OUTCOME_LEVELS,
    verdict_level,
)
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.settings import ComplianceNode
from heading_intercompare.nodes.spinning.clocks import stamp_or_now
from heading_intercompare.report.json import render

from .accounts import Account
from .heard_actions import HeardActions
from .heard_recorders import HeardRecorders
from .report_files import write_report
from .trial_journal import TrialJournal

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
        self._health.note('logbook', WARN, f'{why}; {len(self._waiting)} runs wait', latch=latch,
                          alarm=NOT_WRITTEN if latch else '')


class Reporting:
    """
    Publishes the verdicts and reports on a tested sensor.

    Parameters
    ----------
    node, place
        The node that publishes, and what its topics begin with.
    compliance
        Judges the runs.
    own
        Settings.
    health
        Shows alerts.
    account
        The fate of every reading.
    journal
        Says what it lacks.
    actions
        What operators did while the nodes ran.
    recorders
        What was recorded meanwhile.

    Attributes
    ----------
    verdict
        The verdict of the last report; None before the first.

    """

    def __init__(self, node: Node, place: str, compliance: Compliance, own: ComplianceNode,
                 health: Health, account: Account, journal: TrialJournal,
                 actions: HeardActions, recorders: HeardRecorders) -> None:
        self._node, self._compliance, self._own, self._health = node, compliance, own, health
        self._account, self._journal = account, journal
        self._actions, self._recorders = actions, recorders
        self._verdict = node.create_publisher(
            DiagnosticArray, f'{place}compliance/verdict', qos.STATE,
            event_callbacks=health.of_publisher(f'{place}compliance/verdict'))
        if not compliance.finished_runs:
            self._verdict.publish(encode_no_verdict(
                stamp_or_now(node, compliance.newest_ns), health.owner))
            health.note('verdict', OK, NO_VERDICT)
        self._report, self._intermediate = (
            node.create_publisher(String, f'{place}compliance/{what}', qos.REPORT)
            for what in ('report', 'intermediate_report'))
        self._seen: tuple[int, LookVerdict | None] = (0, None)
        self._due: tuple[int, float] | None = None
        self.verdict: Verdict | None = None
        self._said = ''
        self._next_ns: int | None = None
        self._run_log = RunLog(own, health)
        if own.report_dir is not None:
            os.makedirs(own.report_dir, exist_ok=True)

    def look(self) -> None:
        """Publish changes; a report waits for a ledger that covers the pairs received."""
        seen = self._compliance.finished_runs, self._compliance.early
        if seen[0] != self._seen[0]:
            self._due = self._account.n_pairs, time.monotonic() + self._own.ledger_wait_s
        elif seen[1] != self._seen[1]:
            self._announce(self._compliance.verdict(self._account.ledger))
        self._seen = seen
        if self._due is not None:
            n_due, until_s = self._due
            covered = self._account.covers(n_due)
            if covered or time.monotonic() > until_s:
                self._conclude(covered)
        self._run_log.retry()
        newest_ns, every_h = self._compliance.newest_ns, self._own.report_every_h
        if newest_ns is not None and every_h is not None:
            if self._next_ns is not None and newest_ns >= self._next_ns:
                self.report()
            if self._next_ns is None or newest_ns >= self._next_ns:
                self._next_ns = newest_ns + round(every_h * 3600e9)

    def report(self) -> str:
        """Publish and write what a stop now would give; return its headline, '' without a pair."""
        if self._compliance.newest_ns is None:
            return ''
        verdict = self._complete(self._compliance.preview(self._account.ledger), True)
        text = render(verdict)
        self._intermediate.publish(encode_text(text))
        self._health.logger.info(verdict.headline)
        self._write(text, 'intermediate')
        return verdict.headline

    def close(self, complete: bool) -> None:
        """Publish the last verdict and report, and wait until they are received."""
        # The report of these runs stands, whatever comes until the process is gone.
        self._seen = self._compliance.finished_runs, self._compliance.early
        self._conclude(complete)
        self._run_log.retry(last=True)
        for publisher in (self._verdict, self._report):
            publisher.wait_for_all_acked(Duration(seconds=1.0))

    def _conclude(self, complete: bool) -> None:
        """Publish and write the report, unless it is unchanged."""
        self._due = None
        ledger = self._account.ledger
        verdict = self._complete(self._compliance.verdict(ledger), complete)
        problems = verdict.ledger_problems
        earlier = [result.verdict for result in self._compliance.take_earlier(ledger)]
        self._run_log.take(verdict, earlier)
        report = render(verdict)
        if report == self._said:
            return
        self.verdict, self._said = verdict, report
        self._health.note('ledger', WARN if problems else OK,
                          'the ledger of the last report is incomplete: ' + '; '.join(problems)
                          if problems else 'complete')
        self._announce(verdict)
        self._report.publish(encode_text(report))
        self._write(report)

    def _complete(self, verdict: Verdict, complete: bool) -> Verdict:
        """Return a verdict with what the node knows besides the pairs."""
        return replace(verdict, ledger_problems=tuple(self._problems(complete)),
                       operator_actions=self._actions.notes or None,
                       recordings=self._recorders.recordings or None)

    def _problems(self, complete: bool) -> Iterator[str]:
        """Yield what the verdict does not count, in plain sentences."""
        yield from self._account.find_problems(complete)
        yield from self._journal.describe_dropped()
        if late := self._compliance.motion.late:
            yield f'{late} messages of the motion of the ship came after their run was judged'

    def _announce(self, verdict: Verdict) -> None:
        """Publish the verdict."""
        early = self._compliance.early
        findings = []
        if verdict.runs or early is None:
            findings.append((verdict_level(verdict.outcome, verdict.validity_effect),
                             f'{count_words(len(verdict.runs), "run")}: {verdict.headline}'))
        if early is not None:
            findings.append((OUTCOME_LEVELS[early.outcome], f'the run in progress, {early}'))
        # A good run in progress does not excuse an earlier finding.
        self._health.note('verdict', max(level for level, _ in findings),
                          '; '.join(words for _, words in findings), latch=True, log=False,
                          runs=len(verdict.runs))
        self._health.logger.info(f'verdict on {findings[-1][1]}')
        self._verdict.publish(encode_verdict(
            verdict, stamp_or_now(self._node, self._compliance.newest_ns), early,
            self._health.owner))

    def _write(self, text: str, kind: str = 'verdict') -> None:
        write_report(self._own.report_dir, kind, self._compliance.newest_ns, {'.json': text},
                     self._health)
