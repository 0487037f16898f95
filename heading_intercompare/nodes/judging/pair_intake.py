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

"""The pairs of one synchronizer at a time, even if several publish on the topic."""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from itertools import groupby
import time
from typing import Mapping, NamedTuple, Sequence

import numpy as np
from rclpy.node import Node

from heading_intercompare.bags.rosbag2.sequence_gaps import Numbering
from heading_intercompare.core.pairing.incarnations import IncarnationChoice
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.settings import Pairing
from heading_intercompare.messages.heading_messages import read_pairs
from heading_intercompare.messages.ledger_messages import LedgerMessage
from heading_intercompare.messages.stamps import header_frame, header_stamp_ns
from heading_intercompare.nodes.ros import qos
from heading_intercompare.nodes.ros.batches import Unwatched
from heading_intercompare.nodes.ros.health import Health
from heading_intercompare.nodes.ros.message_types import PAIRS_TYPES
from heading_intercompare.nodes.settings import Taking
from heading_intercompare.nodes.taking.intake import Intake

_Taken = list[tuple[bytes, Mapping[str, int]]]

#: Pairs of another synchronizer that wait until it is known whether the followed one still lives.
_MOST_HELD = 20_000
#: Length and first characters of the frame, which name the start of the synchronizer.
_NAME = slice(12, 40)


class _Frame(NamedTuple):
    """The start of a synchronizer, UTC ns, and the number of the clock segment of a pair."""

    started_ns: int
    segment: int


def _read_frame(data: bytes) -> _Frame:
    """Return what the frame of a pair says; 0 where another program published it."""
    name, _, segment = header_frame(data).partition('/')
    return _Frame(int(name) if name.isdecimal() else 0,
                  int(segment) if segment.isdecimal() else 0)


class PairIntake(Intake):
    """
    The pairs of one synchronizer at a time, as bytes.

    Parameters
    ----------
    node, health
        As for `Intake`.
    taking
        Settings.
    pairing
        Says when the first pair can come.
    arrivals
        As for `Intake`.

    Attributes
    ----------
    left_out : int
        Pairs of other synchronizers that were not taken.
    missed : int
        Pairs that were published while this node was down.

    Notes
    -----
    The frame of a pair names the start of its synchronizer. Pairs of another one than is followed
    are held until the followed one has ended or is silent; see `IncarnationChoice`. So nothing is
    lost when the synchronizer is started again, and nothing is mixed when there are two.

    """

    def __init__(self, node: Node, health: Health, taking: Taking, pairing: Pairing,
                 arrivals: Unwatched | None = None) -> None:
        # The first pairs come, all at once, when the synchronizer has chosen the method.
        choice_s = pairing.auto_s if pairing.method == 'auto' else 0.0
        super().__init__(node, 'pairs', PAIRS_TYPES, qos.PAIRS, health, stale_s=taking.stale_s,
                         first_wait_s=taking.first_wait_s + choice_s,
                         lost_shown_s=taking.lost_shown_s, counted=False, arrivals=arrivals)
        self._choice = IncarnationChoice()
        self._held: dict[int, deque[tuple[bytes, Mapping[str, int]]]] = {}
        self._ledgers: dict[int, LedgerMessage] = {}
        self._numbers: dict[str, Numbering] = {}
        self._newest_ns = self._read_ns = 0
        self._resuming: dict[str, int] = {}
        self._behind = False
        self._taken: deque[bytes] = deque(maxlen=_MOST_HELD)
        self._segment_of, self._first_segment = _Frame(0, 0), 0
        self.left_out = self.missed = 0

    def read(self) -> Pairs:
        """
        Return the pairs since the last call.

        What cannot be read is refused, and pairs with the stamp of the pair before.
        """
        pairs = self.read_rows(self._read_segments)
        new = np.diff(pairs.stamp_ns, prepend=self._read_ns) != 0
        if not new.all():
            # A synchronizer makes no such pair; another node may.
            self.refuse([f'the stamp {stamp_ns} ns is that of the pair before'
                         for stamp_ns in pairs.stamp_ns[~new].tolist()])
            pairs = pairs[new]
        if len(pairs):
            self._read_ns = int(pairs.stamp_ns[-1])
        return pairs

    def _read_segments(self, _: str, messages: Sequence[bytes]) -> tuple[Pairs, list[str]]:
        """Return the pairs in messages, whose frames say in which clock segment each is."""
        parts, problems = [Pairs.empty()], []
        for _, several in groupby(messages, key=lambda data: data[_NAME]):
            batch = [*several]
            number = _read_frame(batch[0])
            if number.started_ns != self._segment_of.started_ns:
                # Another synchronizer counts from 0.
                before = self._segment_of.segment
                self._first_segment += before + 1 if before else 0
            self._segment_of = number
            pairs, troubles = read_pairs(batch)
            problems += troubles
            parts.append(replace(pairs, segment=np.full(
                len(pairs), self._first_segment + number.segment)))
        return Pairs.concatenate(parts), problems

    def take(self) -> _Taken:
        """Return the pairs of the followed synchronizer since the last call."""
        now_s, pairs = time.monotonic(), []
        followed = self.last_sequence
        messages = super().take()
        # The numbers of pairs that are held say nothing of those of the followed synchronizer.
        self.last_sequence = followed
        for _, several in groupby(messages, key=lambda pair: pair[0][_NAME]):
            batch = list(several)
            started_ns, _ = _read_frame(batch[0][0])
            self._choice.hear(started_ns, now_s)
            if started_ns == self._choice.current:
                pairs += self._accept(str(started_ns), batch)
            else:
                self._hold(started_ns, batch)
        before, current = self._choice.current, self._choice.look(now_s)
        if current != before and current is not None:
            # The successor pairs again what its ledger of the one before does not count.
            self._behind = True
            self.last_sequence = 0
            pairs += self._accept(str(current), [*self._held.pop(current, deque())])
        return pairs

    def _accept(self, name: str, batch: _Taken) -> _Taken:
        after = self._resuming.get(name)
        if after is not None:
            # A publisher sends its last messages again to a new subscription.
            batch = [pair for pair in batch if pair[1]['publication_sequence_number'] > after]
        if batch:
            numbers = [info['publication_sequence_number'] for _, info in batch]
            numbering = self._numbers.setdefault(name, Numbering())
            before = numbering.missing
            numbering.take(numbers)
            if self._resuming.pop(name, None) is not None:
                self.missed += numbering.missing - before
            self.last_sequence = numbers[-1]
            if self._behind:
                batch = self._leave_out(batch)
        if batch:
            self._newest_ns = header_stamp_ns(batch[-1][0])
            self._taken += [data for data, _ in batch]
        return batch

    def _leave_out(self, batch: _Taken) -> _Taken:
        """Leave out the pairs that the synchronizer before has published."""
        stamps = [header_stamp_ns(data) for data, _ in batch]
        fresh = [pair for pair, stamp_ns in zip(batch, stamps) if stamp_ns > self._newest_ns]
        if len(fresh) < len(batch):
            taken_ns = {header_stamp_ns(data) for data in self._taken}
            self.left_out += sum(stamp_ns <= self._newest_ns and stamp_ns not in taken_ns
                                 for stamp_ns in stamps)
        self._behind = not fresh
        return fresh

    @property
    def numbers_by_name(self) -> dict[str, tuple[int, int, int]]:
        """First, newest and number of missing ones among the numbers, by synchronizer."""
        return {name: numbering.summary for name, numbering in self._numbers.items()}

    def go_on(self, numbers: Mapping[str, tuple[int, int, int]], newest_ns: int | None) -> None:
        """Go on after the pairs that an earlier process has taken, given its `numbers_by_name`."""
        for name, summary in numbers.items():
            self._numbers[name] = Numbering.go_on(*summary)
            self._resuming[name] = self.last_sequence = summary[1]
            self._choice.follow(int(name), time.monotonic())
        self._newest_ns = self._read_ns = newest_ns or 0
        self.look()

    def _hold(self, started_ns: int, batch: _Taken) -> None:
        held = self._held.setdefault(started_ns, deque(maxlen=_MOST_HELD))
        self.left_out += max(0, len(held) + len(batch) - _MOST_HELD)
        held += batch

    def follow(self, newest: LedgerMessage) -> list[LedgerMessage]:
        """Take a ledger; return those of the followed synchronizer that have come by now."""
        self._choice.hear(newest.started_ns, time.monotonic(), newest.final)
        self._ledgers[newest.started_ns] = newest
        return self.ledgers()

    def ledgers(self) -> list[LedgerMessage]:
        """Return the newest ledger of the followed synchronizer if it has not been returned."""
        current = self._choice.current
        return [self._ledgers.pop(current)] if current in self._ledgers else []

    @property
    def waiting(self) -> bool:
        """Whether another synchronizer was heard that may yet be followed."""
        return bool(self._choice.list_others(time.monotonic()))

    @property
    def lost(self) -> int:
        """Pairs lost on the way, by the numbers of their synchronizers."""
        return sum(numbering.missing for numbering in self._numbers.values()) - self.missed

    @property
    def before(self) -> int:
        """Pairs that a synchronizer had published before the first one that was taken."""
        return sum(max(0, (numbering.first or 1) - 1) for numbering in self._numbers.values())
