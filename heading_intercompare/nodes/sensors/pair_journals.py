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

"""The runs in progress of the pairs without the reference, kept on disk; and what was missed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
import time
from typing import Iterator, Mapping

from rclpy.node import Node

from heading_intercompare.core.motion.motion_record import leave_out_known
from heading_intercompare.core.pairing.incarnations import Incarnations
from heading_intercompare.core.pairing.ledger import Ledger
from heading_intercompare.core.records import Motion, Pairs
from heading_intercompare.core.sensors.comparison import SensorsComparison
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.judge import RunResult
from heading_intercompare.messages.ledger_messages import LedgerMessage
from heading_intercompare.nodes.judging.trial_journal import TrialJournal
from heading_intercompare.nodes.ros.health import Health
from heading_intercompare.nodes.settings import SensorsNode
from heading_intercompare.nodes.taking.headings_intake import HeadingsIntake

Names = tuple[str, str]

#: Readings that may be half of a pair for longer than this are few.
_LONGEST_GAP_S = 10.0
#: Readings before a stamp from which its heading is interpolated.
_READINGS = 4


@dataclass(frozen=True, slots=True)
class _Taken:
    """All that had been taken up to a newest stamp, and the number of pairs by then."""

    newest_ns: int
    ledgers: Mapping[Names, LedgerMessage]


class PairJournals:
    """
    Keeps the runs in progress of all pairs of a comparison, a journal each, and goes on from them.

    Parameters
    ----------
    node, health
        The node, and its state.
    settings
        With `sensors`.
    own
        Settings `journal`, `report_dir`, `resume_within_s` and `bag`.
    comparison
        Its pairs without the reference go on from their journals.
    headings
        The headings by sensor, before the first is taken. It begins where the journals end.

    Attributes
    ----------
    marks : set of (str, int)
        Marks that took effect before. A pair whose journal lacks one takes it now.

    Notes
    -----
    A ledger is kept with the numbers of the readings that it counts, and its successor takes the
    readings after these again. It makes pairs of them again, which the judgement already has. So a
    ledger is kept only when pairs have been judged so far after it that no later pair needs a
    reading that it counts.

    The ledgers of all pairs are kept at once, but each in its journal. Where the process ended
    before all were written, those that are ahead of the others go back to the one before.

    """

    def __init__(self, node: Node, health: Health, settings: Settings, own: SensorsNode,
                 comparison: SensorsComparison, headings: HeadingsIntake) -> None:
        self._others, self._headings = comparison.others, headings
        self._started_ns, rule = time.time_ns(), settings.pairing
        self._behind_ns = round(min(_READINGS * rule.longest_gap_s, _LONGEST_GAP_S) * 1e9)
        # A sensor that is not there does not hold up the others for ever.
        self._latest_ns = self._behind_ns + round((rule.auto_s + rule.longest_wait_s) * 1e9)
        self._taken: _Taken | None = None
        self._journals = {names: TrialJournal(node, pair.compliance, own, health, '.'.join(names))
                          for names, pair in self._others.items()}
        self.marks = {mark for journal in self._journals.values() for mark in journal.kept.marks}
        self._known_ns = {names: {**journal.kept.motion_ns}
                          for names, journal in self._journals.items()}
        self._before = {names: {**journal.kept.numbers}
                        for names, journal in self._journals.items()}
        self._uncounted = {names for names, journal in self._journals.items()
                           if journal.kept.n_pairs and not journal.kept.ledgers}
        self._go_on()
        for names, pair in self._others.items():
            pair.keep_with(partial(self._keep, names))
            marks = self._journals[names].kept.marks
            for kind, stamp_ns in sorted(self.marks, key=lambda mark: mark[1]):
                if (kind, stamp_ns) in marks:
                    pair.pairer.ledger.cut_run(stamp_ns + 1)
                else:
                    self._journals[names].mark(kind, stamp_ns)
                    pair.mark(kind, stamp_ns)

    def _go_on(self) -> None:
        """Take the headings after the newest ledgers of the process before."""
        self._go_back()
        ends: dict[str, tuple[str, int]] = {}
        for names, journal in self._journals.items():
            for name, end in _ends_of(names, journal.kept.newest).items():
                ends[name] = min(ends.get(name, end), end)
        for name, (publisher, last) in ends.items():
            self._headings.intakes[name].resume_after(publisher, last)

    def _go_back(self) -> None:
        """Let all ledgers be of one time: those ahead of another one go back to that before."""
        left = {*self._journals}
        while ahead := next((names for names in left if self._is_ahead(names)), None):
            left.remove(ahead)
            journal = self._journals[ahead]
            assert journal.kept.before is not None
            journal.book(journal.kept.before)

    def _is_ahead(self, names: Names) -> bool:
        """Tell whether the newest ledger of another pair ends where the ledger before ended."""
        trial = self._journals[names].kept
        newest, before = _ends_of(names, trial.newest), _ends_of(names, trial.before)
        return any(newest.get(name) != end == before.get(name)
                   for others, journal in self._journals.items()
                   for name, end in _ends_of(others, journal.kept.newest).items())

    def _keep(self, names: Names, pairs: Pairs) -> None:
        paired = self._others[names].pairer.ledger.paired if len(pairs) else 0
        self._journals[names].add(pairs, {**self._before[names],
                                          str(self._started_ns): (1, paired, 0)})

    def take_motion(self, motion: Motion) -> None:
        """Keep motion of the ship and hand it on, to each pair what its journal has not."""
        for names, journal in self._journals.items():
            rows = leave_out_known(motion, self._known_ns[names])
            journal.take_motion(rows)
            self._others[names].take_motion(rows)

    def mark(self, kind: str, stamp_ns: int) -> None:
        """Keep a mark, before it takes effect."""
        for journal in self._journals.values():
            journal.mark(kind, stamp_ns)

    def tick(self, clear: bool) -> None:
        """Write what is due; call it after each judgement. `clear` as for `TrialJournal.tick`."""
        for journal in self._journals.values():
            journal.tick(clear)

    def look(self, newest_ns: int | None) -> None:
        """Keep the ledgers, given the newest stamp of any sensor; call it once a second."""
        if newest_ns is None:
            return
        if self._taken is not None:
            if newest_ns <= self._taken.newest_ns + self._latest_ns and not all(
                    self._is_past(names, newest_ns) for names in self._others):
                return
            for names, ledger in self._taken.ledgers.items():
                self._journals[names].book(ledger)
        self._taken = _Taken(newest_ns, {names: self._book(names) for names in self._others})

    def _book(self, names: Names) -> LedgerMessage:
        """Return the ledger of a pair as it is now."""
        ledger, numbers = self._others[names].pairer.ledger, self._headings.numbers
        copy = Ledger.from_segments(ledger.segments, ledger.newest_ns,
                                    ledger.all_set_backs)
        return LedgerMessage(copy, False, self._started_ns, {
            stream: numbers[name] for name, stream in zip(names, ('ts', 'rs'))})

    def _is_past(self, names: Names, newest_ns: int) -> bool:
        """Tell whether no pair to come needs a reading that the ledgers count."""
        assert self._taken is not None
        pair, until_ns = self._others[names], self._taken.newest_ns + self._behind_ns
        if (pair.compliance.newest_ns or 0) >= until_ns:
            return True
        silent = pair.pairer.ledger.paired == self._taken.ledgers[names].ledger.paired
        return silent and not pair.pairer.choosing and newest_ns >= until_ns

    def _sum(self, names: Names) -> Incarnations:
        """Return the ledgers of a pair of all processes, the last one as it is now."""
        incarnations = Incarnations()
        for started_ns, message in sorted(self._journals[names].kept.ledgers.items()):
            if started_ns != self._started_ns:
                incarnations.take(*message)
        numbers = self._headings.numbers
        incarnations.take(self._others[names].pairer.ledger, False, self._started_ns, {
            stream: numbers[name] for name, stream in zip(names, ('ts', 'rs'))})
        return incarnations

    def results(self) -> dict[Names, list[RunResult]]:
        """Return the runs of each pair judged so far, with their shares of all ledgers."""
        return {names: pair.compliance.results(self._sum(names).total)
                for names, pair in self._others.items()}

    def problems(self) -> dict[Names, list[str]]:
        """Return, in plain sentences, what each pair missed."""
        return {names: [*self._problems(names)] for names in self._others}

    def _problems(self, names: Names) -> Iterator[str]:
        yield from self._sum(names).problems('sensors_watch', names)
        if names in self._uncounted:
            yield ('sensors_watch was restarted before its first ledger: the readings up to then, '
                   'and those that came while it was down, are not counted')
        if dropped := self._journals[names].kept.dropped:
            yield (f'{dropped} records of the run in progress could not be kept before '
                   'sensors_watch was started again')

    def close(self) -> None:
        """Remove the journals: the trial is over, and its report is out."""
        for journal in self._journals.values():
            journal.close()


def _ends_of(names: Names, ledger: LedgerMessage | None) -> dict[str, tuple[str, int]]:
    """Return the publisher and the number of the newest reading of each sensor in a ledger."""
    numbers = {} if ledger is None else ledger.numbers
    return {name: (numbers[stream].last_publisher, numbers[stream].last)
            for name, stream in zip(names, ('ts', 'rs')) if stream in numbers}
