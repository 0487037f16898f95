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

"""The account of the pairs that a node judges: the fate of every reading."""

from __future__ import annotations

from typing import Iterator, Protocol

from heading_intercompare.core.pairing.incarnations import Incarnations
from heading_intercompare.core.pairing.ledger import Ledger
from heading_intercompare.core.pairing.pair_maker import PairMaker
from heading_intercompare.core.sensors.pair_names import Names
from heading_intercompare.journal.journal_reading import describe_restarts
from heading_intercompare.messages.ledger_messages import LedgerMessage

from .pair_intake import PairIntake
from .trial_journal import TrialJournal

#: Ledgers of synchronizers whose pairs have not come; more than two at once are rare.
_MOST_WAITING = 16


class Account(Protocol):
    """The ledger of the pairs that a node judges, and what it lacks."""

    @property
    def ledger(self) -> Ledger | None:
        """Return the ledger; None before the first one."""

    @property
    def n_pairs(self) -> int:
        """Return the number of the newest pair that has come."""

    def covers(self, n_pairs: int) -> bool:
        """Tell whether the ledger counts the pairs up to a number."""

    def find_problems(self, complete: bool) -> Iterator[str]:
        """Yield what the ledger does not count, in plain sentences."""


class PairerAccount:
    """The account of a pairer in this process: it counts each reading as it comes."""

    def __init__(self, maker: PairMaker, journal: TrialJournal, names: Names) -> None:
        self._pairer, self._journal, self._names = maker.pairer, journal, names

    @property
    def ledger(self) -> Ledger:
        """Return the ledger of the pairer."""
        return self._pairer.ledger

    @property
    def n_pairs(self) -> int:
        """Return the number of pairs so far."""
        return self._pairer.ledger.paired

    def covers(self, n_pairs: int) -> bool:
        """Return True: a pair is counted when it is made."""
        return True

    def find_problems(self, complete: bool) -> Iterator[str]:
        """Yield what a restart cost whose readings have no numbers."""
        return describe_restarts(self._journal.kept, self._names)


class HeardAccount:
    """
    The account of pairs that come from another process, whose ledger comes once a second.

    Parameters
    ----------
    pairs
        The pairs, whose numbers say what is missing.
    journal
        Keeps the ledgers, and may hold those of an earlier process.

    """

    def __init__(self, pairs: PairIntake, journal: TrialJournal) -> None:
        self._pairs, self._journal, self._ledgers = pairs, journal, Incarnations()
        self._waiting: dict[int, LedgerMessage] = {}
        for message in journal.kept.ledgers.values():
            self._take(message)

    def book(self, newest: LedgerMessage) -> None:
        """Take the newest ledger of a synchronizer, once its pairs come."""
        self._waiting[newest.started_ns] = newest
        self.look()

    def look(self) -> None:
        """Take the ledgers that have come of synchronizers whose pairs have come."""
        heard = self._pairs.first_segments or [*self._waiting][:1]
        for started_ns in [*self._waiting]:
            if started_ns in heard:
                message = self._waiting.pop(started_ns)
                self._take(message)
                self._journal.book(message)
        while len(self._waiting) > _MOST_WAITING:
            del self._waiting[min(self._waiting)]

    def _take(self, message: LedgerMessage) -> None:
        self._ledgers.take(*message, first_segment=self._pairs.first_segments.get(
            message.started_ns))

    @property
    def ledger(self) -> Ledger | None:
        """Return the ledgers of all starts of the synchronizer, added up."""
        return self._ledgers.total

    @property
    def n_pairs(self) -> int:
        """Return the number that the synchronizer gave to the newest pair."""
        return self._pairs.last_sequence

    @property
    def is_complete(self) -> bool:
        """Whether the last ledger has come, and all pairs that it counts."""
        return self._ledgers.final and self._pairs.last_sequence >= self._ledgers.paired

    def covers(self, n_pairs: int) -> bool:
        """Tell whether the newest ledger counts the pairs up to a number."""
        return self._ledgers.paired >= n_pairs

    def find_problems(self, complete: bool) -> Iterator[str]:
        """Yield what the ledger does not count, in plain sentences."""
        pairs = self._pairs
        yield from self._ledgers.problems()
        if pairs.before:
            yield f'{pairs.before} pairs were published before this node started'
        if pairs.lost:
            yield f'{pairs.lost} pairs were lost on the way to this node'
        if pairs.missed:
            yield f'{pairs.missed} pairs were published while this node was down'
        if pairs.left_out:
            yield f'{pairs.left_out} pairs of another synchronizer were left out'
        missing = self._ledgers.paired - pairs.last_sequence
        if not complete and self._ledgers.final and missing > 0:
            yield f'the last {missing} pairs did not come to this node'
        elif not complete:
            yield 'the ledger that covers the last pairs did not come'
