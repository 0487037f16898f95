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

"""All messages of a graph that are shown to people, as one view of it."""

from __future__ import annotations

from functools import partial
from operator import itemgetter
import time
from typing import Callable, Mapping, Sequence

from rclpy.node import Node
from rclpy.qos import QoSProfile

from heading_intercompare.core.settings import Settings
from heading_intercompare.messages.heading_messages import read_pairs
from heading_intercompare.messages.heading_places import locate_headings
from heading_intercompare.messages.ledger_messages import decode_ledger, LedgerMessage
from heading_intercompare.messages.status_messages import (
    ALARMS_TOPIC,
    decode_statuses,
    Status,
)
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.interface.message_types import list_heading_types, PAIRS_TYPES
from heading_intercompare.nodes.interface.places import label_tested, name_place
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.settings import Taking
from heading_intercompare.nodes.spinning.batches import Arrivals
from heading_intercompare.web.bridge.bridge_view import Bridge, BridgeView

from .intake import Intake
from .own_messages import OwnMessages
from .topic_headings import TopicHeadings
from .vouchers import owner_of

# With several sensors one node hears the headings, and says what to show of them.
_OF_SENSORS = ('figures', 'vote', 'verdict')


#: Takes the stamp of a message, its statuses, and the time of its receipt.
_Stamped = Callable[[int, Sequence[Status], float], None]


def _read_ledger(data: bytes) -> tuple[str, LedgerMessage]:
    """Return a ledger, and the node that it names."""
    return owner_of(decode_statuses(data)), decode_ledger(data)


def _pass_on(act: _Stamped, message: tuple[int, Sequence[Status]]) -> None:
    act(*message, time.monotonic())


class BridgeIntake:
    """
    Takes what a graph publishes, for a view of it.

    Headings and pairs are only heard once the synchronizer has readings, or after `open`. So a
    view is never mistaken for one of the subscribers that a log or a simulation waits for.

    Parameters
    ----------
    node
        The node that shows the view.
    health
        Its state.
    settings
        Of the analysis.
    limits_deg
        As for `Bridge`.

    """

    def __init__(self, node: Node, health: Health, settings: Settings, taking: Taking,
                 limits_deg: Mapping[str, float] | None = None) -> None:
        self._bridge = Bridge(settings, limits_deg=limits_deg,
                              stale_s=taking.stale_s, namespace=node.get_namespace())
        several = settings.sensors is not None
        labels = {names[0]: name_place(label) for names, label in label_tested(settings).items()}
        self._listen(node, health, labels, several)
        arrivals = Arrivals(node, self._drain, taking.drain_period_s)
        self._intakes: dict[str, Intake] = {}
        self._pairs = {tested: Intake(
            node, f'{place}pairs', PAIRS_TYPES, qos.PAIRS_TAKEN, health, needed=False,
            counted=False, arrivals=arrivals) for tested, place in labels.items()}
        for intake in self._pairs.values():
            intake.open = False
        if not several:
            self._hear_headings(node, health, settings, arrivals)

    def _hear_headings(self, node: Node, health: Health, settings: Settings,
                       arrivals: Arrivals) -> None:
        """Make what hears the headings of two sensors; compliance says those of several."""
        places = {'ts': locate_headings(settings.ts_topic, settings.ts_unit),
                  'rs': locate_headings(settings.rs_topic, settings.rs_unit)}
        conventions = {'ts': settings.ts_convention, 'rs': settings.rs_convention}
        self._intakes = {stream: Intake(
            node, place.topic, list_heading_types(place), qos.HEADINGS_IN, health,
            unreliable=qos.HEADINGS_UNRELIABLE, needed=False, counted=False, arrivals=arrivals)
            for stream, place in places.items()}
        self._readers = {stream: TopicHeadings(place, conventions[stream])
                         for stream, place in places.items()}
        for intake in self._intakes.values():
            intake.open = False

    def _listen(self, node: Node, health: Health, labels: Mapping[str, str],
                several: bool) -> None:
        """Subscribe to the statuses of the graph."""
        bridge = self._bridge
        stamped: list[tuple[str, QoSProfile, _Stamped]] = [
            (f'{place}compliance/run', qos.STATUS, partial(bridge.take_run, tested=tested))
            for tested, place in labels.items()]
        stamped += [
            (f'sensors/{name}', qos.STATE_IN, partial(self._take_sensors, name))
            for name in _OF_SENSORS] if several else [
                ('compliance/rolling', qos.STATUS, bridge.take_rolling),
                ('compliance/verdict', qos.STATE_IN, bridge.take_verdict)]
        own = OwnMessages(node, health, bridge.take_health)
        for topic, profile, act in stamped:
            own.subscribe(topic, profile, decode_statuses, partial(_pass_on, act), owner_of)
        own.subscribe(ALARMS_TOPIC, qos.STATE_IN, decode_statuses, self._take_alarms, owner_of,
                      act_in_doubt=partial(self._take_alarms, in_doubt=True))
        if not several:
            own.subscribe('pairs/ledger', qos.LEDGER, _read_ledger,
                          lambda message: self._book(message[1]), itemgetter(0))

    def _take_alarms(self, message: tuple[int, Sequence[Status]], in_doubt: bool = False) -> None:
        self._bridge.take_alarms(message[1], time.monotonic(), in_doubt=in_doubt)

    def _take_sensors(self, name: str, stamp_ns: int, statuses: Sequence[Status],
                      now_s: float) -> None:
        self._bridge.take_sensors(name, stamp_ns, statuses, now_s)
        if any('age_s' in status.values for status in statuses):
            self.open()

    def _book(self, told: LedgerMessage) -> None:
        self._bridge.take_ledger(told, time.monotonic())
        if any(told.ledger.total.counts.values()):
            self.open()

    def open(self) -> None:
        """Hear headings and pairs from now on."""
        for intake in (*self._intakes.values(), *self._pairs.values()):
            intake.open = True

    def _drain(self) -> None:
        now_s = time.monotonic()
        for stream, intake in self._intakes.items():
            headings = intake.read_messages(self._readers[stream].read)
            if intake.received_ns is not None:
                self._bridge.take_headings(stream, headings, intake.received_ns, now_s)
        for tested, intake in self._pairs.items():
            self._bridge.take_pairs(intake.read_rows(
                lambda _, messages: read_pairs(messages)), now_s, tested)

    def view(self) -> BridgeView:
        """Return what to show now."""
        return self._bridge.view(time.monotonic())
