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

"""The headings of any number of streams, each topic heard once, with what was lost of them."""

from __future__ import annotations

from functools import partial
from typing import Callable, Mapping

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from heading_intercompare.bags.recording.cut_bag import LastMessages
from heading_intercompare.core.pairing.incarnations import StreamNumbers
from heading_intercompare.core.records import Headings, Losses
from heading_intercompare.journal.reading_batches import LastHeard
from heading_intercompare.messages.heading_places import locate_headings
from heading_intercompare.messages.ledger_messages import decode_losses, lost_topic
from heading_intercompare.messages.status_messages import OK, WARN
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.interface.message_types import list_heading_types
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.settings import Taking
from heading_intercompare.nodes.spinning.batches import Unwatched

from .intake import Intake
from .raw_subscription import subscribe
from .topic_headings import TopicHeadings


class HeadingsIntake:
    """
    Takes the headings of several streams.

    Parameters
    ----------
    node, health, taking
        As for `Intake`.
    streams : mapping of str to (str, str, str or None)
        Place (`locate_headings`), convention and known type of each stream, by its name.
    lose
        Called with the name of a stream, the fate of some readings (`LOST_AS`), and how many there
        are: lost on the way, and those that a driver says it never published.
    arrivals
        As for `Intake`.
    unit_of
        Returns the unit that is stated for a place, 'auto' if none.

    Attributes
    ----------
    intakes : dict of str to Intake
        The input of each stream.

    """

    def __init__(self, node: Node, health: Health, taking: Taking,
                 streams: Mapping[str, tuple[str, str, str | None]],
                 lose: Callable[[str, str, Losses], None],
                 arrivals: Unwatched | None = None,
                 unit_of: Callable[[str], str] = lambda topic: 'auto') -> None:
        self._lose_some = lose
        places = {name: locate_headings(topic, unit_of(topic))
                  for name, (topic, _, _) in streams.items()}
        self._node, self._health, self._remarks = node, health, dict.fromkeys(streams, '')
        self._absent: set[str] = set()
        self._readers = {name: TopicHeadings(places[name], convention)
                         for name, (_, convention, _) in streams.items()}
        self.intakes = {name: Intake(
            node, places[name].topic, list_heading_types(places[name]), qos.HEADINGS_IN, health,
            unreliable=qos.HEADINGS_UNRELIABLE, kept=qos.HEADINGS_KEPT, stale_s=taking.stale_s,
            first_wait_s=taking.first_wait_s, lost_shown_s=taking.lost_shown_s, place=places[name],
            known_type=kind, arrivals=arrivals)
            for name, (_, _, kind) in streams.items()}
        health.add_refresher(self._note)
        for name, intake in self.intakes.items():
            subscribe(node, DiagnosticArray, lost_topic(intake.full_name), qos.LOST, health,
                      decode_losses, partial(self._lose, name))

    def hold(self) -> None:
        """Take what has come, so that the subscriptions have room, and return it later."""
        for intake in self.intakes.values():
            intake.hold()

    def take(self, *, last: bool = False) -> dict[str, Headings]:
        """Return the readings since the last call, by stream; `last` says that none follow."""
        for intake in self.intakes.values() if last else ():
            intake.bring_back()
        headings = {name: intake.read_messages(self._readers[name].read)
                    for name, intake in self.intakes.items()}
        if last:
            headings = {name: rows + self._readers[name].flush()
                        for name, rows in headings.items()}
        self._log_remarks()
        for name, intake in self.intakes.items():
            self._lose(name, {'lost.on_the_way': intake.take_losses(),
                              'lost.before_start': intake.take_before()})
        return headings

    def _log_remarks(self) -> None:
        """Say once what is assumed of the headings of a stream, as a note of a bag does."""
        for name, reader in self._readers.items():
            if reader.remark != self._remarks[name]:
                self._remarks[name] = reader.remark
                self._node.get_logger().warning(f'{name}: {reader.remark}')

    def _lose(self, name: str, found: Mapping[str, Losses]) -> None:
        for lost_as, losses in found.items():
            self._lose_some(name, lost_as, losses)

    @property
    def received_ns(self) -> dict[str, int]:
        """When the newest message of each stream arrived, UTC ns; without those never heard."""
        return {name: intake.received_ns for name, intake in self.intakes.items()
                if intake.received_ns is not None}

    def go_on(self, heard: Mapping[str, LastHeard], since_ns: int) -> None:
        """Go on after the readings that an earlier process took, which began at a time, UTC ns."""
        for name, intake in self.intakes.items():
            last = heard.get(name)
            if last is None or not last.numbers.last:
                intake.go_on_after(LastMessages((), since_ns))
            else:
                intake.go_on_after(LastMessages(((last.numbers.last, last.sent_ns),), since_ns,
                                                last.numbers.last_publisher), last.numbers.spans)

    @property
    def last_heard(self) -> dict[str, LastHeard]:
        """Return the numbers of the readings so far, and when the newest was sent, by stream."""
        return {name: LastHeard(intake.numbers, intake.sent_ns)
                for name, intake in self.intakes.items()}

    @property
    def numbers(self) -> dict[str, StreamNumbers]:
        """Return the numbers of the readings taken so far, by stream."""
        return {name: intake.numbers for name, intake in self.intakes.items()}

    def count_publishers(self) -> int:
        """Look at all topics; return the number of their publishers."""
        for intake in self.intakes.values():
            intake.look()
        return sum(intake.publishers for intake in self.intakes.values())

    def _note(self) -> None:
        """Report the sentences that gave no heading of a stream, and frames that never came."""
        for name, reader in self._readers.items():
            if reader.absence or name in self._absent:
                self._absent.add(name)
                self._health.note(f'{name} frames', WARN if reader.absence else OK,
                                  reader.absence or 'receiving')
            if reader.counts is not None:
                self._health.note(f'{name} sentences', OK, reader.sentence or 'listening',
                                  figures=reader.counts)
