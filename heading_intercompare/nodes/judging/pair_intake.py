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

from dataclasses import replace
from itertools import groupby
from typing import Mapping, NamedTuple, Sequence

import numpy as np
from rclpy.node import Node

from heading_intercompare.bags.rosbag2.sequence_gaps import Numbering
from heading_intercompare.core.pairing.names import Span
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.settings import Pairing
from heading_intercompare.messages.heading_messages import read_pairs
from heading_intercompare.messages.stamps import header_frame
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.interface.message_types import PAIRS_TYPES
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.settings import Taking
from heading_intercompare.nodes.spinning.batches import Unwatched
from heading_intercompare.nodes.taking.intake import Intake
from heading_intercompare.nodes.taking.reception import Message

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
    node, topic, health
        As for `Intake`.
    taking
        Settings.
    pairing
        Says when the first pair can come.
    arrivals
        As for `Intake`.

    Attributes
    ----------
    started_ns : int or None
        When the synchronizer that is followed was started, UTC ns; None before its first pair.
    left_out : int
        Pairs of other synchronizers that were not taken.
    missed : int
        Pairs that were published while this node was down.
    first_segments : dict of int to int
        Number of the first clock segment of each synchronizer, by its start.

    Notes
    -----
    The frame of a pair names the start of its synchronizer. The one that was started last is
    followed. Its pairs begin a clock segment: what the one before still held is not known to it.

    """

    def __init__(self, node: Node, topic: str, health: Health, taking: Taking, pairing: Pairing,
                 arrivals: Unwatched | None = None) -> None:
        # The first pairs come, all at once, when the synchronizer has chosen the method.
        choice_s = pairing.auto_s if pairing.method == 'auto' else 0.0
        super().__init__(node, topic, PAIRS_TYPES, qos.PAIRS, health, stale_s=taking.stale_s,
                         first_wait_s=taking.first_wait_s + choice_s,
                         lost_shown_s=taking.lost_shown_s, counted=False, arrivals=arrivals)
        self._numbers: dict[str, Numbering] = {}
        self._resuming: dict[str, int] = {}
        self._newest = _Frame(0, 0)
        self._read_ns = 0
        self.started_ns: int | None = None
        self.first_segments: dict[int, int] = {}
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
            frame = _read_frame(batch[0])
            if frame.started_ns not in self.first_segments:
                self.first_segments[frame.started_ns] = (
                    self.first_segments[self._newest.started_ns] + self._newest.segment + 1
                    if self.first_segments else 0)
            self._newest = frame
            pairs, troubles = read_pairs(batch)
            problems += troubles
            parts.append(replace(pairs, segment=np.full(
                len(pairs), self.first_segments[frame.started_ns] + frame.segment)))
        return Pairs.concatenate(parts), problems

    def take(self) -> list[Message]:
        """Return the pairs of the followed synchronizer since the last call."""
        pairs: list[Message] = []
        followed = self.last_sequence
        messages = super().take()
        # The numbers of pairs that are left out say nothing of those of the followed one.
        self.last_sequence = followed
        for _, several in groupby(messages, key=lambda pair: pair[0][_NAME]):
            batch = [*several]
            started_ns, _ = _read_frame(batch[0][0])
            if self.started_ns is not None and started_ns < self.started_ns:
                self.left_out += len(batch)
                continue
            self.started_ns = started_ns
            pairs += self._accept(str(started_ns), batch)
        return pairs

    def _accept(self, name: str, batch: list[Message]) -> list[Message]:
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
        return batch

    @property
    def numbers_by_name(self) -> dict[str, tuple[int, int, int, int]]:
        """
        Return what is known of the pairs of each synchronizer, by the name of its start.

        First number, newest one, how many are missing, and the number of its first clock segment.
        """
        return {name: (*numbering.summary, self.first_segments.get(int(name), 0))
                for name, numbering in self._numbers.items()}

    def go_on(self, numbers: Mapping[str, tuple[int, int, int, int]], newest_ns: int | None,
              segment: int) -> None:
        """
        Go on after the pairs that an earlier process has taken.

        Parameters
        ----------
        numbers
            Its `numbers_by_name`.
        newest_ns
            Stamp of its newest pair; None if it had none.
        segment
            Number of the clock segment of that pair.

        """
        for name, (first, last, missing, first_segment) in numbers.items():
            started_ns = int(name)
            self._numbers[name] = Numbering.go_on([Span('', first, last)], missing)
            self._resuming[name] = last
            self.first_segments[started_ns] = first_segment
            if self.started_ns is None or started_ns > self.started_ns:
                self.started_ns, self.last_sequence = started_ns, last
                self._newest = _Frame(started_ns, segment - first_segment)
        self._read_ns = newest_ns or 0
        self.look()

    @property
    def lost(self) -> int:
        """Pairs lost on the way, by the numbers of their synchronizers."""
        return sum(numbering.missing for numbering in self._numbers.values()) - self.missed

    @property
    def before(self) -> int:
        """Pairs that a synchronizer had published before the first one that was taken."""
        return sum(max(0, (numbering.first or 1) - 1) for numbering in self._numbers.values())
