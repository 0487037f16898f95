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

"""What the recorder records: topics, types, the QoS for a player; and reports as attachments."""

from __future__ import annotations

from functools import partial
import json
import time
from typing import Callable, Mapping, NamedTuple, Sequence

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

from heading_intercompare.bags.recording.part_states import DIAGNOSTICS_TOPIC, PartStates
from heading_intercompare.bags.recording.recorder_losses import Counts, PublishedHeadings
from heading_intercompare.bags.rosbag2.bag_yaml import Qos
from heading_intercompare.bags.rosbag2.motion_topics import motion_topics
from heading_intercompare.bags.rosbag2.provenance import (
    ACTION_TOPIC,
    NOTE_TOPIC,
    REPORT_TOPIC,
    SENSORS_REPORT_TOPIC,
    TRUTH_TOPIC,
)
from heading_intercompare.bags.rosbag2.sequence_gaps import Numbering
from heading_intercompare.core.pairing.names import Span
from heading_intercompare.core.sensors.compared_sensors import list_sensors
from heading_intercompare.core.sensors.pair_names import TWO
from heading_intercompare.core.settings import Settings
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.heading_places import HeadingPlace, locate_headings
from heading_intercompare.messages.ledger_messages import lost_topic
from heading_intercompare.messages.status_messages import (
    ALARMS_TOPIC,
    decode_text,
    MARKER_TOPIC,
)
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.interface.message_types import (
    list_heading_types,
    MOTION_TYPES,
    PAIRS_TYPES,
    STATUS_TYPES,
    TEXT_TYPES,
    TRUTH_TYPES,
)
from heading_intercompare.nodes.interface.parameters import resolve_topic
from heading_intercompare.nodes.interface.places import (
    heading_places,
    label_tested,
    name_place,
    quality_topics,
)
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.presence.transports import DISCOVERY_S, is_alone
from heading_intercompare.nodes.settings import HeadingTypes, Taking

from .intake import Intake, make_intake_beside
from .reception import Message
from .recorded_messages import RecordedMessages

#: A publisher knows a new subscription within this time, unless the computer is very busy.
_KNOWN_S = 1.0


class Recorded(NamedTuple):
    """
    One recorded topic.

    Attributes
    ----------
    offered
        The QoS that a player of the bag should offer.
    intake
        Its messages.
    expected
        It belongs to every recording, and at the end the recorder waits for its publishers.
    published
        Each says how many messages a synchronizer took before and after those heard here.
    is_heading
        It comes from a sensor, whose publisher may go on when the graph ends.
    is_ledger
        A synchronizer says in it which headings it took.
    spans
        Each returns the numbers of the first and the last message that a synchronizer took, given
        the publisher of the first one; None where it does not know yet.

    """

    offered: Qos
    intake: Intake
    expected: bool
    published: tuple[Callable[[Sequence[Span]], tuple[int, int]], ...] = ()
    is_heading: bool = False
    is_ledger: bool = False
    spans: tuple[Callable[[str], tuple[int | None, int | None]], ...] = ()

    @property
    def first_judged(self) -> int | None:
        """Return the number of the first message that somebody took; None if nobody has."""
        publisher = self.intake.numbers.last_publisher
        return min((first for find in self.spans if (first := find(publisher)[0])), default=None)

    @property
    def last_judged(self) -> int | None:
        """Return the number of the last message that somebody took; None if nobody ended."""
        return max((last for find in self.spans if (last := find('')[1])), default=None)

    def count_missing(self, spans: Sequence[Span]) -> tuple[int, int]:
        """Return how many messages somebody took before the first and after the last ones here."""
        counts = [count_missing(spans) for count_missing in self.published]
        return max((before for before, _ in counts), default=0), max(
            (after for _, after in counts), default=0)


def _offer(profile: QoSProfile) -> Qos:
    stored = profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
    return Qos(depth=profile.depth, durability='transient_local' if stored else 'volatile')


class _State(Intake):
    """
    A state of one or several nodes, whose numbers say nothing about losses.

    Publishers keep only the newest message, which replaces those that came late.
    """

    def __init__(self, node: Node, health: Health, topic: str, own: RecordedMessages, *,
                 needed: bool = False, first_wait_s: float = 0.0) -> None:
        super().__init__(node, topic, STATUS_TYPES, qos.STATE_IN, health, sole=False,
                         needed=needed, counted=False, first_wait_s=first_wait_s)
        self._own = own

    def take(self) -> list[tuple[bytes, Mapping[str, int]]]:
        """Return the messages to record, without numbers."""
        messages, n_left_out = self._own.sift(self.full_name, super().take())
        self.received -= n_left_out
        return [(data, {**info, 'publication_sequence_number': 0}) for data, info in messages]


class _Diagnostics(Intake):
    """The states of all nodes: what is new, and now and then what is not."""

    def __init__(self, node: Node, health: Health, states: PartStates) -> None:
        super().__init__(node, DIAGNOSTICS_TOPIC, STATUS_TYPES, qos.DIAGNOSTICS_IN, health,
                         unreliable=qos.HEADINGS_UNRELIABLE, sole=False, needed=False,
                         counted=False)
        self._states = states

    def take(self) -> list[tuple[bytes, Mapping[str, int]]]:
        """Return the messages to record, without numbers: what is left out is not lost."""
        return [(data, {**info, 'publication_sequence_number': 0}) for data, info in super().take()
                if self._states.take(data, info['received_timestamp'])]


class _Pairs(Intake):
    """
    The pairs, once the headings are heard.

    A synchronizer begins when its pairs are heard. Whatever it takes is to be in the bag, so the
    subscriptions of the headings come first.
    """

    def __init__(self, node: Node, topic: str, health: Health, first_wait_s: float,
                 headings: Sequence[Intake]) -> None:
        super().__init__(node, topic, PAIRS_TYPES, qos.PAIRS_TAKEN, health, sole=False,
                         first_wait_s=first_wait_s, kept=qos.PAIRS)
        self._headings = headings
        # Within one process, nodes know each other at once.
        self._known_s, found_s = (0.0, 0.0) if is_alone() else (_KNOWN_S, DISCOVERY_S)
        self._found_s = time.monotonic() + found_s
        self._since_s: float | None = None
        self.open = False

    def take(self) -> list[Message]:
        """Return the messages to record."""
        now_s = time.monotonic()
        if not self.open:
            self.open = self._is_time(now_s)
        return super().take()

    def _is_time(self, now_s: float) -> bool:
        """Tell whether the headings are heard as far as they are there."""
        absent = now_s >= self._found_s
        if not all(intake.subscribed or (absent and not intake.publishers)
                   for intake in self._headings):
            self._since_s = None
            return False
        self._since_s = self._since_s or now_s
        return now_s >= self._since_s + self._known_s or all(
            intake.received for intake in self._headings)


class _Ledgers(Intake):
    """The ledgers of the synchronizer, which count the headings that were published."""

    def __init__(self, node: Node, health: Health, first_wait_s: float, topic: str,
                 own: RecordedMessages) -> None:
        super().__init__(node, topic, STATUS_TYPES, qos.LEDGER, health,
                         first_wait_s=first_wait_s, sole=False)
        self._own = own
        self.headings = PublishedHeadings()

    def take(self) -> list[tuple[bytes, Mapping[str, int]]]:
        """Return the messages to record."""
        messages, n_left_out = self._own.sift(self.full_name, super().take())
        self.received -= n_left_out
        if messages:
            self.headings.take(messages[-1][0])
        return messages


class _Row(NamedTuple):
    """A topic to record: its types, how it is taken and offered, and whether it must be there."""

    topic: str
    types: Mapping[str, type]
    taken: QoSProfile
    offered: QoSProfile
    expected: bool


def _list_rows(node: Node, reports: Sequence[str],
               headings: Mapping[str, HeadingPlace]) -> list[_Row]:
    """Return the topics whose messages are recorded as they come, in the order to subscribe."""
    rows = [*(_Row(topic, list_heading_types(place), qos.HEADINGS_IN, qos.HEADINGS_OUT, True)
              for topic, place in headings.items()),
            _Row(MARKER_TOPIC, STATUS_TYPES, qos.MARKER, qos.MARKER, True),
            _Row(NOTE_TOPIC, TEXT_TYPES, qos.NOTE, qos.NOTE, False),
            _Row(ACTION_TOPIC, TEXT_TYPES, qos.ACTION, qos.ACTION, False),
            *(_Row(topic, TEXT_TYPES, qos.REPORT, qos.REPORT, True) for topic in reports)]
    if resolve_topic(node, TRUTH_TOPIC) not in [resolve_topic(node, topic) for topic in headings]:
        # First: nobody waits for the truth, but its subscription must precede the headings.
        rows.insert(0, _Row(TRUTH_TOPIC, TRUTH_TYPES, qos.HEADINGS_IN, qos.HEADINGS_OUT, False))
    return rows + [_Row(lost_topic(resolve_topic(node, topic)), STATUS_TYPES, qos.LOST, qos.LOST,
                        False) for topic in headings]


def make_intakes(node: Node, settings: Settings, taking: Taking, types: HeadingTypes,
                 health: Health, states: PartStates) -> dict[str, Recorded]:
    """
    Return the topics by name.

    The topics of the graph, the true heading if any, notes, and the diagnostics if wanted.
    """
    sensors = {sensor.name: sensor for sensor in list_sensors(settings)}
    headings = heading_places(settings)
    places = {names: name_place(label) for names, label in label_tested(settings).items()}
    known_types = dict.fromkeys(headings, types.ts_message_type)
    known_types |= {locate_headings(sensor.heading_topic).topic: types.rs_message_type
                    for sensor in sensors.values() if sensor.is_reference}
    types_beside = {
        **{topic: MOTION_TYPES[what] for what, topic in motion_topics(settings.motion).items()
           if settings.motion.compare},
        **dict.fromkeys(quality_topics(node, settings), STATUS_TYPES)}
    topics = {topic: Recorded(_offer(qos.HEADINGS_OUT), make_intake_beside(
        node, health, topic, types_of_topic, taking), False)
        for topic, types_of_topic in types_beside.items()}
    own = RecordedMessages(node, health)
    reports = [f'{place}{REPORT_TOPIC}' for place in places.values()]
    if settings.sensors is not None:
        reports.append(SENSORS_REPORT_TOPIC)
    for report in reports:
        verdict = report.removesuffix('report') + 'verdict'
        topics[verdict] = Recorded(_offer(qos.STATE), _State(
            node, health, verdict, own, needed=True, first_wait_s=taking.first_wait_s), True)
    for row in _list_rows(node, reports, headings):
        takes_headings = row.taken is qos.HEADINGS_IN
        topics[row.topic] = Recorded(_offer(row.offered), Intake(
            node, row.topic, row.types, row.taken, health,
            unreliable=qos.HEADINGS_UNRELIABLE if takes_headings else None,
            kept=qos.HEADINGS_KEPT if takes_headings else None, first_wait_s=taking.first_wait_s,
            sole=False, needed=row.expected, place=headings.get(row.topic),
            known_type=known_types.get(row.topic)),
            row.expected, is_heading=row.topic in headings)
    heard = [topics[topic].intake for topic in headings]
    for names, place in places.items():
        topics[f'{place}pairs'] = Recorded(_offer(qos.PAIRS_TAKEN), _Pairs(
            node, f'{place}pairs', health, taking.first_wait_s, heard), True)
        ledgers = _Ledgers(node, health, taking.first_wait_s, f'{place}pairs/ledger', own)
        topics[f'{place}pairs/ledger'] = Recorded(_offer(qos.LEDGER), ledgers, True,
                                                  is_ledger=True)
        for stream, name in zip(TWO, names):
            topic = locate_headings(sensors[name].heading_topic).topic
            topics[topic] = topics[topic]._replace(
                published=(*topics[topic].published,
                           partial(ledgers.headings.count_missing, stream)),
                spans=(*topics[topic].spans, partial(ledgers.headings.find_span, stream)))
    topics[ALARMS_TOPIC] = Recorded(_offer(qos.STATE), _State(
        node, health, ALARMS_TOPIC, own), False)
    if states.kept:
        topics[DIAGNOSTICS_TOPIC] = Recorded(
            _offer(qos.STATUS), _Diagnostics(node, health, states), False)
    return topics


def count_messages(topics: Mapping[str, Recorded], not_written: Mapping[str, int],
                   judged: Mapping[str, tuple[int, Numbering]]) -> dict[str, Counts]:
    """
    Return the counts of messages received and lost, by full name of their topic.

    Parameters
    ----------
    topics
        All topics of the recorder.
    not_written
        Messages that could not be written, by full name of their topic.
    judged
        How many headings of a topic were judged and received, and their numbers.

    """
    counts = {}
    for topic, recorded in topics.items():
        received, lost = recorded.intake.received, recorded.intake.lost
        before = 0
        if topic in judged:
            received, numbering = judged[topic]
            before, after = recorded.count_missing(numbering.spans)
            lost = numbering.missing + after
        if recorded.expected or (received and recorded.intake.counted):
            name = recorded.intake.full_name
            counts[name] = Counts(received, lost, not_written.get(name, 0), before)
    return counts


def text_of(data: bytes) -> str:
    """Return the text of a std_msgs/String message; '' if it is damaged."""
    try:
        return decode_text(data)
    except MessageError:
        return ''


def _run_table(report: str) -> str:
    """Return the runs of a report as the table that `analyze --runs` reads: [start, stop) ns."""
    rows = [f'{run["start_ns"]},{run["end_ns"] + 1}' for run in json.loads(report)['runs']]
    return '\n'.join(['start,stop', *rows]) + '\n'


def report_files(report: str) -> list[tuple[str, str, bytes]]:
    """Return the attachments for a report, each with name and media type: itself, its runs."""
    files = [('report.json', 'application/json', report.encode())]
    try:
        files.append(('runs.csv', 'text/csv', _run_table(report).encode()))
    except (ValueError, KeyError, TypeError):
        pass  # Somebody else published this text; the bag must be closed nevertheless.
    return files
