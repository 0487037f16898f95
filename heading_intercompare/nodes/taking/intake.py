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

"""The messages of one topic: take them in batches, count losses, watch publishers."""

from __future__ import annotations

from functools import partial
import math
import time
from typing import Callable, Mapping, Sequence, TypeVar

from rclpy.node import Node
from rclpy.qos import (
    DurabilityPolicy,
    qos_check_compatible,
    QoSCompatibility,
    QoSProfile,
    ReliabilityPolicy,
)
from rclpy.topic_endpoint_info import TopicEndpointInfo

from heading_intercompare.bags.recording.cut_bag import LastMessages
from heading_intercompare.bags.rosbag2.publisher_starts import PublisherStart
from heading_intercompare.bags.rosbag2.sequence_gaps import Numbering
from heading_intercompare.core.alarms.graph_watch import (
    LOST_ON_THE_WAY,
    MISMATCH,
    TWO_PUBLISHERS,
)
from heading_intercompare.core.pairing.incarnations import StreamNumbers
from heading_intercompare.core.pairing.names import Span
from heading_intercompare.core.records import Losses
from heading_intercompare.core.statistics.recent_count import RecentCount
from heading_intercompare.messages.heading_places import HeadingPlace
from heading_intercompare.messages.stamps import header_stamp_ns
from heading_intercompare.messages.status_messages import ERROR, OK, WARN
from heading_intercompare.nodes.interface import qos as profiles
from heading_intercompare.nodes.interface.message_types import (
    begins_with_header,
    explain_absence,
    find_heading_type,
)
from heading_intercompare.nodes.interface.parameters import follow, resolve_topic
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.presence.rivals import Rivals
from heading_intercompare.nodes.presence.transports import DISCOVERY_S
from heading_intercompare.nodes.settings import Taking
from heading_intercompare.nodes.spinning.batches import Unwatched

from .publisher_names import PublisherNames
from .reception import Message, number_of, Reception, Renewal

_Chunk = TypeVar('_Chunk')

#: A launch file ends a graph within this time after a player has ended.
_GONE_S = 5.0
#: How long messages lost on the way are an alarm.
_LOSING_S = 10.0
#: No process ends, and begins to publish again, in less.
_RESTART_NS = 300_000_000
#: All that publishers keep was sent after this time.
_EVER_NS = 1


class Intake:
    """
    The messages of one topic, as bytes.

    Parameters
    ----------
    node
        The node that takes the messages.
    topic
        Relative or absolute name.
    types
        Accepted message types, by name; the publisher's decides.
    qos
        Quality of service of the subscription.
    unreliable
        The same where a publisher is best effort, which a reliable subscription does not hear.
    kept
        The same once a first message has come, where the publishers keep their newest messages:
        what they send while they cannot be reached comes later.
    health
        Shows the state of this input.
    stale_s
        Silence after which the state is a warning, seconds.
    first_wait_s
        How long after its start nothing is wrong with an input that was never heard, seconds.
    lost_shown_s
        How long messages lost or refused are a warning, seconds.
    sole
        More than one publisher is an error.
    needed
        A missing publisher is a warning.
    place
        What the messages hold of a heading, if they do; then `take_losses` says where some are
        missing. Any number of nodes may publish transforms, so of these none are counted.
    counted
        Count what is missing; not where any number of publishers may come and go.
    whole
        Begin with what the publishers keep from before, if all of them keep their newest messages.
    known_type
        The type, where it is known before a publisher is seen. Then the subscription is made at
        the start, as one that hears publishers of any quality of service.
    arrivals
        Callback group of the subscription, for which the executor wakes; by default it does not.

    Attributes
    ----------
    full_name : str
        Full name of the topic in the graph.
    type_name : str or None
        Type of the subscription; None while there is none.
    received, last_sequence : int
        Number of messages taken; number that the publisher gave the newest.
    received_ns, sent_ns
        When the newest message arrived, None before the first, and when it was sent, UTC ns.
    refused : int
        Messages that could not be read.
    publishers : int
        Publishers seen at the last `look`.
    resubscribed : int
        How often the subscription was made again for a publisher that joined and offers less.
    counted
        Messages that are missing are counted.
    open : bool
        Subscribe when a publisher is seen. While this is False, no subscription is made.

    Notes
    -----
    The subscription is made when a publisher is seen, with the type of that publisher. So it knows
    the publisher before the publisher knows it. A publisher that waits for its subscription then
    loses no message, even if the subscription is best effort.

    A publisher that waits for nobody has sent messages by then. If it came when this node already
    looked for publishers, and keeps its newest messages, the subscription begins with all that it
    keeps. Of other ones `take_before` counts what came too early, unless the type is known: then a
    best-effort subscription waits for them, and one as good as the publisher takes over.

    A subscription is as reliable as its publishers. When a best-effort publisher joins reliable
    ones, it is made again; what they publish in between is counted as lost. It stays best effort
    until all publishers are gone.

    DDS gives up a publisher that it cannot reach for 20 s. A subscription that is `kept` gets what
    this publisher sent in the meantime when it is back. Before the first message, this is all that
    it sent since the subscription was made.

    """

    def __init__(self, node: Node, topic: str, types: Mapping[str, type], qos: QoSProfile,
                 health: Health, *, unreliable: QoSProfile | None = None,
                 kept: QoSProfile | None = None,
                 stale_s: float | None = None, first_wait_s: float = 0.0,
                 lost_shown_s: float = 600.0, sole: bool = True, needed: bool = True,
                 place: HeadingPlace | None = None, counted: bool = True, whole: bool = False,
                 known_type: str | None = None,
                 arrivals: Unwatched | None = None) -> None:
        self._node, self._topic, self._types = node, topic, types
        self._reliable, self._unreliable, self._kept, self._qos = qos, unreliable, kept, qos
        self._health, self._stale_s, self._sole, self._needed = health, stale_s, sole, needed
        self.full_name = resolve_topic(node, topic)
        self._reception = Reception(node, topic, arrivals or Unwatched(), whole=whole)
        self._renewal = Renewal()
        self._newest_s = time.monotonic()
        self._first_wait_s, self._begun_s = first_wait_s, self._newest_s
        # When a publisher was seen first since there was none, and last.
        self._come_s = self._there_s = -math.inf
        self._beat_s, self._beat_n, self._latency_s = self._newest_s, 0, 0.0
        self.type_name = self._known_type = known_type
        if known_type is not None and known_type not in types:
            find_heading_type(known_type)  # This says what is wrong with it.
        self._waits = False
        self._there_before: set[str] = set()
        self.open = True
        self.received = self.last_sequence = self.refused = self.publishers = self.sent_ns = 0
        self.resubscribed = 0
        self.received_ns: int | None = None
        self._why_refused = ''
        self._numbering, self._place, self.counted = Numbering(), place, counted
        if place is not None and place.names_frames:
            self._sole = self.counted = False
            self._kept = None
        self._losses: list[Losses] = []
        self._publishers = '', ''
        self._names, self._looked_n = PublisherNames(self._list_gids), 0
        self._resumed: str | None = None
        self._recent = RecentCount(lost_shown_s), RecentCount(lost_shown_s)
        self._losing, self._alarm = RecentCount(_LOSING_S), ''
        self._rivals = Rivals(topic)
        self._whole = whole
        self._opened_ns = self._since_ns = 0
        health.add_refresher(self._note)
        if stale_s is not None:
            follow(node, 'stale_s', partial(setattr, self, '_stale_s'))

    def bring_back(self) -> None:
        """Take what a subscription held that was set aside; call it before the last `take`."""
        self._reception.bring_back()

    def hold(self) -> None:
        """Take what has come, so that the subscription has room, and return it later."""
        self._reception.hold()

    def take(self) -> list[Message]:
        """Return the messages since the last call, each with its info."""
        self._notice_standstill()
        if self._waits or not self._reception.there:
            self.look()
        messages = self._reception.take()
        if messages:
            numbers = [number_of(message) for message in messages]
            self._names.begin(self.received_ns)
            begins = [0] * self._may_be_replaced(messages[0])
            if self._place is not None and self.counted:
                stamps = self.read_stamps(messages)
                self._losses.append(self._numbering.take(numbers, stamps, self._names.find_new,
                                                         begins))
                self._note_resumed(numbers[0], stamps[0])
            elif self.counted:
                self._numbering.take(numbers, find_new=self._names.find_new, begins=begins)
            self.last_sequence = numbers[-1] * self.counted
            self.received += len(messages)
            info = messages[-1][1]
            self.sent_ns = info['source_timestamp']
            self._newest_s, self.received_ns = time.monotonic(), info['received_timestamp']
            self._latency_s = (info['received_timestamp'] - info['source_timestamp']) / 1e9
        return messages

    def read_stamps(self, messages: Sequence[Message]) -> list[int]:
        """Return the stamps of readings in messages: those of their headers, or when sent, ns."""
        is_sent = self._place is not None and self._place.clock
        if is_sent or not begins_with_header(self._types[self.type_name or '']):
            return [info['source_timestamp'] for _, info in messages]
        return [header_stamp_ns(data) for data, _ in messages]

    def _may_be_replaced(self, message: Message) -> bool:
        """Tell whether a message is another publisher's, even if its number follows the last."""
        return bool(self._numbering.publisher
                    and message[1]['source_timestamp'] > self.sent_ns + _RESTART_NS
                    and self._names.are_all_new())

    def read_rows(self, read: Callable[[str, Sequence[bytes]], tuple[_Chunk, Sequence[str]]]
                  ) -> _Chunk:
        """
        Return the rows in the messages since the last call, and count the unreadable messages.

        Parameters
        ----------
        read
            Returns the rows, and what is wrong with others, of messages of a type.

        """
        return self.read_messages(
            lambda type_name, messages: read(type_name, [data for data, _ in messages]))

    def read_messages(self, read: Callable[[str, Sequence[Message]],
                                           tuple[_Chunk, Sequence[str]]]) -> _Chunk:
        """Return rows as `read_rows`, read from messages with their infos."""
        # The type may be known with the first messages only.
        messages = self.take()
        rows, problems = read(self.type_name or '', messages)
        self.refuse(problems)
        return rows

    def go_on_after(self, last: LastMessages, spans: Sequence[Span] = ()) -> None:
        """
        Go on after the last messages that an earlier process took, if any are kept.

        Parameters
        ----------
        last
            The last ones.
        spans
            From which number to which one each publisher was heard; by default, that of the last
            messages from its first number on.

        """
        profile = self._kept or self._reliable
        if profile.durability != DurabilityPolicy.TRANSIENT_LOCAL:
            return
        self._whole = True
        self._reception.go_on(last)
        self._resumed = last.publisher
        if last.names:
            self.last_sequence, self.sent_ns = last.names[-1]
            spans = spans or [Span(last.publisher, 1, self.last_sequence)]
            self._numbering = Numbering.go_on(spans)
            self._names.go_on([last.publisher, *(span.publisher for span in spans)])

    def _note_resumed(self, number: int, stamp_ns: int) -> None:
        """Note whose the first message is after those that an earlier process recorded."""
        if self._resumed is None:
            return
        publisher, self._resumed = self._resumed, None
        if not self._names.starts and publisher:
            self._names.starts.append(PublisherStart(publisher, number, stamp_ns))

    def take_starts(self) -> list[PublisherStart]:
        """Return the first messages of publishers heard since the last call."""
        starts, self._names.starts = self._names.starts, []
        return starts

    def take_losses(self) -> Losses:
        """Return the gaps among the messages taken since the last call, at their stamps."""
        losses, self._losses = Losses.concatenate(self._losses), []
        return losses

    def take_before(self) -> Losses:
        """Return, once, what the publisher sent before the first message that was taken."""
        return self._numbering.take_before()

    def refuse(self, problems: Sequence[str]) -> None:
        """Count messages that could not be read, given what is wrong with each."""
        if problems:
            self.refused += len(problems)
            self._why_refused = problems[-1]

    @property
    def subscribed(self) -> bool:
        """Whether there is a subscription."""
        return self._reception.there

    @property
    def lost(self) -> int:
        """Messages lost on the way, by their publishers' sequence numbers."""
        return self._numbering.missing

    @property
    def _fetchable(self) -> int:
        """Messages missing that the publishers may still have."""
        stored = self._qos.durability == DurabilityPolicy.TRANSIENT_LOCAL
        return self.lost if stored else 0

    @property
    def numbers(self) -> StreamNumbers:
        """Return the first and the newest number taken, and the publishers that gave them."""
        spans = self._numbering.spans
        first, last = self._publishers
        first = spans[0].publisher or first if spans else first
        return StreamNumbers(first, self._numbering.first or 0,
                             self._numbering.publisher or last, self.last_sequence, spans)

    @property
    def before(self) -> int:
        """Messages that the first publisher had sent before the first one that was taken."""
        return max(0, (self._numbering.first or 1) - 1)

    def look(self) -> str:
        """Look for publishers and subscribe to their type; return what is wrong, '' if nothing."""
        self._rivals.is_ghost, self._alarm = False, ''
        self.publishers = self._node.count_publishers(self.full_name)
        if self.publishers < 2:
            self._rivals.look(())
        if not self.publishers:
            self._await_publisher()
            return ''
        now_s = time.monotonic()
        if now_s > self._there_s + _GONE_S:
            self._come_s = now_s
        self._there_s = now_s
        infos = self._node.get_publishers_info_by_topic(self.full_name)
        offered_types = {info.topic_type for info in infos}
        good = [name for name in (*self._types, *sorted(offered_types))
                if name in offered_types and name in self._types]
        self._change_qos(infos, self._have_come(infos))
        suitable = [name for name in good if self.type_name in (None, name)]
        if self.open and suitable and not self._reception.there:
            self.type_name = suitable[0]
            self._opened_ns = self._opened_ns or time.time_ns()
            stored = self._qos is self._kept
            self._reception.open(self._types[suitable[0]], self._qos, self._since_ns * stored)
        strange = sorted(offered_types - {self.type_name} - set(() if self.type_name else good))
        if strange:
            self._alarm = MISMATCH
            if absence := '' if self.type_name else explain_absence(strange, self._types):
                return f'{self._topic}: {absence}'
            return (f'{self._topic} has the type {", ".join(strange)}; must be '
                    f'{self.type_name or " or ".join(self._types)}')
        return self._describe_mismatch(infos) or (
            self._describe_rivals(infos) if self._sole else '')

    def _have_come(self, infos: Sequence[TopicEndpointInfo]) -> bool:
        """Note who publishes; tell whether all came when this node already looked for them."""
        gids = _name_gids(infos)
        self._names.look(gids)
        self._numbering.name_newest(self._names.find_alone(self.received > self._looked_n))
        self._looked_n = self.received
        newest = gids[0] if len(gids) == 1 else ''
        self._publishers = self._publishers[0] or newest, newest
        if time.monotonic() < self._begun_s + DISCOVERY_S:
            self._there_before.update(gids)
        return not self._there_before.intersection(gids)

    def _list_gids(self) -> list[str]:
        return _name_gids(self._node.get_publishers_info_by_topic(self.full_name))

    def _describe_mismatch(self, infos: Sequence[TopicEndpointInfo]) -> str:
        """Say which publisher offers less than the subscription needs; '' if none does."""
        for info in infos:
            verdict, reason = qos_check_compatible(info.qos_profile, self._qos)
            if verdict == QoSCompatibility.ERROR:
                self._alarm = MISMATCH
                return f'QoS mismatch on {self._topic} with {info.node_name}: {reason}'
        return ''

    def _describe_rivals(self, infos: Sequence[TopicEndpointInfo]) -> str:
        """Say that there are several publishers; of one name, the old one may be dead."""
        words = self._rivals.look(infos)
        if words and not self._rivals.is_ghost:
            self._alarm = TWO_PUBLISHERS
        return words

    def _notice_standstill(self) -> None:
        if not self.received and self._renewal.stood_still(time.monotonic()):
            self._part()

    def _await_publisher(self) -> None:
        """Without any publisher: wait for the next one with what hears it best."""
        if self._waits:
            return
        self._part()
        if self._known_type is not None and self._unreliable is not None and self.open and (
                self._qos is self._unreliable or not self._reception.there):
            self._waits = True
            if self._qos is not self._unreliable:
                self._qos = self._unreliable
                self._reception.open(self._types[self._known_type], self._qos)
                self._opened_ns = self._opened_ns or time.time_ns()
        elif self._qos is self._unreliable:
            self._reception.close()
            self._qos = self._reliable

    def _part(self) -> None:
        """Begin again where publishers may have given up this process before a message came."""
        if (self._kept is not None and self._reception.there and not self._waits
                and not self._reception.newest):
            self._since_ns = self._opened_ns
            self._reception.set_aside()

    @property
    def _may_look_back(self) -> bool:
        """Whether it is known with which number or time to begin."""
        return bool(self._whole or self._reception.newest or self._since_ns)

    def _change_qos(self, infos: Sequence[TopicEndpointInfo], came: bool) -> None:
        """Subscribe with what hears all publishers and loses least; `came`: all are new here."""
        waited, self._waits = self._waits, False
        best = self._choose_qos(infos, came, waited)
        if best is self._kept and came and (waited or self._since_ns):
            self._since_ns = _EVER_NS
        if best is self._qos:
            return
        self._qos = best
        if waited and best is self._kept and came:
            # Publishers that keep their messages send them all, in order.
            self._reception.set_aside()
        elif self._reception.there and (waited or best is self._kept):
            self._reception.hand_over(best, seamless=waited)
        else:
            self.resubscribed += self._reception.there
            self._reception.close()

    def _choose_qos(self, infos: Sequence[TopicEndpointInfo], came: bool,
                    waited: bool) -> QoSProfile:
        if self._unreliable is not None and (self._qos is self._unreliable and not waited or any(
                info.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT for info in infos)):
            return self._unreliable
        if self._kept is not None and (self._may_look_back or came) and all(
                info.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for info in infos):
            return self._kept
        return self._reliable

    def _describe(self, wrong: str, now_s: float) -> tuple[int, str]:
        """Return level and words for the state of this input."""
        if wrong:
            return WARN if self._rivals.is_ghost else ERROR, wrong
        if not self.received and now_s < self._begun_s + self._first_wait_s:
            return OK, f'waiting for the first message of {self._topic}'
        if not self.publishers:
            gone = self._needed and now_s > self._there_s + _GONE_S
            return WARN if gone else OK, f'no publisher on {self._topic}'
        stale = self._stale_s is not None and (
            now_s - max(self._newest_s, self._come_s) > self._stale_s)
        if not self.received:
            return (WARN if stale else OK, f'waiting for the first message of {self._topic}'
                    + ', which has a publisher' * stale)
        if stale:
            return WARN, f'silent for more than {self._stale_s:g} s'
        return OK, 'receiving'

    def _note(self) -> None:
        """Report the state of this input."""
        now_s = time.monotonic()
        # Before the renewal is asked, which forgets that this process stood still.
        self._notice_standstill()
        wrong, age_s = self.look(), now_s - self._newest_s
        if self._renewal.is_due(now_s, self.received, self._fetchable) and self._reception.there:
            self._reception.hand_over(self._qos)
        level, words = self._describe(wrong, now_s)
        rate_hz = (self.received - self._beat_n) / max(now_s - self._beat_s, 1e-3)
        self._beat_s, self._beat_n = now_s, self.received
        self._health.note(self._topic, level, words, alarm=self._alarm, type=self.type_name,
                          publishers=self.publishers, received=self.received, lost=self.lost,
                          refused=self.refused or None, before_start=self.before or None,
                          resubscribed=self.resubscribed or None, rate_hz=rate_hz,
                          age_s=age_s if self.received else None,
                          latency_s=self._latency_s)
        lost, refused = (count.take(total, now_s) for count, total in zip(
            self._recent, (self.lost, self.refused)))
        troubles = []
        if lost:
            troubles.append(f'{lost} messages lost on the way')
        if refused:
            troubles.append(f'{refused} messages refused: {self._why_refused}')
        losing = self._losing.take(self.lost, now_s)
        self._health.note(f'{self._topic} lost', WARN if troubles else OK,
                          '; '.join(troubles) or 'nothing lost lately',
                          alarm=LOST_ON_THE_WAY if losing else '', lost=self.lost,
                          refused=self.refused or None)


def make_intake_beside(node: Node, health: Health, topic: str, types: Mapping[str, type],
                       taking: Taking) -> Intake:
    """
    Return the intake of a topic beside the headings: from the first message that is kept.

    If only one type is accepted, the subscription is made at the start.

    Parameters
    ----------
    node, health, topic, types
        As for `Intake`.
    taking
        How messages are taken.

    """
    return Intake(node, topic, types, profiles.HEADINGS_IN, health,
                  unreliable=profiles.HEADINGS_UNRELIABLE, kept=profiles.HEADINGS_KEPT,
                  needed=False, lost_shown_s=taking.lost_shown_s, whole=True,
                  known_type=None if len(types) > 1 else [*types][0])


def _name_gids(infos: Sequence[TopicEndpointInfo]) -> list[str]:
    """Return the identities of publishers in the graph."""
    return [bytes(info.endpoint_gid).hex() for info in infos]
